"""Loads on displaced blocks: forces of constant direction that act at material points, and constant couples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import InputError
from blockstat.large_displacement.displaced.pose import Pose, displaced_points
from blockstat.loading.on_faces import point_forces
from blockstat.loading.placed import PlacedForces, at_centroids, joined, wrenches_about
from blockstat.loads import WeightedLoads, as_load
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Accelerations of blocks that differ by less are one. Relative to the largest. Chosen: far above rounding.
SAME_ACCELERATION = 1e-9


def displaced_wrenches(placed: PlacedForces, assembly: Assembly, pose: Pose) -> Floats:
    """Return the wrench on each block about its displaced centroid.

    Parameters
    ----------
    placed
        The forces. They and the couples keep their directions.
    assembly
        The blocks at rest.
    pose
        Their pose.

    Returns
    -------
    Floats
        Shape (n_blocks, 6) [N, N m].
    """
    return wrenches_about(
        pose.centroids(assembly), displaced_points(assembly, pose, placed.block, placed.point), placed
    )


def read_loads(assembly: Assembly, given: Any, *, live: bool = False) -> PlacedForces:
    """Read loads as a user gives them.

    Parameters
    ----------
    assembly
        The blocks.
    given
        None, three numbers (the direction of an acceleration; only live loads), a wrench on each block, shape
        (n_blocks, 6) [N, N m], whose forces act at the centroids, a sequence of (block, point, force), as in
        `blockstat.point_load`, or forces at their points, as a load case has them.
    live
        Whether the multiplier multiplies them; then no load is an error.

    Returns
    -------
    PlacedForces
        The forces, their points of application and the couples.

    Raises
    ------
    InputError
        For anything else.
    """
    if given is None and not live:
        return joined(assembly, [])
    if isinstance(given, PlacedForces):
        return given
    if given is not None and _are_point_forces(given):
        return joined(assembly, (point_forces(assembly, *row) for row in given))
    if live:
        wrench = as_load(assembly, given)
    else:
        from blockstat.analysis.problem import checked_loads

        wrench = checked_loads(assembly, given)
    return at_centroids(assembly, wrench)


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
        if load is None or isinstance(load, PlacedForces) or _are_point_forces(load) or np.ndim(load) == 1:
            continue
        wrench = np.asarray(load.beside if isinstance(load, WeightedLoads) else load, dtype=float)
        loaded = wrench.any(axis=1) & ~assembly.support
        rate = wrench[loaded, :3] / assembly.mass[loaded, None]
        # Of one block it is not known whether all of its mass is accelerated.
        same = len(rate) > 1 and (np.ptp(rate, axis=0) <= SAME_ACCELERATION * np.abs(rate).max()).all()
        if loaded.any() and not (same and not wrench[loaded, 3:].any()):
            told.append(
                f"the forces of `{name}` are taken to act at the centroids of the blocks. What acts on top of a block "
                "moves further as it turns, and collapse may then come earlier: give it as (block, point, force)"
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
