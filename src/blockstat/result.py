"""What all answers have in common: an outcome that is a sentence, an explanation, plain values, and HTML."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from html import escape
from typing import Any

import numpy as np

ALIKE = 8  #: names that are listed where one does not exist, those like it first


class Sentence(Enum):
    """An answer whose value is the sentence that a user reads.

    Examples
    --------
    >>> from blockstat import Outcome
    >>> Outcome.STABLE.word
    'stable'
    """

    @property
    def word(self) -> str:
        """The answer in one word, as JSON and tables give it."""
        return self.name.lower()


class Unfinished(Sentence):
    """The answer on several things, one after the other, where an interrupt came before the last."""

    STOPPED = "Stopped: an interrupt came before every step was judged."


class Result:
    """The common face of results.

    A subclass has an attribute `outcome`, a `Sentence`, and says how it explains itself and which plain values it has.
    """

    def explain(self) -> str:
        """Return the answer and its evidence in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        raise NotImplementedError

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; what is infinite or not a number is None.

        Returns
        -------
        dict
            Values by name.
        """
        raise NotImplementedError

    def __str__(self) -> str:
        return self.explain()

    def _repr_html_(self) -> str:
        return f'<pre style="white-space: pre-wrap">{escape(self.explain())}</pre>'


def finite(value: float) -> float | None:
    """Return a value as JSON can hold it.

    Parameters
    ----------
    value : float
        Any number.

    Returns
    -------
    float or None
        None for what is infinite or not a number.
    """
    return float(value) if np.isfinite(value) else None


def plain(value: float, digits: int = 3) -> str:
    """Return a number as engineers write it: significant digits, thousands apart, no power of ten for large numbers.

    Parameters
    ----------
    value : float
        In the unit that follows it.
    digits : int, optional
        Significant digits; a number of more digits before its point is rounded to whole ones.

    Returns
    -------
    str
        The number without its unit.

    Examples
    --------
    >>> from blockstat.result import plain
    >>> [plain(number) for number in (1020.0, 295.04, 0.0123, 2.5e-7, 1.4e6)]
    ['1,020', '295', '0.0123', '2.5e-07', '1,400,000']
    >>> plain(1170.3, 4), plain(250.1, 2)
    ('1,170', '250')
    """
    return f"{value:,.0f}" if abs(value) >= min(1000, 10**digits) else f"{value:.{digits}g}"


def both_ends(first: float, second: float, digits: int) -> tuple[str, str]:
    """Return two ends of a bracket as text, with as many digits as tell them apart.

    Parameters
    ----------
    first, second : float
        The numbers.
    digits : int
        Significant digits, if these tell them apart or nothing does.

    Returns
    -------
    tuple of str
        Both.

    Examples
    --------
    >>> from blockstat.result import both_ends
    >>> both_ends(0.25, 0.3, 4), both_ends(0.13412, 0.13414, 4)
    (('0.25', '0.3'), ('0.13412', '0.13414'))
    """
    pairs = [(f"{first:.{few}g}", f"{second:.{few}g}") for few in range(digits, 18)]
    return next((pair for pair in pairs if pair[0] != pair[1]), pairs[0])


def counted(number: int, word: str) -> str:
    """Return a number of things in words: "1 joint", "12 joints", "3,155 blocks".

    Parameters
    ----------
    number : int
        How many.
    word : str
        One of them; its plural has an s more.

    Returns
    -------
    str
        The number with its noun.

    Examples
    --------
    >>> from blockstat.result import counted
    >>> counted(1, "joint"), counted(3155, "block")
    ('1 joint', '3,155 blocks')
    """
    return f"{number:,} {word}" + ("" if number == 1 else "s")


def listed(names: Sequence[str], limit: int) -> str:
    """Return some names in words: the first ones, and how many there are more.

    Parameters
    ----------
    names : sequence of str
        All of them.
    limit : int
        How many are named at most.

    Returns
    -------
    str
        Separated by commas.

    Examples
    --------
    >>> from blockstat.result import listed
    >>> listed(["a", "b", "c", "d"], 2), listed(["a", "b"], 2)
    ('a, b and 2 more', 'a, b')
    """
    more = f" and {len(names) - limit:,} more" if len(names) > limit else ""
    return ", ".join(names[:limit]) + more


def names_like(names: Sequence[str], given: str) -> str:
    """Return names of blocks in words: of many those that are spelled like one that was given, and the first.

    Parameters
    ----------
    names : sequence of str
        All of them.
    given : str
        A name that none of them has.

    Returns
    -------
    str
        Separated by commas; in quotes where one has a comma, which parts the names of a list in an option's text.

    Examples
    --------
    >>> from blockstat.result import names_like
    >>> names_like(["pier", "wall"], "peer")
    'pier, wall'
    """
    from difflib import get_close_matches

    shown, more = list(names), ""
    if len(names) > ALIKE:
        close = get_close_matches(given, names)
        shown = [*close, *[name for name in names if name not in close][: ALIKE - len(close)]]
        more = f", ... ({len(names)} in all)"
    if not any("," in name for name in shown):
        return ", ".join(shown) + more
    quoted = ", ".join(f'"{name}"' for name in shown)
    return f"{quoted}{more}; commas part the names of a list, so give a block whose name has one by its number, from 0"


NANOMETRE = 1e-9  #: a length below this is rounding: no block moves by less than an atom [m]


def millimetres(length: float, digits: int = 3) -> str:
    """Return a length in millimetres as engineers write it; 0 where it is rounding.

    Parameters
    ----------
    length : float
        In metres.
    digits : int, optional
        Significant digits, as in `plain`.

    Returns
    -------
    str
        The number without its unit.

    Examples
    --------
    >>> from blockstat.result import millimetres
    >>> [millimetres(length) for length in (0.0123, -5.2e-13, 2e-8)]
    ['12.3', '0', '2e-05']
    """
    return plain(1e3 * length, digits) if abs(length) >= NANOMETRE else "0"
