"""A primal-dual interior-point method for the programs of rigid blocks: min 1/2 x'P x + q'x, M x + s = b, s in a cone.

The homogeneous embedding of Goulart & Chen (Clarabel, 2024; after Andersen, Ye and Nesterov), with Nesterov-Todd
scaling and Mehrotra's predictor and corrector. All cones have dimension 3 or 1 and are handled in a batch (`cones`).
Each iteration factors the normal equations M' W^-2 M + P, which have the pattern of the contact graph. They lose digits
as the cones close, so every solve is refined on the whole system (`kkt`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.program.conic import ConicProgram
from blockstat.solve.answer import AT_THE_OPTIMUM, Answer, EarlyEnd, Status, read_answer
from blockstat.solve.kkt import DUAL_PROXIMAL, PROXIMAL, REFINED, KktSolver, Pair, largest
from blockstat.solve.phase_one import NOTHING, find_forces
from blockstat.typing import Floats

MOST_ITERATIONS = 100
#: Linear programs are asked for as many digits as there are, for the sake of the bounds that rest on them; the penalty
#: program gives a score, and its verdict rests on a certificate of its own.
TOLERANCE, QUADRATIC_TOLERANCE = 1e-11, 1e-10
#: Where the iteration stalls, an answer this good is still handed on; the certificate check decides.
ALMOST = 1e-6
RAY = 1e-8  #: violation of a ray that proves a program infeasible or unbounded
ASK = 1.0  #: error of M'z + q = 0, in units of the mean weight, from which an answer may be accepted
PATIENCE = 8  #: iterations without progress
STEP = 0.99
INSIDE = 0.1  #: depth of a start at multipliers, in mean weights, and its complementarity
LARGE = 1e3  #: multipliers beyond this change the proximal term of their own no more
#: Far from the end solves need not be as good: a share of the iterate's own error, at most the second.
FIRM, ROUGH = 1e-1, 1e-3


def _dot(a: Floats, b: Floats) -> float:
    """Inner product on one thread: waking the others for it costs more than the sum."""
    return float(np.einsum("i,i->", a, b))


@dataclass(frozen=True, eq=False)
class _State:
    x: Floats
    s: Floats
    z: Floats
    tau: float
    kappa: float


def solve(program: ConicProgram, early: EarlyEnd = AT_THE_OPTIMUM) -> Answer:
    """Solve a program with the structure of blocks.

    Parameters
    ----------
    program
        A program with `has_structure`.
    early
        What may end the solve before the optimum.

    Returns
    -------
    Answer
        Forces, a twist and the status; nothing in them is checked. An iteration is a factorisation.
    """
    first = NOTHING
    if early.guess is not None:
        first = find_forces(program, program.multipliers(early.guess), brief=early.brief)
        if first.found is not None and early.forces is not None and early.forces(program.forces(first.found)):
            return _read(program, 0 * program.cost, first.found, Status.ACCEPTED, first.factorisations)
    if not early.optimise:
        return _read(program, 0 * program.cost, 0 * program.bound, Status.NO_FORCES, first.factorisations)
    answer = _iterate(program, KktSolver(program), early, first.least)
    return replace(answer, iterations=first.factorisations + answer.iterations)


def _read(program: ConicProgram, x: Floats, z: Floats, status: Status, iterations: int) -> Answer:
    slack = program.bound - program.matrix @ x + program.compliance * z if program.compliance else None
    return read_answer(program, x, z, status, iterations, "interior-point", slack)


def _iterate(program: ConicProgram, kkt: KktSolver, early: EarlyEnd, start: Floats | None) -> Answer:
    """Predictor and corrector until the answer is good, or gets no better."""
    try:
        state = _start(program, kkt) if start is None else _start_at(program, kkt, start)
    except ArithmeticError:
        return _read(program, 0 * program.cost, 0 * program.bound, Status.STALLED, 0)
    best, best_error, least, waited, asked = state, np.inf, np.inf, 0, ASK
    iteration = 0
    for iteration in range(MOST_ITERATIONS):
        rest = _residuals(program, kkt, state)
        status, error = _convergence(program, state, rest)
        if status is not None:
            return _answer(program, state, status, iteration)
        if early.twist is not None and early.twist(program.twist(state.x / state.tau)):
            return _answer(program, state, Status.MECHANISM, iteration)
        accept = early.forces
        # Forces are asked about once they nearly balance, and again each time they do so three times better.
        if accept is not None and (near := largest(rest.dual - rest.curved) / state.tau) < asked:
            asked = 0.3 * near
            if accept(program.forces(state.z / state.tau)):
                return _answer(program, state, Status.ACCEPTED, iteration)
        mu = _complementarity(kkt, state)
        # Far from the end the gap may shrink for long before the errors do; near it they count alone.
        moves = error < 0.9 * best_error or (mu < 0.9 * least and best_error > ALMOST)
        waited = 0 if moves else waited + 1
        least = min(least, mu)
        if error < best_error:
            best, best_error = state, error
        if waited > (PATIENCE if best_error > ALMOST else 2):
            break
        try:
            with np.errstate(over="raise", invalid="raise", divide="raise"):
                state = _step(program, kkt, state, rest, error)
        except (ArithmeticError, np.linalg.LinAlgError):
            break
    return _answer(program, best, Status.ALMOST_SOLVED if best_error < ALMOST else Status.STALLED, iteration)


def _answer(program: ConicProgram, state: _State, status: Status, iterations: int) -> Answer:
    scale = 1.0 if status.is_infeasible or status.is_stalled else state.tau
    return _read(program, state.x / scale, state.z / scale, status, iterations)


def _start(program: ConicProgram, kkt: KktSolver) -> _State:
    """The minimisers of the two least-squares problems, moved inside the cones (Vandenberghe 2010, section 5.3)."""
    cones = kkt.cones
    kkt.update(cones.identity)
    if program.is_quadratic:
        ((x, z),) = kkt.solve((-program.cost, program.bound))
        s = -z
    else:
        (x, s), (_, z) = kkt.solve((0 * program.cost, program.bound), (-program.cost, 0 * program.bound))
        s = -s

    def inside(vector: Floats) -> Floats:
        depth = cones.depth(vector)
        return vector.copy() if depth > 1e-4 else vector + (1.0 - depth) * cones.unit

    s = inside(s)
    cones.zeros(s)[:] = 0.0
    return _State(x, s, inside(z), 1.0, 1.0)


def _start_at(program: ConicProgram, kkt: KktSolver, z: Floats) -> _State:
    """Multipliers, all moved by as little as brings the last of them inside its cone.

    No unknown moves, and s is on the central path with the multipliers. What is left is an error of M'z + q = 0 that
    the first steps take away; a start deep inside takes as many steps to come back.
    """
    cones = kkt.cones
    z = z + (INSIDE - min(cones.depth(z), 0.0)) * cones.unit
    s = cones.quotient(z, INSIDE * cones.unit)
    cones.zeros(s)[:] = 0.0
    return _State(0 * program.cost, s, z, 1.0, INSIDE)


@dataclass(frozen=True, eq=False)
class _Residuals:
    """What an iterate leaves of the equations of the embedding, and P x."""

    dual: Floats
    primal: Floats
    gap: float
    curved: Floats


def _residuals(program: ConicProgram, kkt: KktSolver, v: _State) -> _Residuals:
    curved = kkt.hessian(v.x)
    dual = curved + kkt.transposed(v.z) + program.cost * v.tau
    primal = program.matrix @ v.x + v.s - program.compliance * v.z - program.bound * v.tau
    gap = (
        (_dot(v.x, curved) + program.compliance * _dot(v.z, v.z)) / v.tau
        + _dot(program.cost, v.x)
        + _dot(program.bound, v.z)
        + v.kappa
    )
    return _Residuals(dual, primal, gap, curved)


def _complementarity(kkt: KktSolver, v: _State) -> float:
    """mu, what s'z and tau kappa have on average."""
    return (_dot(v.s, v.z) + v.tau * v.kappa) / (kkt.cones.degree + 1)


