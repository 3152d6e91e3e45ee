"""A mechanism as a linkage: bodies on hinges, whose pose follows one parameter exactly.

Contacts that stick hold two material points together, and those that slide hold one on the face of the other block:

    p_b - p_a = 0        gap(q) = 0        |tie| = its length        control(q) = s

Blocks that stick to each other at three points or more are one body. Newton's method with the least change of pose
solves these equations for finite rotations, so the pose at s is free of the error of steps as long as nothing slides
against friction. Directions that the equations leave free, such as that of a sliding block, are those of the mechanism
that the linkage was made from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy import sparse

from blockstat.geometry.components import connected_components
from blockstat.large_displacement.contacts import Contacts, crossings, roles, sides
from blockstat.large_displacement.pose import Pose, places, turned
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Residuals below this, relative to the size of the blocks, are closed: a thousand times the rounding of coordinates.
CLOSED = 1e-12
#: Newton's method converges within this many steps, or the step was too long.
NEWTON = 12
#: Unknowns up to which a matrix is dense.
DENSE = 400
#: Rates that no motion of the linkage gives, relative to that of the parameter.
CONSISTENT = 1e-7


class Rows(NamedTuple):
    """Rows of velocities of b against a along directions: six entries for each side that moves."""

    number: int  #: of rows
    row: Ints  #: of each six entries, shape (k,)
    body: Ints  #: whose motion they multiply, shape (k,)
    entries: Floats  #: shape (k, 6)


def rates(body: Ints, pair: Ints, direction: Floats, place: tuple[Floats, Floats], origin: Floats) -> Rows:
    """Return rows of the velocity of block b against block a along directions.

    Parameters
    ----------
    body
        Body of each block, -1 for what does not move, shape (n_blocks,).
    pair
        Blocks a and b of each row, shape (n, 2); block -1 is at rest.
    direction
        Shape (n, 3).
    place
        Where the points of a and of b are, both of shape (n, 3) [m].
    origin
        Of the bodies, shape (n_bodies, 3) [m].

    Returns
    -------
    Rows
        One for each pair.
    """
    rows, bodies, entries = [], [], []
    for side, sign in ((0, -1.0), (1, 1.0)):
        which = np.append(body, -1)[pair[:, side]]
        own = np.flatnonzero(which >= 0)
        (arm_x, arm_y, arm_z), (x, y, z) = (place[side][own] - origin[which[own]]).T, direction[own].T
        moment = [arm_y * z - arm_z * y, arm_z * x - arm_x * z, arm_x * y - arm_y * x]
        rows.append(own)
        bodies.append(which[own])
        entries.append(sign * np.stack([x, y, z, *moment], axis=1))
    return Rows(len(pair), np.concatenate(rows), np.concatenate(bodies), np.concatenate(entries))


def summed(rows: Rows) -> Rows:
    """Return the sum of rows.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    Rows
        One row.
    """
    return rows._replace(number=1, row=0 * rows.row)


def as_matrix(parts: Sequence[Rows], n_bodies: int, length: float) -> Floats | sparse.csr_array:
    """Return rows one below the other as a matrix.

    Parameters
    ----------
    parts
        The rows.
    n_bodies
        Bodies of three displacements and three rotations each.
    length
        The unit of rotations [m].

    Returns
    -------
    Floats or sparse.csr_array
        Shape (n, 6 n_bodies): dense if small.
    """
    first = np.concatenate([[0], np.cumsum([part.number for part in parts])])
    row = np.concatenate([start + part.row for start, part in zip(first, parts, strict=False)])
    body = np.concatenate([part.body for part in parts])
    entries = np.concatenate([part.entries for part in parts]) / np.repeat([1.0, length], 3)
    row, column = np.repeat(row, 6), (6 * body[:, None] + np.arange(6)).reshape(-1)
    shape = (int(first[-1]), 6 * n_bodies)
    if shape[1] > DENSE:
        return sparse.csr_array((entries.reshape(-1), (row, column)), shape=shape)
    flat: Any = np.bincount(row * shape[1] + column, entries.reshape(-1), shape[0] * shape[1])
    dense: Floats = flat.reshape(shape)
    return dense


@dataclass(frozen=True, eq=False)
class Control:
    """The displacement that the pose follows: a weighted mean of displacements of points, along directions."""

    block: Ints  #: shape (k,)
    point: Floats  #: at rest, shape (k, 3) [m]
    along: Floats  #: weight times direction of each, shape (k, 3)
    name: str = ""

    def value(self, assembly: Assembly, pose: Pose) -> float:
        """Return the displacement [m].

        Parameters
        ----------
        assembly
            The blocks at rest.
        pose
            Their pose.

        Returns
        -------
        float
            The weighted sum.
        """
        moved = places(assembly, pose, self.block, self.point) - self.point
        return float((self.along * moved).sum())

    def rate(self, assembly: Assembly, pose: Pose, motion: Floats) -> float:
        """Return the rate of the displacement under a motion.

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
            Of the weighted sum.
        """
        arm = places(assembly, pose, self.block, self.point) - (assembly.centroid + pose.displacement)[self.block]
        own = motion[self.block]
        return float((self.along * (own[:, :3] + np.cross(own[:, 3:], arm))).sum())

    def row(self, assembly: Assembly, pose: Pose, body: Ints, origin: Floats) -> Rows:
        """Return the rate of the displacement as a row for motions of bodies.

        Parameters
        ----------
        assembly, pose
            As in `value`.
        body
            Body of each block, -1 for what does not move, shape (n_blocks,).
        origin
            Of the bodies, shape (n_bodies, 3) [m].

        Returns
        -------
        Rows
            One row.
        """
        now = places(assembly, pose, self.block, self.point)
        pair = np.column_stack([np.full(len(self.block), -1), self.block])
        return summed(rates(body, pair, self.along, (now, now), origin))


@dataclass(frozen=True, eq=False)
class Linkage:
    """Bodies, and what holds them together."""

    assembly: Assembly  #: at rest
    contacts: Contacts
    pinned: np.ndarray  #: contacts that stick, shape (n,) bool
    sliding: np.ndarray  #: contacts that slide and stay shut, shape (n,) bool
    ties: Ints  #: ties whose length stays
    control: Control | None  #: None where the parameter moves supports
    dilates: bool = False  #: whether joints that slide open at the rate of associated friction

    @cached_property
    def body(self) -> Ints:
        """Body of each block, -1 for what does not move, shape (n_blocks,)."""
        contacts, n = self.contacts, self.assembly.n_blocks
        still = self.pinned & ~contacts.drive.any(axis=(1, 2))
        rigid = [contacts.pair[rows[0]] for rows in self._by_pair(still) if _spans(contacts.anchor[rows, 0])]
        support = np.flatnonzero(self.assembly.support)
        edges = np.concatenate([np.array(rigid).reshape(-1, 2), np.column_stack([support, np.roll(support, 1)])])
        _, label = connected_components(n, edges.astype(np.int64))
        label = np.where(label == label[support[0]], -1, label)
        _, number = np.unique(label, return_inverse=True)
        body: Ints = number - 1 if (label < 0).any() else number
        return body

    def _by_pair(self, mask: np.ndarray) -> list[Ints]:
        rows = np.flatnonzero(mask)
        if not len(rows):
            return []
        _, group = np.unique(self.contacts.pair[rows], axis=0, return_inverse=True)
        order = np.argsort(group, kind="stable")
        return np.split(rows[order], np.flatnonzero(np.diff(group[order])) + 1)

    @property
    def rubs(self) -> bool:
        """Whether a contact slides against friction."""
        return bool((self.contacts.friction[self.sliding] > 0).any())

    @property
    def n_bodies(self) -> int:
        """The number of bodies that move."""
        return int(self.body.max(initial=-1)) + 1

    @cached_property
    def _between(self) -> tuple[Ints, Ints]:
        """Contacts between two bodies that stick, and those that slide."""
        a, b = self.body[self.contacts.pair].T
        apart = a != b
        return np.flatnonzero(self.pinned & apart), np.flatnonzero(self.sliding & apart)

    def tangent(self, pose: Pose, parameter: float, guess: Floats) -> Floats | None:
        """Return the motion of the linkage for a unit rate of the parameter.

        Parameters
        ----------
        pose
            A pose of the linkage.
        parameter
            Its parameter.
        guess
            A motion of all blocks, shape (n_blocks, 6); of all motions of the linkage that next to it is taken.

        Returns
        -------
        Floats or None
            Shape (n_blocks, 6), about the displaced centroids; None where the parameter does not move the linkage.
        """
        rate = 1.0 if self.control is None else self.control.rate(self.assembly, pose, guess)
        # Of the same rate first, so that what is free keeps the shape of the guess.
        guess = guess / rate if rate > 0 else guess
        system = self._system(pose, parameter, guess)
        start = self.of_bodies(guess)
        lacking = system.rate - system.matrix @ start
        change = _least_change(system.matrix, lacking)
        found = start + change
        if np.abs(system.matrix @ found - system.rate).max(initial=0.0) > CONSISTENT:
            return None
        return self.of_blocks(pose, found, system.origin)

    def free(self, pose: Pose, parameter: float, guess: Floats) -> Floats:
        """Return the motion next to the given one that leaves the parameter as it is.

        Parameters
        ----------
        pose, parameter, guess
            As in `tangent`.

        Returns
        -------
        Floats
            Shape (n_blocks, 6).
        """
        system = self._system(pose, parameter, guess)
        start = self.of_bodies(guess)
        return self.of_blocks(pose, start - _least_change(system.matrix, system.matrix @ start), system.origin)

    def moved(
        self, pose: Pose, parameter: float, twist: Floats, *, along: tuple[Floats, float] | None = None
    ) -> Pose | None:
        """Return the pose of the linkage at a parameter, next to where a motion leads.

        Parameters
        ----------
        pose
            Where it starts.
        parameter
            Of the pose that is looked for.
        twist
            Displacement and rotation of all blocks that lead near it, shape (n_blocks, 6).
        along
            A motion and how far the pose lies along it from the start, in place of any such pose.

        Returns
        -------
        Pose or None
            None where Newton's method finds none.
        """
        size = float(self.assembly.size.max())
        now = self.shifted(pose, self.of_bodies(twist), self.origins(pose))
        best = np.inf
        for _ in range(NEWTON):
            system = self._system(now, parameter, twist)
            matrix: Any = system.matrix
            lacking = -system.residual
            if along is not None:
                row, gap = self._distance(pose, now, *along, system.origin)
                rows: Any = [matrix, row]
                matrix = np.vstack(rows) if isinstance(matrix, np.ndarray) else sparse.vstack(rows)
                lacking = np.append(lacking, gap)
            error = np.abs(lacking).max(initial=0.0)
            if error <= CLOSED * size or (error <= 1e3 * CLOSED * size and error > 0.25 * best):
                return now
            if not error < 1e3 * size or (error > best and best < np.inf and error > 1e-3 * size):
                return None
            best = min(best, error)
            now = self.shifted(now, _least_change(matrix, lacking), system.origin)
        return None

    def origins(self, pose: Pose) -> Floats:
        """Return the mean of the centroids of each body.

        Parameters
        ----------
        pose
            The pose.

        Returns
        -------
        Floats
            Shape (n_bodies, 3) [m].
        """
        now = self.assembly.centroid + pose.displacement
        own = self.body >= 0
        count = np.bincount(self.body[own], minlength=self.n_bodies)
        sums = [np.bincount(self.body[own], now[own, k], self.n_bodies) for k in range(3)]
        return np.stack(sums, axis=1) / count[:, None]

    def of_bodies(self, twist: Floats) -> Floats:
        """Return motions of bodies next to those of blocks: the mean of their rotations and of what their centroids do.

        Parameters
        ----------
        twist
            Motions of the blocks about their displaced centroids, shape (n_blocks, 6).

        Returns
        -------
        Floats
            Shape (6 n_bodies,), about the origins of the bodies, rotations times `length` [m].
        """
        own = np.flatnonzero(self.body >= 0)
        body, n = self.body[own], self.n_bodies
        count = np.bincount(body, minlength=n)[:, None]
        spin = np.stack([np.bincount(body, twist[own, 3 + k], n) for k in range(3)], axis=1) / count
        # The origin is the mean of the centroids, so that rotations about it cancel in the mean.
        speed = np.stack([np.bincount(body, twist[own, k], n) for k in range(3)], axis=1) / count
        return np.hstack([speed, self.length * spin]).reshape(-1)

    def of_blocks(self, pose: Pose, motion: Floats, origin: Floats) -> Floats:
        """Return the motions of blocks from those of bodies: the inverse of `of_bodies`.

        Parameters
        ----------
        pose
            The pose.
        motion
            Of the bodies, shape (6 n_bodies,).
        origin
            Of the bodies, as `origins` gives them.

        Returns
        -------
        Floats
            Shape (n_blocks, 6), about the displaced centroids.
        """
        own = np.flatnonzero(self.body >= 0)
        v = motion.reshape(-1, 6)[self.body[own]]
        arm = (self.assembly.centroid + pose.displacement)[own] - origin[self.body[own]]
        twist = np.zeros((self.assembly.n_blocks, 6))
        spin = v[:, 3:] / self.length
        twist[own] = np.hstack([v[:, :3] + np.cross(spin, arm), spin])
        return twist

    def shifted(self, pose: Pose, motion: Floats, origin: Floats) -> Pose:
        """Return the pose after finite rotations and displacements of the bodies.

        Parameters
        ----------
        pose
            Where they start.
        motion, origin
            As in `of_blocks`; the rotations are finite.

        Returns
        -------
        Pose
            Of all blocks.
        """
        own = np.flatnonzero(self.body >= 0)
        step = motion.reshape(-1, 6)
        turn = turned(step[:, 3:] / self.length)
        at = self.body[own]
        arm = (self.assembly.centroid + pose.displacement)[own] - origin[at]
        rotation, displacement = pose.rotation.copy(), pose.displacement.copy()
        rotation[own] = turn[at] @ rotation[own]
        displacement[own] += step[at, :3] + np.einsum("nij,nj->ni", turn[at], arm) - arm
        return Pose(rotation, displacement)

    @property
    def length(self) -> float:
        """The unit of rotations [m]."""
        return float(self.assembly.size.mean())

    def _system(self, pose: Pose, parameter: float, motion: Floats) -> _System:
        """Residuals of all equations and their rates; the motion tells where joints slide that dilate."""
        stuck, slid = self._between
        contacts, origin = self.contacts, self.origins(pose)
        both = sides(self.assembly, contacts, pose, parameter)
        apart = both[:, 1] - both[:, 0]
        driven = contacts.drive[:, 1] - contacts.drive[:, 0]
        normal, valid = roles(contacts, pose, both)
        which, role = np.nonzero(valid[slid])
        slid, across = slid[which], normal[slid[which], role]
        # A corner of a moves with a against the face of b and the reverse: both are taken where that corner is.
        place = both[slid, np.where(role == 1, 1, 0)]
        if (role == 2).any():
            place[role == 2] = crossings(contacts, pose, both)[0].mean(axis=1)[slid[role == 2]]
        gap = np.einsum("ni,ni->n", across, apart[slid])
        if self.dilates:
            across, gap = across - self._dilatancy(pose, slid, place, across, motion), 0.0 * gap
        pins = rates(
            self.body, contacts.pair[np.repeat(stuck, 3)], np.tile(np.eye(3), (len(stuck), 1)),
            (np.repeat(both[stuck, 0], 3, axis=0), np.repeat(both[stuck, 1], 3, axis=0)), origin,
        )  # fmt: skip
        slides = rates(self.body, contacts.pair[slid], across, (place, place), origin)
        residual = [apart[stuck].reshape(-1), gap]
        rate = [-driven[stuck].reshape(-1), -np.einsum("ni,ni->n", across, driven[slid])]
        parts = [pins, slides]
        if len(self.ties):
            row, length = self.tie_rows(pose, origin)
            parts.append(row)
            residual.append(length)
            rate.append(np.zeros(len(length)))
        if self.control is not None:
            parts.append(self.control.row(self.assembly, pose, self.body, origin))
            residual.append(np.array([self.control.value(self.assembly, pose) - parameter]))
            rate.append(np.ones(1))
        matrix = as_matrix(parts, self.n_bodies, self.length)
        return _System(matrix, np.concatenate(residual), np.concatenate(rate), origin)

    def _dilatancy(self, pose: Pose, rows: Ints, place: Floats, normal: Floats, motion: Floats) -> Floats:
        """Friction times the direction of slip of contacts that slide, shape (n, 3)."""
        velocity = []
        for block in self.contacts.pair[rows].T:
            arm = place - (self.assembly.centroid + pose.displacement)[block]
            velocity.append(motion[block, :3] + np.cross(motion[block, 3:], arm))
        slip = velocity[1] - velocity[0]
        slip = slip - np.einsum("ni,ni->n", slip, normal)[:, None] * normal
        size = np.linalg.norm(slip, axis=1)[:, None]
        along: Floats = self.contacts.friction[rows, None] * slip / np.where(size > 0, size, 1.0)
        return along

    def tie_rows(self, pose: Pose, origin: Floats) -> tuple[Rows, Floats]:
        """Return how fast the ties whose length stays would lengthen, and how much longer they are.

        Parameters
        ----------
        pose, origin
            As in `of_blocks`.

        Returns
        -------
        rows : Rows
            One for each tie.
        longer : Floats
            Shape (n,) [m].
        """
        ties = [self.assembly.ties[k] for k in self.ties]
        blocks = [self.assembly.blocks_named(tie.between, tie.label) for tie in ties]
        pair = np.array(blocks, dtype=np.int64).reshape(-1, 2)
        ends = np.array([tie.points for tie in ties], dtype=float).reshape(-1, 2, 3)
        now = [places(self.assembly, pose, pair[:, k], ends[:, k]) for k in (0, 1)]
        line = now[1] - now[0]
        length = np.linalg.norm(line, axis=1)
        rows = rates(self.body, pair, line / length[:, None], (now[0], now[1]), origin)
        return rows, length - np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)

    def _distance(
        self, start: Pose, now: Pose, along: Floats, distance: float, origin: Floats
    ) -> tuple[Floats | sparse.csr_array, float]:
        """How far a pose is from where it is to be along a motion of the centroids."""
        every = np.arange(self.assembly.n_blocks)
        place = self.assembly.centroid + now.displacement
        row = summed(rates(self.body, np.column_stack([0 * every - 1, every]), along[:, :3], (place, place), origin))
        done = float((along[:, :3] * (now.displacement - start.displacement)).sum())
        return as_matrix([row], self.n_bodies, self.length), distance - done


@dataclass(frozen=True, eq=False)
class _System:
    """The linearised equations of a linkage at a pose: matrix @ motion = rate x (rate of the parameter)."""

    matrix: Floats | sparse.csr_array
    residual: Floats
    rate: Floats
    origin: Floats


def _spans(points: Floats) -> bool:
    """Whether points do not all lie on one line."""
    if len(points) < 3:
        return False
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(values[1] > 1e-6 * values[0])


def _least_change(matrix: Any, lacking: Floats) -> Floats:
    """The shortest x with matrix @ x next to what is lacking."""
    rows, unknowns = matrix.shape
    if not rows or not unknowns:
        return np.zeros(unknowns)
    if isinstance(matrix, np.ndarray):
        found: Any = np.linalg.lstsq(matrix, lacking, rcond=1e-11)[0]
        return found
    from scipy.sparse.linalg import splu

    normal = (matrix.T @ matrix).tocsc()
    ridge = 1e-12 * float(normal.diagonal().max())
    factor = splu(sparse.csc_matrix(normal + ridge * sparse.eye_array(unknowns)))
    x = np.zeros(unknowns)
    for _ in range(3):
        x = x + factor.solve(matrix.T @ (lacking - matrix @ x))
    return x
