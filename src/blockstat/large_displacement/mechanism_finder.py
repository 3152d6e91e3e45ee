"""The mechanism that begins at a pose; of a mixture that is in unstable equilibrium, the part that it rolls off to.

A square pier that is pushed along its diagonal tips about either of two edges, and rocks on their corner, at the same
multiplier. The last is a mixture of the other two, and a solver that finds the middle of all motions finds it. Rocking
on its corner the pier is in equilibrium as a ball on a ridge is: its potential energy at a given displacement of the
control is largest there, and it rolls off sideways onto an edge. There the multiplier falls faster. So does a block
that slides until its thrust is at the corner of its bed: which of all turns about that corner a solver finds is
rounding, and most of them leave the ridge at once.

So where a mechanism leaves the blocks free to move aside at the same displacement of the control, the loads are
nudged to either side. Of the mechanisms found, those count whose multiplier under the loads themselves is the same, and
the one is followed whose multiplier falls fastest.

A keystone that sinks between two equal halves of an arch is on such a ridge too, with a joint open on both of its
sides: it may lean towards either half and close one. On supports that move, the motion of least potential energy is
looked for, and of motions of the same energy the one that has the least a little way on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.contact_status import contact_status, tie_status
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, free_sizes
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.finite_steps.free_motion import without_free_motion
from blockstat.large_displacement.linkage.kinematics import motion_at_fixed_parameter
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathEnd, end_at
from blockstat.large_displacement.linkage.state_solver import A_LITTLE_WAY, StateSolver
from blockstat.large_displacement.statics.limit_state import limit_state
from blockstat.large_displacement.statics.settling_state import settling_state
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
    """Finds the mechanism that begins at a pose: of the limit load, or on supports that move."""

    states: StateSolver

    def __call__(
        self, linkage: Linkage, pose: Pose, parameter: float, sticking_speed: float
    ) -> tuple[Linkage, Floats] | PathEnd:
        """Return the mechanism that begins at a pose.

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
        begun = _beginning(linkage, pose, parameter, sticking_speed)
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
            has the same multiplier, or potential energy, that falls faster.
        """
        linkage, motion = begun
        if linkage.sliding.any():
            return begun
        structure = before.structure
        found = [begun]
        least = _to_be_least(structure, pose, parameter, motion)
        most = least + SAME_VALUE * abs(least)
        for push in _pushes_aside(linkage, pose, parameter, motion):
            nudged = replace(before, structure=_nudged(structure, pose, push))
            other = _beginning(nudged, pose, parameter, sticking_speed)
            if not isinstance(other, PathEnd) and _to_be_least(structure, pose, parameter, other[1]) <= most:
                found.append((replace(other[0], structure=structure), other[1]))
        return min(found, key=lambda each: self._a_little_way_on(*each, pose, parameter))

    def _a_little_way_on(self, linkage: Linkage, motion: Floats, pose: Pose, parameter: float) -> float:
        """What is to be least, a little way on; infinite where the linkage cannot be followed."""
        state = self.states.first(linkage, pose, motion, parameter)
        if state is None or not state.forces.admissible:
            return np.inf
        distance = A_LITTLE_WAY * float(free_sizes(linkage.assembly).max())
        ahead = self.states.point_at(state, parameter + distance)
        if ahead is None:
            return np.inf
        return ahead.value if linkage.structure.live is not None else -ahead.value


def _to_be_least(structure: Structure, pose: Pose, parameter: float, motion: Floats) -> float:
    """The multiplier in a motion; on supports that move, the rate of the potential energy."""
    if structure.live is None:
        return -structure.dead_power(pose, parameter, motion)
    return structure.multiplier(pose, parameter, motion)


def _pushes_aside(linkage: Linkage, pose: Pose, parameter: float, motion: Floats) -> Iterator[Floats]:
    """Forces on the blocks along motions of a linkage that leave the parameter as it is, to either side.

    They are sought next to the horizontal motion across the axis of each block's turn, and next to one motion of all
    blocks across the axis about which most turn, and along it. So they are the same for a structure that is turned.
    """
    assembly = linkage.assembly
    there, mass = displaced_assembly(assembly, pose), assembly.mass[:, None]
    up = -assembly.gravity / max(float(np.linalg.norm(assembly.gravity)), 1e-300)
    spin = motion[:, 3:] - np.outer(motion[:, 3:] @ up, up)
    axis = np.linalg.svd(np.sqrt(mass) * spin, full_matrices=False)[2][0]
    known: list[Floats] = []
    for way in (np.cross(motion[:, 3:], up), np.cross(axis, up), axis):
        across = np.zeros_like(motion)
        across[:, :3] = np.where(assembly.support[:, None], 0.0, way)
        aside = motion_at_fixed_parameter(linkage, pose, parameter, across)
        for other in known:  # what is not among the motions before
            aside = aside - float((mass * aside[:, :3] * other[:, :3]).sum()) * other
        speed = float(corner_speed(there, aside).max(initial=0.0))
        if speed <= FREE * float(corner_speed(there, across).max(initial=0.0)):
            continue
        known.append(aside / np.sqrt(float((mass * aside[:, :3] ** 2).sum())))
        for side in (1.0, -1.0):
            push = np.zeros_like(motion)
            push[:, :3] = side * mass * known[-1][:, :3]
            yield push


def _nudged(structure: Structure, pose: Pose, push: Floats) -> Structure:
    """The structure with its live load, or without one its permanent loads, nudged along some forces."""
    own = structure.dead_load(pose) if structure.live is None else structure.live_load(pose)
    size = float(np.linalg.norm(own[:, :3])) / max(float(np.linalg.norm(push)), 1e-300)
    more = at_centroids(structure.assembly, NUDGE * size * push)
    if structure.live is None:
        return replace(structure, dead=structure.dead.plus(more))
    return replace(structure, live=structure.live.plus(more))


def _beginning(
    linkage: Linkage, pose: Pose, parameter: float, sticking_speed: float
) -> tuple[Linkage, Floats] | PathEnd:
    """The mechanism that begins, which may be a mixture: with associated flow, or on supports that move without it."""
    if linkage.structure.live is None:
        return _settling_mechanism(linkage, pose, parameter, sticking_speed)
    return _mechanism_of_limit_load(linkage, pose, parameter, sticking_speed)


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


def _settling_mechanism(
    linkage: Linkage, pose: Pose, parameter: float, sticking_speed: float
) -> tuple[Linkage, Floats] | PathEnd:
    """The motion of least potential energy on supports that move."""
    here = linkage.configuration(pose, parameter)
    found = settling_state(here)
    if (end := end_at(found)) is not None:
        return end
    sticking, sliding = contact_status(here, found.mechanism, 1.0, sticking_speed=sticking_speed, opening=found.opening)
    ties, slack = tie_status(here, found.mechanism, 1.0, sticking_speed=sticking_speed)
    linkage = replace(linkage, sticking=sticking, sliding=sliding, ties=ties, slack=slack)
    return without_free_motion(linkage, pose, parameter, found.mechanism, sticking_speed=sticking_speed)
