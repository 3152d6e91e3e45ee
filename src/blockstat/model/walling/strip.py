"""A strip: one straight or round stretch of wall, and blocks between planes in its own coordinates.

Coordinates of a strip: s along it, d across it (positive to the left of s), z up [m]. Every face of a brick is a plane
in them: beds z = const, faces d = c + k z, ends s = s0 + kd d + kz z (`Edge`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.solids import FACES, polyhedron, prism
from blockstat.model.walling.run import Run
from blockstat.typing import Floats

#: A plane across a strip: s = s0 + kd d + kz z.
Edge = tuple[float, float, float]
#: A plane along a strip: d = c + k z.
Face = tuple[float, float]


def upright(s: float) -> Edge:
    """The upright plane square to a strip.

    Parameters
    ----------
    s : float
        Place along the strip [m].

    Returns
    -------
    Edge
        The plane.
    """
    return (float(s), 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Line:
    """The straight axis of a strip."""

    origin: Floats
    along: Floats  #: unit vector, shape (2,)
    length: float

    @cached_property
    def across(self) -> Floats:
        """Unit vector to the left, shape (2,)."""
        return np.array([-self.along[1], self.along[0]])

    def place(self, s: Floats, d: Floats) -> Floats:
        """Points in plan.

        Parameters
        ----------
        s : ndarray
            Along the axis [m].
        d : ndarray
            To the left of it [m].

        Returns
        -------
        ndarray
            x, y, shape (..., 2) [m].
        """
        return self.origin + s[..., None] * self.along + d[..., None] * self.across


@dataclass(frozen=True, eq=False)
class Ring:
    """A round axis, counter-clockwise, d towards its centre; with tails, straight stretches along its tangents."""

    centre: Floats
    radius: float
    start: float  #: angle where the arc begins [rad]
    arc: float  #: length of the arc [m]
    tails: tuple[float, float] = (0.0, 0.0)  #: lengths of the stretches before and after it [m]

    @property
    def length(self) -> float:
        """Length of the arc and its tails [m]."""
        return self.arc + sum(self.tails)

    def place(self, s: Floats, d: Floats) -> Floats:
        """Points in plan.

        Parameters
        ----------
        s : ndarray
            Along the axis [m].
        d : ndarray
            Towards the centre [m].

        Returns
        -------
        ndarray
            x, y, shape (..., 2) [m].
        """
        beyond = s - self.tails[0]
        on_arc = np.clip(beyond, 0.0, self.arc) if any(self.tails) else beyond
        angle = self.start + on_arc / self.radius
        out = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        along = np.stack([-out[..., 1], out[..., 0]], axis=-1)
        return self.centre + (self.radius - d)[..., None] * out + (beyond - on_arc)[..., None] * along


@dataclass(frozen=True, eq=False)
class Strip:
    """One stretch of wall: its axis, its faces and how many courses it has."""

    run: Run
    axis: Line | Ring
    right: Face
    left: Face
    levels: tuple[float, ...]  #: heights of the beds of the whole work [m]
    top: int  #: courses up to the eaves
    ridge: int  #: courses up to the ridge of the gable; `top` where there is none
    group: str
    segment: int = 0  #: which stretch of the path of its run
    ends: tuple[tuple[float, float], ...] = ()  #: (z, s) of its free end, where that is no upright plane

    @property
    def coped(self) -> int:
        """The course that is the coping, -1 for none."""
        return self.top - 1 if self.run.coping is not None and self.ridge == self.top else -1

    def bed(self, course: int) -> tuple[float, float]:
        """Heights of the beds of a course.

        Parameters
        ----------
        course : int
            Counted from the ground.

        Returns
        -------
        tuple of float
            Lower and upper [m].
        """
        return self.levels[course], self.levels[course + 1]

    def faces(self, course: int) -> tuple[Face, Face]:
        """Right and left face in a course; a coping's are upright and overhang.

        Parameters
        ----------
        course : int
            Counted from the ground.

        Returns
        -------
        tuple of Face
            Right, then left.
        """
        if course != self.coped or self.run.coping is None:
            return self.right, self.left
        z, over = self.levels[course], self.run.coping.overhang
        return (self.right[0] + self.right[1] * z - over, 0.0), (self.left[0] + self.left[1] * z + over, 0.0)

    def far_end(self, course: int) -> Edge:
        """The plane of the free far end in a course.

        Parameters
        ----------
        course : int
            Counted from the ground.

        Returns
        -------
        Edge
            The plane.
        """
        if not self.ends:
            return upright(self.axis.length)
        z0, z1 = self.bed(course)
        rounding = 1e-9 * (z1 - z0)
        for (za, sa), (zb, sb) in zip(self.ends, self.ends[1:], strict=False):
            if za <= z0 + rounding and zb >= z1 - rounding:
                slope = (sb - sa) / (zb - za)
                return (sa - slope * za, 0.0, slope)
        raise AssertionError("the corners of a far end are on beds")

    def points(self, s: Floats, d: Floats, z: Floats) -> Floats:
        """Points in space.

        Parameters
        ----------
        s : ndarray
            Along the strip [m].
        d : ndarray
            Across it, to the left [m].
        z : ndarray
            Up [m].

        Returns
        -------
        ndarray
            x, y, z, shape (..., 3) [m].
        """
        return np.concatenate([self.axis.place(s, d), z[..., None]], axis=-1)

    def bricks(
        self, courses: Sequence[int], ends: Floats, leaves: Floats, names: Sequence[str], groups: Sequence[str]
    ) -> list[Block]:
        """Blocks between two beds, two edges and two places across the strip.

        Parameters
        ----------
        courses : sequence of int
            The course of each, length n.
        ends : ndarray
            The edges that bound each, shape (n, 2, 3).
        leaves : ndarray
            From right face (0) to left (1), shape (n, 2).
        names : sequence of str
            Length n.
        groups : sequence of str
            Length n.

        Returns
        -------
        list of Block
            In the same order.
        """
        if not len(ends):
            return []
        number = np.array(courses)
        z = np.repeat(np.array(self.levels)[np.stack([number, number + 1], axis=1)], 4, axis=1)
        faces = np.array([self.faces(course) for course in range(max(courses) + 1)])[number]
        (rc, rk), (lc, lk) = faces.transpose(1, 2, 0)[..., None]
        share = np.concatenate([leaves[:, (0, 0, 1, 1)]] * 2, axis=1)
        right = rc + rk * z
        d = right + share * (lc + lk * z - right)
        edge = ends[:, (0, 1, 1, 0, 0, 1, 1, 0)]
        s = edge[..., 0] + edge[..., 1] * d + edge[..., 2] * z
        corners = self.points(s, d, z)
        pointed = np.abs(s[:, (1, 2, 5, 6)] - s[:, (0, 3, 4, 7)]).min(axis=1) < 1e-9 * np.ptp(s, axis=1)
        return [
            polyhedron(_meeting(v), FACES, name=name, group=group) if sharp else Block(v, FACES, name, group)
            for v, name, group, sharp in zip(corners, names, groups, pointed.tolist(), strict=True)
        ]

    def slab(self, section: Floats, name: str, group: str, faces: tuple[Face, Face] | None = None) -> Block:
        """A block through the whole thickness.

        Parameters
        ----------
        section : ndarray
            Its outline in s, z at the right face and at the left, shape (k, 2) [m].
        name : str
            Of the block.
        group : str
            Of the block.
        faces : tuple of Face, optional
            Right and left, by default those of the strip.

        Returns
        -------
        Block
            A prism.
        """
        s, z = section.T
        sides = [self.points(s, c + k * z, z) for c, k in faces or (self.right, self.left)]
        return prism(*sides, name=name, group=group)


def _meeting(corners: Floats) -> Floats:
    """Corners of a hexahedron with those that meet within rounding made equal."""
    limit = 1e-9 * np.ptp(corners, axis=0).max()
    out = corners.copy()
    for i, j in ((0, 1), (3, 2), (4, 5), (7, 6)):
        if np.abs(out[i] - out[j]).max() < limit:
            out[j] = out[i]
    return out


def bed_levels(heights: Iterable[float], nominal: float, sliver: float) -> tuple[float, ...]:
    """Levels of the beds from 0 up through all heights, in courses as near the nominal height as fit between two.

    Parameters
    ----------
    heights : iterable of float
        Where there must be a bed [m].
    nominal : float
        Height of a course [m].
    sliver : float
        Least course, as a fraction of the nominal one.

    Returns
    -------
    tuple of float
        Ascending, the first 0 [m].

    Raises
    ------
    InputError
        Where two heights are nearer to each other than the least course.
    """
    marks, levels = [0.0], [0.0]
    for height in sorted(heights):
        if len(marks) == 1 or height - marks[-1] > 1e-9 * max(height, nominal):  # else equal but for rounding
            marks.append(height)
    for low, high in zip(marks, marks[1:], strict=False):
        if high - low < sliver * nominal:
            raise InputError(
                f"heights {low:g} and {high:g} m are nearer to each other than {sliver * nominal:.3g} m, the least "
                "course; make them equal or set them apart"
            )
        number = max(round((high - low) / nominal), 1)
        levels += [float(z) for z in np.linspace(low, high, number + 1)[1:]]
    return tuple(levels)


def nearest(levels: Sequence[float] | Floats, height: float) -> int:
    """Index of the level nearest to a height.

    Parameters
    ----------
    levels : sequence of float
        Ascending [m].
    height : float
        Any [m].

    Returns
    -------
    int
        The lower of two that are as near.
    """
    return int(np.abs(np.asarray(levels) - height).argmin())
