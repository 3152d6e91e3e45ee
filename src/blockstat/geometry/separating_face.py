"""Which face of one block has another block wholly beyond it."""

from __future__ import annotations

import numpy as np

from blockstat.geometry.polyhedron import FacePlanes
from blockstat.typing import Floats, Ints

#: Rows (face of one block, corner of the other) that are held in memory at once.
CHUNK = 2_000_000


def face_separation(
    vertices: Floats,
    vertex_start: Ints,
    planes: FacePlanes,
    face_block: Ints,
    pairs: Ints,
    faces: np.ndarray | None = None,
) -> Floats:
    """Return how far each second block lies wholly beyond one face of the first.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Vertices of all blocks, one block after the other [m].
    vertex_start : array of int, shape (n_blocks + 1,)
        Where the vertices of each block begin.
    planes : FacePlanes
        Planes of all faces.
    face_block : array of int, shape (n_faces,)
        The block of each face, ascending.
    pairs : array of int, shape (n_pairs, 2)
        The first and the second block of each pair.
    faces : array of bool, shape (n_faces,), optional
        Which faces may separate; all when None.

    Returns
    -------
    array of float, shape (n_pairs,)
        Distance of the nearest corner in front of the face that separates best [m]. It is negative when the second
        block reaches behind every face, and -inf when the first has no face that may separate.
    """
    if not len(pairs):
        return np.empty(0)
    first_face = np.searchsorted(face_block, np.arange(len(vertex_start)))
    work = np.cumsum(np.diff(first_face)[pairs[:, 0]] * np.diff(vertex_start)[pairs[:, 1]])
    chunks = np.split(np.arange(len(pairs)), np.searchsorted(work, np.arange(CHUNK, work[-1], CHUNK)))
    allowed = np.ones(len(face_block), dtype=bool) if faces is None else faces
    return np.concatenate(
        [_chunk(vertices, vertex_start, planes, first_face, pairs[rows], allowed) for rows in chunks if len(rows)]
    )


def _chunk(
    vertices: Floats,
    vertex_start: Ints,
    planes: FacePlanes,
    first_face: Ints,
    pairs: Ints,
    allowed: np.ndarray,
) -> Floats:
    n_faces = np.diff(first_face)[pairs[:, 0]]
    row_start = np.cumsum(n_faces) - n_faces
    row = np.repeat(np.arange(len(pairs)), n_faces)
    face = np.arange(len(row)) - row_start[row] + first_face[pairs[row, 0]]
    n_vertices = np.diff(vertex_start)[pairs[row, 1]]
    start = np.cumsum(n_vertices) - n_vertices
    vertex = np.arange(n_vertices.sum()) - np.repeat(start - vertex_start[pairs[row, 1]], n_vertices)
    plane = np.repeat(face, n_vertices)
    height = np.einsum("ij,ij->i", vertices[vertex] - planes.centre[plane], planes.normal[plane])
    lowest = np.where(allowed[face], np.minimum.reduceat(height, start), -np.inf)
    return np.maximum.reduceat(lowest, row_start)
