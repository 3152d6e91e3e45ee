"""Cut a concave block into convex pieces whose outer faces are the block's own.

General decomposers (CoACD) remesh: a groin voussoir becomes 38 pieces whose corners are a thousandth of the
block off, and such blocks wedge where they should touch. Masonry blocks have a few reflex edges, and a plane
through a reflex edge removes it, so cutting again and again ends quickly and moves no face. Cuts are left open, and
where one goes round a hole its parts share no corner. So pieces are tried against the block, and a block of which they
would fill a recess is cut along the planes of its faces (`dynsim.engine.filling`).

A block with warped faces comes apart at its own corners, which no plane hits exactly. Hulls of such parts stand out of
its hollow faces, blocks wedge or lie loose, and sound vaults fall. Where a point inside sees all faces, pieces that
meet there keep every face as it is. Only LMGC90 gets these: in Bullet, pieces of two blocks that touch in no more than
an edge find a normal along the joint, and a slab of such pieces on another does not slide at any angle.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.typing import Floats, Ints
from dynsim.engine.filling import fills, part_above, pieces_between_planes

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

#: What is tried in turn, unless the pieces fill a deep recess (`fills`): a reflex edge shallower than the first figure,
#: relative to the block's size, is a warped face and the hull stands for it; corners as close to a cutting plane as the
#: second lie on it; pieces whose total volume is off by more than the third have failed. Cuts of flat faces are exact.
ATTEMPTS = (
    (5e-3, 1e-9, 1e-4),
    (5e-3, 5e-3, 0.02),
    (2e-2, 2e-2, 0.1),
    (0.1, 0.1, 0.05),
    (5e-3, 1e-9, 0.02),
    (2e-2, 1e-9, 0.1),
)
#: The same where faces must keep their places: these move them by a thousandth of the block, 0.3 mm on a stone of
#: 0.3 m.
FINE_CUTS = ((1e-3, 1e-3, 1e-2), (1e-3, 1e-9, 1e-4))
#: Pieces between the planes of the faces fill nothing; they may lack this share of the volume.
PARTITION = 0.02
#: Corners this close to a plane lie on it, relative to the block's size: rounding of coordinates.
FLUSH = 1e-7
#: How far inside of all faces the point must lie that sees them, relative to the block's size: else pieces are thin.
INSIDE = 0.01
#: More pieces than this and the cutting has failed.
MOST_PIECES = 40
#: Pieces between the planes of the faces may be more: they are disjoint, and stones with meshed curved faces of some
#: hundred triangles need up to sixty.
MOST_BETWEEN_PLANES = 100


class Cut(NamedTuple):
    """A block in convex pieces."""

    pieces: tuple[Floats, ...]  #: corners of each, shape (k, 3) [m]
    filled: bool  #: whether they fill recesses that are too deep for it


def convex_pieces(
    surface: Floats, size: float, depth: float, *, exact: bool = False, planes: bool = True
) -> Cut | None:
    """Cut a closed surface into convex pieces.

    Parameters
    ----------
    surface : array of float, shape (k, 3, 3)
        Corners of its triangles [m], counter-clockwise seen from outside.
    size : float
        Length that tolerances refer to [m].
    depth : float
        Recesses up to this depth may be filled [m].
    exact : bool
        Keep warped faces in their places, by more pieces, where the block allows it.
    planes : bool
        Try the planes of the faces at last, which takes long where there are many.

    Returns
    -------
    Cut or None
        The first pieces that fill no deeper recess, or else the first ones; None when the surface cannot be cut well.
    """
    volume = float(np.einsum("ij,ij->i", surface[:, 0], np.cross(surface[:, 1], surface[:, 2])).sum()) / 6

    def judged(pieces: Sequence[ConvexHull], error: float) -> Cut | None:
        if not pieces or abs(sum(hull.volume for hull in pieces) / volume - 1.0) > error:
            return None
        return Cut(_corners(pieces), fills(surface, pieces, depth))

    def cuts() -> Iterator[Cut | None]:
        if exact:
            for shallow, near, error in FINE_CUTS:
                yield judged(_cut_up(surface, shallow * size, near * size, size), error)
            yield Cut(tuple(star), False) if (star := star_pieces(surface, size)) else None
        for shallow, near, error in ATTEMPTS:
            yield judged(_cut_up(surface, shallow * size, near * size, size), error)
        if planes:
            yield judged(pieces_between_planes(surface, depth, FLUSH * size, MOST_BETWEEN_PLANES), PARTITION)

    first = None
    for found in cuts():
        if found and not found.filled:
            return found
        first = first or found
    return first


def _corners(pieces: Sequence[ConvexHull]) -> tuple[Floats, ...]:
    return tuple(hull.points[hull.vertices] for hull in pieces)


@dataclass(frozen=True, eq=False)
class _Piece:
    """Triangles of the surface, seen from one point inside."""

    corners: frozenset[int]
    beyond: frozenset[int]  #: corners of the block beyond the plane of one of the triangles
    rim: frozenset[tuple[int, int]]  #: edges between these triangles and others
    volume: float  #: six times that between the triangles and the point

    def united(self, other: _Piece) -> _Piece:
        rim = self.rim ^ other.rim
        inner = {edge for edge in rim if edge[::-1] in rim}
        return _Piece(self.corners | other.corners, self.beyond | other.beyond, rim - inner, self.volume + other.volume)


def star_pieces(surface: Floats, size: float) -> list[Floats] | None:
    """Cut a star-shaped block, however warped its faces are, into convex pieces that meet at one point inside.

    Parameters
    ----------
    surface : array of float, shape (k, 3, 3)
        Corners of the triangles of a closed surface [m], counter-clockwise seen from outside.
    size : float
        Length that tolerances refer to [m].

    Returns
    -------
    list of arrays of float, shape (k, 3), or None
        Corners of each piece [m]; None where no point well inside sees all faces, and for too many pieces.

    Notes
    -----
    Each triangle and the point make a tetrahedron. Two pieces that share an edge are united when the result is convex:
    when none of its corners lies beyond the plane of one of its triangles, or of an edge of its rim and the point. The
    smallest union comes first, until there is none.
    """
    centre = _point_that_sees_all(surface, size)
    if centre is None:
        return None
    corner = _indices(surface, size)
    points = np.empty((int(corner.max()) + 1, 3))
    points[corner.reshape(-1)] = surface.reshape(-1, 3)
    edges = [(row[k], row[(k + 1) % 3]) for row in corner.tolist() for k in range(3)]
    ends = points[np.array(edges)] - centre
    sides = np.cross(ends[:, 1], ends[:, 0])  # of the tetrahedra, away from them
    sides /= np.linalg.norm(sides, axis=1)[:, None]
    normal = _normals(surface)
    above = points @ normal.T > np.einsum("ij,ij->i", surface[:, 0], normal) + FLUSH * size
    aside = (points - centre) @ sides.T > FLUSH * size
    beyond_side = {edge: frozenset(np.flatnonzero(aside[:, k]).tolist()) for k, edge in enumerate(edges)}
    volume = np.einsum("ij,ij->i", surface[:, 0] - centre, np.cross(surface[:, 1] - centre, surface[:, 2] - centre))
    pieces = [
        _Piece(
            frozenset(row), frozenset(np.flatnonzero(above[:, t]).tolist()), frozenset(edges[3 * t : 3 * t + 3]),
            float(volume[t]),
        )
        for t, row in enumerate(corner.tolist())
    ]  # fmt: skip
    found = _unite(pieces, beyond_side)
    if len(found) > MOST_PIECES:
        return None
    return [np.vstack([points[sorted(piece.corners)], centre]) for piece in found]


def _point_that_sees_all(surface: Floats, size: float) -> Floats | None:
    """The point furthest inside of the planes of all triangles, if it is far enough inside."""
    from scipy.optimize import linprog

    normal = _normals(surface)
    rows = np.column_stack([normal, np.ones(len(normal))])
    heights = np.einsum("ij,ij->i", normal, surface[:, 0])
    found = linprog([0.0, 0.0, 0.0, -1.0], A_ub=rows, b_ub=heights, bounds=(None, None))
    return found.x[:3] if found.status == 0 and found.x[3] >= INSIDE * size else None


def _unite(pieces: Sequence[_Piece], beyond_side: dict[tuple[int, int], frozenset[int]]) -> list[_Piece]:
    """Unite pieces that share an edge and are convex together, the smallest union first."""
    owner = {edge: piece for piece in pieces for edge in piece.rim}
    count = itertools.count()  # settles ties, so that the order does not hang on the address of a piece
    waiting: list[tuple[float, int, _Piece, _Piece, _Piece]] = []

    def propose(one: _Piece) -> None:
        for other in dict.fromkeys(owner[back] for a, b in sorted(one.rim) if (back := (b, a)) in owner):
            both = one.united(other)
            if both.beyond.union(*(beyond_side[edge] for edge in both.rim)).isdisjoint(both.corners):
                heapq.heappush(waiting, (both.volume, next(count), one, other, both))

    for piece in pieces:
        propose(piece)
    live = {id(piece): piece for piece in pieces}
    while waiting:
        *_, one, other, both = heapq.heappop(waiting)
        if id(one) in live and id(other) in live:
            del live[id(one)], live[id(other)]
            live[id(both)] = both
            owner.update(dict.fromkeys(both.rim, both))
            propose(both)
    return list(live.values())


def _cut_up(surface: Floats, shallow: float, near: float, size: float) -> list[ConvexHull]:
    """Hulls of the pieces without reflex edges deeper than `shallow` [m]; none if there are too many or flat ones."""
    from scipy.spatial import ConvexHull, QhullError

    waiting, done = [surface], []
    while waiting:
        soup = waiting.pop()
        edge = _deepest_reflex_edge(soup, shallow, size)
        if edge is None:
            done.append(_distinct(soup.reshape(-1, 3), size))
        else:
            waiting += [part for side in _best_cut(soup, *edge, near) for part in _connected(side, size)]
        if len(waiting) + len(done) > MOST_PIECES:
            return []
    try:
        return [ConvexHull(points) for points in done]
    except (QhullError, ValueError):
        return []


def _normals(soup: Floats) -> Floats:
    normal = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
    length = np.linalg.norm(normal, axis=1)
    return normal / np.where(length > 0, length, 1.0)[:, None]


def _indices(soup: Floats, size: float) -> Ints:
    """Corner numbers of the triangles, equal where corners coincide, shape (n, 3)."""
    keys = np.round(soup.reshape(-1, 3) / (1e-7 * size)).astype(np.int64)
    return np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1, 3)


def _distinct(points: Floats, size: float) -> Floats:
    keys = np.round(points / (1e-7 * size)).astype(np.int64)
    return points[np.unique(keys, axis=0, return_index=True)[1]]


def _deepest_reflex_edge(soup: Floats, shallow: float, size: float) -> tuple[Floats, Floats, Floats, Floats] | None:
    """Return the reflex edge that is deepest: its ends and the normals of its triangles; None if all are shallow.

    Cut faces are left open: they bound the piece from outside, so their edges are never reflex.
    """
    corner, normal = _indices(soup, size), _normals(soup)
    owner: dict[tuple[int, int], tuple[int, int]] = {}
    for t, triangle in enumerate(corner.tolist()):
        for k in range(3):
            owner[triangle[k], triangle[(k + 1) % 3]] = (t, k)
    best, deepest = None, shallow
    for (a, b), (t, k) in owner.items():
        other = owner.get((b, a))
        if other is None or a > b:
            continue
        s, j = other
        start, end = soup[t, k], soup[t, (k + 1) % 3]
        over = min(normal[t] @ (soup[s, (j + 2) % 3] - start), normal[s] @ (soup[t, (k + 2) % 3] - start))
        if over > deepest:
            best, deepest = (start, end, normal[t], normal[s]), over
    return best


def _best_cut(soup: Floats, start: Floats, end: Floats, one: Floats, two: Floats, near: float) -> list[Floats]:
    """Both sides of the plane through an edge (bisecting, or along either face) that cuts fewest triangles."""
    along = (end - start) / np.linalg.norm(end - start)
    planes = [np.cross(along, one + two), one, two]
    planes = [plane / np.linalg.norm(plane) for plane in planes if np.linalg.norm(plane) > 1e-9]
    heights = [np.einsum("nkj,j->nk", soup - start, plane) for plane in planes]
    cuts = [int(((h > near).any(axis=1) & (h < -near).any(axis=1)).sum()) for h in heights]
    height = heights[int(np.argmin(cuts))]
    height = np.where(np.abs(height) <= near, 0.0, height)
    return [part_above(soup, height), part_above(soup, -height)]


def _connected(soup: Floats, size: float) -> list[Floats]:
    """Return the soup's parts that share no corner."""
    if not len(soup):
        return []
    corner = _indices(soup, size)
    n = int(corner.max()) + 1
    _, label = connected_components(n, np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]]]))
    owner = label[corner[:, 0]]
    return [soup[owner == part] for part in np.unique(owner)]
