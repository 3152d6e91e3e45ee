"""Which faces have their block behind them, and which keep two blocks apart, convex or not."""

from __future__ import annotations

import numpy as np

from blockstat.geometry.polyhedron import Polyhedra, members, next_in_face
from blockstat.typing import Floats, Ints

#: Normals nearer to each other than this cosine (15 degrees) do not count as two.
APART = float(np.cos(np.deg2rad(15.0)))
#: Rows (face of one block, corner of the other) that are held in memory at once.
CHUNK = 2_000_000


def protrusions(blocks: Polyhedra) -> Floats:
    """Return how far the last corner of its block lies in front of each face.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.

    Returns
    -------
    array of float, shape (n_faces,)
        Distances [m]; zero but for rounding, or the warp of the face, where the block is convex.
    """
    planes, first_vertex = blocks.planes, blocks.vertex_start
    first_face = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    n_vertices, n_faces = np.diff(first_vertex), np.diff(first_face)
    kind = n_vertices * (n_faces.max(initial=0) + 1) + n_faces
    found = np.empty(len(blocks.face_block))
    for number in np.unique(kind):
        own = np.flatnonzero(kind == number)
        corner = blocks.vertices[first_vertex[own][:, None] + np.arange(int(n_vertices[own[0]]))]
        face = first_face[own][:, None] + np.arange(int(n_faces[own[0]]))
        origin, normal = corner[:, :1], planes.normal[face]
        offset = np.einsum("nfj,nfj->nf", planes.centre[face] - origin, normal)
        found[face] = (normal @ (corner - origin).swapaxes(1, 2)).max(axis=2) - offset
    return found


def separations(blocks: Polyhedra, pairs: Ints, supporting: np.ndarray) -> tuple[Floats, Floats]:
    """Return how far pairs of blocks are kept apart by the planes of their faces, by the best and by another.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks.
    pairs : array of int, shape (n, 2)
        Numbers of the two blocks of each pair.
    supporting : array of bool, shape (n_faces,)
        Faces that have their whole block behind their plane; no other keeps it apart from anything.

    Returns
    -------
    first : array of float, shape (n,)
        Distance along the normal of the face that separates best [m]; below zero where none does.
    second : array of float, shape (n,)
        The same for the best face whose normal points elsewhere. Where it is not below zero the blocks meet in one line
        at most, and have no unique normal there.
    """
    one, n_one, next_one = _best_faces(blocks, pairs, supporting)
    two, n_two, next_two = _best_faces(blocks, pairs[:, ::-1], supporting)
    alike = np.einsum("ij,ij->i", n_one, -n_two) > APART
    # The better of the two comes first; the other block's best face counts unless it says the same.
    swap = two > one
    first = np.where(swap, two, one)
    own = np.where(swap, next_two, next_one)
    other = np.where(alike, np.where(swap, next_one, next_two), np.where(swap, one, two))
    return first, np.maximum(own, other)


