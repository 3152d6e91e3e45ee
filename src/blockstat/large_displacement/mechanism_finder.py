"""The mechanism that begins at a pose; of a mixture that is in unstable equilibrium, the part that it rolls off to.

A square pier that is pushed along its diagonal tips about either of two edges, and rocks on their corner, at the same
multiplier. The last is a mixture of the other two, and a solver that finds the middle of all motions finds it. Rocking
on its corner the pier is in equilibrium as a ball on a ridge is: its potential energy at a given displacement of the
control is largest there, and it rolls off sideways onto an edge. There the multiplier falls faster. So does a block
that slides until its thrust is at the corner of its bed: which of all turns about that corner a solver finds is
rounding, and most of them leave the ridge at once.

So where a mechanism leaves the blocks free to move aside at the same displacement of the control, the live load is
nudged to either side. Of the mechanisms found, those count whose multiplier under the load itself is the same, and the
one is followed whose multiplier falls fastest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_status import contact_status, tie_status
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, free_sizes
from blockstat.large_displacement.linkage.kinematics import motion_at_fixed_parameter
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathEnd, end_at
from blockstat.large_displacement.linkage.state_solver import A_LITTLE_WAY, StateSolver
from blockstat.large_displacement.statics.limit_state import limit_state
from blockstat.loading.placed import at_centroids
from blockstat.typing import Floats

#: Speeds below this say that blocks are not free to move aside. Relative to the fastest corner. Chosen: far above what
#: solvers leave.
FREE = 1e-3
#: The nudge, relative to the live load. Chosen: far above the accuracy of a limit load. It changes the multiplier to
#: the same order only, which is not used.
NUDGE = 1e-4
#: Multipliers that differ by less are the same. Relative to the larger. Chosen: far above what solvers leave.
SAME_VALUE = 1e-6


@dataclass(frozen=True, eq=False)
class MechanismFinder:
    """Finds the mechanism of the limit load that begins at a pose."""

    states: StateSolver

    def __call__(
        self, linkage: Linkage, pose: Pose, parameter: float, sticking_speed: float
    ) -> tuple[Linkage, Floats] | PathEnd:
        """Return the mechanism that begins at a pose, with associated flow at the displaced geometry.

        Parameters
        ----------
        linkage
            Its closed contacts are those that may carry.
        pose, parameter
            Where it is.
        sticking_speed
            As in `contact_status`.

        Returns
        -------
        tuple or PathEnd
            As `FindMechanism` has it.
        """
        begun = _mechanism_of_limit_load(linkage, pose, parameter, sticking_speed)
        if isinstance(begun, PathEnd):
            return begun
        return self.without_unstable_mixture(linkage, pose, parameter, sticking_speed, begun)

    def without_unstable_mixture(
        self,
        before: Linkage,
        pose: Pose,
        parameter: float,
        sticking_speed: float,
        begun: tuple[Linkage, Floats],
    ) -> tuple[Linkage, Floats]:
        """Return the mechanism that begins, or the one onto which it would roll off.

        Parameters
        ----------
        before, pose, parameter, sticking_speed
            As in a call.
        begun
            The linkage of a mechanism that begins there, and its motion, shape (n_blocks, 6).

        Returns
        -------
        linkage, motion
            Those given where the blocks are not free to move aside, where joints slide, and where no other mechanism
            has a multiplier that is the same and falls faster.
        """
        linkage, motion = begun
        if linkage.sliding.any() or linkage.control is None:
            return begun
        structure, assembly = before.structure, before.assembly
        there = displaced_assembly(assembly, pose)
        up = -assembly.gravity / max(float(np.linalg.norm(assembly.gravity)), 1e-300)
        across = np.zeros_like(motion)
        across[:, 3:] = np.cross(motion[:, 3:], up)
        aside = motion_at_fixed_parameter(linkage, pose, parameter, across)
        if float(corner_speed(there, aside).max(initial=0.0)) <= FREE * float(corner_speed(there, across).max()):
            return begun
        assert structure.live is not None
        push = np.zeros_like(motion)
        push[:, :3] = assembly.mass[:, None] * aside[:, :3]
        live = np.linalg.norm(structure.live_load(pose)[:, :3])
        push *= NUDGE * live / max(float(np.linalg.norm(push)), 1e-300)
        most = (1 + SAME_VALUE) * structure.multiplier(pose, parameter, motion)
        found = [begun]
        for side in (1.0, -1.0):
            nudged = replace(structure, live=structure.live.plus(at_centroids(assembly, side * push)))
            other = _mechanism_of_limit_load(replace(before, structure=nudged), pose, parameter, sticking_speed)
            if not isinstance(other, PathEnd) and structure.multiplier(pose, parameter, other[1]) <= most:
                found.append((replace(other[0], structure=structure), other[1]))
        return min(found, key=lambda each: self._a_little_way_on(*each, pose, parameter))

    def _a_little_way_on(self, linkage: Linkage, motion: Floats, pose: Pose, parameter: float) -> float:
        """The multiplier of a linkage a little way on; infinite where it cannot be followed."""
        state = self.states.first(linkage, pose, motion, parameter)
        if state is None or not state.forces.admissible:
            return np.inf
        distance = A_LITTLE_WAY * float(free_sizes(linkage.assembly).max())
        ahead = self.states.point_at(state, parameter + distance)
        return np.inf if ahead is None else ahead.value


def _mechanism_of_limit_load(
    linkage: Linkage, pose: Pose, parameter: float, sticking_speed: float
) -> tuple[Linkage, Floats] | PathEnd:
    here = linkage.configuration(pose, parameter)
    found = limit_state(here)
    if (end := end_at(found)) is not None:
        return end
    sticking, sliding = contact_status(here, found.mechanism, sticking_speed=sticking_speed)
    ties, slack = tie_status(here, found.mechanism, sticking_speed=sticking_speed)
    return replace(linkage, sticking=sticking, sliding=sliding, ties=ties, slack=slack), found.mechanism
