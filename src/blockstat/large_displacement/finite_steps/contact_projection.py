"""Projection of a pose onto zero gap: the contacts that a finite step has left open or overlapping are closed again.

A step of finite length along a mechanism rotates blocks. Contacts that stay closed by their rates are then open or
overlap by a distance of second order in the step, and contacts that slide with associated flow are open by friction
times slip. The nearest pose that closes them, in the least squares where not all can be closed, is a quadratic program
in the motions u of the rigid bodies:

    min |g + N u|^2 + |t + T u|^2 + |min(gap + G u, 0)|^2 + ridge |u|^2    subject to    c'u = 0.

Here g are the gaps of closed contacts and t the slips of those that stick, both zero at the wanted pose; gap are the
gaps of all contacts that are near; c'u is the work of the live load, if there is one. Overlaps are squares and no
inequalities: where joints overlap by rounding all round a block, no motion is inside all inequalities, and a solver
answers with one of any size. Rotations are finite, so the program is solved a few times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from blockstat.large_displacement.displaced.contact_pairs import ZERO_GAP, gap_normals, gaps, pair_points
from blockstat.large_displacement.displaced.control import Control
from blockstat.large_displacement.displaced.pose import Pose, free_sizes
from blockstat.large_displacement.displaced.velocity_rows import VelocityRows, as_matrix, relative_velocity_rows
from blockstat.large_displacement.linkage.kinematics import tie_rows
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.linear_algebra.factor import make_factor
from blockstat.typing import Floats, Ints

#: Weight of the square of the motion beside the squares of gaps and slips, whose rates are about one. Chosen: the least
#: motion is taken of several that close the contacts, and gaps stay a millionth of it.
MOTION_WEIGHT = 1e-6
#: Programs at most. Chosen: each leaves an error of second order in that of the one before.
MAX_PROGRAMS = 5
#: An error that is not below this share of the one before is what no motion takes away. Chosen: one of second order
#: would be far below.
AT_THE_RESIDUAL = 0.5
#: Changes of the contacts that overlap, at most. Chosen: few are on the way to the minimum.
MAX_OVERLAP_CHANGES = 20


@dataclass(frozen=True, eq=False)
class Projection:
    """A pose in which contacts are closed as far as they can be."""

    pose: Pose
    residual_gap: Floats  #: magnitude of the gap of each closed contact, zero for open ones, shape (n_contacts,) [m]


def projected_onto_zero_gap(
    linkage: Linkage, pose: Pose, parameter: float, reach: float, held: Control | None, target: float
) -> Projection:
    """Find the pose next to a given one that closes the contacts of a linkage and lets no others overlap.

    Parameters
    ----------
    linkage
        Its contacts that stick and slide are those to be closed.
    pose, parameter
        Where a step has led.
    reach
        Contacts whose gap is larger than this stay open [m].
    held
        The displacement that does not change; None where none is held.
    target
        Its value [m].

    Returns
    -------
    Projection
        Of all poses found, the one with the smallest residual.
    """
    size = float(free_sizes(linkage.assembly).max())
    best, least = pose, np.inf
    for solved in range(MAX_PROGRAMS + 1):
        rows = _ContactRows(linkage, pose, parameter, reach)
        before, least = least, min(rows.error, least)
        if rows.error < before:
            best = pose
        if rows.error <= ZERO_GAP * size or rows.error > AT_THE_RESIDUAL * before or solved == MAX_PROGRAMS:
            break
        motion = _closing_motion(linkage, pose, rows, held, target)
        if motion is None:
            break
        pose = linkage.moved(pose, motion, rows.origin)
    left = np.where(linkage.closed, np.abs(gaps(linkage.assembly, linkage.contacts, best, parameter)), 0.0)
    return Projection(best, left)


class _ContactRows:
    """Rates of gaps of near contacts between bodies, of slips of those that stick and of lengths of ties at a pose."""

    def __init__(self, linkage: Linkage, pose: Pose, parameter: float, reach: float) -> None:
        contacts = linkage.contacts
        self.origin = linkage.origins(pose)
        points = pair_points(linkage.assembly, contacts, pose, parameter)
        apart = points[:, 1] - points[:, 0]
        normal, valid = gap_normals(contacts, pose, points)
        between = linkage.may_part
        which, kind = np.nonzero(valid & between[:, None])
        across = normal[which, kind]
        place = points[which, np.where(kind == 1, 1, 0)]
        gap = np.einsum("ni,ni->n", across, apart[which])
        near = gap < reach
        pair, gap = contacts.pair[which[near]], gap[near]
        self.gap = gap
        self.gap_rates = relative_velocity_rows(
            linkage.body, pair, across[near], (place[near], place[near]), self.origin
        )
        self.closed = linkage.closed[which[near]]
        sticking = np.flatnonzero(linkage.sticking & between)
        self.slip_rates, self.slip = self._slips(linkage, sticking, points, normal, valid)
        self.tie_rates, self.lengthening, _ = tie_rows(linkage, pose, parameter, self.origin)

    def _slips(
        self, linkage: Linkage, rows: Ints, points: Floats, normal: Floats, valid: np.ndarray
    ) -> tuple[VelocityRows, Floats]:
        """Rates of the two components of slip of contacts, and the components, shape (2 n,) [m]."""
        n = normal[rows, np.argmax(valid[rows], axis=1)]
        least = np.eye(3)[np.abs(n).argmin(axis=1)]
        one: Floats = np.cross(n, least)
        one /= np.linalg.norm(one, axis=1)[:, None]
        tangents: Floats = np.stack([one, np.cross(n, one)], axis=1)
        middle = np.repeat(points[rows].mean(axis=1), 2, axis=0)
        pair = np.repeat(linkage.contacts.pair[rows], 2, axis=0)
        slip = np.einsum("nki,ni->nk", tangents, points[rows, 1] - points[rows, 0]).reshape(-1)
        directions = tangents.reshape(-1, 3)
        return relative_velocity_rows(linkage.body, pair, directions, (middle, middle), self.origin), slip

    @property
    def error(self) -> float:
        """The largest gap of a closed contact, slip of a sticking one, lengthening of a tie, or overlap [m]."""
        parts = [np.abs(self.gap[self.closed]), np.abs(self.slip), np.abs(self.lengthening), -self.gap]
        return max(float(part.max(initial=0.0)) for part in parts)


def _closing_motion(
    linkage: Linkage, pose: Pose, rows: _ContactRows, held: Control | None, target: float
) -> Floats | None:
    """The motion of the bodies that closes contacts, shape (6 n_bodies,) [m]; None where none is found.

    The objective is quadratic between changes of the contacts that overlap. So each minimum with the overlaps of the
    one before is a system of equations, and the minimum is found where these stay the same.
    """
    n, length = linkage.n_bodies, linkage.length
    if not n:  # all blocks stick to supports at rest
        return None
    near = sparse.csr_array(as_matrix([rows.gap_rates], n, length))
    others = sparse.csr_array(as_matrix([rows.slip_rates, rows.tie_rates], n, length))
    fixed = others.T @ others + MOTION_WEIGHT * sparse.eye_array(6 * n)
    pull = -(others.T @ np.concatenate([rows.slip, rows.lengthening]))
    counts, motion = rows.closed | (rows.gap < 0), np.zeros(6 * n)
    away, row = 0.0, None
    if held is not None:
        away = target - held.value(linkage.assembly, pose)
        row = as_matrix([held.row(linkage.assembly, pose, linkage.body, rows.origin)], n, length)
        row = np.asarray(sparse.csr_array(row).todense())[0]
    for _ in range(MAX_OVERLAP_CHANGES):
        own = near[np.flatnonzero(counts)]
        factor = make_factor()
        try:
            factor.update(sparse.csr_array(sparse.triu(fixed + own.T @ own)))
        except ArithmeticError:
            return None
        motion = factor.solve(pull - own.T @ rows.gap[counts])
        if row is not None:
            along = factor.solve(row)
            motion = motion + (away - row @ motion) / (row @ along) * along
        now = rows.closed | (rows.gap + near @ motion < 0)
        if (now == counts).all():
            break
        counts = now
    return motion if np.isfinite(motion).all() else None
