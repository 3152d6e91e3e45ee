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
from blockstat.solve.phase_one import NOTHING, find_forces, find_motion
from blockstat.typing import Floats

MOST_ITERATIONS = 100
#: An answer this good is solved: linear programs are asked for as many digits as there are, for the sake of the bounds
#: that rest on them; the penalty program gives a score, and its verdict rests on a certificate of its own.
TOLERANCE, QUADRATIC_TOLERANCE = 1e-11, 1e-10
#: Where the iteration stalls, an answer this good is still handed on; the certificate check decides.
ALMOST = 1e-6
#: Where an answer is to be sharp, the iteration goes on to this, or until nothing is gained, or until an error below
#: ALMOST has grown again by the factor LOST: it does not come back.
SHARPEST, LOST = 1e-14, 1e2
RAY = 1e-8  #: violation of a ray that proves a program infeasible or unbounded
ASK = 1.0  #: error of M'z + q = 0, in units of the mean weight, from which an answer may be accepted
PATIENCE = 8  #: iterations without progress
#: With tau below this, relative to kappa, an iterate is a ray to rounding: no better ray and no answer follow it.
ROUNDING = 2.0**-52
STEP = 0.99
INSIDE = 0.1  #: depth of a start at multipliers, in mean weights, and its complementarity
LARGE = 1e3  #: multipliers beyond this change the proximal term of their own no more
#: Correctors of centrality (Gondzio: Multiple centrality corrections in a primal-dual method for linear programming,
#: 1996): each asks for a step so much longer, and for products s o z within a factor of NEAR of their target.
#: FEW of the cones may hinder the predictor without a say in the target. A corrector costs about a tenth of an
#: iteration (COST), so the next is made where the last has made the step longer by more than that.
#: Where the first mechanism is all that is asked, BRIEF of them keep the twists inside the cones, so that the first
#: that gains work is one. Where an answer is to be sharp, FINAL of them keep the iterates so central that most
#: programs lose few digits to the normal equations.
CORRECTORS, BRIEF, FINAL, FURTHER, NEAR, FEW, COST = 8, 2, 1, 0.3, 0.3, 3e-3, 0.1
#: A start inside: the gap between the bounds, in weights that move as fast as the load, and the first multiplier.
FIRST_GAP, FIRST_MULTIPLIER, DEEP = 1.0, 0.1, 1e-3
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
    if early.pair is not None:
        return _solve_inside(program, early)
    first = NOTHING
    if early.guess is not None:
        first = find_forces(program, program.multipliers(early.guess), brief=early.brief, stands=early.stands)
        if first.found is not None and early.forces is not None and early.forces(program.forces(first.found)):
            return _read(program, 0 * program.cost, first.found, Status.ACCEPTED, first.factorisations)
    if not early.optimise:
        return _read(program, 0 * program.cost, 0 * program.bound, Status.NO_FORCES, first.factorisations)
    kkt = KktSolver(program)
    try:
        state = _start(program, kkt) if first.least is None else _start_at(program, kkt, first.least)
    except ArithmeticError:
        return _read(program, 0 * program.cost, 0 * program.bound, Status.STALLED, first.factorisations)
    answer = _iterate(program, kkt, early, state, correctors=BRIEF if early.brief else FINAL if early.sharp else 0)
    return replace(answer, iterations=first.factorisations + answer.iterations)


def _solve_inside(program: ConicProgram, early: EarlyEnd) -> Answer:
    """From inside the cones, with correctors of centrality; nothing is solved where there is no way inside."""
    assert early.inside is not None
    kkt = KktSolver(program)
    opening, factorisations = None, 0
    if not program.n_zeros and program.bounds is None:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            opening, factorisations = find_motion(program, kkt)
    if opening is None:
        return _read(program, 0 * program.cost, 0 * program.bound, Status.STALLED, factorisations)
    state = _start_inside(program, kkt, opening, early.inside)
    answer = _iterate(program, kkt, early, state, correctors=CORRECTORS, rough=True)
    return replace(answer, iterations=factorisations + answer.iterations)


def _read(program: ConicProgram, x: Floats, z: Floats, status: Status, iterations: int) -> Answer:
    slack = program.bound - program.matrix @ x + program.compliance * z if program.compliance else None
    return read_answer(program, x, z, status, iterations, "interior-point", slack)


