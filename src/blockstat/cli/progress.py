"""What a terminal shows while a bracket closes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def shown_progress() -> Iterator[Callable[[int, float, float], None] | None]:
    """Show the iterations of a limit analysis on one line of a terminal, and take it away at the end.

    Yields
    ------
    callable or None
        As `progress` of `blockstat.limit_load`; None where standard error is not a terminal.
    """
    if not sys.stderr.isatty():
        yield None
        return

    def show(iteration: int, reached: float, upper: float) -> None:
        line = f"iteration {iteration}: {max(reached, 0.0):.6g} reached, at most {upper:.6g} (Ctrl-C keeps the bracket)"
        sys.stderr.write(f"\r\x1b[K{line}")
        sys.stderr.flush()

    try:
        yield show
    finally:
        sys.stderr.write("\r\x1b[K")
        sys.stderr.flush()
