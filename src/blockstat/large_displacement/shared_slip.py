"""Slip that several joints share although some of them could take it alone.

Where joints slide without opening, the motion need not be unique. A lintel on two piers that move apart slides on the
left one, on the right one, or on both: the forces are the same. Its fall is earliest where one joint takes all slip. A
lintel that is pushed along two columns slides on both of them, or takes one or both along: there two joints take all
slip together. A solver finds the middle of all motions, in which all joints share it.

The motions with the same forces are the mixtures of those in which as few joints slide as possible: no joint of such a
set could stick while the others slide. So these sets are looked for, the smaller ones first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, combinations, islice
from typing import NamedTuple

import numpy as np

from blockstat.geometry.polyhedron import point_velocity
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED
from blockstat.large_displacement.displaced.pose import Pose, free_sizes
from blockstat.large_displacement.linkage.kinematics import pose_at
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.large_displacement.linkage.state_solver import A_LITTLE_WAY, StateSolver
from blockstat.result import listed
from blockstat.typing import Floats, Ints

#: More joints than this are not tried. Chosen: where so many slide at once, steps follow them.
MOST_JOINTS = 12
#: More sets of joints than this are not tried. Chosen: all up to three of `MOST_JOINTS`, and all of eight joints.
MOST_SETS = 300
#: Joints that take all slip may ask for a multiplier larger by this, relative to it. Chosen: far above what solvers
#: leave.
SAME_VALUE = 1e-6
#: Joints that a warning names at most. Chosen.
MOST_NAMES = 5
#: A step is this part of the way to where the faces leave each other at most, and no shorter than this part of itself.
#: Chosen: a bearing that is used up within one step is not resolved, and a path of too many points takes long.
OF_BEARING, SHORTEST = 1.0 / 4.0, 1e-2


class SlidesAlone(NamedTuple):
    """A mechanism in which one joint, or as few as possible, take the slip that more share."""

    linkage: Linkage
    motion: Floats  #: for a unit rate of the parameter, shape (n_blocks, 6)
    bearing: float  #: how far the joints slide before the faces of one of them leave each other [m]
    told: str  #: what a reader must know

    def step(self, step: float) -> float:
        """Return a step that is short beside the bearing [m]."""
        return max(min(step, OF_BEARING * self.bearing), SHORTEST * step)


def joints_that_slide_alone(solver: StateSolver, linkage: Linkage, pose: Pose, motion: Floats) -> SlidesAlone | None:
    """Return the mechanism at rest in which as few joints as possible take the slip that several share.

    Parameters
    ----------
    solver
        Finds states of the linkage.
    linkage
        Of the mechanism that begins.
    pose
        At rest.
    motion
        The mechanism, of any magnitude, shape (n_blocks, 6).

    Returns
    -------
    SlidesAlone or None
        Of all sets of joints that can take the slip alone, with forces in equilibrium and no larger a multiplier or
        reaction, with a pose a little way on, and of which none could stick, that one slides in which faces leave each
        other first; of several such sets, the one on which the fewest blocks move. None where no joints share their
        slip.
    """
    contacts = linkage.contacts
    slides = linkage.sliding & linkage.may_part & (contacts.friction > 0)
    joints = np.unique(contacts.joint[slides])
    if linkage.associated or not 1 <= len(joints) <= MOST_JOINTS:
        return None
    tried = _joints_that_may_slide(linkage, joints)
    if len(tried) < 2:
        return None
    shared = solver.first(linkage, pose, motion)
    if shared is None:
        return None
    margin = _same_value(linkage, tried) * abs(shared.point.value)
    most = shared.point.value + margin
    # What solvers leave in a mixture may balance no forces: then its multiplier has to be that of the others.
    least = -np.inf if shared.forces.admissible else shared.point.value - margin
    size = float(free_sizes(linkage.assembly).max())
    found: list[_Alone] = []
    for own in _sets_without_one_of(found, tried):
        slides = linkage.closed & np.isin(contacts.joint, own)
        alone = replace(linkage, sticking=linkage.closed & ~slides, sliding=slides)
        state = solver.first(alone, pose, motion)
        if state is not None and state.forces.admissible and least <= state.point.value <= most:
            tangent, distance = state.point.tangent, A_LITTLE_WAY * size
            if pose_at(alone, pose, distance, distance * tangent) is None:
                continue  # the blocks lock each other as soon as they have moved
            bearing = min(_bearing(linkage, joint, tangent) for joint in own)
            if np.isinf(bearing):
                continue
            found.append(_Alone(own, bearing, int(tangent.any(axis=1).sum()), alone, tangent))
    same = CORNER_TOLERANCE * size + linkage.flaw_of_gaps
    first = min(found, key=lambda one: (round(one.bearing / same), one.moving, one.joints), default=None)
    alike = sorted({*joints.tolist(), *chain.from_iterable(one.joints for one in found)})
    if first is None or list(first.joints) == alike:
        return None
    return SlidesAlone(first.linkage, first.motion, first.bearing, _told(linkage, alike, first.joints))


class _Alone(NamedTuple):
    """A set of joints that can take all slip."""

    joints: tuple[int, ...]  #: in ascending order
    bearing: float  #: as in `SlidesAlone`
    moving: int  #: how many blocks move
    linkage: Linkage
    motion: Floats


def _sets_without_one_of(found: list[_Alone], joints: Ints) -> Iterator[tuple[int, ...]]:
    """Sets of joints, the smaller ones first, that contain none of those that have been found so far."""
    sizes = range(1, len(joints) + 1)
    for own in islice(chain.from_iterable(combinations(joints.tolist(), size) for size in sizes), MOST_SETS):
        if not any(set(one.joints) <= set(own) for one in found):
            yield own


def _joints_that_may_slide(linkage: Linkage, joints: Ints) -> Ints:
    """The joints that slide, and those that would slide as well if the faces of all joints were planes.

    Where tilts of faces tell multipliers apart, only the joint slides whose face happens to be tilted most.
    """
    if linkage.flaw_of_rates <= SAME_VALUE:
        return joints
    contacts, interfaces = linkage.contacts, linkage.structure.interfaces
    closed = linkage.closed & (contacts.friction > 0) & (interfaces.area[contacts.joint] > 0)
    every = np.union1d(joints, contacts.joint[closed])
    return every if len(every) <= MOST_JOINTS else joints


def _same_value(linkage: Linkage, joints: Ints) -> float:
    """By how much the multipliers of joints may differ that are the same with plane joints, relative to them.

    A block on a plane that is tilted by a slides at tan(phi + a), which differs from mu = tan(phi) by a (1 + mu^2).
    """
    friction = linkage.contacts.friction[np.isin(linkage.contacts.joint, joints)]
    return SAME_VALUE + linkage.flaw_of_rates * float((friction + 1.0 / np.maximum(friction, SAME_VALUE)).max())


def _bearing(linkage: Linkage, joint: int, motion: Floats) -> float:
    """How far a joint slides along its slip at rest before its faces leave each other [m].

    Infinite where it does not slip at rest, as a joint that slips by the square of the motion only. What lies beside
    the other face, or touches it edge along edge, never bears on it.
    """
    import shapely

    contacts, assembly = linkage.contacts, linkage.assembly
    own = contacts.select(np.flatnonzero(contacts.joint == joint))
    sides = [point_velocity(assembly, motion, own.pair[:, k], own.anchor[:, k]) + own.drive[:, k] for k in (0, 1)]
    normal = linkage.structure.interfaces.frame[joint, 0]
    slip = (sides[1] - sides[0]).mean(axis=0)
    slip = slip - float(slip @ normal) * normal  # a block that tips opens its joint
    fastest = max(float(np.abs(motion).max()), float(np.abs(sides).max()))
    if not float(np.linalg.norm(slip)) > STICKING_SPEED * fastest:
        return np.inf
    along = slip / float(np.linalg.norm(slip))
    _, corner = linkage.structure.outlines.of(np.array([joint]))
    if not len(corner):
        return np.inf
    across = np.cross(normal, along)
    place = corner @ np.stack([along, across], axis=1)  # (polygons, sides, corners, 2)
    touch, bearing = CORNER_TOLERANCE * float(free_sizes(assembly).max()), 0.0
    for one, two in place:
        # A point of two meets a point of one after a slip that is the difference of their places.
        slips = (one[:, None] - two).reshape(-1, 2)
        (low, left), (high, right) = slips.min(axis=0), slips.max(axis=0)
        line = shapely.LineString([(low, 0.0), (high, 0.0)])
        far = float(shapely.intersection(shapely.MultiPoint(slips).convex_hull, line).bounds[2])
        if min(-left, right) > touch + STICKING_SPEED * far:
            bearing = max(bearing, far)
    return bearing


def _told(linkage: Linkage, joints: list[int], alone: tuple[int, ...]) -> str:
    assembly, interfaces = linkage.assembly, linkage.structure.interfaces

    def called(k: int) -> str:
        return " and ".join(f'"{assembly.names[block]}"' for block in interfaces.pair[k])

    names, own = (listed([called(k) for k in each], MOST_NAMES) for each in (joints, alone))
    return (
        f"without dilatancy the slip may be shared by several joints in any way: {names}. The path follows the slip "
        f"between {own} alone, whose faces part first; another share of the slip may end elsewhere"
    )
