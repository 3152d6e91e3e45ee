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
    """Mass-proportional load in a direction, as strong as gravity: the multiplier is in units of the scene's g.

    group : only on the blocks of a group.
    """
    unit = _direction(direction)
    load = np.zeros((assembly.n_blocks, 6))
    blocks = np.arange(assembly.n_blocks) if group is None else assembly.in_group(group)
    load[blocks, :3] = assembly.mass[blocks, None] * np.linalg.norm(assembly.gravity) * unit
    return load


def point_load(assembly: Assembly, block: int | str, point: Sequence[float], force: Sequence[float]) -> Floats:
    """A force [N] at a point [m] of a block, given by index or name."""
    (index,) = assembly.blocks_named(block, "load")
    load = np.zeros((assembly.n_blocks, 6))
    load[index, :3] = force
    load[index, 3:] = np.cross(np.asarray(point, dtype=float) - assembly.centroid[index], force)
    return load


def as_load(assembly: Assembly, load: Any) -> Floats:
    """A load given as three numbers (an acceleration direction) or as wrenches, shape (n_blocks, 6)."""
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
