"""The limit state of a displaced structure: limit multiplier, mechanism and forces; or how its blocks fall.

Where no multiplier is carried, blocks fall along the motion of steepest descent in which the live load does no work:

    min -w'u + |u|^2 / 2    subject to    l'u = 0,  A'u in K*.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import UNBOUNDED
from blockstat.analysis.problem import Problem, free_fall
from blockstat.analysis.verdict import relative_motion
from blockstat.certificate import check as certificate
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.large_displacement.statics.de_saxce import (
    FALLING,
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

#: Where joints slide without opening a second program lets them overlap by this share of friction times slip. A thrust
#: that no load causes would do work in that overlap, and vanishes. Forces that a load causes lose no more of the
#: multiplier than this share of the power of friction. So where twice that is lost, the second program is followed; a
#: step then closes the overlap. Chosen: at a tenth of it the walls of a slot still kept their thrust at rest.
LOOSENESS = 0.01


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
    falls_dilating: bool = True,
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
    falls_dilating
        Whether blocks that fall slide with associated flow in any case.

    Returns
    -------
    LimitState
        Where no multiplier is carried, how the blocks fall. Blocks that nothing holds fall along their load, those that
        touch each other as one body. An infinite multiplier has a proof.
    """
    problem = configuration.problem()
    own = _limit_program(configuration, problem)
    if own is None:
        return LimitState(None, free_fall(problem), None)
    program, columns = own.program, problem.eq.points
    live = configuration.structure.live_load(configuration.pose)
    none = first = np.zeros(program.n_points)
    # In the program the live load has a unit power, so the slip of the guess is divided by its power.
    if guess is not None and (power := float((live * guess).sum())) > 0:
        rate = relative_motion(problem.assembly, problem.interfaces, guess)[columns]
        first = uplift(program, rate) * (program.force_unit * own.unit / power)

    def rates_of(answer: Answer) -> Floats:
        return (program.matrix.T @ answer.twist).reshape(-1, 3)[: program.n_points]

    limits = ROUGH if guess is None else FROM_GUESS

    def sliding(looseness: float) -> tuple[Answer, Floats] | None:
        options: dict[str, Any] = {"accept_last": True, "looseness": looseness}
        found = without_opening(program, own.solve, rates_of, first, limits, **options)
        if found is None and first.any():
            found = without_opening(program, own.solve, rates_of, none, ROUGH, **options)
        return found

    found = None if associated else sliding(0.0)
    if found is not None:
        pressed = found[0].force[: program.n_points, 0] @ uplift(program, rates_of(found[0]))
        loose = sliding(LOOSENESS)
        if loose is not None and found[0].multiplier - loose[0].multiplier > 2.0 * LOOSENESS * float(pressed):
            found = loose  # more is lost than the overlap costs: the rest was a thrust that no load causes
    answer, opening = found or (own.solve(none), None)
    if answer.status.is_infeasible or answer.status.is_stalled:
        fall = steepest_descent(
            configuration, problem, program, answer, own.live, associated=associated or falls_dilating
        )
        locked = fall is None and _carries_any_multiple(program, answer, own.live)
        return fall or LimitState(np.inf if locked else None, np.zeros_like(live), None)
    if opening is not None:
        opening = largest_of_contact(opening, configuration.joints[1][columns], configuration.contacts.number)
    loaded = replace(program, load=program.load + answer.multiplier * own.live)
    forces = _forces(problem, loaded, answer)
    return LimitState(answer.multiplier / own.unit, forces.mechanism, forces, opening)


@dataclass(frozen=True, eq=False)
class _LimitProgram:
    """The program of the limit multiplier of a displaced structure."""

    program: PenaltyProgram
    live: Floats  #: the live load, as large as the weight
    unit: float  #: the size of the live load relative to the weight
    solver: str

    def solve(self, lifted: Floats, accuracy: float = 0.0) -> Answer:
        """Return the answer where contacts open at least at given rates, shape (n_points,)."""
        offset = np.zeros((len(self.program.friction), 3))
        offset[: self.program.n_points, 0] = lifted
        conic = conic_program(self.program, -self.program.load, pinned=self.live, offset=offset.reshape(-1))
        return solve(conic, solver=self.solver, early=EarlyEnd(accuracy=accuracy))


