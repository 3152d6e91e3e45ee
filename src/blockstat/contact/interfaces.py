"""Find the interfaces of an assembly: planar patches where two blocks face each other.

Two faces touch when their normals are opposed and the gap between their planes, measured at every corner of
the common patch, is within the tolerance. Lengths are judged by the size of the smaller block, so the answer
does not depend on units. Faces in one plane (split or concave faces) make one interface a pair of blocks:
only the corners of its convex hull are kept, which is exact for equilibrium.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.coplanar import Patches, merge_coplanar
from blockstat.contact.edges import Tolerances, edge_contacts
from blockstat.contact.faces import convex_faces, frames, planar
from blockstat.contact.nonconvex import concave_patches
from blockstat.contact.tolerance import FLATNESS, GAP, allowed_gap, stated_length
from blockstat.errors import known_options
from blockstat.geometry import clipping as clip
from blockstat.geometry.broad_phase import near_pairs
from blockstat.geometry.facets import facets
from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

WIDTH = 1e-6  #: a patch narrower than this, relative to the smaller block, is two blocks meeting at an edge
SPAN = 1e-9  #: corners closer than this to a line of their neighbours say nothing new (rounding of coordinates)
ANGLE = np.deg2rad(
    15.0
)  #: faces further from opposed than this are never one joint; nearer ones are judged by their gap
NEAR_MISS = 5.0  #: gaps up to this many tolerances are reported as dropped
FILLED = 1.1  #: a block at most this many times as thick as a gap, and next to both sides, fills it


@dataclass(frozen=True)
class Dropped:
    """A patch that looked like a joint and was not taken."""

    a: int
    b: int
    reason: str  #: "gap" or "sliver"
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
    share: Floats | None = None  #: part of the interface's area that each point stands for; None: equal parts
    kind: Ints | None = None  #: shape (n_interfaces,), values of `ContactKind`; None: all are patches
    #: shape (n, 2), pairs that may also touch where there is no unique normal (see `blockstat.contact.unresolved`)
    rims: Ints | None = None

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

    @property
    def point_share(self) -> Floats:
        """Part of its interface's area that each point stands for, shape (n_points,)."""
        if self.share is not None:
            return self.share
        return (1.0 / np.maximum(np.diff(self.start), 1))[self.point_interface]

    def outline(self, interface: int) -> Floats:
        """Return the corners of a patch in order.

        Parameters
        ----------
        interface : int
            Number of the interface.

        Returns
        -------
        array, shape (n, 3)
            Corners [m].
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
        (`blockstat.geometry.facets.facets`).
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
    rough = assembly.planes.warp * (stated_length(gap) is not None)
    patches = _clip_faces(assembly, rows, rough)
    return _collect(assembly, patches, allowed, near)


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


def as_searched(assembly: Assembly, gap: float | str) -> Assembly:
    """Return the blocks with the faces that the search sees.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float or str
        As in `find_interfaces`.

    Returns
    -------
    Assembly
        The blocks themselves, or with facets if the gap is a length: it says how exact the geometry is.
    """
    if stated_length(gap) is None:
        return assembly
    return facets(assembly, tolerance=FLATNESS * allowed_gap(assembly, gap))


@dataclass(frozen=True)
class _Pieces:
    """Convex pieces of contact, one a row, before they are judged and merged."""

    pair: Ints
    frame: Floats
    polygon: Floats  #: shape (n, k, 2), coordinates along t1, t2 from `origin`
    count: Ints
    origin: Floats
    gap: Floats
    rough: Floats  #: how far the corners of the two faces leave their planes, together [m]


def _opposed_faces(assembly: Assembly, pairs: Ints, allowed: Floats) -> tuple[Ints, Ints]:
    """Faces (fa, fb) of paired blocks that are nearly opposed and nearly coplanar."""
    lower, upper = assembly.bounds
    reach = NEAR_MISS * allowed[pairs].min(axis=1)
    corners, start = assembly.vertices[assembly.face_vertices], assembly.face_start[:-1]
    boxes = np.minimum.reduceat(corners, start), np.maximum.reduceat(corners, start)
    row_a, face_a = _faces_near(assembly, boxes, pairs[:, 0], lower[pairs[:, 1]], upper[pairs[:, 1]], reach)
    row_b, face_b = _faces_near(assembly, boxes, pairs[:, 1], lower[pairs[:, 0]], upper[pairs[:, 0]], reach)
    count_b = np.bincount(row_b, minlength=len(pairs))
    first_b = np.concatenate([[0], np.cumsum(count_b)])
    repeat = count_b[row_a]
    fa = np.repeat(face_a, repeat)
    fb = face_b[members(first_b[row_a], repeat)[1]]
    row = np.repeat(row_a, repeat)

    planes = assembly.planes
    opposed = np.einsum("ij,ij->i", planes.normal[fa], planes.normal[fb]) < -np.cos(ANGLE)
    fa, fb, row = fa[opposed], fb[opposed], row[opposed]
    offset = planes.centre[fb] - planes.centre[fa]
    distance = np.abs(np.einsum("ij,ij->i", offset, planes.normal[fa] - planes.normal[fb])) / 2
    near = distance <= reach[row] + np.sin(ANGLE) * np.linalg.norm(offset, axis=1)
    return fa[near], fb[near]


def _faces_near(
    assembly: Assembly, boxes: tuple[Floats, Floats], blocks: Ints, lower: Floats, upper: Floats, reach: Floats
) -> tuple[Ints, Ints]:
    """For each row the faces of its block whose box comes within reach of the other block's box."""
    first = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
    count = np.diff(first)[blocks]
    row, face = members(first[blocks], count)
    slack = reach[row][:, None]
    separated = (boxes[0][face] > upper[row] + slack) | (boxes[1][face] < lower[row] - slack)
    near = ~(separated[:, 0] | separated[:, 1] | separated[:, 2])
    return row[near], face[near]


