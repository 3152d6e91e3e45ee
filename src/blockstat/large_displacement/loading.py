"""A structure that is displaced: loads whose forces keep their direction and act where they have at rest, controls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.analysis.problem import pose as posed
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, no_such
from blockstat.geometry.polyhedron import point_velocity
from blockstat.large_displacement.contacts import Contacts, displaced_interfaces
from blockstat.large_displacement.linkage import Control
from blockstat.large_displacement.pose import Pose, displaced, places, rest
from blockstat.loads import as_load, on_block, point_load, three
from blockstat.program.equilibrium import weight
from blockstat.program.ties import tie_wrenches
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.analysis.limit_load import LimitLoad
    from blockstat.assembly import Assembly

#: The control that is conjugate to the load; see `capacity`.
MEAN = "mean"
#: A control that moves by less than this, where the fastest corner moves at 1, does not move.
MOVES = 1e-6


@dataclass(frozen=True, eq=False)
class Loading:
    """Forces at points of blocks, and constant couples."""

    block: Ints  #: shape (k,)
    point: Floats  #: at rest, shape (k, 3) [m]
    force: Floats  #: shape (k, 3) [N]
    couple: Floats  #: on each block, shape (n_blocks, 3) [N m]

    def at(self, assembly: Assembly, pose: Pose) -> Floats:
        """Return the wrench on each block about its displaced centroid.

        Parameters
        ----------
        assembly
            The blocks at rest.
        pose
            Their pose.

        Returns
        -------
        Floats
            Shape (n_blocks, 6) [N, N m].
        """
        now = places(assembly, pose, self.block, self.point)
        arm = now - (assembly.centroid + pose.displacement)[self.block]
        wrench = np.hstack([np.zeros_like(self.couple), self.couple])
        np.add.at(wrench, self.block, np.hstack([self.force, np.cross(arm, self.force)]))
        return wrench


@dataclass(frozen=True, eq=False)
class Structure:
    """What stays the same while blocks are displaced."""

    assembly: Assembly  #: at rest, with its friction and gravity
    interfaces: Interfaces  #: at rest
    dead: Loading  #: besides the weight
    live: Loading | None  #: what the multiplier multiplies
    solver: str

    def dead_load(self, pose: Pose) -> Floats:
        """Return the wrench of all that does not grow, weights included, shape (n_blocks, 6) [N, N m].

        Parameters
        ----------
        pose
            The pose.

        Returns
        -------
        Floats
            About the displaced centroids; ties whose force is not given are left out.
        """
        return weight(self.assembly) + self.dead.at(self.assembly, pose)

    def tie_work(self, pose: Pose, motion: Floats) -> float:
        """Return the power of the ties on a motion: those that lengthen yield, those that shorten keep their least.

        Parameters
        ----------
        pose
            The pose.
        motion
            Rates of all blocks about their displaced centroids, shape (n_blocks, 6).

        Returns
        -------
        float
            [W]; ties without a greatest force keep their length, which is left to the linkage.
        """
        if not self.assembly.ties:
            return 0.0
        there = displaced(self.assembly, pose)
        ties = list(there.ties)
        unit = [float((tie_wrenches(there, [tie], np.ones(1)) * motion).sum()) for tie in ties]
        return sum(
            rate * (tie.least if rate > 0 or np.isinf(tie.greatest) else tie.greatest)
            for tie, rate in zip(ties, unit, strict=True)
        )

    def live_load(self, pose: Pose) -> Floats:
        """Return the wrench that the multiplier multiplies, shape (n_blocks, 6) [N, N m].

        Parameters
        ----------
        pose
            The pose.

        Returns
        -------
        Floats
            About the displaced centroids.
        """
        assert self.live is not None
        return self.live.at(self.assembly, pose)

    def multiplier(self, pose: Pose, motion: Floats) -> float:
        """Return the multiplier under which the loads do no work on a motion, -w'u / l'u.

        Parameters
        ----------
        pose, motion
            As in `tie_work`.

        Returns
        -------
        float
            Not a number where the live load does no work.
        """
        work = float((self.live_load(pose) * motion).sum())
        dead = float((self.dead_load(pose) * motion).sum()) + self.tie_work(pose, motion)
        return -dead / work if work else np.nan

    def driven(self, contacts: Contacts, closed: np.ndarray, pose: Pose, parameter: float) -> tuple[Floats, Ints]:
        """Return the rates at the contact points by the movement of supports, in the frames of the joints at a pose.

        Parameters
        ----------
        contacts, closed, pose, parameter
            As in `posed`.

        Returns
        -------
        rates : Floats
            Of b against a for a unit rate, shape (n_points, 3).
        contact : Ints
            The pair that each point stands for, shape (n_points,).
        """
        faces, point = displaced_interfaces(self.assembly, self.interfaces, contacts, closed, pose, parameter)
        drive = (contacts.drive[:, 1] - contacts.drive[:, 0])[point]
        return np.einsum("nij,nj->ni", faces.frame[faces.point_interface], drive), point

    def posed(self, contacts: Contacts, closed: np.ndarray, pose: Pose, parameter: float, multiplier: float) -> Problem:
        """Return the equilibrium problem at a pose.

        Parameters
        ----------
        contacts
            The pairs of points.
        closed
            Which of them touch, shape (n,) bool.
        pose, parameter
            Where the blocks are, and the movement of the supports.
        multiplier
            Of the live load.

        Returns
        -------
        Problem
            As `blockstat.analysis.problem.pose` makes it.
        """
        faces, _ = displaced_interfaces(self.assembly, self.interfaces, contacts, closed, pose, parameter)
        loads = self.dead.at(self.assembly, pose)
        if self.live is not None and multiplier:
            loads = loads + multiplier * self.live_load(pose)
        there = displaced(self.assembly, pose)
        return posed(there, friction=None, gravity=None, loads=loads, gap=GAP, interfaces=faces)

    def conjugate(self) -> Control:
        """Return the mean of all displacements weighted by the live load.

        Returns
        -------
        Control
            The displacement that the live load does work on.
        """
        live = self.live
        assert live is not None
        free = ~self.assembly.support[live.block]
        block, point, force = live.block[free], live.point[free], live.force[free]
        return Control(block, point, force / np.linalg.norm(force, axis=1).sum())


def loading(assembly: Assembly, given: Any, *, live: bool = False) -> Loading:
    """Read loads that follow their blocks.

    Parameters
    ----------
    assembly
        The blocks.
    given
        None, three numbers (the direction of an acceleration; only live loads), a wrench on each block, shape
        (n_blocks, 6) [N, N m], whose forces act at the centroids and whose moments stay as they are, or a sequence of
        (block, point, force), as in `blockstat.point_load`.
    live
        Whether a load that is nothing is an error.

    Returns
    -------
    Loading
        The forces and where they act.

    Raises
    ------
    InputError
        For anything else.
    """
    n = assembly.n_blocks
    if given is None and not live:
        return Loading(np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty((0, 3)), np.zeros((n, 3)))
    if given is not None and _are_point_forces(given):
        rows = [(int(assembly.blocks_named(b, "load")[0]), p, point_load(assembly, b, p, f)) for b, p, f in given]
        block = np.array([row[0] for row in rows], dtype=np.int64)
        force = np.array([row[2][row[0], :3] for row in rows])
        return Loading(block, np.array([row[1] for row in rows], dtype=float), force, np.zeros((n, 3)))
    if live:
        wrench = as_load(assembly, given)
    else:
        from blockstat.analysis.problem import checked_loads

        wrench = checked_loads(assembly, given)
    block = np.flatnonzero(wrench[:, :3].any(axis=1))
    return Loading(block, assembly.centroid[block], wrench[block, :3], wrench[:, 3:].copy())


def _are_point_forces(given: Any) -> bool:
    """Whether loads are given as blocks, points and forces."""
    if isinstance(given, np.ndarray) or not isinstance(given, Sequence) or not len(given):
        return False
    rows = [row for row in given if isinstance(row, (tuple, list)) and len(row) == 3]
    if len(rows) < len(given):
        return False
    if all(isinstance(row[0], str) or np.ndim(row[1]) == 1 for row in rows):
        return True
    if any(isinstance(row[0], str) for row in rows):
        raise InputError("loads: each must be a block, a point and a force")
    return False


def control_of(limit: LimitLoad, live: Loading, given: Any) -> Control:
    """Return the control that is asked for, checked to move.

    Parameters
    ----------
    limit
        The limit load, whose mechanism has to move it.
    live
        Its load.
    given
        As `blockstat.capacity` takes it.

    Returns
    -------
    Control
        Along the load, or against it where it moves so.

    Raises
    ------
    InputError
        For what is not there or does not move.
    """
    assembly, motion = limit.assembly, limit.mechanism
    along = live.force.sum(axis=0)
    if not np.linalg.norm(along) > 1e-9 * np.abs(live.force).sum():
        raise InputError("the forces of the load add up to nothing, so no displacement is along them")
    along = along / np.linalg.norm(along)
    if given is None:
        speed = point_velocity(assembly, motion, assembly.vertex_block, assembly.vertices)
        forward = speed @ along
        most = np.flatnonzero(forward >= forward.max() - MOVES)
        corner = most[np.argmax(np.round(np.linalg.norm(speed[most], axis=1), 6))]
        block = assembly.vertex_block[corner]
        place = ", ".join(f"{value:.6g}" for value in assembly.vertices[corner])
        name = f'corner ({place}) of "{assembly.names[block]}" along the load'
        return _moving(limit, Control(np.array([block]), assembly.vertices[[corner]], along[None], name))
    if isinstance(given, (tuple, list)):
        return _moving(limit, _of_point(assembly, given, along))
    if given == MEAN and MEAN not in assembly.names:
        free = ~assembly.support[live.block]
        block, point, force = live.block[free], live.point[free], live.force[free]
        name = "mean of all displacements weighted by the load"
        return _moving(limit, Control(block, point, force / np.linalg.norm(force, axis=1).sum(), name))
    if isinstance(given, str) and given not in assembly.names:
        groups = sorted({group for group in assembly.groups if group})
        if not any(group == given or group.startswith(given + ".") for group in groups):
            raise no_such("control", given, [*assembly.names, *groups, MEAN])
        rows, name = assembly.in_group(given), f'centroid of group "{given}" along the load'
    else:
        rows = assembly.blocks_named(given, "control")
        name = f'centroid of "{assembly.names[rows[0]]}" along the load'
    share = assembly.mass[rows] / assembly.mass[rows].sum()
    return _moving(limit, Control(rows, assembly.centroid[rows], share[:, None] * along, name))


def _of_point(assembly: Assembly, given: Sequence[Any], along: Floats) -> Control:
    """The control that is a point of a block."""
    if len(given) != 2:
        raise InputError(f"control is {given!r}; it must be a block, a group, a block and a point of it, or {MEAN}")
    (block,) = assembly.blocks_named(given[0], "control")
    point = three(given[1], "control: the point")
    if not on_block(assembly, int(block), point):
        raise InputError(f'control: the point {point.tolist()} is not on block "{assembly.names[block]}"')
    place = ", ".join(f"{value:.6g}" for value in point)
    name = f'point ({place}) of "{assembly.names[block]}" along the load'
    return Control(np.array([block]), point[None], along[None], name)


def _moving(limit: LimitLoad, control: Control) -> Control:
    """A control that moves, along the load or against it."""
    rate = control.rate(limit.assembly, rest(limit.assembly), limit.mechanism)
    if abs(rate) <= MOVES:
        raise InputError(f"control: the {control.name} does not move in the mechanism; choose a block that does")
    if rate > 0:
        return control
    return replace(control, along=-control.along, name=control.name.replace("along the load", "against the load"))
