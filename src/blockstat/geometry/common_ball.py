"""The largest ball inside two solids at once: how deep they overlap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.geometry.convex_pieces import convex_pieces
from blockstat.geometry.inscribed_ball import inscribed_balls
from blockstat.geometry.polyhedron import NARROW, Polyhedra, members
from blockstat.geometry.triangulation import fans, triangulate
from blockstat.typing import Floats, Ints

#: Pairs that are measured at once.
CHUNK = 100_000
#: Blocks of up to this many triangles are cut once, as a whole. Others are cut for each pair in the box that both
#: share: the work grows faster than the number of triangles.
FEW = 100
#: Of more triangles than this in the box that two blocks share, cells of the box are looked at first: most blocks that
#: touch along curved surfaces overlap in none of them.
MANY = 300
#: Boxes are halved no further where the smaller half has more than this share of their triangles.
HALVED = 0.8
#: Cells that are looked at at once.
CELLS = 200
#: What sticks out of a block by less than this fraction of its size is inside of it.
FLUSH = 1e-6


def convex_depths(blocks: Polyhedra, pairs: Ints, least: Floats, outward: Floats | None = None) -> Floats:
    """Return the diameter of the largest ball behind all face planes of both blocks of each pair.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    pairs : array of int, shape (n, 2)
        Two blocks each.
    least : array of float, shape (n,)
        Diameters that matter [m]; of those that are no larger, an upper bound is enough.
    outward : array of float, shape (n_faces,), optional
        How far each plane is moved outwards first [m].

    Returns
    -------
    array of float, shape (n,)
        Diameters [m], zero or less where no point is behind all planes. For convex blocks this is the depth of their
        overlap; with planes that are moved out to the last corner of a concave block it is an upper bound.
    """
    reach = np.einsum("ij,ij->i", blocks.planes.normal, blocks.planes.centre)
    reach = reach if outward is None else reach + outward
    first = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    found = [np.empty(0)]
    for own in np.split(np.arange(len(pairs)), np.arange(CHUNK, len(pairs), CHUNK)):
        rows = pairs[own]
        # A block takes part in a set with all its faces: those of a first, then those of b.
        side, face = members(first[rows.reshape(-1)], np.diff(first)[rows.reshape(-1)])
        origin = blocks.centroid[rows[:, 0]][side // 2]
        normal = blocks.planes.normal[face]
        offset = reach[face] - np.einsum("ij,ij->i", normal, origin)
        start = np.searchsorted(side, 2 * np.arange(len(rows) + 1))
        found.append(2.0 * inscribed_balls(normal, offset, start, least[own] / 2)[0])
    return np.concatenate(found)


def piece_depths(blocks: Polyhedra, pairs: Ints, tolerance: Floats, outward: Floats) -> Floats:
    """Return the diameter of the largest ball inside a convex piece of each block of each pair.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks, convex or not.
    pairs : array of int, shape (n, 2)
        Two blocks each, whose boxes have a common part.
    tolerance : array of float, shape (n,)
        How far the corners of a convex piece may lie outside its faces, and the diameters that matter [m].
    outward : array of float, shape (n_faces,)
        How far the last corner of its block lies in front of each face [m].

    Returns
    -------
    array of float, shape (n,)
        Diameters [m]. The ball lies in both blocks but for the tolerance. Of those that are no larger than the
        tolerance an upper bound is given.
    """
    lower, upper = blocks.bounds
    used, number = np.unique(pairs, return_inverse=True)
    number = number.reshape(-1, 2)
    triangles = [_triangles(blocks, int(block)) for block in used]
    low, high = lower[pairs].max(axis=1), upper[pairs].min(axis=1)
    depth = _depths_in_cells(triangles, number, low, high, tolerance)
    deep = np.flatnonzero(np.isnan(depth) | (depth > tolerance))
    least = np.full(len(used), np.inf)
    np.minimum.at(least, number[deep], tolerance[deep, None])
    few = np.array([len(own) <= FEW for own in triangles], dtype=bool)
    small = np.flatnonzero(few & np.isfinite(least))
    whole = convex_pieces([triangles[k] for k in small], lower[used[small]], upper[used[small]], least[small])
    row, side = np.nonzero(~few[number[deep]])
    row = deep[row]
    cut = convex_pieces([triangles[k] for k in number[row, side]], low[row], high[row], tolerance[row])
    # The solid of each side of each pair: a block as a whole, or its part in the box of the pair.
    place = np.zeros(len(used), dtype=np.int64)
    place[small] = np.arange(len(small))
    solid = place[number]
    solid[row, side] = len(small) + np.arange(len(row))
    hulls = [[_hull(blocks, int(block), outward)] for block in used]
    pieces = _Pieces.of([*whole, *cut, *hulls])
    hull = len(whole) + len(cut) + number
    depth[deep] = _piece_depths(pieces, solid[deep], low[deep], tolerance[deep], hull[deep])
    return depth


def _depths_in_cells(triangles: list[Floats], number: Ints, low: Floats, high: Floats, tolerance: Floats) -> Floats:
    """Diameter of the largest ball in a piece of both solids and in a cell of the box that they share [m].

    nan for pairs of so few triangles that there are no cells. The cells reach over each other by so much that a ball
    wider than the tolerance has a part in one of them that is, too.
    """
    cells = [_cells([triangles[k] for k in own], *box) for own, *box in zip(number, low, high, tolerance, strict=True)]
    row = np.repeat(np.arange(len(number)), list(map(len, cells)))
    depth = np.full(len(number), np.nan)
    depth[row] = 0.0
    for own in np.split(np.arange(len(row)), np.arange(CELLS, len(row), CELLS)):
        box = np.concatenate([np.empty((0, 2, 3)), *cells])[own]
        both = np.repeat(row[own], 2)
        solids = [triangles[k] for k in number[row[own]].reshape(-1)]
        lower, upper = (np.repeat(corner, 2, axis=0) for corner in (box[:, 0], box[:, 1]))
        pieces = _Pieces.of(convex_pieces(solids, lower, upper, tolerance[both]))
        solid = np.arange(2 * len(own)).reshape(-1, 2)
        np.maximum.at(depth, row[own], _piece_depths(pieces, solid, box[:, 0], tolerance[row[own]]))
    return depth


def _cells(solids: list[Floats], low: Floats, high: Floats, margin: float) -> Floats:
    """Corners of boxes that fill one and reach over each other, in each of which few triangles of two solids lie.

    Shape (n, 2, 3) [m], with n = 0 where few lie in the box as a whole.
    """
    corners = np.concatenate(solids)
    bottom, top = corners.min(axis=1) - margin, corners.max(axis=1) + margin
    own = np.flatnonzero(((bottom <= high) & (top >= low)).all(axis=1))
    if len(own) <= MANY:
        return np.empty((0, 2, 3))
    cells, open_ones = [], [(low, high, own)]
    while open_ones:
        low, high, own = open_ones.pop()
        axis = int(np.argmax(high - low))
        middle = (low[axis] + high[axis]) / 2
        halves = [own[bottom[own, axis] <= middle], own[top[own, axis] >= middle]]
        if len(own) <= FEW or min(map(len, halves)) > HALVED * len(own) or high[axis] - low[axis] <= 4 * margin:
            cells.append((low - margin, high + margin))
            continue
        for k, half in enumerate(halves):
            ends = low.copy(), high.copy()
            ends[1 - k][axis] = middle
            open_ones.append((*ends, half))
    return np.array(cells)


@dataclass(frozen=True)
class _Pieces:
    """Half-spaces of pieces of solids, one piece after the other."""

    planes: Floats
    start: Ints  #: where the planes of each piece begin
    first: Ints  #: where the pieces of each solid begin

    @classmethod
    def of(cls, solids: list[list[Floats]]) -> _Pieces:
        pieces = [piece for own in solids for piece in own]
        start = np.cumsum([0, *map(len, pieces)])
        return cls(np.concatenate([np.empty((0, 4)), *pieces]), start, np.cumsum([0, *map(len, solids)]))

    def common(self, one: Ints, two: Ints, origin: Floats, least: Floats) -> Floats:
        """Diameter of the largest ball in both of two pieces each, seen from origins near them [m]."""
        both = np.column_stack([one, two]).reshape(-1)
        side, plane = members(self.start[both], np.diff(self.start)[both])
        normal = self.planes[plane, :3]
        offset = self.planes[plane, 3] - np.einsum("ij,ij->i", normal, origin[side // 2])
        start = np.searchsorted(side, 2 * np.arange(len(one) + 1))
        return 2.0 * inscribed_balls(normal, offset, start, least / 2)[0]


def _piece_depths(pieces: _Pieces, solid: Ints, origin: Floats, least: Floats, hull: Ints | None = None) -> Floats:
    """Diameter of the largest ball in a piece of each of two solids of each pair [m].

    Pieces that do not reach into the hull of the other solid, which is a piece of its own, need not be tried.
    """
    kept: list[tuple[Ints, Ints]] = []
    for side in (0, 1):
        pair, piece = members(pieces.first[solid[:, side]], np.diff(pieces.first)[solid[:, side]])
        if hull is not None:
            other = pieces.first[hull[pair, 1 - side]]
            into = pieces.common(piece, other, origin[pair], least[pair]) > least[pair]
            pair, piece = pair[into], piece[into]
        kept.append((pair, piece))
    (pair_one, one), (pair_two, two) = kept
    start = np.searchsorted(pair_two, np.arange(len(solid) + 1))
    row, place = members(start[pair_one], np.diff(start)[pair_one])
    pair = pair_one[row]
    depth = np.zeros(len(solid))
    np.maximum.at(depth, pair, pieces.common(one[row], two[place], origin[pair], least[pair]))
    return depth


def lies_inside(blocks: Polyhedra, a: int, b: int) -> bool:
    """Return whether one of two blocks that overlap lies wholly inside the other.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks, convex or not.
    a, b : int
        Numbers of the inner and of the outer block.

    Returns
    -------
    bool
        True when no part of block a is outside block b.
    """
    lower, upper = (bound[a] for bound in blocks.bounds)
    flush = FLUSH * float(blocks.size[a])
    low, high = (bound[b] for bound in blocks.bounds)
    if (lower < low - flush).any() or (upper > high + flush).any():
        return False
    # With its surface turned, a block becomes what is outside of it.
    solids = [_triangles(blocks, a), _triangles(blocks, b)[:, ::-1]]
    inner, outside = convex_pieces(solids, np.tile(lower, (2, 1)), np.tile(upper, (2, 1)), np.full(2, flush))
    least = np.array([2 * flush])
    return bool(_piece_depths(_Pieces.of([inner, outside]), np.array([[0, 1]]), lower[None], least)[0] <= 2 * flush)


def _triangles(blocks: Polyhedra, block: int) -> Floats:
    """Corners of the triangles of a block's surface, shape (n, 3, 3) [m]; two that share a warped face agree on it."""
    corners, faces = blocks.block_vertices(block), blocks.faces_of(block)
    first = int(np.searchsorted(blocks.face_block, block))
    bent = blocks.planes.warp[first : first + len(faces)] > NARROW * blocks.size[block]
    triangles, flat = [], [face for face, warped in zip(faces, bent, strict=True) if not warped]
    for number in np.flatnonzero(bent).tolist():
        fan = fans(corners[faces[number]], np.array([0, len(faces[number])]))
        side = np.cross(fan[:, 1] - fan[:, 0], fan[:, 2] - fan[:, 0]) @ blocks.planes.normal[first + number]
        if side.min() > 0:
            triangles.append(fan)
        else:
            flat.append(faces[number])
    return np.concatenate([*triangles, *([corners[triangulate(corners, flat)]] if flat else [])])


def _hull(blocks: Polyhedra, block: int, outward: Floats) -> Floats:
    """Planes of the faces of a block, each moved out to its last corner, shape (n, 4)."""
    own = slice(*np.searchsorted(blocks.face_block, [block, block + 1]))
    normal, centre = blocks.planes.normal[own], blocks.planes.centre[own]
    return np.column_stack([normal, (normal * centre).sum(axis=1) + outward[own]])
