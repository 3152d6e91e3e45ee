"""Forces along the loads, exactly: what holds a structure that stands at the limit of friction.

A block on a slope of tan mu has no forces but those on the boundary of its cones, and of these only the ones along its
weight. They are s_i d, with d against gravity. No force across d is needed, so the balance of a block is that of s_i and
of its moments about two axes across d, and along a tree of joints each body hands on what is left of these:

    ds_i = s_i y.a_i,   a_i = (1, (p_i x d)_u, (p_i x d)_v),   (sum s_i a_i a_i') y = (R, M_u, M_v).

Whether d lies within a cone is asked of the rational numbers, so its boundary counts. The normals are then those of the
faces exactly, not those of a frame in floating point.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from scipy import sparse

from blockstat.proof.exact_check import admissible, inside
from blockstat.proof.forces import balanced_forces
from blockstat.proof.rational import Exact
from blockstat.proof.structure import Structure
from blockstat.typing import Floats

#: The least s_i is made as large as possible, up to this fraction of a mean weight.
LARGEST = 1.0


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
    usable = inside(structure, sign[:, None] * along) & (sign != 0)
    size = _least_sizes(structure, along, np.where(usable, sign, 0))
    if size is None:
        return None
    try:
        force = balanced_forces(structure, size * sign, size, Fraction(0), along=along)
    except ArithmeticError:
        return None
    return force if admissible(structure, force) else None


def _least_sizes(structure: Structure, along: Exact, sign: np.ndarray) -> Floats | None:
    """Sizes of the forces in balance, the least of them as large as it can be, shape (n,) [N]."""
    from scipy.optimize import linprog

    used, free = np.flatnonzero(sign), np.flatnonzero(~structure.fixed)
    row = np.full(len(structure.fixed), -1)
    row[free] = np.arange(len(free))
    u, v = across(along)
    arms = np.cross(structure.point[used], along)
    parts = np.column_stack([np.ones(len(used)), arms[:, u].astype(float), arms[:, v].astype(float)]) * sign[used, None]
    entries = []
    for side, turn in ((0, -1.0), (1, 1.0)):
        block = row[structure.pair[used, side]]
        held = np.flatnonzero(block >= 0)
        where = (3 * block[held, None] + np.arange(3)).ravel(), np.repeat(held, 3)
        entries.append(sparse.coo_array((turn * parts[held].ravel(), where), shape=(3 * len(free), len(used) + 1)))
    dead = structure.dead[free]
    load = np.column_stack([(dead[:, :3] * along).sum(axis=1) / (along * along).sum(), dead[:, 3 + u], dead[:, 3 + v]])
    load = load.astype(float).ravel()
    least = sparse.hstack([-sparse.eye_array(len(used)), np.ones((len(used), 1))])
    unit = np.abs(load[::3]).mean()
    bounds = [(0, None)] * len(used) + [(0, LARGEST * unit)]
    cost = np.append(np.zeros(len(used)), -1.0)
    answer = linprog(cost, least, np.zeros(len(used)), sum(entries).tocsr(), -load, bounds)
    if answer.x is None:
        return None
    size = np.zeros(len(sign))
    size[used] = np.maximum(answer.x[:-1], 0.0)
    return size
