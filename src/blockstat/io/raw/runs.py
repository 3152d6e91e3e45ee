"""Solids that follow one another in one list of faces, where corners cannot tell them apart: bricks share them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from blockstat.errors import InputError, some
from blockstat.geometry.components import connected_components
from blockstat.geometry.convex_pieces import contains
from blockstat.geometry.triangulation import fans
from blockstat.typing import Floats, Ints


def closed_runs(faces: Sequence[Sequence[int]]) -> list[range]:
    """Cut faces into runs of which each is a closed surface.

    A surface is closed where its faces use each edge an even number of times, whichever way round they are listed: one
    face that is turned must not leave its solid open, for a solid that is open takes up all solids after it.

    Parameters
    ----------
    faces : sequence of sequences of int
        Corners of each face. A face that is folded to a line or a point opens and closes nothing, nor does one that is
        listed a second time, within its solid or right after it.

    Returns
    -------
    list of range
        Numbers of the faces of each run; what is left open at the end is the last.

    Examples
    --------
    >>> tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> closed_runs([*tetrahedron, *tetrahedron])
    [range(0, 4), range(4, 8)]
    """
    return _runs(faces)[0]


def is_closed(faces: Sequence[Sequence[int]]) -> bool:
    """Return whether the last of the runs is a closed surface.

    Parameters
    ----------
    faces : sequence of sequences of int
        Corners of each face.

    Returns
    -------
    bool
    """
    return _runs(faces)[1]


def closed_parts(faces: Sequence[Sequence[int]], n_vertices: int) -> list[list[int]]:
    """Cut faces into closed surfaces, first where they share no corner, then where one has closed in their order.

    Parameters
    ----------
    faces : sequence of sequences of int
        Corners of each face.
    n_vertices : int
        Number of corners.

    Returns
    -------
    list of list of int
        Numbers of the faces of each surface, in the order of their first ones; none where a part stays open.

    Examples
    --------
    >>> one = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> other = [[k + 4 for k in face] for face in one]
    >>> closed_parts([face for pair in zip(one, other) for face in pair], 8)
    [[0, 2, 4, 6], [1, 3, 5, 7]]
    """
    edges = [(face[0], corner) for face in faces for corner in face[1:]]
    _, label = connected_components(n_vertices, np.array(edges))
    parts: dict[int, list[int]] = {}
    for number, face in enumerate(faces):
        parts.setdefault(int(label[face[0]]), []).append(number)
    runs = []
    for part in parts.values():
        own = closed_runs([faces[k] for k in part])
        if not is_closed([faces[part[k]] for k in own[-1]]):
            return []
        runs += [part[run.start : run.stop] for run in own]
    return sorted(runs)


def with_cavities(vertices: Floats, faces: Sequence[Sequence[int]], runs: Sequence[Sequence[int]]) -> list[list[int]]:
    """Join cavities to the solids around them.

    Parameters
    ----------
    vertices : array of float, shape (n, 3)
        In the unit of the file.
    faces : sequence of sequences of int
        Corners of each face.
    runs : sequence of sequences of int
        Numbers of the faces of closed surfaces.

    Returns
    -------
    list of list of int
        The same without the surfaces that look inwards from within another one: their faces are those of the smallest
        solid around them. One that looks inwards on its own stays, for it is a solid turned inside out.
    """
    with np.errstate(all="ignore"):  # coordinates that cannot be used are refused later
        surfaces = [_triangles(vertices, [faces[k] for k in run]) for run in runs]
        volume = np.array([np.linalg.det(own - own[0, 0]).sum() / 6 for own in surfaces])
        lower, upper = (np.array([end(own, axis=(0, 1)) for own in surfaces]) for end in (np.min, np.max))
        joined = {k: list(run) for k, run in enumerate(runs)}
        for k in np.flatnonzero(volume < 0).tolist():
            larger = (lower < lower[k]).all(axis=1) & (upper > upper[k]).all(axis=1) & (volume > -volume[k])
            point = vertices[faces[runs[k][0]][0]]
            around = [other for other in np.flatnonzero(larger).tolist() if contains(surfaces[other], point)]
            if around:
                joined[min(around, key=volume.__getitem__)] += joined.pop(k)
    return list(joined.values())


def _triangles(vertices: Floats, faces: Sequence[Sequence[int]]) -> Floats:
    return fans(vertices[np.concatenate([np.asarray(face) for face in faces])], np.cumsum([0, *map(len, faces)]))


def _runs(faces: Sequence[Sequence[int]]) -> tuple[list[range], bool]:
    """Runs of faces, and whether the last of them is closed.

    A face that comes again after its solid may as well be the first face of the next, turned. What closes is right.
    """
    runs, closed = _cut(faces, again=False)
    if not closed:
        others, closed = _cut(faces, again=True)
        runs = others if closed else runs
    return runs, closed


def _cut(faces: Sequence[Sequence[int]], *, again: bool) -> tuple[list[range], bool]:
    """Runs, and whether the last is closed; `again` leaves faces that come again after their solid to it."""
    open_edges: set[tuple[int, int]] = set()
    seen: set[tuple[int, ...]] = set()
    before = seen  # faces of the last solid
    same = again  # all faces since the last solid are faces of that solid
    runs, first = [], 0
    for number, face in enumerate(faces):
        edges = _odd_edges(face)
        start = face.index(min(face)) if edges else 0
        turned = (*face[start:], *face[:start])  # the same wherever its list begins
        if not edges or turned in seen:
            continue
        if same and turned not in before:
            same = False
            if seen:
                runs[-1] = range(runs[-1].start, number)
                first, seen, open_edges = number, set(), set()
        seen.add(turned)
        open_edges ^= edges
        if not open_edges:
            runs.append(range(first, number + 1))
            first, before, seen, same = number + 1, seen, set(), again
    if first < len(faces):
        # Folded faces after the last solid are no solid of their own.
        begin = runs.pop().start if runs and (same or not seen) else first
        runs.append(range(begin, len(faces)))
    return runs, same or not open_edges


def _odd_edges(face: Sequence[int]) -> set[tuple[int, int]]:
    """Edges that a face uses an odd number of times; none where it is folded."""
    odd: set[tuple[int, int]] = set()
    for a, b in zip(face, [*face[1:], *face[:1]], strict=True):
        if a != b:
            odd ^= {(min(a, b), max(a, b))}
    return odd


def check_corners(surfaces: Mapping[str, tuple[Floats, Ints | list[Ints]]]) -> None:
    """Raise InputError with the faces of each object that have a corner that does not exist.

    Parameters
    ----------
    surfaces : mapping of str to (vertices, faces)
        By the name of the object, "" where it needs none: vertices of shape (n, 3), and the corners of one or more
        faces.

    Raises
    ------
    InputError
        For all objects at once.
    """
    wrong = []
    for name, (vertices, faces) in surfaces.items():
        corners = np.ravel(faces) if isinstance(faces, np.ndarray) else np.concatenate(faces)
        owner = np.repeat(np.arange(len(faces)), [len(face) for face in faces])
        if lost := np.unique(owner[(corners < 0) | (corners >= len(vertices))]).tolist():
            label = f'object "{name}": ' if name else ""
            wrong.append(f"{label}a face has a corner that does not exist (face {some(lost)})")
    if wrong:
        raise InputError(*wrong)
