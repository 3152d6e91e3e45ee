"""What a structure does where no forces balance it: it moves at constant displacement until a joint shuts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.geometry.polyhedron import point_velocity
from blockstat.large_displacement.contacts import closed_again, crossings, gaps, roles, sides
from blockstat.large_displacement.linkage import Linkage
from blockstat.large_displacement.pose import Pose, displaced
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Contacts that move apart at less than this, where the fastest corner moves at 1, stay together: what solvers leave.
STILL = 1e-4
#: Largest step, and where no joint has shut the blocks are said to fall, both relative to the size of the assembly.
STEP, FALLEN = 0.01, 0.5
#: A gap below this, relative to the size of the blocks, is closed.
SHUT = 1e-9


class NoRootError(ArithmeticError):
    """A change of sign that was seen is not where it was seen."""


@dataclass(frozen=True, eq=False)
class Landing:
    """Where a jump leads."""

    linkage: Linkage | None  #: with the contacts that have closed stuck; None where nothing stops the fall
    pose: Pose
    opened: list[int]  #: joints that open
    shut: list[int]  #: joints that shut
    fell: bool = False  #: whether the fall was followed so far that nothing can stop it; if not, it was lost


def statuses(
    linkage: Linkage,
    pose: Pose,
    parameter: float,
    motion: Floats,
    drive: float = 0.0,
    *,
    still: float = STILL,
    dilates: bool = True,
    lift: Floats | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return which of the contacts that touch stick and which slide under a motion; the others open.

    Parameters
    ----------
    linkage
        Has the contacts that touch.
    pose, parameter
        Where they are.
    motion
        Rates of the blocks about their displaced centroids, shape (n_blocks, 6), of any size.
    drive
        Rate of the supports' movement.
    still
        Contacts that move at less than this stick, where the fastest corner moves at 1.
    dilates
        Whether joints that slide open at the rate of associated friction in this motion.
    lift
        How fast those contacts open that slide, shape (n,), where that is known.

    Returns
    -------
    pinned, sliding : array of bool, shape (n,)
        Of all contacts.
    """
    contacts, closed = linkage.contacts, linkage.pinned | linkage.sliding
    there = displaced(linkage.assembly, pose)
    speed = float(corner_speed(there, motion).max(initial=0.0)) or 1.0
    both = sides(linkage.assembly, contacts, pose, parameter)
    place = crossings(contacts, pose, both)[0].mean(axis=1)
    a, b = (point_velocity(there, motion, contacts.pair[:, k], place) for k in (0, 1))
    apart = (b - a + drive * (contacts.drive[:, 1] - contacts.drive[:, 0])) / speed
    normal, valid = roles(contacts, pose, both)
    along = np.einsum("nij,nj->ni", normal, apart)
    opening = np.where(valid, along, np.inf).min(axis=1)
    slip = np.sqrt(np.maximum((apart**2).sum(axis=1) - opening**2, 0.0))
    moves = (np.abs(apart).max(axis=1) > still) & closed
    rubs = slip > still
    wedged = (
        np.where(dilates & rubs, contacts.friction, 0.0) * np.where(rubs, slip, 0.0) if lift is None else lift / speed
    )
    lifts = opening - np.where(rubs, wedged, 0.0) > still
    return closed & ~moves, moves & ~lifts


