"""Evidence for a state from small programs around what has changed, given forces that balanced most of it before.

Where a block is put in, taken out or let go, the forces of the neighbouring state leave a few blocks out of balance.
Two programs of the blocks N around these decide most states, and both are proofs for the whole:

- forces on the joints inside N and all blocks below that balance these, those on their boundary unchanged: all others
  are in balance already;
- a mechanism of N with all other blocks at rest: it is one of the whole with zeros elsewhere, and the loads do the same
  work on it.

N grows from step to step. Where neither is found the whole is solved. What is found is checked on the whole program.
Forces of the whole cost no more than those of a part in small assemblies, and are looked for first there.

The least adhesion, which gives the score, is local, too. Let f and u be optimal in the penalty program of N with all
other blocks fixed. Joints that do not touch N neither open nor close under u, so they may carry any admissible force.
If such forces balance the other blocks against f on the boundary of N, all conditions of optimality of the whole hold.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from blockstat.analysis.decision import decide
from blockstat.certificate.check import FORCE_TOLERANCE, force_errors, point_slack
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Status
from blockstat.solve.penalty import solve_penalty
from blockstat.solve.phase_one import STEEP, find_forces
from blockstat.typing import Floats, Ints

#: Joints from the blocks out of balance to the rim of each neighbourhood that is tried.
REACHES = (0, 1, 3, 6)
#: Of the fastest block, what may be noise of a mechanism.
AT_REST = 1e-6
#: Of all blocks, how many a neighbourhood has at most; beyond, the whole costs no more.
MOST = 0.6


@dataclass(frozen=True, eq=False)
class Proposal:
    """Evidence for a state, which nothing has checked yet, in the units of its program."""

    force: Floats  #: shape (m, 3); zeros beside a mechanism of which no more is known
    twist: Floats  #: shape (6 n,); zeros beside forces
    adhesion: Floats  #: the least at each point, shape (n_points,); nan where it is not known


def nearby_evidence(
    program: PenaltyProgram, force: Floats, *, small: bool, score: bool, stands: bool = False
) -> Iterator[Proposal]:
    """Propose forces or mechanisms that differ from given forces, or from rest, around blocks out of balance only.

    Parameters
    ----------
    program : PenaltyProgram
        The program of a state.
    force : array of float, shape (m, 3)
        Forces in its units that balance most of its blocks.
    small : bool
        Whether forces of the whole are looked for first, and then mechanisms alone.
    score : bool
        Whether a mechanism is wanted with the least adhesion; in large programs none are proposed then.
    stands : bool, optional
        Whether the state is likely to stand, so that forces of the whole are looked for before mechanisms.

    Yields
    ------
    Proposal
        Nothing in it is checked, but adhesion is the least for its mechanism.
    """
    n, near = len(program.load) // 6, unbalanced(program, force)
    outside = program.point_blocks[point_slack(program, force) < 0]
    near[outside[outside >= 0]] = True
    if not near.any():
        return
    if small and (found := _forces_inside(program, force, np.ones(n, dtype=bool), brief=False)) is not None:
        yield _of_forces(program, found)
    joints = np.unique(program.point_blocks[(program.point_blocks >= 0).all(axis=1)], axis=0)
    reached = 0
    for reach in REACHES:
        for _ in range(reach - reached):
            near[joints[near[joints].any(axis=1)]] = True
        reached = reach
        if near.sum() > MOST * n:
            return
        if not small and (down := below(program, near)).sum() <= MOST * n:
            found = _forces_inside(program, force, down)
            if found is not None:
                yield _of_forces(program, found)
        if stands and not small and not reach:
            found = _forces_inside(program, force, np.ones(n, dtype=bool), brief=False)
            if found is not None:
                yield _of_forces(program, found)
        if small and score:
            yield from nearby_optimum(program, force, near)
        elif not score:
            yield _mechanism_inside(program, near)


def below(program: PenaltyProgram, near: np.ndarray) -> np.ndarray:
    """Return some blocks with all that they rest on, down to what is fixed.

    The weight of a block that is put in or let go has to get there, and forces on the boundary do not change. Joints
    whose normal is level carry nothing down (see `blockstat.solve.phase_one.load_path_guess`).

    Parameters
    ----------
    program : PenaltyProgram
        The program of a state.
    near : array of bool, shape (n,)
        The blocks.

    Returns
    -------
    array of bool, shape (n,)
        These and those below.
    """
    total = program.load.reshape(-1, 6)[:, :3].sum(axis=0)
    a, b = program.point_blocks.T
    rows = program.local[::3]
    normal = np.where((b >= 0)[:, None], rows[:, 6:9], -rows[:, :3])  # of the force on b
    rise = -normal @ (total / (np.linalg.norm(total) or 1.0))
    upper, lower = np.where(rise > 0, b, a), np.where(rise > 0, a, b)
    down = (np.abs(rise) > STEEP) & (upper >= 0) & (lower >= 0)
    upper, lower, found = upper[down], lower[down], near.copy()
    while len(more := lower[found[upper] & ~found[lower]]):
        found[more] = True
    return found


def unbalanced(program: PenaltyProgram, force: Floats) -> np.ndarray:
    """Return which blocks forces leave out of balance.

    Parameters
    ----------
    program : PenaltyProgram
        The program of a state.
    force : array of float, shape (m, 3)
        Forces in its units.

    Returns
    -------
    array of bool, shape (n,)
        Where more than a proof may leave is left, rounding included.
    """
    load = program.load.reshape(-1, 6)
    rest = (program.matrix @ force.reshape(-1)).reshape(-1, 6) + load
    return np.asarray(np.linalg.norm(rest, axis=1) > FORCE_TOLERANCE * np.linalg.norm(load, axis=1))


def nearby_optimum(program: PenaltyProgram, force: Floats, near: np.ndarray) -> Iterator[Proposal]:
    """Propose the mechanism of least adhesion where it is one of some blocks, all others at rest.

    Parameters
    ----------
    program : PenaltyProgram
        The program of a state.
    force : array of float, shape (m, 3)
        Forces in its units from which to look for those of the other blocks.
    near : array of bool, shape (n,)
        The blocks that may move.

    Yields
    ------
    Proposal
        At most one, with forces that balance all blocks together with the adhesion.
    """
    on = np.flatnonzero(np.append(near, False)[program.point_blocks].any(axis=1))
    part = _part(program, near, on, program.load)
    answer = solve_penalty(part, solver="clarabel")
    if answer.status is not Status.SOLVED or not answer.bounded:
        return
    speed = np.linalg.norm(answer.twist.reshape(-1, 6), axis=1)
    moving = speed > AT_REST * speed.max()
    if not moving.all():  # the others may carry what they like
        fewer = np.flatnonzero(near)[moving]
        yield from nearby_optimum(program, force, np.isin(np.arange(len(near)), fewer))
        return
    adhesion = np.zeros(program.n_points)
    adhesion[on] = answer.adhesion
    pull = np.column_stack([adhesion, 0 * adhesion, 0 * adhesion])
    whole = force.copy()
    whole[on] = answer.force - pull[on]
    others = whole if near.all() else _forces_inside(program, whole, ~near)
    if others is None:
        return
    whole = others + pull
    pulled = replace(program, load=program.load - program.normal_columns @ adhesion)
    if not force_errors(pulled, whole).within(FORCE_TOLERANCE):
        return
    twist = np.zeros((len(near), 6))
    twist[near] = decide(part, answer).twist.reshape(-1, 6)
    yield Proposal(whole, twist.reshape(-1), adhesion)


def _of_forces(program: PenaltyProgram, force: Floats) -> Proposal:
    return Proposal(force, 0 * program.load, np.full(program.n_points, np.nan))


def _forces_inside(program: PenaltyProgram, force: Floats, near: np.ndarray, *, brief: bool = True) -> Floats | None:
    """Forces that balance the blocks near, those on their boundary as they are; None where none are found easily."""
    sides = program.point_blocks
    is_near = np.append(near, False)[sides]
    boundary: Any = is_near.any(axis=1) & (sides >= 0).all(axis=1) & ~is_near.all(axis=1)
    inner = np.flatnonzero(is_near.any(axis=1) & ~boundary)
    if not len(inner):
        return None
    kept = np.where(boundary[:, None], force, 0.0)
    load = program.load + program.matrix @ kept.reshape(-1)
    part = _part(program, near, inner, load)
    conic = conic_program(part, -part.load, penalty=True)
    if not conic.has_structure:
        return None
    found = find_forces(conic, conic.multipliers(force[inner]), brief=brief).found
    if found is None:
        return None
    whole = force.copy()
    whole[inner] = conic.forces(found)
    return whole


def _mechanism_inside(program: PenaltyProgram, near: np.ndarray) -> Proposal:
    """A mechanism of the blocks near, all others at rest; no motion where there is none."""
    on = np.flatnonzero(np.append(near, False)[program.point_blocks].any(axis=1))
    part = _part(program, near, on, program.load)
    answer = decide(part, solve_penalty(part, solver="clarabel", score=False))
    twist = np.zeros((len(near), 6))
    if answer.certificate.proves_unstable:
        twist[near] = answer.twist.reshape(-1, 6)
    nothing = np.zeros((len(program.friction), 3))
    return Proposal(nothing, twist.reshape(-1), np.full(program.n_points, np.nan))


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
