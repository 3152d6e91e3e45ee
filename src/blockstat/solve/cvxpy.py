"""The penalty program as it is written on paper, in cvxpy: slow, and the reference for the fast path."""

from __future__ import annotations

import contextlib
import warnings

import numpy as np
from scipy import sparse

from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import RawSolution


def solve(program: PenaltyProgram) -> RawSolution:
    """Minimise ||s|| subject to A (f - E s) + w = 0, f in K, s >= 0.

    The norm has the minimiser of 1/2 ||s||^2; an interior-point method reaches it to as many digits as its
    tolerance, where the square would lose half of them near zero.
    """
    import cvxpy as cp

    mu = program.friction
    m, n = len(mu), program.n_points
    normal, tangent, adhesion = cp.Variable(m), cp.Variable((m, 2)), cp.Variable(n)
    columns = program.matrix
    balance = (
        columns[:, ::3] @ normal
        - program.opening @ adhesion
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
    if len(program.capped):
        held = np.flatnonzero(program.capped < n)
        relief = sparse.csr_array((np.ones(len(held)), (held, program.capped[held])), shape=(len(program.capped), n))
        cone.append(normal[program.capped] - relief @ adhesion <= program.cap[program.capped])
    if len(program.floored):
        cone.append(normal[program.floored] >= program.floor[program.floored])
    problem = cp.Problem(cp.Minimize(cp.norm(adhesion)), [balance, *cone])
    with warnings.catch_warnings():
        # The tolerance is out of reach on purpose: the solver goes as far as it can, our own checks judge.
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        with contextlib.suppress(cp.SolverError):  # then there is no answer, and the verdict is undecided
            problem.solve(solver=cp.CLARABEL, tol_gap_abs=1e-11, tol_gap_rel=1e-11, tol_feas=1e-11, max_iter=400)

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
    return RawSolution(
        force=force,
        adhesion=s,
        twist=twist,
        bounded=bounded,
        status=str(problem.status),
        iterations=int(problem.solver_stats.num_iters or 0) if problem.solver_stats else 0,
        solver="cvxpy",
    )
