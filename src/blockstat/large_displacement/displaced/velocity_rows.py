"""Rows of constraint equations: relative velocities of points of rigid bodies, linear in the motions of the bodies.

A body has a velocity v of its origin and a rotation rate w. The velocity of its point at x along a direction d is

    d . (v + w x (x - o)) = d . v + ((x - o) x d) . w,

with o the body's origin. A row has these six coefficients for each of the two bodies that it concerns.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from blockstat.typing import Floats, Ints

#: Largest number of unknowns of a dense matrix. Chosen: small systems are solved by dense least squares.
MAX_DENSE_UNKNOWNS = 400


class VelocityRows(NamedTuple):
    """Rows of relative velocities: six coefficients for each side of a row whose body moves."""

    number: int  #: of rows
    row: Ints  #: the row of each six coefficients, shape (k,)
    body: Ints  #: the body that they multiply, shape (k,)
    coefficients: Floats  #: shape (k, 6)


def relative_velocity_rows(
    body: Ints, pair: Ints, direction: Floats, place: tuple[Floats, Floats], origin: Floats
) -> VelocityRows:
    """Return rows of the velocity of block b relative to block a along directions.

    Parameters
    ----------
    body
        Rigid body of each block, -1 for a block that does not move, shape (n_blocks,).
    pair
        Blocks a and b of each row, shape (n, 2); -1 stands for a point at rest.
    direction
        Shape (n, 3).
    place
        Displaced points of a and of b, both of shape (n, 3) [m].
    origin
        Of the bodies, shape (n_bodies, 3) [m].

    Returns
    -------
    VelocityRows
        One row for each pair.
    """
    which = np.append(body, -1)[pair.T].reshape(-1)  # first of all a, then of all b
    own = np.flatnonzero(which >= 0)
    row, moving = own % len(pair) if len(pair) else own, which[own]
    arm_x, arm_y, arm_z = (np.concatenate(place)[own] - origin[moving]).T
    coefficients = np.empty((6, len(own)))
    x, y, z = coefficients[:3] = direction[row].T * np.where(own < len(pair), -1.0, 1.0)
    coefficients[3], coefficients[4] = arm_y * z - arm_z * y, arm_z * x - arm_x * z
    coefficients[5] = arm_x * y - arm_y * x
    return VelocityRows(len(pair), row, moving, coefficients.T)


def summed(rows: VelocityRows) -> VelocityRows:
    """Return the sum of all rows as one row.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    VelocityRows
        One row.
    """
    return rows._replace(number=1, row=0 * rows.row)


def as_matrix(parts: Sequence[VelocityRows], n_bodies: int, length: float) -> Floats | sparse.csr_array:
    """Return rows one below the other as a matrix.

    Parameters
    ----------
    parts
        The rows.
    n_bodies
        Number of bodies; each has three displacements and three rotations.
    length
        The unknown of a rotation is its angle times this length [m], so that all unknowns are lengths.

    Returns
    -------
    Floats or sparse.csr_array
        Shape (n, 6 n_bodies); dense up to `MAX_DENSE_UNKNOWNS` columns.
    """
    first = np.concatenate([[0], np.cumsum([part.number for part in parts])])
    row = np.concatenate([start + part.row for start, part in zip(first, parts, strict=False)])
    body = np.concatenate([part.body for part in parts])
    entries = np.concatenate([part.coefficients for part in parts]) / np.repeat([1.0, length], 3)
    row, column = np.repeat(row, 6), (6 * body[:, None] + np.arange(6)).reshape(-1)
    shape = (int(first[-1]), 6 * n_bodies)
    if shape[1] > MAX_DENSE_UNKNOWNS:
        return sparse.csr_array((entries.reshape(-1), (row, column)), shape=shape)
    flat: Any = np.bincount(row * shape[1] + column, entries.reshape(-1), shape[0] * shape[1])
    dense: Floats = flat.reshape(shape)
    return dense
