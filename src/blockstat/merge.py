"""Join patches that lie in one plane between the same two blocks into one interface."""

from __future__ import annotations

from itertools import groupby
from typing import Any

import numpy as np

from blockstat.concave import outline_hull
from blockstat.polyhedron import Floats

#: Normals whose sine is below this are those of one plane.
SAME_NORMAL = 1e-4


def merge_coplanar(patches: list[tuple[Any, ...]], size: Floats, gap: float) -> list[tuple[Any, ...]]:
    """Merge patches (pair, frame, origin, polygon, area, gap), sorted by pair.

    The merged polygon is the convex hull of all corners: forces in one plane with one friction cone add
    up to the same resultants on the hull's corners alone.
    """
    merged = []
    for pair, group in groupby(patches, key=lambda patch: tuple(patch[0])):
        rest = list(group)
        tolerance = gap * min(size[pair[0]], size[pair[1]])
        while rest:
            seed = rest[0]
            same = [p for p in rest if _coplanar(seed, p, tolerance)]
            rest = [p for p in rest if not any(p is q for q in same)]
            merged.append(seed if len(same) == 1 else _join(seed, same))
    return merged


def _coplanar(a: tuple[Any, ...], b: tuple[Any, ...], tolerance: float) -> bool:
    if a is b:
        return True
    normal = a[1][0]
    return bool(
        np.linalg.norm(np.cross(normal, b[1][0])) < SAME_NORMAL
        and normal @ b[1][0] > 0
        and abs(normal @ (b[2] - a[2])) <= tolerance
    )


def _join(seed: tuple[Any, ...], patches: list[tuple[Any, ...]]) -> tuple[Any, ...]:
    pair, frame, origin = seed[:3]
    points = [p[2] + p[3] @ p[1][1:] - origin for p in patches]
    outline = outline_hull(np.concatenate(points) @ frame[1:].T)
    return pair, frame, origin, outline, sum(p[4] for p in patches), max(p[5] for p in patches)
