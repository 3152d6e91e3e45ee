"""Contact points of joints that slide: the corners of the overlap of the two faces at a pose.

Where the faces of a block are several convex polygons, each is overlapped with each one of the other block, and the
points are the corners of the hull of all overlaps. An edge of one face that slides along a notch of the other leaves an
arm there that is no wider than the places of the blocks are certain. It bears nothing, and the hull is without it.
"""

from __future__ import annotations

import numpy as np

from blockstat.contact.coplanar import corner_shares, shares_of_parts
from blockstat.contact.faces import opened, outline_hull
from blockstat.geometry.clipping import area, clip, corners
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE, ContactPairs, concatenate
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED
from blockstat.large_displacement.displaced.pose import Pose, displaced_points, points_at_rest, side_sizes
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.typing import Floats, Ints

#: An overlap of faces with fewer corners, those nearer to each other than `CORNER_TOLERANCE` being one, has no area.
AREA_CORNERS = 3
#: Gaps between the overlaps of a joint below this part of the width of an arm are rounding.
SEAM = 1e-3


def with_overlap_points(
    structure: Structure, contacts: ContactPairs, joints: Ints, pose: Pose, parameter: float
) -> ContactPairs:
    """Return the contacts with new points in some joints: the corners of the overlap of their faces.

    Parameters
    ----------
    structure
        The blocks and joints at rest.
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
    others = contacts.select(np.flatnonzero(~np.isin(contacts.joint, joints)))
    merged = concatenate([others, overlap_points(structure, contacts, joints, pose, parameter)])
    return merged.select(np.argsort(merged.joint, kind="stable"))


def overlap_points(
    structure: Structure,
    contacts: ContactPairs,
    joints: Ints,
    pose: Pose,
    parameter: float,
    *,
    along: Floats | None = None,
) -> ContactPairs:
    """Return the corners of the overlap of the two faces of joints, projected along the mean of their normals.

    Parameters
    ----------
    structure, contacts, joints, pose, parameter
        As in `with_overlap_points`.
    along
        Other directions of projection, of any magnitude, shape (n_interfaces, 3).

    Returns
    -------
    ContactPairs
        Joint by joint in the order of `joints`; none for joints whose faces do not overlap.
    """
    if not len(joints):
        return contacts.select(joints)
    assembly, interfaces = structure.assembly, structure.interfaces
    known, first = np.unique(contacts.joint, return_index=True)
    owner, faces = structure.outlines.of(joints)
    joint = joints[owner]
    first = first[np.searchsorted(known, joint)]
    pair, drive, at_rest = interfaces.pair[joint], contacts.drive[first], interfaces.frame[joint]
    turned = pose.rotation[pair] @ at_rest.transpose(0, 2, 1)[:, None]
    frame = _mean_frames(turned)
    normal = turned[..., 0]
    now = displaced_points(assembly, pose, np.repeat(pair, faces.shape[2]), faces.reshape(-1, 3)).reshape(faces.shape)
    now += parameter * drive[:, :, None]
    direction, plane = _projection(frame, frame[:, 0] if along is None else along[joint])
    outline = np.einsum("ksci,kti->ksct", now, plane)
    # A support is the window: its corners may be far away, and would take the last digits of those of the other block.
    row, cut = np.arange(len(pair)), assembly.support[pair[:, 0]].astype(int)
    polygon, count = clip(outline[row, cut], outline[row, 1 - cut])
    tolerance = CORNER_TOLERANCE * side_sizes(assembly, pair).min(axis=1)
    own, which = np.nonzero(corners(polygon, count, tolerance))
    certain = _certainty(structure, pose, parameter, owner, joint, drive, frame, tolerance)
    size = np.maximum(area(polygon, count), 0.0)
    kept, share = _corners_of_hulls(owner, own, polygon[own, which], size, tolerance, certain)
    own, which = own[kept], which[kept]
    point = polygon[own, which]
    flat = np.einsum("nt,nti->ni", point, frame[own, 1:])
    across, slope = direction[own], np.einsum("ki,ksi->ks", direction, normal)[own]
    height = np.einsum("nsi,nsi->ns", now[own, :, 0] - flat[:, None], normal[own]) / slope
    place = flat[:, None] + height[..., None] * across[:, None]
    distance = np.linalg.norm(point[:, None, None] - outline[own], axis=3).min(axis=2)
    corner = distance <= tolerance[own, None]
    edge = np.zeros((len(own), 2, 3))
    row = np.flatnonzero(~corner.any(axis=1))
    for side in (0, 1):
        along = _edge_directions(point[row], outline[own[row], side])
        line = np.einsum("nt,nti->ni", along, frame[own[row], 1:])
        line -= (np.einsum("ni,ni->n", line, normal[own[row], side]) / slope[row, side])[:, None] * across[row]
        line /= np.linalg.norm(line, axis=1)[:, None]
        edge[row, side] = np.einsum("nji,nj->ni", pose.rotation[pair[own[row], side]], line)
    material = place - parameter * drive[own]
    anchor = points_at_rest(assembly, pose, pair[own].reshape(-1), material.reshape(-1, 3)).reshape(place.shape)
    return ContactPairs(
        joint=joint[own],
        pair=pair[own],
        anchor=anchor,
        corner=corner,
        normal=at_rest[own, 0],
        friction=contacts.friction[first[own]],
        area=share,
        drive=drive[own],
        edge=edge,
    )


def _projection(frame: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Directions of projection, and vectors whose products with points do not change along them; (n, 3), (n, 2, 3)."""
    normal, tangents = frame[:, 0], frame[:, 1:]
    direction: Floats = along / np.einsum("ni,ni->n", along, normal)[:, None]
    plane: Floats = tangents - np.einsum("nti,ni->nt", tangents, direction)[..., None] * normal[:, None]
    return direction, plane


