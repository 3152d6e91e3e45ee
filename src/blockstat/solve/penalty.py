"""The programs that a verdict asks for: the least missing adhesion, its largest value, and a mechanism next to one."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from blockstat.certificate.check import FORCE_LIMIT, FORCE_TOLERANCE, balance, check, force_errors, opening_slack
from blockstat.certificate.interior_motions import Motions, cheapest, least_slack, no_motions, with_interior_motion
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer, EarlyEnd, Status
from blockstat.solve.components import solve_by_components
from blockstat.solve.dispatch import solve
from blockstat.solve.phase_one import load_path_guess
from blockstat.typing import Floats, Ints

#: Joints open by more than this many violations need no watching when a mechanism is corrected.
WIDE_OPEN = 1e3
#: A point with an upper bound that closes faster than this fraction of the fastest joint crushes or yields.
YIELDS = 1e-6
#: Unknowns from which it pays to look for connected components.
COMPONENTS = 3_000
#: Of the load and the adhesion, what the answer of a penalty program may leave unbalanced.
BALANCED = 1e-6
#: Of what a proof may leave unbalanced, what forces may leave that are not balanced any better.
ALREADY = 0.01


def solve_penalty(
    program: PenaltyProgram,
    *,
    solver: str = "auto",
    motions: Motions = no_motions,
    score: bool = True,
    guess: Floats | None = None,
    stands: bool = False,
) -> Answer:
    """Minimise the penalty `1/2 ||E'A'u||^2` less the work of the load over the admissible twists.

    A twist is admissible when `A'u` lies in K*. At points with an upper bound the penalty is `1/2 |g_n + y|^2`.

    Parameters
    ----------
    program
        The penalty program. A large one is solved by connected components (see `blockstat.solve.components`).
    solver
        One of `blockstat.solve.dispatch.CHOICES`.
    motions
        Gives twists that may open every joint, shape (6 n,) each (see `blockstat.certificate.interior_motions`).
    score
        False allows to end with the first mechanism that is found, whose adhesion is not known.
    guess
        Forces from which to look for forces in balance first, shape (m, 3), inside their cones or on their boundaries;
        by default those of a load path.
    stands
        Whether the assembly is expected to stand: the search for forces is then given up later.

    Returns
    -------
    Answer
        Forces, adhesion and mechanism.
    """
    if len(program.load) >= COMPONENTS and program.plane is None and guess is None:
        return solve_by_components(program, partial(solve_whole, solver=solver, score=score, stands=stands), motions)
    return solve_whole(program, motions, solver=solver, score=score, guess=guess, stands=stands)


def solve_whole(
    program: PenaltyProgram,
    motions: Motions = no_motions,
    *,
    solver: str = "auto",
    score: bool = True,
    guess: Floats | None = None,
    stands: bool = False,
) -> Answer:
    """Solve a penalty program as one.

    Parameters
    ----------
    program, motions, solver, score, guess, stands
        As in `solve_penalty`.

    Returns
    -------
    Answer
        Forces, adhesion and mechanism.
    """
    proven: list[Floats] = []

    def accept(force: Floats) -> bool:
        """Forces on the way to the optimum that, balanced, prove stability are as good as the optimum's."""
        proven[:] = [force]
        if force_errors(program, force).within(ALREADY * FORCE_TOLERANCE):
            return True
        proven[:] = [balance(program, force)]
        return force_errors(program, proven[0]).within(FORCE_TOLERANCE)

    if guess is None:
        normal = load_path_guess(program)
        guess = np.column_stack([normal, 0 * normal, 0 * normal])
    iterates = _Iterates(program, motions)
    early = EarlyEnd(
        accept,
        iterates.noted if score else iterates.falls,
        guess=guess,
        # Who asks for no score expects most designs to fall, and then it is mostly in vain to look for forces for long.
        brief=not score,
        stands=stands,
    )
    answer = solve(conic_program(program, -program.load, penalty=True), solver=solver, early=early)
    if answer.status.is_proven:
        stands = answer.status is Status.ACCEPTED
        return Answer(
            force=proven[0] if stands else 0 * answer.force,
            twist=0 * answer.twist if stands else iterates.mechanism,
            status=answer.status,
            iterations=answer.iterations,
            solver=answer.solver,
            adhesion=np.full(program.n_points, 0.0 if stands else np.nan),
        )
    normal_gaps = program.normal_columns.T @ answer.twist
    adhesion = np.maximum(normal_gaps + answer.yielding[: program.n_points], 0.0)
    bounded = _balances(program, answer.force, adhesion)
    return replace(answer, adhesion=adhesion, bounded=bounded, interior=iterates.interior())


