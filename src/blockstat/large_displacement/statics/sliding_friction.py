"""The multiplier of a configuration in which joints slide against friction, and the forces of that state.

The force of a contact that slides along a unit vector t is a multiple of n - mu t, as friction acts against the slip.
So it is a contact without friction whose normal is n - mu t.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from blockstat.analysis.thrust import power_on_supports
from blockstat.analysis.verdict import corner_speed, relative_motion
from blockstat.certificate import check as certificate
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.large_displacement.statics.equilibrium import (
    EquilibriumForces,
    adhesion_tolerance,
    floating_blocks,
    forces_of,
)
from blockstat.program.conic import ConicProgram, conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve import clarabel
from blockstat.solve.answer import Answer
from blockstat.typing import Floats, Ints

#: Weight of the square of the motion in the program. Directions that no contact resists, such as that across a slip, do
#: work by rounding only, 1e-16 of the loads, so their motion stays below 1e-16 / 1e-10 = 1e-6. The program leaves
#: unbalanced this weight times the motion; where that is more than rounding, no equilibrium exists.
MOTION_WEIGHT = 1e-10
#: Contacts that slip more slowly than this stick. Relative to the fastest corner, or to the supports. Chosen: above
#: what solvers leave.
STICKING_SPEED = 1e-4
#: Steps of Newton's method at most in which the direction of slip is corrected. Chosen: slips turn by less than
#: `STICKING_SPEED`, so the first leaves that part of the error.
MAX_TURNS = 2
#: Programs with at most so many equations are corrected once whatever they leave, as errors of directions add up along
#: a path. Chosen: the correction of a larger one, which is dense, takes longer than the program.
SMALL = 300
#: Weight of the rates at which contacts open, or slip that stick, beside the friction of those that slide. Chosen: such
#: motions are then left out, while tilts that are rounding hold nothing.
HELD = 1e2


def sliding_multiplier(
    configuration: Configuration, motion: Floats, *, associated: bool = False
) -> tuple[EquilibriumForces, float, Floats]:
    """Find the multiplier and the forces of a state in which joints slide against friction in a given motion.

    Parameters
    ----------
    configuration
        The displaced structure.
    motion
        Rates of the blocks about their displaced centroids, shape (n_blocks, 6). Friction acts against the slip, and
        ties pull as they lengthen or shorten.
    associated
        Whether joints open by friction times slip as they slide.

    Returns
    -------
    forces : EquilibriumForces
        Those with the largest smallest slack; at contacts that slide they lie on the friction cone. Where supports
        move, of all such forces those that resist them most, or push them least: those of the least potential energy.
    multiplier : float
        Of the live load. Without a live load, the force of the structure on the moving supports along their movement
        [N].
    motion : Floats
        The motion in which friction balances the loads across the slip, too: as given, but for what solvers leave.

    Notes
    -----
    The multiplier alpha is unknown:

        max s   subject to   A f + w + alpha l = 0,   f - s n in K.
    """
    structure = configuration.structure
    problem = configuration.problem(motion=motion + structure.support_motion)
    program = problem.program
    if program is None or len(problem.floating):
        return floating_blocks(problem), np.nan, motion
    driven = configuration.support_rates(problem)
    rate = relative_motion(problem.assembly, problem.interfaces, motion)[problem.eq.points]
    if structure.live is None:
        rate = rate + driven[: program.n_points]
    slip = np.hypot(rate[:, 1], rate[:, 2])
    fastest = float(corner_speed(problem.assembly, motion).max(initial=0.0))
    slides = slip > STICKING_SPEED * max(fastest, float(structure.live is None))
    point = np.flatnonzero(slides & (program.friction[: program.n_points] > 0))
    sliding = _Sliding(point, rate[point, 1:] / slip[point, None], program.friction[point, None])
    load = np.zeros_like(program.load)
    if structure.live is not None:
        load = problem.scaled(structure.live_load(configuration.pose))
    state = _balanced(program, sliding, None if structure.live is None else load)
    tolerance = adhesion_tolerance(configuration, state.force)
    for turns in range(MAX_TURNS):
        wanted = state.unbalanced > tolerance or (not turns and len(program.load) <= SMALL)
        turned = _turned(program, sliding, slip[point], state, associated) if wanted else None
        if turned is None:
            break
        sliding, twist = turned
        state = _balanced(program, sliding, None if structure.live is None else load)
        motion = motion + problem.to_blocks(twist)
    answer, multiplier, force = state.answer, state.answer.multiplier, state.force
    loaded = replace(_with_tilted_normals(program, sliding), load=program.load + multiplier * load)
    missing = np.inf if answer.status.is_infeasible or state.unbalanced > tolerance else state.adhesion
    if structure.live is None and missing <= tolerance:
        force = _of_most_resistance(loaded, sliding, driven, force)
    force = certificate.balance(loaded, force)
    proven = certificate.check(loaded, force, np.zeros_like(program.load)).proves_stable
    force = _with_friction(force, sliding)
    if structure.live is None:
        multiplier = power_on_supports(problem, driven, structure.support_motion, force)
    found = forces_of(problem, force, answer.twist, missing, proven)
    return replace(found, tolerance=tolerance), multiplier, motion


class _Sliding(NamedTuple):
    """The contact points that slide against friction."""

    point: Ints  #: their numbers, shape (k,)
    along: Floats  #: unit vectors of the slip in the frames of the joints, shape (k, 2)
    friction: Floats  #: shape (k, 1)


class _Balanced(NamedTuple):
    """Forces of points that slide along given directions."""

    answer: Answer
    force: Floats  #: along tilted normals, in the unit of the program, shape (m, 3)
    adhesion: float  #: that the points need
    residual: Floats  #: what the forces leave unbalanced, shape (6 n,)

    @property
    def unbalanced(self) -> float:
        """The largest part of what is left."""
        return MOTION_WEIGHT * float(np.abs(self.answer.twist).max(initial=0.0))


def _balanced(program: PenaltyProgram, sliding: _Sliding, live: Floats | None) -> _Balanced:
    """The forces with the largest smallest slack whose friction acts along given directions."""
    tilted = _with_tilted_normals(program, sliding)
    total = np.asarray(tilted.normal_columns.sum(axis=1)).reshape(-1)
    answer = clarabel.solve(_margin_program(tilted, total, live))
    load = tilted.load if live is None else tilted.load + answer.multiplier * live
    # The solver's forces are f + adhesion n.
    residual = tilted.matrix @ answer.force.reshape(-1) + load
    adhesion = float(total @ residual) / float(total @ total)
    force = answer.force.copy()
    force[: program.n_points, 0] -= adhesion
    return _Balanced(answer, force, adhesion, tilted.matrix @ force.reshape(-1) + load)


def _of_most_resistance(tilted: PenaltyProgram, sliding: _Sliding, driven: Floats, force: Floats) -> Floats:
    """The forces along tilted normals that push the moving supports least; the given ones where there are no such.

    A block on two supports that both hold it by friction may press on either with more than its share, and so may
    anything whose friction is not used up. `settling_state` has the forces of least potential energy as well.
    """
    offset, point = driven.copy(), sliding.point
    offset[point, 0] -= (sliding.friction * sliding.along * offset[point, 1:]).sum(axis=1)
    answer = clarabel.solve(conic_program(tilted, -tilted.load, offset=offset.reshape(-1)))
    return force if answer.status.is_infeasible or answer.status.is_stalled else answer.force


def _turned(
    program: PenaltyProgram, sliding: _Sliding, slip: Floats, state: _Balanced, associated: bool
) -> tuple[_Sliding, Floats] | None:
    """The sliding points whose slip is turned so that friction balances what is left, and the motion that turns it.

    None where it turns too far.

    A body that slides on a plane may move across its slip, too. Friction resists that in proportion to how far the slip
    turns, which is where the loads across it are balanced. A solver knows that motion to the root of its accuracy only,
    as the energy is flat there. With u across the slip, one step of Newton's method solves

        sum of b (mu N / |s|) b'u = what is left,    b the wrench of a unit force across the slip at a point,

    in motions that leave the contacts as open as they are, or with associated flow open them by friction times slip:
    the rates along n, or along n - mu t, are zero. A spin alone would then be no motion of the linkage, and the roll
    that it needs moves the contacts across the slip.
    """
    if state.answer.status.is_infeasible:
        return None
    points = np.asarray(program.matrix.todense()).reshape(len(program.load), -1, 3)
    across = np.column_stack([-sliding.along[:, 1], sliding.along[:, 0]])
    wrench = np.einsum("rpk,pk->rp", points[:, sliding.point, 1:], across)
    held = np.delete(points, sliding.point, axis=1).reshape(len(program.load), -1)
    opening = points[:, sliding.point, 0]
    if associated:
        opening = opening - np.einsum("rpk,pk->rp", points[:, sliding.point, 1:], sliding.friction * sliding.along)
    held = np.hstack([opening, held])
    normal = np.maximum(state.force[sliding.point, 0], 0.0)
    rows = np.hstack([wrench * np.sqrt(sliding.friction[:, 0] * normal / slip), HELD * held]).T
    motion = np.linalg.lstsq(rows.T @ rows, state.residual, rcond=None)[0].astype(float)
    turn = (motion @ wrench) / slip
    if not np.abs(turn).max(initial=0.0) <= STICKING_SPEED:
        return None
    along = sliding.along + turn[:, None] * across
    return sliding._replace(along=along / np.linalg.norm(along, axis=1)[:, None]), motion


def _with_tilted_normals(program: PenaltyProgram, sliding: _Sliding) -> PenaltyProgram:
    """The program whose sliding points are without friction and have n - mu t for their normals."""
    local, friction = program.local.reshape(-1, 3, 12).copy(), program.friction.copy()
    point, along = sliding.point, sliding.along
    local[point, 0] -= sliding.friction * (along[:, :1] * local[point, 1] + along[:, 1:] * local[point, 2])
    friction[point] = 0.0
    return replace(program, local=local.reshape(-1, 12), friction=friction, plane=None)


def _margin_program(program: PenaltyProgram, total: Floats, live: Floats | None) -> ConicProgram:
    """The program of the largest smallest slack; with a live load its multiplier is free, so l'u = 0."""
    if live is None:
        conic = conic_program(program, -program.load - total, at_most_one=total)
    else:
        conic = conic_program(program, -program.load - total, at_most_one=total, pinned=live)
        bound = conic.bound.copy()
        bound[-1] = 0.0
        conic = replace(conic, bound=bound)
    return replace(conic, ridge=MOTION_WEIGHT)


def _with_friction(force: Floats, sliding: _Sliding) -> Floats:
    """Forces along tilted normals in the frames of the joints, shape (m, 3)."""
    found, point = force.copy(), sliding.point
    found[point, 1:] -= sliding.friction * sliding.along * force[point, :1]
    return found
