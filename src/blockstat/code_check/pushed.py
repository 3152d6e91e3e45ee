"""Whether the load of a limit is the acceleration of all that has mass, which the code checks ask for.

The contact forces of a limit balance the weight, the permanent loads and the multiple of its load. So they tell what
acts beside the weight, and what is left of it beside the acceleration must be the permanent loads.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.limit_load import LimitLoad
from blockstat.analysis.problem import Loads, checked_loads
from blockstat.contact.cells import centres
from blockstat.errors import InputError, check_positive
from blockstat.large_displacement.displaced.pose import Pose, displaced_points
from blockstat.loads import WeightedLoads, acceleration, three
from blockstat.program.ties import tie_wrenches
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

G = 9.81  #: unit of ground accelerations [m/s2]
#: Gravity of a scene is an acceleration from there to there, in units of `G`. Chosen: a vertical component of an
#: earthquake changes it by less, and another unit of length or of force by more.
LEAST_GRAVITY, MOST_GRAVITY = 0.5, 1.5
#: Forces of a limit balance its loads to this part of the load of each block, the certificate of its lower bound to
#: much less; and to this part of what a block passes on, which is rounding.
BALANCE, ROUNDING = 1e-5, 1e-12


def gravity_of(assembly: Assembly) -> tuple[float, tuple[str, ...]]:
    """Return the acceleration that the multipliers of a scene are in units of.

    Parameters
    ----------
    assembly : Assembly
        The blocks.

    Returns
    -------
    strength : float
        The gravity of the scene [m/s2]; that of the earth where it is far from it, as with gravity 1 and densities that
        are unit weights.
    warnings : tuple of str
        That it was taken so.
    """
    strength = float(np.linalg.norm(assembly.gravity))
    if LEAST_GRAVITY * G <= strength <= MOST_GRAVITY * G:
        return strength, ()
    return G, (
        f"gravity is {strength:.6g}, which is taken as {G:g} m/s2 in other units; coordinates must be in metres",
    )


def check_metres(assembly: Assembly) -> None:
    """Check that a scene is in metres, as spectra and displacements are.

    Parameters
    ----------
    assembly : Assembly
        The blocks.

    Raises
    ------
    InputError
        For a gravity above `MOST_GRAVITY` times `G`: that of a smaller unit of length, such as 9810 mm/s2. One that is
        far below, as 1 with densities that are unit weights, says nothing about lengths.
    """
    strength = float(np.linalg.norm(assembly.gravity))
    if strength > MOST_GRAVITY * G:
        raise InputError(
            f"gravity is {strength:.6g}; it must be at most {MOST_GRAVITY * G:g} m/s2, because displacements are "
            "compared with spectra in metres and seconds: give the scene in metres (--units mm reads a file in "
            "millimetres) with a gravity in m/s2"
        )


def check_pushed(
    limit: LimitLoad,
    direction: Sequence[float],
    masses: Sequence[tuple[int | str, Sequence[float], float]],
    loads: Loads | None,
) -> tuple[Floats, tuple[str, ...], tuple[str, ...]]:
    """Check that the load of a limit is the acceleration of all that has mass.

    Parameters
    ----------
    limit : LimitLoad
        With its forces.
    direction : sequence of float, shape (3,)
        Of the acceleration.
    masses : sequence of (block, point, weight)
        As in `blockstat.linear_check`.
    loads : array, shape (n_blocks, 6), WeightedLoads or None
        Permanent loads; None where they are not told.

    Returns
    -------
    push : array, shape (n_blocks, 6)
        The acceleration of all that has mass, in units of gravity, as a load [N, N m].
    idle : tuple of str
        That permanent loads press down which have no mass, if there are any; and that they may where loads lift a
        block: what presses on it besides is not known.
    weightless : tuple of str
        That masses have no weight among the permanent loads, if there are any.

    Raises
    ------
    InputError
        Naming a block whose load is another. Where the permanent loads are not told, those of a block may be any force
        that passes through it and does not hold it back.
    """
    assembly = limit.assembly
    unit = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    push, carried = acceleration(assembly, direction), np.zeros(assembly.n_blocks)
    for block, place, weight in mass_points(assembly, masses):
        carried[block] += weight
        force = weight / gravity_of(assembly)[0] * np.linalg.norm(assembly.gravity) * unit
        push[block, :3] += force
        push[block, 3:] += np.cross(place - assembly.centroid[block], force)
    beside, passed = acting_beside_weight(limit)
    beside = beside - limit.lower * push
    free, weight = assembly.free, loads.weight if isinstance(loads, WeightedLoads) else 1.0
    more = WeightedLoads(beside, weight).more_weight(assembly)
    down = WeightedLoads(beside - more, weight).pressing(assembly)
    if loads is not None:
        beside = beside - checked_loads(assembly, loads)
    weights = assembly.mass * np.linalg.norm(assembly.gravity)
    force, moment = (np.linalg.norm(part, axis=1) for part in (beside[:, :3], beside[:, 3:]))
    own = weights + np.linalg.norm(limit.lower * push[:, :3], axis=1) + force
    close = BALANCE * own + ROUNDING * passed
    far = np.linalg.norm(assembly.vertices - assembly.centroid[assembly.vertex_block], axis=1)
    reach = np.maximum.reduceat(far, assembly.vertex_start[:-1])
    # Arms of forces are known as well as coordinates are.
    blur = ROUNDING * float(np.abs(assembly.vertices).max()) * passed
    if loads is None:
        wrong = (beside[:, :3] @ unit < -close) | (moment > reach * (force + close) + blur)
    else:
        force, moment = (np.linalg.norm(part, axis=1) for part in (beside[:, :3], beside[:, 3:]))
        wrong = (force > close) | (moment > reach * close + blur)
    if wrong[free].any():
        name = assembly.names[int(free[np.argmax(wrong[free])])]
        told = (
            "with these permanent loads" if loads is not None else "permanent loads that hold back are told as loads="
        )
        raise InputError(
            f"the limit is not that of an acceleration along {[*map(float, direction)]} of all that has mass: "
            f'another load acts on "{name}" ({told})'
        )
    return push, _idle(assembly, down, carried, close), _weightless(assembly, down, carried, close)


def _weightless(assembly: Assembly, down: Floats, carried: Floats, close: Floats) -> tuple[str, ...]:
    """What to say of masses whose weight is not among the permanent loads; the arguments are those of `_idle`."""
    missing = float(carried.sum()) - max(float(down[assembly.free].sum()), 0.0)
    if missing <= float(close.sum()):
        return ()
    return (
        f"masses of {missing:.6g} N are accelerated, and no permanent load has their weight: alpha0 is right if it is "
        "borne elsewhere, and too high or too low if it presses on these blocks",
    )


def _idle(assembly: Assembly, down: Floats, carried: Floats, close: Floats) -> tuple[str, ...]:
    """What to say of permanent loads that press down without a mass.

    Parameters
    ----------
    assembly
        The blocks.
    down
        By how much the permanent loads press down on each block, shape (n_blocks,) [N].
    carried
        The weights that have a mass besides the blocks' own, shape (n_blocks,) [N].
    close
        Forces that are none, shape (n_blocks,) [N].
    """
    free = assembly.free
    down = down[free]
    # Loads of one block are known as their sum alone, but what lifts one does not take the mass of others away.
    pressing = down - carried[free]
    idle = float(pressing[pressing > close[free]].sum())
    if idle > 0:
        return (
            f"permanent loads of {idle:.6g} N press down and have no mass, so alpha0 is too high; what of them is "
            f"weight must be accelerated, too: as blocks, or in Python as masses of the check and in the load of the "
            f"limit",
        )
    if (down >= -close[free]).all():
        return ()
    name = assembly.names[int(free[np.argmin(down)])]
    return (
        f'permanent loads lift "{name}" by {-float(down.min()):.6g} N, so what presses down on it without a mass is '
        f"not known, and would make alpha0 too high; a factor on the weight is told as weighted_permanent of the case",
    )


def acting_beside_weight(limit: LimitLoad) -> tuple[Floats, Floats]:
    """Return the wrenches that the forces of a limit balance beside the weight, and what each block passes on.

    Parameters
    ----------
    limit : LimitLoad
        With its forces, and those of its bonds and ties.

    Returns
    -------
    acting : array, shape (n_blocks, 6)
        About the centroids [N, N m]; what a support carries counts as well.
    passed : array, shape (n_blocks,)
        The sum of the magnitudes of all forces on a block [N].
    """
    assembly, joints = limit.assembly, limit.interfaces
    held, passed = np.zeros((assembly.n_blocks, 6)), np.zeros(assembly.n_blocks)

    def add(pair: Ints, point: Floats, force: Floats, couple: Floats | float = 0.0) -> None:
        for side, sign in ((0, -1.0), (1, 1.0)):
            block = pair[:, side]
            moment = np.cross(point - assembly.centroid[block], force) + couple
            np.add.at(held, block, sign * np.hstack([force, moment]))
            np.add.at(passed, block, np.linalg.norm(force, axis=1))

    own = joints.point_interface
    add(joints.pair[own], joints.point, np.einsum("ni,nij->nj", limit.forces, joints.frame[own]))
    if limit.bonds is not None and len(limit.bonds.interface):
        rows = limit.bonds.interface
        add(joints.pair[rows], centres(joints, rows), limit.bonds.force, limit.bonds.moment)
    if limit.ties is not None and len(limit.ties):
        tied = tie_wrenches(assembly, assembly.ties, limit.ties)
        held += tied
        passed += np.linalg.norm(tied[:, :3], axis=1)
    held[:, :3] += assembly.mass[:, None] * assembly.gravity
    return -held, passed


def mass_points(
    assembly: Assembly, masses: Sequence[tuple[int | str, Sequence[float], float]]
) -> Iterator[tuple[int, Floats, float]]:
    """Give the weights with mass besides the blocks' own.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    masses : sequence of (block, point, weight)
        As in `blockstat.linear_check`.

    Yields
    ------
    block, place, weight
        The number of the block, the point, shape (3,) [m], and the weight [N].

    Raises
    ------
    InputError
        For a weight that is not above 0, a point that is not three numbers, an unknown block, or a support.
    """
    if not isinstance(masses, Sequence):
        raise InputError(f"masses is {masses!r}; it must be a list of a block, a point of it and a weight each")
    for mass in masses:
        if not isinstance(mass, Sequence) or len(mass) != 3:
            raise InputError(f"masses: {mass!r}; each is a block, a point of it and a weight")
        name, point, weight = mass
        blocks = assembly.blocks_named(name, "masses")
        if len(blocks) != 1:
            raise InputError(f"masses: {name!r} are {len(blocks)} blocks; give one")
        if assembly.support[blocks[0]]:
            raise InputError(f"masses: {name!r} is a support, which no mass pushes")
        check_positive(f"masses: the weight on {name!r}", weight)
        yield int(blocks[0]), three(point, "masses: the point"), float(weight)


def mean_displacement(
    assembly: Assembly,
    poses: Sequence[Pose],
    direction: Sequence[float],
    masses: Sequence[tuple[int | str, Sequence[float], float]],
) -> Floats:
    """Return how far the masses have moved along a direction, in the mean.

    Parameters
    ----------
    assembly : Assembly
        The blocks at rest.
    poses : sequence of Pose
        Where they are.
    direction : sequence of float, shape (3,)
        A unit vector.
    masses : sequence of (block, point, weight)
        As in `mass_points`.

    Returns
    -------
    array of float, shape (n_poses,)
        Of all free blocks and these [m].
    """
    own = (assembly.mass * gravity_of(assembly)[0])[assembly.free]
    points = list(mass_points(assembly, masses))
    block = np.array([row[0] for row in points], dtype=np.int64)
    place, weight = np.array([row[1] for row in points]).reshape(-1, 3), np.array([row[2] for row in points])
    moments = [
        own @ pose.displacement[assembly.free] + weight @ (displaced_points(assembly, pose, block, place) - place)
        for pose in poses
    ]
    return np.array(moments) @ np.asarray(direction, dtype=float) / (own.sum() + weight.sum())
