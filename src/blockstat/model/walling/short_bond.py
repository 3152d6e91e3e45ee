"""Running bond: where the head joints of a row of bricks are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

#: A brick cut shorter than this fraction of a whole one is joined to its neighbour.
SLIVER = 1 / 3


@dataclass(frozen=True)
class Void:
    """A stretch of a row that is left open (a door, a window)."""

    start: float
    end: float


@dataclass(frozen=True)
class Lintel:
    """A stretch of a row that is one block."""

    start: float
    end: float


def brick_length(row: float, nominal: float) -> float:
    """Brick length nearest to the nominal one for which a row is whole bricks and one half brick.

    LongitudeRow = NumberOfPoints x SizeOfBrick + HalfBrick (the procedural-masonry paper, Eq. 4).
    """
    whole = max(round(row / nominal - 0.5), 1)
    return row / (whole + 0.5)


def row_joints(row: float, brick: float, course: int) -> np.ndarray:
    """Joints of a row from 0 to its length; the half brick is last in even courses and first in odd ones."""
    whole = round(row / brick - 0.5)
    edges = brick * np.arange(whole + 1)
    return np.append(edges, row) if course % 2 == 0 else np.append(0.0, row - edges[::-1])


def lay_row(row: float, brick: float, course: int, gaps: Sequence[Void | Lintel] = ()) -> list[tuple[float, float]]:
    """Bricks of one row as (start, end), cut at openings and lintels; a remainder too short joins its neighbour."""
    joints = row_joints(row, brick, course)
    for gap in gaps:
        inside = (joints > gap.start) & (joints < gap.end)
        near = np.minimum(np.abs(joints - gap.start), np.abs(joints - gap.end)) < SLIVER * brick
        ends = (joints <= 0) | (joints >= row)
        joints = joints[~(inside | near) | ends]
    joints = np.unique(np.concatenate([joints, *([gap.start, gap.end] for gap in gaps)]))
    middle = (joints[:-1] + joints[1:]) / 2
    voids = [gap for gap in gaps if isinstance(gap, Void)]
    return [
        (float(a), float(b))
        for a, b, m in zip(joints[:-1], joints[1:], middle, strict=True)
        if not any(v.start < m < v.end for v in voids)
    ]
