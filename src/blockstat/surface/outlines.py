"""What directed edges in a plane enclose: outlines, holes, and faces without holes that cover the same."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from blockstat.typing import Floats

#: An edge, from one vertex to another.
Edge = tuple[int, int]


def boundary(rings: list[list[int]]) -> Counter[Edge]:
    """Return the edges that remain of some rings when those that are walked both ways cancel.

    Parameters
    ----------
    rings : list of list of int
        Vertices of each ring in order.

    Returns
    -------
    Counter of (int, int)
        How often each directed edge remains.

    Examples
    --------
    >>> sorted(boundary([[0, 1, 2], [0, 2, 3]]))
    [(0, 1), (1, 2), (2, 3), (3, 0)]
    """
    walked = Counter(edge for ring in rings for edge in zip(ring, ring[1:] + ring[:1], strict=True))
    return Counter({(a, b): n - walked[b, a] for (a, b), n in walked.items() if n > walked[b, a]})


def covered(
    edges: Counter[Edge], place: dict[int, Floats], rounding: float, *, slivers: bool = True
) -> list[list[int]]:
    """Return faces without holes that cover what edges enclose.

    Parameters
    ----------
    edges : Counter of (int, int)
        Directed edges, with what they enclose on their left. As many end at a vertex as begin there.
    place : dict of int to array of float, shape (2,)
        Vertices in the plane [m].
    rounding : float
        How far a vertex may be off [m].
    slivers : bool, optional
        Whether there may be outlines without width.

    Returns
    -------
    list of list of int
        Vertices of each face, counter-clockwise; `boundary` of them is `edges`. An outline without holes is one face,
        any other is cut into triangles, with a corner more where a vertex lies on a side. Outlines without width are
        faces, too, whichever way they are walked.

    Raises
    ------
    ValueError
        For edges that do not enclose each point of a region once and no other point.

    Examples
    --------
    >>> corners = dict(enumerate(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])))
    >>> covered(boundary([[0, 1, 2], [0, 2, 3]]), corners, 1e-9)
    [[0, 1, 2, 3]]
    """
    import shapely

    loops = _loops(edges, place)
    solid = {k: shapely.Polygon([place[v] for v in loop]) for k, loop in enumerate(loops)}
    narrow = [k for k, own in solid.items() if abs(_area(own)) <= rounding * own.length / 2]
    if narrow and not slivers:
        raise ValueError("an outline has no width")
    faces = [loops[k] for k in narrow]
    solid = {k: own for k, own in solid.items() if k not in narrow}
    outer = [k for k, own in solid.items() if _area(own) > 0]
    holes: dict[int, list[int]] = {k: [] for k in outer}
    for k in solid.keys() - set(outer):
        inside = shapely.make_valid(solid[k]).representative_point()
        around = [one for one in outer if shapely.make_valid(solid[one]).contains(inside)]
        if not around:
            raise ValueError("an outline looks the other way")
        holes[min(around, key=lambda one: solid[one].area)].append(k)
    region = [shapely.Polygon(solid[k].exterior, [solid[h].exterior for h in holes[k]]) for k in outer]
    total = sum(map(_area, solid.values()))
    length = sum(own.length for own in solid.values())
    if abs(shapely.union_all([shapely.make_valid(own) for own in region]).area - total) > rounding * length:
        raise ValueError("outlines cross")
    for k in outer:
        rings = [loops[k], *(loops[h] for h in holes[k])]
        faces += _triangles(rings, place) if holes[k] else rings
    if boundary(faces) != edges:
        raise ValueError("triangles leave a gap")
    return faces


def _area(polygon: Any) -> float:
    """The area of a polygon, negative for one that is walked clockwise [m2]."""
    ring = np.array(polygon.exterior.coords)
    ring -= ring[0]
    return float((ring[:-1, 0] * ring[1:, 1] - ring[1:, 0] * ring[:-1, 1]).sum() / 2)


def _loops(edges: Counter[Edge], place: dict[int, Floats]) -> list[list[int]]:
    """Edges as loops, none of which passes through a vertex twice."""
    left: dict[int, list[int]] = {}
    for a, b in sorted(edges.elements()):
        left.setdefault(a, []).append(b)
    loops = []
    for start in sorted(left):
        while left[start]:
            path, step = [start], {start: 0}
            while path:
                before, vertex = path[-2:] if len(path) > 1 else (None, start)
                ahead = _next(before, vertex, left[vertex], place)
                if ahead not in step:
                    step[ahead] = len(path)
                    path.append(ahead)
                    continue
                loop = path[step[ahead] :]
                loops.append(loop)
                # The walk goes on from the vertex that it has met again.
                del path[step[ahead] + 1 :]
                for other in loop[1:]:
                    del step[other]
                if not left[ahead]:
                    path = []
    return loops


def _next(before: int | None, vertex: int, left: list[int], place: dict[int, Floats]) -> int:
    """Take the edge that bounds the same wedge on the left: the first clockwise from where the walk comes from."""
    if before is None or len(left) == 1:
        return left.pop(0)
    back = complex(*(place[before] - place[vertex]))
    turn = [-np.angle(complex(*(place[other] - place[vertex])) / back) % (2 * np.pi) for other in left]
    return left.pop(int(np.argmin(turn)))


def _triangles(rings: list[list[int]], place: dict[int, Floats]) -> list[list[int]]:
    """An outline with holes in triangles, with the vertices that lie on their sides."""
    import mapbox_earcut

    vertices = [v for ring in rings for v in ring]
    corners = np.array([place[v] for v in vertices])
    ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
    cut = mapbox_earcut.triangulate_float64(corners - corners[0], ends).reshape(-1, 3).astype(np.int64)
    one, two = corners[cut[:, 1]] - corners[cut[:, 0]], corners[cut[:, 2]] - corners[cut[:, 0]]
    turned = one[:, 0] * two[:, 1] < one[:, 1] * two[:, 0]
    cut[turned] = cut[turned][:, ::-1]
    faces = [[vertices[k] for k in own] for own in cut.tolist()]
    # Ear clipping leaves out vertices in a line with their neighbours.
    wanted, found = boundary(rings), boundary(faces)
    chord, ahead = found - wanted, dict((wanted - found).keys())

    def whole(face: list[int]) -> list[int]:
        ring = []
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            ring.append(a)
            vertex = ahead.get(a, b) if (a, b) in chord else b
            while vertex != b and vertex not in ring:
                ring.append(vertex)
                vertex = ahead.get(vertex, b)
        return ring

    return [whole(face) for face in faces]
