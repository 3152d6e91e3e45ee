"""What follows an event on the path of a linkage: a jump, the mechanism after a closing contact or after sliding."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED
from blockstat.large_displacement.displaced.pose import Pose
from blockstat.large_displacement.linkage.jump import FALLING_TOGETHER, MAX_PART_FALLEN, JumpEnd, jump
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.path import FindMechanism, PathEnd, PathEvent, PathPoint, PathState
from blockstat.large_displacement.linkage.state_solver import StateSolver, with_ties_in_own_motion

#: Jumps that may follow each other at one displacement. Chosen: where more follow, it is no linkage that moves.
MAX_JUMPS = 20
#: Speeds below which contacts are tried as sticking where a mechanism changes. Relative to the fastest corner. Chosen:
#: what solvers leave, and larger parts of a mixture of two mechanisms.
STICKING_SPEEDS = (STICKING_SPEED, 1e-3, 1e-2)
#: How far beyond its limit a mechanism is looked for that follows it. Relative to the accuracy to which the limit is
#: located; the second reaches the tolerance of the path. At the last the multipliers of two mechanisms differ least.
DISTANCES_BEYOND = (10.0, 100.0, 1.0)


@dataclass(frozen=True, eq=False)
class AfterEvent:
    """Finds the states that follow events."""

    solver: StateSolver
    find_mechanism: FindMechanism
    ends_at_zero: bool  #: whether a negative multiplier ends the path

    def after_loss_of_equilibrium(
        self, state: PathState, beyond: PathState | None
    ) -> Iterator[PathState | PathEvent | PathEnd]:
        """Yield what follows where no forces balance the loads any more.

        Parameters
        ----------
        state
            The last state in equilibrium.
        beyond
            A state just beyond it.

        Yields
        ------
        PathState, PathEvent or PathEnd
            The event, then the state that follows or the end.
        """
        if state.linkage.slides_with_friction and beyond is not None:
            changed = self._changed_mechanism(state, beyond)
            if changed is not None:
                yield _event("change", state, changed, [], [])
                yield changed
                return
        yield from self._after_jump(state, beyond)

    def _after_jump(self, state: PathState, beyond: PathState | None) -> Iterator[PathState | PathEvent | PathEnd]:
        mechanism = (beyond or state).forces.mechanism
        before, opened, shut, end = state, [], [], PathEnd.LOST
        if beyond is not None and len(gone := _joints_gone(state.linkage, beyond.linkage)):
            state, opened = beyond, gone  # what the joints have held falls without them
        for _ in range(MAX_JUMPS):
            point = state.point
            landing = jump(state.linkage, point.pose, point.parameter, mechanism, point.tangent)
            opened += landing.opened
            if landing.linkage is None:
                if landing.fell and self._stands_without_the_fallen(before, landing):
                    yield end  # by finite steps the curve goes on without them
                    return
                end = PathEnd.COLLAPSE if landing.fell else end
                break
            shut += landing.shut
            found = self._landed(landing, landing.linkage, point)
            if isinstance(found, PathEnd):
                # What falls from here on, and what is lost, is followed by finite steps.
                end = found if found is PathEnd.LOCKED else end
                break
            linkage, landed = found
            if self.ends_at_zero and landed.value < 0:
                end = PathEnd.COLLAPSE
                break
            state = self.solver.state(linkage, landed)
            if state.forces.admissible:
                yield _event("jump", before, state, opened, shut)
                yield state
                return
            if not state.forces.solved:
                break
            mechanism = state.forces.mechanism
        if end is not PathEnd.LOST:  # what is lost is followed by finite steps, which tell what falls
            yield _event("jump", before, end, opened, shut)
        yield end

    def _stands_without_the_fallen(self, before: PathState, landing: JumpEnd) -> bool:
        """Whether a fall has left most of what the live load moves where it was."""
        if self.solver.structure.live is None:
            return False
        pose, tangent = before.point.pose, before.point.tangent
        moved = np.linalg.norm(landing.pose.displacement - pose.displacement, axis=1)
        fallen = np.flatnonzero(moved > FALLING_TOGETHER * moved.max())
        return self.solver.structure.part_of_live_power(pose, tangent, fallen) <= MAX_PART_FALLEN

    def _landed(self, landing: JumpEnd, linkage: Linkage, before: PathPoint) -> tuple[Linkage, PathPoint] | PathEnd:
        """The linkage after a jump and its first point: the one that has landed, or the mechanism that begins there."""
        point = self.solver.point(linkage, landing.pose, before.parameter, before.tangent)
        if point is not None:  # a tie may have yielded on the way that shortens from there on
            turned = linkage.with_turned_ties(point.pose, point.parameter, point.tangent)
            again = self.solver.point(turned, landing.pose, before.parameter, point.tangent)
            return (linkage, point) if again is None else (turned, again)
        return self._first_point(linkage, landing.pose, before.parameter, STICKING_SPEED)

    def _first_point(
        self, linkage: Linkage, pose: Pose, parameter: float, sticking_speed: float
    ) -> tuple[Linkage, PathPoint] | PathEnd:
        """The mechanism that begins at a pose, and its first point; the end of the path where there is none.

        A mechanism that is no linkage is lost here: it is followed by finite steps.
        """
        begun = self.find_mechanism(linkage, pose, parameter, sticking_speed)
        if isinstance(begun, PathEnd):
            return begun
        linkage = with_ties_in_own_motion(begun[0], pose, parameter, begun[1])
        point = self.solver.point(linkage, pose, parameter, begun[1])
        return PathEnd.LOST if point is None else (linkage, point)

    def _changed_mechanism(self, state: PathState, beyond: PathState) -> PathState | None:
        """The state of another mechanism where a joint ceases to slide; None where there is none.

        Just beyond its limit two mechanisms have the same multiplier to rounding, and a solver finds a mixture of both.
        Its forces may balance there, too. So the other mechanism is first looked for further on, up to the tolerance,
        and without its slower part. Only mechanisms with forces in equilibrium count.
        """
        start = state.point.parameter
        width = beyond.point.parameter - start
        nearly: PathState | None = None
        for sticking_speed, factor in product(STICKING_SPEEDS, DISTANCES_BEYOND):
            point = beyond.point if factor == 1.0 else self.solver.point_at(state, start + factor * width)
            if point is None:
                continue
            linkage = point.linkage or beyond.linkage
            following = self._first_point(linkage, point.pose, point.parameter, sticking_speed)
            if isinstance(following, PathEnd):
                continue
            found = self.solver.state(*following)
            if not (found.forces.admissible and self._goes_on(found, max(DISTANCES_BEYOND) * width)):
                continue
            if found.forces.proven:
                return found
            nearly = nearly or found
        return nearly

    def _goes_on(self, state: PathState, distance: float) -> bool:
        """Whether forces balance a mechanism that begins a little way on as well."""
        point = self.solver.point_at(state, state.point.parameter + distance)
        return point is not None and self.solver.state(point.linkage or state.linkage, point).forces.admissible

    def after_closing(self, state: PathState) -> Iterator[PathState | PathEvent | PathEnd]:
        """Yield what follows where a contact has closed.

        Parameters
        ----------
        state
            The state in which it closes.

        Yields
        ------
        PathState, PathEvent or PathEnd
            The event, then the state that follows or the end.
        """
        linkage, point = state.linkage, state.point
        closed = linkage.just_closed(point.pose, point.parameter)
        if not len(closed):  # the linkage has no pose beyond
            yield PathEnd.LOST
            return
        held = linkage.rejoined(closed, point.pose, point.parameter)
        joints = sorted(set(linkage.contacts.joint[closed[closed < linkage.contacts.number]].tolist()))
        following = self._first_point(held, point.pose, point.parameter, STICKING_SPEED)
        if isinstance(following, PathEnd):
            if following is not PathEnd.LOST:
                yield _event("closing", state, following, [], joints)
            yield following
            return
        found = self.solver.state(*following)
        if not found.forces.admissible:  # the mechanism that begins is followed by finite steps
            yield PathEnd.LOST
            return
        yield _event("closing", state, found, [], joints)
        yield found


def _joints_gone(before: Linkage, after: Linkage) -> list[int]:
    """The joints that are closed before and have no contact points after, as their blocks have slid off each other."""
    gone: list[int] = np.setdiff1d(before.contacts.joint[before.closed], after.contacts.joint).tolist()
    return gone


def _event(
    kind: str, before: PathState, after: PathState | PathEnd, opened: Iterable[int], shut: Iterable[int]
) -> PathEvent:
    if isinstance(after, PathEnd):
        value = np.inf if after is PathEnd.LOCKED else None
    else:
        value = after.point.value
    joints = [tuple(dict.fromkeys(int(k) for k in given)) for given in (opened, shut)]
    return PathEvent(kind, before.point.parameter, before.point.value, value, joints[0], joints[1])
