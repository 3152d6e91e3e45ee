"""Forces along the loads, exactly: what holds a structure that stands at the limit of friction.

A block on a slope of tan mu has no forces but those on the boundary of its cones, and of these only the ones along its
weight. They are s_i d, with d against gravity. The balance of a block is then that of the s_i and of moments about two
axes across d, and along a tree of joints each body hands on what is left of these:

    ds_i = s_i y.a_i,   a_i = (1, (p_i x d)_u, (p_i x d)_v),   (sum s_i a_i a_i') y = (R, M_u, M_v).

Whether d lies within a cone is asked of the rational numbers, so its boundary counts. The normals are then those of the
faces exactly, not those of a frame in floating point.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from scipy import sparse

from blockstat.proof.exact_check import admissible
from blockstat.proof.forces import balanced_forces
from blockstat.proof.rational import Exact
from blockstat.proof.structure import Structure
from blockstat.typing import Floats


def parallel_forces(structure: Structure) -> Exact | None:
    """Return admissible forces along the loads that balance every block exactly.

    Parameters
    ----------
    structure
        The blocks, contacts and dead loads.

    Returns
    -------
    Exact or None
        Shape (n, 3) [N]; None where loads are not parallel, where joints have laws, and where none are found.
    """
    along = -structure.dead[:, :3].sum(axis=0)
    if structure.law is not None or not along.any() or np.cross(structure.dead[:, :3], along).any():
        return None
    along = along / abs(along).sum()
    sign = np.sign((structure.normal * along).sum(axis=1).astype(float)).astype(int)
    sign[~admissible(structure, sign[:, None] * along)] = 0
    size = _sizes(structure, along, sign)
    if size is None:
        return None
    force = (sign * size)[:, None] * along.astype(float)
    try:
        found = balanced_forces(structure, force, size, Fraction(0), along)
    except ArithmeticError:
        return None
    return found if admissible(structure, found).all() else None


def _sizes(structure: Structure, along: Exact, sign: np.ndarray) -> Floats | None:
    """Sizes of forces in balance, the least of them as large as it can be, shape (n,); None where there are none."""
    from scipy.optimize import linprog

    used, free = np.flatnonzero(sign), np.flatnonzero(~structure.fixed)
    u, v = np.delete(np.arange(3), np.abs(along.astype(float)).argmax())
    arm = np.cross(structure.point[used], along).astype(float)
    parts = sign[used, None] * np.column_stack([np.ones(len(used)), arm[:, u], arm[:, v]])
    matrix = sparse.lil_array((3 * len(structure.fixed), len(used) + 1))
    for side, turn in ((0, -1.0), (1, 1.0)):
        for k in range(3):
            matrix[3 * structure.pair[used, side] + k, np.arange(len(used))] = turn * parts[:, k]
    rows = (3 * free[:, None] + np.arange(3)).ravel()
    dead = structure.dead[free].astype(float)
    load = np.column_stack([dead[:, :3] @ along.astype(float) / float(along @ along), dead[:, 3 + u], dead[:, 3 + v]])
    above = sparse.hstack([-sparse.eye_array(len(used)), np.ones((len(used), 1))])
    most = np.abs(load[:, 0]).mean()
    bounds = [(0.0, None)] * len(used) + [(0.0, most)]
    cost = np.append(np.zeros(len(used)), -1.0)
    answer = linprog(cost, above, np.zeros(len(used)), matrix.tocsr()[rows], -load.ravel(), bounds)
    if answer.x is None:
        return None
    size = np.zeros(len(sign))
    size[used] = answer.x[:-1]
    return size
