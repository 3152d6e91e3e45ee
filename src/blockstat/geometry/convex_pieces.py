"""Cut the part of a solid that lies in a box into convex pieces along the planes of its own faces.

The pieces are the full leaves of a binary space partition (Fuchs, Kedem and Naylor 1980): they are disjoint, each is a
set of half-spaces, and together they fill the solid in the box.
"""

from __future__ import annotations

import numpy as np

from blockstat.typing import Floats

#: Heights below this fraction of the box are on a plane: rounding.
ON = 1e-9


def convex_pieces(triangles: Floats, lower: Floats, upper: Floats, tolerance: float) -> list[Floats]:
    """Cut the part of a solid in a box into convex pieces.

    Parameters
    ----------
    triangles : array of float, shape (n, 3, 3)
        Corners of the triangles of a closed surface, counter-clockwise seen from outside [m].
    lower, upper : array of float, shape (3,)
        Corners of the box [m].
    tolerance : float
        A piece whose corners lie outside its faces by no more than this is convex [m].

    Returns
    -------
    list of array of float, shape (k, 4)
        For each piece its half-spaces `row[:3] @ x <= row[3]`, with unit normals.

    References
    ----------
    H. Fuchs, Z. M. Kedem and B. F. Naylor, On visible surface generation by a priori tree structures, SIGGRAPH 1980,
    124-133, doi:10.1145/800250.807481.

    Examples
    --------
    >>> from blockstat import box
    >>> from blockstat.geometry.triangulation import triangulate
    >>> cube = box((0, 0, 0), (1, 1, 1))
    >>> corners = np.array(cube.vertices, dtype=float)
    >>> triangles = corners[triangulate(corners, [np.array(face) for face in cube.faces])]
    >>> [len(p) for p in convex_pieces(triangles, np.zeros(3), np.array([1.0, 1.0, 0.5]), 1e-6)]
    [11]
    """
    # About the middle of the box no digits are lost far from the origin.
    middle = (lower + upper) / 2
    on = ON * float(np.linalg.norm(upper - lower))
    walls = np.column_stack([np.concatenate([np.eye(3), -np.eye(3)]), np.tile((upper - lower) / 2, 2)])
    surface = triangles - middle
    height = surface @ walls[:, :3].T - walls[:, 3]
    inside = surface[(height.min(axis=1) < -on).all(axis=1)]
    for wall in walls[(height.max(axis=1) > on).any(axis=0)]:
        inside = _split(inside, wall, on)[1]
    pieces = _leaves(inside, walls, surface, tolerance, on)
    return [np.column_stack([p[:, :3], p[:, 3] + p[:, :3] @ middle]) for p in pieces]


