"""How far apart blocks are: the exact distance between the surfaces of polyhedra.

Two surfaces are nearest where an edge meets an edge, or a corner a face. A bound from the corners alone leaves few of
these to look at.
"""

from __future__ import annotations

import numpy as np

from blockstat.geometry.broad_phase import near_pairs
from blockstat.geometry.polyhedron import Polyhedra, members, next_in_face
from blockstat.typing import Floats, Ints

#: Neighbours of a corner among which one of another block is looked for, to have a first bound.
NEIGHBOURS = 32
#: Pairs of edges that are looked at together, for the sake of memory.
BATCH = 2_000_000

Boxes = tuple[Floats, Floats]


def smallest_gap(solid: Polyhedra, some: Ints, others: Ints) -> tuple[float, int, int]:
    """Find the smallest distance between one of some blocks and one of others.

    Parameters
    ----------
    solid : Polyhedra
        The blocks.
    some, others : array of int, shape (n,) and (m,)
        Numbers of the blocks. A block in both is not compared with itself.

    Returns
    -------
    distance : float
        Distance between the two surfaces [m]; zero if they cross, inf if there are no two blocks.
    a, b : int
        The two blocks, a < b; -1 if there are none.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> three = [box((0, 0, 0), (1, 1, 1)), box((0, 0, 1.25), (1, 1, 2)), box((3, 0, 0), (4, 1, 1))]
    >>> smallest_gap(Assembly.from_blocks(three, supports=[0]), np.array([0]), np.array([1, 2]))
    (0.25, 0, 1)
    """
    sets = np.zeros((2, solid.n_blocks), dtype=bool)
    sets[0, some] = sets[1, others] = True
    bound = _corner_distance(solid, sets)
    lower, upper = solid.bounds
    reach = bound if np.isfinite(bound) else float(np.ptp(solid.vertices, axis=0).max(initial=0.0))
    pairs = near_pairs(lower, upper, np.full(solid.n_blocks, reach))
    a, b = pairs.T
    pairs = pairs[(sets[0, a] & sets[1, b]) | (sets[1, a] & sets[0, b])]
    apart = np.maximum(lower[pairs[:, 0]] - upper[pairs[:, 1]], lower[pairs[:, 1]] - upper[pairs[:, 0]])
    apart = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
    order = np.argsort(apart, kind="stable")
    pairs, apart = pairs[order], apart[order]
    edges = _Edges(solid)
    work = np.cumsum(edges.count[pairs[:, 0]] * edges.count[pairs[:, 1]]) // BATCH
    best, found = np.inf, (-1, -1)
    for batch in np.split(np.arange(len(pairs)), np.flatnonzero(np.diff(work)) + 1):
        batch = batch[apart[batch] <= min(bound, best)]
        distance = _distances(solid, edges, pairs[batch], min(bound, best))
        if len(batch) and distance.min() < best:
            best, found = float(distance.min()), tuple(pairs[batch[distance.argmin()]].tolist())
    return best, found[0], found[1]


class _Edges:
    """The edges of all blocks, each once, and boxes of edges and faces."""

    def __init__(self, solid: Polyhedra) -> None:
        tail, head = solid.face_vertices, solid.face_vertices[next_in_face(solid.face_start)]
        ends = np.unique(np.sort(np.column_stack([tail, head]), axis=1), axis=0)  # sorted by block
        # Two corners of a face at one place are the ends of no edge.
        ends = ends[(solid.vertices[ends[:, 0]] != solid.vertices[ends[:, 1]]).any(axis=1)]
        block = solid.vertex_block[ends[:, 0]]
        self.first = np.searchsorted(block, np.arange(solid.n_blocks))
        self.count = np.bincount(block, minlength=solid.n_blocks)
        self.ends = solid.vertices[ends]  #: shape (n_edges, 2, 3) [m]
        self.box: Boxes = (self.ends.min(axis=1), self.ends.max(axis=1))
        corners, start = solid.vertices[solid.face_vertices], solid.face_start[:-1]
        self.face_box: Boxes = (np.minimum.reduceat(corners, start), np.maximum.reduceat(corners, start))
        self.first_face = np.searchsorted(solid.face_block, np.arange(solid.n_blocks))
        self.faces = np.bincount(solid.face_block, minlength=solid.n_blocks)


def _corner_distance(solid: Polyhedra, sets: np.ndarray) -> float:
    """Smallest distance between corners of a block of the first set and one of the second; inf if none is found."""
    from scipy.spatial import KDTree

    used = np.unique(solid.face_vertices)
    block, corners = solid.vertex_block[used], solid.vertices[used]
    some, others = (np.flatnonzero(members[block]) for members in sets)
    if not len(some) or not len(others):
        return np.inf
    distance, near = KDTree(corners[others]).query(corners[some], k=min(NEIGHBOURS, len(others)))
    near = near.reshape(len(some), -1)
    return float(distance.reshape(near.shape)[block[others][near] != block[some, None]].min(initial=np.inf))


def _distances(solid: Polyhedra, edges: _Edges, pairs: Ints, bound: float) -> Floats:
    """Distance between the surfaces of each pair of blocks, exact where it is at most the bound [m]."""
    best = np.full(len(pairs), np.inf)
    boxes = [(solid.bounds[0][pairs[:, i]], solid.bounds[1][pairs[:, i]]) for i in (0, 1)]
    near = [_near_box(edges.box, edges.first, edges.count, pairs[:, i], boxes[1 - i], bound) for i in (0, 1)]
    row, one, other = _matches(near[0], near[1], edges.box, edges.box, len(pairs), bound)
    np.minimum.at(best, row, segment_distances(edges.ends[one], edges.ends[other]))
    for i in (0, 1):
        faces = _near_box(edges.face_box, edges.first_face, edges.faces, pairs[:, 1 - i], boxes[i], bound)
        row, edge, face = _matches(near[i], faces, edges.box, edges.face_box, len(pairs), bound)
        np.minimum.at(best, row, _edge_to_face(solid, edges.ends[edge], face))
    return best


