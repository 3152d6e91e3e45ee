"""Motions that no admissible forces resist, exactly, next to those of a solver.

The slack of an opening, g_n - mu |g_t|, is concave and homogeneous. So a motion u that closes contacts by rounding
opens all of them with a little of a motion d that opens all (`blockstat.certificate.interior_motions`):

    slack(u + e d) >= slack(u) + e slack(d).

Where contacts jam no motion opens them all. Blocks that move as one are then joined to one body, between whose
contacts nothing moves at all. What closes even so is bounded: forces that sum to less than `BOUND` times the loads do
not resist.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.certificate.check import FORCE_LIMIT, opening_slack
from blockstat.contact.point_law import joint_friction
from blockstat.geometry.components import connected_components
from blockstat.geometry.polyhedron import point_velocity
from blockstat.proof.centre import endless, opening_motion
from blockstat.proof.exact_check import Power, power
from blockstat.proof.rational import Exact, exact, rounded
from blockstat.proof.structure import Structure
from blockstat.typing import Floats, Ints

#: Contact forces of so many dead loads are none (`blockstat.certificate.check.FORCE_LIMIT`).
BOUND = int(FORCE_LIMIT)
#: Decimal places of velocities and rotations behind the first digit of the greatest.
PLACES = 20
#: How far a motion is opened, relative to what its contacts close by; and at least, relative to its size.
MORE, LEAST = 2.0, 1e-14
#: Rates below this fraction of the fastest velocity are none; a motion that opens contacts less opens none.
STILL = 1e-9


def driven_motion(problem: Problem, structure: Structure, mechanism: Floats) -> tuple[Exact, Power]:
    """Return a motion near a mechanism that no admissible forces resist, or none of a size in question.

    Parameters
    ----------
    problem
        The posed problem.
    structure
        The same, exactly.
    mechanism
        Velocity of the centroid and rotation of each block, shape (n_blocks, 6).

    Returns
    -------
    motion : Exact
        Velocity of the point at the origin and rotation of each block, shape (n_blocks, 6).
    power : Power
        What drives it, and what resists it.
    """
    alone = np.arange(len(mechanism))
    motion = _at_origin(problem, mechanism, alone)
    best = power(structure, motion)
    opening = _opening(problem) if best.closing else None
    if opening is not None:
        size = float(np.abs(mechanism).max())
        share = MORE * float(best.closing) * size + LEAST * size
        motion = _at_origin(problem, mechanism + share * opening, alone)
        best = power(structure, motion)
    if best.closing:
        joined = _at_origin(problem, _settled(problem, mechanism), _bodies(problem, mechanism))
        second = power(structure, joined)
        if second.multiplier(BOUND) < best.multiplier(BOUND) if best.live > 0 else second.closing < best.closing:
            motion, best = joined, second
    return motion, best


def _at_origin(problem: Problem, mechanism: Floats, body: Ints) -> Exact:
    """Exact motions about the origin; blocks of one body move as the block that gives it its number."""
    size = float(np.abs(mechanism).max()) or 1.0
    twist = rounded(mechanism[body] / size, PLACES)
    centre = exact(problem.assembly.centroid[body])
    twist[:, :3] = twist[:, :3] - np.cross(twist[:, 3:], centre)
    twist[problem.assembly.support] = Fraction(0)
    return twist


def _rates(problem: Problem, motion: Floats) -> Floats:
    """Relative velocities at the contact points in their frames, shape (n, 3)."""
    interfaces = problem.interfaces
    k = interfaces.point_interface
    one, two = (point_velocity(problem.assembly, motion, interfaces.pair[k, side], interfaces.point) for side in (0, 1))
    return np.einsum("nij,nj->ni", interfaces.frame[k], two - one)


def _program_rates(problem: Problem, motion: Floats, columns: Ints) -> Floats:
    """Relative velocities of columns of three of the program, shape (n, 3)."""
    assert problem.program is not None
    twist = (motion[problem.eq.blocks] * np.repeat([1.0, problem.program.length_unit], 3)).reshape(-1)
    rows = (3 * columns[:, None] + np.arange(3)).ravel()
    return (problem.program.matrix[:, rows].T @ twist).reshape(-1, 3)


def _opening(problem: Problem) -> Floats | None:
    """A motion that opens all contacts, and shortens all ties without limit, by one or more; None where none does."""
    friction = joint_friction(problem.assembly, problem.interfaces)[problem.interfaces.point_interface]
    if problem.program is None or np.isinf(friction).any():
        return None

    ties = endless(problem.program)

    def least(motion: Floats) -> float:
        slack = np.append(opening_slack(_rates(problem, motion), friction), _program_rates(problem, motion, ties)[:, 0])
        return float(slack.min()) / float(np.abs(motion).max())

    motions = [problem.to_blocks(twist) for twist in problem.motions()]
    found = max(motions, key=least, default=None)
    if found is None or least(found) < STILL:
        twist = opening_motion(problem.program)
        found = None if twist is None else problem.to_blocks(twist)
    if found is None or least(found) < STILL:
        return None
    return found / (least(found) * float(np.abs(found).max()))


def _bodies(problem: Problem, mechanism: Floats) -> Ints:
    """A block of each body of blocks that move as one, a fixed one if there is one."""
    still = np.abs(_rates(problem, mechanism)).max(axis=1) <= STILL * np.abs(mechanism).max()
    interfaces = problem.interfaces
    together = np.logical_and.reduceat(still, interfaces.start[:-1]) & (np.diff(interfaces.start) > 2)
    fixed = np.flatnonzero(problem.assembly.support)
    pairs = np.concatenate([interfaces.pair[together], np.column_stack([np.full(len(fixed), fixed[0]), fixed])])
    _, label = connected_components(problem.assembly.n_blocks, pairs)
    head = np.zeros(label.max() + 1, dtype=np.int64)
    order = np.argsort(problem.assembly.support, kind="stable")  # fixed blocks last
    head[label[order]] = order
    return head[label]


def _settled(problem: Problem, mechanism: Floats) -> Floats:
    """The mechanism with the rates that it leaves at zero brought there as far as rounding allows."""
    if problem.program is None:
        return mechanism
    friction = problem.program.friction[: problem.program.n_points]
    rate = _rates(problem, mechanism)[problem.eq.points]
    size = np.abs(mechanism).max()
    zero = np.abs(rate) <= STILL * size
    zero[np.isinf(friction), 1:] = True
    ties = endless(problem.program)
    ties = ties[np.abs(_program_rates(problem, mechanism, ties)[:, 0]) <= STILL * size]
    rows = problem.program.matrix.T.tocsr()[np.append(np.flatnonzero(zero.reshape(-1)), 3 * ties)]
    twist = (mechanism[problem.eq.blocks] * np.repeat([1.0, problem.program.length_unit], 3)).reshape(-1)
    inverse = np.linalg.pinv(rows.toarray(), rcond=STILL)
    for _ in range(3):
        twist = twist - inverse @ (rows @ twist)
    return problem.to_blocks(twist)
