"""Contacts of edges and corners beside the patches: which pairs can have them, and what a patch does not cover.

Two convex blocks on the two sides of the plane of their patch meet nowhere but in it. So edges and corners are looked
for in pairs without a patch, and in pairs of which a block is not convex or reaches through that plane.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.coplanar import Patch, Patches, in_one_plane, joined, merge_coplanar
from blockstat.contact.faces import frames
from blockstat.contact.features import INSIDE, ContactKind, Features, Search, crossings, on_faces, position, together
from blockstat.geometry.convexity import protrusions, separations
from blockstat.geometry.polyhedron import Polyhedra, members
from blockstat.geometry.topology import edge_topology
from blockstat.surface.distance import segment_distances
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A vertex may lie outside a face of a convex block by this fraction of its size: rounding of coordinates.
CONVEX = 1e-6
#: The plane of a patch is that of both faces when the patch is no more open than rounding and no narrower than this,
#: both relative to the smaller block: then both blocks lie on their sides of it to a thousandth.
PLAIN = 1e-3
#: Cosine of the normals of a patch and of an edge in it: faces nearer to opposed than this may be one joint.
ONE_PATCH = float(np.cos(np.deg2rad(15.0)))


@dataclass(frozen=True)
class Tolerances:
    """What counts as touching."""

    allowed: Floats  #: gap of a joint of each block, shape (n_blocks,) [m]
    rounding: float  #: lengths below this, relative to the smaller block, are nothing
    steepest: float  #: largest sine of the angle between a contact and a face that counts as lying on it
    blurred: bool = False  #: whether a rim is as wide as the gap: the geometry is no more exact than that


def edge_contacts(
    assembly: Assembly, patches: Patches, near: Ints, tolerances: Tolerances
) -> tuple[Patches, Ints | None, Ints, list[Patch]]:
    """Add the contacts of edges and corners to the patches of an assembly.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    patches : Patches
        Its patches, one a plane and pair.
    near : array of int, shape (n, 2)
        Pairs among which to look.
    tolerances : Tolerances
        What counts as touching.

    Returns
    -------
    patches : Patches
        All contacts, sorted by pair; those of edges have two points, those of corners one.
    kind : array of int or None
        Values of `ContactKind`, None where there are patches only.
    rims : array of int, shape (k, 2)
        Pairs that may also touch where there is no unique normal.
    absorbed : list of Patch
        The edges and corners that have become part of a patch in their plane.
    """
    pairs, rims = _candidates(assembly, patches, near, tolerances)
    if not len(pairs):
        return patches, None, rims, []
    search = search_of(assembly, pairs, tolerances, rims=False)
    row, own = _rows_of(pairs, patches.pair, assembly.n_blocks)
    known = Contacts(row, np.zeros(len(row), np.int64), patches.take(own))
    kinds = ContactKind.EDGE, ContactKind.CORNER, ContactKind.CROSSING
    for kind, found in zip(kinds, features_of(search, tolerances.steepest), strict=True):
        free = found.take(~found.rim)
        free = free.take(~covered(search, free, known, ONE_PATCH))
        known = known.with_more(kind, free.take(~_overlaps_at_rims(search, free, patches, tolerances)), pairs)
    known = _with_sunk(search, known, patches, tolerances)
    if len(known.row) == len(row):
        return patches, None, rims, []
    rest = np.setdiff1d(np.arange(len(patches.pair)), own)
    merged, absorbed = _merged(search, known)
    both = patches.take(rest).with_more([patch for _, patch in merged])
    kind = np.concatenate([np.zeros(len(rest), np.int64), np.array([kind for kind, _ in merged], np.int64)])
    order = np.lexsort((kind, both.pair[:, 1], both.pair[:, 0]))
    return both.take(order), kind[order], rims, absorbed


def search_of(assembly: Polyhedra, pairs: Ints, tolerances: Tolerances, *, rims: bool) -> Search:
    """Return a search for the edges and corners of some pairs.

    Parameters
    ----------
    assembly : Polyhedra
        The blocks.
    pairs : array of int, shape (n, 2)
        The pairs.
    tolerances : Tolerances
        What counts as touching.
    rims : bool
        Whether contacts on rims are wanted too.

    Returns
    -------
    Search
        The pairs with the edges of their blocks.
    """
    reach = tolerances.allowed[pairs].min(axis=1)
    rounding = tolerances.rounding * assembly.size[pairs].min(axis=1)
    beyond = reach if tolerances.blurred else rounding
    topology = edge_topology(assembly, np.unique(pairs))
    return Search(assembly, topology, pairs, reach, rounding, beyond, rims)


def _candidates(assembly: Assembly, patches: Patches, near: Ints, tolerances: Tolerances) -> tuple[Ints, Ints]:
    """Pairs that may have contacts of edges or corners, and those that may touch where there is no unique normal."""
    near, reach, rounding, beside = _boxes_meet(assembly, near, tolerances, patches)
    supporting = protrusions(assembly) <= CONVEX * assembly.size[assembly.face_block]
    first_face = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks))
    convex = np.logical_and.reduceat(supporting, first_face)
    both = convex[near[:, 0]] & convex[near[:, 1]]
    # Each patch has its pair among the sorted ones.
    place = np.searchsorted(near @ [assembly.n_blocks, 1], patches.pair @ [assembly.n_blocks, 1])
    plain = (patches.gap <= rounding[place]) & (patches.area >= PLAIN * assembly.size[patches.pair].min(axis=1) ** 2)
    patched, exact = np.zeros((2, len(near)), dtype=bool)
    patched[place], exact[place[plain]] = True, True

    apart, no_normal = both & exact, beside & ~patched
    bare = np.flatnonzero(~patched & ~no_normal)
    if len(bare):
        first, second = separations(assembly, near[bare], supporting)
        apart[bare[first > reach[bare]]] = True
        no_normal[bare[second >= -rounding[bare]]] = True
    if len(rows := np.flatnonzero(both[place] & ~apart[place])):
        pair = place[rows]
        apart[pair[_divides(assembly, patches.take(rows), reach[pair])]] = True
    if len(rows := np.flatnonzero(~both[place] & plain)):
        pair = place[rows]
        no_normal[pair[_flush(assembly, patches.take(rows), reach[pair], rounding[pair])]] = True
    return near[~apart & ~no_normal], near[~apart]


def _boxes_meet(
    assembly: Assembly, near: Ints, tolerances: Tolerances, patches: Patches
) -> tuple[Ints, Floats, Floats, np.ndarray]:
    """The pairs whose boxes meet, their reach and rounding, and whether the boxes share no more than a line.

    Pairs with a patch stay: the plane of a face that is not quite flat may leave the box of its block.
    """
    a, b = near.T
    reach = np.minimum(tolerances.allowed[a], tolerances.allowed[b])
    rounding = tolerances.rounding * np.minimum(assembly.size[a], assembly.size[b])
    close, level = np.ones(len(near), dtype=bool), np.zeros(len(near), dtype=np.int64)
    for lower, upper in zip(*(bound.T for bound in assembly.bounds), strict=True):
        gap = np.maximum(lower[a] - upper[b], lower[b] - upper[a])
        close &= gap <= reach + rounding
        level += gap >= -rounding
    close |= np.isin(near @ [assembly.n_blocks, 1], patches.pair @ [assembly.n_blocks, 1])
    return near[close], reach[close], rounding[close], level[close] >= 2


def _divides(assembly: Assembly, patches: Patches, reach: Floats) -> np.ndarray:
    """Whether the plane of each patch has its two blocks on its two sides."""
    beside = np.ones(len(reach), dtype=bool)
    for side, sign in ((0, 1.0), (1, -1.0)):
        block = patches.pair[:, side]
        row, vertex = members(assembly.vertex_start[block], np.diff(assembly.vertex_start)[block])
        beside[row[sign * _heights(assembly, patches, row, vertex) > reach[row]]] = False
    return beside


def _flush(assembly: Assembly, patches: Patches, reach: Floats, rounding: Floats) -> np.ndarray:
    """Whether two blocks meet on the plane of a patch with whole faces only.

    All of each block lies on its side, and all of its corners near the plane belong to faces in the plane. Then the
    blocks meet where these faces overlap, which are patches, and where their outlines touch.
    """
    flush = np.ones(len(reach), dtype=bool)
    first_face = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
    n_vertices, n_faces, n_corners = (np.diff(x) for x in (assembly.vertex_start, first_face, assembly.face_start))
    for side, sign in ((0, 1.0), (1, -1.0)):
        block = patches.pair[:, side]
        row, face = members(first_face[block], n_faces[block])
        count = n_corners[face]
        owner, slot = members(assembly.face_start[face], count)
        row, vertex = row[owner], assembly.face_vertices[slot]
        height = sign * _heights(assembly, patches, row, vertex)
        level = np.logical_and.reduceat(np.abs(height) <= rounding[row], np.cumsum(count) - count)
        number = vertex + (np.cumsum(n_vertices[block]) - n_vertices[block] - assembly.vertex_start[block])[row]
        covered = np.zeros(n_vertices[block].sum(), dtype=bool)
        covered[number[level[owner]]] = True
        flush[row[(height > rounding[row]) | ((height >= -reach[row]) & ~covered[number])]] = False
    return flush


def _heights(assembly: Assembly, patches: Patches, row: Ints, vertex: Ints) -> Floats:
    """Heights of vertices over the planes of patches [m]."""
    return np.einsum("ij,ij->i", assembly.vertices[vertex] - patches.origin[row], patches.frame[row, 0])


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts of the pairs of a search, one a row."""

    row: Ints  #: number of the pair
    kind: Ints
    patches: Patches

    def with_more(self, kind: ContactKind, features: Features, pairs: Ints) -> Contacts:
        """Return these contacts and then some of edges or corners.

        Parameters
        ----------
        kind : ContactKind
            Of all the others: `EDGE`, `CORNER` or `CROSSING`.
        features : Features
            The others; none of them gives these contacts as they are.
        pairs : array of int, shape (n_pairs, 2)
            Pairs of the search, by which the rows of the features are numbered.

        Returns
        -------
        Contacts
            The others are patches without area about the middle of their ends: of two corners for an edge, of one
            otherwise.
        """
        n = len(features.row)
        if not n:
            return self
        frame, origin = frames(features.normal), features.ends.mean(axis=1)
        flat = np.einsum("nkj,ntj->nkt", features.ends - origin[:, None], frame[:, 1:])
        points = 2 if kind == ContactKind.EDGE else 1
        new = Patches(
            pairs[features.row], frame, origin, np.zeros(n), features.gap, flat[:, :points].reshape(-1, 2),
            np.full(n, points), np.zeros(n),
        )  # fmt: skip
        both: list[Any] = [np.concatenate(x) for x in zip(self.patches.columns(), new.columns(), strict=True)]
        kinds = np.concatenate([self.kind, np.full(n, kind, np.int64)])
        return Contacts(np.concatenate([self.row, features.row]), kinds, Patches(*both))


