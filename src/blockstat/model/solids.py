"""The solids that the elements are made of."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.typing import Floats

FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def hexahedron(bottom: Floats, top: Floats, *, name: str, group: str) -> Block:
    """A block between two quadrilaterals.

    Parameters
    ----------
    bottom : ndarray
        Shape (4, 3), counter-clockwise seen from the top [m].
    top : ndarray
        Shape (4, 3), its corners in the same order [m].
    name, group : str, optional
        Of the block.

    Returns
    -------
    Block
        With eight corners and six faces.
    """
    return Block(np.vstack([bottom, top]), FACES, name=name, group=group)


def box(
    lower: tuple[float, float, float], upper: tuple[float, float, float], *, name: str = "", group: str = ""
) -> Block:
    """An axis-aligned block.

    Parameters
    ----------
    lower : tuple of float
        Least x, y, z [m].
    upper : tuple of float
        Greatest x, y, z [m].
    name, group : str, optional
        Of the block.

    Returns
    -------
    Block
        With eight corners and six faces.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    corners = [
        (x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0),
        (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1),
    ]  # fmt: skip
    return Block(np.array(corners, dtype=float), FACES, name=name, group=group)


def prism(bottom: Floats, top: Floats, *, name: str = "", group: str = "") -> Block:
    """A block between two polygons with as many corners each, whichever way round they are listed.

    Corners may coincide: a prism with an edge or a corner for an end is a wedge or a pyramid.

    Parameters
    ----------
    bottom : ndarray
        Shape (n, 3) [m].
    top : ndarray
        Shape (n, 3), its corners in the same order [m].
    name : str
        Of the block.
    group : str
        Of the block.

    Returns
    -------
    Block
        Its surface turned outwards.
    """
    n = len(bottom)
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return polyhedron(np.vstack([bottom, top]), [range(n)[::-1], range(n, 2 * n), *sides], name=name, group=group)


def fuse(parts: Sequence[Block], *, name: str = "", group: str = "") -> Block:
    """One block of solids that share whole faces, corner for corner; the shared faces go.

    Parameters
    ----------
    parts : sequence of Block
        Solids side by side.
    name : str
        Of the block.
    group : str
        Of the block.

    Returns
    -------
    Block
        Its surface turned outwards.
    """
    start = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [[int(first + k) for k in face] for first, part in zip(start, parts, strict=False) for face in part.faces]
    return polyhedron(np.vstack([part.vertices for part in parts]), faces, name=name, group=group)


def polyhedron(vertices: Floats, faces: Sequence[Sequence[int]], *, name: str = "", group: str = "") -> Block:
    """A block from corners that may coincide.

    Equal corners become one. Faces with less than three of them go, and so do two faces with the same corners. The
    surface is turned outwards.

    Parameters
    ----------
    vertices : array_like
        Corners, shape (n, 3) [m].
    faces : sequence of sequences of int
        Indices of the corners of each face, all turned the same way.
    name : str
        Of the block.
    group : str
        Of the block.

    Returns
    -------
    Block
        Its surface turned outwards.
    """
    corners, index = _distinct(np.asarray(vertices, dtype=float) + 0.0)  # adding zero makes -0.0 the same as 0.0
    merged = [list(dict.fromkeys(index[k] for k in face)) for face in faces]
    number = Counter(frozenset(face) for face in merged)
    kept = [face for face in merged if len(face) > 2 and number[frozenset(face)] == 1]
    used = sorted({k for face in kept for k in face})
    place = {k: i for i, k in enumerate(used)}
    corners = corners[used]
    kept = [[place[k] for k in face] for face in kept]
    centred = (corners - corners.mean(axis=0)).tolist()
    if sum(_cone([centred[k] for k in face]) for face in kept) < 0:
        kept = [face[::-1] for face in kept]
    return Block(corners, kept, name=name, group=group)


def _distinct(points: Floats) -> tuple[Floats, list[int]]:
    """Distinct points in the order of x, y, z, and the place of each point among them."""
    order = np.lexsort(points.T[::-1])
    ranked = points[order]
    first = np.append(True, (ranked[1:] != ranked[:-1]).any(axis=1))
    index = np.empty(len(points), dtype=int)
    index[order] = np.cumsum(first) - 1
    return ranked[first], index.tolist()


def _cone(face: Sequence[Sequence[float]]) -> float:
    """The volume of the pyramid over a face from the origin, times a positive number."""
    middle = [sum(c) for c in zip(*face, strict=True)]
    total = 0.0
    for (ax, ay, az), (bx, by, bz) in zip(face, [*face[1:], face[0]], strict=True):
        total += middle[0] * (ay * bz - az * by) + middle[1] * (az * bx - ax * bz) + middle[2] * (ax * by - ay * bx)
    return total / len(face)


def below(face: Floats, depth: float, *, name: str = "", group: str = "") -> Block:
    """What stands under a face: a prism of vertical sides.

    Parameters
    ----------
    face : ndarray
        Shape (n, 3) [m].
    depth : float
        Of the foot below the lowest corner of the face [m].
    name : str
        Of the block.
    group : str
        Of the block.

    Returns
    -------
    Block
        Its surface turned outwards.
    """
    foot = face.copy()
    foot[:, 2] = face[:, 2].min() - depth
    return prism(foot, face, name=name, group=group)
