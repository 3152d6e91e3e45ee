"""Checks of the names of engines, and of times that loads are made with."""

from __future__ import annotations

import numpy as np

from blockstat.errors import InputError

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
