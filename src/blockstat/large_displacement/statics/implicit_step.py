"""One finite step of the limit mechanism, in which open contacts may close: a convex program in the motion of the step.

A step has a given live work W. Of all motions u with it, the one of least potential energy of the permanent loads is

    min -w'u    subject to    l'u = W,    gap + n'u >= mu |t'u| at every contact point.

Its multipliers are contact forces and the load multiplier alpha, in equilibrium at the pose where the step begins:
A f + w + alpha l = 0. Contacts carry force that are closed there, or that close within the step. So nothing has to
decide which small gaps count as closed.

A contact that slides at its cone opens by mu times the slip of one step. In the next step it is open by that much, and
closes again while it slides on. So joints slide without opening, to the length of a step, with no iteration.

References
----------
Anitescu, M. (2006). Optimization-based simulation of nonsmooth rigid multibody dynamics. Mathematical Programming 105,
113-143, which does so in time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_pairs import pair_points
from blockstat.large_displacement.displaced.pose import displaced_assembly
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.large_displacement.statics.equilibrium import EquilibriumForces, checked, forces_of, least_adhesion
from blockstat.large_displacement.statics.limit_state import free_fall
from blockstat.program.conic import conic_program
from blockstat.solve.answer import EarlyEnd, Status
from blockstat.solve.dispatch import solve
from blockstat.typing import Floats

#: Accuracy of the multiplier of a step, as in `EarlyEnd`. Its errors add up over hundreds of blocks, so a few digits are
#: not enough.
ACCURACY = 1e-8
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
    problem, structure, contacts = configuration.problem(), configuration.structure, configuration.contacts
    none = np.zeros(contacts.number, dtype=bool)
    program = problem.program
    if program is None or len(problem.floating):
        fall = free_fall(structure, problem, configuration.pose).mechanism
        return ImplicitStep(None, fall, 0.0, None, none, none, 0.0)
    faces, contact = configuration.joints
    points = pair_points(structure.assembly, contacts, configuration.pose, configuration.parameter)
    apart = (points[:, 1] - points[:, 0])[contact]
    gap = np.maximum(np.einsum("ni,ni->n", faces.frame[faces.point_interface, 0], apart), 0.0)[problem.eq.points]
    live = structure.live_load(configuration.pose)
    load = problem.scaled(live)
    unit = float(np.abs(load).sum()) / program.total_load  # scales the live load to the size of the weight
    scale = program.force_unit * unit / work  # of a motion, so that its live work is one in the program
    offset = np.zeros((len(program.friction), 3))
    offset[: program.n_points, 0] = gap * scale
    conic = conic_program(program, -program.load, pinned=load / unit, offset=offset.reshape(-1))
    answer = solve(conic, solver=structure.solver, early=EarlyEnd(accuracy=ACCURACY))
    if answer.status is Status.PRIMAL_INFEASIBLE:
        return ImplicitStep(np.inf, np.zeros_like(live), 0.0, None, none, none, 0.0)
    motion = problem.to_blocks(answer.twist)
    if answer.status.is_infeasible:
        return ImplicitStep(None, motion, 0.0, None, none, none, 0.0)
    if answer.status.is_stalled:
        return ImplicitStep(None, np.zeros_like(live), 0.0, None, none, none, 0.0)
    motion = motion * (work / float((live * motion).sum()))
    length = float(corner_speed(displaced_assembly(structure.assembly, configuration.pose), motion).max())
    rate = (program.matrix.T @ answer.twist).reshape(-1, 3)[: program.n_points] / scale
    slip = np.hypot(rate[:, 1], rate[:, 2])
    friction = program.friction[: program.n_points]
    opening = gap + rate[:, 0] - np.where(np.isfinite(friction), friction, 0.0) * slip
    own = contact[problem.eq.points]
    carries = answer.force[: program.n_points, 0] > CARRIES * float(answer.force[: program.n_points, 0].max())
    closed = carries | (opening <= HOLDS * length)
    holds, slides = none.copy(), none.copy()
    holds[own[closed]] = True
    slides[own[closed & (slip > HOLDS * length)]] = True
    multiplier = answer.multiplier / unit
    loaded = replace(program, load=program.load + multiplier * load)
    force, proven = checked(loaded, answer.force, settles=True)
    forces = forces_of(problem, force, answer.twist, least_adhesion(loaded, force), proven)
    return ImplicitStep(multiplier, motion, length, forces, holds, slides, float(gap[carries].max(initial=0.0)))
