"""Evidence for a state from a small program around what has changed, given forces that balanced most of it before.

Where a block is put in, taken out or let go, the forces of the neighbouring state leave a few blocks out of balance.
Two programs of the blocks N around these decide most states, and both are proofs for the whole:

- forces on the joints inside N that balance it, those on its boundary unchanged: all others are in balance already;
- a mechanism of N with all other blocks at rest: it is one of the whole with zeros elsewhere, and the loads do the same
  work on it.

N grows from step to step. Where neither is found the whole is solved. What is found is checked on the whole program.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from blockstat.analysis.decision import decide
from blockstat.certificate.check import FORCE_TOLERANCE, point_slack
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.penalty import solve_penalty
from blockstat.solve.phase_one import find_forces
from blockstat.typing import Floats, Ints

#: Joints from the blocks out of balance to the rim of each neighbourhood that is tried.
REACHES = (1, 3, 6)
#: Of all blocks, how many a neighbourhood has at most; beyond, the whole costs no more.
MOST = 0.6


def nearby_evidence(program: PenaltyProgram, force: Floats, *, mechanisms: bool) -> Iterator[tuple[Floats, Floats]]:
    """Propose forces or mechanisms that differ from given forces, or from rest, around blocks out of balance only.

    Parameters
    ----------
    program : PenaltyProgram
        The program of a state.
    force : array of float, shape (m, 3)
        Forces in its units that balance most of its blocks.
    mechanisms : bool
        Whether mechanisms are proposed, too.

    Yields
    ------
    force : array of float, shape (m, 3)
        Zeros beside a mechanism.
    twist : array of float, shape (6 n,)
        Zeros beside forces. Nothing is checked.
    """
    n = len(program.load) // 6
    own = np.linalg.norm(program.load.reshape(n, 6), axis=1)
    rest = np.linalg.norm((program.matrix @ force.reshape(-1) + program.load).reshape(n, 6), axis=1)
    near = rest > FORCE_TOLERANCE * own
    outside = program.point_blocks[point_slack(program, force) < 0]
    near[outside[outside >= 0]] = True
    joints = np.unique(program.point_blocks[(program.point_blocks >= 0).all(axis=1)], axis=0)
    reached = 0
    for reach in REACHES:
        for _ in range(reach - reached):
            near[joints[near[joints].any(axis=1)]] = True
        reached = reach
        if not near.any() or near.sum() > MOST * n:
            return
        found = _forces_inside(program, force, near)
        if found is not None:
            yield found, 0 * program.load
        if mechanisms:
            yield 0 * force, _mechanism_inside(program, near)


def _forces_inside(program: PenaltyProgram, force: Floats, near: np.ndarray) -> Floats | None:
    """Forces that balance the blocks near, those on their boundary as they are; None where none are found easily."""
    sides = program.point_blocks
    is_near = np.append(near, False)[sides]
    boundary: Any = is_near.any(axis=1) & (sides >= 0).all(axis=1) & ~is_near.all(axis=1)
    inner = np.flatnonzero(is_near.any(axis=1) & ~boundary)
    kept = np.where(boundary[:, None], force, 0.0)
    load = program.load + program.matrix @ kept.reshape(-1)
    part = _part(program, near, inner, load)
    conic = conic_program(part, -part.load, penalty=True)
    if not conic.has_structure:
        return None
    found = find_forces(conic, conic.multipliers(force[inner]), brief=True).found
    if found is None:
        return None
    whole = force.copy()
    whole[inner] = conic.forces(found)
    return whole


def _mechanism_inside(program: PenaltyProgram, near: np.ndarray) -> Floats:
    """A mechanism of the blocks near, all others at rest; zeros where there is none."""
    on = np.flatnonzero(np.append(near, False)[program.point_blocks].any(axis=1))
    part = _part(program, near, on, program.load)
    answer = decide(part, solve_penalty(part, solver="clarabel", score=False))
    twist = np.zeros((len(near), 6))
    if answer.certificate.proves_unstable:
        twist[near] = answer.twist.reshape(-1, 6)
    return twist.reshape(-1)


def _part(program: PenaltyProgram, near: np.ndarray, points: Ints, load: Floats) -> PenaltyProgram:
    """The program of some blocks with some of their points, all other blocks fixed."""
    row = np.append(np.where(near, np.cumsum(near) - 1, -1), -1)
    sides = row[program.point_blocks[points]]
    local = program.local.reshape(-1, 3, 2, 6)[points] * (sides >= 0)[:, None, :, None]
    return replace(
        program,
        local=local.reshape(-1, 12),
        load=load.reshape(-1, 6)[near].reshape(-1),
        friction=program.friction[points],
        shift=program.shift[points],
        lower=program.lower[points],
        upper=program.upper[points],
        point_blocks=sides,
        n_points=int((points < program.n_points).sum()),
        plane=None,
    )
