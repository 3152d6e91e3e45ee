"""Which faces have their block behind them, and keep it apart from another."""

from __future__ import annotations

import numpy as np

from blockstat.geometry.polyhedron import Polyhedra
from blockstat.typing import Floats, Ints

#: Normals nearer to each other than this cosine (15 degrees) do not count as two.
APART = float(np.cos(np.deg2rad(15.0)))
#: Rows (face of one block, corner of the other) that are held in memory at once.
CHUNK = 2_000_000


def protrusions(blocks: Polyhedra) -> Floats:
    """Return how far the last corner of its block lies in front of each face.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.

    Returns
    -------
    array of float, shape (n_faces,)
        Distances [m]; zero but for rounding, or the warp of the face, where the block is convex.
    """
    planes, first_vertex = blocks.planes, blocks.vertex_start
    first_face = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    n_vertices, n_faces = np.diff(first_vertex), np.diff(first_face)
    kind = n_vertices * (n_faces.max(initial=0) + 1) + n_faces
    found = np.empty(len(blocks.face_block))
    for number in np.unique(kind):
        own = np.flatnonzero(kind == number)
        corner = blocks.vertices[first_vertex[own][:, None] + np.arange(n_vertices[own[0]])]
        face = first_face[own][:, None] + np.arange(n_faces[own[0]])
        origin, normal = corner[:, :1], planes.normal[face]
        offset = np.einsum("nfj,nfj->nf", planes.centre[face] - origin, normal)
        found[face] = (normal @ (corner - origin).swapaxes(1, 2)).max(axis=2) - offset
    return found


def separations(blocks: Polyhedra, pairs: Ints, supporting: np.ndarray) -> tuple[Floats, Floats]:
    """Return how far pairs of blocks are kept apart by the planes of their faces, by the best and by another.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    pairs : array of int, shape (n, 2)
        Numbers of the two blocks of each pair.
    supporting : array of bool, shape (n_faces,)
        Faces that have their whole block behind their plane; no other keeps it apart from anything.

    Returns
    -------
    first : array of float, shape (n,)
        Distance along the normal of the face that separates best [m]; below zero where none does.
    second : array of float, shape (n,)
        The same for the best face whose normal points elsewhere. Where it is not below zero the blocks meet in one line
        at most, and have no unique normal there.
    """
    one, n_one, next_one = _best_faces(blocks, pairs, supporting)
    two, n_two, next_two = _best_faces(blocks, pairs[:, ::-1], supporting)
    alike = np.einsum("ij,ij->i", n_one, -n_two) > APART
    # The better of the two comes first; the other block's best face counts unless it says the same.
    swap = two > one
    first = np.where(swap, two, one)
    own = np.where(swap, next_two, next_one)
    other = np.where(alike, np.where(swap, next_one, next_two), np.where(swap, one, two))
    return first, np.maximum(own, other)


def _best_faces(blocks: Polyhedra, pairs: Ints, supporting: np.ndarray) -> tuple[Floats, Floats, Floats]:
    """For the faces of the first blocks: the best separation, its normal, and the best of the other normals."""
    planes = blocks.planes
    start = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    size = np.column_stack([np.diff(start)[pairs[:, 0]], np.diff(blocks.vertex_start)[pairs[:, 1]]])
    code = size @ [len(blocks.vertices) + 1, 1]
    best, normal, following = np.empty(len(pairs)), np.empty((len(pairs), 3)), np.empty(len(pairs))
    for kind in np.unique(code):
        rows = np.flatnonzero(code == kind)
        faces, vertices = size[rows[0]]
        for own in np.array_split(rows, 1 + len(rows) * faces * vertices // CHUNK):
            face = start[pairs[own, 0]][:, None] + np.arange(faces)
            corner = blocks.vertices[blocks.vertex_start[pairs[own, 1]][:, None] + np.arange(vertices)]
            origin = planes.centre[face[:, :1]]
            across = planes.normal[face]
            offset = np.einsum("nfj,nfj->nf", planes.centre[face] - origin, across)
            lowest = (across @ (corner - origin).swapaxes(1, 2)).min(axis=2) - offset
            lowest[~supporting[face]] = -np.inf
            top = lowest.argmax(axis=1)
            row = np.arange(len(own))
            best[own], normal[own] = lowest[row, top], across[row, top]
            alike = np.einsum("nfj,nj->nf", across, across[row, top]) > APART
            following[own] = np.where(alike, -np.inf, lowest).max(axis=1)
    return best, normal, following
