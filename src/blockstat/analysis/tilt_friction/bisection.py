"""Values at which a parameter's verdict changes, closed in on by bisection and by the scores of what falls."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from blockstat.analysis.verdict import Outcome

#: Past a right angle there is no load multiplier; tilts are tried in steps of this many degrees and then halved.
STEP = 5.0
#: Bisections stop at this width (degrees, or friction).
WIDTH = 1e-6
#: Two values so far (of that width) on either side of a limit are a bracket of less than the width.
BESIDE = 0.45
#: An outcome and its score.
Answer = tuple[Outcome, float]
#: Gives the answer at a value.
Judge = Callable[[float], Answer]
#: A value that stands and one that falls.
Ends = tuple[float, float]


def is_closed(stands: float, falls: float, width: float) -> bool:
    """Return whether two values are as near as was asked, or no number lies between them; nan is near to nothing.

    Parameters
    ----------
    stands, falls
        The values.
    width
        How near they shall be.

    Returns
    -------
    bool
        True for a closed bracket.
    """
    return abs(falls - stands) <= max(width, float(np.spacing(max(abs(stands), abs(falls)))))


def scan(judge: Judge, top: float, width: float, stands: float = 0.0, falls: float = math.nan) -> Ends:
    """Find the first change from stable to not stable on the way up in steps, then close in on it.

    Parameters
    ----------
    judge
        Gives the answer at a value.
    top
        The last value.
    width
        Of the bracket.
    stands
        Where it is above 0, a value that is known to stand and close to the limit, so the first step is small.
    falls
        A value that is known to fall, or nan.

    Returns
    -------
    tuple of float
        A value that stands and one that falls, nan for none.
    """
    if not stands and (first := judge(0.0)[0]) is not Outcome.STABLE:
        return nowhere(first, 0.0)
    low, step = stands, width if stands else STEP
    while low < top:
        high = min(low + step, top)
        if (outcome := judge(high)[0]) is not Outcome.STABLE:
            beyond = {falls: Outcome.UNSTABLE} if falls > high else {}
            return close_in(judge, low, {high: outcome, **beyond}, width)
        low, step = high, STEP
    return top, math.nan


def nowhere(first: Outcome, value: float) -> tuple[float, float]:
    """Return the bracket of an assembly that does not stand at the value where it would stand first.

    Only a mechanism is a proof that it stands nowhere.

    Parameters
    ----------
    first
        The outcome there.
    value
        That value.

    Returns
    -------
    tuple of float
        As of `scan`.
    """
    return math.nan, value if first is Outcome.UNSTABLE else math.nan


def close_in(judge: Judge, stands: float, others: dict[float, Outcome], width: float = WIDTH) -> Ends:
    """Bring a value that stands and one that falls together; nan for the second where no fall is proven.

    Where values between are undecided, each is brought near to these on its own side.

    Parameters
    ----------
    judge
        Gives the answer at a value.
    stands
        A value that stands.
    others
        Values that do not, on one side of it, at least one, with their outcomes.
    width
        Of the bracket.

    Returns
    -------
    tuple of float
        As of `scan`.
    """
    tried = dict(others)

    def away(value: float) -> float:
        return abs(value - stands)

    stands, _ = _halved(judge, stands, min(others, key=away), width, tried, Outcome.STABLE)
    fell = [value for value, outcome in tried.items() if outcome not in (Outcome.STABLE, Outcome.UNDECIDED)]
    if not fell:
        return stands, math.nan
    falls = min(fell, key=away)
    doubts = [value for value, outcome in tried.items() if outcome is Outcome.UNDECIDED and away(value) < away(falls)]
    if doubts:
        # Quarters leave half of the width to undecided values that are only numerical.
        _, falls = _halved(judge, max(doubts, key=away), falls, width / 4, tried, Outcome.STABLE, Outcome.UNDECIDED)
        stands, _ = _halved(judge, stands, min(doubts, key=away), width / 4, tried, Outcome.STABLE)
    return stands, falls


def _halved(judge: Judge, near: float, far: float, width: float, tried: dict[float, Outcome], *inside: Outcome) -> Ends:
    """Bring a value whose outcome is `inside` and one whose outcome is not together; values tried are noted.

    The score of what falls vanishes towards the limit, nearly along a line. So the places just beside the zero of the
    line through the last two scores are tried, and the middle wherever that has not halved the bracket.
    """
    scores: list[tuple[float, float]] = []
    aims = True
    while (wide := abs(far - near)) > width:
        aim = _beside_the_zero(scores, near, far, width) if aims else None
        trial = (near + far) / 2 if aim is None else aim
        if trial in (near, far):
            break  # no number lies between them
        outcome, score = judge(trial)
        tried[trial] = outcome
        if outcome in inside:
            near = trial
        else:
            far = trial
            falls = outcome is not Outcome.UNDECIDED and math.isfinite(score) and score > 0
            scores = [*scores[-1:], (trial, score)] if falls else scores
        aims = aim is None or abs(far - near) <= wide / 2
    return near, far


def _beside_the_zero(scores: Sequence[tuple[float, float]], near: float, far: float, width: float) -> float | None:
    """A value next to the zero of the line through two scores, on the side not yet known; None where there is none."""
    if len(scores) < 2 or scores[0][1] <= scores[1][1]:
        return None
    (one, high), (other, low) = scores
    zero = other + low * (other - one) / (high - low)
    aside = math.copysign(BESIDE * width, near - far)
    inside = (value for value in (zero + aside, zero - aside) if min(near, far) < value < max(near, far))
    return next(inside, None)
