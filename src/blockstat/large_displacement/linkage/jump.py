"""A jump: where no forces balance the loads, the structure moves at constant displacement until a contact closes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_pairs import ZERO_GAP
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED, contact_status, tie_status
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, free_sizes
from blockstat.large_displacement.linkage.kinematics import motion_at_fixed_parameter, pose_at
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.parts import hang_on_ties
from blockstat.large_displacement.linkage.root_finding import root_of
from blockstat.typing import Floats

#: Longest step of the fastest corner in a jump. Relative to the extent of the free blocks. Chosen: contacts that close
#: are located by root finding, so a step must only be too short to pass through a block.
MAX_STEP = 0.01
#: The first step, relative to `MAX_STEP`, and the shortest, relative to the extent of the free blocks. Chosen: the
#: first is short because the contacts that stop a fall may be near.
FIRST_STEP, MIN_STEP = 1e-3, 1e-9
#: Blocks that have moved so far without a contact that closes have fallen. Relative to the extent of the free blocks.
#: Chosen: what is still in the way after that was no part of the structure's equilibrium.
FALLEN = 0.5
#: Blocks fall together that move by more than this. Relative to the block that moves most. Chosen: others are dragged
#: along.
FALLING_TOGETHER = 0.5
#: A curve ends when more than this part of the work of the live load, or of the control, was on blocks that have
#: fallen. Chosen: what remains is then another structure.
MAX_PART_FALLEN = 0.5
#: A linkage whose motion is slower than this does not move: what is left of a mechanism that its contacts resist is
#: rounding. Relative to the mechanism, or to the motion before. Chosen: contacts that move more slowly stick.
NO_MOTION = STICKING_SPEED
#: Trial steps of a jump at most. Chosen: ten times those of a fall without shorter steps. One that needs more creeps,
#: and is not followed further.
MAX_TRIALS = 10 * int(FALLEN / MAX_STEP)
#: Accuracy of the length at which a contact closes. Relative to the step. Chosen: near rounding.
CLOSING_ACCURACY = 1e-12


@dataclass(frozen=True, eq=False)
class JumpEnd:
    """Where a jump ends."""

    linkage: Linkage | None  #: with the contacts that have closed sticking; None where nothing stops the fall
    pose: Pose  #: without a linkage: as far as the fall was followed
    opened: list[int]  #: joints that open, numbers of interfaces
    shut: list[int]  #: joints that close
    #: without a linkage: whether the blocks have fallen, far (`FALLEN`) or upside down; if not, the fall could not be
    #: followed
    fell: bool = False


def jump(linkage: Linkage, pose: Pose, parameter: float, mechanism: Floats, tangent: Floats) -> JumpEnd:
    """Follow the motion that no forces resist, at constant displacement, until a contact closes.

    Parameters
    ----------
    linkage
        The mechanism that has come to its limit.
    pose, parameter
        Where it is.
    mechanism
        The motion that the contacts do not resist there, shape (n_blocks, 6), as `equilibrium_forces` gives it.
    tangent
        The motion of the linkage itself for a unit rate of the parameter, shape (n_blocks, 6).

    Returns
    -------
    JumpEnd
        Where it ends.

    Notes
    -----
    The linkage's own motion does no work under its own multiplier. So that part of the mechanism that moves the control
    is subtracted, and the loads still do positive work in what remains. Blocks that only ties hold swing on these to
    their lowest place. That is not looked for, and no fall: the jump is lost.
    """
    assembly, contacts = linkage.assembly, linkage.contacts
    if linkage.control is not None:
        mechanism = mechanism - linkage.control.rate(assembly, pose, mechanism) * tangent
    sticking, sliding = contact_status(linkage.configuration(pose, parameter), mechanism)
    opens = linkage.closed & ~sticking & ~sliding
    opened = contacts.joint[opens].tolist()
    ties, slack = tie_status(linkage.configuration(pose, parameter), mechanism)
    falling = replace(linkage, sticking=sticking, sliding=sliding, ties=ties, slack=slack)
    extent = float(np.ptp(assembly.vertices[~assembly.support[assembly.vertex_block]], axis=0).max())
    tolerance, travelled = ZERO_GAP * float(free_sizes(assembly).max()), 0.0
    lost = JumpEnd(None, pose, opened, [])
    moved = np.linalg.norm(mechanism[:, :3], axis=1)
    if hang_on_ties(falling, np.flatnonzero(moved > FALLING_TOGETHER * moved.max())):
        return lost
    direction = _direction(falling, pose, parameter, mechanism)
    if direction is not None and opens.any() and not (opens & _opens(linkage, pose, parameter, direction)).any():
        return lost
    step = FIRST_STEP * MAX_STEP * extent
    for _ in range(MAX_TRIALS):
        if direction is None or travelled >= FALLEN * extent:
            break
        gap = np.where(falling.open, falling.gaps(pose, parameter), np.inf)

        def at(length: float, pose: Pose = pose, direction: Floats = direction) -> Pose | None:
            distance = length * float((direction[:, :3] ** 2).sum())
            found = pose_at(falling, pose, parameter, length * direction, along=(direction, distance))
            return None if found is None else falling.with_yielded_ties(found, parameter)

        there = at(step)
        if there is None:
            step /= 2
            if step < MIN_STEP * extent:
                return lost
            continue
        now = np.where(falling.open, falling.gaps(there, parameter), np.inf)
        if (now < -tolerance).any():
            found = _first_closing(at, _gaps_at(falling, parameter), now < -tolerance, gap > tolerance, step)
            return lost if found is None else _landed(falling, found, parameter, opened)
        travelled, pose = travelled + step, there
        direction = _direction(falling, pose, parameter, direction)
        step = min(2 * step, MAX_STEP * extent)
    return replace(lost, pose=pose, fell=travelled >= FALLEN * extent)


def _gaps_at(linkage: Linkage, parameter: float) -> Callable[[Pose], Floats]:
    return lambda pose: linkage.gaps(pose, parameter)


def _direction(linkage: Linkage, pose: Pose, parameter: float, guess: Floats) -> Floats | None:
    """The linkage's motion next to a given one, with a unit rate of its fastest corner; None where it has none."""
    motion = motion_at_fixed_parameter(linkage, pose, parameter, guess)
    there = displaced_assembly(linkage.assembly, pose)
    speed, given = (float(corner_speed(there, each).max(initial=0.0)) for each in (motion, guess))
    return motion / speed if speed > NO_MOTION * given else None


