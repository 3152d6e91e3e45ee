"""Triangles of one surface that meet elsewhere than at the corners and edges that they share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np

from blockstat.geometry.broad_phase import count_of_close, near_pairs
from blockstat.geometry.polyhedron import Polyhedra, members, next_in_face
from blockstat.geometry.triangulation import fans, triangulate
from blockstat.typing import Floats, Ints

#: Surfaces of up to this many triangles have all their pairs compared; larger ones are sorted by place first.
FEW = 64
#: Pairs of triangles of a block that are near each other at most. Where there are more, as about the middle of a face
#: of 70,000 corners, none are compared. Chosen: a gigabyte.
CROWDED = 20_000_000
#: Pairs that are compared at once.
CHUNK = 50_000
#: Areas that agree to this fraction are equal but for rounding.
SAME = 1e-9


@dataclass(frozen=True)
class Surface:
    """Triangles of some blocks, block after block."""

    corner: Floats  #: shape (n, 3, 3) [m], about a point of each block
    vertex: Ints  #: shape (n, 3): one number for all corners of a block at one place
    block: Ints  #: shape (n,), of each triangle, ascending


def surface_of(blocks: Polyhedra, merged: Ints, origin: Floats) -> Surface:
    """Cut the faces of blocks into triangles.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    merged : array of int, shape (n_vertices,)
        As `merged_vertices` gives it.
    origin : array of float, shape (n_blocks, 3)
        The point of each block about which its corners are seen [m].

    Returns
    -------
    Surface
        Its triangles are closed as the faces are, whatever their shape. A face that is not star-shaped is cut into
        ears, and where it passes through itself into a fan with triangles that look the other way.
    """
    count = np.diff(blocks.face_start)
    face = np.repeat(np.arange(len(count)), count)
    place = blocks.vertices[blocks.face_vertices] - origin[blocks.face_block[face]]
    tail = merged[blocks.face_vertices]
    following = next_in_face(blocks.face_start)
    corner = fans(place, blocks.face_start)
    vertex = np.column_stack([tail, tail[following], len(merged) + face])
    normal = blocks.planes.normal[face]
    double = _cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    height = np.einsum("ij,ij->i", double, normal)
    fan = np.logical_and.reduceat(height >= 0, blocks.face_start[:-1]) & (count > 3)
    parts = [(corner[fan[face]], vertex[fan[face]], face[fan[face]])]
    first = blocks.face_start[:-1]
    three = np.flatnonzero(count == 3)
    at = first[three][:, None] + np.arange(3)
    parts.append((place[at], tail[at], three))
    for number in np.flatnonzero(~fan & (count > 3)).tolist():
        own = slice(first[number], first[number] + count[number])
        ears = triangulate(place[own], [np.arange(count[number])])
        ear = place[own][ears]
        area = np.linalg.norm(_cross(ear[:, 1] - ear[:, 0], ear[:, 2] - ear[:, 0]), axis=1)
        if abs(area.sum() / 2 - blocks.planes.area[number]) < SAME * blocks.planes.area[number]:
            parts.append((place[own][ears], tail[own][ears], np.full(len(ears), number)))
        else:
            parts.append((corner[own], vertex[own], np.full(count[number], number)))
    corner, vertex, face = (np.concatenate(own) for own in zip(*parts, strict=True))
    order = np.argsort(face, kind="stable")
    return Surface(corner[order], vertex[order], blocks.face_block[face[order]])


def meeting_pairs(surface: Surface, n_blocks: int, on: Floats) -> Ints:
    """Find the triangles of one block that meet elsewhere than at what they share.

    Parameters
    ----------
    surface : Surface
        The triangles.
    n_blocks : int
        Number of blocks.
    on : array of float, shape (n_blocks,)
        What is no further apart meets: rounding [m].

    Returns
    -------
    array of int, shape (n_pairs, 2)
        Numbers of triangles.

    Notes
    -----
    Two triangles are apart when the projections on one of the axes of the separating axis theorem are. Two that share
    one corner meet further on when the edge opposite to it in one of the two meets the other. Two that share an edge do
    when they lie on each other.
    """
    found = [np.empty((0, 2), dtype=np.int64)]
    for pairs in _near(surface, n_blocks, on):
        shared = surface.vertex[pairs[:, 0]][:, :, None] == surface.vertex[pairs[:, 1]][:, None, :]
        times = shared.any(axis=2).sum(axis=1)
        limit = on[surface.block[pairs[:, 0]]]
        one, two = surface.corner[pairs[:, 0]], surface.corner[pairs[:, 1]]
        meet = np.zeros(len(pairs), dtype=bool)
        rows = np.flatnonzero(times == 0)
        meet[rows] = _meet(one[rows], two[rows], limit[rows])
        rows = np.flatnonzero(times == 1)
        a, b = shared[rows].any(axis=2).argmax(axis=1), shared[rows].any(axis=1).argmax(axis=1)
        meet[rows] = _meet(_opposite(one[rows], a), two[rows], limit[rows])
        meet[rows] |= _meet(one[rows], _opposite(two[rows], b), limit[rows])
        rows = np.flatnonzero(times == 2)
        a, b = (~shared[rows].any(axis=2)).argmax(axis=1), (~shared[rows].any(axis=1)).argmax(axis=1)
        meet[rows] = _folded(one[rows], two[rows], a, b, limit[rows])
        meet[times == 3] = True
        found.append(pairs[meet])
    return np.concatenate(found)


def _near(surface: Surface, n_blocks: int, on: Floats) -> list[Ints]:
    """Pairs of triangles of a block whose boxes meet, in portions."""
    lower, upper = surface.corner.min(axis=1), surface.corner.max(axis=1)
    start = np.searchsorted(surface.block, np.arange(n_blocks + 1))
    count = np.diff(start)
    few = count[surface.block] <= FEW
    rows = np.flatnonzero(few)
    later = start[surface.block[rows] + 1] - rows - 1
    portions, found = np.split(rows, np.searchsorted(np.cumsum(later), np.arange(CHUNK, later.sum(), CHUNK))), []
    for own in portions:
        which, other = members(own + 1, start[surface.block[own] + 1] - own - 1)
        first = own[which]
        slack = on[surface.block[first]][:, None]
        near = ((lower[first] <= upper[other] + slack) & (lower[other] <= upper[first] + slack)).all(axis=1)
        found.append(np.column_stack([first, other])[near])
    for block in np.flatnonzero(count > FEW).tolist():
        own = slice(start[block], start[block + 1])
        boxes = lower[own], upper[own], np.full(count[block], on[block])
        if count_of_close(*boxes) > CROWDED:
            continue
        pairs = near_pairs(*boxes) + start[block]
        found += np.split(pairs, np.arange(CHUNK, len(pairs), CHUNK))
    return [pairs for pairs in found if len(pairs)]


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross product of rows."""
    product: Floats = np.asarray(np.cross(a, b), dtype=float)
    return product


