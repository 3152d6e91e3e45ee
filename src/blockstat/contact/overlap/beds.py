"""Beds that overlap: contacts that are nothing but the overlap, and those that sink with the bed.

Both are told by moving the two blocks of a pair apart by the overlap.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.coplanar import Patches, merge_coplanar
from blockstat.contact.features import CHUNK, ContactKind, Features, Search, together
from blockstat.contact.known_contacts import ONE_PATCH, Contacts, Tolerances, covered, features_of, inside, search_of
from blockstat.geometry.broad_phase import row_pairs
from blockstat.geometry.polyhedron import Polyhedra, members
from blockstat.surface.distance import segment_distances
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Vertices of copies of pairs that are held in memory at once.
COPIED = 50_000


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
    item, cover, up = _of_one_block(assembly, parts.pair, parts.boxes(), deep, tolerances.rounding)
    if not len(item):
        return keys
    corner = parts.in_space()
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
    keys[low] = overlap_at_rims(search, features, deep, tolerances)
    return keys


def _longest(points: Floats) -> Floats:
    """The two of some points that are furthest apart."""
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    return points[list(np.unravel_index(distance.argmax(), distance.shape))]


def _of_one_block(
    assembly: Polyhedra, pairs: Ints, boxes: tuple[Floats, Floats], patches: Patches, rounding: float
) -> tuple[Ints, Ints, Floats]:
    """Each pair beside each near patch of one of its blocks: their numbers, and the way out of it of the second block.

    boxes : what is asked of each pair lies in them
    """
    # What lies in a patch is no deeper than this below it, and beside it by no more than this and rounding.
    depth = np.zeros(assembly.n_blocks)
    for other in (0, 1):
        np.maximum.at(depth, patches.pair[:, other], patches.overlap + patches.gap)
    reach = 2 * (depth + rounding * assembly.size)
    lower, upper = patches.boxes()
    found: list[tuple[Ints, Ints, Floats]] = []
    for side in (0, 1):
        for other in (0, 1):
            one, two = (np.argsort(of[:, k], kind="stable") for of, k in ((pairs, side), (patches.pair, other)))
            box_a, box_b = (boxes[0][one], boxes[1][one]), (lower[two], upper[two])
            item, cover = row_pairs(pairs[one, side], box_a, patches.pair[two, other], box_b, reach)
            item, cover = one[item], two[cover]
            found.append((item, cover, (1.0 if side == other else -1.0) * patches.frame[cover, 0]))
    item, cover, up = (np.concatenate(column) for column in zip(*found, strict=True))
    return item, cover, up


def overlap_at_rims(search: Search, features: Features, patches: Patches, tolerances: Tolerances) -> np.ndarray:
    """Say which features across a patch are nothing but the overlap of its blocks, seen at its rim.

    Parameters
    ----------
    search : Search
        The pairs.
    features : Features
        Contacts of edges or corners, shape (n,), whose rows are numbers of these pairs.
    patches : Patches
        Patches of all blocks.
    tolerances : Tolerances
        What counts as touching.

    Returns
    -------
    array of bool, shape (n,)
        True for those that are gone when the blocks are moved apart by the overlap.

    Notes
    -----
    Where two faces that overlap end at a rim, one of them reaches past that rim by as much, and its edge touches the
    side of the other block, or of a third one behind it. With the blocks moved apart by the overlap, straight or along
    that side, such a contact is gone. That of a step, or of a wall at whose foot the joint is, stays.
    """
    lost = np.zeros(len(features.row), dtype=bool)
    boxes = features.ends.min(axis=1), features.ends.max(axis=1)
    item, cover, up = _of_one_block(search.assembly, search.pairs[features.row], boxes, patches, tolerances.rounding)
    alike = np.einsum("ij,ij->i", up, features.normal[item])
    across = (np.abs(alike) < ONE_PATCH) & (patches.overlap[cover] > search.rounding[features.row[item]])
    item, cover, up, alike = item[across], cover[across], up[across], alike[across]
    # What is gone then is no further from the plane than the overlap, and the plane from the faces than their gap.
    near = inside(search, features.take(item), patches, cover, patches.overlap[cover] + patches.gap[cover])
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


def with_sunk(search: Search, known: Contacts, patches: Patches, tolerances: Tolerances) -> Contacts:
    """Add the edges and corners that touch a wall at its foot when a bed that overlaps is moved apart by the overlap.

    As drawn they lie below that foot, where the wall ends.

    Parameters
    ----------
    search : Search
        The pairs.
    known : Contacts
        Their contacts, with the beds.
    patches : Patches
        Patches of all blocks.
    tolerances : Tolerances
        What counts as touching, as drawn and when moved apart.

    Returns
    -------
    Contacts
        The contacts, with those edges and corners; each lies in its bed, in the middle of the overlap.
    """
    deep = np.flatnonzero(known.kind == ContactKind.FACE)
    deep = deep[known.patches.overlap[deep] > search.rounding[known.row[deep]]]
    deep = deep[_beside_walls(search, known.row[deep], known.patches.take(deep))]
    rows, beds = known.row[deep], known.patches.take(deep)
    if not len(rows):
        return known
    most = np.zeros(len(search.pairs))
    np.maximum.at(most, rows, beds.overlap)
    wide = replace(search, rounding=search.rounding + most)
    work = np.cumsum(np.diff(search.assembly.vertex_start)[search.pairs[rows]].sum(axis=1))
    parts = np.split(np.arange(len(rows)), np.searchsorted(work, np.arange(COPIED, work[-1], COPIED)))
    found = [_sunk(search, rows[own], beds.take(own), tolerances) for own in parts if len(own)]
    for kind, of_parts in zip((ContactKind.EDGE, ContactKind.CORNER), zip(*found, strict=True), strict=True):
        new = together(of_parts)
        new = new.take(~covered(wide, new, known, ONE_PATCH))
        known = known.with_more(kind, new.take(~overlap_at_rims(search, new, patches, tolerances)), search.pairs)
    return known


def _sunk(search: Search, rows: Ints, beds: Patches, tolerances: Tolerances) -> list[Features]:
    """Edges and corners in beds, of pairs with these rows, that touch walls when the two blocks are moved apart."""
    apart = beds.overlap[:, None] * beds.frame[:, 0]
    margin = 2 * (beds.overlap + search.reach[rows] + search.rounding[rows])[:, None]
    lower, upper = beds.boxes()
    moved = replace(_moved(search, rows, apart, tolerances), within=(lower - margin, upper + margin))
    sunk = []
    for found in features_of(moved, tolerances.steepest)[:2]:
        bed = found.row
        nearer = np.abs(np.einsum("ij,ij->i", found.normal, apart[bed]))
        good = ~found.rim & (nearer < ONE_PATCH * beds.overlap[bed]) & (found.gap + nearer <= search.reach[rows[bed]])
        found, bed = replace(found, row=rows[bed]).take(good), bed[good]
        found = replace(found, ends=found.ends - apart[bed, None] / 2)
        # In the plane of the bed, and over it but for half of the gap to the wall.
        height = np.einsum("nkj,nj->nk", found.ends - beds.origin[bed][:, None], beds.frame[bed, 0])
        level = np.abs(height).max(axis=1, initial=0.0) <= beds.overlap[bed] + 2 * search.rounding[rows[bed]]
        sunk.append(found.take(level & inside(search, found, beds, bed, beds.overlap[bed] + found.gap / 2)))
    return sunk


def _beside_walls(search: Search, row: Ints, beds: Patches) -> np.ndarray:
    """Whether a face of the lower block of a bed may rise beside it by more than the overlap, or one of the upper sink.

    Judged by bounding boxes, so it keeps some beds that have no wall.
    """
    walls = np.zeros(len(row), dtype=bool)
    start = np.searchsorted(search.assembly.face_block, np.arange(search.assembly.n_blocks + 1))
    lower, upper = search.assembly.face_bounds
    low, high = beds.boxes()
    for side, sign in ((0, 1.0), (1, -1.0)):
        block = search.pairs[row, side]
        count = np.diff(start)[block]
        for part in np.split(np.arange(len(row)), np.flatnonzero(np.diff(np.cumsum(count) // CHUNK)) + 1):
            if not len(part):
                continue
            own, face = members(start[block[part]], count[part])
            own = part[own]
            near = (search.reach[row] + beds.overlap)[own, None]
            good = ((lower[face] <= high[own] + near) & (upper[face] >= low[own] - near)).all(axis=1)
            own, face = own[good], face[good]
            rise = sign * beds.frame[own, 0]
            across = np.abs(np.einsum("ij,ij->i", search.assembly.planes.normal[face], rise)) < ONE_PATCH
            top = np.where(rise > 0, rise * upper[face], rise * lower[face]).sum(axis=1)
            top -= np.einsum("ij,ij->i", rise, beds.origin[own])
            walls[own[across & (top > beds.overlap[own] + search.rounding[row[own]])]] = True
    return walls


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