class _Iterates:
    """The twists on the way to the optimum. They lie inside the cones until near its end.

    So mechanisms are among them long before it, and those that are none yet open the joints that later ones close.
    """

    def __init__(self, program: PenaltyProgram, motions: Motions) -> None:
        self._program, self._motions = program, motions
        self._seen: list[Floats] = []
        self._slack: dict[int, float] = {}  # of those seen that were asked for
        self.mechanism = np.zeros_like(program.load)  #: the one that `falls` has found

    def noted(self, twist: Floats) -> bool:
        """Keep a twist; it ends nothing."""
        self._seen.append(twist)
        return False

    def falls(self, twist: Floats) -> bool:
        """Whether a twist, with a little of earlier ones, proves instability."""
        if float(self._program.load @ twist) > 0:
            if self._proves(twist) or self._proves(self._opened(twist)):
                return True
        return self.noted(twist)

    def _opened(self, twist: Floats) -> Floats:
        first = self.interior()
        motions = self._motions() if first is None else (first, *self._motions())
        return with_interior_motion(self._program, twist, motions)

    def _proves(self, mechanism: Floats) -> bool:
        self.mechanism = mechanism
        no_force = np.zeros((len(self._program.friction), 3))
        return check(self._program, no_force, mechanism).proves_unstable

    def interior(self) -> Floats | None:
        """The cheapest of the last motions seen that open every joint."""
        return cheapest(self._program, ((self._seen[k], self._slack_of(k)) for k in reversed(range(len(self._seen)))))

    def _slack_of(self, k: int) -> float:
        if k not in self._slack:
            self._slack[k] = least_slack(self._program, self._seen[k])
        return self._slack[k]


def _balances(program: PenaltyProgram, force: Floats, adhesion: Floats) -> bool:
    """Whether forces and adhesion balance the load; where no adhesion could, a solver ends with some ray."""
    rest = program.matrix @ force.reshape(-1) - program.normal_columns @ adhesion + program.load
    size = program.total_load + float(adhesion.sum()) + float(np.abs(program.load).max(initial=0.0))
    return bool(np.abs(rest).max(initial=0.0) <= BALANCED * size)


def solve_margin(program: PenaltyProgram, *, solver: str = "auto") -> Answer:
    """Find the least adhesion tau, the same at every point, that lets an equilibrium exist; at least -1.

    Parameters
    ----------
    program
        The penalty program.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    Answer
        Forces with tau taken off, the mechanism, and tau as the adhesion of every point.

    Notes
    -----
    Primal: min tau subject to A f + w = 0, f_i + tau n in K, tau >= -1, and f_n - tau <= upper where there is a bound.
    Dual: max w'u + sum g_n - 1 subject to A'u in K*, sum g_n <= 1, with 2 y added to g_n at an upper bound. The penalty
    program is quadratic, so near the limit its answer is good to the square root of the tolerance; this one is linear
    and good to the tolerance itself. It costs a second solve, so it is asked only where the first proved neither side.
    """
    total = np.asarray(program.normal_columns.sum(axis=1)).reshape(-1)
    answer = solve(conic_program(program, -program.load - total, at_most_one=total, yielding=2.0), solver=solver)
    bounded = program.upper_bounded
    own = bounded[bounded < program.n_points]
    earned = float(total @ answer.twist) + 2.0 * float(answer.yielding[own].sum()) - 1.0
    tau = float(program.load @ answer.twist) - float(program.upper[bounded] @ answer.yielding[bounded]) + earned
    tau += _paid_by_lower_bounds(program, answer)
    force = answer.force.copy()
    force[: program.n_points, 0] -= tau
    return replace(answer, force=force, adhesion=np.full(program.n_points, max(tau, 0.0)))


def _paid_by_lower_bounds(program: PenaltyProgram, answer: Answer) -> float:
    """What the lower bounds pay for the opening beyond friction at their points."""
    points = program.lower_bounded
    rate = (program.matrix.T @ answer.twist).reshape(-1, 3)[points]
    slack = opening_slack(rate, program.friction[points]) + answer.yielding[points]
    return float(program.lower[points] @ np.maximum(slack, 0.0))


