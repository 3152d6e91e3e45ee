"""Checks of what Bullet would simulate wrongly and without an error.

Bullet accepts positions that are not numbers, flat hulls, negative masses and unknown bodies, and its answer is then
wrong. Files are checked where they are read. An assembly can be changed afterwards, so all is checked again here.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np

from blockstat.assembly import Assembly, check_supports
from blockstat.contact.faces import frames
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.loads import up_of
from blockstat.typing import Floats

#: Sizes (cube root of the volume) beyond this many times the median, or below its reciprocal.
SIZES = 100.0
#: Largest ratio of the mass of a block to that of the free ones that carry it: limits with so many iterations as
#: `iterations_for` asks for were tried up to it.
MASSES = 10_000.0
#: Iterations of the contact solver for each time that a block is heavier than those that carry it.
SWEEPS = 2.0
#: A block that is about to tip or to slide rests on the outermost of those that carry it: on this part of their width.
EDGE = 0.25
#: Places that differ by less than this fraction of the width are equally far out.
ROUNDING = 1e-9
#: Blocks carry one another along a direction where the normal of their joint is within 60 degrees of it.
ALONG = 0.5
#: A free block thinner than this, relative to the median block size, does not come to rest under others (9 mm for
#: bricks of 0.3 m).
THINNEST = 0.03
#: What is said of a block whose place is no longer finite.
LOST = "was lost in the simulation (its position is not a number); forces, velocities and time steps must be smaller"
#: Shapes may overlap by this share of the median block size before the first step; more of it flies apart.
OVERLAP = 0.05


def check_can_simulate(assembly: Assembly) -> None:
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
    """Return whether some free block would need more iterations if the lightest one were beside it.

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


def joints_to_support(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Return the number of joints between each block and the nearest support.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    array of float, shape (n_blocks,)
        Numbers of joints on the shortest way; 0 for blocks without one.
    """
    from scipy import sparse
    from scipy.sparse.csgraph import dijkstra

    pair = interfaces.pair
    n = assembly.n_blocks
    graph = sparse.coo_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(n, n)).tocsr()
    far = dijkstra(graph, directed=False, indices=np.flatnonzero(assembly.support), unweighted=True, min_only=True)
    return np.where(np.isfinite(far), far, 0.0)


def iterations_for(assembly: Assembly, interfaces: Interfaces, *, careful: bool = False) -> int:
    """Return the iterations that the contact solver needs for blocks on much lighter ones.

    A sweep moves each light block until it carries its own share, so what is left of an error shrinks by one part in
    the ratio of the heavy mass to all that carry it: `SWEEPS` sweeps for each part are enough for blocks that stand.
    What is about to move rests on the outermost of those alone. And where they stand on others, the force goes down
    step by step, and each step passes on as much less as there are steps: so many sweeps for each joint down to a
    support. With so many sweeps, blocks on lighter ones tip and slide within 3 % of their limits
    (docs/dynamics.md). With fewer they move too early.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Joints of the assembly.
    careful : bool, optional
        Whether they are for blocks that are about to move, not for such as stand.

    Returns
    -------
    int
        For the block that needs most, at most `SWEEPS` times `MASSES`; 0 where no free block is carried by free ones.

    Raises
    ------
    InputError
        For a block that is too heavy for all that carry it, unless `careful`; the message names it and the lightest of
        them.
    """
    n, mass = assembly.n_blocks, np.where(assembly.support, np.inf, assembly.mass)
    place = np.add.reduceat(interfaces.point, interfaces.start[:-1]) / np.diff(interfaces.start)[:, None]
    heavy, light = np.concatenate([interfaces.pair, interfaces.pair[:, ::-1]]).T
    push = np.concatenate([-interfaces.frame[:, 0], interfaces.frame[:, 0]])  # of the light one on the heavy one
    place = np.concatenate([place, place])
    up = up_of(assembly)
    angle = np.arange(8)[:, None] * np.pi / 4
    around = np.hstack([np.cos(angle), np.sin(angle)]) @ frames(up[None])[0, 1:]
    beside = np.full(n, SWEEPS)
    down = beside * np.maximum(joints_to_support(assembly, interfaces), 1.0) if careful else beside
    most = 0.0
    for direction, times in ((up, down), *((side, beside) for side in around)):
        on = np.flatnonzero((push @ direction > ALONG) & ~assembly.support[heavy])
        _, first = np.unique(heavy[on] * n + light[on], return_index=True)  # a pair may touch in several places
        on, plane = on[first], frames(direction[None])[0, 1:]
        least = np.full(n, np.inf)
        np.minimum.at(least, heavy[on], mass[light[on]])
        at_most = times * assembly.mass / least
        for block in np.argsort(-at_most, kind="stable"):
            if at_most[block] <= most:
                break
            own = on[heavy[on] == block]
            ratio = assembly.mass[block] / _least_mass(mass[light[own]], place[own] @ plane.T, EDGE if careful else 1.0)
            if not careful and ratio > MASSES * (1 + 1e-9):
                lightest = light[own[np.argmin(mass[light[own]])]]
                raise InputError(
                    f'block "{assembly.names[block]}" is {ratio:.3g} times as heavy as what carries it, '
                    f'"{assembly.names[lightest]}"; Bullet carries at most {MASSES:g} times'
                )
            most = max(most, times[block] * ratio)
    return ceil(min(most, SWEEPS * MASSES))


def _least_mass(mass: Floats, place: Floats, part: float) -> float:
    """The mass of what carries a block, at places in a plane, in the outermost part along an edge where it is least."""
    if part >= 1:
        return float(mass.sum())
    room = ROUNDING * np.ptp(place, axis=0).max()
    least = np.inf
    for out in _outward(place):
        along = place @ out
        least = min(least, mass[along >= along.max() - part * np.ptp(along) - room].sum())
    return float(least)


def _outward(place: Floats) -> Floats:
    """Normals of the edges of what points in a plane span; of points in a row, both ways along it."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(place).equations[:, :2]
    except QhullError:  # fewer than three, or all in a row
        along = np.linalg.svd(place - place.mean(axis=0))[2][:1]
        return np.concatenate([along, -along])


def check_overlap(assembly: Assembly, pair: tuple[int, int], depth: float, filled: Sequence[str] = ()) -> None:
    """Check that two blocks do not start so far inside each other that they would fly apart.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    pair : tuple of two ints
        The two blocks.
    depth : float
        How far they overlap [m].
    filled : sequence of str, optional
        Names of the blocks whose convex pieces fill recesses of theirs.

    Raises
    ------
    InputError
        For a deeper overlap; the message names both blocks. Where pieces fill a recess of one of them, it does not say
        that the blocks overlap: only their pieces are known to.
    """
    size = float(np.median(assembly.size[~assembly.support]))
    if depth > OVERLAP * size:
        a, b = (assembly.names[block] for block in pair)
        most = f"At most {1e3 * OVERLAP * size:.3g} mm (1/20 of the block size) is simulated"
        if own := " and ".join(f'"{name}"' for name in (a, b) if name in filled):
            raise InputError(
                f"no cut of {own} into convex pieces was found that leaves the recesses open; the pieces of "
                f'"{a}" and "{b}" overlap by {1e3 * depth:.3g} mm, though the blocks may not, and Bullet would throw '
                f"them apart. {most}; draw {own} with fewer and larger faces, or as several blocks"
            )
        raise InputError(
            f'blocks "{a}" and "{b}" overlap by {1e3 * depth:.3g} mm; Bullet would throw them apart. {most}'
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
