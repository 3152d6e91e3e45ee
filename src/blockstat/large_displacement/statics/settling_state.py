"""The state of a displaced structure on supports that move: the motion of least potential energy, and its forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.analysis.problem import Problem, free_fall
from blockstat.analysis.thrust import power_on_supports
from blockstat.analysis.verdict import relative_motion
from blockstat.certificate import check as certificate
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.large_displacement.statics.de_saxce import (
    CONVERGED,
    ROUGH,
    largest_of_contact,
    uplift,
    without_opening,
)
from blockstat.large_displacement.statics.equilibrium import forces_of, least_adhesion
from blockstat.large_displacement.statics.limit_state import LimitState, steepest_descent
from blockstat.large_displacement.statics.sliding_friction import MOTION_WEIGHT
from blockstat.program.conic import conic_program
from blockstat.solve import clarabel
from blockstat.solve.answer import Answer, Status
from blockstat.typing import Floats

#: A motion that is this many times as fast as the supports is solved for once more, as the least of those with the same
#: energy. A block that has left its contacts may swing at any speed, and part as little from some of them as the
#: program's accuracy. Chosen: what the supports drive is as fast near a dead centre only.
FASTEST = 1e2


def settling_state(
    configuration: Configuration, *, guess: Floats | None = None, rough: bool = False, falls_dilating: bool = True
) -> LimitState:
    """Find the motion of least potential energy for a unit rate of the supports' movement, and its forces.

    Parameters
    ----------
    configuration
        The displaced structure.
    guess
        A motion near the wanted one for a unit rate, shape (n_blocks, 6). De Saxce's fixed point begins with its slip.
    rough
        Whether joints that slide may open or overlap a little, as `LimitState.opening` says: the projection of a
        finite step closes them.
    falls_dilating
        Whether blocks that fall slide with associated flow.

    Returns
    -------
    LimitState
        The multiplier is the force of the structure on the moving supports along their movement [N]. Where blocks fall,
        the motion is that of steepest descent on supports at rest. Where they jam, it is zero and the multiplier
        infinite.

    Notes
    -----
    The program is min -w'u subject to A'u + r in K*, with r the rates by the supports' movement. Joints slide without
    opening by De Saxce's fixed point; where that is not found, flow is associated.
    """
    problem = configuration.problem()
    program = problem.program
    if program is None or len(problem.floating):
        return LimitState(None, free_fall(problem), None)
    rate, points = configuration.support_rates(problem), slice(program.n_points)

    def solve_with(lifted: Floats) -> Answer:
        offset = rate.copy()
        offset[points, 0] += lifted
        conic = conic_program(program, -program.load, offset=offset.reshape(-1))
        answer = clarabel.solve(conic)
        if answer.status.is_infeasible or float(np.abs(answer.twist).max(initial=0.0)) <= FASTEST:
            return answer
        return clarabel.solve(replace(conic, ridge=MOTION_WEIGHT))

    def rates_of(answer: Answer) -> Floats:
        return rate[points] + (program.matrix.T @ answer.twist).reshape(-1, 3)[points]

    first = np.zeros(program.n_points)
    if guess is not None:
        guessed = relative_motion(problem.assembly, problem.interfaces, guess)[problem.eq.points]
        first = uplift(program, guessed + rate[points])
    limits = ROUGH if rough else CONVERGED
    found = without_opening(program, solve_with, rates_of, first, limits, accept_last=rough)
    if found is not None:
        contact = configuration.joints[1][problem.eq.points]
        opening = largest_of_contact(found[1], contact, configuration.contacts.number)
        return replace(_with_reaction(configuration, problem, found[0], rate), opening=opening)
    answer = solve_with(np.zeros(program.n_points))
    none = np.zeros((configuration.structure.assembly.n_blocks, 6))
    if answer.status is Status.PRIMAL_INFEASIBLE:
        return LimitState(np.inf, none, None)
    if answer.status.is_infeasible or answer.status.is_stalled:
        fall = steepest_descent(configuration, problem, program, answer, None, associated=falls_dilating)
        return fall or LimitState(None, none, None)
    return _with_reaction(configuration, problem, answer, rate)


def _with_reaction(configuration: Configuration, problem: Problem, answer: Answer, rate: Floats) -> LimitState:
    """The answer's motion and forces, with the power of the forces at a unit rate of the supports [N]."""
    program = problem.program
    assert program is not None
    force = certificate.balance(program, answer.force)
    proven = certificate.check(program, force, np.zeros_like(program.load)).proves_stable
    forces = forces_of(problem, force, answer.twist, least_adhesion(program, force), proven)
    reaction = power_on_supports(problem, rate, configuration.structure.support_motion, force)
    return LimitState(reaction, forces.mechanism, forces)
