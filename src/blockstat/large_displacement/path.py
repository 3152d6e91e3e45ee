"""Following a mechanism: steps, the events that end a piece of the path, and jumps.

On a piece of the path the same contacts stick or slide, and the pose is that of a linkage (`linkage`). The multiplier
is that of virtual work on the linkage's own motion u, which is an upper bound; forces that balance it are looked for at
the same pose and make it a lower bound too:

    alpha = -w'u / l'u,        A f + w + alpha l = 0, f in K.

A piece ends where a contact closes that was open, where no forces balance any more (the thrust has reached an edge, or
a joint slides), where alpha is zero, or at the displacement asked for. Each is located by root finding.

Where no forces balance any more, the motion that no forces resist opens a joint at constant displacement. It is
followed until a joint shuts (`jump`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from blockstat.large_displacement.contacts import closed_again, gaps
from blockstat.large_displacement.jump import STILL, NoRootError, jump, root_of
from blockstat.large_displacement.linkage import Linkage
from blockstat.large_displacement.loading import Structure
from blockstat.large_displacement.pose import Pose
from blockstat.large_displacement.sliding import renewed
from blockstat.large_displacement.statics import LACKING, Forces, balance, rubbing
from blockstat.result import Sentence
from blockstat.typing import Floats

#: A gap below this, relative to the size of the blocks, is closed.
SHUT = 1e-9
#: A step is no shorter than this part of the first, and so many jumps may follow each other at one displacement.
SHORTEST, JUMPS = 1e-9, 20
#: So many pieces in a row may be shorter than this part of a step. One change may be that of a mixture of mechanisms;
#: where they follow each other so fast, it is no linkage that moves: joints slide to and fro.
SHORT, CHATTER = 3, 1e-2
#: A new step aims at this part of the deviation that is allowed.
FIRM = 0.9
#: Contacts that move at less than this, where the fastest corner moves at 1, are tried as sticking where a mechanism
#: changes.
SLOWER = (STILL, 1e-3, 1e-2)


#: Linkage and motion that begin at a pose, given what touches there, the parameter, and at what speed a contact sticks.
Begin = Callable[[Linkage, Pose, float, float], tuple[Linkage, Floats] | None]


class PathEnd(Sentence):
    """How a path ends; each value is a sentence."""

    ZERO = "Zero: the multiplier reaches zero."
    REACHED = "Reached: the displacement asked for is reached."
    COLLAPSE = "Collapse: no admissible state follows at this displacement."
    LOST = "Lost: the mechanism could not be followed any further; what lies beyond is not known."
    INTERRUPTED = "Interrupted: the path is known up to here."


@dataclass(frozen=True, eq=False)
class Motion:
    """A pose on a piece of the path, and how it moves on."""

    parameter: float  #: displacement of the control, or movement of the supports [m]
    pose: Pose
    rate: Floats  #: rate of the pose for a unit rate of the parameter, shape (n_blocks, 6)
    value: float  #: the multiplier, or the force on the moving supports [N]
    linkage: Linkage | None = None  #: with contact points renewed, where joints slide against friction
    forces: Forces | None = None  #: which tell the value there


@dataclass(frozen=True, eq=False)
class State:
    """One state on the path."""

    motion: Motion
    linkage: Linkage
    forces: Forces
    #: where a finite step has led to it, how far contacts are open that count as touching [m]; its value is then that
    #: of the limit analysis there
    open: float | None = None
    upper: float | None = None  #: the multiplier with associated friction, where that of the state is less
    bodies: bool = False  #: whether blocks that move together were taken as one body


@dataclass(frozen=True)
class PathEvent:
    """A change of the mechanism."""

    kind: str  #: "jump", "closing" or "change"
    parameter: float  #: where [m]
    before: float  #: multiplier or force before it
    after: float | None  #: and after it; None where no admissible state follows
    opened: tuple[int, ...]  #: joints that open, numbers of interfaces
    shut: tuple[int, ...]  #: joints that shut


@dataclass(frozen=True, eq=False)
class Follower:
    """Follows one structure along one path."""

    structure: Structure
    value: Callable[[Pose, Floats], float]  #: of a pose and its rate, where nothing slides against friction
    #: statuses of contacts and of ties where a contact has closed, and the first motion from a pose
    begin: Begin
    end: float  #: largest parameter [m]
    step: float  #: largest step [m]
    tolerance: float  #: of the value between points and of the place of events, relative to their scale
    ends_at_zero: bool = True

    def follow(self, linkage: Linkage, pose: Pose, guess: Floats) -> Iterator[State | PathEvent | PathEnd]:
        """Yield the states on the path in order, with the events between them, and at last how it ends.

        Parameters
        ----------
        linkage
            The mechanism that begins.
        pose
            Where it begins.
        guess
            Its motion, shape (n_blocks, 6).

        Yields
        ------
        State, PathEvent or PathEnd
            In order; the end comes last.
        """
        state = self.first(linkage, pose, guess)
        if state is None or state.forces.lacking > LACKING:  # what the mechanism of several bodies at once has become
            yield PathEnd.LOST
            return
        yield state
        try:
            yield from self._pieces(state)
        except NoRootError:
            yield PathEnd.LOST

    def meets(self, event: PathEvent, other: PathEvent) -> bool:
        """Return whether two events are at one place, as far as a change of mechanism is looked for (`_changed`).

        Parameters
        ----------
        event, other
            The events.

        Returns
        -------
        bool
            Whether they are.
        """
        return abs(event.parameter - other.parameter) <= self.tolerance * self.step

    def _pieces(self, state: State) -> Iterator[State | PathEvent | PathEnd]:
        short = 0
        while True:
            start = state.motion.parameter
            reason, state, ahead = yield from self._piece(state)
            if isinstance(reason, PathEnd):
                yield reason
                return
            short = short + 1 if state.motion.parameter - start <= CHATTER * self.step else 0
            if short > SHORT:
                yield PathEnd.LOST
                return
            following = self._jumped(state, ahead) if reason == "jump" else self._closed(state)
            for item in following:
                yield item
                if isinstance(item, PathEnd):
                    return
                if isinstance(item, State):
                    state = item

    def first(self, linkage: Linkage, pose: Pose, guess: Floats) -> State | None:
        """Return the state in which a path begins.

        Parameters
        ----------
        linkage, pose, guess
            As in `follow`.

        Returns
        -------
        State or None
            None where the parameter does not move the linkage.
        """
        motion = self._motion(linkage, pose, 0.0, guess)
        return None if motion is None else self._state(linkage, motion)

    def _motion(self, linkage: Linkage, pose: Pose, parameter: float, guess: Floats) -> Motion | None:
        rate = linkage.tangent(pose, parameter, guess)
        if rate is None:
            return None
        if not linkage.rubs:
            return Motion(parameter, pose, rate, self.value(pose, rate))
        linkage = renewed(linkage, self.structure.interfaces, pose, parameter, rate)
        forces, value = rubbing(self.structure, linkage, pose, parameter, rate)
        return Motion(parameter, pose, rate, value, linkage, forces)

    def ahead(self, state: State, parameter: float) -> Motion | None:
        """Return the pose of the same linkage at another parameter.

        Parameters
        ----------
        state
            Where it starts.
        parameter
            Of the pose.

        Returns
        -------
        Motion or None
            None where the linkage has none near.
        """
        linkage, start = state.linkage, state.motion
        pose = linkage.moved(start.pose, parameter, (parameter - start.parameter) * start.rate)
        return None if pose is None else self._motion(linkage, pose, parameter, start.rate)

    def _state(self, linkage: Linkage, motion: Motion) -> State:
        if motion.linkage is not None and motion.forces is not None:
            return State(motion, motion.linkage, motion.forces)
        linkage = renewed(linkage, self.structure.interfaces, motion.pose, motion.parameter, motion.rate)
        closed = linkage.pinned | linkage.sliding
        multiplier = motion.value if self.structure.live is not None else 0.0
        forces = balance(self.structure, linkage.contacts, closed, motion.pose, motion.parameter, multiplier)
        return State(motion, linkage, forces)

    def _piece(self, state: State) -> Any:
        """Yield states up to an event; return its kind, the state at it and the one just beyond."""
        allowed = self.tolerance * max(abs(state.motion.value), 1e-300)
        step = self.step
        for _ in range(100_000):
            start = state.motion
            target = min(start.parameter + step, self.end)
            motion = self.ahead(state, target)
            bend = np.inf if motion is None else self._bend(state, motion)
            if motion is None or bend > allowed:
                step *= 0.5 if np.isinf(bend) else max(float(np.sqrt(FIRM * allowed / bend)), 0.1)
                if step < self.step * SHORTEST:
                    return PathEnd.LOST, state, None
                continue
            reason, motion = self._first(state, motion)
            reached = self._state(state.linkage, motion)
            beyond = None
            if reached.forces.lacking > LACKING:
                reason = "jump"
                reached, beyond = self._limit(state, reached)
            if reached.motion.parameter > start.parameter:
                state = reached
                yield state
            if reason is not None:
                return reason, state, beyond
            if target >= self.end:
                return PathEnd.REACHED, state, None
            step = min(step * min(float(np.sqrt(FIRM * allowed / max(bend, 1e-300))), 10.0), self.step)
        return PathEnd.LOST, state, None

    def _bend(self, state: State, motion: Motion) -> float:
        """How far the value midway between two points is from the line between them."""
        middle = self.ahead(state, 0.5 * (state.motion.parameter + motion.parameter))
        if middle is None:
            return np.inf
        return 0.0 if motion.linkage is not None else abs(middle.value - 0.5 * (state.motion.value + motion.value))

    def _first(self, state: State, motion: Motion) -> tuple[str | PathEnd | None, Motion]:
        """The first of what kinematics alone tells: a contact that closes, or a value of zero."""
        reason: str | PathEnd | None = None
        start, found = state.motion.parameter, motion
        room = SHUT * float(self.structure.assembly.size.max())
        closing = np.flatnonzero(self._gaps(state.linkage, motion) < -room)
        for contact in closing:

            def gap(parameter: float, contact: int = int(contact)) -> float:
                at = self.ahead(state, parameter)
                return -room if at is None else float(self._gaps(state.linkage, at)[contact])

            if gap(found.parameter) >= -room:
                continue
            low = start + 1e-6 * (found.parameter - start)
            if gap(low) <= 0:
                return "closing", state.motion
            root = root_of(gap, low, found.parameter, 1e-14 * max(1.0, abs(found.parameter)))
            at = self.ahead(state, root)
            if at is not None:
                reason, found = "closing", at
        if self.ends_at_zero and found.value < 0:

            def value(parameter: float) -> float:
                at = self.ahead(state, parameter)
                return -1.0 if at is None else at.value

            if state.motion.value <= 0:
                return PathEnd.ZERO, state.motion
            root = root_of(value, start, found.parameter, 1e-14 * max(1.0, abs(found.parameter)))
            at = self.ahead(state, root)
            if at is not None:
                reason, found = PathEnd.ZERO, replace(at, value=0.0)
        return reason, found

    def _gaps(self, linkage: Linkage, motion: Motion) -> Floats:
        """Gaps of the contacts that are open, infinite for those that touch."""
        gap = gaps(self.structure.assembly, linkage.contacts, motion.pose, motion.parameter)
        open_: Floats = np.where(linkage.pinned | linkage.sliding, np.inf, gap)
        return open_

    def _limit(self, state: State, beyond: State) -> tuple[State, State]:
        """The last state that forces balance, and one just beyond, where `beyond` is one that none balance."""
        width = self.tolerance * 1e-2 * (beyond.motion.parameter - state.motion.parameter)
        low, high = state, beyond
        seen = {beyond.motion.parameter: beyond, state.motion.parameter: state}

        if state.forces.lacking > LACKING:
            near = self.ahead(state, state.motion.parameter + width)
            return state, beyond if near is None else self._state(state.linkage, near)
        level = 0.0 if state.forces.lacking < -LACKING else LACKING

        def lacking(parameter: float) -> float:
            if parameter not in seen:
                at = self.ahead(state, parameter)
                if at is None:
                    raise NoRootError
                seen[parameter] = self._state(state.linkage, at)
            return min(seen[parameter].forces.lacking, 1e3) - level

        root = root_of(lacking, state.motion.parameter, beyond.motion.parameter, width)
        for parameter in (root - width, root + width):
            if state.motion.parameter < parameter < beyond.motion.parameter:
                lacking(parameter)
        for parameter in sorted(seen):
            if lacking(parameter) <= 0:
                low = seen[parameter]
            else:
                high = seen[parameter]
                break
        return low, high

    def _jumped(self, state: State, beyond: State | None) -> Iterator[State | PathEvent | PathEnd]:
        """What follows where no forces balance any more."""
        if state.linkage.rubs and beyond is not None:
            changed = self._changed(state, beyond)
            if changed is not None:
                yield self._event("change", state, changed, [], [])
                yield changed
                return
        mode = (beyond or state).forces.mode
        before, opened, shut, end = state, [], [], PathEnd.LOST
        for _ in range(JUMPS):
            landing = jump(state.linkage, state.motion.pose, state.motion.parameter, mode, state.motion.rate)
            opened += landing.opened
            if landing.linkage is None:
                end = PathEnd.COLLAPSE if landing.fell else end
                break
            shut += landing.shut
            motion = self._motion(landing.linkage, landing.pose, state.motion.parameter, state.motion.rate)
            linkage = landing.linkage
            if motion is None:
                begun = self.begin(linkage, landing.pose, state.motion.parameter, STILL)
                motion = begun and self._motion(begun[0], landing.pose, state.motion.parameter, begun[1])
                if begun is None or motion is None:
                    break
                linkage = begun[0]
            if self.ends_at_zero and motion.value < 0:
                end = PathEnd.COLLAPSE
                break
            state = self._state(linkage, motion)
            if state.forces.lacking <= LACKING:
                yield self._event("jump", before, state, opened, shut)
                yield state
                return
            mode = state.forces.mode
        yield self._event("jump", before, None, opened, shut)
        yield end

    def _changed(self, state: State, beyond: State) -> State | None:
        """The state of another mechanism where a joint slides no more; None where there is none.

        Just beyond its limit two mechanisms have the same multiplier to rounding, and what is found is a mixture. So it
        is looked for further on too, up to the tolerance, and without its slower part. Only balanced forces count.
        """
        start = state.motion.parameter
        width = beyond.motion.parameter - start
        nearly: State | None = None
        for still, factor in product(SLOWER, (1.0, 10.0, 100.0)):
            motion = beyond.motion if factor == 1.0 else self.ahead(state, start + factor * width)
            if motion is None:
                continue
            begun = self.begin(motion.linkage or beyond.linkage, motion.pose, motion.parameter, still)
            following = begun and self._motion(begun[0], motion.pose, motion.parameter, begun[1])
            if begun is None or following is None:
                continue
            found = self._state(begun[0], following)
            if found.forces.proven and found.forces.lacking <= LACKING:
                return found
            if found.forces.lacking <= LACKING:
                nearly = nearly or found
        return nearly

    def _closed(self, state: State) -> Iterator[State | PathEvent | PathEnd]:
        """What follows where a contact has closed."""
        linkage, motion = state.linkage, state.motion
        room = 10 * SHUT * float(self.structure.assembly.size.max())
        met = np.flatnonzero(self._gaps(linkage, motion) <= room)
        contacts = closed_again(self.structure.assembly, linkage.contacts, met, motion.pose, motion.parameter)
        pinned = linkage.pinned.copy()
        pinned[met] = True
        held = replace(linkage, contacts=contacts, pinned=pinned)
        begun = self.begin(held, motion.pose, motion.parameter, STILL)
        following = begun and self._motion(begun[0], motion.pose, motion.parameter, begun[1])
        joints = sorted(set(contacts.joint[met].tolist()))
        if begun is None or following is None:
            yield self._event("closing", state, None, [], joints)
            yield PathEnd.COLLAPSE
            return
        found = self._state(begun[0], following)
        yield self._event("closing", state, found, [], joints)
        yield found

    def _event(self, kind: str, before: State, after: State | None, opened: Any, shut: Any) -> PathEvent:
        value = None if after is None else after.motion.value
        unique = [tuple(dict.fromkeys(int(k) for k in joints)) for joints in (opened, shut)]
        return PathEvent(kind, before.motion.parameter, before.motion.value, value, unique[0], unique[1])
