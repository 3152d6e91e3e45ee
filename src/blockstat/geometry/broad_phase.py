"""Broad phase: pairs of axis-aligned boxes that come near each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from scipy.spatial import KDTree


#: Boxes whose neighbours are counted for an estimate.
SAMPLE = 100
#: Pairs of boxes of a row of which each is looked at; of more only those that trees find near.
MANY = 10_000
#: Distances between centres are no more exact than this, relative to them.
ROUNDED = 1e-9


def near_pairs(lower: Floats, upper: Floats, reach: Floats) -> Ints:
    """Find the pairs of boxes that are near each other.

    The gap along every axis is at most the larger of the two reaches.

    Parameters
    ----------
    lower, upper : array of float, shape (n, 3)
        Lower and upper corners of the boxes [m].
    reach : array of float, shape (n,)
        How far each box reaches beyond itself [m].

    Returns
    -------
    array of int, shape (n_pairs, 2)
        The pairs i < j, sorted.

    Notes
    -----
    Boxes are binned by size, so that a ground slab among bricks costs no more than its own neighbours do.
    """
    found = []
    for members_a, members_b, tree_a, tree_b, distance in _classes(lower, upper, reach):
        if tree_a is tree_b:
            pairs = members_a[tree_a.query_pairs(distance, output_type="ndarray")]
        else:
            hits = tree_a.query_ball_point(tree_b.data, distance)
            counts = [len(h) for h in hits]
            first = members_a[np.concatenate([[], *hits]).astype(np.int64)]
            pairs = np.column_stack([first, np.repeat(members_b, counts)])
        found.append(_boxes_touch(pairs, lower, upper, reach))
    pairs = np.sort(np.concatenate(found), axis=1) if found else np.empty((0, 2), dtype=np.int64)
    return pairs[np.lexsort(pairs.T[::-1])]


def count_of_close(lower: Floats, upper: Floats, reach: Floats) -> float:
    """Estimate how many pairs of boxes `near_pairs` looks at, which it holds in memory.

    Parameters
    ----------
    lower, upper, reach
        As of `near_pairs`.

    Returns
    -------
    float
        Number of pairs, from those of `SAMPLE` boxes of each size; each box counts with itself, and pairs of boxes of
        about the same size count twice.
    """
    total = 0.0
    for _, members_b, tree_a, tree_b, distance in _classes(lower, upper, reach):
        some = tree_b.data[:: -(-len(members_b) // SAMPLE)]
        total += len(members_b) * float(np.mean(tree_a.query_ball_point(some, distance, return_length=True)))
    return total


def _classes(lower: Floats, upper: Floats, reach: Floats) -> Iterator[tuple[Ints, Ints, KDTree, KDTree, float]]:
    """Each pair of classes of boxes by size: their members, trees of their centres, and how far apart may be near."""
    from scipy.spatial import KDTree

    if len(lower) < 2:
        return
    centre = (lower + upper) / 2
    radius = np.linalg.norm(upper - lower, axis=1) / 2 + reach
    level = np.round(np.log2(radius)).astype(int)
    classes = [(np.flatnonzero(level == v)) for v in np.unique(level)]
    trees = [KDTree(centre[members]) for members in classes]
    for a, members_a in enumerate(classes):
        for b, members_b in enumerate(classes[: a + 1]):
            yield members_a, members_b, trees[a], trees[b], float(radius[members_a].max() + radius[members_b].max())


def _boxes_touch(pairs: Ints, lower: Floats, upper: Floats, reach: Floats) -> Ints:
    i, j = pairs[:, 0], pairs[:, 1]
    slack = np.maximum(reach[i], reach[j])[:, None]
    touch = ((lower[i] <= upper[j] + slack) & (lower[j] <= upper[i] + slack)).all(axis=1)
    return pairs[touch]


def row_pairs(
    row_a: Ints, box_a: tuple[Floats, Floats], row_b: Ints, box_b: tuple[Floats, Floats], reach: Floats
) -> tuple[Ints, Ints]:
    """Find the boxes of two lists that are near each other and in the same row.

    Parameters
    ----------
    row_a, row_b : array of int, shape (n_a,) and (n_b,)
        Row of each box, ascending.
    box_a, box_b : tuple of two arrays of float, shape (n_a, 3) and (n_b, 3)
        Lower and upper corners of the boxes [m].
    reach : array of float, shape (n_rows,)
        Largest gap along every axis in each row [m].

    Returns
    -------
    a, b : array of int, shape (n,)
        Numbers of the boxes of each pair, sorted by a and then by b.

    Notes
    -----
    Rows of many boxes, as of blocks with fine meshes, are looked through with trees.
    """
    count_a, count_b = (np.bincount(row, minlength=len(reach)) for row in (row_a, row_b))
    first_a, first_b = np.cumsum(count_a) - count_a, np.cumsum(count_b) - count_b
    crowded = count_a * count_b > MANY
    own = np.flatnonzero(~crowded[row_a])
    place, b = members(first_b[row_a[own]], count_b[row_a[own]])
    pairs = [(own[place], b)]
    for row in np.flatnonzero(crowded).tolist():
        one = slice(first_a[row], first_a[row] + count_a[row])
        two = slice(first_b[row], first_b[row] + count_b[row])
        close = _close((box_a[0][one], box_a[1][one]), (box_b[0][two], box_b[1][two]), float(reach[row]))
        pairs += [(i + one.start, j + two.start) for i, j in close]
    a, b = (np.concatenate(column) for column in zip(*pairs, strict=True))
    slack, near = reach[row_a[a]], np.ones(len(a), dtype=bool)
    for k in range(3):
        near &= box_a[0][a, k] <= box_b[1][b, k] + slack
        near &= box_a[1][a, k] >= box_b[0][b, k] - slack
    a, b = a[near], b[near]
    if crowded.any():
        order = np.lexsort((b, a))
        a, b = a[order], b[order]
    return a, b


def _close(box_a: tuple[Floats, Floats], box_b: tuple[Floats, Floats], reach: float) -> Iterator[tuple[Ints, Ints]]:
    """Numbers of boxes of two lists that may be near each other, a class of sizes of each after the other."""
    from scipy.spatial import KDTree

    lists = []
    for low, high in (box_a, box_b):
        half = (high - low).max(axis=1) / 2 + reach
        level = np.round(np.log2(np.maximum(half, np.finfo(float).tiny))).astype(int)
        classes = [np.flatnonzero(level == value) for value in np.unique(level)]
        centre = (low + high) / 2
        lists.append([(own, KDTree(centre[own]), float(half[own].max())) for own in classes])
    for own_a, tree_a, half_a in lists[0]:
        for own_b, tree_b, half_b in lists[1]:
            distance = (1 + ROUNDED) * (half_a + half_b)
            found = tree_a.sparse_distance_matrix(tree_b, distance, p=np.inf, output_type="ndarray")
            yield own_a[found["i"]], own_b[found["j"]]
