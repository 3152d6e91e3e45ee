"""Walks through a space: one parameter after the other, or every combination.

The paper's walk simulates every design it comes by. The pruned one finds the same answer from the other end: along one
parameter the answer is the smallest value that stands, in a grid the design of least volume that stands, so designs are
asked in that order and the first that stands is the answer. Whatever statics exclude on the way needs no simulation.
Nothing is assumed about the order of standing and falling: every design that is better than the answer has been judged,
so both walks end at the same one in spaces of any kind, monotone or not.
"""

from __future__ import annotations

from collections.abc import Callable

from blockstat.design_search.evaluator import Evaluator
from blockstat.design_search.space import Values
from blockstat.errors import InputError

#: Lines with more values than this are first bisected.
LONG = 16

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
    standing = [candidate for candidate in found if candidate.stands and candidate.volume is not None]
    return min(standing, key=lambda candidate: candidate.volume or 0.0).parameters if standing else None


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
    weighed = []
    for values in evaluator.space.grid():
        evaluator.check_cancelled()
        try:
            weighed.append((evaluator.weigh(values), values))
        except InputError:
            continue  # it cannot stand
    # Sorting keeps the order of equals.
    return evaluator.first_that_stands([values for _, values in sorted(weighed, key=lambda pair: pair[0])])


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
