"""The dual programs through Clarabel: the fast path."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.planar import Plane
from blockstat.polyhedron import Floats
from blockstat.program import PenaltyProgram
from blockstat.solve.certificate import opening_room, power
from blockstat.solve.raw import RawSolution

#: Looser settings have given energies 8 % wrong under the status "Solved".
TOLERANCE = 1e-10
MAX_ITERATIONS = 200
#: Joints open by more than this many violations need no watching when a mechanism is mended.
WIDE_OPEN = 1e3
#: A point with a cap that closes faster than this fraction of the fastest joint crushes or yields.
YIELDS = 1e-6


@dataclass(frozen=True, eq=False)
class DualAnswer:
    """An answer to one of the dual programs; nothing in it is trusted."""

    twist: Floats  #: u, shape (6 n,)
    force: Floats  #: multipliers of the cones as forces, shape (m, 3)
    multiplier: float  #: lambda of A f + w + lambda l = 0 when a load was pinned, else 0
    status: str
    iterations: int
    crushing: Floats  #: y, the closing that caps allow, shape (m,)


def solve(program: PenaltyProgram) -> RawSolution:
    """Minimise 1/2 ||E' A' u||^2 - w' u over twists with A' u in K*; at points with a cap, 1/2 |g_n + y|^2."""
    opening = program.opening
    hessian = sparse.csc_array(sparse.triu(opening @ opening.T))
    answer = solve_dual(program, -program.load, hessian=hessian, penalty=True)
    return RawSolution(
        force=answer.force,
        adhesion=np.maximum(opening.T @ answer.twist + answer.crushing[: program.n_points], 0.0),
        twist=answer.twist,
        bounded="DualInfeasible" not in answer.status,
        status=answer.status,
        iterations=answer.iterations,
    )


def solve_margin(program: PenaltyProgram) -> RawSolution:
    """The least adhesion tau, the same at every point, that lets an equilibrium exist; at least -1.

    Primal: min tau subject to A f + w = 0, f_i + tau n in K, tau >= -1. Dual: max w' u + sum g_n - 1
    subject to A' u in K*, sum g_n <= 1. The penalty program is quadratic, so near the limit its answer is
    good to the square root of the tolerance; this one is linear and good to the tolerance itself. It costs a
    second solve, so it is asked only where the first could not prove either side.
    """
    total = np.asarray(program.opening.sum(axis=1)).reshape(-1)
    answer = solve_dual(program, -program.load - total, capped=total)
    tau = float(power(program, answer.twist)[0] + total @ answer.twist - 1.0)
    force = answer.force.copy()
    force[: program.n_points, 0] -= tau
    adhesion = np.full(program.n_points, max(tau, 0.0))
    return RawSolution(force, adhesion, answer.twist, bounded=True, status=answer.status, iterations=answer.iterations)


def open_joints(program: PenaltyProgram, twist: Floats) -> Floats:
    """A twist next to the given one under which no joint closes at all.

    With eps the largest violation of A' u in K*, looks for the least d with A' (u / eps + d) in K* + n and
    returns u + eps d. The solver's error is then relative to eps and not to u. Returns u itself when there is
    nothing to mend or, in jammed assemblies, no such d.
    """
    gap_rate = (program.matrix.T @ twist).reshape(-1, 3)
    room = opening_room(gap_rate, program.friction)
    # Points that crush or bonds that yield may go on closing; those that close by an error are mended.
    room[program.capped[room[program.capped] < -YIELDS * np.abs(gap_rate).max(initial=0.0)]] = np.inf
    worst = -float(room.min(initial=0.0))
    if worst <= 0:
        return twist
    offset = np.zeros_like(gap_rate)
    sticky = np.isinf(program.friction)
    offset[:, 0] = np.minimum(np.where(sticky & np.isfinite(room), gap_rate[:, 0], room) / worst, WIDE_OPEN) - 1.0
    offset[sticky, 1:] = gap_rate[sticky, 1:] / worst
    identity = sparse.csc_array(sparse.eye_array(len(twist)))
    answer = solve_dual(program, np.zeros(len(twist)), hessian=identity, offset=offset.reshape(-1))
    return twist + worst * answer.twist if "Infeasible" not in answer.status else twist


def solve_dual(
    program: PenaltyProgram,
    cost: Floats,
    *,
    hessian: sparse.csc_array | None = None,
    offset: Floats | None = None,
    capped: Floats | None = None,
    pinned: Floats | None = None,
    penalty: bool = False,
) -> DualAnswer:
    """Minimise 1/2 u' H u + cost' u subject to A' u + offset in K*, capped' u <= 1 and pinned' u = 1.

    hessian : upper triangle of H. offset : shape (3 m,). capped, pinned : shape (6 n,). penalty : whether H is that of
    the penalty program, for which the closing y at a cap counts as well.
    """
    if hessian is None:
        hessian = sparse.csc_array((len(cost), len(cost)))
    plane = program.plane
    slips = bool(np.isfinite(program.friction).all())
    if plane is not None and slips and offset is None and plane.holds(cost, capped, pinned):
        return _solve_in_plane(program, plane, cost, hessian, capped, pinned)
    rows, cones, scale = _dual_cones(program)
    constraint = -(sparse.diags_array(scale) @ program.matrix.T.tocsr()[rows])
    bound = np.zeros(len(rows)) if offset is None else scale * offset[rows]
    price = np.concatenate([program.cap[program.capped], -program.floor[program.floored]])
    if len(price):
        constraint, bound, cones = _with_limits(program, constraint, bound, cones, rows, scale)
        cost = np.concatenate([cost, price])
        capped, pinned = (None if row is None else np.concatenate([row, 0 * price]) for row in (capped, pinned))
        hessian = _with_crushing(program, hessian, len(price), penalty)
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


def _solve_in_plane(
    program: PenaltyProgram,
    plane: Plane,
    cost: Floats,
    hessian: sparse.csc_array,
    capped: Floats | None,
    pinned: Floats | None,
) -> DualAnswer:
    """The same program with planar twists; each cone is two half-planes, g_n + mu g_t >= 0 and g_n - mu g_t >= 0."""
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
    answer, multipliers = _clarabel(
        small,
        fold @ cost,
        constraint,
        np.zeros(constraint.shape[0]),
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
