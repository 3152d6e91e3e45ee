"""Broad phase: pairs of axis-aligned boxes that come near each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from scipy.spatial import KDTree


#: Boxes whose neighbours are counted for an estimate.
SAMPLE = 100


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