def jump(linkage: Linkage, pose: Pose, parameter: float, mode: Floats, rate: Floats) -> Landing:
    """Follow the motion that no forces resist, at constant displacement, until a joint shuts.

    Parameters
    ----------
    linkage
        The mechanism that has come to its limit.
    pose, parameter
        Where it is.
    mode
        The motion that no forces resist there, shape (n_blocks, 6), as `statics.balance` gives it.
    rate
        The motion of the linkage itself for a unit rate of the parameter.

    Returns
    -------
    Landing
        Where it stops.

    Notes
    -----
    The linkage's own motion costs no work under its own multiplier. So that part of the mode that moves the control is
    taken off, and what remains still falls.
    """
    assembly, contacts = linkage.assembly, linkage.contacts
    if linkage.control is not None:
        mode = mode - linkage.control.rate(assembly, pose, mode) * rate
    pinned, sliding = statuses(linkage, pose, parameter, mode)
    opened = contacts.joint[(linkage.pinned | linkage.sliding) & ~pinned & ~sliding]
    loose = replace(linkage, pinned=pinned, sliding=sliding)
    extent = float(np.ptp(assembly.vertices, axis=0).max())
    room, touched = SHUT * float(assembly.size.max()), 0.0
    open_ = ~(pinned | sliding)
    nothing = Landing(None, pose, opened.tolist(), [])
    direction = _unit(assembly, pose, loose.free(pose, parameter, mode))
    step = 1e-3 * STEP * extent
    while touched < FALLEN * extent and direction is not None:
        gap = np.where(open_, gaps(assembly, contacts, pose, parameter), np.inf)

        def at(length: float, pose: Pose = pose, direction: Floats = direction) -> Pose | None:
            distance = length * float((direction[:, :3] ** 2).sum())
            return loose.moved(pose, parameter, length * direction, along=(direction, distance))

        there = at(step)
        if there is None:
            step /= 2
            if step < 1e-9 * extent:
                return nothing
            continue
        now = np.where(open_, gaps(assembly, contacts, there, parameter), np.inf)
        if (now < -room).any():
            found = _meeting(at, lambda p: gaps(assembly, contacts, p, parameter), now < -room, gap > room, step)
            if found is None:
                return nothing
            return _landed(loose, found, parameter, opened.tolist())
        touched, pose = touched + step, there
        direction = _unit(assembly, pose, loose.free(pose, parameter, direction))
        step = min(2 * step, STEP * extent)
    return replace(nothing, fell=touched >= FALLEN * extent)


def root_of(function: Callable[[float], float], low: float, high: float, accuracy: float) -> float:
    """Return where a function changes its sign, by Brent's method.

    Parameters
    ----------
    function
        Of one number.
    low, high
        Between which its sign changes.
    accuracy
        Of the answer.

    Returns
    -------
    float
        The root.

    Raises
    ------
    NoRootError
        When the sign is the same at both ends: what the function stands for could not be followed.
    """
    from scipy.optimize import brentq

    if not function(low) * function(high) <= 0:
        raise NoRootError
    found: Any = brentq(function, low, high, xtol=accuracy)
    return float(found)


def _unit(assembly: Assembly, pose: Pose, motion: Floats) -> Floats | None:
    """A motion whose fastest corner moves at 1; None for none."""
    speed = float(corner_speed(displaced(assembly, pose), motion).max(initial=0.0))
    return motion / speed if speed > 0 else None


def _meeting(
    at: Callable[[float], Pose | None],
    gap: Callable[[Pose], Floats],
    overlap: np.ndarray,
    apart: np.ndarray,
    step: float,
) -> Pose | None:
    """The pose in which the first of some contacts closes; None where they were not open to begin with."""
    if not (apart | ~overlap).all():
        return None
    last = step
    for contact in np.flatnonzero(overlap):

        def of(length: float, contact: int = int(contact)) -> float:
            pose = at(length)
            return -1.0 if pose is None else float(gap(pose)[contact])

        if of(last) < 0:
            last = root_of(of, 0.0, last, 1e-12 * step)
    return at(last)


def _landed(linkage: Linkage, pose: Pose, parameter: float, opened: list[int]) -> Landing:
    """Stick the contacts that have closed."""
    assembly, contacts = linkage.assembly, linkage.contacts
    gap = gaps(assembly, contacts, pose, parameter)
    open_ = ~(linkage.pinned | linkage.sliding)
    met = np.flatnonzero(open_ & (gap <= 10 * SHUT * float(assembly.size.max())))
    held = closed_again(assembly, contacts, met, pose, parameter)
    pinned = linkage.pinned.copy()
    pinned[met] = True
    return Landing(replace(linkage, contacts=held, pinned=pinned), pose, opened, contacts.joint[met].tolist())
