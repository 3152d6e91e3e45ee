"""Join patches that lie in one plane between the same two blocks into one interface.

Forces act at the corners of the hull. A strength per area is that of the patches: each corner stands for so much of
their area that the sum and the first moment of uniform stress on them are exact.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from blockstat.contact.faces import FILLED, outline_hull
from blockstat.geometry.polyhedron import members, next_in_face
from blockstat.typing import Floats, Ints

#: Normals whose sine is below this are those of one plane.
SAME_NORMAL = 1e-4
#: Points whose outline has no more than this area over the sum of their squared distances lie in a line.
FLAT = 1e-12

#: Corners of the patches of some joints, each of shape (n, 3) [m], by number of the joint.
Parts = dict[int, list[Floats]]


class Patch(NamedTuple):
    """One planar patch of contact."""

    pair: Ints  #: shape (2,)
    frame: Floats  #: shape (3, 3), rows n, t1, t2
    origin: Floats  #: shape (3,) [m]
    area: float  #: [m2]
    gap: float  #: [m]
    polygon: Floats  #: shape (k, 2) [m], corners along t1, t2 from the origin
    overlap: float = 0.0  #: [m]


@dataclass(frozen=True)
class Patches:
    """Planar patches of contact, one a row."""

    pair: Ints  #: shape (n, 2)
    frame: Floats  #: shape (n, 3, 3), rows n, t1, t2
    origin: Floats  #: shape (n, 3) [m]
    area: Floats  #: shape (n,) [m2]
    gap: Floats  #: shape (n,) [m]
    corner: (
        Floats  #: corners of all polygons, one after the other, along t1, t2 from the origin, shape (n_corners, 2) [m]
    )
    count: Ints  #: corners of each, shape (n,)
    overlap: Floats  #: how far the two blocks reach into each other at most, shape (n,) [m]

    def take(self, rows: Ints) -> Patches:
        """Return some of the patches, in the order asked for.

        Parameters
        ----------
        rows : array of int, shape (k,)
            Numbers of the patches.

        Returns
        -------
        Patches
            The patches of these numbers.
        """
        count = self.count[rows]
        first = (np.cumsum(self.count) - self.count)[rows]
        corner = members(first, count)[1]
        return Patches(
            self.pair[rows], self.frame[rows], self.origin[rows], self.area[rows], self.gap[rows],
            self.corner[corner], count, self.overlap[rows],
        )  # fmt: skip

    def in_space(self) -> Floats:
        """Return the corners of all polygons as points.

        Returns
        -------
        array of float, shape (n_corners, 3)
            One after the other [m].
        """
        along = np.repeat(self.frame[:, 1:], self.count, axis=0)
        return np.repeat(self.origin, self.count, axis=0) + np.einsum("nk,nkj->nj", self.corner, along)

    def boxes(self) -> tuple[Floats, Floats]:
        """Return the bounding boxes of the polygons.

        Returns
        -------
        lower, upper : array of float, shape (n, 3)
            Their corners [m].
        """
        corner = self.in_space()
        if not len(corner):
            return corner, corner
        first = np.cumsum(self.count) - self.count
        return np.minimum.reduceat(corner, first), np.maximum.reduceat(corner, first)

    def columns(self) -> tuple[Floats | Ints, ...]:
        """Return the arrays in their order.

        Returns
        -------
        tuple of array
            One a field.
        """
        return self.pair, self.frame, self.origin, self.area, self.gap, self.corner, self.count, self.overlap

    def with_more(self, more: Sequence[Patch]) -> Patches:
        """Return these patches and then some others.

        Parameters
        ----------
        more : sequence of Patch
            At least one.

        Returns
        -------
        Patches
            All of them.
        """
        pair, frame, origin, area, gaps, polygon, overlap = zip(*more, strict=True)
        return Patches(
            np.concatenate([self.pair, pair]),
            np.concatenate([self.frame, frame]),
            np.concatenate([self.origin, origin]),
            np.concatenate([self.area, area]),
            np.concatenate([self.gap, gaps]),
            np.concatenate([self.corner, *polygon]),
            np.concatenate([self.count, [len(p) for p in polygon]]),
            np.concatenate([self.overlap, overlap]),
        )

    def __iter__(self) -> Iterator[Patch]:
        polygons = np.split(self.corner, np.cumsum(self.count))[:-1]
        numbers = self.area.tolist(), self.gap.tolist()
        rows = zip(self.pair, self.frame, self.origin, *numbers, polygons, self.overlap.tolist(), strict=True)
        return (Patch(*row) for row in rows)


def merge_coplanar(patches: Patches, allowed: Floats) -> Patches:
    """Merge patches of the same two blocks that lie in one plane.

    Parameters
    ----------
    patches : Patches
        The patches.
    allowed : array of float, shape (n_blocks,)
        Gap of a joint of each block [m].

    Returns
    -------
    Patches
        The merged patches, sorted by pair.

    Notes
    -----
    The merged polygon is the convex hull of all corners: forces in one plane with one friction cone add up to the same
    resultants on the hull's corners alone.
    """
    if not len(patches.pair):
        return patches
    patches = patches.take(np.lexsort((patches.pair[:, 1], patches.pair[:, 0])))
    same = (patches.pair[1:] == patches.pair[:-1]).all(axis=1)
    several = np.append(same, False) | np.append(False, same)
    if not several.any():
        return patches
    single = patches.take(np.flatnonzero(~several))
    merged = _merged(patches.take(np.flatnonzero(several)), allowed)
    both = single.with_more(merged)
    return both.take(np.lexsort((both.pair[:, 1], both.pair[:, 0])))


def _merged(patches: Patches, allowed: Floats) -> list[Patch]:
    """Patches of pairs that have several, sorted by pair."""
    own, normal = list(patches), patches.frame[:, 0]
    new_pair = np.flatnonzero((patches.pair[1:] != patches.pair[:-1]).any(axis=1)) + 1
    merged = []
    for rest in np.split(np.arange(len(own)), new_pair):
        tolerance = float(allowed[patches.pair[rest[0]]].min())
        while len(rest):
            seed = rest[0]
            first = normal[seed], patches.origin[seed], float(patches.gap[seed])
            same = in_one_plane(*first, normal[rest], patches.origin[rest], patches.gap[rest], tolerance)
            same[0] = True
            merged.append(joined(own[seed], [own[i] for i in rest[same]]) if same.sum() > 1 else own[seed])
            rest = rest[~same]
    return merged


def in_one_plane(
    normal: Floats, origin: Floats, gap: float, normals: Floats, origins: Floats, gaps: Floats, tolerance: float
) -> np.ndarray:
    """Whether patches lie in the plane of a first one and face the same way.

    Parameters
    ----------
    normal, origin : array, shape (3,)
        Of the first patch.
    gap : float
        How open it is [m].
    normals, origins : array, shape (n, 3)
        Of the patches.
    gaps : array, shape (n,)
        How open they are [m].
    tolerance : float
        Largest distance of their origins from the plane of the first [m].

    Returns
    -------
    array of bool, shape (n,)
        True for patches in the plane.

    Notes
    -----
    The origin of a patch lies halfway between its faces, so that half of each gap may be between two patches of one
    joint. What is further apart is a step, and forces on it have other arms.
    """
    aside, between = np.linalg.norm(np.cross(normal, normals), axis=1), origins - origin
    leaning = SAME_NORMAL * (np.linalg.norm(between, axis=1) + tolerance)
    level = np.abs(between @ normal) <= np.minimum(leaning + (gaps + gap) / 2, tolerance)
    return (aside < SAME_NORMAL) & (normals @ normal > 0) & level


def joined(seed: Patch, patches: Sequence[Patch]) -> Patch:
    """Return the convex hull of patches of one plane.

    Parameters
    ----------
    seed : Patch
        Its frame and origin are those of the hull.
    patches : sequence of Patch
        All patches to join, with the seed.

    Returns
    -------
    Patch
        Its area is the sum of theirs, its gap and its overlap the largest.
    """
    points = np.concatenate([p.origin + p.polygon @ p.frame[1:] - seed.origin for p in patches])
    outline = outline_hull(points @ seed.frame[1:].T)
    area, gap, overlap = sum(p.area for p in patches), max(p.gap for p in patches), max(p.overlap for p in patches)
    return seed._replace(polygon=outline, area=area, gap=gap, overlap=overlap)


def joints_of_patches(outlines: Sequence[Floats], pair: Ints, frame: Floats, patches: Patches) -> Ints:
    """Return the joint that each patch is part of.

    Parameters
    ----------
    outlines : sequence of array, shape (n, 3)
        Corners of the hull of each joint [m].
    pair, frame : array, shape (n_joints, ...)
        Of the joints, as `Patch` has them.
    patches : Patches
        Convex patches, and the edges and corners in their planes.

    Returns
    -------
    array of int, shape (n_patches,)
        Of the joints of two blocks with one normal, that in whose plane the patch lies; -1 where there is none.
    """
    rows: defaultdict[tuple[int, ...], list[int]] = defaultdict(list)
    for k, own_pair in enumerate(pair.tolist()):
        rows[tuple(own_pair)].append(k)
    origin = np.array([outline[0] for outline in outlines]).reshape(-1, 3)
    joint = np.full(len(patches.pair), -1, dtype=np.int64)
    for row, patch in enumerate(patches):
        own = np.array(rows[tuple(patch.pair.tolist())], dtype=int)
        normal = frame[own, 0]
        height = np.abs(np.einsum("ij,ij->i", normal, patch.origin - origin[own]))
        aligned = np.linalg.norm(np.cross(normal, patch.frame[0]), axis=1) < SAME_NORMAL
        if aligned.any():
            joint[row] = own[np.where(aligned, height, np.inf).argmin()]
    return joint


def parts_of(outlines: Sequence[Floats], pair: Ints, frame: Floats, area: Floats, patches: Patches) -> Parts:
    """Return what those joints are made of whose hull is more than their patches.

    Parameters
    ----------
    outlines : sequence of array, shape (n, 3)
        Corners of the hull of each joint [m].
    pair, frame, area : array, shape (n_joints, ...)
        Of the joints, as `Patch` has them.
    patches : Patches
        Convex patches, and the edges and corners in their planes.

    Returns
    -------
    dict of list of array, shape (k, 3)
        Corners of the patches by joint, and the ends of edges and corners without area [m].
    """
    found: defaultdict[int, list[Floats]] = defaultdict(list)
    for patch, k in zip(patches, joints_of_patches(outlines, pair, frame, patches).tolist(), strict=True):
        if k >= 0:
            found[k].append(patch.origin + patch.polygon @ patch.frame[1:])
    hull = {k: _area((outlines[k] - outlines[k][0]) @ frame[k, 1:].T) for k in found}
    return {k: own for k, own in found.items() if hull[k] > (1 + FILLED) * area[k] > 0}


def _area(corners: Floats) -> float:
    x, y = corners.T
    return 0.5 * abs(float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()))


def corner_shares(corners: Floats, start: Ints) -> Floats:
    """Return the part of the area of convex polygons that each of their corners stands for.

    The triangle of an edge and the area centroid counts half for either end of the edge: then the centroid of the
    weighted corners is that of the area, and the mean of a convex function over them is no less than over the area.

    Parameters
    ----------
    corners : array of float, shape (n, 2)
        Corners of all polygons, each in its own plane, one polygon after the other [m].
    start : array of int, shape (n_polygons + 1,)
        Where the corners of each polygon begin, and their number at the end.

    Returns
    -------
    array of float, shape (n,)
        Shares, of sum 1 a polygon; equal ones for points in a line.
    """
    count = np.diff(start)
    k, n = np.repeat(np.arange(len(count)), count), len(count)
    equal = (1.0 / np.maximum(count, 1))[k]
    if not len(corners):
        return equal

    def sums(values: Floats) -> Floats:
        return np.stack([np.bincount(k, column, n) for column in values.T], axis=1).astype(float)

    following = next_in_face(np.unique(start))
    arm = corners - (sums(corners) / np.maximum(count, 1)[:, None])[k]
    order = np.lexsort((np.arctan2(arm[:, 1], arm[:, 0]), k))
    arm = arm[order]
    twice = _cross(arm, arm[following])
    total = np.bincount(k, twice, n)
    solid = (count > 2) & (total > FLAT * sums(arm**2).sum(axis=1))
    moment = sums((arm + arm[following]) * twice[:, None])
    arm = arm - (moment / np.where(solid, 3 * total, 1.0)[:, None])[k]
    twice = np.maximum(_cross(arm, arm[following]), 0.0)
    both = twice.copy()
    both[following] += twice
    share = np.empty_like(equal)
    share[order] = both / np.where(solid, np.bincount(k, both, n), 1.0)[k]
    return np.where(solid[k], share, equal)


def shares_of_parts(hull: Floats, parts: Sequence[Floats]) -> Floats:
    """Return the part of the area of several patches that each corner of their hull stands for.

    Parameters
    ----------
    hull : array of float, shape (n, 2)
        Corners of the hull [m].
    parts : sequence of array, shape (k, 2)
        Corners of the patches in the same plane [m]; edges and corners have no area.

    Returns
    -------
    array of float, shape (n,)
        Shares of sum 1, with the area centroid of the patches.
    """
    solid = [part for part in parts if len(part) > 2]
    point = np.concatenate(solid)
    start = np.concatenate([[0], np.cumsum([len(part) for part in solid])])
    area = np.array([_area(part - part[0]) for part in solid])
    weight = corner_shares(point, start) * np.repeat(area / area.sum(), np.diff(start))
    # Each corner of a patch lies in a triangle of an edge of the hull and its centroid, which stands for all corners.
    whole = corner_shares(hull, np.array([0, len(hull)]))
    centre = whole @ hull
    arm, inner = hull - centre, point - centre
    order = np.argsort(np.arctan2(arm[:, 1], arm[:, 0]))
    one, two = order, np.roll(order, -1)
    twice = _cross(arm[one], arm[two])
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([_cross(inner[:, None], arm[two]), _cross(arm[one], inner[:, None])]) / twice
    ends = np.where(twice > 0, ends, -np.inf)
    sector = ends.min(axis=0).argmax(axis=1)
    first, second = np.maximum(ends[:, np.arange(len(point)), sector], 0.0)
    rest = np.maximum(1.0 - first - second, 0.0)
    weight = weight / (first + second + rest)
    share: Floats = (weight @ rest) * whole
    np.add.at(share, one[sector], weight * first)
    np.add.at(share, two[sector], weight * second)
    return share


def _cross(one: Floats, two: Floats) -> Floats:
    return np.asarray(one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0])
