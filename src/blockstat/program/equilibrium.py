"""Equilibrium of the free blocks under contact forces: A f + w = 0.

Contact point i of interface (a, b) carries the force f_i = (f_n, f_1, f_2) [N] in the frame of the interface,
acting on b; its opposite acts on a. Row block k of A holds the force [N] and then the moment about the
centroid [N m] of the k-th free block. Supports have no rows (Whiting, Ochsendorf & Durand 2009, Eq. 1-3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from blockstat.contact.interfaces import Interfaces
from blockstat.geometry.components import connected_components
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True, eq=False)
class Columns:
    """Forces between two blocks, in threes: what a unit of each does to block b at a point (and its opposite to a)."""

    point: Floats  #: where the force acts, shape (n, 3) [m]
    pair: Ints  #: blocks a and b, shape (n, 2)
    force: Floats  #: shape (n, 3, 3), row c is the force of component c
    couple: Floats | None = None  #: moment of component c besides that of its force, shape (n, 3, 3)


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """The matrices of one set of free blocks and contact points; bonds, if any, follow the points."""

    local: Floats  #: the columns of A in the rows of their blocks a and b, 0 for a support, shape (3 n_columns, 12)
    load: Floats  #: w, shape (n_free, 6) [N, N m]
    blocks: Ints  #: index of each free block in the assembly, shape (n_free,)
    points: Ints  #: index of each contact point in the interfaces, shape (n_points,)
    point_blocks: Ints  #: row of block a and of block b for each column of three, -1 for a support, (n_columns, 2)
    length: Floats  #: size of each free block, shape (n_free,) [m]; the unit of moments and rotations
    columns: tuple[Columns, ...]  #: the contact points, then the bonds, then the ties

    @cached_property
    def matrix(self) -> sparse.csc_array:
        """A, shape (6 n_free, 3 n_columns)."""
        return in_place(self.local, self.point_blocks, self.n_blocks)

    @property
    def n_blocks(self) -> int:
        """The number of free blocks."""
        return len(self.blocks)

    @property
    def n_points(self) -> int:
        """The number of contact points."""
        return len(self.points)

    @property
    def n_columns(self) -> int:
        """Contact points and the columns of three of the bonds and the ties."""
        return len(self.point_blocks)


def equilibrium(
    assembly: Assembly,
    interfaces: Interfaces,
    load: Floats,
    blocks: Ints,
    points: Ints,
    more: Sequence[Columns] = (),
) -> Equilibrium:
    """Assemble A for some free blocks, contact points and bonds.

    Parameters
    ----------
    assembly
        The blocks.
    interfaces
        The joints.
    load
        Wrench on each block of the assembly about its centroid, shape (n_blocks, 6) [N, N m].
    blocks
        The free blocks, shape (n_free,).
    points
        The contact points, shape (n_points,).
    more
        Columns after those of the contact points: of bonds and of ties.

    Returns
    -------
    Equilibrium
        A f + w = 0 in SI units.

    References
    ----------
    Whiting, Ochsendorf & Durand: Procedural modeling of structurally-sound masonry buildings, 2009, Eq. 1-3.
    """
    row = np.full(assembly.n_blocks, -1)
    row[blocks] = np.arange(len(blocks))
    interface = interfaces.point_interface[points]
    contacts = Columns(interfaces.point[points], interfaces.pair[interface], interfaces.frame[interface])
    parts = (contacts, *more)
    local = np.concatenate([_local(assembly, part, row) for part in parts])
    pairs = np.concatenate([part.pair for part in parts])
    return Equilibrium(local, load[blocks], blocks, points, row[pairs], assembly.size[blocks], parts)


def _local(assembly: Assembly, columns: Columns, row: Ints) -> Floats:
    """Columns of A in the rows of their blocks, shape (3 n, 12); row : of each block of the assembly in A, or -1."""
    local = np.zeros((len(columns.pair), 3, 2, 6))
    for side, sign in ((0, -1.0), (1, 1.0)):
        block = columns.pair[:, side]
        arm = columns.point - assembly.centroid[block]
        moment = np.cross(arm[:, None, :], columns.force)
        if columns.couple is not None:
            moment = moment + columns.couple
        sign = np.where(row[block] >= 0, sign, 0.0)[:, None, None]
        np.multiply(sign, columns.force, out=local[:, :, side, :3])
        np.multiply(sign, moment, out=local[:, :, side, 3:])
    return local.reshape(-1, 12)


def in_place(local: Floats, point_blocks: Ints, n_blocks: int) -> sparse.csc_array:
    """Assemble A from its columns in the rows of their blocks.

    Parameters
    ----------
    local
        Entries of each column in the rows of its blocks a and b, k columns for each point and w rows for each block:
        3 and 6 in space. Shape (k n, 2 w).
    point_blocks
        Row of block a and of block b, -1 for a support, shape (n, 2).
    n_blocks
        The number of free blocks.

    Returns
    -------
    sparse.csc_array
        A, shape (w n_blocks, k n), with sorted indices.
    """
    width, columns = local.shape[1] // 2, len(local) // max(len(point_blocks), 1)
    turned = point_blocks[:, 0] > point_blocks[:, 1]
    first = width * np.sort(point_blocks, axis=1).astype(np.int32)
    row = (first[:, :, None] + np.arange(width, dtype=np.int32)).reshape(-1, 2 * width)
    if turned.any():
        local = local.reshape(-1, columns, 2, width)
        local = np.where(turned[:, None, None, None], local[:, :, ::-1], local).reshape(-1, 2 * width)
    there = local != 0  # a third of the entries where blocks stand along the axes
    start = np.concatenate([[0], np.cumsum(there.sum(axis=1))]).astype(np.int32)
    index = np.repeat(row, columns, axis=0)[there]
    return sparse.csc_array((local[there], index, start), shape=(width * n_blocks, len(local)))


def weight(assembly: Assembly) -> Floats:
    """Return the weight of each block as a wrench about its centroid.

    Parameters
    ----------
    assembly
        The blocks, with their masses [kg] and gravity [m/s2].

    Returns
    -------
    Floats
        Shape (n_blocks, 6) [N, N m]; the moments are 0.
    """
    load = np.zeros((assembly.n_blocks, 6))
    load[:, :3] = assembly.mass[:, None] * assembly.gravity
    return load


def wrenches_between(
    assembly: Assembly, pair: Ints, point: Floats, force: Floats, couple: Floats | float = 0.0
) -> Floats:
    """Return what forces between two blocks do to both.

    Parameters
    ----------
    assembly
        The blocks.
    pair
        Blocks a and b, shape (n, 2).
    point
        Where the forces act, shape (n, 3) [m].
    force
        On block b, their opposites on block a, shape (n, 3) [N].
    couple
        Moment on block b besides that of the force, shape (n, 3) [N m].

    Returns
    -------
    Floats
        Wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].
    """
    load = np.zeros((assembly.n_blocks, 6))
    for side, sign in ((0, -1.0), (1, 1.0)):
        block = pair[:, side]
        moment = np.cross(point - assembly.centroid[block], force) + couple
        np.add.at(load, block, sign * np.hstack([force, moment]))
    return load


def split_floating(assembly: Assembly, pairs: Ints) -> tuple[Ints, Ints]:
    """Split the free blocks into those that a chain of joints ties to a support and those that nothing holds.

    Parameters
    ----------
    assembly
        The blocks.
    pairs
        Blocks that joints or ties connect, shape (n, 2).

    Returns
    -------
    held, floating : Ints
        Indices of the blocks.
    """
    _, label = connected_components(assembly.n_blocks, pairs)
    held = np.isin(label, label[assembly.support])
    return np.flatnonzero(held & ~assembly.support), np.flatnonzero(~held)
