"""Joint laws: closed forms, and how fast cells converge to them.

Torsion of a square joint of side a under uniform pressure: mu N a (sqrt 2 + ln(1 + sqrt 2)) / 6, from the moment of
uniform friction; on four corners mu N a / sqrt 2. Stress block (Heyman; EN 1996): a joint b wide under N carries
e <= (b / 2)(1 - N / (sigma A)), so a block b x h tips at lambda = (b / h)(1 - N / (sigma A)). Each division into cells
is a lower bound.
"""

from __future__ import annotations

import numpy as np

from blockstat import JointLaw
from evidence.references.row import Row, Value, limit
from evidence.scenes.small import assembly, box

SIDE = (1, 0, 0)
UNIFORM = (np.sqrt(2) + np.log(1 + np.sqrt(2))) / 6


def block(size, law, friction=0.6):
    a, b, h = size
    ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    stone = box((-a / 2, -b / 2, 0), (a / 2, b / 2, h), name="stone", group="stone")
    return assembly([ground, stone], joints=[law], friction=friction)


def torsion(cells: int, *, uniform: bool) -> Value:
    """Couple / mu N a; with a strength just above the mean pressure every cell carries its share."""
    law = JointLaw(("stone", "ground"), cells=cells, compression=1 + 1e-5 if uniform else None)
    twist = np.zeros((2, 6))
    twist[1, 5] = 0.6
    return limit(block((1.0, 1.0, 1.0), law), twist)


def tipping(cells: int, used: float) -> Value:
    law = JointLaw(("stone", "ground"), cells=cells, compression=2.0 / used)
    return limit(block((0.5, 1.0, 2.0), law, friction=2.0), SIDE)


def sliding(**strengths: float) -> Value:
    pull = np.array([np.zeros(6), [1, 0, 0, *np.cross((0, 0, -0.25), SIDE)]])
    return limit(block((2.0, 1.0, 0.5), JointLaw(("stone", "ground"), **strengths), friction=0.5), pull)


def cantilever(moment: float) -> Value:
    """Self weights that a bonded beam .5 x .5 x 2 carries: (M + F a / 2) / (W L / 2)."""
    wall = box((-1, 0, -1), (0, 0.5, 1), name="wall", group="wall")
    beam = box((0, 0, -0.25), (2.0, 0.5, 0.25), name="beam", group="beam")
    glue = JointLaw(("wall", "beam"), bond=3.0, bond_moment=moment)
    found = limit(assembly([wall, beam], joints=[glue], friction=5.0, gravity=(0, 0, -1e-3)), (0, 0, -1))
    return Value((1 + found.ours) * 1e-3, found.bracket * 1e-3)


ROWS = [
    Row("E", "slab slides, mu W + c A", "mu W + c A", 1.9, lambda: sliding(cohesion=0.7)),
    Row("E", "the same with a tension of .3", "mu W + c A", 1.9, lambda: sliding(cohesion=0.7, tension=0.3)),
    Row("E", "bonded cantilever, F = 3", "(M + F a / 2) / (W L / 2)", 1.5, lambda: cantilever(0.0)),
    Row("E", "bonded cantilever, F = 3, M = .4", "(M + F a / 2) / (W L / 2)", 2.3, lambda: cantilever(0.4)),
    *(Row("E", f"torsion, uniform pressure, {n} x {n} cells", "mu N a (sqrt 2 + ln(1 + sqrt 2)) / 6", float(UNIFORM), lambda n=n: torsion(n, uniform=True), within=0.28 / n**1.8) for n in (4, 8, 16, 32)),
    *(Row("E", f"torsion, any pressure, {n} x {n} cells", "mu N a / sqrt 2", float(np.sqrt(0.5)), lambda n=n: torsion(n, uniform=False), within=2.0 / n**2) for n in (4, 8, 16, 32)),
    *(Row("E", f"stress block, N = {used} sigma A, {n} cells", "(b / h) (1 - N / (sigma A))", 0.25 * (1 - used), lambda n=n, used=used: tipping(n, used), within=0.5 / n**2) for used in (0.25, 0.8) for n in (4, 8, 16)),
]  # fmt: skip
