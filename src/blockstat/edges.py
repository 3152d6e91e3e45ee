"""Edges and corners that rest on faces, and overlaps: contacts that the model of planar patches does not have.

A mechanism is a proof only if no block runs into another. Patches are checked by the certificate; here it is checked
that no moving corner or edge presses into a face it rests on without a patch.
"""

from __future__ import annotations

import numpy as np

from blockstat.broad import near_pairs
from blockstat.overlap import overlaps
from blockstat.polyhedron import Floats, Ints, next_in_face
from blockstat.problem import Problem

#: Points along an edge that are looked at.
SAMPLES = 5
#: A point this far inside the outline of a face, relative to the smaller block, rests on the face and not on its rim.
INSIDE = 1e-3
#: Speeds into a face below this fraction of the fastest corner are rounding.
SLOW = 1e-6


def edge_warnings(problem: Problem, mechanism: Floats) -> list[str]:
    """Warnings about pairs of blocks that a mechanism drives into each other where only an edge or corner touches."""
    assembly, gap = problem.assembly, problem.gap
    lower, upper = assembly.bounds
    pairs = near_pairs(lower, upper, gap * assembly.size)
    joined = {tuple(pair) for pair in problem.interfaces.pair.tolist()}
    moves = np.abs(mechanism).max(axis=1) > 0
    hidden = [pair for pair in overlaps(assembly, gap=gap)[0].tolist() if tuple(sorted(pair)) not in joined]
    hidden = [pair for pair in hidden if moves[pair].any()]
    if hidden:
        one, two = (assembly.names[i] for i in hidden[0])
        return [
            f'"{one}" and "{two}" overlap too far to have a joint ({len(hidden)} such pairs move), so instability is '
            "not proven"
        ]
    found = []
    for a, b in pairs.tolist():
        if (a, b) in joined or not (moves[a] or moves[b]):
            continue
        if _presses(problem, a, b, mechanism) or _presses(problem, b, a, mechanism):
            found.append((a, b))
    if not found:
        return []
    one, two = (assembly.names[i] for i in found[0])
    return [
        f'"{one}" and "{two}" touch only at an edge or a corner ({len(found)} such pairs would be driven into '
        "each other); such contacts are not modelled, so instability is not proven"
    ]


def _presses(problem: Problem, a: int, b: int, mechanism: Floats) -> bool:
    """Whether a point on an edge of block a rests inside a face of block b and moves into it."""
    assembly = problem.assembly
    size = float(min(assembly.size[a], assembly.size[b]))
    points = _edge_points(assembly.block_vertices(a), assembly.faces_of(a))
    first, last = np.searchsorted(assembly.face_block, [b, b + 1])
    for face in range(first, last):
        normal, centre = assembly.planes.normal[face], assembly.planes.centre[face]
        height = (points - centre) @ normal
        near = points[np.abs(height) <= problem.gap * size]
        if not len(near):
            continue
        corners = assembly.vertices[assembly.face_vertices[assembly.face_start[face] : assembly.face_start[face + 1]]]
        resting = near[_inside(near, corners, normal, INSIDE * size)]
        if len(resting) and (_speed(problem, a, b, resting, mechanism) @ normal).min() < -SLOW:
            return True
    return False


def _edge_points(vertices: Floats, faces: list[Ints]) -> Floats:
    """Points along all edges of a block, ends included."""
    start = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    tail = np.concatenate(faces)
    head = tail[next_in_face(start)]
    share = np.linspace(0, 1, SAMPLES)[:, None, None]
    return ((1 - share) * vertices[tail] + share * vertices[head]).reshape(-1, 3)


def _inside(points: Floats, corners: Floats, normal: Floats, margin: float) -> np.ndarray:
    """Points whose foot lies inside a convex outline by more than a margin."""
    edge = np.roll(corners, -1, axis=0) - corners
    inward = np.cross(normal, edge)
    inward /= np.maximum(np.linalg.norm(inward, axis=1), 1e-300)[:, None]
    return (np.einsum("ek,pek->pe", inward, points[:, None] - corners[None]) > margin).all(axis=1)


def _speed(problem: Problem, a: int, b: int, points: Floats, mechanism: Floats) -> Floats:
    """Velocity of points of block a as seen from block b."""
    velocity = []
    for block in (a, b):
        arm = points - problem.assembly.centroid[block]
        velocity.append(mechanism[block, :3] + np.cross(mechanism[block, 3:], arm))
    return velocity[0] - velocity[1]
