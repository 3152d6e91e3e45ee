"""Find the interfaces of an assembly: planar patches where two blocks face each other.

Two faces touch when their normals are opposed and the gap between their planes, measured at every corner of
the common patch, is within the tolerance. The gap of a warped face is measured from its surface, a fan of triangles
about its mean corner. Lengths are judged by the size of the smaller block, so the answer does not depend on units.
Faces in one plane (split or concave faces) make one interface a pair of blocks: only the corners of its convex hull
are kept, which is exact for equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.between import held_apart, in_gaps
from blockstat.contact.coplanar import Parts, Patches, corner_shares, merge_coplanar, parts_of, shares_of_parts
from blockstat.contact.edges import edge_contacts
from blockstat.contact.faces import (
    as_searched,
    concave_patches,
    convex_faces,
    flatness,
    frames,
    gaps_of_planes,
    gaps_of_surfaces,
    planar,
)
from blockstat.contact.features import ContactKind
from blockstat.contact.known_contacts import Tolerances
from blockstat.contact.overlap.back_to_back import back_to_back, centres
from blockstat.contact.overlap.beds import keys_of_overlap
from blockstat.contact.tolerance import GAP, allowed_gap, stated_length
from blockstat.errors import known_options
from blockstat.geometry import clipping as clip
from blockstat.geometry.broad_phase import near_pairs, row_pairs
from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

WIDTH = 1e-6  #: a patch narrower than this, relative to the smaller block, is two blocks meeting at an edge
SPAN = 1e-9  #: corners closer than this to a line of their neighbours say nothing new (rounding of coordinates)
#: Faces further from opposed than this are never one joint; nearer ones are judged by their gap.
ANGLE = np.deg2rad(15.0)
NEAR_MISS = 5.0  #: gaps up to this many tolerances are reported as dropped


@dataclass(frozen=True)
class Dropped:
    """A patch that looked like a joint and was not taken."""

    a: int
    b: int
    #: "gap", "narrow" for a patch that is narrower than its gap, which no tolerance takes, "sliver", "between" for
    #: faces that a block in their gap holds apart, or "overlap" for faces that meet no higher than a bed beside them
    #: overlaps
    reason: str
    value: float  #: the gap or the width [m]
    limit: float  #: what would have been accepted [m]


@dataclass(frozen=True, eq=False)
class Interfaces:
    """Contacts between blocks and their points: patches, and edges and corners without area.

    The normal points from block a to block b; forces are those on b. The frame (n, t1, t2) is right-handed.
    """

    pair: Ints  #: shape (n_interfaces, 2), blocks a < b
    frame: Floats  #: shape (n_interfaces, 3, 3), rows n, t1, t2
    area: Floats  #: shape (n_interfaces,) [m2]
    gap: Floats  #: shape (n_interfaces,) [m], largest distance between the two faces on the patch
    point: Floats  #: shape (n_points, 3) [m]
    start: Ints  #: shape (n_interfaces + 1,), points of interface k are start[k]:start[k+1]
    dropped: tuple[Dropped, ...] = ()
    outlines: tuple[Floats, ...] | None = None  #: corners of the patches where the points are not those
    share: Floats | None = None  #: part of the interface's area that each point stands for; None: that of corners
    #: the convex patches before those of one plane were merged, with the edges and corners in it; None: no others
    patches: Patches | None = None
    kind: Ints | None = None  #: shape (n_interfaces,), values of `ContactKind`; None: all are patches
    #: shape (n, 2), pairs that may also touch where there is no unique normal (see `blockstat.contact.unresolved`)
    rims: Ints | None = None
    #: coefficient of each interface, shape (n_interfaces,), in place of that of the assembly and of joint laws
    friction: Floats | None = None
    searched: float | str = GAP  #: the gap up to which faces were taken for a joint, as `find_interfaces` was asked
    #: the contacts as drawn, where these have lost their edges: what they covered is no bare contact; None: these
    drawn: Interfaces | None = None
    #: contacts without area that a joint law lets carry nothing: not among these, but in the way of a mechanism
    crushed: tuple[Interfaces, ...] = ()
    moved: bool = False  #: whether displaced corners took them along, while the ends of ties stayed where drawn

    @property
    def kinds(self) -> Ints:
        """Kind of each interface, values of `ContactKind`, shape (n_interfaces,)."""
        return np.zeros(self.n_interfaces, np.int64) if self.kind is None else self.kind

    @property
    def n_interfaces(self) -> int:
        """Number of interfaces."""
        return len(self.pair)

    @property
    def n_points(self) -> int:
        """Number of contact points."""
        return len(self.point)

    @property
    def point_interface(self) -> Ints:
        """Interface of each point, shape (n_points,)."""
        return np.repeat(np.arange(self.n_interfaces), np.diff(self.start))

    @cached_property
    def parts(self) -> Parts:
        """Patches, edges and corners that those joints are made of whose hull is more than their patches."""
        if self.patches is None:
            return {}
        outlines = [self.outline(k) for k in range(self.n_interfaces)]
        return parts_of(outlines, self.pair, self.frame, self.area, self.patches)

    @cached_property
    def point_share(self) -> Floats:
        """Part of its interface's area that each point stands for, shape (n_points,).

        The points of an interface with these weights have the area centroid of its patches.
        """
        if self.share is not None:
            return self.share
        k = self.point_interface
        first = self.point[self.start[k]]
        share = corner_shares(np.einsum("nj,ntj->nt", self.point - first, self.frame[k, 1:]), self.start)
        for k, parts in self.parts.items():
            own, across = slice(self.start[k], self.start[k + 1]), self.frame[k, 1:].T
            hull, *flat = ((corners - self.point[self.start[k]]) @ across for corners in (self.point[own], *parts))
            share[own] = shares_of_parts(hull, flat)
        return share

    @property
    def contacts(self) -> dict[str, int]:
        """Number of interfaces of each kind, by "face", "edge", "corner" and "crossing"."""
        counts = np.bincount(self.kinds, minlength=len(ContactKind))
        return {kind.name.lower(): int(counts[kind]) for kind in ContactKind}

    @property
    def contact_words(self) -> str:
        """The kinds that occur with their numbers, such as "3 face, 2 edge"; nothing where all are patches."""
        if not self.kinds.any():
            return ""
        return ", ".join(f"{count} {kind}" for kind, count in self.contacts.items() if count)

    def subset(self, rows: Ints | np.ndarray) -> Interfaces:
        """Return some of the interfaces with their points.

        Parameters
        ----------
        rows : array of int, or array of bool, shape (n_interfaces,)
            Numbers of the interfaces that stay, or a mask of them.

        Returns
        -------
        Interfaces
            In the order of `rows`; what was dropped, is crushed or has no normal stays listed.
        """
        rows = np.arange(self.n_interfaces)[rows]
        count = np.diff(self.start)[rows]
        _, points = members(self.start[rows], count)
        return replace(
            self,
            pair=self.pair[rows], frame=self.frame[rows], area=self.area[rows], gap=self.gap[rows],
            point=self.point[points], start=np.concatenate([[0], np.cumsum(count)]),
            outlines=None if self.outlines is None else tuple(self.outlines[k] for k in rows),
            share=None if self.share is None else self.share[points],
            kind=None if self.kind is None else self.kind[rows],
            friction=None if self.friction is None else self.friction[rows],
        )  # fmt: skip

    def outline(self, interface: int) -> Floats:
        """Return the corners of a patch in order: the ends of an edge, or the one point of a corner or a crossing.

        Parameters
        ----------
        interface : int
            Number of the interface.

        Returns
        -------
        array, shape (n, 3)
            Corners [m]: three or more of a patch, fewer without area.
        """
        if self.outlines is not None:
            return self.outlines[interface]
        return self.point[self.start[interface] : self.start[interface + 1]]


@known_options
def find_interfaces(assembly: Assembly, *, gap: float | str = GAP, near: Ints | None = None) -> Interfaces:
    """Find the interfaces between all blocks that touch; those between two supports are left out.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float or str, optional
        Largest gap or overlap of a joint, relative to the size (cube root of volume) of the smaller block. For plates
        and needles it is no more than a quarter of their thickness. A length such as "2 mm" says in addition that the
        geometry is no more exact: faces of a block that are flat to a quarter of it are one face
        (`blockstat.surface.facets.facets`).
    near : array of int, shape (n, 2), optional
        Pairs of blocks among which to look, as `near_blocks` gives them.

    Returns
    -------
    Interfaces
        The interfaces with their contact points, and the patches that were not taken.

    Raises
    ------
    InputError
        When `gap` is neither between 0 and 0.2 nor a length, or for an option that does not exist.

    Examples
    --------
    >>> from blockstat import Assembly, box, find_interfaces
    >>> blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1))]
    >>> found = find_interfaces(Assembly.from_blocks(blocks, supports=[0]))
    >>> found.pair.tolist(), found.n_points, found.area.tolist()
    ([[0, 1]], 4, [1.0])
    """
    near = near_blocks(assembly, gap=gap) if near is None else near
    allowed = allowed_gap(assembly, gap)
    assembly = as_searched(assembly, gap)
    rows = _opposed_faces(assembly, near, allowed)
    warp, blurred = assembly.planes.warp, stated_length(gap) is not None
    bent = warp > np.maximum(flatness(assembly, gap), WIDTH * assembly.size)[assembly.face_block]
    patches = _clip_faces(assembly, rows, np.where(blurred & ~bent, warp, 0.0), bent)
    return replace(_collect(assembly, patches, allowed, near), searched=gap)


def near_blocks(assembly: Assembly, *, gap: float | str = GAP) -> Ints:
    """Find the pairs of blocks whose boxes touch, or nearly so, without those of two supports.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float or str, optional
        As in `find_interfaces`.

    Returns
    -------
    array of int, shape (n, 2)
        Pairs a < b, sorted.

    Raises
    ------
    InputError
        When `gap` is neither between 0 and 0.2 nor a length.
    """
    lower, upper = assembly.bounds
    pairs = near_pairs(lower, upper, NEAR_MISS * allowed_gap(assembly, gap))
    return pairs[~assembly.support[pairs].all(axis=1)]


@dataclass(frozen=True)
class _Pieces:
    """Convex pieces of contact, one a row, before they are judged and merged."""

    pair: Ints
    frame: Floats
    polygon: Floats  #: shape (n, k, 2), coordinates along t1, t2 from `origin`
    count: Ints
    origin: Floats
    gap: Floats
    overlap: Floats
    rough: Floats  #: how far the corners of the two faces leave their planes, together [m]
    behind: np.ndarray  #: whether the two faces lie back to back, bool
    filling: dict[int, list[Floats]]  #: convex polygons of the pieces that do not fill their polygon, by row


def _opposed_faces(assembly: Assembly, pairs: Ints, allowed: Floats) -> tuple[Ints, Ints]:
    """Faces (fa, fb) of paired blocks that are nearly opposed and nearly coplanar."""
    lower, upper = assembly.bounds
    reach = NEAR_MISS * allowed[pairs].min(axis=1)
    row_a, face_a = _faces_near(assembly, pairs[:, 0], lower[pairs[:, 1]], upper[pairs[:, 1]], reach)
    row_b, face_b = _faces_near(assembly, pairs[:, 1], lower[pairs[:, 0]], upper[pairs[:, 0]], reach)
    low, high = assembly.face_bounds
    a, b = row_pairs(row_a, (low[face_a], high[face_a]), row_b, (low[face_b], high[face_b]), reach)
    fa, fb, row = face_a[a], face_b[b], row_a[a]

    planes = assembly.planes
    opposed = sum(axis[fa] * axis[fb] for axis in planes.normal.T) < -np.cos(ANGLE)
    fa, fb, row = fa[opposed], fb[opposed], row[opposed]
    offset = planes.centre[fb] - planes.centre[fa]
    distance = np.abs(np.einsum("ij,ij->i", offset, planes.normal[fa] - planes.normal[fb])) / 2
    near = distance <= reach[row] + np.sin(ANGLE) * np.linalg.norm(offset, axis=1)
    return fa[near], fb[near]


def _faces_near(assembly: Assembly, blocks: Ints, lower: Floats, upper: Floats, reach: Floats) -> tuple[Ints, Ints]:
    """For each row the faces of its block whose box comes within reach of the other block's box."""
    first = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
    count = np.diff(first)[blocks]
    row, face = members(first[blocks], count)
    near = np.ones(len(row), dtype=bool)
    for k, (low, high) in enumerate(zip(*(bound.T for bound in assembly.face_bounds), strict=True)):
        near &= low[face] <= np.repeat(upper[:, k] + reach, count)
        near &= high[face] >= np.repeat(lower[:, k] - reach, count)
    return row[near], face[near]


