"""The faces of joints at rest as convex polygons: several where the faces of a block do not fill their hull.

A joint of an edge or a corner has faces on one side only. On the other its outline is the edge, from end to end and not
only where it touches, or the corner: a polygon of two points, or of one. Where edges cross there is one on both sides.
"""

from __future__ import annotations

from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from blockstat.contact.faces import FILLED, convex_polygons, joined_convex, outline_hull
from blockstat.contact.interfaces import Interfaces
from blockstat.large_displacement.displaced.pose import side_sizes
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Faces of a block belong to a joint when the sine of the angle between the normals is below this. Chosen: faces of one
#: joint are nearly parallel, and other faces of a block stand at an angle to it.
SAME_FACE_SINE = 0.05
#: Faces of a block belong to a joint when they are within this distance of it, beside the joint's gap at rest. Relative
#: to the block's size, and for a support to that of the block on it. Chosen: parallel faces of a block are further
#: apart.
SAME_FACE_DISTANCE = 1e-3
#: Joints whose faces are warped, or tilted against each other, by more than this are meant so [rad]. Chosen: the tilt
#: up to which faces belong to a joint.
LARGEST_TILT = SAME_FACE_SINE
#: A point of a joint lies on the faces, or on an edge, of a block when it is no further from them than this, beside the
#: joint's gap at rest. Relative to the block's size, and for a support to that of the block on it. Chosen: far above
#: the rounding of coordinates, and far below the distance of parallel edges of a block.
ON_FEATURE = 1e-5
#: Edges of a joint are drawn parallel when the sine of their angle is below this. Chosen: faces of voussoirs and of
#: domes taper by more where they are meant to.
PARALLEL_EDGES = 0.01


class Flaw(NamedTuple):
    """By how much the drawn faces of joints miss planes: the rounding of corners in files, and of far coordinates.

    With plane joints a lintel on two piers slides freely on both. With corners off by a micrometre its bearings are
    two planes that are not quite parallel: taken literally, it can slide along their line of intersection alone, which
    is anywhere. And the hinges of an arch are not quite parallel, so that taken literally it is rigid. So what follows
    from tilts and distances of this size is not taken literally.
    """

    distance: float  #: largest distance of a corner of a joint from its plane, or from a parallel to an edge [m]
    tilt: float  #: largest angle between the normal of a joint and one that its corners would allow [rad]
    mean_distance: float  #: root mean square of the distances of faces [m]
    mean_tilt: float  #: root mean square of the angles of faces [rad]

    def speed(self, length: float) -> float:
        """Return by how much two points of a contact that sticks may part, relative to the fastest motion.

        Parameters
        ----------
        length
            That rotations are multiplied by [m].

        Returns
        -------
        float
            The arms of both points about the centroids may be off by the distance along each axis.
        """
        return 2.0 * np.sqrt(3.0) * self.distance / length

    def rate(self, length: float) -> float:
        """Return by how much the rate of the gap of a contact may be off, relative to the fastest motion.

        Parameters
        ----------
        length
            That rotations are multiplied by [m].

        Returns
        -------
        float
            A row of rates has a normal, which may be tilted, and the moment of that normal about the centroid of each
            of two bodies, whose arm may be off by the distance along each axis.
        """
        return 2.0 * self.tilt + self.speed(length)

    def row(self, length: float, *, slides: bool) -> float:
        """Return the root mean square by which the rows of rates of a linkage are off.

        Parameters
        ----------
        length
            That rotations are multiplied by [m].
        slides
            Whether a contact slides. Rows of contacts that stick are along fixed axes, so no tilt turns them.

        Returns
        -------
        float
            Length of a row of two bodies. Of an axis, two components of the moment are off by the distance.
        """
        return 2.0 * (self.mean_distance / length + (self.mean_tilt if slides else 0.0))

    def gap(self, slip: float) -> float:
        """Return by how much a contact may be open or overlap where a linkage with plane joints keeps it closed.

        Parameters
        ----------
        slip
            How far a contact slides at most [m].

        Returns
        -------
        float
            Both points of a contact may be off by the distance along each axis, and a rotation of their blocks turns
            these against each other; a contact that slides rises by the tilt [m].
        """
        return 2.0 * np.sqrt(3.0) * self.distance + self.tilt * slip


