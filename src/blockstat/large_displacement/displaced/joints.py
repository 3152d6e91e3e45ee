"""The joints of a displaced structure as interfaces: the closed contact points, each with its normal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.large_displacement.displaced.contact_pairs import (
    ContactPairs,
    edge_crossings,
    gap_normals,
    pair_points,
)
from blockstat.large_displacement.displaced.pose import Pose
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A joint whose two blocks are rotated against each other by less than this has stayed a plane joint [rad]. Chosen: far
#: above the rounding of rotations, far below any rotation of a step.
ROTATION_TOLERANCE = 1e-9
#: Columns of the normals that a contact point may have: those of `gap_normals`, and that of a joint that is still
#: plane.
CORNER_OF_A, CORNER_OF_B, CROSSING, PLANE_JOINT = range(4)


def displaced_interfaces(
    assembly: Assembly,
    interfaces: Interfaces,
    contacts: ContactPairs,
    closed: np.ndarray,
    pose: Pose,
    parameter: float,
) -> tuple[Interfaces, Ints]:
    """Return the joints at a pose: the closed contact points with their normals.

    Parameters
    ----------
    assembly
        The blocks at rest.
    interfaces
        Their joints at rest.
    contacts
        The pairs of points.
    closed
        The active set: which pairs are closed, shape (n,) bool.
    pose, parameter
        As in `pair_points`.

    Returns
    -------
    interfaces : Interfaces
        A joint whose points are all closed and whose blocks are not rotated against each other is one interface with
        the area of its contact at the pose. Any other joint has no area, and gives one interface for the corners of
        each block that touch the other, and one for each crossing of edges.
    contact : Ints
        The pair of each contact point of `interfaces`, shape (n_points,).
    """
    points = pair_points(assembly, contacts, pose, parameter)
    middle = edge_crossings(contacts, pose, points)[0].mean(axis=1)
    plane = _plane_joints(interfaces, contacts, closed, pose)
    normal, valid = gap_normals(contacts, pose, points)
    normal = np.concatenate([normal, normal[:, CORNER_OF_B : CORNER_OF_B + 1]], axis=1)
    in_plane = plane[contacts.joint]
    wanted = np.column_stack([valid & ~in_plane[:, None], in_plane]) & closed[:, None]
    point, kind = np.nonzero(wanted)
    crossing = np.where(kind == CROSSING, point, -1)  # each crossing has a normal of its own
    order = np.lexsort((crossing, kind, contacts.joint[point]))
    point, kind, crossing = point[order], kind[order], crossing[order]
    key = np.column_stack([contacts.joint[point], kind, crossing])
    start = np.flatnonzero(np.append(True, (np.diff(key, axis=0) != 0).any(axis=1))) if len(point) else np.empty(0, int)
    first = point[start]
    start = np.append(start, len(point))
    joint, whole = contacts.joint[first], kind[start[:-1]] == PLANE_JOINT
    along = np.einsum("nij,nkj->nki", pose.rotation[interfaces.pair[joint, 0]], interfaces.frame[joint, 1:])
    area, share = _areas(contacts.area[point], whole, start)
    return Interfaces(
        pair=interfaces.pair[joint],
        frame=_frames(normal[first, kind[start[:-1]]], along),
        area=area,
        gap=np.zeros(len(joint)),
        point=np.where((kind < CROSSING)[:, None], points[point, np.minimum(kind, 1)], middle[point]),
        start=start,
        share=share if assembly.joints else None,
        friction=contacts.friction[first],
    ), point


def _plane_joints(interfaces: Interfaces, contacts: ContactPairs, closed: np.ndarray, pose: Pose) -> np.ndarray:
    """Whether each joint at rest that has an area is still closed all over, shape (n_interfaces,) bool.

    The force of an edge or a corner that slides is at that, and not half-way to the place where it was.
    """
    a, b = interfaces.pair.T
    rotation = np.abs(pose.rotation[a] - pose.rotation[b]).max(axis=(1, 2))
    count = np.bincount(contacts.joint, minlength=interfaces.n_interfaces)
    still = np.bincount(contacts.joint[closed], minlength=interfaces.n_interfaces)
    found: np.ndarray = (still == count) & (rotation <= ROTATION_TOLERANCE) & (interfaces.area > 0)
    return found


def _areas(area: Floats, whole: np.ndarray, start: Ints) -> tuple[Floats, Floats]:
    """Areas of interfaces [m2], zero unless they are whole, and the share of each of their points."""
    count = np.diff(start)
    own = np.repeat(np.arange(len(count)), count)
    total = np.where(whole, np.bincount(own, area, len(count)), 0.0)
    share: Floats = np.where(total[own] > 0, area / np.where(total > 0, total, 1.0)[own], 1.0 / count[own])
    return total, share


def _frames(n: Floats, along: Floats) -> Floats:
    """Right-handed frames with normals n, shape (k, 3, 3).

    The first tangent is near the first of two unit vectors at right angles, shape (k, 2, 3). Where the normal has
    turned to within 45 degrees of that one, it is near the second one, which is then further from it than that.
    """
    cosine = np.einsum("ni,ni->n", along[:, 0], n)
    near = along[np.arange(len(n)), (np.abs(cosine) > np.sqrt(0.5)).astype(int)]
    t: Floats = near - np.einsum("ni,ni->n", near, n)[:, None] * n
    t = t / np.linalg.norm(t, axis=1)[:, None]
    frame: Floats = np.stack([n, t, np.cross(n, t)], axis=1)
    return frame
