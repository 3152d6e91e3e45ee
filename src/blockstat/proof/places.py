"""On what each contact of a proof file lies: a face, an edge or a corner of either block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import Interfaces
from blockstat.proof.solids import Solid
from blockstat.typing import Floats

#: The tolerances that a file states are no less: rounding of coordinates.
LEAST = 1e-9


@dataclass(frozen=True)
class Places:
    """On what contact points lie: `[face]`, the two ends of an edge, or a corner given twice."""

    on: list[list[int]]  #: one a point
    distance: float  #: how far the farthest point is off [m]
    sine: float  #: of the largest angle by which the normal is not that of the place

    @property
    def error(self) -> float:
        """How badly the places fit; both errors are small where they do."""
        return self.distance + self.sine


def contact_places(blocks: list[Solid], interfaces: Interfaces) -> tuple[list[list[list[int]]], float, float]:
    """Find the faces, edges and corners on which contact points lie.

    Parameters
    ----------
    blocks
        The blocks.
    interfaces
        The contacts.

    Returns
    -------
    on : list
        For each point the place on block a and that on block b.
    distance, sine : float
        Tolerances [m, -] that all of them keep.
    """
    on: list[list[list[int]]] = []
    distance, sine = LEAST, LEAST
    for k, pair in enumerate(interfaces.pair.tolist()):
        points = interfaces.point[interfaces.start[k] : interfaces.start[k + 1]]
        kind, normals = interfaces.kinds[k], (interfaces.frame[k, 0], -interfaces.frame[k, 0])
        sides = [(blocks[block], points, normal) for block, normal in zip(pair, normals, strict=True)]
        found = [on_face(*side) for side in sides]
        if kind == ContactKind.CROSSING:
            found = [on_edge(*side) for side in sides]
        elif kind != ContactKind.FACE:  # on a face of one block
            other = int(found[1].error > found[0].error)
            found[other] = (on_edge if kind == ContactKind.EDGE else on_corner)(*sides[other])
        on += [list(both) for both in zip(found[0].on, found[1].on, strict=True)]
        distance = max(distance, *(place.distance for place in found))
        sine = max(sine, *(place.sine for place in found))
    return on, distance, sine


def on_face(block: Solid, points: Floats, normal: Floats) -> Places:
    """Return the face of a block that fits each point and the outward normal best.

    Parameters
    ----------
    block
        The block.
    points
        Shape (n, 3) [m].
    normal
        Shape (3,), unit.

    Returns
    -------
    Places
        Faces.
    """
    unit = block.normals
    facing = np.flatnonzero(unit @ normal > 0)
    if not len(facing):
        return Places([[0]] * len(points), np.inf, 1.0)
    sine = np.linalg.norm(np.cross(unit[facing], normal), axis=1)
    low, high = block.face_boxes[facing].swapaxes(0, 1)
    least = np.linalg.norm(np.maximum(np.maximum(low - points[:, None], points[:, None] - high), 0.0), axis=-1)
    off = np.full((len(points), len(facing)), np.inf)
    score = least / block.size + sine
    trial = np.unique(score.argmin(axis=1))
    for _ in range(2):  # those that may be best by their boxes, then all that may be better
        for k in trial:
            off[:, k] = _off_face(block.corners[block.faces[facing[k]]], unit[facing[k]], points)
        reached = (off / block.size + sine).min(axis=1)
        trial = np.setdiff1d(np.flatnonzero((score <= reached[:, None]).any(axis=0)), trial)
    best = (off / block.size + sine).argmin(axis=1)
    farthest = float(off[np.arange(len(points)), best].max())
    return Places([[int(facing[k])] for k in best], farthest, float(sine[best].max()))


def _off_face(ring: Floats, unit: Floats, points: Floats) -> Floats:
    """Distances of points from a polygon: from its plane, or from its rim beside it, whichever is more."""
    height = np.abs((points - ring.mean(axis=0)) @ unit)
    u, v = np.delete(np.arange(3), np.abs(unit).argmax())
    a, b = ring, np.roll(ring, -1, axis=0)
    crosses = (a[:, v] > points[:, None, v]) != (b[:, v] > points[:, None, v])
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, u] + (points[:, None, v] - a[:, v]) * (b[:, u] - a[:, u]) / (b[:, v] - a[:, v])
    inside = (crosses & (points[:, None, u] < at)).sum(axis=1) % 2 == 1
    return np.where(inside, height, np.maximum(height, _off_segments(a, b, points).min(axis=1)))


def _off_segments(a: Floats, b: Floats, points: Floats) -> Floats:
    """Distance of each point from each segment, shape (n_points, n_segments)."""
    along, to = b - a, points[:, None] - a
    share = np.clip((to * along).sum(axis=-1) / np.maximum((along**2).sum(axis=1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(to - share[..., None] * along, axis=-1)


def on_edge(block: Solid, points: Floats, normal: Floats) -> Places:
    """Return the edge of a block that fits each point and the outward normal best.

    Parameters
    ----------
    block
        The block.
    points
        Shape (n, 3) [m].
    normal
        Shape (3,), unit.

    Returns
    -------
    Places
        Ends of edges.
    """
    a, b = block.corners[block.edges].swapaxes(0, 1)
    off = _off_segments(a, b, points)
    sine = np.abs((b - a) @ normal) / np.linalg.norm(b - a, axis=1)
    best = (off / block.size + sine).argmin(axis=1)
    return _ends(block, block.edges[best].tolist(), off[np.arange(len(points)), best], sine[best], points, normal)


def on_corner(block: Solid, points: Floats, normal: Floats) -> Places:
    """Return the corner of a block next to each point.

    Parameters
    ----------
    block
        The block.
    points
        Shape (n, 3) [m].
    normal
        Shape (3,), unit, outward.

    Returns
    -------
    Places
        Corners, each given twice.
    """
    off = np.linalg.norm(points[:, None] - block.corners, axis=-1)
    best = off.argmin(axis=1)
    return _ends(block, [[int(i), int(i)] for i in best], off.min(axis=1), np.zeros(len(points)), points, normal)


def _ends(block: Solid, ends: list[list[int]], off: Floats, sine: Floats, points: Floats, normal: Floats) -> Places:
    """Places with the angle by which edges that leave them rise above the plane of the contact."""
    rise = 0.0
    for own, point in zip(ends, points, strict=True):
        leaving = np.isin(block.edges, own)
        away = block.corners[np.setdiff1d(block.edges[leaving.any(axis=1)], own)] - point
        rise = max(rise, float((away @ normal / np.linalg.norm(away, axis=1)).max(initial=0.0)))
    return Places(ends, float(off.max()), max(float(sine.max()), rise))
