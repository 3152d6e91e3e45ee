"""Contact points of a linkage whose joints slide: at each pose the corners of the overlap of the two faces.

Edges and corners that slide on a face keep their points as far as these are still on it (`overlap.edge_overlap`).

With associated flow a joint is open by a distance g once it has slid, and its two faces are no longer at one place. A
contact that slides along the unit vector t presses along n - mu t. Its force meets one face at p and the other one at

    q = p + g (n - mu t),

and it acts on the blocks only if p lies in the one face and q in the other. So the faces overlap along n - mu t and not
along n, and the moment of the force is that at p, at q or anywhere between. Points of a and of b that lie straight
above each other would leave an arm of mu g to choice: that of the corner, of the middle of two crossing edges or of the
middle of a joint that has not turned, as rounding has it. The contact point is in the middle between p and q, also
where a block begins to turn about it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_pairs import (
    CORNER_TOLERANCE,
    JUST_CLOSED_GAP,
    ZERO_GAP,
    ContactPairs,
    concatenate,
    gap_normals,
    gaps,
    pair_points,
)
from blockstat.large_displacement.displaced.contact_status import contact_status
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, free_sizes, points_at_rest
from blockstat.large_displacement.linkage.kinematics import slip_friction
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.overlap.edge_overlap import cut_to_faces
from blockstat.large_displacement.overlap.face_overlap import AREA_CORNERS, overlap_points
from blockstat.typing import Floats, Ints

#: With associated flow, new contact points that are open by no more than this beside the least open one are closed.
#: Relative to the largest free block. Chosen: a thousand times `ZERO_GAP`, as no equations hold their gaps.
OPENED_GAP = 1e3 * ZERO_GAP
#: How far a linkage moves on where two corners coincide, to see which of them stays above a face. Relative to the
#: largest free block. Chosen: a hundred times the distance within which a point is a corner.
LOOK_AHEAD = 100 * CORNER_TOLERANCE


def with_new_sliding_contacts(linkage: Linkage, pose: Pose, parameter: float, motion: Floats) -> Linkage:
    """Return a linkage with new contact points in the joints that slide.

    Parameters
    ----------
    linkage
        The linkage.
    pose, parameter
        Where it is.
    motion
        How it moves, shape (n_blocks, 6).

    Returns
    -------
    Linkage
        The given one where nothing slides.
    """
    joints = np.unique(linkage.contacts.joint[linkage.sliding])
    if not len(joints):
        return linkage
    along = _directions_of_forces(linkage, pose, parameter, motion)
    linkage = _with_edges_on_faces(linkage, joints, pose, parameter, along)
    contacts = linkage.contacts
    joints = joints[linkage.structure.interfaces.area[joints] > 0]
    if not len(joints):
        return linkage
    kept = ~np.isin(contacts.joint, joints)
    found = _with_bearing(overlap_points(linkage.structure, contacts, joints, pose, parameter, along=along))
    merged = concatenate([contacts.select(np.flatnonzero(kept)), found])
    new = np.arange(merged.number) >= kept.sum()
    gap = np.where(new, gaps(linkage.assembly, merged, pose, parameter), np.inf)
    # Faces tilted by t touch in a line. Where it is the rim of one, the edge of the other is open by t times what is
    # left of the bearing. It counts as closed, with the normal of the other face, where that is below 1e-8 / t of the
    # size. With t above .01 the bearing is lost by then (`CORNER_TOLERANCE`); with less, both normals are alike.
    size, open_by = float(free_sizes(linkage.assembly).max()), JUST_CLOSED_GAP
    least = 0.0
    if linkage.associated:  # a joint that has slid is open, and has lost its strength; it bears where it is least open
        least, open_by = max(float(gap.min(initial=np.inf)), 0.0), OPENED_GAP
        merged = replace(merged, area=np.where(new & (merged.friction > 0), 0.0, merged.area))
    near = gap <= open_by * size + linkage.flaw_of_gaps + least
    if linkage.associated:
        merged = _joined_in_the_middle(linkage, merged, np.flatnonzero(near), pose, parameter)
    was_sticking, was_sliding = (
        np.concatenate([mask[kept], np.zeros(new.sum(), bool)]) for mask in (linkage.sticking, linkage.sliding)
    )
    touching = replace(linkage, contacts=merged, sticking=was_sticking | near, sliding=was_sliding)
    support_rate = 1.0 if linkage.control is None else 0.0
    here = touching.configuration(pose, parameter)
    sticking, sliding = contact_status(here, motion, support_rate, associated=linkage.associated)
    renewed = replace(touching, sticking=was_sticking | (sticking & new), sliding=was_sliding | (sliding & new))
    two_corners = renewed.sliding & merged.corner.all(axis=1) & new
    return _one_sided(renewed, pose, parameter, motion, two_corners) if two_corners.any() else renewed


def _with_edges_on_faces(linkage: Linkage, joints: Ints, pose: Pose, parameter: float, along: Floats | None) -> Linkage:
    """The linkage without what has left its faces of the edges and corners that slide.

    What is left of an edge slides, sticks or is open as the nearest of its ends before. But an end that has moved on
    the edge does not stick: the edge has slid across the rim there.
    """
    contacts, row, new = cut_to_faces(linkage.structure, linkage.contacts, joints, pose, parameter, along=along)
    if contacts is linkage.contacts:
        return linkage
    closed = linkage.closed[row]
    sticking = linkage.sticking[row] & ~new
    return replace(linkage, contacts=contacts, sticking=sticking, sliding=closed & ~sticking)


def _with_bearing(found: ContactPairs) -> ContactPairs:
    """The corners of those overlaps that have an area.

    A block whose edge has come to the rim of its bed has left it. Forces between the two edges may balance the loads
    there, but the rim is then a knife edge without width: which way it holds is a matter of rounding.
    """
    return found.select(np.flatnonzero(np.bincount(found.joint)[found.joint] >= AREA_CORNERS))


def _directions_of_forces(linkage: Linkage, pose: Pose, parameter: float, motion: Floats) -> Floats | None:
    """The directions n - mu t of the forces of joints that slide, shape (n_interfaces, 3); None without dilatancy.

    Where a block turns about the normal, the forces have no one direction, and t is the mean of those of the slip. On a
    block that leans n is the normal of the face on which it slides, and not the mean of both.
    """
    if not linkage.associated:
        return None
    contacts, found = linkage.contacts, np.zeros((linkage.structure.interfaces.n_interfaces, 3))
    rows = np.flatnonzero(linkage.sliding)
    points = pair_points(linkage.assembly, contacts, pose, parameter)
    normal, valid = gap_normals(contacts, pose, points)
    across = normal[rows, np.argmax(valid[rows], axis=1)]
    slip = slip_friction(linkage, pose, rows, points[rows].mean(axis=1), across, motion)
    np.add.at(found, contacts.joint[rows], across - slip)
    return found


def _joined_in_the_middle(
    linkage: Linkage, contacts: ContactPairs, rows: Ints, pose: Pose, parameter: float
) -> ContactPairs:
    """The contacts with both points of some of them in the middle between the two."""
    middle = pair_points(linkage.assembly, contacts, pose, parameter)[rows].mean(axis=1)
    anchor = contacts.anchor.copy()
    for side in (0, 1):
        place = middle - parameter * contacts.drive[rows, side]
        anchor[rows, side] = points_at_rest(linkage.assembly, pose, contacts.pair[rows, side], place)
    return replace(contacts, anchor=anchor)


def _one_sided(linkage: Linkage, pose: Pose, parameter: float, motion: Floats, rows: np.ndarray) -> Linkage:
    """The linkage with contacts of two corners that slide apart as contacts of the corner that stays above a face.

    The overlap of the faces at a pose a little further on shows which corner that is.
    """
    assembly, contacts = linkage.assembly, linkage.contacts
    speed = float(corner_speed(displaced_assembly(assembly, pose), motion).max(initial=0.0))
    if linkage.control is None:
        speed = max(speed, float(np.linalg.norm(contacts.drive, axis=2).max()))
    if not speed:
        return linkage
    length = LOOK_AHEAD * float(free_sizes(assembly).max()) / speed
    there = linkage.moved(pose, length * linkage.body_motions(motion), linkage.origins(pose))
    after = parameter + length * (linkage.control is None)
    corner = contacts.corner.copy()
    now = pair_points(assembly, contacts, pose, parameter).mean(axis=1)
    joints = np.unique(contacts.joint[rows])
    along = _directions_of_forces(linkage, there, after, motion)
    all_ahead = overlap_points(linkage.structure, contacts, joints, there, after, along=along)
    for joint in np.unique(all_ahead.joint):
        ahead = all_ahead.select(np.flatnonzero(all_ahead.joint == joint))
        place = pair_points(assembly, ahead, there, after).mean(axis=1)
        own = np.flatnonzero(rows & (contacts.joint == joint))
        distance = np.linalg.norm(now[own, None] - place, axis=2)
        next_ = distance.argmin(axis=1)
        near = (distance.min(axis=1) <= 2 * length * speed) & ahead.corner[next_].any(axis=1)
        corner[own[near]] = ahead.corner[next_[near]]
    return replace(linkage, contacts=replace(contacts, corner=corner))
