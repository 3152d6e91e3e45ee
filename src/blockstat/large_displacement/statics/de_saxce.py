"""De Saxce's fixed point: joints slide without opening (non-associated flow), by programs of associated flow.

With associated flow a contact that slides at the speed s opens at the rate mu s. The programs here let the normal rate
be smaller than that by a given amount, the uplift. At the fixed point the uplift equals mu s at every contact that
slides, so the joints do not open.

References
----------
De Saxce, G. & Feng, Z.-Q. (1998). The bipotential method: a constructive approach to design the complete contact law
with friction and improved numerical algorithms. Mathematical and Computer Modelling 28, 225-245.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer
from blockstat.typing import Floats, Ints


class FixedPointLimits(NamedTuple):
    """When the fixed-point iteration ends."""

    programs: int  #: programs at most
    tolerance: float  #: change of the uplift at which it has converged, relative to the largest rate


#: To convergence, for the mechanism of a linkage, which may not open where it slides. Chosen: the tolerance is ten
#: times the accuracy of the programs.
CONVERGED = FixedPointLimits(50, 1e-7)
#: For a finite step without an initial guess. Chosen: what joints open by is closed by the step's projection.
ROUGH = FixedPointLimits(10, 0.01)
#: For blocks that fall, without an initial guess: the motion of associated flow may be a fortieth of theirs, and then
#: grows before it converges. Chosen.
FALLING = FixedPointLimits(40, 0.01)
#: For a finite step with an initial guess: the multiplier hardly changes after the first program, and what joints open
#: by is closed by the step's projection. Chosen.
FROM_GUESS = FixedPointLimits(5, 0.05)


def uplift(program: PenaltyProgram, rate: Floats) -> Floats:
    """Return friction times slip at the contact points.

    Parameters
    ----------
    program
        The contact points.
    rate
        Their relative velocities (normal, two tangents), shape (n_points, 3).

    Returns
    -------
    Floats
        Shape (n_points,); zero where friction is infinite.
    """
    friction = program.friction[: program.n_points]
    found: Floats = np.where(np.isfinite(friction), friction, 0.0) * np.hypot(rate[:, 1], rate[:, 2])
    return found


def without_opening(
    program: PenaltyProgram,
    solve_with: Callable[[Floats], Answer],
    rates_of: Callable[[Answer], Floats],
    first: Floats,
    limits: FixedPointLimits,
    *,
    accept_last: bool,
    looseness: float = 0.0,
) -> tuple[Answer, Floats] | None:
    """Iterate to the mechanism whose joints slide without opening.

    Parameters
    ----------
    program
        The contact points.
    solve_with
        Solves the program of associated flow with a given uplift, shape (n_points,).
    rates_of
        Relative velocities at the contact points in an answer, shape (n_points, 3).
    first
        The uplift to begin with, shape (n_points,).
    limits
        When the iteration ends.
    accept_last
        Whether the last program counts although it has not converged.
    looseness
        By which share of friction times slip joints may overlap. With any above zero, forces that only hold each other
        give up.

    Returns
    -------
    answer : Answer
        Of the last program.
    opening : Floats
        Rates at which the contacts open that slide, shape (n_points,); negative where they overlap.

    None is returned where a program has no solution, or where the iteration does not converge.
    """
    lifted, changes = (1.0 + looseness) * first, list[float]()
    before = dilatancy = lifted
    for _ in range(limits.programs):
        answer = solve_with(lifted)
        if answer.status.is_infeasible or answer.status.is_stalled:
            return None
        rate = rates_of(answer)
        dilatancy = uplift(program, rate)
        before, lifted = lifted, (1.0 + looseness) * dilatancy
        changes.append(float(np.abs(lifted - before).max(initial=0.0)))
        if changes[-1] <= limits.tolerance * np.abs(rate).max(initial=0.0):
            return answer, dilatancy - before
    return (answer, dilatancy - before) if accept_last and changes[-1] <= changes[0] else None


def largest_of_contact(opening: Floats, contact: Ints, number: int) -> Floats:
    """Return the largest opening rate among the points of each contact.

    Parameters
    ----------
    opening
        Of each point, shape (n_points,).
    contact
        The contact of each point, shape (n_points,).
    number
        The number of contacts.

    Returns
    -------
    Floats
        Shape (number,), at least zero.
    """
    found = np.zeros(number)
    np.maximum.at(found, contact, opening)
    return found
