"""Force fields that real friction reaches: without dilatancy and without self-stress.

In limit analysis a sliding joint opens at the rate mu, but stone slides without opening. And any thrust can hold a
block between fixed ones, although no load causes it. A Coulomb state has neither: its displacements cause its forces
(`blockstat.certificate.coulomb_state` has the conditions and their check). "Stable" rests on a state that has passed
the check, whichever way it was found.

It is looked for by De Saxce's fixed point (`blockstat.solve.coulomb`) in assemblies of three kinds of joints: stiff
ones that are all open by the same amount at first, elastic ones that are hardly open, and both. Forces between stiff
joints are those of a mechanism that the loads have closed. Forces between elastic joints are spread as in a
distinct-element code. Each kind has its own state, if it has one, because friction depends on history; any state is
a proof.

That none is found proves nothing. The answer is "stable only by self-stress" when blocks fall freely from joints that
nothing has pressed, which is a proof (`blockstat.certificate.falling`) beside which only states in joints of every kind
count, or when slips grow without bound for every kind of joints and stiff joints of unequal openings have no state
either; it is undecided otherwise. A block that only a thrust holds slips on by the same amount or more with each
program.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from blockstat.certificate.bracket import Progress
from blockstat.certificate.coulomb_state import RATE_ACCURACY, CoulombCertificate, check_coulomb_state, loaded_points
from blockstat.program.penalty import PenaltyProgram, as_strong_as_the_weight
from blockstat.solve.coulomb import Iterate, solve_state
from blockstat.typing import Floats, Ints

MOST_SOLVES = 40
#: Openings and compliances of the family, in units of the mean block and weight. Only their ratio counts: forces of the
#: mean weight close a joint by c; so the joints are stiff, elastic, or both.
FAMILY = ((1.0, 1e-3), (0.1, 1.0), (1.0, 1.0))
#: Joints of stones that are cut alike are open by amounts that differ by a factor of two to either side.
UNEQUAL = float(np.log10(2.0))
#: Friction beyond which none slides: what is larger, or infinite, counts as this where slips are looked for.
GREAT = 1e3
#: Width of the bracket of a limit load without dilatancy, relative to the limit load with it.
MULTIPLIER_WIDTH = 5e-4
#: The least multiplier that is told from none where a load has no limit with dilatancy, relative to the largest tried.
LEAST_MULTIPLIER = 1e-8
#: A member's slips grow when they change by as much in the last third of so many programs as in the third before.
EARLY = 6
#: After so many programs they have no bound when the changes shrink no faster than those of a harmonic series, whose
#: sum is unbounded: over the last third of n programs 1/k has the mean `ln(3/2) / ln 2` of that over the third before.
#: Three kinds of joints and the unequal ones have so many programs each within `MOST_SOLVES`.
LATE, HARMONIC = 9, float(np.log(1.5) / np.log(2.0))
#: Least share of its change that a slip takes, so that it is not held where it happens to be.
LEAST_SHARE = 0.1
NOWHERE = np.empty(0, dtype=np.int64)


@dataclass(eq=False)
class _Member:
    """Joints of one kind, and the programs solved for them."""

    opening: Floats
    compliance: float
    slip: Floats
    known: bool = False  #: whether the openings are given, and not only assumed
    changes: list[float] = field(default_factory=list)
    last: Iterate | None = None
    lost: bool = False  #: whether the solver has found no forces
    step: Floats | None = None  #: by how much the slips would have changed in the last program, shape (m,)
    turned: np.ndarray | bool = False  #: which slips last went back
    share: Floats | float = 1.0  #: of its change that the slip of each point takes

    @property
    def grows(self) -> bool:
        """Whether its slips grow without bound."""
        third = len(self.changes) // 3
        if self.lost or len(self.changes) < EARLY:
            return self.lost and len(self.changes) > 1 and self.changes[-1] > self.changes[0]
        before, after = np.mean(self.changes[third : 2 * third]), np.mean(self.changes[2 * third :])
        return bool(after >= before * (HARMONIC if len(self.changes) >= LATE else 1.0))

    @property
    def ends(self) -> bool:
        """Whether there is no use in further programs."""
        return self.lost or self.grows

    def solve(self, program: PenaltyProgram, solver: str) -> bool:
        """Solve one program more. Whether the state that it leads to has passed the check."""
        found = solve_state(
            program, self.slip, opening=self.opening, compliance=self.compliance, known=self.known, solver=solver
        )
        if found is None:
            self.lost = True
            return False
        self._relax(found.slip - self.slip)
        self.last = found
        self.changes.append(found.change)
        return found.certificate.proves_settled

    def _relax(self, step: Floats) -> None:
        """Take the new slips, but less of those that go back and forth, of each what the secant method says.

        One block that may slip on either of two joints can alternate for ever where thousands of others have settled.
        """
        if self.step is not None:
            turned = self.step * step < 0
            secant = self.share * self.step / np.where(turned, self.step - step, 1.0)
            smaller = np.maximum(secant, LEAST_SHARE)
            self.share = np.where(turned, np.where(self.turned, smaller, self.share), np.minimum(2.0 * self.share, 1.0))
            self.turned = turned
        self.step = step
        self.slip = self.slip + self.share * step


@dataclass(frozen=True, eq=False)
class CoulombState:
    """What was found out about friction without dilatancy and self-stress."""

    settles: bool | None  #: True: a state has passed the check; False: slips grow for all joints; None: neither
    force: Floats  #: forces of the state, or of the last program, in units of the program, shape (m, 3)
    displacement: Floats  #: displacements that cause them, shape (6 n,)
    certificate: CoulombCertificate  #: of both
    solves: int  #: conic programs
    changes: tuple[tuple[float, ...], ...]  #: force-weighted change of the slips at each program of each kind of joints
    held: Ints  #: points that carry a force and do not close, whatever the joints; empty where a state was found
    share: float  #: what they carry of all normal forces
    opposed: bool  #: whether slips grow in joints of one kind at least, or blocks fall freely
    unequal: bool = False  #: whether slips grow in equal joints, and stiff ones of unequal openings have a state
    #: share of random tightnesses of the joints at which a state is found (see `settling_share`); nan if not asked for
    tightness: float = float("nan")
    #: blocks that would fall freely from joints that nothing has pressed, and that others clamp as joints give way
    clamped: Ints = field(default_factory=lambda: NOWHERE)

    @classmethod
    def of_falling(cls, program: PenaltyProgram, force: Floats, points: np.ndarray) -> CoulombState:
        """Return what is known where blocks fall freely from joints that nothing has pressed.

        Parameters
        ----------
        program
            The penalty program.
        force
            Forces that balance it, shape (m, 3).
        points
            Those of the blocks that fall, shape (m,).

        Returns
        -------
        CoulombState
            With the points of these blocks that carry a force, all of which need self-stress.
        """
        still = np.zeros(len(program.load))
        held = loaded_points(program, force) & points
        normal = np.maximum(force[:, 0], 0.0) * (np.arange(len(force)) < program.n_points)
        return cls(
            settles=False, force=force, displacement=still, certificate=check_coulomb_state(program, force, still),
            solves=0, changes=(), held=np.flatnonzero(held), opposed=True,
            share=float(normal[held].sum() / max(normal.sum(), 1e-300)),
        )  # fmt: skip

    def explain(self) -> str:
        """Return what was found in words.

        Returns
        -------
        str
            One sentence.
        """
        if self.settles:
            words = (
                "The loads alone cause forces without dilatancy and self-stress: every loaded joint closes, and "
                f"friction opposes slip (checked; conic programs: {self.solves})."
            )
        else:
            changes = ", ".join(f"{own[-1]:.2g} (first {own[0]:.2g})" for own in self.changes if own)
            grow = "grow" if self.settles is False or self.unequal else "neither settle nor clearly grow"
            words = f"Points that do not close carry {100 * self.share:.3g} % of the normal force."
            if changes:
                words += f" Slips change by {changes} with each program: they {grow} in joints of these kinds."
        unequal = self.solves - sum(len(own) for own in self.changes)
        if self.settles is False and unequal:
            words += f" Stiff joints that are open by unequal amounts have no state either (programs: {unequal})."
        if not np.isnan(self.tightness):
            words += f" At {100 * self.tightness:.0f} % of random tightnesses of the joints there is such a state."
        if self.unequal:
            words += " In stiff joints that are open by unequal amounts there is a state (checked)."
        if self.hangs:
            words += " Whether the blocks stand hangs on how tight the joints are"
            words += "." if self._differs else " (tightnesses=12 tells the share)."
        return words

    @property
    def _differs(self) -> bool:
        """Whether random tightnesses were tried, and do not say what the kinds of joints say."""
        return self.tightness < 1 if self.settles else self.tightness > 0

    @property
    def hangs(self) -> bool:
        """Whether there is a state in some joints and none was found in others, as tight as they are."""
        return bool(self._differs or self.unequal or (self.settles and (self.opposed or len(self.clamped))))


def coulomb_state(
    program: PenaltyProgram,
    *,
    kinds: Sequence[tuple[float, float]] = FAMILY,
    tightnesses: int = 0,
    solver: str = "auto",
) -> CoulombState:
    """Look for a Coulomb state in each kind of joints by turns.

    Parameters
    ----------
    program
        The penalty program of a statically stable assembly. Friction above `GREAT` counts as that.
    kinds
        The opening and the compliance of each kind of joints, tried by turns.
    tightnesses
        How many random tightnesses of the joints are tried for `CoulombState.tightness`.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    CoulombState
        A checked state, or what speaks against one.

    References
    ----------
    De Saxce & Feng: The bipotential method, 1998. Acary, Cadoux, Lemarechal & Malick: A formulation of the linear
    discrete Coulomb friction problem via convex optimization, 2011.
    """
    program = replace(program, friction=np.minimum(program.friction, GREAT))
    m = len(program.friction)
    state = _search(program, [_Member(np.full(m, t), c, np.zeros(m)) for t, c in kinds], solver)
    if state.settles is False and len(kinds) > 1:
        state = _in_unequal_joints(program, state, solver)
    if not tightnesses:
        return state
    return replace(state, tightness=settling_share(program, tries=tightnesses, solver=solver))


def state_in_every_kind(program: PenaltyProgram, *, tightnesses: int = 0, solver: str = "auto") -> CoulombState | None:
    """Look for a Coulomb state in joints of every kind.

    Parameters
    ----------
    program, tightnesses, solver
        As in `coulomb_state`.

    Returns
    -------
    CoulombState or None
        That of the first kind, with the programs of all; None where joints of one kind have none.
    """
    found: list[CoulombState] = []
    for kind in FAMILY:
        found.append(coulomb_state(program, kinds=[kind], solver=solver))
        if not found[-1].settles:
            return None
    share = settling_share(program, tries=tightnesses, solver=solver) if tightnesses else float("nan")
    solves, changes = sum(own.solves for own in found), tuple(change for own in found for change in own.changes)
    return replace(found[0], solves=solves, changes=changes, tightness=share)


def _in_unequal_joints(program: PenaltyProgram, state: CoulombState, solver: str) -> CoulombState:
    """Whether stiff joints of which each is open by another amount have a state.

    Next to its limit an assembly hangs on where the joints are tight, and the answer is undecided.
    """
    m = len(program.friction)
    opening = 10.0 ** np.random.default_rng(0).uniform(-UNEQUAL, UNEQUAL, m)
    found = _search(program, [_Member(opening, FAMILY[0][1], np.zeros(m))], solver, MOST_SOLVES - state.solves)
    solves = state.solves + found.solves
    return replace(state, settles=None, solves=solves, unequal=True) if found.settles else replace(state, solves=solves)


def _search(program: PenaltyProgram, members: list[_Member], solver: str, most: int = MOST_SOLVES) -> CoulombState:
    """One program of each kind of joints by turns, until a state has passed or none is to be expected."""
    solves = 0
    while live := [member for member in members if not member.ends]:
        for member in live:
            if solves == most:
                return _failed(program, members, solves)
            solves += 1
            if member.solve(program, solver):
                return _state(True, member.last, members, solves)
    return _failed(program, members, solves)


def _failed(program: PenaltyProgram, members: list[_Member], solves: int) -> CoulombState:
    """What speaks against a state: the points that carry a force and close for no kind of joints."""
    tried = [member.last for member in members if member.last is not None]
    held = np.ones(len(program.friction), dtype=bool)
    for found in tried:
        held &= _unclosed(program, found)
    last = min(tried, key=lambda found: found.certificate.unsupported, default=None)
    if last is None:
        return _state(None, Iterate.nothing(program), members, solves)
    normal = np.maximum(last.force[: program.n_points, 0], 0.0)
    share = float(normal[held[: program.n_points]].sum() / max(normal.sum(), 1e-300))
    grows = all(member.grows for member in members) and bool(held.any())
    return _state(False if grows else None, last, members, solves, np.flatnonzero(held), share)


def _state(
    settles: bool | None,
    found: Iterate | None,
    members: list[_Member],
    solves: int,
    held: Ints = NOWHERE,
    share: float = 0.0,
) -> CoulombState:
    assert found is not None
    return CoulombState(
        settles=settles,
        force=found.force,
        displacement=found.displacement,
        certificate=found.certificate,
        solves=solves,
        changes=tuple(tuple(member.changes) for member in members),
        held=held,
        share=share,
        opposed=any(member.grows for member in members),
    )


def _unclosed(program: PenaltyProgram, found: Iterate) -> np.ndarray:
    """Points that carry a force and do not close, shape (m,)."""
    rate = (program.matrix.T @ found.displacement).reshape(-1, 3)
    touching = np.arange(len(rate)) < program.n_points
    closes = -rate[:, 0] > RATE_ACCURACY * np.abs(rate).max(initial=0.0)
    return loaded_points(program, found.force) & touching & ~closes


def settling_share(program: PenaltyProgram, *, tries: int = 12, seed: int = 0, solver: str = "auto") -> float:
    """Return the share of random tightnesses of the joints at which a Coulomb state is found.

    At 0 or 1 history plays no part.

    Parameters
    ----------
    program
        As in `coulomb_state`.
    tries
        In each of them the joint of every point is open by another random amount, from a tenth of the usual one to ten
        times it.
    seed
        Of the random numbers.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    float
        From 0 to 1.
    """
    random, m = np.random.default_rng(seed), len(program.friction)
    states = (
        _search(program, [_Member(10.0 ** random.uniform(-1.0, 1.0, m), FAMILY[0][1], np.zeros(m), known=True)], solver)
        for _ in range(tries)
    )
    return float(np.mean([state.settles is True for state in states]))


def multiplier_brackets(
    program: PenaltyProgram,
    load: Floats,
    associated: float,
    *,
    most: float = np.inf,
    falls: bool = False,
    solver: str = "auto",
    progress: Progress | None = None,
) -> tuple[tuple[tuple[float, float], ...], bool]:
    """Find, for each kind of joints, the multipliers of a load with and without a Coulomb state.

    Parameters
    ----------
    program
        The penalty program of the dead load.
    load
        What the multiplier multiplies, in the units of the program, shape (6 n,).
    associated
        The multiplier of limit analysis, above which there is none. Infinite where it finds no limit.
    most
        How many times as strong as the weight the load is at most, then. One that is carried so has no limit.
    falls
        Whether it is proven that only self-stress holds the dead load: then none is carried.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.
    progress
        Told the number of the trial, from 0 for each kind, and the bracket of the kind until then. With it a
        KeyboardInterrupt keeps what is known; without it, it is raised.

    Returns
    -------
    brackets : tuple of (float, float)
        By kind as in `FAMILY`, found by bisection; both ends are infinite where there is no limit.
    stopped : bool
        Whether a KeyboardInterrupt has ended the last bracket early; kinds behind it have none.
    """
    if falls:
        return ((0.0, 0.0),) * len(FAMILY), False
    brackets = [(0.0, associated)]
    try:
        for number, kind in enumerate(FAMILY):
            brackets[number:] = [(0.0, associated)]
            for trial, bracket in enumerate(_bisection(program, load, associated, kind, solver, most)):
                brackets[number] = bracket
                if progress is not None:
                    progress(trial, *bracket)
    except KeyboardInterrupt:
        if progress is None:
            raise
        return tuple(brackets), True
    return tuple(brackets), False


def _bisection(
    program: PenaltyProgram,
    load: Floats,
    associated: float,
    kind: tuple[float, float],
    solver: str,
    most: float = np.inf,
) -> Iterator[tuple[float, float]]:
    """The brackets of one kind of joints, ever narrower."""

    def settles(multiplier: float) -> bool:
        loaded = replace(program, load=program.load + multiplier * load)
        if np.isinf(associated):  # a load far beyond the weight closes joints by what the weight closes them else
            loaded = loaded.in_units(*(np.full(size, max(1.0, multiplier * strength)) for size in sizes))
        return coulomb_state(loaded, kinds=[kind], solver=solver).settles is True

    strength, sizes = as_strong_as_the_weight(program, load)[1], (len(load) // 6, len(program.friction))
    width = MULTIPLIER_WIDTH * associated
    low, high = 0.0, associated
    yield low, high
    if not settles(0.0):
        yield low, low  # not even the dead load
        return
    if np.isinf(associated):
        if settles(most / strength):
            yield associated, associated
        else:
            yield from _through_decades(settles, most / strength)
        return
    while high - low > width:
        # Most structures lose little to zero dilatancy, so the first trial is near the top.
        middle = high - width if low == 0.0 and high == associated else (low + high) / 2
        low, high = (middle, high) if settles(middle) else (low, middle)
        yield low, high


def _through_decades(settles: Callable[[float], bool], most: float) -> Iterator[tuple[float, float]]:
    """The brackets between nothing and a multiplier too large by orders of magnitude, ever narrower."""
    low, high, least = 0.0, most, LEAST_MULTIPLIER * most
    yield low, high
    while high - max(low, least) > MULTIPLIER_WIDTH * high:
        middle = float(np.sqrt(max(low, least) * high))
        low, high = (middle, high) if settles(middle) else (low, middle)
        yield low, high
