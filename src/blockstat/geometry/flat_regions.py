"""Group neighbouring faces that lie nearly in one plane (hierarchical face clustering)."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np

from blockstat.geometry.polyhedron import Polyhedra
from blockstat.typing import Floats, Ints

#: A face leans by at most this to the plane of its region. Faces of two blocks that are further than 15 degrees from
#: opposed are never one joint (`blockstat.contact.interfaces.ANGLE`); half of it is left to each.
LEAN = np.deg2rad(7.5)


@dataclass(frozen=True)
class _Region:
    """Faces of one block that are merged so far."""

    vertices: Ints  #: numbers, once each
    area: Floats  #: vector area, shape (3,) [m2]
    normals: Floats  #: unit normals of the faces that are wider than the tolerance, shape (n, 3)


def flat_regions(solid: Polyhedra, label: Ints, sides: Ints, tolerance: Floats) -> Ints:
    """Merge regions of faces as long as their corners lie between two near planes.

    Parameters
    ----------
    solid : Polyhedra
        The blocks.
    label : array of int, shape (n_faces,)
        The region of each face to begin with, by its lowest face.
    sides : array of int, shape (n_edges, 2)
        The two faces of each edge.
    tolerance : array of float, shape (n_blocks,)
        Largest distance of the two planes [m]; blocks with zero are left alone.

    Returns
    -------
    array of int, shape (n_faces,)
        The region of each face, by its lowest face.

    Notes
    -----
    A face that is narrower than the tolerance may have any direction: that of a sliver is noise. All others lean to the
    plane of their region, which is that of its vector area, by at most `LEAN`.
    """
    ends = label[sides]
    ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1), axis=0)
    ends = ends[tolerance[solid.face_block[ends[:, 0]]] > 0]
    if not len(ends):
        return label
    merged = np.arange(len(label))
    block = solid.face_block[ends[:, 0]]
    for one in np.unique(block):
        for region, into in _cluster(solid, label, ends[block == one], float(tolerance[one])):
            merged[region] = into
    return merged[label]


def _cluster(solid: Polyhedra, label: Ints, ends: Ints, tolerance: float) -> list[tuple[int, int]]:
    """Which regions of a block are merged into which, the lowest of each."""
    regions, beside = _start(solid, label, ends, tolerance)
    heap = [(cost, *pair) for pair in map(tuple, ends.tolist()) if (cost := _cost(solid, regions, pair, tolerance)) >= 0]
    heapify(heap)
    into: dict[int, int] = {}
    parts: dict[int, list[int]] = {}
    number = len(label)
    while heap:
        _, a, b = heappop(heap)
        if a not in regions or b not in regions:
            continue
        one, other = regions.pop(a), regions.pop(b)
        regions[number] = _Region(
            np.union1d(one.vertices, other.vertices),
            one.area + other.area,
            np.concatenate([one.normals, other.normals]),
        )
        parts[number] = parts.pop(a, [a]) + parts.pop(b, [b])
        beside[number] = (beside.pop(a) | beside.pop(b)) - {a, b}
        for near in beside[number]:
            beside[near] = beside[near] - {a, b} | {number}
            cost = _cost(solid, regions, (near, number), tolerance)
            if cost >= 0:
                heappush(heap, (cost, near, number))
        number += 1
    for members in parts.values():
        into.update(dict.fromkeys(members, min(members)))
    return list(into.items())


def _start(
    solid: Polyhedra, label: Ints, ends: Ints, tolerance: float
) -> tuple[dict[int, _Region], dict[int, set[int]]]:
    """The regions to begin with, and those beside each."""
    beside: dict[int, set[int]] = defaultdict(set)
    for a, b in ends.tolist():
        beside[a].add(b)
        beside[b].add(a)
    first, last = np.searchsorted(solid.face_block, solid.face_block[ends[0, 0]] + np.array([0, 1]))
    regions = {}
    for region in beside:
        faces = first + np.flatnonzero(label[first:last] == region)
        corners = [solid.face_vertices[solid.face_start[f] : solid.face_start[f + 1]] for f in faces]
        vertices = np.unique(np.concatenate(corners))
        area = (solid.planes.normal[faces] * solid.planes.area[faces, None]).sum(axis=0)
        size = float(np.linalg.norm(area))
        length = float(np.linalg.norm(np.ptp(solid.vertices[vertices], axis=0)))
        wide = size > tolerance * length
        regions[region] = _Region(vertices, area, (area / size)[None] if wide else np.empty((0, 3)))
    return regions, dict(beside)


def _cost(solid: Polyhedra, regions: dict[int, _Region], pair: tuple[int, ...], tolerance: float) -> float:
    """How far apart two planes are that hold both regions between them [m]; -1 if they are not one."""
    one, other = regions[pair[0]], regions[pair[1]]
    area = one.area + other.area
    size = float(np.linalg.norm(area))
    if size == 0:
        return -1.0
    normal = area / size
    if min((one.normals @ normal).min(initial=1.0), (other.normals @ normal).min(initial=1.0)) < np.cos(LEAN):
        return -1.0
    height = solid.vertices[np.concatenate([one.vertices, other.vertices])] @ normal
    thickness = float(height.max() - height.min())
    return thickness if thickness <= tolerance else -1.0
