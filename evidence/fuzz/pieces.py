"""Convex pieces and the directions that separate them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from evidence.fuzz.solids import Array

SAME = 1e-3  #: directions closer than this are one normal [rad]


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
