"""Triangles of polygonal faces, concave ones included."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

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
        local = corners - corners.mean(axis=0)
        normal = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
        axis = int(np.abs(normal).argmax())
        flat = np.delete(local, axis, axis=1)
        if (normal[axis] > 0) == (axis == 1):
            flat = flat[:, ::-1]
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
