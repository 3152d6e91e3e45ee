"""Progress where there is no terminal: plain lines, not too many."""

from __future__ import annotations

import sys
from time import monotonic

EVERY = 2.0  #: time between two lines [s]


class PlainLines:
    """Prints a line to standard error at most every two seconds, and the first after the first two.

    Examples
    --------
    >>> line = PlainLines()
    >>> line("nothing yet: less than two seconds have passed")
    """

    def __init__(self) -> None:
        self._last = monotonic()

    def __call__(self, text: str) -> None:
        """Print a line where one is due.

        Parameters
        ----------
        text : str
            The line.
        """
        if monotonic() - self._last >= EVERY:
            self._last = monotonic()
            print(text, file=sys.stderr, flush=True)
