"""Where the axles of a train stand: the faces along a path, and the load of a train at each place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import InputError
from blockstat.loading.faces import ON, Face
from blockstat.loading.ground import below, depths, dispersed
from blockstat.loads import as_points, up_of
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Stretches of a path shorter than this, relative to the size of a block, are rounding.
SHORT = 1e-6
#: Faces to the left and to the right of a path along a joint are told apart within this distance, relative to the size
#: of a block.
BESIDE = 1e-3


@dataclass(frozen=True, eq=False)
class Road:
    """A path, and the faces that carry a wheel along it."""

    assembly: Assembly
    corners: Floats  #: of the path, shape (n, 3) [m]; without a spread of loads at no height
    length: Floats  #: along the path to each corner, shape (n,) [m]
    faces: tuple[Face, ...]
    start: Floats  #: stretches of the path, ascending, shape (k,) [m]
    end: Floats  #: shape (k,) [m]
    #: the highest face below each stretch, shape (k, 2): two that are as high to the left and to the right of a path
    #: along a joint, else twice the same
    face: Ints

    @property
    def slack(self) -> float:
        """Lengths along the path that differ by less are one place [m]."""
        return SHORT * float(self.assembly.size.min())

    def point(self, along: float) -> Floats:
        """Return the point at a length along the path.

        Parameters
        ----------
        along : float
            Length from the first corner [m]; beyond an end of the path it is that end.

        Returns
        -------
        Floats
            Shape (3,) [m]; at no height where the corners are.
        """
        return np.array([np.interp(along, self.length, self.corners[:, k]) for k in range(3)])

    def wheel(self, along: float, side: int, lane: int = 0) -> Floats:
        """Return the wrenches of a unit force downwards at a length along the path.

        Parameters
        ----------
        along
            [m]
        side
            Where a stretch begins or ends: -1 for what lies before, 1 for what lies after, which beyond an end of the
            path and in a gap is nothing; 0 for the stretch after, or the one before where nothing follows.
        lane
            Where the path runs along a joint: 0 for the face to the left of it, 1 for that to the right.

        Returns
        -------
        Floats
            Shape (n_blocks, 6); zero where the path has no face.
        """
        load = np.zeros((self.assembly.n_blocks, 6))
        slack = self.slack
        on = (self.start <= along + slack) & (self.end >= along - slack)
        if side > 0:
            on &= self.end > along + slack
        elif side < 0:
            on &= self.start < along - slack
        if not on.any():
            return load
        stretches = np.flatnonzero(on)
        face = self.faces[self.face[stretches[0] if side < 0 else stretches[-1], lane]]
        up, point = up_of(self.assembly), self.point(along)
        foot = point - up * float(face.height(point)) / float(face.normal @ up)
        load[face.block] = np.concatenate([-up, np.cross(foot - self.assembly.centroid[face.block], -up)])
        return load


def road_along(
    assembly: Assembly, path: Sequence[Sequence[float]], faces: Sequence[Face], *, spread: float | None = None
) -> Road:
    """Find the faces along a path, the highest where several lie above each other; with a spread, of those below it.

    Parameters
    ----------
    assembly
        The blocks.
    path
        Corners of the path, shape (n, 3) [m]; without a spread their heights do not count, and lengths are in plan.
    faces
        Free faces that look up.
    spread
        As in `train_loads`.

    Returns
    -------
    Road
        The path with its stretches.

    Raises
    ------
    InputError
        For a path of one point, or one that has no face below it.
    """
    corners, up = as_points(path, "path", 2), up_of(assembly)
    if spread is None:
        corners = corners - np.outer(corners @ up, up)
    step = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    slack = SHORT * float(assembly.size.min())
    if (step <= slack).any():
        where = " in plan" if spread is None else ""
        raise InputError(f"path: two of its points that follow each other are the same{where}")
    length = np.concatenate([[0.0], np.cumsum(step)])
    cuts = {0.0, float(length[-1])}
    for k, (one, two) in enumerate(zip(corners[:-1], corners[1:], strict=True)):
        for face in faces:
            cuts |= {float(length[k] + at * step[k]) for at in _crossings(face, one, two, up)}
    marks = np.array(sorted(cuts))
    marks = marks[np.concatenate([[True], np.diff(marks) > slack])]
    numbers = {id(face): k for k, face in enumerate(faces)}
    stretches = []
    for a, b in zip(marks[:-1], marks[1:], strict=True):
        middle = np.array([np.interp((a + b) / 2, length, corners[:, k]) for k in range(3)])
        under = below(faces, middle, up)
        if spread is not None:  # the path has heights, and what stands above it carries nothing
            under = [(face, height) for face, height in under if height <= float(middle @ up) + slack]
        if under:
            top = max(height for _, height in under)
            highest = [face for face, height in under if height >= top - slack]
            k = int(np.searchsorted(length, (a + b) / 2)) - 1
            ahead, radius = corners[k + 1] - corners[k], BESIDE / SHORT * slack
            highest.sort(key=lambda face: _offset(face, middle, up, ahead, radius), reverse=True)
            stretches.append((a, b, (numbers[id(highest[0])], numbers[id(highest[-1])])))
    if not stretches:
        raise InputError("path: no free face of these blocks lies below it")
    start, end, face = (np.array(column) for column in zip(*stretches, strict=True))
    return Road(assembly, corners, length, tuple(faces), start, end, face)


def _offset(face: Face, place: Floats, up: Floats, ahead: Floats, radius: float) -> float:
    """How far to the left of a point what a face has near it lies."""
    from shapely import Point

    there = face.flat(place - up * float(face.height(place)) / float(face.normal @ up))
    near = face.region.intersection(Point(there).buffer(radius)).centroid
    if near.is_empty:
        return 0.0
    return float(np.linalg.det([up, ahead, (np.array([near.x, near.y]) - there) @ face.frame[1:]]))


def _crossings(face: Face, one: Floats, two: Floats, up: Floats) -> list[float]:
    """Where the outline of a face is crossed in plan on the way from one point to the other, from 0 to 1."""
    from shapely import LineString, Point
    from shapely.ops import nearest_points

    drop = [point - up * float(face.height(point)) / float(face.normal @ up) for point in (one, two)]
    line = LineString(face.flat(np.stack(drop)))
    # A path along an edge counts as on the face, as in `below`.
    met: Any = line.intersection(face.region.buffer(ON * face.region.length, join_style="mitre"))
    ends = [part.coords for part in getattr(met, "geoms", [met]) if part.geom_type == "LineString"]
    on_face = [nearest_points(face.region, Point(own[k]))[0] for own in ends if len(own) for k in (0, -1)]
    return [line.project(point) / line.length for point in on_face]


def train_loads(
    road: Road,
    axles: Floats,
    place: Floats,
    side: Ints,
    *,
    spread: float | None,
    footprint: Sequence[float],
    lane: int = 0,
) -> Floats:
    """Return the loads of a train at some places.

    Parameters
    ----------
    road
        The path and its faces.
    axles
        Distance behind the first [m] and force [N] of each axle, shape (n_axles, 2).
    place
        Of the first axle along the path, shape (n,) [m].
    side
        Where an axle stands on a joint or an end of the path, -1 or 1 as in `Road.wheel`, or 0, shape (n,).
    spread, footprint
        As in `blockstat.dispersed_load`; without a spread the axles stand on the faces.
    lane
        As in `Road.wheel`.

    Returns
    -------
    Floats
        Shape (n, n_blocks, 6) [N, N m]; axles beyond the path or with no face below press on nothing.
    """
    loads = np.zeros((len(place), road.assembly.n_blocks, 6))
    for k, (at, way) in enumerate(zip(place, side, strict=True)):
        for behind, force in axles:
            along = at - behind
            if not -road.slack <= along <= road.length[-1] + road.slack:
                continue
            if spread is None:
                loads[k] += force * road.wheel(along, int(way), lane)
            elif depths(road.assembly, road.faces, road.point(along)):
                loads[k] += dispersed(road.assembly, road.faces, road.point(along), force, spread, footprint).wrenches(
                    road.assembly
                )
    return loads


def with_other_lane(
    road: Road, axles: Floats, place: Floats, side: Ints, joint: np.ndarray, wrenches: Floats
) -> tuple[Floats, Ints, Floats]:
    """Add places where a path runs along a joint, with the axles on the blocks to its right.

    Parameters
    ----------
    road, axles, place, side, joint
        As `places_of` takes and returns them.
    wrenches
        Of the train there, on the blocks to the left, shape (n, n_blocks, 6).

    Returns
    -------
    place, side, wrenches
        With those that differ, in the order of their places.
    """
    which = np.where(joint, side, 0)
    right = train_loads(road, axles, place, which, spread=None, footprint=(0.0, 0.0), lane=1)
    differs = (right != wrenches).any(axis=(1, 2))
    place, side = np.append(place, place[differs]), np.append(side, side[differs])
    order = np.lexsort((side, place))
    return place[order], side[order], np.concatenate([wrenches, right[differs]])[order]


def unloaded_warnings(road: Road, axles: Floats, wrenches: Floats) -> list[str]:
    """Return what is to be told of places where a train presses on nothing.

    Parameters
    ----------
    road, axles
        As in `train_loads`.
    wrenches
        Of the train at each place, shape (n, n_blocks, 6).

    Returns
    -------
    list of str
        How many such places there are, and axles that are further apart than the path is long; empty for none.
    """
    told, length = [], float(road.length[-1])
    if (none := np.count_nonzero(~wrenches.any(axis=(1, 2)))) > 0:
        told.append(f"at {none} of {len(wrenches)} places no axle stands on a block, so nothing is loaded there")
    widest = float(np.diff(np.sort(axles[:, 0])).max(initial=0.0))
    if widest > length + road.slack:
        told.append(
            f"two axles that follow each other are {widest:g} m apart, and the path is {length:g} m long: they are "
            "never on it together; distances are in metres behind the first axle"
        )
    return told


def checked_train(axles: Sequence[Sequence[float]]) -> Floats:
    """Return the axles of a train.

    Parameters
    ----------
    axles
        Distance behind the first axle [m] and force downwards [N] of each.

    Returns
    -------
    Floats
        Shape (n_axles, 2).

    Raises
    ------
    InputError
        For an axle that is before the first one, and for a force that is not above 0.
    """
    try:
        train = np.asarray(axles, dtype=float)
    except (TypeError, ValueError):
        train = np.empty(0)
    if (
        train.ndim != 2
        or train.shape[1:] != (2,)
        or not len(train)
        or not np.isfinite(train).all()
        or (train[:, 1] <= 0).any()
        or (train[:, 0] < 0).any()
    ):
        raise InputError(f"axles are {axles!r}; each is a distance behind the first, at least 0, and a force above 0")
    return train


def places_of(
    road: Road, train: Floats, positions: int, joints: bool, *, spread: float | None
) -> tuple[Floats, Ints, np.ndarray]:
    """Return places of the first axle along a path.

    Parameters
    ----------
    road
        The path and its faces.
    train
        Of `checked_train`.
    positions
        How many even ones.
    joints
        Whether to add those where an axle stands where a stretch begins or ends, on both sides. Without, an even one
        where one does is given on both sides.
    spread
        As in `train_loads`; with a spread no axle stands on a block, and there are even places alone.

    Returns
    -------
    place : Floats
        Ascending, shape (n,) [m].
    side : Ints
        -1 or 1 where an axle stands where a stretch begins or ends, 1 elsewhere, shape (n,).
    joint : ndarray
        Where one does, shape (n,).
    """
    last = float(road.length[-1] + train[:, 0].max())
    even = np.linspace(0.0, last, positions) if positions > 1 else np.array([last / 2])
    if spread is not None:
        return even, np.ones(len(even), dtype=np.int64), np.zeros(len(even), dtype=bool)
    ends = np.unique(np.concatenate([road.start, road.end]))
    met = np.unique(ends[:, None] + train[:, 0])
    met = np.append(met[(met > road.slack) & (met < last - road.slack)], [0.0, last][: 2 if len(met) else 0])
    met = np.unique(met)
    met = met[np.diff(met, prepend=-np.inf) > road.slack]
    there = np.searchsorted(met, even - road.slack) < np.searchsorted(met, even + road.slack, side="right")
    if not joints:
        met = even[there]
    after, before = met[met < last], met[met > 0.0]  # beyond both there is no train
    place = np.concatenate([even[~there], after, before])
    side = np.concatenate([np.ones(len(place) - len(before)), -np.ones(len(before))]).astype(np.int64)
    order = np.lexsort((side, place))
    return place[order], side[order], np.isin(place[order], met)
