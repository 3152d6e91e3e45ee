"""A mechanism as a linkage: rigid bodies that contacts and ties hold together.

Blocks that stick to each other at three points or more, not all on one line, are one rigid body. The supports that do
not move are at rest.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.large_displacement.displaced.contact_pairs import (
    JUST_CLOSED_GAP,
    ContactPairs,
    gaps,
    pairs_at_rest,
    rejoined,
)
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED_AT_REST, contact_status, tie_status
from blockstat.large_displacement.displaced.control import Control
from blockstat.large_displacement.displaced.pose import Pose, free_sizes, rest_pose, rotation_matrices
from blockstat.large_displacement.displaced.structure import (
    Configuration,
    Structure,
    slack_of_ties,
    with_yielded_ties,
)
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Points lie on one line when their second singular value is below this. Relative to the first. Chosen: the points of
#: an edge whose corners are off by millimetres do, and blocks whose points are taken for those of an edge in error are
#: held by equations instead of being one body.
COLLINEAR = 1e-2


@dataclass(frozen=True, eq=False)
class Linkage:
    """Rigid bodies, and the contacts and ties that hold them together."""

    structure: Structure
    contacts: ContactPairs
    sticking: np.ndarray  #: contacts whose two points coincide, shape (n_contacts,) bool
    sliding: np.ndarray  #: contacts that are closed and slide, shape (n_contacts,) bool
    ties: Ints  #: numbers of the ties whose length does not change, shape (k,)
    slack: Ints  #: numbers of the ties that are slack or shorten, until they are as long as before, shape (k,)
    control: Control | None  #: the displacement that is the parameter; None where the parameter moves supports
    associated: bool = False  #: whether flow is associated: joints open by friction times slip as they slide
    #: blocks of other mechanisms that begin at the same multiplier and are left at rest, shape (k,)
    left_at_rest: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    @property
    def assembly(self) -> Assembly:
        """The blocks at rest."""
        return self.structure.assembly

    @property
    def closed(self) -> np.ndarray:
        """The active set of contacts: those that stick and those that slide, shape (n_contacts,) bool."""
        closed: np.ndarray = self.sticking | self.sliding
        return closed

    @property
    def open(self) -> np.ndarray:
        """What may close: the contacts that are not in the active set, then slack ties, (n_contacts + n_ties,) bool."""
        return np.append(~self.closed, np.isin(np.arange(len(self.assembly.ties)), self.slack))

    def gaps(self, pose: Pose, parameter: float) -> Floats:
        """Return the gaps of all contacts, then the slacks of all ties.

        Parameters
        ----------
        pose
            The pose.
        parameter
            Its parameter [m].

        Returns
        -------
        Floats
            Shape (n_contacts + n_ties,) [m].
        """
        gap = gaps(self.assembly, self.contacts, pose, parameter)
        return np.append(gap, slack_of_ties(self.assembly, self.structure.with_supports(pose, parameter)))

    def just_closed(self, pose: Pose, parameter: float) -> Ints:
        """Return the open contacts and slack ties that close at a pose, in the order of `gaps`.

        Parameters
        ----------
        pose
            The pose, which was located by root finding.
        parameter
            Its parameter [m].

        Returns
        -------
        Ints
            Shape (k,). Of an edge of a joint that closes, all points, where they are off by the flaw of the joints.
        """
        gap = np.where(self.open, self.gaps(pose, parameter), np.inf)
        closes = gap <= JUST_CLOSED_GAP * float(free_sizes(self.assembly).max())
        closing = np.isin(self.contacts.joint, self.contacts.joint[closes[: self.contacts.number]])
        closes[: self.contacts.number] |= closing & (gap[: self.contacts.number] <= self.flaw_of_gaps)
        return np.flatnonzero(closes)

    def rejoined(self, rows: Ints, pose: Pose, parameter: float) -> Linkage:
        """Return the linkage with contacts that have closed sticking, and ties that are taut again of fixed length.

        Parameters
        ----------
        rows
            Which have closed, in the order of `gaps`, shape (k,).
        pose
            The pose.
        parameter
            Its parameter [m].

        Returns
        -------
        Linkage
            The points of the contacts coincide again (`displaced.contact_pairs.rejoined`).
        """
        contact, taut = rows[rows < self.contacts.number], rows[rows >= self.contacts.number] - self.contacts.number
        contacts = rejoined(self.assembly, self.contacts, contact, pose, parameter)
        sticking = self.sticking.copy()
        sticking[contact] = True
        ties = np.union1d(self.ties, taut).astype(np.int64)
        return replace(self, contacts=contacts, sticking=sticking, ties=ties, slack=np.setdiff1d(self.slack, taut))

    def configuration(self, pose: Pose, parameter: float) -> Configuration:
        """Return the structure at a pose with the active set of the linkage.

        Parameters
        ----------
        pose
            The pose.
        parameter
            Its parameter [m].

        Returns
        -------
        Configuration
            What equilibrium is asked of.
        """
        return Configuration(
            self.structure, self.contacts, self.closed, pose, parameter, yielding=self.yielding, slack=self.slack
        )

    @cached_property
    def body(self) -> Ints:
        """Rigid body of each block, -1 for a block that does not move, shape (n_blocks,)."""
        contacts, n = self.contacts, self.assembly.n_blocks
        fixed = self.sticking & ~contacts.drive.any(axis=(1, 2))
        rigid = [contacts.pair[rows[0]] for rows in self._by_pair(fixed) if _not_collinear(contacts.anchor[rows, 0])]
        support = np.flatnonzero(self.assembly.support)
        edges = np.concatenate([np.array(rigid).reshape(-1, 2), np.column_stack([support, np.roll(support, 1)])])
        _, label = connected_components(n, edges.astype(np.int64))
        label = np.where(label == label[support[0]], -1, label)
        _, number = np.unique(label, return_inverse=True)
        body: Ints = number - 1 if (label < 0).any() else number
        return body

    def _by_pair(self, mask: np.ndarray) -> list[Ints]:
        """The contacts of a mask, grouped by their pair of blocks."""
        rows = np.flatnonzero(mask)
        if not len(rows):
            return []
        _, group = np.unique(self.contacts.pair[rows], axis=0, return_inverse=True)
        order = np.argsort(group, kind="stable")
        return np.split(rows[order], np.flatnonzero(np.diff(group[order])) + 1)

    @cached_property
    def n_bodies(self) -> int:
        """The number of rigid bodies that move."""
        return int(self.body.max(initial=-1)) + 1

    @cached_property
    def length(self) -> float:
        """The length that rotations are multiplied by as unknowns [m]: the mean size of the free blocks."""
        return float(free_sizes(self.assembly).mean())

    @cached_property
    def flaw_of_rates(self) -> float:
        """By how much the rate of a contact may be off, relative to the fastest motion (`FaceOutlines.flaw`)."""
        return self.structure.outlines.flaw.rate(self.length)

    @cached_property
    def flaw_of_rows(self) -> float:
        """Root mean square by which the rows of the linkage's equations may be off (`FaceOutlines.flaw`)."""
        return self.structure.outlines.flaw.row(self.length, slides=bool(self.sliding.any()))

    @cached_property
    def flaw_of_gaps(self) -> float:
        """By how much a contact of a pose may be open or overlap where its faces miss planes [m].

        A joint that has slid by a block has no contact any more.
        """
        return self.structure.outlines.flaw.gap(float(free_sizes(self.assembly).max()))

    @property
    def slides_with_friction(self) -> bool:
        """Whether a contact slides whose friction is not zero."""
        return bool((self.contacts.friction[self.sliding] > 0).any())

    @property
    def yielding(self) -> Ints:
        """Numbers of the ties that yield."""
        bounded = [not tie.constant and np.isfinite(tie.greatest) for tie in self.assembly.ties]
        found: Ints = np.setdiff1d(np.flatnonzero(bounded), np.append(self.ties, self.slack))
        return found

    @cached_property
    def between_bodies(self) -> tuple[Ints, Ints]:
        """Contacts between bodies: those that stick, and those that slide."""
        between = self.may_part
        return np.flatnonzero(self.sticking & between), np.flatnonzero(self.sliding & between)

    @property
    def may_part(self) -> np.ndarray:
        """Whether the sides of a contact belong to two bodies, or one to a support that moves, (n_contacts,) bool.

        What sticks to supports at rest and supports that move are the same body, -1, as far as their own motion goes.
        """
        a, b = self.body[self.contacts.pair].T
        apart: np.ndarray = (a != b) | self.contacts.drive.any(axis=(1, 2))
        return apart

    def origins(self, pose: Pose) -> Floats:
        """Return the mean of the displaced centroids of the blocks of each body.

        Parameters
        ----------
        pose
            The pose.

        Returns
        -------
        Floats
            Shape (n_bodies, 3) [m].
        """
        now = pose.centroids(self.assembly)
        own = self.body >= 0
        body, n = self.body[own], self.n_bodies
        sums = [np.bincount(body, now[own, k], n) for k in range(3)]
        return np.array(sums).T / np.bincount(body, minlength=n)[:, None]

    def body_motions(self, motion: Floats) -> Floats:
        """Return the motions of the bodies nearest to motions of the blocks: the mean velocity and mean rotation rate.

        Parameters
        ----------
        motion
            Rates of the blocks about their displaced centroids, shape (n_blocks, 6).

        Returns
        -------
        Floats
            About the origins of the bodies, rotation rates times `length`, shape (6 n_bodies,) [m].
        """
        own = np.flatnonzero(self.body >= 0)
        body, n = self.body[own], self.n_bodies
        count = np.bincount(body, minlength=n)[:, None]
        spin = np.stack([np.bincount(body, motion[own, 3 + k], n) for k in range(3)], axis=1) / count
        # The origin is the mean of the centroids, so velocities by rotation about it cancel in the mean.
        speed = np.stack([np.bincount(body, motion[own, k], n) for k in range(3)], axis=1) / count
        return np.hstack([speed, self.length * spin]).reshape(-1)

    def block_motions(self, pose: Pose, motion: Floats, origin: Floats) -> Floats:
        """Return the motions of the blocks in motions of the bodies.

        Parameters
        ----------
        pose
            The pose.
        motion
            Of the bodies, as `body_motions` gives it, shape (6 n_bodies,) [m].
        origin
            Of the bodies, as `origins` gives them.

        Returns
        -------
        Floats
            About the displaced centroids, shape (n_blocks, 6).
        """
        own = np.flatnonzero(self.body >= 0)
        v = motion.reshape(-1, 6)[self.body[own]]
        arm = pose.centroids(self.assembly)[own] - origin[self.body[own]]
        twist = np.zeros((self.assembly.n_blocks, 6))
        spin = v[:, 3:] / self.length
        twist[own] = np.hstack([v[:, :3] + np.cross(spin, arm), spin])
        return twist

    def moved(self, pose: Pose, motion: Floats, origin: Floats) -> Pose:
        """Return the pose after finite displacements and rotations of the bodies.

        Parameters
        ----------
        pose
            Where they start.
        motion, origin
            As in `block_motions`; the rotations are finite.

        Returns
        -------
        Pose
            Of all blocks.
        """
        own = np.flatnonzero(self.body >= 0)
        step = motion.reshape(-1, 6)
        turn = rotation_matrices(step[:, 3:] / self.length)
        at = self.body[own]
        arm = pose.centroids(self.assembly)[own] - origin[at]
        rotation, displacement = pose.rotation.copy(), pose.displacement.copy()
        rotation[own] = turn[at] @ rotation[own]
        displacement[own] += step[at, :3] + np.einsum("nij,nj->ni", turn[at], arm) - arm
        return replace(pose, rotation=rotation, displacement=displacement)

    def with_yielded_ties(self, pose: Pose, parameter: float) -> Pose:
        """Return a pose in which the ties that yield have lengthened for good (`displaced.structure`).

        Parameters
        ----------
        pose
            The pose to which the linkage has moved.
        parameter
            Its parameter [m].

        Returns
        -------
        Pose
            The given one where no tie yields.
        """
        return with_yielded_ties(self.assembly, pose, self.yielding, self.structure.with_supports(pose, parameter))

    def with_turned_ties(self, pose: Pose, parameter: float, motion: Floats) -> Linkage:
        """Return the linkage whose ties are slack that have yielded and are shorter by now, or shorten.

        Parameters
        ----------
        pose, parameter
            As in `with_yielded_ties`.
        motion
            Of the linkage for a unit rate of the parameter, shape (n_blocks, 6).

        Returns
        -------
        Linkage
            The given one where no tie has yielded.
        """
        if not len(self.yielding):
            return self
        slack = tie_status(self.configuration(pose, parameter), motion, float(self.control is None))[1]
        turned = np.intersect1d(slack, self.yielding)
        return replace(self, slack=np.union1d(self.slack, turned).astype(np.int64))


