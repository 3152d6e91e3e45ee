"""The limit load of a train at every place of a path: influence line, envelope, and the worst place.

Every mechanism bounds the multiplier at all places from above, and every force field at the places whose loads are
sums of those that it carries from below. So a place is solved only where these bounds do not meet:

    the loads that an assembly carries are a convex set. Between two joints the load of a train is linear in its place,
    so 1/multiplier is convex there. The worst place of all is at a joint, on one of its sides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, bracket, limit_load
from blockstat.analysis.problem import Problem, crushes
from blockstat.analysis.rims import ROUNDS, overlap_warnings, pairs_driven, rim_warnings
from blockstat.analysis.thrust import shared_joints, standing, with_overlaps
from blockstat.analysis.verdict import unit_motion
from blockstat.certificate import check as certificate
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.unresolved import unresolved_contacts
from blockstat.errors import InputError, known_options
from blockstat.loading.faces import selected, up_of
from blockstat.loading.on_faces import facing
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.result import Result, Sentence, finite
from blockstat.solve.penalty import solve_penalty
from blockstat.solve.phase_one import find_forces
from blockstat.traffic.places import checked_train, places_of, road_along, train_loads
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

MOST_POSITIONS = 100_000
#: Where contacts without a unique normal are asked too, the ends of a bracket are those of two problems. Each is found
#: to this share of the tolerance, so that both together keep it.
FINER = 0.25


class MovingOutcome(Sentence):
    """The answers of `moving_load`; the value of each is the sentence that a user reads."""

    LIMIT = "Limit: at its worst place the train is carried up to the lower bound, and not beyond the upper one."
    UNBOUNDED = "Unbounded: any multiple of the train is carried at every place."
    UNDECIDED = "Undecided: at a place that may be the worst, no bracket as narrow as the tolerance could be proven."


@dataclass(frozen=True, eq=False)
class MovingLoad(Result):
    """Brackets on the multiplier of a train at each place of a path."""

    outcome: MovingOutcome
    place: Floats  #: of the first axle along the path, ascending, shape (n,) [m]
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
        Distance behind the first axle [m] and force downwards [N] of each.
    path : sequence of points, shape (n, 3)
        Corners of the path [m]; without a spread their heights do not count, and lengths along it are in plan.
    positions : int, optional
        Places of the first axle, even from where it enters the path to where the last axle leaves it.
    joints : bool, optional
        Further places where an axle passes from a block to the next, or enters or leaves the path, on both sides. The
        worst of all places is among them. Without a spread only.
    only_worst : bool, optional
        Ask for the envelope alone: the bracket of the worst place is as narrow as `tolerance` says, and every other
        place is proven to carry as much. Elsewhere the upper bounds are those of the mechanisms found, and may be far
        above the multiplier there; the influence line is not computed.
    spread, footprint : optional
        As in `blockstat.dispersed_load`: the axles stand on fill, whose surface is the path.
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
    if not 1e-9 <= tolerance <= 0.1:
        raise InputError(f"tolerance is {tolerance!r}; it must be from 1e-9 to 0.1")
    shared, told = shared_joints(assembly, gap, interfaces)
    options = {"friction": friction, "gravity": gravity, "loads": loads, "gap": gap}
    problem, inside = standing(assembly, solver=solver, interfaces=shared, **options)
    problem = replace(problem, warnings=(*told, *problem.warnings))
    faces = facing(problem.assembly, selected(assembly, None, group), up_of(problem.assembly), shared)
    road = road_along(problem.assembly, path, faces, spread=spread)
    place, side, joint = places_of(road, train, positions, joints and spread is None)
    which = np.where(joint, side, 0)
    wrenches = train_loads(road, train, place, which, spread=spread, footprint=footprint)
    given: dict[str, Any] = {"loads": loads, "gap": gap, "interfaces": shared}
    judge = partial(limit_load, problem.assembly, **given, solver=solver, tolerance=FINER * tolerance)
    stand = partial(standing, problem.assembly, **options | {"friction": None, "gravity": None}, solver=solver)
    search = _Search(problem, inside, wrenches, place, solver, tolerance, judge, stand)
    if only_worst:
        search.run_worst()
    else:
        search.run()
    return search.result(side)


@dataclass
class _Search:
    """Brackets at all places, narrowed by what each solve proves."""

    problem: Problem
    inside: Floats  #: forces with slack under the dead load
    wrenches: Floats
    place: Floats
    solver: str
    tolerance: float
    judge: Callable[[Floats], LimitLoad]  #: what `limit_load` makes of a load
    #: the problem with other joints under the dead load, and forces with slack
    stand: Callable[..., tuple[Problem, Floats]]
    solves: int = 0
    fields: dict[int, Floats] = field(default_factory=dict)  #: forces at the lower bounds of places
    unbounded: set[int] = field(default_factory=set)  #: places where any multiple is carried
    undecided: set[int] = field(default_factory=set)  #: places whose own bracket is not proven
    told: list[str] = field(default_factory=list)  #: why
    twists: list[Floats] = field(default_factory=list)
    #: pairs of blocks whose contacts without a unique normal some mechanism needs, shape (n, 2)
    held: Ints = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
    beside: tuple[Problem, Floats] | None = None  #: the problem with these contacts as joints, and forces with slack

    def __post_init__(self) -> None:
        n, joints = len(self.wrenches), self.problem.interfaces
        seen = cache(partial(unresolved_contacts, self.problem.assembly, joints, gap=self.problem.gap))
        self.problem = replace(self.problem, unresolved=seen)
        self.loads = np.stack([self.problem.scaled(load) for load in self.wrenches])
        self.lower, self.upper = np.zeros(n), np.full(n, np.inf)
        self.by = np.full(n, -1)  #: the mechanism of the upper bound
        none = ~self.loads.any(axis=1)
        self.lower[none] = np.inf
        self.program: PenaltyProgram = self.problem.program  # type: ignore[assignment]

    def run(self) -> None:
        """Solve where the bounds do not meet, coarse steps first."""
        # While the axles stay on their blocks the load is linear in its place, and what is known at the first and the
        # last of such places bounds those between them.
        loaded = self.wrenches.any(axis=2)
        passes = (loaded[1:] != loaded[:-1]).any(axis=1)
        outer = np.append(True, passes) | np.append(passes, True)
        rows = (np.flatnonzero(outer), np.flatnonzero(~outer))
        for k in (int(own[i]) for own in rows for i in _coarse_first(len(own))):
            if self._open(k):
                self._from_neighbours(k)
            if self._open(k) and not self._carried(k):
                self._solve(k)

    def run_worst(self) -> None:
        """Solve the place with the least upper bound, until all others are proven to carry as much."""
        left = np.ones(len(self.place), dtype=bool)
        while True:
            least = float(self.upper.min())
            goal = (1.0 - self.tolerance) * least if np.isfinite(least) else np.inf
            short = np.flatnonzero((self.lower < goal) & left)
            if not len(short):
                return
            # Without a mechanism yet, the place in the middle; a train there is on the path for certain.
            k = int(short[np.argmin(self.upper[short])] if np.isfinite(goal) else short[len(short) // 2])
            if not np.isfinite(goal) or not self._bears(k, goal):
                self._solve(k)
                left[k] = False

    def _bears(self, k: int, goal: float) -> bool:
        """Whether forces are found that carry a multiplier at a place; finding none proves nothing."""
        guess, nothing = self._borrowed(k, goal), np.zeros_like(self.program.load)
        at = replace(self.program, load=self.program.load + goal * self.loads[k])
        conic = conic_program(at, -at.load)
        found = find_forces(conic, conic.multipliers(guess), stands=True).found if conic.has_structure else None
        if found is None:
            force = solve_penalty(at, solver=self.solver, motions=self.problem.motions, score=False, guess=guess).force
        else:
            force = certificate.balance(at, conic.forces(found))
        if not certificate.check(at, force, nothing).proves_stable:
            return False
        self.lower[k], self.fields[k] = goal, force
        return True

    def _borrowed(self, k: int, goal: float) -> Floats:
        """The forces of the nearest place with some, mixed with those under the dead load to carry a multiplier."""
        if not self.fields:
            return self.inside
        near = min(self.fields, key=lambda other: abs(self.place[other] - self.place[k]))
        share = min(goal / self.lower[near], 1.0) if self.lower[near] > 0 else 0.0
        return share * self.fields[near] + (1.0 - share) * self.inside

    def _open(self, k: int) -> bool:
        return not (np.isinf(self.lower[k]) or _close(self.lower[k], self.upper[k], self.tolerance))

    def _solve(self, k: int) -> None:
        self.solves += 1
        found = bracket(self.problem, self.inside, self.wrenches[k], self.solver, self.tolerance)
        outcome, lower, upper, force, twist, _ = found
        if outcome is LoadOutcome.UNBOUNDED:
            self._carries_all(k)
            return
        self.lower[k] = max(self.lower[k], lower)
        self.fields[k] = force
        motion = unit_motion(self.problem.assembly, self.problem.to_blocks(twist))
        if outcome is not LoadOutcome.LIMIT:
            self._judge(k)
        elif (told := self._hidden(motion)) is not None:
            self.undecided.add(k)
            self.told += told
        elif len(driven := pairs_driven(self.problem, motion)):
            self._hold(k, upper, rim_warnings(self.problem, motion), driven)
        else:
            self._note(twist, upper, k)

    def _hidden(self, motion: Floats) -> list[str] | None:
        """What a mechanism drives blocks into that no program can hold; None for nothing."""
        self.problem = with_overlaps(self.problem)
        told = overlap_warnings(self.problem, motion)
        return told if told or crushes(self.problem, motion) else None

    def _hold(self, k: int, own: float, told: list[str], driven: Ints) -> None:
        """Bound a place by a mechanism that no contacts without a unique normal resist, whatever these carry.

        own : the upper bound without them
        told : what to say where they may carry more
        driven : pairs that the mechanism of this bound drives into each other at such contacts
        """
        problem, load, finer = self.problem, self.wrenches[k], FINER * self.tolerance
        for _ in range(ROUNDS):
            if len(driven := _others(driven, self.held)) or self.beside is None:
                self.held = np.concatenate([self.held, driven])
                more = problem.unresolved().among(self.held, problem.assembly.n_blocks)
                self.beside = self.stand(interfaces=more.beside(problem.interfaces))
            outcome, _, upper, _, twist, _ = bracket(*self.beside, load, self.solver, finer)
            motion = unit_motion(problem.assembly, self.beside[0].to_blocks(twist))
            if outcome is not LoadOutcome.LIMIT or self._hidden(motion) is not None:
                break
            if not len(driven := _others(pairs_driven(problem, motion), self.held)):
                self._note(twist, upper, k)
                if self._open(k) and _close(own, upper, self.tolerance):  # the ends are those of two problems
                    _, lower, _, force, _, _ = bracket(problem, self.inside, load, self.solver, finer)
                    if lower > self.lower[k]:
                        self.lower[k], self.fields[k] = lower, force
                if self._open(k):
                    self.undecided.add(k)
                    self.told += told
                return
        self._judge(k)

    def _judge(self, k: int) -> None:
        """Bound a place as `limit_load` does, which asks contacts without a unique normal too."""
        found = self.judge(self.wrenches[k])
        if found.outcome is LoadOutcome.UNBOUNDED:
            self._carries_all(k)
            return
        self.lower[k] = max(self.lower[k], found.lower)
        units = np.repeat([1.0, self.program.length_unit], 3)
        twist = (found.mechanism[self.problem.eq.blocks] * units).reshape(-1)
        if np.isfinite(found.upper) and self.loads[k] @ twist > 0:
            self._note(twist, found.upper, k)
        if found.outcome is not LoadOutcome.LIMIT and self._open(k):
            self.undecided.add(k)
            self.told += found.warnings

    def _carries_all(self, k: int) -> None:
        self.lower[k] = np.inf
        self.unbounded.add(k)

    def _note(self, twist: Floats, upper: float, k: int) -> None:
        """Bound all places from above by a mechanism that bounds one of them."""
        work = self.loads @ (twist / float(self.loads[k] @ twist))
        with np.errstate(divide="ignore"):
            bound = np.where(work > 0, upper / np.where(work > 0, work, 1.0), np.inf)
        better = bound < self.upper
        self.upper[better], self.by[better] = bound[better], len(self.twists)
        self.twists.append(twist)

    def _from_neighbours(self, k: int) -> None:
        """Bound a place from below by the force fields of solved places next to it, whose loads add up to its own."""
        if (pair := self._neighbours(k)) is None:
            return
        a, b, share = pair
        mixed = (1 - share) * self.loads[a] + share * self.loads[b]
        if np.abs(mixed - self.loads[k]).max() <= 1e-9 * np.abs(self.loads[k]).max():
            with np.errstate(divide="ignore"):
                self.lower[k] = max(self.lower[k], 1.0 / ((1 - share) / self.lower[a] + share / self.lower[b]))
            if np.isinf(self.lower[k]):
                self.unbounded.add(k)

    def _neighbours(self, k: int) -> tuple[int, int, float] | None:
        """The solved places before and after, and how far from the first to the second a place is."""
        solved = np.array(sorted(self.unbounded | self.fields.keys()), dtype=np.int64)
        before, after = solved[solved < k], solved[solved > k]
        if not len(before) or not len(after):
            return None
        a, b = int(before[-1]), int(after[0])
        length = self.place[b] - self.place[a]
        return a, b, float((self.place[k] - self.place[a]) / length) if length > 0 else 0.5

    def _carried(self, k: int) -> bool:
        """Whether forces like those of its neighbours carry almost the upper bound of a place."""
        pair = self._neighbours(k)
        if pair is None or not np.isfinite(self.upper[k]) or not set(pair[:2]) <= self.fields.keys():
            return False
        a, b, share = pair
        value = (1 - 0.9 * self.tolerance) * self.upper[k]
        at = replace(self.program, load=self.program.load + value * self.loads[k])
        mixed = (1 - share) * self.fields[a] + share * self.fields[b]
        guess = (1 - 0.5 * self.tolerance) * mixed + 0.5 * self.tolerance * self.inside
        nothing = np.zeros_like(self.program.load)
        force = certificate.settle(at, guess)
        if not certificate.check(at, force, nothing).proves_stable:
            return False
        self.lower[k], self.fields[k] = value, force
        return True

    def result(self, side: Ints) -> MovingLoad:
        """Return what was found."""
        least = float(self.upper.min())
        bounded = np.isfinite(least)
        worst = int(np.argmin(self.upper if bounded else self.lower))
        twist = self.twists[self.by[worst]] if bounded else np.zeros_like(self.program.load)
        return MovingLoad(
            outcome=self._outcome(least),
            place=self.place,
            side=side,
            lower=np.minimum(self.lower, self.upper),
            upper=self.upper,
            worst=worst,
            load=self.wrenches[worst],
            mechanism=unit_motion(self.problem.assembly, self.problem.to_blocks(twist)),
            solves=self.solves,
            assembly=self.problem.assembly,
            warnings=tuple(dict.fromkeys([*self.problem.warnings, *self.told])),
        )

    def _outcome(self, least: float) -> MovingOutcome:
        """What is proven of the worst place, of which the least upper bound is known."""
        if np.isinf(self.lower).all():
            return MovingOutcome.UNBOUNDED
        rows = [k for k in self.undecided if self._open(k)]
        may_be_worst = np.isinf(least) or (self.lower[rows] < (1.0 - self.tolerance) * least).any()
        return MovingOutcome.UNDECIDED if may_be_worst else MovingOutcome.LIMIT


def _close(lower: float, upper: float, tolerance: float) -> bool:
    """Whether a bracket is narrow enough, relative to its upper end."""
    return bool(np.isfinite(upper) and upper - lower <= tolerance * upper)


def _others(pairs: Ints, known: Ints) -> Ints:
    """The pairs that are not among others, shape (n, 2)."""
    return pairs[[pair not in {*map(tuple, known.tolist())} for pair in map(tuple, pairs.tolist())]]


def _coarse_first(n: int) -> list[int]:
    """Numbers from 0 to n - 1: the ends, then the middles of what is left, level by level."""
    order, level = [*range(n)][:: max(n - 1, 1)], [(0, n - 1)]
    while level:
        below = []
        for a, b in level:
            if b - a > 1:
                middle = (a + b) // 2
                order.append(middle)
                below += [(a, middle), (middle, b)]
        level = below
    return order
