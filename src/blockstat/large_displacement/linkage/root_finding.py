"""Where a function along a path changes its sign."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class NoRootError(ArithmeticError):
    """A change of sign that was expected is not there: what the function stands for could not be followed."""


def root_of(function: Callable[[float], float], low: float, high: float, accuracy: float) -> float:
    """Return where a function changes its sign, by Brent's method.

    Parameters
    ----------
    function
        Of one number.
    low, high
        Between which its sign changes.
    accuracy
        Absolute, of the root.

    Returns
    -------
    float
        The root.

    Raises
    ------
    NoRootError
        When the sign is the same at both ends.
    """
    from scipy.optimize import brentq

    if not function(low) * function(high) <= 0:
        raise NoRootError
    found: Any = brentq(function, low, high, xtol=accuracy)
    return float(found)