def _rows_of(pairs: Ints, other: Ints, n_blocks: int) -> tuple[Ints, Ints]:
    """Which of some other pairs are among the sorted pairs: their numbers there, and their own."""
    key, wanted = pairs @ [n_blocks, 1], other @ [n_blocks, 1]
    place = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    own = np.flatnonzero(key[place] == wanted)
    return place[own], own


def features_of(search: Search, steepest: float) -> list[Features]:
    """Find the contacts of edges and corners of all pairs of a search.

    Parameters
    ----------
    search : Search
        The pairs; with its `rims` contacts on rims are found too, but no edges across edges, which are never on one.
    steepest : float
        Largest sine of the angle between an edge and the face that it rests on.

    Returns
    -------
    list of Features
        Edges on faces, corners on faces and, unless rims are wanted, edges across edges; rows are numbers of pairs.
    """
    found: list[list[Features]] = [[], []] if search.rims else [[], [], []]
    first = 0
    for part in search.chunks():
        for side in (0, 1):
            for kind, features in zip(found, on_faces(part, side, steepest), strict=False):
                kind.append(features.shifted(first))
        if not search.rims:
            found[2].append(crossings(part).shifted(first))
        first += len(part.pairs)
    return [together(kind) for kind in found]


def covered(search: Search, features: Features, known: Contacts, least: float) -> np.ndarray:
    """Return which features lie whole in one known contact of their pair.

    Parameters
    ----------
    search : Search
        The pairs, with the reach and the rounding of each.
    features : Features
        Contacts of edges or corners, shape (n,).
    known : Contacts
        The contacts that are known; rows of both are numbers of the pairs of the search.
    least : float
        Least cosine between the normals of a feature and of the contact that it lies in; -inf for any.

    Returns
    -------
    array of bool, shape (n,)
        True where both ends are no further from the plane of the contact than the reach of the pair, and in its polygon
        or beside it by no more than twice the rounding and what the angle between the normals makes of the reach.
    """
    found = np.zeros(len(features.row), dtype=bool)
    item, cover, alike = _of_one_pair(features, known)
    alike_enough = alike >= least
    item, cover = item[alike_enough], cover[alike_enough]
    found[item[_inside(search, features.take(item), known.patches, cover, search.reach[features.row[item]])]] = True
    return found


