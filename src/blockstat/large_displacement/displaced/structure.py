"""The structure whose blocks are displaced, and its configuration: a pose with the active set of contacts.

A tie is unilateral. One that is shorter than its own length hangs slack and pulls with its least force, until it is as
long as that again. Its own length is that at rest and whatever it has yielded by since: a tie lengthens for good while
its force is its greatest, and at no smaller one. So a strength that is not reached does not matter. A strut is slack
where it is longer than its own length. Supports that move whole carry the ends of their ties.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.analysis.problem import pose as equilibrium_problem
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.point_law import last_law
from blockstat.joint import Tie
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE, ContactPairs
from blockstat.large_displacement.displaced.face_outlines import FaceOutlines
from blockstat.large_displacement.displaced.joints import displaced_interfaces
from blockstat.large_displacement.displaced.loads import displaced_wrenches
from blockstat.large_displacement.displaced.pose import Pose, displaced_assembly, free_sizes
from blockstat.loading.placed import PlacedForces
from blockstat.program.equilibrium import weight
from blockstat.program.ties import tie_wrenches
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A tie is slack from this slack on. Relative to the largest free block. Chosen: a pose of finite steps leaves ties
#: that hold their length shorter by less.
SLACK = CORNER_TOLERANCE
#: A tie that lengthens more slowly than this keeps its length. Relative to the fastest motion. Chosen: far above what
#: the equations of a linkage leave, far below the speed at which ties yield.
KEPT_LENGTH = 1e-9


@dataclass(frozen=True, eq=False)
class Structure:
    """What does not change while blocks are displaced."""

    assembly: Assembly  #: at rest, with its friction and gravity
    interfaces: Interfaces  #: at rest
    dead: PlacedForces  #: permanent loads besides the weight
    live: PlacedForces | None  #: the load that the multiplier multiplies; None where supports move instead
    solver: str  #: as in `blockstat.limit_load`
    #: of the supports that move whole, for a unit rate of their movement, shape (n_blocks, 6); zero elsewhere
    support_motion: Floats

    @cached_property
    def outlines(self) -> FaceOutlines:
        """The faces of the joints at rest."""
        return FaceOutlines(self.assembly, self.interfaces)

    def dead_load(self, pose: Pose) -> Floats:
        """Return the wrenches w of the permanent loads, weights included.

        Parameters
        ----------
        pose
            The pose.

        Returns
        -------
        Floats
            About the displaced centroids, shape (n_blocks, 6) [N, N m]. Forces of ties are not among them.
        """
        return weight(self.assembly) + displaced_wrenches(self.dead, self.assembly, pose)

    def live_load(self, pose: Pose) -> Floats:
        """Return the wrenches l that the multiplier multiplies.

        Parameters
        ----------
        pose
            The pose.

        Returns
        -------
        Floats
            About the displaced centroids, shape (n_blocks, 6) [N, N m].
        """
        assert self.live is not None
        return displaced_wrenches(self.live, self.assembly, pose)

    def with_supports(self, pose: Pose, parameter: float) -> Pose:
        """Return a pose in which the supports that move whole are where they have moved, as the ties on them are.

        Parameters
        ----------
        pose
            The pose, with all supports at rest.
        parameter
            Movement of the supports [m].

        Returns
        -------
        Pose
            Of all blocks.
        """
        return replace(pose, displacement=pose.displacement + parameter * self.support_motion[:, :3])

    def tie_power(self, pose: Pose, parameter: float, motion: Floats, yielding: Ints | None = None) -> float:
        """Return the power of the ties in a motion.

        Parameters
        ----------
        pose
            The pose.
        parameter
            Movement of the supports [m]; it counts where some move.
        motion
            Rates of all blocks about their displaced centroids, shape (n_blocks, 6); where supports move, for a unit
            rate of their movement.
        yielding
            Numbers of the ties that yield if they lengthen; all where None.

        Returns
        -------
        float
            [W]. A tie that lengthens yields at its greatest force. One that shortens or is slack keeps its least. One
            that the linkage holds counts with its least, too: what it lengthens by is rounding.
        """
        if not self.assembly.ties:
            return 0.0
        there = displaced_with_slack_ties(self.assembly, self.with_supports(pose, parameter))
        moving = motion + self.support_motion
        held = -KEPT_LENGTH * float(np.abs(moving).max())
        rates = slackening(there, moving)
        force = [tie.least for tie in there.ties]
        for k in _which_yield(there.ties, rates < held, yielding):
            force[k] = there.ties[k].greatest
        return float(rates @ force)

    def dead_power(self, pose: Pose, parameter: float, motion: Floats, yielding: Ints | None = None) -> float:
        """Return the power of the permanent loads and the ties in a motion.

        Parameters
        ----------
        pose, parameter, motion, yielding
            As in `tie_power`.

        Returns
        -------
        float
            w'u and that of the ties [W].
        """
        return float((self.dead_load(pose) * motion).sum()) + self.tie_power(pose, parameter, motion, yielding)

    def part_of_live_power(self, pose: Pose, motion: Floats, blocks: Ints) -> float:
        """Return the part of the power of the live load in a motion that is on some blocks.

        Parameters
        ----------
        pose, motion
            As in `tie_power`.
        blocks
            Their numbers.

        Returns
        -------
        float
            1 where it is all of it.
        """
        power: Floats = (self.live_load(pose) * motion).sum(axis=1)
        return float(power[blocks].sum() / power.sum())

    def multiplier(self, pose: Pose, parameter: float, motion: Floats, yielding: Ints | None = None) -> float:
        """Return the multiplier of virtual work, under which all loads together do no work in a motion.

        Parameters
        ----------
        pose, parameter, motion, yielding
            As in `tie_power`.

        Returns
        -------
        float
            alpha = -w'u / l'u, with the power of the ties in w'u; nan where the live load does no work.
        """
        work = float((self.live_load(pose) * motion).sum())
        dead = self.dead_power(pose, parameter, motion, yielding)
        return -dead / work if work else np.nan


@dataclass(frozen=True, eq=False)
class Configuration:
    """A structure at a pose with its active set of contacts: what an equilibrium problem needs."""

    structure: Structure
    contacts: ContactPairs
    closed: np.ndarray  #: the active set: which contacts are closed, shape (n_contacts,) bool
    pose: Pose
    parameter: float  #: movement of the supports, or displacement of the control [m]
    #: numbers of the ties that yield if they lengthen, and of those that are slack, in the motions of a linkage; the
    #: lengths and rates of ties tell that alone where None
    yielding: Ints | None = None
    slack: Ints | None = None

    @cached_property
    def joints(self) -> tuple[Interfaces, Ints]:
        """The displaced joints, and the contact that each of their points stands for, shape (n_points,)."""
        fixed = self.structure
        return displaced_interfaces(
            fixed.assembly, fixed.interfaces, self.contacts, self.closed, self.pose, self.parameter
        )

    def support_rates(self, problem: Problem) -> Floats:
        """Return the rates of contact points, bonds and ties when the supports alone move at a unit rate.

        Parameters
        ----------
        problem
            As `problem` gives it.

        Returns
        -------
        Floats
            Of the columns of its program, shape (m, 3).
        """
        faces, contact = self.joints
        drive = self.contacts.drive[contact[faces.start[:-1]]]
        return problem.rates_by_supports(drive[:, 1] - drive[:, 0], self.structure.support_motion)

    def problem(self, multiplier: float = 0.0, motion: Floats | None = None) -> Problem:
        """Return the equilibrium problem of the displaced structure.

        Parameters
        ----------
        multiplier
            Of the live load.
        motion
            Rates of all blocks, supports included, in which ties yield or are slack, shape (n_blocks, 6). None where
            those that are not slack may carry whatever they can.

        Returns
        -------
        Problem
            As `blockstat.analysis.problem.pose` makes it.
        """
        fixed = self.structure
        loads = displaced_wrenches(fixed.dead, fixed.assembly, self.pose)
        if fixed.live is not None and multiplier:
            loads = loads + multiplier * fixed.live_load(self.pose)
        there = displaced_with_slack_ties(fixed.assembly, fixed.with_supports(self.pose, self.parameter))
        there = there if motion is None else self._with_ties_in_motion(there, motion)
        return equilibrium_problem(
            there, friction=None, gravity=None, loads=loads, gap=GAP, interfaces=self.joints[0], displaced=True
        )

    def _with_ties_in_motion(self, there: Assembly, motion: Floats) -> Assembly:
        """The displaced assembly whose ties have the force that a motion gives them.

        One that lengthens yields at its greatest force, and one that shortens or is slack keeps its least. One that
        keeps its length, or has no greatest force, may carry whatever it can.
        """
        if not there.ties:
            return there
        rate, held = slackening(there, motion), KEPT_LENGTH * float(np.abs(motion).max(initial=0.0))
        ties, loose = list(there.ties), rate > held
        if self.slack is not None:
            loose[self.slack] = True
        for k in np.flatnonzero(loose):
            ties[k] = replace(ties[k], greatest=ties[k].least)
        for k in _which_yield(ties, (rate < -held) & ~loose, self.yielding):
            ties[k] = replace(ties[k], least=ties[k].greatest)
        return replace(there, ties=tuple(ties))


def why_not_followed(assembly: Assembly, interfaces: Interfaces) -> str:
    """Return why blocks cannot be followed as they move: joint laws whose points change as joints open.

    Parameters
    ----------
    assembly
        The blocks and their joint laws.
    interfaces
        Joints of the blocks at rest.

    Returns
    -------
    str
        Empty where they can be followed.
    """
    laws = [law for law in last_law(assembly, interfaces) if law is not None]
    if any(law.compression is not None for law in laws):
        return "joints with compressive strength crush at their hinges, which is not followed; leave it out"
    if any(law.cells for law in laws) or interfaces.share is not None:
        return "joints that are divided into cells are not followed as they open; leave the cells out"
    return ""


def slack_of_ties(assembly: Assembly, pose: Pose) -> Floats:
    """Return by how much ties are shorter than their own length, that at rest and what they have yielded by.

    Parameters
    ----------
    assembly
        The blocks at rest and their ties.
    pose
        The pose.

    Returns
    -------
    Floats
        Shape (n_ties,) [m]; of struts, by how much they are longer. Negative where a tie is longer than its own length.
    """
    return _slack(assembly.ties, displaced_assembly(assembly, pose).ties, pose) if assembly.ties else np.empty(0)


def _slack(rest: Sequence[Tie], now: Sequence[Tie], pose: Pose) -> Floats:
    lengths = [np.diff([tie.points for tie in ties], axis=1)[:, 0] for ties in (rest, now)]
    shorter = np.linalg.norm(lengths[0], axis=1) - np.linalg.norm(lengths[1], axis=1)
    slack: Floats = np.where([tie.strut for tie in rest], -shorter, shorter)
    return slack + pose.yielded if len(pose.yielded) else slack


def with_yielded_ties(assembly: Assembly, pose: Pose, ties: Ints, whole: Pose) -> Pose:
    """Return a pose in which ties that yield have lengthened for good, as far as it has them longer than before.

    Parameters
    ----------
    assembly
        The blocks at rest and their ties.
    pose
        The pose.
    ties
        Numbers of the ties that yield on the way to the pose.
    whole
        The pose with the supports that move whole where they are (`Structure.with_supports`).

    Returns
    -------
    Pose
        The given one where no tie that yields is longer than its own length.
    """
    if not len(ties):
        return pose
    longer = np.zeros(len(assembly.ties))
    longer[ties] = np.maximum(-slack_of_ties(assembly, whole)[ties], 0.0)
    before = pose.yielded if len(pose.yielded) else np.zeros(len(longer))
    return replace(pose, yielded=before + longer) if longer.any() else pose


def displaced_with_slack_ties(assembly: Assembly, pose: Pose) -> Assembly:
    """Return the assembly at a pose, with the least force of slack ties as a constant one.

    Parameters
    ----------
    assembly
        The blocks at rest and their ties.
    pose
        The pose.

    Returns
    -------
    Assembly
        The same blocks, displaced.
    """
    there = displaced_assembly(assembly, pose)
    if not there.ties:
        return there
    slack = _slack(assembly.ties, there.ties, pose) > SLACK * float(free_sizes(assembly).max())
    ties = [replace(tie, greatest=tie.least) if own else tie for tie, own in zip(there.ties, slack, strict=True)]
    return replace(there, ties=tuple(ties))


def _which_yield(ties: Sequence[Tie], lengthens: np.ndarray, yielding: Ints | None) -> Ints:
    """Numbers of the ties that lengthen and yield, of those that may."""
    finite = np.isfinite([tie.greatest for tie in ties])
    found = np.flatnonzero(lengthens & finite)
    return found if yielding is None else np.intersect1d(found, yielding)


def slackening(there: Assembly, motion: Floats) -> Floats:
    """Return the rates at which ties shorten and struts lengthen in a motion.

    Parameters
    ----------
    there
        The displaced assembly.
    motion
        Rates of all blocks about their displaced centroids, shape (n_blocks, 6).

    Returns
    -------
    Floats
        The power of a unit force of each, shape (n_ties,).
    """
    return np.array([float((tie_wrenches(there, [tie], np.ones(1)) * motion).sum()) for tie in there.ties])
