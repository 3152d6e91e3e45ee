"""Checks of what a load is given: vectors and times."""

from __future__ import annotations

from typing import Any

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats


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
