"""Bisection between a value where something holds and one where it does not."""

from __future__ import annotations

from collections.abc import Callable


def bisect(holds: Callable[[float], bool], inside: float, outside: float, width: float) -> tuple[float, float]:
    """Values at most `width` apart: the first, where it holds, and the second, where it does not.

    That it holds at `inside` and not at `outside` is taken for granted; either may be the greater.
    """
    while abs(outside - inside) > width:
        middle = (inside + outside) / 2
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return inside, outside
