"""Faces as the search for contacts sees them: neighbouring faces of a block in one plane are one face.

A mesh divides a plane face into triangles, and a traced or scanned stone has faces that are flat only nearly. The edges
between such pieces are no edges of the stone: nothing rests on them.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from heapq import heapify, heappop, heappush
from typing import TypeVar

import numpy as np

from blockstat.geometry.polyhedron import Polyhedra, members, next_in_face
from blockstat.typing import Floats, Ints

Solid = TypeVar("Solid", bound=Polyhedra)

#: Relative to its size, what a block's surface may move to be simpler: rounding of coordinates. A contact that is
#: narrower than this counts as an edge.
ROUNDING = 1e-6
#: An edge whose faces turn by less (sine of the angle) is judged by the distances of their corners; a longer row of
#: such edges than 1 / FLAT is a curve.
FLAT = 1e-3
#: A line turns at a corner if the sine of the angle is larger.
STRAIGHT = 1e-6
#: A face leans by at most this to the plane of its region. Faces of two blocks that are further than 15 degrees from
#: opposed are never one joint (`blockstat.contact.interfaces.ANGLE`); half of it is left to each.
LEAN = np.deg2rad(7.5)


def facets(solid: Solid, *, tolerance: Floats | None = None) -> Solid:
    """Merge neighbouring faces of a block that lie in one plane.

    Parameters
    ----------
    solid : Polyhedra
        The blocks.
    tolerance : array of float, shape (n_blocks,), optional
        Faces are one if their corners lie between two parallel planes no further apart than this [m]. By default, and
        at least, a millionth of the size of the block, which is rounding.

    Returns
    -------
    Polyhedra
        The blocks with merged faces, of the type of `solid`, or `solid` itself if there was nothing to merge. Vertices
        keep their numbers. Those inside a merged face, or on a straight edge between two, belong to no face.

    Notes
    -----
    Beyond rounding, the two neighbours that fit a plane best are merged first, as in hierarchical face clustering, as
    long as their corners fit between the two planes and none of the merged faces leans to the common plane by more than
    `LEAN`. Which faces become one does not depend on the other blocks.

    A merged face is one closed outline. Faces that surround a hole stay as they are: their patches lie in one plane,
    and become one joint later.

    References
    ----------
    Attene, Falcidieno & Spagnuolo: Hierarchical mesh segmentation based on fitting primitives, 2006.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> cube = box((0, 0, 0), (1, 1, 1))
    >>> halves = [[f[i] for i in half] for f in cube.faces for half in ((0, 1, 2), (0, 2, 3))]
    >>> cut = Assembly.from_blocks([type(cube)(cube.vertices, halves)], supports=[0])
    >>> len(cut.face_block), len(facets(cut).face_block)
    (12, 6)
    """
    if not len(solid.face_block):
        return solid
    rounding = ROUNDING * solid.size
    tail = solid.face_vertices
    head = tail[next_in_face(solid.face_start)]
    face = np.repeat(np.arange(len(solid.face_block)), np.diff(solid.face_start))
    one, other = _opposite(tail, head, len(solid.vertices))
    sides = np.column_stack([face[one], face[other]])
    label = _coplanar(solid, sides, rounding)
    if tolerance is not None:
        label = _flat_regions(solid, label, sides, np.where(tolerance > rounding, tolerance, 0.0))
    if (label == np.arange(len(label))).all():
        return solid
    inner = np.zeros(len(tail), dtype=bool)
    joined = label[sides[:, 0]] == label[sides[:, 1]]
    inner[one[joined]] = inner[other[joined]] = True
    return _merged(solid, label, inner, tail, head, face)


def _opposite(tail: Ints, head: Ints, n_vertices: int) -> tuple[Ints, Ints]:
    """The two corners from which each edge goes, one in each of its two faces."""
    key = np.minimum(tail, head).astype(np.int64) * n_vertices + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    same = key[order[1:]] == key[order[:-1]]
    single = same & ~np.append(False, same[:-1]) & ~np.append(same[1:], False)
    one, other = order[:-1][single], order[1:][single]
    apart = tail[one] == head[other]
    return one[apart], other[apart]


def _coplanar(solid: Polyhedra, sides: Ints, rounding: Floats) -> Ints:
    """The lowest face of each region of faces in one plane but for rounding, shape (n_faces,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(solid.face_block)
    normal = solid.planes.normal
    turn = np.linalg.norm(np.cross(normal[sides[:, 0]], normal[sides[:, 1]]), axis=1)
    along = np.einsum("ij,ij->i", normal[sides[:, 0]], normal[sides[:, 1]])
    flat = sides[(turn < FLAT) & (along > 0)]
    lowest = np.arange(n)
    if not len(flat):
        return lowest
    _, label = connected_components(coo_array((np.ones(len(flat)), flat.T), shape=(n, n)), directed=False)
    # The plane of a region is that of its vector area; a region that does not lie in it falls apart.
    area = solid.planes.normal * solid.planes.area[:, None]
    total = np.stack([np.bincount(label, area[:, k]) for k in range(3)], axis=1)
    total /= np.maximum(np.linalg.norm(total, axis=1), 1e-300)[:, None]
    corner_label = np.repeat(label, np.diff(solid.face_start))
    origin = solid.centroid[np.repeat(solid.face_block, np.diff(solid.face_start))]
    height = np.einsum("ij,ij->i", solid.vertices[solid.face_vertices] - origin, total[corner_label])
    low, high = np.full(len(total), np.inf), np.full(len(total), -np.inf)
    np.minimum.at(low, corner_label, height)
    np.maximum.at(high, corner_label, height)
    plane = (high - low)[label] <= rounding[solid.face_block]
    _, first = np.unique(label, return_index=True)
    return np.where(plane, first[label], lowest)


@dataclass(frozen=True)
class _Region:
    """Faces of one block that are merged so far."""

    vertices: Ints  #: numbers, once each
    area: Floats  #: vector area, shape (3,) [m2]
    normals: Floats  #: unit normals of the faces that are wider than the tolerance, shape (n, 3)


def _flat_regions(solid: Polyhedra, label: Ints, sides: Ints, tolerance: Floats) -> Ints:
    """Merge regions whose corners lie between two planes as near as the tolerance of their block, zero for none.

    A face that is narrower than the tolerance may have any direction: that of a sliver is noise.
    """
    normal, allowed = solid.planes.normal[sides], tolerance[solid.face_block[sides]]
    low, high = solid.face_bounds
    narrow = solid.planes.area <= tolerance[solid.face_block] * np.linalg.norm(high - low, axis=1)
    alike = np.einsum("ij,ij->i", normal[:, 0], normal[:, 1]) >= np.cos(2 * LEAN)
    sides = sides[(alike | narrow[sides].any(axis=1)) & (allowed[:, 0] > 0)]
    ends = label[sides]
    ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1), axis=0)
    if not len(ends):
        return label
    merged = np.arange(len(label))
    block = solid.face_block[ends[:, 0]]
    begin = _may_be_one(solid, label, ends, tolerance[block])
    order = np.argsort(label, kind="stable")
    faces = order, label[order]
    by_block = np.argsort(block, kind="stable")
    ends, block, begin = ends[by_block], block[by_block], begin[by_block]
    for one in np.unique(block[begin]):
        own = slice(*np.searchsorted(block, [one, one + 1]))
        found = _Regions(solid, faces, len(label), float(tolerance[one]))
        for region, into in _cluster(found, ends[own], ends[own][begin[own]]):
            merged[region] = into
    return merged[label]


