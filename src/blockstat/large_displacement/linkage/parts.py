"""Parts of a mechanism that may move without the others: several equal mechanisms that begin at one multiplier.

Two equal walls that do not touch begin to turn at the same multiplier. A solver finds a mixture of both, which has two
degrees of freedom. As the multiplier falls along the curve of one of them, the other carries it at rest.

Blocks belong to one part where a contact between them sticks or slides, or a tie joins them that keeps its length or
yields. A part needs another one where it would press against it, or slide along it, were the other at rest. A tie that
the mechanism shortens joins nothing: the first of two tied walls turns towards the second one. But it holds a part that
would lengthen it alone: the second wall does not move away from the first one.
"""

from __future__ import annotations

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.errors import InputError
from blockstat.geometry.components import connected_components
from blockstat.large_displacement.displaced.contact_status import (
    STICKING_SPEED,
    STICKING_SPEED_AT_REST,
    contact_status,
)
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, rest_pose
from blockstat.large_displacement.displaced.structure import Configuration, slackening
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.program.ties import tied_pairs
from blockstat.typing import Floats, Ints

#: A part is a mechanism of the same multiplier where its own is at most this much above that of all parts, relative to
#: it. Chosen: far above what solvers leave, far below what matters.
SAME_MULTIPLIER = 1e-6
#: A part moves the control as much as another where its rate is within this of it, relative to it. Chosen: equal parts
#: differ by what solvers leave.
AS_MUCH = 1e-3
#: Blocks that move more slowly than this hardly move. Relative to the fastest corner. Chosen: far above what solvers
#: leave in blocks that are at rest.
HARDLY = 1e-3


def part_that_moves_control(linkage: Linkage, mechanism: Floats) -> tuple[Floats, Ints] | None:
    """Return the motion of the part of a mechanism at rest that moves the control, with all other blocks at rest.

    Parameters
    ----------
    linkage
        That of the mechanism, at rest and with a control.
    mechanism
        Of all parts, of any magnitude, shape (n_blocks, 6).

    Returns
    -------
    motion : Floats
        A mechanism of the same multiplier, shape (n_blocks, 6).
    left : Ints
        The blocks that move in the given mechanism and not in this one. None for both where the mechanism has no part
        that moves without the others, under the same multiplier, and moves the control. Blocks that a tie holds until
        others have moved are not among those that are left.

    Raises
    ------
    InputError
        Where only parts move the control that a tie holds.

    Notes
    -----
    Of several parts that move the control, it is the one that moves it most for a unit speed of its fastest corner; of
    several such parts, the first in the order of blocks.
    """
    label = _parts(linkage, mechanism)
    if linkage.control is None or label.max() < 1:
        return None
    assembly, pose = linkage.assembly, rest_pose(linkage.assembly)
    every = [_alone(mechanism, label, [part]) for part in range(label.max() + 1)]
    rates = np.array(
        [linkage.control.rate(assembly, pose, motion) / corner_speed(assembly, motion).max() for motion in every]
    )
    held = np.array([_held_by_tie(linkage, motion) for motion in every])
    if held.any() and rates[held].max() > 0 and not (rates[~held] > 0).any():
        raise InputError(
            f"control: the {linkage.control.name} does not move before other blocks have, as a tie holds it; choose a "
            "block that does"
        )
    rates = np.where(held, -np.inf, rates)
    first = int(np.argmax(rates >= rates.max() - AS_MUCH * abs(rates.max())))
    motion = _alone(mechanism, label, _with_needed(linkage, mechanism, label, first))
    structure = linkage.structure
    power = float((structure.live_load(pose) * motion).sum())
    at_rest = (label >= 0) & ~motion.any(axis=1)
    if not (at_rest.any() and power > 0):
        return None
    left = np.flatnonzero(at_rest & ~held[label])
    own, whole = (structure.multiplier(pose, 0.0, each) for each in (motion, mechanism))
    same = own <= whole + SAME_MULTIPLIER * abs(whole)
    return (motion, left) if same and linkage.control.rate(assembly, pose, motion) > 0 else None