def _certainty(
    structure: Structure,
    pose: Pose,
    parameter: float,
    owner: Ints,
    joint: Ints,
    drive: Floats,
    frame: Floats,
    tolerance: Floats,
) -> Floats:
    """Scales of the planes of joints with several overlaps: what is less than 1 wide is less than their places are off.

    Along the way that a joint has slid, the place of a block is that of the path. Across it a motion is known to the
    speed below which contacts stick, and so is the place to that part of the way of the fastest corner. Shape
    (n, 2, 2), zero for joints of one overlap.
    """
    assembly, interfaces = structure.assembly, structure.interfaces
    scale = np.zeros((len(joint), 2, 2))
    several = np.flatnonzero(np.bincount(owner)[owner] > 1)
    if not len(several):
        return scale
    moved = displaced_points(assembly, pose, assembly.vertex_block, assembly.vertices) - assembly.vertices
    way = max(float(np.linalg.norm(moved, axis=1).max()), abs(parameter) * float(np.abs(drive).max(initial=0.0)))
    for row in several:
        points = interfaces.point[interfaces.start[joint[row]] : interfaces.start[joint[row] + 1]]
        one, two = (
            displaced_points(assembly, pose, np.full(len(points), block), points) + parameter * driven
            for block, driven in zip(interfaces.pair[joint[row]], drive[row], strict=True)
        )
        slip = frame[row, 1:] @ (two - one).mean(axis=0)
        length = float(np.linalg.norm(slip))
        along = slip / length if length > tolerance[row] else np.zeros(2)
        across = tolerance[row] + STICKING_SPEED * way
        scale[row] = np.eye(2) / across + np.outer(along, along) * (1 / tolerance[row] - 1 / across)
    return scale


