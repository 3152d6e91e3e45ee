"""The solids that the elements are made of."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.typing import Floats

FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def hexahedron(bottom: Floats, top: Floats, *, name: str, group: str) -> Block:
    """A block between two quadrilaterals, shape (4, 3) each, counter-clockwise seen from the top."""
    return Block(np.vstack([bottom, top]), FACES, name=name, group=group)


def box(
    lower: tuple[float, float, float], upper: tuple[float, float, float], *, name: str = "", group: str = ""
) -> Block:
    """An axis-aligned block."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    corners = [
        (x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0),
        (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1),
    ]  # fmt: skip
    return Block(np.array(corners, dtype=float), FACES, name=name, group=group)


def prism(bottom: Floats, top: Floats, *, name: str = "", group: str = "") -> Block:
    """A block between two polygons with as many corners each, shape (n, 3), whichever way round they are listed.

    Corners may coincide: a prism with an edge or a corner for an end is a wedge or a pyramid.
    """
    n = len(bottom)
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return polyhedron(np.vstack([bottom, top]), [range(n)[::-1], range(n, 2 * n), *sides], name=name, group=group)


def fuse(parts: Sequence[Block], *, name: str = "", group: str = "") -> Block:
    """One block of solids that share whole faces, corner for corner; the shared faces go."""
    start = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [[int(first + k) for k in face] for first, part in zip(start, parts, strict=False) for face in part.faces]
    return polyhedron(np.vstack([part.vertices for part in parts]), faces, name=name, group=group)


def polyhedron(vertices: Floats, faces: Sequence[Sequence[int]], *, name: str = "", group: str = "") -> Block:
    """A block from corners that may coincide: equal ones become one, faces with less than three of them go, and so do
    two faces with the same corners. The surface is turned outwards.
    """
    # Adding zero makes -0.0 the same as 0.0.
    corners, index = np.unique(np.asarray(vertices, dtype=float) + 0.0, axis=0, return_inverse=True)
    index = index.ravel()
    merged = [list(dict.fromkeys(int(index[k]) for k in face)) for face in faces]
    number = Counter(frozenset(face) for face in merged)
    kept = [face for face in merged if len(face) > 2 and number[frozenset(face)] == 1]
    used = sorted({k for face in kept for k in face})
    place = {k: i for i, k in enumerate(used)}
    corners = corners[used]
    kept = [[place[k] for k in face] for face in kept]
    centre = corners.mean(axis=0)
    if sum(_cone(corners[face] - centre) for face in kept) < 0:
        kept = [face[::-1] for face in kept]
    return Block(corners, kept, name=name, group=group)


def _cone(face: Floats) -> float:
    """Six times the volume of the pyramid over a face from the origin."""
    middle = face.mean(axis=0)
    return float(np.cross(face, np.roll(face, -1, axis=0)).sum(axis=0) @ middle)


def below(face: Floats, depth: float, *, name: str = "", group: str = "") -> Block:
    """What stands under a face, shape (n, 3): a prism of vertical sides down to `depth` [m] below its lowest corner."""
    foot = face.copy()
    foot[:, 2] = face[:, 2].min() - depth
    return prism(foot, face, name=name, group=group)
