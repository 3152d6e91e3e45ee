"""Whether convex pieces fill recesses of their block, and pieces that fill none: its parts between its own planes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.geometry.convex_pieces import contains
from blockstat.geometry.convex_pieces import convex_pieces as between_planes
from blockstat.geometry.inscribed_ball import inscribed_balls
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull

#: Corners of a polygon, and its area [m2].
Part = tuple[frozenset[int], float]
#: Faces whose normal has less than this along a direction are upright to it.
UPRIGHT = 1e-6


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


def prisms(surface: Floats, size: float, flush: float, directions: Sequence[Floats], reach: Floats) -> list[Floats]:
    """Cut a block that is a relief above a plane, such as a terrain, into prisms between its upper faces and the plane.

    Parameters
    ----------
    surface : array of float, shape (k, 3, 3)
        Corners of the triangles of a closed surface [m], counter-clockwise seen from outside.
    size : float
        Length that tolerances refer to [m].
    flush : float
        Corners this close to a plane lie on it, relative to `size`.
    directions : sequence of arrays of float, shape (3,)
        Unit vectors along which the block may rise, tried in turn.
    reach : array of float, shape (n, 3)
        Corners of all that may touch the block [m].

    Returns
    -------
    list of arrays of float, shape (l, 3)
        Corners of the prisms [m]; none where the block is no such relief.

    Notes
    -----
    A line along the direction leaves a closed surface at a face that looks down and enters it at one that looks up. So
    where no corner of a face that looks up is below one that looks down, each such line goes through one upper face
    alone, and the prisms are disjoint. They are the block but for what is below the highest corner of a face that looks
    down, which may be rough. That part is left out only if nothing reaches below it.
    """
    normal = np.cross(surface[:, 1] - surface[:, 0], surface[:, 2] - surface[:, 0])
    length = np.linalg.norm(normal, axis=1)
    surface, normal = surface[length > 0], normal[length > 0] / length[length > 0, None]
    for up in directions:
        rise, height = normal @ up, surface @ up
        above, below = rise > UPRIGHT, rise < -UPRIGHT
        if not above.any() or not below.any():
            continue
        base, lowest = height[below].max(), height.min()
        whole = base - lowest <= flush * size
        if height[above].min() < base - flush * size or not (whole or (reach @ up > base).all()):
            continue
        tops = _united(surface[above], normal[above], flush * size)
        feet = [top - np.outer(top @ up - base, up) for top in tops]
        return [np.vstack([top, foot]) for top, foot in zip(tops, feet, strict=True)]
    return []


def _united(surface: Floats, normal: Floats, near: float) -> list[Floats]:
    """Corners of convex polygons that triangles make, with those united that are in one plane."""
    keys = np.round(surface.reshape(-1, 3) / near).astype(np.int64)
    _, first, corner = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    points, triangles = surface.reshape(-1, 3)[first], corner.reshape(-1, 3)
    owner = {(a, b): t for t, row in enumerate(triangles.tolist()) for a, b in zip(row, row[1:] + row[:1], strict=True)}
    sides = np.array([(t, owner[b, a]) for (a, b), t in owner.items() if (b, a) in owner and t < owner[b, a]])
    sides = sides.reshape(-1, 2)
    one, other = surface[sides[:, 0]], surface[sides[:, 1]]
    off = np.einsum("ikj,ij->ik", other - one[:, :1], normal[sides[:, 0]])
    sides = sides[(np.abs(off) <= near).all(axis=1)]
    area = np.linalg.norm(np.cross(surface[:, 1] - surface[:, 0], surface[:, 2] - surface[:, 0]), axis=1) / 2
    label = connected_components(len(surface), sides)[1]
    found = []
    for group in np.split(np.argsort(label, kind="stable"), np.cumsum(np.bincount(label))[:-1]):
        own = {t: (frozenset(triangles[t].tolist()), float(area[t])) for t in group.tolist()}
        if len(own) > 1:
            inside = sides[label[sides[:, 0]] == label[group[0]]]
            own = _convex_unions(points, own, inside, normal[group[np.argmax(area[group])]], near)
        found += [points[sorted(corners)] for corners, _ in {id(part): part for part in own.values()}.values()]
    return found


def _convex_unions(points: Floats, parts: dict[int, Part], sides: Ints, normal: Floats, near: float) -> dict[int, Part]:
    """Unite triangles of one plane, all at once or side by side, where the outline of the union is convex."""
    from scipy.spatial import ConvexHull

    corners = sorted(frozenset().union(*(own for own, _ in parts.values())))
    across = np.linalg.svd(normal[None])[2][1:]
    place = dict(zip(corners, points[corners] @ across.T, strict=True))
    height = (points[corners] - points[corners[0]]) @ normal

    def united(one: Part, other: Part) -> Part | None:
        both, area = one[0] | other[0], one[1] + other[1]
        hull = ConvexHull(np.array([place[corner] for corner in both]))  # its "volume" is an area
        return (both, area) if hull.volume <= area + near * np.sqrt(area) else None

    if np.abs(height).max() > near:
        return parts  # they follow a curve
    whole = (frozenset(corners), sum(area for _, area in parts.values()))
    if united(whole, (frozenset(), 0.0)):
        return dict.fromkeys(parts, whole)
    found = dict(parts)
    members = {t: [t] for t in parts}
    for a, b in sides.tolist():
        if found[a] is not found[b] and (both := united(found[a], found[b])):
            one, other = members[a], members[b]
            one += other
            for t in one:
                found[t], members[t] = both, one
    return found
