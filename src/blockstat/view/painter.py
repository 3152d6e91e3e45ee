"""The painter's algorithm: in which order to paint blocks so that what is behind is painted first."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.faces import planar
from blockstat.contact.overlap.penetration import convex_blocks, face_separation
from blockstat.geometry import clipping as clip
from blockstat.geometry.broad_phase import near_pairs
from blockstat.geometry.polyhedron import FacePlanes, face_planes, next_in_face
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

AZIMUTH, ELEVATION = -55.0, 25.0  #: where one looks from, where nothing else is asked for [deg]
#: An edge at which a block turns by less than this shows no line: its faces stand for one curved face.
SMOOTH = np.cos(np.deg2rad(20.0))
OUTLINE = (0.45, 0.45, 0.45, 1.0)  #: colour of outlines, as part of the face's
#: Faces within this (sine) of being seen edge-on hide nothing.
EDGE_ON = 1e-6


def looked_at(options: dict[str, Any]) -> tuple[dict[str, Any], Floats]:
    """Return the options of a picture with the angles of the eye among them, and what is seen from there.

    Parameters
    ----------
    options : dict
        Perhaps with "azimuth" and "elevation" [deg].

    Returns
    -------
    dict
        The options, with both.
    array of float, shape (3, 3)
        As `view_of` returns it.
    """
    look = {"azimuth": AZIMUTH, "elevation": ELEVATION} | options
    return look, view_of(look["azimuth"], look["elevation"])


def view_of(azimuth: float, elevation: float) -> Floats:
    """Return the directions of the picture.

    Parameters
    ----------
    azimuth : float
        Angle of the eye about the z axis, from the x axis [deg].
    elevation : float
        Angle of the eye above the horizon [deg].

    Returns
    -------
    array of float, shape (3, 3)
        Unit vectors as rows: right, up, towards the eye.
    """
    a, e = np.deg2rad([azimuth, elevation])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.stack([right, np.cross(eye, right), eye])


def posed(assembly: Assembly, displacement: Floats | None, rotation: Floats | None) -> Floats:
    """Return the vertices of blocks displaced and turned about their centroids.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    displacement : array of float, shape (n_blocks, 3), or None
        Displacements of the centroids [m].
    rotation : array of float, shape (n_blocks, 3, 3), or None
        Rotation matrices.

    Returns
    -------
    array of float, shape (n_vertices, 3)
        Places of the vertices [m].
    """
    if displacement is None and rotation is None:
        return assembly.vertices
    block = assembly.vertex_block
    arm = assembly.vertices - assembly.centroid[block]
    if rotation is not None:
        arm = np.einsum("nij,nj->ni", rotation[block], arm)
    moved = 0.0 if displacement is None else displacement[block]
    return assembly.centroid[block] + arm + moved


def with_copies(assembly: Assembly, blocks: Ints) -> Assembly:
    """Return the assembly with copies of some of its blocks after the others, to be painted elsewhere.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    blocks : array of int
        Those to copy, ascending.

    Returns
    -------
    Assembly
        All blocks, then the copies.
    """
    face = np.flatnonzero(np.isin(assembly.face_block, blocks))
    corner = np.isin(np.repeat(assembly.face_block, np.diff(assembly.face_start)), blocks)
    vertex = np.flatnonzero(np.isin(assembly.vertex_block, blocks))
    moved = np.zeros(len(assembly.vertices), dtype=np.int64)
    moved[vertex] = len(assembly.vertices) + np.arange(len(vertex))
    count = np.diff(assembly.vertex_start)[blocks]
    sizes = np.diff(assembly.face_start)[face]
    number = np.searchsorted(blocks, assembly.face_block[face]) + assembly.n_blocks
    return replace(
        assembly,
        vertices=np.concatenate([assembly.vertices, assembly.vertices[vertex]]),
        vertex_start=np.concatenate([assembly.vertex_start, assembly.vertex_start[-1] + np.cumsum(count)]),
        face_vertices=np.concatenate([assembly.face_vertices, moved[assembly.face_vertices[corner]]]),
        face_start=np.concatenate([assembly.face_start, assembly.face_start[-1] + np.cumsum(sizes)]),
        face_block=np.concatenate([assembly.face_block, number]),
        names=assembly.names + tuple(assembly.names[i] for i in blocks),
        groups=assembly.groups + tuple(assembly.groups[i] for i in blocks),
        density=np.concatenate([assembly.density, assembly.density[blocks]]),
        support=np.concatenate([assembly.support, assembly.support[blocks]]),
    )


def visible(
    assembly: Assembly, vertices: Floats, view: Floats, colour: Floats, layer: Ints | None = None
) -> tuple[list[Floats], Floats, Floats]:
    """Return the faces towards the eye, hidden ones first.

    A face with smooth edges has no outline; a polygon of two corners follows for each other edge of it.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    vertices : array of float, shape (n_vertices, 3)
        Vertices of the blocks as they are drawn [m].
    view : array of float, shape (3, 3)
        Right, up and towards the eye, as `view_of` returns them.
    colour : array of float, shape (n_blocks, 4)
        RGBA of each block, 0 to 1.
    layer : array of int, shape (n_blocks,), optional
        What is painted first wherever it is; see `paint_order`.

    Returns
    -------
    polygons : list of array of float, shape (k, 2)
        Corners in the picture [m].
    fill : array of float, shape (n_polygons, 4)
        Shaded colours of the polygons.
    line : array of float, shape (n_polygons, 4)
        Colours of their outlines.
    """
    corners = vertices[assembly.face_vertices]
    planes = face_planes(corners, assembly.face_start)
    front = np.flatnonzero(planes.normal @ view[2] > 1e-9)
    if convex_blocks(assembly).all():
        rank = np.empty(assembly.n_blocks, dtype=np.int64)
        rank[paint_order(assembly, vertices, planes, view, layer)] = np.arange(assembly.n_blocks)
        order = front[np.lexsort((planes.centre[front] @ view[2], rank[assembly.face_block[front]]))]
    else:
        order = face_order(replace(assembly, vertices=vertices), planes, view, front, layer)
    light = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])
    shade = 0.62 + 0.38 * np.clip(planes.normal[order] @ light, 0, 1)
    colour = colour[assembly.face_block[order]] * np.column_stack([shade, shade, shade, np.ones(len(shade))])
    flat, sharp = corners @ view[:2].T, sharp_edges(assembly, planes)
    polygons, fill, line = [], [], []
    for f, paint in zip(order, np.clip(colour, 0, 1), strict=True):
        own = slice(assembly.face_start[f], assembly.face_start[f + 1])
        polygon, edges, dark = flat[own], np.flatnonzero(sharp[own]), paint * OUTLINE
        smooth = len(edges) < len(polygon)
        segments = [polygon[[k, (k + 1) % len(polygon)]] for k in edges] if smooth else []
        polygons += [polygon, *segments]
        fill += [paint] * (1 + len(segments))
        line += [paint if smooth else dark] + [dark] * len(segments)
    return polygons, np.array(fill).reshape(-1, 4), np.array(line).reshape(-1, 4)


def sharp_edges(assembly: Assembly, planes: FacePlanes) -> np.ndarray:
    """Return which edges show a line: those at which the block turns.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    planes : FacePlanes
        Planes of the faces.

    Returns
    -------
    array of bool, shape (n_corners,)
        One value for the edge after each corner of each face.
    """
    tail = assembly.face_vertices
    head = tail[next_in_face(assembly.face_start)]
    face = np.repeat(np.arange(len(planes.normal)), np.diff(assembly.face_start))
    forward, backward = tail * len(assembly.vertices) + head, head * len(assembly.vertices) + tail
    order = np.argsort(forward)
    found = order[np.minimum(np.searchsorted(forward, backward, sorter=order), len(order) - 1)]
    turn = np.einsum("ij,ij->i", planes.normal[face], planes.normal[face[found]])
    return (forward[found] != backward) | (turn < SMOOTH)


def paint_order(
    assembly: Assembly, vertices: Floats, planes: FacePlanes, view: Floats, layer: Ints | None = None
) -> list[int]:
    """Return the blocks from back to front: exact for convex blocks that do not hide one another in a circle.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    vertices : array of float, shape (n_vertices, 3)
        Vertices of the blocks as they are drawn [m].
    planes : FacePlanes
        Planes of the faces as they are drawn.
    view : array of float, shape (3, 3)
        Right, up and towards the eye, as `view_of` returns them.
    layer : array of int, shape (n_blocks,), optional
        Blocks of opposite sign are painted the negative first, wherever they are. Blocks of layer 0 keep their place
        among both.

    Returns
    -------
    list of int
        Numbers of the blocks.

    Notes
    -----
    Of two blocks that overlap in the picture, one lies beyond a face of the other; if that face looks towards
    the eye, what lies beyond it is painted later. Where faces of both kinds separate them, no ray meets both and
    the order is free. Circles are cut at the block that is furthest away.
    """
    n = assembly.n_blocks
    flat = vertices @ view.T
    first = assembly.vertex_start[:-1]
    lower, upper = np.minimum.reduceat(flat, first), np.maximum.reduceat(flat, first)
    depth = (lower[:, 2] + upper[:, 2]) / 2
    lower[:, 2] = upper[:, 2] = 0.0
    pairs = near_pairs(lower, upper, np.zeros(n))
    slope = planes.normal @ view[2]

    def beyond(which: Ints, faces: np.ndarray) -> Floats:
        return face_separation(vertices, assembly.vertex_start, planes, assembly.face_block, which, faces)

    swapped, towards, away = pairs[:, ::-1], slope > -EDGE_ON, slope < EDGE_ON
    second_later = np.maximum(beyond(pairs, towards), beyond(swapped, away))
    first_later = np.maximum(beyond(pairs, away), beyond(swapped, towards))
    touching = -1e-6 * assembly.size[pairs].min(axis=1)
    tied = np.minimum(second_later, first_later) < touching
    a, b = pairs[tied].T
    second = (second_later > first_later)[tied]
    if layer is not None:
        second = np.where(layer[a] * layer[b] < 0, layer[b] > 0, second)
    return _topological(n, np.where(second, a, b), np.where(second, b, a), depth)


def face_order(assembly: Assembly, planes: FacePlanes, view: Floats, front: Ints, layer: Ints | None = None) -> Ints:
    """Return the faces towards the eye from back to front, for blocks with notches.

    Such a block may hide a neighbour and be hidden by it, so faces are compared: any two that overlap in the picture.

    Parameters
    ----------
    assembly : Assembly
        The blocks, with their vertices where they are drawn.
    planes : FacePlanes
        Planes of the faces as they are drawn.
    view : array of float, shape (3, 3)
        Right, up and towards the eye, as `view_of` returns them.
    front : array of int
        The faces towards the eye.
    layer : array of int, shape (n_blocks,), optional
        What is painted first wherever it is; see `paint_order`.

    Returns
    -------
    array of int
        The same faces in order.
    """
    count = np.diff(assembly.face_start)[front]
    corner = assembly.vertices[assembly.face_vertices] @ view.T
    lower, upper = (f.reduceat(corner, assembly.face_start[:-1])[front] for f in (np.minimum, np.maximum))
    lower[:, 2] = upper[:, 2] = 0.0
    i, j = near_pairs(lower, upper, np.zeros(len(front))).T
    frame, origin = np.broadcast_to(np.roll(view, 1, axis=0), (len(i), 3, 3)), np.zeros((len(i), 3))
    sides = [planar(assembly, front[k], frame, origin, int(count.max())) for k in (i, j)]
    shared, corners = clip.clip(*sides)
    live = np.arange(shared.shape[1]) < corners[:, None]
    middle = (shared * live[..., None]).sum(axis=1) / np.maximum(corners, 1)[:, None]
    nearer = _depth_at(planes, view, front[j], middle) - _depth_at(planes, view, front[i], middle)
    size = np.minimum(*(assembly.size[assembly.face_block[front[k]]] for k in (i, j)))
    seen = (corners > 2) & (clip.area(shared, corners) > 1e-6 * size**2) & (np.abs(nearer) > 1e-9 * size)
    i, j, second = i[seen], j[seen], nearer[seen] > 0
    if layer is not None:
        a, b = (layer[assembly.face_block[front[k]]] for k in (i, j))
        second = np.where(a * b < 0, b > 0, second)
    depth = planes.centre[front] @ view[2]
    return front[_topological(len(front), np.where(second, i, j), np.where(second, j, i), depth)]


def _depth_at(planes: FacePlanes, view: Floats, face: Ints, point: Floats) -> Floats:
    """How near to the eye the plane of each face is at a point of the picture, shape (n,) [m]."""
    local = planes.normal[face] @ view.T
    offset = np.einsum("ij,ij->i", planes.normal[face], planes.centre[face])
    return (offset - np.einsum("ij,ij->i", local[:, :2], point)) / local[:, 2]


def _topological(n: int, behind: Ints, before: Ints, depth: Floats) -> list[int]:
    """Order in which every `behind` comes ahead of its `before`; the deepest first where that leaves a choice."""
    import heapq

    waits = np.bincount(before, minlength=n)
    by_block = np.argsort(behind, kind="stable")
    start = np.searchsorted(behind[by_block], np.arange(n + 1))
    ready = [(depth[i], i) for i in np.flatnonzero(waits == 0)]
    heapq.heapify(ready)
    circle = iter(np.argsort(depth))
    done = np.zeros(n, dtype=bool)
    order: list[int] = []
    while len(order) < n:
        block = heapq.heappop(ready)[1] if ready else next(int(i) for i in circle if not done[i])
        if done[block]:
            continue
        done[block] = True
        order.append(int(block))
        for follower in before[by_block[start[block] : start[block + 1]]]:
            waits[follower] -= 1
            if waits[follower] == 0 and not done[follower]:
                heapq.heappush(ready, (depth[follower], follower))
    return order
