"""Cut the parts of solids that lie in boxes into convex pieces along the planes of their own faces.

The pieces are the full leaves of a binary space partition (Fuchs, Kedem and Naylor 1980): they are disjoint, each is a
set of half-spaces, and together they fill the solid in the box. All solids are cut at once, one level after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from blockstat.geometry.inscribed_ball import inscribed_balls
from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

#: Heights below this fraction of the diagonal of the box are on a plane: rounding.
ON = 1e-9
#: Pairs of a plane and a triangle that are held in memory at once.
CHUNK = 1_000_000


def convex_pieces(
    solids: Sequence[Floats], lower: Floats, upper: Floats, tolerance: Floats, *, most: float = np.inf
) -> list[list[Floats]]:
    """Cut the part of each solid in its box into convex pieces.

    Parameters
    ----------
    solids : sequence of array of float, shape (m, 3, 3)
        For each solid the corners of the triangles of a closed surface, counter-clockwise seen from outside [m].
    lower, upper : array of float, shape (n, 3)
        Corners of the boxes [m].
    tolerance : array of float, shape (n,)
        A piece whose corners lie outside its faces by no more than this is convex [m].
    most : float
        Solids that cuts divide into more parts than this, with those beside the solids, are given up: no pieces.

    Returns
    -------
    list of list of array of float, shape (k, 4)
        For each piece of each solid its half-spaces `row[:3] @ x <= row[3]`, with unit normals.

    Notes
    -----
    A part of a triangle keeps the plane of the whole, and lies in it whatever rounding says. So each cut uses up a face
    and the cuts come to an end, and a sliver left over by a cut has no plane of its own.

    Two faces make a notch where one reaches in front of the other by more than the tolerance; when one is narrower than
    that, where each does. A sliver whose plane is rounding has the faces beside it in front of its plane, but is not in
    front of theirs: it makes no notch.

    Surface that lies in the plane of a cut but for rounding is lost, and so is a notch narrower than the tolerance.
    Whether a piece is of the solid is therefore not told by the face that bounds it but by the whole surface: by the
    solid angle about the centre of the largest ball in the piece, as far as can be from all that was lost.

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
        found += _cut(solids[first:last], lower[first:last], upper[first:last], tolerance[first:last], most)
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
    return bool(solid_angles(triangles - point).sum() > 2 * np.pi)