def _clip_faces(assembly: Assembly, rows: tuple[Ints, Ints], rough: Floats) -> list[_Pieces]:
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
        patches.append((batch, polygon, count))
    if not simple.all():
        patches.append(concave_patches(assembly, fa, fb, frame, origin, np.flatnonzero(~simple)))
    found = []
    for batch, polygon, count in patches:
        gap, middle = _gaps(assembly, fa[batch], fb[batch], frame[batch], origin[batch], polygon, count)
        found.append(
            _Pieces(
                pair=np.column_stack([assembly.face_block[fa[batch]], assembly.face_block[fb[batch]]]),
                frame=frame[batch],
                polygon=polygon,
                count=count,
                origin=origin[batch] + middle[:, None] * frame[batch, 0],
                gap=gap,
                rough=rough[fa[batch]] + rough[fb[batch]],
            )
        )
    return found


def _gaps(
    assembly: Assembly, fa: Ints, fb: Ints, frame: Floats, origin: Floats, polygon: Floats, count: Ints
) -> tuple[Floats, Floats]:
    """Largest distance along n between two faces over the corners of their patch, and the height of the middle.

    Faces that are not parallel do not meet halfway between their centres.
    """
    height = []
    live = np.arange(polygon.shape[1]) < count[:, None]
    for face in (fa, fb):
        local = np.einsum("nij,nj->ni", frame, assembly.planes.normal[face])
        offset = np.einsum("nj,nj->n", assembly.planes.centre[face] - origin, assembly.planes.normal[face])
        inplane = np.einsum("nkj,nj->nk", polygon, local[:, 1:])
        height.append((offset[:, None] - inplane) / local[:, :1])
    middle = np.where(live, height[0] + height[1], 0.0).sum(axis=1) / (2 * np.maximum(count, 1))
    return np.where(live, np.abs(height[1] - height[0]), 0.0).max(axis=1, initial=0.0), middle


