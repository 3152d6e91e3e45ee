"""Walks through a space: one parameter after the other, or every combination.

The paper's walk simulates every design it comes by. The pruned one finds the same answer from the other end: along one
parameter the answer is the smallest value that stands, in a grid the design of least volume that stands, so designs are
asked in that order and the first that stands is the answer. Whatever statics exclude on the way needs no simulation.
Nothing is assumed about the order of standing and falling: every design that is better than the answer has been judged,
so both walks end at the same one in spaces of any kind, monotone or not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from blockstat.design_search.evaluator import Evaluator
from blockstat.design_search.space import Values
from blockstat.errors import InputError

#: Lines with more values than this are first bisected.
LONG = 16
#: Volumes that differ by less than this share are one: sums of the same blocks that were rounded otherwise.
SAME = 1e-9

T = TypeVar("T")
Walk = Callable[[Evaluator], Values | None]


def paper_line(evaluator: Evaluator) -> Values | None:
    """Move each parameter in its turn: every value is simulated, the smallest that stands is kept.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.

    Returns
    -------
    dict of str to float, or None
        Parameter values of the answer; None where no design stands.
    """
    best, stood = evaluator.space.start, False
    for name in evaluator.space.names:
        line = [{**best, name: value} for value in evaluator.space.line(name)]
        standing = [values for values in line if evaluator.ask(values, always=True).stands]
        if standing:
            best, stood = min(standing, key=lambda values: values[name]), True
    return best if stood else None


def pruned_line(evaluator: Evaluator) -> Values | None:
    """Find the answer of `paper_line`: each parameter from its smallest value up to the first that stands.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.

    Returns
    -------
    dict of str to float, or None
        Parameter values of the answer; None where no design stands.
    """
    best, stood = evaluator.space.start, False
    for name in evaluator.space.names:
        line = [{**best, name: value} for value in sorted(evaluator.space.line(name))]
        if len(line) > LONG:
            _bisect(evaluator, line)
        standing = evaluator.first_that_stands(line)
        if standing is not None:
            best, stood = standing, True
    return best if stood else None


def _bisect(evaluator: Evaluator, line: list[Values]) -> None:
    """Look for where statics begin to allow designs, as if that happened once.

    What is found is not trusted: each smaller value is still judged. But the evidence of designs close to the limit is
    then known, with which others may be decided without a solve.
    """
    low, high = -1, len(line)
    while high - low > 1:
        middle = (low + high) // 2
        if evaluator.ask(line[middle], dynamics=False).excluded:
            low = middle
        else:
            high = middle


def by_volume(designs: Sequence[T], volumes: Sequence[float]) -> list[T]:
    """Order designs from the lightest on; of equals the first stays first.

    Parameters
    ----------
    designs : sequence
        The designs, of any kind.
    volumes : sequence of float
        Of each [m3]; they are equal where they differ by no more than rounding.

    Returns
    -------
    list
        The same designs.

    Examples
    --------
    >>> by_volume(["heavy", "first", "second"], [0.4, 0.1 + 0.2, 0.3])
    ['first', 'second', 'heavy']
    """
    volume = np.asarray(volumes, dtype=float)
    order = np.argsort(volume, kind="stable")
    level = np.empty(len(volume), dtype=int)
    level[order] = np.cumsum(np.diff(volume[order], prepend=0.0) > SAME * volume[order])
    return [designs[k] for k in np.argsort(level, kind="stable")]


def paper_grid(evaluator: Evaluator) -> Values | None:
    """Simulate every combination; the lightest that stands is kept, of equals the first.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.

    Returns
    -------
    dict of str to float, or None
        Parameter values of the answer; None where no design stands.
    """
    found = [evaluator.ask(values, always=True) for values in evaluator.space.grid()]
    weighed = [
        (candidate, candidate.volume) for candidate in found if candidate.stands and candidate.volume is not None
    ]
    standing = by_volume([c for c, _ in weighed], [volume for _, volume in weighed])
    return standing[0].parameters if standing else None


def pruned_grid(evaluator: Evaluator) -> Values | None:
    """Find the answer of `paper_grid`: from the lightest combination up to the first that stands.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.

    Returns
    -------
    dict of str to float, or None
        Parameter values of the answer; None where no design stands.
    """
    built, volumes = list[Values](), list[float]()
    for values in evaluator.space.grid():
        evaluator.check_cancelled()
        try:
            volumes.append(evaluator.weigh(values))
        except InputError:
            evaluator.unbuilt += 1  # it cannot stand
            continue
        built.append(values)
    return evaluator.first_that_stands(by_volume(built, volumes))


WALKS: dict[tuple[str, str], Walk] = {
    ("paper", "line"): paper_line,
    ("paper", "grid"): paper_grid,
    ("pruned", "line"): pruned_line,
    ("pruned", "grid"): pruned_grid,
}


def expected(evaluator: Evaluator, over: str) -> int:
    """Return the number of designs that a walk comes by at most.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.
    over : {"line", "grid"}
        One parameter after the other, or every combination.

    Returns
    -------
    int
    """
    if over == "grid":
        return evaluator.space.size
    return 1 + sum(len(evaluator.space.line(name)) - 1 for name in evaluator.space.names)
