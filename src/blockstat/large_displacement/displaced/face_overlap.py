"""Contact points of joints that slide: the corners of the overlap of the two faces at a pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.faces import outline_hull
from blockstat.contact.interfaces import Interfaces
from blockstat.geometry.clipping import clip, corners
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE, ContactPairs, concatenate
from blockstat.large_displacement.displaced.pose import Pose, displaced_points, points_at_rest
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Faces of a block belong to a joint when the sine of the angle between the normals is below this. Chosen: faces of one
#: joint are nearly parallel, and other faces of a block stand at an angle to it.
SAME_FACE_SINE = 0.05
#: Faces of a block belong to a joint when they are within this distance of it, beside the joint's gap at rest. Relative
#: to the block's size. Chosen: parallel faces of a block are further apart.
SAME_FACE_DISTANCE = 1e-3


def with_overlap_points(
    assembly: Assembly, interfaces: Interfaces, contacts: ContactPairs, joints: Ints, pose: Pose, parameter: float
) -> ContactPairs:
    """Return the contacts with new points in some joints: the corners of the overlap of their faces.

    Parameters
    ----------
    assembly
        The blocks at rest.
    interfaces
        Their joints at rest.
    contacts
        The pairs of points.
    joints
        Numbers of the joints, shape (k,); each has a pair of points and an area.
    pose, parameter
        The pose, and the movement of the supports [m].

    Returns
    -------
    ContactPairs
        Sorted by joint.
    """
    parts = [contacts.select(np.flatnonzero(~np.isin(contacts.joint, joints)))]
    parts += [overlap_points(assembly, interfaces, contacts, int(k), pose, parameter) for k in joints]
    merged = concatenate(parts)
    return merged.select(np.argsort(merged.joint, kind="stable"))


def overlap_points(
    assembly: Assembly, interfaces: Interfaces, contacts: ContactPairs, joint: int, pose: Pose, parameter: float
) -> ContactPairs:
    """Return the corners of the overlap of the two faces of a joint, projected along the mean of their normals.

    Parameters
    ----------
    assembly, interfaces, contacts, pose, parameter
        As in `with_overlap_points`.
    joint
        Number of the joint; it has a pair of points and an area.

    Returns
    -------
    ContactPairs
        Empty where the faces do not overlap.
    """
    pair = interfaces.pair[joint]
    first = int(np.flatnonzero(contacts.joint == joint)[0])
    drive = contacts.drive[first]
    turned = pose.rotation[pair] @ interfaces.frame[joint].T
    frame = _mean_frame(turned)
    outlines, faces = [], []
    for side in (0, 1):
        corner = _face_corners(assembly, interfaces, joint, side)
        now = displaced_points(assembly, pose, np.full(len(corner), pair[side]), corner) + parameter * drive[side]
        hull = outline_hull((now - now[0]) @ frame[1:].T) + now[0] @ frame[1:].T
        outlines.append(hull)
        faces.append(now)
    polygon, count = clip(outlines[0][None], outlines[1][None])
    tolerance = CORNER_TOLERANCE * float(assembly.size[pair].min())
    point = polygon[0][corners(polygon, count, np.array([tolerance]))[0]]
    n = len(point)
    place = np.stack([_on_plane(point, frame, faces[side], turned[side][:, 0]) for side in (0, 1)], axis=1)
    corner = np.stack([_distance_to_corner(point, outline) <= tolerance for outline in outlines], axis=1)
    edge = np.zeros((n, 2, 3))
    for row in np.flatnonzero(~corner.any(axis=1)):
        for side in (0, 1):
            line = _edge_direction(point[row], outlines[side]) @ frame[1:]
            normal = turned[side][:, 0]
            line = line - (line @ normal) / (frame[0] @ normal) * frame[0]
            edge[row, side] = pose.rotation[pair[side]].T @ (line / np.linalg.norm(line))
    anchor = np.stack(
        [points_at_rest(assembly, pose, np.full(n, pair[k]), place[:, k] - parameter * drive[k]) for k in (0, 1)],
        axis=1,
    )
    return ContactPairs(
        joint=np.full(n, joint),
        pair=np.tile(pair, (n, 1)),
        anchor=anchor,
        corner=corner,
        normal=np.tile(interfaces.frame[joint, 0], (n, 1)),
        friction=np.full(n, contacts.friction[first]),
        drive=np.tile(drive, (n, 1, 1)),
        edge=edge,
    )


def _mean_frame(turned: Floats) -> Floats:
    """The rotation nearest to the sum of two, by its singular value decomposition; rows n, t1, t2."""
    left, _, right = np.linalg.svd(turned.sum(axis=0))
    frame: Floats = (left @ right).T
    return frame


def _face_corners(assembly: Assembly, interfaces: Interfaces, joint: int, side: int) -> Floats:
    """Corners at rest of those faces of a block that lie in a joint, shape (k, 3) [m]."""
    block, normal = int(interfaces.pair[joint, side]), interfaces.frame[joint, 0]
    points = interfaces.point[interfaces.start[joint] : interfaces.start[joint + 1]]
    faces = np.flatnonzero(assembly.face_block == block)
    outward = 1.0 if side == 0 else -1.0
    facing = outward * (assembly.planes.normal[faces] @ normal) > np.sqrt(1 - SAME_FACE_SINE**2)
    height = np.abs((assembly.planes.centre[faces] - points.mean(axis=0)) @ normal)
    distance = float(interfaces.gap[joint]) + SAME_FACE_DISTANCE * float(assembly.size[block])
    rows = faces[facing & (height <= distance)]
    if not len(rows):
        return points
    own = np.concatenate([assembly.face_vertices[assembly.face_start[f] : assembly.face_start[f + 1]] for f in rows])
    found: Floats = assembly.vertices[np.unique(own)]
    return found


def _on_plane(point: Floats, frame: Floats, face: Floats, normal: Floats) -> Floats:
    """Points given in the plane of frame[1:], projected along frame[0] onto the plane of a face, shape (n, 3) [m]."""
    flat = point @ frame[1:]
    height = ((face[0] - flat) @ normal) / (frame[0] @ normal)
    projected: Floats = flat + height[:, None] * frame[0]
    return projected


def _distance_to_corner(point: Floats, outline: Floats) -> Floats:
    """Distance of points to the nearest corner of an outline, shape (n,) [m]."""
    distance: Floats = np.linalg.norm(point[:, None] - outline, axis=2).min(axis=1)
    return distance


def _edge_direction(point: Floats, outline: Floats) -> Floats:
    """Unit vector along the side of an outline that is nearest to a point, shape (2,)."""
    line = np.roll(outline, -1, axis=0) - outline
    unit = line / np.linalg.norm(line, axis=1)[:, None]
    off = point - outline
    distance = np.abs(off[:, 0] * unit[:, 1] - off[:, 1] * unit[:, 0])
    found: Floats = unit[np.argmin(distance)]
    return found
