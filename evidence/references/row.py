"""A reference value next to the computation that has to meet it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from blockstat import Outcome, assess, limit_load, tilt_limit
from evidence.bisection import bisect

INF = math.inf


class Value(NamedTuple):
    """What we answer, and the distance between what is proven to stand and what is proven to fall."""

    ours: float
    bracket: float = math.nan


@dataclass(frozen=True)
class Row:
    """One reference.

    tag : E exact, P published, D derived from first principles by two methods, d by one.
    source : a formula or a method, or works as docs/bibliography.md calls them; always the latter for P.
    reference : as printed, and then met to half a unit of its last digit (a unit where it was derived: some are cut off
    and not rounded); a number is met to a millionth.
    """

    tag: str
    name: str
    source: str
    reference: str | float
    compute: Callable[[], Value]
    within: float | None = None  #: error accepted instead, where the source says "about"
    needs: Path | None = None  #: data without which it cannot be computed
    slow: bool = False  #: takes more than about ten seconds

    @property
    def test(self) -> str:
        """Name of the test that asks for it: tests/validation/test_references.py::test_reference[...]."""
        return f"{self.tag} {self.name}"

    @property
    def missing(self) -> bool:
        return self.needs is not None and not self.needs.exists()

    @property
    def value(self) -> float:
        return float(self.reference)

    @property
    def accepted(self) -> float:
        """Largest error that still agrees with the reference as it is printed."""
        if self.within is not None:
            return self.within
        if isinstance(self.reference, str):
            unit = 10.0 ** -len(self.reference.partition(".")[2])
            return (1.0 if self.tag in "Dd" else 0.5) * unit * (1 + 1e-9)
        return 1e-6 * abs(self.value)


def limit(asm, load, **options) -> Value:
    found = limit_load(asm, load, optimum=True, **options)
    return Value(found.lower, found.upper - found.lower)


def zero_dilatancy(asm, load) -> Value:
    """That of joints both open and elastic, to which the published minima belong; other kinds carry less or more."""
    low, high = ((math.nan, math.nan), *limit_load(asm, load, flow="coulomb").coulomb_kinds)[-1]
    return Value(low, high - low)


def tilt(asm, axis="y", **options) -> Value:
    found = tilt_limit(asm, axis, **options)
    return Value(found.stands, found.falls - found.stands)


def between(stands: float, falls: float, outcome: Callable[[float], Outcome], width: float) -> Value:
    """Middle of the gap between the last value seen to stand and the first seen to fall, and its width."""
    assert (outcome(stands), outcome(falls)) == (Outcome.STABLE, Outcome.UNSTABLE)
    stands, next_to = _edge(stands, falls, lambda x: outcome(x) is Outcome.STABLE, width)
    falls, _ = _edge(falls, next_to, lambda x: outcome(x) is Outcome.UNSTABLE, width)
    return Value((stands + falls) / 2, abs(falls - stands))


def _edge(inside: float, outside: float, holds: Callable[[float], bool], width: float) -> tuple[float, float]:
    """Neighbouring values where something holds and where it does not, if there are such."""
    return (outside, outside) if holds(outside) else bisect(holds, inside, outside, width)


def stands(asm, **options) -> Outcome:
    return assess(asm, **options).outcome
