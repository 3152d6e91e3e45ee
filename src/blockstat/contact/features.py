"""Where edges and corners touch: edge on face, corner on face, edge across edge, each clipped exactly.

A point touches a face when its foot lies inside the outline, or on a side where the block goes on in the same plane or
into a notch. On a side that is a convex edge it is on the rim, where there is no unique normal. At a corner between two
notches the block may end below the face all the same: a corner of a block that is beside the face is past it there, and
one that is above the face is on its rim.

A mesh may leave a face in pieces, as it must round a hole. The rim of the face is what the convex edges of all pieces
make: the sides between pieces are no edges of the block, so the boundary of the union is in the others. At a corner of
the hole a piece may have two sides that are joins, and yet the block does not go on all round. So a point inside a
piece touches the face only if it is on no convex edge of any piece in the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np

from blockstat.contact.faces import (
    INSIDE,
    OUTSIDE,
    RIM,
    frames,
    nearest_rim,
    planar,
    position,
    spans,
    surface_heights,
    wedges,
)
from blockstat.contact.tolerance import FLATNESS, ROUNDING
from blockstat.geometry.broad_phase import row_pairs
from blockstat.geometry.polyhedron import Polyhedra, members
from blockstat.geometry.topology import Topology, least_lean, over_faces
from blockstat.surface.facets import FLAT
from blockstat.typing import Floats, Ints

#: What touches is outside the other block when its directions lean into it by less than this sine.
LEAN = 1e-4
#: Rows (feature of one block, feature of the other) that are held in memory at once.
CHUNK = 500_000
COLUMNS = ("row", "normal", "ends", "gap", "rim", "own", "other")


class ContactKind(IntEnum):
    """What touches what at a contact."""

    FACE = 0  #: face on face: the corners of a patch, three or more points
    EDGE = 1  #: edge on face: the ends of a segment, two points, no area
    CORNER = 2  #: corner on face: one point, no area
    CROSSING = 3  #: edge across edge: one point, no area, normal to both edges


@dataclass(frozen=True, eq=False)
class Features:
    """Contacts of edges or corners, one a row."""

    row: Ints  #: number of the pair of blocks, shape (n,)
    normal: Floats  #: from the first block of the pair to the second, shape (n, 3)
    ends: Floats  #: the points, halfway across the gap, shape (n, 2, 3) [m]; a single point twice
    gap: Floats  #: shape (n,) [m]
    rim: np.ndarray  #: shape (n,), True where the contact has no unique normal
    own: Ints  #: the edge, or ~ the corner, that touches, numbered as in `Topology`, shape (n,)
    other: Ints  #: the edge, or ~ the corner, of the other block where it is on a rim, shape (n,)

    def take(self, rows: Ints | np.ndarray) -> Features:
        """Return some of the contacts.

        Parameters
        ----------
        rows : array of int or bool
            Which.

        Returns
        -------
        Features
            These contacts, in the order asked for.
        """
        return Features(*(getattr(self, column)[rows] for column in COLUMNS))

    def shifted(self, first: int) -> Features:
        """Return the contacts with the numbers of their pairs counted from another one.

        Parameters
        ----------
        first : int
            Number of the first pair.

        Returns
        -------
        Features
            The same contacts.
        """
        return replace(self, row=self.row + first)


def together(parts: Sequence[Features]) -> Features:
    """Return contacts one after the other.

    Parameters
    ----------
    parts : sequence of Features
        At least one.

    Returns
    -------
    Features
        All of them.
    """
    return Features(*(np.concatenate([getattr(part, column) for part in parts]) for column in COLUMNS))


@dataclass(frozen=True, eq=False)
class Search:
    """Pairs of blocks whose edges and corners are looked at."""

    assembly: Polyhedra
    topology: Topology
    pairs: Ints  #: shape (n_pairs, 2)
    reach: Floats  #: largest gap or overlap of each pair, shape (n_pairs,) [m]
    rounding: Floats  #: what is nearer to a rim than this is on it, shape (n_pairs,) [m]
    beyond: Floats  #: what is outside an outline, but no further than this, is on its rim, shape (n_pairs,) [m]
    rims: bool  #: whether contacts on rims are wanted too
    #: lower and upper corners of boxes in which contacts of each pair are wanted, shape (n_pairs, 3) [m]; None for all
    within: tuple[Floats, Floats] | None = None

    def limits(self, row: int) -> tuple[float, float]:
        """Return the reach and the rounding of one pair.

        Parameters
        ----------
        row : int
            Number of the pair.

        Returns
        -------
        tuple of float
            Both [m].
        """
        return float(self.reach[row]), float(self.rounding[row])

    def chunks(self) -> list[Search]:
        """Return the search in parts that fit into memory.

        Returns
        -------
        list of Search
            Parts with consecutive pairs.
        """
        edges = np.diff(self.topology.edge_start)[self.pairs]
        faces = np.diff(np.searchsorted(self.assembly.face_block, np.arange(self.assembly.n_blocks + 1)))[self.pairs]
        work = np.cumsum((edges * np.maximum(faces, edges)[:, ::-1]).max(axis=1, initial=0))
        if not len(work):
            return []
        parts = np.split(np.arange(len(work)), np.searchsorted(work, np.arange(CHUNK, work[-1], CHUNK)))
        return [self._take(rows) for rows in parts if len(rows)]

    def _take(self, rows: Ints) -> Search:
        within = None if self.within is None else (self.within[0][rows], self.within[1][rows])
        reach, rounding, beyond = self.reach[rows], self.rounding[rows], self.beyond[rows]
        return replace(self, pairs=self.pairs[rows], reach=reach, rounding=rounding, beyond=beyond, within=within)


def on_faces(search: Search, side: int, steepest: float) -> tuple[Features, Features]:
    """Find edges and corners of one block of each pair that rest on faces of the other.

    Parameters
    ----------
    search : Search
        The pairs.
    side : int
        Which block of each pair has the faces, 0 or 1.
    steepest : float
        Largest sine of the angle between an edge and the face that it rests on.

    Returns
    -------
    edges, corners : Features
        The contacts.
    """
    assembly, topo = search.assembly, search.topology
    start = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
    faces = start, *assembly.face_bounds
    one, two = assembly.vertices[topo.edge[:, 0]], assembly.vertices[topo.edge[:, 1]]
    spot = assembly.vertices[topo.corner]
    edges = _meeting(search, side, faces, (topo.edge_start, np.minimum(one, two), np.maximum(one, two)))
    lines = _edges_on(search, side, *edges, steepest)
    return lines, _corners_on(search, side, *_meeting(search, side, faces, (topo.corner_start, spot, spot)))


def crossings(search: Search) -> Features:
    """Find edges of the two blocks of each pair that cross, each between its ends.

    Parameters
    ----------
    search : Search
        The pairs.

    Returns
    -------
    Features
        The contacts, with normals at right angles to both edges.
    """
    assembly, topo = search.assembly, search.topology
    ends = assembly.vertices[topo.edge]
    edges = topo.edge_start, ends.min(axis=1), ends.max(axis=1)
    row, one, two = _meeting(search, 0, edges, edges)
    a, b = ends[one, 1] - ends[one, 0], ends[two, 1] - ends[two, 0]
    across = np.cross(a, b)
    square = np.einsum("ij,ij->i", across, across)
    length = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)
    # Edges that do not part by more than rounding over their length are parallel.
    skew = np.sqrt(square) > 2 * search.rounding[row] * np.maximum(*length)
    row, one, two, a, b, across, square = (x[skew] for x in (row, one, two, a, b, across, square))
    offset = ends[two, 0] - ends[one, 0]
    share = np.einsum("ij,ij->i", np.cross(offset, b), across) / square
    other = np.einsum("ij,ij->i", np.cross(offset, a), across) / square
    normal = across / np.sqrt(square)[:, None]
    height = np.einsum("ij,ij->i", offset, normal)
    good = np.abs(height) <= search.reach[row]
    for at, line in ((share, a), (other, b)):
        # Like a patch it must be no more open than it is wide, here its distance from the ends.
        margin = np.maximum(search.rounding[row], np.abs(height)) / np.linalg.norm(line, axis=1)
        good &= (at > margin) & (at < 1 - margin)
    lean_a = np.einsum("ikj,ij->ik", topo.inward[one], normal)
    lean_b = np.einsum("ikj,ij->ik", topo.inward[two], normal)
    upward = (lean_a.max(axis=1, initial=-1) <= LEAN) & (lean_b.min(axis=1, initial=1) >= -LEAN)
    downward = (lean_a.min(axis=1, initial=1) >= -LEAN) & (lean_b.max(axis=1, initial=-1) <= LEAN)
    good &= upward | downward
    sign = np.where(upward, 1.0, -1.0)[good, None]
    row, one, two = row[good], one[good], two[good]
    place = ends[one, 0] + share[good, None] * a[good] + height[good, None] / 2 * normal[good]
    none = np.zeros(len(row), dtype=bool)
    return Features(row, sign * normal[good], np.stack([place, place], axis=1), np.abs(height[good]), none, one, two)


def _meeting(
    search: Search, side: int, own: tuple[Ints, Floats, Floats], others: tuple[Ints, Floats, Floats]
) -> tuple[Ints, Ints, Ints]:
    """For each pair those features of a block and of the other whose boxes come near each other.

    own, others : where the features of each block begin, and their boxes
    """
    near = [_near(search, side, *own), _near(search, 1 - side, *others)]
    boxes = [(low[item], high[item]) for (_, item), (_, low, high) in zip(near, (own, others), strict=True)]
    (row, one), (other_row, two) = near
    a, b = row_pairs(row, boxes[0], other_row, boxes[1], search.reach)
    return row[a], one[a], two[b]


def _near(search: Search, side: int, start: Ints, low: Floats, high: Floats) -> tuple[Ints, Ints]:
    """For each pair those features of one of its blocks whose box comes near that of the other block, and is within."""
    own, other = search.pairs[:, side], search.pairs[:, 1 - side]
    row, item = members(start[own], np.diff(start)[own])
    lower, upper = (bound[other] for bound in search.assembly.bounds)
    if search.within is not None:
        lower, upper = np.maximum(lower, search.within[0]), np.minimum(upper, search.within[1])
    slack = search.reach[row][:, None]
    near = (low[item] <= upper[row] + slack).all(axis=1)
    near &= (high[item] >= lower[row] - slack).all(axis=1)
    return row[near], item[near]


def _edges_on(search: Search, side: int, row: Ints, face: Ints, edge: Ints, steepest: float) -> Features:
    """Edges on faces: the parts of each edge inside the outline of the face, and those along its rim."""
    assembly, topo = search.assembly, search.topology
    normal, centre = assembly.planes.normal, assembly.planes.centre
    ends = assembly.vertices[topo.edge[edge]] - centre[face][:, None]
    height = np.einsum("ikj,ij->ik", ends, normal[face])
    reach = search.reach[row]
    low, high = np.minimum(height[:, 0], height[:, 1]), np.maximum(height[:, 0], height[:, 1])
    near = (low <= reach) & (high >= -reach)
    row, face, edge, ends, height = row[near], face[near], edge[near], ends[near], height[near]
    pieces = row, face, edge
    toward = np.einsum("ikj,ij->ik", topo.inward[edge], normal[face])
    lean = np.minimum(toward[:, 0], toward[:, 1])
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    level = np.abs(height[:, 1] - height[:, 0]) <= steepest * length
    level &= search.rims | (lean >= -LEAN)
    row, face, edge, ends, height, lean = row[level], face[level], edge[level], ends[level], height[level], lean[level]
    frame = frames(normal[face])
    flat = np.einsum("ikj,itj->ikt", ends, frame[:, 1:])
    none = np.empty(0, dtype=np.int64)
    parts: list[tuple[Any, ...]] = [(none, np.empty(0), np.empty(0), none, none, np.empty(0))]
    for own, polygon, sides in _outlines(search, face, frame):
        which, begin, finish, state = spans(
            flat[own], polygon, sides >= 0, search.rounding[row[own]], search.beyond[row[own]]
        )
        middle = flat[own[which], 0] + ((begin + finish) / 2)[:, None] * (flat[own[which], 1] - flat[own[which], 0])
        parts.append((own[which], begin, finish, state, *nearest_rim(middle, polygon[which], sides[which])))
    which, begin, finish, state, other, inset = (np.concatenate(column) for column in zip(*parts, strict=True))
    share = np.stack([begin, finish], axis=1)
    heights = height[which, :1] + share * (height[which, 1:] - height[which, :1])
    points = ends[which, :1] + share[..., None] * (ends[which, 1:] - ends[which, :1]) + centre[face[which]][:, None]
    gap = np.abs(heights).max(axis=1, initial=0.0)
    on_rim = state == RIM
    good = _touches(search, row[which], gap, inset, on_rim) & (on_rim | (lean[which] >= -LEAN))
    good &= _at_surface(search, row[which], face[which], points)
    asked = np.flatnonzero(good & ~on_rim)
    own = np.repeat(which[asked], 3)
    places = np.concatenate([points[asked], points[asked].mean(axis=1, keepdims=True)], axis=1).reshape(-1, 3)
    clear = _from_rims(search, pieces, (row[own], face[own], edge[own]), places).reshape(-1, 3)
    # The end of an edge may well be on a rim, which it crosses there.
    good[asked] = (clear[:, 2] > search.rounding[row[which[asked]]]) & (gap[asked] <= clear.max(axis=1))
    which, other, on_rim = which[good], other[good], on_rim[good]
    points, heights, gap = points[good], heights[good], gap[good]
    out = normal[face[which]]
    points = points - heights[..., None] / 2 * out[:, None]
    sign = 1.0 if side == 0 else -1.0
    return Features(row[which], sign * out, points, gap, on_rim, edge[which], other)


def _corners_on(search: Search, side: int, row: Ints, face: Ints, corner: Ints) -> Features:
    """Corners on faces and on their rims."""
    assembly, topo = search.assembly, search.topology
    normal, centre = assembly.planes.normal, assembly.planes.centre
    offset = assembly.vertices[topo.corner[corner]] - centre[face]
    height = np.einsum("ij,ij->i", offset, normal[face])
    near = np.abs(height) <= search.reach[row]
    row, face, corner, offset, height = row[near], face[near], corner[near], offset[near], height[near]
    pieces = row, face, corner
    lean = least_lean(topo, corner, normal[face])
    wanted = search.rims | (lean >= -LEAN)
    row, face, corner, offset = row[wanted], face[wanted], corner[wanted], offset[wanted]
    height, lean = height[wanted], lean[wanted]
    frame = frames(normal[face])
    flat = np.einsum("ij,itj->it", offset, frame[:, 1:])
    state, other = np.zeros(len(row), dtype=np.int8), np.zeros(len(row), dtype=np.int64)
    inset, wedge, met = np.zeros(len(row)), np.zeros((len(row), 2)), np.full(len(row), -1)
    for own, polygon, sides in _outlines(search, face, frame):
        rounding, beyond = search.rounding[row[own]], search.beyond[row[own]]
        state[own] = position(flat[own][:, None], polygon, sides >= 0, rounding, beyond)[:, 0]
        distance = np.linalg.norm(polygon - flat[own][:, None], axis=2)
        at = assembly.face_start[face[own]] + distance.argmin(axis=1)
        meets = np.searchsorted(topo.corner, topo.vertex[assembly.face_vertices[at]])
        meets = np.minimum(meets, len(topo.corner) - 1)
        at_corner = distance.min(axis=1) <= beyond
        at_corner &= topo.corner[meets] == topo.vertex[assembly.face_vertices[at]]
        wedge[own[at_corner]] = wedges(polygon[at_corner], distance[at_corner].argmin(axis=1))
        met[own[at_corner]] = meets[at_corner]
        side_below, inset[own] = nearest_rim(flat[own], polygon, sides)
        other[own] = np.where(at_corner, ~meets, side_below)
    passed = np.flatnonzero((state == INSIDE) & (met >= 0))
    passed = passed[least_lean(topo, met[passed], normal[face[passed]]) < -LEAN]
    above = over_faces(topo, corner[passed], frame[passed], wedge[passed], LEAN)
    state[passed] = np.where(above, RIM, OUTSIDE)
    good = (state == RIM) | ((state == INSIDE) & (lean >= -LEAN))
    good &= _touches(search, row, np.abs(height), inset, state == RIM)
    good &= _at_surface(search, row, face, (offset + centre[face])[:, None])
    asked = np.flatnonzero(good & (state == INSIDE))
    own = row[asked], face[asked], corner[asked]
    clear = _from_rims(search, pieces, own, assembly.vertices[topo.corner[corner[asked]]])
    good[asked] = (clear > search.rounding[row[asked]]) & (np.abs(height[asked]) <= clear)
    row, face, corner, height, other = row[good], face[good], corner[good], height[good], other[good]
    out = normal[face]
    place = assembly.vertices[topo.corner[corner]] - height[:, None] / 2 * out
    sign = 1.0 if side == 0 else -1.0
    ends = np.stack([place, place], axis=1)
    return Features(row, sign * out, ends, np.abs(height), state[good] == RIM, ~corner, other)


def _from_rims(
    search: Search, pieces: tuple[Ints, Ints, Ints], asked: tuple[Ints, Ints, Ints], points: Floats
) -> Floats:
    """How far points in pieces of faces are from the rims of the whole faces, inf where no rim is near.

    pieces : pair, face and feature of all that come near each other
    asked : those of them to which the points belong, a point each
    """
    clear = np.full(len(points), np.inf)
    if not len(points):
        return clear
    wanted = np.zeros(pieces[2].max() + 1, dtype=bool)
    wanted[asked[2]] = True
    row, face, item = (column[wanted[pieces[2]]] for column in pieces)
    order = np.argsort(key := row * len(wanted) + item, kind="stable")
    own = asked[0] * len(wanted) + asked[2]
    first, last = np.searchsorted(key[order], own, "left"), np.searchsorted(key[order], own, "right")
    point, place = members(first, last - first)
    row, piece = row[order[place]], face[order[place]]
    normal, centre = search.assembly.planes.normal[asked[1]], search.assembly.planes.centre
    foot = points - np.einsum("ij,ij->i", points - centre[asked[1]], normal)[:, None] * normal
    whole = _in_one_plane(search, row, asked[1][point], piece, foot[point])
    point, piece = point[whole], piece[whole]
    frame = frames(search.assembly.planes.normal[piece])
    flat = np.einsum("ij,itj->it", foot[point] - centre[piece], frame[:, 1:])
    for part, polygon, sides in _outlines(search, piece, frame):
        np.minimum.at(clear, point[part], nearest_rim(flat[part], polygon, sides)[1])
    return clear


def _in_one_plane(search: Search, row: Ints, one: Ints, other: Ints, foot: Floats) -> np.ndarray:
    """Whether two faces of a block are pieces of one, seen from points in the plane of the first.

    The second must pass the point, and turn from the first along its own length, by no more than a face may leave its
    plane (`blockstat.contact.faces.flatness`). An edge that is as flat as `FLAT` is none, whatever its length.
    """
    assembly = search.assembly
    lower, upper = assembly.bounds
    rounded = ROUNDING * float((upper.max(axis=0) - lower.min(axis=0)).max())
    # A rim is as wide as the reach where the gap is a length, and as rounding otherwise.
    uneven = np.minimum(FLATNESS * search.reach, np.maximum(rounded, FLATNESS * search.beyond))
    uneven = np.maximum(uneven, search.rounding)[row]
    normal = assembly.planes.normal
    height = np.abs(np.einsum("ij,ij->i", foot - assembly.planes.centre[other], normal[other]))
    turn = np.linalg.norm(np.cross(normal[one], normal[other]), axis=1)
    length = np.linalg.norm(assembly.face_bounds[1][other] - assembly.face_bounds[0][other], axis=1)
    alike = np.einsum("ij,ij->i", normal[one], normal[other]) > 0
    return alike & (height <= uneven) & (turn * length <= np.maximum(uneven, FLAT * length))


def _at_surface(search: Search, row: Ints, face: Ints, points: Floats) -> np.ndarray:
    """Whether points near the planes of faces are near their surfaces too, which leave the planes of warped ones."""
    near = np.ones(len(row), dtype=bool)
    if len(warped := np.flatnonzero(search.assembly.planes.warp[face] > FLATNESS * search.reach[row])):
        normal = search.assembly.planes.normal[face[warped]]
        height = surface_heights(search.assembly, face[warped], normal, points[warped])
        near[warped] = np.abs(height).max(axis=1) <= search.reach[row[warped]]
    return near


def _outlines(search: Search, face: Ints, frame: Floats) -> list[tuple[Ints, Floats, np.ndarray]]:
    """Outlines of faces in their planes, in batches of like corner counts, with the convex edge of each side or -1."""
    assembly = search.assembly
    count = np.diff(assembly.face_start)[face]
    batches = []
    for width in np.unique(2 ** np.ceil(np.log2(count)).astype(int)) if len(face) else []:
        own = np.flatnonzero((count <= width) & (count > width // 2))
        k = int(count[own].max())
        polygon = planar(assembly, face[own], frame[own], assembly.planes.centre[face[own]], k)
        index = assembly.face_start[face[own]][:, None] + np.arange(k)
        real = np.arange(k) < count[own][:, None]
        sides = np.where(real, search.topology.side[np.where(real, index, 0)], -1)
        # A row that is too short repeats its last corner, so that its last side closes the polygon.
        sides[:, -1:] = np.take_along_axis(sides, (count[own] - 1)[:, None], axis=1)
        batches.append((own, polygon, sides))
    return batches


def _touches(search: Search, row: Ints, gap: Floats, inset: Floats, on_rim: np.ndarray) -> np.ndarray:
    """Whether a contact closes: like a patch it is no more open than wide, here than its distance from the rim."""
    return gap <= np.where(on_rim, search.beyond[row], np.minimum(search.reach[row], inset))
