"""A whole path: on the linkage as far as it is one, by finite steps from there on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.contact.tolerance import ROUNDING
from blockstat.errors import InputError, check_count, check_number, check_positive
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, free_sizes
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.finite_steps.fall import FallenBlocks
from blockstat.large_displacement.finite_steps.follower import StepFollower
from blockstat.large_displacement.finite_steps.implicit_follower import ImplicitFollower
from blockstat.large_displacement.finite_steps.trial_state import per_unit_parameter
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathEnd, PathEvent, PathFault, PathPoint, PathState
from blockstat.large_displacement.linkage.state_solver import A_LITTLE_WAY
from blockstat.solve.dispatch import STRUCTURED
from blockstat.typing import Floats

#: The longest step where the value is not a straight line. Relative to the median size of the free blocks. Chosen: the
#: gaps that a step leaves are of second order in it, hence about 0.03^2, a thousandth of a block.
LONGEST_STEP = 0.03
#: Structures with more blocks than this are followed by implicit steps. Chosen: from there on their mechanisms are
#: seldom of a few bodies.
IMPLICIT_ABOVE = STRUCTURED // 10
#: The longest implicit step, relative to the median size of the free blocks. Chosen: a facade as wide as it is high
#: then takes about as many steps as are asked for.
LONGEST_IMPLICIT_STEP = 0.15
#: A collapse within this part of the first step is that of a linkage that is not the mechanism's. Chosen: jumps follow
#: each other there at a distance of rounding.
AT_REST = 1e-3
#: Joints are said to miss planes from this on. Relative to the largest free block. Chosen: the default tolerance of a
#: path.
TOLD_FLAW = 1e-4
#: The largest tolerance of a path. Chosen: a curve that is wrong by more than a tenth is none.
LARGEST_TOLERANCE = 0.1
#: What a path consists of.
PathItem = PathState | PathEvent | FallenBlocks | PathFault | PathEnd


def follow_path(
    follower: LinkageFollower, linkage: Linkage, pose: Pose, guess: Floats, first: PathState | None, *, change: float
) -> Iterator[PathItem]:
    """Yield the path of a linkage and, where the linkage is lost, the path by finite steps from there on.

    Parameters
    ----------
    follower
        Follows the linkage.
    linkage
        The mechanism that begins.
    pose
        Where it begins.
    guess
        Its motion, of any magnitude, shape (n_blocks, 6).
    first
        What `StateSolver.first` returns for these.
    change
        As in `StepFollower`.

    Yields
    ------
    PathState, PathEvent, FallenBlocks, PathFault or PathEnd
        In order; the end comes last.

    Raises
    ------
    InputError
        Where there is not even a first state.
    """
    last: PathState | None = None
    item: PathItem | None = None
    for path in _beginnings(follower, linkage, first):
        waiting: list[PathItem] | None = []
        for item in _until_a_fault(path, last):
            if item is PathEnd.COLLAPSE and last is not None and last.point.parameter <= AT_REST * follower.step:
                item = PathEnd.LOST
            if item is PathEnd.LOST:
                break
            if isinstance(item, PathState):
                last = item
            if waiting is None:
                yield item
                continue
            # A linkage that is lost within its first step is not that of the mechanism, so its states do not count.
            waiting.append(item)
            if isinstance(item, PathEnd) or (last is not None and last.point.parameter >= follower.step):
                yield from waiting
                waiting = None
        if not waiting:
            break
        last = None
    if item is PathEnd.LOST:
        start = _at_rest(follower, linkage, pose, guess) if last is None else last.point
        steps = _step_follower(follower, linkage, start, change)
        yield from _until_a_fault(steps.follow(linkage if last is None else last.linkage, start), last)


def _until_a_fault(path: Iterator[PathItem], last: PathState | None) -> Iterator[PathItem]:
    """A path that is lost at a pose whose joints are refused; what leads there is kept, if it is more than nothing.

    What a user has given was checked at rest.
    """
    try:
        for item in path:
            last = item if isinstance(item, PathState) else last
            yield item
    except InputError as error:
        if last is None:
            raise
        yield PathFault(last.point.parameter, str(error))
        yield PathEnd.LOST


def _beginnings(
    follower: LinkageFollower, linkage: Linkage, first: PathState | None
) -> Iterator[Iterator[PathState | PathEvent | PathEnd]]:
    """The path of a linkage, and that on which it begins a little way from rest.

    A joint may slip by the square of the motion only, to let a block turn with another one beside it. At rest it does
    not slip and counts as sticking, and the linkage has no pose beyond. A little way on it slips.
    """
    yield follower.follow(first)
    if first is None or not linkage.slides_with_friction:
        return
    distance = min(A_LITTLE_WAY * float(free_sizes(linkage.assembly).max()), follower.step)
    point = follower.solver.point_at(replace(first, linkage=linkage), distance)
    later = None if point is None else follower.solver.state(linkage, point)
    if later is not None and later.forces.admissible:
        yield chain([first], follower.follow(later))


def _at_rest(follower: LinkageFollower, linkage: Linkage, pose: Pose, guess: Floats) -> PathPoint:
    """Where a path begins that is no linkage from rest on."""
    motion = per_unit_parameter(linkage, pose, guess)
    return PathPoint(0.0, pose, motion, follower.solver.value(pose, 0.0, guess, linkage.yielding))


def _step_follower(
    follower: LinkageFollower, linkage: Linkage, start: PathPoint, change: float
) -> StepFollower | ImplicitFollower:
    """The follower by finite steps whose longest step moves the parameter by a step of the linkage's follower."""
    there = displaced_assembly(linkage.assembly, start.pose)
    speed = max(float(corner_speed(there, start.tangent).max()), float(linkage.control is None))
    longest = speed * follower.step
    structure, size = follower.solver.structure, float(np.median(free_sizes(linkage.assembly)))
    step = min(longest, LONGEST_STEP * size)
    if structure.live is not None and not linkage.associated and structure.assembly.n_blocks > IMPLICIT_ABOVE:
        step = min(longest, LONGEST_IMPLICIT_STEP * size)
        return ImplicitFollower(structure, follower.end, step, change, follower.tolerance)
    return StepFollower(structure, follower.end, step, longest, change, follower.tolerance)


