"""Blocks that no contact holds in place, whatever its forces: they rest on points and edges and can turn about them.

Contacts hold a block when every motion of it moves a contact point: `A'u = 0` has no solution but u = 0. A patch fixes
two blocks to each other, and so do three points that do not lie on a line. Such blocks are joined to bodies first, the
ground among them. Only what is left, in most assemblies nothing, is asked for motions.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from blockstat.contact.interfaces import Interfaces
from blockstat.geometry.components import connected_components
from blockstat.typing import Floats, Ints

#: Points within this fraction of their distances of a line lie on it, as patches so narrow are edges
#: (`blockstat.contact.interfaces.WIDTH`). Motions that move contact points so much less than blocks do not move them.
ON_A_LINE = 1e-6


def loose_blocks(support: np.ndarray, interfaces: Interfaces, held: Ints, fixed: Ints) -> Ints:
    """Find the blocks that can move without moving any contact point.

    Parameters
    ----------
    support
        Which blocks cannot move, shape (n_blocks,).
    interfaces
        The joints.
    held
        The blocks that a chain of joints ties to a support, shape (n,).
    fixed
        Interfaces that hold their blocks together at whatever points they have, as bonds do.

    Returns
    -------
    Ints
        Their numbers, ascending.
    """
    flat = interfaces.area > 0
    flat[fixed] = True
    if flat.all() or not len(held):
        return np.empty(0, dtype=np.int64)
    narrow = ~flat[interfaces.point_interface]
    pair, point = interfaces.pair[interfaces.point_interface[narrow]], interfaces.point[narrow]
    body = _bodies(support, interfaces.pair[flat], pair, point)
    ground = body[np.argmax(support)]
    free = np.setdiff1d(body[held], ground)
    if not len(free):
        return np.empty(0, dtype=np.int64)
    across = (body[pair[:, 0]] != body[pair[:, 1]]) & np.isin(body[pair], free).any(axis=1)
    rates = _rates(free, body[pair[across]], point[across])
    value, vector = np.linalg.eigh((rates.T @ rates).toarray())
    still = vector[:, value <= ON_A_LINE**2 * value[-1]].reshape(len(free), -1)
    moving = free[np.linalg.norm(still, axis=1) > ON_A_LINE]
    return held[np.isin(body[held], moving)]


def _bodies(support: np.ndarray, joined: Ints, pair: Ints, point: Floats) -> Ints:
    """The body of each block; pairs of bodies are joined while three points between them do not lie on a line."""
    grounded = np.flatnonzero(support)
    joined = np.concatenate([np.column_stack([np.full(len(grounded), grounded[0]), grounded]), joined])
    while True:
        _, body = connected_components(len(support), joined)
        sides = np.sort(body[pair], axis=1)
        order = np.lexsort((sides[:, 1], sides[:, 0]))
        runs = np.split(order, np.flatnonzero((np.diff(sides[order], axis=0) != 0).any(axis=1)) + 1)
        tied = [run[0] for run in runs if sides[run[0], 0] != sides[run[0], 1] and _spread(point[run])]
        if not tied:
            return body
        joined = np.concatenate([joined, pair[tied]])


def _spread(point: Floats) -> bool:
    """Whether some three points do not lie on a line."""
    if len(point) < 3:
        return False
    values = np.linalg.svd(point - point.mean(axis=0), compute_uv=False)
    return bool(values[1] > ON_A_LINE * values[0])


def _rates(free: Ints, sides: Ints, point: Floats) -> sparse.csr_array:
    """Relative velocities at points between bodies, for motions of the free ones about the middle of their points.

    sides : the bodies at each point, shape (p, 2). Returns shape (3 p, 6 k); rotations are in units of one over the
    reach of the points of a body.
    """
    column = np.searchsorted(free, sides)
    ours = np.isin(sides, free)
    rows, columns, values = [], [], []
    for k in range(len(free)):
        which, side = np.nonzero(ours & (column == k))
        arm = point[which] - point[which].mean(axis=0)
        arm /= np.linalg.norm(arm, axis=1).max(initial=0.0) or 1.0
        turned = np.cross(np.eye(3), arm[:, None, :]).swapaxes(1, 2)
        sign = np.where(side == 1, 1.0, -1.0)[:, None, None]
        values.append((sign * np.concatenate([np.broadcast_to(np.eye(3), turned.shape), turned], axis=2)).ravel())
        rows.append(np.repeat(3 * which[:, None] + np.arange(3), 6, axis=1).ravel())
        columns.append(np.broadcast_to(6 * k + np.arange(6), turned.shape[:2] + (6,)).ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_array(entries, shape=(3 * len(point), 6 * len(free)))
