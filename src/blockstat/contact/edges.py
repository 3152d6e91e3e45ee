"""Edges and corners that rest on faces, and overlaps: contacts that the model of planar patches does not have.

A mechanism is a proof only if no block runs into another. Patches are checked by the certificate; here it is checked
that no moving corner or edge presses into a face it rests on without a patch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.contact.penetration import overlaps
from blockstat.geometry.broad_phase import near_pairs
from blockstat.geometry.polyhedron import members, next_in_face, point_velocity
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Points along an edge that are looked at.
SAMPLES = 5
#: A point this far inside the outline of a face, relative to the smaller block, rests on the face and not on its rim.
INSIDE = 1e-3
#: Speeds into a face below this fraction of the fastest corner are rounding.
SLOW = 1e-6


def edge_warnings(assembly: Assembly, interfaces: Interfaces, gap: float, mechanism: Floats) -> list[str]:
    """Warn of pairs of blocks that a mechanism drives into each other where only an edge or a corner touches.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        The contacts that the model has.
    gap : float
        Tolerance of the contact search, relative to block size.
    mechanism : array, shape (n_blocks, 6)
        Velocity [m] and rotation [rad] of each block; the fastest corner moves by 1 m.

    Returns
    -------
    list of str
        One warning that names a pair, or none.
    """
    lower, upper = assembly.bounds
    pairs = near_pairs(lower, upper, gap * assembly.size)
    joined = {tuple(pair) for pair in interfaces.pair.tolist()}
    moves = np.abs(mechanism).max(axis=1) > 0
    hidden = [pair for pair in overlaps(assembly, gap=gap)[0].tolist() if tuple(sorted(pair)) not in joined]
    hidden = [pair for pair in hidden if moves[pair].any()]
    if hidden:
        one, two = (assembly.names[i] for i in hidden[0])
        return [
            f'"{one}" and "{two}" overlap too far to have a joint ({len(hidden)} such pairs move), so instability is '
            "not proven"
        ]
    bare = np.array([tuple(pair) not in joined for pair in pairs.tolist()], dtype=bool)
    pairs = pairs[bare & moves[pairs].any(axis=1)]
    both = np.concatenate([pairs, pairs[:, ::-1]])
    found = np.unique(np.sort(both[_presses(assembly, both, gap, mechanism)], axis=1), axis=0)
    if not len(found):
        return []
    one, two = (assembly.names[i] for i in found[0])
    return [
        f'"{one}" and "{two}" touch only at an edge or a corner ({len(found)} such pairs would be driven into '
        "each other); such contacts are not modelled, so instability is not proven"
    ]


def _presses(assembly: Assembly, pairs: Ints, gap: float, mechanism: Floats) -> Ints:
    """Pairs of which a point on an edge of the first rests inside a face of the second and moves into it."""
    row, face, points = _near(assembly, pairs, gap)
    inside = _depth(assembly, face, points) > INSIDE * _sizes(assembly, pairs[row])
    row, face, points = row[inside], face[inside], points[inside]
    one, two = (point_velocity(assembly, mechanism, pairs[row, side], points) for side in (0, 1))
    speed = np.einsum("ij,ij->i", one - two, assembly.planes.normal[face])
    return np.unique(row[speed < -SLOW])


def _sizes(assembly: Assembly, pairs: Ints) -> Floats:
    return assembly.size[pairs].min(axis=1)


def _near(assembly: Assembly, pairs: Ints, gap: float) -> tuple[Ints, Ints, Floats]:
    """Points along the edges of the first block of a pair that lie in the plane of a face of the second.

    Returns for each its pair, the face, and itself, shape (k, 3) [m].
    """
    bound = np.searchsorted(assembly.face_block, np.arange(assembly.n_blocks + 1))
    first, count = bound[:-1], np.diff(bound)
    row, face = members(first[pairs[:, 1]], count[pairs[:, 1]])
    # Faces of a block are one run of corners, each the tail of an edge.
    tail, head = assembly.face_vertices, assembly.face_vertices[next_in_face(assembly.face_start)]
    start, corners = assembly.face_start[first], np.diff(assembly.face_start[bound])
    block = pairs[row, 0]
    place, edge = members(start[block], corners[block])
    once = tail[edge] < head[edge]  # two faces share an edge and go along it in opposite ways
    place, edge = place[once], edge[once]
    row, face = row[place], face[place]
    normal, centre = assembly.planes.normal[face], assembly.planes.centre[face]
    low, high = (np.einsum("ij,ij->i", assembly.vertices[end[edge]] - centre, normal) for end in (tail, head))
    share = np.linspace(0, 1, SAMPLES)
    height = np.outer(low, 1 - share) + np.outer(high, share)
    which, sample = np.nonzero(np.abs(height) <= gap * _sizes(assembly, pairs[row])[:, None])
    part = share[sample][:, None]
    points = (1 - part) * assembly.vertices[tail[edge[which]]] + part * assembly.vertices[head[edge[which]]]
    return row[which], face[which], points


def _depth(assembly: Assembly, face: Ints, points: Floats) -> Floats:
    """How far inside the outline of a convex face the foot of each point is [m]."""
    corners = assembly.vertices[assembly.face_vertices]
    edges = corners[next_in_face(assembly.face_start)] - corners
    inward = np.cross(np.repeat(assembly.planes.normal, np.diff(assembly.face_start), axis=0), edges)
    inward /= np.maximum(np.linalg.norm(inward, axis=1), 1e-300)[:, None]
    owner, edge = members(assembly.face_start[face], np.diff(assembly.face_start)[face])
    least = np.full(len(face), np.inf)
    np.minimum.at(least, owner, np.einsum("ij,ij->i", inward[edge], points[owner] - corners[edge]))
    return least
