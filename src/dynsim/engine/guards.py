"""Checks of what Bullet would simulate wrongly and without an error.

Bullet accepts positions that are not numbers, flat hulls, negative masses and unknown bodies, and its answer is then
wrong. Files are checked where they are read. An assembly can be changed afterwards, so all is checked again here.
"""

from __future__ import annotations

from math import ceil

import numpy as np

from blockstat.assembly import Assembly, check_supports
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.typing import Floats

#: Sizes (cube root of the volume) beyond this many times the median, or below its reciprocal.
SIZES = 100.0
#: Largest ratio of the masses of two blocks that touch: limits with so many iterations as `iterations_for` asks for
#: were tried up to it.
MASSES = 10_000.0
#: Iterations of the contact solver for each time that a block is heavier than one that it touches. A sweep moves the
#: light one until it carries its own share, so what is left of an error shrinks by one part in the ratio of the masses
#: at each. With two sweeps a part, blocks on lighter ones tip and slide within 3 % of their limits (docs/dynamics.md).
SWEEPS = 2.0
#: A free block thinner than this, relative to the median block size, does not come to rest under others (9 mm for
#: bricks of 0.3 m).
THINNEST = 0.03
#: What is said of a block whose place is no longer finite.
LOST = "was lost in the simulation (its position is not a number); forces, velocities and time steps must be smaller"
#: Shapes may overlap by this share of the median block size before the first step; more of it flies apart.
OVERLAP = 0.05


def check_assembly(assembly: Assembly) -> None:
    """Check that Bullet can simulate a scene rightly.

    Parameters
    ----------
    assembly : Assembly
        What is to be simulated.

    Raises
    ------
    InputError
        For a scene that it cannot; the message names the first block at fault.
    """
    check_supports(assembly)
    if assembly.support.all():
        raise InputError(f'"{assembly.name}": all blocks are supports; there is nothing to simulate')
    corner = np.repeat(np.arange(assembly.n_blocks), np.diff(assembly.vertex_start))
    finite = np.isfinite(assembly.vertices).all(axis=1)
    _refuse(
        assembly, np.bincount(corner[~finite], minlength=assembly.n_blocks) > 0, "has a corner that is not a number"
    )
    if not np.isfinite(assembly.gravity).all() or not np.linalg.norm(assembly.gravity) > 0:
        raise InputError(
            f'"{assembly.name}": gravity is {assembly.gravity.tolist()}; it must be three numbers, not all 0'
        )
    if not assembly.friction >= 0:
        raise InputError(f'"{assembly.name}": friction is {assembly.friction!r}; it must be at least 0')
    with np.errstate(all="ignore"):
        volume, mass = assembly.volume, assembly.mass
        _refuse(assembly, ~(volume > 0), "has no volume or is inside out")
        _refuse(assembly, ~(np.isfinite(mass) & (mass > 0)), "has a mass that is not a positive number")
        _refuse(assembly, ~(thickness(assembly) > 0), "is flat")
    _check_ratios(assembly)


def _check_ratios(assembly: Assembly) -> None:
    free = ~assembly.support
    size = np.median(assembly.size[free])
    _refuse(assembly, free & (assembly.size > SIZES * size), f"is more than {SIZES:g} times as large as most blocks")
    _refuse(assembly, free & (assembly.size < size / SIZES), f"is less than 1/{SIZES:g} as large as most blocks")
    _refuse(
        assembly,
        free & (thickness(assembly) < THINNEST * size),
        f"is thinner than {THINNEST:g} of the size of most blocks; in Bullet it would not come to rest",
    )


def may_have_uneven_masses(assembly: Assembly, iterations: int) -> bool:
    """Return whether some free block would need more iterations if it rested on the lightest one.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    iterations : int
        Of the contact solver.

    Returns
    -------
    bool
        True where `iterations_for` has to be asked.
    """
    mass = assembly.mass[~assembly.support]
    return bool(SWEEPS * mass.max() > iterations * mass.min())


