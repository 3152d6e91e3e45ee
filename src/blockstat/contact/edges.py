"""Contacts of edges and corners beside the patches: which pairs can have them, and what a patch does not cover.

Two convex blocks on the two sides of the plane of their patch meet nowhere but in it. So edges and corners are looked
for in pairs without a patch, and in pairs of which a block is not convex or reaches through that plane.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.coplanar import Patch, Patches, in_one_plane, joined, merge_coplanar
from blockstat.contact.features import ContactKind, Search
from blockstat.contact.known_contacts import ONE_PATCH, Contacts, Tolerances, covered, features_of, search_of
from blockstat.contact.overlap.beds import overlap_at_rims, with_sunk
from blockstat.geometry.convexity import protrusions, separations
from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A vertex may lie outside a face of a convex block by this fraction of its size: rounding of coordinates.
CONVEX = 1e-6
#: The plane of a patch is that of both faces when the patch is no more open than rounding and no narrower than this,
#: both relative to the smaller block: then both blocks lie on their sides of it to a thousandth.
PLAIN = 1e-3
#: Vertices of a block that are asked before all are.
SOME = 50


def edge_contacts(
    assembly: Assembly, patches: Patches, behind: Patches, near: Ints, tolerances: Tolerances
) -> tuple[Patches, Ints | None, Ints, list[Patch]]:
    """Add the contacts of edges and corners to the patches of an assembly.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    patches : Patches
        Its patches, one a plane and pair.
    behind : Patches
        Of faces that lie back to back: no edge or corner of the two blocks touches there.
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
    behind = merge_coplanar(behind, tolerances.allowed)
    place, of_pairs = _rows_of(pairs, behind.pair, assembly.n_blocks)
    nowhere = Contacts(place, np.zeros(len(place), np.int64), behind.take(of_pairs))
    kinds = ContactKind.EDGE, ContactKind.CORNER, ContactKind.CROSSING
    for kind, found in zip(kinds, features_of(search, tolerances.steepest), strict=True):
        free = found.take(~found.rim)
        for taken in (known, nowhere):
            free = free.take(~covered(search, free, taken, ONE_PATCH))
        known = known.with_more(kind, free.take(~overlap_at_rims(search, free, patches, tolerances)), pairs)
    known = with_sunk(search, known, patches, tolerances)
    if len(known.row) == len(row):
        return patches, None, rims, []
    rest = np.setdiff1d(np.arange(len(patches.pair)), own)
    merged, absorbed = _merged(search, known)
    both = patches.take(rest).with_more([patch for _, patch in merged])
    kind = np.concatenate([np.zeros(len(rest), np.int64), np.array([kind for kind, _ in merged], np.int64)])
    order = np.lexsort((kind, both.pair[:, 1], both.pair[:, 0]))
    return both.take(order), kind[order], rims, absorbed


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
    rows = np.flatnonzero(~both[place] & plain)
    rows = rows[~_crossed(assembly, patches.take(rows), rounding[place[rows]])]
    if len(rows):
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


def _crossed(assembly: Assembly, patches: Patches, rounding: Floats) -> np.ndarray:
    """Whether one of a few vertices of a block lies beyond the plane of a patch: of fine meshes mostly one does."""
    crossed = np.zeros(len(rounding), dtype=bool)
    for side, sign in ((0, 1.0), (1, -1.0)):
        block = patches.pair[:, side]
        n = np.diff(assembly.vertex_start)[block]
        row, place = members(np.zeros_like(n), np.minimum(n, SOME))
        vertex = assembly.vertex_start[block[row]] + place * n[row] // np.minimum(n[row], SOME)
        crossed[row[sign * _heights(assembly, patches, row, vertex) > rounding[row]]] = True
    return crossed


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


def _rows_of(pairs: Ints, other: Ints, n_blocks: int) -> tuple[Ints, Ints]:
    """Which of some other pairs are among the sorted pairs: their numbers there, and their own."""
    key, wanted = pairs @ [n_blocks, 1], other @ [n_blocks, 1]
    place = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    own = np.flatnonzero(key[place] == wanted)
    return place[own], own


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
