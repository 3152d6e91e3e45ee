"""Forces and mechanisms at displaced geometry, each with the independent check that all verdicts have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.analysis.verdict import relative_motion
from blockstat.certificate import check as certificate
from blockstat.large_displacement.contacts import Contacts, displaced_interfaces
from blockstat.large_displacement.linkage import Linkage
from blockstat.large_displacement.loading import Structure
from blockstat.large_displacement.pose import Pose, displaced
from blockstat.program.condensed import Bodies, moving_as_one
from blockstat.program.conic import ConicProgram, conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve import clarabel
from blockstat.solve.answer import Answer, EarlyEnd, Status
from blockstat.solve.dispatch import solve
from blockstat.solve.penalty import solve_margin
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    pass

#: Adhesion [mean weights] that equilibrium may lack by the rounding of a solve.
LACKING = 1e-7
#: Weight of the square of the motion in the program of sliding states. Directions that no contact resists, such as
#: that across a slip, do work by rounding only, 1e-16 of the loads; so their motion stays below 1e-6. What it leaves
#: unbalanced is RIDGE times the motion: where that is more than rounding, there is no equilibrium.
RIDGE = 1e-10
#: Programs of the fixed point of joints that slide without opening, and how fast they may open, relative to the motion.
SETTLED, ROUGH = (50, 1e-7), (10, 0.01)
#: The same for a limit load that starts near it: its multiplier hardly changes after the first, and what joints open by
#: is closed by the step.
LIMITED = (5, 0.05)
#: Contacts that slip at less than this, relative to the motion, stick.
STILL = 1e-4


@dataclass(frozen=True, eq=False)
class Forces:
    """Whether forces balance a displaced state."""

    lacking: float  #: adhesion at each contact point without which none do, less than zero with slack [mean weights]
    proven: bool  #: whether the independent check finds them admissible and in balance
    total: float  #: sum of their magnitudes [N]
    mode: Floats  #: the motion that lacks most, shape (n_blocks, 6)
    floating: tuple[int, ...]  #: blocks that nothing holds
    problem: Problem
    forces: Floats  #: at the points of `problem.interfaces`, shape (n_points, 3) [N]


def _found(problem: Problem, force: Floats, twist: Floats, lacking: float, proven: bool) -> Forces:
    """Forces of a program [its unit] as those of a state."""
    assert problem.program is not None
    total = float(np.linalg.norm(force, axis=1).sum()) * problem.program.force_unit
    return Forces(lacking, proven, total, problem.to_blocks(twist), (), problem, problem.to_points(force))


def _floating(problem: Problem) -> Forces:
    """Those of a state in which nothing holds some blocks."""
    none = np.zeros((problem.assembly.n_blocks, 6))
    return Forces(np.inf, False, 0.0, none, tuple(problem.floating.tolist()), problem, np.empty((0, 3)))


def balance(
    structure: Structure, contacts: Contacts, closed: np.ndarray, pose: Pose, parameter: float, multiplier: float
) -> Forces:
    """Find forces that balance a displaced state under a multiple of the live load, or the motion that none resists.

    Parameters
    ----------
    structure
        The assembly and its loads.
    contacts, closed, pose, parameter, multiplier
        As in `Structure.posed`.

    Returns
    -------
    Forces
        The forces with the largest least slack, and their certificate.
    """
    problem = structure.posed(contacts, closed, pose, parameter, multiplier)
    program = problem.program
    if program is None or len(problem.floating):
        return _floating(problem)
    answer = solve_margin(program, solver=structure.solver)
    slack = certificate.point_slack(program, answer.force)[: program.n_points]
    lacking = -float(slack.min(initial=np.inf))
    if answer.status.is_infeasible:
        lacking = np.inf
    force, proven = _checked(program, answer.force, settles=lacking <= LACKING)
    return _found(problem, force, answer.twist, lacking, proven)


def _checked(program: PenaltyProgram, force: Floats, *, settles: bool = True) -> tuple[Floats, bool]:
    """Forces moved to where they balance, and whether the independent check proves them."""
    balanced = certificate.balance(program, force)
    proven = certificate.check(program, balanced, np.zeros_like(program.load)).proves_stable
    if not proven and settles:
        settled = certificate.settle(program, balanced)
        if certificate.check(program, settled, np.zeros_like(program.load)).proves_stable:
            return settled, True
    return balanced, proven


def rubbing(
    structure: Structure, linkage: Linkage, pose: Pose, parameter: float, motion: Floats
) -> tuple[Forces, float]:
    """Find the multiplier of a state in which joints slide against friction, and the forces that balance it.

    Parameters
    ----------
    structure
        The assembly and its loads.
    linkage, pose, parameter
        The state.
    motion
        How it moves, shape (n_blocks, 6): friction acts against it.

    Returns
    -------
    forces : Forces
        With the largest least slack, those of sliding contacts on their friction cones, against the slip.
    multiplier : float
        Of the live load; without one, the force on the moving supports along their movement [N].

    Notes
    -----
    The force of a contact that slides along t is a multiple of n - mu t. So it is a contact without friction, with that
    for its normal. The multiplier is unknown:

        max least slack   subject to   A f + w + alpha l = 0.
    """
    closed = linkage.pinned | linkage.sliding
    problem = structure.posed(linkage.contacts, closed, pose, parameter, 0.0)
    program, faces = problem.program, problem.interfaces
    if program is None or len(problem.floating):
        return _floating(problem), np.nan
    driven = structure.driven(linkage.contacts, closed, pose, parameter)[0][problem.eq.points]
    rate = relative_motion(problem.assembly, faces, motion)[problem.eq.points]
    if structure.live is None:
        rate = rate + driven
    slip = np.hypot(rate[:, 1], rate[:, 2])
    slides = slip > STILL * np.abs(motion).max(initial=0.0)
    point = np.flatnonzero(slides & (program.friction[: program.n_points] > 0))
    local, friction = program.local.reshape(-1, 3, 12).copy(), program.friction.copy()
    along = rate[point, 1:] / slip[point, None]
    mu = friction[point, None]
    local[point, 0] -= mu * (along[:, :1] * local[point, 1] + along[:, 1:] * local[point, 2])
    friction[point] = 0.0
    program = replace(program, local=local.reshape(-1, 12), friction=friction, plane=None)
    total = np.asarray(program.normal_columns.sum(axis=1)).reshape(-1)
    if structure.live is None:
        load = np.zeros_like(total)
        conic = conic_program(program, -program.load - total, at_most_one=total)
    else:
        load = problem.scaled(structure.live_load(pose))
        conic = conic_program(program, -program.load - total, at_most_one=total, pinned=load)
        bound = conic.bound.copy()
        bound[-1] = 0.0  # l'u = 0: the multiplier is free
        conic = replace(conic, bound=bound)
    answer = clarabel.solve(replace(conic, ridge=RIDGE))
    multiplier = answer.multiplier
    loaded = replace(program, load=program.load + multiplier * load)
    # The multipliers are f + tau n.
    rest = program.matrix @ answer.force.reshape(-1) + loaded.load
    tau = float(total @ rest) / float(total @ total)
    force = answer.force.copy()
    force[: program.n_points, 0] -= tau
    unbalanced = RIDGE * float(np.abs(answer.twist).max(initial=0.0))
    lacking = np.inf if answer.status.is_infeasible or unbalanced > LACKING else tau
    force = certificate.balance(loaded, force)
    found = certificate.check(loaded, force, np.zeros_like(program.load))
    if structure.live is None:  # the force on the moving supports, by what the contacts do to them
        # The normal of a contact that slides has friction in it.
        tilted = driven.copy()
        tilted[point, 0] -= mu[:, 0] * (along * driven[point, 1:]).sum(axis=1)
        multiplier = float((force[: program.n_points] * tilted).sum()) * program.force_unit
    return _found(problem, force, answer.twist, lacking, found.proves_stable), multiplier


@dataclass(frozen=True, eq=False)
class Limited:
    """The state in which a displaced structure moves on."""

    #: of the live load; without one, the force on the moving supports [N]; None where the blocks fall under any;
    #: infinite where bodies of several blocks lock each other
    multiplier: float | None
    #: its mechanism, or how they fall, shape (n_blocks, 6), of any size; zero where the solver found neither
    motion: Floats
    forces: Forces | None  #: that balance it; None where the blocks fall, or only bodies were looked at
    #: how fast contacts that slide open, shape (n,); None where that is friction times slip
    lift: Floats | None = None


def as_bodies(
    structure: Structure, contacts: Contacts, closed: np.ndarray, pose: Pose, parameter: float,
    motion: Floats, still: float,
) -> Ints:  # fmt: skip
    """Return which blocks of a displaced structure move as one in a motion.

    Parameters
    ----------
    structure
        The assembly and its loads.
    contacts, closed, pose, parameter
        As in `Structure.posed`.
    motion
        Of the blocks, shape (n_blocks, 6).
    still
        As in `moving_as_one`.

    Returns
    -------
    array of int
        Body of each block, -1 for those that do not move, shape (n_blocks,).
    """
    faces, _ = displaced_interfaces(structure.assembly, structure.interfaces, contacts, closed, pose, parameter)
    rate = relative_motion(displaced(structure.assembly, pose), faces, motion)
    return moving_as_one(structure.assembly.support, faces.pair[faces.point_interface], rate, still)


def _condensed(problem: Problem, body: Ints | None) -> Bodies | None:
    """Bodies of the blocks that a problem has; None where each block is one."""
    program = problem.program
    if body is None or program is None:
        return None
    own = np.concatenate([[-1], body[problem.eq.blocks]])
    number = np.unique(own, return_inverse=True)[1].reshape(-1)[1:] - 1
    if number.max(initial=-1) < 0:
        return None
    return Bodies(program, number, problem.assembly.centroid[problem.eq.blocks] / program.length_unit)


def limited(
    structure: Structure,
    contacts: Contacts,
    closed: np.ndarray,
    pose: Pose,
    parameter: float,
    *,
    dilates: bool = True,
    guess: Floats | None = None,
    limits: tuple[int, float] | None = None,
    bodies: Ints | None = None,
    accuracy: float = 0.0,
) -> Limited:
    """Find the limit multiplier of a displaced state, its mechanism and its forces.

    Parameters
    ----------
    structure
        The assembly and its loads.
    contacts, closed, pose, parameter
        As in `Structure.posed`.
    dilates
        Whether joints open as they slide, by friction times slip. Else they open by little, as `Limited.lift` tells.
    guess
        A motion near it, of any size, shape (n_blocks, 6): by it joints slip at first; not used where they dilate.
    limits
        As `LIMITED`, which is taken with a guess, `ROUGH` without.
    bodies
        Body of each block, -1 for those that do not move, shape (n_blocks,): they move as one, so that the multiplier
        is one of a mechanism, and no forces are told. By default each block is a body.
    accuracy
        As in `EarlyEnd`.

    Returns
    -------
    Limited
        Where no multiplier is carried, the motion is that of steepest descent at which the live load does no work:

            min -w'u + |u|^2 / 2    subject to    l'u = 0,  A'u in K*.

        What nothing touches falls along the weight.
    """
    problem = structure.posed(contacts, closed, pose, parameter, 0.0)
    if problem.program is None or len(problem.floating):
        return _falling(structure, problem, pose)
    part = _condensed(problem, bodies)
    program = problem.program if part is None else part.program
    columns = problem.eq.points if part is None else problem.eq.points[part.columns[: program.n_points]]
    live = structure.live_load(pose)
    load = problem.scaled(live)
    unit = float(np.abs(load).sum()) / program.total_load
    load = load if part is None else part.loads(load)
    points, lift = slice(program.n_points), np.zeros(program.n_points)
    if guess is not None and (power := float((live * guess).sum())) > 0:
        rate = relative_motion(problem.assembly, problem.interfaces, guess)[columns]
        lift = _slip(program, rate) * (program.force_unit * unit / power)

    def least(lifted: Floats) -> Answer:
        offset = np.zeros((len(program.friction), 3))
        offset[points, 0] = lifted
        conic = conic_program(program, -program.load, pinned=load / unit, offset=offset.reshape(-1))
        return solve(conic, solver=structure.solver, early=EarlyEnd(accuracy=accuracy))

    def rates(answer: Answer) -> Floats:
        return (program.matrix.T @ answer.twist).reshape(-1, 3)[points]

    limits = limits or (ROUGH if guess is None else LIMITED)
    slid = None if dilates else _without_opening(program, least, rates, lift, limits, rough=True)
    answer, opening = slid or (least(np.zeros(program.n_points)), None)
    if part is not None and answer.status is Status.PRIMAL_INFEASIBLE:
        return Limited(np.inf, np.zeros_like(live), None)
    if answer.status.is_infeasible or answer.status.is_stalled:
        conic = conic_program(program, -program.load, pinned=load / unit)
        bound = conic.bound.copy()
        bound[-1] = 0.0
        return _descending(problem, replace(conic, bound=bound), part)
    multiplier = answer.multiplier / unit
    if opening is not None:
        contact = structure.driven(contacts, closed, pose, parameter)[1][columns]
        opening = _by_contact(opening, contact, contacts.number)
    if part is not None:
        return Limited(multiplier, problem.to_blocks(part.twists(answer.twist)), None, opening)
    loaded = replace(program, load=program.load + multiplier * load)
    force, proven = _checked(loaded, answer.force)
    slack = certificate.point_slack(loaded, force)[: program.n_points]
    forces = _found(problem, force, answer.twist, -float(slack.min(initial=np.inf)), proven)
    return Limited(multiplier, forces.mode, forces, opening)


def _slip(program: PenaltyProgram, rate: Floats) -> Floats:
    """Friction times slip of rates at the contact points, shape (n_points,)."""
    friction = program.friction[: program.n_points]
    found: Floats = np.where(np.isfinite(friction), friction, 0.0) * np.hypot(rate[:, 1], rate[:, 2])
    return found


def _by_contact(opening: Floats, contact: Ints, number: int) -> Floats:
    """The largest of the points of each contact."""
    found = np.zeros(number)
    np.maximum.at(found, contact, opening)
    return found


def _without_opening(
    program: PenaltyProgram,
    least: Callable[[Floats], Answer],
    rates: Callable[[Answer], Floats],
    lifted: Floats,
    limits: tuple[int, float],
    *,
    rough: bool,
) -> tuple[Answer, Floats] | None:
    """De Saxce's fixed point: joints that slide may open by friction times slip less than with associated friction.

    Parameters
    ----------
    program
        The contact points.
    least
        The answer where normal rates are raised by so much, shape (n_points,).
    rates
        Those at the points in an answer, shape (n_points, 3).
    lifted
        By what they are raised at first.
    limits
        Programs at most, and the change of what they are raised by that is none, relative to the rates.
    rough
        Whether the last one counts too.

    Returns
    -------
    tuple of Answer and Floats, or None
        The answer, and how fast the points open that slide, shape (n_points,).
    """
    passes, tolerance = limits
    for trial in range(passes):
        answer = least(lifted)
        if answer.status.is_infeasible or answer.status.is_stalled:
            return None
        total = rates(answer)
        before, lifted = lifted, _slip(program, total)
        near = np.abs(lifted - before).max(initial=0.0) <= tolerance * np.abs(total).max(initial=0.0)
        if near or (rough and trial == passes - 1):
            return answer, lifted - before
    return None


def limiting(
    structure: Structure,
    contacts: Contacts,
    closed: np.ndarray,
    pose: Pose,
    parameter: float,
    bodies: Ints | None = None,
) -> tuple[float, Floats] | None:
    """Return the limit multiplier of a displaced state with associated friction, and its mechanism.

    Parameters
    ----------
    structure
        The assembly and its loads.
    contacts, closed, pose, parameter
        As in `Structure.posed`.
    bodies
        As in `limited`: the multiplier is an upper bound.

    Returns
    -------
    tuple of float and Floats, or None
        None where no multiplier is carried.
    """
    found = limited(structure, contacts, closed, pose, parameter, bodies=bodies)
    return None if found.multiplier is None else (found.multiplier, found.motion)


def settled(
    structure: Structure,
    contacts: Contacts,
    closed: np.ndarray,
    pose: Pose,
    parameter: float,
    *,
    guess: Floats | None = None,
    rough: bool = False,
) -> Limited:
    """Find the motion of least potential energy for a unit rate of the supports' movement, and the forces with it.

    Parameters
    ----------
    structure
        The assembly and its loads.
    contacts, closed, pose, parameter
        As in `Structure.posed`.
    guess
        A motion near it for a unit rate, shape (n_blocks, 6): by it joints slip at first.
    rough
        Whether joints that slide may open or overlap a little, as `lift` tells: what closes a step closes that too.

    Returns
    -------
    Limited
        The multiplier is the force on the moving supports along their movement [N]. Where the blocks fall, the motion
        is that of steepest descent on supports at rest; where they jam, it is zero.

    Notes
    -----
    Joints slide without opening where their normal rates may be less than those of associated friction by the friction
    times their slip, which is looked for by De Saxce's fixed point. Where it is not found friction is associated.
    """
    problem = structure.posed(contacts, closed, pose, parameter, 0.0)
    program = problem.program
    if program is None or len(problem.floating):
        return _falling(structure, problem, pose)
    rate, points = np.zeros((len(program.friction), 3)), slice(program.n_points)
    driven, contact = structure.driven(contacts, closed, pose, parameter)
    driven, contact = driven[problem.eq.points], contact[problem.eq.points]
    rate[points] = driven

    def least(lifted: Floats) -> Answer:
        offset = rate.copy()
        offset[points, 0] += lifted
        return clarabel.solve(conic_program(program, -program.load, offset=offset.reshape(-1)))

    def rates(answer: Answer) -> Floats:
        return rate[points] + (program.matrix.T @ answer.twist).reshape(-1, 3)[points]

    lifted = np.zeros(program.n_points)
    if guess is not None:
        guessed = relative_motion(problem.assembly, problem.interfaces, guess)[problem.eq.points]
        lifted = _slip(program, guessed + driven)
    slid = _without_opening(program, least, rates, lifted, ROUGH if rough else SETTLED, rough=rough)
    if slid is not None:
        opening = _by_contact(slid[1], contact, contacts.number)
        return replace(_driving(problem, slid[0], driven), lift=opening)
    answer = least(np.zeros(program.n_points))
    if answer.status is Status.PRIMAL_INFEASIBLE:
        return Limited(None, np.zeros((structure.assembly.n_blocks, 6)), None)
    if answer.status.is_infeasible or answer.status.is_stalled:
        return _descending(problem, conic_program(program, -program.load))
    return _driving(problem, answer, driven)


def _driving(problem: Problem, answer: Answer, driven: Floats) -> Limited:
    """A motion of blocks on moving supports, with the forces that go with it."""
    program = problem.program
    assert program is not None
    force = certificate.balance(program, answer.force)
    found = certificate.check(program, force, np.zeros_like(program.load))
    slack = certificate.point_slack(program, force)[: program.n_points]
    forces = _found(problem, force, answer.twist, -float(slack.min(initial=np.inf)), found.proves_stable)
    reaction = float((force[: program.n_points] * driven).sum()) * program.force_unit
    return Limited(reaction, forces.mode, forces)


def _descending(problem: Problem, conic: ConicProgram, part: Bodies | None = None) -> Limited:
    """How blocks fall that nothing holds."""
    answer = clarabel.solve(replace(conic, ridge=1.0))
    # The ridge is 1, so the motion is the force that is left unbalanced; below that of a solve, it is no fall.
    falls = float(np.abs(answer.twist).max(initial=0.0)) > LACKING
    twist = answer.twist if part is None else part.twists(answer.twist)
    return Limited(None, falls * problem.to_blocks(twist), None)


def _falling(structure: Structure, problem: Problem, pose: Pose) -> Limited:
    """What nothing touches falls along its load."""
    force = structure.dead_load(pose)[:, :3]
    fall = np.zeros((structure.assembly.n_blocks, 6))
    fall[problem.floating, :3] = force[problem.floating]
    return Limited(None, fall, None)
