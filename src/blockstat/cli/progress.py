"""What is shown while a command works: one line on a terminal, and elsewhere a line every two seconds."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from blockstat.system.lines import PlainLines

#: The line is renewed this often [s].
BEAT = 0.5
#: The kinds of joints of `blockstat.analysis.coulomb.FAMILY`, in words.
KINDS = ("stiff joints", "elastic joints", "joints both stiff and elastic")


@contextmanager
def at_work(text: str) -> Iterator[Callable[[str], None]]:
    """Show on standard error what is being done and for how long; on a terminal the line goes away at the end.

    Parameters
    ----------
    text : str
        What is being done at first.

    Yields
    ------
    callable
        Takes what is being done from then on.
    """
    said, over, begin = [text], threading.Event(), monotonic()
    on_terminal = sys.stderr.isatty()
    plain = PlainLines()

    def show() -> None:
        while not over.wait(BEAT):
            line = f"{said[0]}, {monotonic() - begin:.0f} s"
            if on_terminal:
                print(f"\r\x1b[K{line}", end="", file=sys.stderr, flush=True)
            else:
                plain(line)

    thread = threading.Thread(target=show, name="progress", daemon=True)
    thread.start()
    try:
        yield lambda new: said.__setitem__(0, new)
    finally:
        over.set()
        thread.join()
        if on_terminal:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


@contextmanager
def shown_progress(*, kept: bool = True) -> Iterator[Callable[[int, float, float], None]]:
    """Show the iterations of a limit analysis on standard error.

    Parameters
    ----------
    kept : bool, optional
        Whether the command answers with the bracket that an interrupt leaves.

    Yields
    ------
    callable
        As `progress` of `blockstat.limit_load`.
    """
    with at_work("limit load") as say:
        kinds = 0

        def show(iteration: int, reached: float, upper: float) -> None:
            nonlocal kinds
            kinds += iteration == 0
            if kinds:
                kind = KINDS[(kinds - 1) % len(KINDS)]
                text = f"without dilatancy, {kind}, trial {iteration}: {reached:.5g} to {upper:.5g}"
            else:
                text = f"iteration {iteration}: {max(reached, 0.0):.6g} reached, at most {upper:.6g}"
            say(f"{text} (Ctrl-C keeps the bracket)" if kept else text)

        yield show
