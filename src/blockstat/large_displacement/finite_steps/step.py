"""One finite step: along the motion of a limit state, then onto zero gap, then the limit state at the new pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE, ZERO_GAP, gaps, pair_points, rejoined
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED
from blockstat.large_displacement.displaced.control import conjugate_control
from blockstat.large_displacement.displaced.pose import Pose, free_sizes
from blockstat.large_displacement.displaced.structure import SLACK, slack_of_ties
from blockstat.large_displacement.finite_steps.contact_projection import projected_onto_zero_gap
from blockstat.large_displacement.finite_steps.free_motion import without_free_motion
from blockstat.large_displacement.finite_steps.trial_state import (
    NOT_SOLVED,
    TrialState,
)
from blockstat.large_displacement.linkage.jump import CLOSING_ACCURACY
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.parts import without_left_at_rest
from blockstat.large_displacement.linkage.path import end_at
from blockstat.large_displacement.linkage.root_finding import root_of
from blockstat.large_displacement.overlap.edge_overlap import cut_to_faces
from blockstat.large_displacement.overlap.face_overlap import AREA_CORNERS, overlap_points, with_overlap_points
from blockstat.large_displacement.statics.limit_state import limit_state
from blockstat.large_displacement.statics.settling_state import settling_state
from blockstat.typing import Floats

#: The projection keeps contacts open whose gap is larger than this. Relative to the step. Chosen: a step of that length
#: cannot close them.
PROJECTION_REACH = 10


def stepped(trial: TrialState, step: float) -> TrialState:
    """Return the trial state after a step along the motion of a limit state.

    Parameters
    ----------
    trial
        Where the step begins.
    step
        Its length: the displacement of the fastest corner, or of the supports [m].

    Returns
    -------
    TrialState
        The live load does no work in the projection. The step ends where a slack tie is taut again.
    """
    linkage, structure = trial.moving_linkage(), trial.structure
    held = linkage.ties
    length = _until_a_tie_is_taut(trial, linkage, step / trial.speed())
    motion = length * linkage.body_motions(trial.limit.mechanism)
    pose = linkage.moved(trial.pose, motion, linkage.origins(trial.pose))
    control = None if structure.live is None else conjugate_control(structure)
    target = 0.0 if control is None else control.value(linkage.assembly, pose)
    parameter = trial.parameter + length * trial.support_rate
    linkage = _with_taut_ties(_without_lost_bearings(linkage, pose, parameter), pose, parameter)
    closed = projected_onto_zero_gap(linkage, pose, parameter, PROJECTION_REACH * step, control, target)
    residual = np.zeros(structure.interfaces.n_interfaces)
    np.maximum.at(residual, linkage.contacts.joint, closed.residual_gap)
    guess = None if trial.limit.multiplier is None else trial.limit.mechanism
    pose = linkage.with_yielded_ties(closed.pose, parameter)
    after = trial_state_at(linkage, pose, parameter, residual, guess, dilates=trial.dilates)
    slack = slack_of_ties(linkage.assembly, structure.with_supports(pose, parameter))
    stretched = float(-slack[held].min(initial=0.0))
    return replace(after, left_open=float(residual.max(initial=0.0)), stretched=stretched)


def trial_state_at(
    linkage: Linkage,
    pose: Pose,
    parameter: float,
    residual_gap: Floats,
    guess: Floats | None = None,
    *,
    dilates: bool = True,
) -> TrialState:
    """Return the trial state at a pose: its closed contacts, those that have slid with new points, and its limit state.

    Parameters
    ----------
    linkage
        Has the structure, the contacts and the control; its active set is not used.
    pose, parameter
        The pose; the parameter counts where supports move.
    residual_gap
        What a projection has left open in each joint, shape (n_interfaces,) [m]: contacts with such gaps are closed.
    guess
        A motion near that of the limit state, shape (n_blocks, 6).
    dilates
        As of `TrialState`.

    Returns
    -------
    TrialState
        All closed contacts stick.
    """
    structure = linkage.structure
    if linkage.control is not None:
        parameter = linkage.control.value(linkage.assembly, pose)
    tolerance = residual_gap + CORNER_TOLERANCE * float(free_sizes(linkage.assembly).max())
    linkage = _with_active_set(linkage, pose, parameter, tolerance)
    gap = gaps(linkage.assembly, linkage.contacts, pose, parameter)[linkage.sticking]
    trial = TrialState(linkage, pose, parameter, NOT_SOLVED, float(gap.max(initial=0.0)), dilates=dilates)
    if structure.live is not None:
        limit = limit_state(trial.configuration, associated=linkage.associated, guess=guess, falls_dilating=dilates)
        if limit.multiplier is None:
            return replace(trial, limit=limit)
        mechanism = without_left_at_rest(linkage, pose, limit.mechanism)
        return replace(trial, limit=replace(limit, mechanism=mechanism))
    trial = replace(trial, limit=settling_state(trial.configuration, guess=guess, rough=True, falls_dilating=dilates))
    if end_at(trial.limit) is not None:
        return trial
    moving, motion = trial.moving_linkage(), trial.limit.mechanism
    _, motion = without_free_motion(moving, pose, parameter, motion, sticking_speed=STICKING_SPEED)
    return replace(trial, limit=replace(trial.limit, mechanism=motion))


def _until_a_tie_is_taut(trial: TrialState, linkage: Linkage, length: float) -> float:
    """The part of a step along the motion of a limit state in which no slack tie becomes longer than its own length.

    Beyond, the motion is that of another mechanism, and a projection would tear the closed contacts open.
    """
    if not len(linkage.slack):
        return length
    motion, origin = linkage.body_motions(trial.limit.mechanism), linkage.origins(trial.pose)

    def slack(part: float) -> Floats:
        pose, parameter = linkage.moved(trial.pose, part * motion, origin), trial.parameter + part * trial.support_rate
        return slack_of_ties(linkage.assembly, linkage.structure.with_supports(pose, parameter))[linkage.slack]

    size = float(free_sizes(linkage.assembly).max())
    first = slack(0.0)
    for tie in np.flatnonzero((first > SLACK * size) & (slack(length) < 0)):
        if slack(length)[tie] < 0:
            length = root_of(lambda part, tie=tie: float(slack(part)[tie]), 0.0, length, CLOSING_ACCURACY * length)
    return length


def _with_taut_ties(linkage: Linkage, pose: Pose, parameter: float) -> Linkage:
    """The linkage that holds the ties, too, that a step has made taut again."""
    slack = slack_of_ties(linkage.assembly, linkage.structure.with_supports(pose, parameter))
    taut = linkage.slack[slack[linkage.slack] <= ZERO_GAP * float(free_sizes(linkage.assembly).max())]
    return linkage.rejoined(linkage.contacts.number + taut, pose, parameter) if len(taut) else linkage


def _without_lost_bearings(linkage: Linkage, pose: Pose, parameter: float) -> Linkage:
    """The linkage without the joints that slide and whose faces overlap in no area any more, and edges beyond a rim.

    Their gaps are those of planes without end. A projection onto them would draw a block that has slid off its support
    back onto the edge.
    """
    structure, joints = linkage.structure, np.unique(linkage.contacts.joint[linkage.sliding])
    contacts, row, new = cut_to_faces(structure, linkage.contacts, joints, pose, parameter)
    if contacts is not linkage.contacts:
        sticking = linkage.sticking[row] & ~new
        linkage = replace(linkage, contacts=contacts, sticking=sticking, sliding=linkage.closed[row] & ~sticking)
    interfaces = structure.interfaces
    joints = joints[interfaces.area[joints] > 0]
    if not len(joints):
        return linkage
    overlap = overlap_points(structure, contacts, joints, pose, parameter).joint
    lost = joints[np.bincount(overlap, minlength=interfaces.n_interfaces)[joints] < AREA_CORNERS]
    if not len(lost):
        return linkage
    kept = np.flatnonzero(~np.isin(contacts.joint, lost))
    return replace(
        linkage, contacts=contacts.select(kept), sticking=linkage.sticking[kept], sliding=linkage.sliding[kept]
    )


def _with_active_set(linkage: Linkage, pose: Pose, parameter: float, tolerance: Floats) -> Linkage:
    """The linkage whose sticking contacts are all that are closed at a pose, to a tolerance for each joint [m].

    Joints that have slid get new contact points: faces the corners of their overlap, edges and corners the points that
    meet, as far as they are still on their faces.
    """
    contacts, assembly, interfaces = linkage.contacts, linkage.assembly, linkage.structure.interfaces
    closed = gaps(assembly, contacts, pose, parameter) <= tolerance[contacts.joint]
    points = pair_points(assembly, contacts, pose, parameter)
    slip = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    joints = np.unique(contacts.joint[closed & (slip > CORNER_TOLERANCE * float(free_sizes(assembly).max()))])
    has_area = interfaces.area[joints] > 0
    before = contacts
    contacts = cut_to_faces(linkage.structure, contacts, joints, pose, parameter).contacts
    if has_area.any():
        contacts = with_overlap_points(linkage.structure, contacts, joints[has_area], pose, parameter)
    if contacts is not before:
        closed = gaps(assembly, contacts, pose, parameter) <= tolerance[contacts.joint]
    on_edges = np.flatnonzero(closed & np.isin(contacts.joint, joints[~has_area]))
    if len(on_edges):
        contacts = rejoined(assembly, contacts, on_edges, pose, parameter)
    return replace(linkage, contacts=contacts, sticking=closed, sliding=np.zeros_like(closed))
