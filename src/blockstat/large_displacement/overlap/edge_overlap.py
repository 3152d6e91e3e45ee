"""Contacts of edges and corners that slide: they carry where they are on the face, and no further.

A joint without area is an edge or a corner of one block on faces of the other, or an edge across an edge. Its gap is
measured from a plane, or between two lines, that have no end. So at each pose an edge is cut to the part that is above
the faces, a corner acts only above them, and a crossing only between the ends of both edges. Either side may be the one
that moves: a foot that reaches the rim of its bed, or a lintel whose end reaches the ridge that bears it. An end of the
part that is cut off is where the edge crosses the rim, and stays there as the blocks slide on.

Points are above a face that are on it when moved along the force: along the normal of the face or, where joints open by
friction times slip, along n - mu t.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from blockstat.large_displacement.displaced.contact_pairs import (
    CORNER_TOLERANCE,
    ContactPairs,
    concatenate,
    edge_crossings,
    gap_normals,
    pair_points,
)
from blockstat.large_displacement.displaced.pose import Pose, displaced_points, points_at_rest, side_sizes
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.typing import Floats, Ints

#: The slope of an outline across itself is zero where it is narrower than this. Relative to its length. Chosen: the
#: slope of an edge is that along it.
FLAT = 1e-6


class Cut(NamedTuple):
    """Contacts after those of edges and corners have been cut to where they touch."""

    contacts: ContactPairs
    row: Ints  #: of each contact the one that it was, or that it is next to on its edge, shape (n,)
    new: np.ndarray  #: whether it is at another place on its edge than that one, shape (n,) bool


class _Side(NamedTuple):
    """The outlines of one side of a joint at a pose."""

    block: int
    rest: list[Floats]  #: as of `FaceOutlines.sides`, moved into the middle of the joint's gap at rest [m]
    now: list[Floats]  #: displaced [m]


class _Joint(NamedTuple):
    """A joint without area at a pose."""

    rows: Ints  #: its contacts
    sides: tuple[_Side, _Side]
    frame: Floats  #: at rest, rows n, t1, t2
    tolerance: float  #: how far beyond a rim a point is still on the face [m]


def cut_to_faces(
    structure: Structure,
    contacts: ContactPairs,
    joints: Ints,
    pose: Pose,
    parameter: float,
    *,
    along: Floats | None = None,
) -> Cut:
    """Return the contacts without those parts of edges and corners that have left the faces they slide on.

    Parameters
    ----------
    structure
        The blocks and joints at rest.
    contacts
        The pairs of points.
    joints
        Numbers of the joints that have slid; those with an area are left as they are, shape (k,).
    pose, parameter
        The pose, and the movement of the supports [m].
    along
        Directions of the forces, of any magnitude, shape (n_interfaces, 3); None for those of the normals.

    Returns
    -------
    Cut
        The other contacts are the given ones, in their order; `contacts` itself where nothing has left its faces.
    """
    every = np.arange(contacts.number)
    chosen = np.intersect1d(joints[structure.interfaces.area[joints] <= 0], contacts.joint)
    if not len(chosen):
        return Cut(contacts, every, np.zeros(contacts.number, dtype=bool))
    points = pair_points(structure.assembly, contacts, pose, parameter)
    place = edge_crossings(contacts, pose, points)[0]
    normal, valid = gap_normals(contacts, pose, points)
    kept = np.flatnonzero(~np.isin(contacts.joint, chosen))
    parts, row, new = [contacts.select(kept)], [kept], [np.zeros(len(kept), dtype=bool)]
    for number in map(int, chosen):
        joint = _joint_at(structure, contacts, number, pose, parameter)
        edge = _edge_side(joint)
        force = None if along is None else along[number]
        if edge is None:
            part = _where_both_are(contacts, joint, pose, place, normal, valid, force)
        else:
            part = _cut_edge(structure, contacts, joint, edge, pose, parameter, points, force)
        for found, own in zip((parts, row, new), part, strict=True):
            found.append(own)  # type: ignore[arg-type]
    order = np.argsort(np.concatenate(row), kind="stable")
    cut = Cut(concatenate(parts).select(order), np.concatenate(row)[order], np.concatenate(new)[order])
    same = np.array_equal(cut.row, every) and not cut.new.any() and (cut.contacts.corner == contacts.corner).all()
    return Cut(contacts, every, cut.new) if same else cut


def _joint_at(structure: Structure, contacts: ContactPairs, number: int, pose: Pose, parameter: float) -> _Joint:
    """A joint with its outlines at a pose."""
    assembly, interfaces = structure.assembly, structure.interfaces
    rows, pair = np.flatnonzero(contacts.joint == number), interfaces.pair[number]
    sides = []
    frame = interfaces.frame[number]
    middle = interfaces.point[interfaces.start[number] : interfaces.start[number + 1]].mean(axis=0)
    for side, drawn in enumerate(structure.outlines.sides(number)):
        rest = [_closed(one, middle, frame) for one in drawn]
        drive, block = parameter * contacts.drive[rows[0], side], int(pair[side])
        now = [displaced_points(assembly, pose, np.full(len(one), block), one) + drive for one in rest]
        sides.append(_Side(block, rest, now))
    tolerance = CORNER_TOLERANCE * float(side_sizes(assembly, pair[None]).min())
    return _Joint(rows, (sides[0], sides[1]), frame, tolerance)


def _closed(outline: Floats, middle: Floats, frame: Floats) -> Floats:
    """An outline moved along the normal, so that it goes through the middle of a joint, where all points of rest are.

    A new point would be open by the gap otherwise, beside old ones that are not.
    """
    arm, centre = outline - outline.mean(axis=0), outline.mean(axis=0)
    slope = np.linalg.lstsq(arm @ frame[1:].T, arm @ frame[0], rcond=FLAT)[0]
    away = middle - centre
    moved: Floats = outline + (away @ frame[0] - away @ frame[1:].T @ slope) * frame[0]
    return moved


def _edge_side(joint: _Joint) -> int | None:
    """Which side of a joint is an edge on faces of the other; None where there is no such side."""
    corners = [max((len(one) for one in side.now), default=0) for side in joint.sides]
    return next((side for side in (0, 1) if corners[side] == 2 and corners[1 - side] > 2), None)


def _cut_edge(
    structure: Structure,
    contacts: ContactPairs,
    joint: _Joint,
    side: int,
    pose: Pose,
    parameter: float,
    points: Floats,
    force: Floats | None,
) -> Cut:
    """The contacts of an edge on faces: the ends of that part of it that is above them."""
    own, other = joint.sides[side], joint.sides[1 - side]
    frame = joint.frame @ pose.rotation[other.block].T
    direction = frame[0] if force is None else force
    drawn, ends = own.rest[0], own.now[0]
    line = ends[1] - ends[0]
    length = float(np.linalg.norm(line))
    spans = [_span(frame, direction, ends, face, joint.tolerance) for face in other.now]
    inside = [(k, *span) for k, span in enumerate(spans) if span[0] <= span[1]]
    if not inside:
        return Cut(contacts.select(joint.rows[:0]), joint.rows[:0], np.zeros(0, dtype=bool))
    first, last = min(inside, key=lambda one: one[1]), max(inside, key=lambda one: one[2])
    # A corner of the other block alone is known by its place on that block. Crossings are known by their material
    # points, so that where the edge has slid along itself across a rim, the point that is there now is taken.
    moves = np.where(contacts.corner[joint.rows, side] | ~contacts.corner[joint.rows].any(axis=1), side, 1 - side)
    known = (points[joint.rows, moves] - ends[0]) @ line / length**2
    parts, row, new = [], [], []
    for face, share, rim in ((first[0], first[1], first[3]), (last[0], last[2], last[4])):
        nearest = int(np.abs(known - share).argmin())
        row.append(int(joint.rows[nearest]))
        new.append(abs(known[nearest] - share) * length > joint.tolerance)
        part = contacts.select(np.array([row[-1]]))
        if new[-1]:
            spot = ends[0] + share * line
            plane = other.now[face][0]
            spot = spot - float((spot - plane) @ frame[0]) / float(direction @ frame[0]) * direction
            at_rest = points_at_rest(
                structure.assembly, pose, np.array([other.block]), (spot - parameter * part.drive[0, 1 - side])[None]
            )[0]
            part = _on_edge(part, side, drawn, share, at_rest, None if rim is None else (other.rest[face], rim))
        parts.append(part)
    count = 1 if row[0] == row[1] and not any(new) else 2  # a part as short as the tolerance may be one point
    return Cut(concatenate(parts[:count]), np.array(row[:count]), np.array(new[:count]))


def _on_edge(
    like: ContactPairs, side: int, ends: Floats, share: float, opposite: Floats, rim: tuple[Floats, int] | None
) -> ContactPairs:
    """A contact at a place on an edge: its end, or where it crosses a side of a face; `ends` and places at rest."""
    corner, anchor, edge = np.zeros((1, 2), dtype=bool), np.empty((1, 2, 3)), np.zeros((1, 2, 3))
    anchor[0, side], anchor[0, 1 - side] = ends[0] + share * (ends[1] - ends[0]), opposite
    if rim is None:
        corner[0, side] = True
    else:
        face, k = rim
        for own, tail, head in ((side, *ends), (1 - side, face[k - 1], face[k % len(face)])):
            edge[0, own] = (head - tail) / np.linalg.norm(head - tail)
    return replace(like, corner=corner, anchor=anchor, edge=edge)


def _span(
    frame: Floats, direction: Floats, ends: Floats, face: Floats, tolerance: float
) -> tuple[float, float, int | None, int | None]:
    """The part of an edge that is above a convex face, as shares of its length, and the sides of the face that cut it.

    The first share is larger than the last one where no part is. Side k ends in corner k; None where the edge ends.
    """
    flat = _flat(frame, direction, np.concatenate([ends, face]), face[0])
    (tail, head), outline = flat[:2], flat[2:]
    low, high, first, last = 0.0, 1.0, None, None
    for k in range(1, len(outline) + 1):
        along = outline[k % len(outline)] - outline[k - 1]
        width = float(np.linalg.norm(along))
        if not width > 0:
            continue
        inward = np.array([-along[1], along[0]]) / width
        begin, end = (float((point - outline[k - 1]) @ inward) for point in (tail, head))
        if min(begin, end) >= -tolerance:
            continue
        if max(begin, end) < -tolerance:
            return 1.0, 0.0, None, None
        share = float(np.clip(begin / (begin - end), 0.0, 1.0))
        if begin < end and share > low:
            low, first = share, k
        elif end < begin and share < high:
            high, last = share, k
    return low, high, first, last


def _flat(frame: Floats, direction: Floats, points: Floats, origin: Floats) -> Floats:
    """Points moved along a direction onto the plane of a frame, in that plane; shape (n, 2)."""
    arm = points - origin
    moved: Floats = arm - np.outer(arm @ frame[0] / float(direction @ frame[0]), direction)
    flat: Floats = moved @ frame[1:].T
    return flat


def _where_both_are(
    contacts: ContactPairs,
    joint: _Joint,
    pose: Pose,
    place: Floats,
    normal: Floats,
    valid: np.ndarray,
    force: Floats | None,
) -> Cut:
    """The contacts of corners on faces, and of edges that cross, at places that belong to both blocks.

    Where both blocks have a corner, each counts for as long as it is above the other block.
    """
    kept, corner = [], contacts.corner[joint.rows].copy()
    for k, row in enumerate(joint.rows):
        beside = {0: (1,), 1: (0,), 2: (0, 1)}
        acts = False
        for kind in np.flatnonzero(valid[row]).tolist():
            point = place[row, kind] if kind < 2 else place[row].mean(axis=0)
            direction = normal[row, kind] if force is None else force
            on = all(_is_on(joint, other, pose, point, direction) for other in beside[kind])
            acts |= on
            if kind < 2:
                corner[k, kind] = on
        kept.append(acts)
    own = np.flatnonzero(kept)
    part = replace(contacts.select(joint.rows), corner=corner).select(own)
    return Cut(part, joint.rows[own], np.zeros(len(own), dtype=bool))


def _is_on(joint: _Joint, side: int, pose: Pose, point: Floats, direction: Floats) -> bool:
    """Whether a point is above one side of a joint, or its outline is not known."""
    import shapely

    own = joint.sides[side]
    frame = joint.frame @ pose.rotation[own.block].T
    for outline in own.now:
        flat = _flat(frame, direction, np.concatenate([point[None], outline]), outline[0])
        shapes = (shapely.Point, shapely.LineString, shapely.Polygon)
        shape = shapes[min(len(outline), 3) - 1](flat[1:] if len(outline) > 1 else flat[1])
        if shapely.distance(shapely.Point(flat[0]), shape) <= joint.tolerance:
            return True
    return not own.now
