"""Join patches that lie in one plane between the same two blocks into one interface."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from blockstat.contact.faces import outline_hull
from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

#: Normals whose sine is below this are those of one plane.
SAME_NORMAL = 1e-4


class Patch(NamedTuple):
    """One planar patch of contact."""

    pair: Ints  #: shape (2,)
    frame: Floats  #: shape (3, 3), rows n, t1, t2
    origin: Floats  #: shape (3,) [m]
    area: float  #: [m2]
    gap: float  #: [m]
    polygon: Floats  #: shape (k, 2) [m], corners along t1, t2 from the origin


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
            self.corner[corner], count,
        )  # fmt: skip

    def columns(self) -> tuple[Floats | Ints, ...]:
        """Return the arrays in their order.

        Returns
        -------
        tuple of array
            One a field.
        """
        return self.pair, self.frame, self.origin, self.area, self.gap, self.corner, self.count

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
        pair, frame, origin, area, gaps, polygon = zip(*more, strict=True)
        return Patches(
            np.concatenate([self.pair, pair]),
            np.concatenate([self.frame, frame]),
            np.concatenate([self.origin, origin]),
            np.concatenate([self.area, area]),
            np.concatenate([self.gap, gaps]),
            np.concatenate([self.corner, *polygon]),
            np.concatenate([self.count, [len(p) for p in polygon]]),
        )

    def __iter__(self) -> Iterator[Patch]:
        polygons = np.split(self.corner, np.cumsum(self.count)[:-1])
        rows = zip(self.pair, self.frame, self.origin, self.area.tolist(), self.gap.tolist(), polygons, strict=True)
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
            same = in_one_plane(normal[seed], patches.origin[seed], normal[rest], patches.origin[rest], tolerance)
            same[0] = True
            merged.append(joined(own[seed], [own[i] for i in rest[same]]) if same.sum() > 1 else own[seed])
            rest = rest[~same]
    return merged


def in_one_plane(normal: Floats, origin: Floats, normals: Floats, origins: Floats, tolerance: float) -> np.ndarray:
    """Whether patches lie in the plane of a first one and face the same way.

    Parameters
    ----------
    normal, origin : array, shape (3,)
        Of the first patch.
    normals, origins : array, shape (n, 3)
        Of the patches.
    tolerance : float
        Largest distance of their origins from the plane of the first [m].

    Returns
    -------
    array of bool, shape (n,)
        True for patches in the plane.
    """
    aside = np.linalg.norm(np.cross(normal, normals), axis=1)
    return (aside < SAME_NORMAL) & (normals @ normal > 0) & (np.abs((origins - origin) @ normal) <= tolerance)


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
        Its area is the sum of theirs, its gap the largest.
    """
    points = np.concatenate([p.origin + p.polygon @ p.frame[1:] - seed.origin for p in patches])
    outline = outline_hull(points @ seed.frame[1:].T)
    return seed._replace(polygon=outline, area=sum(p.area for p in patches), gap=max(p.gap for p in patches))
