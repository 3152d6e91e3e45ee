"""Statically admissible forces of a displaced structure, with the independent check that all verdicts have."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.linalg import lsqr

from blockstat.analysis.problem import Problem
from blockstat.certificate import check as certificate
from blockstat.large_displacement.displaced.pose import free_sizes
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.program.penalty import PenaltyProgram
from blockstat.program.ties import tied_pairs
from blockstat.solve.answer import Answer
from blockstat.solve.penalty import solve_margin
from blockstat.typing import Floats

#: Forces count as admissible when an adhesion up to this at each contact point makes them so [mean block weights].
#: Chosen: ten times the accuracy to which programs are solved.
ADHESION_TOLERANCE = 1e-7


@dataclass(frozen=True, eq=False)
class EquilibriumForces:
    """Forces that balance the loads on a displaced structure, or what resists equilibrium."""

    #: least adhesion at each contact point with which forces in equilibrium exist [mean block weights]; negative where
    #: they exist with slack, infinite where they do not exist
    adhesion: float
    proven: bool  #: whether the independent check finds the forces admissible and in equilibrium
    total: float  #: sum of their magnitudes [N]
    mechanism: Floats  #: the dual motion, which the contacts resist least, shape (n_blocks, 6)
    floating: tuple[int, ...]  #: blocks that nothing holds
    problem: Problem
    forces: Floats  #: at the points of `problem.interfaces`, in their frames, shape (n_points, 3) [N]
    #: least adhesion that counts as none: more than `ADHESION_TOLERANCE` where the faces of joints miss planes
    tolerance: float = ADHESION_TOLERANCE
    solved: bool = True  #: whether a solver has found them; one that has stalled says nothing of equilibrium

    @property
    def admissible(self) -> bool:
        """Whether forces in equilibrium exist without adhesion, to the tolerance."""
        return self.solved and self.adhesion <= self.tolerance


def forces_of(problem: Problem, force: Floats, twist: Floats, adhesion: float, proven: bool) -> EquilibriumForces:
    """Return the forces of a solved program in newtons.

    Parameters
    ----------
    problem
        The equilibrium problem; it has a program.
    force
        Forces at the points of the program, in its unit, shape (n_points, 3).
    twist
        Motion of the blocks of the program, in its units, shape (6 n,).
    adhesion, proven
        As in `EquilibriumForces`.

    Returns
    -------
    EquilibriumForces
        With forces and motion of all points and blocks of the assembly.
    """
    assert problem.program is not None
    total = float(np.linalg.norm(force, axis=1).sum()) * problem.program.force_unit
    points = problem.to_points(force)
    return EquilibriumForces(adhesion, proven, total, problem.to_blocks(twist), (), problem, points)


def floating_blocks(problem: Problem) -> EquilibriumForces:
    """Return that no forces exist, because some blocks have no contact.

    Parameters
    ----------
    problem
        The equilibrium problem.

    Returns
    -------
    EquilibriumForces
        Without forces or motion.
    """
    none = np.zeros((problem.assembly.n_blocks, 6))
    return EquilibriumForces(np.inf, False, 0.0, none, tuple(problem.floating.tolist()), problem, np.empty((0, 3)))


def unbalanced(problem: Problem) -> float:
    """Return how far the loads on blocks that nothing holds are from balancing each other.

    Parameters
    ----------
    problem
        The equilibrium problem.

    Returns
    -------
    float
        The largest force, or moment over the mean size of the free blocks, on a block that touches none [mean weights
        of the free blocks]; 0 where all blocks are held, and infinite where blocks touch each other that nothing holds.
    """
    loose = problem.floating
    if not len(loose):
        return 0.0
    assembly = problem.assembly
    if np.isin(np.concatenate([problem.interfaces.pair, tied_pairs(assembly)]), loose).any():
        return np.inf
    free = ~assembly.support
    unit, length = assembly.free_weight / free.sum(), float(assembly.size[free].mean())
    force, moment = (np.linalg.norm(problem.load[loose, part], axis=1) for part in (slice(3), slice(3, 6)))
    return float(max(force.max(), moment.max() / length)) / unit


def equilibrium_forces(
    configuration: Configuration, multiplier: float = 0.0, *, motion: Floats | None = None, slides: bool = False
) -> EquilibriumForces:
    """Find forces in equilibrium with the dead load and a multiple of the live load.

    Parameters
    ----------
    configuration
        The displaced structure.
    multiplier
        Of the live load.
    motion
        As in `Configuration.problem`.
    slides
        Whether contacts slide, so that forces are where friction has them, to the flaw of the joints. Forces that hold
        together contacts that stick find their balance where these are drawn.

    Returns
    -------
    EquilibriumForces
        The forces whose smallest slack is largest: max s subject to A f + w + alpha l = 0, f - s n in K.
    """
    problem = configuration.problem(multiplier, motion)
    program = problem.program
    if unbalanced(problem) > ADHESION_TOLERANCE:
        return floating_blocks(problem)
    if program is None:
        none = np.zeros((problem.assembly.n_blocks, 6))
        return EquilibriumForces(0.0, True, 0.0, none, (), problem, np.empty((0, 3)))
    answer = _margin(program, configuration.structure.solver)
    adhesion = np.inf if answer.status.is_infeasible else least_adhesion(program, answer.force)
    tolerance = adhesion_tolerance(configuration, answer.force) if slides else ADHESION_TOLERANCE
    force, proven = checked(program, answer.force, settles=adhesion <= tolerance)
    found = forces_of(problem, force, answer.twist, adhesion, proven)
    return replace(found, solved=proven or not answer.status.is_stalled, tolerance=tolerance)


def _margin(program: PenaltyProgram, solver: str) -> Answer:
    """The forces with the largest smallest slack; loads that are unbalanced by rounding only count as balanced.

    The loads on blocks that hang on ties alone must lie on the lines of these, and no adhesion makes up for what is
    off. So where there is no answer, the part of the loads is left out that no forces of any sign balance, if it is no
    more than the adhesion that counts as none.
    """
    answer = solve_margin(program, solver=solver)
    if not answer.status.is_infeasible:
        return answer
    any_sign = lsqr(program.matrix, -program.load, atol=0.0, btol=0.0, conlim=0.0)[0]
    off = program.load + program.matrix @ any_sign
    if not 0 < float(np.abs(off).max()) <= ADHESION_TOLERANCE:
        return answer
    return solve_margin(replace(program, load=program.load - off), solver=solver)


def adhesion_tolerance(configuration: Configuration, force: Floats) -> float:
    """Return the adhesion at each contact point up to which forces count as admissible.

    Parameters
    ----------
    configuration
        The displaced structure.
    force
        In the unit of the program, shape (n_points, 3).

    Returns
    -------
    float
        [mean block weights]. Forces that are admissible with plane joints are unbalanced where these miss planes, each
        by the flaw of the rates. Corners are off independently of each other, so the squares add up.
    """
    structure = configuration.structure
    flaw = structure.outlines.flaw.rate(float(free_sizes(structure.assembly).mean()))
    return ADHESION_TOLERANCE + flaw * float(np.linalg.norm(force))


def least_adhesion(program: PenaltyProgram, force: Floats) -> float:
    """Return the adhesion that forces need at the contact point that needs most.

    Parameters
    ----------
    program
        The contact points.
    force
        In the unit of the program, shape (n_points, 3).

    Returns
    -------
    float
        Negative where every point has slack.
    """
    slack = certificate.point_slack(program, force)[: program.n_points]
    return -float(slack.min(initial=np.inf))


def checked(program: PenaltyProgram, force: Floats, *, settles: bool = True) -> tuple[Floats, bool]:
    """Return forces moved into equilibrium, and whether the independent check proves them.

    Parameters
    ----------
    program
        With all loads.
    force
        Forces of a solver, in the unit of the program, shape (n_points, 3).
    settles
        Whether to look for admissible forces nearby where the first check fails.

    Returns
    -------
    force : Floats
        Shape (n_points, 3).
    proven : bool
        Whether they are admissible and in equilibrium.
    """
    balanced = certificate.balance(program, force)
    proven = certificate.check(program, balanced, np.zeros_like(program.load)).proves_stable
    if not proven and settles:
        settled = certificate.settle(program, balanced)
        if certificate.check(program, settled, np.zeros_like(program.load)).proves_stable:
            return settled, True
    return balanced, proven
