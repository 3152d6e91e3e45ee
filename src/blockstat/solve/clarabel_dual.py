"""The dual programs through Clarabel: every program that there is, fast when it is small."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.program.penalty import PenaltyProgram
from blockstat.program.planar import Plane
from blockstat.solve.answer import DualAnswer, DualProgram
from blockstat.typing import Floats

#: Looser settings have given energies 8 % wrong under the status "Solved".
TOLERANCE = 1e-10
MAX_ITERATIONS = 200


def solve_dual(problem: DualProgram) -> DualAnswer:
    """Solve a dual program, in the plane when it is planar."""
    program, cost, offset = problem.program, problem.cost, problem.offset
    capped, pinned = problem.capped, problem.pinned
    hessian = _hessian(problem)
    if problem.plane is not None:
        return _solve_in_plane(problem, problem.plane, hessian)
    rows, cones, scale = _dual_cones(program)
    constraint = -(sparse.diags_array(scale) @ program.matrix.T.tocsr()[rows])
    bound = np.zeros(len(rows)) if offset is None else scale * offset[rows]
    price = problem.price
    if len(price):
        constraint, bound, cones = _with_limits(program, constraint, bound, cones, rows, scale)
        cost = np.concatenate([cost, price])
        capped = None if capped is None else np.concatenate([capped, problem.earned])
        pinned = None if pinned is None else np.concatenate([pinned, 0 * price])
        hessian = _with_crushing(program, hessian, len(price), problem.penalty)
    answer, multipliers = _clarabel(hessian, cost, constraint, bound, cones, capped, pinned)
    force = np.zeros(3 * len(program.friction))
    force[rows] = scale * multipliers[: len(rows)]
    crushing = np.zeros(len(program.friction))
    size = len(program.load)
    crushing[program.capped] = np.array(answer.x)[size : size + len(program.capped)]
    return DualAnswer(
        twist=np.array(answer.x)[:size],
        force=force.reshape(-1, 3),
        multiplier=0.0 if pinned is None else -float(multipliers[-1]),
        status=str(answer.status),
        iterations=int(answer.iterations),
        crushing=crushing,
        solver="clarabel",
    )


def _with_crushing(program: PenaltyProgram, hessian: Any, extra: int, penalty: bool) -> sparse.csc_array:
    """The Hessian over (u, y, z): of 1/2 |E'(A' u + y)|^2 for the penalty program, else nothing for y and z."""
    own = program.capped[program.capped < program.n_points] if penalty else program.capped[:0]
    shape = (program.n_points, extra)
    heads = sparse.csr_array((np.ones(len(own)), (own, np.arange(len(own)))), shape=shape)
    corner = sparse.csc_array(heads.T @ heads)
    return sparse.csc_array(sparse.block_array([[hessian, program.opening @ heads], [None, corner]]))


def _with_limits(
    program: PenaltyProgram, constraint: Any, bound: Floats, cones: list, rows: np.ndarray, scale: Floats
) -> tuple[Any, Floats, list]:
    """Add the unknowns y, z >= 0 of the caps and floors, g + (y - z) n in K*, to the constraint."""
    clarabel: Any = importlib.import_module("clarabel")
    place = np.empty(3 * len(program.friction), dtype=np.int64)
    place[rows] = np.arange(len(rows))
    points = np.concatenate([program.capped, program.floored])
    sign = np.repeat([-1.0, 1.0], [len(program.capped), len(program.floored)])
    head = place[3 * points]
    extra = sparse.csr_array((sign * scale[head], (head, np.arange(len(points)))), shape=(len(rows), len(points)))
    lower = sparse.hstack([sparse.csr_array((len(points), constraint.shape[1])), -sparse.eye_array(len(points))])
    full = sparse.csr_array(sparse.vstack([sparse.hstack([constraint, extra]), lower]))
    return full, np.concatenate([bound, np.zeros(len(points))]), [*cones, clarabel.NonnegativeConeT(len(points))]


def _hessian(problem: DualProgram) -> sparse.csc_array:
    """Upper triangle of P."""
    size = len(problem.cost)
    if problem.penalty:
        opening = problem.program.opening
        return sparse.csc_array(sparse.triu(opening @ opening.T))
    return sparse.csc_array(sparse.eye_array(size)) if problem.least_norm else sparse.csc_array((size, size))


def _solve_in_plane(problem: DualProgram, plane: Plane, hessian: sparse.csc_array) -> DualAnswer:
    """The same program with planar twists; each cone is two half-planes, g_n + mu g_t >= 0 and g_n - mu g_t >= 0."""
    program, capped, pinned = problem.program, problem.capped, problem.pinned
    clarabel: Any = importlib.import_module("clarabel")
    fold = plane.unfold.T
    normal, along = plane.rates(program.matrix)
    mu = program.friction[plane.first]
    scale = 1.0 / np.maximum(mu, 1.0)
    one = sparse.diags_array(scale) @ (normal + sparse.diags_array(mu) @ along)
    two = sparse.diags_array(scale) @ (normal - sparse.diags_array(mu) @ along)
    cones = [clarabel.NonnegativeConeT(2 * len(mu))]
    constraint: Any = sparse.csr_array(sparse.vstack([-one, -two]))
    full = hessian + hessian.T - sparse.diags_array(hessian.diagonal())
    small = sparse.csc_array(sparse.triu(fold @ full @ plane.unfold))
    bound = np.zeros(constraint.shape[0])
    if problem.offset is not None:
        head, tangent = plane.offsets(problem.offset)
        bound = np.concatenate([scale * (head + mu * tangent), scale * (head - mu * tangent)])
    answer, multipliers = _clarabel(
        small,
        fold @ problem.cost,
        constraint,
        bound,
        cones,
        None if capped is None else fold @ capped,
        None if pinned is None else fold @ pinned,
    )
    p = len(mu)
    plus, minus = scale * multipliers[:p], scale * multipliers[p : 2 * p]
    return DualAnswer(
        twist=plane.unfold @ np.array(answer.x),
        force=plane.unfold_forces(plus + minus, mu * (plus - minus), len(program.friction)),
        multiplier=0.0 if pinned is None else -float(multipliers[-1]),
        status=str(answer.status),
        iterations=int(answer.iterations),
        crushing=np.zeros(len(program.friction)),
        solver="clarabel",
    )


def _clarabel(
    hessian: sparse.csc_array,
    cost: Floats,
    constraint: sparse.csr_array,
    bound: Floats,
    cones: list,
    capped: Floats | None,
    pinned: Floats | None,
) -> tuple[Any, Floats]:
    """Run Clarabel with the rows capped' u <= 1 and pinned' u = 1 below the cones: its answer and all multipliers."""
    clarabel: Any = importlib.import_module("clarabel")
    blocks, bounds = [constraint], [bound]
    for vector, cone in ((capped, clarabel.NonnegativeConeT(1)), (pinned, clarabel.ZeroConeT(1))):
        if vector is not None:
            blocks.append(sparse.csr_array(vector[None, :]))
            bounds.append(np.ones(1))
            cones = [*cones, cone]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.direct_solve_method = "qdldl"  # five times faster here than the multithreaded default
    settings.max_iter = MAX_ITERATIONS
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    matrix = sparse.csc_array(sparse.vstack(blocks))
    answer = clarabel.DefaultSolver(hessian, cost, matrix, np.concatenate(bounds), cones, settings).solve()
    return answer, np.array(answer.z)


def _dual_cones(program: PenaltyProgram) -> tuple[np.ndarray, list, Floats]:
    """Order of the rows of A', the cones of K* over them, and the factor of each row.

    A point with friction is a second-order cone (g_n / mu, g_1, g_2), times mu where that is below 1. Without
    friction only g_n >= 0 is left; with infinite friction g_n >= 0 and g_t = 0.
    """
    clarabel: Any = importlib.import_module("clarabel")
    mu = program.friction
    none, sticky = np.flatnonzero(mu == 0), np.flatnonzero(np.isinf(mu))
    coulomb = np.flatnonzero((mu > 0) & np.isfinite(mu))
    rows, scale, cones = [], [], []
    if len(coulomb):
        rows.append((3 * coulomb[:, None] + np.arange(3)).reshape(-1))
        slip = np.minimum(mu[coulomb], 1.0)
        scale.append(np.column_stack([slip / mu[coulomb], slip, slip]).reshape(-1))
        cones += [clarabel.SecondOrderConeT(3)] * len(coulomb)
    halfspace = np.concatenate([none, sticky])
    if len(halfspace):
        rows.append(3 * halfspace)
        cones.append(clarabel.NonnegativeConeT(len(halfspace)))
    if len(sticky):
        rows.append((3 * sticky[:, None] + np.arange(1, 3)).reshape(-1))
        cones.append(clarabel.ZeroConeT(2 * len(sticky)))
    rows = np.concatenate(rows)
    given = np.concatenate(scale) if scale else np.empty(0)
    return rows, cones, np.concatenate([given, np.ones(len(rows) - len(given))])
