"""The limit load of a train at every place of a path: influence line, envelope, and the worst place.

Every mechanism bounds the multiplier at all places from above, and every force field at the places whose loads are
sums of those that it carries from below. So a place is solved only where these bounds do not meet:

    the loads that an assembly carries are a convex set. Between two joints the load of a train is linear in its place,
    so 1/multiplier is convex there. The worst place of all is at a joint, on one of its sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.limit_load import limited
from blockstat.analysis.problem import Problem
from blockstat.analysis.reserve import limit_warning
from blockstat.analysis.thrust import standing, standing_on
from blockstat.analysis.verdict import unit_motion
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.overlap.searched import searched_joints
from blockstat.errors import InputError, check_number, known_options
from blockstat.loading.faces import selected
from blockstat.loading.ground import warn_of_spread
from blockstat.loading.on_faces import facing
from blockstat.loads import numbers, up_of
from blockstat.result import Result, Sentence, finite
from blockstat.traffic.place_brackets import FINER, PlaceBrackets
from blockstat.traffic.places import (
    checked_train,
    places_of,
    road_along,
    train_loads,
    unloaded_warnings,
    with_other_lane,
)
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

MOST_POSITIONS = 100_000


class MovingOutcome(Sentence):
    """The answers of `moving_load`; the value of each is the sentence that a user reads."""

    LIMIT = "Limit: at its worst place the train is carried up to the lower bound, and not beyond the upper one."
    UNBOUNDED = "Unbounded: any multiple of the train is carried wherever an axle stands."
    UNDECIDED = "Undecided: at a place that may be the worst, no bracket as narrow as the tolerance could be proven."


@dataclass(frozen=True, eq=False)
class MovingLoad(Result):
    """Brackets on the multiplier of a train at each place of a path."""

    outcome: MovingOutcome
    #: of the first axle along the path, ascending, shape (n,) [m]; twice where the path runs along a joint and the
    #: axles stand on the blocks to its left, and to its right
    place: Floats
    #: -1 or 1: an axle that stands on a joint loads the block before or the one after, and beyond an end of the path
    #: nothing; 1 where no axle stands on one, shape (n,)
    side: Ints
    lower: Floats  #: multiplier carried at each place, shape (n,)
    upper: Floats  #: and not beyond this, shape (n,); infinite where nothing is proven
    worst: int  #: the place with the least upper bound; where none is finite, with the least lower bound
    load: Floats  #: of the train there, shape (n_blocks, 6) [N, N m]
    mechanism: Floats  #: there, shape (n_blocks, 6), scaled so that the fastest corner moves by 1 m
    solves: int  #: places that were solved; the others follow from them
    assembly: Assembly
    warnings: tuple[str, ...] = ()

    def explain(self) -> str:
        """Return the answer in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value]
        if self.outcome is MovingOutcome.LIMIT:
            k = self.worst
            lines.append(f"{self.lower[k]:.6g} <= multiplier <= {self.upper[k]:.6g}")
            lines.append(f"Worst place of the first axle: {self.place[k]:.4g} m along the path.")
        elif self.outcome is MovingOutcome.UNDECIDED:
            k, least = int(np.argmin(self.lower)), float(self.upper.min())
            lines.append(f"{self.lower[k]:.6g} <= multiplier" + (f" <= {least:.6g}" if np.isfinite(least) else ""))
            lines.append(f"Least is proven with the first axle {self.place[k]:.4g} m along the path.")
        lines.append(f"{len(self.place)} places, {self.solves} solved.")
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; infinite bounds are None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "place": self.place.tolist(),
            "side": self.side.tolist(),
            "lower": [finite(value) for value in self.lower],
            "upper": [finite(value) for value in self.upper],
            "worst": self.worst,
            "solves": self.solves,
            "warnings": list(self.warnings),
        }


