"""Joints that have lost a strip along each of their edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import Interfaces
from blockstat.geometry import clipping
from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints


def lose_edges(interfaces: Interfaces, depth: Floats) -> Interfaces:
    """Move the edges of joints inwards; joints of which nothing is left are no contacts any more.

    Parameters
    ----------
    interfaces
        Joints without cells.
    depth
        How far the edges of each joint move, shape (n_interfaces,) [m].

    Returns
    -------
    Interfaces
        The joints that are left. An edge on a face loses both ends; corners and crossings stay as they are.
    """
    points, kept = [], []
    area = interfaces.area.copy()
    count = np.diff(interfaces.start)
    patch = interfaces.kinds == ContactKind.FACE
    for size in np.unique(count):
        rows = np.flatnonzero(count == size)
        corners = interfaces.point[members(interfaces.start[rows], count[rows])[1]].reshape(len(rows), size, 3)
        for is_patch in (True, False):
            own = patch[rows] == is_patch
            shrink = _inset if is_patch else _shorten
            left = shrink(corners[own], interfaces.frame[rows[own]], depth[rows[own]])
            for k, (there, covered) in zip(rows[own], left, strict=True):
                if len(there):
                    kept.append(k)
                    points.append(there)
                    area[k] = covered
    order = np.argsort(kept, kind="stable")
    rows = np.array(kept, dtype=np.int64)[order]
    chosen = [points[i] for i in order]
    found = replace(interfaces, patches=None).subset(rows)
    start = np.concatenate([[0], np.cumsum([len(p) for p in chosen])]).astype(np.int64)
    return replace(found, point=np.concatenate([np.empty((0, 3)), *chosen]), start=start, area=area[rows])


def least_width(interfaces: Interfaces) -> Floats:
    """Return how wide each joint is across its narrowest direction.

    Parameters
    ----------
    interfaces
        Joints without cells.

    Returns
    -------
    Floats
        The least distance from an edge to the corner farthest from it; the length of an edge on a face, and 0 for
        corners and crossings. Shape (n_interfaces,) [m].
    """
    width = np.zeros(interfaces.n_interfaces)
    for k in range(interfaces.n_interfaces):
        corners = interfaces.point[interfaces.start[k] : interfaces.start[k + 1]]
        if len(corners) == 2:
            width[k] = np.linalg.norm(corners[1] - corners[0])
        elif len(corners) > 2:
            flat = (corners - corners[0]) @ interfaces.frame[k, 1:].T
            along = np.roll(flat, -1, axis=0) - flat
            away = flat[None, :] - flat[:, None]
            height = np.abs(along[:, None, 0] * away[..., 1] - along[:, None, 1] * away[..., 0])
            width[k] = (height.max(axis=1) / np.linalg.norm(along, axis=1)).min()
    return width


def _inset(corners: Floats, frame: Floats, depth: Floats) -> list[tuple[Floats, float]]:
    """Corners and area of polygons whose edges moved inwards; no corners where nothing is left."""
    n, size, _ = corners.shape
    if not n:
        return []
    origin = corners[:, :1]
    flat = np.einsum("nkj,nij->nki", corners - origin, frame[:, 1:])
    all_count: Ints = np.full(n, size)
    turned = clipping.area(flat, all_count) < 0
    flat[turned] = flat[turned, ::-1]
    polygon, count = clipping.inset(flat, depth)
    area = clipping.area(polygon, count)
    needed = clipping.corners(polygon, count, 1e-9 * np.sqrt(np.maximum(area, 0.0)))
    world = origin + np.einsum("nki,nij->nkj", polygon, frame[:, 1:])
    return [
        (points[live], float(own)) if own > 0 and live.sum() > 2 else (points[:0], 0.0)
        for points, live, own in zip(world, needed, area, strict=True)
    ]


def _shorten(corners: Floats, _: Floats, depth: Floats) -> list[tuple[Floats, float]]:
    """The ends of segments, moved towards each other; single points stay."""
    if corners.shape[1] != 2:
        return [(points, 0.0) for points in corners]
    along = corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(along, axis=1)
    step = (depth / length)[:, None] * along
    moved = np.stack([corners[:, 0] + step, corners[:, 1] - step], axis=1)
    return [(points if whole > 0 else points[:0], 0.0) for points, whole in zip(moved, length - 2 * depth, strict=True)]
