"""Following a structure by finite steps, where joints slide and open at so many places that it is no linkage.

At each pose the limit analysis on the contacts that touch tells the multiplier, with forces that carry it, and the
mechanism, in which joints slide without opening (De Saxce's fixed point) or with associated friction; on supports that
move, the motion of least potential energy tells the force on them. A step leads along it, until the fastest corner has
moved a given length, and the contacts that have stuck or slid are closed again (`place`): joints slide without
opening, as far as the bodies let them. Where no multiplier is carried, the blocks fall while the live load does no
work, or the supports rest, until contacts shut or the blocks have left.

Of many blocks most move together. Those between which no joint moves by more than a small part of the motion are taken
as one body, and what a step tries is solved for the bodies. Where a state is told, the limit analysis of all blocks,
whose joints slide as those of the bodies, tells whether the bodies hold; where they do not, they become smaller.

The steps are along the arc of the fastest corner, so that loose parts and snaps back are followed too. Unlike on a
linkage, the pose depends on the length of the steps.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.contacts import CORNER, closed_again, gaps, sides
from blockstat.large_displacement.jump import NoRootError
from blockstat.large_displacement.linkage import Linkage
from blockstat.large_displacement.loading import Structure
from blockstat.large_displacement.path import Follower, Motion, PathEnd, PathEvent, State
from blockstat.large_displacement.place import (
    COARSE,
    FINER,
    NOTHING,
    Place,
    closed_up,
    for_unit,
    of_blocks,
    of_bodies,
    refined,
    without,
)
from blockstat.large_displacement.pose import Pose, displaced
from blockstat.large_displacement.sliding import clipped_again
from blockstat.large_displacement.statics import Limited, as_bodies, limiting, settled
from blockstat.solve.dispatch import STRUCTURED
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: The longest step, relative to the size of the blocks.
FINE = 0.03
#: How far the value may be from the line through the two places before it where a step is longer than that, relative
#: to the value at the beginning: a thousandth in a step that is a thirtieth of the way.
BEND = 1e-3
#: Blocks that have fallen by this part of their size without being stopped have left.
LEFT = 0.5
#: Steps of a path at most, and trials to meet a displacement or a multiplier of zero.
MOST, TRIALS = 2000, 12
#: What bodies leave open touches: as far as the joints within them may have moved, and no more than what counts as
#: touching at rest, relative to the blocks.
TOUCH = 1e-3
#: Bodies hold where the blocks carry less than they by this part at most.
HOLD = 0.01
#: Blocks from which on bodies save more than they cost.
MANY = STRUCTURED // 6
#: The shortest step and that of a fall, relative to the longest.
SHORTEST, FALL = 1.0 / 16.0, 1.0 / 4.0
#: The same where bodies fall: what has moved unseen within them falls by so little.
FALL_OF_BODIES = 1.0 / 64.0


def follow(
    follower: Follower, linkage: Linkage, pose: Pose, guess: Floats, *, change: float
) -> Iterator[State | PathEvent | Left | PathEnd]:
    """Yield the path of a linkage, and where that is lost, the path by finite steps from there.

    Parameters
    ----------
    follower, linkage, pose, guess
        As in `Follower.follow`.
    change
        As of `Stepper`.

    Yields
    ------
    State, PathEvent, Left or PathEnd
        In order; the end comes last.
    """
    last: State | None = None
    early: list[State | PathEvent | PathEnd] | None = []
    for item in follower.follow(linkage, pose, guess):
        if item is PathEnd.LOST:
            break
        if isinstance(item, State):
            last = item
        if early is None:
            yield item
            continue
        # A linkage that does not go one step is not that of the mechanism, so nothing is told of it.
        early.append(item)
        if isinstance(item, PathEnd) or (last is not None and last.motion.parameter >= follower.step):
            yield from early
            early = None
    if early:
        last = None
    if item is PathEnd.LOST:
        start = last.motion if last is not None else _at_rest(follower, linkage, pose, guess)
        there = displaced(linkage.assembly, start.pose)
        speed = max(float(corner_speed(there, start.rate).max()), float(linkage.control is None))
        longest = speed * follower.step
        step = min(longest, FINE * float(np.median(linkage.assembly.size)))
        stepper = Stepper(follower.structure, follower.end, step, longest, change, follower.tolerance)
        yield from stepper.follow(linkage if last is None else last.linkage, start)


def _at_rest(follower: Follower, linkage: Linkage, pose: Pose, guess: Floats) -> Motion:
    """Where a path begins that is no linkage from rest on, with the motion for a unit rate of its displacement."""
    return Motion(0.0, pose, for_unit(linkage, pose, guess), follower.value(pose, guess))


def of_steps(states: Sequence[State], assembly: Assembly) -> list[str]:
    """Return what is to be said of states that finite steps have led to.

    Parameters
    ----------
    states
        Of a path.
    assembly
        The blocks at rest.

    Returns
    -------
    list of str
        Empty where there are none.
    """
    stepped = [(state.motion.parameter, state.open) for state in states if state.open is not None]
    if not stepped:
        return []
    start, widest = min(stepped)[0], max(open_ for _, open_ in stepped)
    room = CORNER * float(assembly.size.max())
    touching = f"; contacts that are open by up to {1e3 * widest:.2g} mm count as touching" if widest > room else ""
    together = "; many blocks move as bodies, whose falls hang on the steps" if any(s.bodies for s in states) else ""
    return [
        f"no linkage from {start:.4g} m on: followed by finite steps{touching}{together}. More steps tell the error"
    ]


@dataclass(frozen=True, eq=False)
class Left:
    """Blocks that have fallen out of the structure."""

    parameter: float  #: where [m]
    blocks: Ints  #: their numbers


@dataclass(frozen=True, eq=False)
class Stepper:
    """Follows one structure by finite steps."""

    structure: Structure
    end: float  #: largest displacement of the control, or movement of the supports [m]
    step: float  #: of the fastest corner, the longest where the value bends [m]
    longest: float  #: that where it goes on along a line [m]
    change: float  #: of the multiplier in one step, relative to that at the beginning, before the step is halved
    tolerance: float  #: of the multiplier where it is zero, relative to that at the beginning, and of the displacement

    def follow(self, linkage: Linkage, start: Motion) -> Iterator[State | PathEvent | Left | PathEnd]:
        """Yield the states that follow a given one in order, with jumps and what leaves, and at last how it ends.

        Parameters
        ----------
        linkage
            Its contacts that slide are no longer those of rest.
        start
            Where it begins, and its value.

        Yields
        ------
        State, PathEvent, Left or PathEnd
            In order; the end comes last.
        """
        open_ = np.zeros(self.structure.interfaces.n_interfaces)
        linkage = self._anew(linkage, start)
        where, guess, bodies = (self.structure, linkage, start.pose, start.parameter, open_), None, None
        if self._coarse:
            touching = linkage.contacts, linkage.pinned | linkage.sliding
            guess = start.rate
            bodies = as_bodies(self.structure, *touching, start.pose, start.parameter, guess, COARSE[0])
        place = self._place(*where, guess, bodies)
        known: Ints | None = None
        before: Motion | None = None
        last, scale, step = start, abs(start.value), self.step
        for _ in range(MOST):
            place, found = self._checked(place)
            if place.limit.multiplier is None:
                try:
                    fallen = yield from self._fall(place, last)
                except NoRootError:  # the solver found no fall, or the blocks jam
                    break
                if fallen is None:
                    yield PathEnd.COLLAPSE
                    return
                before = None
                place, found = self._checked(fallen)
                if place.limit.multiplier is None:
                    continue
            state = _state(place, found)
            yield state
            if self._coarse and (place.bodies is None or (known is not None and place.bodies.max() > 2 * known.max())):
                now = as_bodies(*place.where, found.motion, COARSE[0])
                place = replace(place, bodies=now if known is None else refined(known, now))
            known = place.bodies
            after, step = self._next(before, place, step, scale)
            last = state.motion
            before = replace(last, value=place.limit.multiplier)
            end = None if after.limit.multiplier is None else self._passed(after, scale)
            if end is not None:
                yield from self._met(place, after, step, scale, end)
                return
            further = 2.0
            if place.bodies is not None and after.limit.multiplier is not None:
                # The next step is not tried where it would change the multiplier too much.
                change = abs(after.limit.multiplier - before.value)
                further = min(further, 0.9 * self.change * scale / max(change, 1e-300))
            place, step = after, min(further * step, max(self.longest, self.step))
        yield PathEnd.LOST

    @property
    def _coarse(self) -> bool:
        """Whether bodies pay."""
        return self.structure.live is not None and self.structure.assembly.n_blocks > MANY

    def _anew(self, linkage: Linkage, start: Motion) -> Linkage:
        """The linkage whose sliding contacts are no longer of one corner only: they may slide back."""
        faces = self.structure.interfaces
        joints = np.unique(linkage.contacts.joint[linkage.sliding])
        joints = joints[faces.area[joints] > 0]
        contacts = clipped_again(linkage.assembly, faces, linkage.contacts, joints, start.pose, start.parameter)
        return replace(linkage, contacts=contacts)

    def _checked(self, place: Place) -> tuple[Place, Limited]:
        """A place whose bodies hold, and the limit state of its blocks."""
        smaller = iter(COARSE)
        while place.bodies is not None and place.limit.multiplier is not None:
            found = of_blocks(place)
            if found.multiplier is None:
                return self._falling(place, found)
            if found.multiplier >= (1.0 - HOLD) * place.limit.multiplier:
                return place, found
            still = next(smaller, None)
            bodies = None if still is None else as_bodies(*place.where, found.motion, still)
            place = of_bodies(place, found.motion, bodies)
        return place, place.limit

    def _falling(self, place: Place, found: Limited) -> tuple[Place, Limited]:
        """A place where blocks fall within bodies, with bodies so small that they fall too."""
        assert place.bodies is not None
        for still in (*COARSE, *FINER):
            bodies = refined(place.bodies, as_bodies(*place.where, found.motion, still))
            place = of_bodies(place, place.limit.motion, bodies)
            if place.limit.multiplier is None or place.bodies is None:
                return place, place.limit
        return replace(place, limit=found, bodies=None), found

    def _passed(self, place: Place, scale: float) -> PathEnd | None:
        """The end that a place is at or beyond."""
        assert place.limit.multiplier is not None
        if self.structure.live is not None and place.limit.multiplier <= self.tolerance * scale:
            return PathEnd.ZERO
        return PathEnd.REACHED if place.parameter >= self.end else None

    def _next(self, before: Motion | None, place: Place, step: float, scale: float) -> tuple[Place, float]:
        """The place after a step, and its length.

        It is shorter where the multiplier changes much or none is carried, and where it leaves the line through that
        of the place and of the one before.
        """
        now = place.limit.multiplier
        assert now is not None
        slope = np.nan
        if before is not None and before.parameter != place.parameter:
            slope = (now - before.value) / (place.parameter - before.parameter)
        while True:
            after = self._moved(place, step)
            value = after.limit.multiplier
            if value is not None and abs(value - now) <= self.change * scale:
                bend = abs(value - now - slope * (after.parameter - place.parameter))
                if step <= self.step or bend <= BEND * scale:
                    return after, step
            elif step <= SHORTEST * self.step:
                return after, step
            step /= 2

    def _met(self, place: Place, after: Place, step: float, scale: float, end: PathEnd) -> Iterator[State | PathEnd]:
        """The last state, at which the multiplier is zero or the displacement is the one asked for, and the end."""

        def beyond(at: Place) -> float:
            assert at.limit.multiplier is not None
            return -at.limit.multiplier if end is PathEnd.ZERO else at.parameter - self.end

        room = self.tolerance * (scale if end is PathEnd.ZERO else self.end)
        low, high, behind, over, found = 0.0, step, beyond(place), beyond(after), after
        for trial in range(TRIALS):
            if abs(beyond(found)) <= room:
                last, limit = self._checked(found)
                if limit.multiplier is None:
                    break
                yield _state(last, limit)
                yield end
                return
            part = behind / (behind - over) if trial % 3 < 2 else 0.5  # halved now and then, where it bends
            middle = low + part * (high - low)
            there = self._moved(place, middle)
            if there.limit.multiplier is None:
                break
            found = there
            if beyond(found) > 0:
                high, over = middle, beyond(found)
            else:
                low, behind = middle, beyond(found)
        # The multiplier drops past zero at a change of the mechanism.
        yield PathEnd.COLLAPSE if end is PathEnd.ZERO else end

    def _moved(self, place: Place, step: float) -> Place:
        """The place after a step along the motion, with what should touch closed."""
        linkage = place.moving()
        length = step / place.speed()
        motion = length * linkage.of_bodies(place.limit.motion)
        pose = linkage.shifted(place.pose, motion, linkage.origins(place.pose))
        held = None if self.structure.live is None else place.structure.conjugate()
        target = 0.0 if held is None else held.value(linkage.assembly, pose)
        parameter = place.parameter + length * place.drive
        closing = closed_up(linkage, pose, parameter, 10 * step, held, target)
        open_ = np.zeros(self.structure.interfaces.n_interfaces)
        np.maximum.at(open_, linkage.contacts.joint, closing.open)
        guess = None if place.limit.multiplier is None else place.limit.motion
        return self._place(place.structure, linkage, closing.pose, parameter, open_, guess, place.bodies)

    def _place(
        self,
        structure: Structure,
        linkage: Linkage,
        pose: Pose,
        parameter: float,
        open_: Floats,
        guess: Floats | None = None,
        bodies: Ints | None = None,
    ) -> Place:
        """What touches at a pose, with contacts open by so much in each joint; those that have slid get new points."""
        assembly, contacts = structure.assembly, linkage.contacts
        if linkage.control is not None:
            parameter = linkage.control.value(assembly, pose)
        room = CORNER * float(assembly.size.max())
        travel = float(np.linalg.norm(pose.displacement, axis=1).max())
        touch = open_ + (room if bodies is None else min(COARSE[0] * travel, TOUCH * float(np.median(assembly.size))))
        closed = gaps(assembly, contacts, pose, parameter) <= touch[contacts.joint]
        both = sides(assembly, contacts, pose, parameter)
        slid = closed & (np.linalg.norm(both[:, 1] - both[:, 0], axis=1) > room)
        joints = np.unique(contacts.joint[slid])
        faces = self.structure.interfaces.area[joints] > 0
        if faces.any():
            contacts = clipped_again(assembly, self.structure.interfaces, contacts, joints[faces], pose, parameter)
            closed = gaps(assembly, contacts, pose, parameter) <= touch[contacts.joint]
        lines = np.flatnonzero(closed & np.isin(contacts.joint, joints[~faces]))
        if len(lines):
            contacts = closed_again(assembly, contacts, lines, pose, parameter)
        linkage = replace(linkage, assembly=assembly, contacts=contacts, pinned=closed, sliding=np.zeros_like(closed))
        widest = float(gaps(assembly, contacts, pose, parameter)[closed].max(initial=0.0))
        if structure.live is not None:
            place = Place(structure, linkage, pose, parameter, NOTHING, widest, bodies)
            return of_bodies(place, guess, bodies)
        found = settled(structure, contacts, closed, pose, parameter, guess=guess, rough=True)
        return Place(structure, linkage, pose, parameter, found, widest, None)

    def _work(self, motion: Motion, blocks: Ints) -> float:
        """The part of the work of the live load that it does on some blocks, in a motion."""
        power = (self.structure.live_load(motion.pose) * motion.rate).sum(axis=1)
        return float(power[blocks].sum() / power.sum())

    def _fall(self, place: Place, last: Motion) -> Generator[PathEvent | Left, None, Place | None]:
        """Let blocks fall until a positive multiplier is carried; None where most of what the load moves has fallen.

        On supports that move, until forces balance; None where a block is not stopped.
        """
        shortest = (FALL if place.bodies is None else FALL_OF_BODIES) * self.step
        start, step, fallen, gone = place, shortest, 0.0, 0.0
        for _ in range(MOST):
            standing = place
            if not place.limit.motion.any():
                raise NoRootError
            place = self._moved(standing, step)
            while step > shortest and place.touching() != standing.touching():  # nothing may be fallen through
                if place.bodies is not None and place.limit.multiplier is not None:
                    break
                step = max(step / 2, shortest)
                place = self._moved(standing, step)
            fallen += step
            step = min(2 * step, self.step)
            moved = np.linalg.norm(place.pose.displacement - start.pose.displacement, axis=1)
            most = np.flatnonzero(moved > 0.5 * moved.max())
            if place.limit.multiplier is None and fallen > LEFT * float(place.linkage.assembly.size[most].max()):
                if self.structure.live is None:
                    break
                yield Left(place.parameter, most)
                gone += self._work(last, most)
                rest = without(standing, most)
                if rest is None or gone > 0.5:
                    break
                none = np.zeros_like(self.structure.interfaces.area)
                place = self._place(*rest, standing.parameter, none, bodies=standing.bodies)
                start, fallen = place, 0.0
            if place.limit.multiplier is not None:
                carried = self.structure.live is None or place.limit.multiplier > 0
                value = place.limit.multiplier if carried else None
                opened, shut = start.touching() - place.touching(), place.touching() - start.touching()
                joints = tuple(sorted(opened)), tuple(sorted(shut))
                yield PathEvent("jump", place.parameter, last.value, value, *joints)
                return None if value is None else place
        return None


def _state(place: Place, found: Limited) -> State:
    """A limit state as a state of a path; its motion is for a unit rate of the parameter, where that moves on."""
    linkage, upper = place.moving(), place.limit.multiplier
    assert found.multiplier is not None
    assert found.forces is not None
    if linkage.control is not None and not linkage.dilates and linkage.sliding.any():
        most = limiting(*place.where, place.bodies)
        upper = None if most is None else most[0]
    rate = for_unit(linkage, place.pose, place.limit.motion)
    motion = Motion(place.parameter, place.pose, rate, found.multiplier)
    return State(motion, linkage, found.forces, place.open, upper, place.bodies is not None)