def _collect(assembly: Assembly, batches: list[_Pieces], allowed: Floats, pairs: Ints) -> Interfaces:
    """Judge the patches, merge those of one plane, and list their corner points."""
    near: list[tuple[Dropped, Floats]] = []
    dropped: list[Dropped] = []
    kept: list[tuple] = [(np.empty((0, 2), int), np.empty((0, 3, 3)), np.empty((0, 3)), *[np.empty(0)] * 2)]
    corners, counts = [np.empty((0, 2))], [np.empty(0, int)]
    for p in batches:
        size = assembly.size[p.pair].min(axis=1)
        area = clip.area(p.polygon, p.count)
        extent = np.where(p.count > 0, _diameter(p.polygon, p.count), 0.0)
        # A patch of almost a point has an area of rounding only: it is no wider than it is long.
        width = np.minimum(area / np.where(extent > 0, extent, 1.0), extent)
        wide = width > WIDTH * size
        # Faces that meet at an angle touch along their edge; what is more open than wide is no joint.
        limit = np.minimum(allowed[p.pair].min(axis=1), width)
        close = p.gap <= limit
        for i in np.flatnonzero(
            wide & ~close & (p.gap <= NEAR_MISS * allowed[p.pair].min(axis=1)) & (width > p.gap / NEAR_MISS)
        ):
            a, b = map(int, p.pair[i])
            near.append((Dropped(a, b, "gap", float(p.gap[i]), float(limit[i])), p.frame[i, 0]))
        for i in np.flatnonzero(~wide & close & (width > SPAN * size)):
            a, b = map(int, p.pair[i])
            dropped.append(Dropped(a, b, "sliver", float(width[i]), float(WIDTH * size[i])))
        good = np.flatnonzero(wide & close)
        mask = clip.corners(p.polygon[good], p.count[good], SPAN * size[good])
        kept.append((p.pair[good], p.frame[good], p.origin[good], area[good], p.gap[good] + p.rough[good]))
        corners.append(p.polygon[good][mask])
        counts.append(mask.sum(axis=1))
    pair, frame, origin, area, gaps = (np.concatenate(column) for column in zip(*kept, strict=True))
    found = Patches(pair, frame, origin, area, gaps, np.concatenate(corners), np.concatenate(counts))
    found = merge_coplanar(found, allowed)
    found, kind, rims = edge_contacts(assembly, found, pairs, Tolerances(allowed, WIDTH, float(np.sin(ANGLE))))
    tangents = np.repeat(found.frame[:, 1:], found.count, axis=0)
    point = np.repeat(found.origin, found.count, axis=0) + np.einsum("nk,nkj->nj", found.corner, tangents)
    start = np.concatenate([[0], np.cumsum(found.count)])
    dropped = [*_open(assembly, near, found.pair), *dropped]
    return Interfaces(
        found.pair, found.frame, found.area, found.gap, point, start, tuple(dropped), kind=kind, rims=rims
    )


def _open(assembly: Assembly, near: list[tuple[Dropped, Floats]], pair: Ints) -> list[Dropped]:
    """The near joints without those that a third block fills, which touches both and is as thick as they are apart."""
    touching: defaultdict[int, set[int]] = defaultdict(set)
    for a, b in pair.tolist() if near else ():
        touching[a].add(b)
        touching[b].add(a)
    found = []
    for joint, normal in near:
        between = touching[joint.a] & touching[joint.b]
        corners = (assembly.vertices[slice(*assembly.vertex_start[c : c + 2])] @ normal for c in between)
        if not any(np.ptp(height) <= FILLED * joint.value for height in corners):
            found.append(joint)
    return found


def _diameter(polygon: Floats, count: Ints) -> Floats:
    """Diagonal of the box of each polygon."""
    live = (np.arange(polygon.shape[1]) < count[:, None])[..., None]
    top = np.where(live, polygon, -np.inf).max(axis=1)
    bottom = np.where(live, polygon, np.inf).min(axis=1)
    return np.linalg.norm(np.where(count[:, None] > 0, top - bottom, 0.0), axis=1)
