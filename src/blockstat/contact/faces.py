"""Faces seen in a plane: contact frames, planar coordinates, convexity, rims, and what any two faces have in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.tolerance import FLATNESS, ROUNDING, allowed_gap, stated_length
from blockstat.geometry.polyhedron import Polyhedra, next_in_face
from blockstat.surface.facets import facets
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

OUTSIDE, RIM, INSIDE = 0, 1, 2  #: where a point is in the plane of a face
#: A corner may turn the wrong way by this much (sine of the angle): rounding, not a notch.
REFLEX = 1e-6
#: A hull that is larger than what it is around by more than this fraction is not filled by it.
FILLED = 1e-6
#: Gaps between polygons below this fraction of them are rounding.
SEAM = 1e-9
#: Regions are cut on a grid of about this share of their outline: where edges all but coincide, GEOS may find nothing
#: in common, give back all that it was to take away, or fail (locationtech/jts#1000), but not on a grid.
GRID = 2.0**-44
#: A corner with one over the sine of half its angle above this is an arm: over a hundred times the width asked for,
#: it is narrower than a tenth of it.
SHARP = 1e3
#: What is wide grows back by this part more than it shrank, because circles are polygons that lack half a hundredth of
#: their radius. So an arm leaves a stub of a twentieth of the width.
REGROWTH = 0.1


def flatness(assembly: Assembly, gap: float | str) -> Floats:
    """Return how far the corners of a face may leave its plane.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float or str
        As in `find_interfaces`.

    Returns
    -------
    array of float, shape (n_blocks,)
        Lengths [m]: the rounding of single precision, or a part of the gap if that is a length.
    """
    flat = FLATNESS * allowed_gap(assembly, gap)
    if stated_length(gap) is not None:
        return flat
    return np.minimum(flat, ROUNDING * float(np.ptp(assembly.vertices, axis=0).max(initial=0.0)))


def as_searched(assembly: Assembly, gap: float | str) -> Assembly:
    """Return the blocks with the faces that the search sees.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float or str
        As in `find_interfaces`.

    Returns
    -------
    Assembly
        The blocks with facets: faces in one plane are one, however a mesh divides them. Planes are one up to the
        rounding of single precision, and up to a part of the gap if that is a length: it says how exact the geometry
        is.
    """
    return facets(assembly, tolerance=flatness(assembly, gap))


def convex_faces(assembly: Polyhedra) -> np.ndarray:
    """Return which faces are convex polygons.

    Parameters
    ----------
    assembly : Polyhedra
        The blocks.

    Returns
    -------
    array of bool, shape (n_faces,)
        True for a convex face.
    """
    corners = assembly.vertices[assembly.face_vertices]
    following = next_in_face(assembly.face_start)
    edge = corners[following] - corners
    length = np.linalg.norm(edge, axis=1)
    face = np.repeat(np.arange(len(assembly.face_block)), np.diff(assembly.face_start))
    # Two corners at one place are one: between them is no side, and so no turn at either.
    sides = np.flatnonzero(length > SEAM * np.maximum.reduceat(length, assembly.face_start[:-1])[face])
    edge, face = edge[sides] / length[sides, None], face[sides]
    following = next_in_face(np.unique(np.searchsorted(face, np.arange(len(assembly.face_block) + 1))))
    turn = np.einsum("ij,ij->i", np.cross(edge, edge[following]), assembly.planes.normal[face])
    convex = np.ones(len(assembly.face_block), dtype=bool)
    convex[face[turn < -REFLEX]] = False
    return convex


def frames(normal: Floats) -> Floats:
    """Return right-handed frames for unit normals.

    Parameters
    ----------
    normal : array of float, shape (n, 3)
        Unit normals.

    Returns
    -------
    array of float, shape (n, 3, 3)
        Rows are the normal, t1 and t2.
    """
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    t1: Floats = np.cross(axis, normal)
    t1 = t1 / np.linalg.norm(t1, axis=1)[:, None]
    t2: Floats = np.cross(normal, t1)
    return np.stack([normal, t1, t2], axis=1)


def planar(assembly: Polyhedra, face: Ints, frame: Floats, origin: Floats, width: int) -> Floats:
    """Return the corners of faces in the planes of contact patches.

    Parameters
    ----------
    assembly : Polyhedra
        The blocks.
    face : array of int, shape (n,)
        Numbers of the faces.
    frame : array of float, shape (n, 3, 3)
        Rows n, t1, t2 of each plane.
    origin : array of float, shape (n, 3)
        A point of each plane [m].
    width : int
        Corners a row; faces with fewer repeat their last one.

    Returns
    -------
    array of float, shape (n, width, 2)
        Corners along t1 and t2 from the origin [m].
    """
    first, last = assembly.face_start[face], assembly.face_start[face + 1] - 1
    index = np.minimum(first[:, None] + np.arange(width), last[:, None])
    local: Floats = assembly.vertices[assembly.face_vertices[index]] - origin[:, None]
    across: Floats = frame[:, 1:].swapaxes(1, 2)
    return local @ across


def surface_heights(assembly: Polyhedra, face: Ints, normal: Floats, point: Floats) -> Floats:
    """Return how high the surfaces of faces lie over points; a warped face is a fan of triangles about its mean corner.

    Parameters
    ----------
    assembly : Polyhedra
        The blocks.
    face : array of int, shape (n,)
        Numbers of the faces.
    normal : array of float, shape (n, 3)
        Unit vectors along which is measured, not in the planes of the faces.
    point : array of float, shape (n, k, 3)
        Points for each face; beside its outline the nearest triangle goes on [m].

    Returns
    -------
    array of float, shape (n, k)
        Heights, positive where the surface is further along the normal than the point [m].
    """
    first, last = assembly.face_start[face], assembly.face_start[face + 1] - 1
    width = int((last - first).max(initial=0)) + 1
    index = np.minimum(first[:, None] + np.arange(width), last[:, None])
    centre, along = assembly.planes.centre[face][:, None], normal[:, None]
    one = assembly.vertices[assembly.face_vertices[index]] - centre
    two = np.roll(one, -1, axis=1)
    offset = point - centre
    # Seen along the normal, a point is s times one end of a side and t times the other, from the mean corner.
    twice = np.einsum("nwj,nj->nw", np.cross(one, two), normal)
    solid = np.abs(twice) > SEAM * assembly.planes.area[face][:, None]
    twice = np.where(solid, twice, 1.0)[..., None]
    s = np.einsum("nwj,nkj->nwk", np.cross(two, along), offset) / twice
    t = np.einsum("nwj,nkj->nwk", np.cross(along, one), offset) / twice
    height = s * (one @ normal[..., None]) + t * (two @ normal[..., None])
    # A concave face may go over a point more than once: then that triangle counts whose side is nearest to it.
    inside = np.minimum(s, t)
    fit = np.where(inside >= -SEAM, 1 / (1 + np.abs(1 - s - t)), inside)
    best = np.where(solid[..., None], fit, -np.inf).argmax(axis=1)
    surface: Floats = np.take_along_axis(height, best[:, None], axis=1)[:, 0]
    return surface - np.einsum("nkj,nj->nk", offset, normal)


def gaps_of_planes(
    assembly: Polyhedra, fa: Ints, fb: Ints, frame: Floats, origin: Floats, polygon: Floats, count: Ints
) -> tuple[Floats, Floats, Floats]:
    """Return gaps and overlaps of flat faces over the corners of their patch.

    Parameters
    ----------
    assembly, fa, fb, frame, origin, polygon, count
        As in `gaps_of_surfaces`; a patch may have no corners.

    Returns
    -------
    gap : array of float, shape (n,)
        Largest distance along n at the corners of a patch [m].
    overlap : array of float, shape (n,)
        How far the first block reaches into the second there at most [m].
    middle : array of float, shape (n,)
        Height of the middle between the two faces over the plane of the patch, as faces that are not parallel do not
        meet halfway between their centres [m].
    """
    height = []
    live = np.arange(polygon.shape[1]) < count[:, None]
    for face in (fa, fb):
        local = np.einsum("nij,nj->ni", frame, assembly.planes.normal[face])
        offset = np.einsum("nj,nj->n", assembly.planes.centre[face] - origin, assembly.planes.normal[face])
        inplane = np.einsum("nkj,nj->nk", polygon, local[:, 1:])
        height.append((offset[:, None] - inplane) / local[:, :1])
    middle = np.where(live, height[0] + height[1], 0.0).sum(axis=1) / (2 * np.maximum(count, 1))
    apart = np.where(live, height[1] - height[0], 0.0)
    return np.abs(apart).max(axis=1, initial=0.0), -apart.min(axis=1, initial=0.0), middle


def gaps_of_surfaces(
    assembly: Polyhedra, fa: Ints, fb: Ints, frame: Floats, origin: Floats, polygon: Floats, count: Ints
) -> tuple[Floats, Floats]:
    """Return gaps and overlaps of warped faces on patches; two blocks that share such a face agree on its surface.

    Parameters
    ----------
    assembly : Polyhedra
        The blocks.
    fa, fb : array of int, shape (n,)
        The two faces of each patch.
    frame : array of float, shape (n, 3, 3)
        Rows n, t1, t2 of the plane of each patch.
    origin : array of float, shape (n, 3)
        A point of each plane [m].
    polygon : array of float, shape (n, k, 2)
        Corners of the patches along t1 and t2 [m].
    count : array of int, shape (n,)
        How many of the corners count, at least one.

    Returns
    -------
    gap : array of float, shape (n,)
        Largest distance along n at the corners of a patch and in the middle of its sides [m].
    overlap : array of float, shape (n,)
        How far the first block reaches into the second there at most [m].
    """
    column = np.arange(polygon.shape[1])
    following = np.where(column + 1 < count[:, None], column + 1, 0)
    live = np.where(column < count[:, None], column, 0)
    corner = np.take_along_axis(polygon, live[..., None], axis=1)
    middle = (corner + np.take_along_axis(polygon, following[..., None], axis=1)) / 2
    point = origin[:, None] + np.concatenate([corner, middle], axis=1) @ frame[:, 1:]
    height = [surface_heights(assembly, face, frame[:, 0], point) for face in (fa, fb)]
    apart: Floats = height[1] - height[0]
    return np.abs(apart).max(axis=1, initial=0.0), -apart.min(axis=1, initial=0.0)


def concave_patches(
    assembly: Polyhedra, fa: Ints, fb: Ints, frame: Floats, origin: Floats, rows: Ints, width: float
) -> tuple[Ints, Floats, Ints, dict[int, list[Floats]]]:
    """Return the convex hulls of the common parts of two faces, one row a connected part.

    Parameters
    ----------
    assembly : Polyhedra
        The blocks.
    fa, fb : array of int, shape (n,)
        Faces that meet, of block a and of block b.
    frame : array of float, shape (n, 3, 3)
        Rows n, t1, t2 of the plane of each pair of faces.
    origin : array of float, shape (n, 3)
        A point of each plane [m].
    rows : array of int, shape (k,)
        Pairs of faces to go through.
    width : float
        What is narrower than this, relative to the smaller block, is no patch.

    Returns
    -------
    rows : array of int, shape (m,)
        The pair of faces of each part.
    polygons : array of float, shape (m, width, 2)
        Corners along t1 and t2 [m]; short polygons repeat their last one.
    counts : array of int, shape (m,)
        Corners of each polygon.
    pieces : dict of list of array, shape (k, 2)
        Convex polygons that the parts which do not fill their hull are made of, by row of the result [m].

    Notes
    -----
    Where an edge of one face runs along a notch of the other, rounding leaves an arm of next to no width. The hull of a
    part with such an arm would bear where nothing does. So an arm is cut off as soon as it is no wider than a patch
    must be, and is a row of its own: the same two blocks with a mesh that divides the face there have such a patch.
    """
    import shapely

    found, polygons = [], []
    pieces: dict[int, list[Floats]] = {}
    size = np.diff(assembly.face_start)
    for row in rows:
        sides = []
        for face in (fa[row], fb[row]):
            outline = planar(assembly, np.array([face]), frame[[row]], origin[[row]], int(size[face]))[0]
            sides.append(shapely.make_valid(shapely.Polygon(outline)))
        least = width * float(assembly.size[assembly.face_block[[fa[row], fb[row]]]].min())
        common = shapely.intersection(*sides)
        if not shapely.area(common):
            common = shapely.intersection(*map(_polygons, sides), grid_size=max(map(grid_of, sides)))
        for part in shapely.get_parts(common):
            for own in _without_arms(part, least):
                hull = own.convex_hull
                if hull.area > (1 + FILLED) * own.area:
                    pieces[len(found)] = convex_polygons(own)
                found.append(row)
                polygons.append(_ring(hull))
    longest = max((len(p) for p in polygons), default=3)
    padded = np.array([np.vstack([p, np.repeat(p[-1:], longest - len(p), axis=0)]) for p in polygons])
    return (
        np.array(found, dtype=np.int64),
        padded.reshape(-1, longest, 2),
        np.array([len(p) for p in polygons], int),
        pieces,
    )


def _without_arms(part: Any, width: float) -> list[Any]:
    """A polygon, or what of it is wide and the convex pieces of its arms if they reach beyond that; no lines."""
    import shapely

    if not _solid(part):
        return []
    hull = part.convex_hull
    if hull.area <= (1 + FILLED) * part.area:
        return [part]
    wide = opened(part, width)
    if not wide.is_empty:
        beyond = shapely.distance(shapely.points(shapely.get_coordinates(hull)), wide.convex_hull)
        if beyond.max() <= width:
            return [part]
    arms = [own for own in shapely.get_parts(shapely.difference(part, wide)) if _solid(own)]
    bare = [shapely.Polygon(piece) for arm in arms for piece in convex_polygons(arm)]
    return [own for own in [*shapely.get_parts(wide), *bare] if _solid(own)]


def _solid(shape: Any) -> bool:
    """Whether a shape is a polygon whose corners do not lie in a line."""
    hull = shape.convex_hull
    return shape.geom_type == hull.geom_type == "Polygon" and hull.area > 0


def opened(region: Any, width: float, grid: float | None = None) -> Any:
    """Return what of a region is wide: its corners stay, its arms go.

    Parameters
    ----------
    region : shapely.Polygon or shapely.MultiPolygon
        In a plane [m].
    width : float
        A disc with this diameter fits into what stays, up to its corners [m].
    grid : float, optional
        Width of the grid on which the region is cut [m]; None for none.

    Returns
    -------
    shapely geometry
        Part of the region, empty where all of it is narrower.

    Examples
    --------
    >>> from shapely import box, union
    >>> opened(union(box(0, 0, 1, 1), box(1, 0, 2, 0.001)), 0.01).convex_hull.area < 1.001
    True
    """
    import shapely

    core = shapely.buffer(region, -width / 2)
    grown = shapely.buffer(core, (1 + REGROWTH) * width / 2, join_style="mitre", mitre_limit=SHARP)
    return _polygons(shapely.intersection(region, grown, grid_size=grid))


def grid_of(region: Any) -> float:
    """Return the width of the grid on which a region is cut, a power of two, on which round numbers lie.

    Parameters
    ----------
    region : shapely geometry
        In a plane [m].

    Returns
    -------
    float
        A length [m].
    """
    return GRID * 2.0 ** math.frexp(region.length)[1]


def uncovered(region: Any, covers: Sequence[Floats], width: Sequence[float]) -> Any:
    """Return what convex polygons leave of a region, but for strips beside them.

    Parameters
    ----------
    region : shapely geometry
        Polygon or polygons [m].
    covers : sequence of array of float, shape (n, 2)
        Corners of the convex polygons, in any order [m].
    width : sequence of float
        Widest strip beside each of them that counts for nothing [m].

    Returns
    -------
    shapely geometry
        Polygons, none where all is covered; the region itself where there are no covers.

    Examples
    --------
    >>> from shapely import box
    >>> cover = np.array([(0, 0), (1, 0), (1, 0.999), (0, 0.999)])
    >>> round(uncovered(box(0, 0, 2, 1), [cover], [0.01]).area, 5)
    1.0
    """
    import shapely

    hulls: dict[float, list[Any]] = {}
    for corners, own in zip(covers, width, strict=True):
        hull = shapely.MultiPoint(corners).convex_hull
        if hull.geom_type == "Polygon":
            hulls.setdefault(own, []).append(hull)
    if not hulls:
        return region
    grid = grid_of(region)
    alike = {own: shapely.union_all(parts, grid_size=grid) for own, parts in hulls.items()}
    whole = shapely.union_all(list(alike.values()), grid_size=grid)
    left = _polygons(shapely.difference(_polygons(region), whole, grid_size=grid))
    strips = []
    for own, covered in alike.items():
        narrow = _polygons(shapely.difference(left, opened(left, own, grid), grid_size=grid))
        beside = shapely.buffer(covered, own, join_style="mitre")
        strips.append(_polygons(shapely.intersection(narrow, beside, grid_size=grid)))
    return _polygons(shapely.difference(left, shapely.union_all(strips, grid_size=grid), grid_size=grid))


def _polygons(region: Any) -> Any:
    """What of a region has an area."""
    import shapely

    parts = shapely.get_parts(shapely.get_parts(region))
    return shapely.MultiPolygon([part for part in parts if part.geom_type == "Polygon" and part.area > 0])


def convex_polygons(polygon: Any) -> list[Floats]:
    """Return convex polygons that a polygon with holes is made of.

    Parameters
    ----------
    polygon : shapely.Polygon
        In a plane [m].

    Returns
    -------
    list of array, shape (k, 2)
        Corners of each, counter-clockwise [m].
    """
    import mapbox_earcut

    rings = [np.array(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    corners = np.concatenate(rings)
    ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
    triangles = corners[mapbox_earcut.triangulate_float64(corners - corners[0], ends).reshape(-1, 3)]
    return joined_convex(list(triangles))


def joined_convex(pieces: list[Floats]) -> list[Floats]:
    """Join convex polygons that do not overlap for as long as two of them make a convex one.

    Parameters
    ----------
    pieces : list of array, shape (k, 2)
        Corners of each, in either sense [m].

    Returns
    -------
    list of array, shape (k, 2)
        Corners of fewer polygons, counter-clockwise, that cover the same points.
    """
    import shapely

    left = [hull for piece in pieces if (hull := shapely.MultiPoint(piece).convex_hull).geom_type == "Polygon"]
    found: list[Any] = []
    boxes, centre, size = np.full((len(left), 4), np.nan), np.zeros((len(left), 2)), np.zeros(len(left))
    extent = np.ptp(shapely.total_bounds(left).reshape(2, 2), axis=0).max(initial=0.0) if left else 0.0
    rounding = 8 * np.finfo(float).eps * extent**2
    while left:
        new = left.pop()
        near, area = SEAM * new.length, new.area
        west, south, east, north = np.array(new.bounds) + 2 * near * np.array([-1, -1, 1, 1])
        meet = (boxes[:, 0] <= east) & (boxes[:, 1] <= north) & (boxes[:, 2] >= west) & (boxes[:, 3] >= south)
        meet = np.flatnonzero(meet)
        most = (1 + 2 * SEAM) * (area + size[meet]) + rounding
        for i in meet[area + _growth(new, centre[meet]) <= most].tolist():
            old = found[i]
            if not shapely.dwithin(new, old, near):
                continue
            hull = shapely.geometrycollections([new, old]).convex_hull  # a union may lose slivers
            if hull.area <= (1 + SEAM) * (area + old.area):
                left.append(hull)
                boxes[i] = np.nan  # it is part of another one
                break
        else:
            i = len(found)
            boxes[i], centre[i], size[i] = new.bounds, shapely.get_coordinates(new)[:-1].mean(axis=0), area
            found.append(new)
    return [_ring(piece) for piece, box in zip(found, boxes, strict=False) if not np.isnan(box[0])]


def _growth(polygon: Any, points: Floats) -> Floats:
    """By how much the area of a convex polygon grows when its hull takes in each of some points [m2]."""
    import shapely

    corners = shapely.get_coordinates(polygon)
    x, y = (corners - points[:, None]).transpose(2, 0, 1)
    # Of the triangles of a point with the sides, those beyond the polygon count with the other sign.
    twice = x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1]
    return (np.abs(twice).sum(axis=1) - np.abs(twice.sum(axis=1))) / 4


def outline_hull(points: Floats) -> Floats:
    """Return the corners of the convex hull of planar points.

    Parameters
    ----------
    points : array of float, shape (n, 2)
        Points [m].

    Returns
    -------
    array of float, shape (k, 2)
        Corners, counter-clockwise [m].
    """
    import shapely

    return _ring(shapely.MultiPoint(points).convex_hull)


def _ring(polygon: Any) -> Floats:
    """Corners of a polygon, counter-clockwise, the first not repeated."""
    from shapely.geometry.polygon import orient

    return np.array(orient(polygon).exterior.coords)[:-1]


def nearest_rim(points: Floats, polygon: Floats, sides: Ints) -> tuple[Ints, Floats]:
    """Return the convex edge of each face that is nearest to a point in its plane.

    Parameters
    ----------
    points : array of float, shape (n, 2)
        A point for each face [m].
    polygon : array of float, shape (n, k, 2)
        Corners of the faces [m]; short ones repeat their last corner.
    sides : array of int, shape (n, k)
        The convex edge that begins at each corner, -1 for none.

    Returns
    -------
    edge : array of int, shape (n,)
        -1 where a face has no convex edge.
    distance : array of float, shape (n,)
        To the edge [m]; inf where there is none.
    """
    if not len(points):
        return np.empty(0, dtype=np.int64), np.empty(0)
    line = np.roll(polygon, -1, axis=1) - polygon
    offset = points[:, None] - polygon
    square = (line**2).sum(axis=2)
    share = np.clip((offset * line).sum(axis=2) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    distance = np.linalg.norm(offset - share[..., None] * line, axis=2)
    distance = np.where((sides >= 0) & (square > 0), distance, np.inf)
    best = distance.argmin(axis=1)[:, None]
    return np.take_along_axis(sides, best, axis=1)[:, 0], np.take_along_axis(distance, best, axis=1)[:, 0]


def wedges(polygon: Floats, at: Ints) -> Floats:
    """Return from which angle to which polygons are seen from one of their corners.

    Parameters
    ----------
    polygon : array of float, shape (n, k, 2)
        Corners, counter-clockwise [m]; short ones repeat their last corner.
    at : array of int, shape (n,)
        The first number of the corner.

    Returns
    -------
    array of float, shape (n, 2)
        The angle of the side that begins there and of the one that ends there, from -pi to pi [rad].
    """
    each, k = np.arange(len(at)), polygon.shape[1]
    here, following = polygon[each, at], polygon[each, (at + 1) % k]
    last = (following == here).all(axis=1)
    following = np.where(last[:, None], polygon[:, 0], following)
    sides = np.stack([following, polygon[each, at - 1]], axis=1) - here[:, None]
    return np.arctan2(sides[..., 1], sides[..., 0])


def position(
    points: Floats, polygon: Floats, rim: np.ndarray, rounding: Floats, beyond: Floats | None = None
) -> np.ndarray:
    """Say whether points are outside polygons, on their rims, or inside.

    Parameters
    ----------
    points : array of float, shape (n, m, 2)
        m points for each polygon [m].
    polygon : array of float, shape (n, k, 2)
        Corners of polygons of any form [m]; short ones repeat their last corner.
    rim : array of bool, shape (n, k)
        Whether the side that begins at a corner is a rim. On another side a point is inside.
    rounding : array of float, shape (n,)
        A point nearer to a side than this is on it [m].
    beyond : array of float, shape (n,), optional
        A point outside is on a rim that is no further away than this [m]; by default `rounding`.

    Returns
    -------
    array of int, shape (n, m)
        `OUTSIDE`, `RIM` or `INSIDE`.
    """
    # Component by component: numpy takes several times as long to sum over an axis of two.
    side_x, side_y = np.moveaxis((np.roll(polygon, -1, axis=1) - polygon)[:, None], 3, 0)
    x, y = (points[:, :, None, k] - polygon[:, None, :, k] for k in (0, 1))
    square = side_x**2 + side_y**2
    share = np.clip((x * side_x + y * side_y) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    distance = np.sqrt((x - share * side_x) ** 2 + (y - share * side_y) ** 2)
    near = distance <= rounding[:, None, None]
    above = y >= 0
    leaves = np.roll(above, -1, axis=2)  # of one corner both sides must say the same, to the last bit
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = x - y * side_x / side_y < 0
    inside = ((above != leaves) & crossing).sum(axis=2) % 2 == 1
    # A side without length repeats a corner, which belongs to the true sides next to it.
    rim = (rim & (square[:, 0] > 0))[:, None]
    inside |= near.any(axis=2)
    on_rim = (near & rim).any(axis=2)
    if beyond is not None:
        on_rim |= ~inside & ((distance <= beyond[:, None, None]) & rim).any(axis=2)
    return np.where(on_rim, RIM, np.where(inside, INSIDE, OUTSIDE)).astype(np.int8)


def spans(
    ends: Floats, polygon: Floats, rim: np.ndarray, rounding: Floats, beyond: Floats
) -> tuple[Ints, Floats, Floats, Ints]:
    """Return the parts of segments that lie inside polygons or along their rims.

    Parameters
    ----------
    ends : array of float, shape (n, 2, 2)
        The ends of a segment for each polygon [m].
    polygon, rim, rounding, beyond
        As in `position`.

    Returns
    -------
    which : array of int, shape (n_parts,)
        The segment of each part.
    begin, finish : array of float, shape (n_parts,)
        Where the part begins and ends, as shares of the length of its segment.
    state : array of int, shape (n_parts,)
        `RIM` or `INSIDE`.
    """
    n = len(ends)
    start, line = ends[:, :1], (ends[:, 1] - ends[:, 0])[:, None]
    side = np.roll(polygon, -1, axis=1) - polygon
    offset = polygon - start
    square = (line**2).sum(axis=2)
    length = np.sqrt(square)
    turn = line[..., 0] * side[..., 1] - line[..., 1] * side[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        met = (offset[..., 0] * side[..., 1] - offset[..., 1] * side[..., 0]) / turn
        foot = (offset * line).sum(axis=2) / square
    cuts = np.concatenate([np.nan_to_num(met, nan=1.0, posinf=1.0, neginf=0.0), foot], axis=1)
    cuts = np.sort(np.clip(np.concatenate([np.zeros((n, 1)), cuts, np.ones((n, 1))], axis=1), 0.0, 1.0), axis=1)
    middle = (cuts[:, :-1] + cuts[:, 1:]) / 2
    state = position(start + middle[..., None] * line, polygon, rim, rounding, beyond)
    # Pieces of rounding have the state of the piece before them, or of the first true one.
    real = (np.diff(cuts, axis=1) * length > rounding[:, None]).astype(bool)
    column = np.arange(state.shape[1])
    before = np.maximum.accumulate(np.where(real, column, -1), axis=1)
    first = np.where(real.any(axis=1), real.argmax(axis=1), 0)[:, None]
    state = np.take_along_axis(state, np.where(before >= 0, before, first), axis=1)
    state[~real.any(axis=1)] = OUTSIDE
    changes = np.diff(state, axis=1, prepend=-1) != 0
    which, begin = np.nonzero(changes)
    finish = np.append(begin[1:], 0)
    finish[np.append(which[1:] != which[:-1], True)] = state.shape[1]
    found = state[which, begin]
    parts = found != OUTSIDE
    which, begin, finish, found = which[parts], begin[parts], finish[parts], found[parts]
    return which, cuts[which, begin], cuts[which, finish], found
