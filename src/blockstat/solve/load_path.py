"""A guess of the load path, where phase one begins: each block hands what it carries down to those it rests on.

Only the direction of the sum of all loads counts. Joints share what a block carries by the squares of the cosines of
their normals with it, and no joint rubs. Such forces do not balance, but they lie inside all cones and are as large as
they will be: a few steps from a force field (see `blockstat.solve.phase_one`).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats

#: Joints whose normal makes less than this cosine with the loads carry nothing down.
STEEP = 0.1
#: Courses that a burden is handed down at most, and the change of the burdens at which it has arrived.
COURSES, ARRIVED = 1_000, 1e-3


def load_path_guess(program: PenaltyProgram) -> Floats:
    """Guess the normal force at each point from the loads above it.

    Parameters
    ----------
    program
        The equilibrium, in its units.

    Returns
    -------
    Floats
        Normal forces, shape (m,), none below zero. They do not balance.
    """
    load = program.load.reshape(-1, 6)[:, :3]
    total = load.sum(axis=0)
    size = float(np.linalg.norm(total))
    if not size:
        return np.zeros(len(program.friction))
    a, b = program.point_blocks.T
    head = program.local[::3]
    normal = np.where((b >= 0)[:, None], head[:, 6:9], -head[:, :3])  # of the force on b
    rise = -normal @ (total / size)
    upper, lower = np.where(rise > 0, b, a), np.where(rise > 0, a, b)
    slope = np.where((upper >= 0) & (np.abs(rise) > STEEP), np.abs(rise), 0.0)
    held = np.bincount(np.maximum(upper, 0), slope**2, len(load))[upper]
    share = slope**2 / np.where(slope > 0, held, 1.0)
    on = np.flatnonzero((slope > 0) & (lower >= 0))
    hand = sparse.csr_array((share[on], (lower[on], upper[on])), shape=(len(load), len(load)))
    own = np.maximum(load @ (total / size), 0.0)
    burden = own
    for _ in range(COURSES):
        before, burden = burden, own + hand @ burden
        if np.abs(burden - before).max() <= ARRIVED * burden.max():
            break
    return burden[upper] * share / np.where(slope > 0, slope, 1.0)
