"""On what each contact of a proof file lies: a face, an edge or a corner of either block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.contact.faces import frames
from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import Interfaces
from blockstat.proof.solids import Solid
from blockstat.typing import Floats, Ints

#: The tolerances that a file states are no less: rounding of coordinates.
LEAST = 1e-9
#: Of faces and edges that fit a point equally well to this share, those are taken that fit a point beside it best.
ALIKE = 1e-9
#: How far beside: a share of the smaller block, or of the way to the middle of a segment. Directions that are tried.
ASIDE, AROUND = 1e-6, 48
#: Where no two faces that fit overlap there, as where those of a rough block are taken for one, others are looked for:
#: next to it or that far away, and worse by a share of the block or a sine.
FURTHER, BROAD = (1e-4, 1e-3, 4e-3), 0.1
ENOUGH = 12  #: of all points that are tried so many lie on both faces, or there may be a better pair


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
        kind, normal = interfaces.kinds[k], interfaces.frame[k, 0]
        one, other = blocks[pair[0]], blocks[pair[1]]
        if kind == ContactKind.FACE:
            found = on_faces(one, other, points, normal)
        else:
            within = points + ASIDE * (points.mean(axis=0) - points)  # what an edge goes into where it crosses a rim
            sides = [(one, points, normal, within), (other, points, -normal, within)]
            found = [on_edge(*side) if kind == ContactKind.CROSSING else on_face(*side) for side in sides]
            if kind != ContactKind.CROSSING:  # on a face of one block
                side = int(found[1].error > found[0].error)
                found[side] = on_edge(*sides[side]) if kind == ContactKind.EDGE else on_corner(*sides[side][:3])
        on += [list(both) for both in zip(found[0].on, found[1].on, strict=True)]
        distance = max(distance, *(place.distance for place in found))
        sine = max(sine, *(place.sine for place in found))
    return on, distance, sine


def on_faces(one: Solid, other: Solid, points: Floats, normal: Floats) -> list[Places]:
    """Return the faces of two blocks that fit each point best; of several in one plane, two that overlap next to it.

    Parameters
    ----------
    one, other
        The blocks.
    points
        Shape (n, 3) [m].
    normal
        From the first block to the other, shape (3,), unit.

    Returns
    -------
    list of Places
        Faces of the first block, and of the other.
    """
    sides = (one, normal), (other, -normal)
    found = [on_face(block, points, out, points) for block, out in sides]
    angle = np.arange(AROUND) * 2.0 * np.pi / AROUND
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) @ frames(normal[None])[0, 1:]
    ring = min(one.size, other.size) * np.concatenate([share * ring for share in (ASIDE, *FURTHER)])
    met = np.zeros(len(points), dtype=bool)
    for f, g in {(f, g) for (f,), (g,) in zip(found[0].on, found[1].on, strict=True)}:
        own = np.array([on == ([f], [g]) for on in zip(found[0].on, found[1].on, strict=True)])
        both = _over(one, f, points[own], ring, normal) & _over(other, g, points[own], ring, normal)
        met[own] = both.sum(axis=1) >= ENOUGH
    for i in np.flatnonzero(~met):
        place = points[i : i + 1]
        facing, _, score = zip(*(_scores(block, place, out, BROAD) for block, out in sides), strict=True)
        near = [np.flatnonzero(own[0] <= own.min() + BROAD) for own in score]
        above = [
            np.array([_over(block, int(facing[k][f]), place, ring, normal)[0] for f in near[k]], dtype=np.int64)
            for k, block in enumerate((one, other))
        ]
        fit = score[0][0][near[0]][:, None] + score[1][0][near[1]]
        shared = above[0] @ above[1].T
        fit = np.where((shared > 0) & (shared >= min(ENOUGH, shared.max())), fit, np.inf)
        if np.isfinite(fit).any():
            for k, best in enumerate(np.unravel_index(fit.argmin(), fit.shape)):
                found[k].on[i] = [int(facing[k][near[k][best]])]
    return [_fitted(block, place.on, points, out) for (block, out), place in zip(sides, found, strict=True)]


def on_face(block: Solid, points: Floats, normal: Floats, within: Floats) -> Places:
    """Return the face of a block that fits each point and the outward normal best.

    Parameters
    ----------
    block
        The block.
    points
        Shape (n, 3) [m].
    normal
        Shape (3,), unit.
    within
        Points next to them, which say what face is taken of several in one plane, shape (n, 3) [m].

    Returns
    -------
    Places
        Faces.
    """
    facing, _, score = _scores(block, points, normal)
    best = _best(score, _scores(block, within, normal)[2])
    return _fitted(block, [[int(k)] for k in facing[best]], points, normal)


def _fitted(block: Solid, on: list[list[int]], points: Floats, normal: Floats) -> Places:
    """Faces with the tolerances that they keep."""
    face = np.array(on)[:, 0]
    off = np.empty(len(points))
    for f in np.unique(face):
        off[face == f] = _off_face(block.corners[block.faces[f]], block.normals[f], points[face == f])
    sine = np.linalg.norm(np.cross(block.normals[face], normal), axis=1)
    sine[block.normals[face] @ normal <= 0] = 1.0
    return Places(on, float(off.max()), float(sine.max()))


def _over(block: Solid, face: int, points: Floats, ring: Floats, normal: Floats) -> np.ndarray:
    """Whether points beside others, seen along a normal, are on a face, shape (n_points, n_ring)."""
    around = (points[:, None] + ring).reshape(-1, 3)
    corners, unit = block.corners[block.faces[face]], block.normals[face]
    height = (around - corners.mean(axis=0)) @ unit
    on = around - (height / (unit @ normal or 1.0))[:, None] * normal
    return _inside(corners, unit, on).reshape(len(points), -1)


def _scores(block: Solid, points: Floats, normal: Floats, slack: float = ALIKE) -> tuple[Ints, Floats, Floats]:
    """Faces that look along a normal, how far off them points are, and how badly they fit; inf: worse by the slack."""
    unit = block.normals
    facing = np.flatnonzero(unit @ normal > 0)
    if not len(facing):
        none = np.full((len(points), 1), np.inf)
        return np.zeros(1, dtype=np.int64), none, none
    sine = np.linalg.norm(np.cross(unit[facing], normal), axis=1)
    low, high = block.face_boxes[facing].swapaxes(0, 1)
    least = np.linalg.norm(np.maximum(np.maximum(low - points[:, None], points[:, None] - high), 0.0), axis=-1)
    off = np.full((len(points), len(facing)), np.inf)
    score = least / block.size + sine
    trial = np.unique(score.argmin(axis=1))
    for _ in range(2):  # those that may be best by their boxes, then all that may be better
        for k in trial:
            off[:, k] = _off_face(block.corners[block.faces[facing[k]]], unit[facing[k]], points)
        reached = (off / block.size + sine).min(axis=1) + slack
        trial = np.setdiff1d(np.flatnonzero((score <= reached[:, None]).any(axis=0)), trial)
    return facing, off, off / block.size + sine


def _best(score: Floats, beside: Floats) -> Ints:
    """The best in each row; of those that are alike the best beside it."""
    alike = score <= score.min(axis=1, keepdims=True) + ALIKE
    return np.where(alike, beside, np.inf).argmin(axis=1)


def _off_face(ring: Floats, unit: Floats, points: Floats) -> Floats:
    """Distances of points from a polygon: from its plane, or from its rim beside it, whichever is more."""
    height = np.abs((points - ring.mean(axis=0)) @ unit)
    beside = _off_segments(ring, np.roll(ring, -1, axis=0), points).min(axis=1)
    return np.where(_inside(ring, unit, points), height, np.maximum(height, beside))


def _inside(ring: Floats, unit: Floats, points: Floats) -> np.ndarray:
    """Whether points are over a polygon."""
    u, v = np.delete(np.arange(3), np.abs(unit).argmax())
    a, b = ring, np.roll(ring, -1, axis=0)
    crosses = (a[:, v] > points[:, None, v]) != (b[:, v] > points[:, None, v])
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, u] + (points[:, None, v] - a[:, v]) * (b[:, u] - a[:, u]) / (b[:, v] - a[:, v])
    inside: np.ndarray = (crosses & (points[:, None, u] < at)).sum(axis=1) % 2 == 1
    return inside


def _off_segments(a: Floats, b: Floats, points: Floats) -> Floats:
    """Distance of each point from each segment, shape (n_points, n_segments)."""
    along, to = b - a, points[:, None] - a
    share = np.clip((to * along).sum(axis=-1) / np.maximum((along**2).sum(axis=1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(to - share[..., None] * along, axis=-1)


def on_edge(block: Solid, points: Floats, normal: Floats, within: Floats) -> Places:
    """Return the edge of a block that fits each point and the outward normal best.

    Parameters
    ----------
    block
        The block.
    points
        Shape (n, 3) [m].
    normal
        Shape (3,), unit.
    within
        Points next to them, which say what edge is taken of several in one line, shape (n, 3) [m].

    Returns
    -------
    Places
        Ends of edges.
    """
    a, b = block.corners[block.edges].swapaxes(0, 1)
    off, beside = _off_segments(a, b, points), _off_segments(a, b, within)
    sine = np.abs((b - a) @ normal) / np.linalg.norm(b - a, axis=1)
    best = _best(off / block.size + sine, beside / block.size + sine)
    ends, distance = block.edges[best].tolist(), float(off[np.arange(len(points)), best].max())
    return Places(ends, distance, max(float(sine[best].max()), _rise(block, ends, normal)))


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
    ends = [[int(i), int(i)] for i in off.argmin(axis=1)]
    return Places(ends, float(off.min(axis=1).max()), _rise(block, ends, normal))


def _rise(block: Solid, ends: list[list[int]], normal: Floats) -> float:
    """Sine of the angle by which the faces beside edges and corners rise above the plane of the contact."""
    rise = 0.0
    for own in {tuple(place) for place in ends}:
        for face, unit in zip(block.faces, block.normals, strict=True):
            for before, at, after in zip(face[-1:] + face[:-1], face, face[1:] + face[:1], strict=True):
                one, two = block.corners[at] - block.corners[before], block.corners[after] - block.corners[at]
                ways = []
                if {at, after} == set(own):
                    ways = [np.cross(unit, two)]
                elif own == (at, at):
                    ways = [-one, two]
                    if one @ two >= 0 or np.cross(one, two) @ unit <= 0:  # else the corner of the face is acute
                        ways += [np.cross(unit, one), np.cross(unit, two)]
                rise = max([rise, *(float(way @ normal / np.linalg.norm(way)) for way in ways)])
    return rise