def _convergence(program: ConicProgram, v: _State, rest: _Residuals) -> tuple[Status | None, float]:
    """The status if it is time to stop, and the largest relative error of the candidate answer."""
    linear, bound = _dot(program.cost, v.x), _dot(program.bound, v.z)
    quadratic = (_dot(v.x, rest.curved) + program.compliance * _dot(v.z, v.z)) / v.tau**2
    value, other = quadratic / 2 + linear / v.tau, -quadratic / 2 - bound / v.tau
    length = largest(v.x)
    errors = (
        largest(rest.primal) / v.tau / max(1.0, largest(program.bound) + (length + largest(v.s)) / v.tau),
        largest(rest.dual) / v.tau / max(1.0, largest(program.cost) + (length + largest(v.z)) / v.tau),
        abs(value - other) / max(1.0, min(abs(value), abs(other))),
    )
    if max(errors) < (QUADRATIC_TOLERANCE if program.is_quadratic else TOLERANCE):
        return Status.SOLVED, max(errors)
    # A ray is one when what it violates is nothing against what it gains, per unit of all that is given.
    if bound < 0 and not program.compliance:
        pulled = largest(rest.dual - rest.curved - program.cost * v.tau)
        if pulled * np.abs(program.bound).sum() < RAY * -bound:
            return Status.PRIMAL_INFEASIBLE, max(errors)
    if linear < 0:
        moved = rest.primal + program.bound * v.tau + program.compliance * v.z
        if max(largest(rest.curved), largest(moved)) * np.abs(program.cost).sum() < RAY * -linear:
            return Status.DUAL_INFEASIBLE, max(errors)
    return None, max(errors)


