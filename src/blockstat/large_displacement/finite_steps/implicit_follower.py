"""Following a large structure by implicit steps, in which contacts slide, open and close (`statics.implicit_step`).

A mechanism of hundreds of blocks slides, opens and closes at many joints at once, and gaps of a thousandth of a block
decide which of them carry. So each step is one program in the motions of all blocks that knows all gaps. The live
work of a step is given: the structure is driven by the displacement that is conjugate to the live load. What falls
while that is held falls within the step, onto the contacts below it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE, gaps, pair_points
from blockstat.large_displacement.displaced.face_overlap import with_overlap_points
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, rotation_matrices
from blockstat.large_displacement.displaced.structure import Configuration, Structure
from blockstat.large_displacement.finite_steps.fall import FallenBlocks, without_blocks
from blockstat.large_displacement.finite_steps.trial_state import per_unit_parameter
from blockstat.large_displacement.linkage.jump import FALLING_TOGETHER, MAX_PART_FALLEN
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathEnd, PathPoint, PathState
from blockstat.large_displacement.statics.implicit_step import ACCURACY, ImplicitStep, implicit_step
from blockstat.large_displacement.statics.limit_state import associated_limit
from blockstat.typing import Ints

#: Contacts with a gap up to this may close in a step. Relative to the median size of the blocks. Chosen: a block that
#: has nothing so near below it has lost its bearing.
NEAR = 0.1
#: Joints that have slid by more than this get new contact points. Relative to the largest block. Chosen: as where
#: corners are told apart.
SLID = CORNER_TOLERANCE
#: The live work of a step differs from that of the one before by this factor at most. Chosen: lengths grow back within a
#: few steps where they were halved.
MOST_LENGTHENING = 2.0
#: The first step, relative to the longest. Chosen: as long as those that follow in a facade of some hundred blocks.
FIRST_STEP = 0.5
#: A step is halved in which the multiplier changes by more than so many times the wanted change. Chosen: the multiplier
#: of a step depends a little on its length, and that is no change of the mechanism.
LEAP = 3.0
#: A step is halved so many times at most. Chosen: across a change of the mechanism the value changes much in any step,
#: and blocks that fall do so in any step.
MOST_HALVINGS = 4
#: Steps of a path at most. Chosen: a path without end is broken off.
MAX_STEPS = 2000
#: Trial steps that locate the end at most. Every `BISECTION`-th of them halves the interval. Chosen: the secant method
#: alone may converge slowly from one side where the value bends.
MAX_END_TRIALS, BISECTION = 12, 3
#: Stands in for a change of zero where it is divided by.
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Here:
    """A pose on the path, and the step that leads on from it."""

    linkage: Linkage  #: its contacts are those of the pose; its active set is not used
    pose: Pose
    parameter: float  #: displacement of the control [m]
    work: float  #: of the live load in the step [J]
    step: ImplicitStep

    def passed(self, part: float) -> Pose:
        """Return the pose after a part of the step.

        Parameters
        ----------
        part
            From 0 to 1.

        Returns
        -------
        Pose
            Rotations are finite.
        """
        motion = part * self.step.motion
        rotation = rotation_matrices(motion[:, 3:]) @ self.pose.rotation
        return Pose(rotation, self.pose.displacement + motion[:, :3])


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
        scale, part, travel, last, gone = abs(start.value), 1.0, 0.0, start, 0.0
        here = self._at(linkage, start.pose, self._first_work(start))
        for _ in range(MAX_STEPS):
            while here.step.multiplier is None:
                blocks = _falling(here)
                if not len(blocks):
                    yield PathEnd.LOST
                    return
                gone += self.structure.part_of_live_power(last.pose, last.tangent, blocks)
                rest = without_blocks(here.linkage, blocks)
                if rest is None or gone > MAX_PART_FALLEN:
                    yield PathEnd.COLLAPSE
                    return
                yield FallenBlocks(here.parameter, blocks)
                here = self._at(rest, here.pose, here.work)
            if np.isinf(here.step.multiplier):
                yield PathEnd.LOCKED
                return
            state = _state(here)
            yield state
            last = state.point
            here, after = self._next(here, part, scale)
            end = self._end_passed(after, scale)
            if end is not None:
                yield from self._located_end(here, after, scale, end)
                return
            travel += here.step.length
            part = (
                self._lengthening(after, travel, 1.0 - after.step.multiplier / scale) if after.step.multiplier else 1.0
            )
            here = after
        yield PathEnd.LOST

    def _first_work(self, start: PathPoint) -> float:
        """Live work of a first step along the tangent at the start [J]."""
        assembly = self.structure.assembly
        speed = float(corner_speed(displaced_assembly(assembly, start.pose), start.tangent).max())
        return float((self.structure.live_load(start.pose) * start.tangent).sum()) * FIRST_STEP * self.step / speed

    def _at(self, linkage: Linkage, pose: Pose, work: float) -> Here:
        """A pose and the step of a given live work that leads on from it."""
        assembly, structure = linkage.assembly, linkage.structure
        assert linkage.control is not None
        parameter = linkage.control.value(assembly, pose)
        contacts, near = linkage.contacts, NEAR * float(np.median(assembly.size))
        gap = gaps(assembly, contacts, pose, parameter)
        points = pair_points(assembly, contacts, pose, parameter)
        slip = np.sqrt(np.maximum(((points[:, 1] - points[:, 0]) ** 2).sum(axis=1) - gap**2, 0.0))
        slid = (gap <= near) & (slip > SLID * float(assembly.size.max()))
        joints = np.unique(contacts.joint[slid])
        joints = joints[structure.interfaces.area[joints] > 0]
        if len(joints):
            contacts = with_overlap_points(structure, contacts, joints, pose, parameter)
            gap = gaps(assembly, contacts, pose, parameter)
        closed = gap <= near
        linkage = replace(linkage, contacts=contacts, sticking=closed, sliding=np.zeros_like(closed))
        step = implicit_step(Configuration(structure, contacts, closed, pose, parameter), work)
        return Here(linkage, pose, parameter, work, step)

    def _next(self, here: Here, part: float, scale: float) -> tuple[Here, Here]:
        """A step that is kept, and where it leads.

        The step is halved where it is longer than `step`, and where the multiplier changes much or none is carried.
        """
        for halvings in range(MOST_HALVINGS + 1):
            assert here.step.multiplier is not None
            last = halvings == MOST_HALVINGS
            if here.step.length <= MOST_LENGTHENING * self.step or last:
                after = self._at(here.linkage, here.passed(1.0), part * here.work)
                value = after.step.multiplier
                if last or (value is not None and abs(value - here.step.multiplier) <= LEAP * self.change * scale):
                    break
            part = 1.0
            shorter = self._at(here.linkage, here.pose, here.work / 2)
            if shorter.step.multiplier is None or np.isinf(shorter.step.multiplier):
                after = self._at(here.linkage, here.passed(1.0), here.work)
                break
            here = shorter
        return here, after

    def _lengthening(self, after: Here, travel: float, lost: float) -> float:
        """The live work of the step after the next relative to that of the next.

        For a step in which the multiplier loses `change`, as it has on the way.
        """
        wanted = min(travel * self.change / max(lost, TINY), self.step)
        return float(np.clip(wanted / max(after.step.length, TINY), 1.0 / MOST_LENGTHENING, MOST_LENGTHENING))

    def _end_passed(self, here: Here, scale: float) -> PathEnd | None:
        """The end of the path that a pose is at or beyond."""
        multiplier = here.step.multiplier
        if multiplier is None or np.isinf(multiplier):
            return None
        if multiplier <= self.tolerance * scale:
            return PathEnd.ZERO
        return PathEnd.REACHED if here.parameter >= self.end else None

    def _located_end(self, here: Here, after: Here, scale: float, end: PathEnd) -> Iterator[PathState | PathEnd]:
        """The state at the end, located by the secant method with bisections, and the end."""

        def excess(at: Here) -> float:
            assert at.step.multiplier is not None
            return -at.step.multiplier if end is PathEnd.ZERO else at.parameter - self.end

        tolerance = self.tolerance * (scale if end is PathEnd.ZERO else self.end)
        low, high, below, above, found = 0.0, 1.0, excess(here), excess(after), after
        for count in range(MAX_END_TRIALS):
            if abs(excess(found)) <= tolerance:
                yield _state(found)
                yield end
                return
            part = 0.5 if count % BISECTION == BISECTION - 1 else below / (below - above)
            middle = low + part * (high - low)
            found = self._at(here.linkage, here.passed(middle), here.work)
            if found.step.multiplier is None or np.isinf(found.step.multiplier):
                break
            if excess(found) > 0:
                high, above = middle, excess(found)
            else:
                low, below = middle, excess(found)
        # The multiplier falls below zero at a change of the mechanism.
        yield PathEnd.COLLAPSE if end is PathEnd.ZERO else PathEnd.LOST


def _falling(here: Here) -> Ints:
    """Blocks that fall together; none where the step was not solved."""
    speed = corner_speed(displaced_assembly(here.linkage.assembly, here.pose), here.step.motion)
    return np.flatnonzero(speed > FALLING_TOGETHER * speed.max()) if speed.max() > 0 else np.empty(0, dtype=np.int64)


def _state(here: Here) -> PathState:
    """The state of the path at a pose; its upper bound is that of associated flow."""
    step = here.step
    assert step.multiplier is not None
    assert step.forces is not None
    linkage = replace(here.linkage, sticking=step.holds & ~step.slides, sliding=step.slides)
    upper = None
    if step.slides.any():
        found = associated_limit(linkage.configuration(here.pose, here.parameter), accuracy=ACCURACY)
        upper = None if found is None else found.multiplier
    rate = per_unit_parameter(linkage, here.pose, step.motion)
    point = PathPoint(here.parameter, here.pose, rate, step.multiplier)
    return PathState(point, linkage, step.forces, step.residual_gap, upper)
