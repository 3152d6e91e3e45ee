"""How the two sides of a joint have moved against each other, and forces on both."""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP
from blockstat.typing import Floats, Ints
from dynsim.engine.world import World


class Poses:
    """Where the blocks are: centroids, shape (n_blocks, 3) [m], and rotations since built, shape (n_blocks, 3, 3)."""

    def __init__(self, world: World) -> None:
        moved, self.rotation = world.poses()
        self.built = world.assembly.centroid
        self.centroid = self.built + moved


def removed(world: World, pair: Ints) -> np.ndarray:
    """Whether one of the two blocks of each joint has been taken out, shape (n,) bool."""
    return np.asarray(np.isin(pair, list(world.removed)).any(axis=1))


def reach(assembly: Assembly, pair: Ints) -> Floats:
    """Opening or slip at which the bond of a pair of blocks is broken [m]: the gap up to which a joint is one."""
    return GAP * assembly.size[pair].min(axis=1)


def at_points(poses: Poses, pair: Ints, point: Floats) -> tuple[Floats, Floats, Floats]:
    """Points of joints as they are now.

    pair : blocks a and b, shape (n, 2); point : as built, shape (n, 3) [m]. Returns the place half-way between the two
    sides (n, 3) [m], side b as seen from side a (n, 3) [m], and the rotation of a (n, 3, 3).
    """
    a, b = (
        poses.centroid[block] + np.einsum("nij,nj->ni", poses.rotation[block], point - poses.built[block])
        for block in pair.T
    )
    return (a + b) / 2, b - a, poses.rotation[pair[:, 0]]


def apply_on_pairs(
    world: World, poses: Poses, pair: Ints, point: Floats, force: Floats, couple: Floats | None = None
) -> None:
    """Forces on blocks b at points, the opposite on blocks a; force, couple : shape (n, 3) [N], [N m]."""
    total, moment = np.zeros((2, len(poses.centroid), 3))
    for side, sign in ((0, -1.0), (1, 1.0)):
        block = pair[:, side]
        turning = np.cross(point - poses.centroid[block], force)
        np.add.at(total, block, sign * force)
        np.add.at(moment, block, sign * (turning if couple is None else turning + couple))
    world.load(total, moment)