def _step(program: ConicProgram, kkt: KktSolver, v: _State, rest: _Residuals, error: float) -> _State:
    """One predictor and corrector from an iterate of some error."""
    cones, curved = kkt.cones, rest.curved
    scaling = cones.scaling(v.s, v.z)
    # Proximal terms must not hold back what is large: W'W is s over z, and s is mu over z.
    length, force = (max(largest(part) / v.tau, 1.0) for part in (v.x, v.z))
    kkt.update(
        scaling,
        pull=PROXIMAL / length,
        shift=DUAL_PROXIMAL / min(force, LARGE) ** 2,
        refined=max(REFINED, min(FIRM * error, ROUGH)),
    )
    mean = scaling.apply(v.z)
    mu = _complementarity(kkt, v)
    slope = 2.0 * curved / v.tau + program.cost
    dual_slope = 2.0 * program.compliance / v.tau * v.z + program.bound
    bend_of_gap = (_dot(v.x, curved) + program.compliance * _dot(v.z, v.z)) / v.tau**2
    square = cones.product(mean, mean)

    def right(share: float, bend: Floats) -> tuple[Floats, Pair]:
        """For residuals reduced to `share` and lambda o (W^-1 ds + W dz) = -bend."""
        shift = scaling.apply(cones.quotient(mean, bend))
        return shift, (-share * rest.dual, shift - share * rest.primal)

    shift, affine = right(1.0, square)
    (x2, z2), first = kkt.solve((-program.cost, program.bound), affine)
    below = _dot(slope, x2) + _dot(dual_slope, z2) - bend_of_gap - v.kappa / v.tau

    def direction(share: float, shift: Floats, one: Pair, turn: float) -> tuple[Floats, Floats, Floats, float, float]:
        """The step, with tau kappa changed by -turn."""
        x1, z1 = one
        above = -share * rest.gap + turn / v.tau - _dot(slope, x1) - _dot(dual_slope, z1)
        d_tau = above / below
        dx, dz = x1 + d_tau * x2, z1 + d_tau * z2
        ds = -shift - scaling.squared(dz)
        return dx, ds, dz, d_tau, (-turn - v.kappa * d_tau) / v.tau

    def longest(ds: Floats, dz: Floats, d_tau: float, d_kappa: float) -> float:
        steps = [cones.longest_step(v.s, ds), cones.longest_step(v.z, dz)]
        steps += [-now / change for now, change in ((v.tau, d_tau), (v.kappa, d_kappa)) if change < 0]
        return min(1.0, *steps)

    _, ds, dz, d_tau, d_kappa = direction(1.0, shift, first, v.tau * v.kappa)
    alpha = longest(ds, dz, d_tau, d_kappa)
    sigma = (1.0 - alpha) ** 3
    second = cones.product(scaling.inverse(ds), scaling.apply(dz))
    bend = square + second - sigma * mu * cones.unit
    turn = v.tau * v.kappa + d_tau * d_kappa - sigma * mu
    shift, corrected = right(1.0 - sigma, bend)
    (second_order,) = kkt.solve(corrected)
    dx, ds, dz, d_tau, d_kappa = direction(1.0 - sigma, shift, second_order, turn)
    alpha = STEP * longest(ds, dz, d_tau, d_kappa)
    return _State(
        v.x + alpha * dx, v.s + alpha * ds, v.z + alpha * dz, v.tau + alpha * d_tau, v.kappa + alpha * d_kappa
    )
