"""The one exception that bad input raises, and checks of single physical values that raise it."""

from __future__ import annotations

from typing import Any

import numpy as np

from blockstat.typing import Floats

HUGE = 1e30  #: no length, density or acceleration of a building comes near it


class InputError(ValueError):
    """The input cannot be used; the message says what was given, where, and what is allowed.

    The command line prints the message on one line and exits with status 2.
    """


class InputWarning(UserWarning):
    """The input can be used, but a person should look at it."""


def check_density(label: str, value: Any) -> float:
    """A density [kg/m3] of the block with this label."""
    number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    if not number or not 0 < value < HUGE:
        raise InputError(f'block "{label}": density is {value!r}; it must be a positive number of kg/m3')
    return float(value)


def check_friction(value: Any) -> float:
    """A coefficient of friction."""
    if not isinstance(value, (int, float, np.number)) or isinstance(value, bool) or not value >= 0:
        raise InputError(f"friction is {value!r}; it must be a number of at least 0 (inf for no sliding)")
    return float(value)


def check_gravity(value: Any) -> Floats:
    """A gravity vector [m/s2], shape (3,)."""
    try:
        gravity = np.array(value, dtype=float)
    except (TypeError, ValueError):
        gravity = np.array([np.nan])
    if gravity.shape != (3,) or not 1 / HUGE < np.linalg.norm(gravity) < HUGE:
        raise InputError(f"gravity is {value!r}; it must be three numbers gx, gy, gz in m/s2, not all zero")
    return gravity