@known_options
def moving_load(
    assembly: Assembly,
    axles: Sequence[Sequence[float]],
    path: Sequence[Sequence[float]],
    *,
    positions: int = 100,
    joints: bool = True,
    only_worst: bool = False,
    spread: float | None = None,
    footprint: Sequence[float] = (0.0, 0.0),
    group: str | None = None,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
    tolerance: float = 1e-3,
) -> MovingLoad:
    """Find the limit load of a train of axles at every place of a path over the highest free faces.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand without the train.
    axles : sequence of (distance, force)
        Distance behind the first axle [m] and force downwards [N] of each. Of a train that is not symmetric this is one
        of its two ways: reverse the path for the other.
    path : sequence of points, shape (n, 3)
        Corners of the path [m]; without a spread their heights do not count, and lengths along it are in plan.
    positions : int, optional
        Places of the first axle, even from where it enters the path to where the last axle leaves it.
        A place where no axle stands on a block counts as carried, and how many there are is a warning.
    joints : bool, optional
        Further places where an axle passes from a block to the next, or enters or leaves the path, on both sides. The
        worst of all places is among them. Without a spread only. With joints=False these places are left out, and an
        even place where an axle stands on a joint is there twice, once for each side.
    only_worst : bool, optional
        Ask for the envelope alone: the bracket of the worst place is as narrow as `tolerance` says, and every other
        place is proven to carry as much. Elsewhere the upper bounds are those of the mechanisms found, and may be far
        above the multiplier there; the influence line is not computed.
    spread, footprint : optional
        As in `blockstat.dispersed_load`: the axles stand on fill, whose surface is the path. A footprint needs a
        spread. An axle with no face below it presses on nothing.
    group : str, optional
        The group that carries the train, by default all free blocks.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`; `loads` stay as they are.
    tolerance : float, optional
        Width of the brackets relative to their upper ends, from 1e-9 to 0.1.

    Returns
    -------
    MovingLoad
        A proven bracket at each place: the influence line of the multiplier, and its least value.

    Raises
    ------
    InputError
        When the assembly does not stand, for a bad train or path, or for an option that does not exist.

    Warns
    -----
    InputWarning
        With a spread that may be an angle.

    Notes
    -----
    A mechanism bounds the multiplier only where it drives no blocks into each other at contacts that are in no program,
    as in `blockstat.limit_load`. Places where no other is found are undecided.

    Examples
    --------
    A wheel on an overhang of a slab: the slab tips about the edge of its support.

    >>> from blockstat import Assembly, box, moving_load
    >>> blocks = [box((0, 0, -1), (2, 1, 0), name="pier"), box((0, 0, 0), (3, 1, 0.5), name="slab")]
    >>> bridge = Assembly.from_blocks(blocks, supports=["pier"], density=1000.0)
    >>> found = moving_load(bridge, [(0, 1000.0)], [(0, 0.5, 0.5), (3, 0.5, 0.5)], positions=7)
    >>> found.place[found.worst].item(), round(found.upper[found.worst].item(), 2)
    (3.0, 7.36)
    """
    train = checked_train(axles)
    if not (isinstance(positions, int) and 1 <= positions <= MOST_POSITIONS):
        raise InputError(f"positions is {positions!r}; it must be a whole number from 1 to {MOST_POSITIONS}")
    check_number("tolerance", tolerance, least=1e-9, most=0.1)
    if spread is None and np.any(footprint):
        raise InputError(f"footprint is {footprint!r} without a spread; axles without fill stand on points")
    for name, value in (("spread", 0.0 if spread is None else spread), ("footprint", footprint)):
        if not (np.isfinite(numbers(value)) & (numbers(value) >= 0)).all():
            raise InputError(f"{name} is {value!r}; it must be at least 0")
    warn_of_spread("spread", spread)
    told: tuple[str, ...] = ()
    if interfaces is None:
        interfaces, _, told = searched_joints(assembly, gap)
    options = {"friction": friction, "gravity": gravity, "loads": loads, "gap": gap}
    problem, inside = standing(assembly, solver=solver, interfaces=interfaces, **options)
    some = "only the places listed were looked at; between them the train may be carried less"
    left_out = (some,) if spread is not None or not joints else ()
    problem = replace(problem, warnings=(*told, *problem.warnings, *left_out))
    faces = facing(problem.assembly, selected(assembly, None, group), up_of(problem.assembly), interfaces)
    road = road_along(problem.assembly, path, faces, spread=spread)
    place, side, joint = places_of(road, train, positions, joints, spread=spread)
    which = np.where(joint, side, 0)
    wrenches = train_loads(road, train, place, which, spread=spread, footprint=footprint)
    if spread is None:
        place, side, wrenches = with_other_lane(road, train, place, side, joint, wrenches)
    problem = replace(problem, warnings=(*problem.warnings, *unloaded_warnings(road, train, wrenches)))
    how: dict[str, Any] = {"solver": solver, "tolerance": FINER * tolerance, "optimum": False, "reserve": False}
    stand = partial(standing, problem.assembly, **options | {"friction": None, "gravity": None}, solver=solver)

    def search_on(problem: Problem, inside: Floats) -> PlaceBrackets:
        judge = partial(limited, problem, loads=loads, **how)
        return PlaceBrackets(problem, inside, wrenches, place, solver, tolerance, judge, stand)

    def carried_by(joints: Interfaces) -> float:
        stood = standing_on(problem, joints, loads, solver)
        if stood is None:
            return -np.inf
        fewer = search_on(*stood)
        fewer.run_worst()
        return fewer.least

    search = search_on(problem, inside)
    if only_worst:
        search.run_worst()
    else:
        search.run()
    thin = limit_warning(problem, search.carrying, search.least, 2 * tolerance, carried_by)
    return _answer(search, side, thin)


def _answer(found: PlaceBrackets, side: Ints, thin: list[str]) -> MovingLoad:
    """What was found, and what is said of doubtful joints."""
    least = float(found.upper.min())
    bounded = np.isfinite(least)
    worst = int(np.argmin(found.upper if bounded else found.lower))
    twist = found.twists[found.by[worst]] if bounded else np.zeros_like(found.program.load)
    return MovingLoad(
        outcome=_outcome(found, least),
        place=found.place,
        side=side,
        lower=np.minimum(found.lower, found.upper),
        upper=found.upper,
        worst=worst,
        load=found.wrenches[worst],
        mechanism=unit_motion(found.problem.assembly, found.problem.to_blocks(twist)),
        solves=found.solves,
        assembly=found.problem.assembly,
        warnings=tuple(dict.fromkeys([*found.problem.warnings, *found.told, *thin])),
    )


def _outcome(found: PlaceBrackets, least: float) -> MovingOutcome:
    """What is proven of the worst place, of which the least upper bound is known."""
    if np.isinf(found.lower).all():
        return MovingOutcome.UNBOUNDED
    rows = [k for k in found.undecided if found.is_open(k)]
    may_be_worst = np.isinf(least) or (found.lower[rows] < (1.0 - found.tolerance) * least).any()
    return MovingOutcome.UNDECIDED if may_be_worst else MovingOutcome.LIMIT