def iterations_for(assembly: Assembly, interfaces: Interfaces) -> int:
    """Return the iterations that the contact solver needs for blocks on much lighter ones.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    int
        `SWEEPS` times the largest ratio of the masses of two free blocks that touch; 0 where none do.

    Raises
    ------
    InputError
        For two blocks whose masses are too far apart; the message names both.
    """
    mass = np.sort(np.where(assembly.support, np.nan, assembly.mass)[interfaces.pair], axis=1)
    ratio = np.nan_to_num(mass[:, 1] / mass[:, 0])  # a support carries anything
    if not len(ratio):
        return 0
    worst = int(np.argmax(ratio))
    if ratio[worst] > MASSES * (1 + 1e-9):
        light, heavy = sorted(interfaces.pair[worst], key=lambda block: assembly.mass[block])
        raise InputError(
            f'block "{assembly.names[heavy]}" is {ratio[worst]:.3g} times as heavy as '
            f'"{assembly.names[light]}", which it touches; Bullet carries at most {MASSES:g} times'
        )
    return ceil(SWEEPS * ratio[worst])


def check_overlap(assembly: Assembly, pair: tuple[int, int], depth: float) -> None:
    """Check that two blocks do not start so far inside each other that they would fly apart.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    pair : tuple of two ints
        The two blocks.
    depth : float
        How far they overlap [m].

    Raises
    ------
    InputError
        For a deeper overlap; the message names both blocks.
    """
    size = float(np.median(assembly.size[~assembly.support]))
    if depth > OVERLAP * size:
        a, b = (assembly.names[block] for block in pair)
        raise InputError(
            f'blocks "{a}" and "{b}" overlap by {1e3 * depth:.3g} mm; Bullet would throw them apart. '
            f"At most {1e3 * OVERLAP * size:.3g} mm (1/20 of the block size) is simulated"
        )


def check_rotations(assembly: Assembly, rotations: Floats) -> None:
    """Check that orientations are rotations; by any other Bullet would scale the block.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    rotations : array of float, shape (n_blocks, 3, 3)
        Their orientations.

    Raises
    ------
    InputError
        For another matrix; the message names the first block at fault.
    """
    product = np.einsum("nij,nik->njk", rotations, rotations)
    with np.errstate(invalid="ignore"):
        wrong = ~(np.abs(product - np.eye(3)).max(axis=(1, 2)) < 1e-6) | ~(np.linalg.det(rotations) > 0)
    _refuse(assembly, wrong, "has an orientation that is not a rotation")


def check_places(assembly: Assembly, position: Floats, orientation: Floats) -> None:
    """Check that an engine still knows where the blocks are.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    position : array of float, shape (n_blocks, 3)
        Their places.
    orientation : array of float, shape (n_blocks, ...)
        Their orientations.

    Raises
    ------
    InputError
        For a place that is not finite; the message names the first block that is lost.
    """
    known = np.hstack([position, orientation.reshape(len(orientation), -1)])
    _refuse(assembly, np.asarray(~np.isfinite(known).all(axis=1)), LOST)


def check_blocks(assembly: Assembly, blocks: np.ndarray) -> None:
    """Check that numbers are those of blocks.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    blocks : array of int
        Numbers of blocks.

    Raises
    ------
    InputError
        For the number of a block that does not exist.
    """
    for block in np.atleast_1d(blocks):
        if not 0 <= block < assembly.n_blocks:
            raise InputError(f"no block {block}; blocks are 0 to {assembly.n_blocks - 1}")


def thickness(assembly: Assembly) -> Floats:
    """Return the smallest extent of each block, as of the box with its inertia.

    Parameters
    ----------
    assembly : Assembly
        The blocks.

    Returns
    -------
    array of float, shape (n_blocks,)
        Extent [m].
    """
    moments = np.linalg.eigvalsh(assembly.inertia)
    square = 6 * (moments[:, 0] + moments[:, 1] - moments[:, 2]) / assembly.mass
    return np.sqrt(np.maximum(square, 0.0))


def _refuse(assembly: Assembly, wrong: np.ndarray, reason: str) -> None:
    if wrong.any():
        raise InputError(f'block "{assembly.names[int(np.argmax(wrong))]}" {reason}')
