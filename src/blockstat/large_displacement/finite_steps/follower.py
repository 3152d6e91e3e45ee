"""Following a structure by finite steps, where joints slide and open at so many places that it is no linkage.

At each pose the limit analysis on the closed contacts gives the multiplier, the forces that carry it, and the
mechanism. Joints slide in it without opening (De Saxce's fixed point), as far as the rigid bodies allow that, or with
associated flow. On supports that move, the motion of least potential energy gives the force on them. A step leads along
the mechanism until the fastest corner has moved by a given length, and the closed contacts are projected onto zero gap
(`contact_projection`). Where no multiplier is carried, blocks fall (`fall`).

The length of a step is the arc length of the fastest corner, not a displacement of the control. So the control
displacement may decrease: loose parts and snap-back are followed too. Unlike on a linkage, the pose depends on the
length of the steps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED
from blockstat.large_displacement.displaced.pose import free_sizes
from blockstat.large_displacement.displaced.structure import SLACK, Structure
from blockstat.large_displacement.finite_steps.fall import FallenBlocks, fall
from blockstat.large_displacement.finite_steps.step import stepped, trial_state_at
from blockstat.large_displacement.finite_steps.trial_state import TrialState, path_state
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathEnd, PathEvent, PathPoint, PathState, end_at
from blockstat.large_displacement.linkage.root_finding import NoRootError
from blockstat.large_displacement.overlap.edge_overlap import cut_to_faces
from blockstat.large_displacement.overlap.face_overlap import with_overlap_points

#: Largest deviation of the value from the straight line through the two states before it in a step that is longer than
#: `StepFollower.step`. Relative to the value at the beginning. Chosen: a thousandth, in a step that is a thirtieth of
#: the way.
MAX_DEVIATION = 1e-3
#: The shortest step, relative to `StepFollower.step`. Chosen: across a change of the mechanism the value changes much
#: in any step.
MIN_STEP = 1.0 / 16.0
#: A step is lengthened by this factor at most, and aims at the second, a part of the largest change of the value.
#: Chosen: a trial that has to be repeated with a shorter step costs as much as one that is kept.
MOST_LENGTHENING, AIMED_CHANGE = 2.0, 0.9
#: Steps of a path at most. Chosen: a path without end is broken off.
MAX_STEPS = 2000
#: Trial steps that locate the end at most. Every `BISECTION`-th of them halves the interval. Chosen: the secant method
#: alone may converge slowly from one side where the value bends.
MAX_END_TRIALS, BISECTION = 12, 3
#: Stands in for a change of zero where it is divided by.
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class StepFollower:
    """Follows one structure by finite steps, with step length control."""

    structure: Structure
    end: float  #: largest displacement of the control, or movement of the supports [m]
    step: float  #: longest step of the fastest corner where the value is not a straight line [m]
    longest: float  #: longest step where it is [m]
    change: float  #: largest change of the multiplier in a step, relative to that at the beginning
    tolerance: float  #: of a multiplier of zero, relative to that at the beginning, and of `end`, relative to it

    def follow(self, linkage: Linkage, start: PathPoint) -> Iterator[PathState | PathEvent | FallenBlocks | PathEnd]:
        """Yield the states that follow a given one in order, jumps and blocks that fall out, and at last how it ends.

        Parameters
        ----------
        linkage
            The linkage that is lost.
        start
            Where that is, and the value there.

        Yields
        ------
        PathState, PathEvent, FallenBlocks or PathEnd
            In order; the end comes last.
        """
        trial = self._first_trial(linkage, start)
        before: PathPoint | None = None
        last, scale, step = start, abs(start.value), self.step
        for _ in range(MAX_STEPS):
            if trial.limit.multiplier is None:
                try:
                    fallen = yield from fall(trial, last, self.step)
                except NoRootError:
                    break
                if fallen is None:
                    yield PathEnd.COLLAPSE
                    return
                before = None
                trial = fallen
                if trial.limit.multiplier is None:
                    continue
            if end_at(trial.limit) is PathEnd.LOCKED:
                yield PathEnd.LOCKED
                return
            state = path_state(trial)
            yield state
            assert trial.limit.multiplier is not None
            try:
                after, taken = self._next(before, trial, step, scale)
            except NoRootError:
                break
            last = state.point
            before = replace(last, value=trial.limit.multiplier)
            end = self._end_passed(after, scale)
            if end is not None:
                yield from self._located_end(trial, after, taken, scale, end)
                return
            step = taken if taken < step else self._next_length(before, after, taken, scale)  # not again too long
            trial = after
        yield PathEnd.LOST

    def _first_trial(self, linkage: Linkage, start: PathPoint) -> TrialState:
        """The state where the linkage is lost.

        Joints that slid get new contact points. On the linkage each of them was a corner of one block only, and the
        joints may slide back.
        """
        faces = self.structure.interfaces
        joints = np.unique(linkage.contacts.joint[linkage.sliding])
        contacts = cut_to_faces(self.structure, linkage.contacts, joints, start.pose, start.parameter).contacts
        joints = joints[faces.area[joints] > 0]
        contacts = with_overlap_points(self.structure, contacts, joints, start.pose, start.parameter)
        none = np.zeros(faces.n_interfaces)
        linkage = replace(linkage, contacts=contacts)
        return trial_state_at(linkage, start.pose, start.parameter, none)

    def _next(self, before: PathPoint | None, trial: TrialState, step: float, scale: float) -> tuple[TrialState, float]:
        """The state after a step, and its length.

        The step is halved where the multiplier changes much or none is carried, and where it deviates from the straight
        line through the two states before it. On supports that move it is halved, too, where the projection leaves
        contacts further open than a motion that keeps them closed can open them, to first order and to the speed at
        which contacts stick: `NoRootError` where even the shortest step does. So it is where a tie is longer by more
        than `SLACK` that does not yield: the way on is barred, and what no block moves by would count as its motion.
        """
        now, size = trial.limit.multiplier, float(free_sizes(trial.linkage.assembly).max())
        assert now is not None
        slope = np.nan
        if before is not None and before.parameter != trial.parameter:
            slope = (now - before.value) / (trial.parameter - before.parameter)
        while True:
            after = stepped(trial, step)
            value = after.limit.multiplier
            torn = after.left_open - trial.left_open > step * (STICKING_SPEED + step / size)
            barred = after.stretched > SLACK * float(free_sizes(trial.linkage.assembly).max())
            if barred or (torn and self.structure.live is None):  # a live load may find other blocks in contact
                if step <= MIN_STEP * self.step:
                    raise NoRootError
            elif value is not None and np.isfinite(value) and abs(value - now) <= self.change * scale:
                deviation = abs(value - now - slope * (after.parameter - trial.parameter))
                if step <= self.step or deviation <= MAX_DEVIATION * scale:
                    return after, step
            elif step <= MIN_STEP * self.step:
                return after, step
            step /= 2

    def _next_length(self, before: PathPoint, after: TrialState, step: float, scale: float) -> float:
        """Length of the next step [m]: longer, unless it would change the multiplier too much, but not too short.

        Where two states are in equilibrium the multiplier may leap to and fro between them in any step.
        """
        factor = MOST_LENGTHENING
        if after.limit.multiplier is not None:
            # `before` has the multiplier of the state before `after`.
            change = abs(after.limit.multiplier - before.value)
            factor = min(factor, AIMED_CHANGE * self.change * scale / max(change, TINY))
        return max(min(factor * step, max(self.longest, self.step)), MIN_STEP * self.step)

    def _end_passed(self, trial: TrialState, scale: float) -> PathEnd | None:
        """The end of the path that a state is at or beyond."""
        multiplier = trial.limit.multiplier
        if multiplier is None or np.isinf(multiplier):
            return None
        if self.structure.live is not None and multiplier <= self.tolerance * scale:
            return PathEnd.ZERO
        return PathEnd.REACHED if trial.parameter >= self.end else None

    def _located_end(
        self, trial: TrialState, after: TrialState, step: float, scale: float, end: PathEnd
    ) -> Iterator[PathState | PathEnd]:
        """The state at the end, located by the secant method with bisections, and the end."""

        def excess(at: TrialState) -> float:
            assert at.limit.multiplier is not None
            return -at.limit.multiplier if end is PathEnd.ZERO else at.parameter - self.end

        tolerance = self.tolerance * (scale if end is PathEnd.ZERO else self.end)
        low, high, below, above, found = 0.0, step, excess(trial), excess(after), after
        lost: PathEnd | None = None
        for count in range(MAX_END_TRIALS):
            if abs(excess(found)) <= tolerance:
                yield path_state(found)
                yield end
                return
            part = 0.5 if count % BISECTION == BISECTION - 1 else below / (below - above)
            middle = low + part * (high - low)
            there = stepped(trial, middle)
            if (lost := end_at(there.limit)) is not None:
                break
            found = there
            if excess(found) > 0:
                high, above = middle, excess(found)
            else:
                low, below = middle, excess(found)
        # The multiplier falls below zero at a change of the mechanism, unless what is on the way there is not known.
        if end is PathEnd.ZERO:
            yield lost if lost is PathEnd.LOST else PathEnd.COLLAPSE
        else:  # blocks that fall may be caught again beyond
            yield lost if lost is PathEnd.LOCKED else PathEnd.LOST
