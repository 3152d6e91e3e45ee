"""Where two strips meet: whose stones lie in the part of the plan that belongs to both.

The overlap of two strips is a parallelogram. It belongs to one strip in even courses and to the other in odd ones;
a strip that has it is cut by the other's far face (or passes), one that has not by the near face.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from blockstat.errors import InputError
from blockstat.model.walling.run import HEADER_BONDS
from blockstat.model.walling.strip import Edge, Line, Strip

LEAST_ANGLE = 30.0  #: between two runs that meet [degrees]; below it the overlap is longer than two thicknesses


@dataclass(frozen=True, eq=False)
class Join:
    """A junction seen from one of its strips."""

    strip: Strip
    other: Strip
    role: str  #: "start" or "end" of the strip, or "across" where it passes
    first: bool  #: whether the strip has the overlap in even courses
    bonded: bool

    def owns(self, course: int) -> bool:
        """Whether the overlap is the strip's in a course.

        Parameters
        ----------
        course : int
            Counted from the ground.

        Returns
        -------
        bool
            True where stones of the strip fill the overlap.
        """
        if course >= self.other.top:
            return True
        return self.first if not self.bonded else (course % 2 == 0) == self.first

    def edges(self, course: int) -> tuple[Edge, Edge]:
        """Planes of the other's faces in coordinates of the strip; upright above the other's top.

        Parameters
        ----------
        course : int
            Counted from the ground.

        Returns
        -------
        tuple of Edge
            Lower s first.
        """
        if course < self.other.top:
            faces = self.other.faces(course)
        else:
            z = self.other.levels[self.other.top]
            faces = tuple((c + k * z, 0.0) for c, k in (self.other.right, self.other.left))
        offset, across, slope = self._plan
        edges = [((c - offset) / slope, across / slope, k / slope) for c, k in faces]
        return (edges[0], edges[1]) if edges[0][0] < edges[1][0] else (edges[1], edges[0])

    @cached_property
    def _plan(self) -> tuple[float, float, float]:
        """Of the other's axis in coordinates of the strip: offset, and slopes across and along the strip."""
        a, b = self.strip.axis, self.other.axis
        assert isinstance(a, Line)
        assert isinstance(b, Line)
        return float((a.origin - b.origin) @ b.across), -float(a.across @ b.across), float(a.along @ b.across)

    def joints(self, course: int) -> list[Edge]:
        """Where the other's stones end beside the overlap and in it.

        These are its faces, and joints between leaves that headers cover in the next course.

        Parameters
        ----------
        course : int
            Counted from the ground.

        Returns
        -------
        list of Edge
            In the order of s.
        """
        low, high = np.array(self.edges(course))
        leaves = self.other.run.leaves_laid if self.other.run.bond in HEADER_BONDS else 1
        return [tuple(map(float, low + (high - low) * k / leaves)) for k in range(leaves + 1)]  # type: ignore[misc]


def joins(strips: Sequence[Strip], loose: Sequence[tuple[int, int]] = (), *, bonded: bool = True) -> list[list[Join]]:
    """The junctions of each strip, in order along it.

    Of two strips the one that passes has the overlap in even courses, else the one listed first.

    Parameters
    ----------
    strips : sequence of Strip
        All of the work.
    loose : sequence of tuple of int
        Pairs of strips that are not bonded.
    bonded : bool
        False for straight joints everywhere.

    Returns
    -------
    list of list of Join
        For each strip.

    Raises
    ------
    InputError
        Where strips overlap in a way that is no junction.
    """
    found: list[list[Join]] = [[] for _ in strips]
    for i, j in combinations(range(len(strips)), 2):
        a, b = strips[i], strips[j]
        roles = _roles(a, b)
        if roles is None:
            continue
        a_first = roles[0] == "across" or roles[1] != "across"
        tied = bonded and (i, j) not in loose
        found[i].append(Join(a, b, roles[0], a_first, tied))
        found[j].append(Join(b, a, roles[1], not a_first, tied))
    for of_strip in found:
        of_strip.sort(key=lambda join: join.edges(0)[0][0])
        _check(of_strip)
    return found


def _roles(a: Strip, b: Strip) -> tuple[str, str] | None:
    """What each of two strips does where they meet, None where they do not."""
    assert isinstance(a.axis, Line)
    assert isinstance(b.axis, Line)
    sine = abs(float(a.axis.along @ b.axis.across))
    names = f'"{a.run.name}" and "{b.run.name}"'
    if sine < math.sin(math.radians(LEAST_ANGLE)):
        if _footprints_meet(a, b):
            raise InputError(
                f"walls {names} meet at less than {LEAST_ANGLE:g} degrees, or overlap lengthwise; "
                "turn more sharply, or use an arc"
            )
        return None
    roles = (_role(a, b), _role(b, a))
    if roles[0] and roles[1]:
        return roles[0], roles[1]
    if _footprints_meet(a, b):
        raise InputError(f"walls {names} overlap by their sides; the end of one must reach the path of the other")
    return None


def _role(strip: Strip, other: Strip) -> str:
    """Where a strip's path meets the other's band, "" where it does not."""
    (low, *_), (high, *_) = Join(strip, other, "", True, True).edges(0)
    length, tol = strip.axis.length, 1e-9 * strip.axis.length
    if low > length + tol or high < -tol:
        return ""
    starts, ends = low <= tol, high >= length - tol
    if starts and ends:
        raise InputError(f'wall "{strip.run.name}" is shorter than the thickness of "{other.run.name}", which it meets')
    return "start" if starts else "end" if ends else "across"


def _footprints_meet(a: Strip, b: Strip) -> bool:
    """Whether the rectangles of two strips overlap (separating axes)."""
    boxes = []
    for strip in (a, b):
        axis = strip.axis
        assert isinstance(axis, Line)
        boxes.append([axis.origin + s * axis.along + d * axis.across for s in (0, axis.length) for d in _reach(strip)])
    for strip in (a, b):
        assert isinstance(strip.axis, Line)
        for normal in (strip.axis.along, strip.axis.across):
            (a0, a1), (b0, b1) = ((min(v), max(v)) for v in ([float(p @ normal) for p in box] for box in boxes))
            if min(a1, b1) - max(a0, b0) < 1e-9 * (a1 - a0 + b1 - b0):
                return False
    return True


def _reach(strip: Strip) -> tuple[float, float]:
    return strip.right[0], strip.left[0]


def _check(of_strip: Sequence[Join]) -> None:
    for before, after in zip(of_strip, of_strip[1:], strict=False):
        if after.edges(0)[0][0] < before.edges(0)[1][0] - 1e-9:
            raise InputError(
                f'walls "{before.other.run.name}" and "{after.other.run.name}" meet "{before.strip.run.name}" at one '
                "place; let one run pass there and only one other end at it"
            )
    for join in of_strip:
        strip, other = join.strip, join.other
        if strip.ridge > strip.top and other.top > strip.top:
            raise InputError(
                f'wall "{other.run.name}" is higher than the eaves of the gable "{strip.run.name}", which it meets'
            )
