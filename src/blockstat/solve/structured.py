"""The dual programs of rigid blocks in the form of the structured interior-point method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import sparse

from blockstat.program.penalty import PenaltyProgram
from blockstat.program.planar import Plane
from blockstat.solve.answer import OPTIMUM, DualAnswer, DualProgram, Enough
from blockstat.solve.cones import Cones
from blockstat.solve.interior_point import AT_THE_OPTIMUM, ConicAnswer, Early, solve
from blockstat.solve.kkt import ConicProgram, Limits
from blockstat.solve.load_path import resting_forces
from blockstat.typing import Floats, Ints


def fits(problem: DualProgram) -> bool:
    """Whether the method knows all that is in a program: caps and floors only where there is Coulomb friction."""
    program = problem.program
    limited = program.friction[np.concatenate([program.capped, program.floored])]
    return bool((limited > 0).all() and np.isfinite(limited).all())


def solve_dual(problem: DualProgram, enough: Enough = OPTIMUM) -> DualAnswer:
    """Solve a dual program, in the plane when it is planar."""
    plane = problem.plane
    return _solve_in_plane(problem, plane, enough) if plane is not None else _solve_in_space(problem, enough)


def _solve_in_space(problem: DualProgram, enough: Enough) -> DualAnswer:
    """Each point is a cone (g_n / mu, g_1, g_2), or where friction is nothing or endless g_n >= 0 and g_t = 0."""
    program = problem.program
    mu = program.friction
    rough = np.flatnonzero((mu > 0) & np.isfinite(mu))
    sticky, plain = np.flatnonzero(np.isinf(mu)), np.flatnonzero((mu == 0) | np.isinf(mu))
    slip = np.minimum(mu[rough], 1.0)
    size = np.ones((len(mu), 3))
    size[rough] = np.column_stack([slip / mu[rough], slip, slip])
    single = np.concatenate([3 * sticky + 1, 3 * sticky + 2, 3 * plain])
    rows = np.concatenate([*(3 * rough + k for k in range(3)), single])
    grouped = np.concatenate([(3 * rough[:, None] + np.arange(3)).reshape(-1), single])
    scale = size.reshape(-1)[rows]
    matrix = program.matrix.T.tocsr()[rows]
    matrix.data *= -np.repeat(scale, np.diff(matrix.indptr))
    offset = np.zeros(len(rows)) if problem.offset is None else scale * problem.offset[rows]

    def forces(z: Floats) -> Floats:
        force = np.zeros(3 * len(mu))
        force[rows] = scale * z[: len(rows)]
        return force.reshape(-1, 3)

    def twist(x: Floats) -> Floats:
        return x[: len(program.load)]

    answer = _solve(
        problem,
        matrix,
        offset,
        Cones(len(rough), 2 * len(sticky), len(plain)),
        program.point_blocks[grouped // 3],
        size.reshape(-1, 1)[grouped] * program.local[grouped],
        (
            sparse.csr_array(program.opening.T),
            program.local[: 3 * program.n_points : 3],
            program.point_blocks[: program.n_points],
        ),
        None,
        _limits(program, rough, slip / mu[rough]),
        _early(enough, forces, twist, lambda force: force.reshape(-1)[rows] / scale, program),
    )
    return _answer(problem, answer, twist(answer.x), forces(answer.z))


def _early(
    enough: Enough,
    forces: Callable[[Floats], Floats],
    twist: Callable[[Floats], Floats],
    multipliers: Callable[[Floats], Floats],
    program: PenaltyProgram,
) -> Early:
    """What may end the solve, asked of forces and twists made from the method's own unknowns."""
    start = None
    if enough.approach:
        resting = resting_forces(program)
        start = multipliers(np.column_stack([resting, 0 * resting, 0 * resting]))
    return Early(
        None if enough.forces is None else lambda z, ask=enough.forces: ask(forces(z)),
        None if enough.twist is None else lambda x, ask=enough.twist: ask(twist(x)),
        approach=enough.approach,
        brief=enough.brief,
        start=start,
        optimise=enough.optimise,
    )


def _limits(program: PenaltyProgram, rough: Ints, head: Floats) -> Limits | None:
    """The caps and floors of points, whose triples are those of the points `rough`."""
    points = np.union1d(program.capped, program.floored)
    if not len(points):
        return None
    triple = np.searchsorted(rough, points)
    y, z = (np.full(len(points), -1) for _ in range(2))
    y[np.searchsorted(points, program.capped)] = np.arange(len(program.capped))
    z[np.searchsorted(points, program.floored)] = len(program.capped) + np.arange(len(program.floored))
    return Limits(triple, head[triple], np.where(points < program.n_points, points, -1), y, z)


