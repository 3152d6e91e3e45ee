"""Broad phase: pairs of axis-aligned boxes that come near each other."""

from __future__ import annotations

import numpy as np

from blockstat.typing import Floats, Ints


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
    from scipy.spatial import KDTree

    if len(lower) < 2:
        return np.empty((0, 2), dtype=np.int64)
    centre = (lower + upper) / 2
    radius = np.linalg.norm(upper - lower, axis=1) / 2 + reach
    level = np.round(np.log2(radius)).astype(int)
    classes = [(np.flatnonzero(level == v)) for v in np.unique(level)]
    trees = [KDTree(centre[members]) for members in classes]
    found = []
    for a, members_a in enumerate(classes):
        for b in range(a + 1):
            distance = radius[members_a].max() + radius[classes[b]].max()
            if a == b:
                pairs = trees[a].query_pairs(distance, output_type="ndarray")
                found.append(_boxes_touch(members_a[pairs], lower, upper, reach))
            else:
                hits = trees[a].query_ball_point(centre[classes[b]], distance)
                counts = [len(h) for h in hits]
                if sum(counts):
                    first = members_a[np.concatenate([h for h in hits if h]).astype(np.int64)]
                    pairs = np.column_stack([first, np.repeat(classes[b], counts)])
                    found.append(_boxes_touch(pairs, lower, upper, reach))
    pairs = np.sort(np.concatenate(found), axis=1) if found else np.empty((0, 2), dtype=np.int64)
    return pairs[np.lexsort(pairs.T[::-1])]


def _boxes_touch(pairs: Ints, lower: Floats, upper: Floats, reach: Floats) -> Ints:
    i, j = pairs[:, 0], pairs[:, 1]
    slack = np.maximum(reach[i], reach[j])[:, None]
    touch = ((lower[i] <= upper[j] + slack) & (lower[j] <= upper[i] + slack)).all(axis=1)
    return pairs[touch]
