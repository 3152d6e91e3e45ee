"""Cut the parts of solids that lie in boxes into convex pieces along the planes of their own faces.

The pieces are the full leaves of a binary space partition (Fuchs, Kedem and Naylor 1980): they are disjoint, each is a
set of half-spaces, and together they fill the solid in the box. All solids are cut at once, one level after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

#: Heights below this fraction of the box are on a plane: rounding.
ON = 1e-9
#: Pairs of a plane and a triangle that are held in memory at once.
CHUNK = 1_000_000


def convex_pieces(solids: Sequence[Floats], lower: Floats, upper: Floats, tolerance: Floats) -> list[list[Floats]]:
    """Cut the part of each solid in its box into convex pieces.

    Parameters
    ----------
    solids : sequence of array of float, shape (m, 3, 3)
        For each solid the corners of the triangles of a closed surface, counter-clockwise seen from outside [m].
    lower, upper : array of float, shape (n, 3)
        Corners of the boxes [m].
    tolerance : array of float, shape (n,)
        A piece whose corners lie outside its faces by no more than this is convex [m].

    Returns
    -------
    list of list of array of float, shape (k, 4)
        For each piece of each solid its half-spaces `row[:3] @ x <= row[3]`, with unit normals.

    Notes
    -----
    No point behind all planes of a piece lies outside the solid: on the way from such a point to the inside one would
    cross a face from its front. So pieces that are convex but for the tolerance are too small, and never too large.

    References
    ----------
    H. Fuchs, Z. M. Kedem and B. F. Naylor, On visible surface generation by a priori tree structures, SIGGRAPH 1980,
    124-133, doi:10.1145/800250.807481.

    Examples
    --------
    >>> from blockstat import box
    >>> from blockstat.geometry.triangulation import triangulate
    >>> cube = box((0, 0, 0), (1, 1, 1))
    >>> corners = np.array(cube.vertices, dtype=float)
    >>> triangles = corners[triangulate(corners, [np.array(face) for face in cube.faces])]
    >>> pieces = convex_pieces([triangles], np.zeros((1, 3)), np.array([[1.0, 1.0, 0.5]]), np.array([1e-6]))
    >>> [len(piece) for piece in pieces[0]]
    [6]
    """
    found: list[list[Floats]] = []
    work = np.cumsum([len(own) ** 2 for own in solids])
    first = 0
    while first < len(solids):
        done = work[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(work, done + CHUNK, side="right")))
        found += _cut(solids[first:last], lower[first:last], upper[first:last], tolerance[first:last])
        first = last
    return found


def contains(triangles: Floats, point: Floats) -> bool:
    """Return whether a point lies inside a closed surface, by its solid angle.

    Parameters
    ----------
    triangles : array of float, shape (n, 3, 3)
        Corners of the triangles, counter-clockwise seen from outside [m].
    point : array of float, shape (3,)
        The point, not on the surface [m].

    Returns
    -------
    bool
        True for a point inside.

    References
    ----------
    A. van Oosterom and J. Strackee, The solid angle of a plane triangle, IEEE Transactions on Biomedical Engineering 30
    (1983) 125-126, doi:10.1109/TBME.1983.325207.
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    dots = la * lb * lc + ab * lc + bc * la + ca * lb
    return bool(2 * np.arctan2(volume, dots).sum() > 2 * np.pi)


@dataclass
class _Tree:
    """Cells of all solids: each is its parent cut by a plane, and the roots are the boxes."""

    solid: Ints
    parent: Ints
    plane: Floats
    full: list[tuple[int, Floats]] = field(default_factory=list)  #: cells of pieces, and planes that bound them further

    def grow(self, parent: Ints, plane: Floats) -> Ints:
        """Cut cells, each by a plane, and return the numbers of what is behind."""
        first = len(self.solid)
        self.solid = np.concatenate([self.solid, self.solid[parent]])
        self.parent = np.concatenate([self.parent, parent])
        self.plane = np.concatenate([self.plane, plane])
        return np.arange(first, len(self.solid))

    def path(self, cell: int) -> list[Floats]:
        """Return the planes that bound a cell within its box."""
        planes = []
        while self.parent[cell] >= 0:
            planes.append(self.plane[cell])
            cell = int(self.parent[cell])
        return planes