def _of_one_pair(features: Features, known: Contacts) -> tuple[Ints, Ints, Floats]:
    """Each feature beside each known contact of its pair: their numbers, and the cosine between their normals."""
    order = np.argsort(known.row, kind="stable")
    rows = known.row[order]
    first, last = np.searchsorted(rows, features.row, "left"), np.searchsorted(rows, features.row, "right")
    item, place = members(first, last - first)
    cover = order[place]
    return item, cover, np.einsum("ij,ij->i", known.patches.frame[cover, 0], features.normal[item])


def _inside(search: Search, features: Features, patches: Patches, cover: Ints, depth: Floats) -> np.ndarray:
    """Whether each feature lies in its patch, with both ends no further from the plane of the patch than a depth."""
    inside = np.zeros(len(cover), dtype=bool)
    local = np.einsum("nkj,ntj->nkt", features.ends - patches.origin[cover][:, None], patches.frame[cover])
    near = np.flatnonzero(np.abs(local[..., 0]).max(axis=1, initial=0.0) <= depth)
    if not len(near):
        return inside
    local, cover, depth, features = local[near], cover[near], depth[near], features.take(near)
    # Seen along another normal, a point off the plane lies beside its place by as much as the normals differ.
    alike = np.einsum("ij,ij->i", patches.frame[cover, 0], features.normal)
    aside = 2 * search.rounding[features.row] + depth * np.sqrt(np.clip(1 - alike**2, 0.0, 1.0))
    first = (np.cumsum(patches.count) - patches.count)[cover]
    width = int(patches.count[cover].max())
    column = np.minimum(np.arange(width), patches.count[cover][:, None] - 1)
    polygon = patches.corner[first[:, None] + column]
    no_rim = np.zeros(polygon.shape[:2], dtype=bool)
    within = position(local[..., 1:], polygon, no_rim, aside) == INSIDE
    at_corner = np.linalg.norm(local[..., None, 1:] - polygon[:, None], axis=3).min(axis=2) <= aside[:, None]
    inside[near] = (within | at_corner).all(axis=1)
    return inside


