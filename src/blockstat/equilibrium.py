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
class Equilibrium:
    """The matrices of one set of free blocks and contact points."""

    matrix: sparse.csr_array  #: A, shape (6 n_free, 3 n_points)
    load: Floats  #: w, shape (n_free, 6) [N, N m]
    blocks: Ints  #: index of each free block in the assembly, shape (n_free,)
    points: Ints  #: index of each contact point in the interfaces, shape (n_points,)
    point_blocks: Ints  #: row of block a and of block b for each point, -1 for a support, shape (n_points, 2)
    length: Floats  #: size of each free block, shape (n_free,) [m]; the unit of moments and rotations

    @property
    def n_blocks(self) -> int:
        return len(self.blocks)

    @property
    def n_points(self) -> int:
        return len(self.points)


def equilibrium(assembly: Assembly, interfaces: Interfaces, load: Floats, blocks: Ints, points: Ints) -> Equilibrium:
    """Assemble A for some free blocks and contact points.

    load : wrench on each block of the assembly, shape (n_blocks, 6) [N, N m].
    """
    row = np.full(assembly.n_blocks, -1)
    row[blocks] = np.arange(len(blocks))
    interface = interfaces.point_interface[points]
    frame = interfaces.frame[interface]
    pair = interfaces.pair[interface]
    point_blocks = row[pair]

    data, rows, cols = [], [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        live = np.flatnonzero(point_blocks[:, side] >= 0)
        arm = interfaces.point[points[live]] - assembly.centroid[pair[live, side]]
        force = np.swapaxes(frame[live], 1, 2)
        moment = np.cross(arm[:, None, :], frame[live]).swapaxes(1, 2)
        data.append(sign * np.concatenate([force, moment], axis=1))
        shape = (len(live), 6, 3)
        rows.append(np.broadcast_to(6 * point_blocks[live, side, None, None] + np.arange(6)[:, None], shape))
        cols.append(np.broadcast_to(3 * live[:, None, None] + np.arange(3), shape))
    flat = [np.concatenate([part.reshape(-1) for part in parts]) for parts in (data, rows, cols)]
    matrix = sparse.coo_array((flat[0], (flat[1], flat[2])), shape=(6 * len(blocks), 3 * len(points))).tocsr()
    return Equilibrium(matrix, load[blocks], blocks, points, point_blocks, assembly.size[blocks])


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
