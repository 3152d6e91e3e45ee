"""Loads: a wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].

A load multiplier is a factor on one of these, on top of the weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


def acceleration(assembly: Assembly, direction: Sequence[float], *, group: str | None = None) -> Floats:
    """Make a mass-proportional load in a direction, as strong as gravity: a multiplier is in units of the scene's g.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    direction : sequence of float, shape (3,)
        Direction of the acceleration, of any length.
    group : str, optional
        Load only the blocks of this group.

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For a direction that is none, or an unknown group.

    Examples
    --------
    >>> from blockstat import Assembly, acceleration, box
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], density=1000.0)
    >>> acceleration(cube, (2, 0, 0)).round(3).tolist()
    [[9810.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    """
    unit = _direction(direction)
    load = np.zeros((assembly.n_blocks, 6))
    blocks = np.arange(assembly.n_blocks) if group is None else assembly.in_group(group)
    load[blocks, :3] = assembly.mass[blocks, None] * np.linalg.norm(assembly.gravity) * unit
    return load


def point_load(assembly: Assembly, block: int | str, point: Sequence[float], force: Sequence[float]) -> Floats:
    """Make the load of a force at a point of a block.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    block : str or int
        Name or number of the block.
    point : sequence of float, shape (3,)
        Where the force acts [m].
    force : sequence of float, shape (3,)
        The force [N].

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For an unknown block.

    Examples
    --------
    >>> from blockstat import Assembly, box, point_load
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1), name="cube")])
    >>> point_load(cube, "cube", (0.5, 0.5, 1.0), (10, 0, 0)).round(6).tolist()
    [[10.0, 0.0, 0.0, 0.0, 5.0, 0.0]]
    """
    (index,) = assembly.blocks_named(block, "load")
    load = np.zeros((assembly.n_blocks, 6))
    load[index, :3] = force
    load[index, 3:] = np.cross(np.asarray(point, dtype=float) - assembly.centroid[index], force)
    return load


def as_load(assembly: Assembly, load: Any) -> Floats:
    """Return a load as wrenches on the blocks.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    load : array_like, shape (3,) or (n_blocks, 6)
        Direction of an acceleration as strong as gravity, or a wrench on each block [N, N m].

    Returns
    -------
    array, shape (n_blocks, 6)
        Force [N] and moment about the centroid [N m] on each block.

    Raises
    ------
    InputError
        For another shape, or a load that is zero on every free block.
    """
    values = np.asarray(load, dtype=float)
    if values.shape == (3,):
        return acceleration(assembly, list(values))
    if values.shape != (assembly.n_blocks, 6) or not np.isfinite(values).all():
        raise InputError(
            f"load has shape {values.shape}; three numbers (a direction) or finite values of shape "
            f"({assembly.n_blocks}, 6) are needed"
        )
    if not values[assembly.free].any():
        raise InputError("load is zero on every free block")
    return values


def _direction(direction: Sequence[float]) -> Floats:
    vector = np.asarray(direction, dtype=float)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
        raise InputError(f"load direction is {[*map(float, vector.flat)]}; it must be three numbers, not all zero")
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)
