"""Contact patches of faces that are not convex polygons, through shapely (GEOS)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.faces import planar
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


def concave_patches(
    assembly: Assembly, fa: Ints, fb: Ints, frame: Floats, origin: Floats, rows: Ints
) -> tuple[Ints, Floats, Ints]:
    """Return the convex hulls of the common parts of two faces, one row a connected part.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    fa, fb : array of int, shape (n,)
        Faces that meet, of block a and of block b.
    frame : array of float, shape (n, 3, 3)
        Rows n, t1, t2 of the plane of each pair of faces.
    origin : array of float, shape (n, 3)
        A point of each plane [m].
    rows : array of int, shape (k,)
        Pairs of faces to go through.

    Returns
    -------
    rows : array of int, shape (m,)
        The pair of faces of each part.
    polygons : array of float, shape (m, width, 2)
        Corners along t1 and t2 [m]; short polygons repeat their last one.
    counts : array of int, shape (m,)
        Corners of each polygon.
    """
    import shapely

    found, polygons = [], []
    size = np.diff(assembly.face_start)
    for row in rows:
        sides = []
        for face in (fa[row], fb[row]):
            outline = planar(assembly, np.array([face]), frame[[row]], origin[[row]], int(size[face]))[0]
            sides.append(shapely.make_valid(shapely.Polygon(outline)))
        for part in shapely.get_parts(shapely.intersection(*sides)):
            hull = part.convex_hull
            if hull.geom_type == "Polygon" and hull.area > 0:
                found.append(row)
                polygons.append(_ring(hull))
    width = max((len(p) for p in polygons), default=3)
    padded = np.array([np.vstack([p, np.repeat(p[-1:], width - len(p), axis=0)]) for p in polygons])
    return (
        np.array(found, dtype=np.int64),
        padded.reshape(-1, width, 2),
        np.array([len(p) for p in polygons], int),
    )


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
