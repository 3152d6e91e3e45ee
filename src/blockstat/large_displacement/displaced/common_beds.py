"""Joints of two blocks that are drawn in several planes where one is meant: the triangles of a bed, rounded in a file.

Two planes that are nearly one leave a block that slides their line of intersection alone, which is anywhere, and forces
that flip with the last digits of a pose. At rest that is within what their corners are off by. On a path it is not.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.coplanar import Patches, joints_of_patches
from blockstat.contact.faces import frames, outline_hull
from blockstat.contact.interfaces import Interfaces
from blockstat.large_displacement.displaced.face_outlines import SAME_FACE_DISTANCE, SAME_FACE_SINE
from blockstat.large_displacement.displaced.pose import side_sizes
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True)
class _Plane:
    """A plane that several joints of two blocks share."""

    joints: Ints  #: their numbers, the one with the largest area first
    frame: Floats  #: shape (3, 3), rows n, t1, t2
    centre: Floats  #: centroid of the joints, shape (3,) [m]

    def flat(self, points: Floats) -> Floats:
        """Points along t1 and t2 from the centre, shape (n, 2) [m]."""
        found: Floats = (points - self.centre) @ self.frame[1:].T
        return found


def in_common_planes(assembly: Assembly, interfaces: Interfaces) -> Interfaces:
    """Return the joints, with those of two blocks that are meant to lie in one plane as one joint.

    Parameters
    ----------
    assembly
        The blocks at rest.
    interfaces
        Their joints as found.

    Returns
    -------
    Interfaces
        The same object where no joints are merged. A joint of several has the mean of their normals by area, their
        convex hull in that plane, and the sum of their areas.

    Notes
    -----
    What is meant to be one plane is judged as for the faces of a joint (`FaceOutlines`): by their normals, and by the
    distance `SAME_FACE_DISTANCE` of corners from the mean plane. How open the joint is allows no more. Planes that are
    parallel are a step, however low: a corner may be off by no more than the tilts of the planes about their common
    centroid explain. Joints that are divided into cells, or have a friction of their own, stay as they are.
    """
    plain = interfaces.outlines is None and interfaces.share is None and interfaces.friction is None
    rows: defaultdict[tuple[int, ...], list[int]] = defaultdict(list)
    for k, pair in enumerate(interfaces.pair.tolist() if plain else []):
        rows[tuple(pair)].append(k)
    several = [np.array(own) for own in rows.values() if np.count_nonzero(interfaces.area[own] > 0) > 1]
    shared = [plane for own in several for plane in _planes(assembly, interfaces, own)]
    return _merged(interfaces, shared) if shared else interfaces


def _planes(assembly: Assembly, interfaces: Interfaces, rest: Ints) -> Iterator[_Plane]:
    """The planes that joints of two blocks share, from that of the largest joint on."""
    within = SAME_FACE_DISTANCE * float(side_sizes(assembly, interfaces.pair[rest[:1]]).min())
    rest = rest[np.argsort(-interfaces.area[rest], kind="stable")]
    while len(rest) > 1 and interfaces.area[rest[1]] > 0:
        seed, normal = rest[0], interfaces.frame[rest, 0]
        origin = interfaces.outline(int(seed)).mean(axis=0)
        height = np.array([np.abs((interfaces.outline(int(k)) - origin) @ normal[0]).max() for k in rest])
        near = (np.linalg.norm(np.cross(normal, normal[0]), axis=1) < SAME_FACE_SINE) & (normal @ normal[0] > 0)
        near[0] = True
        order = np.flatnonzero(near)[np.argsort(height[near], kind="stable")]
        own = np.append(seed, rest[order[order != 0]])
        while len(own) > 1:  # what is furthest from the plane of the first is the first to be in another one
            plane = _mean_plane(interfaces, own, within)
            if plane is not None:
                yield plane
                break
            own = own[:-1]
        rest = rest[~np.isin(rest, own)]


def _mean_plane(interfaces: Interfaces, own: Ints, within: float) -> _Plane | None:
    """The mean plane of joints by area; None where they do not lie in it."""
    points = [interfaces.outline(int(k)) for k in own]
    area, normals = interfaces.area[own], interfaces.frame[own, 0]
    origin = points[0][0]
    centre = origin + area @ np.array([(corners - origin).mean(axis=0) for corners in points]) / area.sum()
    normal = area @ normals
    normal = normal / np.linalg.norm(normal)
    arm = np.concatenate(points) - centre
    sine = np.linalg.norm(np.cross(normals[area > 0], normal), axis=1).max()
    tilted = float(sine * np.linalg.norm(arm, axis=1).max())
    if np.abs(arm @ normal).max() > min(within, tilted):
        return None
    return _Plane(own, frames(normal[None])[0], centre)


def _merged(interfaces: Interfaces, shared: list[_Plane]) -> Interfaces:
    """The joints, with those of each plane in the place of its largest."""
    corners = [interfaces.outline(k) for k in range(interfaces.n_interfaces)]
    frame, area, gap = interfaces.frame.copy(), interfaces.area.copy(), interfaces.gap.copy()
    kept = np.ones(interfaces.n_interfaces, dtype=bool)
    for plane in shared:
        first, own = plane.joints[0], plane.joints
        hull = outline_hull(plane.flat(np.concatenate([corners[k] for k in own])))
        corners[first] = plane.centre + hull @ plane.frame[1:]
        frame[first], area[first], gap[first] = plane.frame, area[own].sum(), gap[own].max()
        kept[own[1:]] = False
    rows = np.flatnonzero(kept)
    return replace(
        interfaces,
        pair=interfaces.pair[rows],
        frame=frame[rows],
        area=area[rows],
        gap=gap[rows],
        point=np.concatenate([corners[k] for k in rows]),
        start=np.cumsum([0, *(len(corners[k]) for k in rows)]),
        kind=None if interfaces.kind is None else interfaces.kind[rows],
        patches=_patches(interfaces, shared),
    )


def _patches(interfaces: Interfaces, shared: list[_Plane]) -> Patches:
    """What the joints are made of, turned into the planes that they share."""
    found, start = interfaces.patches, interfaces.start
    if found is None:
        count, first = np.diff(start), interfaces.point[start[:-1]]
        arm = interfaces.point - np.repeat(first, count, axis=0)
        tangents = np.repeat(interfaces.frame[:, 1:], count, axis=0)
        flat = np.einsum("nkj,nj->nk", tangents, arm)
        found = Patches(
            interfaces.pair, interfaces.frame, first, interfaces.area, interfaces.gap, flat, count,
            np.zeros(interfaces.n_interfaces),
        )  # fmt: skip
    outlines = [interfaces.outline(k) for k in range(interfaces.n_interfaces)]
    joint = joints_of_patches(outlines, interfaces.pair, interfaces.frame, found)
    frame, origin, corner = found.frame.copy(), found.origin.copy(), found.corner.copy()
    ends = list(pairwise(np.cumsum([0, *found.count.tolist()]).tolist()))
    for plane in shared:
        for row in np.flatnonzero(np.isin(joint, plane.joints)):
            own = slice(*ends[row])
            corner[own] = plane.flat(found.origin[row] + found.corner[own] @ found.frame[row, 1:])
            frame[row], origin[row] = plane.frame, plane.centre
    return replace(found, frame=frame, origin=origin, corner=corner)
