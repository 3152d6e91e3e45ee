"""A reference value next to the computation that has to meet it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from blockstat import Outcome, assess, limit_load, tilt_limit

INF = math.inf


class Value(NamedTuple):
    """What we answer, and the distance between what is proven to stand and what is proven to fall."""

    ours: float
    bracket: float = math.nan


@dataclass(frozen=True)
class Row:
    """One reference.

    tag : E exact, P published, D derived from first principles by two methods, d by one.
    reference : as printed, and then met to half a unit of its last digit; a number is met to a millionth.
    """

    tag: str
    name: str
    reference: str | float
    compute: Callable[[], Value]
    within: float | None = None  #: error accepted instead, where the source says "about"
    slow: bool = False  #: takes more than about ten seconds

    @property
    def value(self) -> float:
        return float(self.reference)

    @property
    def accepted(self) -> float:
        """Largest error that still agrees with the reference as it is printed."""
        if self.within is not None:
            return self.within
        if isinstance(self.reference, str):
            return 0.5 * 10.0 ** -len(self.reference.partition(".")[2]) * (1 + 1e-9)
        return 1e-6 * abs(self.value)


def limit(asm, load, **options) -> Value:
    found = limit_load(asm, load, **options)
    return Value(found.lower, found.upper - found.lower)


def zero_dilatancy(asm, load) -> Value:
    low, high = limit_load(asm, load, flow="coulomb").coulomb or (math.nan, math.nan)
    return Value(low, high - low)


def tilt(asm, axis="y", **options) -> Value:
    found = tilt_limit(asm, axis, **options)
    return Value(found.stands, found.falls - found.stands)


def between(stands: float, falls: float, outcome: Callable[[float], Outcome], width: float) -> Value:
    """Bisection on a verdict between a value that stands and one that falls; an undecided verdict ends it."""
    assert (outcome(stands), outcome(falls)) == (Outcome.STABLE, Outcome.UNSTABLE)
    while abs(falls - stands) > width:
        middle = (stands + falls) / 2
        found = outcome(middle)
        if found is Outcome.UNDECIDED:
            break
        stands, falls = (middle, falls) if found is Outcome.STABLE else (stands, middle)
    return Value((stands + falls) / 2, abs(falls - stands))


def stands(asm, **options) -> Outcome:
    return assess(asm, **options).outcome
