"""Rows and heads of a strip as blocks with names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from blockstat.assembly import Block
from blockstat.model.walling.heads import Head
from blockstat.model.walling.pattern import Pattern
from blockstat.model.walling.row import Row, lay
from blockstat.model.walling.strip import Strip
from blockstat.typing import Floats

#: Number of the next block of each group and course: stretches of one run go on counting. The builders move it on.
Numbers = dict[tuple[str, int], int]
SLIVER = 1 / 3  #: of a brick: the least rest of one that is laid by itself
HEADS = -1  #: in place of a course, for the openings of a group


def brickwork(
    rows: Sequence[Row], pattern: Pattern, sliver: float, numbers: Numbers, *, round_the_ring: bool = False
) -> list[Block]:
    """Bricks of all rows of a strip; the coping in longer stones.

    Parameters
    ----------
    rows : sequence of Row
        Of one strip.
    pattern : Pattern
        The bond of the strip.
    sliver : float
        Least part of a brick, as a fraction.
    numbers : dict
        Number of the next block of each group and course; it is moved on.
    round_the_ring : bool
        Whether coping stones must come out even.

    Returns
    -------
    list of Block
        Course by course.
    """
    if not rows:
        return []
    strip = rows[0].strip
    courses: list[int] = []
    names: list[str] = []
    groups: list[str] = []
    laid: list[tuple[Floats, Floats]] = []
    alike: dict[Any, tuple[Floats, Floats]] = {}
    for row in rows:
        bond, group = pattern, strip.group
        coping = strip.run.coping
        if row.course == strip.coped and coping is not None:
            long = coping.length or 2 * pattern.brick
            if round_the_ring:
                long = strip.axis.length / max(round(strip.axis.length / long), 3)
            bond = replace(pattern, bond="running", brick=long, leaves=1, through=None)
            group = f"{group}.coping"
        kind = row.kind if bond is pattern and pattern.through is None else None
        if kind is None or kind not in alike:
            alike[kind] = lay(row, bond, sliver * pattern.brick)
        ends, leaves = alike[kind]
        first = numbers.get((group, row.course), 0)
        numbers[group, row.course] = first + len(ends)
        names += [f"{group}.{row.course}.{first + i}" for i in range(len(ends))]
        groups += [group] * len(ends)
        courses += [row.course] * len(ends)
        laid.append((ends, leaves))
    ends, leaves = (np.concatenate(parts) for parts in zip(*laid, strict=True))
    return strip.bricks(courses, ends, leaves, names, groups)


def head_stones(strip: Strip, found: Sequence[Head], numbers: Numbers) -> list[Block]:
    """Lintels and voussoirs, through the whole thickness.

    Parameters
    ----------
    strip : Strip
        Whose openings they span.
    found : sequence of Head
        The openings.
    numbers : dict
        Number of the next opening of each group; it is moved on.

    Returns
    -------
    list of Block
        Opening by opening.
    """
    blocks = []
    for head in found:
        group = f"{strip.group}.{head.kind}"
        k = numbers.get((group, HEADS), 0)
        numbers[group, HEADS] = k + 1
        blocks += [strip.slab(stone, f"{group}.{k}.{i}", group) for i, stone in enumerate(head.stones)]
    return blocks