def solid_angles(triangles: Floats) -> Floats:
    """Return the solid angle of each triangle seen from the origin.

    Parameters
    ----------
    triangles : array of float, shape (n, 3, 3)
        Corners [m].

    Returns
    -------
    array of float, shape (n,)
        Solid angles, positive for triangles that look away from the origin. Over a closed surface they sum up to its
        winding number times 4 pi.
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    dots = la * lb * lc + ab * lc + bc * la + ca * lb
    return 2 * np.arctan2(volume, dots)


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

    def leave(self, cells: Ints) -> None:
        """Set aside cells without any part of the surface, which are wholly inside or wholly outside."""
        self.full += [(cell, np.empty((0, 4))) for cell in cells.tolist()]

    def path(self, cell: int) -> list[Floats]:
        """Return the planes that bound a cell within its box."""
        planes = []
        while self.parent[cell] >= 0:
            planes.append(self.plane[cell])
            cell = int(self.parent[cell])
        return planes


def winding_balls(
    solids: Sequence[Floats], lower: Floats, upper: Floats, tolerance: Floats, *, most: float = np.inf
) -> list[tuple[Ints, Floats, Floats] | None]:
    """Return how often a surface encloses the convex pieces of each box that it cuts out, with the largest balls there.

    Parameters
    ----------
    solids, lower, upper, tolerance, most
        As of `convex_pieces`; the surfaces may pass through themselves.

    Returns
    -------
    list of tuple or None
        For each box the winding number of each piece, the diameter of the largest ball in it [m] and the centre of
        that ball [m]; None where cuts were given up. Of two regions beside each other the one that the surface looks
        away from is among the pieces, so the largest winding number is, too.
    """
    pieces, owner, middle, around = _leaves(solids, lower, upper, tolerance, most)
    number, radius, centre = _winding(pieces, owner, *around)
    many = np.bincount(owner, minlength=len(solids)) > most
    found: list[tuple[Ints, Floats, Floats] | None] = []
    for solid in range(len(solids)):
        own = np.flatnonzero((owner == solid) & np.isfinite(number))
        times = np.rint(number[own]).astype(np.int64)
        found.append(None if many[solid] else (times, 2 * radius[own], centre[own] + middle[solid]))
    return found


def _cut(solids: Sequence[Floats], lower: Floats, upper: Floats, tolerance: Floats, most: float) -> list[list[Floats]]:
    pieces, owner, middle, around = _leaves(solids, lower, upper, tolerance, most)
    found: list[list[Floats]] = [[] for _ in solids]
    many = np.bincount(owner, minlength=len(solids)) > most
    kept = np.flatnonzero(~many[owner])
    for k in kept[_filled([pieces[k] for k in kept], owner[kept], *around)].tolist():
        pieces[k][:, 3] += pieces[k][:, :3] @ middle[owner[k]]
        found[owner[k]].append(pieces[k])
    return found


def _leaves(
    solids: Sequence[Floats], lower: Floats, upper: Floats, tolerance: Floats, most: float
) -> tuple[list[Floats], Ints, Floats, tuple[Floats, Ints, Floats]]:
    """Planes of the convex cells, their solids and the middles of the boxes; about these, the surfaces and rounding."""
    n = len(solids)
    # About the middle of its box a solid loses no digits far from the origin.
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    on = 2 * ON * np.linalg.norm(half, axis=1)
    cell = np.repeat(np.arange(n), [len(own) for own in solids])
    surface = np.concatenate(solids) - middle[cell][:, None]
    parts = _Parts(surface, cell, np.arange(len(cell))).take(_real(surface, on[cell]))
    for axis, sign in ((axis, sign) for axis in range(3) for sign in (1.0, -1.0)):
        wall = np.zeros((len(parts.cell), 4))
        wall[:, axis], wall[:, 3] = sign, half[parts.cell, axis]
        parts = parts.split(wall, on[parts.cell])[1]
    faces, own = np.unique(parts.face, return_inverse=True)
    parts.face = _faces(surface[faces], cell[faces], on)[own]
    planes = _planes(surface[faces])
    tree = _Tree(np.arange(n), np.full(n, -1), np.zeros((n, 4)))
    tree.leave(np.setdiff1d(np.arange(n), parts.cell))
    least = np.maximum(tolerance, on)
    while len(parts.cell):
        parts = _level(tree, parts, planes, least, on)
        many = np.bincount(tree.solid[[k for k, _ in tree.full]], minlength=n) > most
        parts = parts.take(~many[tree.solid[parts.cell]])
    walls = np.vstack([np.eye(3), -np.eye(3)])
    pieces, owner = [], tree.solid[[k for k, _ in tree.full]]
    for solid, (k, bounds) in zip(owner.tolist(), tree.full, strict=True):
        box = np.column_stack([walls, np.tile(half[solid], 2)])
        pieces.append(_distinct(np.vstack([bounds, *tree.path(k), box]), float(on[solid])))
    return pieces, owner, middle, (surface, cell, on)


def _faces(triangles: Floats, cell: Ints, on: Floats) -> Ints:
    """For each triangle the widest one of its solid in whose plane it lies and that looks its way, mostly itself."""
    planes, order = _planes(triangles), np.lexsort((-_widths(triangles), cell))
    count = np.bincount(cell, minlength=len(on))[cell]
    row, place = members(np.searchsorted(cell, cell), count)
    other = order[place]
    height = [np.einsum("nj,nj->n", triangles[row, k], planes[other, :3]) - planes[other, 3] for k in range(3)]
    same = reduce(np.maximum, map(np.abs, height)) <= on[cell[row]]
    same &= np.einsum("nj,nj->n", planes[row, :3], planes[other, :3]) > 0
    same |= row == other
    where = np.flatnonzero(same)
    _, first = np.unique(row[where], return_index=True)
    return other[where[first]]


def _level(tree: _Tree, parts: _Parts, planes: Floats, least: Floats, on: Floats) -> _Parts:
    """Set the convex cells aside and cut the others once; the parts of the surface in what is left."""
    parts = parts.take(np.lexsort((parts.face, parts.cell)))
    cells, start = np.unique(parts.cell, return_index=True)
    side = _Sides.of(parts, planes, least[tree.solid[cells]], on[tree.solid[cells]])
    # The plane with surface in front that cuts fewest parts of it, then the one that halves it.
    best = np.lexsort((side.cost, side.cell))[side.first]
    notched = np.isfinite(side.cost[best])
    group = np.repeat(np.arange(len(cells)), np.diff(np.append(start, len(parts.cell))))
    for k in np.flatnonzero(~notched):
        own = np.arange(side.first[k], side.first[k] + side.count[k])
        tree.full.append((int(cells[k]), planes[side.face[own[side.bounds[own]]]]))
    # What lies in the face that cuts lies in the plane, whatever rounding says: so the faces come to an end.
    kept = np.flatnonzero(notched[group] & (parts.face != side.face[best][group]))
    cuts = cells[notched]
    plane = planes[side.face[best[notched]]]
    front, back = tree.grow(cuts, -plane), tree.grow(cuts, plane)
    at = np.cumsum(notched)[group[kept]] - 1
    above, below = parts.take(kept).split(plane[at], on[tree.solid[parts.cell[kept]]])
    above.cell, below.cell = front[np.searchsorted(cuts, above.cell)], back[np.searchsorted(cuts, below.cell)]
    tree.leave(np.setdiff1d(front, above.cell))
    tree.leave(np.setdiff1d(back, below.cell))
    return above.joined(below)


@dataclass
class _Parts:
    """Parts of the surfaces: triangles, cell after cell or not."""

    triangle: Floats  #: shape (n, 3, 3)
    cell: Ints  #: the cell that each lies in
    face: Ints  #: the triangle in whose plane it lies, as told before anything was cut

    def take(self, rows: np.ndarray) -> _Parts:
        return _Parts(self.triangle[rows], self.cell[rows], self.face[rows])

    def joined(self, other: _Parts) -> _Parts:
        return _Parts(*(np.concatenate([a, b]) for a, b in zip(vars(self).values(), vars(other).values(), strict=True)))

    def split(self, plane: Floats, on: Floats) -> tuple[_Parts, _Parts]:
        """What is in front of a plane each and what is behind it."""
        above, up, below, down = _split(self.triangle, plane, on)
        return _Parts(above, self.cell[up], self.face[up]), _Parts(below, self.cell[down], self.face[down])


@dataclass
class _Sides:
    """The faces that have parts in a cell, cell after cell."""

    face: Ints
    cell: Ints  #: number among the cells
    first: Ints  #: where those of each cell begin
    count: Ints  #: how many each cell has
    bounds: np.ndarray  #: which bound a convex piece
    cost: Floats  #: of a cut in the plane of each, infinite where none is needed

    @classmethod
    def of(cls, parts: _Parts, planes: Floats, least: Floats, on: Floats) -> _Sides:
        """Measure each face in a cell with each part of the surface there; the parts come cell after cell, by faces."""
        new = (np.diff(parts.cell, prepend=-1) != 0) | (np.diff(parts.face, prepend=-1) != 0)
        side, begin = np.cumsum(new) - 1, np.flatnonzero(new)
        cell = np.cumsum(np.diff(parts.cell, prepend=-1) != 0)[begin] - 1
        first = np.searchsorted(cell, np.arange(len(least)))
        count, size = np.diff(np.append(first, len(cell))), np.diff(np.append(begin[first], len(side)))
        row, other = members(begin[first][cell], size[cell])
        normal, reach = planes[parts.face[begin], :3][row], planes[parts.face[begin], 3][row]
        heights = [np.einsum("nj,nj->n", parts.triangle[other, k], normal) - reach for k in range(3)]
        # numpy takes the largest of three numbers in each of many rows several times as slowly.
        strange = side[other] != row
        top, bottom = reduce(np.maximum, heights) * strange, reduce(np.minimum, heights) * strange
        # How far each face reaches in front of each other one; and the other way round, in blocks of rows and columns.
        pair = np.flatnonzero((np.diff(row, prepend=-1) != 0) | (np.diff(side[other], prepend=-1) != 0))
        gap, i, j = np.maximum.reduceat(top, pair), row[pair], side[other[pair]]
        own = cell[i]
        back = (np.cumsum(count**2) - count**2 - first)[own] + (j - first[own]) * count[own] + i
        each = np.cumsum(count[cell]) - count[cell]
        ahead = np.maximum.reduceat(gap, each)
        # A face narrower than the tolerance is within it of the faces beside, and its plane may be rounding.
        wide = np.maximum.reduceat(_widths(parts.triangle), begin) > least[cell]
        notch = np.where(wide[i] & wide[j], gap, np.minimum(gap, gap[back]))
        reflex = np.maximum.reduceat(notch, each) > least[cell]
        tight, at = on[cell][row], np.cumsum(size[cell]) - size[cell]
        over, under = top > tight, bottom < -tight
        cut, uneven = np.add.reduceat(over & under, at, dtype=int), np.add.reduceat(over * 1 - under * 1, at)
        cost = np.where(reflex, cut * (len(side) + 1.0) + np.abs(uneven), np.inf)
        return cls(parts.face[begin], cell, first, count, wide | (ahead <= least[cell]), cost)


def _filled(pieces: list[Floats], owner: Ints, surface: Floats, cell: Ints, on: Floats) -> np.ndarray:
    """Which pieces are wider than rounding and lie inside their solids."""
    number, _, _ = _winding(pieces, owner, surface, cell, on)
    # A surface that looks inwards encloses what is outside of it.
    signed = np.einsum("ij,ij->i", surface[:, 0], np.cross(surface[:, 1], surface[:, 2]))
    turned = np.bincount(cell, signed, len(on)) < 0
    return np.isfinite(number) & (number + turned[owner] > 0.5)


def _winding(
    pieces: list[Floats], owner: Ints, surface: Floats, cell: Ints, on: Floats
) -> tuple[Floats, Floats, Floats]:
    """How often surfaces enclose the centres of the largest balls in pieces, with radii and centres of these.

    It is told by the solid angle, and nan for pieces no wider than rounding.
    """
    start = np.cumsum([0, *map(len, pieces)])
    planes = np.concatenate([np.empty((0, 4)), *pieces])
    radius, centre = inscribed_balls(planes[:, :3], planes[:, 3], start)
    wide = np.flatnonzero(radius > on[owner])
    first = np.searchsorted(cell, np.arange(len(on) + 1))
    number = np.full(len(pieces), np.nan)
    work = np.cumsum(np.diff(first)[owner[wide]])
    for own in np.split(wide, np.searchsorted(work, np.arange(CHUNK, work[-1], CHUNK)) if len(wide) else []):
        row, triangle = members(first[owner[own]], np.diff(first)[owner[own]])
        angle = np.bincount(row, solid_angles(surface[triangle] - centre[own][row][:, None]), len(own))
        number[own] = angle / (4 * np.pi)
    return number, radius, centre


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
    return _widths(triangles) > on


def _widths(triangles: Floats) -> Floats:
    """Least height of each triangle, 0 where its corners are one point."""
    longest = np.linalg.norm(triangles[:, [1, 2, 0]] - triangles, axis=2).max(axis=1, initial=0.0)
    return 2 * np.linalg.norm(_vector_areas(triangles), axis=1) / np.where(longest > 0, longest, 1.0)


def _vector_areas(triangles: Floats) -> Floats:
    """Area of each triangle times its normal; numpy.cross takes several times as long on few of them."""
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return (u[:, [1, 2, 0]] * v[:, [2, 0, 1]] - u[:, [2, 0, 1]] * v[:, [1, 2, 0]]) / 2
