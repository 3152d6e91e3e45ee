"""Intersection of many pairs of convex polygons at once (Sutherland & Hodgman 1974, vectorised).

A batch of polygons is an array of shape (n, k, 2), counter-clockwise; a polygon with fewer than k corners
repeats its last one.
"""

from __future__ import annotations

import numpy as np

from blockstat.typing import Floats, Ints


def clip(subject: Floats, window: Floats) -> tuple[Floats, Ints]:
    """Return the part of each subject polygon that lies inside its window.

    Parameters
    ----------
    subject : array of float, shape (n, k, 2)
        Corners of convex polygons, counter-clockwise [m].
    window : array of float, shape (n, m, 2)
        Corners of convex polygons, counter-clockwise [m].

    Returns
    -------
    polygon : array of float, shape (n, k + m, 2)
        Corners of the common parts [m].
    count : array of int, shape (n,)
        How many of the corners count.

    Examples
    --------
    >>> square = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    >>> area(*clip(square, square + 0.5)).tolist()
    [0.25]
    """
    n, k, _ = subject.shape
    polygon, count = subject, np.full(n, k)
    for edge in range(window.shape[1]):
        tail, head = window[:, edge], window[:, (edge + 1) % window.shape[1]]
        polygon, count = _cut(polygon, count, tail, head - tail)
    return polygon, count


def inset(polygon: Floats, depth: Floats) -> tuple[Floats, Ints]:
    """Return what is left of convex polygons when each edge moves inwards.

    Parameters
    ----------
    polygon : array of float, shape (n, k, 2)
        Corners, counter-clockwise [m].
    depth : array of float, shape (n,)
        How far the edges of each polygon move [m].

    Returns
    -------
    polygon : array of float, shape (n, m, 2)
        Corners of what is left [m].
    count : array of int, shape (n,)
        How many of the corners count; 0 where nothing is left.

    Examples
    --------
    >>> square = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    >>> area(*inset(square, np.array([0.25]))).tolist()
    [0.25]
    """
    n, k, _ = polygon.shape
    left, count = polygon, np.full(n, k)
    for edge in range(k):
        along = polygon[:, (edge + 1) % k] - polygon[:, edge]
        length = np.linalg.norm(along, axis=1)
        inward = np.column_stack([-along[:, 1], along[:, 0]]) / np.where(length > 0, length, 1.0)[:, None]
        left, count = _cut(left, count, polygon[:, edge] + depth[:, None] * inward, along)
    return left, count


def _cut(polygon: Floats, count: Ints, tail: Floats, direction: Floats) -> tuple[Floats, Ints]:
    """Keep what lies left of a line through `tail`; a line without direction keeps all."""
    n, width, _ = polygon.shape
    column = np.arange(width)
    valid = column < count[:, None]
    following = np.where(column + 1 < count[:, None], column + 1, 0)
    height = direction[:, None, 0] * (polygon[..., 1] - tail[:, None, 1]) - direction[:, None, 1] * (
        polygon[..., 0] - tail[:, None, 0]
    )
    height_next = height[np.arange(n)[:, None], following]
    keep = valid & (height >= 0)
    cross = valid & ((height >= 0) != (height_next >= 0))

    row, corner = np.nonzero(cross)
    here, there = polygon[row, corner], polygon[row, following[row, corner]]
    share = height[row, corner] / (height[row, corner] - height_next[row, corner])
    # Each corner may give itself and then the crossing of its edge; what is left of each polygon is counted off.
    place = np.cumsum(np.stack([keep, cross], axis=2).reshape(n, 2 * width), axis=1)
    new_count = place[:, -1]
    place = place.reshape(n, width, 2) - 1
    packed = np.zeros((n, max(int(new_count.max(initial=0)), 1), 2))
    packed[row, place[row, corner, 1]] = here + share[:, None] * (there - here)
    row, corner = np.nonzero(keep)
    packed[row, place[row, corner, 0]] = polygon[row, corner]
    return packed, new_count


def area(polygon: Floats, count: Ints) -> Floats:
    """Return the area of each polygon.

    Parameters
    ----------
    polygon : array of float, shape (n, k, 2)
        Corners [m].
    count : array of int, shape (n,)
        How many corners of each polygon count.

    Returns
    -------
    array of float, shape (n,)
        Areas [m2], positive for counter-clockwise corners.
    """
    x, y = _closed(polygon, count)
    return 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)


def corners(polygon: Floats, count: Ints, tolerance: Floats) -> np.ndarray:
    """Return which corners span each polygon: no duplicates, none on the line of its neighbours.

    Parameters
    ----------
    polygon : array of float, shape (n, k, 2)
        Corners [m].
    count : array of int, shape (n,)
        How many corners of each polygon count.
    tolerance : array of float, shape (n,)
        Distance within which a corner is redundant [m].

    Returns
    -------
    array of bool, shape (n, k)
        True for the corners that are needed.

    Notes
    -----
    To leave the others out is exact for equilibrium: a force at a point of an edge is the sum of parallel forces at its
    ends.
    """
    width = polygon.shape[1]
    mask = np.arange(width) < count[:, None]
    for column in range(width):
        before = _neighbour(mask, column, step=-1)
        after = _neighbour(mask, column, step=1)
        rows = np.arange(len(polygon))
        here, left, right = polygon[:, column], polygon[rows, before], polygon[rows, after]
        chord = right - left
        length = np.linalg.norm(chord, axis=1)
        offset = here - left
        height = np.abs(chord[:, 0] * offset[:, 1] - chord[:, 1] * offset[:, 0]) / np.where(length > 0, length, 1.0)
        duplicate = np.linalg.norm(offset, axis=1) <= tolerance
        between = (np.einsum("ij,ij->i", offset, chord) <= length**2) & (length > tolerance)
        redundant = duplicate | (between & (height <= tolerance))
        mask[:, column] &= ~(redundant & (mask.sum(axis=1) > 1))
    return mask


def _neighbour(mask: np.ndarray, column: int, *, step: int) -> Ints:
    """Nearest column with a live corner before or after `column`, cyclically; itself if there is no other."""
    width = mask.shape[1]
    order = (column + step * np.arange(1, width + 1)) % width
    return order[np.argmax(mask[:, order], axis=1)]


def _closed(polygon: Floats, count: Ints) -> tuple[Floats, Floats]:
    """Coordinates with the unused places filled by the first corner, so that they add no area."""
    live = np.arange(polygon.shape[1]) < count[:, None]
    filled = np.where(live[..., None], polygon, polygon[:, :1])
    return filled[..., 0], filled[..., 1]


def diameter(polygon: Floats, count: Ints) -> Floats:
    """Return the diagonal of the box of each polygon.

    Parameters
    ----------
    polygon : array of float, shape (n, k, 2)
        Corners, of which the first `count` are used.
    count : array of int, shape (n,)
        Numbers of corners.

    Returns
    -------
    array of float, shape (n,)
        Lengths in the unit of the corners; 0 without corners.
    """
    live = (np.arange(polygon.shape[1]) < count[:, None])[..., None]
    top = np.where(live, polygon, -np.inf).max(axis=1)
    bottom = np.where(live, polygon, np.inf).min(axis=1)
    return np.linalg.norm(np.where(count[:, None] > 0, top - bottom, 0.0), axis=1)