def _iterate(
    program: ConicProgram, kkt: KktSolver, early: EarlyEnd, state: _State, *, correctors: int, rough: bool = False
) -> Answer:
    """Predictor and corrector until the answer is good, or gets no better.

    correctors : of centrality, at most so many a step; they pay where an iterate proves what is asked before the end.
    rough : what a solve leaves of equilibrium is balanced by who is told the iterates.
    """
    best, best_error, least, waited, asked = state, np.inf, np.inf, 0, ASK
    usual = QUADRATIC_TOLERANCE if program.is_quadratic else TOLERANCE
    tolerance, close = (SHARPEST, usual) if early.sharp else (usual, ALMOST)
    iteration = 0
    for iteration in range(MOST_ITERATIONS):
        rest = _residuals(program, kkt, state)
        status, error = _convergence(program, state, rest, tolerance)
        if status is not None:
            return _answer(program, state, status, iteration)
        if state.tau <= ROUNDING * max(state.kappa, ROUNDING):
            break
        if error < early.accuracy:
            return _answer(program, state, Status.ALMOST_SOLVED, iteration)
        if early.twist is not None and early.twist(program.twist(state.x / state.tau)):
            return _answer(program, state, Status.MECHANISM, iteration)
        if early.pair is not None and early.pair(*_pair(program, state)):
            return _answer(program, state, Status.ACCEPTED, iteration)
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
        lost = early.sharp and best_error < ALMOST and error > LOST * best_error
        if lost or waited > (PATIENCE if best_error > close else 2):
            break
        try:
            with np.errstate(over="raise", invalid="raise", divide="raise"):
                refined = ROUGH if rough else max(REFINED, min(FIRM * error, ROUGH))
                state = _step(program, kkt, state, rest, refined, correctors)
        except (ArithmeticError, np.linalg.LinAlgError):
            break
    near = Status.SOLVED if best_error < usual else Status.ALMOST_SOLVED
    return _answer(program, best, near if best_error < ALMOST else Status.STALLED, iteration)


def _answer(program: ConicProgram, state: _State, status: Status, iterations: int) -> Answer:
    scale = 1.0 if status.is_infeasible or status.is_stalled else state.tau
    return _read(program, state.x / scale, state.z / scale, status, iterations)


def _pair(program: ConicProgram, v: _State) -> tuple[Floats, Floats, float]:
    """Twist, forces and multiplier of an iterate."""
    return program.twist(v.x / v.tau), program.forces(v.z / v.tau), float(v.z[-1] / v.tau)


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


def _start_inside(program: ConicProgram, kkt: KktSolver, opening: Floats, force: Floats) -> _State:
    """A motion that opens every joint and forces that balance the cost, far enough apart for a gap of `FIRST_GAP`.

    Only the load of the multiplier is not balanced yet, and its work is not yet one.
    """
    cones, z = kkt.cones, program.multipliers(force)
    z[-1] = FIRST_MULTIPLIER
    z = cones.lifted(z, np.maximum(DEEP - cones.depths(z), 0.0))
    s = -(program.matrix @ opening)
    size = FIRST_GAP / _dot(s[:-1], z[:-1])
    s *= size
    mu = FIRST_GAP / cones.degree
    s[-1] = mu / FIRST_MULTIPLIER
    return _State(size * opening, s, z, 1.0, mu)


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


def _convergence(program: ConicProgram, v: _State, rest: _Residuals, tolerance: float) -> tuple[Status | None, float]:
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
    if max(errors) < tolerance:
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


#: The change of x, s, z, tau and kappa.
Direction = tuple[Floats, Floats, Floats, float, float]


