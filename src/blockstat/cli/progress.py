"""What is shown while a bracket closes: one line on a terminal, and elsewhere a line every two seconds."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from blockstat.system.lines import PlainLines


@contextmanager
def shown_progress() -> Iterator[Callable[[int, float, float], None]]:
    """Show the iterations of a limit analysis on standard error; on a terminal the line goes away at the end.

    Yields
    ------
    callable
        As `progress` of `blockstat.limit_load`.
    """

    def words(iteration: int, reached: float, upper: float) -> str:
        return f"iteration {iteration}: {max(reached, 0.0):.6g} reached, at most {upper:.6g} (Ctrl-C keeps the bracket)"

    if not sys.stderr.isatty():
        line = PlainLines()
        yield lambda *state: line(words(*state))
        return

    def show(*state: Any) -> None:
        sys.stderr.write(f"\r\x1b[K{words(*state)}")
        sys.stderr.flush()

    try:
        yield show
    finally:
        sys.stderr.write("\r\x1b[K")
        sys.stderr.flush()
