"""Where solids touch: the judge's own search, by separating axes of convex pieces and their support polygons.

Of two convex pieces the directions that separate them are known: face normals of either and cross products of their
edges. Along the best of these each piece ends in a corner, an edge or a face, and the pieces touch where the two ends,
seen along it, have points in common. If another direction separates them as well, or the ends meet only at their rims,
the contact has no unique normal. All directions that separate are kept then, and marked.

Tolerances are those that the statics state: a joint may be open by `GAP` of the smaller block's size and a quarter of
its mean thickness, faces may be `ANGLE` from opposed, and nothing narrower than `WIDTH` of it is a patch. A contact
within half the tolerance is certain; one within twice the tolerance is possible.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely

from evidence.fuzz.scene import Scene
from evidence.fuzz.solids import SAME, Array, Piece, separating

GAP, THIN, WIDTH = 1e-2, 0.25, 1e-6
ANGLE = np.deg2rad(15.0)
SURE = 2.0  #: what is this much closer or wider than the tolerance is certain, this much further impossible
GRID = 1e-4  #: of the least width of a contact: grid of the corners of common patches


@dataclass(frozen=True)
class Touch:
    """Points at which block b is touched by block a, with the normal from a to b."""

    a: int
    b: int
    normal: Array
    points: Array
    gap: float
    kind: str  #: dimensions of the two ends that meet: "22" face on face, "21" edge on face, "11" edge across edge
    unique: bool  #: no other normal is possible
    certain: bool  #: unique, and well within the tolerances
    rim: tuple[int, ...] = ()  #: blocks and pieces that touch; contacts of one rim are its possible normals


def touches(scene: Scene) -> list[Touch]:
    """All contacts of a scene that are certain or possible, those between two supports left out."""
    pieces = [[Piece.of(corners) for corners in solid.pieces] for solid in scene.solids]
    size = np.array([np.cbrt(solid.volume) for solid in scene.solids])
    allowed = np.minimum(GAP * size, [THIN * 2 * s.volume / s.surface for s in scene.solids])
    found: list[Touch] = []
    for a, b in _near(scene, SURE * allowed):
        pair = [
            replace(touch, rim=(a, b, i, k))
            for i, one in enumerate(pieces[a])
            for k, two in enumerate(pieces[b])
            for touch in _between(a, b, one, two, min(allowed[a], allowed[b]), WIDTH * min(size[a], size[b]))
        ]
        found += [touch for touch in pair if touch.unique or not _covered(touch, pair)]
    return [touch for touch in found if not _filled(scene, pieces, touch, WIDTH * size[[touch.a, touch.b]].min())]


def _near(scene: Scene, reach: Array) -> Iterator[tuple[int, int]]:
    """Pairs of blocks, not both supports, whose boxes come within reach."""
    lower = np.array([s.vertices.min(axis=0) for s in scene.solids])
    upper = np.array([s.vertices.max(axis=0) for s in scene.solids])
    for a in range(len(lower)):
        for b in range(a + 1, len(lower)):
            near = min(reach[a], reach[b])
            apart = (lower[b] > upper[a] + near).any() or (lower[a] > upper[b] + near).any()
            if not apart and not (scene.support[a] and scene.support[b]):
                yield a, b


def _between(a: int, b: int, one: Piece, two: Piece, allowed: float, width: float) -> list[Touch]:
    """Contacts of two convex pieces."""
    axes = separating(one, two)
    high, low = (one.corners @ axes.T).max(axis=0), (two.corners @ axes.T).min(axis=0)
    gap = low - high
    best = float(gap.max())
    if abs(best) > SURE * allowed:
        return []
    rim = SURE * width
    ties = _clusters(axes, gap, best - rim)
    (first, *others) = ties
    kind, points, transversal = _meeting(one, two, axes[first], rim)
    if transversal and not others:
        # What is open is certain only where it is much wider than it is open.
        wide = abs(best) <= rim or _meeting(one, two, axes[first], SURE * abs(best))[2]
        exact = Touch(a, b, axes[first], points, best, kind, True, wide and abs(best) <= allowed / SURE)
        return [exact, *_nearly(exact, one, two, rim, SURE * allowed)]
    loose = []
    for axis in _clusters(axes, gap, min(best, 0.0) - rim):
        kind, points, _ = _meeting(one, two, axes[axis], rim)
        if len(points):
            touch = Touch(a, b, axes[axis], points, float(gap[axis]), kind, False, False)
            loose += [touch, *_nearly(touch, one, two, rim, SURE * allowed)]
    return loose


def _nearly(exact: Touch, one: Piece, two: Piece, rim: float, reach: float) -> list[Touch]:
    """The contact that would be if what is open by less than the tolerance, and rises gently, touched as well."""
    near = [_gentle(piece.corners, sign * exact.normal, rim, reach) for piece, sign in ((one, -1.0), (two, 1.0))]
    if all(corners is None for corners in near):
        return []
    one, two = (
        piece if corners is None else replace(piece, corners=corners)
        for piece, corners in zip((one, two), near, strict=True)
    )
    kind, points, transversal = _meeting(one, two, exact.normal, rim, reach)
    return [replace(exact, kind=kind, points=points, unique=True, certain=False)] if transversal else []


def _gentle(corners: Array, up: Array, rim: float, reach: float) -> Array | None:
    """The lowest corners of a piece and what rises gently from them to within reach; None where nothing does."""
    height = corners @ up - (corners @ up).min()
    lowest, higher = corners[height <= rim], corners[height > rim]
    climb = np.minimum(height[height > rim], reach)
    share = (climb / height[height > rim])[None, :, None]
    near = (lowest[:, None] + share * (higher[None] - lowest[:, None])).reshape(-1, 3)
    flat = np.linalg.svd(up[None])[2][1:].T
    aside = shapely.distance(shapely.MultiPoint(lowest @ flat).convex_hull, shapely.points(near @ flat))
    gentle = aside * np.tan(SURE * ANGLE) >= np.tile(climb, len(lowest))
    return np.concatenate([lowest, near[gentle]]) if gentle.any() else None


def _clusters(axes: Array, gap: Array, least: float) -> list[int]:
    """Of directions with at least this gap one for each normal, the best first; faces come before edges."""
    rows = np.flatnonzero(gap >= least)
    best = gap[rows].max()
    rows = rows[np.argsort(np.round((best - gap[rows]) / (abs(best - least) + 1e-300), 3), kind="stable")]
    chosen: list[int] = []
    for row in rows.tolist():
        if all(np.linalg.norm(axes[row] - axes[other]) > SAME for other in chosen):
            chosen.append(row)
    return chosen


def _meeting(one: Piece, two: Piece, normal: Array, rim: float, reach: float = 0.0) -> tuple[str, Array, bool]:
    """Kind of the ends of two pieces along a normal, the points that they share, and whether these are off the rims."""
    frame = np.linalg.svd(normal[None])[2][1:]
    ends, heights = [], []
    for corners, sign in ((one.corners, 1.0), (two.corners, -1.0)):
        along = sign * corners @ normal
        end = corners[along >= along.max() - max(rim, reach, SAME * SAME * np.ptp(along))]
        ends.append(end)
        heights.append(sign * along.max())
    origin = ends[1].mean(axis=0)
    first, second = (_end(end, origin, frame, rim) for end in ends)
    kind = "".join(str(shapely.get_dimensions(end)) for end in (first, second))
    shared = first.intersection(second, grid_size=GRID * rim)  # edges that all but coincide need a grid
    transversal = _transversal(first, second, shared, rim)
    if not transversal and first.distance(second) > rim:
        return kind, np.empty((0, 3)), False
    if shared.is_empty:
        shared = shapely.shortest_line(first, second).interpolate(0.5, normalized=True)
    flat = shapely.get_coordinates(shared.convex_hull)
    if shared.convex_hull.geom_type == "Polygon":
        flat = flat[:-1]
    middle = (heights[0] + heights[1]) / 2 - origin @ normal
    return kind, origin + flat @ frame + middle * normal, transversal


def _end(corners: Array, origin: Array, frame: Array, rim: float) -> shapely.Geometry:
    """The convex hull of corners seen along the normal, a segment or point where it is no wider than the rim."""
    shape = shapely.MultiPoint((corners - origin) @ frame.T).convex_hull
    if shape.geom_type == "Polygon" and 2 * shape.area < rim * shape.length:
        flat = (corners - origin) @ frame.T
        far = flat[np.linalg.norm(flat - flat[0], axis=1).argmax()]
        shape = shapely.LineString([flat[np.linalg.norm(flat - far, axis=1).argmax()], far])
    return shape.centroid if shape.geom_type == "LineString" and shape.length < rim else shape


def _transversal(first: shapely.Geometry, second: shapely.Geometry, shared: shapely.Geometry, rim: float) -> bool:
    """Whether two ends meet off their rims, so that no other normal separates what they end."""
    low, high = sorted((first, second), key=shapely.get_dimensions)
    if shared.is_empty:
        return False
    if shapely.get_dimensions(high) == 2:
        if shapely.get_dimensions(low) == 2:
            return shapely.get_dimensions(shared) == 2 and shared.area > rim * shared.length / 2
        inside = low.intersection(high.buffer(-rim, join_style="mitre"))
        return not inside.is_empty and (shapely.get_dimensions(low) == 0 or inside.length > rim)
    if shapely.get_dimensions(low) == 1:
        return shared.geom_type == "Point" and all(shared.distance(line.boundary) > rim for line in (first, second))
    return False


def _covered(touch: Touch, others: list[Touch]) -> bool:
    """Whether a contact of one normal of the same blocks leaves nothing open: at the seam of two pieces of a face."""
    fan = [other.normal for other in others if not other.unique]
    known = (o for o in others if o.unique and np.linalg.norm(fan - o.normal, axis=1).min() < SAME)
    return any(_within(touch.points, other) for other in known)


def _within(points: Array, other: Touch) -> bool:
    frame = np.linalg.svd(other.normal[None])[2][1:]
    origin = other.points[0]
    patch = shapely.MultiPoint((other.points - origin) @ frame.T).convex_hull
    reach = 1e-9 + 1e-6 * np.ptp(other.points, axis=0).max()
    level = np.abs((points - origin) @ other.normal).max() <= reach
    return bool(level and shapely.distance(patch, shapely.points((points - origin) @ frame.T)).max() <= reach)


def _filled(scene: Scene, pieces: list[list[Piece]], touch: Touch, rim: float) -> bool:
    """Whether a third block lies in an open joint; one that stands beside it does not."""
    if touch.gap <= rim:
        return False
    frame = np.linalg.svd(touch.normal[None])[2][1:]
    origin = touch.points.mean(axis=0)
    patch = shapely.MultiPoint((touch.points - origin) @ frame.T).convex_hull
    inner = patch.buffer(-rim)
    patch = patch.buffer(rim) if inner.is_empty else inner
    sections = (
        _section(piece.corners - origin, touch.normal, frame)
        for c, group in enumerate(pieces)
        if c not in (touch.a, touch.b)
        for piece in group
    )
    return any(section is not None and patch.intersects(section) for section in sections)


def _section(corners: Array, normal: Array, frame: Array) -> shapely.Geometry | None:
    """Where a convex piece meets the plane through the origin across a normal."""
    height = corners @ normal
    above, below = corners[height > 0], corners[height <= 0]
    if not (len(above) and len(below)):
        return None
    share = (height[height > 0][:, None] / (height[height > 0][:, None] - height[height <= 0]))[..., None]
    through = above[:, None] + share * (below - above[:, None])
    return shapely.MultiPoint(through.reshape(-1, 3) @ frame.T).convex_hull
