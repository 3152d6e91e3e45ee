"""Forces without an optimum: steps of a barrier method from the forces of least squares to M'z + q = 0 in the cones.

Each step is the least change that satisfies the equations, measured in the metric of the barrier at z: points next to
the boundary of their cones hardly move (the affine steps of Dikin 1967 and of primal interior-point methods). The first
step that may be taken whole ends it. Where no forces balance the steps soon shrink to nothing, and it is given up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.polyhedron import Floats
from blockstat.solve.cones import Cones
from blockstat.solve.kkt import ConicProgram, Kkt
from blockstat.solve.normal import normal_equations

#: Least depth of the start inside the cones, in mean weights.
INSIDE = 0.1
#: Of all forces, what may be lacking inside the cones for points to be lifted one by one. Where more is, all are lifted
#: alike: a start next to the boundary of many cones would hold up the steps.
LITTLE = 0.05
#: Of the way to the boundary what a step takes, and the least step after which another is tried.
STEP, LEAST = 0.95, 0.2
#: Points with many weights to spare move no further for more: forces are compared with this many mean weights.
SATURATED = 10.0
MOST_STEPS = 25


@dataclass(frozen=True)
class Approach:
    """Multipliers of the rows."""

    #: The smallest that balance, of which some lie outside their cones; None where the first step shows that those
    #: inside are far away, if there are any.
    least: Floats | None
    found: Floats | None  #: inside the cones and in balance
    factorisations: int


NOWHERE = Approach(None, None, 0)


def approach(program: ConicProgram) -> Approach:
    """Look for multipliers in the cones that balance the cost; finding none says nothing."""
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return _approach(program)
    except (ArithmeticError, np.linalg.LinAlgError):
        return NOWHERE


def _approach(program: ConicProgram) -> Approach:
    program = program.feasibility()
    cones = program.cones
    kkt = Kkt(program, normal_equations(program.pair, program.n_blocks, program.width))

    def change(z: Floats, metric: Floats) -> Floats:
        """The least change of z, in the metric at some multipliers, that balances."""
        scaling = cones.scaling(cones.quotient(metric, cones.unit), metric)
        kkt.update(scaling, pull=0.0, shift=SATURATED**-2)
        ((_, step),) = kkt.solve((-(kkt.transposed(z) + program.cost), np.zeros_like(z)))
        return step

    least = change(0 * program.bound, cones.unit)
    z = _inside(cones, least)
    for factorisations in range(2, MOST_STEPS + 1):
        step = change(z, z)
        room = cones.longest_step(z, step)
        if room > 1.0:
            return Approach(least, _further(program, kkt, z + step), factorisations)
        if STEP * room < LEAST:
            break
        z = z + STEP * room * step
    return Approach(least if factorisations > 2 else None, None, factorisations)


def _inside(cones: Cones, least: Floats) -> Floats:
    """A start inside all cones."""
    depths = cones.depths(least)
    if np.maximum(-depths, 0.0).sum() < LITTLE * np.abs(least * cones.unit).sum():
        return cones.lifted(least, np.maximum(INSIDE - depths, 0.0))
    return least + (INSIDE - min(depths.min(), 0.0)) * cones.unit


def _further(program: ConicProgram, kkt: Kkt, z: Floats) -> Floats:
    """Multipliers in balance, moved away from the boundary along what keeps them so; needs no factorisation."""
    cones = program.cones
    away = kkt.inverse_squared(cones.quotient(z, cones.unit))
    ((_, back),) = kkt.solve((-kkt.transposed(away), np.zeros_like(z)))
    step = away + back
    return z + min(0.5 * cones.longest_step(z, step), 1.0) * step
