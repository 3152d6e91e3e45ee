"""The control displacement that a path is followed against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import InputError, no_such
from blockstat.geometry.polyhedron import point_velocity
from blockstat.large_displacement.displaced.pose import Pose, displaced_points, rest_pose
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.displaced.velocity_rows import VelocityRows, relative_velocity_rows, summed
from blockstat.loading.placed import PlacedForces
from blockstat.loads import on_block, three
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.analysis.limit_load import LimitLoad
    from blockstat.assembly import Assembly

#: What a user writes for the control that is conjugate to the load.
MEAN = "mean"
#: A control that moves more slowly than this does not move. Relative to the fastest corner of the mechanism. Chosen:
#: far above what a solver leaves, far below any motion of a mechanism.
MIN_CONTROL_RATE = 1e-6
#: The forces of a load balance each other when their sum is below this. Relative to the sum of their magnitudes.
#: Chosen: far above rounding.
MIN_RESULTANT = 1e-9


@dataclass(frozen=True, eq=False)
class Control:
    """A weighted mean of displacements of material points, each along a direction."""

    block: Ints  #: block of each point, shape (k,)
    point: Floats  #: positions at rest, shape (k, 3) [m]
    along: Floats  #: weight times unit direction of each, shape (k, 3)
    name: str = ""  #: what users read

    def value(self, assembly: Assembly, pose: Pose) -> float:
        """Return the control displacement at a pose.

        Parameters
        ----------
        assembly
            The blocks at rest.
        pose
            Their pose.

        Returns
        -------
        float
            [m].
        """
        moved = displaced_points(assembly, pose, self.block, self.point) - self.point
        return float((self.along * moved).sum())

    def rate(self, assembly: Assembly, pose: Pose, motion: Floats) -> float:
        """Return the rate of the control displacement in a motion.

        Parameters
        ----------
        assembly
            The blocks at rest.
        pose
            Their pose.
        motion
            Rates of the blocks about their displaced centroids, shape (n_blocks, 6).

        Returns
        -------
        float
            In the units of the motion.
        """
        arm = displaced_points(assembly, pose, self.block, self.point) - pose.centroids(assembly)[self.block]
        own = motion[self.block]
        return float((self.along * (own[:, :3] + np.cross(own[:, 3:], arm))).sum())

    def row(self, assembly: Assembly, pose: Pose, body: Ints, origin: Floats) -> VelocityRows:
        """Return the rate of the control displacement as a row for motions of rigid bodies.

        Parameters
        ----------
        assembly, pose
            As in `value`.
        body
            Rigid body of each block, -1 for a block that does not move, shape (n_blocks,).
        origin
            Of the bodies, shape (n_bodies, 3) [m].

        Returns
        -------
        VelocityRows
            One row.
        """
        now = displaced_points(assembly, pose, self.block, self.point)
        pair = np.column_stack([np.full(len(self.block), -1), self.block])
        return summed(relative_velocity_rows(body, pair, self.along, (now, now), origin))


def conjugate_control(structure: Structure) -> Control:
    """Return the control that is conjugate to the live load: the mean displacement weighted by its forces.

    Parameters
    ----------
    structure
        The structure, which has a live load.

    Returns
    -------
    Control
        Its rate times the sum of the magnitudes of the forces is the power of the forces on free blocks.
    """
    assert structure.live is not None
    return _conjugate(structure.assembly, structure.live, "mean of all displacements weighted by the load")


def _conjugate(assembly: Assembly, live: PlacedForces, name: str) -> Control:
    free = ~assembly.support[live.block]
    block, point, force = live.block[free], live.point[free], live.force[free]
    return Control(block, point, force / np.linalg.norm(force, axis=1).sum(), name)


def read_control(limit: LimitLoad, live: PlacedForces, given: Any) -> Control:
    """Read the control that a user asks for, and check that it moves.

    Parameters
    ----------
    limit
        The limit load, whose mechanism has to move the control.
    live
        Its load.
    given
        As `blockstat.capacity` takes it.

    Returns
    -------
    Control
        Along the resultant of the load on free blocks, or against it where the mechanism moves it so.

    Raises
    ------
    InputError
        For a block or group that does not exist, or a control that does not move.
    """
    assembly = limit.assembly
    force = live.force[~assembly.support[live.block]]
    along = force.sum(axis=0)
    if not np.linalg.norm(along) > MIN_RESULTANT * np.abs(force).sum():
        raise InputError("the forces of the load have no resultant on free blocks, so no displacement is along them")
    along = along / np.linalg.norm(along)
    if given is None:
        return _oriented(limit, _corner_that_moves_most(limit, along))
    if isinstance(given, (tuple, list)):
        return _oriented(limit, _point_of_block(assembly, given, along))
    if not isinstance(given, (str, int, np.integer)) or isinstance(given, bool):
        raise InputError(f"control is {given!r}; it must be a block, a group, a block and a point of it, or {MEAN}")
    if given == MEAN and MEAN not in assembly.names:
        return _oriented(limit, _conjugate(assembly, live, "mean of all displacements weighted by the load"))
    return _oriented(limit, _centroid(assembly, given, along))


def _corner_that_moves_most(limit: LimitLoad, along: Floats) -> Control:
    """The corner with the largest velocity along the load; of several, the one with the largest velocity in all."""
    assembly = limit.assembly
    speed = point_velocity(assembly, limit.mechanism, assembly.vertex_block, assembly.vertices)
    forward = speed @ along
    most = np.flatnonzero(forward >= forward.max() - MIN_CONTROL_RATE)
    corner = most[np.argmax(np.round(np.linalg.norm(speed[most], axis=1), 6))]
    block = assembly.vertex_block[corner]
    name = f'corner {_written(assembly.vertices[corner])} of "{assembly.names[block]}" along the load'
    return Control(np.array([block]), assembly.vertices[[corner]], along[None], name)


def _point_of_block(assembly: Assembly, given: Sequence[Any], along: Floats) -> Control:
    if len(given) != 2:
        raise InputError(f"control is {given!r}; it must be a block, a group, a block and a point of it, or {MEAN}")
    found = assembly.blocks_named(given[0], "control")
    if len(found) != 1:
        raise InputError(f"control: {given[0]!r} are {len(found)} blocks; give one, and a point of it")
    block = found[0]
    point = three(given[1], "control: the point")
    if not on_block(assembly, int(block), point):
        raise InputError(f'control: the point {point.tolist()} is not on block "{assembly.names[block]}"')
    name = f'point {_written(point)} of "{assembly.names[block]}" along the load'
    return Control(np.array([block]), point[None], along[None], name)


def _centroid(assembly: Assembly, given: Any, along: Floats) -> Control:
    """The centroid of a block, or of the mass of a group."""
    if isinstance(given, str) and given not in assembly.names:
        groups = sorted({group for group in assembly.groups if group})
        if not any(group == given or group.startswith(given + ".") for group in groups):
            raise no_such("control", given, dict.fromkeys([*assembly.names, *groups, MEAN]))
        rows, name = assembly.in_group(given), f'centroid of group "{given}" along the load'
    else:
        rows = assembly.blocks_named(given, "control")
        name = f'centroid of "{assembly.names[rows[0]]}" along the load'
    share = assembly.mass[rows] / assembly.mass[rows].sum()
    return Control(rows, assembly.centroid[rows], share[:, None] * along, name)


def _written(point: Floats) -> str:
    return f"({', '.join(f'{value:.6g}' for value in point)})"


def _oriented(limit: LimitLoad, control: Control) -> Control:
    """The control with the direction in which the mechanism moves it: along the load, or against it."""
    rate = control.rate(limit.assembly, rest_pose(limit.assembly), limit.mechanism)
    if abs(rate) <= MIN_CONTROL_RATE:
        raise InputError(f"control: the {control.name} does not move in the mechanism; choose a block that does")
    if rate > 0:
        return control
    return replace(control, along=-control.along, name=control.name.replace("along the load", "against the load"))
