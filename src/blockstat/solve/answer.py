"""What a solver returns, how a solve ended, and what may end it early. Nothing in an answer is trusted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from blockstat.certificate.check import UNCHECKED, Certificate
from blockstat.program.conic import ConicProgram
from blockstat.result import Sentence
from blockstat.typing import Floats


class Status(Sentence):
    """How a solve ended; each value is a sentence."""

    SOLVED = "Solved: the optimum to the tolerance of the solver."
    ALMOST_SOLVED = "Almost solved: the optimum to a looser tolerance than asked for."
    ACCEPTED = "Accepted: the solve ended early with forces that prove stability."
    MECHANISM = "Mechanism: the solve ended early with a mechanism that proves instability."
    PRIMAL_INFEASIBLE = "Primal infeasible: no twist satisfies the constraints, and a ray of forces shows it."
    DUAL_INFEASIBLE = "Dual infeasible: no forces balance the load, and a ray of twists shows it."
    STALLED = "Stalled: the solver stopped short of an answer."
    NO_FORCES = "No forces: phase one found none, and no optimum was asked for."
    RECALLED = "Recalled: evidence of an earlier design decided, and nothing was solved."
    MIXED = "Mixed: connected components ended in different ways."

    @property
    def is_infeasible(self) -> bool:
        """Whether the program, or its dual, has no feasible point."""
        return self in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE)

    @property
    def is_proven(self) -> bool:
        """Whether the solve ended early with evidence that has passed the independent check."""
        return self in (Status.ACCEPTED, Status.MECHANISM)

    @property
    def is_stalled(self) -> bool:
        """Whether there is no answer to speak of."""
        return self in (Status.STALLED, Status.NO_FORCES)


#: A program solved for its multipliers has the two kinds of infeasibility exchanged.
EXCHANGED = {
    Status.PRIMAL_INFEASIBLE: Status.DUAL_INFEASIBLE,
    Status.DUAL_INFEASIBLE: Status.PRIMAL_INFEASIBLE,
}


@dataclass(frozen=True, eq=False)
class EarlyEnd:
    """What may end a solve before its optimum. Nothing does unless asked for."""

    forces: Callable[[Floats], bool] | None = None  #: told forces on the way, shape (m, 3); True ends with `ACCEPTED`
    twist: Callable[[Floats], bool] | None = None  #: told twists on the way, shape (6 n,); True ends with `MECHANISM`
    #: Forces inside the cones, or on their boundaries, shape (m, 3), from which phase one looks for forces in balance
    #: before the iteration (see `blockstat.solve.phase_one`). None leaves phase one out.
    guess: Floats | None = None
    #: Whether the first proof is all that is asked: phase one ends where forces are not found easily, and the steps of
    #: the iteration keep its twists inside the cones, where a mechanism is found sooner.
    brief: bool = False
    stands: bool = False  #: whether forces are expected, so that phase one looks for them longer
    optimise: bool = True  #: whether the iteration follows where phase one finds none
    #: Told twist, forces and multiplier of each iterate; True ends with `ACCEPTED`. The iteration then starts at
    #: `inside`, forces inside their cones that balance the cost, shape (m, 3), and a motion that opens every joint.
    #: Both stay so on the way (see `blockstat.solve.interior_point`). Where no such motion is found nothing is solved.
    pair: Callable[[Floats, Floats, float], bool] | None = None
    inside: Floats | None = None
    #: Relative error of the balance, the motion and the gap between both at which the iteration ends with
    #: `ALMOST_SOLVED`. The least that the method reaches unless asked for.
    accuracy: float = 0.0
    sharp: bool = False  #: whether the iteration goes on from a good answer as long as it gains digits


#: Go on to the optimum.
AT_THE_OPTIMUM = EarlyEnd()


@dataclass(frozen=True, eq=False)
class Answer:
    """Forces and a twist in the units of a program."""

    force: Floats  #: contact forces f, shape (m, 3)
    twist: Floats  #: u, shape (6 n,)
    status: Status
    iterations: int
    solver: str  #: which one answered
    multiplier: float = 0.0  #: lambda of A f + w + lambda l = 0 when a load l was pinned
    #: y, the closing that the upper bounds of forces allow, shape (m,)
    yielding: Floats = field(default_factory=lambda: np.empty(0))
    #: s of a program with a compliance as velocities at the points, shape (m, 3)
    rates: Floats = field(default_factory=lambda: np.empty((0, 3)))
    #: s of the penalty program, shape (n_points,); nan where the solve ended with a mechanism before its optimum
    adhesion: Floats = field(default_factory=lambda: np.empty(0))
    bounded: bool = True  #: False when no adhesion is enough; then `twist` is a ray along which the work grows
    interior: Floats | None = None  #: a twist met on the way that opens every joint, shape (6 n,)
    certificate: Certificate = UNCHECKED  #: what the independent check makes of `force` and `twist`


def read_answer(
    program: ConicProgram,
    x: Floats,
    z: Floats,
    status: Status,
    iterations: int,
    solver: str,
    slack: Floats | None = None,
) -> Answer:
    """Read an answer off the unknowns and the multipliers of a program.

    Parameters
    ----------
    program
        The program that was solved.
    x
        Its unknowns, shape (n,).
    z
        The multipliers of its rows, shape (n_rows,).
    status
        How the solve ended.
    iterations
        Factorisations that the solve took.
    solver
        The name of the solver.
    slack
        s of the rows, shape (n_rows,), of a program with a compliance.

    Returns
    -------
    Answer
        Forces and twists of the assembly, unfolded where the program is planar.
    """
    return Answer(
        force=program.forces(z),
        twist=program.twist(x),
        status=status,
        iterations=iterations,
        solver=solver,
        multiplier=float(z[-1]) if program.pinned else 0.0,
        yielding=program.yielding(x),
        rates=np.empty((0, 3)) if slack is None else program.rates(slack),
    )


def no_answer(program: ConicProgram, iterations: int) -> Answer:
    """Return what a solve leaves that was stopped.

    Parameters
    ----------
    program
        The program.
    iterations
        Factorisations until then.

    Returns
    -------
    Answer
        Without forces and without a twist.
    """
    return read_answer(program, 0 * program.cost, 0 * program.bound, Status.STALLED, iterations, "interior-point")
