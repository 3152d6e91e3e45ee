"""Phase one: forces in balance without an optimum, by affine scaling steps to M'z + q = 0 in the cones.

Each step is the least change that satisfies the equations, measured in the metric of the barrier at z: points next to
the boundary of their cones hardly move (affine scaling, Dikin 1967). The first
step that may be taken whole ends it. Where no forces balance the steps soon shrink to nothing, and it is given up.

The first start is a guess of the load path: each block hands what it carries down to those it rests on. Such forces do
not balance, but they lie inside all cones and are as large as they will be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from blockstat.program.conic import ConicProgram
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.cones import Cones
from blockstat.solve.kkt import KktSolver, largest
from blockstat.typing import Floats

#: Least depth of the start inside the cones, in mean weights.
INSIDE = 0.1
#: Of all forces, what may be lacking inside the cones for points to be lifted one by one. Where more is, all are lifted
#: alike: a start next to the boundary of many cones would hold up the steps.
LITTLE = 0.05
#: Of the way to the boundary what a step takes, and the least step after which another is tried. From the guess the
#: steps grow, but for dips: they are given up where one is less than this share of the one before.
STEP, LEAST, DIP = 0.95, 0.1, 0.5
#: Points with a slack of many weights move no further for more: forces are compared with this many mean weights.
SATURATED = 10.0
MOST = 25  #: factorisations
#: Of the search for a motion that opens every joint: factorisations, its proximal terms, and the slack of a row that
#: touches all blocks, next to 1 of the others.
MOST_OPENING, OPENING_PULL, FREE = 10, 1e-9, 1e6
BALANCED = 1e-13  #: of the largest load, what may be left unbalanced
#: Joints whose normal makes less than this cosine with the loads carry nothing down.
STEEP = 0.1
#: Courses that a burden is handed down at most, and the change of the burdens at which it has arrived.
COURSES, ARRIVED = 1_000, 1e-3


@dataclass(frozen=True)
class PhaseOne:
    """Multipliers of the rows that phase one ends with."""

    #: The smallest that balance, of which some lie outside their cones; None where the first step shows that those
    #: inside are far away, if there are any.
    least: Floats | None
    found: Floats | None  #: inside the cones and in balance
    factorisations: int


NOTHING = PhaseOne(None, None, 0)


def find_forces(program: ConicProgram, start: Floats, *, brief: bool = False, stands: bool = False) -> PhaseOne:
    """Look for multipliers in the cones that balance the cost; finding none proves nothing.

    Parameters
    ----------
    program
        A program with the structure of blocks.
    start
        Multipliers inside the cones, or on their boundaries, from which to try first, shape (n_rows,).
    brief
        Leave out the second attempt, from the least multipliers that balance. It takes more steps and may get there
        where the first does not.
    stands
        Forces are expected to exist, so that the second attempt is made however short the steps of the first become.

    Returns
    -------
    PhaseOne
        The multipliers, where there are any, and the number of factorisations.
    """
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return _Search(program.feasibility()).run(start, brief, stands)
    except (ArithmeticError, np.linalg.LinAlgError):
        return NOTHING


class _Search:
    """Steps towards multipliers in balance."""

    def __init__(self, program: ConicProgram) -> None:
        self._program = program
        self._kkt = KktSolver(program)
        self._factorisations = 0

    def run(self, start: Floats, brief: bool, stands: bool) -> PhaseOne:
        """Walk from the start, then from the least multipliers that balance."""
        cones = self._kkt.cones
        found, step = self._walk(start + INSIDE * cones.unit, growing=True)
        if found is not None or brief or (step < LEAST and not stands):
            return PhaseOne(None, found, self._factorisations)
        least = self._change(0 * self._program.bound, cones.unit)
        before = self._factorisations
        found, _ = self._walk(_inside(cones, least), growing=False)
        near = self._factorisations > before + 1
        return PhaseOne(least if near else None, found, self._factorisations)

    def _walk(self, z: Floats, *, growing: bool) -> tuple[Floats | None, float]:
        """Multipliers in balance, or None, and the share of the last step that stays inside the cones.

        growing : give up as soon as a share is much smaller than the one before.
        """
        before = 0.0
        while True:
            step = self._change(z, z)
            share = STEP * self._kkt.cones.longest_step(z, step)
            if share > STEP:
                return self._mended(self._further(z + step)), share
            if share < max(LEAST, DIP * before * growing) or self._factorisations >= MOST:
                return None, share
            z, before = z + share * step, share

    def _change(self, z: Floats, metric: Floats) -> Floats:
        """The least change of z, in the metric at some multipliers, that balances."""
        cones, kkt = self._kkt.cones, self._kkt
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
        cones, kkt = self._kkt.cones, self._kkt
        away = kkt.inverse_squared(cones.quotient(z, cones.unit))
        ((_, back),) = kkt.solve((-kkt.transposed(away), np.zeros_like(z)))
        step = away + back
        return z + min(0.5 * cones.longest_step(z, step), 1.0) * step


def find_motion(program: ConicProgram, kkt: KktSolver) -> tuple[Floats | None, int]:
    """Look for unknowns that are strictly inside all constraints of two blocks: a motion that opens every joint.

    Each step is the least change of the slack s that satisfies M x + s = 0, in the metric of the barrier at s, from
    the unit of every cone: the blocks part as evenly as they can. Finding none proves nothing. The more courses a wall
    has, the further its top moves, and the shorter the first steps are; so the search goes on as long as they grow.

    Parameters
    ----------
    program
        A program with the structure of blocks, without zeros and bounds of points.
    kkt
        Its systems.

    Returns
    -------
    motion : Floats or None
        Unknowns, shape (n,).
    factorisations : int
        How many it took.
    """
    cones, x, s, before = kkt.cones, 0 * program.cost, kkt.cones.unit.copy(), 0.0
    two_blocks = np.arange(len(s)) < len(program.local)
    s[~two_blocks] = FREE  # the border holds nothing back
    for k in range(1, MOST_OPENING + 1):
        kkt.update(cones.scaling(s, cones.quotient(s, cones.unit)), pull=OPENING_PULL, shift=OPENING_PULL)
        rest = np.where(two_blocks, program.matrix @ x + s, 0.0)
        ((step, _),) = kkt.solve((0 * x, -rest))
        change = np.where(two_blocks, -rest - program.matrix @ step, 0.0)
        share = STEP * cones.longest_step(s, change)
        if share > STEP:
            return x + step, k
        if share < before:
            break
        x, s, before = x + share * step, s + share * change, share
    return None, k


def _inside(cones: Cones, least: Floats) -> Floats:
    """A start inside all cones."""
    depths = cones.depths(least)
    if np.maximum(-depths, 0.0).sum() < LITTLE * np.abs(least * cones.unit).sum():
        return cones.lifted(least, np.maximum(INSIDE - depths, 0.0))
    return least + (INSIDE - min(depths.min(), 0.0)) * cones.unit


def load_path_guess(program: PenaltyProgram) -> Floats:
    """Guess the normal force at each point from the loads above it.

    Parameters
    ----------
    program
        The equilibrium, in its units.

    Returns
    -------
    Floats
        Normal forces, shape (m,), none below zero. They do not balance.

    Notes
    -----
    Only the direction of the sum of all loads counts. Joints share what a block carries by the squares of the cosines
    of their normals with it, and no joint rubs.
    """
    load = program.load.reshape(-1, 6)[:, :3]
    total = load.sum(axis=0)
    size = float(np.linalg.norm(total))
    if not size:
        return np.zeros(len(program.friction))
    a, b = program.point_blocks.T
    head = program.local[::3]
    normal = np.where((b >= 0)[:, None], head[:, 6:9], -head[:, :3])  # of the force on b
    rise = -normal @ (total / size)
    upper, lower = np.where(rise > 0, b, a), np.where(rise > 0, a, b)
    slope = np.where((upper >= 0) & (np.abs(rise) > STEEP), np.abs(rise), 0.0)
    held = np.bincount(np.maximum(upper, 0), slope**2, len(load))[upper]
    share = slope**2 / np.where(slope > 0, held, 1.0)
    on = np.flatnonzero((slope > 0) & (lower >= 0))
    hand = sparse.csr_array((share[on], (lower[on], upper[on])), shape=(len(load), len(load)))
    own = np.maximum(load @ (total / size), 0.0)
    burden = own
    for _ in range(COURSES):
        before, burden = burden, own + hand @ burden
        if np.abs(burden - before).max() <= ARRIVED * burden.max():
            break
    return burden[upper] * share / np.where(slope > 0, slope, 1.0)