def contains(triangles: Floats, point: Floats) -> bool:
    """Return whether a point lies inside a closed surface, by its solid angle.

    Parameters
    ----------
    triangles : array of float, shape (n, 3, 3)
        Corners of the triangles, counter-clockwise seen from outside [m].
    point : array of float, shape (3,)
        The point, not on the surface [m].

    Returns
    -------
    bool
        True for a point inside.

    References
    ----------
    A. van Oosterom and J. Strackee, The solid angle of a plane triangle, IEEE Transactions on Biomedical Engineering 30
    (1983) 125-126, doi:10.1109/TBME.1983.325207.
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = la * lb * lc + sum(
        np.einsum("ij,ij->i", u, v) * w for u, v, w in ((a, b, lc), (b, c, la), (c, a, lb))
    )  # fmt: skip
    return bool(2 * np.arctan2(volume, dots).sum() > 2 * np.pi)


def _leaves(inside: Floats, walls: Floats, surface: Floats, tolerance: float, on: float) -> list[Floats]:
    """Full leaves of the cell that `walls` bound, with the parts of the surface inside of it."""
    if not len(inside):
        return [walls] if contains(surface, np.zeros(3)) else []
    pieces, cells = [], [(inside, walls)]
    while cells:
        parts, path = cells.pop()
        planes = _planes(parts)
        heights = planes[:, :3] @ parts.reshape(-1, 3).T - planes[:, 3:]
        front = heights.max(axis=1)
        if front.max() <= max(tolerance, on):
            pieces.append(np.concatenate([path, _distinct(planes, on)]))
            continue
        plane = planes[_best(heights.reshape(len(planes), -1, 3), front > max(tolerance, on), on)]
        above, below = _split(parts, plane, on)
        # A side without any part of the surface is wholly outside in front of a face, and wholly inside behind it.
        if len(above):
            cells.append((above, np.vstack([path, -plane])))
        if len(below):
            cells.append((below, np.vstack([path, plane])))
        else:
            pieces.append(np.vstack([path, plane]))
    return pieces


def _best(heights: Floats, reflex: np.ndarray, on: float) -> int:
    """Of the planes with surface in front, the one that cuts fewest parts of it, then the one that halves it."""
    front, back = (heights > on).any(axis=2), (heights < -on).any(axis=2)
    cut = (front & back).sum(axis=1)
    uneven = np.abs(front.sum(axis=1) - back.sum(axis=1))
    cost = np.where(reflex, cut * (heights.shape[1] + 1) + uneven, np.inf)
    return int(cost.argmin())


def _planes(triangles: Floats) -> Floats:
    normal = _vector_areas(triangles)
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    return np.column_stack([normal, np.einsum("ij,ij->i", normal, triangles.mean(axis=1))])


def _distinct(planes: Floats, on: float) -> Floats:
    """One of each group of planes that are equal but for rounding."""
    keys = np.round(planes / [1e-9, 1e-9, 1e-9, on])
    return planes[np.sort(np.unique(keys, axis=0, return_index=True)[1])]


def _split(triangles: Floats, plane: Floats, on: float) -> tuple[Floats, Floats]:
    """Parts of triangles in front of a plane and behind it, as triangles; what lies in the plane is in neither."""
    height = triangles @ plane[:3] - plane[3]
    height[np.abs(height) <= on] = 0.0
    up, down = (height > 0).any(axis=1), (height < 0).any(axis=1)
    both = up & down
    above, below = triangles[up & ~down], triangles[down & ~up]
    if not both.any():
        return above, below
    corner, h = triangles[both], height[both]
    # The corner that is alone on its side comes first.
    odd = h > 0
    alone = np.where(odd.sum(axis=1) == 1, odd.argmax(axis=1), (~odd).argmax(axis=1))
    turn = (alone[:, None] + np.arange(3)) % 3
    rows = np.arange(len(turn))[:, None]
    corner, h = corner[rows, turn], h[rows, turn]
    share = h[:, :1] / (h[:, :1] - h[:, 1:])
    crossing = corner[:, :1] + share[..., None] * (corner[:, 1:] - corner[:, :1])
    p, q = crossing[:, 0], crossing[:, 1]
    tip = np.stack([corner[:, 0], p, q], axis=1)
    rest = np.concatenate([np.stack([p, corner[:, 1], corner[:, 2]], axis=1), np.stack([p, corner[:, 2], q], axis=1)])
    first_up = h[:, 0] > 0
    rest_up = np.tile(~first_up, 2)
    above = np.concatenate([above, tip[first_up], rest[rest_up]])
    below = np.concatenate([below, tip[~first_up], rest[~rest_up]])
    return _real(above, on), _real(below, on)


def _real(triangles: Floats, on: float) -> Floats:
    """The triangles that are wider than rounding: the others have no plane."""
    edge = triangles[:, [1, 2, 0]] - triangles
    longest = np.linalg.norm(edge, axis=2).max(axis=1, initial=0.0)
    return triangles[2 * np.linalg.norm(_vector_areas(triangles), axis=1) > on * longest]


def _vector_areas(triangles: Floats) -> Floats:
    """Area of each triangle times its normal; numpy.cross takes several times as long on few of them."""
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return (u[:, [1, 2, 0]] * v[:, [2, 0, 1]] - u[:, [2, 0, 1]] * v[:, [1, 2, 0]]) / 2
