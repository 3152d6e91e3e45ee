"""Forces and motions that keep as far from the limit as they can: the best ground for exact ones.

Both are conic programs with one further unknown t, the margin, which is made as large as possible:

    forces:  A f + w = 0,   f_n >= |f_t| / mu + t           at all points,   t <= 1;
    motions: g = A'u,       g_n >= mu |g_t| + t             at all points,   |u_i| <= 1.

Joint laws put t between the force and its bounds too, and so do bonds and ties that have a range. A margin of zero
leaves points at the boundary; an interior-point method then ends at the centre of what there is, away from all bounds
that need not be met.
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.clarabel import run
from blockstat.typing import Floats, Ints

#: Slope of the cone that stands for infinite friction here: forces in it are admissible there too.
STEEP = 10.0


def centred_forces(program: PenaltyProgram, load: Floats) -> Floats | None:
    """Return forces in balance with the largest slack that all points can have, up to a mean weight.

    Parameters
    ----------
    program
        The penalty program.
    load
        Shape (6 n,), in its units.

    Returns
    -------
    Floats or None
        Shape (m, 3), in its units; None where the solver finds none.
    """
    clarabel: Any = importlib.import_module("clarabel")

    m, last = len(program.friction), 3 * len(program.friction)
    mu, capped = np.minimum(program.friction, STEEP), program.upper_bounded
    margin = (program.upper > program.lower).astype(float)  # a bond without strength in one component has none there
    every, normal, end = np.arange(m), 3 * np.arange(m), np.full(m, last)
    tangent = np.setdiff1d(np.arange(last), normal)
    heads = _rows(last, (normal, normal, -mu), (normal, end, mu * margin), (tangent, tangent, -np.ones(2 * m)))
    above = _rows(last, (every, normal, -np.ones(m)), (every, end, margin), size=m)
    k = np.arange(len(capped))
    below = _rows(last, (k, 3 * capped, np.ones(len(k))), (k, np.full(len(k), last), margin[capped]), size=len(k))
    least = _rows(last, (every[:1], np.array([last]), np.ones(1)), size=1)
    balance = sparse.hstack([program.matrix, sparse.csc_array((len(load), 1))])
    bound = np.concatenate([-load, np.zeros(last), -program.lower, program.upper[capped], [1.0]])
    cones = [clarabel.ZeroConeT(len(load)), *[clarabel.SecondOrderConeT(3)] * m]
    cones += [clarabel.NonnegativeConeT(m + len(capped) + 1)]
    matrix = sparse.csc_array(sparse.vstack([balance, heads, above, below, least]))
    answer: Any = run(sparse.csc_array((last + 1, last + 1)), _up(last), matrix, bound, cones)
    return np.array(answer.x)[:-1].reshape(-1, 3) if "Infeasible" not in str(answer.status) else None


def opening_motion(program: PenaltyProgram, rows: Ints, basis: Any) -> Floats | None:
    """Return the motion of unit size that opens contact points and shortens ties most.

    Parameters
    ----------
    program
        The penalty program.
    rows
        Columns of three that are to open: contact points and ties.
    basis
        Twists of which the motion is a combination, a sparse array of shape (6 n, p).

    Returns
    -------
    Floats or None
        Shape (6 n,), in its units; None where the solver finds none.
    """
    clarabel: Any = importlib.import_module("clarabel")

    m, n = len(rows), basis.shape[1]
    mu = np.minimum(program.friction[rows], STEEP)
    normal = 3 * np.arange(m)
    scale = np.column_stack([np.ones(m), mu, mu]).reshape(-1)
    rates = sparse.csr_array(program.matrix.T)[(3 * rows[:, None] + np.arange(3)).ravel()] @ basis
    rates = rates.multiply(scale[:, None])
    opening = sparse.hstack([-rates, _rows(0, (normal, np.zeros(m, dtype=int), np.ones(m)), size=3 * m)])
    box = sparse.hstack([sparse.vstack([sparse.eye_array(n), -sparse.eye_array(n)]), sparse.csc_array((2 * n, 1))])
    bound = np.concatenate([np.zeros(3 * m), np.ones(2 * n)])
    cones = [*[clarabel.SecondOrderConeT(3)] * m, clarabel.NonnegativeConeT(2 * n)]
    matrix = sparse.csc_array(sparse.vstack([opening, box]))
    answer: Any = run(sparse.csc_array((n + 1, n + 1)), _up(n), matrix, bound, cones)
    return basis.dot(np.array(answer.x)[:-1]) if "Infeasible" not in str(answer.status) else None


def endless(program: PenaltyProgram) -> Ints:
    """Return the columns of three of the ties whose tension has no upper bound.

    Parameters
    ----------
    program
        The penalty program.

    Returns
    -------
    Ints
        After those of the contact points.
    """
    return program.n_points + np.flatnonzero(np.isinf(program.upper[program.n_points :]))


def _up(last: int) -> Floats:
    """The cost of a program whose last unknown is made as large as possible."""
    cost = np.zeros(last + 1)
    cost[-1] = -1.0
    return cost


def _rows(last: int, *entries: tuple[Ints, Ints, Floats], size: int | None = None) -> sparse.coo_array:
    """A matrix with unknowns 0 to `last` from rows, columns and values."""
    row, column, value = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    return sparse.coo_array((value, (row, column)), shape=(last if size is None else size, last + 1))
