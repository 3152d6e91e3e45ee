"""Places that finite steps lead to: the limit state there, and how what a step has left open or overlapping is closed.

A step of finite length along a mechanism turns blocks, so contacts that stay shut by their rates are open or overlap by
a part of second order in the step, and those that slide with associated friction are open by friction times slip. The
pose next to it that closes them, in the least squares where not all can be closed, is a quadratic program in the
motions of the bodies:

    min |g + N u|^2 + |t + T u|^2 + ridge |u|^2    subject to    gap + G u >= 0,    c'u = 0,

g and t the gaps of contacts that stay shut and the slip of those that stick, gap that of all contacts that are near,
and c'u the work of the live load, if there is one. It is solved a few times, as rotations are finite.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.contacts import Contacts, gaps, roles, sides
from blockstat.large_displacement.jump import STILL, statuses
from blockstat.large_displacement.linkage import Control, Linkage, Rows, as_matrix, rates
from blockstat.large_displacement.loading import Structure
from blockstat.large_displacement.pose import Pose, displaced
from blockstat.large_displacement.sliding import taken
from blockstat.large_displacement.statics import Limited, as_bodies, limited
from blockstat.solve import clarabel
from blockstat.typing import Floats, Ints

#: Of the squares of the motion, beside those of the rows, whose entries are about one: so the least motion is taken.
RIDGE = 1e-6
#: Programs at most, and a gap that is closed, relative to the size of the blocks.
PASSES, CLOSED = 5, 1e-9
#: Joints within bodies move by less than this, where the fastest moves at 1; then each block is one.
COARSE, FINER = (3e-3, 1e-3), (3e-4, 1e-4)
#: How well programs of bodies are solved, and those that tell whether they hold: their errors add over hundreds of
#: blocks, so a few digits are not enough.
ROUGHLY = 1e-8
#: Where nothing is known yet.
NOTHING = Limited(None, np.empty((0, 6)), None)


@dataclass(frozen=True, eq=False)
class Place:
    """Where the blocks are, what touches, and the limit state there."""

    structure: Structure  #: in which what has left is at rest
    linkage: Linkage  #: its contacts that stick are all that touch
    pose: Pose
    parameter: float  #: displacement of the control, or movement of the supports [m]
    limit: Limited
    open: float  #: how far contacts are open that count as touching [m]
    bodies: Ints | None  #: body of each block, -1 for those that do not move; None where each block is one

    @property
    def where(self) -> tuple[Structure, Contacts, np.ndarray, Pose, float]:
        """What a limit analysis there asks for."""
        return self.structure, self.linkage.contacts, self.linkage.pinned, self.pose, self.parameter

    @property
    def drive(self) -> float:
        """Rate of the supports in the motion of the limit state: they rest while blocks fall."""
        return float(self.linkage.control is None and self.limit.multiplier is not None)

    def moving(self) -> Linkage:
        """The linkage of what sticks and slides in the motion of the limit state."""
        where, still = (self.linkage, self.pose, self.parameter), STILL if self.bodies is None else COARSE[0]
        pinned, sliding = statuses(*where, self.limit.motion, self.drive, still=still, lift=self.limit.lift)
        return replace(self.linkage, pinned=pinned, sliding=sliding)

    def speed(self) -> float:
        """That of the fastest corner in the motion of the limit state, or of the supports."""
        corners = corner_speed(displaced(self.linkage.assembly, self.pose), self.limit.motion)
        return max(float(corners.max(initial=0.0)), self.drive)

    def touching(self) -> set[int]:
        """The joints that touch somewhere."""
        return set(self.linkage.contacts.joint[self.linkage.pinned].tolist())


def of_bodies(place: Place, guess: Floats | None, bodies: Ints | None) -> Place:
    """A place with the limit state of bodies, or of smaller ones where they lock each other."""

    def limit(bodies: Ints | None) -> Limited:
        accuracy = 0.0 if bodies is None else ROUGHLY
        return limited(*place.where, dilates=place.linkage.dilates, guess=guess, bodies=bodies, accuracy=accuracy)

    found = limit(bodies)
    if found.multiplier == np.inf and guess is not None:
        bodies = as_bodies(*place.where, guess, COARSE[-1])
        found = limit(bodies)
    if found.multiplier == np.inf:
        found, bodies = limit(None), None
    return replace(place, limit=found, bodies=bodies)


def of_blocks(place: Place) -> Limited:
    """The limit state of all blocks, where joints slide as those of bodies."""
    dilates, guess = place.linkage.dilates, place.limit.motion
    return limited(*place.where, dilates=dilates, guess=guess, limits=(1, 0.0), accuracy=ROUGHLY)


def for_unit(linkage: Linkage, pose: Pose, motion: Floats) -> Floats:
    """A motion for a unit rate of the control, or of the fastest corner where the control hardly moves on."""
    if linkage.control is None:
        return motion
    speed = float(corner_speed(displaced(linkage.assembly, pose), motion).max())
    rate = linkage.control.rate(linkage.assembly, pose, motion)
    return motion / (rate if rate > 1e-6 * speed else speed)


def refined(bodies: Ints, others: Ints) -> Ints:
    """Bodies of blocks that are one body in both; -1 where they move in neither."""
    _, number = np.unique(np.column_stack([bodies, others]), axis=0, return_inverse=True)
    number = np.where((bodies < 0) & (others < 0), -1, number.reshape(-1))
    return np.unique(np.append(number, -1), return_inverse=True)[1][:-1] - 1


def without(place: Place, blocks: Ints) -> tuple[Structure, Linkage, Pose] | None:
    """The structure without blocks; None where most of the control is on them, or nothing else is left that moves."""
    assembly, control = place.structure.assembly, place.linkage.control
    assert control is not None
    gone = np.zeros(assembly.n_blocks, dtype=bool)
    gone[blocks] = True
    support = assembly.support | gone
    weight = np.linalg.norm(control.along, axis=1)
    if support.all() or weight[gone[control.block]].sum() > 0.5 * weight.sum():
        return None
    structure = replace(place.structure, assembly=replace(assembly, support=support))
    contacts = place.linkage.contacts
    kept = np.flatnonzero(~gone[contacts.pair].any(axis=1))
    linkage = replace(
        place.linkage, assembly=structure.assembly, contacts=taken(contacts, kept),
        pinned=place.linkage.pinned[kept], sliding=place.linkage.sliding[kept],
    )  # fmt: skip
    return structure, linkage, place.pose


@dataclass(frozen=True, eq=False)
class Closing:
    """A pose in which contacts are closed as far as they can be."""

    pose: Pose
    open: Floats  #: how far contacts that should touch are open still, or slip where they stick, shape (n,) [m]


def closed_up(
    linkage: Linkage, pose: Pose, parameter: float, reach: float, held: Control | None, target: float
) -> Closing:
    """Find the pose next to a given one that closes the contacts of a linkage and lets no others overlap.

    Parameters
    ----------
    linkage
        Its contacts that stick and slide are those to be closed.
    pose, parameter
        Where a step has led.
    reach
        Contacts that are open by more than this stay open [m].
    held
        The displacement that is not to change; None where none is held.
    target
        What it is [m].

    Returns
    -------
    Closing
        The pose, and what is left open.
    """
    size = float(linkage.assembly.size.max())
    shut = linkage.pinned | linkage.sliding
    best, least = pose, np.inf
    for trial in range(PASSES + 1):
        rows = _Near(linkage, pose, parameter, reach)
        if rows.error < least:
            best, least = pose, rows.error
        if rows.error <= CLOSED * size or trial == PASSES:
            break
        motion = _least_squares(linkage, pose, rows, held, target)
        if motion is None:
            break
        pose = linkage.shifted(pose, motion, rows.origin)
    left = np.where(shut, np.abs(gaps(linkage.assembly, linkage.contacts, best, parameter)), 0.0)
    return Closing(best, left)


class _Near:
    """Rates of gaps of near contacts between bodies, of slips of those that stick and of ties' lengths, at a pose."""

    def __init__(self, linkage: Linkage, pose: Pose, parameter: float, reach: float) -> None:
        contacts, assembly = linkage.contacts, linkage.assembly
        self.origin = linkage.origins(pose)
        both = sides(assembly, contacts, pose, parameter)
        apart = both[:, 1] - both[:, 0]
        normal, valid = roles(contacts, pose, both)
        body = linkage.body[contacts.pair]
        between = body[:, 0] != body[:, 1]
        which, role = np.nonzero(valid & between[:, None])
        across = normal[which, role]
        place = both[which, np.where(role == 1, 1, 0)]
        gap = np.einsum("ni,ni->n", across, apart[which])
        near = gap < reach
        self.which, self.gap = which[near], gap[near]
        self.gaps = rates(
            linkage.body, contacts.pair[self.which], across[near], (place[near], place[near]), self.origin
        )
        self.shut = (linkage.pinned | linkage.sliding)[self.which]
        self.slips, self.slip = self._slips(linkage, np.flatnonzero(linkage.pinned & between), both, normal, valid)
        self.ties, self.longer = linkage.tie_rows(pose, self.origin)

    def _slips(
        self, linkage: Linkage, rows: Ints, both: Floats, normal: Floats, valid: np.ndarray
    ) -> tuple[Rows, Floats]:
        n = normal[rows, np.argmax(valid[rows], axis=1)]
        least = np.eye(3)[np.abs(n).argmin(axis=1)]
        one: Floats = np.cross(n, least)
        one /= np.linalg.norm(one, axis=1)[:, None]
        tangents: Floats = np.stack([one, np.cross(n, one)], axis=1)
        middle = np.repeat(both[rows].mean(axis=1), 2, axis=0)
        pair = np.repeat(linkage.contacts.pair[rows], 2, axis=0)
        slip = np.einsum("nki,ni->nk", tangents, both[rows, 1] - both[rows, 0]).reshape(-1)
        return rates(linkage.body, pair, tangents.reshape(-1, 3), (middle, middle), self.origin), slip

    @property
    def error(self) -> float:
        """The largest gap, slip or lengthening of a tie that should be none, or overlap [m]."""
        parts = [np.abs(self.gap[self.shut]), np.abs(self.slip), np.abs(self.longer), -self.gap]
        return max(float(part.max(initial=0.0)) for part in parts)


