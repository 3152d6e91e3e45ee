"""The largest ball inside each of many sets of half-spaces: a linear program of four unknowns, solved in batches."""

from __future__ import annotations

import numpy as np

from blockstat.geometry.polyhedron import members
from blockstat.typing import Floats, Ints

#: The objective is tilted by this much, so that no two bases are equally good and none comes back. It moves the radius
#: by this fraction of the size of the problem.
TILT = 1e-9
#: A plane may cut into the ball by this fraction of the size of the problem: rounding.
TIGHT = 1e-11
#: Weights below this are zero: such a plane does not take part in the direction of an exchange.
ZERO = 1e-11
MOST_EXCHANGES = 200
#: Planes that are worked on at once: few enough to stay in the cache.
CHUNK = 30_000


def inscribed_balls(normal: Floats, offset: Floats, start: Ints, least: Floats | None = None) -> tuple[Floats, Floats]:
    """Return the largest ball inside each set of half-spaces `normal @ x <= offset`.

    Parameters
    ----------
    normal : array of float, shape (n_planes, 3)
        Unit normals, one set after the other.
    offset : array of float, shape (n_planes,)
        Distance of each plane from the origin along its normal [m]. Take an origin near the sets.
    start : array of int, shape (n_sets + 1,)
        Where the planes of each set begin, and their number at the end.
    least : array of float, shape (n_sets,), optional
        Radii that matter [m]: a set is left as soon as its ball is known to be no larger. Its radius is then an upper
        bound.

    Returns
    -------
    radius : array of float, shape (n_sets,)
        Radii [m]. A negative radius says by how much the planes must at least move out for a point to be inside of all.
    centre : array of float, shape (n_sets, 3)
        Centres [m].

    Notes
    -----
    The dual simplex method holds four planes that the ball touches and takes in the one that cuts deepest into the
    ball, until none does. All sets exchange one plane at a time together. A large tetrahedron around everything is the
    first basis; it bounds sets that are open.

    Examples
    --------
    >>> cube = np.concatenate([np.eye(3), -np.eye(3)])
    >>> radius, centre = inscribed_balls(cube, np.array([1.0, 2, 3, 0, 0, 0]), np.array([0, 6]))
    >>> radius.round(6).tolist()
    [0.5]
    """
    n = len(start) - 1
    radius, centre = np.empty(n), np.empty((n, 3))
    count = np.diff(start)
    least = np.full(n, -np.inf) if least is None else least
    order = np.argsort(count, kind="stable")
    width = count[order]
    first = 0
    while first < n:
        last = first + 1
        # Sets of like size fill a rectangle of rows; the widest is the last.
        last = max(last, min(int(np.searchsorted(width, 2 * width[first], side="right")), n))
        last = max(first + 1, min(last, first + CHUNK // max(int(width[last - 1]), 1)))
        rows = order[first:last]
        radius[rows], centre[rows] = _solve(normal, offset, start[rows], count[rows], least[rows])
        first = last
    return radius, centre


def _solve(normal: Floats, offset: Floats, first: Ints, count: Ints, least: Floats) -> tuple[Floats, Floats]:
    """Balls of sets of like size, by the dual simplex method."""
    n, width = len(first), max(int(count.max(initial=0)), 1)
    g, d = np.zeros((n, 4 + width, 4)), np.full((n, 4 + width), np.inf)
    row, plane = members(first, count)
    column = 4 + plane - first[row]
    g[row, column, :3], g[row, column, 3] = normal[plane], 1.0
    d[row, column] = offset[plane]
    size = np.where(np.isfinite(d), np.abs(d), 0.0).max(axis=1)
    size = np.where(size > 0, size, 1.0)
    d /= size[:, None]
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
    g[:, :4, :3], g[:, :4, 3], d[:, :4] = corners, 1.0, 100.0
    tilt = TILT * np.array([np.sqrt(2) - 1, -(np.sqrt(3) - 1), np.sqrt(5) - 2, 0.0])
    goal = np.array([0.0, 0.0, 0.0, 1.0]) + tilt
    basis = np.tile(np.arange(4), (n, 1))
    answer = np.zeros((n, 4))
    live = np.arange(n)
    for _ in range(MOST_EXCHANGES + width):
        rows = np.arange(len(live))[:, None]
        held = g[live][rows, basis[live]]
        x = np.linalg.solve(held, d[live][rows, basis[live]][..., None])[..., 0]
        answer[live] = x
        with np.errstate(invalid="ignore"):
            slack = d[live] - np.einsum("nki,ni->nk", g[live], x)
        worst = slack.argmin(axis=1)
        bad = (slack[rows[:, 0], worst] < -TIGHT) & (x[:, 3] * size[live] > least[live])
        live, held, worst = live[bad], held[bad], worst[bad]
        if not len(live):
            break
        transposed = held.swapaxes(1, 2)
        both = np.stack([np.broadcast_to(goal, (len(live), 4)), g[live, worst]], axis=2)
        weight, share = np.moveaxis(np.linalg.solve(transposed, both), 2, 0)
        ratio = np.where(share > ZERO, np.maximum(weight, 0.0) / np.where(share > ZERO, share, 1.0), np.inf)
        basis[live, ratio.argmin(axis=1)] = worst
    return answer[:, 3] * size, answer[:, :3] * size[:, None]
