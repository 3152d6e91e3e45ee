"""Equilibrium of the free blocks under contact forces: A f + w = 0.

Contact point i of interface (a, b) carries the force f_i = (f_n, f_1, f_2) [N] in the frame of the interface,
acting on b; its opposite acts on a. Row block k of A holds the force [N] and then the moment about the
centroid [N m] of the k-th free block. Supports have no rows (Whiting, Ochsendorf & Durand 2009, Eq. 1-3).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from blockstat.contact import Interfaces
from blockstat.polyhedron import Floats, Ints

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

    matrix: sparse.csr_array  #: A, shape (6 n_free, 3 n_columns)
    load: Floats  #: w, shape (n_free, 6) [N, N m]
    blocks: Ints  #: index of each free block in the assembly, shape (n_free,)
    points: Ints  #: index of each contact point in the interfaces, shape (n_points,)
    point_blocks: Ints  #: row of block a and of block b for each column of three, -1 for a support, (n_columns, 2)
    length: Floats  #: size of each free block, shape (n_free,) [m]; the unit of moments and rotations
    columns: tuple[Columns, ...]  #: the contact points, then the bonds

    @property
    def n_blocks(self) -> int:
        return len(self.blocks)

    @property
    def n_points(self) -> int:
        return len(self.points)

    @property
    def n_columns(self) -> int:
        """Contact points and the columns of three of the bonds."""
        return len(self.point_blocks)


def equilibrium(
    assembly: Assembly,
    interfaces: Interfaces,
    load: Floats,
    blocks: Ints,
    points: Ints,
    bonds: Columns | None = None,
) -> Equilibrium:
    """Assemble A for some free blocks, contact points and bonds.

    load : wrench on each block of the assembly, shape (n_blocks, 6) [N, N m].
    """
    row = np.full(assembly.n_blocks, -1)
    row[blocks] = np.arange(len(blocks))
    interface = interfaces.point_interface[points]
    contacts = Columns(interfaces.point[points], interfaces.pair[interface], interfaces.frame[interface])
    parts = (contacts,) if bonds is None else (contacts, bonds)
    matrices = [_matrix(assembly, part, row, len(blocks)) for part in parts]
    matrix = matrices[0] if bonds is None else sparse.csr_array(sparse.hstack(matrices))
    pairs = np.concatenate([part.pair for part in parts])
    return Equilibrium(matrix, load[blocks], blocks, points, row[pairs], assembly.size[blocks], parts)


def _matrix(assembly: Assembly, columns: Columns, row: Ints, n_blocks: int) -> sparse.csr_array:
    """Columns of A, shape (6 n_blocks, 3 n); row : of each block of the assembly in A, -1 for none."""
    point_blocks = row[columns.pair]
    data, block, point = [], [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        live = np.flatnonzero(point_blocks[:, side] >= 0)
        arm = columns.point[live] - assembly.centroid[columns.pair[live, side]]
        moment = np.cross(arm[:, None, :], columns.force[live])
        if columns.couple is not None:
            moment = moment + columns.couple[live]
        data.append(sign * np.concatenate([columns.force[live], moment], axis=2).swapaxes(1, 2))
        block.append(point_blocks[live, side])
        point.append(live)
    blocks, points = np.concatenate(block), np.concatenate(point)
    order = np.lexsort((points, blocks))
    start = np.searchsorted(blocks[order], np.arange(n_blocks + 1))
    values = np.concatenate(data)[order]
    shape = (6 * n_blocks, 3 * len(point_blocks))
    matrix = sparse.bsr_array((values, points[order], start), shape=shape, blocksize=(6, 3)).tocsr()
    matrix.eliminate_zeros()  # two thirds of the entries where blocks stand along the axes
    return matrix


def column_rates(assembly: Assembly, eq: Equilibrium, motion: Floats) -> Floats:
    """Velocity of block b against block a along each column of three, shape (n_columns, 3).

    motion : velocity and rotation of every block, supports too, shape (n_blocks, 6) [m/s, rad/s].
    """
    rates = []
    for columns in eq.columns:
        relative, turning = 0.0, 0.0
        for side, sign in ((0, -1.0), (1, 1.0)):
            block = columns.pair[:, side]
            arm = columns.point - assembly.centroid[block]
            relative = relative + sign * (motion[block, :3] + np.cross(motion[block, 3:], arm))
            turning = turning + sign * motion[block, 3:]
        rate = np.einsum("nij,nj->ni", columns.force, relative)
        if columns.couple is not None:
            rate = rate + np.einsum("nij,nj->ni", columns.couple, turning)
        rates.append(rate)
    return np.concatenate(rates)


def weight(assembly: Assembly) -> Floats:
    """Weight of each block as a wrench about its centroid, shape (n_blocks, 6) [N, N m]."""
    load = np.zeros((assembly.n_blocks, 6))
    load[:, :3] = assembly.mass[:, None] * assembly.gravity
    return load


def split_floating(assembly: Assembly, interfaces: Interfaces) -> tuple[Ints, Ints]:
    """Free blocks that a chain of interfaces ties to a support, and those that nothing holds."""
    from scipy.sparse.csgraph import connected_components

    n = assembly.n_blocks
    pair = interfaces.pair
    graph = sparse.coo_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    held = np.isin(label, label[assembly.support])
    return np.flatnonzero(held & ~assembly.support), np.flatnonzero(~held)