class _Newton:
    """The directions at one iterate."""

    def __init__(self, program: ConicProgram, kkt: KktSolver, v: _State, rest: _Residuals, refined: float) -> None:
        self._kkt, self._v, self._rest = kkt, v, rest
        self.cones, curved = kkt.cones, rest.curved
        self.scaling = self.cones.scaling(v.s, v.z)
        # Proximal terms must not hold back what is large: W'W is s over z, and s is mu over z.
        length, force = (max(largest(part) / v.tau, 1.0) for part in (v.x, v.z))
        kkt.update(
            self.scaling,
            pull=PROXIMAL / length,
            shift=DUAL_PROXIMAL / min(force, LARGE) ** 2,
            refined=refined,
        )
        self.mean = self.scaling.apply(v.z)
        self.square = self.cones.product(self.mean, self.mean)
        self._slope = 2.0 * curved / v.tau + program.cost
        self._dual_slope = 2.0 * program.compliance / v.tau * v.z + program.bound
        bend_of_gap = (_dot(v.x, curved) + program.compliance * _dot(v.z, v.z)) / v.tau**2
        shift, affine = self._right(1.0, self.square)
        self._tau_pair, first = kkt.solve((-program.cost, program.bound), affine)
        x2, z2 = self._tau_pair
        self._below = _dot(self._slope, x2) + _dot(self._dual_slope, z2) - bend_of_gap - v.kappa / v.tau
        self.predictor = self._complete(1.0, shift, first, v.tau * v.kappa)

    def _right(self, share: float, bend: Floats) -> tuple[Floats, Pair]:
        """For residuals reduced to `share` and lambda o (W^-1 ds + W dz) = -bend."""
        shift = self.scaling.apply(self.cones.quotient(self.mean, bend))
        return shift, (-share * self._rest.dual, shift - share * self._rest.primal)

    def _complete(self, share: float, shift: Floats, one: Pair, turn: float) -> Direction:
        """The step, with tau kappa changed by -turn."""
        v, (x1, z1), (x2, z2) = self._v, one, self._tau_pair
        above = -share * self._rest.gap + turn / v.tau - _dot(self._slope, x1) - _dot(self._dual_slope, z1)
        d_tau = above / self._below
        dx, dz = x1 + d_tau * x2, z1 + d_tau * z2
        ds = -shift - self.scaling.squared(dz)
        return dx, ds, dz, d_tau, (-turn - v.kappa * d_tau) / v.tau

    def direction(self, share: float, bend: Floats, turn: float) -> Direction:
        """The step for another right-hand side."""
        shift, right = self._right(share, bend)
        (one,) = self._kkt.solve(right)
        return self._complete(share, shift, one, turn)

    def longest(self, d: Direction, left_out: float = 0.0) -> float:
        """The longest step inside the cones, at most 1, of all of them but a share."""
        v, (_, ds, dz, d_tau, d_kappa) = self._v, d
        steps = [-now / change for now, change in ((v.tau, d_tau), (v.kappa, d_kappa)) if change < 0]
        for start, change in ((v.s, ds), (v.z, dz)):
            own = self.cones.longest_steps(start, change)
            k = int(left_out * len(own))
            steps.append(float(np.partition(own, k)[k]) if k else float(own.min(initial=np.inf)))
        return min(1.0, *steps)

    def scaled(self, d: Direction) -> tuple[Floats, Floats]:
        """W^-1 ds and W dz."""
        return self.scaling.inverse(d[1]), self.scaling.apply(d[2])


def _step(
    program: ConicProgram, kkt: KktSolver, v: _State, rest: _Residuals, refined: float, correctors: int
) -> _State:
    """One predictor and corrector from an iterate, with solves as good as `refined`, and correctors of centrality."""
    newton = _Newton(program, kkt, v, rest, refined)
    unit, mu = newton.cones.unit, _complementarity(kkt, v)
    # A few cones that the predictor would leave say little of the rest, and correctors see to them.
    sigma = (1.0 - newton.longest(newton.predictor, FEW if correctors else 0.0)) ** 3
    ds, dz = newton.scaled(newton.predictor)
    bend = newton.square + newton.cones.product(ds, dz) - sigma * mu * unit
    turn = v.tau * v.kappa + newton.predictor[3] * newton.predictor[4] - sigma * mu
    best = newton.direction(1.0 - sigma, bend, turn)
    alpha = newton.longest(best)
    for _ in range(correctors):
        far = min(1.0, alpha + FURTHER)
        ds, dz = newton.scaled(best)
        product = newton.cones.product(newton.mean + far * ds, newton.mean + far * dz)
        bend = bend - newton.cones.towards(product, NEAR * sigma * mu, sigma * mu / NEAR)
        trial = newton.direction(1.0 - sigma, bend, turn)
        longer = newton.longest(trial)
        if longer > alpha:
            best = trial
        if longer < (1.0 + COST) * alpha:
            alpha = max(alpha, longer)
            break
        alpha = longer
    dx, ds, dz, d_tau, d_kappa = best
    alpha *= STEP
    return _State(
        v.x + alpha * dx, v.s + alpha * ds, v.z + alpha * dz, v.tau + alpha * d_tau, v.kappa + alpha * d_kappa
    )