def keys_of_overlap(assembly: Assembly, parts: Patches, tolerances: Tolerances) -> np.ndarray:
    """Say which patches are nothing but the overlap of other patches, seen at their rims.

    A block that sinks into one of two others whose tops are level meets the side of the other no higher than it sinks.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    parts : Patches
        All patches that are joints.
    tolerances : Tolerances
        What counts as touching.

    Returns
    -------
    array of bool, shape (n_parts,)
        True for a patch across one that overlaps, no higher than that overlap, and gone when the blocks are moved apart
        by it.
    """
    keys = np.zeros(len(parts.pair), dtype=bool)
    rounding = tolerances.rounding * assembly.size[parts.pair].min(axis=1)
    if not (parts.overlap > rounding).any():
        return keys
    joints = merge_coplanar(parts, tolerances.allowed)
    deep = joints.take(np.flatnonzero(joints.overlap > tolerances.rounding * assembly.size[joints.pair].min(axis=1)))
    item, cover, up = _of_one_block(parts.pair, deep)
    if not len(item):
        return keys
    corner = np.repeat(parts.origin, parts.count, axis=0)
    corner = corner + np.einsum("nk,nkj->nj", parts.corner, np.repeat(parts.frame[:, 1:], parts.count, axis=0))
    start = np.cumsum(parts.count) - parts.count
    row, own = members(start[item], parts.count[item])
    height = np.einsum("ij,ij->i", corner[own], up[row])
    first = np.cumsum(parts.count[item]) - parts.count[item]
    extent = np.maximum.reduceat(height, first) - np.minimum.reduceat(height, first)
    low = np.unique(item[extent <= deep.overlap[cover] + 2 * rounding[item]])
    if not len(low):
        return keys
    ends = np.array([_longest(corner[start[i] : start[i] + parts.count[i]]) for i in low])
    none = np.zeros(len(low), dtype=np.int64)
    features = Features(np.arange(len(low)), parts.frame[low, 0], ends, parts.gap[low], none > 0, none, none)
    search = search_of(assembly, parts.pair[low], tolerances, rims=False)
    keys[low] = _overlaps_at_rims(search, features, deep, tolerances)
    return keys


