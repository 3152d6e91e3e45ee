"""A primal-dual interior-point method for the programs of rigid blocks: min 1/2 x'P x + q'x, M x + s = b, s in a cone.

The homogeneous embedding of Goulart & Chen (Clarabel, 2024; after Andersen, Ye and Nesterov), with Nesterov-Todd
scaling and Mehrotra's predictor and corrector. All cones have dimension 3 or 1 and are handled in a batch (`cones`),
and each iteration factors one matrix with the pattern of the contact graph (`normal`), M' W^-2 M + P. The normal
equations lose digits as the cones close, so every solve is refined on the whole system.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from blockstat.polyhedron import Floats, Ints
from blockstat.solve.cones import Cones, Scaling
from blockstat.solve.normal import BlockNormal, borrowed

MOST_ITERATIONS = 100
TOLERANCE = 1e-10
#: Where the iteration stalls, an answer this good is still handed on; our own certificates judge it.
ALMOST = 1e-6
STEP = 0.99
MOST_REFINEMENTS = 3
#: Refinement stops when the residual is this small relative to the right-hand side, or stops shrinking.
REFINED = 1e-8


@dataclass(frozen=True, eq=False)
class ConicProgram:
    """One program. Its rows come in the order of the cones: triples, half-lines of two blocks, then bordering rows."""

    cost: Floats  #: q, shape (n,)
    matrix: sparse.csr_array  #: M, shape (n_rows, n)
    bound: Floats  #: b, shape (n_rows,)
    cones: Cones
    local: Floats  #: entries of the rows of two blocks in the columns of a and b, shape (n_local, 2 width)
    pair: Ints  #: blocks of these rows and then of those of `penalty`, -1 for a support
    n_blocks: int
    width: int  #: unknowns a block
    penalty: sparse.csr_array  #: Q with P = Q'Q, shape (n_penalty, n)
    penalty_local: Floats  #: its entries, shape (n_penalty, 2 width)
    ridge: float = 0.0  #: P = Q'Q + ridge I

    @property
    def curved(self) -> bool:
        return len(self.penalty_local) > 0 or self.ridge > 0


@dataclass(frozen=True, eq=False)
class ConicAnswer:
    """Where the iteration ended; nothing in it is trusted."""

    x: Floats
    z: Floats  #: multipliers of the rows
    status: str  #: "Solved", "AlmostSolved", "PrimalInfeasible", "DualInfeasible" or "Stalled"
    iterations: int


_Pair = tuple[Floats, Floats]


class _Kkt:
    """The system [P M'; M -W'W] of one scaling."""

    def __init__(self, program: ConicProgram, normal: BlockNormal) -> None:
        self._p, self._normal = program, normal
        self._transposed = sparse.csr_array(program.matrix.T)
        self._penalty_t = sparse.csr_array(program.penalty.T)
        self._border = program.matrix[len(program.local) :].toarray()
        self._scaling: Scaling | None = None

    def hessian(self, x: Floats) -> Floats:
        return self._penalty_t @ (self._p.penalty @ x) + self._p.ridge * x

    def transposed(self, z: Floats) -> Floats:
        return self._transposed @ z

    def update(self, scaling: Scaling) -> None:
        """Factor for another scaling."""
        program, cones = self._p, self._p.cones
        self._scaling = scaling
        triples = program.local[: 3 * cones.n_soc].reshape(3, -1, program.local.shape[1])
        halves = program.local[3 * cones.n_soc :]
        inner = scaling.half[: len(halves)]
        rows = [scaling.inverse_rows(triples).reshape(-1, program.local.shape[1]), halves / inner[:, None]]
        self._normal.update(np.concatenate([*rows, program.penalty_local]), program.ridge)
        self._held = np.empty((0, 0))
        if len(self._border):
            scaled = self._border / scaling.half[len(halves) :][:, None]
            self._border_scaled = scaled
            self._border_solved = self._normal.factor.solve(np.asfortranarray(scaled.T)).reshape(-1, len(scaled))
            self._held = np.eye(len(scaled)) + scaled @ self._border_solved

    def _solve_normal(self, right: list[Floats]) -> list[Floats]:
        """S^-1 of several vectors at once, which costs little more than of one."""
        x = self._normal.factor.solve(np.column_stack(right)) if len(right) > 1 else self._normal.factor.solve(right[0])
        x = x.reshape(len(right[0]), -1)
        if len(self._border):
            x = x - self._border_solved @ np.linalg.solve(self._held, self._border_scaled @ x)
        return [np.ascontiguousarray(column) for column in x.T]

    def _once(self, right: list[_Pair]) -> list[_Pair]:
        scaling = self._scaling
        assert scaling is not None
        x = self._solve_normal([top + self.transposed(scaling.inverse_squared(bottom)) for top, bottom in right])
        return [
            (own, scaling.inverse_squared(self._p.matrix @ own - bottom))
            for own, (_, bottom) in zip(x, right, strict=True)
        ]

    def _residual(self, right: _Pair, found: _Pair) -> _Pair:
        assert self._scaling is not None
        (top, bottom), (x, z) = right, found
        upper = top - self.hessian(x) - self.transposed(z)
        return upper, bottom - self._p.matrix @ x + self._scaling.squared(z)

    def solve(self, *right: _Pair) -> list[_Pair]:
        """Solve for right-hand sides (top, bottom), refined on the whole system."""
        found = self._once(list(right))
        size = np.inf
        for _ in range(MOST_REFINEMENTS):
            rest = [self._residual(given, answer) for given, answer in zip(right, found, strict=True)]
            now = max(_size(*left) / max(_size(*given), 1e-300) for left, given in zip(rest, right, strict=True))
            if now <= REFINED or not now < 0.5 * size:
                break
            size = now
            change = self._once(rest)
            found = [(x + dx, z + dz) for (x, z), (dx, dz) in zip(found, change, strict=True)]
        return found


def _size(*vectors: Floats) -> float:
    """Largest magnitude in some vectors."""
    return max(float(np.abs(vector).max(initial=0.0)) for vector in vectors)


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


def solve(program: ConicProgram) -> ConicAnswer:
    """Solve a program."""
    with borrowed(program.pair, program.n_blocks, program.width) as normal:
        return _iterate(program, _Kkt(program, normal))


def _iterate(program: ConicProgram, kkt: _Kkt) -> ConicAnswer:
    """Predictor and corrector until the answer is good, or gets no better."""
    try:
        state = _start(program, kkt)
    except ArithmeticError as error:
        return ConicAnswer(0 * program.cost, 0 * program.bound, f"Stalled: {error}", 0)
    best, best_error, waited = state, np.inf, 0
    iteration = 0
    for iteration in range(MOST_ITERATIONS):
        status, error = _judge(program, kkt, state)
        if status:
            return _answer(state, status, iteration)
        waited = 0 if error < 0.9 * best_error else waited + 1
        if error < best_error:
            best, best_error = state, error
        if waited > 8:
            break
        try:
            with np.errstate(over="raise", invalid="raise", divide="raise"):
                state = _step(program, kkt, state)
        except (ArithmeticError, np.linalg.LinAlgError):
            break
    return _answer(best, "AlmostSolved" if best_error < ALMOST else "Stalled", iteration)


def _answer(state: _State, status: str, iterations: int) -> ConicAnswer:
    scale = state.tau if "Solved" in status else 1.0
    return ConicAnswer(state.x / scale, state.z / scale, status, iterations)


def _start(program: ConicProgram, kkt: _Kkt) -> _State:
    """The minimisers of the two least-squares problems, moved inside the cones (Vandenberghe 2010, section 5.3)."""
    cones = program.cones
    ones = Scaling(cones, np.tile([[1.0], [0.0], [0.0]], cones.n_soc), np.ones(cones.n_soc), np.ones(cones.n_half))
    kkt.update(ones)
    if program.curved:
        ((x, z),) = kkt.solve((-program.cost, program.bound))
        s = -z
    else:
        (x, s), (_, z) = kkt.solve((0 * program.cost, program.bound), (-program.cost, 0 * program.bound))
        s = -s

    def inside(vector: Floats) -> Floats:
        depth = cones.depth(vector)
        return vector if depth > 1e-4 else vector + (1.0 - depth) * cones.unit

    return _State(x, inside(s), inside(z), 1.0, 1.0)


def _residuals(program: ConicProgram, kkt: _Kkt, v: _State) -> tuple[Floats, Floats, float, Floats]:
    """Residuals of the embedding, and P x."""
    curved = kkt.hessian(v.x)
    dual = curved + kkt.transposed(v.z) + program.cost * v.tau
    primal = program.matrix @ v.x + v.s - program.bound * v.tau
    gap = _dot(v.x, curved) / v.tau + _dot(program.cost, v.x) + _dot(program.bound, v.z) + v.kappa
    return dual, primal, gap, curved


def _judge(program: ConicProgram, kkt: _Kkt, v: _State) -> tuple[str, float]:
    """The status if it is time to stop, and the largest relative error of the candidate answer."""

    dual, primal, _, curved = _residuals(program, kkt, v)
    quadratic, linear, bound = _dot(v.x, curved) / v.tau**2, _dot(program.cost, v.x), _dot(program.bound, v.z)
    value, other = quadratic / 2 + linear / v.tau, -quadratic / 2 - bound / v.tau
    errors = (
        _size(primal) / v.tau / max(1.0, _size(program.bound) + (_size(v.x) + _size(v.s)) / v.tau),
        _size(dual) / v.tau / max(1.0, _size(program.cost) + (_size(v.x) + _size(v.z)) / v.tau),
        abs(value - other) / max(1.0, min(abs(value), abs(other))),
    )
    if max(errors) < TOLERANCE:
        return "Solved", max(errors)
    pulled = kkt.transposed(v.z)
    if bound < 0 and _size(pulled) < TOLERANCE * max(1.0, _size(v.x) + _size(v.z)) * -bound:
        return "PrimalInfeasible", max(errors)
    if linear < 0:
        ray = max(_size(curved), _size(program.matrix @ v.x + v.s))
        if ray < TOLERANCE * max(1.0, _size(v.x) + _size(v.s)) * -linear:
            return "DualInfeasible", max(errors)
    return "", max(errors)


def _step(program: ConicProgram, kkt: _Kkt, v: _State) -> _State:
    """One predictor and corrector."""
    cones = program.cones
    dual, primal, gap, curved = _residuals(program, kkt, v)
    scaling = cones.scaling(v.s, v.z)
    kkt.update(scaling)
    mean = scaling.apply(v.z)
    mu = (_dot(v.s, v.z) + v.tau * v.kappa) / (cones.degree + 1)
    xi = v.x / v.tau
    slope = 2.0 * curved / v.tau + program.cost
    square = cones.product(mean, mean)

    def right(share: float, bend: Floats) -> tuple[Floats, _Pair]:
        """For residuals reduced to `share` and lambda o (W^-1 ds + W dz) = -bend."""
        shift = scaling.apply(cones.quotient(mean, bend))
        return shift, (-share * dual, -share * primal + shift)

    shift, affine = right(1.0, square)
    (x2, z2), first = kkt.solve((-program.cost, program.bound), affine)
    below = _dot(slope, x2) + _dot(program.bound, z2) - _dot(xi, curved) / v.tau - v.kappa / v.tau

    def direction(share: float, shift: Floats, one: _Pair, turn: float) -> tuple[Floats, Floats, Floats, float, float]:
        """The step, with tau kappa changed by -turn."""
        x1, z1 = one
        above = -share * gap + turn / v.tau - _dot(slope, x1) - _dot(program.bound, z1)
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
