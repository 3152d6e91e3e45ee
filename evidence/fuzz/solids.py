"""Solids of random scenes: the surface for the statics, and convex pieces and what separates them for the judge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

Array = np.ndarray
Polygon = Sequence[Sequence[float]]

#: Triangles of a convex hull whose normals differ by less are one face.
FLAT = 1e-9
SAME = 1e-3  #: directions closer than this are one normal [rad]


@dataclass(frozen=True)
class Solid:
    """A closed surface, and the same solid as convex pieces, each by its corners.

    Pieces overlap at concave edges, so that what lies in such an edge touches the inside of a face of either piece.
    """

    vertices: Array
    faces: tuple[tuple[int, ...], ...]
    pieces: tuple[Array, ...]

    def moved(self, shift: Sequence[float] = (0, 0, 0), turn: Array | None = None) -> Solid:
        """The solid turned about the origin, then shifted."""
        turn = np.eye(3) if turn is None else turn

        def move(points: Array) -> Array:
            return points @ turn.T + np.asarray(shift, dtype=float)

        return Solid(move(self.vertices), self.faces, tuple(map(move, self.pieces)))

    @cached_property
    def _tetrahedra(self) -> tuple[Array, Array]:
        """Six times the volumes of the tetrahedra of all faces on the first corner, and their centres."""
        first = self.vertices[0]
        triangles = np.array([(f[0], f[i], f[i + 1]) for f in self.faces for i in range(1, len(f) - 1)])
        corner = self.vertices[triangles] - first
        return np.linalg.det(corner), first + corner.sum(axis=1) / 4

    @property
    def volume(self) -> float:
        """[m3]."""
        return float(self._tetrahedra[0].sum() / 6)

    @property
    def centroid(self) -> Array:
        """[m]."""
        weight, centre = self._tetrahedra
        return weight @ centre / weight.sum()

    @property
    def surface(self) -> float:
        """[m2]."""
        total = 0.0
        for face in self.faces:
            corner = self.vertices[list(face)] - self.vertices[face[0]]
            total += float(np.linalg.norm(np.cross(corner[1:-1], corner[2:]).sum(axis=0)) / 2)
        return total


def box(lower: Sequence[float], upper: Sequence[float]) -> Solid:
    """A box along the axes."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    return extruded([[(x0, z0), (x1, z0), (x1, z1), (x0, z1)]], y0, y1)


def brick(length: float, depth: float, height: float) -> Solid:
    """A box about the origin."""
    half = np.array([length, depth, height]) / 2
    return box(-half, half)


def extruded(pieces: Sequence[Polygon], y0: float, y1: float, outline: Polygon | None = None) -> Solid:
    """Convex polygons (x, z), counter-clockwise, drawn out along y; `outline` is that of all of them together."""
    ring = np.asarray(pieces[0] if outline is None else outline, dtype=float)
    n = len(ring)

    def prism(polygon: Polygon) -> Array:
        flat = np.asarray(polygon, dtype=float)
        return np.concatenate([np.insert(flat, 1, y, axis=1) for y in (y0, y1)])

    sides = [(i, (i + 1) % n, (i + 1) % n + n, i + n) for i in range(n)]
    faces = (tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1)), *(side[::-1] for side in sides))
    return _outward(Solid(prism(ring), faces, tuple(prism(p) for p in pieces)))


def hull(points: Array) -> Solid:
    """The convex hull of points, its flat faces whole."""
    points = np.asarray(points, dtype=float)
    found = ConvexHull(points)
    points, centre = points[found.vertices], points[found.vertices].mean(axis=0)
    rows = np.unique(np.round(found.equations / FLAT / 1e2), axis=0, return_index=True)[1]
    faces = []
    for normal, offset in ((e[:3], e[3]) for e in found.equations[rows]):
        on = np.flatnonzero(points @ normal + offset > -1e-7 * np.ptp(points))
        middle = points[on].mean(axis=0)
        first = points[on[0]] - middle
        second = np.cross(normal, first)
        angle = np.arctan2((points[on] - middle) @ second, (points[on] - middle) @ first)
        faces.append(tuple(on[np.argsort(angle)].tolist()))
    faces = tuple({frozenset(face): face for face in faces}.values())
    return _outward(Solid(points - centre, faces, (points - centre,))).moved(centre)


def split(solid: Solid, random: np.random.Generator, *, triangles: bool) -> Solid:
    """The same solid, its convex faces cut about a point inside or into triangles from one corner."""
    vertices, faces = list(solid.vertices), []
    for face in solid.faces:
        corner = solid.vertices[list(face)]
        if not _is_convex(corner) or random.random() < 0.3:
            faces.append(face)
        elif triangles:
            faces += [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]
        else:
            share = random.uniform(0.2, 1.0, len(face))
            vertices.append(share @ corner / share.sum())
            faces += [(face[i - 1], face[i], len(vertices) - 1) for i in range(len(face))]
    return replace(solid, vertices=np.array(vertices), faces=tuple(faces))


def _is_convex(corner: Array) -> bool:
    ahead = np.roll(corner, -1, axis=0) - corner
    turn = np.cross(ahead, np.roll(ahead, -1, axis=0))
    return bool((turn @ turn.sum(axis=0) > 0).all())


def _outward(solid: Solid) -> Solid:
    return solid if solid.volume > 0 else replace(solid, faces=tuple(face[::-1] for face in solid.faces))


@dataclass(frozen=True)
class Piece:
    """A convex piece of a solid with the directions of its faces and edges."""

    corners: Array
    normals: Array
    edges: Array

    @classmethod
    def of(cls, corners: Array) -> Piece:
        """From its corners."""
        found = ConvexHull(corners - corners.mean(axis=0))
        normals = _distinct(found.equations[:, :3])
        edges = []
        for triangle, beside, normal in zip(found.simplices, found.neighbors, found.equations, strict=True):
            for k in range(3):
                other = found.equations[beside[k], :3]
                if np.linalg.norm(np.cross(normal[:3], other)) > 1e-7:
                    i, j = np.delete(triangle, k)
                    along = corners[j] - corners[i]
                    edges.append(along / np.linalg.norm(along))
        edges = np.array(edges)
        sign = np.sign(edges[np.arange(len(edges)), np.abs(edges).argmax(axis=1)])
        return cls(corners, normals, _distinct(edges * sign[:, None]))


def separating(one: Piece, two: Piece) -> Array:
    """Directions from the first piece to the second among which one separates them best."""
    cross = np.cross(one.edges[:, None], two.edges[None]).reshape(-1, 3)
    length = np.linalg.norm(cross, axis=1)
    cross = cross[length > SAME] / length[length > SAME, None]
    return np.concatenate([one.normals, -two.normals, cross, -cross])


def _distinct(directions: Array) -> Array:
    """Unit vectors without those that are the same."""
    kept: list[Array] = []
    for row in directions:
        if all(np.abs(row - other).max() > 1e-7 for other in kept):
            kept.append(row)
    return np.array(kept)
