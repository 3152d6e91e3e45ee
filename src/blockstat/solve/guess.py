"""Forces without an optimiser: least squares, pressed back into the friction cones a few times.

Where blocks lie on each other and little pushes, that is an admissible force field after two linear systems, and most
walls and barrel vaults need no more. Where blocks lean on each other it soon gets no better, and is given up; the
least squares are then where the optimiser starts.
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


def least_squares(program: PenaltyProgram) -> Floats:
    """Forces in equilibrium, the smallest, shape (m, 3); some pull."""
    force = np.zeros((len(program.friction), 3))
    force[:, 0] = SMALL
    return balance(program, force, passes=2)


def admissible(program: PenaltyProgram, force: Floats) -> Floats | None:
    """Forces next to these that prove stability, shape (m, 3), or None if they are not found so."""
    last = np.inf
    for _ in range(MOST):
        unbalanced, outside = force_errors(program, force)
        if unbalanced <= FORCE_TOLERANCE and outside == 0.0:
            return force
        if not outside < SHRINKS * last:
            return None
        last = outside
        force = balance(program, pressed(program, force), passes=2)
    return None
