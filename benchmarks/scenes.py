"""Scenes of any size for the benchmarks."""

from __future__ import annotations

import numpy as np

from blockstat import Assembly, Block
from blockstat.model.bond import lay_row
from blockstat.model.solids import box


def wall(blocks: int) -> Assembly:
    """A free-standing running-bond wall of about that many bricks on a fixed slab, as many courses as bricks."""
    side = max(round(np.sqrt(blocks)), 2)
    length, depth, height = 0.4, 0.2, 0.175
    row = (side - 0.5) * length
    bricks: list[Block] = [box((-1, -1, -0.2), (row + 1, depth + 1, 0), name="ground", group="ground")]
    for course in range(side):
        z = course * height
        for i, (a, b) in enumerate(lay_row(row, length, course)):
            bricks.append(box((a, 0, z), (b, depth, z + height), name=f"{course}.{i}", group="wall"))
    return Assembly.from_blocks(bricks, supports=[0], name=f"wall of {blocks}")
