"""Loads on displaced blocks: forces of constant direction that act at material points, and constant couples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import InputError
from blockstat.large_displacement.displaced.pose import Pose, displaced_points
from blockstat.loads import WeightedLoads, as_load, point_load
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Accelerations of blocks that differ by less are one. Relative to the largest. Chosen: far above rounding.
SAME_ACCELERATION = 1e-9


@dataclass(frozen=True, eq=False)
class PointLoads:
    """Forces at material points of blocks, and couples. Neither changes its direction when the blocks are rotated."""

    block: Ints  #: block of each force, shape (k,)
    point: Floats  #: point of application at rest, shape (k, 3) [m]
    force: Floats  #: shape (k, 3) [N]
    couple: Floats  #: on each block, shape (n_blocks, 3) [N m]

    def wrenches(self, assembly: Assembly, pose: Pose) -> Floats:
        """Return the wrench on each block about its displaced centroid.

        Parameters
        ----------
        assembly
            The blocks at rest.
        pose
            Their pose.

        Returns
        -------
        Floats
            Shape (n_blocks, 6) [N, N m].
        """
        arm = displaced_points(assembly, pose, self.block, self.point) - pose.centroids(assembly)[self.block]
        wrench = np.hstack([np.zeros_like(self.couple), self.couple])
        np.add.at(wrench, self.block, np.hstack([self.force, np.cross(arm, self.force)]))
        return wrench


def read_loads(assembly: Assembly, given: Any, *, live: bool = False) -> PointLoads:
    """Read loads as a user gives them.

    Parameters
    ----------
    assembly
        The blocks.
    given
        None, three numbers (the direction of an acceleration; only live loads), a wrench on each block, shape
        (n_blocks, 6) [N, N m], whose forces act at the centroids, or a sequence of (block, point, force), as in
        `blockstat.point_load`.
    live
        Whether the multiplier multiplies them; then no load is an error.

    Returns
    -------
    PointLoads
        The forces, their points of application and the couples.

    Raises
    ------
    InputError
        For anything else.
    """
    n = assembly.n_blocks
    if given is None and not live:
        return PointLoads(np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty((0, 3)), np.zeros((n, 3)))
    if given is not None and _are_point_forces(given):
        rows = [(int(assembly.blocks_named(b, "load")[0]), p, point_load(assembly, b, p, f)) for b, p, f in given]
        block = np.array([row[0] for row in rows], dtype=np.int64)
        force = np.array([row[2][row[0], :3] for row in rows])
        return PointLoads(block, np.array([row[1] for row in rows], dtype=float), force, np.zeros((n, 3)))
    if live:
        wrench = as_load(assembly, given)
    else:
        from blockstat.analysis.problem import checked_loads

        wrench = checked_loads(assembly, given)
    block = np.flatnonzero(wrench[:, :3].any(axis=1))
    return PointLoads(block, assembly.centroid[block], wrench[block, :3], wrench[:, 3:].copy())


def moved_with_centroids(assembly: Assembly, given: Mapping[str, Any]) -> list[str]:
    """Return a warning for each load of which it is not known where on its blocks it acts.

    Parameters
    ----------
    assembly
        The blocks.
    given
        Loads as `read_loads` takes them, by the name of their option.

    Returns
    -------
    list of str
        For wrenches, unless they are those of an acceleration, which acts at centroids.
    """
    told = []
    for name, load in given.items():
        if load is None or _are_point_forces(load) or np.ndim(load) == 1:
            continue
        wrench = np.asarray(load.beside if isinstance(load, WeightedLoads) else load, dtype=float)
        loaded = wrench.any(axis=1) & ~assembly.support
        rate = wrench[loaded, :3] / assembly.mass[loaded, None]
        # Of one block it is not known whether all of its mass is accelerated.
        same = len(rate) > 1 and (np.ptp(rate, axis=0) <= SAME_ACCELERATION * np.abs(rate).max()).all()
        if loaded.any() and not (same and not wrench[loaded, 3:].any()):
            told.append(
                f"the forces of `{name}` are taken to act at the centroids of the blocks. What acts on top of a block "
                "moves further as it turns, and the curve may then end earlier: give it as (block, point, force)"
            )
    return told


def _are_point_forces(given: Any) -> bool:
    """Whether loads are given as blocks, points and forces."""
    if isinstance(given, np.ndarray) or not isinstance(given, Sequence) or not len(given):
        return False
    rows = [row for row in given if isinstance(row, (tuple, list)) and len(row) == 3]
    if len(rows) < len(given):
        return False
    if all(isinstance(row[0], str) or np.ndim(row[1]) == 1 for row in rows):
        return True
    if any(isinstance(row[0], str) for row in rows):
        raise InputError("loads: each must be a block, a point and a force")
    return False
