"""Joints of several patches that have lost a strip along each of their edges.

Only the rims of what the patches cover together move inwards: a face that is drawn in pieces is one face. Where two
rims make a notch, the strips of both go on for their own depth, so that its corner loses a square.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.contact.faces import joined_convex, outline_hull
from blockstat.geometry import clipping
from blockstat.typing import Floats, Ints

#: Lengths below this fraction of a joint are rounding.
ROUNDING = 1e-7
#: Areas below this fraction of a joint are rounding.
SPECK = 1e-12


def lose_rims(parts: Sequence[Floats], depth: float) -> tuple[list[Floats], Floats]:
    """Move the rims of patches of one plane inwards.

    Parameters
    ----------
    parts : sequence of array, shape (k, 2)
        Corners of convex patches that do not overlap, and the ends of edges and corners without area [m].
    depth : float
        How far the rims move [m].

    Returns
    -------
    parts : list of array, shape (k, 2)
        What is left: an edge loses both ends, a corner stays.
    hull : array, shape (n, 2)
        Corners of the hull of all that is left, counter-clockwise; the ends of an edge, one corner, or nothing.
    """
    patches = [_counter_clockwise(part) for part in parts if len(part) > 2]
    whole = sum(_area(patch) for patch in patches)
    left = patches
    for strip in _strips(patches, depth) if depth > 0 else ():
        left = [piece for patch in left for piece in _without(patch, strip, SPECK * whole)]
    left = joined_convex(left)
    for bare in (part for part in parts if len(part) < 3):
        along = bare[-1] - bare[0]
        length = float(np.linalg.norm(along))
        if length == 0:
            left.append(bare)
        elif length > 2 * depth:
            left.append(bare + np.stack([along, -along]) * depth / length)
    if not left:
        return left, np.empty((0, 2))
    return left, _hull(np.concatenate(left))


def joined_patches(parts: Sequence[Floats]) -> list[Floats]:
    """Join patches of one plane that are convex together.

    Parameters
    ----------
    parts : sequence of array, shape (k, 2)
        As in `lose_rims`.

    Returns
    -------
    list of array, shape (k, 2)
        Corners of the patches, counter-clockwise, then what has no area.
    """
    patches = [_counter_clockwise(part) for part in parts if len(part) > 2]
    return [*joined_convex(patches), *(part for part in parts if len(part) < 3)]


def corner_speeds(corners: Floats, parts: Sequence[Floats]) -> Floats:
    """Return how the corners of the hull of patches move while the rims of the patches move inwards.

    Parameters
    ----------
    corners : array of float, shape (n, 2)
        Corners of the hull [m].
    parts : sequence of array, shape (k, 2)
        As in `lose_rims`.

    Returns
    -------
    array of float, shape (n, 2)
        Displacement of each corner per displacement of the rims.
    """
    speed = np.zeros_like(corners)
    rims = _rims([_counter_clockwise(part) for part in parts if len(part) > 2])
    near = ROUNDING * float(np.ptp(np.concatenate(list(parts)), axis=0).max())
    along = rims[:, 1] - rims[:, 0]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    inward = np.column_stack([-along[:, 1], along[:, 0]])
    ends = [part for part in parts if len(part) == 2]
    for i, corner in enumerate(corners):
        after, before = (np.linalg.norm(rims[:, side] - corner, axis=1) <= near for side in (0, 1))
        if after.any() and before.any():
            one, two = inward[before.argmax()], inward[after.argmax()]
            speed[i] = (one + two) / (1.0 + one @ two)
            continue
        for edge in ends:
            away = np.linalg.norm(edge - corner, axis=1)
            if away.min() <= near:
                other = edge[away.argmax()] - corner
                speed[i] = other / np.linalg.norm(other)
    return speed


def _rims(patches: Sequence[Floats]) -> Floats:
    """Pieces of the edges of patches along which there is no other patch, shape (n, 2, 2), patches to their left."""
    if not patches:
        return np.empty((0, 2, 2))
    edges = np.concatenate([np.stack([patch, np.roll(patch, -1, axis=0)], axis=1) for patch in patches])
    tolerance = ROUNDING * float(np.ptp(np.concatenate(list(patches)), axis=0).max())
    edges = edges[np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1) > tolerance]
    found = []
    for tail, head in edges:
        length = float(np.linalg.norm(head - tail))
        along = (head - tail) / length
        place = (edges - tail) @ along
        aside = np.abs((edges - tail) @ [-along[1], along[0]]).max(axis=1)
        other = np.flatnonzero((aside <= tolerance) & (place[:, 1] < place[:, 0]))
        free = 0.0
        for low, high in sorted(zip(place[other, 1].tolist(), place[other, 0].tolist(), strict=True)):
            if min(low, length) > free + tolerance:
                found.append((tail + free * along, tail + min(low, length) * along))
            free = max(free, high)
        if length > free + tolerance:
            found.append((tail + free * along, head))
    return np.array(found).reshape(-1, 2, 2)


def _strips(patches: Sequence[Floats], depth: float) -> list[Floats]:
    """Rectangles inside the rims, counter-clockwise, the inner side first; longer by the depth at a notch."""
    rims = _rims(patches)
    if not len(rims):
        return []
    near = ROUNDING * float(np.ptp(np.concatenate(list(patches)), axis=0).max())
    along = rims[:, 1] - rims[:, 0]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    # A rim ends where another begins; it is a notch if the way round the patches turns right there.
    meets = np.linalg.norm(rims[:, None, 1] - rims[None, :, 0], axis=2) <= near
    turn = along[:, None, 0] * along[None, :, 1] - along[:, None, 1] * along[None, :, 0]
    notch = meets & (turn < -ROUNDING)
    strips = []
    for (tail, head), u, at_head, at_tail in zip(rims, along, notch.any(axis=1), notch.any(axis=0), strict=True):
        inward = np.array([-u[1], u[0]])
        first, last = tail - depth * at_tail * u, head + depth * at_head * u
        strips.append(
            np.array([last + depth * inward, first + depth * inward, first - near * inward, last - near * inward])
        )
    return strips


def _without(patch: Floats, window: Floats, speck: float) -> list[Floats]:
    """Convex pieces of a patch outside a convex window."""
    inside, found = patch, []
    for tail, head in zip(window, np.roll(window, -1, axis=0), strict=True):
        outside = _half(inside, head, tail)
        inside = _half(inside, tail, head)
        if _area(outside) > speck:
            found.append(outside)
        if _area(inside) <= speck:
            return [patch]
    return found


def _half(polygon: Floats, tail: Floats, head: Floats) -> Floats:
    """The part of a convex polygon to the left of a line."""
    if len(polygon) < 3:
        return polygon[:0]
    along = (head - tail) / np.linalg.norm(head - tail)
    height = (polygon - tail) @ [-along[1], along[0]]
    found = []
    for here, there, h, g in zip(polygon, np.roll(polygon, -1, axis=0), height, np.roll(height, -1), strict=True):
        if h >= 0:
            found.append(here)
        if (h >= 0) != (g >= 0):
            found.append(here + (there - here) * h / (h - g))
    return np.array(found).reshape(-1, 2)


def _hull(points: Floats) -> Floats:
    """Corners of the hull, none of them on the line of its neighbours; two ends, or one point."""
    away = np.linalg.norm(points - points[0], axis=1)
    far = points[away.argmax()]
    if away.max() == 0:
        return points[:1]
    along = (far - points[0]) / away.max()
    if np.abs((points - points[0]) @ [-along[1], along[0]]).max() <= ROUNDING * away.max():
        place = (points - points[0]) @ along
        return points[[place.argmin(), place.argmax()]]
    hull = outline_hull(points)
    count: Ints = np.array([len(hull)])
    return hull[clipping.corners(hull[None], count, np.array([1e-9 * np.sqrt(_area(hull))]))[0]]


def _counter_clockwise(polygon: Floats) -> Floats:
    return polygon if _area(polygon) > 0 else polygon[::-1]


def _area(polygon: Floats) -> float:
    if len(polygon) < 3:
        return 0.0
    x, y = (polygon - polygon[0]).T
    return 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
