"""Programs through cvxpy: any conic program, and the penalty program as it is written on paper.

Both are slow. The second shares nothing with the other solvers but the equilibrium: it is the reference.
"""

from __future__ import annotations

import contextlib
import warnings
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.program.conic import ConicProgram
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import EXCHANGED, Answer, Status, read_answer
from blockstat.typing import Floats

#: Words of cvxpy; with any other there is no answer.
STATUS = {
    "optimal": Status.SOLVED,
    "optimal_inaccurate": Status.ALMOST_SOLVED,
    "infeasible": Status.PRIMAL_INFEASIBLE,
    "infeasible_inaccurate": Status.PRIMAL_INFEASIBLE,
    "unbounded": Status.DUAL_INFEASIBLE,
    "unbounded_inaccurate": Status.DUAL_INFEASIBLE,
}
TOLERANCE, MAX_ITERATIONS = 1e-11, 400


def solve(program: ConicProgram) -> Answer:
    """Solve a conic program.

    Parameters
    ----------
    program
        Any program; the structure in blocks is not used.

    Returns
    -------
    Answer
        Forces, a twist and the status; nothing in them is checked. Zeros where there is no optimum.
    """
    return _solve_for_multipliers(program) if program.compliance else _solve_for_unknowns(program)


def _solve_for_unknowns(program: ConicProgram) -> Answer:
    """Minimise 1/2 x'P x + q'x subject to M x + s = b, s in the cones."""
    import cvxpy as cp

    x = cp.Variable(len(program.cost))
    slack = program.bound - program.matrix @ x
    twists = x[: program.width * program.n_blocks]
    cost = program.cost @ x + 0.5 * cp.sum_squares(program.penalty @ x) + 0.5 * program.ridge * cp.sum_squares(twists)
    triples, numbers = _inside(program, slack)
    zeros = [slack[3 * program.n_triples :][: program.n_zeros] == 0] if program.n_zeros else []
    status, iterations = _run(cp.Problem(cp.Minimize(cost), [*triples, *zeros, *numbers]))
    if x.value is None:
        return _read(program, 0 * program.cost, 0 * program.bound, status, iterations)
    parts = [np.concatenate([np.ravel(part) for part in cone.dual_value]) for cone in triples]
    parts += [-np.asarray(row.dual_value) for row in zeros] + [np.asarray(row.dual_value) for row in numbers]
    return _read(program, np.asarray(x.value), np.concatenate(parts), status, iterations)


def _solve_for_multipliers(program: ConicProgram) -> Answer:
    """With a compliance, and neither P nor zeros: min c/2 |f|^2 + b'z, M'z + q = 0, z in the cones."""
    import cvxpy as cp

    assert not program.is_quadratic
    assert not program.n_zeros
    z = cp.Variable(len(program.bound))
    own = cp.multiply(program.scale, z[: len(program.scale)])
    cost = 0.5 * program.compliance * cp.sum_squares(own) + program.bound @ z
    balance = program.transposed @ z + program.cost == 0
    triples, numbers = _inside(program, z)
    status, iterations = _run(cp.Problem(cp.Minimize(cost), [balance, *triples, *numbers]))
    status = EXCHANGED.get(status, status)
    if z.value is None:
        return _read(program, 0 * program.cost, 0 * program.bound, status, iterations)
    x, force = -np.asarray(balance.dual_value), np.asarray(z.value)
    slack = program.bound - program.matrix @ x
    slack[: len(program.scale)] += program.compliance * program.scale**2 * force[: len(program.scale)]
    return read_answer(program, x, force, status, iterations, "cvxpy", slack)


def _inside(program: ConicProgram, vector: Any) -> tuple[list, list]:
    """Constraints that put the triples and the half-lines of a vector inside their cones."""
    import cvxpy as cp

    n, free = program.n_triples, 3 * program.n_triples + program.n_zeros
    triples = [cp.SOC(vector[:n], cp.vstack([vector[n : 2 * n], vector[2 * n : 3 * n]]))] if n else []
    return triples, [vector[free:] >= 0] if program.n_half else []


def _read(program: ConicProgram, x: Floats, z: Floats, status: Status, iterations: int) -> Answer:
    return read_answer(program, x, z, status, iterations, "cvxpy")


def solve_on_paper(program: PenaltyProgram) -> Answer:
    """Minimise ||s|| subject to A (f - E s) + w = 0, f in K, s >= 0.

    Parameters
    ----------
    program
        The penalty program; its bounds are lower <= f_n and f_n - s <= upper.

    Returns
    -------
    Answer
        Forces, adhesion and the multiplier of equilibrium as the twist.

    Notes
    -----
    The norm has the minimiser of 1/2 ||s||^2. An interior-point method reaches it to as many digits as its tolerance,
    where the square would lose half of them near zero.

    References
    ----------
    Whiting, Ochsendorf & Durand: Procedural modeling of structurally-sound masonry buildings, 2009.
    """
    import cvxpy as cp

    mu = program.friction
    m, n = len(mu), program.n_points
    normal, tangent, adhesion = cp.Variable(m), cp.Variable((m, 2)), cp.Variable(n)
    columns = program.matrix
    balance = (
        columns[:, ::3] @ normal
        - program.normal_columns @ adhesion
        + columns[:, 1::3] @ tangent[:, 0]
        + columns[:, 2::3] @ tangent[:, 1]
        + program.load
        == 0
    )
    cone = [normal >= 0, adhesion >= 0]
    finite = np.isfinite(mu)
    if finite.any():
        index = np.flatnonzero(finite)
        cone.append(cp.norm(tangent[index], axis=1) <= cp.multiply(mu[index], normal[index]))
    upper, lower = program.upper_bounded, program.lower_bounded
    if len(upper):
        held = np.flatnonzero(upper < n)
        relief = sparse.csr_array((np.ones(len(held)), (held, upper[held])), shape=(len(upper), n))
        cone.append(normal[upper] - relief @ adhesion <= program.upper[upper])
    if len(lower):
        cone.append(normal[lower] >= program.lower[lower])
    status, iterations = _run(cp.Problem(cp.Minimize(cp.norm(adhesion)), [balance, *cone]))

    bounded = normal.value is not None
    dual = np.asarray(balance.dual_value) if bounded else np.zeros(len(program.load))
    s = np.asarray(adhesion.value) if bounded else np.full(n, np.inf)
    force = np.zeros((m, 3))
    if bounded:
        force[:, 0], force[:, 1:] = normal.value, tangent.value
    # The multiplier belongs to ||s||; that of 1/2 ||s||^2, the mechanism, is ||s|| times as large.
    twist = dual.astype(float) * float(np.linalg.norm(s) if bounded else 0.0)
    if twist @ program.load < 0:
        twist = -twist
    return Answer(force, twist, status, iterations, "cvxpy", adhesion=s, bounded=bounded)


def _run(problem: Any) -> tuple[Status, int]:
    """Solve as far as it goes: how it ended, and after how many iterations."""
    import cvxpy as cp

    with warnings.catch_warnings():
        # The tolerance is out of reach on purpose: the solver goes as far as it can, and the certificate check decides.
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        with contextlib.suppress(cp.SolverError):  # then there is no answer, and the verdict is undecided
            tolerances = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), TOLERANCE)
            problem.solve(solver=cp.CLARABEL, max_iter=MAX_ITERATIONS, **tolerances)
    stats = problem.solver_stats
    return STATUS.get(str(problem.status), Status.STALLED), int(stats.num_iters or 0) if stats else 0
