"""Bed levels that all runs of a work share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats


def bed_levels(heights: Iterable[float], nominal: float, sliver: float) -> tuple[float, ...]:
    """Levels of the beds from 0 up through all heights, in courses as near the nominal height as fit between two [m].

    Raises InputError where two heights are nearer to each other than a fraction `sliver` of a course.
    """
    marks = [0.0, *sorted(set(heights))]
    levels = [0.0]
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
    """Index of the level nearest to a height."""
    return int(np.abs(np.asarray(levels) - height).argmin())
