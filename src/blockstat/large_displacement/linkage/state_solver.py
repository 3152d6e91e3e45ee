"""States of a linkage at given parameters: pose, multiplier and forces.

The multiplier is that of virtual work in the linkage's own motion u, which is an upper bound. Forces that balance it at
the same pose make it a lower bound too:

    alpha = -w'u / l'u,        A f + w + alpha l = 0,  f in K.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED_AT_REST, tie_status
from blockstat.large_displacement.displaced.pose import Pose
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.linkage.kinematics import pose_at, tangent
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import PathPoint, PathState
from blockstat.large_displacement.linkage.sliding_contacts import with_new_sliding_contacts
from blockstat.large_displacement.statics.equilibrium import equilibrium_forces
from blockstat.large_displacement.statics.sliding_friction import sliding_multiplier
from blockstat.typing import Floats, Ints

#: How far from rest mechanisms are looked at again that are alike at rest. Relative to the largest free block. Chosen:
#: multipliers then differ by about as much, which is far above rounding, and slip that grows with the square of the
#: motion is ten times as fast as what counts as sticking.
A_LITTLE_WAY = 1e-3


@dataclass(frozen=True, eq=False)
class StateSolver:
    """Finds points and states of the linkages of one structure."""

    structure: Structure
    #: multiplier, or force on the moving supports [N], of a pose, its parameter, its motion and the ties that yield,
    #: where nothing slides against friction
    value: Callable[[Pose, float, Floats, Ints], float]

    def point(self, linkage: Linkage, pose: Pose, parameter: float, guess: Floats) -> PathPoint | None:
        """Return the motion and the multiplier of a linkage at a pose.

        Parameters
        ----------
        linkage, pose, parameter
            The pose is one of the linkage.
        guess
            A motion near that of the linkage, of any magnitude, shape (n_blocks, 6).

        Returns
        -------
        PathPoint or None
            None where the parameter does not move the linkage.
        """
        motion = tangent(linkage, pose, parameter, guess)
        if motion is None:
            return None
        if not linkage.slides_with_friction:
            return PathPoint(parameter, pose, motion, self.value(pose, parameter, motion, linkage.yielding))
        linkage = with_new_sliding_contacts(linkage, pose, parameter, motion)
        here = linkage.configuration(pose, parameter)
        forces, value, turned = sliding_multiplier(here, motion, associated=linkage.associated)
        turned = tangent(linkage, pose, parameter, turned)  # else the path would go astray by what solvers leave
        return PathPoint(parameter, pose, motion if turned is None else turned, value, linkage, forces)

    def point_at(self, state: PathState, parameter: float) -> PathPoint | None:
        """Return the point of a state's linkage at another parameter.

        Parameters
        ----------
        state
            Where Newton's method starts.
        parameter
            Of the point [m].

        Returns
        -------
        PathPoint or None
            None where the linkage has no pose near.
        """
        linkage, start = state.linkage, state.point
        pose = pose_at(linkage, start.pose, parameter, (parameter - start.parameter) * start.tangent)
        if pose is None:
            return None
        pose = linkage.with_yielded_ties(pose, parameter)
        return self.point(linkage, pose, parameter, start.tangent)

    def state(self, linkage: Linkage, point: PathPoint) -> PathState:
        """Return the state of a linkage at a point: with forces.

        Parameters
        ----------
        linkage
            The linkage.
        point
            One of its points.

        Returns
        -------
        PathState
            Its forces may need adhesion: `EquilibriumForces.admissible` says whether they do.

        Notes
        -----
        A multiplier holds the forces to the motion by virtual work. A reaction does not: it would count ties that yield
        with their greatest forces, though the equilibrium has others. So on supports that move, ties have the forces
        that the motion gives them. Where there is no such equilibrium, but another, it is not this mechanism that
        moves, and no block falls: the forces then count as not found.
        """
        if point.linkage is not None and point.forces is not None:
            return PathState(point, point.linkage, point.forces)
        linkage = with_new_sliding_contacts(linkage, point.pose, point.parameter, point.tangent)
        multiplier = point.value if self.structure.live is not None else 0.0
        here = linkage.configuration(point.pose, point.parameter)
        slides = bool(linkage.sliding.any())
        forces = equilibrium_forces(here, multiplier, slides=slides)
        if self.structure.live is None and forces.admissible and len(self.structure.assembly.ties):
            own = equilibrium_forces(here, motion=point.tangent + self.structure.support_motion, slides=slides)
            forces = own if own.admissible else replace(own, solved=False)
        return PathState(point, linkage, forces)

    def state_at(self, state: PathState, parameter: float) -> PathState | None:
        """Return the state of a state's linkage at another parameter.

        Parameters
        ----------
        state, parameter
            As in `point_at`.

        Returns
        -------
        PathState or None
            None where the linkage has no pose near.
        """
        point = self.point_at(state, parameter)
        return None if point is None else self.state(state.linkage, point)

    def first(self, linkage: Linkage, pose: Pose, guess: Floats, parameter: float = 0.0) -> PathState | None:
        """Return the state in which a mechanism begins.

        Parameters
        ----------
        linkage
            The mechanism that begins.
        pose
            Where it begins.
        guess
            Its motion, of any magnitude, shape (n_blocks, 6).
        parameter
            Of the pose [m].

        Returns
        -------
        PathState or None
            None where the parameter does not move the linkage.
        """
        linkage = with_ties_in_own_motion(linkage, pose, parameter, guess)
        point = self.point(linkage, pose, parameter, guess)
        return None if point is None else self.state(linkage, point)


def with_ties_in_own_motion(linkage: Linkage, pose: Pose, parameter: float, guess: Floats) -> Linkage:
    """Return a linkage whose ties hold, yield or go slack as its own motion has it.

    Parameters
    ----------
    linkage
        Of a mechanism that begins, with ties as the mechanism of associated flow has them. There joints open as they
        slide, and a tie may lengthen that shortens where they do not.
    pose, parameter
        Where it begins.
    guess
        The mechanism, of any magnitude, shape (n_blocks, 6).

    Returns
    -------
    Linkage
        The given one where no joint slides against friction without opening.
    """
    if linkage.associated or not (linkage.assembly.ties and linkage.slides_with_friction):
        return linkage
    motion = tangent(linkage, pose, parameter, guess)
    if motion is None:
        return linkage
    here, rate = linkage.configuration(pose, parameter), float(linkage.control is None)
    ties, slack = tie_status(here, motion, rate, sticking_speed=STICKING_SPEED_AT_REST)
    return replace(linkage, ties=ties, slack=slack)
