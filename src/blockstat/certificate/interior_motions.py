"""Motions that open every joint, and what they do for a mechanism that a solver has left closing a little.

The slack of an opening, g_n - mu |g_t|, is concave and homogeneous in the twist. So with d a motion that opens all
joints

    slack(u + e d) >= slack(u) + e slack(d) >= 0    for    e = max -slack(u) / min slack(d).

The proof then has no error at all, at the price of e w'd in the work of the loads. The iterates of an interior-point
method are such motions until the joints close, and the last of them cost least.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from blockstat.certificate.check import opening_slack
from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.contact.interfaces import Interfaces

#: Gives twists that may open every joint, shape (6 n,) each, where they are needed.
Motions = Callable[[], Sequence[Floats]]

#: How much slower than upwards the blocks move apart sideways, in the motions that are tried.
SPREADS = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)
#: How much faster than sideways all blocks leave the supports.
LIFT = 2.0
#: Rounding: so much more of the opening motion is added than the mechanism needs.
SLACK = 1e-6
#: Motions compared before one is taken.
FEW = 4


def no_motions() -> tuple[Floats, ...]:
    """Return no twists.

    Returns
    -------
    tuple
        Empty.
    """
    return ()


def expansions(assembly: Assembly, interfaces: Interfaces, blocks: Ints) -> tuple[Floats, ...]:
    """Return the assembly lifted off its supports and growing upwards and more slowly sideways.

    Parameters
    ----------
    assembly
        The blocks, with gravity.
    interfaces
        The joints.
    blocks
        The free blocks, shape (n,).

    Returns
    -------
    tuple of Floats
        Twists, shape (6 n,) each; none without gravity or supports. Blocks only move, without turning, so the twists
        are the same in every unit of rotation.
    """
    strength = float(np.linalg.norm(assembly.gravity))
    touching = np.any(assembly.support[interfaces.pair], axis=1)[interfaces.point_interface]
    if not strength or not touching.any() or not len(blocks):
        return ()
    up = -assembly.gravity / strength
    centre = assembly.centroid[blocks]
    height = (centre - assembly.centroid[blocks[0]]) @ up
    foot = float(((interfaces.point[touching] - assembly.centroid[blocks[0]]) @ up).min())
    level = centre - centre.mean(axis=0)
    level -= np.outer(level @ up, up)
    found = []
    for spread in SPREADS:
        twist = np.zeros((len(blocks), 6))
        lift = LIFT * spread * float(np.linalg.norm(level, axis=1).max())
        twist[:, :3] = spread * level + np.outer(height - foot + lift, up)
        found.append(twist.reshape(-1))
    return tuple(found)


def with_interior_motion(program: PenaltyProgram, twist: Floats, motions: Sequence[Floats]) -> Floats:
    """Add to a twist as little of a motion that opens every joint as leaves none closing.

    Parameters
    ----------
    program
        The penalty program.
    twist
        Shape (6 n,).
    motions
        Tried in this order, shape (6 n,) each.

    Returns
    -------
    Floats
        Shape (6 n,); the twist itself where none closes or no motion helps.
    """
    closing = -least_slack(program, twist)
    if closing <= 0:
        return twist
    for motion in motions:
        least = least_slack(program, motion)
        if least > 0:
            return twist + (1.0 + SLACK) * closing / least * motion
    return twist


def cheapest(program: PenaltyProgram, motions: Iterable[tuple[Floats, float]]) -> Floats | None:
    """Return the motion that opens every joint and takes least work from the loads for it.

    Parameters
    ----------
    program
        The penalty program.
    motions
        Each of shape (6 n,) with its `least_slack`, tried in this order; only the first few that open every joint are
        compared.

    Returns
    -------
    Floats or None
        Shape (6 n,); None if none opens every joint.
    """
    best, least_price, found = None, np.inf, 0
    for motion, slack in motions:
        if slack <= 0:
            continue
        price, found = -float(program.load @ motion) / slack, found + 1
        if price < least_price:
            best, least_price = motion, price
        if found == FEW:
            break
    return best


def least_slack(program: PenaltyProgram, motion: Floats) -> float:
    """Return the slack of the opening at the joint that has least.

    Parameters
    ----------
    program
        The penalty program.
    motion
        Shape (6 n,).

    Returns
    -------
    float
        Above 0 for a motion that opens every joint.
    """
    return float(opening_slack((program.matrix.T @ motion).reshape(-1, 3), program.friction).min(initial=np.inf))
