"""Corners that neighbouring blocks share, and the faces that are closed by them."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.typing import Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


def shared_corners(assembly: Assembly, gap: float) -> Ints:
    """Return the number of the corner of each vertex.

    Vertices of neighbours that are no further apart than gap times the size of the smaller block share a corner. A
    corner that would take in two vertices of one block is left apart.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float
        Largest distance of vertices that share a corner, relative to the size of the smaller block.

    Returns
    -------
    array of int, shape (n_vertices,)
        Number of the corner of each vertex.
    """
    from scipy.spatial import KDTree

    n, block = len(assembly.vertices), assembly.vertex_block
    pairs = KDTree(assembly.vertices).query_pairs(gap * float(assembly.size.max()), output_type="ndarray")
    distance = np.linalg.norm(assembly.vertices[pairs[:, 0]] - assembly.vertices[pairs[:, 1]], axis=1)
    near = (distance <= gap * assembly.size[block[pairs]].min(axis=1)) & (block[pairs[:, 0]] != block[pairs[:, 1]])
    pairs = pairs[near]
    count, corner = connected_components(n, pairs)
    both, times = np.unique(np.column_stack([corner, block]), axis=0, return_counts=True)
    torn = np.isin(corner, both[times > 1, 0])
    corner = np.where(torn, count + np.arange(n), corner)
    return np.unique(corner, return_inverse=True)[1].ravel()


def settled_faces(assembly: Assembly, corner: Ints) -> np.ndarray:
    """Return which triangles need no plane of their own.

    All their corners are corners of joints that match corner for corner, as those of curved vaults do.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    corner : array of int, shape (n_vertices,)
        Number of the corner of each vertex.

    Returns
    -------
    array of bool, shape (n_faces,)
        True for a triangle that is settled.
    """
    faces = [
        corner[assembly.face_vertices[a:b]]
        for a, b in zip(assembly.face_start, assembly.face_start[1:], strict=False)
    ]  # fmt: skip
    same: dict[frozenset[int], list[int]] = defaultdict(list)
    for number, face in enumerate(faces):
        same[frozenset(face.tolist())].append(number)
    joint = np.zeros(len(faces), dtype=bool)
    for alike in same.values():
        joint[alike] = len(alike) > 1
    held = np.zeros(int(corner.max()) + 1, dtype=bool)
    for number in np.flatnonzero(joint):
        held[faces[number]] = True
    return np.array([len(face) == 3 and bool(held[face].all()) for face in faces])