def path_options(*, steps: Any, tolerance: Any, displacement: Any) -> tuple[float, float | None]:
    """Return options of a path as numbers.

    Parameters
    ----------
    steps, tolerance, displacement
        As in `blockstat.capacity`.

    Returns
    -------
    tolerance : float
        The tolerance.
    displacement : float or None
        Where to stop [m].

    Raises
    ------
    InputError
        That names the option.
    """
    check_count("steps", steps)
    check_positive("tolerance", tolerance)
    check_number("tolerance", tolerance, most=LARGEST_TOLERANCE)
    if displacement is not None:
        check_positive("displacement", displacement)
    return float(tolerance), None if displacement is None else float(displacement)


def warnings_on_accuracy(states: Sequence[PathState], structure: Structure) -> list[str]:
    """Return what a reader must know of the accuracy of states: finite steps, and joints that miss planes.

    Parameters
    ----------
    states
        Of a path.
    structure
        The blocks and joints at rest.

    Returns
    -------
    list of str
        Empty where a linkage was followed whose joints are plane.
    """
    size = float(free_sizes(structure.assembly).max())
    stepped = [(state.point.parameter, state.residual_gap) for state in states if state.residual_gap is not None]
    if not stepped:
        off = structure.outlines.flaw.distance
        if off <= TOLD_FLAW * size:
            return []
        return [
            f"faces of joints miss planes with parallel edges by up to {1e3 * off:.2g} mm, and are followed as such "
            "planes: the end of the path is as uncertain as they are"
        ]
    start, largest = min(stepped)[0], max(gap for _, gap in stepped)
    text = f"the mechanism is no linkage from {start:.4g} m on and is followed by finite steps"
    if largest > CORNER_TOLERANCE * size:
        text += f". Contacts that are open by up to {1e3 * largest:.2g} mm count as closed"
    told = [f"{text}. A run with so many steps that its path has more points shows the error"]
    drawn = structure.outlines.drawn
    if drawn.tilt > ROUNDING:
        told.append(
            f"faces of joints miss planes by up to {1e3 * drawn.distance:.2g} mm. Finite steps then follow each corner "
            "as it is drawn: the end of the path may be far off, on either side, whatever the number of steps. "
            "`repair` brings the faces of neighbours into common planes; then edges that are not parallel are left"
        )
    return told