def _cut(solids: Sequence[Floats], lower: Floats, upper: Floats, tolerance: Floats) -> list[list[Floats]]:
    n = len(solids)
    # About the middle of its box a solid loses no digits far from the origin.
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    on = 2 * ON * np.linalg.norm(half, axis=1)
    cell = np.repeat(np.arange(n), [len(own) for own in solids])
    parts = np.concatenate(solids) - middle[cell][:, None]
    real = _real(parts, on[cell])
    parts, cell = parts[real], cell[real]
    for axis, sign in ((axis, sign) for axis in range(3) for sign in (1.0, -1.0)):
        wall = np.zeros((len(parts), 4))
        wall[:, axis], wall[:, 3] = sign, half[cell, axis]
        _, _, parts, own = _split(parts, wall, on[cell])
        cell = cell[own]
    tree = _Tree(np.arange(n), np.full(n, -1), np.zeros((n, 4)))
    for k in np.setdiff1d(np.arange(n), cell):
        if contains(solids[k], middle[k]):
            tree.full.append((int(k), np.empty((0, 4))))
    least = np.maximum(tolerance, on)
    while len(parts):
        parts, cell = _level(tree, parts, cell, least, on)
    found: list[list[Floats]] = [[] for _ in solids]
    for k, planes in tree.full:
        solid = int(tree.solid[k])
        walls = np.column_stack([np.vstack([np.eye(3), -np.eye(3)]), np.tile(half[solid], 2)])
        piece = _distinct(np.vstack([planes, *tree.path(k), walls]), float(on[solid]))
        piece[:, 3] += piece[:, :3] @ middle[solid]
        found[solid].append(piece)
    return found


def _level(tree: _Tree, parts: Floats, cell: Ints, least: Floats, on: Floats) -> tuple[Floats, Ints]:
    """Set the convex cells aside and cut the others once; the parts of the surface in what is left, and their cells."""
    order = np.argsort(cell, kind="stable")
    parts, cell = parts[order], cell[order]
    cells, start = np.unique(cell, return_index=True)
    count = np.diff(np.append(start, len(cell)))
    planes = _planes(parts)
    # Each plane with each triangle of its cell.
    group = np.repeat(np.arange(len(cells)), count)
    row, other = members(start[group], count[group])
    normal, reach = planes[row, :3], planes[row, 3]
    heights = [np.einsum("nj,nj->n", parts[other, k], normal) - reach for k in range(3)]
    tight = on[tree.solid[cell]][row]
    # numpy takes the largest of three numbers in each of many rows several times as slowly.
    top, bottom = reduce(np.maximum, heights), reduce(np.minimum, heights)
    first = np.cumsum(count[group]) - count[group]
    front, back = top > tight, bottom < -tight
    ahead = np.maximum.reduceat(top, first)
    reflex = ahead > least[tree.solid[cell]]
    # The plane with surface in front that cuts fewest parts of it, then the one that halves it.
    cut, uneven = np.add.reduceat(front & back, first), np.add.reduceat(front.astype(int) - back.astype(int), first)
    cost = np.where(reflex, cut * (len(parts) + 1.0) + np.abs(uneven), np.inf)
    best = np.lexsort((cost, group))[start]
    notched = reflex[best]
    for k in np.flatnonzero(~notched):
        tree.full.append((int(cells[k]), planes[start[k] : start[k] + count[k]]))
    kept = notched[group]
    plane = planes[best]
    above, up, below, down = _split(parts[kept], plane[group[kept]], on[tree.solid[cell[kept]]])
    up, down = group[kept][up], group[kept][down]
    number = np.full((2, len(cells)), -1)
    cuts = np.flatnonzero(notched)
    number[0, cuts] = tree.grow(cells[cuts], -plane[cuts])
    number[1, cuts] = tree.grow(cells[cuts], plane[cuts])
    # A side without any part of the surface is wholly outside in front of a face, and wholly inside behind it.
    for k in np.setdiff1d(cuts, down):
        tree.full.append((int(number[1, k]), np.empty((0, 4))))
    return np.concatenate([above, below]), np.concatenate([number[0, up], number[1, down]])


