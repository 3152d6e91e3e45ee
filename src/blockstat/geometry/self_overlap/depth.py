"""How deep the surface of a block passes through itself: the largest ball that it encloses twice, or inside out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.geometry.convex_pieces import solid_angles, winding_balls
from blockstat.geometry.convexity import protrusions
from blockstat.geometry.polyhedron import Polyhedra, members
from blockstat.geometry.self_overlap.meeting import Surface, meeting_pairs, surface_of
from blockstat.geometry.triangulation import fans
from blockstat.typing import Floats, Ints

#: What a block may overlap itself by, relative to its size: as much as two blocks may at a joint, `GAP` of
#: `blockstat.contact.tolerance`, which stands above this room. A point counted wrongly is then no further from the
#: surface than half the depth, and such a layer on one side of the surface has a volume of at most half the depth times
#: the surface, or little more where that is concave. So the volume of a cube is wrong by 3 percent at most.
ALLOWED = 1e-2
#: And at most this share of the mean thickness, volume over half the surface: `THIN` of `blockstat.contact.tolerance`.
SHARE = 0.25
#: What is no further apart than this fraction of the diagonal of a block meets: rounding.
ON = 1e-9
#: Faces times corners of a block up to which it is tested for convexity. Chosen: 40 MB.
MOST = 5_000_000
#: Corners of a convex piece may lie outside its faces by this share of the depth allowed: the ball in it is measured
#: against the whole surface, so this only says how well its centre lies.
FINE = 0.1
#: Cosine up to which faces look another way. Chosen: 60 degrees, far from all rounding.
ALIKE = 0.5
#: Convex pieces into which a box is cut at most before it is halved: the work grows faster than their number.
PIECES = 500
#: Pieces of a box whose balls are measured, the largest first. Chosen: the deepest is seldom further down.
TRIED = 50
#: Triangles in a box up to which it is cut as a whole, and boxes that are cut at once. Chosen for speed.
MANY, TOGETHER = 150, 8
#: Ways in which a ball is moved, and opposite; and the step, relative to the depth, at which that ends.
WAYS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]]) / np.sqrt(
    [[1], [1], [1], [3], [3], [3], [3]]
)
CLOSE = 0.01
TINY = 1e-300  #: keeps zero from being divided by


@dataclass(frozen=True)
class SelfOverlap:
    """Where a block overlaps itself most."""

    block: int
    depth: float  #: diameter of the largest ball [m]
    centre: Floats  #: of that ball, shape (3,) [m]
    times: int  #: how often the surface encloses it: 2 or more, or less than 0 where it is inside out


def self_overlaps(blocks: Polyhedra, merged: Ints, tested: Ints) -> list[SelfOverlap]:
    """Find blocks whose surface encloses some of their stone more than once, or inside out.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    merged : array of int, shape (n_vertices,)
        As `merged_vertices` gives it.
    tested : array of int, shape (n,)
        Numbers of the blocks to look at, which are closed and have a positive volume.

    Returns
    -------
    list of SelfOverlap
        Those deeper than a hundredth of the size of the block, or a quarter of its mean thickness if that is less.

    Notes
    -----
    A surface encloses a point as often as its winding number says, the solid angle over 4 pi. Of stone it is 1, and 0
    outside of it and in cavities. The volume and centroid count each point that often, so they are right where there
    is no other number. Regions with another number are cut into convex pieces, and the depth is the largest diameter of
    the balls about the centres of the pieces that the surface leaves free. For two convex solids this is the largest
    ball in both, by which overlaps of blocks are measured.

    A block behind all planes of its faces whose surface encloses its centroid once has no other number: all faces lie
    on the surface of its hull, and the core of the hull is of one number. With corners that lie in front of planes by
    a, and in faces off their planes by w, a ball with another number has a diameter of 2 (a + w) at most, since the
    ball is in the hull, and its centre not in the core.

    Where triangles do not meet beside what they share, the number changes by 1 from one side of the surface to the
    other and nowhere else, so one point of each connected part tells both numbers. Only the boxes around the other
    triangles, and around parts with a wrong number, are cut into convex pieces. Of a surface whose triangles are too
    crowded to be compared (`CROWDED`) one point of each connected part is looked at all the same.
    """
    limit = _allowed(blocks)
    left = tested[~_once_around(blocks, limit)[tested]]
    if not len(left):
        return []
    chosen = blocks.copied(left)
    start = np.searchsorted(blocks.vertex_block, left)
    own = members(blocks.vertex_start[left], np.diff(blocks.vertex_start)[left])[1]
    moved = np.repeat(start - chosen.vertex_start[:-1], np.diff(chosen.vertex_start))
    lower, upper = chosen.bounds
    middle = (lower + upper) / 2
    surface = surface_of(chosen, merged[own] - moved, middle)
    on = ON * np.linalg.norm(upper - lower, axis=1) + 4 * np.spacing(np.abs(chosen.vertices).max())
    pairs = meeting_pairs(surface, len(left), on)
    wrong = _doubtful(surface, pairs, len(left))
    boxes = [
        (block, *box)
        for block in np.unique(surface.block[wrong]).tolist()
        for box in _boxes(surface, block, wrong, pairs, float(limit[left[block]]))
    ]
    deepest = _deepest(surface, boxes, limit[left])
    return [replace(own, block=int(left[k]), centre=own.centre + middle[k]) for k, own in sorted(deepest.items())]


def _allowed(blocks: Polyhedra) -> Floats:
    """Depth up to which an overlap does not count, shape (n_blocks,) [m]."""
    surface = np.bincount(blocks.face_block, blocks.planes.area, blocks.n_blocks)
    return np.minimum(ALLOWED * np.abs(blocks.size), SHARE * 2 * np.abs(blocks.volume) / surface)


def _once_around(blocks: Polyhedra, limit: Floats) -> np.ndarray:
    """Which blocks are convex but for the limit, and enclosed by their surface once."""
    first = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    small = np.diff(first) * np.diff(blocks.vertex_start) <= MOST
    out = np.zeros(blocks.n_blocks, dtype=bool)
    own = np.flatnonzero(small)
    some = blocks if small.all() else blocks.copied(own)
    if not some.n_blocks:
        return out
    begin = np.searchsorted(some.face_block, np.arange(some.n_blocks))
    reach = np.maximum.reduceat(protrusions(some) + some.planes.warp, begin)
    convex = 2 * reach <= limit[own]
    # Where no other face looks the way of the first one, that face alone bounds the hull there, and with up to four
    # corners it does not go round twice.
    sure = convex & (reach <= ON * some.size) & (some.planes.area[begin] > 0) & (np.diff(some.face_start)[begin] <= 4)
    normal = some.planes.normal
    alike = np.einsum("ij,ij->i", normal, normal[begin][some.face_block]) > ALIKE
    out[own] = sure & (np.add.reduceat(alike, begin, dtype=int) == 1)
    left = np.flatnonzero(convex & ~out[own])
    if len(left):
        rest = some.copied(left)
        corner_block = np.repeat(rest.face_block, np.diff(rest.face_start))
        place = rest.vertices[rest.face_vertices] - rest.centroid[corner_block]
        angle = np.bincount(corner_block, solid_angles(fans(place, rest.face_start)), rest.n_blocks)
        out[own[left]] = np.abs(angle / (4 * np.pi) - 1) < 0.5
    return out


def _doubtful(surface: Surface, pairs: Ints, n_blocks: int) -> Ints:
    """Triangles that meet others, and those of parts of the surface that do not bound stone with what is no stone."""
    n = len(surface.vertex)
    meets = np.zeros(n, dtype=bool)
    meets[pairs.reshape(-1)] = True
    area = np.linalg.norm(_double_areas(surface.corner), axis=1)
    ends = np.sort(np.stack([surface.vertex, surface.vertex[:, [1, 2, 0]]], axis=2), axis=2).reshape(-1, 2)
    key = ends[:, 0] * (surface.vertex.max() + 1) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    _, first, count = np.unique(key[order], return_index=True, return_counts=True)
    edge = np.column_stack([order[first[count == 2]], order[first[count == 2] + 1]]) // 3
    part = connected_components(n, edge[~meets[edge].any(axis=1)])[1]
    # The largest triangle of each part stands for it.
    rows = np.flatnonzero(~meets)
    rows = rows[np.lexsort((-area[rows], part[rows]))]
    probe = rows[np.flatnonzero(np.diff(part[rows], prepend=-1))] if len(rows) else rows
    good = np.zeros(n, dtype=bool)
    start = np.searchsorted(surface.block, np.arange(n_blocks + 1))
    for row in probe.tolist():
        block = surface.block[row]
        own = np.arange(int(start[block]), int(start[block + 1]))
        own = own[own != row]
        # Half of the number behind and in front of the triangle, which differ by one.
        angle = solid_angles(surface.corner[own] - surface.corner[row].mean(axis=0)).sum()
        good[part[row]] = abs(angle / (4 * np.pi) - 0.5) < 0.1
    return np.flatnonzero(meets | ~good[part])


def _boxes(surface: Surface, block: int, wrong: Ints, pairs: Ints, limit: float) -> list[tuple[Floats, Floats]]:
    """Boxes around the groups of connected triangles of a block that are thicker than a limit."""
    own = wrong[surface.block[wrong] == block]
    vertex, number = np.unique(surface.vertex[own], return_inverse=True)
    node = np.column_stack([np.repeat(np.arange(len(own)), 3), len(own) + number.reshape(-1)])
    met = np.searchsorted(own, pairs[surface.block[pairs[:, 0]] == block])
    group = connected_components(len(own) + len(vertex), np.concatenate([node, met]))[1][: len(own)]
    found = []
    for one in np.unique(group).tolist():
        corner = surface.corner[own[group == one]]
        double = _double_areas(corner)
        area = np.linalg.norm(double, axis=1)
        across = corner.reshape(-1, 3) @ (double[area.argmax()] / max(float(area.max()), TINY))
        low, high = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
        if min(float(np.ptp(across)), float((high - low).min())) > limit:
            found.append((low, high))
    return found


def _deepest(surface: Surface, boxes: list[tuple[int, Floats, Floats]], limit: Floats) -> dict[int, SelfOverlap]:
    """The deepest place of each block that is deeper than its limit, of the boxes tried until one has such a place.

    A box with many triangles or pieces is cut in halves.
    """
    best: dict[int, SelfOverlap] = {}
    start = np.searchsorted(surface.block, np.arange(len(limit) + 1))
    low, high = surface.corner.min(axis=1), surface.corner.max(axis=1)
    left, ready = boxes[::-1], []
    while left or ready:
        while left and len(ready) < TOGETHER:
            block, lower, upper = left.pop()
            own = slice(start[block], start[block + 1])
            many = int(((low[own] <= upper) & (high[own] >= lower)).all(axis=1).sum()) > MANY
            halves = _halves((block, lower, upper), limit) if many else []
            if block not in best:
                left += halves
                ready += [] if halves else [(block, lower, upper)]
        again = np.zeros(len(ready), dtype=bool)
        solids = [surface.corner[start[block] : start[block + 1]] for block, _, _ in ready]
        for k, found in _wrong_balls(ready, solids, limit):
            block = ready[k][0]
            again[k] |= found is None
            if found is not None and (block not in best or found.depth > best[block].depth):
                best[block] = found
        left += [half for k in np.flatnonzero(again) for half in _halves(ready[k], limit)]
        ready = []
    return {k: _climbed(surface.corner[start[k] : start[k + 1]], own) for k, own in best.items()}


def _wrong_balls(
    boxes: list[tuple[int, Floats, Floats]], solids: list[Floats], limit: Floats
) -> Iterator[tuple[int, SelfOverlap | None]]:
    """Balls that are enclosed wrongly and larger than the limit, with their boxes; None for a box with many pieces."""
    if not boxes:
        return
    block = [box[0] for box in boxes]
    lower, upper = np.array([box[1] for box in boxes]), np.array([box[2] for box in boxes])
    for sign in (1, -1):
        # What is enclosed inside out is enclosed by the turned surface.
        seen = [own[:, ::sign] for own in solids]
        for k, found in enumerate(winding_balls(seen, lower, upper, FINE * limit[block], most=PIECES)):
            if found is None:
                yield k, None
                continue
            times, depth, centre = found
            own = np.flatnonzero((sign * times < 0) | (sign * times > 1))
            for piece in own[np.argsort(-depth[own])][:TRIED].tolist():
                clear = 2 * _distance(solids[k], centre[piece])
                if clear > limit[block[k]]:
                    yield k, SelfOverlap(block[k], clear, centre[piece], sign * int(times[piece]))


def _climbed(triangles: Floats, found: SelfOverlap) -> SelfOverlap:
    """The ball moved within its region to where it may be larger."""
    ways = np.concatenate([WAYS, -WAYS])
    depth, centre, step = found.depth, found.centre, found.depth / 4
    while step > CLOSE * depth:
        # A step shorter than the radius does not leave the region.
        reached = [2 * _distance(triangles, centre + step * way) for way in ways]
        k = int(np.argmax(reached))
        if reached[k] > depth * (1 + CLOSE / 10):
            depth, centre = reached[k], centre + step * ways[k]
        else:
            step /= 2
    return replace(found, depth=depth, centre=centre)


def _halves(box: tuple[int, Floats, Floats], limit: Floats) -> list[tuple[int, Floats, Floats]]:
    """A box cut across its longest side; none where the halves are no wider than the limit."""
    block, lower, upper = box
    axis = int((upper - lower).argmax())
    if upper[axis] - lower[axis] <= 2 * limit[block]:
        return []
    below, above = upper.copy(), lower.copy()
    below[axis] = above[axis] = (lower[axis] + upper[axis]) / 2
    return [(block, lower, below), (block, above, upper)]


def _distance(triangles: Floats, point: Floats) -> float:
    """Distance of a point from the nearest of some triangles."""
    local = triangles - point
    edge = local[:, [1, 2, 0]] - local
    along = -(local * edge).sum(axis=2) / np.maximum((edge**2).sum(axis=2), TINY)
    nearest = float(np.linalg.norm(local + np.clip(along, 0, 1)[..., None] * edge, axis=2).min())
    double = _double_areas(local)
    area = np.linalg.norm(double, axis=1)
    side = np.einsum("nkj,nj->nk", np.cross(local, edge), double)
    above = np.flatnonzero((side > 0).all(axis=1) & (area > 0))
    height = np.abs(np.einsum("ij,ij->i", local[above, 0], double[above])) / area[above]
    return min(nearest, float(height.min(initial=np.inf)))


def _double_areas(triangles: Floats) -> Floats:
    """Twice the area of each triangle times its normal."""
    areas: Floats = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return areas