def _longest(points: Floats) -> Floats:
    """The two of some points that are furthest apart."""
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    return points[list(np.unravel_index(distance.argmax(), distance.shape))]


def _of_one_block(pairs: Ints, patches: Patches) -> tuple[Ints, Ints, Floats]:
    """Each pair beside each patch of one of its blocks: their numbers, and the way out of it of the second block."""
    found: list[tuple[Ints, Ints, Floats]] = []
    for side in (0, 1):
        for other in (0, 1):
            order = np.argsort(patches.pair[:, other], kind="stable")
            blocks = patches.pair[order, other]
            first, last = (np.searchsorted(blocks, pairs[:, side], end) for end in ("left", "right"))
            item, place = members(first, last - first)
            cover = order[place]
            found.append((item, cover, (1.0 if side == other else -1.0) * patches.frame[cover, 0]))
    item, cover, up = (np.concatenate(column) for column in zip(*found, strict=True))
    return item, cover, up


def _overlaps_at_rims(search: Search, features: Features, patches: Patches, tolerances: Tolerances) -> np.ndarray:
    """Which features across a patch are nothing but the overlap of its blocks, seen at its rim.

    Where two faces that overlap end at a rim, one of them reaches past that rim by as much, and its edge touches the
    side of the other block, or of a third one behind it. With the blocks moved apart by the overlap, straight or along
    that side, such a contact is gone. That of a step, or of a wall at whose foot the joint is, stays.
    """
    lost = np.zeros(len(features.row), dtype=bool)
    item, cover, up = _of_one_block(search.pairs[features.row], patches)
    alike = np.einsum("ij,ij->i", up, features.normal[item])
    across = (np.abs(alike) < ONE_PATCH) & (patches.overlap[cover] > search.rounding[features.row[item]])
    item, cover, up, alike = item[across], cover[across], up[across], alike[across]
    # What is gone then is no further from the plane than the overlap, and the plane from the faces than their gap.
    near = _inside(search, features.take(item), patches, cover, patches.overlap[cover] + patches.gap[cover])
    item, cover, up, alike = item[near], cover[near], up[near], alike[near]
    if not len(item):
        return lost
    row, normal = features.row[item], features.normal[item]
    least = patches.overlap[cover] + 2 * search.rounding[row]
    along = (up - alike[:, None] * normal) / (1 - alike**2)[:, None]
    own = features.take(item)
    stays = [_stays(search, own, least[:, None] * way, tolerances) for way in (up, along)]
    lost[item[~(stays[0] | stays[1])]] = True
    return lost


def _with_sunk(search: Search, known: Contacts, patches: Patches, tolerances: Tolerances) -> Contacts:
    """The contacts with those that are there when a bed that overlaps is moved apart by the overlap, and only then.

    An edge at the foot of a wall sinks below that foot with its bed, and a wall ends at its foot.
    """
    faces = known.kind == ContactKind.FACE
    deep = faces & (known.patches.overlap > search.rounding[known.row])
    rows, beds = known.row[deep], known.patches.take(np.flatnonzero(deep))
    if not len(rows):
        return known
    apart = beds.overlap[:, None] * beds.frame[:, 0]
    wide = replace(search, rounding=search.rounding + np.bincount(rows, beds.overlap, len(search.pairs)))
    kinds = ContactKind.EDGE, ContactKind.CORNER, ContactKind.CROSSING
    for kind, found in zip(
        kinds, features_of(_moved(search, rows, apart, tolerances), tolerances.steepest), strict=True
    ):
        bed = found.row
        across = np.abs(np.einsum("ij,ij->i", found.normal, beds.frame[bed, 0])) < ONE_PATCH
        found, bed = replace(found, row=rows[bed]), bed[across & ~found.rim]
        found = found.take(across & ~found.rim)
        new = ~covered(wide, found, known, ONE_PATCH)
        found = found.take(new)
        found = replace(found, ends=found.ends - apart[bed[new], None] / 2)  # in the middle of the overlap, as the bed
        known = known.with_more(kind, found.take(~_overlaps_at_rims(search, found, patches, tolerances)), search.pairs)
    return known


