"""The exact kinematics of a linkage: its motion for a unit rate of the parameter, and its pose at a parameter.

The equations of a linkage are

    p_b - p_a = 0         at contacts that stick,
    gap(q) = 0            at contacts that slide,
    |tie| = its length    for ties whose length does not change: that at rest and what they have yielded by,
    control(q) = s        unless the parameter s moves supports.

Newton's method with the least change of the pose solves them for finite rotations. So the pose at s does not depend on
the length of steps unless a joint slides against friction. Directions that the equations leave free, such as that of a
sliding block, are those of the mechanism that the linkage was made from.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.large_displacement.displaced.contact_pairs import edge_crossings, gap_normals, pair_points
from blockstat.large_displacement.displaced.contact_status import STICKING_SPEED
from blockstat.large_displacement.displaced.pose import Pose, displaced_points, free_sizes
from blockstat.large_displacement.displaced.velocity_rows import (
    VelocityRows,
    as_matrix,
    relative_velocity_rows,
    summed,
)
from blockstat.large_displacement.linkage.linkage import Linkage
from blockstat.typing import Floats, Ints

#: Newton's method has converged when all residuals are below this. Relative to the largest free block. A thousand times
#: the rounding of coordinates.
RESIDUAL_TOLERANCE = 1e-12
#: Below this residual Newton's method has converged too if a step hardly reduces it: rounding keeps it above
#: `RESIDUAL_TOLERANCE`. Relative to the largest free block.
STAGNATED_RESIDUAL = 1e3 * RESIDUAL_TOLERANCE
#: A Newton step hardly reduces the residual when it leaves more than this part of it. Chosen: near a solution a step
#: leaves far less.
STAGNATION = 0.25
#: Newton's method diverges when the residual is above the first, or grows and is above the second. Relative to the
#: largest free block. Chosen: a pose is at most a step of that order away.
DIVERGED_RESIDUAL, GROWING_RESIDUAL = 1e3, 1e-3
#: Steps of Newton's method at most. Chosen: it converges quadratically, so where it needs more, the step along the path
#: was too long.
MAX_NEWTON_STEPS = 12
#: A guess is a motion of the linkage when no more than this part of it has to change. Chosen: in a step along a path
#: rates change by less. A mixture of two mechanisms changes by more.
NEAR_GUESS = 0.1
#: The parameter does not move the linkage when the equations of its rates leave more than this. Relative to the rate of
#: the parameter. Chosen: far above rounding.
MAX_RATE_RESIDUAL = 1e-7
#: Singular values below this count as zero in dense least squares. Relative to the largest. Chosen: above rounding, so
#: that redundant equations do not count twice.
RANK_TOLERANCE = 1e-11
#: Diagonal that is added to the normal equations of sparse least squares, relative to their largest, and the number of
#: iterative refinements that remove its effect. Chosen: the shift lets the matrix be factorised where the equations
#: leave directions free.
NORMAL_EQUATIONS_SHIFT, REFINEMENTS = 1e-12, 3


@dataclass(frozen=True, eq=False)
class _Equations:
    """The linearised equations of a linkage at a pose: matrix @ motion = rate * (rate of the parameter)."""

    matrix: Floats | sparse.csr_array  #: shape (n, 6 n_bodies)
    residual: Floats  #: of the equations themselves, shape (n,) [m]
    rate: Floats  #: shape (n,)
    origin: Floats  #: of the bodies, shape (n_bodies, 3) [m]


def tangent(linkage: Linkage, pose: Pose, parameter: float, guess: Floats) -> Floats | None:
    """Return the motion of a linkage for a unit rate of the parameter.

    Parameters
    ----------
    linkage
        The linkage.
    pose
        A pose of it.
    parameter
        Its parameter [m].
    guess
        A motion of all blocks, of any magnitude, shape (n_blocks, 6). Of all motions of the linkage the one next to it
        is returned.

    Returns
    -------
    Floats or None
        About the displaced centroids, shape (n_blocks, 6); None where the parameter does not move the linkage.
    """
    rate = 1.0 if linkage.control is None else linkage.control.rate(linkage.assembly, pose, guess)
    # Scaled to a unit rate of the control, so that free directions keep their part in the motion.
    guess = guess / rate if rate > 0 else guess
    equations = _equations(linkage, pose, parameter, guess)
    start = linkage.body_motions(guess)
    found = start + _least_change(linkage, equations.matrix, equations.rate - equations.matrix @ start, guess=start)
    missing = equations.matrix @ found - equations.rate
    flaw = linkage.flaw_of_rows * np.sqrt(12.0) * float(np.abs(found).max(initial=0.0))  # of the motions of two bodies
    if np.abs(missing).max(initial=0.0) > MAX_RATE_RESIDUAL and _rms(missing) > flaw:
        return None
    return linkage.block_motions(pose, found, equations.origin)


def motion_at_fixed_parameter(linkage: Linkage, pose: Pose, parameter: float, guess: Floats) -> Floats:
    """Return the motion of a linkage next to a given one that leaves the parameter as it is.

    Parameters
    ----------
    linkage, pose, parameter, guess
        As in `tangent`.

    Returns
    -------
    Floats
        About the displaced centroids, shape (n_blocks, 6); zero where the linkage has no such motion.
    """
    equations = _equations(linkage, pose, parameter, guess)
    start = linkage.body_motions(guess)
    found = start - _least_change(linkage, equations.matrix, equations.matrix @ start)
    return linkage.block_motions(pose, found, equations.origin)


def pose_at(
    linkage: Linkage,
    start: Pose,
    parameter: float,
    step: Floats,
    *,
    along: tuple[Floats, float] | None = None,
) -> Pose | None:
    """Return the pose of a linkage at a parameter, by Newton's method.

    Parameters
    ----------
    linkage
        The linkage.
    start
        A pose of it.
    parameter
        Of the pose that is looked for [m].
    step
        Displacements and rotations of all blocks that lead near that pose, shape (n_blocks, 6).
    along
        A motion, shape (n_blocks, 6), and how far along it the pose lies from the start; as an equation beside those of
        the linkage.

    Returns
    -------
    Pose or None
        None where Newton's method does not converge.
    """
    size = float(free_sizes(linkage.assembly).max())
    pose = linkage.moved(start, linkage.body_motions(step), linkage.origins(start))
    best = np.inf
    for _ in range(MAX_NEWTON_STEPS):
        equations = _equations(linkage, pose, parameter, step)
        matrix: Any = equations.matrix
        missing = -equations.residual
        if along is not None:
            row, distance = _distance_along(linkage, start, pose, *along, equations.origin)
            rows: Any = [matrix, row]
            matrix = np.vstack(rows) if isinstance(matrix, np.ndarray) else sparse.vstack(rows)
            missing = np.append(missing, distance)
        error = np.abs(missing).max(initial=0.0)
        known = error <= STAGNATED_RESIDUAL * size or _rms(missing) <= linkage.flaw_of_gaps
        stagnates = known and error > STAGNATION * best
        if error <= RESIDUAL_TOLERANCE * size or stagnates:
            return pose
        grows = error > best and best < np.inf and error > GROWING_RESIDUAL * size
        if not error < DIVERGED_RESIDUAL * size or grows:
            return None
        best = min(best, error)
        guess = linkage.body_motions(step) if along is None else None
        change = _least_change(linkage, matrix, missing, more=int(along is not None), guess=guess)
        pose = linkage.moved(pose, change, equations.origin)
    return None


def tie_rows(linkage: Linkage, pose: Pose, parameter: float, origin: Floats) -> tuple[VelocityRows, Floats, Floats]:
    """Return the rates at which the ties lengthen whose length should not change, and their lengthening.

    Parameters
    ----------
    linkage
        The linkage.
    pose
        The pose.
    parameter
        Its parameter [m].
    origin
        Of the bodies, as `Linkage.origins` gives them.

    Returns
    -------
    rows : VelocityRows
        One for each of `linkage.ties`.
    lengthening : Floats
        Shape (n,) [m].
    rate : Floats
        At which moving supports alone lengthen them, for a unit rate of the parameter, shape (n,).
    """
    assembly, structure = linkage.assembly, linkage.structure
    pose = structure.with_supports(pose, parameter)
    ties = [assembly.ties[k] for k in linkage.ties]
    blocks = [assembly.blocks_named(tie.between, tie.label) for tie in ties]
    pair = np.array(blocks, dtype=np.int64).reshape(-1, 2)
    ends = np.array([tie.points for tie in ties], dtype=float).reshape(-1, 2, 3)
    now = [displaced_points(assembly, pose, pair[:, k], ends[:, k]) for k in (0, 1)]
    length = np.linalg.norm(now[1] - now[0], axis=1)
    along = (now[1] - now[0]) / length[:, None]
    rows = relative_velocity_rows(linkage.body, pair, along, (now[0], now[1]), origin)
    apart = structure.support_motion[pair[:, 1], :3] - structure.support_motion[pair[:, 0], :3]
    own = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    if len(pose.yielded):
        own = own + np.where([tie.strut for tie in ties], -1.0, 1.0) * pose.yielded[linkage.ties]
    return rows, length - own, np.einsum("ni,ni->n", along, apart)


def _equations(linkage: Linkage, pose: Pose, parameter: float, motion: Floats) -> _Equations:
    """Residuals of all equations and their rates; with associated flow the motion gives the directions of slip."""
    assembly, contacts = linkage.assembly, linkage.contacts
    stuck = linkage.between_bodies[0]
    origin = linkage.origins(pose)
    points = pair_points(assembly, contacts, pose, parameter)
    apart = points[:, 1] - points[:, 0]
    driven = contacts.drive[:, 1] - contacts.drive[:, 0]
    slid, across, place = _sliding_normals(linkage, pose, points)
    gap = np.einsum("ni,ni->n", across, apart[slid])
    if linkage.associated:
        across, gap = across - slip_friction(linkage, pose, slid, place, across, motion), 0.0 * gap
    one, two = (np.vstack([np.repeat(points[stuck, side], 3, axis=0), place]) for side in (0, 1))
    pair = contacts.pair[np.append(np.repeat(stuck, 3), slid)]
    normals = np.vstack([np.tile(np.eye(3), (len(stuck), 1)), across])
    residual = [apart[stuck].reshape(-1), gap]
    rate = [-driven[stuck].reshape(-1), -np.einsum("ni,ni->n", across, driven[slid])]
    parts = [relative_velocity_rows(linkage.body, pair, normals, (one, two), origin)]
    if len(linkage.ties):
        row, lengthening, by_supports = tie_rows(linkage, pose, parameter, origin)
        parts.append(row)
        residual.append(lengthening)
        rate.append(-by_supports)
    if linkage.control is not None:
        parts.append(linkage.control.row(assembly, pose, linkage.body, origin))
        residual.append(np.array([linkage.control.value(assembly, pose) - parameter]))
        rate.append(np.ones(1))
    matrix = as_matrix(parts, linkage.n_bodies, linkage.length)
    return _Equations(matrix, np.concatenate(residual), np.concatenate(rate), origin)


def _sliding_normals(linkage: Linkage, pose: Pose, points: Floats) -> tuple[Ints, Floats, Floats]:
    """Contacts that slide, the normal of each of their gaps and where it is measured; (n,), (n, 3), (n, 3)."""
    contacts, slid = linkage.contacts, linkage.between_bodies[1]
    normal, valid = gap_normals(contacts, pose, points)
    which, kind = np.nonzero(valid[slid])
    slid, across = slid[which], normal[slid[which], kind]
    # A corner of a moves with a against the face of b, and the reverse: the velocities of both are taken at the corner.
    place = points[slid, np.where(kind == 1, 1, 0)]
    if (kind == 2).any():
        place[kind == 2] = edge_crossings(contacts, pose, points)[0].mean(axis=1)[slid[kind == 2]]
    return slid, across, place


def slip_friction(linkage: Linkage, pose: Pose, rows: Ints, place: Floats, normal: Floats, motion: Floats) -> Floats:
    """Return friction times the direction of slip of contacts.

    Parameters
    ----------
    linkage, pose
        The linkage, and where it is.
    rows
        Numbers of the contacts, shape (n,).
    place
        Where they are, shape (n, 3) [m].
    normal
        Their unit normals, shape (n, 3).
    motion
        Of any magnitude, shape (n_blocks, 6).

    Returns
    -------
    Floats
        Shape (n, 3): mu t, with t the unit vector along the slip of b over a, or zero where there is none.
    """
    velocity = []
    for block in linkage.contacts.pair[rows].T:
        arm = place - pose.centroids(linkage.assembly)[block]
        velocity.append(motion[block, :3] + np.cross(motion[block, 3:], arm))
    slip = velocity[1] - velocity[0]
    slip = slip - np.einsum("ni,ni->n", slip, normal)[:, None] * normal
    size = np.linalg.norm(slip, axis=1)[:, None]
    along: Floats = linkage.contacts.friction[rows, None] * slip / np.where(size > 0, size, 1.0)
    return along


def _distance_along(
    linkage: Linkage, start: Pose, now: Pose, along: Floats, distance: float, origin: Floats
) -> tuple[Floats | sparse.csr_array, float]:
    """The rate of the distance along a motion of the centroids as a row, and the distance that is missing."""
    every = np.arange(linkage.assembly.n_blocks)
    place = now.centroids(linkage.assembly)
    pair = np.column_stack([0 * every - 1, every])
    row = summed(relative_velocity_rows(linkage.body, pair, along[:, :3], (place, place), origin))
    done = float((along[:, :3] * (now.displacement - start.displacement)).sum())
    return as_matrix([row], linkage.n_bodies, linkage.length), distance - done


def _rms(residual: Floats) -> float:
    """The root of the mean square of residuals: least squares make it no larger than that of any other motion."""
    return float(np.sqrt(np.mean(residual**2))) if len(residual) else 0.0


def _change_along(contacts: Floats, control: Floats, missing: Floats, guess: Floats, rank: float) -> Floats | None:
    """The shortest change of the contacts and ties, and so much more of the guess's motion as the control asks for.

    Where the equations leave directions free, the shortest change that moves a control in a corner turns the block
    about the vertical, each time in the same sense. None where no direction is free beside the motion, which is then
    known without the guess, and where the guess is no motion of the linkage (`NEAR_GUESS`).
    """
    change, _, independent, _ = np.linalg.lstsq(contacts, missing[: len(contacts)], rcond=rank)
    if independent > len(guess) - 2:
        return None
    motion = guess - np.linalg.lstsq(contacts, contacts @ guess, rcond=rank)[0]
    rate = float(control @ motion)
    if not (rate and np.linalg.norm(motion - guess) <= NEAR_GUESS * np.linalg.norm(guess)):
        return None
    found: Floats = change + (float(missing[len(contacts)]) - float(control @ change)) / rate * motion
    return found


def _least_change(
    linkage: Linkage, matrix: Any, missing: Floats, *, more: int = 0, guess: Floats | None = None
) -> Floats:
    """The shortest x that minimises |matrix @ x - missing| of the contacts and ties.

    The last row is that of the control, if there is one, and `more` rows follow it. These are no contacts, so they are
    kept exactly, unless the matrix is sparse. Each other row is off by the flaw, so the singular values are by
    flaw sqrt(rows) at most (Weyl). Rows are as long as a unit normal at least, so the largest singular value is no less
    than sqrt(rows / unknowns). Relative to it, those below flaw sqrt(unknowns) may be zero. Rows n - mu t of associated
    flow are off by mu times the turn of t as well, which is known to the speed below which contacts stick. Without it
    the five or more corners of a joint in one plane would hold a block that slides by rounding.
    """
    rows, unknowns = matrix.shape
    if not rows or not unknowns:
        return np.zeros(unknowns)
    friction = linkage.contacts.friction[linkage.sliding] if linkage.associated else np.zeros(0)
    flaw = linkage.flaw_of_rows + STICKING_SPEED * float(friction.max(initial=0.0))
    rank = max(RANK_TOLERANCE, flaw * np.sqrt(unknowns))
    if isinstance(matrix, np.ndarray):
        contacts, kept = np.split(matrix, [rows - more - (linkage.control is not None)])
        if guess is not None and linkage.control is not None:
            onwards = _change_along(contacts, kept[0], missing, guess, rank)
            if onwards is not None:
                return onwards
        start = np.linalg.lstsq(kept, missing[len(contacts) :], rcond=RANK_TOLERANCE)[0]
        directions = np.linalg.qr(kept.T)[0]
        across = contacts - (contacts @ directions) @ directions.T
        found: Any = start + np.linalg.lstsq(across, missing[: len(contacts)] - contacts @ start, rcond=rank)[0]
        return found
    from scipy.sparse.linalg import splu

    normal = (matrix.T @ matrix).tocsc()
    shift = max(NORMAL_EQUATIONS_SHIFT, rank**2) * float(normal.diagonal().max())
    factor = splu(sparse.csc_matrix(normal + shift * sparse.eye_array(unknowns)))
    x = np.zeros(unknowns)
    for _ in range(REFINEMENTS):
        x = x + factor.solve(matrix.T @ (missing - matrix @ x))
    return x