class FaceOutlines:
    """Convex polygons of the faces on the two sides of joints, found when they are first asked for."""

    def __init__(self, assembly: Assembly, interfaces: Interfaces) -> None:
        self._assembly, self._interfaces = assembly, interfaces
        self._found: dict[int, tuple[list[Floats], list[Floats]]] = {}

    def of(self, joints: Ints) -> tuple[Ints, Floats]:
        """Return the corners of the faces of joints at rest: each polygon of block a with each one of block b.

        Parameters
        ----------
        joints
            Numbers of the joints, shape (k,).

        Returns
        -------
        owner : Ints
            Which of the joints each row is of, ascending, shape (n,). Most joints have one row: the faces of either
            block fill their convex hull.
        corner : Floats
            Shape (n, 2, w, 3) [m]: of each polygon, counter-clockwise seen against the joint's normal. One with fewer
            than w corners repeats its last one; so do edges, which have two, and corners of blocks, which have one.
        """
        rows = [(k, pair) for k, joint in enumerate(map(int, joints)) for pair in product(*self.sides(joint))]
        outlines = [pair for _, pair in rows]
        width = max((len(outline) for pair in outlines for outline in pair), default=0)
        corner = np.empty((len(outlines), 2, width, 3))
        for k, pair in enumerate(outlines):
            for side, outline in enumerate(pair):
                corner[k, side, : len(outline)] = outline
                corner[k, side, len(outline) :] = outline[-1]
        return np.array([k for k, _ in rows], dtype=np.int64), corner

    def sides(self, joint: int) -> tuple[list[Floats], list[Floats]]:
        """Return the outlines of the two sides of a joint at rest.

        Parameters
        ----------
        joint
            Number of the joint.

        Returns
        -------
        tuple of two lists
            Of block a and of block b: convex polygons, each of shape (n, 3) [m]; of an edge its two ends, of a corner
            the corner. Empty where what touches is not found.
        """
        if joint not in self._found:
            own = self._polygons if self._interfaces.area[joint] > 0 else self._feature
            self._found[joint] = (own(joint, 0), own(joint, 1))
        return self._found[joint]

    @property
    def flaw(self) -> Flaw:
        """How well the faces of all joints agree with planes; zero where some are far from plane, hence meant so."""
        return self.drawn if self.drawn.tilt <= LARGEST_TILT else Flaw(0.0, 0.0, 0.0, 0.0)

    @cached_property
    def drawn(self) -> Flaw:
        """How well the faces of all joints agree with planes, whether meant so or not."""
        found = []
        for joint in np.flatnonzero(self._interfaces.area > 0):
            points = self._interfaces.point[self._interfaces.start[joint] : self._interfaces.start[joint + 1]]
            reach = 0.5 * float(np.linalg.norm(np.ptp(points, axis=0)))
            skew = _off_parallel(self._interfaces.outline(int(joint)))
            for corner in (face for side in (0, 1) for face in self._faces(int(joint), side)):
                off, sine, warp = _off_plane(corner, self._interfaces.frame[joint, 0])
                # A support may reach far beyond the joint, and so may what it is off by.
                found.append((np.hypot(min(off, warp * reach) + sine * reach, skew), sine + warp))
        each = np.array(found).reshape(-1, 2)
        largest, mean = each.max(axis=0, initial=0.0), np.sqrt((each**2).sum(axis=0) / max(len(each), 1))
        return Flaw(*map(float, (*largest, *mean)))

    def _feature(self, joint: int, side: int) -> list[Floats]:
        """What of one block touches in a joint without area: the faces on which the points lie, or an edge or a corner.

        Faces of the block in the same plane elsewhere are not what touches: a beam with a flat foot may have a sharp
        one, too.
        """
        import shapely

        interfaces, block = self._interfaces, int(self._interfaces.pair[joint, side])
        points = interfaces.point[interfaces.start[joint] : interfaces.start[joint + 1]]
        size = float(side_sizes(self._assembly, interfaces.pair[[joint]])[0, side])
        within = float(interfaces.gap[joint]) + ON_FEATURE * size
        if self._touching(joint, side):
            polygons, across = self._polygons(joint, side), interfaces.frame[joint, 1:].T
            region = shapely.union_all([shapely.Polygon(corner @ across) for corner in polygons])
            if (shapely.distance(shapely.points(points @ across), region) <= within).all():
                return polygons
        corners = self._assembly.block_vertices(block)
        if len(points) == 1:
            distance = np.linalg.norm(corners - points, axis=1)
            if distance.min() <= within:
                return [corners[[distance.argmin()]]]
        edge = _edge_along(self._assembly, block, points, interfaces.frame[joint, 0], within)
        return [] if edge is None else [edge]

    def _polygons(self, joint: int, side: int) -> list[Floats]:
        """Convex polygons in the joint's plane that the faces of one block fill, each of shape (n, 3) [m]."""
        import shapely

        faces = self._faces(joint, side)
        corner = np.concatenate(faces)
        flat = (corner - corner[0]) @ self._interfaces.frame[joint, 1:].T
        hull, ends = outline_hull(flat), np.cumsum([len(face) for face in faces])[:-1]
        filled = shapely.union_all([shapely.make_valid(shapely.Polygon(face)) for face in np.split(flat, ends)])
        polygons = [hull]
        if shapely.Polygon(hull).area > (1 + FILLED) * filled.area:
            parts = [part for part in shapely.get_parts(filled) if part.geom_type == "Polygon"]
            polygons = joined_convex([piece for part in parts for piece in convex_polygons(part)])
        return [corner[np.linalg.norm(one[:, None] - flat, axis=2).argmin(axis=1)] for one in polygons]

    def _faces(self, joint: int, side: int) -> list[Floats]:
        """Corners at rest of those faces of a block that lie in a joint, each of shape (n, 3) [m]; else its points."""
        interfaces = self._interfaces
        points = interfaces.point[interfaces.start[joint] : interfaces.start[joint + 1]]
        return self._touching(joint, side) or [points]

    def _touching(self, joint: int, side: int) -> list[Floats]:
        """Corners at rest of those faces of a block that lie in the plane of a joint, each of shape (n, 3) [m]."""
        assembly, interfaces = self._assembly, self._interfaces
        block, normal = int(interfaces.pair[joint, side]), interfaces.frame[joint, 0]
        points = interfaces.point[interfaces.start[joint] : interfaces.start[joint + 1]]
        faces = np.flatnonzero(assembly.face_block == block)
        outward = 1.0 if side == 0 else -1.0
        facing = outward * (assembly.planes.normal[faces] @ normal) > np.sqrt(1 - SAME_FACE_SINE**2)
        to_centre = assembly.planes.centre[faces] - points.mean(axis=0)
        if assembly.support[block]:  # its centre may be far away, so that the least tilt of the joint would lift it
            height = np.abs(np.einsum("ni,ni->n", to_centre, assembly.planes.normal[faces]))
        else:
            height = np.abs(to_centre @ normal)
        size = float(side_sizes(assembly, interfaces.pair[[joint]])[0, side])
        distance = float(interfaces.gap[joint]) + SAME_FACE_DISTANCE * size
        rows = faces[facing & (height <= distance)]
        start = assembly.face_start
        return [assembly.vertices[assembly.face_vertices[start[f] : start[f + 1]]] for f in rows]


