"""Joints that slide: their contact points at a pose are the corners of what the two faces have in common there."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.contact.faces import outline_hull
from blockstat.contact.interfaces import Interfaces
from blockstat.geometry.clipping import clip, corners
from blockstat.large_displacement.contacts import CORNER, Contacts, gaps, sides
from blockstat.large_displacement.jump import SHUT, statuses
from blockstat.large_displacement.linkage import Linkage
from blockstat.large_displacement.pose import Pose, displaced, origins, places
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

NAMES = tuple(field.name for field in fields(Contacts))
#: Faces of a block lie in a joint when their normals are within this sine of the joint's.
IN_JOINT = 0.05
#: How far ahead it is looked, which of two corners stays above a face, relative to the size of the blocks: further than
#: a point is near to a corner.
AHEAD = 100 * CORNER


def renewed(linkage: Linkage, interfaces: Interfaces, pose: Pose, parameter: float, motion: Floats) -> Linkage:
    """Return a linkage with new contact points in the joints that slide.

    Parameters
    ----------
    linkage
        The linkage.
    interfaces
        The joints at rest.
    pose, parameter
        Where it is.
    motion
        How it moves, shape (n_blocks, 6).

    Returns
    -------
    Linkage
        The same one where nothing slides, or only edges and corners do.
    """
    contacts = linkage.contacts
    joints = np.unique(contacts.joint[linkage.sliding])
    joints = joints[interfaces.area[joints] > 0]
    if not len(joints):
        return linkage
    kept = ~np.isin(contacts.joint, joints)
    parts = [taken(contacts, np.flatnonzero(kept))]
    parts += [_clipped(linkage.assembly, interfaces, contacts, int(k), pose, parameter) for k in joints]
    merged = _joined(parts)
    fresh = np.arange(merged.number) >= kept.sum()
    room = 1e3 * SHUT * float(linkage.assembly.size.max())
    gap = np.where(fresh, gaps(linkage.assembly, merged, pose, parameter), np.inf)
    # A joint that dilates is open and carries where it is least so.
    near = gap <= room + (max(float(gap.min(initial=np.inf)), 0.0) if linkage.dilates else 0.0)
    whole = [np.concatenate([mask[kept], np.zeros(fresh.sum(), bool)]) for mask in (linkage.pinned, linkage.sliding)]
    touching = replace(linkage, contacts=merged, pinned=whole[0] | near, sliding=whole[1])
    drive = 1.0 if linkage.control is None else 0.0
    pinned, sliding = statuses(touching, pose, parameter, motion, drive, dilates=linkage.dilates)
    found = replace(linkage, contacts=merged, pinned=whole[0] | (pinned & fresh), sliding=whole[1] | (sliding & fresh))
    both = found.sliding & merged.corner.all(axis=1) & fresh
    return _one_sided(found, interfaces, pose, parameter, motion, both) if both.any() else found


def _one_sided(
    linkage: Linkage, interfaces: Interfaces, pose: Pose, parameter: float, motion: Floats, rows: np.ndarray
) -> Linkage:
    """The linkage with contacts of two corners that slide apart as contacts of the one that stays above a face.

    Which one that is shows a little further on.
    """
    assembly, contacts = linkage.assembly, linkage.contacts
    speed = float(corner_speed(displaced(assembly, pose), motion).max(initial=0.0))
    if linkage.control is None:
        speed = max(speed, float(np.linalg.norm(contacts.drive, axis=2).max()))
    if not speed:
        return linkage
    length = AHEAD * float(assembly.size.max()) / speed
    there = linkage.shifted(pose, length * linkage.of_bodies(motion), linkage.origins(pose))
    after = parameter + length * (linkage.control is None)
    corner = contacts.corner.copy()
    now = sides(assembly, contacts, pose, parameter).mean(axis=1)
    for joint in np.unique(contacts.joint[rows]):
        ahead = _clipped(assembly, interfaces, contacts, int(joint), there, after)
        if not ahead.number:
            continue
        place = sides(assembly, ahead, there, after).mean(axis=1)
        own = np.flatnonzero(rows & (contacts.joint == joint))
        distance = np.linalg.norm(now[own, None] - place, axis=2)
        next_ = distance.argmin(axis=1)
        near = (distance.min(axis=1) <= 2 * length * speed) & ahead.corner[next_].any(axis=1)
        corner[own[near]] = ahead.corner[next_[near]]
    return replace(linkage, contacts=replace(contacts, corner=corner))


def clipped_again(
    assembly: Assembly, interfaces: Interfaces, contacts: Contacts, joints: Ints, pose: Pose, parameter: float
) -> Contacts:
    """Return the contacts with new points in some joints: the corners of what their faces have in common at a pose.

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
        Where the blocks are, and the movement of the supports.

    Returns
    -------
    Contacts
        In the order of the joints.
    """
    parts = [taken(contacts, np.flatnonzero(~np.isin(contacts.joint, joints)))]
    merged = _joined(parts + [_clipped(assembly, interfaces, contacts, int(k), pose, parameter) for k in joints])
    return taken(merged, np.argsort(merged.joint, kind="stable"))


def taken(contacts: Contacts, rows: Ints) -> Contacts:
    """Return some of the contacts.

    Parameters
    ----------
    contacts
        All of them.
    rows
        Which, shape (k,).

    Returns
    -------
    Contacts
        In the order of the rows.
    """
    return Contacts(**{name: getattr(contacts, name)[rows] for name in NAMES})


def _joined(parts: list[Contacts]) -> Contacts:
    return Contacts(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in NAMES})


def _clipped(
    assembly: Assembly, interfaces: Interfaces, contacts: Contacts, joint: int, pose: Pose, parameter: float
) -> Contacts:
    """The corners of what the faces of one joint have in common, seen along the mean of their normals."""
    pair = interfaces.pair[joint]
    first = int(np.flatnonzero(contacts.joint == joint)[0])
    drive = contacts.drive[first]
    turned = pose.rotation[pair] @ interfaces.frame[joint].T
    frame = np.linalg.svd(turned.sum(axis=0))
    frame = (frame[0] @ frame[2]).T  # the rotation next to the mean
    outlines, solid = [], []
    for side in (0, 1):
        corner = _footprint(assembly, interfaces, joint, side)
        now = places(assembly, pose, np.full(len(corner), pair[side]), corner) + parameter * drive[side]
        hull = outline_hull((now - now[0]) @ frame[1:].T) + now[0] @ frame[1:].T
        outlines.append(hull)
        solid.append(now)
    polygon, count = clip(outlines[0][None], outlines[1][None])
    room = CORNER * float(assembly.size[pair].min())
    point = polygon[0][corners(polygon, count, np.array([room]))[0]]
    n = len(point)
    lifted = [_lifted(point, frame, solid[side], turned[side][:, 0]) for side in (0, 1)]
    place = np.stack(lifted, axis=1)
    corner = np.stack([_near(point, outline) <= room for outline in outlines], axis=1)
    edge = np.zeros((n, 2, 3))
    for row in np.flatnonzero(~corner.any(axis=1)):
        for side in (0, 1):
            flat = _edge_at(point[row], outlines[side])
            line = flat @ frame[1:]
            normal = turned[side][:, 0]
            line = line - (line @ normal) / (frame[0] @ normal) * frame[0]
            edge[row, side] = pose.rotation[pair[side]].T @ (line / np.linalg.norm(line))
    anchor = np.stack(
        [origins(assembly, pose, np.full(n, pair[k]), place[:, k] - parameter * drive[k]) for k in (0, 1)], axis=1
    )
    return Contacts(
        joint=np.full(n, joint),
        pair=np.tile(pair, (n, 1)),
        anchor=anchor,
        corner=corner,
        normal=np.tile(interfaces.frame[joint, 0], (n, 1)),
        friction=np.full(n, contacts.friction[first]),
        drive=np.tile(drive, (n, 1, 1)),
        edge=edge,
    )


def _footprint(assembly: Assembly, interfaces: Interfaces, joint: int, side: int) -> Floats:
    """Corners at rest of the faces of a block that lie in a joint, shape (k, 3)."""
    block, normal = int(interfaces.pair[joint, side]), interfaces.frame[joint, 0]
    points = interfaces.point[interfaces.start[joint] : interfaces.start[joint + 1]]
    faces = np.flatnonzero(assembly.face_block == block)
    outward = 1.0 if side == 0 else -1.0
    facing = outward * (assembly.planes.normal[faces] @ normal) > np.sqrt(1 - IN_JOINT**2)
    height = np.abs((assembly.planes.centre[faces] - points.mean(axis=0)) @ normal)
    room = float(interfaces.gap[joint]) + 1e-3 * float(assembly.size[block])
    rows = faces[facing & (height <= room)]
    if not len(rows):
        return points
    own = np.concatenate([assembly.face_vertices[assembly.face_start[f] : assembly.face_start[f + 1]] for f in rows])
    found: Floats = assembly.vertices[np.unique(own)]
    return found


def _lifted(point: Floats, frame: Floats, solid: Floats, normal: Floats) -> Floats:
    """Points seen along frame[0] on the plane through the solid's first corner, shape (n, 3)."""
    flat = point @ frame[1:]
    height = ((solid[0] - flat) @ normal) / (frame[0] @ normal)
    lifted: Floats = flat + height[:, None] * frame[0]
    return lifted


def _near(point: Floats, outline: Floats) -> Floats:
    """Distance of points to the nearest corner of an outline."""
    distance: Floats = np.linalg.norm(point[:, None] - outline, axis=2).min(axis=1)
    return distance


def _edge_at(point: Floats, outline: Floats) -> Floats:
    """Direction of the side of an outline that a point is nearest to."""
    line = np.roll(outline, -1, axis=0) - outline
    unit = line / np.linalg.norm(line, axis=1)[:, None]
    off = point - outline
    distance = np.abs(off[:, 0] * unit[:, 1] - off[:, 1] * unit[:, 0])
    found: Floats = unit[np.argmin(distance)]
    return found
