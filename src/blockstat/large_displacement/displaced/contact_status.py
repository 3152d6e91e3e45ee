"""Which closed contacts stick, slide or open in a motion, and which ties keep their length or are slack."""

from __future__ import annotations

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.geometry.polyhedron import point_velocity
from blockstat.large_displacement.displaced.contact_pairs import edge_crossings, gap_normals, pair_points
from blockstat.large_displacement.displaced.pose import displaced_assembly, free_sizes
from blockstat.large_displacement.displaced.structure import SLACK, Configuration, slack_of_ties, slackening
from blockstat.typing import Floats, Ints

#: Contacts that move more slowly than this stick. Relative to the fastest corner. Chosen: far above what solvers leave.
STICKING_SPEED = 1e-4
#: The same for the mechanism that leaves rest. Chosen: smaller, so that contacts that open slowly open from the
#: beginning.
STICKING_SPEED_AT_REST = 1e-5


def contact_status(
    configuration: Configuration,
    motion: Floats,
    support_rate: float = 0.0,
    *,
    sticking_speed: float = STICKING_SPEED,
    associated: bool = True,
    opening: Floats | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return which of the closed contacts stick and which slide in a motion; the others open.

    Parameters
    ----------
    configuration
        The displaced structure with its closed contacts.
    motion
        Rates of the blocks about their displaced centroids, of any magnitude, shape (n_blocks, 6).
    support_rate
        Rate of the supports' movement.
    sticking_speed
        Contacts that move more slowly than this stick. Relative to the fastest corner, or to the supports.
    associated
        Whether flow is associated in this motion: contacts that slide open by friction times slip.
    opening
        Rates at which those contacts open that slide, shape (n_contacts,), where they are known.

    Returns
    -------
    sticking, sliding : array of bool, shape (n_contacts,)
        Of all contacts.
    """
    contacts, closed = configuration.contacts, configuration.closed
    there = displaced_assembly(configuration.structure.assembly, configuration.pose)
    speed = max(float(corner_speed(there, motion).max(initial=0.0)), support_rate) or 1.0
    size = float(free_sizes(configuration.structure.assembly).mean())
    flaw = configuration.structure.outlines.flaw
    sticking_speed = max(sticking_speed, flaw.speed(size))
    points = pair_points(configuration.structure.assembly, contacts, configuration.pose, configuration.parameter)
    place = edge_crossings(contacts, configuration.pose, points)[0].mean(axis=1)
    a, b = (point_velocity(there, motion, contacts.pair[:, k], place) for k in (0, 1))
    relative = (b - a + support_rate * (contacts.drive[:, 1] - contacts.drive[:, 0])) / speed
    normal, valid = gap_normals(contacts, configuration.pose, points)
    along = np.einsum("nij,nj->ni", normal, relative)
    normal_rate = np.where(valid, along, np.inf).min(axis=1)
    slip = np.sqrt(np.maximum((relative**2).sum(axis=1) - normal_rate**2, 0.0))
    moves = (np.abs(relative).max(axis=1) > sticking_speed) & closed
    slips = slip > sticking_speed
    if opening is not None:
        by_flow = opening / speed
    else:
        by_flow = np.where(associated & slips, contacts.friction, 0.0) * np.where(slips, slip, 0.0)
    rises = np.maximum(sticking_speed, 2.0 * flaw.tilt * slip)
    opens = normal_rate - np.where(slips, by_flow, 0.0) > rises
    return closed & ~moves, moves & ~opens


def tie_status(
    configuration: Configuration, motion: Floats, support_rate: float = 0.0, *, sticking_speed: float = STICKING_SPEED
) -> tuple[Ints, Ints]:
    """Return which ties keep their length in a motion, and which are slack or shorten.

    Parameters
    ----------
    configuration
        The displaced structure.
    motion
        Rates of the blocks about their displaced centroids, of any magnitude, shape (n_blocks, 6).
    support_rate
        Rate of the supports' movement.
    sticking_speed
        Ties that shorten more slowly than this keep their length, and so do those that lengthen more slowly, or have no
        greatest force. Relative to the fastest corner, or to the supports.

    Returns
    -------
    ties, slack : array of int
        Numbers of ties. Those that yield, and those whose force is constant, are neither.
    """
    structure, assembly = configuration.structure, configuration.structure.assembly
    if not assembly.ties:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    pose = structure.with_supports(configuration.pose, configuration.parameter)
    there = displaced_assembly(assembly, pose)
    speed = max(float(corner_speed(there, motion).max(initial=0.0)), support_rate) or 1.0
    unilateral = np.array([not tie.constant for tie in assembly.ties])
    shortens = slackening(there, motion + support_rate * structure.support_motion) / speed
    shorter = slack_of_ties(assembly, pose) / float(free_sizes(assembly).max())
    slack = (shorter > SLACK) | (shortens > sticking_speed)
    finite = np.isfinite([tie.greatest for tie in assembly.ties])
    yields = finite & (shortens < -sticking_speed)
    return np.flatnonzero(unilateral & ~slack & ~yields), np.flatnonzero(unilateral & slack)
