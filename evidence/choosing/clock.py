"""Process time of a computation."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import TypeVar

T = TypeVar("T")
#: Computations that take less than this in sum [s] are repeated, up to so many times.
ENOUGH, MOST = 0.5, 5


def timed(compute: Callable[[], T], most: int = MOST) -> tuple[T, float]:
    """What is computed, and the least process time of one or a few computations [s]."""
    spent: list[float] = []
    while True:
        begin = process_time()
        found = compute()
        spent.append(process_time() - begin)
        if sum(spent) >= ENOUGH or len(spent) == most:
            return found, min(spent)