def solve_least_force(program: PenaltyProgram, *, solver: str = "auto") -> Answer:
    """Find the equilibrium whose normal forces have the least sum, and the mechanism that no smaller sum resists.

    Parameters
    ----------
    program
        The penalty program.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    Answer
        The forces and the mechanism; a mechanism that closes no joint where there is no equilibrium at all.

    Notes
    -----
    Primal: min sum f_n subject to A f + w = 0, f_i in K. Dual: max w'u subject to A'u + n in K*, in units in which a
    mechanism of unit work closes by one part in `FORCE_LIMIT`. This is the last word: forces and mechanism are judged
    by that sum, and at the optimum both sides agree on it. Where friction is infinite, shear is paid for as well (see
    `_with_dear_shear`).
    """
    priced, shear = _with_dear_shear(program)
    offset = np.zeros((len(priced.friction), 3))
    offset[:, 0] = 1.0 / FORCE_LIMIT
    offset[priced.upper_bounded] = 0.0  # these may close, at a price
    answer = solve(conic_program(priced, -program.load, offset=offset.reshape(-1)), solver=solver)
    m, force = len(program.friction), answer.force[: len(program.friction)].copy()
    if len(shear):
        plus, minus = answer.force[m:, 0].reshape(2, -1, 2)
        force[shear, 1:] = plus - minus
    return replace(answer, force=force, adhesion=np.zeros(program.n_points))


def _with_dear_shear(program: PenaltyProgram) -> tuple[PenaltyProgram, Ints]:
    """The program with the shear of infinite friction as forces along the tangents that each have a price.

    Without one, joints whose planes differ by rounding balance anything by shear forces without bound. Behind the
    columns of the program stand those of +t1, +t2 at each point, then those of -t1, -t2, each without friction.
    """
    shear = np.flatnonzero(np.isinf(program.friction))
    if not len(shear):
        return program, shear
    rows = program.local.reshape(-1, 3, 12)
    along = np.zeros((2, len(shear), 2, 3, 12))
    along[0, :, :, 0], along[1, :, :, 0] = rows[shear, 1:], -rows[shear, 1:]
    more = 4 * len(shear)

    def longer(values: Floats, value: float) -> Floats:
        return np.concatenate([values, np.full(more, value)])

    sides = np.tile(np.repeat(program.point_blocks[shear], 2, axis=0), (2, 1))
    wider = replace(
        program,
        local=np.concatenate([program.local, along.reshape(-1, 12)]),
        friction=longer(np.where(np.isinf(program.friction), 0.0, program.friction), 0.0),
        shift=longer(program.shift, 0.0),
        lower=longer(program.lower, 0.0),
        upper=longer(program.upper, np.inf),
        point_blocks=np.concatenate([program.point_blocks, sides]),
        plane=None,
    )
    return wider, shear


def open_joints(program: PenaltyProgram, twist: Floats, *, solver: str = "auto") -> Floats:
    """Find a twist next to the given one under which no joint closes at all.

    Parameters
    ----------
    program
        The penalty program.
    twist
        Shape (6 n,).
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    Floats
        The twist, shape (6 n,); the given one when there is nothing to correct or, in jammed assemblies, no such twist.

    Notes
    -----
    With eps the largest violation of A'u in K*, looks for the least d with A'(u / eps + d) in K* + n and returns
    u + eps d. The solver's error is then relative to eps and not to u.
    """
    gap_rate = (program.matrix.T @ twist).reshape(-1, 3)
    slack = opening_slack(gap_rate, program.friction)
    # Points that crush or bonds that yield may go on closing; those that close by an error are corrected.
    bounded = program.upper_bounded
    slack[bounded[slack[bounded] < -YIELDS * np.abs(gap_rate).max(initial=0.0)]] = np.inf
    worst = -float(slack.min(initial=0.0))
    if worst <= 0:
        return twist
    offset = np.zeros_like(gap_rate)
    no_slip = np.isinf(program.friction)
    offset[:, 0] = np.minimum(np.where(no_slip & np.isfinite(slack), gap_rate[:, 0], slack) / worst, WIDE_OPEN) - 1.0
    offset[no_slip, 1:] = gap_rate[no_slip, 1:] / worst
    least = conic_program(program, np.zeros(len(twist)), least_norm=True, offset=offset.reshape(-1))
    answer = solve(least, solver=solver)
    return twist if answer.status.is_infeasible else twist + worst * answer.twist
