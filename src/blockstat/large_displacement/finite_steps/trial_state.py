"""The state that a finite step leads to: a pose, the contacts that are closed there, and the limit state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_status import contact_status, tie_status
from blockstat.large_displacement.displaced.control import MIN_CONTROL_RATE
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly
from blockstat.large_displacement.displaced.structure import Configuration, Structure
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathPoint, PathState
from blockstat.large_displacement.statics.limit_state import LimitState, associated_multiplier
from blockstat.typing import Floats

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
    left_open: float = 0.0  #: the largest gap of a contact that the projection could not close [m]
    stretched: float = 0.0  #: by how much the projection leaves a tie longer that was to keep its length [m]
    dilates: bool = True  #: whether blocks that fall slide with associated flow, whatever that of the linkage is

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

    def moving_linkage(self) -> Linkage:
        """Return the linkage of the contacts that stick and slide in the motion of the limit state.

        Returns
        -------
        Linkage
            With the active set of the motion.
        """
        motion, opening = self.limit.mechanism, self.limit.opening
        sticking, sliding = contact_status(self.configuration, motion, self.support_rate, opening=opening)
        ties, slack = tie_status(self.configuration, motion, self.support_rate)
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


def path_state(trial: TrialState) -> PathState:
    """Return a trial state as a state of a path.

    Parameters
    ----------
    trial
        The trial state, whose limit state has forces.

    Returns
    -------
    PathState
        Its upper bound is that of associated flow where joints slide without opening.
    """
    linkage, limit = trial.moving_linkage(), trial.limit
    upper = limit.multiplier
    assert limit.multiplier is not None
    assert limit.forces is not None
    if linkage.control is not None and not linkage.associated and linkage.sliding.any():
        upper = associated_multiplier(trial.configuration)
    rate = per_unit_parameter(linkage, trial.pose, limit.mechanism)
    point = PathPoint(trial.parameter, trial.pose, rate, limit.multiplier)
    return PathState(point, linkage, limit.forces, trial.residual_gap, upper)


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
