"""Exact numbers: arrays of `fractions.Fraction`, and how they are written.

A float is taken for the shortest decimal that rounds to it, the one that Python prints: the 0.1 of a file is one tenth.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from blockstat.typing import Floats

#: An array of objects, all of them fractions.
Exact = Any


def exact(values: Floats | float) -> Exact:
    """Return floats as the decimals that Python prints.

    Parameters
    ----------
    values
        Of any shape, all finite.

    Returns
    -------
    array of Fraction
        Of the same shape.

    Examples
    --------
    >>> exact(np.array([0.1, 2.5])).tolist()
    [Fraction(1, 10), Fraction(5, 2)]
    """
    array = np.asarray(values, dtype=float)
    fractions = np.array([Fraction(repr(x)) for x in array.ravel().tolist()], dtype=object)
    return fractions.reshape(array.shape)


def rounded(values: Any, places: int) -> Exact:
    """Round numbers to so many decimal places.

    Parameters
    ----------
    values
        Floats or fractions, of any shape.
    places
        May be negative.

    Returns
    -------
    array of Fraction
        Of the same shape.
    """
    array = np.asarray(values)
    unit = Fraction(10) ** places
    fractions = np.array([Fraction(round(Fraction(x) * unit)) / unit for x in array.ravel().tolist()], dtype=object)
    return fractions.reshape(array.shape)


def text(value: Fraction) -> str:
    """Write a fraction: as a decimal where it is one, else as a fraction.

    Parameters
    ----------
    value
        Any.

    Returns
    -------
    str
        What `Fraction` reads back.

    Examples
    --------
    >>> [text(Fraction(*x)) for x in ((1, 40), (-7, 3), (-5, 1))]
    ['0.025', '-7/3', '-5']
    """
    below, places = value.denominator, 0
    for prime in (2, 5):
        count = 0
        while below % prime == 0:
            below, count = below // prime, count + 1
        places = max(places, count)
    if below > 1:
        return str(value)
    digits = str(abs(value.numerator) * 10**places // value.denominator).rjust(places + 1, "0")
    sign = "-" if value < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)


def written(values: Exact) -> Any:
    """Write an array of fractions as nested lists of texts.

    Parameters
    ----------
    values
        Of any shape.

    Returns
    -------
    list
        Of the same shape.
    """
    return [written(row) for row in values] if isinstance(values, np.ndarray | list) else text(values)
