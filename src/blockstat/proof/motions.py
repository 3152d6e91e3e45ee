"""Motions that no admissible forces resist, exactly, next to those of a solver.

The slack of an opening, g_n - mu |g_t|, is concave and homogeneous. So a motion u that closes contacts by rounding
opens all of them with a little of a motion d that opens all (`blockstat.certificate.interior_motions`):

    slack(u + e d) >= slack(u) + e slack(d).

Where contacts jam no motion opens them all, and with ties that have no limit none may shorten them too. Blocks that
move as one are then joined to one body, between whose contacts nothing moves at all, and d is a motion of bodies. What
closes even so is bounded: forces that sum to less than `BOUND` times the loads do not resist.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from scipy import sparse

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
    if best.closing:
        motion, best = _opened(problem, structure, mechanism, alone, (motion, best))
    if best.closing:
        body, settled = _bodies(problem, mechanism), _settled(problem, mechanism)
        joined = _at_origin(problem, settled, body)
        found = joined, power(structure, joined)
        if found[1].closing:
            found = _opened(problem, structure, settled, body, found)
        if found[1].multiplier(BOUND) < best.multiplier(BOUND) if best.live > 0 else found[1].closing < best.closing:
            motion, best = found
    return motion, best


def _opened(
    problem: Problem, structure: Structure, mechanism: Floats, body: Ints, found: tuple[Exact, Power]
) -> tuple[Exact, Power]:
    """A motion of bodies with a little of one that opens all contacts between them; what was found where none does."""
    opening = _opening(problem, body)
    if opening is None:
        return found
    size = float(np.abs(mechanism).max())
    share = MORE * float(found[1].closing) * size + LEAST * size
    motion = _at_origin(problem, mechanism + share * opening, body)
    return motion, power(structure, motion)


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


def _opening(problem: Problem, body: Ints) -> Floats | None:
    """A motion of bodies that opens all contacts between them, and shortens ties without limit, by one or more.

    None where none does.
    """
    program, interfaces = problem.program, problem.interfaces
    friction = joint_friction(problem.assembly, interfaces)[interfaces.point_interface]
    if program is None or np.isinf(friction).any():
        return None
    own = np.append(body[problem.eq.blocks], body[problem.assembly.support][0])  # the last is that of supports
    rows = np.concatenate([np.arange(program.n_points), endless(program)])
    rows = rows[own[program.point_blocks[rows, 0]] != own[program.point_blocks[rows, 1]]]

    def least(motion: Floats) -> float:
        rates = _program_rates(problem, motion, rows)
        points = rows < program.n_points
        slack = np.append(opening_slack(rates[points], program.friction[rows[points]]), rates[~points, 0])
        return float(slack.min(initial=np.inf)) / float(np.abs(motion).max())

    motions = [problem.to_blocks(twist) for twist in problem.motions()] if (body == np.arange(len(body))).all() else []
    found = max(motions, key=least, default=None)
    if found is None or least(found) < STILL:
        twist = opening_motion(program, rows, _basis(problem, body))
        found = None if twist is None else problem.to_blocks(twist)
    if found is None or not STILL <= least(found) < np.inf:
        return None
    return found / (least(found) * float(np.abs(found).max()))


def _basis(problem: Problem, body: Ints) -> sparse.csr_array:
    """Twists of the program under which the blocks of each body move as one, shape (6 n, 6 n_bodies)."""
    assert problem.program is not None
    centroid, blocks = problem.assembly.centroid / problem.program.length_unit, problem.eq.blocks
    heads = np.unique(body[blocks][~problem.assembly.support[body[blocks]]])
    column, moving = np.searchsorted(heads, body[blocks]), np.flatnonzero(~problem.assembly.support[body[blocks]])
    basis = sparse.lil_array((6 * len(blocks), 6 * len(heads)))
    for row in moving:
        first, start = 6 * row, 6 * column[row]
        basis[np.arange(first, first + 6), np.arange(start, start + 6)] = 1.0
        x, y, z = centroid[blocks[row]] - centroid[body[blocks[row]]]
        arm = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
        basis[first : first + 3, start + 3 : start + 6] = arm  # times a rotation: the velocity of the centroid
    return basis.tocsr()


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
