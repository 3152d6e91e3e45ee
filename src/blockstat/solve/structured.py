"""The dual programs of rigid blocks in the form of the structured interior-point method."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from blockstat.planar import Plane
from blockstat.polyhedron import Floats, Ints
from blockstat.solve.cones import Cones
from blockstat.solve.interior_point import ConicAnswer, ConicProgram, solve
from blockstat.solve.raw import DualAnswer, DualProgram


def fits(problem: DualProgram) -> bool:
    """Whether the method knows all that is in a program."""
    program = problem.program
    return bool(np.isfinite(program.friction).all()) and not len(program.capped) and not len(program.floored)


def solve_dual(problem: DualProgram) -> DualAnswer:
    """Solve a dual program, in the plane when it is planar."""
    plane = problem.plane
    return _solve_in_plane(problem, plane) if plane is not None else _solve_in_space(problem)


def local_rows(matrix: sparse.csr_array, pair: Ints, width: int) -> Floats:
    """Entries of rows in the columns of their blocks a and b, shape (n_rows, 2 width)."""
    entries = matrix.tocoo()
    row, column = entries.coords[0], entries.coords[1]
    second = column // width == pair[row, 1]
    local = np.zeros((len(pair), 2 * width))
    local[row, width * second + column % width] = entries.data
    return local


def _solve_in_space(problem: DualProgram) -> DualAnswer:
    program = problem.program
    mu = program.friction
    m = len(mu)
    rough, smooth = np.flatnonzero(mu > 0), np.flatnonzero(mu == 0)
    slip = np.minimum(mu[rough], 1.0)
    # Heads, first and second tangents of the cones (g_n / mu, g_1, g_2), then g_n alone where there is no friction.
    rows = np.concatenate([3 * rough, 3 * rough + 1, 3 * rough + 2, 3 * smooth])
    scale = np.concatenate([slip / mu[rough], slip, slip, np.ones(len(smooth))])
    owner = np.concatenate([rough, rough, rough, smooth])
    rates = sparse.csr_array(sparse.diags_array(scale) @ program.matrix.T.tocsr()[rows])
    offset = np.zeros(len(rows)) if problem.offset is None else scale * problem.offset[rows]
    opening = sparse.csr_array(program.opening.T)
    answer = _solve(
        problem,
        rates,
        offset,
        Cones(len(rough), len(smooth)),
        program.point_blocks[owner],
        (opening, program.point_blocks[: program.n_points]),
        None,
    )
    force = np.zeros(3 * m)
    force[rows] = scale * answer.z[: len(rows)]
    return _answer(problem, answer, answer.x, force.reshape(-1, 3))


def _solve_in_plane(problem: DualProgram, plane: Plane) -> DualAnswer:
    """Each pair of points is two half-planes, g_n + mu g_t >= 0 and g_n - mu g_t >= 0."""
    program = problem.program
    normal, along = plane.rates(program.matrix)
    mu = program.friction[plane.first]
    scale = 1.0 / np.maximum(mu, 1.0)
    sideways = sparse.diags_array(mu) @ along
    rates = sparse.csr_array(
        sparse.diags_array(np.tile(scale, 2)) @ sparse.vstack([normal + sideways, normal - sideways])
    )
    offset = np.zeros(2 * len(mu))
    if problem.offset is not None:
        head, tangent = plane.offsets(problem.offset)
        offset = np.concatenate([scale * (head + mu * tangent), scale * (head - mu * tangent)])
    blocks = program.point_blocks[plane.first]
    # Two points a pair, so the penalty on a pair counts twice.
    opening = (sparse.csr_array(np.sqrt(2.0) * normal), blocks)
    answer = _solve(problem, rates, offset, Cones(0, len(offset)), np.tile(blocks, (2, 1)), opening, plane)
    plus, minus = scale * answer.z[: len(mu)], scale * answer.z[len(mu) : 2 * len(mu)]
    force = plane.unfold_forces(plus + minus, mu * (plus - minus), len(program.friction))
    return _answer(problem, answer, plane.unfold @ answer.x, force)


def _solve(
    problem: DualProgram,
    rates: sparse.csr_array,
    offset: Floats,
    cones: Cones,
    pair: Ints,
    opening: tuple[sparse.csr_array, Ints],
    plane: Plane | None,
) -> ConicAnswer:
    """Solve with rates x + offset in the cones and the bordering rows of the program below them."""
    width = 6 if plane is None else 3
    size = width * (len(problem.program.load) // 6)

    def folded(vector: Floats) -> Floats:
        return vector if plane is None else plane.unfold.T @ vector

    border, bounds = [], []
    for vector, sign in ((problem.capped, 1.0), (problem.pinned, -1.0)):
        if vector is not None:
            # A load does as little work as it can, so l'u = 1 may be relaxed to l'u >= 1.
            border.append(sparse.csr_array(sign * folded(vector)[None, :]))
            bounds.append(sign)
    matrix = sparse.csr_array(sparse.vstack([-rates, *border]))
    penalty, owners = opening
    if not problem.penalty:
        penalty, owners = sparse.csr_array((0, size)), owners[:0]
    return solve(
        ConicProgram(
            cost=folded(problem.cost),
            matrix=matrix,
            bound=np.concatenate([offset, bounds]),
            cones=Cones(cones.n_soc, cones.n_half + len(bounds)),
            local=local_rows(rates, pair, width),
            pair=np.concatenate([pair, owners]),
            n_blocks=size // width,
            width=width,
            penalty=penalty,
            penalty_local=local_rows(penalty, owners, width),
            ridge=1.0 if problem.least_norm else 0.0,
        )
    )


def _answer(problem: DualProgram, answer: ConicAnswer, twist: Floats, force: Floats) -> DualAnswer:
    return DualAnswer(
        twist=twist,
        force=force,
        multiplier=0.0 if problem.pinned is None else float(answer.z[-1]),
        status=answer.status,
        iterations=answer.iterations,
        crushing=np.zeros(len(problem.program.friction)),
        solver="interior-point",
    )
