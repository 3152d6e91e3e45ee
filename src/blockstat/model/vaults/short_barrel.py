"""Barrel vaults of voussoirs in bonded courses."""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Block
from blockstat.model.solids import hexahedron
from blockstat.model.walling.short_bond import brick_length, lay_row


def build_barrel(
    *, length: float, span: float, springing: float, thickness: float, courses: int, brick: float
) -> list[Block]:
    """A semicircular barrel along x over 0 <= y <= span, springing at a height [m].

    Straight-sided voussoirs with radial joints; each course from springing to springing is a row of running
    bond along x. courses : number of voussoirs round the arch.
    """
    inner, outer = span / 2, span / 2 + thickness
    angles = np.pi - np.pi * np.arange(courses + 1) / courses  # from the south springing over the crown
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    ring[[0, -1], 1] = 0.0
    voussoir = brick_length(length, brick)
    rows = [lay_row(length, voussoir, course) for course in (0, 1)]
    blocks = []
    for course in range(courses):
        a, b = ring[course], ring[course + 1]
        profile = np.array([inner * a, inner * b, outer * b, outer * a]) + [span / 2, springing]
        for i, ends in enumerate(rows[course % 2]):
            corners = np.empty((2, 4, 3))
            corners[:, :, 0], corners[:, :, 1:] = np.reshape(ends, (2, 1)), profile
            blocks.append(hexahedron(*corners, name=f"vault.{course}.{i}", group="vault"))
    return blocks
