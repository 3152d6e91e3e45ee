"""Checks of what a load is given: blocks by name, vectors, times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.typing import Floats, Ints


def blocks_named(assembly: Assembly, given: Sequence[int | str] | int | str, what: str) -> Ints:
    """Indices of blocks given by name or number; what : starts the message of the InputError."""
    found = []
    for block in [given] if isinstance(given, int | str) else given:
        if isinstance(block, str) and block in assembly.names:
            found.append(assembly.names.index(block))
        elif not isinstance(block, str) and 0 <= int(block) < assembly.n_blocks:
            found.append(int(block))
        else:
            some = ", ".join(assembly.names[:8]) + (", ..." if assembly.n_blocks > 8 else "")
            raise InputError(f'{what}: no block "{block}"; blocks are: {some}')
    if not found:
        raise InputError(f"{what}: no blocks are given")
    return np.array(found, dtype=np.int64)


def vector_of(value: Any, what: str, *, zero: bool = False) -> Floats:
    vector = np.asarray(value, dtype=float)
    if vector.shape != (3,) or not np.isfinite(vector).all() or not (zero or vector.any()):
        raise InputError(f"{what} is {value!r}; it must be three numbers{'' if zero else ', not all zero'}")
    return vector


def positive(value: float, what: str) -> None:
    if not (np.isfinite(value) and value > 0):
        raise InputError(f"{what} is {value!r}; it must be above 0")


def not_negative(value: float, what: str) -> None:
    if not (np.isfinite(value) and value >= 0):
        raise InputError(f"{what} is {value!r}; it must be 0 or more")
