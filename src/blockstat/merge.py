"""Join patches that lie in one plane between the same two blocks into one interface."""

from __future__ import annotations

from itertools import groupby
from typing import NamedTuple

import numpy as np

from blockstat.concave import outline_hull
from blockstat.polyhedron import Floats, Ints

#: Normals whose sine is below this are those of one plane.
SAME_NORMAL = 1e-4


class Patch(NamedTuple):
    """One planar patch of contact."""

    pair: Ints  #: shape (2,)
    frame: Floats  #: shape (3, 3), rows n, t1, t2
    origin: Floats  #: shape (3,) [m]
    polygon: Floats  #: shape (k, 2) [m], corners along t1, t2 from the origin
    area: float  #: [m2]
    gap: float  #: [m]


def merge_coplanar(patches: list[Patch], size: Floats, gap: float) -> list[Patch]:
    """Merge patches in one plane; they come sorted by pair.

    The merged polygon is the convex hull of all corners: forces in one plane with one friction cone add
    up to the same resultants on the hull's corners alone.
    """
    merged = []
    for pair, group in groupby(patches, key=lambda patch: tuple(patch.pair)):
        rest = list(group)
        if len(rest) == 1:
            merged += rest
            continue
        tolerance = gap * float(size[list(pair)].min())
        while rest:
            seed = rest[0]
            same = [p for p in rest if _coplanar(seed, p, tolerance)]
            rest = [p for p in rest if not any(p is q for q in same)]
            merged.append(seed if len(same) == 1 else _join(seed, same))
    return merged


def _coplanar(a: Patch, b: Patch, tolerance: float) -> bool:
    if a is b:
        return True
    normal, other = a.frame[0], b.frame[0]
    return bool(
        np.linalg.norm(np.cross(normal, other)) < SAME_NORMAL
        and normal @ other > 0
        and abs(normal @ (b.origin - a.origin)) <= tolerance
    )


def _join(seed: Patch, patches: list[Patch]) -> Patch:
    points = np.concatenate([p.origin + p.polygon @ p.frame[1:] - seed.origin for p in patches])
    outline = outline_hull(points @ seed.frame[1:].T)
    return seed._replace(polygon=outline, area=sum(p.area for p in patches), gap=max(p.gap for p in patches))
