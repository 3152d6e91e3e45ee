"""Following a structure by finite steps, where joints slide and open at so many places that it is no linkage.

At each pose the limit analysis on the contacts that touch tells the multiplier, with forces that carry it, and the
mechanism. A step leads along it, until the fastest corner has moved a given length, and the contacts that have stuck or
slid are closed again (`closing`): joints slide without opening, as far as the bodies let them. Where no multiplier is
carried, the blocks fall while the live load does no work, until contacts shut or the blocks have left.

The steps are along the arc of the fastest corner, so that loose parts and snaps back are followed too. Unlike on a
linkage, the pose depends on the length of the steps.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.closing import closed_up
from blockstat.large_displacement.contacts import CORNER, closed_again, gaps, sides
from blockstat.large_displacement.jump import NoRootError, statuses
from blockstat.large_displacement.linkage import Control, Linkage
from blockstat.large_displacement.path import Motion, PathEnd, PathEvent, State
from blockstat.large_displacement.pose import Pose, displaced
from blockstat.large_displacement.sliding import clipped_again, taken
from blockstat.large_displacement.statics import Limited, Structure, limited
from blockstat.typing import Floats, Ints

#: Blocks that have fallen by this part of their size without being stopped have left.
LEFT = 0.5
#: Steps of a path at most, and trials to meet a displacement or a multiplier of zero.
MOST, TRIALS = 2000, 12
#: The shortest step and that of a fall, relative to the longest.
SHORTEST, FALL = 1.0 / 16.0, 1.0 / 4.0


@dataclass(frozen=True, eq=False)
class Left:
    """Blocks that have fallen out of the structure."""

    parameter: float  #: where [m]
    blocks: Ints  #: their numbers


@dataclass(frozen=True, eq=False)
class _Place:
    """Where the blocks are, what touches, and the limit state there."""

    structure: Structure  #: in which what has left is at rest
    linkage: Linkage  #: its contacts that stick are all that touch
    pose: Pose
    limit: Limited
    open: float  #: how far contacts are open that count as touching [m]

    @property
    def parameter(self) -> float:
        """Displacement of the control [m]."""
        control = self.linkage.control
        assert control is not None
        return control.value(self.linkage.assembly, self.pose)

    def moving(self) -> Linkage:
        """The linkage of what sticks and slides in the motion of the limit state."""
        pinned, sliding = statuses(replace(self.linkage, dilates=True), self.pose, 0.0, self.limit.motion)
        return replace(self.linkage, pinned=pinned, sliding=sliding)

    def speed(self) -> float:
        """That of the fastest corner in the motion of the limit state."""
        return float(corner_speed(displaced(self.linkage.assembly, self.pose), self.limit.motion).max(initial=0.0))

    def touching(self) -> set[int]:
        """The joints that touch somewhere."""
        return set(self.linkage.contacts.joint[self.linkage.pinned].tolist())


@dataclass(frozen=True, eq=False)
class Stepper:
    """Follows one structure by finite steps."""

    structure: Structure
    end: float  #: largest displacement of the control [m]
    step: float  #: the longest, of the fastest corner [m]
    change: float  #: of the multiplier in one step, relative to that at the beginning, before the step is halved
    tolerance: float  #: of the multiplier where it is zero, relative to that at the beginning, and of the displacement

    def follow(self, start: State) -> Iterator[State | PathEvent | Left | PathEnd]:
        """Yield the states that follow a given one in order, with jumps and what leaves, and at last how it ends.

        Parameters
        ----------
        start
            Where it begins; its contacts that stick or slide touch.

        Yields
        ------
        State, PathEvent, Left or PathEnd
            In order; the end comes last.
        """
        open_ = np.zeros(self.structure.interfaces.n_interfaces)
        place = self._place(self.structure, self._anew(start), start.motion.pose, open_)
        last, scale, step = start, abs(start.motion.value), self.step
        for _ in range(MOST):
            if place.limit.multiplier is None:
                try:
                    fallen = yield from self._fall(place, last)
                except NoRootError:
                    break
                if fallen is None:
                    yield PathEnd.COLLAPSE
                    return
                place = fallen
            last = _state(place)
            yield last
            after, step = self._next(place, step, self.change * scale)
            end = None if after.limit.multiplier is None else self._passed(after, scale)
            if end is not None:
                yield from self._met(place, after, step, scale, end)
                return
            place, step = after, min(2 * step, self.step)
        yield PathEnd.LOST

    def _anew(self, start: State) -> Linkage:
        """The linkage of a state whose sliding contacts are no longer of one corner only: they may slide back."""
        linkage, faces = start.linkage, self.structure.interfaces
        joints = np.unique(linkage.contacts.joint[linkage.sliding])
        joints = joints[faces.area[joints] > 0]
        contacts = clipped_again(linkage.assembly, faces, linkage.contacts, joints, start.motion.pose)
        return replace(linkage, contacts=contacts)

    def _passed(self, place: _Place, scale: float) -> PathEnd | None:
        """The end that a place is at or beyond."""
        assert place.limit.multiplier is not None
        if place.limit.multiplier <= self.tolerance * scale:
            return PathEnd.ZERO
        return PathEnd.REACHED if place.parameter >= self.end else None

    def _next(self, place: _Place, step: float, change: float) -> tuple[_Place, float]:
        """The place after a step, and its length: shorter where the multiplier changes much or none is carried."""
        assert place.limit.multiplier is not None
        while True:
            after = self._moved(place, step)
            value = after.limit.multiplier
            if (value is not None and abs(value - place.limit.multiplier) <= change) or step <= SHORTEST * self.step:
                return after, step
            step /= 2

    def _met(self, place: _Place, after: _Place, step: float, scale: float, end: PathEnd) -> Iterator[State | PathEnd]:
        """The last state, at which the multiplier is zero or the displacement is the one asked for, and the end."""

        def beyond(at: _Place) -> float:
            assert at.limit.multiplier is not None
            return -at.limit.multiplier if end is PathEnd.ZERO else at.parameter - self.end

        room = self.tolerance * (scale if end is PathEnd.ZERO else self.end)
        low, high, behind, over, found = 0.0, step, beyond(place), beyond(after), after
        for trial in range(TRIALS):
            if abs(beyond(found)) <= room:
                yield _state(found)
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

    def _moved(self, place: _Place, step: float) -> _Place:
        """The place after a step along the motion, with what should touch closed."""
        linkage = place.moving()
        motion = step / place.speed() * linkage.of_bodies(place.limit.motion)
        pose = linkage.shifted(place.pose, motion, linkage.origins(place.pose))
        held = _conjugate(place.structure)
        closing = closed_up(linkage, pose, held, held.value(linkage.assembly, pose), 10 * step)
        open_ = np.zeros(self.structure.interfaces.n_interfaces)
        np.maximum.at(open_, linkage.contacts.joint, closing.open)
        return self._place(place.structure, linkage, closing.pose, open_)

    def _place(self, structure: Structure, linkage: Linkage, pose: Pose, open_: Floats) -> _Place:
        """What touches at a pose, with contacts open by so much in each joint; those that have slid get new points."""
        assembly, contacts = structure.assembly, linkage.contacts
        room = CORNER * float(assembly.size.max())
        closed = gaps(assembly, contacts, pose, 0.0) <= room + open_[contacts.joint]
        both = sides(assembly, contacts, pose, 0.0)
        slid = closed & (np.linalg.norm(both[:, 1] - both[:, 0], axis=1) > room)
        joints = np.unique(contacts.joint[slid])
        faces = self.structure.interfaces.area[joints] > 0
        if faces.any():
            contacts = clipped_again(assembly, self.structure.interfaces, contacts, joints[faces], pose)
            closed = gaps(assembly, contacts, pose, 0.0) <= room + open_[contacts.joint]
        lines = np.flatnonzero(closed & np.isin(contacts.joint, joints[~faces]))
        if len(lines):
            contacts = closed_again(assembly, contacts, lines, pose, 0.0)
        linkage = replace(linkage, assembly=assembly, contacts=contacts, pinned=closed, sliding=np.zeros_like(closed))
        widest = float(gaps(assembly, contacts, pose, 0.0)[closed].max(initial=0.0))
        return _Place(structure, linkage, pose, limited(structure, contacts, closed, pose, 0.0), widest)

    def _work(self, state: State, blocks: Ints) -> float:
        """The part of the work of the live load that it does on some blocks, in the motion of a state."""
        power = (self.structure.live_load(state.motion.pose) * state.motion.rate).sum(axis=1)
        return float(power[blocks].sum() / power.sum())

    def _fall(self, place: _Place, last: State) -> Generator[PathEvent | Left, None, _Place | None]:
        """Let blocks fall until a positive multiplier is carried; None where most of what the load moves has fallen."""
        start, step, fallen, gone = place, FALL * self.step, 0.0, 0.0
        for _ in range(MOST):
            standing = place
            if not place.limit.motion.any():
                raise NoRootError
            place = self._moved(place, step)
            fallen += step
            moved = np.linalg.norm(place.pose.displacement - start.pose.displacement, axis=1)
            most = np.flatnonzero(moved > 0.5 * moved.max())
            if place.limit.multiplier is None and fallen > LEFT * float(place.linkage.assembly.size[most].max()):
                yield Left(place.parameter, most)
                gone += self._work(last, most)
                rest = _without(standing, most)
                if rest is None or gone > 0.5:
                    break
                place = self._place(*rest)
                start, fallen = place, 0.0
            if place.limit.multiplier is not None:
                value = place.limit.multiplier if place.limit.multiplier > 0 else None
                opened, shut = start.touching() - place.touching(), place.touching() - start.touching()
                joints = tuple(sorted(opened)), tuple(sorted(shut))
                yield PathEvent("jump", place.parameter, last.motion.value, value, *joints)
                return None if value is None else place
        return None


def _conjugate(structure: Structure) -> Control:
    """The mean of all displacements weighted by the live load."""
    live = structure.live
    assert live is not None
    free = ~structure.assembly.support[live.block]
    block, point, force = live.block[free], live.point[free], live.force[free]
    return Control(block, point, force / np.linalg.norm(force, axis=1).sum())


def _state(place: _Place) -> State:
    """A limit state as a state of a path; its motion is for a unit rate of the control, where that moves on."""
    linkage, found = place.moving(), place.limit
    control, speed = linkage.control, place.speed()
    assert control is not None
    assert found.multiplier is not None
    assert found.forces is not None
    rate = control.rate(linkage.assembly, place.pose, found.motion)
    motion = found.motion / (rate if rate > 1e-6 * speed else speed)
    return State(Motion(place.parameter, place.pose, motion, found.multiplier), linkage, found.forces, place.open)


def _without(place: _Place, blocks: Ints) -> tuple[Structure, Linkage, Pose, Floats] | None:
    """The structure without blocks; None where most of the control is on them, or nothing else is left that moves."""
    assembly, control = place.structure.assembly, place.linkage.control
    assert control is not None
    gone = np.zeros(assembly.n_blocks, dtype=bool)
    gone[blocks] = True
    support = assembly.support | gone
    weight = np.linalg.norm(control.along, axis=1)
    if support.all() or weight[gone[control.block]].sum() > 0.5 * weight.sum():
        return None
    structure = replace(place.structure, assembly=replace(assembly, support=support))
    contacts = place.linkage.contacts
    kept = np.flatnonzero(~gone[contacts.pair].any(axis=1))
    linkage = replace(
        place.linkage, assembly=structure.assembly, contacts=taken(contacts, kept),
        pinned=place.linkage.pinned[kept], sliding=place.linkage.sliding[kept],
    )  # fmt: skip
    return structure, linkage, place.pose, np.zeros(structure.interfaces.n_interfaces)
