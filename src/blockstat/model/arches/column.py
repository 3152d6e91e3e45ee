"""Piers and columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, check_choice
from blockstat.model.arches.profile import at_least, positive
from blockstat.model.quantities import Count, Length, Lengths, Size, Three
from blockstat.model.solids import box, prism

PIER_BONDS = ("single", "halves")
SPREAD = 0.5  #: of a plinth beyond what stands on it, relative to its own height


def pier(
    *,
    size: Lengths,
    height: Length,
    courses: Count,
    bond: Literal["single", "halves"] = "single",
    plinth: Size = 0.0,
) -> list[Block]:
    """A rectangular pier of courses from z = 0 up, centred on its origin.

    Parameters
    ----------
    size : tuple of float
        Along x and y [m].
    height : float
        Of all courses together [m].
    courses : int
        Their number.
    bond : str
        One stone a course ("single"), or two ("halves") with a joint across x and across y in turn.
    plinth : float
        Height of the block under the foot, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "pier" and "plinth".

    Raises
    ------
    InputError
        Naming the option that cannot be built.
    """
    if not (isinstance(size, Sequence) and len(size) == 2):
        raise InputError(f"size is {size!r}; it must be the two lengths along x and y [m]")
    positive(**{"size[0]": size[0], "size[1]": size[1]}, height=height)
    at_least(1, courses=courses)
    check_choice("bond", bond, PIER_BONDS)
    x, y = size[0] / 2, size[1] / 2
    blocks = []
    for course, (z0, z1) in enumerate(_courses(height, courses)):
        if bond == "single":
            plans = [((-x, -y), (x, y))]
        elif course % 2 == 0:
            plans = [((-x, -y), (0.0, y)), ((0.0, -y), (x, y))]
        else:
            plans = [((-x, -y), (x, 0.0)), ((-x, 0.0), (x, y))]
        for i, (low, high) in enumerate(plans):
            blocks.append(box((*low, z0), (*high, z1), name=f"pier.{course}.{i}", group="pier"))
    return [*blocks, *_plinth(size, plinth)]


def column(
    *, diameter: Length, height: Length, drums: Count, sides: Three = 16, top: Length | None = None, plinth: Size = 0.0
) -> list[Block]:
    """A round column of drums from z = 0 up, about its origin.

    Parameters
    ----------
    diameter : float
        At the foot, of the circle round its polygon [m].
    height : float
        Of all drums together [m].
    drums : int
        Their number.
    sides : int
        Of the polygon.
    top : float, optional
        Diameter at the top, by default that of the foot [m].
    plinth : float
        Height of the square block under the foot, 0 for none [m].

    Returns
    -------
    list of Block
        Groups "column" and "plinth".

    Raises
    ------
    InputError
        Naming the option that cannot be built.
    """
    top = diameter if top is None else top
    positive(diameter=diameter, height=height, top=top)
    at_least(1, drums=drums)
    at_least(3, sides=sides)
    angle = 2 * np.pi * (np.arange(sides) + 0.5) / sides  # a side, not a corner, looks along x
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1) / 2

    def bed(z: float) -> np.ndarray:
        wide = diameter + (top - diameter) * z / height
        return np.column_stack([wide * circle, np.full(sides, z)])

    blocks = [
        prism(bed(z0), bed(z1), name=f"column.{i}", group="column")
        for i, (z0, z1) in enumerate(_courses(height, drums))
    ]
    return [*blocks, *_plinth((diameter, diameter), plinth)]


def _courses(height: float, number: int) -> list[tuple[float, float]]:
    levels = height * np.arange(number + 1) / number
    return [(float(a), float(b)) for a, b in zip(levels[:-1], levels[1:], strict=True)]


def _plinth(size: tuple[float, float], height: float) -> list[Block]:
    if not height:
        return []
    positive(plinth=height)
    x, y = (s / 2 + SPREAD * height for s in size)
    return [box((-x, -y, -height), (x, y, 0.0), name="plinth", group="plinth")]
