"""Forces at points of blocks, of which loads are made: as the blocks move, each force goes with its point."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


@dataclass(frozen=True, eq=False)
class PlacedForces:
    """Forces at material points of blocks, and couples. Neither changes its direction when the blocks are rotated."""

    block: Ints  #: block of each force, shape (k,)
    point: Floats  #: point of application at rest, shape (k, 3) [m]
    force: Floats  #: shape (k, 3) [N]
    couple: Floats  #: on each block, shape (n_blocks, 3) [N m]

    def wrenches(self, assembly: Assembly) -> Floats:
        """Return the wrench on each block about its centroid at rest.

        Parameters
        ----------
        assembly
            The blocks.

        Returns
        -------
        Floats
            Shape (n_blocks, 6) [N, N m].
        """
        return wrenches_about(assembly.centroid, self.point, self)

    def times(self, factor: float) -> PlacedForces:
        """Return forces and couples multiplied by a factor.

        Parameters
        ----------
        factor
            The factor.

        Returns
        -------
        PlacedForces
            At the same points.
        """
        return PlacedForces(self.block, self.point, factor * self.force, factor * self.couple)

    def plus(self, other: PlacedForces) -> PlacedForces:
        """Return these forces and others on the same blocks.

        Parameters
        ----------
        other
            The other forces.

        Returns
        -------
        PlacedForces
            One after another.
        """
        return PlacedForces(
            np.concatenate([self.block, other.block]),
            np.concatenate([self.point, other.point]),
            np.concatenate([self.force, other.force]),
            self.couple + other.couple,
        )


def wrenches_about(centre: Floats, point: Floats, placed: PlacedForces) -> Floats:
    """Return the wrenches of forces whose points are elsewhere than at rest.

    Parameters
    ----------
    centre
        Of each block, shape (n_blocks, 3) [m].
    point
        Where the forces act, shape (k, 3) [m].
    placed
        The forces.

    Returns
    -------
    Floats
        Shape (n_blocks, 6) [N, N m].
    """
    wrench = np.hstack([np.zeros_like(placed.couple), placed.couple])
    moment = np.cross(point - centre[placed.block], placed.force)
    np.add.at(wrench, placed.block, np.hstack([placed.force, moment]))
    return wrench


def at_points(assembly: Assembly, block: Ints, point: Floats, force: Floats) -> PlacedForces:
    """Return forces without couples.

    Parameters
    ----------
    assembly, block, point, force
        As in `PlacedForces`.

    Returns
    -------
    PlacedForces
        The forces.
    """
    return PlacedForces(block, point, force, np.zeros((assembly.n_blocks, 3)))


def at_centroids(assembly: Assembly, wrench: Floats) -> PlacedForces:
    """Return wrenches as forces at the centroids, and couples.

    Parameters
    ----------
    assembly
        The blocks.
    wrench
        Shape (n_blocks, 6) [N, N m].

    Returns
    -------
    PlacedForces
        The forces that are not zero.
    """
    block = np.flatnonzero(wrench[:, :3].any(axis=1))
    return PlacedForces(block, assembly.centroid[block], wrench[block, :3], wrench[:, 3:].copy())


def joined(assembly: Assembly, parts: Iterable[PlacedForces]) -> PlacedForces:
    """Return all of some forces.

    Parameters
    ----------
    assembly
        The blocks.
    parts
        Forces.

    Returns
    -------
    PlacedForces
        One after another.
    """
    return reduce(PlacedForces.plus, parts, at_centroids(assembly, np.zeros((assembly.n_blocks, 6))))
