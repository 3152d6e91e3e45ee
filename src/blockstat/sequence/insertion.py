"""Whether a block can be put in by a straight motion that collides with nothing.

A block that comes along -d leaves along d. Its joints leave a cone of directions open, {d : n'd >= 0} with n their
normals towards the block. Tried are upwards, the mean of the normals, each of them, and the edges of the cone. Along a
direction the block collides when one of its corners meets a face of another block, a corner of another block meets one
of its faces, or two edges cross: seen along d, each is a test in the plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.geometry.triangulation import triangulate
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A block that slides along its joints grazes them: it is made smaller by this share about its centroid.
SMALLER = 1e-3
#: Directions that lean into a joint by less than this sine are along it.
ALONG = 1e-6


def insertion_direction(assembly: Assembly, interfaces: Interfaces, block: int, present: np.ndarray) -> Floats | None:
    """Find a direction along which a block can be put in beside others.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    interfaces : Interfaces
        Their joints.
    block : int
        The block.
    present : array of bool, shape (n_blocks,)
        Which others are there.

    Returns
    -------
    array of float, shape (3,), or None
        A unit vector; None where none of the directions that are tried is free.

    Examples
    --------
    A drawer between two cheeks and below a lid comes in from the front.

    >>> import numpy as np
    >>> from blockstat import Assembly, box, find_interfaces
    >>> from blockstat.sequence.insertion import insertion_direction
    >>> blocks = [box((0, 0, 0), (3, 1, 1)), box((0, 0, 1), (1, 1, 2)), box((2, 0, 1), (3, 1, 2)),
    ...           box((0, 0, 2), (3, 1, 3)), box((1, 0, 1), (2, 1, 2))]
    >>> chest = Assembly.from_blocks(blocks, supports=[0])
    >>> np.abs(insertion_direction(chest, find_interfaces(chest), 4, np.ones(5, bool))).round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    away = _normals(interfaces, block, present)
    up = -assembly.gravity / np.linalg.norm(assembly.gravity)
    others = present.copy()
    others[block] = False
    for direction in _directions(away, up):
        if not _collides(assembly, block, np.flatnonzero(others), direction):
            return -direction
    return None


def _normals(interfaces: Interfaces, block: int, present: np.ndarray) -> Floats:
    """Normals of the joints of a block with others that are present, towards the block, shape (n, 3)."""
    pair = interfaces.pair
    own = (pair == block).any(axis=1) & (present[pair] | (pair == block)).all(axis=1)
    sign = np.where(pair[own, 1] == block, 1.0, -1.0)
    return interfaces.frame[own, 0] * sign[:, None]


def _directions(away: Floats, up: Floats) -> Floats:
    """Unit vectors in the cone that the joints leave open, shape (n, 3)."""
    unique = np.unique(away.round(6), axis=0)
    first, second = np.triu_indices(len(unique), 1)
    edges = np.cross(unique[first], unique[second])
    tried = np.concatenate([[up], away.sum(axis=0)[None], unique, edges, -edges])
    length = np.linalg.norm(tried, axis=1)
    tried = tried[length > ALONG] / length[length > ALONG, None]
    return tried[(tried @ away.T >= -ALONG).all(axis=1)]


def _collides(assembly: Assembly, block: int, others: Ints, direction: Floats) -> bool:
    """Whether a block that leaves along a direction runs into one of the others."""
    across = np.linalg.svd(direction[None])[2][1:]
    axes = np.vstack([across, direction])
    own = assembly.block_vertices(block) @ axes.T
    centre = axes @ assembly.centroid[block]
    own = centre + (1 - SMALLER) * (own - centre)
    corner = assembly.vertices @ axes.T
    low, high = (f.reduceat(corner, assembly.vertex_start[:-1]) for f in (np.minimum, np.maximum))
    ahead = (high[others] > own.min(axis=0)).all(axis=1) & (low[others, :2] < own.max(axis=0)[:2]).all(axis=1)
    others = others[ahead]
    if not len(others):
        return False
    faces = _triangles(assembly, block), np.concatenate([_triangles(assembly, int(k)) for k in others])
    first = assembly.vertex_start[block]
    mine, theirs = own[faces[0] - first], corner[faces[1]]
    points = corner[np.concatenate([np.arange(*assembly.vertex_start[k : k + 2]) for k in others])]
    back = np.array([1.0, 1.0, -1.0])
    return _meets(own, theirs) or _meets(points * back, mine * back) or _crosses(_edges(mine), _edges(theirs))


def _triangles(assembly: Assembly, block: int) -> Ints:
    """Corners of the faces of a block cut into triangles, as numbers of vertices, shape (n, 3)."""
    first = assembly.vertex_start[block]
    return triangulate(assembly.block_vertices(block), assembly.faces_of(block)) + first


def _meets(point: Floats, triangle: Floats) -> bool:
    """Whether a point moving along the last axis meets a triangle."""
    a, b, c = (triangle[None, :, k] for k in range(3))
    p = point[:, None]

    def area(u: Floats, v: Floats, w: Floats) -> Floats:
        return (v[..., 0] - u[..., 0]) * (w[..., 1] - u[..., 1]) - (v[..., 1] - u[..., 1]) * (w[..., 0] - u[..., 0])

    whole = area(a, b, c)
    parts = np.stack([area(b, c, p), area(c, a, p), area(a, b, p)]) * np.sign(whole)
    inside = (parts > 0).all(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = (parts * np.stack([a[..., 2], b[..., 2], c[..., 2]])).sum(axis=0) / np.abs(whole)
    return bool((inside & (height > p[..., 2])).any())


def _edges(triangle: Floats) -> Floats:
    """The sides of triangles, each once, shape (n, 2, 3)."""
    sides = triangle[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2, 3)
    ascending: Any = (sides[:, 0] < sides[:, 1]).any(axis=1)
    ordered = np.where(ascending[:, None, None], sides, sides[:, ::-1])
    return np.unique(ordered.reshape(-1, 6), axis=0).reshape(-1, 2, 3)


def _crosses(mine: Floats, theirs: Floats) -> bool:
    """Whether an edge that moves along the last axis crosses another."""
    start, way = mine[:, None, 0], (mine[:, 1] - mine[:, 0])[:, None]
    other, run = theirs[None, :, 0], (theirs[:, 1] - theirs[:, 0])[None]
    between = other - start
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = way[..., 0] * run[..., 1] - way[..., 1] * run[..., 0]
        s = (between[..., 0] * run[..., 1] - between[..., 1] * run[..., 0]) / turn
        t = (between[..., 0] * way[..., 1] - between[..., 1] * way[..., 0]) / turn
        ahead = between[..., 2] + t * run[..., 2] - s * way[..., 2]
        return bool(((s > 0) & (s < 1) & (t > 0) & (t < 1) & (ahead > 0)).any())
