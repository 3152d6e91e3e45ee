"""The free parts of faces, and the wrenches of tractions on them.

A face is free where no other block touches it. Integrals over it are exact: it is cut into triangles about one point,
with signs, and a traction that is linear in place times an arm is a polynomial of degree two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from blockstat.contact.cells import patches_of
from blockstat.contact.faces import frames, grid_of, uncovered
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.contact.tolerance import allowed_gap
from blockstat.errors import InputError
from blockstat.loading.placed import PlacedForces, at_points
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: What is on a plane, or covers a region, to this fraction of a block's size, or of the region's.
ON = 1e-6
#: A joint lies in a face when their normals differ by less than this cosine says (15 degrees, as joints are found).
ALONG = float(np.cos(np.deg2rad(15.0)))
#: A face that leans towards a direction by less than this cosine is parallel to it: as much as it may turn where its
#: corners are off by the gap of a joint. Of coordinates to a millimetre it is half on stones of a foot. What is left
#: out along the direction is less than this share of the load that the face would bear if it looked that way.
TOWARDS = GAP

#: Force per area [N/m2] at points of shape (n, 3) with the unit outward normal there, shape (n, 3).
Traction = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True, eq=False)
class Face:
    """A free part of a face of a block."""

    block: int
    frame: Floats  #: rows outward normal, t1, t2, shape (3, 3)
    origin: Floats  #: shape (3,) [m]
    region: Any  #: shapely polygon or polygons, along t1 and t2 from the origin [m]

    @property
    def normal(self) -> Floats:
        """Unit outward normal, shape (3,)."""
        return self.frame[0]

    def flat(self, points: Any) -> Floats:
        """Return points of space along t1 and t2.

        Parameters
        ----------
        points : array_like, shape (n, 3)
            Points [m]; what they are off the plane of the face is left out.

        Returns
        -------
        Floats
            Coordinates from the origin of the face, shape (n, 2) [m].
        """
        return (np.asarray(points, dtype=float) - self.origin) @ self.frame[1:].T

    def height(self, points: Any) -> Floats:
        """Return how far points are outside the plane of the face.

        Parameters
        ----------
        points : array_like, shape (n, 3) or (3,)
            Points [m].

        Returns
        -------
        Floats
            Distances along the outward normal, shape (n,) or () [m]; below 0 on the side of the block.
        """
        return (np.asarray(points, dtype=float) - self.origin) @ self.frame[0]

    def within(self, region: Any) -> Face:
        """Return the part inside a region of its plane.

        Parameters
        ----------
        region : shapely geometry
            Polygon or polygons, along t1 and t2 from the origin of the face [m].

        Returns
        -------
        Face
            Of the same block, frame and origin; its region is empty where the two do not meet.
        """
        part = self.region.intersection(region, grid_size=grid_of(self.region))
        return Face(self.block, self.frame, self.origin, part)


def selected(assembly: Assembly, blocks: Iterable[int | str] | int | str | None, group: str | None) -> Ints:
    """Return the blocks that a load is for: those named, those of a group, or all that are free.

    Parameters
    ----------
    assembly
        The blocks.
    blocks
        Names or numbers.
    group
        Name of a group, with its subgroups.

    Returns
    -------
    Ints
        Numbers of the blocks, ascending, each once.

    Raises
    ------
    InputError
        For both, or for a name that does not exist.
    """
    if blocks is not None and group is not None:
        raise InputError("a load is for blocks or for a group; give one of the two")
    if blocks is not None:
        return np.unique(assembly.blocks_named(blocks, "load"))
    return assembly.free if group is None else assembly.in_group(group)


def free_faces(
    assembly: Assembly, blocks: Ints, *, towards: Floats | None = None, interfaces: Interfaces | None = None
) -> list[Face]:
    """Find the parts of faces of some blocks that no other block touches.

    Parameters
    ----------
    assembly
        The blocks.
    blocks
        Numbers of those whose faces are wanted, shape (n,).
    towards
        Only faces that look this way by a cosine above `TOWARDS`, shape (3,).
    interfaces
        Where blocks touch; searched for when None.

    Returns
    -------
    list of Face
        In the order of the faces of the assembly.

    Notes
    -----
    Joints are found between faces that are apart, or warped, by up to a share of the smaller block. So a joint lies in
    the faces of its blocks that are as near to it, and strips that joints leave of a face are no face where they are no
    wider.
    """
    from shapely import Polygon

    interfaces = find_interfaces(assembly) if interfaces is None else interfaces
    wanted = np.isin(assembly.face_block, blocks)
    if towards is not None:
        wanted &= assembly.planes.normal @ (towards / np.linalg.norm(towards)) > TOWARDS
    joints = _joints(assembly, interfaces, blocks)
    found = []
    for f in np.flatnonzero(wanted):
        block = int(assembly.face_block[f])
        corners = assembly.vertices[assembly.face_vertices[assembly.face_start[f] : assembly.face_start[f + 1]]]
        frame = frames(assembly.planes.normal[f][None])[0]
        face = Face(block, frame, assembly.planes.centre[f], None)
        beds = [
            joint
            for joint in joints[block]
            if joint.normal @ face.normal > ALONG and np.abs(face.height(joint.patch)).max() <= joint.reach
        ]
        patches, strips = [face.flat(joint.patch) for joint in beds], [joint.reach for joint in beds]
        region = uncovered(Polygon(face.flat(corners)), patches, strips)
        if not region.is_empty:
            found.append(Face(block, frame, face.origin, region))
    return found


class _Joint(NamedTuple):
    """A patch of a joint as one of its blocks has it."""

    normal: Floats  #: outward
    patch: Floats  #: corners, shape (n, 3) [m]
    reach: float  #: how far it may be from the faces that it lies in [m]


def _joints(assembly: Assembly, interfaces: Interfaces, blocks: Ints) -> dict[int, list[_Joint]]:
    """Of each block the patches that cover it."""
    found: dict[int, list[_Joint]] = {int(block): [] for block in blocks}
    reach = interfaces.gap + allowed_gap(assembly, GAP)[interfaces.pair].min(axis=1)
    for k in np.flatnonzero((interfaces.area > 0) & np.isin(interfaces.pair, blocks).any(axis=1)):
        for block, sign in zip(interfaces.pair[k].tolist(), (1.0, -1.0), strict=True):
            if block in found:
                normal, far = sign * interfaces.frame[k, 0], float(reach[k])
                found[block] += [_Joint(normal, patch, far) for patch in patches_of(interfaces, int(k))]
    return found


def integrated(assembly: Assembly, faces: Iterable[Face], traction: Traction) -> PlacedForces:
    """Integrate a traction over parts of faces.

    Parameters
    ----------
    assembly
        The blocks.
    faces
        Where it acts.
    traction
        Linear in place on each face.

    Returns
    -------
    PlacedForces
        Forces at points of the faces, with the resultants and the moments of the traction.
    """
    blocks, points, forces = [np.empty(0, dtype=np.int64)], [np.empty((0, 3))], [np.empty((0, 3))]
    for face in faces:
        corners, area = _triangles(face)
        if not len(area):
            continue
        # The middles of the sides with a third of the area each: exact to degree two.
        points.append(((corners + np.roll(corners, -1, axis=1)) / 2).reshape(-1, 3))
        normal = np.broadcast_to(face.normal, points[-1].shape)
        forces.append(np.repeat(area / 3, 3)[:, None] * traction(points[-1], normal))
        blocks.append(np.full(len(points[-1]), face.block))
    return at_points(assembly, np.concatenate(blocks), np.concatenate(points), np.concatenate(forces))


def _triangles(face: Face) -> tuple[Floats, Floats]:
    """Triangles with signed areas that add up to a part of a face, shapes (n, 3, 3) [m] and (n,) [m2]."""
    corners, areas = [], []
    for ring, sign in rings(face.region):
        first, second = ring[:-1], ring[1:]
        apex = np.broadcast_to(ring[0], first.shape)
        one, two = first - apex, second - apex
        turn = 0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        areas.append(sign * np.sign(turn.sum()) * turn)
        corners.append(np.stack([apex, first, second], axis=1))
    if not corners:
        return np.empty((0, 3, 3)), np.empty(0)
    return face.origin + np.concatenate(corners) @ face.frame[1:], np.concatenate(areas)


def rings(region: Any) -> list[tuple[Floats, float]]:
    """Return the closed outlines of polygons and of their holes.

    Parameters
    ----------
    region : shapely geometry
        Polygon, polygons or a collection [m]; what has no area in it is left out.

    Returns
    -------
    list of (Floats, float)
        Corners, shape (n + 1, 2) [m], of which the last is the first, with 1.0 for an outline and -1.0 for a hole.
    """
    polygons = [part for part in getattr(region, "geoms", [region]) if part.geom_type == "Polygon" and part.area > 0]
    return [
        (np.asarray(ring.coords)[:, :2], sign)
        for polygon in polygons
        for sign, own in ((1.0, [polygon.exterior]), (-1.0, polygon.interiors))
        for ring in own
    ]
