"""Rows of a linear system for motions of bodies: velocities of one body against another along directions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from blockstat.typing import Floats, Ints

#: Unknowns up to which a matrix is dense.
DENSE = 400


class Rows(NamedTuple):
    """Rows of velocities of b against a along directions: six entries for each side that moves."""

    number: int  #: of rows
    row: Ints  #: of each six entries, shape (k,)
    body: Ints  #: whose motion they multiply, shape (k,)
    entries: Floats  #: shape (k, 6)


def rates(body: Ints, pair: Ints, direction: Floats, place: tuple[Floats, Floats], origin: Floats) -> Rows:
    """Return rows of the velocity of block b against block a along directions.

    Parameters
    ----------
    body
        Body of each block, -1 for what does not move, shape (n_blocks,).
    pair
        Blocks a and b of each row, shape (n, 2); block -1 is at rest.
    direction
        Shape (n, 3).
    place
        Where the points of a and of b are, both of shape (n, 3) [m].
    origin
        Of the bodies, shape (n_bodies, 3) [m].

    Returns
    -------
    Rows
        One for each pair.
    """
    rows, bodies, entries = [], [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        which = np.append(body, -1)[pair[:, side]]
        own = np.flatnonzero(which >= 0)
        (arm_x, arm_y, arm_z), (x, y, z) = (place[side][own] - origin[which[own]]).T, direction[own].T
        moment = [arm_y * z - arm_z * y, arm_z * x - arm_x * z, arm_x * y - arm_y * x]
        rows.append(own)
        bodies.append(which[own])
        entries.append(sign * np.stack([x, y, z, *moment], axis=1))
    return Rows(len(pair), np.concatenate(rows), np.concatenate(bodies), np.concatenate(entries))


def summed(rows: Rows) -> Rows:
    """Return the sum of rows.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    Rows
        One row.
    """
    return rows._replace(number=1, row=0 * rows.row)


def as_matrix(parts: Sequence[Rows], n_bodies: int, length: float) -> Floats | sparse.csr_array:
    """Return rows one below the other as a matrix.

    Parameters
    ----------
    parts
        The rows.
    n_bodies
        Bodies of three displacements and three rotations each.
    length
        The unit of rotations [m].

    Returns
    -------
    Floats or sparse.csr_array
        Shape (n, 6 n_bodies): dense if small.
    """
    first = np.concatenate([[0], np.cumsum([part.number for part in parts])])
    row = np.concatenate([start + part.row for start, part in zip(first, parts, strict=False)])
    body = np.concatenate([part.body for part in parts])
    entries = np.concatenate([part.entries for part in parts]) / np.repeat([1.0, length], 3)
    row, column = np.repeat(row, 6), (6 * body[:, None] + np.arange(6)).reshape(-1)
    shape = (int(first[-1]), 6 * n_bodies)
    if shape[1] > DENSE:
        return sparse.csr_array((entries.reshape(-1), (row, column)), shape=shape)
    flat: Any = np.bincount(row * shape[1] + column, entries.reshape(-1), shape[0] * shape[1])
    dense: Floats = flat.reshape(shape)
    return dense
