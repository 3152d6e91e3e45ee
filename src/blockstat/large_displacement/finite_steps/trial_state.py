"""The state that a finite step leads to: a pose, the contacts that are closed there, and the limit state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED, contact_status, tie_status
from blockstat.large_displacement.displaced.control import MIN_CONTROL_RATE
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly
from blockstat.large_displacement.displaced.structure import Configuration, Structure
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathPoint, PathState
from blockstat.large_displacement.statics.de_saxce import ONE_PROGRAM
from blockstat.large_displacement.statics.limit_state import LimitState, associated_limit, limit_state
from blockstat.large_displacement.statics.macro_blocks import macro_blocks_of
from blockstat.typing import Floats, Ints

#: Joints all of whose points move more slowly than this are rigid: their blocks belong to one macro-block. Relative to
#: the fastest point of a joint. The second is tried where macro-blocks made by the first do not hold; then each block
#: is one. Chosen: they leave out motions of a thousandth part.
RIGID_JOINT_SPEEDS = (3e-3, 1e-3)
#: Accuracy of the multiplier of macro-blocks and of that which checks them, as in `EarlyEnd`. Their errors add up over
#: hundreds of blocks, so a few digits are not enough.
MULTIPLIER_ACCURACY = 1e-8
#: Stands where no limit state has been found yet.
NOT_SOLVED = LimitState(None, np.empty((0, 6)), None)


@dataclass(frozen=True, eq=False)
class TrialState:
    """A pose with its closed contacts and its limit state."""

    linkage: Linkage  #: all closed contacts are among those that stick; blocks that have fallen are supports
    pose: Pose
    parameter: float  #: displacement of the control, or movement of the supports [m]
    limit: LimitState
    residual_gap: float  #: the largest gap of a contact that counts as closed [m]
    macro_blocks: Ints | None  #: macro-block of each block, -1 for blocks that do not move; None where each is one
    left_open: float = 0.0  #: the largest gap of a contact that the projection could not close [m]

    @property
    def structure(self) -> Structure:
        """The structure, in which blocks that have fallen are supports."""
        return self.linkage.structure

    @cached_property
    def configuration(self) -> Configuration:
        """What equilibrium is asked of."""
        return self.linkage.configuration(self.pose, self.parameter)

    @property
    def support_rate(self) -> float:
        """Rate of the supports in the motion of the limit state: zero while blocks fall."""
        return float(self.linkage.control is None and self.limit.multiplier is not None)

    @property
    def sticking_speed(self) -> float:
        """Contacts that move more slowly than this stick, relative to the fastest corner."""
        return STICKING_SPEED if self.macro_blocks is None else RIGID_JOINT_SPEEDS[0]

    def moving_linkage(self) -> Linkage:
        """Return the linkage of the contacts that stick and slide in the motion of the limit state.

        Returns
        -------
        Linkage
            With the active set of the motion.
        """
        motion, opening = self.limit.mechanism, self.limit.opening
        sticking, sliding = contact_status(
            self.configuration, motion, self.support_rate, sticking_speed=self.sticking_speed, opening=opening
        )
        ties, slack = tie_status(self.configuration, motion, self.support_rate, sticking_speed=self.sticking_speed)
        return replace(self.linkage, sticking=sticking, sliding=sliding, ties=ties, slack=slack)

    def speed(self) -> float:
        """Return the speed of the fastest corner, or of the supports, in the motion of the limit state.

        Returns
        -------
        float
            In the units of the motion.
        """
        corners = corner_speed(displaced_assembly(self.linkage.assembly, self.pose), self.limit.mechanism)
        return max(float(corners.max(initial=0.0)), self.support_rate)

    def closed_joints(self) -> set[int]:
        """Return the joints that are closed at one point at least.

        Returns
        -------
        set of int
            Numbers of interfaces.
        """
        return set(self.linkage.contacts.joint[self.linkage.sticking].tolist())


def with_limit_state(trial: TrialState, guess: Floats | None, macro_blocks: Ints | None) -> TrialState:
    """Return a trial state with the limit state of macro-blocks, or of smaller ones where they lock each other.

    Parameters
    ----------
    trial
        The pose; its structure has a live load.
    guess
        A mechanism near the wanted one, shape (n_blocks, 6).
    macro_blocks
        As in `TrialState`.

    Returns
    -------
    TrialState
        With the macro-blocks that were used.
    """

    def limit(macro_blocks: Ints | None) -> LimitState:
        return limit_state(
            trial.configuration,
            associated=trial.linkage.associated,
            guess=guess,
            macro_blocks=macro_blocks,
            accuracy=0.0 if macro_blocks is None else MULTIPLIER_ACCURACY,
        )

    found = limit(macro_blocks)
    if found.multiplier == np.inf and guess is not None:
        macro_blocks = macro_blocks_of(trial.configuration, guess, RIGID_JOINT_SPEEDS[-1])
        found = limit(macro_blocks)
    if found.multiplier == np.inf:
        found, macro_blocks = limit(None), None
    return replace(trial, limit=found, macro_blocks=macro_blocks)


def limit_state_of_blocks(trial: TrialState) -> LimitState:
    """Return the limit state of all blocks, whose joints slide as those of the macro-blocks.

    Parameters
    ----------
    trial
        With the limit state of macro-blocks.

    Returns
    -------
    LimitState
        With forces, unless the blocks fall.
    """
    return limit_state(
        trial.configuration,
        associated=trial.linkage.associated,
        guess=trial.limit.mechanism,
        limits=ONE_PROGRAM,
        accuracy=MULTIPLIER_ACCURACY,
    )


def path_state(trial: TrialState, limit: LimitState) -> PathState:
    """Return a trial state as a state of a path.

    Parameters
    ----------
    trial
        The trial state.
    limit
        The limit state of its blocks, which has forces.

    Returns
    -------
    PathState
        Its upper bound is that of associated flow where joints slide without opening.
    """
    linkage, upper = trial.moving_linkage(), trial.limit.multiplier
    assert limit.multiplier is not None
    assert limit.forces is not None
    if linkage.control is not None and not linkage.associated and linkage.sliding.any():
        associated = associated_limit(trial.configuration, trial.macro_blocks)
        upper = None if associated is None else associated.multiplier
    rate = per_unit_parameter(linkage, trial.pose, trial.limit.mechanism)
    point = PathPoint(trial.parameter, trial.pose, rate, limit.multiplier)
    return PathState(point, linkage, limit.forces, trial.residual_gap, upper, trial.macro_blocks is not None)


def per_unit_parameter(linkage: Linkage, pose: Pose, motion: Floats) -> Floats:
    """Return a motion scaled to a unit rate of the control, or of the fastest corner where the control hardly moves.

    Parameters
    ----------
    linkage
        Has the control.
    pose
        The pose.
    motion
        Rates of the blocks about their displaced centroids, shape (n_blocks, 6).

    Returns
    -------
    Floats
        Shape (n_blocks, 6); the given motion where supports move.
    """
    if linkage.control is None:
        return motion
    speed = float(corner_speed(displaced_assembly(linkage.assembly, pose), motion).max())
    rate = linkage.control.rate(linkage.assembly, pose, motion)
    return motion / (rate if rate > MIN_CONTROL_RATE * speed else speed)