def _may_be_one(solid: Polyhedra, label: Ints, ends: Ints, tolerance: Floats) -> np.ndarray:
    """Whether the corners of each two regions lie between two planes as near as the tolerance, shape (n_ends,)."""
    area = np.zeros((len(label), 3))
    np.add.at(area, label, solid.planes.normal * solid.planes.area[:, None])
    owner = np.repeat(label, np.diff(solid.face_start))
    order = np.argsort(owner, kind="stable")
    count = np.bincount(owner, minlength=len(label))
    first = np.cumsum(count) - count
    normal = area[ends].sum(axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    low, high = np.full(len(ends), np.inf), np.full(len(ends), -np.inf)
    for side in ends.T:
        row, place = members(first[side], count[side])
        corner = solid.vertices[solid.face_vertices[order[place]]] - solid.centroid[solid.face_block[side]][row]
        height = np.einsum("ij,ij->i", corner, normal[row])
        np.minimum.at(low, row, height)
        np.maximum.at(high, row, height)
    return high - low <= tolerance


def _cluster(regions: _Regions, ends: Ints, begin: Ints) -> list[tuple[int, int]]:
    """Which regions of a block are merged into which, the lowest of each.

    ends : regions beside each other
    begin : those of which the two may be one
    """
    beside: dict[int, set[int]] = defaultdict(set)
    for a, b in ends.tolist():
        beside[a].add(b)
        beside[b].add(a)
    heap = [(regions.cost(a, b), a, b) for a, b in begin.tolist()]
    heap = [item for item in heap if item[0] >= 0]
    heapify(heap)
    gone: set[int] = set()
    into: dict[int, int] = {}
    parts: dict[int, list[int]] = {}
    while heap:
        _, a, b = heappop(heap)
        if a in gone or b in gone:
            continue
        gone |= {a, b}
        number = regions.joined(a, b)
        parts[number] = parts.pop(a, [a]) + parts.pop(b, [b])
        beside[number] = (beside.pop(a) | beside.pop(b)) - {a, b}
        for near in beside[number]:
            beside[near] = beside[near] - {a, b} | {number}
            cost = regions.cost(near, number)
            if cost >= 0:
                heappush(heap, (cost, near, number))
    for grouped in parts.values():
        into.update(dict.fromkeys(grouped, min(grouped)))
    return list(into.items())


class _Regions:
    """The regions of a block that may be merged, each made when it is asked for."""

    def __init__(self, solid: Polyhedra, faces: tuple[Ints, Ints], new: int, tolerance: float) -> None:
        """Begin with faces sorted by their region, these regions, and the number of the first that is made."""
        self._solid, self._faces, self._next, self._tolerance = solid, faces, new, tolerance
        self._known: dict[int, _Region] = {}

    def __getitem__(self, number: int) -> _Region:
        if number not in self._known:
            faces, regions = self._faces
            self._known[number] = self._made(faces[slice(*np.searchsorted(regions, [number, number + 1]))])
        return self._known[number]

    def _made(self, faces: Ints) -> _Region:
        solid = self._solid
        corners = [solid.face_vertices[solid.face_start[f] : solid.face_start[f + 1]] for f in faces]
        vertices = np.unique(np.concatenate(corners))
        area = (solid.planes.normal[faces] * solid.planes.area[faces, None]).sum(axis=0)
        size = float(np.linalg.norm(area))
        length = float(np.linalg.norm(np.ptp(solid.vertices[vertices], axis=0)))
        wide = size > self._tolerance * length
        return _Region(vertices, area, (area / size)[None] if wide else np.empty((0, 3)))

    def joined(self, a: int, b: int) -> int:
        """The number of two regions that become one."""
        one, other, number = self[a], self[b], self._next
        self._known[number] = _Region(
            np.union1d(one.vertices, other.vertices),
            one.area + other.area,
            np.concatenate([one.normals, other.normals]),
        )
        self._next += 1
        return number

    def cost(self, a: int, b: int) -> float:
        """How far apart two planes are that hold two regions between them [m]; -1 if they are not one."""
        one, other = self[a], self[b]
        area = one.area + other.area
        size = float(np.linalg.norm(area))
        if size == 0:
            return -1.0
        normal = area / size
        if min((one.normals @ normal).min(initial=1.0), (other.normals @ normal).min(initial=1.0)) < np.cos(LEAN):
            return -1.0
        height = self._solid.vertices[np.concatenate([one.vertices, other.vertices])] @ normal
        thickness = float(height.max() - height.min())
        return thickness if thickness <= self._tolerance else -1.0


def _merged(solid: Solid, label: Ints, inner: np.ndarray, tail: Ints, head: Ints, face: Ints) -> Solid:
    """Replace the faces of each region by its outline, where it has one."""
    region = label[face]
    several = np.bincount(label, minlength=len(label)) > 1
    edge = np.flatnonzero(several[region] & ~inner)
    order, place = _rings(tail[edge], head[edge], region[edge])
    whole = np.zeros(len(label), dtype=bool)  # regions with one outline, by their lowest face
    whole[np.unique(region[edge])] = True
    whole[region[edge[place < 0]]] = False
    if not whole.any():
        return solid
    kept = ~whole[region]  # corners of faces that stay as they are
    ring = edge[order[whole[region[edge[order]]]]]
    corner = np.concatenate([np.flatnonzero(kept), ring])
    owner = np.concatenate([face[kept], region[ring]])
    corner, owner = (x[np.argsort(owner, kind="stable")] for x in (corner, owner))
    vertex = tail[corner]
    count = np.unique(owner, return_counts=True)[1]
    changed = np.bincount(solid.face_block, whole, solid.n_blocks) > 0
    needed = _turns(solid, vertex, np.concatenate([[0], np.cumsum(count)]), changed[solid.face_block[owner]])
    vertex, owner = vertex[needed], owner[needed]
    number, count = np.unique(owner, return_counts=True)
    return replace(
        solid,
        face_vertices=vertex,
        face_start=np.concatenate([[0], np.cumsum(count)]),
        face_block=solid.face_block[number],
    )


def _rings(tail: Ints, head: Ints, region: Ints) -> tuple[Ints, Ints]:
    """Edges of the outlines in order, and the place of each edge in its outline, -1 where a region has no single one.

    The outline is followed by doubling: after k rounds each edge knows the edge 2**k further on.
    """
    n = len(tail)
    place = np.full(n, -1)
    if not n:
        return np.arange(0), place
    key, goal = region * (tail.max() + 1) + tail, region * (tail.max() + 1) + head
    order = np.argsort(key)
    following = order[np.minimum(np.searchsorted(key[order], goal), n - 1)]
    _, number, count = np.unique(region, return_inverse=True, return_counts=True)
    bad = np.zeros(len(count), dtype=bool)
    bad[number[key[following] != goal]] = True
    repeated = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    bad[number[order[repeated]]] = True  # an outline that meets itself in a corner
    first = np.zeros(len(count), dtype=np.int64)
    first[number[::-1]] = np.arange(n)[::-1]
    start = first[number]
    # Steps from each edge to the first of its region: cut the ring there, and sum up steps by doubling.
    end = following == start
    jump = np.where(end, np.arange(n), following)
    steps = np.where(end, 0, 1)
    for _ in range(int(np.ceil(np.log2(count.max()))) + 1):
        steps = steps + steps[jump]
        jump = jump[jump]
    reached = end[jump]
    bad[number[~reached]] = True
    bad |= np.bincount(number, reached, len(count)) < count
    place = np.where(bad[number], -1, count[number] - 1 - steps)
    order = np.lexsort((place, number))
    return order, place


def _turns(solid: Polyhedra, vertex: Ints, start: Ints, free: np.ndarray) -> np.ndarray:
    """Corners that are needed: all but those on a straight edge between two faces, of blocks that may change."""
    following = next_in_face(start)
    before = np.empty_like(following)
    before[following] = np.arange(len(following))
    ahead = solid.vertices[vertex[following]] - solid.vertices[vertex]
    behind = solid.vertices[vertex] - solid.vertices[vertex[before]]
    length = np.linalg.norm(ahead, axis=1) * np.linalg.norm(behind, axis=1)
    bend = np.linalg.norm(np.cross(behind, ahead), axis=1)
    straight = (bend <= STRAIGHT * length) & (np.einsum("ij,ij->i", behind, ahead) > 0) & free
    faces = np.bincount(vertex, minlength=len(solid.vertices))
    calm = np.bincount(vertex, straight, len(solid.vertices))
    return ~((faces == 2) & (calm == 2))[vertex]
