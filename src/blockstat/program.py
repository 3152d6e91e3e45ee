"""The conic programs as plain data.

The penalty program of Whiting, Ochsendorf & Durand (2009) with an exact friction cone:

    minimise 1/2 ||s||^2   subject to   A (f - E s) + w = 0,   f_i in K,   s >= 0

where s_i [N] is the adhesion missing at contact point i and K = {f_n >= 0, ||f_t|| <= mu f_n}. Its dual has
six unknowns a block, a twist u = (velocity, angular velocity):

    minimise 1/2 ||E' A' u||^2 - w' u   subject to   g_i = (A' u)_i in K* = {g_n >= mu ||g_t||}

u is the collapse mechanism, g_i the relative velocity at point i, s_i = g_n at the optimum, and the
multipliers of the cones are the contact forces.

Everything here is dimensionless: forces in units of the mean weight, lengths in units of the mean block size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from blockstat.equilibrium import Equilibrium
from blockstat.planar import Plane
from blockstat.polyhedron import Floats


@dataclass(frozen=True, eq=False)
class PenaltyProgram:
    """The scaled penalty program of one equilibrium."""

    matrix: sparse.csr_array  #: A, shape (6 n, 3 m), moments in units of force x length
    load: Floats  #: w, shape (6 n,); with bonds w - A E t, and the forces of the program are f + t n
    friction: Floats  #: mu of each point, shape (m,), inf allowed
    force_unit: float  #: [N]
    length_unit: float  #: [m]
    total_load: float  #: sum of the magnitudes of the forces on the blocks
    tension: Floats  #: t, tension capacity of each point, shape (m,)
    plane: Plane | None = None  #: the reduction of a prismatic scene

    @cached_property
    def opening(self) -> sparse.csc_array:
        """A E, the columns of the normal forces, shape (6 n, m)."""
        return self.matrix.tocsc()[:, ::3]


def penalty_program(
    eq: Equilibrium, friction: Floats, tension: Floats | None = None, plane: Plane | None = None
) -> PenaltyProgram:
    """Scale an equilibrium.

    friction : mu of each of its points; tension : capacity of each point [N], shape (n_points,). A capacity t moves
    the apex of the cone to -t n: with f' = f + t n in K, equilibrium reads A f' + (w - A E t) = 0.
    """
    length_unit = float(eq.length.mean())
    force_unit = float(np.linalg.norm(eq.load[:, :3], axis=1).mean()) or 1.0
    scale = np.tile([1, 1, 1, 1 / length_unit, 1 / length_unit, 1 / length_unit], eq.n_blocks)
    matrix = sparse.csr_array(sparse.diags_array(scale) @ eq.matrix)
    load = scale * eq.load.reshape(-1) / force_unit
    total = float(np.linalg.norm(load.reshape(-1, 6)[:, :3], axis=1).sum()) or 1.0
    held = np.zeros(len(friction)) if tension is None else tension / force_unit
    if held.any():
        load = load - matrix.tocsc()[:, ::3] @ held
    return PenaltyProgram(matrix, load, friction, force_unit, length_unit, total, held, plane)
