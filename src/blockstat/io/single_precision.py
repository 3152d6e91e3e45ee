"""Seven digits: what single precision, as GLB, STL and PLY have it, makes of corners."""

from __future__ import annotations

import numpy as np

from blockstat.typing import Floats

SINGLE = float(np.finfo(np.float32).eps)
#: Corners that move by no more than this fraction of the extent of all are as near the origin as seven digits need.
NEAR = 1e-6


def rounding_of(corners: Floats) -> float:
    """Return how far single precision may have moved one of some corners out of the plane of others.

    Parameters
    ----------
    corners : array of float, shape (n, 3)
        Corners as a file has them [m].

    Returns
    -------
    float
        Distance [m]; zero where not all of the corners are in single precision.
    """
    if (corners != corners.astype(np.float32)).any():
        return 0.0
    return 2 * SINGLE * float(np.abs(corners).max(initial=0.0))


def moved_far_away(corners: Floats) -> float:
    """Return how far single precision will move corners that are far from the origin.

    Parameters
    ----------
    corners : array of float, shape (n, 3)
        All corners of an assembly [m].

    Returns
    -------
    float
        The furthest that a coordinate moves [m]; zero where that is no more than `NEAR` of their extent.
    """
    moved = float(np.abs(corners - corners.astype(np.float32)).max())
    return moved if moved > NEAR * float(np.ptp(corners, axis=0).max()) else 0.0
