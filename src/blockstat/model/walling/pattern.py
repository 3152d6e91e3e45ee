"""Bonds: where the head joints of a course are, and which stones reach through the thickness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from blockstat.model.walling.run import Run, Through
from blockstat.typing import Floats

HEADER = 0.5  #: width of a header, as a fraction of the length of a stretcher: two headers and a joint make one
#: Least distance of head joints in courses on each other, as a fraction of a brick; English and Flemish bond have 1/4.
LAP = 0.24
STACK_LAP = 0.05  #: in stack bond, where joints stay in line; one that would lie nearer a corner than this is left out


@dataclass(frozen=True)
class Pattern:
    """The bond of one strip.

    Two lattices of head joints, half a brick apart, change places from course to course. Which of them holds the
    point `anchor` in even courses is its phase: a course that begins there begins with a whole brick.
    """

    bond: str
    brick: float  #: length of a stretcher [m]
    anchor: float  #: [m] along the strip
    phase: int  #: 0: even courses have a joint at the anchor, 1: odd ones
    half: float = 0.5
    leaves: int = 1
    through: Through | None = None
    staggered: bool = True  #: whether joints of neighbouring leaves are half a brick apart in running bond

    def leaves_in(self, course: int) -> int:
        """The number of leaves in a course.

        Parameters
        ----------
        course : int
            Counted from the ground.

        Returns
        -------
        int
            1 in a course of headers.
        """
        return 1 if self.bond == "english" and course % 2 else self.leaves

    def joints(self, course: int, leaf: int, low: float, high: float) -> Floats:
        """Head joints of a leaf between two places.

        Parameters
        ----------
        course : int
            Counted from the ground.
        leaf : int
            Counted from the right face.
        low : float
            From here along the strip [m].
        high : float
            To here [m].

        Returns
        -------
        ndarray
            Places along the strip, ascending, shape (n,) [m].
        """
        if self.bond == "flemish":
            return np.empty(0)
        if self.bond == "english" and course % 2:
            return self._lattice(self.brick / 4, HEADER * self.brick, low, high)
        turn = {"running": course + leaf * self.staggered, "stack": self.phase, "english": 0}[self.bond] + self.phase
        return self._lattice(self._offset(turn), self.brick, low, high)

    def headers(self, course: int, low: float, high: float) -> Floats:
        """Stones through the thickness that reach into a stretch.

        Parameters
        ----------
        course : int
            Counted from the ground.
        low : float
            From here along the strip [m].
        high : float
            To here [m].

        Returns
        -------
        ndarray
            (start, end) of each, shape (n, 2) [m].
        """
        if self.bond == "flemish":
            start = self.brick if (course + self.phase) % 2 == 0 else self.brick / 4
            first = self._lattice(start, (1 + HEADER) * self.brick, low - HEADER * self.brick, high)
            return np.column_stack([first, first + HEADER * self.brick])
        if self.through is None or course % self.through.courses != self.through.courses - 1:
            return np.empty((0, 2))
        every = self.through.bricks * self.brick
        turn = self.phase + (course if self.bond == "running" else self.phase)
        middle = self._offset(turn) + self.brick * (self.through.bricks // 2)
        first = self._lattice(middle, every, low - self.brick, high)
        return np.column_stack([first, first + self.brick])

    def _offset(self, turn: int) -> float:
        """Of the lattice that has the anchor (even turn) or of the other one."""
        if turn % 2 == 0:
            return 0.0
        return self.brick * (self.half if self.phase == 0 else 1 - self.half)

    def _lattice(self, offset: float, step: float, low: float, high: float) -> Floats:
        first = int(np.ceil((low - self.anchor - offset) / step))
        last = int(np.floor((high - self.anchor - offset) / step))
        return self.anchor + offset + step * np.arange(first, last + 1, dtype=float)


def fitted(run: Run, nominal: float, start: tuple[float, int | None], end: tuple[float, int | None]) -> Pattern:
    """The bond whose bricks are nearest to a nominal length and fit whole between two places.

    In running bond a course between two free ends is whole bricks and one half brick: LongitudeRow = NumberOfPoints x
    SizeOfBrick + HalfBrick (the procedural-masonry paper, Eq. 4).

    Parameters
    ----------
    run : Run
        Says the bond.
    nominal : float
        Length of a brick [m].
    start : tuple
        Place [m] and phase there, None for a free end.
    end : tuple
        The same at the other end.

    Returns
    -------
    Pattern
        With the length of its bricks.
    """
    half = run.half if run.bond == "running" else 0.5
    choices = [(p, q) for p in _phases(start[1]) for q in _phases(end[1])]
    if start[1] is None and end[1] is None:
        choices = [(0, 1)] if run.bond == "running" else [(0, 0)]
    clear = end[0] - start[0]
    best: tuple[float, int, float] | None = None
    for p, q in choices:
        brick = _brick(run.bond, clear, nominal, 0.0 if p == q else half if p == 0 else 1 - half, p == q)
        misfit = abs(np.log(brick / nominal))
        if best is None or misfit < best[0] - 1e-12:
            best = (misfit, p, brick)
    assert best is not None
    return Pattern(run.bond, best[2], start[0], best[1], half, run.leaves_laid, run.through)


def plain_row(length: float, nominal: float) -> tuple[Floats, Floats]:
    """Ends of the bricks of an even and of an odd course of running bond between two free ends.

    Each course is whole bricks and one half brick: last in even courses, first in odd ones (the procedural-masonry
    paper, Eq. 4).

    Parameters
    ----------
    length : float
        Of the course [m].
    nominal : float
        Length of a brick; that laid is the nearest that fits [m].

    Returns
    -------
    tuple of ndarray
        From 0 to the length, in an even and in an odd course [m].

    Examples
    --------
    >>> [ends.tolist() for ends in plain_row(5.0, 2.0)]
    [[0.0, 2.0, 4.0, 5.0], [0.0, 1.0, 3.0, 5.0]]
    """
    whole = max(round(length / nominal - 0.5), 1)
    edges = length / (whole + 0.5) * np.arange(whole + 1)
    return np.append(edges, length), np.append(0.0, length - edges[::-1])


def _phases(phase: int | None) -> tuple[int, ...]:
    return (0, 1) if phase is None else (phase,)


def _brick(bond: str, clear: float, nominal: float, rest: float, same: bool) -> float:
    """Length of a brick near the nominal one of which a whole number and a rest fill a clear length."""
    if bond == "flemish":  # a stretcher, then headers and stretchers in turn: rests of the period
        unit, rest = 1 + HEADER, 2 / 3 if same else 1 / 6
    else:
        unit, rest = 1.0, 0.0 if bond == "stack" else rest
    whole = max(round(clear / (nominal * unit) - rest), 0 if rest > 0.6 else 1)
    return clear / ((whole + rest) * unit)


def bands(avoid: Sequence[tuple[float, float]], lap: float) -> Floats:
    """Stretches where a course has no joint.

    Parameters
    ----------
    avoid : sequence of tuple of float
        (low, high) of each place along the strip where the courses above and below have joints [m].
    lap : float
        Distance kept from them [m].

    Returns
    -------
    ndarray
        (low, high), ascending and apart, shape (n, 2) [m].
    """
    found: list[list[float]] = []
    for low, high in sorted((low - lap, high + lap) for low, high in avoid):
        if found and low < found[-1][1]:
            found[-1][1] = max(found[-1][1], high)
        else:
            found.append([low, high])
    return np.array(found, dtype=float).reshape(-1, 2)


def spread(joints: Floats, bands: Floats, *, drop: bool) -> Floats:
    """Joints kept out of bands: moved to the nearer end, or dropped.

    Parameters
    ----------
    joints : ndarray
        Ascending places, shape (n,) [m].
    bands : ndarray
        As `bands` gives them, shape (m, 2) [m].
    drop : bool
        Whether a joint in a band is dropped.

    Returns
    -------
    ndarray
        Ascending places [m].
    """
    if not len(joints) or not len(bands):
        return joints
    low, high = bands[np.maximum(np.searchsorted(bands[:, 0], joints) - 1, 0)].T
    inside = (joints > low) & (joints < high)
    if drop:
        return joints[~inside]
    joints = np.where(inside, np.where(joints < (low + high) / 2, low, high), joints)
    return joints[np.append(True, np.diff(joints) > 0)]
