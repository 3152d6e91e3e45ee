"""Brackets on the multiplier of a train at all places of a path, narrowed by what each solve proves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, bracket
from blockstat.analysis.problem import Problem, crushes
from blockstat.analysis.rims import ROUNDS, overlap_warnings, pairs_driven, rim_warnings
from blockstat.analysis.thrust import with_overlaps
from blockstat.analysis.verdict import unit_motion
from blockstat.certificate import check as certificate
from blockstat.contact.unresolved import unresolved_contacts
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.penalty import solve_penalty
from blockstat.solve.phase_one import find_forces
from blockstat.typing import Floats, Ints

#: Where contacts without a unique normal are asked too, the ends of a bracket are those of two problems. Each is found
#: to this share of the tolerance, so that both together keep it.
FINER = 0.25


@dataclass
class PlaceBrackets:
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
        self._bare = cache(partial(unresolved_contacts, self.problem.assembly, joints, gap=self.problem.gap))
        self.problem = replace(self.problem, unresolved=self._bare)
        self.loads = np.stack([self.problem.scaled(load) for load in self.wrenches])
        self.lower, self.upper = np.zeros(n), np.full(n, np.inf)
        self.by = np.full(n, -1)  #: the mechanism of the upper bound
        none = ~self.loads.any(axis=1)
        self.lower[none] = np.inf
        self.program: PenaltyProgram = self.problem.program  # type: ignore[assignment]

    @property
    def least(self) -> float:
        """The multiplier that is carried at every place."""
        return float(np.minimum(self.lower, self.upper).min())

    @property
    def carrying(self) -> Floats | None:
        """How strong the forces at each contact point are in all that carry, shape (n_points, 3) [N].

        None where they are not at hand, as those of a place where any multiple is carried.
        """
        if self.unbounded or not self.fields:
            return None
        return np.sum([np.abs(self.problem.to_points(force)) for force in self.fields.values()], axis=0)

    def run(self) -> None:
        """Solve where the bounds do not meet, coarse steps first."""
        # While the axles stay on their blocks the load is linear in its place, and what is known at the first and the
        # last of such places bounds those between them.
        loaded: np.ndarray = np.any(self.wrenches, axis=2)
        passes: np.ndarray = np.any(loaded[1:] != loaded[:-1], axis=1)
        outer = np.append(True, passes) | np.append(passes, True)
        rows = (np.flatnonzero(outer), np.flatnonzero(~outer))
        for k in (int(own[i]) for own in rows for i in _coarse_first(len(own))):
            if self.is_open(k):
                self._from_neighbours(k)
            if self.is_open(k) and not self._carried(k):
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

    def is_open(self, k: int) -> bool:
        """Return whether the bracket of a place is still too wide.

        Parameters
        ----------
        k
            The place.

        Returns
        -------
        bool
            False where any multiple is carried, too.
        """
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
                more = self._bare().among(self.held, problem.assembly.n_blocks)
                self.beside = self.stand(interfaces=more.beside(problem.interfaces))
            outcome, _, upper, _, twist, _ = bracket(*self.beside, load, self.solver, finer)
            motion = unit_motion(problem.assembly, self.beside[0].to_blocks(twist))
            if outcome is not LoadOutcome.LIMIT or self._hidden(motion) is not None:
                break
            if not len(driven := _others(pairs_driven(problem, motion), self.held)):
                self._note(twist, upper, k)
                if self.is_open(k) and _close(own, upper, self.tolerance):  # the ends are those of two problems
                    _, lower, _, force, _, _ = bracket(problem, self.inside, load, self.solver, finer)
                    if lower > self.lower[k]:
                        self.lower[k], self.fields[k] = lower, force
                if self.is_open(k):
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
        if found.outcome is not LoadOutcome.LIMIT and self.is_open(k):
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