def _clip_faces(assembly: Assembly, rows: tuple[Ints, Ints], rough: Floats, bent: np.ndarray) -> list[_Pieces]:
    """Common patches of face pairs, in batches of like corner counts; concave faces go piece by piece."""
    fa, fb = rows
    if not len(fa):
        return []
    planes = assembly.planes
    normal = planes.normal[fa] - planes.normal[fb]
    frame = frames(normal / np.linalg.norm(normal, axis=1)[:, None])
    origin = (planes.centre[fa] + planes.centre[fb]) / 2
    size = np.diff(assembly.face_start)
    widest = np.maximum(size[fa], size[fb])
    convex = convex_faces(assembly)
    simple = convex[fa] & convex[fb]
    patches = []
    for width in np.unique(2 ** np.ceil(np.log2(widest[simple])).astype(int)) if simple.any() else []:
        batch = np.flatnonzero(simple & (widest <= width) & (widest > width // 2))
        k = int(widest[batch].max())
        a = planar(assembly, fa[batch], frame[batch], origin[batch], k)
        b = planar(assembly, fb[batch], frame[batch], origin[batch], k)[:, ::-1]
        polygon, count = clip.clip(a, b)
        patches.append((batch, polygon, count, {}))
    if not simple.all():
        patches.append(concave_patches(assembly, fa, fb, frame, origin, np.flatnonzero(~simple), WIDTH))
    found = []
    for batch, polygon, count, filling in patches:
        faces = fa[batch], fb[batch]
        gap, overlap, middle = gaps_of_planes(assembly, *faces, frame[batch], origin[batch], polygon, count)
        warped = np.flatnonzero((bent[fa[batch]] | bent[fb[batch]]) & (count > 0))
        own = batch[warped]
        sides = fa[own], fb[own], frame[own], origin[own]
        gap[warped], overlap[warped] = gaps_of_surfaces(assembly, *sides, polygon[warped], count[warped])
        inside = origin[batch] + np.einsum("nk,nkj->nj", centres(polygon, count, filling), frame[batch, 1:])
        found.append(
            _Pieces(
                pair=np.column_stack([assembly.face_block[fa[batch]], assembly.face_block[fb[batch]]]),
                frame=frame[batch],
                polygon=polygon,
                count=count,
                origin=origin[batch] + middle[:, None] * frame[batch, 0],
                gap=gap,
                overlap=overlap,
                rough=rough[fa[batch]] + rough[fb[batch]],
                behind=back_to_back(assembly, faces, frame[batch], inside, overlap),
                filling=filling,
            )
        )
    return found


def _collect(assembly: Assembly, batches: list[_Pieces], allowed: Floats, pairs: Ints) -> Interfaces:
    """Judge the patches, merge those of one plane, and list their corner points."""
    slivers: list[Dropped] = []
    kept: list[tuple] = [(np.empty((0, 2), int), np.empty((0, 3, 3)), np.empty((0, 3)), *[np.empty(0)] * 6)]
    corners, counts = [np.empty((0, 2))], [np.empty(0, int)]
    filling: dict[int, list[Floats]] = {}
    for p in batches:
        size = assembly.size[p.pair].min(axis=1)
        area = clip.area(p.polygon, p.count)
        extent = np.where(p.count > 0, clip.diameter(p.polygon, p.count), 0.0)
        # A patch of almost a point has an area of rounding only: it is no wider than it is long.
        width = np.minimum(area / np.where(extent > 0, extent, 1.0), extent)
        wide = width > WIDTH * size
        # Faces that meet at an angle touch along their edge; what is more open than wide is no joint.
        reach = allowed[p.pair].min(axis=1)
        limit = np.minimum(reach, width)
        close = p.gap <= limit
        near = wide & ~close & ~p.behind & (p.gap <= NEAR_MISS * reach) & (width > p.gap / NEAR_MISS)
        for i in np.flatnonzero(~wide & close & ~p.behind & (width > SPAN * size)):
            a, b = map(int, p.pair[i])
            slivers.append(Dropped(a, b, "sliver", float(width[i]), float(WIDTH * size[i])))
        gaps = p.gap + p.rough
        rows = np.flatnonzero((wide & close) | near)
        mask = clip.corners(p.polygon[rows], p.count[rows], SPAN * size[rows])
        before = sum(map(len, counts))
        for i in np.flatnonzero(np.isin(rows, list(p.filling))):
            filling[before + int(i)] = p.filling[int(rows[i])]
            area[rows[i]] = sum(clip.area(piece[None], np.array([len(piece)]))[0] for piece in p.filling[int(rows[i])])
        rough = p.rough[rows]
        numbers = area[rows], gaps[rows], p.overlap[rows], limit[rows] + rough, width[rows] + rough, p.behind[rows]
        kept.append((p.pair[rows], p.frame[rows], p.origin[rows], *numbers))
        corners.append(p.polygon[rows][mask])
        counts.append(mask.sum(axis=1))
    pair, frame, origin, area, gaps, overlap, *rest = (np.concatenate(own) for own in zip(*kept, strict=True))
    found = Patches(pair, frame, origin, area, gaps, np.concatenate(corners), np.concatenate(counts), overlap)
    tolerances = Tolerances(allowed, WIDTH, float(np.sin(ANGLE)))
    limit, width, behind = rest
    real = np.flatnonzero(behind == 0)
    joints, held, dropped = _without_blocks_between(assembly, found.take(real), limit[real], width[real], tolerances)
    joints = real[joints]
    single = found.take(joints)
    merged = merge_coplanar(single, allowed)
    parts = _filled(single, {i: filling[k] for i, k in enumerate(joints.tolist()) if k in filling})
    found, kind, rims, bare = edge_contacts(assembly, merged, found.take(np.flatnonzero(behind)), pairs, tolerances)
    if kind is not None:
        found, kind = _edges_that_touch(assembly, found, kind, held)
    tangents = np.repeat(found.frame[:, 1:], found.count, axis=0)
    point = np.repeat(found.origin, found.count, axis=0) + np.einsum("nk,nkj->nj", found.corner, tangents)
    start = np.concatenate([[0], np.cumsum(found.count)])
    several = len(parts.pair) > len(merged.pair) or bare
    return Interfaces(
        found.pair, found.frame, found.area, found.gap, point, start, (*dropped, *slivers),
        patches=(parts.with_more(bare) if bare else parts) if several else None, kind=kind, rims=rims,
    )  # fmt: skip


def _filled(patches: Patches, filling: dict[int, list[Floats]]) -> Patches:
    """Patches with the convex polygons that some of them are made of in their place."""
    if not filling:
        return patches
    more = [
        patch._replace(polygon=piece, area=float(clip.area(piece[None], np.array([len(piece)]))[0]))
        for patch, row in zip(patches.take(np.array(list(filling))), filling, strict=True)
        for piece in filling[row]
    ]
    return patches.take(np.setdiff1d(np.arange(len(patches.pair)), list(filling))).with_more(more)


def _without_blocks_between(
    assembly: Assembly, found: Patches, limit: Floats, width: Floats, tolerances: Tolerances
) -> tuple[Ints, Patches, list[Dropped]]:
    """Numbers of the joints that no other block holds open, those held open, and all patches that are none."""
    close = found.gap <= limit
    held = held_apart(assembly, found.take(np.flatnonzero(close)), found, ANGLE)
    rest = np.flatnonzero(close & ~held)
    keys = rest[keys_of_overlap(assembly, found.take(rest), tolerances)]
    reason = np.select([held, close, found.gap > width], ["between", "overlap", "narrow"], "gap")
    dropped = [
        Dropped(a, b, str(reason[i]), float(found.gap[i]), float(limit[i]))
        for i in np.union1d(np.flatnonzero(held == close), keys).tolist()
        for a, b in found.pair[[i]].tolist()
    ]
    return np.setdiff1d(rest, keys), found.take(np.flatnonzero(held)), dropped


def _edges_that_touch(assembly: Assembly, found: Patches, kind: Ints, held: Patches) -> tuple[Patches, Ints]:
    """All contacts but those of edges and corners that another block holds open, there or elsewhere in their plane."""
    bare = np.flatnonzero(kind != ContactKind.FACE)
    contacts = found.take(bare)
    apart = held_apart(assembly, found, contacts, ANGLE)
    apart |= in_gaps(assembly, contacts, held, ANGLE)
    kept = np.setdiff1d(np.arange(len(kind)), bare[apart])
    return (found, kind) if len(kept) == len(kind) else (found.take(kept), kind[kept])
