"""Geometry of closed polyhedra stored as flat arrays: face planes, exact mass integrals, rigid velocity.

Faces are polygons of any size. Each face is split into triangles about the mean of its vertices: for a
planar face any such split is exact, and for a warped one two blocks that share the face agree on it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from blockstat.typing import Floats, Ints

#: A face that is narrower than this share of the size of its block may have a normal of rounding, and is then taken to
#: lie in the plane of a neighbour.
NARROW = 1e-6
#: Of two levels that differ by no more than this fraction of the height of a block, neither is lower.
LEVEL = 0.01


def members(first: Ints, count: Ints) -> tuple[Ints, Ints]:
    """Return the members of runs of consecutive numbers, one run after the other.

    Parameters
    ----------
    first : array of int, shape (n,)
        The first number of each run.
    count : array of int, shape (n,)
        How many numbers each run has.

    Returns
    -------
    owner : array of int, shape (n_members,)
        The run of each member.
    member : array of int, shape (n_members,)
        Its number.

    Examples
    --------
    >>> owner, member = members(np.array([5, 20]), np.array([2, 3]))
    >>> owner.tolist(), member.tolist()
    ([0, 0, 1, 1, 1], [5, 6, 20, 21, 22])
    """
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) + np.repeat(first - (np.cumsum(count) - count), count)


def next_in_face(face_start: Ints) -> Ints:
    """Return for each face corner the position of the one that follows it round the face.

    Parameters
    ----------
    face_start : array of int, shape (n_faces + 1,)
        Where the corners of each face begin, and their number at the end.

    Returns
    -------
    array of int, shape (n_corners,)
        Positions among the corners of all faces.

    Examples
    --------
    >>> next_in_face(np.array([0, 3, 7])).tolist()
    [1, 2, 0, 4, 5, 6, 3]
    """
    following = np.arange(1, face_start[-1] + 1)
    following[face_start[1:] - 1] = face_start[:-1]
    return following


def read_only(array: Any) -> Any:
    """Return a view of an array that cannot be written to; anything else as it is.

    Parameters
    ----------
    array : object
        It stays writable itself.

    Returns
    -------
    object
        The view.
    """
    if not isinstance(array, np.ndarray) or not array.flags.writeable:
        return array
    view = array.view()
    view.flags.writeable = False
    return view


class ReadOnly:
    """A record whose arrays cannot be written to, because others are computed from them once and kept.

    An array that is given is copied, unless it is read-only already.
    """

    def __post_init__(self) -> None:
        given = vars(self)
        for name, value in given.items():
            if isinstance(value, np.ndarray) and value.flags.writeable:
                given[name] = read_only(value.copy(order="K"))

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update((name, read_only(value)) for name, value in state.items())


@dataclass(frozen=True)
class FacePlanes(ReadOnly):
    """Best-fit planes of polygons (Newell's method)."""

    normal: Floats  #: shape (n_faces, 3), unit, outward for a positively oriented block
    area: Floats  #: shape (n_faces,) [m2]
    centre: Floats  #: shape (n_faces, 3) [m], mean of the corners
    warp: Floats  #: shape (n_faces,) [m], largest distance of a corner from the plane


def face_planes(corners: Floats, face_start: Ints) -> FacePlanes:
    """Fit a plane to each face.

    Parameters
    ----------
    corners : array of float, shape (n_corners, 3)
        Corners of the faces, one face after the other [m].
    face_start : array of int, shape (n_faces + 1,)
        Where the corners of each face begin, and their number at the end.

    Returns
    -------
    FacePlanes
        The planes.
    """
    count = np.diff(face_start)
    first = face_start[:-1]
    centre = np.add.reduceat(corners, first, axis=0) / count[:, None]
    local = corners - np.repeat(centre, count, axis=0)
    vector_area = 0.5 * np.add.reduceat(np.cross(local, local[next_in_face(face_start)]), first, axis=0)
    area = np.linalg.norm(vector_area, axis=1)
    normal = vector_area / np.where(area > 0, area, 1.0)[:, None]
    offset = np.abs(np.einsum("ij,ij->i", local, np.repeat(normal, count, axis=0)))
    return FacePlanes(normal, area, centre, np.maximum.reduceat(offset, first))


@dataclass(frozen=True)
class Integrals(ReadOnly):
    """Volume integrals of blocks of unit density."""

    volume: Floats  #: shape (n_blocks,) [m3]
    centroid: Floats  #: shape (n_blocks, 3) [m]
    inertia: Floats  #: shape (n_blocks, 3, 3) [m5], about the centroid


def integrals(corners: Floats, face_start: Ints, face_block: Ints, n_blocks: int) -> Integrals:
    """Return the exact volume, centroid and inertia of each block.

    Parameters
    ----------
    corners : array of float, shape (n_corners, 3)
        Corners of the faces, one face after the other [m].
    face_start : array of int, shape (n_faces + 1,)
        Where the corners of each face begin, and their number at the end.
    face_block : array of int, shape (n_faces,)
        The block of each face.
    n_blocks : int
        Number of blocks.

    Returns
    -------
    Integrals
        Volume integrals, for unit density.

    Notes
    -----
    Signed tetrahedra are summed. Those of a block share the mean of its corners as apex, so a block far from the origin
    loses no digits.
    """
    count = np.diff(face_start)
    corner_block = np.repeat(face_block, count)
    n_corners = np.bincount(corner_block, minlength=n_blocks)
    apex = np.stack([np.bincount(corner_block, corners[:, k], n_blocks) for k in range(3)], axis=1)
    apex /= np.maximum(n_corners, 1)[:, None]

    a = corners - apex[corner_block]
    b = a[next_in_face(face_start)]
    mean = np.add.reduceat(a, face_start[:-1], axis=0) / count[:, None]
    m = np.repeat(mean, count, axis=0)
    volume6 = np.einsum("ij,ij->i", m, np.cross(a, b))
    total = m + a + b

    volume = np.bincount(corner_block, volume6, n_blocks) / 6.0
    safe = np.where(volume != 0, volume, 1.0)
    first = np.stack([np.bincount(corner_block, volume6 * total[:, k], n_blocks) for k in range(3)], axis=1)
    offset = first / 24.0 / safe[:, None]

    second = np.empty((n_blocks, 3, 3))
    for i in range(3):
        for j in range(i, 3):
            product = m[:, i] * m[:, j] + a[:, i] * a[:, j] + b[:, i] * b[:, j] + total[:, i] * total[:, j]
            second[:, i, j] = second[:, j, i] = np.bincount(corner_block, volume6 * product, n_blocks) / 120.0
    second -= volume[:, None, None] * offset[:, :, None] * offset[:, None, :]
    inertia = np.trace(second, axis1=1, axis2=2)[:, None, None] * np.eye(3) - second
    return Integrals(volume, apex + offset, inertia)


@dataclass(frozen=True, eq=False)
class Polyhedra(ReadOnly):
    """The geometry of many blocks in flat arrays, which are read-only."""

    vertices: Floats  #: shape (n_vertices, 3) [m], block after block
    vertex_start: Ints  #: shape (n_blocks + 1,), the vertices of block b are vertex_start[b]:vertex_start[b+1]
    face_vertices: Ints  #: shape (n_corners,), indices into `vertices`, face after face
    face_start: Ints  #: shape (n_faces + 1,), slices of `face_vertices`
    face_block: Ints  #: shape (n_faces,), ascending

    @property
    def n_blocks(self) -> int:
        """Number of blocks."""
        return len(self.vertex_start) - 1

    @cached_property
    def integrals(self) -> Integrals:
        """Volume, centroid and inertia of each block."""
        return integrals(self.vertices[self.face_vertices], self.face_start, self.face_block, self.n_blocks)

    @property
    def volume(self) -> Floats:
        """Volume of each block, shape (n_blocks,) [m3]."""
        return self.integrals.volume

    @property
    def centroid(self) -> Floats:
        """Centroid of each block, shape (n_blocks, 3) [m]."""
        return self.integrals.centroid

    @cached_property
    def size(self) -> Floats:
        """Size of each block, the cube root of its volume, shape (n_blocks,) [m]; lengths are judged by it."""
        return read_only(np.cbrt(self.volume))

    @cached_property
    def planes(self) -> FacePlanes:
        """Planes of all faces; a face without width has the normal of a face beside it."""
        planes = face_planes(self.vertices[self.face_vertices], self.face_start)
        return replace(planes, normal=_with_those_beside(self, planes))

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corners of the axis-aligned box of each block, each shape (n_blocks, 3) [m]."""
        first = self.vertex_start[:-1]
        low, high = (bound.reduceat(self.vertices, first) for bound in (np.minimum, np.maximum))
        return read_only(low), read_only(high)

    @cached_property
    def face_bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corners of the axis-aligned box of each face, each shape (n_faces, 3) [m]."""
        corners, first = self.vertices[self.face_vertices], self.face_start[:-1]
        low, high = (bound.reduceat(corners, first) for bound in (np.minimum, np.maximum))
        return read_only(low), read_only(high)

    @property
    def vertex_block(self) -> Ints:
        """Block of each vertex, shape (n_vertices,)."""
        return np.repeat(np.arange(self.n_blocks), np.diff(self.vertex_start))

    def faces_of(self, block: int) -> list[Ints]:
        """Return the faces of one block.

        Parameters
        ----------
        block : int
            Number of the block.

        Returns
        -------
        list of arrays of int
            Corners of each face as indices into `block_vertices(block)`.
        """
        first, last = np.searchsorted(self.face_block, [block, block + 1])
        offset = self.vertex_start[block]
        return [self.face_vertices[self.face_start[f] : self.face_start[f + 1]] - offset for f in range(first, last)]

    def copied(self, blocks: Ints) -> Polyhedra:
        """Return the geometry of some blocks.

        Parameters
        ----------
        blocks : array of int, shape (k,)
            Which; one may come several times.

        Returns
        -------
        Polyhedra
            Of k blocks in this order.
        """
        first_face = np.searchsorted(self.face_block, np.arange(self.n_blocks + 1))
        n_vertices, n_faces = np.diff(self.vertex_start)[blocks], np.diff(first_face)[blocks]
        _, vertex = members(self.vertex_start[:-1][blocks], n_vertices)
        row, face = members(first_face[blocks], n_faces)
        count = np.diff(self.face_start)[face]
        owner, corner = members(self.face_start[face], count)
        start = np.concatenate([[0], np.cumsum(n_vertices)])
        moved = (start[:-1] - self.vertex_start[:-1][blocks])[row]
        return Polyhedra(
            self.vertices[vertex], start, self.face_vertices[corner] + moved[owner],
            np.concatenate([[0], np.cumsum(count)]), row,
        )  # fmt: skip

    def block_vertices(self, block: int) -> Floats:
        """Return the vertices of one block.

        Parameters
        ----------
        block : int
            Number of the block.

        Returns
        -------
        array of float, shape (n, 3)
            Vertices [m].
        """
        return self.vertices[self.vertex_start[block] : self.vertex_start[block + 1]]


def _with_those_beside(blocks: Polyhedra, planes: FacePlanes) -> Floats:
    """Normals of all faces, with that of its neighbour for each face whose own is rounding, shape (n_faces, 3)."""
    head = next_in_face(blocks.face_start)
    length = np.linalg.norm(blocks.vertices[blocks.face_vertices[head]] - blocks.vertices[blocks.face_vertices], axis=1)
    longest = np.maximum.reduceat(length, blocks.face_start[:-1])
    # Twice the area over the longest edge is the height of a triangle.
    thin = 2 * planes.area <= NARROW * np.abs(blocks.size[blocks.face_block]) * longest
    if not thin.any():
        return planes.normal
    normal, left = planes.normal.copy(), set(np.flatnonzero(thin).tolist())
    beside = _beside_long_edges(blocks, length, left)
    left -= {face for face in left if _is_bevel(normal[face], normal[[k for k in beside[face] if k not in left]])}
    while known := {face: near for face in left for near in beside[face] if near not in left}:
        for face, near in known.items():
            normal[face] = normal[near]
        left.difference_update(known)
    return normal


def _is_bevel(normal: Floats, beside: Floats) -> bool:
    """Whether a narrow face looks between the ways of two faces beside it, as the bevel or the fillet of an edge does.

    The normal of three corners in one line is any at right angles to it. Those between two normals make an angle with
    their bisector that is no larger than the two make. Each of the two alone does not tell: where they are more than
    120 degrees apart, what looks the other way is as near to both as they are to each other.
    """
    cosine, own = beside @ beside.T, beside @ normal
    between = own[:, None] + own >= 1 + cosine - NARROW**2
    np.fill_diagonal(between, False)
    return bool(normal.any() and between.any())


def _beside_long_edges(blocks: Polyhedra, length: Floats, faces: Iterable[int]) -> dict[int, list[int]]:
    """The faces on the other side of the longest edge of each of some faces, and of those half as long; it comes last.

    A face without width lies along its long edges, and so in the planes of the faces beside them. One without length
    lies in those of all faces at its place.
    """
    owner = np.repeat(np.arange(len(blocks.face_block)), np.diff(blocks.face_start))
    start = merged_vertices(blocks)[blocks.face_vertices]
    end, n = start[next_in_face(blocks.face_start)], len(blocks.vertices)
    forward = start * n + end
    order, at_vertex = np.argsort(forward, kind="stable"), np.argsort(start, kind="stable")
    walked, met = forward[order], start[at_vertex]
    found = {}
    for face in faces:
        corners = np.arange(blocks.face_start[face], blocks.face_start[face + 1])
        corners = corners[np.argsort(length[corners], kind="stable")]
        corners = corners[(2 * length[corners] >= length[corners[-1]]) & (start[corners] != end[corners])]
        beside = []
        for back in end[corners] * n + start[corners]:
            others = owner[order[slice(*np.searchsorted(walked, [back, back + 1]))]]
            others = others[others != face]
            beside += others.tolist() if len(others) == 1 else []
        if not len(corners):
            vertex = start[blocks.face_start[face]]
            beside = owner[at_vertex[slice(*np.searchsorted(met, [vertex, vertex + 1]))]].tolist()
        found[face] = [other for other in beside if other != face]
    return found


def merged_vertices(blocks: Polyhedra) -> Ints:
    """Return for each vertex the first vertex of its block with the same coordinates.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.

    Returns
    -------
    array of int, shape (n_vertices,)
        Numbers of vertices.
    """
    keys = np.column_stack([blocks.vertex_block, blocks.vertices + 0.0])
    order = np.lexsort(keys.T[::-1])
    new = np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)])
    merged = np.empty(len(order), dtype=np.int64)
    merged[order] = order[new][np.cumsum(new) - 1]
    return merged


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


def reach_down(vertices: Floats, start: Ints, gravity: Floats) -> np.ndarray:
    """Return which blocks reach down to the lowest corner of all.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Corners [m].
    start : array of int, shape (n_blocks + 1,)
        First corner of each block, and their number.
    gravity : array of float, shape (3,)
        Points downwards; not zero.

    Returns
    -------
    array of bool, shape (n_blocks,)
        True for those whose lowest corner is no higher than that of all by more than `LEVEL` of their own height.
    """
    up = -gravity / np.linalg.norm(gravity)
    bottom, top = (own.reduceat(vertices @ up, start[:-1]) for own in (np.minimum, np.maximum))
    return bottom <= bottom.min() + LEVEL * (top - bottom)
