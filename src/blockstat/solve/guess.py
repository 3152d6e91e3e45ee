"""Forces without an optimiser: least squares, pressed back into the friction cones a few times.

Where blocks lie on each other and little pushes, that is an admissible force field after two linear systems, and most
walls and barrel vaults need no more. Where blocks lean on each other it soon gets no better, and is given up.
"""

from __future__ import annotations

import numpy as np

from blockstat.polyhedron import Floats
from blockstat.program import PenaltyProgram
from blockstat.solve.certificate import FORCE_TOLERANCE, balance, force_errors, pressed

#: The same force at every point to begin with, so small that all of the load is left to the first correction.
SMALL = 1e-6
#: Corrections at most, and how much of the error each may leave.
MOST, SHRINKS = 6, 0.5


def guess(program: PenaltyProgram) -> Floats | None:
    """Forces that prove stability, shape (m, 3), or None if they are not found so."""
    force = np.zeros((len(program.friction), 3))
    force[:, 0] = SMALL
    last = np.inf
    for _ in range(MOST):
        force = balance(program, force, passes=2)
        unbalanced, outside = force_errors(program, force)
        if unbalanced <= FORCE_TOLERANCE and outside == 0.0:
            return force
        if not outside < SHRINKS * last:
            return None
        last = outside
        force = pressed(program, force)
    return None
