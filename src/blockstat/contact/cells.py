"""Divide contact patches into cells, each with one contact point at its centroid.

Uniform stress in each cell is a real stress field, so what the cells carry the joint carries. The cells are narrow at
the rims, where the pressure of a hinge concentrates: their bounds follow (1 - cos)/2 along each side of the smallest
rectangle around the patch. A joint of several patches, such as that of a block on two feet, has cells on each of them:
the hull, which is enough for equilibrium, would carry pressure where nothing touches.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.geometry import clipping as clip
from blockstat.typing import Floats, Ints

#: Cells below this fraction of the patch are rounding at its outline.
SPECK = 1e-9


def refine(interfaces: Interfaces, divisions: Ints) -> Interfaces:
    """Put cells in place of the corners of some interfaces.

    Parameters
    ----------
    interfaces : Interfaces
        The interfaces.
    divisions : array of int, shape (n_interfaces,)
        Cells along each side of each interface; 0 leaves its corners as they are. Edges and corners have no cells.

    Returns
    -------
    Interfaces
        The same interfaces, with other contact points.
    """
    points, shares, counts = [], [], []
    parts = _parts(interfaces)
    for k, cells in enumerate(divisions):
        corners = interfaces.point[interfaces.start[k] : interfaces.start[k + 1]]
        if not cells or not interfaces.area[k]:
            own, share = corners, interfaces.point_share[interfaces.start[k] : interfaces.start[k + 1]]
        else:
            own, share = _cells_of(parts.get(k, [corners]), interfaces.frame[k], int(cells))
        points.append(own)
        shares.append(share)
        counts.append(len(own))
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    outlines = tuple(interfaces.outline(k) for k in range(interfaces.n_interfaces))
    changes = {"point": np.concatenate(points), "start": start, "share": np.concatenate(shares), "outlines": outlines}
    return replace(interfaces, **changes)


def centres(interfaces: Interfaces, rows: Ints) -> Floats:
    """Return the centroids of the patches of some interfaces; the middle of an edge, and the point of a corner.

    Parameters
    ----------
    interfaces : Interfaces
        The interfaces.
    rows : array of int, shape (n,)
        Numbers of the interfaces asked for.

    Returns
    -------
    array, shape (n, 3)
        Centroids [m].
    """
    found = np.empty((len(rows), 3))
    parts = _parts(interfaces) if interfaces.share is None else {}
    for i, k in enumerate(rows):
        own = slice(interfaces.start[k], interfaces.start[k + 1])
        corners, share = interfaces.point[own], interfaces.point_share[own]
        # Cells have their centroids already, and so have one point or two; more corners enclose one cell.
        if interfaces.share is None and len(corners) > 2:
            corners, share = _cells_of(parts.get(int(k), [corners]), interfaces.frame[k], 1)
        found[i] = share @ corners
    return found


def patches_of(interfaces: Interfaces, interface: int) -> list[Floats]:
    """Return the corners of the patches that one joint is made of, in order.

    Parameters
    ----------
    interfaces : Interfaces
        The interfaces.
    interface : int
        Number of one with an area.

    Returns
    -------
    list of array, shape (n, 3)
        Corners [m]; several patches where their hull is more than they are.
    """
    if interfaces.patches is not None:
        own = (interfaces.patches.pair == interfaces.pair[interface]).all(axis=1)
        few = replace(interfaces.subset(np.array([interface])), patches=interfaces.patches.take(np.flatnonzero(own)))
        if parts := _parts(few).get(0):
            return parts
    return [interfaces.outline(interface)]


def _parts(interfaces: Interfaces) -> dict[int, list[Floats]]:
    """Corners of the patches of those joints whose hull they do not fill, each of shape (n, 3) [m]."""
    return {k: [own for own in parts if len(own) > 2] for k, parts in interfaces.parts.items()}


def _cells_of(parts: list[Floats], frame: Floats, cells: int) -> tuple[Floats, Floats]:
    """Centroids [m], shape (n, 3), and shares of the whole area, shape (n,), of the cells of convex patches."""
    points, areas = zip(*(_cells(corners, frame, cells) for corners in parts), strict=True)
    area = np.concatenate(areas)
    return np.concatenate(points), area / area.sum()


def _cells(corners: Floats, frame: Floats, cells: int) -> tuple[Floats, Floats]:
    """Centroids [m], shape (n, 3), and areas [m2], shape (n,), of the cells of a convex patch."""
    centre = corners.mean(axis=0)
    flat = (corners - centre) @ frame[1:].T
    flat = flat[np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))]
    turn = _rectangle(flat)
    flat = flat @ turn.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    bound = (1 - np.cos(np.pi * np.arange(cells + 1) / cells)) / 2
    x, y = (low[i] + (high[i] - low[i]) * bound for i in range(2))
    i, j = (index.reshape(-1) for index in np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij"))
    window = np.stack([x[i], y[j], x[i + 1], y[j], x[i + 1], y[j + 1], x[i], y[j + 1]], axis=1).reshape(-1, 4, 2)
    polygon, count = clip.clip(np.repeat(flat[None], len(window), axis=0), window)
    area, centroid = _centroids(polygon, count)
    real = area > SPECK * area.sum()
    return centre + (centroid[real] @ turn) @ frame[1:], area[real]


def _rectangle(outline: Floats) -> Floats:
    """Rotation, shape (2, 2), that lays the smallest rectangle around a convex outline along the axes."""
    edge = np.roll(outline, -1, axis=0) - outline
    edge = edge[np.linalg.norm(edge, axis=1) > 0]
    along = edge / np.linalg.norm(edge, axis=1)[:, None]
    turns = np.stack([along, np.column_stack([-along[:, 1], along[:, 0]])], axis=1)
    extent = np.ptp(np.einsum("eij,pj->epi", turns, outline), axis=1)
    return turns[np.argmin(extent.prod(axis=1).round(12))]


def _centroids(polygon: Floats, count: Ints) -> tuple[Floats, Floats]:
    """Area and centroid of polygons in a batch, shapes (n,) and (n, 2); unused corners count for nothing."""
    live = np.arange(polygon.shape[1]) < count[:, None]
    first = polygon[:, :1]
    corner = np.where(live[..., None], polygon, first) - first
    after = np.roll(corner, -1, axis=1)
    cross = corner[..., 0] * after[..., 1] - after[..., 0] * corner[..., 1]
    area = cross.sum(axis=1) / 2
    moment = ((corner + after) * cross[..., None]).sum(axis=1) / 6
    return area, first[:, 0] + moment / np.where(area > 0, area, 1.0)[:, None]
