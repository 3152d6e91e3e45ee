"""The conic programs as plain data.

The penalty program of Whiting, Ochsendorf & Durand (2009) with an exact friction cone:

    minimise 1/2 ||s||^2   subject to   A (f - E s) + w = 0,   f_i in K,   s >= 0

where s_i [N] is the adhesion missing at contact point i and K = {f_n >= 0, ||f_t|| <= mu f_n}. Its dual has
six unknowns a block, a twist u = (velocity, angular velocity):

    minimise 1/2 ||E' A' u||^2 - w' u   subject to   g_i = (A' u)_i in K* = {g_n >= mu ||g_t||}

u is the collapse mechanism, g_i the relative velocity at point i, s_i = g_n at the optimum, and the
multipliers of the cones are the contact forces.

Joint laws add three numbers a point (see `blockstat.joint`). The apex of the cone lies `shift` below zero force. The
force from there, which is the unknown f of a program with laws, has a lower and an upper bound:

    lower_i <= f_n,   f_n - s_i <= upper_i

In the dual each bound is an unknown y or z >= 0, g + (y - z) n in K*, at the price of upper'y - lower'z, and the
penalty is on g_n + y. Bonds are further columns of three after the contact points. They know no adhesion.

Everything here is dimensionless: forces in units of the mean weight, lengths in units of the mean block size.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from blockstat.program.equilibrium import Equilibrium, in_place
from blockstat.program.planar import Plane
from blockstat.typing import Floats, Ints


@dataclass(frozen=True, eq=False)
class PenaltyProgram:
    """The scaled penalty program of one equilibrium."""

    local: Floats  #: the columns of A in the rows of their blocks a and b, 0 for a support, shape (3 m, 12)
    load: Floats  #: w, shape (6 n,); with joint laws w - A E a, and the forces of the program are f + a n
    friction: Floats  #: mu of each point, shape (m,), inf allowed
    force_unit: float  #: [N]
    length_unit: float  #: [m]
    total_load: float  #: sum of the magnitudes of the loads on the blocks, force and moment of a block in one
    shift: Floats  #: a, shape (m,)
    lower: Floats  #: least f_n, shape (m,)
    upper: Floats  #: greatest f_n, inf for none, shape (m,)
    point_blocks: Ints  #: row of block a and of block b for each point, -1 for a support, shape (m, 2)
    n_points: int  #: how many of the m columns are contact points; the others are bonds
    plane: Plane | None = None  #: the reduction of a prismatic scene

    @cached_property
    def matrix(self) -> sparse.csc_array:
        """A, shape (6 n, 3 m), moments in units of force x length."""
        return in_place(self.local, self.point_blocks, len(self.load) // 6)

    @cached_property
    def planar_local(self) -> tuple[Floats, Floats]:
        """What takes planar twists of blocks a and b to (g_n, g_t) of each pair of points, shape (p, 6) each."""
        assert self.plane is not None
        return self.plane.local(self.local)

    def in_units(self, block: Floats, point: Floats) -> PenaltyProgram:
        """Return the program with the loads on each block and the forces of each point in units of their own.

        Parameters
        ----------
        block
            Unit of the loads on each block, shape (n,), in the program's units.
        point
            Unit of the forces of each point, shape (m,), in the program's units.

        Returns
        -------
        PenaltyProgram
            Its forces times `point` are forces of this program, its twists over `block` are twists of this program.
        """
        own = np.repeat(1.0 / block[self.point_blocks], 6, axis=1)  # what it is for a support meets zeros
        return replace(
            self,
            local=np.repeat(point[:, None] * own, 3, axis=0) * self.local,
            load=self.load / np.repeat(block, 6),
            shift=self.shift / point,
            lower=self.lower / point,
            upper=self.upper / point,
            plane=None,
        )

    @cached_property
    def normal_columns(self) -> sparse.csc_array:
        """A E, the columns of the normal forces of the contact points, shape (6 n, n_points)."""
        return self.matrix[:, : 3 * self.n_points : 3]

    @cached_property
    def upper_bounded(self) -> Ints:
        """Points whose force has an upper bound."""
        return np.flatnonzero(np.isfinite(self.upper))

    @cached_property
    def lower_bounded(self) -> Ints:
        """Points whose force has a lower bound above the apex of the cone."""
        return np.flatnonzero(self.lower > 0)


def penalty_program(
    eq: Equilibrium,
    friction: Floats,
    *,
    shift: Floats | None = None,
    lower: Floats | None = None,
    upper: Floats | None = None,
    plane: Plane | None = None,
) -> PenaltyProgram:
    """Scale an equilibrium to forces of the mean weight and lengths of the mean block.

    Parameters
    ----------
    eq
        The equilibrium in SI units.
    friction
        mu of each column of three, shape (n_columns,), inf allowed.
    shift, lower, upper
        Of the joint laws, shape (n_columns,) [N]; None for dry joints.
    plane
        The reduction of a prismatic scene.

    Returns
    -------
    PenaltyProgram
        With joint laws its forces are f' = f + a n, a the shift, and equilibrium reads A f' + (w - A E a) = 0.
    """
    length_unit = float(eq.length.mean())
    scale = np.array([1, 1, 1, 1 / length_unit, 1 / length_unit, 1 / length_unit])
    local = eq.local * np.tile(scale, 2)
    force_unit = float(np.linalg.norm(scale * eq.load, axis=1).mean()) or 1.0
    load = (scale * eq.load).reshape(-1) / force_unit
    total = float(np.linalg.norm(load.reshape(-1, 6), axis=1).sum()) or 1.0
    zero = np.zeros(len(friction))
    apex = zero if shift is None else shift / force_unit
    if apex.any():
        load = load - in_place(local, eq.point_blocks, eq.n_blocks)[:, ::3] @ apex
    return PenaltyProgram(
        local=local,
        load=load,
        friction=friction,
        force_unit=force_unit,
        length_unit=length_unit,
        total_load=total,
        shift=apex,
        lower=zero if lower is None else lower / force_unit,
        upper=np.full(len(friction), np.inf) if upper is None else upper / force_unit,
        point_blocks=eq.point_blocks,
        n_points=eq.n_points,
        plane=plane,
    )


def as_strong_as_the_weight(program: PenaltyProgram, load: Floats) -> tuple[Floats, float]:
    """Scale a load so that its multipliers are near one.

    Parameters
    ----------
    program
        The penalty program.
    load
        In its units, shape (6 n,).

    Returns
    -------
    load : Floats
        The load over its strength, shape (6 n,).
    strength : float
        The sum of its magnitudes, force and moment of a block in one, in those of the dead load.
    """
    unit = float(np.linalg.norm(load.reshape(-1, 6), axis=1).sum()) / program.total_load
    return load / unit, unit
