"""Repair the surface of one block: duplicate vertices, corners on edges, faces that came to nothing or look inwards."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.geometry.convex_pieces import contains
from blockstat.geometry.polyhedron import integrals
from blockstat.geometry.triangulation import fans
from blockstat.geometry.validity import corners_on_edges
from blockstat.typing import Floats

Faces = list[list[int]]


@dataclass(frozen=True)
class RepairedSurface:
    """A surface after repair, and what was done to it."""

    vertices: Floats
    faces: Faces
    merged: int  #: vertices that others stand for now
    spread: float  #: the furthest that merging moved a vertex [m]
    dropped: int  #: faces left out: with fewer than three corners, there already, or walls inside the solid
    turned: int  #: faces listed the other way round now
    inserted: int  #: corners put into the edges of faces that they lie on


def repair_surface(vertices: Floats, faces: Sequence[Sequence[int]], distance: float) -> RepairedSurface:
    """Repair the surface of one block.

    Vertices that are close become one, faces that come to nothing and walls inside the solid are dropped, corners are
    put into the open edges of other faces that they lie on, and faces are turned outwards. The two ends of the slit
    between a face and its hole stay two vertices.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Vertices of one block [m].
    faces : sequence of sequences of int
        Vertex indices of each face.
    distance : float
        Vertices closer than this become one, and corners no further from an open edge than this lie on it [m].

    Returns
    -------
    RepairedSurface
        The surface, and what was changed.
    """
    points, index = merge_vertices(vertices, distance)
    spread = float(np.linalg.norm(vertices - points[index], axis=1).max(initial=0.0))
    kept = _needed([[int(index[c]) for c in face] for face in faces])
    kept, inserted = _with_corners_on_edges(points, kept, distance)
    turn = to_turn(points, kept)
    outward = [face[::-1] if turned else face for face, turned in zip(kept, turn, strict=True)]
    points, outward = _without_repeats(points, outward)
    used = np.unique(np.concatenate([np.asarray(f) for f in outward])) if outward else np.empty(0, int)
    number = {int(corner): i for i, corner in enumerate(used)}
    return RepairedSurface(
        points[used],
        [[number[c] for c in face] for face in outward],
        max(len(vertices) - len(points), 0),
        spread,
        len(faces) - len(kept),
        sum(turn),
        inserted,
    )


def _with_corners_on_edges(points: Floats, faces: Faces, distance: float) -> tuple[Faces, int]:
    """Faces with the corners of other faces that lie on their open edges, and how many there are.

    A real hole stays open, for an edge takes no corner but of other open edges along it.
    """
    walked = Counter(frozenset(edge) for face in faces for edge in zip(face, face[1:] + face[:1], strict=True))
    odd = [edge for edge, times in walked.items() if times % 2]
    if not odd:
        return faces, 0
    ends = np.array([sorted(edge) for edge in odd])
    on = dict(zip(odd, (own.tolist() for own in corners_on_edges(points, ends, distance)), strict=True))
    found = []
    for face in faces:
        own: list[int] = []
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            between = [corner for corner in on.get(frozenset((a, b)), ()) if corner not in face]
            own += [a, *(between if a < b else between[::-1])]
        found.append(own)
    return found, sum(map(len, found)) - sum(map(len, faces))


def _needed(faces: Faces) -> Faces:
    """Faces of three or more corners, each once. Of a wall inside a solid, which is listed from both sides, none."""
    faces = [[c for c, before in zip(face, face[-1:] + face[:-1], strict=True) if c != before] for face in faces]
    faces = [face for face in faces if len(face) >= 3]
    copies = Counter(map(frozenset, faces))
    around: dict[frozenset[int], set[frozenset[int]]] = defaultdict(set)
    for face in faces:
        for edge in zip(face, face[1:] + face[:1], strict=True):
            around[frozenset(edge)].add(frozenset(face))
    first = {frozenset(face): face for face in reversed(faces)}
    kept = []
    for face in faces:
        # Without a wall, two other faces meet at each of its edges; without a face that is listed twice, only one is.
        edges = map(frozenset, zip(face, face[1:] + face[:1], strict=True))
        wall = copies[frozenset(face)] > 1 and all(len(around[edge]) > 2 for edge in edges)
        if first[frozenset(face)] is face and not wall:
            kept.append(face)
    return kept


def _without_repeats(points: Floats, faces: Faces) -> tuple[Floats, Faces]:
    """Points and faces where one that comes back to a corner, along the slit to its hole, has another vertex there."""
    more: list[Floats] = []
    found = []
    for face in faces:
        own: list[int] = []
        for corner in face:
            if corner in own:
                more.append(points[corner])
                corner = len(points) + len(more) - 1
            own.append(corner)
        found.append(own)
    return (np.concatenate([points, more]) if more else points), found


def merge_vertices(vertices: Floats, distance: float) -> tuple[Floats, np.ndarray]:
    """Merge vertices that are close to each other.

    Vertices belong together when a chain of steps of at most the distance joins them.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Vertices of one block [m].
    distance : float
        Longest step [m].

    Returns
    -------
    points : array of float, shape (n_points, 3)
        Means of the groups of vertices [m].
    index : array of int, shape (n_vertices,)
        The point of each vertex.
    """
    from scipy.spatial import KDTree

    n = len(vertices)
    pairs = KDTree(vertices).query_pairs(distance, output_type="ndarray")
    count, index = connected_components(n, pairs)
    if count == n:
        return vertices, np.arange(n)
    total = np.zeros((count, 3))
    np.add.at(total, index, vertices)
    return total / np.bincount(index)[:, None], index


def to_turn(vertices: Floats, faces: Faces) -> list[bool]:
    """Return which faces must be listed the other way round for all to look outwards.

    Parameters
    ----------
    vertices : array of float, shape (n_vertices, 3)
        Vertices of one block [m].
    faces : sequence of sequences of int
        Vertex indices of each face.

    Returns
    -------
    list of bool
        True for a face that must be turned.

    Notes
    -----
    Faces that share an edge must walk it in opposite directions. A connected surface of which some faces disagree is
    turned so that its volume is positive, or negative where it lies inside another one of the block: it is a cavity.
    Surfaces that agree within themselves are left, unless the volume of the whole block is negative, or there are
    several, all closed: then each of them is turned as if some of its faces disagreed.
    """
    walked: dict[tuple[int, int], list[tuple[int, bool]]] = defaultdict(list)
    for number, face in enumerate(faces):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            walked[min(a, b), max(a, b)].append((number, a < b))
    turn, surfaces = _agreeing(walked, len(faces))
    closed = len(surfaces) > 1 and all(len(edge) == 2 for edge in walked.values())
    doubtful = [k for k, own in enumerate(surfaces) if closed or any(turn[f] for f in own)]
    cavities = _cavities(vertices, [[_turned(faces, turn, f) for f in own] for own in surfaces], doubtful)
    for k in doubtful:
        if (-1 if k in cavities else 1) * _volume(vertices, faces, turn, surfaces[k]) < 0:
            turn |= {f: not turn[f] for f in surfaces[k]}
    if faces and _volume(vertices, faces, turn, range(len(faces))) < 0:
        turn = {face: not turned for face, turned in turn.items()}
    return [turn[f] for f in range(len(faces))]


def _agreeing(
    walked: dict[tuple[int, int], list[tuple[int, bool]]], n_faces: int
) -> tuple[dict[int, bool], list[list[int]]]:
    """Which faces to turn so that those of each connected surface agree with its first, and these surfaces."""
    beside: dict[int, list[tuple[int, bool]]] = defaultdict(list)
    for edge in walked.values():
        if len(edge) == 2:
            (f, forward), (g, again) = edge
            beside[f].append((g, forward == again))
            beside[g].append((f, forward == again))
    turn: dict[int, bool] = {}
    surfaces = []
    for start in range(n_faces):
        if start in turn:
            continue
        turn[start], surface, front = False, [start], [start]
        while front:
            face = front.pop()
            for other, against in beside[face]:
                if other not in turn:
                    turn[other] = turn[face] != against
                    surface.append(other)
                    front.append(other)
        surfaces.append(surface)
    return turn, surfaces


def _cavities(vertices: Floats, surfaces: Sequence[Faces], asked: Sequence[int]) -> set[int]:
    """Which of some surfaces lie inside an odd number of the others: a cavity does, a stone in a cavity does not."""
    if not asked or len(surfaces) < 2:
        return set()
    corners = [vertices[np.unique(np.concatenate([np.asarray(face) for face in own]))] for own in surfaces]
    lower = np.array([own.min(axis=0) for own in corners])
    upper = np.array([own.max(axis=0) for own in corners])
    found = set()
    for k in asked:
        larger = np.flatnonzero((lower < lower[k]).all(axis=1) & (upper > upper[k]).all(axis=1))
        if sum(_goes_round(vertices, surfaces[other], corners[k][0]) for other in larger.tolist()) % 2:
            found.add(k)
    return found


def _goes_round(vertices: Floats, faces: Faces, point: Floats) -> bool:
    """Whether a surface of faces that agree goes round a point, whichever way they look."""
    corners, start = vertices[np.concatenate([np.asarray(face) for face in faces])], np.cumsum([0, *map(len, faces)])
    triangles = fans(corners, start)
    return contains(triangles, point) or contains(triangles[:, ::-1], point)


def _turned(faces: Faces, turn: dict[int, bool], face: int) -> list[int]:
    return faces[face][::-1] if turn[face] else faces[face]


def _volume(vertices: Floats, faces: Faces, turn: dict[int, bool], chosen: Sequence[int]) -> float:
    lists = [_turned(faces, turn, f) for f in chosen]
    start = np.concatenate([[0], np.cumsum([len(face) for face in lists])])
    corners = vertices[np.concatenate([np.asarray(face) for face in lists])]
    return float(integrals(corners, start, np.zeros(len(lists), dtype=np.int64), 1).volume[0])
