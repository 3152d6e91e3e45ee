"""Faces seen in a plane: contact frames, planar coordinates, convexity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.polyhedron import next_in_face
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A corner may turn the wrong way by this much (sine of the angle): rounding, not a notch.
REFLEX = 1e-6


def convex_faces(assembly: Assembly) -> np.ndarray:
    """Return which faces are convex polygons.

    Parameters
    ----------
    assembly : Assembly
        The blocks.

    Returns
    -------
    array of bool, shape (n_faces,)
        True for a convex face.
    """
    corners = assembly.vertices[assembly.face_vertices]
    following = next_in_face(assembly.face_start)
    edge = corners[following] - corners
    length = np.linalg.norm(edge, axis=1)
    edge = edge / np.where(length > 0, length, 1.0)[:, None]
    normal = np.repeat(assembly.planes.normal, np.diff(assembly.face_start), axis=0)
    turn = np.einsum("ij,ij->i", np.cross(edge, edge[following]), normal)
    return np.minimum.reduceat(turn, assembly.face_start[:-1]) >= -REFLEX


def frames(normal: Floats) -> Floats:
    """Return right-handed frames for unit normals.

    Parameters
    ----------
    normal : array of float, shape (n, 3)
        Unit normals.

    Returns
    -------
    array of float, shape (n, 3, 3)
        Rows are the normal, t1 and t2.
    """
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    t1: Floats = np.cross(axis, normal)
    t1 = t1 / np.linalg.norm(t1, axis=1)[:, None]
    t2: Floats = np.cross(normal, t1)
    return np.stack([normal, t1, t2], axis=1)


def planar(assembly: Assembly, face: Ints, frame: Floats, origin: Floats, width: int) -> Floats:
    """Return the corners of faces in the planes of contact patches.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    face : array of int, shape (n,)
        Numbers of the faces.
    frame : array of float, shape (n, 3, 3)
        Rows n, t1, t2 of each plane.
    origin : array of float, shape (n, 3)
        A point of each plane [m].
    width : int
        Corners a row; faces with fewer repeat their last one.

    Returns
    -------
    array of float, shape (n, width, 2)
        Corners along t1 and t2 from the origin [m].
    """
    first, last = assembly.face_start[face], assembly.face_start[face + 1] - 1
    index = np.minimum(first[:, None] + np.arange(width), last[:, None])
    local: Floats = assembly.vertices[assembly.face_vertices[index]] - origin[:, None]
    across: Floats = frame[:, 1:].swapaxes(1, 2)
    return local @ across