def _moved(search: Search, row: Ints, apart: Floats, tolerances: Tolerances) -> Search:
    """A search in copies of some pairs, of which the second block is moved; its pairs have the order of the rows."""
    pairs = search.pairs[row]
    copies = search.assembly.copied(pairs.reshape(-1))
    shift = np.stack([np.zeros_like(apart), apart], axis=1).reshape(-1, 3)
    copies = replace(copies, vertices=copies.vertices + shift[copies.vertex_block])
    allowed = replace(tolerances, allowed=tolerances.allowed[pairs].reshape(-1))
    return search_of(copies, np.arange(2 * len(row)).reshape(-1, 2), allowed, rims=False)


def _stays(search: Search, features: Features, apart: Floats, tolerances: Tolerances) -> np.ndarray:
    """Whether each feature is still there when the second block of its pair is moved."""
    n = len(features.row)
    again = _moved(search, features.row, apart, tolerances)
    # Edges steeper than those that may lie in the bed meet no further from where they met.
    reach = np.linalg.norm(apart, axis=1) / np.sqrt(1 - ONE_PATCH**2) + 2 * again.rounding
    stays = np.zeros(n, dtype=bool)
    for found in features_of(again, tolerances.steepest):
        row = found.row
        same = np.einsum("ij,ij->i", found.normal, features.normal[row]) >= ONE_PATCH
        same &= (segment_distances(features.ends[row], found.ends) <= reach[row]) & ~found.rim
        stays[row[same]] = True
    return stays


def _merged(search: Search, known: Contacts) -> tuple[list[tuple[int, Patch]], list[Patch]]:
    """The contacts, those of one plane and one line in one, and the ones that are now part of a patch."""
    absorbed: list[Patch] = []
    rows: defaultdict[int, list[tuple[int, Patch]]] = defaultdict(list)
    order = np.lexsort((known.kind, known.row))
    kinds = known.kind[order].tolist()
    for row, kind, patch in zip(known.row[order].tolist(), kinds, known.patches.take(order), strict=True):
        own = rows[row]
        into = None if kind == ContactKind.FACE else _absorbed(own, kind, patch, *search.limits(row))
        if into is None:
            own.append((kind, patch))
        elif into == ContactKind.FACE:
            absorbed.append(patch)
    return [item for row in sorted(rows) for item in rows[row]], absorbed


def _absorbed(own: list[tuple[int, Patch]], kind: int, new: Patch, reach: float, rounding: float) -> int | None:
    """The kind of the contact before it that a contact has become part of, or None."""
    if not own:
        return None
    normals, origins = np.array([p.frame[0] for _, p in own]), np.array([p.origin for _, p in own])
    # Whether the new one lies in the plane of each.
    gaps = np.array([p.gap for _, p in own])
    level = in_one_plane(new.frame[0], new.origin, new.gap, normals, origins, gaps, reach)
    for k in np.flatnonzero(level).tolist():
        other, patch = own[k]
        if other == ContactKind.FACE:
            own[k] = other, joined(patch, [patch, new])
            return other
        line = _line(patch, new, rounding)
        if line is not None and (ContactKind.EDGE in (other, kind) or np.ptp(line.polygon, axis=0).max() == 0):
            own[k] = min(other, kind), line
            return int(min(other, kind))
    return None


def _line(one: Patch, two: Patch, rounding: float) -> Patch | None:
    """The segment from end to end of two contacts, or None when they do not lie in a line."""
    points = np.concatenate([one.polygon, (two.origin + two.polygon @ two.frame[1:] - one.origin) @ one.frame[1:].T])
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    i, j = np.unravel_index(distance.argmax(), distance.shape)
    gap = max(one.gap, two.gap)
    if distance[i, j] <= 2 * rounding:
        return one._replace(polygon=one.polygon[:1], gap=gap)
    along = (points[j] - points[i]) / distance[i, j]
    aside = (points - points[i]) @ [-along[1], along[0]]
    return one._replace(polygon=points[[i, j]], gap=gap) if np.abs(aside).max() <= 2 * rounding else None
