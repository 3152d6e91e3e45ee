"""The solids that the elements are made of."""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Block
from blockstat.polyhedron import Floats

FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def hexahedron(bottom: Floats, top: Floats, *, name: str, group: str) -> Block:
    """A block between two quadrilaterals, shape (4, 3) each, counter-clockwise seen from the top."""
    return Block(np.vstack([bottom, top]), FACES, name=name, group=group)


def box(lower: tuple[float, float, float], upper: tuple[float, float, float], *, name: str, group: str) -> Block:
    """An axis-aligned block."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    plan = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    bottom = np.column_stack([plan, np.full(4, z0)])
    return hexahedron(bottom, np.column_stack([plan, np.full(4, z1)]), name=name, group=group)