def _limit_program(configuration: Configuration, problem: Problem) -> _LimitProgram | None:
    """The program at a pose; None where a block has no contact."""
    program = problem.program
    if program is None or len(problem.floating):
        return None
    load = problem.scaled(configuration.structure.live_load(configuration.pose))
    unit = float(np.abs(load).sum()) / program.total_load
    return _LimitProgram(program, load / unit, unit, configuration.structure.solver)


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


def associated_multiplier(configuration: Configuration, accuracy: float = 0.0) -> float | None:
    """Return the limit multiplier with associated flow.

    Parameters
    ----------
    configuration
        The displaced structure, which has a live load.
    accuracy
        As in `EarlyEnd`.

    Returns
    -------
    float or None
        None where no multiplier is carried, or any.
    """
    own = _limit_program(configuration, configuration.problem())
    if own is None:
        return None
    answer = own.solve(np.zeros(own.program.n_points), accuracy)
    return None if answer.status.is_infeasible or answer.status.is_stalled else answer.multiplier / own.unit


def steepest_descent(
    configuration: Configuration,
    problem: Problem,
    program: PenaltyProgram,
    answer: Answer,
    live: Floats | None,
    *,
    associated: bool,
) -> LimitState | None:
    """Return how blocks fall that no forces hold.

    Parameters
    ----------
    configuration
        The displaced structure.
    problem
        Its equilibrium problem.
    program
        The problem's program.
    answer
        Of the program that was solved for a multiplier or a motion of the supports, and found infeasible or stalled.
    live
        The live load, in the unit of the program; None where supports move.
    associated
        As in `limit_state`.

    Returns
    -------
    LimitState or None
        The motion is of any magnitude. None where it is below the accuracy of a solve, and where it is not proven that
        the blocks fall: what a solver leaves that has stalled proves nothing.

    Notes
    -----
    The weight of |u|^2 / 2 is one, so the motion of associated flow equals the forces that are left unbalanced. That
    flow has the proof. But joints that slide open in it, and the projection of a step that closes them leads back to
    where the step began.
    """

    def solve_with(lifted: Floats) -> Answer:
        offset = np.zeros((len(program.friction), 3))
        offset[: program.n_points, 0] = lifted
        conic = conic_program(program, -program.load, pinned=live, offset=offset.reshape(-1))
        if live is not None:  # l'u = 0
            conic = replace(conic, bound=np.append(conic.bound[:-1], 0.0))
        return clarabel.solve(replace(conic, ridge=1.0))

    def rates_of(answer: Answer) -> Floats:
        return (program.matrix.T @ answer.twist).reshape(-1, 3)[: program.n_points]

    none = np.zeros(program.n_points)
    found = solve_with(none)
    if not float(np.abs(found.twist).max(initial=0.0)) > ADHESION_TOLERANCE:
        return None
    ray = [answer.twist] if answer.status is Status.DUAL_INFEASIBLE else []
    if not any(_proves_fall(program, twist, live) for twist in (found.twist, *ray)):
        return None
    sliding = None if associated else without_opening(program, solve_with, rates_of, none, FALLING, accept_last=True)
    if sliding is None or not float(np.abs(sliding[0].twist).max(initial=0.0)) > ADHESION_TOLERANCE:
        return LimitState(None, problem.to_blocks(found.twist), None)
    contact = configuration.joints[1][problem.eq.points]
    opening = largest_of_contact(sliding[1], contact, configuration.contacts.number)
    return LimitState(None, problem.to_blocks(sliding[0].twist), None, opening)


def _proves_fall(program: PenaltyProgram, twist: Floats, live: Floats | None) -> bool:
    """Whether the independent check proves that a motion drives blocks that no forces of a bounded size hold.

    Nor does a live load of a multiple that is not negative, where the live load drives the motion too, or does no work
    but for rounding.
    """
    none = np.zeros((len(program.friction), 3))
    if not certificate.check(program, none, twist).proves_unstable:
        return False
    return live is None or -float(live @ twist) * UNBOUNDED <= float(program.load @ twist)