def linkage_at_rest(
    structure: Structure,
    mechanism: Floats,
    control: Control | None,
    *,
    associated: bool = False,
    drive: Floats | None = None,
) -> Linkage:
    """Return the linkage of a mechanism that leaves rest.

    Parameters
    ----------
    structure
        The structure.
    mechanism
        Of any magnitude, shape (n_blocks, 6); where supports move, for a unit rate of their movement.
    control
        None where supports move.
    associated
        As in `Linkage`.
    drive
        Movement of the two sides of each joint by a unit movement of the supports, shape (n_interfaces, 2, 3); None
        where no support moves.

    Returns
    -------
    Linkage
        Ties keep their length, unless the mechanism shortens them or they yield in it.
    """
    assembly = structure.assembly
    contacts = pairs_at_rest(assembly, structure.interfaces, straight=structure.outlines.flaw.gap(0.0))
    if drive is not None:
        contacts = replace(contacts, drive=drive[contacts.joint])
    closed = np.ones(contacts.number, dtype=bool)
    rest = Configuration(structure, contacts, closed, rest_pose(assembly), 0.0)
    rate = 0.0 if drive is None else 1.0
    sticking, sliding = contact_status(rest, mechanism, rate, sticking_speed=STICKING_SPEED_AT_REST)
    ties, slack = tie_status(rest, mechanism, rate, sticking_speed=STICKING_SPEED_AT_REST)
    return Linkage(structure, contacts, sticking, sliding, ties, slack, control, associated)


def _not_collinear(points: Floats) -> bool:
    """Whether points do not all lie on one line."""
    if len(points) < 3:
        return False
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(values[1] > COLLINEAR * values[0])