def _edge_along(assembly: Assembly, block: int, points: Floats, normal: Floats, within: float) -> Floats | None:
    """The ends of the edge of a block on which one or two points lie, shape (2, 3) [m]; None where there is none.

    Edges that continue each other are one. One that leaves the plane of the joint through a single point is none.
    """
    corners = assembly.block_vertices(block)
    tails = np.concatenate([corners[face] for face in assembly.faces_of(block)])
    heads = np.concatenate([corners[np.roll(face, -1)] for face in assembly.faces_of(block)])
    unit = (heads - tails) / np.linalg.norm(heads - tails, axis=1)[:, None]
    off = np.linalg.norm(np.cross(points - tails[:, None], unit[:, None]), axis=2).max(axis=1)
    line = points[-1] - points[0]
    length = float(np.linalg.norm(line))
    if length > 0:
        along = line / length
        level = np.linalg.norm(np.cross(unit, along), axis=1) <= PARALLEL_EDGES
    else:
        level = np.abs(unit @ normal) <= PARALLEL_EDGES
        low, high = (np.einsum("ij,ij->i", points[0] - end, unit) for end in (tails, heads))
        level &= (low >= -within) & (high <= within)
        if not level.any():
            return None
        along = unit[level][off[level].argmin()]
        level &= np.linalg.norm(np.cross(unit, along), axis=1) <= PARALLEL_EDGES
    rows = np.flatnonzero(level & (off <= within))
    ends = np.concatenate([tails[rows], heads[rows]])
    place = (ends - points[0]) @ along
    spans = np.sort(place.reshape(2, -1), axis=0).T
    low, high = 0.0, length
    for _ in spans:  # each may lengthen the edge and so reach another one
        meets = (spans[:, 0] <= high + within) & (spans[:, 1] >= low - within)
        low, high = min(low, *spans[meets, 0], high), max(high, *spans[meets, 1], low)
    if not len(rows) or high - low <= 2 * within:
        return None
    found: Floats = ends[[np.abs(place - low).argmin(), np.abs(place - high).argmin()]]
    return found


def _off_plane(corner: Floats, normal: Floats) -> tuple[float, float, float]:
    """The largest distance of a face's corners from its mean plane [m], and the sine of its tilt against a normal.

    The third is the angle by which it is warped: that distance over half its width, as its plane is that of some of its
    corners as well.
    """
    arm = corner - corner.mean(axis=0)
    _, _, axes = np.linalg.svd(arm, full_matrices=False)
    off, width = float(np.abs(arm @ axes[2]).max()), float(np.ptp(arm @ axes[1]))
    sine = float(np.linalg.norm(np.cross(axes[2], normal)))
    return off, sine, 2.0 * off / width if width > 0 else 0.0


def _off_parallel(corner: Floats) -> float:
    """By how much the ends of those edges of a joint are off that are drawn parallel, at most [m]."""
    edge = np.roll(corner, -1, axis=0) - corner
    length = np.linalg.norm(edge, axis=1)
    edge, length = edge[length > 0], length[length > 0]
    unit = edge / length[:, None]
    sine = np.linalg.norm(np.cross(unit[:, None], unit), axis=2)
    shorter = np.minimum(length[:, None], length)
    return float(0.5 * (np.where(sine <= PARALLEL_EDGES, sine, 0.0) * shorter).max(initial=0.0))
