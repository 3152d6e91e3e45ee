"""Which solver takes a conic program."""

from __future__ import annotations

from dataclasses import replace

from blockstat.program.conic import ConicProgram
from blockstat.solve import clarabel, cvxpy, interior_point
from blockstat.solve.answer import AT_THE_OPTIMUM, Answer, EarlyEnd

#: Unknowns from which the interior-point method is the faster one; below, its many small steps in Python cost more.
STRUCTURED = 500
CHOICES = ("auto", "interior-point", "clarabel", "cvxpy")


def solve(program: ConicProgram, *, solver: str = "auto", early: EarlyEnd = AT_THE_OPTIMUM) -> Answer:
    """Solve a conic program with the interior-point method where it fits and pays, else with Clarabel.

    Parameters
    ----------
    program
        The program.
    solver
        One of `CHOICES`. Where the interior-point method does not fit (bounds on points with infinite friction or
        none) or stalls, Clarabel takes over; the answer says who gave it.
    early
        What may end the interior-point method before the optimum. The other solvers do not ask. With "auto", phase one
        comes before Clarabel too.

    Returns
    -------
    Answer
        Forces, a twist and the status; nothing in them is checked.
    """
    if solver == "cvxpy":
        return cvxpy.solve(program)
    whole = pays(program, solver)
    if program.has_structure and (whole or (early.guess is not None and solver == "auto")):
        answer = interior_point.solve(program, early if whole else replace(early, optimise=False))
        if not answer.status.is_stalled:
            return answer
    return clarabel.solve(program)


def pays(program: ConicProgram, solver: str) -> bool:
    """Return whether the interior-point method is to solve a program of this size.

    Parameters
    ----------
    program
        The program.
    solver
        One of `CHOICES`.

    Returns
    -------
    bool
        True where it is asked for by name, or by "auto" for a large program.
    """
    return solver == "interior-point" or (solver == "auto" and program.width * program.n_blocks >= STRUCTURED)
