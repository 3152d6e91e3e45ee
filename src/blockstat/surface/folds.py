"""Faces that lie folded on others of their block: what a mesh makes of a concave face that it cuts into a fan.

The triangles of a fan over a concave polygon lie on each other, and some of them look the other way and reach beyond
the polygon. Their signed sum is the polygon: volumes, and edges that are walked both ways, are right. But a triangle
that looks the other way is no face of the stone, and nothing touches it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from blockstat.errors import InputError
from blockstat.geometry.components import connected_components
from blockstat.geometry.polyhedron import Polyhedra, members, merged_vertices, next_in_face
from blockstat.surface.facets import ROUNDING
from blockstat.surface.outlines import boundary, covered
from blockstat.typing import Floats, Ints

Solid = TypeVar("Solid", bound=Polyhedra)

#: Two faces may be in one plane if the cosine between their normals is beyond this. Distances decide.
ALIKE = 0.5
#: Faces fold if they are this near to opposed (cosine): no joint takes a face that leans by more than 15 degrees.
OPPOSED = float(np.cos(np.deg2rad(15.0)))
#: Faces of a block are in one plane if their corners are off it by at most this part of its size, and of its mean
#: thickness. The first is three times what coordinates of four digits round off, as the plane of a face is off, too.
#: What is thicker is a tip that tapers to an edge: its sides share that edge and look opposite ways, too. Of a plate
#: the two sides are not in one plane.
FLAT, THICK = 2.5e-4, 0.0625
#: Corners that are rounded to few digits are looked for with such multiples of `ROUNDING`, up to `FLAT`.
COARSER = (1.0, 10.0, 100.0, 1e3)
#: Folded faces are so many times wider than corners are off their plane. Chosen: the pieces of a concave face are far
#: wider; the neighbours in a noisy scan, which may be folded by chance, are not.
WIDER = 20.0
#: A fold that cannot be resolved is refused if its faces are longer than this part of the size of the block. Chosen:
#: the faces of a scan are shorter, and where noise folds two of them they stay, as no joint hangs on them.
LONG = 0.1


def unfolded(solid: Solid, names: Sequence[str]) -> Solid:
    """Put the faces that they stand for in place of faces that lie folded on each other.

    Parameters
    ----------
    solid : Polyhedra
        Closed blocks.
    names : sequence of str
        Their names, for the message.

    Returns
    -------
    Polyhedra
        The blocks, of the type of `solid`, or `solid` itself where nothing is folded, which is all blocks whose
        faces have been cut into triangles that do not overlap. Vertices without a face are left out.

    Raises
    ------
    InputError
        For folded faces that do not sum up to faces that look one way.

    Notes
    -----
    Two faces are folded if they walk an edge in opposite senses, as neighbours do, lie in one plane, and look opposite
    ways: then they lie on the same side of the edge. The two sides of a plate do not share an edge, and those of two
    solids that touch along one walk it in the same sense. All faces of the block that are connected in this plane are
    summed up: edges that are walked both ways cancel, and what is left is the outline of the true face.

    Examples
    --------
    An angle whose front and back are fans about a corner from which they are not seen whole.

    >>> from blockstat import Assembly, Block
    >>> corners = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    >>> vertices = [(x, y, z) for y in (0, 1) for x, z in corners]
    >>> fan = [[2, 3, 4], [2, 4, 5], [2, 5, 0], [2, 0, 1]]
    >>> back = [[k + 6 for k in face[::-1]] for face in fan]
    >>> sides = [[(k + 1) % 6, k, k + 6, (k + 1) % 6 + 6] for k in range(6)]
    >>> angle = Assembly.from_blocks([Block(vertices, fan + back + sides)])
    >>> len(angle.face_block)
    8
    """
    edges = _neighbours(solid, np.arange(len(solid.vertices)))
    back = edges.sides[_cosine(solid, edges.sides) < -OPPOSED]
    narrow = _narrow(solid, ROUNDING * solid.size)
    if not len(back) and not narrow.any():
        return solid
    surface = np.bincount(solid.face_block, solid.planes.area, solid.n_blocks)
    most = np.minimum(FLAT * solid.size, THICK * 2 * solid.volume / surface)
    for coarser in COARSER:
        allowed = np.maximum(ROUNDING * solid.size, np.minimum(coarser * ROUNDING * solid.size, most))
        # The two sides of a narrow slit or of a sharp rim sum up to a sliver, and are no fold but to rounding.
        solid, wrong = _summed_up(solid, allowed, slivers=coarser == 1.0)
        if wrong and coarser == 1.0:
            raise InputError(
                *(
                    f'block "{names[block]}": face {face} lies folded on a face beside it, and the faces in this plane '
                    "do not sum up to one that looks one way; cut concave faces into triangles that do not overlap"
                    for block, face in wrong
                )
            )
    return solid


def _narrow(solid: Polyhedra, allowed: Floats) -> np.ndarray:
    """Which faces have no width but for rounding, shape (n_faces,)."""
    low, high = solid.face_bounds
    narrow: np.ndarray = solid.planes.area <= allowed[solid.face_block] * np.linalg.norm(high - low, axis=1)
    return narrow


def _long(solid: Polyhedra, faces: Ints) -> bool:
    """Whether one of some faces of a block is long enough for a joint to hang on it."""
    low, high = (bound[faces] for bound in solid.face_bounds)
    return bool(np.linalg.norm(high - low, axis=1).max() > LONG * solid.size[solid.face_block[faces[0]]])


def _summed_up(solid: Solid, allowed: Floats, slivers: bool) -> tuple[Solid, list[tuple[int, int]]]:
    """The blocks without folds, and the block and the face of each long fold that is left."""
    edges = _neighbours(solid, np.arange(len(solid.vertices)))
    narrow = _narrow(solid, allowed)
    seeds = _folds(solid, edges, allowed, narrow)
    if not len(seeds):
        return solid, []
    made: list[tuple[int, list[int]]] = []
    gone = np.zeros(len(narrow), dtype=bool)
    wrong = []
    for faces in _regions(solid, edges, seeds, allowed, narrow):
        block = int(solid.face_block[faces[0]])
        try:
            summed = _summed(solid, faces, edges.vertex, float(allowed[block]), slivers)
            made += [(block, face) for face in summed]
            gone[faces] = True
        except ValueError:
            folded = np.intersect1d(faces, seeds)
            if _long(solid, folded):
                wrong.append((block, int(folded[0] - np.searchsorted(solid.face_block, block))))
    return (_replaced(solid, gone, made) if gone.any() else solid), wrong


@dataclass(frozen=True)
class _Edges:
    """Which faces are beside each other."""

    vertex: Ints  #: shape (n_vertices,), the vertex that stands for this one
    sides: Ints  #: shape (n, 2), faces that walk an edge in opposite senses
    key: Ints  #: shape (n,), the edge, for those that more than two faces share; -1 for others


def _neighbours(solid: Polyhedra, vertex: Ints) -> _Edges:
    """Faces beside each other; vertices at one place count as one in blocks that are not closed otherwise."""
    tail = vertex[solid.face_vertices]
    head = tail[next_in_face(solid.face_start)]
    key = np.minimum(tail, head) * len(vertex) + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    face = np.repeat(np.arange(len(solid.face_block)), np.diff(solid.face_start))[order]
    key, way = key[order], np.sign(head - tail)[order]
    first = np.flatnonzero(np.diff(key, prepend=-1))
    loose = solid.face_block[face[first[np.add.reduceat(way, first) != 0]]]
    if len(loose):
        merged = np.where(np.isin(solid.vertex_block, loose), merged_vertices(solid), vertex)
        if (merged != vertex).any():
            return _neighbours(solid, merged)
    size = np.diff(first, append=len(key))
    crowded = np.repeat(size > 2, size)
    sides, shared = [], []
    for step in range(1, int(size.max())):
        at = np.flatnonzero((key[step:] == key[:-step]) & (way[step:] * way[:-step] < 0))
        sides.append(np.column_stack([face[at], face[at + step]]))
        shared.append(np.where(crowded[at], key[at], -1))
    return _Edges(vertex, np.concatenate(sides), np.concatenate(shared))


def _cosine(solid: Polyhedra, sides: Ints) -> Floats:
    """Between the normals of the two faces of each pair."""
    one, other = solid.planes.normal[sides.T]
    cosine: Floats = np.einsum("ij,ij->i", one, other)
    return cosine


def _folds(solid: Polyhedra, edges: _Edges, allowed: Floats, narrow: np.ndarray) -> Ints:
    """Pairs of faces that are folded on each other, shape (n, 2)."""
    wide = ~narrow[edges.sides].any(axis=1)
    small = _narrow(solid, WIDER * allowed)
    seeds = np.flatnonzero(~small[edges.sides].any(axis=1) & (_cosine(solid, edges.sides) < -OPPOSED))
    seeds = seeds[_in_one_plane(solid, edges.sides[seeds], allowed)]
    crowded = edges.key[seeds] >= 0
    if crowded.any():
        # Solids of one block that touch look opposite ways, too; but they have more planes there than one.
        at = np.flatnonzero(np.isin(edges.key, edges.key[seeds[crowded]]) & wide)
        bent = edges.key[at[~_in_one_plane(solid, edges.sides[at], allowed)]]
        seeds = seeds[~crowded | ~np.isin(edges.key[seeds], bent)]
    found = edges.sides[seeds]
    if not narrow.any():
        return found
    # Faces without width between two that are folded, as where a fan has corners in one line.
    beyond = _beyond_narrow(edges.sides, narrow)
    beyond = beyond[~small[beyond].any(axis=1) & (_cosine(solid, beyond) < -OPPOSED)]
    return np.concatenate([found, beyond[_in_one_plane(solid, beyond, allowed)]])


def _beyond_narrow(sides: Ints, narrow: np.ndarray) -> Ints:
    """Pairs of wide faces that have the same faces without width beside them, shape (n, 2)."""
    at = narrow[sides]
    _, label = connected_components(len(narrow), sides[at.all(axis=1)])
    one = sides[at[:, 0] & ~at[:, 1]]
    other = sides[at[:, 1] & ~at[:, 0]][:, ::-1]
    around: dict[int, set[int]] = {}
    for between, face in np.concatenate([one, other]).tolist():
        around.setdefault(int(label[between]), set()).add(face)
    pairs = [pair for own in around.values() for pair in combinations(sorted(own), 2)]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _regions(solid: Polyhedra, edges: _Edges, seeds: Ints, allowed: Floats, narrow: np.ndarray) -> list[Ints]:
    """The faces around each fold that are connected in its plane."""
    sides = edges.sides[np.isin(solid.face_block[edges.sides[:, 0]], solid.face_block[seeds])]
    near = sides[~narrow[sides].any(axis=1) & (np.abs(_cosine(solid, sides)) > ALIKE)]
    near = np.concatenate([near[_in_one_plane(solid, near, allowed)], seeds])
    _, label = connected_components(len(narrow), near)
    # A bridge to a hole leaves the faces around the hole beside the others in a corner only.
    own = np.flatnonzero(np.isin(solid.face_block, solid.face_block[seeds]))
    corners = {f: edges.vertex[solid.face_vertices[slice(*solid.face_start[f : f + 2])]].tolist() for f in own.tolist()}
    at: dict[int, set[int]] = {}
    for face, ring in corners.items():
        for vertex in ring:
            at.setdefault(vertex, set()).add(face)
    found: list[Ints] = []
    used: set[int] = set()  # a face without width may be in two planes, and counts in one
    for seed in seeds[:, 0].tolist():
        if seed in used:
            continue
        inside = set(np.flatnonzero(label == label[seed]).tolist())
        largest = max(inside, key=lambda face: float(solid.planes.area[face]))
        edge = inside
        while edge:
            beside = set().union(*(at[vertex] for face in edge for vertex in corners[face]))
            around = np.array(sorted(beside - inside - used), dtype=np.int64)
            pairs = np.column_stack([around, np.full(len(around), largest)])
            flat = _in_one_plane(solid, pairs, allowed) & (narrow[around] | (np.abs(_cosine(solid, pairs)) > ALIKE))
            edge = set(around[flat].tolist())
            inside |= edge
        used |= inside
        found.append(np.array(sorted(inside)))
    return found


def _in_one_plane(solid: Polyhedra, sides: Ints, allowed: Floats) -> np.ndarray:
    """Whether the corners of the smaller of two faces lie in the plane of the larger, shape (n,)."""
    planes = solid.planes
    smaller = planes.area[sides].argmin(axis=1)
    row = np.arange(len(sides))
    small, large = sides[row, smaller], sides[row, 1 - smaller]
    owner, corner = members(solid.face_start[small], np.diff(solid.face_start)[small])
    offset = solid.vertices[solid.face_vertices[corner]] - planes.centre[large][owner]
    height = np.abs(np.einsum("ij,ij->i", offset, planes.normal[large][owner]))
    flat = np.ones(len(sides), dtype=bool)
    flat[owner[height > allowed[solid.face_block[small]][owner]]] = False
    return flat


def _summed(solid: Polyhedra, faces: Ints, vertex: Ints, allowed: float, slivers: bool) -> list[list[int]]:
    """Faces that cover the signed sum of some in one plane; raises ValueError where there are no such faces."""
    rings = [vertex[solid.face_vertices[slice(*solid.face_start[f : f + 2])]].tolist() for f in faces.tolist()]
    edges = boundary(rings)
    if not edges:
        return []
    area = solid.planes.normal[faces] * solid.planes.area[faces, None]
    normal = solid.planes.normal[faces[solid.planes.area[faces].argmax()]]
    normal = normal if area.sum(axis=0) @ normal >= 0 else -normal
    used = np.unique(np.concatenate(rings))
    local = solid.vertices[used] - solid.vertices[used].mean(axis=0)
    # Corners are within rounding of the face beside, and so a region may be off its plane by a little more.
    if np.ptp(local @ normal) > 4 * allowed:
        raise ValueError("the faces are not in one plane")
    axis = np.cross(np.eye(3)[np.abs(normal).argmin()], normal)
    axis /= np.linalg.norm(axis)
    flat = local @ np.column_stack([axis, np.cross(normal, axis)])
    return covered(edges, dict(zip(used.tolist(), flat, strict=True)), allowed, slivers=slivers)


def _replaced(solid: Solid, gone: np.ndarray, made: list[tuple[int, list[int]]]) -> Solid:
    """The blocks with other faces in place of some, at the end of each block, and without vertices of no face."""
    kept = np.flatnonzero(~gone)
    owner, corner = members(solid.face_start[kept], np.diff(solid.face_start)[kept])
    sizes = np.concatenate([np.bincount(owner, minlength=len(kept)), [len(ring) for _, ring in made]]).astype(np.int64)
    corners = np.concatenate([solid.face_vertices[corner], *(np.array(ring) for _, ring in made)])
    block = np.concatenate([solid.face_block[kept], [own for own, _ in made]]).astype(np.int64)
    order = np.argsort(block, kind="stable")
    _, place = members((np.cumsum(sizes) - sizes)[order], sizes[order])
    used, corners = np.unique(corners[place], return_inverse=True)
    return replace(
        solid,
        vertices=solid.vertices[used],
        vertex_start=np.searchsorted(used, solid.vertex_start),
        face_vertices=corners.reshape(-1),
        face_start=np.concatenate([[0], np.cumsum(sizes[order])]),
        face_block=block[order],
    )