def _beyond(overlaps: list[Floats]) -> np.ndarray:
    """Which corners of overlaps are those of arms that are less than 1 wide, and reach further than that."""
    import shapely

    polygons = [shapely.Polygon(overlap) for overlap in overlaps]
    thin = shapely.area(polygons) < shapely.minimum_bounding_radius(polygons) * 2
    points = np.concatenate(overlaps)
    if not thin.any() or thin.all():  # there is no arm, or nothing that it is an arm of
        return np.zeros(len(points), dtype=bool)
    wide = opened(shapely.union_all(shapely.buffer(polygons, SEAM, join_style="mitre")), 1.0)
    if wide.is_empty:
        return np.zeros(len(points), dtype=bool)
    away: np.ndarray = shapely.distance(shapely.points(points), wide.convex_hull) > 1.0
    return away


def _corners_of_hulls(
    owner: Ints, own: Ints, point: Floats, size: Floats, tolerance: Floats, certain: Floats
) -> tuple[Ints, Floats]:
    """Those corners of overlaps that are corners of the hull of all overlaps of their joint, without its arms.

    Parameters
    ----------
    owner
        Joint of each overlap, ascending, shape (n,).
    own
        Overlap of each corner, ascending, shape (k,).
    point
        Corners, those of a joint in one plane, shape (k, 2) [m].
    size
        Areas of the overlaps, shape (n,) [m2].
    tolerance
        Corners nearer to each other than this are one, shape (n,) [m].
    certain
        Scales of the planes of the overlaps, shape (n, 2, 2) [1/m], as of `_certainty`.

    Returns
    -------
    kept : Ints
        Numbers of corners, joint by joint.
    share : Floats
        The part of the area of the overlaps that each of them stands for [m2].
    """
    corner_count = np.bincount(own, minlength=len(owner))
    share = corner_shares(point, np.append(0, np.cumsum(corner_count))) * size[own]
    kept, joint = np.ones(len(own), dtype=bool), owner[own]
    parts: list[Ints] = []
    for several in np.flatnonzero(np.bincount(owner) > 1):
        mine = np.flatnonzero(joint == several)
        kept[mine] = False
        flat = mine[corner_count[own[mine]] >= AREA_CORNERS]
        if not len(flat):  # edges that touch, or nothing
            parts.append(mine[own[mine] == own[mine[:1]]])
            continue
        overlaps = np.unique(own[flat])
        flat = flat[~_beyond([point[flat[own[flat] == row]] @ certain[row] for row in overlaps])]
        hull = outline_hull(point[flat])
        hull = hull[corners(hull[None], np.array([len(hull)]), tolerance[own[flat[:1]]])[0]]
        chosen = flat[np.linalg.norm(hull[:, None] - point[flat], axis=2).argmin(axis=1)]
        overlaps = np.unique(own[flat])
        share[chosen] = shares_of_parts(hull, [point[own == row] for row in overlaps]) * size[overlaps].sum()
        parts.append(chosen)
    found = np.concatenate([np.flatnonzero(kept), *parts])
    found = found[np.argsort(joint[found], kind="stable")]
    return found, share[found]


def _mean_frames(turned: Floats) -> Floats:
    """The rotations nearest to sums of two, by their singular value decompositions; rows n, t1, t2."""
    left, _, right = np.linalg.svd(turned.sum(axis=1))
    frames: Floats = (left @ right).transpose(0, 2, 1)
    return frames


def _edge_directions(point: Floats, outline: Floats) -> Floats:
    """Unit vectors along the sides of outlines that are nearest to points, shape (n, 2)."""
    line = np.roll(outline, -1, axis=1) - outline
    length = np.linalg.norm(line, axis=2)
    unit = line / np.where(length > 0, length, 1.0)[..., None]
    off = point[:, None] - outline
    distance = np.abs(off[..., 0] * unit[..., 1] - off[..., 1] * unit[..., 0])
    distance[length == 0] = np.inf  # a corner that is repeated has no side
    found: Floats = unit[np.arange(len(point)), np.argmin(distance, axis=1)]
    return found
