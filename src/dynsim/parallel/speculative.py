"""Speculative runs: answers begun before they are asked for."""

from __future__ import annotations

import queue
import tempfile
from collections.abc import Callable
from functools import partial
from typing import Any, Generic, TypeVar

from dynsim.parallel.pool import Answer, Line, Waiting, jobs_checked, with_options

T = TypeVar("T")


class SpeculativeRuns(Generic[T]):
    """A function whose answers may be begun before they are asked for, in processes of their own; a context manager.

    What still runs at its end is abandoned.

    Examples
    --------
    >>> from blockstat.model import arch, assemble
    >>> from dynsim import SpeculativeRuns, verify
    >>> ring = assemble(arch(span=2.0, thickness=0.4, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> with SpeculativeRuns(verify, jobs=1) as runs:
    ...     runs.begin(ring)
    ...     runs(ring).outcome.word
    'stands'
    """

    def __init__(self, function: Callable[[Any], T], jobs: int | None = None) -> None:
        """Prepare the processes; they start when the context is entered.

        Parameters
        ----------
        function : callable
            One that can be imported from a module.
        jobs : int, optional
            Number of processes; all cores when None.
        """
        self._function = function
        self._arguments: list[Any] = []
        self._begun: dict[int, int] = {}  #: identities of arguments, which are kept, and their numbers
        self._found: dict[int, Answer] = {}
        self._waiting: Waiting = queue.SimpleQueue()
        self._done: queue.SimpleQueue[tuple[int, Answer]] = queue.SimpleQueue()
        self._scratch = tempfile.TemporaryDirectory(prefix="dynsim-pool-")
        self._lines = [
            Line(
                partial(with_options, function),
                self._arguments,
                self._waiting,
                self._done,
                None,
                self._scratch.name,
                early=True,
            )
            for _ in range(jobs_checked(jobs))
        ]

    def __enter__(self) -> SpeculativeRuns[T]:
        for line in self._lines:
            line.start()
        return self

    def __exit__(self, *error: object) -> None:
        for line in self._lines:
            line.stop()
            self._waiting.put(None)
        self._scratch.cleanup()

    def begin(self, argument: Any, **options: Any) -> None:
        """Begin an answer that will probably be asked for.

        Parameters
        ----------
        argument : object
            What the function is called with; the same object is asked for later.
        **options
            Options of the function.
        """
        self._begun[id(argument)] = len(self._arguments)
        self._arguments.append((argument, options))
        self._waiting.put(len(self._arguments) - 1)

    def __call__(self, argument: Any, **options: Any) -> T:
        """Return the answer for an argument; where nothing was begun, or that failed, it is found here.

        Parameters
        ----------
        argument : object
            What the function is called with.
        **options
            Options of the function, the same as those it was begun with.

        Returns
        -------
        object
            What the function returns.
        """
        number = self._begun.get(id(argument))
        if number is None:
            return self._function(argument, **options)
        while number not in self._found:
            index, answer = self._done.get()
            self._found[index] = answer
        result, error, _ = self._found.pop(number)
        self._arguments[number] = None
        del self._begun[id(argument)]
        return self._function(argument, **options) if error or result is None else result
