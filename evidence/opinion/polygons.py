"""Linear programs of the second opinion: equilibrium with polygons inside and outside the cones of friction."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csc_array

SIDES = 64  #: of each polygon, which is 0.12 % off at its sides


def columns(place, frame, block, free, centre, size):
    """Equilibrium of the free blocks under forces at points, shape (6 n_free, 3 m); moments over the size of a block.

    place : where the forces act, shape (m, 3); frame : their axes, (m, 3, 3); block : what they push apart, (m, 2)
    """
    row = np.full(len(centre), -1)
    row[free] = np.arange(len(free))
    values, rows, places = [], [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        own = np.flatnonzero(row[block[:, side]] >= 0)
        body = block[own, side]
        arm = (place[own] - centre[body]) / size[body][:, None]
        part = sign * np.concatenate([frame[own], np.cross(arm[:, None], frame[own])], axis=2)
        values.append(part.reshape(-1))
        rows.append(np.broadcast_to((6 * row[body])[:, None, None] + np.arange(6), part.shape).reshape(-1))
        places.append(np.broadcast_to((3 * own)[:, None, None] + np.arange(3)[:, None], part.shape).reshape(-1))
    entry = np.concatenate(values), (np.concatenate(rows), np.concatenate(places))
    return coo_array(entry, shape=(6 * len(free), 3 * len(place))).tocsc()


def cones(mu, *, inside=True):
    """Rows that are at most 0 where forces lie in a polygon inside their cones, or outside them, shape (k, 3 m)."""
    own = np.flatnonzero(np.isfinite(mu))
    reach = np.cos(np.pi / SIDES) if inside else 1.0
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    row = np.arange(SIDES * len(own)).reshape(SIDES, -1)
    values, rows, places = [], [], []
    for k, part in enumerate((-reach * mu[own][None] + 0 * angle[:, None], np.cos(angle), np.sin(angle))):
        values.append(np.broadcast_to(part if k == 0 else part[:, None], row.shape).reshape(-1))
        rows.append(row.reshape(-1))
        places.append(np.broadcast_to(3 * own + k, row.shape).reshape(-1))
    entry = np.concatenate(values), (np.concatenate(rows), np.concatenate(places))
    return csc_array(coo_array(entry, shape=(row.size, 3 * len(mu))))


def bounds(m):
    """Of m contact forces, whose normal parts push."""
    return [(0, None) if k % 3 == 0 else (None, None) for k in range(3 * m)]
