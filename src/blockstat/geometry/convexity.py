"""Which blocks are convex, and which of their faces keep two of them apart."""

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
    planes, n_vertices = blocks.planes, np.diff(blocks.vertex_start)
    first_face = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    kinds, kind = np.unique(np.column_stack([n_vertices, np.diff(first_face)]), axis=0, return_inverse=True)
    found = np.empty(len(blocks.face_block))
    for number, (vertices, faces) in enumerate(kinds):
        own = np.flatnonzero(kind.reshape(-1) == number)
        corner = blocks.vertex_start[own][:, None] + np.arange(vertices)
        face = first_face[own][:, None] + np.arange(faces)
        origin = blocks.vertices[corner[:, :1]]
        normal = planes.normal[face]
        offset = ((planes.centre[face] - origin) * normal).sum(axis=2)
        height = normal @ (blocks.vertices[corner] - origin).swapaxes(1, 2)
        found[face] = height.max(axis=2) - offset
    return found


def convex_solids(blocks: Polyhedra, tolerance: float) -> np.ndarray:
    """Return which blocks are convex.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    tolerance : float
        A vertex may lie outside a face plane by this fraction of the size of its block.

    Returns
    -------
    array of bool, shape (n_blocks,)
        True for a convex block.
    """
    first = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks))
    return np.maximum.reduceat(protrusions(blocks), first) <= tolerance * blocks.size


def separations(blocks: Polyhedra, pairs: Ints) -> tuple[Floats, Floats]:
    """Return how far pairs of convex blocks are kept apart by the planes of their faces, by the best and by another.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    pairs : array of int, shape (n, 2)
        Numbers of the two blocks of each pair.

    Returns
    -------
    first : array of float, shape (n,)
        Distance along the normal of the face that separates best [m]; below zero where none does.
    second : array of float, shape (n,)
        The same for the best face whose normal points elsewhere. Where it is not below zero the blocks meet in one line
        at most, and have no unique normal there.
    """
    one, n_one, next_one = _best_faces(blocks, pairs)
    two, n_two, next_two = _best_faces(blocks, pairs[:, ::-1])
    alike = np.einsum("ij,ij->i", n_one, -n_two) > APART
    # The better of the two comes first; the other block's best face counts unless it says the same.
    swap = two > one
    first = np.where(swap, two, one)
    own = np.where(swap, next_two, next_one)
    other = np.where(alike, np.where(swap, next_one, next_two), np.where(swap, one, two))
    return first, np.maximum(own, other)


def _best_faces(blocks: Polyhedra, pairs: Ints) -> tuple[Floats, Floats, Floats]:
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
            top = lowest.argmax(axis=1)
            row = np.arange(len(own))
            best[own], normal[own] = lowest[row, top], across[row, top]
            alike = np.einsum("nfj,nj->nf", across, across[row, top]) > APART
            following[own] = np.where(alike, -np.inf, lowest).max(axis=1)
    return best, normal, following
