"""The limit state of a displaced structure: limit multiplier, mechanism and forces; or how its blocks fall.

Where no multiplier is carried, blocks fall along the motion of steepest descent in which the live load does no work:

    min -w'u + |u|^2 / 2    subject to    l'u = 0,  A'u in K*.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.limit_load import UNBOUNDED
from blockstat.analysis.problem import Problem, free_fall
from blockstat.analysis.verdict import relative_motion
from blockstat.certificate import check as certificate
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.large_displacement.statics.de_saxce import (
    FROM_GUESS,
    ROUGH,
    largest_of_contact,
    uplift,
    without_opening,
)
from blockstat.large_displacement.statics.equilibrium import (
    ADHESION_TOLERANCE,
    EquilibriumForces,
    checked,
    forces_of,
    least_adhesion,
)
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve import clarabel
from blockstat.solve.answer import Answer, EarlyEnd, Status
from blockstat.solve.dispatch import solve
from blockstat.typing import Floats


@dataclass(frozen=True, eq=False)
class LimitState:
    """The state in which a displaced structure moves on."""

    #: of the live load; without one, the force on the moving supports [N]. None where blocks fall under any multiplier
    #: that is not negative. Infinite where blocks lock each other: any multiplier is carried, or no motion follows the
    #: moving supports.
    multiplier: float | None
    #: the mechanism, or how the blocks fall, of any magnitude, shape (n_blocks, 6); zero where they lock each other,
    #: and where neither a multiplier was found nor a proof that none is carried
    mechanism: Floats
    forces: EquilibriumForces | None  #: None where blocks fall
    #: rates at which contacts open that slide, shape (n_contacts,); None where that is friction times slip
    opening: Floats | None = None


def limit_state(
    configuration: Configuration,
    *,
    associated: bool = True,
    guess: Floats | None = None,
    accuracy: float = 0.0,
) -> LimitState:
    """Find the limit multiplier of a displaced structure, its mechanism and its forces.

    Parameters
    ----------
    configuration
        The displaced structure, which has a live load.
    associated
        Whether flow is associated: joints open by friction times slip as they slide. If not, they open by little, as
        `LimitState.opening` says.
    guess
        A mechanism near the wanted one, of any magnitude, shape (n_blocks, 6). De Saxce's fixed point begins with its
        slip. Associated flow does not use it.
    accuracy
        As in `EarlyEnd`.

    Returns
    -------
    LimitState
        Where no multiplier is carried, how the blocks fall. Blocks that nothing holds fall along their load, those that
        touch each other as one body. An infinite multiplier has a proof.
    """
    problem, structure = configuration.problem(), configuration.structure
    if problem.program is None or len(problem.floating):
        return LimitState(None, free_fall(problem), None)
    program, columns = problem.program, problem.eq.points
    live = structure.live_load(configuration.pose)
    load = problem.scaled(live)
    unit = float(np.abs(load).sum()) / program.total_load  # scales the live load to the size of the weight
    points, first = slice(program.n_points), np.zeros(program.n_points)
    # In the program the live load has a unit power, so the slip of the guess is divided by its power.
    if guess is not None and (power := float((live * guess).sum())) > 0:
        rate = relative_motion(problem.assembly, problem.interfaces, guess)[columns]
        first = uplift(program, rate) * (program.force_unit * unit / power)

    def solve_with(lifted: Floats) -> Answer:
        offset = np.zeros((len(program.friction), 3))
        offset[points, 0] = lifted
        conic = conic_program(program, -program.load, pinned=load / unit, offset=offset.reshape(-1))
        return solve(conic, solver=structure.solver, early=EarlyEnd(accuracy=accuracy))

    def rates_of(answer: Answer) -> Floats:
        return (program.matrix.T @ answer.twist).reshape(-1, 3)[points]

    limits = ROUGH if guess is None else FROM_GUESS
    none = np.zeros(program.n_points)
    found = None if associated else without_opening(program, solve_with, rates_of, first, limits, accept_last=True)
    if found is None and first.any():
        found = without_opening(program, solve_with, rates_of, none, ROUGH, accept_last=True)
    answer, opening = found or (solve_with(none), None)
    if answer.status.is_infeasible or answer.status.is_stalled:
        fall = steepest_descent(problem, program, answer, load / unit)
        locked = fall is None and _carries_any_multiple(program, answer, load / unit)
        return LimitState(np.inf if locked else None, np.zeros_like(live) if fall is None else fall, None)
    if opening is not None:
        opening = largest_of_contact(opening, configuration.joints[1][columns], configuration.contacts.number)
    multiplier = answer.multiplier / unit
    forces = _forces(problem, replace(program, load=program.load + multiplier * load), answer)
    return LimitState(multiplier, forces.mechanism, forces, opening)


def _forces(problem: Problem, loaded: PenaltyProgram, answer: Answer) -> EquilibriumForces:
    """The forces of a limit load, checked under all loads."""
    force, proven = checked(loaded, answer.force)
    return forces_of(problem, force, answer.twist, least_adhesion(loaded, force), proven)


def _carries_any_multiple(program: PenaltyProgram, answer: Answer, load: Floats) -> bool:
    """Whether the ray of an infeasible program, as the independent check finds it, holds a live load alone.

    Then any multiple is carried beyond one that is carried, as admissible forces may be added.
    """
    if answer.status is not Status.PRIMAL_INFEASIBLE or not answer.multiplier > 0:
        return False
    # Rays lie in the cones without their bounds from below, and are zero where forces are bounded from above.
    upper = np.where(np.isinf(program.upper), np.inf, 0.0)
    alone = replace(program, load=load, lower=np.zeros_like(program.lower), upper=upper)
    return checked(alone, answer.force / answer.multiplier)[1]


def associated_limit(configuration: Configuration, accuracy: float = 0.0) -> LimitState | None:
    """Return the limit state with associated flow.

    Parameters
    ----------
    configuration
        The displaced structure, which has a live load.
    accuracy
        As in `EarlyEnd`.

    Returns
    -------
    LimitState or None
        None where no multiplier is carried, or any.
    """
    found = limit_state(configuration, accuracy=accuracy)
    return None if found.multiplier is None or np.isinf(found.multiplier) else found


def steepest_descent(problem: Problem, program: PenaltyProgram, answer: Answer, live: Floats | None) -> Floats | None:
    """Return how blocks fall that no forces hold.

    Parameters
    ----------
    problem
        The equilibrium problem.
    program
        Its program.
    answer
        Of the program that was solved for a multiplier or a motion of the supports, and found infeasible or stalled.
    live
        The live load, in the unit of the program; None where supports move.

    Returns
    -------
    Floats or None
        Of any magnitude, shape (n_blocks, 6). None where the motion is below the accuracy of a solve, and where it is
        not proven that the blocks fall: what a solver leaves that has stalled proves nothing.

    Notes
    -----
    The weight of |u|^2 / 2 is one, so the motion equals the forces that are left unbalanced.
    """
    conic = conic_program(program, -program.load, pinned=live)
    if live is not None:  # l'u = 0
        conic = replace(conic, bound=np.append(conic.bound[:-1], 0.0))
    found = clarabel.solve(replace(conic, ridge=1.0))
    if not float(np.abs(found.twist).max(initial=0.0)) > ADHESION_TOLERANCE:
        return None
    ray = [answer.twist] if answer.status is Status.DUAL_INFEASIBLE else []
    if not any(_proves_fall(program, twist, live) for twist in (found.twist, *ray)):
        return None
    return problem.to_blocks(found.twist)


def _proves_fall(program: PenaltyProgram, twist: Floats, live: Floats | None) -> bool:
    """Whether the independent check proves that a motion drives blocks that no forces of a bounded size hold.

    Nor does a live load of a multiple that is not negative, where the live load drives the motion too, or does no work
    but for rounding.
    """
    none = np.zeros((len(program.friction), 3))
    if not certificate.check(program, none, twist).proves_unstable:
        return False
    return live is None or -float(live @ twist) * UNBOUNDED <= float(program.load @ twist)
