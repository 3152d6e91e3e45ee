"""Bonds at the centre of a joint: glue, dowels, clamps with a capacity in force and in moment.

A bond holds a tension and a shear of at most F each, and a bending moment and a torsion of at most M each. It enters
the programs as four more columns of three, whose cone is cut at the capacity (see `blockstat.program.penalty`):

    tension (-n, 0, 0),   shear (0, t1, t2),   bending (0, couple t1, couple t2),   torsion (0, couple n, 0).

The first of the three is the head of the cone: |second, third| <= first <= capacity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.cells import centres
from blockstat.contact.point_law import last_law
from blockstat.program.equilibrium import Columns, wrenches_between
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.contact.interfaces import Interfaces

KINDS = 4


@dataclass(frozen=True, eq=False)
class Bonds:
    """What the bonds of an assembly carry."""

    interface: Ints  #: shape (n,)
    force: Floats  #: on block b, at the centre of the joint, shape (n, 3) [N]
    moment: Floats  #: on block b, shape (n, 3) [N m]


def bonded(assembly: Assembly, interfaces: Interfaces) -> tuple[Ints, Floats]:
    """Find the joints with a bond at their centre.

    Parameters
    ----------
    assembly
        The assembly, with its joint laws.
    interfaces
        Its joints.

    Returns
    -------
    rows : Ints
        The interfaces with a bond, shape (n,).
    capacity : Floats
        The capacities of their columns, four a bond, shape (4 n,) [N]. Moments are divided by the square root of the
        joint's area.
    """
    rows, capacity = [], []
    for k, law in enumerate(last_law(assembly, interfaces)):
        arm = np.sqrt(interfaces.area[k])
        if arm and law is not None and law.bond_moment is not None and (law.bond or law.bond_moment):
            rows.append(k)
            capacity.append((law.bond, law.bond, law.bond_moment / arm, law.bond_moment / arm))
    return np.array(rows, dtype=np.int64), np.array(capacity).reshape(-1)


def bond_columns(interfaces: Interfaces, rows: Ints) -> Columns:
    """Return the columns of the bonds of some interfaces, four a bond.

    Parameters
    ----------
    interfaces
        The joints.
    rows
        Those with a bond, shape (n,).

    Returns
    -------
    Columns
        Tension, shear, bending and torsion of each bond, 4 n in all. All values are forces [N]: moments act on an arm
        of the square root of the joint's area.
    """
    n = len(rows)
    frame = interfaces.frame[rows]
    force, couple = np.zeros((n, KINDS, 3, 3)), np.zeros((n, KINDS, 3, 3))
    force[:, 0, 0] = -frame[:, 0]
    force[:, 1, 1:] = frame[:, 1:]
    arm = np.sqrt(interfaces.area[rows])[:, None, None]  # moments are forces on this arm, so that all values are [N]
    couple[:, 2, 1:] = arm * frame[:, 1:]
    couple[:, 3, 1] = arm[:, 0] * frame[:, 0]
    return Columns(
        point=np.repeat(centres(interfaces, rows), KINDS, axis=0),
        pair=np.repeat(interfaces.pair[rows], KINDS, axis=0),
        force=force.reshape(-1, 3, 3),
        couple=couple.reshape(-1, 3, 3),
    )


def bond_forces(interfaces: Interfaces, rows: Ints, values: Floats) -> Bonds:
    """Return what bonds carry.

    Parameters
    ----------
    interfaces
        The joints.
    rows
        Those with a bond, shape (n,).
    values
        Forces of the columns, shape (4 n, 3) [N].

    Returns
    -------
    Bonds
        Force and moment of each bond on block b of its joint.
    """
    columns = bond_columns(interfaces, rows)
    parts = (columns.force, columns.couple if columns.couple is not None else 0 * columns.force)
    force, moment = (np.einsum("nci,nc->ni", part, values).reshape(-1, KINDS, 3).sum(axis=1) for part in parts)
    return Bonds(rows, force, moment)


def bond_wrenches(assembly: Assembly, interfaces: Interfaces, bonds: Bonds | None) -> Floats:
    """Return what bonds do to the blocks.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        Their joints.
    bonds
        What the bonds carry; None without bonds.

    Returns
    -------
    Floats
        Wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].
    """
    if bonds is None:
        return np.zeros((assembly.n_blocks, 6))
    rows = bonds.interface
    return wrenches_between(assembly, interfaces.pair[rows], centres(interfaces, rows), bonds.force, bonds.moment)