def _solve_in_plane(problem: DualProgram, plane: Plane, enough: Enough) -> DualAnswer:
    """Each pair of points is two half-planes, g_n + mu g_t >= 0 and g_n - mu g_t >= 0."""
    program = problem.program
    normal, along = plane.rates(program.matrix)
    mu = program.friction[plane.first]
    scale = 1.0 / np.maximum(mu, 1.0)
    sideways = sparse.diags_array(mu) @ along
    matrix = sparse.csr_array(
        sparse.diags_array(np.tile(-scale, 2)) @ sparse.vstack([normal + sideways, normal - sideways])
    )
    offset = np.zeros(2 * len(mu))
    if problem.offset is not None:
        head, tangent = plane.offsets(problem.offset)
        offset = np.concatenate([scale * (head + mu * tangent), scale * (head - mu * tangent)])
    blocks = program.point_blocks[plane.first]
    head, tangent = program.planar_local
    tangent = mu[:, None] * tangent
    local = np.tile(scale, 2)[:, None] * np.concatenate([head + tangent, head - tangent])
    # Two points a pair, so the penalty on a pair counts twice.
    opening = (sparse.csr_array(np.sqrt(2.0) * normal), np.sqrt(2.0) * head, blocks)

    def forces(z: Floats) -> Floats:
        plus, minus = scale * z[: len(mu)], scale * z[len(mu) : 2 * len(mu)]
        return plane.unfold_forces(plus + minus, mu * (plus - minus), len(program.friction))

    pair = np.tile(blocks, (2, 1))

    def twist(x: Floats) -> Floats:
        return plane.unfold @ x

    def multipliers(force: Floats) -> Floats:
        normal, along = plane.fold_forces(force)
        sideways = along / np.where(mu > 0, mu, 1.0)
        return np.concatenate([normal + sideways, normal - sideways]) / (2.0 * np.tile(scale, 2))

    early = _early(enough, forces, twist, multipliers, program)
    answer = _solve(problem, matrix, offset, Cones(0, 0, len(offset)), pair, local, opening, plane, early=early)
    return _answer(problem, answer, twist(answer.x), forces(answer.z))


def _solve(
    problem: DualProgram,
    matrix: sparse.csr_array,
    offset: Floats,
    cones: Cones,
    pair: Ints,
    local: Floats,
    opening: tuple[sparse.csr_array, Floats, Ints],
    plane: Plane | None,
    limits: Limits | None = None,
    early: Early = AT_THE_OPTIMUM,
) -> ConicAnswer:
    """Solve with offset - matrix x in the cones, the half-lines of the limits and the bordering rows below them."""
    width = 6 if plane is None else 3
    n_blocks = len(problem.program.load) // 6
    size = width * n_blocks

    def folded(vector: Floats) -> Floats:
        return vector if plane is None else plane.unfold.T @ vector

    border, bounds = [], []
    for vector, sign in ((problem.capped, 1.0), (problem.pinned, -1.0)):
        if vector is not None:
            # A load does as little work as it can, so l'u = 1 may be relaxed to l'u >= 1.
            border.append(sparse.csr_array(sign * folded(vector)[None, :]))
            bounds.append(sign)
    penalty, penalty_local, owners = opening
    if not problem.penalty:
        penalty, penalty_local, owners = sparse.csr_array((0, size)), penalty_local[:0], owners[:0]
    program = ConicProgram(
        cost=folded(problem.cost),
        matrix=sparse.csr_array(sparse.vstack([matrix, *border])) if border else matrix,
        bound=np.concatenate([offset, bounds]),
        cones=Cones(cones.n_soc, cones.n_zero, cones.n_half + len(bounds)),
        local=local,
        pair=np.concatenate([pair, owners]),
        n_blocks=n_blocks,
        width=width,
        penalty=penalty,
        penalty_local=penalty_local,
        ridge=1.0 if problem.least_norm else 0.0,
        compliance=problem.compliance,
    )
    if limits is not None:
        program = _with_limits(problem, program, limits)
    if early.start is not None:  # half-lines of the limits begin at nothing
        early = replace(early, start=np.pad(early.start, (0, len(program.bound) - len(early.start))))
    return solve(program, early)


def _with_limits(problem: DualProgram, program: ConicProgram, limits: Limits) -> ConicProgram:
    """Append the unknowns y and z, their columns in the triples and in the penalty, and their half-lines."""
    n_rows, n_penalty, n_local = len(program.bound), len(program.penalty_local), len(program.local)
    has_y, has_z = limits.y >= 0, limits.z >= 0
    values = np.concatenate([-limits.head[has_y], limits.head[has_z]])
    rows, places = (
        np.concatenate([limits.triple[has_y], limits.triple[has_z]]),
        np.append(limits.y[has_y], limits.z[has_z]),
    )
    if problem.capped is not None:
        values = np.concatenate([values, problem.earned])
        rows = np.concatenate([rows, np.full(limits.size, n_local)])
        places = np.concatenate([places, np.arange(limits.size)])
    heads = sparse.csr_array((values, (rows, places)), shape=(n_rows, limits.size))
    bent = has_y & (limits.penalty >= 0) & (n_penalty > 0)
    ones = (np.ones(bent.sum()), (limits.penalty[bent], limits.y[bent]))
    matrix = sparse.csr_array(sparse.hstack([program.matrix, heads]))
    own = sparse.hstack([sparse.csr_array((limits.size, len(program.cost))), -sparse.eye_array(limits.size)])
    cones = program.cones
    return replace(
        program,
        cost=np.concatenate([program.cost, problem.price]),
        matrix=sparse.csr_array(sparse.vstack([matrix[:n_local], own, matrix[n_local:]])),
        bound=np.insert(program.bound, n_local, np.zeros(limits.size)),
        cones=Cones(cones.n_soc, cones.n_zero, cones.n_half + limits.size),
        pair=np.concatenate([program.pair, np.repeat(program.pair[3 * limits.triple], 4, axis=0)]),
        penalty=sparse.csr_array(
            sparse.hstack([program.penalty, sparse.csr_array(ones, shape=(n_penalty, limits.size))])
        ),
        limits=limits,
    )


def _answer(problem: DualProgram, answer: ConicAnswer, twist: Floats, force: Floats) -> DualAnswer:
    program = problem.program
    crushing = np.zeros(len(program.friction))
    crushing[program.capped] = answer.x[len(program.load) :][: len(program.capped)]
    return DualAnswer(
        twist=twist,
        force=force,
        multiplier=0.0 if problem.pinned is None else float(answer.z[-1]),
        status=answer.status,
        iterations=answer.iterations,
        crushing=crushing,
        solver="interior-point",
    )
