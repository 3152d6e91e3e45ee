"""Checks of the names of engines, and of vectors and times that loads are made with."""

from __future__ import annotations

from typing import Any

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats

ENGINES = ("bullet", "lmgc90")


def check_engine(name: str) -> None:
    """Check that there is an engine of a name.

    Parameters
    ----------
    name : str
        "bullet" or "lmgc90".

    Raises
    ------
    InputError
        For another name.
    """
    if name not in ENGINES:
        raise InputError(f"no engine {name!r}; engines are: {', '.join(ENGINES)}")


def vector_of(value: Any, what: str, *, zero: bool = False) -> Floats:
    """Return a value as a vector.

    Parameters
    ----------
    value : sequence of three floats
        What was given.
    what : str
        What it is for; the message of an error begins with it.
    zero : bool
        Whether all three may be zero.

    Returns
    -------
    array of float, shape (3,)
        The vector.

    Raises
    ------
    InputError
        For anything but three finite numbers.
    """
    try:
        vector = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        vector = np.empty(0)  # refused below
    if vector.shape != (3,) or not np.isfinite(vector).all() or not (zero or vector.any()):
        raise InputError(f"{what} is {value!r}; it must be three numbers{'' if zero else ', not all zero'}")
    return vector


def not_negative(value: float, what: str) -> None:
    """Check that a number is finite and not negative.

    Parameters
    ----------
    value : float
        What was given.
    what : str
        What it is for; the message begins with it.

    Raises
    ------
    InputError
        For any other number.
    """
    if not (np.isfinite(value) and value >= 0):
        raise InputError(f"{what} is {value!r}; it must be 0 or more")
