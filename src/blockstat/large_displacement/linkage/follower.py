"""Following the path of a linkage: step length, events, and the pieces between events.

On a piece of the path the same contacts stick and slide, and the pose is that of one linkage. A piece ends where an
open contact closes, where no forces balance the loads any more (the thrust has reached an edge, or a joint slides),
where the multiplier is zero, or at the displacement asked for. Each of these events is located by root finding.

Where no forces balance the loads any more, a joint opens at constant displacement in a motion that no forces resist.
That motion is followed until a contact closes (`jump`). What follows an event is found by `after_event`.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE
from blockstat.large_displacement.displaced.pose import displaced_assembly, free_sizes
from blockstat.large_displacement.linkage.after_event import AfterEvent
from blockstat.large_displacement.linkage.event_location import (
    first_kinematic_event,
    loss_of_equilibrium,
    reversal_of_tie,
    slack_from_reversal,
)
from blockstat.large_displacement.linkage.path import FindMechanism, PathEnd, PathEvent, PathPoint, PathState
from blockstat.large_displacement.linkage.root_finding import NoRootError
from blockstat.large_displacement.linkage.state_solver import StateSolver

#: The shortest step, relative to the largest. Chosen: a path that needs shorter steps is lost.
MIN_STEP = 1e-9
#: Pieces in a row that may be short, and the length below which a piece is short, relative to the largest step. One
#: short piece may be that of a mixture of two mechanisms. Where more follow each other, joints slide to and fro, and it
#: is no linkage that moves. Chosen.
MAX_SHORT_PIECES, SHORT_PIECE = 3, 1e-2
#: A new step aims at this part of the allowed deviation. Chosen, so that it rarely has to be shortened again.
AIMED_DEVIATION = 0.9
#: A step is shortened to this part of itself at least, and lengthened by this factor at most. Chosen: where the
#: deviation does not grow with the square of the step, as at a change of mechanism, its square root misleads.
LEAST_SHORTENING, MOST_LENGTHENING = 0.1, 10.0
#: A linkage on moving supports is at its dead centre where its fastest corner is this many times as fast as they.
#: Chosen: the place is then known to a millionth of the size.
DEAD_CENTRE = 1e3
#: Steps of one piece at most. Chosen: a path without end is broken off.
MAX_STEPS = 100_000
#: Stands in for a value of zero, relative to which a deviation is allowed.
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class LinkageFollower:
    """Follows one structure along one path."""

    solver: StateSolver
    find_mechanism: FindMechanism
    end: float  #: largest parameter [m]
    step: float  #: largest step [m]
    #: largest deviation of the value from straight lines between points, relative to the value; and the accuracy of
    #: events, relative to a step
    tolerance: float
    ends_at_zero: bool = True  #: whether the path ends where the value is zero
    least: float = TINY  #: values below this are rounding, and their deviations are not looked at

    def follow(self, state: PathState | None) -> Iterator[PathState | PathEvent | PathEnd]:
        """Yield the states on the path in order, the events between them, and at last how it ends.

        Parameters
        ----------
        state
            In which the path begins: `StateSolver.first`.

        Yields
        ------
        PathState, PathEvent or PathEnd
            In order; the end comes last.
        """
        # Several bodies that begin to move together may be no linkage: its motion then balances no forces.
        if state is None or not state.forces.admissible:
            yield PathEnd.LOST
            return
        yield state
        if self.ends_at_zero and state.point.value <= 0:  # joints that open have lost their tension
            yield PathEnd.ZERO
            return
        try:
            yield from self._pieces(state)
        except NoRootError:
            yield PathEnd.LOST

    def coincide(self, event: PathEvent, other: PathEvent) -> bool:
        """Return whether two events are at one place, to the tolerance to which a changed mechanism is looked for.

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

    def _pieces(self, state: PathState) -> Iterator[PathState | PathEvent | PathEnd]:
        after, short, changed = AfterEvent(self.solver, self.find_mechanism, self.ends_at_zero), 0, False
        while True:
            start = state.point.parameter
            event, state, beyond = yield from self._piece(state)
            if isinstance(event, PathEnd):
                yield event
                return
            short = short + 1 if state.point.parameter - start <= SHORT_PIECE * self.step else 0
            if short > MAX_SHORT_PIECES:
                yield PathEnd.LOST
                return
            lost = event == "jump"
            if lost and short and changed:  # what has begun was a mixture of mechanisms
                yield PathEnd.LOST
                return
            changed = False
            for item in after.after_loss_of_equilibrium(state, beyond) if lost else after.after_closing(state):
                yield item
                if isinstance(item, PathEnd):
                    return
                if isinstance(item, PathState):
                    state = item
                changed = changed or (isinstance(item, PathEvent) and item.kind == "change")

    def _piece(
        self, state: PathState
    ) -> Generator[PathState | PathEvent, None, tuple[str | PathEnd, PathState, PathState | None]]:
        """Yield the states of a piece; return the event at its end, the state there, and one just beyond it."""
        first, step = abs(state.point.value), self.step
        across = CORNER_TOLERANCE * float(free_sizes(self.solver.structure.assembly).max())
        for _ in range(MAX_STEPS):
            start = state.point
            allowed = self.tolerance * max(first, abs(start.value), self.least)
            target = min(start.parameter + step, self.end)
            point = self.solver.point_at(state, target)
            turn = None if point is None else reversal_of_tie(self.solver, state, point)
            leaps = turn is not None and turn[0] - start.parameter <= 2 * across
            if turn is not None:  # a step ends just before the force of the tie leaps, and the next one leads across
                target = min(turn[0] + (across if leaps else -across), self.end)
                state = slack_from_reversal(self.solver, state, turn) if leaps else state
                point = self.solver.point_at(state, target)
            deviation = np.inf if point is None else 0.0 if leaps else self._deviation(state, point)
            if point is None or deviation > allowed:
                step *= 0.5 if np.isinf(deviation) else max(self._step_factor(allowed, deviation), LEAST_SHORTENING)
                if step < self.step * MIN_STEP:
                    return PathEnd.LOST, state, None
                continue
            event, point = first_kinematic_event(self.solver, state, point, ends_at_zero=self.ends_at_zero)
            reached = self.solver.state(state.linkage, point)
            beyond = None
            if not reached.forces.solved:
                return PathEnd.LOST, state, None
            if not reached.forces.admissible:
                event = "jump"
                reached, beyond = loss_of_equilibrium(self.solver, state, reached, self.tolerance)
            if reached.point.parameter > start.parameter:
                state = reached
                if leaps and abs(state.point.value - start.value) > allowed:
                    yield PathEvent("change", start.parameter, start.value, state.point.value, (), ())
                yield state
            if event is not None:
                return event, state, beyond
            if target >= self.end:
                return PathEnd.REACHED, state, None
            if not self.ends_at_zero and self._at_dead_centre(state):
                return PathEnd.COLLAPSE, state, None
            step = min(step * self._step_factor(allowed, deviation), self.step)
        return PathEnd.LOST, state, None

    @staticmethod
    def _step_factor(allowed: float, deviation: float) -> float:
        """Step length control: the deviation grows with the square of the step."""
        aimed = AIMED_DEVIATION * allowed
        return float(np.sqrt(aimed / max(deviation, aimed / MOST_LENGTHENING**2)))

    @staticmethod
    def _at_dead_centre(state: PathState) -> bool:
        """Whether supports that the assembly pushes have drawn its linkage out straight.

        Beyond there it has no pose, and the thrust grows without bound before. With the movement d left, the fastest
        corner is faster than the supports by 1 / sqrt(d), so that the movement left is 1 / `DEAD_CENTRE`^2 of the size.
        """
        there = displaced_assembly(state.linkage.assembly, state.point.pose)
        speed = float(corner_speed(there, state.point.tangent).max())
        return state.point.value > 0 and speed > DEAD_CENTRE

    def _deviation(self, state: PathState, point: PathPoint) -> float:
        """How far the value midway between two points is from the straight line between them.

        Infinite where the linkage has no pose there. Zero where joints slide against friction: steps are not shortened
        there.
        """
        middle = self.solver.point_at(state, 0.5 * (state.point.parameter + point.parameter))
        if middle is None:
            return np.inf
        if point.linkage is not None:
            return 0.0
        return abs(middle.value - 0.5 * (state.point.value + point.value))
