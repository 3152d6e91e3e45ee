"""Whether convex pieces fill recesses of their block, and pieces that fill none: its parts between its own planes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.convex_pieces import contains
from blockstat.geometry.convex_pieces import convex_pieces as between_planes
from blockstat.geometry.inscribed_ball import inscribed_balls
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull


def fills(surface: Floats, pieces: Sequence[ConvexHull], depth: float) -> bool:
    """Return whether convex pieces fill a recess of a block, or a hollow in it, deeper than so much.

    Parameters
    ----------
    surface : array of float, shape (k, 3, 3)
        Corners of the triangles of the block's closed surface [m], counter-clockwise seen from outside.
    pieces : sequence of ConvexHull
        The pieces.
    depth : float
        What may be filled [m].

    Returns
    -------
    bool
        Whether a point deeper than that below the faces of a piece lies outside the block.

    Notes
    -----
    The points of a piece deeper than `depth` below its faces are a convex set, the core. A core that the surface does
    not reach lies wholly inside or wholly outside the block, so one point of it tells.
    """
    return any(_fills(surface, piece.equations, depth) for piece in pieces)


def _fills(surface: Floats, planes: Floats, depth: float) -> bool:
    radius, centre = inscribed_balls(planes[:, :3], -planes[:, 3], np.array([0, len(planes)]))
    if radius[0] <= depth:
        return False
    if not contains(surface, centre[0]):
        return True
    # Triangles with all corners in front of one face of the core stay out of it.
    below = -(surface @ planes[:, :3].T + planes[:, 3]) - depth
    near = (below.max(axis=1) > 0).all(axis=1)
    if (below[near] > 0).all(axis=2).any():  # a corner in the core
        return True
    left, corners = surface[near], np.full(near.sum(), 3)
    for plane in planes:
        if not len(left):
            break
        left, corners = polygons_above(left, corners, -(left @ plane[:3] + plane[3]) - depth)
    return bool(len(left))


def polygons_above(polygon: Floats, corners: Ints, height: Floats) -> tuple[Floats, Ints]:
    """Return the parts of convex polygons where a height is not negative.

    Parameters
    ----------
    polygon : array of float, shape (n, k, 3)
        Corners of the polygons in turn [m].
    corners : array of int, shape (n,)
        How many corners each has; what follows in its row is ignored.
    height : array of float, shape (n, k)
        Height of each corner [m].

    Returns
    -------
    part : array of float, shape (m, l, 3)
        Corners of the parts [m]; polygons that reach above height 0 nowhere are left out.
    corners : array of int, shape (m,)
        How many corners each has.

    Notes
    -----
    The part of a triangle stays one polygon, whatever number of planes cuts it. As triangles, it would be cut into more
    of them by every plane.
    """
    own = np.arange(polygon.shape[1]) < corners[:, None]
    reach = (own & (height > 0)).any(axis=1)
    polygon, corners, height, own = polygon[reach], corners[reach], height[reach], own[reach]
    following = np.where(np.arange(1, polygon.shape[1] + 1) < corners[:, None], np.arange(1, polygon.shape[1] + 1), 0)
    after = np.take_along_axis(height, following, axis=1)
    crossed = own & (height * after < 0)
    share = np.where(crossed, height, 0.0) / np.where(crossed, height - after, 1.0)
    crossing = polygon + share[..., None] * (np.take_along_axis(polygon, following[..., None], axis=1) - polygon)
    # After each corner that stays comes the point where the edge from it crosses the plane.
    points = np.stack([polygon, crossing], axis=2).reshape(len(polygon), 2 * own.shape[1], 3)
    kept = np.stack([own & (height >= 0), crossed], axis=2).reshape(len(polygon), 2 * own.shape[1])
    count = kept.sum(axis=1)
    order = np.argsort(~kept, axis=1, kind="stable")[:, : count.max(initial=0)]
    return np.take_along_axis(points, order[..., None], axis=1), count


def part_above(soup: Floats, height: Floats) -> Floats:
    """Return the parts of triangles where a height is not negative, triangulated again.

    Parameters
    ----------
    soup : array of float, shape (k, 3, 3)
        Corners of the triangles [m].
    height : array of float, shape (k, 3)
        Height of each corner [m].

    Returns
    -------
    array of float, shape (m, 3, 3)
        Corners of the parts [m]; triangles at height 0 are left out.
    """
    parts = [soup[(height >= 0).all(axis=1) & (height > 0).any(axis=1)]]
    crossed = (height.min(axis=1) < 0) & (height.max(axis=1) > 0)
    for triangle, h in zip(soup[crossed], height[crossed], strict=True):
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


def pieces_between_planes(surface: Floats, least: float, thin: float, most: int) -> list[ConvexHull]:
    """Cut a block along the planes of its own faces: it is filled, and nothing beside it.

    Parameters
    ----------
    surface : array of float, shape (k, 3, 3)
        Corners of the triangles of a closed surface [m], counter-clockwise seen from outside.
    least : float
        Surface that stands out of a plane by no more than this does not call for a cut [m].
    thin : float
        Pieces no thicker than twice this are left out [m].
    most : int
        Of pieces.

    Returns
    -------
    list of ConvexHull
        The pieces; none where there are more.
    """
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    corners = surface.reshape(-1, 3)
    lower, upper = corners.min(axis=0)[None], corners.max(axis=0)[None]
    # As many parts may lie beside the block as in it.
    found = between_planes([surface], lower, upper, np.array([least]), most=2 * most)[0]
    if len(found) > most:
        return []
    start = np.cumsum([0, *map(len, found)])
    planes = np.concatenate([np.empty((0, 4)), *found])
    radius, centre = inscribed_balls(planes[:, :3], planes[:, 3], start)
    return [
        ConvexHull(HalfspaceIntersection(np.column_stack([own[:, :3], -own[:, 3]]), middle).intersections)
        for own, middle, half in zip(found, centre, radius, strict=True)
        if half > thin
    ]
