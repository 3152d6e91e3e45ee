"""Location of events on the path of a linkage: a closing contact, a multiplier of zero, a loss of equilibrium."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from blockstat.large_displacement.displaced.contact_pairs import ZERO_GAP
from blockstat.large_displacement.displaced.pose import displaced_assembly, free_sizes
from blockstat.large_displacement.displaced.structure import slackening
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathEnd, PathPoint, PathState
from blockstat.large_displacement.linkage.root_finding import NoRootError, root_of
from blockstat.large_displacement.linkage.state_solver import StateSolver
from blockstat.typing import Floats

#: Accuracy of the parameter at which a contact closes or the multiplier is zero. Relative to the parameter, or absolute
#: below 1 m: near rounding [m].
ROOT_ACCURACY = 1e-14
#: A contact that is closed after this part of a step closes at the beginning of the step. Chosen: too small a part for
#: the gap to have opened and closed in it.
AT_ONCE = 1e-6
#: Where a multiplier changes its sign it is zero if it is below this. Relative to its change in the step. Chosen: far
#: above what `ROOT_ACCURACY` leaves. Where it is more, the multiplier leaps: the contacts of a joint that slides change
#: there, or the linkage has no pose beyond.
CONTINUOUS = 1e-6
#: How well a loss of equilibrium is located. Relative to the path's tolerance times the step. Chosen: the forces just
#: before it and just after it show what changes.
LIMIT_ACCURACY = 1e-2
#: Adhesion that stands for an infinite one in root finding [mean block weights]. Chosen: far above any finite one.
MAX_ADHESION = 1e3


def open_gaps(linkage: Linkage, point: PathPoint) -> Floats:
    """Return the gaps of the open contacts at a point, and the slacks of the slack ties.

    Parameters
    ----------
    linkage, point
        A point of the linkage.

    Returns
    -------
    Floats
        Shape (n_contacts + n_ties,) [m]; infinite for closed contacts and other ties.
    """
    found: Floats = np.where(linkage.open, linkage.gaps(point.pose, point.parameter), np.inf)
    return found


def first_kinematic_event(
    solver: StateSolver, state: PathState, point: PathPoint, *, ends_at_zero: bool
) -> tuple[str | PathEnd | None, PathPoint]:
    """Return the first event in a step that needs no forces: a contact that closes, or a multiplier of zero.

    A tie that is taut again counts as a contact that closes.

    Parameters
    ----------
    solver
        Finds points of the linkage.
    state
        Where the step begins.
    point
        Where it leads.
    ends_at_zero
        Whether the path ends where the multiplier is zero.

    Returns
    -------
    event : str, PathEnd or None
        "closing", `PathEnd.ZERO`, `PathEnd.LOST` where the multiplier leaps below zero, or None for no event.
    point : PathPoint
        At the event; the given one where there is none.
    """
    event: str | PathEnd | None = None
    start, found = state.point.parameter, point
    tolerance = ZERO_GAP * float(free_sizes(solver.structure.assembly).max())
    for contact in np.flatnonzero(open_gaps(state.linkage, point) < -tolerance):
        gap = _gap_of(solver, state, int(contact), tolerance)
        if gap(found.parameter) >= -tolerance:
            continue
        low = start + AT_ONCE * (found.parameter - start)
        if gap(low) <= 0:
            return "closing", state.point
        at = solver.point_at(state, root_of(gap, low, found.parameter, _accuracy(found)))
        if at is not None:
            event, found = "closing", at
    if ends_at_zero and found.value < 0:
        if state.point.value <= 0:
            return PathEnd.ZERO, state.point
        accuracy = _accuracy(found)
        root = root_of(_value_of(solver, state), start, found.parameter, accuracy)
        at = solver.point_at(state, root)
        if at is not None and abs(at.value) <= CONTINUOUS * (state.point.value - found.value):
            return PathEnd.ZERO, replace(at, value=0.0)
        before = solver.point_at(state, root - AT_ONCE * (root - start))
        if before is None or before.value <= 0:
            return PathEnd.LOST, state.point
        return PathEnd.LOST, before
    return event, found


def reversal_of_tie(solver: StateSolver, state: PathState, point: PathPoint) -> tuple[float, int] | None:
    """Return where a tie that yields begins to shorten in a step.

    Parameters
    ----------
    solver, state, point
        As in `first_kinematic_event`.

    Returns
    -------
    (float, int) or None
        The first such parameter [m], at which the force of the tie leaps, and the number of the tie; None where there
        is none.
    """
    own = state.linkage.yielding
    if not len(own):
        return None
    structure, start = solver.structure, state.point.parameter

    def rates(at: PathPoint) -> Floats:
        there = displaced_assembly(structure.assembly, structure.with_supports(at.pose, at.parameter))
        return slackening(there, at.tangent + structure.support_motion)[own]

    def rate_at(parameter: float, tie: int) -> float:
        at = state.point if parameter == start else solver.point_at(state, parameter)
        if at is None:
            raise NoRootError
        return float(rates(at)[tie])

    turned = np.flatnonzero((rates(state.point) < 0) & (rates(point) > 0)).tolist()
    roots = [root_of(lambda s, k=k: rate_at(s, k), start, point.parameter, _accuracy(point)) for k in turned]
    return min(zip(roots, own[turned].tolist(), strict=True), default=None)


def slack_from_reversal(solver: StateSolver, state: PathState, turn: tuple[float, int]) -> PathState:
    """Return a state in which a tie is slack that turns back: it keeps the length that it has yielded to.

    Parameters
    ----------
    solver, state
        As in `first_kinematic_event`; the state is just before the place where the tie turns back.
    turn
        As `reversal_of_tie` returns it.

    Returns
    -------
    PathState
        With the length of the tie there.

    Raises
    ------
    NoRootError
        When the linkage has no pose there.
    """
    at = solver.point_at(state, turn[0])
    if at is None:
        raise NoRootError
    linkage = replace(state.linkage, slack=np.union1d(state.linkage.slack, turn[1]).astype(np.int64))
    pose = replace(state.point.pose, yielded=at.pose.yielded)
    return replace(state, linkage=linkage, point=replace(state.point, pose=pose))


def _accuracy(point: PathPoint) -> float:
    return ROOT_ACCURACY * max(1.0, abs(point.parameter))


def _gap_of(solver: StateSolver, state: PathState, contact: int, tolerance: float) -> Callable[[float], float]:
    """The gap of a contact as a function of the parameter; just overlapping where there is no pose."""

    def gap(parameter: float) -> float:
        at = solver.point_at(state, parameter)
        return -tolerance if at is None else float(open_gaps(state.linkage, at)[contact])

    return gap


def _value_of(solver: StateSolver, state: PathState) -> Callable[[float], float]:
    """The multiplier as a function of the parameter; negative where there is no pose."""

    def value(parameter: float) -> float:
        at = solver.point_at(state, parameter)
        return -1.0 if at is None else at.value

    return value


def loss_of_equilibrium(
    solver: StateSolver, state: PathState, beyond: PathState, tolerance: float
) -> tuple[PathState, PathState]:
    """Locate where forces in equilibrium cease to exist.

    Parameters
    ----------
    solver
        Finds states of the linkage.
    state
        Where a step begins.
    beyond
        Where it leads; forces in equilibrium do not exist there.
    tolerance
        Of the path.

    Returns
    -------
    last, beyond : PathState
        The last state in equilibrium, and one just beyond it.

    Raises
    ------
    NoRootError
        When the linkage has no pose in between.
    """
    start, end = state.point.parameter, beyond.point.parameter
    width = tolerance * LIMIT_ACCURACY * (end - start)
    if not state.forces.admissible:
        near = solver.state_at(state, start + width)
        return state, beyond if near is None else near
    seen = {end: beyond, start: state}
    tolerance = max(state.forces.tolerance, beyond.forces.tolerance)
    level = 0.0 if state.forces.adhesion < -tolerance else tolerance

    def excess(parameter: float) -> float:
        if parameter not in seen:
            at = solver.state_at(state, parameter)
            if at is None:
                raise NoRootError
            seen[parameter] = at
        return min(seen[parameter].forces.adhesion, MAX_ADHESION) - level

    root = root_of(excess, start, end, width)
    for parameter in (root - width, root + width):
        if start < parameter < end:
            excess(parameter)
    # Next to the root a solver's accuracy may be more than the adhesion, so that its sign is not in order there.
    order = sorted(seen)
    last = max(k for k, parameter in enumerate(order) if excess(parameter) <= 0)
    return seen[order[last]], seen[order[last + 1]] if last + 1 < len(order) else beyond
