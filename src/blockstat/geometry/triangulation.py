"""Triangles of polygonal faces, concave ones included."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.geometry.polyhedron import next_in_face
from blockstat.typing import Floats, Ints


def triangulate(vertices: Floats, faces: Sequence[Ints]) -> Ints:
    """Cut faces into triangles by ear clipping.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Vertices [m].
    faces : sequence of arrays of int
        Vertex indices of each face.

    Returns
    -------
    array of int, shape (n, 3)
        Vertex indices of the triangles, oriented like their faces.
    """
    triangles = []
    for face in faces:
        face = np.asarray(face)
        if len(face) == 3:
            triangles.append(face[None])
            continue
        corners = vertices[face]
        local = corners - corners.sum(axis=0) / len(corners)
        following = np.concatenate([local[1:], local[:1]])
        # Twice the vector area, by sums of products: numpy.cross takes several times as long on one face.
        moment = local.T @ following
        normal = [moment[1, 2] - moment[2, 1], moment[2, 0] - moment[0, 2], moment[0, 1] - moment[1, 0]]
        axis = max(range(3), key=lambda k: abs(normal[k]))
        u, v = ((1, 2), (0, 2), (0, 1))[axis]
        flat = local[:, [v, u] if (normal[axis] > 0) == (axis == 1) else [u, v]]
        triangles.append(face[_ears(np.ascontiguousarray(flat))])
    return np.concatenate(triangles)


def _ears(polygon: Floats) -> Ints:
    import mapbox_earcut

    ring = np.array([len(polygon)], dtype=np.uint32)
    triangles = mapbox_earcut.triangulate_float64(polygon, ring).reshape(-1, 3).astype(np.int64)
    a, b, c = (polygon[triangles[:, k]] for k in range(3))
    turn = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    triangles[turn < 0] = triangles[turn < 0][:, ::-1]
    return triangles


def fans(corners: Floats, face_start: Ints) -> Floats:
    """Cut faces into triangles about the mean of their corners.

    Parameters
    ----------
    corners : array of float, shape (n_corners, 3)
        Corners of the faces, one face after the other [m].
    face_start : array of int, shape (n_faces + 1,)
        Where the corners of each face begin, and their number at the end.

    Returns
    -------
    array of float, shape (n_corners, 3, 3)
        Corners of the triangles; of a concave face some look the other way, and their signed sum is the face.
    """
    count = np.diff(face_start)
    centre = np.add.reduceat(corners, face_start[:-1], axis=0) / count[:, None]
    return np.stack([corners, corners[next_in_face(face_start)], np.repeat(centre, count, axis=0)], axis=1)
