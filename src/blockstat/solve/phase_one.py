"""Forces without an optimum: steps of a barrier method to M'z + q = 0 in the cones.

Each step is the least change that satisfies the equations, measured in the metric of the barrier at z: points next to
the boundary of their cones hardly move (the affine steps of Dikin 1967 and of primal interior-point methods). The first
step that may be taken whole ends it. Where no forces balance the steps soon shrink to nothing, and it is given up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.solve.cones import Cones
from blockstat.solve.kkt import ConicProgram, Kkt, largest
from blockstat.linear_algebra.normal_equations import normal_equations
from blockstat.typing import Floats

#: Least depth of the start inside the cones, in mean weights.
INSIDE = 0.1
#: Of all forces, what may be lacking inside the cones for points to be lifted one by one. Where more is, all are lifted
#: alike: a start next to the boundary of many cones would hold up the steps.
LITTLE = 0.05
#: Of the way to the boundary what a step takes, and the least step after which another is tried.
STEP, LEAST = 0.95, 0.2
#: Points with many weights to spare move no further for more: forces are compared with this many mean weights.
SATURATED = 10.0
MOST = 25  #: factorisations
BALANCED = 1e-13  #: of the largest load, what may be left unbalanced


@dataclass(frozen=True)
class Approach:
    """Multipliers of the rows."""

    #: The smallest that balance, of which some lie outside their cones; None where the first step shows that those
    #: inside are far away, if there are any.
    least: Floats | None
    found: Floats | None  #: inside the cones and in balance
    factorisations: int


NOWHERE = Approach(None, None, 0)


def approach(program: ConicProgram, start: Floats | None = None, *, brief: bool = False) -> Approach:
    """Look for multipliers in the cones that balance the cost; finding none says nothing.

    start : multipliers inside the cones from which to try first; from the least ones that balance it takes more steps,
    but it may get there where others do not. brief : leave out the second attempt.
    """
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return _Search(program.feasibility()).approach(start, brief)
    except (ArithmeticError, np.linalg.LinAlgError):
        return NOWHERE


class _Search:
    """Steps towards multipliers in balance."""

    def __init__(self, program: ConicProgram) -> None:
        self._program = program
        self._kkt = Kkt(program, normal_equations(program.pair, program.n_blocks, program.width))
        self._factorisations = 0

    def approach(self, start: Floats | None, brief: bool) -> Approach:
        cones = self._program.cones
        if start is not None:
            found, room = self._walk(start + INSIDE * cones.unit, growing=True)
            if found is not None or room < LEAST or brief:
                return Approach(None, found, self._factorisations)
        least = self._change(0 * self._program.bound, cones.unit)
        before = self._factorisations
        found, _ = self._walk(_inside(cones, least), growing=False)
        near = self._factorisations > before + 1
        return Approach(least if near else None, found, self._factorisations)

    def _walk(self, z: Floats, *, growing: bool) -> tuple[Floats | None, float]:
        """Multipliers in balance, or None with the room that the last step left, as parts of the step.

        growing : give up as soon as a step has less room than the one before.
        """
        before = 0.0
        while True:
            step = self._change(z, z)
            room = STEP * self._program.cones.longest_step(z, step)
            if room > STEP:
                return self._mended(self._further(z + step)), room
            if room < max(LEAST, before * growing) or self._factorisations >= MOST:
                return None, room
            z, before = z + room * step, room

    def _change(self, z: Floats, metric: Floats) -> Floats:
        """The least change of z, in the metric at some multipliers, that balances."""
        cones, kkt = self._program.cones, self._kkt
        scaling = cones.scaling(cones.quotient(metric, cones.unit), metric)
        kkt.update(scaling, pull=0.0, shift=SATURATED**-2)
        self._factorisations += 1
        ((_, step),) = kkt.solve((-(kkt.transposed(z) + self._program.cost), np.zeros_like(z)))
        return step

    def _mended(self, z: Floats) -> Floats:
        """Multipliers balanced to rounding, which in walls of ten thousand blocks a single solve does not reach."""
        rest = self._kkt.transposed(z) + self._program.cost
        if largest(rest) <= BALANCED * largest(self._program.cost):
            return z
        ((_, change),) = self._kkt.solve((-rest, np.zeros_like(z)))
        return z + change

    def _further(self, z: Floats) -> Floats:
        """Multipliers in balance, moved away from the boundary along what keeps them so; needs no factorisation."""
        cones, kkt = self._program.cones, self._kkt
        away = kkt.inverse_squared(cones.quotient(z, cones.unit))
        ((_, back),) = kkt.solve((-kkt.transposed(away), np.zeros_like(z)))
        step = away + back
        return z + min(0.5 * cones.longest_step(z, step), 1.0) * step


def _inside(cones: Cones, least: Floats) -> Floats:
    """A start inside all cones."""
    depths = cones.depths(least)
    if np.maximum(-depths, 0.0).sum() < LITTLE * np.abs(least * cones.unit).sum():
        return cones.lifted(least, np.maximum(INSIDE - depths, 0.0))
    return least + (INSIDE - min(depths.min(), 0.0)) * cones.unit
