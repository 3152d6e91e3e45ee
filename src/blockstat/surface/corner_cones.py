"""Solids about their corners, cut into convex cones."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np

from blockstat.geometry.convex_pieces import convex_pieces
from blockstat.geometry.polyhedron import Polyhedra
from blockstat.geometry.topology import FLAT
from blockstat.geometry.triangulation import triangulate
from blockstat.typing import Floats, Ints

#: Three planes whose normals span less than this volume meet in no point.
SKEW = 1e-6


def corner_cones(blocks: Polyhedra, vertex: Ints) -> list[list[Floats]]:
    """Cut blocks about some of their corners into convex cones.

    Parameters
    ----------
    blocks : Polyhedra
        Closed blocks.
    vertex : array of int, shape (n,)
        Vertex numbers of the corners.

    Returns
    -------
    list of list of array of float, shape (k, 3)
        For each corner the unit directions that span each of its cones, some within the cone included.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    >>> [cone] = corner_cones(cube, np.array([0]))[0]
    >>> bool((cone >= 0).all())
    True
    """
    if not len(vertex):
        return []
    block, place = blocks.vertex_block[vertex], blocks.vertices[vertex]
    surface = {int(b): _triangles(blocks, int(b)) for b in np.unique(block)}
    solids = [surface[int(b)] for b in block]
    half = np.array([_clear(solid, point) for solid, point in zip(solids, place, strict=True)]) / 2
    found = convex_pieces(solids, place - half[:, None], place + half[:, None], FLAT * half)
    cones = [
        [_directions(piece, point, FLAT * size) for piece in pieces]
        for pieces, point, size in zip(found, place, half.tolist(), strict=True)
    ]
    return [[cone for cone in own if len(cone)] for own in cones]


def _triangles(blocks: Polyhedra, block: int) -> Floats:
    """Corners of the triangles of the surface of a block."""
    faces = np.flatnonzero(blocks.face_block == block)
    rings = [blocks.face_vertices[blocks.face_start[f] : blocks.face_start[f + 1]] for f in faces]
    return np.asarray(blocks.vertices[triangulate(blocks.vertices, rings)])


def _clear(triangles: Floats, point: Floats) -> float:
    """How far the next corner is."""
    distance = np.linalg.norm(triangles.reshape(-1, 3) - point, axis=1)
    return float(distance[distance > 0].min())


def _directions(planes: Floats, point: Floats, rounding: float) -> Floats:
    """Directions from a point to the corners of a convex piece that has it as a corner too; none where it has not."""
    room = planes[:, 3] - planes[:, :3] @ point
    if room.min() < -rounding:
        return np.empty((0, 3))
    room[room <= rounding] = 0.0
    trio = _trios(len(planes))
    normals = planes[trio, :3]
    meet = np.abs(np.linalg.det(normals)) > SKEW
    corner = np.linalg.solve(normals[meet], room[trio[meet]][..., None])[..., 0]
    length = np.linalg.norm(corner, axis=1)
    own = (corner @ planes[:, :3].T <= room + rounding / 10).all(axis=1) & (length > rounding / 2)
    direction = corner[own] / length[own, None]
    # The sides of a cone span it, and where it has two sides or one, what lies on one of them or anywhere.
    bounds = planes[room == 0, :3]
    rank = np.linalg.matrix_rank(bounds, FLAT) if len(bounds) > 1 else len(bounds)
    kept = direction[(np.abs(direction @ bounds.T) <= FLAT).sum(axis=1) >= rank - 1]
    alike = np.triu(kept @ kept.T > 1 - FLAT**2 / 2, 1)
    return kept[~alike.any(axis=0)]


@cache
def _trios(n: int) -> Ints:
    """All sets of three of n numbers, shape (n_sets, 3)."""
    return np.array(list(combinations(range(n), 3)), dtype=np.int64)