def _near_box(boxes: Boxes, first: Ints, count: Ints, blocks: Ints, other: Boxes, bound: float) -> tuple[Ints, Ints]:
    """For each row those parts of its block that come within the bound of a box."""
    row, part = members(first[blocks], count[blocks])
    near = ((boxes[0][part] <= other[1][row] + bound) & (boxes[1][part] >= other[0][row] - bound)).all(axis=1)
    return row[near], part[near]


def _matches(
    a: tuple[Ints, Ints], b: tuple[Ints, Ints], box_a: Boxes, box_b: Boxes, n_rows: int, bound: float
) -> tuple[Ints, Ints, Ints]:
    """All pairs of parts of one row whose boxes come within the bound of each other."""
    count = np.bincount(b[0], minlength=n_rows)
    first = np.cumsum(count) - count
    which, other = members(first[a[0]], count[a[0]])
    one, other = a[1][which], b[1][other]
    near = np.ones(len(one), dtype=bool)
    for k in range(3):
        near &= (box_a[0][one, k] <= box_b[1][other, k] + bound) & (box_b[0][other, k] <= box_a[1][one, k] + bound)
    return a[0][which[near]], one[near], other[near]


def segment_distances(one: Floats, other: Floats) -> Floats:
    """Return the distances between segments (Ericson: Real-Time Collision Detection, 2005, section 5.1.9).

    Parameters
    ----------
    one, other : array of float, shape (n, 2, 3)
        Their ends [m]; both may be one point.

    Returns
    -------
    array of float, shape (n,)
        Of each of the first from that of the second [m].

    Examples
    --------
    >>> cross = np.array([[[-1.0, 0, 0], [1, 0, 0]]]), np.array([[[0, -1.0, 2], [0, 1, 2]]])
    >>> point = np.full((1, 2, 3), [4.0, 0, 4])
    >>> [segment_distances(*pair).item() for pair in (cross, (cross[0], point), (point, point))]
    [2.0, 5.0, 0.0]
    """
    p, d = one[:, 0], one[:, 1] - one[:, 0]
    q, e = other[:, 0], other[:, 1] - other[:, 0]
    r = p - q
    a, b, c = _dot(d, d), _dot(d, e), _dot(e, e)
    f, g = _dot(d, r), _dot(e, r)
    skew = a * c - b * b
    s = np.where(skew > 1e-14 * a * c, (b * g - c * f) / np.where(skew > 0, skew, 1.0), 0.0).clip(0, 1)
    t = ((b * s + g) / np.where(c > 0, c, 1.0)).clip(0, 1)
    s = ((b * t - f) / np.where(a > 0, a, 1.0)).clip(0, 1)
    return np.linalg.norm(r + s[:, None] * d - t[:, None] * e, axis=1)


def _edge_to_face(solid: Polyhedra, ends: Floats, face: Ints) -> Floats:
    """Distance of the ends of edges to faces above or below which they lie, zero for an edge through its face."""
    normal = solid.planes.normal[face]
    height = np.einsum("nij,nj->ni", ends - solid.planes.centre[face, None], normal)
    through = height[:, 0] * height[:, 1] < 0
    share = height[:, 0] / np.where(through, height[:, 0] - height[:, 1], 1.0)
    crossing = ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])
    best = np.full(len(face), np.inf)
    for foot, distance, rows in (
        (ends[:, 0], np.abs(height[:, 0]), ~through),
        (ends[:, 1], np.abs(height[:, 1]), ~through),
        (crossing, np.zeros(len(face)), through),
    ):
        rows = np.flatnonzero(rows)
        rows = rows[_over(solid, face[rows], foot[rows])]
        best[rows] = np.minimum(best[rows], distance[rows])
    return best


def _over(solid: Polyhedra, face: Ints, point: Floats) -> np.ndarray:
    """Which points lie over the outline of their face, concave ones too: a ray from inside crosses it an odd number."""
    axes = np.argsort(np.abs(solid.planes.normal[face]), axis=1)[:, :2]
    # A foot lies on the normal of its face, not on an axis.
    height = _dot(point - solid.planes.centre[face], solid.planes.normal[face])
    foot = np.take_along_axis(point - height[:, None] * solid.planes.normal[face], axes, axis=1)
    row, corner = members(solid.face_start[face], np.diff(solid.face_start)[face])
    following = next_in_face(solid.face_start)[corner]
    a, b = (solid.vertices[solid.face_vertices[c]] for c in (corner, following))
    a, b = (np.take_along_axis(x, axes[row], axis=1) - foot[row] for x in (a, b))
    spans = (a[:, 1] > 0) != (b[:, 1] > 0)
    rise = np.where(spans, b[:, 1] - a[:, 1], 1.0)
    crosses = spans & (a[:, 0] - a[:, 1] * (b[:, 0] - a[:, 0]) / rise > 0)
    return np.bincount(row, crosses, len(face)) % 2 == 1


def _dot(a: Floats, b: Floats) -> Floats:
    return np.einsum("ij,ij->i", a, b)