def without_left_at_rest(linkage: Linkage, pose: Pose, motion: Floats) -> Floats:
    """Return a mechanism at a pose without the blocks that are left at rest, if they do not touch the rest of it.

    Parameters
    ----------
    linkage
        Its active set is that of the pose.
    pose
        The pose.
    motion
        The mechanism, of any magnitude, shape (n_blocks, 6).

    Returns
    -------
    Floats
        Shape (n_blocks, 6). The given one where closed contacts or ties join blocks that are left at rest and others
        that move, or hardly any others move. Forces in equilibrium do as little work with the loads in it.
    """
    if not len(linkage.left_at_rest):
        return motion
    speed = corner_speed(displaced_assembly(linkage.assembly, pose), motion)
    left = np.isin(np.arange(len(motion)), linkage.left_at_rest)
    moving = speed > STICKING_SPEED * speed.max(initial=0.0)
    pairs = np.concatenate([linkage.contacts.pair[linkage.closed], tied_pairs(linkage.assembly)])
    joined = moving[pairs].all(axis=1) & (left[pairs[:, 0]] != left[pairs[:, 1]])
    if joined.any() or speed[~left].max(initial=0.0) <= HARDLY * speed.max(initial=0.0):
        return motion
    return np.where(left[:, None], 0.0, motion)


def _parts(linkage: Linkage, mechanism: Floats) -> Ints:
    """The part of each block, numbered in the order of blocks; -1 for a block at rest."""
    assembly, contacts = linkage.assembly, linkage.contacts
    speed = corner_speed(assembly, mechanism)
    moving = (speed > STICKING_SPEED_AT_REST * speed.max()) & (linkage.body >= 0)
    ties = np.delete(tied_pairs(assembly), linkage.slack, axis=0)
    pairs = np.concatenate([contacts.pair[linkage.closed], ties])
    _, label = connected_components(assembly.n_blocks, pairs[moving[pairs].all(axis=1)])
    parts: Ints = np.full(assembly.n_blocks, -1)
    parts[moving] = np.unique(label[moving], return_inverse=True)[1]
    return parts


def _alone(mechanism: Floats, label: Ints, parts: list[int]) -> Floats:
    """The motion of some parts, with all other blocks at rest."""
    return np.where(np.isin(label, parts)[:, None], mechanism, 0.0)


def _held_by_tie(linkage: Linkage, motion: Floats) -> bool:
    """Whether the motion of a part lengthens a tie that the motion of all parts shortens."""
    speed = float(corner_speed(linkage.assembly, motion).max())
    return bool((slackening(linkage.assembly, motion)[linkage.slack] < -STICKING_SPEED_AT_REST * speed).any())


def _with_needed(linkage: Linkage, mechanism: Floats, label: Ints, part: int) -> list[int]:
    """A part and all parts that it needs: contacts that open when all move press or slide when it moves alone."""
    contacts, parts = linkage.contacts, [part]
    closed = np.ones(contacts.number, dtype=bool)
    rest = Configuration(linkage.structure, contacts, closed, rest_pose(linkage.assembly), 0.0)
    while True:
        motion = _alone(mechanism, label, parts)
        _, sliding = contact_status(rest, motion, sticking_speed=STICKING_SPEED_AT_REST)
        met = np.unique(label[contacts.pair[sliding & ~linkage.closed]])
        needed = sorted(set(met.tolist()) - {-1, *parts})
        if not needed:
            return parts
        parts += needed


def hang_on_ties(linkage: Linkage, blocks: Ints) -> bool:
    """Return whether blocks stick to nothing, but ties that keep their length hold them, so that they swing.

    Parameters
    ----------
    linkage
        With the contacts and ties of a motion.
    blocks
        Numbers of the blocks that move in it.

    Returns
    -------
    bool
        Whether they do.
    """
    touch = np.isin(linkage.contacts.pair[linkage.sticking], blocks).any()
    return not touch and bool(np.isin(tied_pairs(linkage.assembly)[linkage.ties], blocks).any())