def _opens(linkage: Linkage, pose: Pose, parameter: float, motion: Floats) -> np.ndarray:
    """The closed contacts that open in a motion, shape (n_contacts,) bool.

    A mechanism may open joints as they slide, while the linkage keeps them shut. What is left of a block that tips over
    and turns about the vertical may be the turn alone, which is no fall.
    """
    sticking, sliding = contact_status(linkage.configuration(pose, parameter), motion)
    found: np.ndarray = linkage.closed & ~sticking & ~sliding
    return found


def _first_closing(
    at: Callable[[float], Pose | None],
    gap: Callable[[Pose], Floats],
    overlaps: np.ndarray,
    was_open: np.ndarray,
    step: float,
) -> Pose | None:
    """The pose in which the first of the overlapping contacts closes; None where one was not open before the step."""
    if not (was_open | ~overlaps).all():
        return None
    last = step
    for contact in np.flatnonzero(overlaps):

        def gap_of(length: float, contact: int = int(contact)) -> float:
            pose = at(length)
            return -1.0 if pose is None else float(gap(pose)[contact])

        if gap_of(last) < 0:
            last = root_of(gap_of, 0.0, last, CLOSING_ACCURACY * step)
    return at(last)


def _landed(linkage: Linkage, pose: Pose, parameter: float, opened: list[int]) -> JumpEnd:
    """The end of a jump, with the contacts sticking that have closed and the ties held that are taut.

    Blocks have fallen whose faces look away from each other where they meet again: they have turned half round, and the
    corners that close are beside the faces.
    """
    closed = linkage.just_closed(pose, parameter)
    if len(closed) and _looks_away(linkage, pose)[closed].all():
        return JumpEnd(None, pose, opened, [], fell=True)
    shut = linkage.contacts.joint[closed[closed < linkage.contacts.number]].tolist()
    return JumpEnd(linkage.rejoined(closed, pose, parameter), pose, opened, shut)


def _looks_away(linkage: Linkage, pose: Pose) -> np.ndarray:
    """Whether the blocks of contacts have turned by more than a right angle against each other, in order of `gaps`."""
    contacts = linkage.contacts
    turned = [np.einsum("nij,nj->ni", pose.rotation[block], contacts.normal) for block in contacts.pair.T]
    away: np.ndarray = np.einsum("ni,ni->n", *turned) < 0
    return np.append(away, np.zeros(len(linkage.assembly.ties), dtype=bool))
