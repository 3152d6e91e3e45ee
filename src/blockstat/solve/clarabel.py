"""Conic programs through Clarabel: every program that there is, fast when it is small."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.program.conic import ConicProgram
from blockstat.solve.answer import EXCHANGED, Answer, Status, read_answer
from blockstat.typing import Floats, Ints

#: Looser settings have given energies 8 % wrong under the status "Solved".
TOLERANCE = 1e-10
MAX_ITERATIONS = 200
#: Clarabel's words; with any other it has no answer.
STATUS = {
    "Solved": Status.SOLVED,
    "AlmostSolved": Status.ALMOST_SOLVED,
    "PrimalInfeasible": Status.PRIMAL_INFEASIBLE,
    "AlmostPrimalInfeasible": Status.PRIMAL_INFEASIBLE,
    "DualInfeasible": Status.DUAL_INFEASIBLE,
    "AlmostDualInfeasible": Status.DUAL_INFEASIBLE,
}


def solve(program: ConicProgram) -> Answer:
    """Solve a program to its optimum.

    Parameters
    ----------
    program
        Any program; the structure in blocks is not used.

    Returns
    -------
    Answer
        Forces, a twist and the status; nothing in them is checked.
    """
    return _solve_for_multipliers(program) if program.compliance else _solve_for_unknowns(program)


def _solve_for_unknowns(program: ConicProgram) -> Answer:
    """Minimise 1/2 x'P x + q'x subject to M x + s = b, s in the cones."""
    order, cones = _rows(program)
    hessian = sparse.triu(program.penalty.T @ program.penalty)
    if program.ridge:
        twists = np.arange(len(program.cost)) < program.width * program.n_blocks
        hessian = hessian + sparse.diags_array(program.ridge * twists)
    matrix, bound = sparse.csc_array(program.matrix[order]), program.bound[order]
    answer = run(sparse.csc_array(hessian), program.cost, matrix, bound, cones)
    z = np.empty(len(order))
    z[order] = np.array(answer.z)
    return read_answer(program, np.array(answer.x), z, _status(answer), int(answer.iterations), "clarabel")


def _solve_for_multipliers(program: ConicProgram) -> Answer:
    """With a compliance, and neither P nor zeros: min c/2 |f|^2 + b'z, M'z + q = 0, z in the cones, f the forces of z.

    The variables are the forces. Rows of the cones are as large as those of M'z + q = 0.
    """
    assert not program.is_quadratic
    assert not program.n_zeros
    clarabel: Any = importlib.import_module("clarabel")
    n, rows, triples = len(program.cost), len(program.bound), program.n_triples
    order, cones = _rows(program)
    size, slip, compliance = np.ones(rows), np.ones(rows), np.zeros(rows)
    size[: len(program.scale)] = program.scale
    slip[: 3 * triples] = np.tile(program.scale[triples : 2 * triples], 3)
    compliance[: len(program.scale)] = program.compliance
    balance = sparse.csc_array(program.transposed @ sparse.diags_array(1.0 / size))[:, order]
    constraint = sparse.csc_array(sparse.vstack([balance, -sparse.diags_array((slip / size)[order])]))
    bound = np.concatenate([-program.cost, np.zeros(rows)])
    hessian = sparse.csc_array(sparse.diags_array(compliance[order]))
    answer = run(hessian, (program.bound / size)[order], constraint, bound, [clarabel.ZeroConeT(n), *cones])
    dual, z, slack = np.array(answer.z), np.empty(rows), np.empty(rows)
    z[order] = np.array(answer.x) / size[order]
    slack[order] = slip[order] * dual[n:]
    status = _status(answer)
    status = EXCHANGED.get(status, status)
    # The multipliers of M'z + q = 0 are the unknowns.
    return read_answer(program, -dual[:n], z, status, int(answer.iterations), "clarabel", slack)


def _rows(program: ConicProgram) -> tuple[Ints, list]:
    """The order in which Clarabel wants the rows, the three of a triple together, and their cones."""
    clarabel: Any = importlib.import_module("clarabel")
    triples, zeros, local = 3 * program.n_triples, program.n_zeros, len(program.local)
    place = np.arange(len(program.bound))
    order = np.concatenate(
        [
            place[:triples].reshape(3, -1).T.reshape(-1),
            place[triples + zeros : local],
            place[triples : triples + zeros],
            place[local:],
        ]
    )
    sizes = [local - triples - zeros, program.bounds.size if program.bounds else 0]
    border = [1] * (len(place) - local - sizes[1])
    cones = [clarabel.SecondOrderConeT(3)] * program.n_triples
    cones += [clarabel.NonnegativeConeT(size) for size in sizes[:1] if size]
    cones += [clarabel.ZeroConeT(zeros)] if zeros else []
    cones += [clarabel.NonnegativeConeT(size) for size in [*sizes[1:], *border] if size]
    if program.pinned:
        cones[-1] = clarabel.ZeroConeT(1)
    return order, cones


def run(hessian: Any, cost: Floats, matrix: sparse.csc_array, bound: Floats, cones: list) -> Any:
    """Return Clarabel's own answer to min 1/2 x'P x + q'x subject to M x + s = b, s in the cones.

    Parameters
    ----------
    hessian
        The upper triangle of P.
    cost
        q, shape (n,).
    matrix
        M.
    bound
        b, shape (n_rows,).
    cones
        Clarabel's cones, in the order of the rows.

    Returns
    -------
    object
        With `x`, `z`, `status`, `obj_val` and `obj_val_dual`.
    """
    clarabel: Any = importlib.import_module("clarabel")
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.direct_solve_method = "qdldl"  # five times faster here than the multithreaded default
    settings.max_iter = MAX_ITERATIONS
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    return clarabel.DefaultSolver(hessian, cost, matrix, bound, cones, settings).solve()


def _status(answer: Any) -> Status:
    return STATUS.get(str(answer.status), Status.STALLED)
