"""Work in another process: it reports by messages, ends at once when told to, and never holds up the page."""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from blockstat.system.process import end_with_parent

#: Imported once by the process that all workers are forked from, so that each starts in milliseconds.
PRELOADED = (
    "__main__",
    "blockstat.app.evaluation",
    "blockstat.model",
    "blockstat.solve.interior_point",
    "scipy.sparse.linalg",
    "scipy.spatial",
    "pypardiso",
)


@dataclass(frozen=True)
class Limits:
    """What work for the page may use before it is stopped.

    Attributes
    ----------
    seconds : float
        Of one verdict, of its slower results, and of reading an uploaded file [s].
    gigabytes : float
        Of memory in each process [GB = 1e9 bytes]. The system holds a process to it on Linux only.
    """

    seconds: float = 300.0
    gigabytes: float = 4.0

    @property
    def too_long(self) -> str:
        """What is said of work that took too long."""
        return f"stopped after {self.seconds:g} s; `--most-seconds` of the command allows more"

    @property
    def too_large(self) -> str:
        """What is said of work that needs too much memory."""
        return f"stopped at {self.gigabytes:g} GB of memory; `--most-gigabytes` of the command allows more"

    def hold(self) -> None:
        """Hold this process to the memory."""
        try:
            import resource
        except ImportError:  # Windows has none
            return
        if hasattr(resource, "RLIMIT_DATA"):
            most = int(self.gigabytes * 1e9)
            _, hard = resource.getrlimit(resource.RLIMIT_DATA)
            least = most if hard == resource.RLIM_INFINITY else min(most, hard)
            resource.setrlimit(resource.RLIMIT_DATA, (least, hard))


class Channel:
    """The worker's end of a connection: what it was asked, and the way back to the page.

    Parameters
    ----------
    connection : multiprocessing.connection.Connection
        The worker's end of a pipe.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def send(self, message: Any) -> None:
        """Report to the page.

        Parameters
        ----------
        message : object
            Anything that can be pickled.
        """
        self._connection.send(message)

    def receive(self) -> Any:
        """Return the newest thing asked, and wait for one if there is none.

        Older ones are dropped.

        Returns
        -------
        object
            What the page sent last.

        Raises
        ------
        EOFError
            When the page has closed the connection.
        """
        message = self._connection.recv()
        while self._connection.poll():
            message = self._connection.recv()
        return message

    @property
    def waiting(self) -> bool:
        """Whether something newer was asked."""
        return self._connection.poll()


@dataclass(frozen=True)
class Refused:
    """Why what a worker was asked cannot be done.

    Attributes
    ----------
    message : str
        The reason, in words.
    """

    message: str


class Ended:
    """The last message of every worker, however it ended."""


class Crashed(Ended):
    """The worker raised an exception, was killed by something else, or used more than its limits allow.

    Parameters
    ----------
    message : str
        What happened, in words.
    """

    def __init__(self, message: str) -> None:
        self.message = message


class Worker:
    """A function of a `Channel` in a process of its own.

    Parameters
    ----------
    work : callable
        A function of a module. It is called in the process as ``work(channel, *arguments)``.
    *arguments : object
        Further arguments of `work`; they can be pickled.
    report : callable
        Called as ``report(worker, message)`` with each message of the worker, and at last with an `Ended`. It runs in a
        thread that waits for messages. It is not called after `stop`.
    limits : Limits, optional
        The memory that the process may use.
    timed : bool, optional
        Whether the worker is also stopped when it has said nothing for as long as the limits allow.
    """

    def __init__(
        self,
        work: Callable[..., None],
        *arguments: Any,
        report: Callable[[Worker, Any], None],
        limits: Limits | None = None,
        timed: bool = False,
    ) -> None:
        context: Any = multiprocessing.get_context(_method())
        parent_end, child_end = context.Pipe()
        self._connection, self._report = parent_end, report
        self._stopped, self._limits, self._timed = False, limits or Limits(), timed
        self._process = context.Process(target=_run, args=(work, child_end, arguments, self._limits), daemon=True)
        self._process.start()
        child_end.close()
        threading.Thread(target=self._listen, daemon=True).start()

    def send(self, message: Any) -> None:
        """Ask for something; nothing happens if the worker has ended.

        Parameters
        ----------
        message : object
            Anything that can be pickled.
        """
        try:
            self._connection.send(message)
        except (BrokenPipeError, OSError):
            pass

    def stop(self) -> None:
        """End the worker now, whatever it is doing."""
        self._stopped = True
        self._process.kill()

    @property
    def running(self) -> bool:
        """Whether the worker is at work."""
        return not self._stopped and self._process.is_alive()

    def _listen(self) -> None:
        last: Ended = Crashed("the worker was ended from outside")
        while True:
            try:
                if not self._connection.poll(self._limits.seconds if self._timed else None):
                    last = Crashed(self._limits.too_long)
                    self._process.kill()
                    break
                message = self._connection.recv()
            except (EOFError, OSError):
                break
            if isinstance(message, Ended):
                last = message
            elif not self._stopped:
                self._report(self, message)
        self._process.join()
        self._connection.close()
        if not self._stopped:
            self._report(self, last)


def prepare() -> None:
    """Start the process that workers are forked from, so that the first worker does not wait for its imports."""
    if _method() == "forkserver":
        from multiprocessing import forkserver

        multiprocessing.get_context("forkserver").set_forkserver_preload(list(PRELOADED))
        forkserver.ensure_running()


def _method() -> str:
    return "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"


def _run(work: Callable[..., None], connection: Connection, arguments: tuple, limits: Limits) -> None:
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C in the terminal is the page's business
    end_with_parent()
    channel = Channel(connection)
    limits.hold()
    try:
        work(channel, *arguments)
        channel.send(Ended())
    except (EOFError, BrokenPipeError, OSError):
        pass  # the page is gone
    except MemoryError:
        channel.send(Crashed(limits.too_large))
    except Exception as error:
        channel.send(Crashed(f"{type(error).__name__}: {error}"))