def _planes(triangles: Floats) -> Floats:
    normal = _vector_areas(triangles)
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    return np.column_stack([normal, np.einsum("ij,ij->i", normal, triangles.mean(axis=1))])


def _distinct(planes: Floats, on: float) -> Floats:
    """One of each group of planes that are equal but for rounding."""
    keys = np.round(planes / [1e-9, 1e-9, 1e-9, on])
    order = np.lexsort(keys.T)
    new = np.append(True, (np.diff(keys[order], axis=0) != 0).any(axis=1))
    return planes[order[new]]


def _split(triangles: Floats, plane: Floats, on: Floats) -> tuple[Floats, Ints, Floats, Ints]:
    """Parts of triangles in front of a plane each and behind it, with the numbers of the triangles they are from.

    The parts are triangles, too. What lies in its plane is in neither.
    """
    height = np.einsum("nkj,nj->nk", triangles, plane[:, :3]) - plane[:, 3:]
    height[np.abs(height) <= on[:, None]] = 0.0
    up, down = (height > 0).any(axis=1), (height < 0).any(axis=1)
    over, under = np.flatnonzero(up & ~down), np.flatnonzero(down & ~up)
    both = np.flatnonzero(up & down)
    if not len(both):
        return triangles[over], over, triangles[under], under
    corner, h = triangles[both], height[both]
    # The corner that is alone on its side comes first.
    odd = h > 0
    alone = np.where(odd.sum(axis=1) == 1, odd.argmax(axis=1), (~odd).argmax(axis=1))
    turn = (alone[:, None] + np.arange(3)) % 3
    rows = np.arange(len(turn))[:, None]
    corner, h = corner[rows, turn], h[rows, turn]
    share = h[:, :1] / (h[:, :1] - h[:, 1:])
    crossing = corner[:, :1] + share[..., None] * (corner[:, 1:] - corner[:, :1])
    p, q = crossing[:, 0], crossing[:, 1]
    parts = np.stack(
        [corner[:, 0], p, q, p, corner[:, 1], corner[:, 2], p, corner[:, 2], q], axis=1
    ).reshape(-1, 3, 3)  # fmt: skip
    front = (np.repeat(h[:, 0] > 0, 3).reshape(-1, 3) ^ [False, True, True]).reshape(-1)
    source = np.repeat(both, 3)
    real = _real(parts, on[source])
    above, below = front & real, ~front & real
    return (
        np.concatenate([triangles[over], parts[above]]), np.concatenate([over, source[above]]),
        np.concatenate([triangles[under], parts[below]]), np.concatenate([under, source[below]]),
    )  # fmt: skip


def _real(triangles: Floats, on: Floats) -> np.ndarray:
    """Which triangles are wider than rounding: the others have no plane."""
    edge = triangles[:, [1, 2, 0]] - triangles
    longest = np.linalg.norm(edge, axis=2).max(axis=1, initial=0.0)
    return 2 * np.linalg.norm(_vector_areas(triangles), axis=1) > on * longest


def _vector_areas(triangles: Floats) -> Floats:
    """Area of each triangle times its normal; numpy.cross takes several times as long on few of them."""
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return (u[:, [1, 2, 0]] * v[:, [2, 0, 1]] - u[:, [2, 0, 1]] * v[:, [1, 2, 0]]) / 2
