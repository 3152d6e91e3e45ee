"""Energies of infeasibility, and how they grow past the limit.

Whiting, Ochsendorf & Durand, ACM TOG 28(5) (2009), erratum: a block of weight 1 whose centre of mass lies d = .3 beyond
its base needs the tension s = W d / b at the far edge of a base b. Its square falls from .090 to .0225 when the base is
stretched from 1 to 2, though the block tips exactly as much. The torque energy of Whiting et al., ACM TOG 31(6) (2012),
1/2 (s b)^2, stays .045. Past a limit the energy grows as the square of the way past it.
"""

import math

import numpy as np

from blockstat import assess, tilt_limit
from evidence.references.row import Row, Value
from evidence.scenes.small import arch, cantilever, stack


def tension(base: float) -> float:
    """Total of the missing adhesion, which lies at the far edge of the base."""
    verdict = assess(cantilever(base, 0.3))
    assert not verdict.adhesion[verdict.interfaces.point[:, 0] > 1e-9].max() > 1e-6
    return float(verdict.adhesion.sum())


def growth(asm, friction: float, degrees: tuple[float, float]) -> Value:
    """Slope of log energy over log angle in a range past the tilt limit."""
    limit = tilt_limit(asm, "y", friction=friction)
    past = np.geomspace(*degrees, 9)
    score = [
        assess(asm, friction=friction, gravity=(-math.sin(a), 0, -math.cos(a))).score
        for a in np.radians(limit.value + past)
    ]
    return Value(float(np.polyfit(np.log(past), 2 * np.log(score), 1)[0]))


ROWS = [
    Row("P", "energy of 2009, base 1", "Whiting 2009", ".090", lambda: Value(tension(1.0) ** 2), within=1e-6),
    Row("P", "energy of 2009, base 2", "Whiting 2009", ".0225", lambda: Value(tension(2.0) ** 2), within=1e-6),
    Row(
        "P",
        "torque energy of 2012, base 1",
        "Whiting 2012",
        ".045",
        lambda: Value(0.5 * (tension(1.0) * 1.0) ** 2),
        within=1e-6,
    ),
    Row(
        "P",
        "torque energy of 2012, base 2",
        "Whiting 2012",
        ".045",
        lambda: Value(0.5 * (tension(2.0) * 2.0) ** 2),
        within=1e-6,
    ),
    Row(
        "E",
        "exponent of the energy past the limit, block",
        "the lack grows in proportion",
        2.0,
        lambda: growth(stack(1, 0.5, 1.0), 0.9, (0.05, 1.0)),
        within=1e-3,
    ),
    Row(
        "E",
        "exponent of the energy past the limit, arch",
        "the lack grows in proportion",
        2.0,
        lambda: growth(arch(20, 0.15), 2.0, (1e-3, 3e-2)),
        within=1e-3,
    ),
]
