"""Cut a concave block into convex pieces whose outer faces are exactly the block's own.

General decomposers (CoACD) remesh: a groin voussoir becomes 38 pieces whose corners are a thousandth of the
block off, and such blocks wedge where they should touch. Masonry blocks have a few reflex edges, and a plane
through a reflex edge removes it, so cutting again and again ends quickly and moves no face.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

#: What is tried in turn: a reflex edge shallower than the first figure, relative to the block's size, is a warped
#: face and the hull stands for it; corners as close to a cutting plane as the second lie on it; pieces whose total
#: volume is off by more than the third have failed. Cuts of planar faces are exact. A block with warped faces comes
#: apart at its own corners, which no cutting plane hits exactly.
ATTEMPTS = (
    (5e-3, 1e-9, 1e-4),
    (5e-3, 5e-3, 0.02),
    (2e-2, 2e-2, 0.1),
    (0.1, 0.1, 0.05),
    (5e-3, 1e-9, 0.02),
    (2e-2, 1e-9, 0.1),
)
#: More pieces than this and the cutting has failed.
MOST_PIECES = 40


def convex_pieces(vertices: Floats, triangles: Ints, size: float) -> list[Floats] | None:
    """Cut a closed surface into convex pieces.

    Parameters
    ----------
    vertices : array of float, shape (n, 3)
        Corners [m].
    triangles : array of int, shape (k, 3)
        Corners of each triangle, counter-clockwise seen from outside.
    size : float
        Length that tolerances refer to [m].

    Returns
    -------
    list of arrays of float, shape (k, 3), or None
        Corners of each piece [m]; None when the surface cannot be cut well.
    """
    surface = vertices[triangles]
    volume = float(np.einsum("ij,ij->i", surface[:, 0], np.cross(surface[:, 1], surface[:, 2])).sum()) / 6
    for shallow, near, error in ATTEMPTS:
        pieces = _cut_up(surface, shallow * size, near * size, size)
        if pieces is not None and abs(sum(hull.volume for hull in pieces) / volume - 1.0) <= error:
            return [hull.points[hull.vertices] for hull in pieces]
    return None


def _cut_up(surface: Floats, shallow: float, near: float, size: float) -> list[ConvexHull] | None:
    """Hulls of the pieces without reflex edges deeper than `shallow` [m]; None if there are too many or flat ones."""
    from scipy.spatial import ConvexHull, QhullError

    waiting, done = [surface], []
    while waiting:
        soup = waiting.pop()
        edge = _deepest_reflex_edge(soup, shallow, size)
        if edge is None:
            done.append(_distinct(soup.reshape(-1, 3), size))
        else:
            waiting += [part for side in _best_cut(soup, *edge, near) for part in _connected(side, size)]
        if len(waiting) + len(done) > MOST_PIECES:
            return None
    try:
        return [ConvexHull(points) for points in done]
    except (QhullError, ValueError):
        return None


def _normals(soup: Floats) -> Floats:
    normal = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
    length = np.linalg.norm(normal, axis=1)
    return normal / np.where(length > 0, length, 1.0)[:, None]


def _indices(soup: Floats, size: float) -> Ints:
    """Corner numbers of the triangles, equal where corners coincide, shape (n, 3)."""
    keys = np.round(soup.reshape(-1, 3) / (1e-7 * size)).astype(np.int64)
    return np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1, 3)


def _distinct(points: Floats, size: float) -> Floats:
    keys = np.round(points / (1e-7 * size)).astype(np.int64)
    return points[np.unique(keys, axis=0, return_index=True)[1]]


def _deepest_reflex_edge(soup: Floats, shallow: float, size: float) -> tuple[Floats, Floats, Floats, Floats] | None:
    """Return the reflex edge that is deepest: its ends and the normals of its triangles; None if all are shallow.

    Cut faces are left open: they bound the piece from outside, so their edges are never reflex.
    """
    corner, normal = _indices(soup, size), _normals(soup)
    owner: dict[tuple[int, int], tuple[int, int]] = {}
    for t, triangle in enumerate(corner.tolist()):
        for k in range(3):
            owner[triangle[k], triangle[(k + 1) % 3]] = (t, k)
    best, deepest = None, shallow
    for (a, b), (t, k) in owner.items():
        other = owner.get((b, a))
        if other is None or a > b:
            continue
        s, j = other
        start, end = soup[t, k], soup[t, (k + 1) % 3]
        over = min(normal[t] @ (soup[s, (j + 2) % 3] - start), normal[s] @ (soup[t, (k + 2) % 3] - start))
        if over > deepest:
            best, deepest = (start, end, normal[t], normal[s]), over
    return best


def _best_cut(soup: Floats, start: Floats, end: Floats, one: Floats, two: Floats, near: float) -> list[Floats]:
    """Both sides of the plane through an edge (bisecting, or along either face) that cuts fewest triangles."""
    along = (end - start) / np.linalg.norm(end - start)
    planes = [np.cross(along, one + two), one, two]
    planes = [plane / np.linalg.norm(plane) for plane in planes if np.linalg.norm(plane) > 1e-9]
    heights = [np.einsum("nkj,j->nk", soup - start, plane) for plane in planes]
    cuts = [int(((h > near).any(axis=1) & (h < -near).any(axis=1)).sum()) for h in heights]
    height = heights[int(np.argmin(cuts))]
    height = np.where(np.abs(height) <= near, 0.0, height)
    return [_above(soup, height), _above(soup, -height)]


def _above(soup: Floats, height: Floats) -> Floats:
    """Parts of triangles where height >= 0, triangulated again."""
    parts = [soup[(height >= 0).all(axis=1) & (height > 0).any(axis=1)]]
    for triangle, h in zip(soup, height, strict=True):
        if not (h.min() < 0 < h.max()):
            continue
        polygon = []
        for k in range(3):
            m = (k + 1) % 3
            if h[k] >= 0:
                polygon.append(triangle[k])
            if h[k] * h[m] < 0:
                polygon.append(triangle[k] + h[k] / (h[k] - h[m]) * (triangle[m] - triangle[k]))
        fan = [[polygon[0], polygon[i], polygon[i + 1]] for i in range(1, len(polygon) - 1)]
        parts.append(np.array(fan))
    return np.concatenate(parts)


def _connected(soup: Floats, size: float) -> list[Floats]:
    """Return the soup's parts that share no corner."""
    if not len(soup):
        return []
    corner = _indices(soup, size)
    n = int(corner.max()) + 1
    _, label = connected_components(n, np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]]]))
    owner = label[corner[:, 0]]
    return [soup[owner == part] for part in np.unique(owner)]
