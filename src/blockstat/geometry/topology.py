"""Edges and corners of polyhedra: which faces meet there, and whether the solid is convex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.geometry.polyhedron import NARROW, Polyhedra, members, next_in_face
from blockstat.typing import Floats, Ints

#: Faces whose normals differ by less than this sine lie in one plane: no edge is between them.
FLAT = 1e-4


@dataclass(frozen=True, eq=False)
class Topology:
    """The edges and corners of some blocks that can touch another block, block after block."""

    edge_start: Ints  #: shape (n_blocks + 1,), edges of block b are edge_start[b]:edge_start[b+1]
    edge: Ints  #: ends of each convex edge, vertex numbers, shape (n_edges, 2)
    inward: Floats  #: directions into its two faces, at right angles to it, shape (n_edges, 2, 3), unit
    corner_start: Ints  #: shape (n_blocks + 1,)
    corner: Ints  #: vertices where three or more faces of different planes meet, shape (n_corners,)
    vertex: Ints  #: shape (n_vertices,), the vertex that stands for this one and its equals
    spoke_start: Ints  #: shape (n_corners + 1,)
    spoke: Floats  #: directions of the edges that leave each corner, shape (n_spokes, 3), unit
    saddle: np.ndarray  #: shape (n_corners,), whether an edge of the corner is a notch
    side: (
        Ints  #: shape (n_face_corners,), the convex edge that begins at that corner of a face, -1 for a flat or a notch
    )


def edge_topology(blocks: Polyhedra, chosen: Ints) -> Topology:
    """Find the convex edges and the corners of some blocks.

    Parameters
    ----------
    blocks : Polyhedra
        Closed blocks. Vertices with exactly equal coordinates count as one.
    chosen : array of int, shape (n,)
        Numbers of the blocks whose edges are wanted.

    Returns
    -------
    Topology
        Edges and corners of these blocks; none of the others.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    >>> found = edge_topology(cube, np.array([0]))
    >>> len(found.edge), len(found.corner)
    (12, 8)
    """
    wanted = np.zeros(blocks.n_blocks, dtype=bool)
    wanted[chosen] = True
    faces = np.flatnonzero(wanted[blocks.face_block])
    owner, slot = members(blocks.face_start[faces], np.diff(blocks.face_start)[faces])
    face = faces[owner]
    vertex = _merged(blocks, slot)
    following = next_in_face(blocks.face_start)
    tail, head = vertex[blocks.face_vertices[slot]], vertex[blocks.face_vertices[following[slot]]]

    # Each edge is walked once in each direction, so the two sorted lists agree row by row.
    n = len(blocks.vertices)
    out, back = np.flatnonzero(tail < head), np.flatnonzero(tail > head)
    out = out[np.argsort(tail[out] * n + head[out], kind="stable")]
    back = back[np.argsort(head[back] * n + tail[back], kind="stable")]
    ends = np.column_stack([tail[out], head[out]])
    line = blocks.vertices[ends[:, 1]] - blocks.vertices[ends[:, 0]]
    along: Floats = line / np.linalg.norm(line, axis=1)[:, None]
    left, right = blocks.planes.normal[face[out]], blocks.planes.normal[face[back]]
    inward: Floats = np.stack([np.cross(left, along), np.cross(along, right)], axis=1).astype(float)
    fold = np.einsum("ij,ij->i", inward[:, 0], right)
    alike = np.einsum("ij,ij->i", left, right) >= 0
    flat = (np.abs(fold) < FLAT) & alike
    convex = ~flat & ((fold < 0) | (~alike & (np.abs(fold) < FLAT)))

    crowded = np.bincount(ends[~flat].reshape(-1), minlength=n) > 2
    edge, inward, whole = _straightened(blocks, ends[convex], inward[convex], crowded)
    side = np.full(len(blocks.face_vertices), -1)
    side[slot[out[convex]]] = side[slot[back[convex]]] = whole
    corner, spoke_start, spoke, saddle = _corners(ends[~flat], along[~flat], ~convex[~flat])
    vertex_block = blocks.vertex_block
    bounds = np.arange(blocks.n_blocks + 1)
    return Topology(
        edge_start=np.searchsorted(vertex_block[edge[:, 0]], bounds),
        edge=edge,
        inward=inward,
        corner_start=np.searchsorted(vertex_block[corner], bounds),
        corner=corner,
        vertex=vertex,
        spoke_start=spoke_start,
        spoke=spoke,
        saddle=saddle,
        side=side,
    )


def least_lean(topology: Topology, corner: Ints, direction: Floats) -> Floats:
    """Return how far the edges of corners lean in a direction at least.

    Parameters
    ----------
    topology : Topology
        Has the corners.
    corner : array of int, shape (n,)
        Numbers of corners.
    direction : array of float, shape (n, 3)
        A unit vector for each.

    Returns
    -------
    array of float, shape (n,)
        The least sine of the angle between an edge and the plane at right angles to the direction.
    """
    owner, spoke = members(topology.spoke_start[corner], np.diff(topology.spoke_start)[corner])
    lean = np.full(len(corner), np.inf)
    np.minimum.at(lean, owner, np.einsum("ij,ij->i", topology.spoke[spoke], direction[owner]))
    return lean


def over_faces(topology: Topology, corner: Ints, frame: Floats, wedge: Floats, within: float) -> np.ndarray:
    """Return whether some of the block of each corner is over a face, seen along its normal from a corner of the face.

    Parameters
    ----------
    topology : Topology
        Has the corners.
    corner : array of int, shape (n,)
        Numbers of those that touch a corner of a face.
    frame : array of float, shape (n, 3, 3)
        Rows normal, t1, t2 of each face.
    wedge : array of float, shape (n, 2)
        From which angle to which the face is seen in its frame [rad].
    within : float
        Angles that differ by less are equal [rad].

    Returns
    -------
    array of bool, shape (n,)
        False where the cones of both, seen along the normal, share no more than a side.
    """
    owner, spoke = members(topology.spoke_start[corner], np.diff(topology.spoke_start)[corner])
    along = np.einsum("ij,itj->it", topology.spoke[spoke], frame[owner][:, 1:])
    seen = np.linalg.norm(along, axis=1) > within
    owner, along = owner[seen], along[seen]
    # Of two cones that overlap, one has a side of the other within it, or its middle.
    half = np.mod(wedge[:, 1] - wedge[:, 0], 2 * np.pi) / 2
    turned = np.arctan2(along[:, 1], along[:, 0]) - (wedge[:, 0] + half)[owner]
    angle = np.pi - np.mod(np.pi - turned, 2 * np.pi)  # of each edge from the middle of the face
    least, left, right = (np.full(len(corner), far) for far in (np.inf, np.inf, -np.inf))
    np.minimum.at(least, owner, np.abs(angle))
    np.minimum.at(left, owner, np.where(angle > 0, angle, np.inf))
    np.maximum.at(right, owner, np.where(angle < 0, angle, -np.inf))
    return (least < half - within) | (left - right < np.pi - within)


def _straightened(blocks: Polyhedra, ends: Ints, inward: Floats, crowded: np.ndarray) -> tuple[Ints, Floats, Ints]:
    """Edges of which those in one line are one, their directions inwards, and what each edge has become part of.

    A vertex at which no third edge ends does not divide an edge of the stone, wherever a mesh puts it.
    """
    following = _in_line(blocks, ends, crowded)
    while len(following):
        _, whole = connected_components(len(ends), following)
        runs = np.split(np.argsort(whole, kind="stable"), np.cumsum(np.bincount(whole))[:-1])
        several = np.flatnonzero(np.bincount(whole) > 1)
        lines = {int(k): _line(blocks, ends[runs[k]], inward[runs[k]]) for k in several}
        curved = [k for k, line in lines.items() if line is None]
        if not curved:
            first = np.array([run[0] for run in runs])
            edge, sides = ends[first], inward[first]
            for k, line in lines.items():
                assert line is not None
                edge[k], sides[k] = line
            return edge, sides, whole
        following = following[~np.isin(whole[following[:, 0]], curved)]
    return ends, inward, np.arange(len(ends))


def _line(blocks: Polyhedra, ends: Ints, inward: Floats) -> tuple[Ints, Floats] | None:
    """The ends of a row of edges and its directions inwards; None where it bends or twists little by little."""
    vertex, times = np.unique(ends, return_counts=True)
    tips = vertex[times == 1]
    if len(tips) != 2:
        return None
    line = blocks.vertices[tips[1]] - blocks.vertices[tips[0]]
    offset = np.linalg.norm(np.cross(blocks.vertices[vertex] - blocks.vertices[tips[0]], line), axis=1)
    if offset.max() > NARROW * float(blocks.size[blocks.vertex_block[tips[0]]]) * float(np.linalg.norm(line)):
        return None
    back = (blocks.vertices[ends[:, 1]] - blocks.vertices[ends[:, 0]]) @ line < 0
    sides = np.where(back[:, None, None], inward[:, ::-1], inward)
    twist = np.linalg.norm(np.cross(sides, sides[:1]), axis=2)
    return (tips, sides[0]) if twist.max() < FLAT and (sides * sides[:1]).sum(axis=2).min() > 0 else None


def _in_line(blocks: Polyhedra, ends: Ints, crowded: np.ndarray) -> Ints:
    """Pairs of edges that go on in one line at a vertex where no other edge ends, shape (n, 2)."""
    order = np.argsort(ends.reshape(-1), kind="stable")
    vertex = ends.reshape(-1)[order]
    at = np.flatnonzero((vertex[1:] == vertex[:-1]) & ~crowded[vertex[1:]])
    place = np.stack([order[at], order[at + 1]])
    arm = blocks.vertices[ends.reshape(-1)[place ^ 1]] - blocks.vertices[vertex[at]]  # the other end of each edge
    turn = np.linalg.norm(np.cross(*arm), axis=1)
    long = np.linalg.norm(arm, axis=2)
    straight = (turn < FLAT * long.prod(axis=0)) & (np.einsum("ij,ij->i", *arm) < 0)
    straight &= turn <= NARROW * blocks.size[blocks.vertex_block[vertex[at]]] * long.sum(axis=0)
    return (place[:, straight] // 2).T


def _merged(blocks: Polyhedra, slot: Ints) -> Ints:
    """For each vertex the one that stands for it: itself, or the first of equal ones where its block needs it."""
    tail, head = blocks.face_vertices[slot], blocks.face_vertices[next_in_face(blocks.face_start)[slot]]
    merged = np.arange(n := len(blocks.vertices))
    key, back = np.sort(tail * n + head), np.sort(head * n + tail)
    short = (blocks.vertices[tail] == blocks.vertices[head]).all(axis=1)
    loose = np.zeros(blocks.n_blocks, dtype=bool)
    loose[blocks.vertex_block[np.concatenate([key[key != back] // n, tail[short]])]] = True
    if not loose.any():
        return merged
    chosen = np.flatnonzero(loose)
    own = members(blocks.vertex_start[chosen], np.diff(blocks.vertex_start)[chosen])[1]
    keys = np.column_stack([blocks.vertex_block[own], blocks.vertices[own] + 0.0])
    _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    merged[own] = own[first[same.reshape(-1)]]
    return merged


def _corners(ends: Ints, along: Floats, notch: np.ndarray) -> tuple[Ints, Ints, Floats, np.ndarray]:
    """Corners with the directions of their edges, and whether one is a notch; a vertex on a straight edge is none."""
    vertex = ends.reshape(-1)
    order = np.argsort(vertex, kind="stable")
    spoke = np.stack([along, -along], axis=1).reshape(-1, 3)[order]
    corner, first, count = np.unique(vertex[order], return_index=True, return_counts=True)
    if not len(corner):
        return corner, np.zeros(1, dtype=np.int64), spoke, np.zeros(0, dtype=bool)
    real = count > 2  # where two faces meet is an edge, also one that bends because they are not quite flat
    saddle = np.logical_or.reduceat(np.repeat(notch, 2)[order], first)
    start = np.concatenate([[0], np.cumsum(count[real])])
    return corner[real], start, spoke[members(first[real], count[real])[1]], saddle[real]