def _least_squares(linkage: Linkage, pose: Pose, rows: _Near, held: Control | None, target: float) -> Floats | None:
    """The motion of the bodies that closes contacts, shape (6 n_bodies,); None where the program has no answer."""
    n, length = linkage.n_bodies, linkage.length
    near = sparse.csc_array(as_matrix([rows.gaps], n, length))
    others = sparse.csc_array(as_matrix([rows.slips, rows.ties], n, length))
    wanted = sparse.csc_array(sparse.vstack([near[np.flatnonzero(rows.shut)], others]))
    missing = -np.concatenate([rows.gap[rows.shut], rows.slip, rows.longer])
    unit = max(rows.error, 1e-300)  # in gaps of about one
    constraint, bound, cones = -near, rows.gap / unit, _cones(len(rows.gap), held)
    if held is not None:
        row = held.row(linkage.assembly, pose, linkage.body, rows.origin)
        constraint = sparse.csc_array(sparse.vstack([sparse.csc_array(as_matrix([row], n, length)), -near]))
        bound = np.append((target - held.value(linkage.assembly, pose)) / unit, bound)
    square = sparse.csc_array(sparse.triu(wanted.T @ wanted + RIDGE * sparse.eye_array(6 * n)))
    answer = clarabel.run(square, -(wanted.T @ missing) / unit, constraint, bound, cones)
    motion = np.array(answer.x) * unit
    return motion if np.isfinite(motion).all() and str(answer.status) in ("Solved", "AlmostSolved") else None


def _cones(number: int, held: Control | None) -> list:
    """One equation, if a displacement is held, and so many inequalities."""
    solver: Any = importlib.import_module("clarabel")
    return [*([] if held is None else [solver.ZeroConeT(1)]), *([solver.NonnegativeConeT(number)] if number else [])]
