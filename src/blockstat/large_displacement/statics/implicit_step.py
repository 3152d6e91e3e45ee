"""One finite step of the limit mechanism, in which open contacts may close: a convex program in the motion of the step.

A step has a given live work W. Of all motions u with it, the one of least potential energy of the permanent loads is

    min -w'u    subject to    l'u = W,    gap + n'u >= mu |t'u| at every contact point.

Its multipliers are contact forces and the load multiplier alpha, in equilibrium at the pose where the step begins:
A f + w + alpha l = 0. Contacts carry force that are closed there, or that close within the step. So nothing has to
decide which small gaps count as closed.

A contact that slides at its cone opens by mu times its slip in the step, and closes again when the blocks settle. So
joints slide without opening from step to step. The work that lifts a block in a step, its force times mu times its
slip, is what friction takes. But the multiplier and the motion of a step are those of associated flow.

References
----------
Anitescu, M. (2006). Optimization-based simulation of nonsmooth rigid multibody dynamics. Mathematical Programming 105,
113-143: the same program with inertia, in time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from blockstat.analysis.problem import Problem, free_fall
from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_pairs import pair_points
from blockstat.large_displacement.displaced.pose import displaced_assembly
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.large_displacement.statics.equilibrium import EquilibriumForces, checked, forces_of, least_adhesion
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer, EarlyEnd, Status
from blockstat.solve.dispatch import solve
from blockstat.typing import Floats, Ints

#: Accuracy of the multiplier of a step, as in `EarlyEnd`. Its errors add up over hundreds of blocks, so that a few
#: digits are not enough.
ACCURACY = 1e-8
#: The same of the motion in which blocks settle. Chosen: no multiplier is read off it, but with two digits fewer the
#: curve of a facade in which bricks slide ended elsewhere.
SETTLING_ACCURACY = 1e-7
#: A contact whose gap after the step, less friction times slip, is smaller than this holds. Relative to the motion of
#: the fastest corner. Chosen: far above what solvers leave.
HOLDS = 1e-4
#: A contact carries whose normal force is larger than this. Relative to the largest. Chosen: far above what solvers
#: leave.
CARRIES = 1e-5


@dataclass(frozen=True, eq=False)
class ImplicitStep:
    """What a finite step of given live work does."""

    multiplier: float | None  #: None where blocks fall under any multiplier; infinite where blocks lock each other
    #: displacements and rotations of the blocks about their displaced centroids, shape (n_blocks, 6) [m, rad]; of any
    #: magnitude where they fall, zero where they lock each other or no answer was found
    motion: Floats
    length: float  #: motion of the fastest corner [m]
    forces: EquilibriumForces | None  #: where the step begins; None where blocks fall or lock each other
    holds: np.ndarray  #: which contacts are closed at the end of the step, shape (n_contacts,) bool
    slides: np.ndarray  #: those of them that slide, shape (n_contacts,) bool
    residual_gap: float  #: the largest gap at the beginning of a contact that carries force [m]


@dataclass(frozen=True, eq=False)
class _StepProgram:
    """The program of steps from a pose."""

    configuration: Configuration
    problem: Problem
    program: PenaltyProgram
    work: float  #: of the live load in a step [J]

    @property
    def contact(self) -> Ints:
        """The contact of each point of the program."""
        return self.configuration.joints[1][self.problem.eq.points]

    @cached_property
    def gap(self) -> Floats:
        """The gap of each point of the program [m]; zero where blocks overlap."""
        here = self.configuration
        faces, contact = here.joints
        points = pair_points(here.structure.assembly, here.contacts, here.pose, here.parameter)
        apart = (points[:, 1] - points[:, 0])[contact]
        gap = np.einsum("ni,ni->n", faces.frame[faces.point_interface, 0], apart)
        return np.maximum(gap, 0.0)[self.problem.eq.points]

    @cached_property
    def live(self) -> Floats:
        """The live load in the unit of the program."""
        return self.problem.scaled(self.configuration.structure.live_load(self.configuration.pose))

    @property
    def unit(self) -> float:
        """The size of the live load relative to the weight."""
        return float(np.abs(self.live).sum()) / self.program.total_load

    @property
    def scale(self) -> float:
        """Rates of the program for a unit of displacement: the live work of a step is one in the program [1/m]."""
        return self.program.force_unit * self.unit / self.work

    def solve(self, live_work: float, accuracy: float) -> Answer:
        """Return the answer for so many times the live work of a step."""
        program = self.program
        offset = np.zeros((len(program.friction), 3))
        offset[: program.n_points, 0] = self.gap * self.scale
        conic = conic_program(program, -program.load, pinned=self.live / self.unit, offset=offset.reshape(-1))
        conic = replace(conic, bound=np.append(conic.bound[:-1], live_work * conic.bound[-1]))
        return solve(conic, solver=self.configuration.structure.solver, early=EarlyEnd(accuracy=accuracy))

    def motion(self, answer: Answer) -> Floats:
        """Return the motion of the blocks, shape (n_blocks, 6) [m, rad]."""
        return self.problem.to_blocks(answer.twist) / self.scale


def _step_program(configuration: Configuration, work: float) -> _StepProgram | None:
    """The program of steps from a pose; None where a block has no contact."""
    problem = configuration.problem()
    if problem.program is None or len(problem.floating):
        return None
    return _StepProgram(configuration, problem, problem.program, work)


def implicit_step(configuration: Configuration, work: float) -> ImplicitStep:
    """Find the motion of a finite step.

    Parameters
    ----------
    configuration
        The pose where the step begins, which has a live load. Its closed contacts are all that may close in the step.
    work
        Of the live load in the step [J].

    Returns
    -------
    ImplicitStep
        Its length is that of the motion to first order.
    """
    structure, none = configuration.structure, np.zeros(configuration.contacts.number, dtype=bool)
    own = _step_program(configuration, work)
    if own is None:
        fall = free_fall(configuration.problem())
        return ImplicitStep(None, fall, 0.0, None, none, none, 0.0)
    program, answer = own.program, own.solve(1.0, ACCURACY)
    rest = np.zeros((structure.assembly.n_blocks, 6))
    if answer.status is Status.PRIMAL_INFEASIBLE:
        return ImplicitStep(np.inf, rest, 0.0, None, none, none, 0.0)
    if answer.status.is_infeasible or answer.status.is_stalled:
        fall = own.motion(answer) if answer.status.is_infeasible else rest
        return ImplicitStep(None, fall, 0.0, None, none, none, 0.0)
    motion = own.motion(answer)
    length = float(corner_speed(displaced_assembly(structure.assembly, configuration.pose), motion).max())
    rate = (program.matrix.T @ answer.twist).reshape(-1, 3)[: program.n_points] / own.scale
    slip = np.hypot(rate[:, 1], rate[:, 2])
    friction = program.friction[: program.n_points]
    opening = own.gap + rate[:, 0] - np.where(np.isfinite(friction), friction, 0.0) * slip
    normal_force = answer.force[: program.n_points, 0]
    carries = normal_force > CARRIES * float(normal_force.max())
    closed = carries | (opening <= HOLDS * length)
    holds, slides = none.copy(), none.copy()
    holds[own.contact[closed]] = True
    slides[own.contact[closed & (slip > HOLDS * length)]] = True
    loaded = replace(program, load=program.load + answer.multiplier / own.unit * own.live)
    force, proven = checked(loaded, answer.force)
    forces = forces_of(own.problem, force, answer.twist, least_adhesion(loaded, force), proven)
    residual = float(own.gap[carries].max(initial=0.0))
    return ImplicitStep(answer.multiplier / own.unit, motion, length, forces, holds, slides, residual)


def settling_step(configuration: Configuration, work: float) -> Floats:
    """Find the motion in which the blocks settle onto near contacts while the live load does no work.

    Parameters
    ----------
    configuration, work
        As in `implicit_step`; the work scales the program only.

    Returns
    -------
    Floats
        Shape (n_blocks, 6) [m, rad]; zero where blocks fall.
    """
    own = _step_program(configuration, work)
    rest = np.zeros((configuration.structure.assembly.n_blocks, 6))
    if own is None:
        return rest
    answer = own.solve(0.0, SETTLING_ACCURACY)
    return rest if answer.status.is_infeasible or answer.status.is_stalled else own.motion(answer)