def _opposite(triangle: Floats, corner: Ints) -> Floats:
    """The edge opposite to a corner of each triangle, as a triangle without width."""
    rows = np.arange(len(corner))
    a, b = triangle[rows, (corner + 1) % 3], triangle[rows, (corner + 2) % 3]
    return np.stack([a, b, b], axis=1)


def _folded(one: Floats, two: Floats, a: Ints, b: Ints, limit: Floats) -> np.ndarray:
    """Whether triangles that share an edge lie on each other; `a` and `b` are their other corners."""
    rows = np.arange(len(a))
    ends = one[rows, (a + 1) % 3], one[rows, (a + 2) % 3]
    line = ends[1] - ends[0]
    line /= np.maximum(np.linalg.norm(line, axis=1), 1e-300)[:, None]
    arms = [own - ends[0] - np.einsum("ij,ij->i", own - ends[0], line)[:, None] * line for own in
            (one[rows, a], two[rows, b])]  # fmt: skip
    long = [np.linalg.norm(arm, axis=1) for arm in arms]
    off = np.linalg.norm(_cross(arms[0], arms[1]), axis=1)
    return (np.einsum("ij,ij->i", arms[0], arms[1]) > 0) & (off <= limit * np.maximum(long[0], long[1]))


def _meet(one: Floats, two: Floats, limit: Floats) -> np.ndarray:
    """Whether triangles, some of them without width, are nowhere known to be further apart than a limit."""
    meet = np.ones(len(one), dtype=bool)
    e, f = (own[:, [1, 2, 0]] - own for own in (one, two))
    n, m = _cross(e[:, 0], e[:, 1]), _cross(f[:, 0], f[:, 1])

    def tried(axis: Floats, rows: Ints) -> None:
        length = np.linalg.norm(axis, axis=1)
        axis = axis / np.where(length > 0, length, 1.0)[:, None]
        # numpy takes the largest of three numbers in each of many rows several times as slowly.
        p, q = ([np.einsum("nj,nj->n", own[rows, k], axis) for k in range(3)] for own in (one, two))
        low, high = ([reduce(pick, own) for own in (p, q)] for pick in (np.minimum, np.maximum))
        meet[rows] = np.maximum(low[0] - high[1], low[1] - high[0]) <= limit[rows]

    for normal in (n, m):
        rows = np.flatnonzero(meet)
        tried(normal[rows], rows)
    for normal, edge in [(n, e), (m, f)]:  # of triangles in one plane
        for k in range(3):
            rows = np.flatnonzero(meet)
            tried(_cross(normal[rows], edge[rows, k]), rows)
    for i in range(3):
        for j in range(3):
            rows = np.flatnonzero(meet)
            tried(_cross(e[rows, i], f[rows, j]), rows)
    return meet
