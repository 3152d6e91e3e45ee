"""One course of a strip: what is solid of it, and the bricks laid in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from blockstat.errors import InputError
from blockstat.model.walling.pattern import LAP, STACK_LAP, Pattern, bands, spread
from blockstat.model.walling.strip import Edge, Strip, upright
from blockstat.typing import Floats


@dataclass(frozen=True)
class Gap:
    """A part of a course between two planes that has no bricks of the strip."""

    low: Edge
    high: Edge
    what: str  #: for messages, such as 'wall "north"'


@dataclass(frozen=True, eq=False)
class Row:
    """One course of a strip before bricks are laid in it."""

    strip: Strip
    course: int
    start: Gap  #: ends in the plane where the course begins
    end: Gap  #: begins in the plane where the course ends
    gaps: Sequence[Gap] = ()
    avoid: list[tuple[float, float]] = field(default_factory=list)  #: where courses above and below are cut
    pointed: bool = False  #: whether it may run out to an edge (under the ridge of a gable)

    @property
    def kind(self) -> Any:
        """What decides how bricks lie in a course between upright planes: equal in courses laid alike, else None."""
        planes = [plane for gap in (self.start, self.end, *self.gaps) for plane in (gap.low, gap.high)]
        if any(plane[1] or plane[2] for plane in planes):
            return None
        return self.course % 2, *planes, *self.avoid

    def span(self, edge: Edge) -> tuple[float, float]:
        """Least and largest s of a plane inside the course.

        Parameters
        ----------
        edge : Edge
            The plane.

        Returns
        -------
        tuple of float
            Least and largest [m].
        """
        s = self.corners(edge)
        return min(s), max(s)

    def at_faces(self, edge: Edge) -> list[tuple[float, float]]:
        """Least and largest s of a plane on the right face and on the left face.

        Parameters
        ----------
        edge : Edge
            The plane.

        Returns
        -------
        list of tuple of float
            Right, then left [m].
        """
        s = self.corners(edge)
        return [(min(side), max(side)) for side in (s[0::2], s[1::2])]

    def corners(self, edge: Edge) -> list[float]:
        """Return s of a plane at the four edges of the course.

        Parameters
        ----------
        edge : Edge
            The plane.

        Returns
        -------
        list of float
            Lower right, lower left, upper right, upper left [m].
        """
        return [edge[0] + edge[1] * d + edge[2] * z for d, z in self._edges]

    @cached_property
    def _edges(self) -> list[tuple[float, float]]:
        """(d, z) of the four edges of the course."""
        faces = self.strip.faces(self.course)
        return [(c + k * z, z) for z in self.strip.bed(self.course) for c, k in faces]

    def stretches(self, least: float) -> list[tuple[Edge, Edge]]:
        """The solid parts between the gaps.

        Parameters
        ----------
        least : float
            Width below which a part is refused, unless the run's `closers` allow it [m].

        Returns
        -------
        list of tuple of Edge
            First and last plane of each.

        Raises
        ------
        InputError
            For a part that is too narrow, naming what it lies between.
        """
        gaps = sorted(self.gaps, key=lambda gap: sum(self.corners(gap.low)))
        found = []
        for before, after in zip([self.start, *gaps], [*gaps, self.end], strict=True):
            widths = [b - a for a, b in zip(self.corners(before.high), self.corners(after.low), strict=True)]
            width = min(widths)
            if max(map(abs, widths)) < 1e-9 * least:
                continue
            narrow = self.pointed or self.strip.run.closers
            if width < least * (1 - 1e-9) and not (narrow and width > -1e-9 * least):
                at = f"at a height of {self.strip.bed(self.course)[0]:.3g} m"
                left = f"{width:.3g} m is left between" if width > 0 else "nothing is left between"
                raise InputError(
                    f'"{self.strip.group}": {left} {before.what} and {after.what} {at}, lintels and arches included; '
                    f"leave at least {least:.3g} m"
                )
            found.append((before.high, after.low))
        return found


def lay(row: Row, pattern: Pattern, sliver: float) -> tuple[Floats, Floats]:
    """Bricks of a row.

    Parameters
    ----------
    row : Row
        One course.
    pattern : Pattern
        Its bond.
    sliver : float
        A stretch, or the rest of a brick at its end, shorter than this is joined to its neighbour [m].

    Returns
    -------
    ends : ndarray
        The planes that bound each brick, shape (n, 2, 3).
    leaves : ndarray
        The leaves that each fills, shape (n, 2), see `Strip.bricks`.
    """
    ends: list[tuple[Edge, Edge]] = []
    leaves: list[tuple[float, float]] = []
    number = pattern.leaves_in(row.course)
    drop = pattern.bond == "stack"
    closed = bands(row.avoid, (STACK_LAP if drop else LAP) * pattern.brick)
    for first, last in row.stretches(sliver):
        low, high = row.span(first)[1] + sliver, row.span(last)[0] - sliver
        headers = pattern.headers(row.course, low, high)
        marks = _within(spread(np.unique(headers), closed, drop=drop), low, high, sliver) if len(headers) else []
        bounds = [first, *map(upright, marks), last]
        for a, b in zip(bounds, bounds[1:], strict=False):
            inner, outer = row.span(a)[1], row.span(b)[0]
            middle = (inner + outer) / 2
            if number == 1 or ((headers[:, 0] < middle) & (middle < headers[:, 1])).any():
                shares = [(0.0, 1.0)]
            else:
                shares = [(k / number, (k + 1) / number) for k in range(number)]
            whole = len(shares) < number
            for leaf, share in enumerate(shares):
                joints = np.empty(0) if whole else pattern.joints(row.course, leaf, inner, outer)
                joints = spread(joints, closed, drop=drop)
                joints = _within(joints, inner + sliver, outer - sliver, sliver)
                cuts = [a, *map(upright, joints), b]
                ends += zip(cuts, cuts[1:], strict=False)
                leaves += [share] * (len(cuts) - 1)
    return np.array(ends, dtype=float).reshape(-1, 2, 3), np.array(leaves, dtype=float).reshape(-1, 2)


def _within(joints: Floats, low: float, high: float, least: float) -> list[float]:
    """Joints between two places and not nearer to each other than `least`."""
    rounding = 1e-9 * least
    kept: list[float] = []
    for x in joints[(joints >= low - rounding) & (joints <= high + rounding)].tolist():
        if not kept or x - kept[-1] >= least - rounding:
            kept.append(x)
    return kept
