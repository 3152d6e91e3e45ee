"""Following a large structure by implicit steps, in which contacts slide, open and close (`statics.implicit_step`).

A mechanism of hundreds of blocks slides, opens and closes at many joints at once, and gaps of a thousandth of a block
decide which of them carry. So each step is one program in the motions of all blocks that knows all gaps. The live work
of a step is given: the structure is driven by the displacement that is conjugate to the live load. After each step the
blocks settle: a second program, in which the live load does no work, closes what the step has left open, and what falls
while the live load does no work falls onto the contacts below it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE, gaps, pair_points
from blockstat.large_displacement.displaced.contact_status import tie_status
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, free_sizes, rotation_matrices
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.finite_steps.fall import (
    FallenBlocks,
    without_blocks,
    without_ties_of_blocks,
)
from blockstat.large_displacement.finite_steps.trial_state import per_unit_parameter
from blockstat.large_displacement.linkage.jump import FALLING_TOGETHER, MAX_PART_FALLEN
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathEnd, PathPoint, PathState
from blockstat.large_displacement.overlap.edge_overlap import cut_to_faces
from blockstat.large_displacement.overlap.face_overlap import with_overlap_points
from blockstat.large_displacement.statics.implicit_step import ImplicitStep, implicit_step, settling_step
from blockstat.large_displacement.statics.limit_state import associated_multiplier
from blockstat.typing import Floats, Ints

#: Contacts with a gap up to this may close in a step. Relative to the median size of the free blocks. Chosen: a block
#: that has nothing so near below it has lost its bearing.
NEAR = 0.1
#: The live work of a step differs from that of the one before by this factor at most. Chosen: lengths grow back within
#: a few steps where they were halved.
MOST_LENGTHENING = 2.0
#: The first step, relative to the longest. Chosen: as long as those that follow in a facade of some hundred blocks.
FIRST_STEP = 0.5
#: Least power of the live load in the first step, relative to that of all its forces at the fastest corner. Chosen:
#: where a linkage is lost while it goes back, its own is not positive.
LEAST_POWER = 1e-3
#: A step is halved in which the multiplier changes by more than so many times the wanted change. Chosen: the multiplier
#: of a step depends a little on its length, and that is no change of the mechanism.
LEAP = 3.0
#: A step is halved so many times at most. Chosen: across a change of the mechanism the value changes much in any step,
#: and blocks that fall do so in any step.
MOST_HALVINGS = 4
#: Steps of a path at most. Chosen: a path without end is broken off.
MAX_STEPS = 2000
#: Trial steps that locate the end at most. Chosen: the secant method from one side needs a few.
MAX_END_TRIALS = 6
#: A multiplier below this, relative to that at the beginning, is not positive. Chosen: what solvers leave.
NO_MULTIPLIER = 1e-6
#: Accuracy of the upper bound of a state, as in `EarlyEnd`: a hundredth of the default tolerance of a curve. No error
#: of it adds up, as no step follows from it.
BOUND_ACCURACY = 1e-6
#: Below this half of an angle [rad] the second coefficient of a screw motion is its limit. Chosen: the difference is
#: then below rounding.
SMALL_ANGLE = 1e-4
#: Stands in for a change of zero where it is divided by.
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Here:
    """A pose on the path, and the step that leads on from it."""

    linkage: Linkage  #: its contacts are those of the pose, and those in its active set may close in the step
    pose: Pose
    work: float  #: of the live load in the step [J]
    step: ImplicitStep

    @property
    def parameter(self) -> float:
        """The displacement of the control [m]."""
        assert self.linkage.control is not None
        return self.linkage.control.value(self.linkage.assembly, self.pose)

    @property
    def multiplier(self) -> float:
        """The multiplier that is carried; minus infinity where blocks fall under any."""
        return -np.inf if self.step.multiplier is None else self.step.multiplier

    @property
    def falling(self) -> Ints:
        """Blocks that fall together; none where a multiplier is carried, and where the step was not solved."""
        if self.step.multiplier is not None or not self.step.motion.any():
            return np.empty(0, dtype=np.int64)
        speed = corner_speed(displaced_assembly(self.linkage.assembly, self.pose), self.step.motion)
        return np.flatnonzero(speed > FALLING_TOGETHER * speed.max())


@dataclass(frozen=True, eq=False)
class ImplicitFollower:
    """Follows one large structure by implicit steps, with step length control."""

    structure: Structure
    end: float  #: largest displacement of the control [m]
    step: float  #: longest step of the fastest corner [m]
    change: float  #: wanted change of the multiplier in a step, relative to that at the beginning
    tolerance: float  #: of a multiplier of zero, relative to that at the beginning, and of `end`, relative to it

    def follow(self, linkage: Linkage, start: PathPoint) -> Iterator[PathState | FallenBlocks | PathEnd]:
        """Yield the states that follow a given one in order, blocks that fall out, and at last how the path ends.

        Parameters
        ----------
        linkage
            The linkage that is lost.
        start
            Where that is, and the value there.

        Yields
        ------
        PathState, FallenBlocks or PathEnd
            In order; the end comes last.
        """
        scale, travel, part, gone, last = abs(start.value), 0.0, 1.0, 0.0, start
        here, before = self._at(linkage, start.pose, self._first_work(start)), None
        for _ in range(MAX_STEPS):
            while here.step.multiplier is None:
                blocks = here.falling
                gone += self._moved_by_load(blocks, last)
                rest = without_blocks(here.linkage, blocks) if len(blocks) else None
                if rest is None or gone > MAX_PART_FALLEN:
                    yield PathEnd.COLLAPSE if len(blocks) else PathEnd.LOST
                    return
                yield FallenBlocks(here.parameter, blocks)
                pose = without_ties_of_blocks(here.pose, here.linkage.assembly, blocks)
                here = self._at(rest, pose, here.work)
            if np.isinf(here.multiplier):
                yield PathEnd.LOCKED
                return
            state = _state(here)
            yield state
            last = state.point
            here, after = self._next(here, last, part, scale)
            end = self._end_passed(after, last, scale)
            if end is not None:
                yield from self._located_end(before, here, after, scale, end)
                return
            travel += here.step.length
            part = self._lengthening(after, travel, scale)
            before, here = here, after
        yield PathEnd.LOST

    def _first_work(self, start: PathPoint) -> float:
        """Live work of a first step along the tangent at the start [J]."""
        assembly, live = self.structure.assembly, self.structure.live_load(start.pose)
        speed = float(corner_speed(displaced_assembly(assembly, start.pose), start.tangent).max())
        least = LEAST_POWER * float(np.linalg.norm(live[:, :3], axis=1).sum()) * speed
        return max(float((live * start.tangent).sum()), least) * FIRST_STEP * self.step / speed

    def _at(self, linkage: Linkage, pose: Pose, work: float) -> Here:
        """A pose and the step of a given live work that leads on from it."""
        linkage = _with_near_contacts(linkage, pose)
        return Here(linkage, pose, work, implicit_step(linkage.configuration(pose, 0.0), work))

    def _after(self, here: Here, part: float, work: float) -> Here:
        """Where a part of a step leads when the blocks have settled, and the step of a given live work from there."""
        pose = _moved(here.pose, part * here.step.motion)
        ties, slack = tie_status(here.linkage.configuration(here.pose, 0.0), here.step.motion)
        pose = replace(here.linkage, ties=ties, slack=slack).with_yielded_ties(pose, 0.0)
        linkage = _with_near_contacts(here.linkage, pose)
        pose = _moved(pose, settling_step(linkage.configuration(pose, 0.0), work))
        return self._at(linkage, pose, work)

    def _next(self, here: Here, last: PathPoint, part: float, scale: float) -> tuple[Here, Here]:
        """A step that is kept, and where it leads, with so many times its live work for the step from there.

        The step is halved where it is longer than `step`, and where the multiplier changes much or none is carried.
        """
        for halvings in range(MOST_HALVINGS + 1):
            kept = halvings == MOST_HALVINGS
            if here.step.length <= MOST_LENGTHENING * self.step or kept:
                after = self._after(here, 1.0, part * here.work)
                small = abs(after.multiplier - here.multiplier) <= LEAP * self.change * scale
                if small or kept or self._end_passed(after, last, scale) is PathEnd.ZERO:
                    break
            part = 1.0
            shorter = self._at(here.linkage, here.pose, here.work / 2)
            if not self.tolerance * scale < shorter.multiplier < np.inf:  # contacts that closed in the step carried it
                after = self._after(here, 1.0, here.work)
                break
            here = shorter
        return here, after

    def _lengthening(self, after: Here, travel: float, scale: float) -> float:
        """The live work of the step after the next relative to that of the next.

        For a step in which the multiplier loses `change`, as it has on the way.
        """
        lost = max(1.0 - after.multiplier / scale, TINY)
        wanted = min(travel * self.change / lost, self.step)
        return float(np.clip(wanted / max(after.step.length, TINY), 1.0 / MOST_LENGTHENING, MOST_LENGTHENING))

    def _moved_by_load(self, blocks: Ints, last: PathPoint) -> float:
        """The part of the power of the live load that is on some blocks, in the motion of the last state."""
        return self.structure.part_of_live_power(last.pose, last.tangent, blocks)

    def _end_passed(self, here: Here, last: PathPoint, scale: float) -> PathEnd | None:
        """The end of the path that a pose is at or beyond.

        Beyond a multiplier of zero the program has no answer, and what the live load moves falls.
        """
        if here.step.multiplier is None:
            return PathEnd.ZERO if self._moved_by_load(here.falling, last) > MAX_PART_FALLEN else None
        if here.multiplier <= self.tolerance * scale:
            return PathEnd.ZERO
        return PathEnd.REACHED if here.parameter >= self.end else None

    def _located_end(
        self, last: Here | None, here: Here, after: Here, scale: float, end: PathEnd
    ) -> Iterator[PathState | PathEnd]:
        """The state at the end, located by the secant method, and the end.

        Beyond a multiplier of zero nothing is known but that it is not positive. So the secant is that of the two last
        trials before it, and where it leads beyond, the interval is halved. A multiplier that falls to zero from more
        than it changes in a step has leapt: the mechanism has changed.
        """

        def excess(at: Here) -> float:
            if end is PathEnd.REACHED:
                return at.parameter - self.end
            return -at.multiplier if at.multiplier > NO_MULTIPLIER * scale else np.inf

        tolerance = self.tolerance * (scale if end is PathEnd.ZERO else self.end)
        found, short, high = after, (0.0, here), 1.0
        before = None if last is None else (-last.work / here.work, last)
        for _ in range(MAX_END_TRIALS):
            if abs(excess(found)) <= tolerance:
                yield _state(found)
                yield end
                return
            low, part = short[0], 0.5 * (short[0] + high)
            if before is not None and (gained := excess(short[1]) - excess(before[1])) > 0 and np.isfinite(gained):
                part = min(low - excess(short[1]) * (low - before[0]) / gained, 0.5 * (part + high))
            found = self._after(here, part, here.work)
            if excess(found) > 0:
                high = part
            else:
                before, short = short, (part, found)
        if short[0]:
            yield _state(short[1])
        if end is PathEnd.REACHED:
            yield PathEnd.LOST
        else:
            yield PathEnd.ZERO if short[1].multiplier <= self.change * scale else PathEnd.COLLAPSE


def _moved(pose: Pose, motion: Floats) -> Pose:
    """The pose after finite screw motions of all blocks, whose axes stay where those of the rates are.

    A block that turns about its edge keeps it: its centroid moves by (I + b W + c W W) v, with the matrix W of w x.
    """
    speed, spin = motion[:, :3], motion[:, 3:]
    half = 0.5 * np.linalg.norm(spin, axis=1)[:, None]
    b = 0.5 * np.sinc(half / np.pi) ** 2  # (1 - cos a) / a^2 of the angle a
    c = np.where(half > SMALL_ANGLE, (2 * half - np.sin(2 * half)) / np.maximum(2 * half, SMALL_ANGLE) ** 3, 1.0 / 6.0)
    across = np.cross(spin, speed)
    moved = speed + b * across + c * np.cross(spin, across)
    return replace(pose, rotation=rotation_matrices(spin) @ pose.rotation, displacement=pose.displacement + moved)


def _with_near_contacts(linkage: Linkage, pose: Pose) -> Linkage:
    """The linkage whose active set are the contacts that may close in a step.

    Joints that have slid get new contact points, the corners of the overlap of their faces; edges are cut to theirs.
    """
    structure, contacts = linkage.structure, linkage.contacts
    assembly = structure.assembly
    near = NEAR * float(np.median(free_sizes(assembly)))
    gap = gaps(assembly, contacts, pose, 0.0)
    apart = np.linalg.norm(np.diff(pair_points(assembly, contacts, pose, 0.0), axis=1)[:, 0], axis=1)
    slip = np.sqrt(np.maximum(apart**2 - gap**2, 0.0))
    joints = np.unique(contacts.joint[(gap <= near) & (slip > CORNER_TOLERANCE * float(free_sizes(assembly).max()))])
    contacts = cut_to_faces(structure, contacts, joints, pose, 0.0).contacts
    joints = joints[structure.interfaces.area[joints] > 0]
    if len(joints):
        contacts = with_overlap_points(structure, contacts, joints, pose, 0.0)
    if contacts is not linkage.contacts:
        gap = gaps(assembly, contacts, pose, 0.0)
    return replace(linkage, contacts=contacts, sticking=gap <= near, sliding=np.zeros(len(gap), dtype=bool))


def _state(here: Here) -> PathState:
    """The state of the path at a pose; its upper bound is that of associated flow."""
    step = here.step
    assert step.multiplier is not None
    assert step.forces is not None
    linkage = replace(here.linkage, sticking=step.holds & ~step.slides, sliding=step.slides)
    upper = None
    if step.slides.any():
        upper = associated_multiplier(linkage.configuration(here.pose, 0.0), BOUND_ACCURACY)
    rate = per_unit_parameter(linkage, here.pose, step.motion)
    point = PathPoint(here.parameter, here.pose, rate, step.multiplier)
    return PathState(point, linkage, step.forces, step.residual_gap, upper)
