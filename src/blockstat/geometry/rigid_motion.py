"""Velocities of points that are fixed to rigid bodies."""

from __future__ import annotations

import numpy as np

from blockstat.geometry.polyhedron import Polyhedra
from blockstat.typing import Floats, Ints


def point_velocity(blocks: Polyhedra, twist: Floats, block: Ints, point: Floats) -> Floats:
    """Return the velocity of points fixed to blocks, v + omega x (p - centroid).

    Parameters
    ----------
    blocks : Polyhedra
        The blocks, an assembly for instance.
    twist : array, shape (n_blocks, 6)
        Velocity of the centroid [m/s] and angular velocity [rad/s] of each block.
    block : array of int, shape (n_points,)
        The block that each point is fixed to.
    point : array, shape (n_points, 3)
        The points [m].

    Returns
    -------
    array, shape (n_points, 3)
        Velocity of each point [m/s].
    """
    velocity: Floats = twist[block, :3] + np.cross(twist[block, 3:], point - blocks.centroid[block])
    return velocity