def _best_faces(blocks: Polyhedra, pairs: Ints, supporting: np.ndarray) -> tuple[Floats, Floats, Floats]:
    """For the faces of the first blocks: the best separation, its normal, and the best of the other normals."""
    planes = blocks.planes
    start = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    size = np.column_stack([np.diff(start)[pairs[:, 0]], np.diff(blocks.vertex_start)[pairs[:, 1]]])
    code = size @ [len(blocks.vertices) + 1, 1]
    best, normal, following = np.empty(len(pairs)), np.empty((len(pairs), 3)), np.empty(len(pairs))
    for kind in np.unique(code):
        rows = np.flatnonzero(code == kind)
        faces, vertices = size[rows[0]]
        for own in np.array_split(rows, 1 + len(rows) * faces * vertices // CHUNK):
            face = start[pairs[own, 0]][:, None] + np.arange(faces)
            corner = blocks.vertices[blocks.vertex_start[pairs[own, 1]][:, None] + np.arange(vertices)]
            origin = planes.centre[face[:, :1]]
            across = planes.normal[face]
            offset = np.einsum("nfj,nfj->nf", planes.centre[face] - origin, across)
            lowest = (across @ (corner - origin).swapaxes(1, 2)).min(axis=2) - offset
            lowest[~supporting[face] | ~across.any(axis=2)] = -np.inf
            top = lowest.argmax(axis=1)
            row = np.arange(len(own))
            best[own], normal[own] = lowest[row, top], across[row, top]
            alike = np.einsum("nfj,nj->nf", across, across[row, top]) > APART
            following[own] = np.where(alike, -np.inf, lowest).max(axis=1)
    return best, normal, following


def surface_stays_out(blocks: Polyhedra, pairs: Ints, outward: Floats, depth: Floats) -> np.ndarray:
    """Return of which pairs the surface of the second block stays outside the hull of the first.

    Parameters
    ----------
    blocks : Polyhedra
        The blocks, convex or not.
    pairs : array of int, shape (n, 2)
        Numbers of the two blocks of each pair.
    outward : array of float, shape (n_faces,)
        How far the last corner of its block lies in front of each face [m].
    depth : array of float, shape (n,)
        How deep the surface may reach [m].

    Returns
    -------
    array of bool, shape (n,)
        True proves that no ball with a radius above the depth lies in both blocks. False proves nothing.

    Notes
    -----
    The hull is what lies behind all planes of the first block, each moved out to its last corner. A face whose corners
    all lie in front of one of these planes, but for the depth, does not reach into the hull less a margin of that
    depth. When no face does, that core lies wholly inside the second block or wholly outside, and one point of it tells
    which. The centre of a ball in both blocks would lie in the core and in the second block.
    """
    start = np.searchsorted(blocks.face_block, np.arange(blocks.n_blocks + 1))
    n_faces, n_vertices = np.diff(start)[pairs[:, 0]], np.diff(blocks.vertex_start)[pairs[:, 1]]
    order = np.argsort(n_faces, kind="stable")
    out = np.zeros(len(pairs), dtype=bool)
    first = 0
    while first < len(order):
        # Pairs with numbers of planes alike fill a rectangle; the last has the most.
        last = int(np.searchsorted(n_faces[order], 2 * n_faces[order[first]], side="right"))
        work = np.cumsum(n_vertices[order[first:last]] * n_faces[order[last - 1]])
        last = max(first + 1, first + int(np.searchsorted(work, CHUNK)))
        own = order[first:last]
        out[own] = _stays_out(blocks, start, pairs[own], outward, depth[own])
        first = last
    return out


def _stays_out(blocks: Polyhedra, start: Ints, pairs: Ints, outward: Floats, depth: Floats) -> np.ndarray:
    one, two = pairs[:, 0], pairs[:, 1]
    count = np.diff(start)[one]
    face = start[one][:, None] + np.minimum(np.arange(count.max()), count[:, None] - 1)
    origin, normal = blocks.centroid[one], blocks.planes.normal[face]
    reach = ((blocks.planes.centre[face] - origin[:, None]) * normal).sum(axis=2) + outward[face]
    n_vertices = np.diff(blocks.vertex_start)[two]
    row, vertex = members(blocks.vertex_start[two], n_vertices)
    local = blocks.vertices[vertex] - origin[row]
    height = np.matmul(normal[row], local[:, :, None])[..., 0] - reach[row]
    # One bit for each plane: which have the corner in front.
    front = np.packbits(height >= -depth[row][:, None], axis=1)
    corners = blocks.face_start[start]
    own, corner = members(corners[two], np.diff(corners)[two])
    place = (np.cumsum(n_vertices) - n_vertices - blocks.vertex_start[two])[own] + blocks.face_vertices[corner]
    surface, number = members(start[two], np.diff(start)[two])
    width = np.diff(blocks.face_start)[number]
    clear = np.bitwise_and.reduceat(front[place], np.cumsum(width) - width, axis=0).any(axis=1)
    out = np.logical_and.reduceat(clear, np.flatnonzero(np.diff(surface, prepend=-1)))
    # The centroid is a point of the hull, but it need not lie deep enough in it.
    out &= (reach > depth[:, None]).all(axis=1)
    rows = np.flatnonzero(out)
    out[rows] = ~_inside(blocks, corners, two[rows], origin[rows])
    return out


def _inside(blocks: Polyhedra, corners: Ints, number: Ints, point: Floats) -> np.ndarray:
    """Which blocks hold a point each that is not near their surface, by its solid angle (see `convex_pieces.contains`).

    Faces are seen as fans about the mean of their corners; where the hull of a face does not reach the point, any other
    way to span it comes to the same.
    """
    lower, upper = blocks.bounds
    found: np.ndarray = np.all((point > lower[number]) & (point < upper[number]), axis=1)
    rows = np.flatnonzero(found)
    if not len(rows):
        return found
    own, corner = members(corners[number[rows]], np.diff(corners)[number[rows]])
    following = next_in_face(blocks.face_start)[corner]
    owner = np.repeat(np.arange(len(blocks.face_block)), np.diff(blocks.face_start))
    centre = point[rows][own]
    a = blocks.vertices[blocks.face_vertices[corner]] - centre
    b = blocks.vertices[blocks.face_vertices[following]] - centre
    c = blocks.planes.centre[owner[corner]] - centre
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    angle = 2 * np.arctan2(np.einsum("ij,ij->i", a, np.cross(b, c)), la * lb * lc + ab * lc + bc * la + ca * lb)
    found[rows] = np.bincount(own, angle, len(rows)) > 2 * np.pi
    return found
