"""The force program of the Coulomb fixed point through Clarabel."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.clarabel_dual import MAX_ITERATIONS, TOLERANCE
from blockstat.typing import Floats


def solve_pressure(program: PenaltyProgram, cost: Floats, compliance: float) -> tuple[Floats, Floats, str]:
    """Minimise cost' f_n + compliance/2 |f|^2 subject to A f + w = 0, f in K, for positive finite friction.

    cost : of the normal force at each point, shape (m,). Returns the forces, shape (m, 3), the cone multipliers
    z in K* (relative velocities with the closing and the dilatancy taken off), shape (m, 3), and the status.
    """
    clarabel: Any = importlib.import_module("clarabel")
    m, rows = len(cost), len(program.load)
    unit = max(float(cost.max()), 1.0)
    cone = np.column_stack([program.friction, np.ones(m), np.ones(m)]).reshape(-1)
    heads = sparse.csr_array(sparse.eye_array(3 * m))[::3]
    above, below = heads[program.floored], heads[program.capped]
    constraint = sparse.csc_array(sparse.vstack([program.matrix, -sparse.diags_array(cone), -above, below]))
    linear = np.zeros(3 * m)
    linear[::3] = cost / unit
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.direct_solve_method = "qdldl"
    settings.max_iter = MAX_ITERATIONS
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    hessian = sparse.csc_array((compliance / unit) * sparse.eye_array(3 * m))
    limits = np.concatenate([-program.floor[program.floored], program.cap[program.capped]])
    bound = np.concatenate([-program.load, np.zeros(3 * m), limits])
    cones = [clarabel.ZeroConeT(rows), *[clarabel.SecondOrderConeT(3)] * m]
    if len(limits):
        cones.append(clarabel.NonnegativeConeT(len(limits)))
    answer = clarabel.DefaultSolver(hessian, linear, constraint, bound, cones, settings).solve()
    multiplier = unit * cone * np.array(answer.z)[rows : rows + 3 * m]
    return np.array(answer.x).reshape(-1, 3), multiplier.reshape(-1, 3), str(answer.status)
