"""How the two sides of a joint have moved against each other, forces on both, and the mass that they move."""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP
from blockstat.typing import Floats, Ints
from dynsim.engine.world import World


class Poses:
    """Where the blocks are: centroids, shape (n_blocks, 3) [m], and rotations since built, shape (n_blocks, 3, 3)."""

    def __init__(self, world: World) -> None:
        """Ask where the blocks are.

        Parameters
        ----------
        world : World
            What they are in.
        """
        moved, self.rotation = world.poses()
        self.built = world.assembly.centroid
        self.centroid = self.built + moved


def removed(world: World, pair: Ints) -> np.ndarray:
    """Return whether one of the two blocks of each joint has been taken out.

    Parameters
    ----------
    world : World
        What the blocks are in.
    pair : array of int, shape (n, 2)
        The two blocks of each joint.

    Returns
    -------
    array of bool, shape (n,)
        True for a joint that is gone.
    """
    return np.asarray(np.isin(pair, list(world.removed)).any(axis=1))


def reach(assembly: Assembly, pair: Ints) -> Floats:
    """Return the opening or slip at which the bond of two blocks is broken.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    pair : array of int, shape (n, 2)
        The two blocks of each joint.

    Returns
    -------
    array of float, shape (n,)
        The gap up to which a joint is one [m].
    """
    return GAP * assembly.size[pair].min(axis=1)


def moved_mass(assembly: Assembly, blocks: Ints, points: Floats, lines: Floats) -> Floats:
    """Return the mass that a unit force along each of some lines moves, shared among the lines at a block.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    blocks : array of int, shape (n, k)
        The blocks that each line ends at; supports do not move.
    points : array of float, shape (n, k, 3)
        Where, on the blocks as built [m].
    lines : array of float, shape (n, 3)
        Unit vectors along the lines.

    Returns
    -------
    array of float, shape (n,)
        Masses [kg]; 0 for a line that ends at supports alone.
    """
    turning = np.linalg.inv(assembly.inertia)
    mobility = np.zeros(len(blocks))
    for side, block in enumerate(blocks.T):
        arm = np.cross(points[:, side] - assembly.centroid[block], lines)
        own = 1.0 / assembly.mass[block] + np.einsum("ni,nij,nj->n", arm, turning[block], arm)
        mobility += np.where(assembly.support[block], 0.0, own)
    count = np.bincount(blocks.reshape(-1), minlength=assembly.n_blocks)
    count[assembly.support] = 1
    shared = mobility * count[blocks].max(axis=1)
    return np.divide(1.0, shared, out=np.zeros(len(blocks)), where=shared > 0)


def at_points(poses: Poses, pair: Ints, point: Floats) -> tuple[Floats, Floats, Floats]:
    """Return points of joints as they are now.

    Parameters
    ----------
    poses : Poses
        Where the blocks are.
    pair : array of int, shape (n, 2)
        Blocks a and b of each joint.
    point : array of float, shape (n, 3)
        The points as built [m].

    Returns
    -------
    place : array of float, shape (n, 3)
        Half-way between the two sides [m].
    offset : array of float, shape (n, 3)
        Side b as seen from side a [m].
    rotation : array of float, shape (n, 3, 3)
        Rotation of block a since built.
    """
    a, b = (
        poses.centroid[block] + np.einsum("nij,nj->ni", poses.rotation[block], point - poses.built[block])
        for block in pair.T
    )
    return (a + b) / 2, b - a, poses.rotation[pair[:, 0]]


def apply_on_pairs(
    world: World, poses: Poses, pair: Ints, point: Floats, force: Floats, couple: Floats | None = None
) -> None:
    """Apply forces and couples on blocks b, and the opposite ones on blocks a, for the next time step.

    Parameters
    ----------
    world : World
        What the blocks are in.
    poses : Poses
        Where they are.
    pair : array of int, shape (n, 2)
        Blocks a and b of each joint.
    point : array of float, shape (n, 3)
        Where the forces act [m].
    force : array of float, shape (n, 3)
        Forces on blocks b [N].
    couple : array of float, shape (n, 3), optional
        Couples on blocks b [N m].
    """
    total, moment = np.zeros((2, len(poses.centroid), 3))
    for side, sign in ((0, -1.0), (1, 1.0)):
        block = pair[:, side]
        turning = np.cross(point - poses.centroid[block], force)
        np.add.at(total, block, sign * force)
        np.add.at(moment, block, sign * (turning if couple is None else turning + couple))
    world.load(total, moment)
