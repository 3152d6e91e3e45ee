"""Processes that end when they should: with the program that started them, and when they are interrupted.

A command imports this module first, and SIGINT leaves a stack trace until `end_when_interrupted` has been called. So
other modules are imported inside functions, and in place of signal, which imports enum, the module below it.
"""

from __future__ import annotations

import _signal  # pyright: ignore[reportMissingImports]
import _thread
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

INTERRUPTED = 130  #: exit status of a program that SIGINT ended, as shells have it
BEAT = 0.5  #: how often a process looks after its parent [s]
LATER = 0.01  #: after which an interrupt that was lost is raised again [s]


def end_with_parent() -> None:
    """Let this process end soon after the one that started it, whatever it is doing.

    An orphan is given another parent by the system; on Windows, where it is not, nothing happens.
    """
    import threading
    import time

    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(BEAT)
        os._exit(INTERRUPTED)

    threading.Thread(target=watch, name="parent", daemon=True).start()


def end_when_interrupted(prog: str) -> None:
    """Let SIGINT end this process with one line, even while it imports or cleans up.

    Parameters
    ----------
    prog : str
        The name of the command, which begins the line.
    """

    def end(*_: Any) -> None:
        os.write(sys.__stderr__.fileno() if sys.__stderr__ else 2, f"{prog}: interrupted\n".encode())
        os._exit(INTERRUPTED)

    _handle(end)


def _lost(error: Any) -> None:
    """Raise an interrupt again that came in a finalizer, where Python drops it with a stack trace."""
    if error.exc_type is KeyboardInterrupt:
        _thread.start_new_thread(_interrupt_again, ())
    else:
        sys.__unraisablehook__(error)


def _interrupt_again() -> None:
    """Interrupt the main thread as SIGINT does, when it has left the finalizer."""
    import time

    time.sleep(LATER)
    _thread.interrupt_main()


def _handle(handler: Any) -> None:
    """Set what SIGINT does, if this is the main thread; others cannot."""
    try:
        _signal.signal(_signal.SIGINT, handler)
    except ValueError:
        pass


def end_now(status: int) -> None:
    """End this process with a status, after what was registered for its end.

    Python gives a status of its own where the interrupt passed through code that was compiled on the spot.

    Parameters
    ----------
    status : int
        For the shell.
    """
    import atexit

    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(status)


class Interruptions:
    """Whether SIGINT came: libraries turn the KeyboardInterrupt that it raises into errors of their own."""

    def __init__(self) -> None:
        self.came = False

    def heed(self) -> None:
        """Raise KeyboardInterrupt at SIGINT from now on, and remember it."""
        _handle(self._interrupt)
        if sys.unraisablehook is sys.__unraisablehook__:
            sys.unraisablehook = _lost

    def ignore(self) -> None:
        """Let SIGINT do nothing from now on, to the very end of the process."""
        _handle(_signal.SIG_IGN)

    def _interrupt(self, *_: Any) -> None:
        self.came = True
        raise KeyboardInterrupt
