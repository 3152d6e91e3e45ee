"""A pool of processes for many designs, each in a process that may die without harm to the others."""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError, check_assembly, check_count, check_positive, known_options
from dynsim.engine.world import Action
from dynsim.judge.verdict import DynamicVerdict
from dynsim.judge.verify import verify
from dynsim.loads.load import Loads, as_actions
from dynsim.settings import Settings

T = TypeVar("T")
Waiting = queue.SimpleQueue[int | None]  #: numbers of tasks; None ends a line
Answer = tuple[Any, str, tuple[str, ...]]  #: what a worker says: fields of a row after its name

INTERRUPTED = "interrupted before it was done"
#: One thread of linear algebra a process: as many processes as cores, and the same sums in the same order.
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")}


@dataclass(frozen=True)
class Row(Generic[T]):
    """The result of one task, or why there is none."""

    name: str
    result: T | None  #: None when there is none
    error: str = ""  #: why there is none
    warnings: tuple[str, ...] = ()  #: InputWarnings on the way


@dataclass(frozen=True)
class Rows(Generic[T]):
    """The results of all tasks, in the order of the tasks."""

    rows: tuple[Row[T], ...]
    finished: bool  #: False after an interrupt; what was done by then is kept

    def __iter__(self):
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, index: int) -> Row[T]:
        return self.rows[index]


@known_options
def verify_many(
    designs: Iterable[Assembly],
    *,
    settings: Settings | None = None,
    loads: Loads = (),
    actions: Sequence[Action] = (),
    interfaces: Sequence[Interfaces] | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    progress: Callable[[int, Row[DynamicVerdict]], None] | None = None,
) -> Rows[DynamicVerdict]:
    """Return `dynsim.verify` of many assemblies, the same bit by bit whatever the number of processes.

    Parameters
    ----------
    designs : iterable of Assembly
        What is verified.
    settings, loads, actions : optional
        As in `verify`, the same for all.
    interfaces : sequence of Interfaces, optional
        Joints, of each assembly its own; searched for when None.
    jobs, timeout, progress : optional
        As in `run_many`.

    Returns
    -------
    Rows of DynamicVerdict
        In the order of the designs.

    Raises
    ------
    InputError
        For a bad number of processes or timeout, or interfaces of another number of assemblies. Also for an option that
        does not exist.

    Examples
    --------
    >>> from blockstat.model import arch, assemble
    >>> from dynsim import verify_many
    >>> ring = assemble(arch(span=2.0, thickness=0.4, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> rows = verify_many([ring, ring.with_(friction=0.1)], jobs=1)
    >>> [row.result.outcome.word for row in rows]
    ['stands', 'falls']
    """
    if isinstance(designs, Assembly):
        raise InputError("designs: one assembly is given; verify_many takes a sequence of them, verify one")
    designs, settings = listed(designs), Settings.of(settings)
    names = [design.name for design in designs]
    function = partial(with_options, partial(verify, settings=settings, loads=loads, actions=as_actions(actions)))
    tasks = paired(designs, interfaces)
    return run_many(function, tasks, names=names, jobs=jobs, timeout=timeout, progress=progress)


def listed(designs: Assembly | Iterable[Assembly]) -> list[Assembly]:
    """Return one assembly or several as a list.

    Parameters
    ----------
    designs : Assembly or iterable of Assembly
        What was given.

    Returns
    -------
    list of Assembly
        In their order.

    Raises
    ------
    InputError
        For anything else, and for none at all.
    """
    several = isinstance(designs, Iterable) and not isinstance(designs, str)
    found: list[Any] = list(cast(Iterable[Any], designs)) if several else [designs]
    if not found:
        raise InputError("there are no assemblies; an iterator that was gone through before has none left")
    for number, design in enumerate(found):
        check_assembly(f"assembly {number}" if several else "assembly", design)
    return found


def paired(
    designs: Sequence[Assembly], interfaces: Sequence[Interfaces] | None
) -> list[tuple[Assembly, dict[str, Any]]]:
    """Return each design with the options for it alone.

    Parameters
    ----------
    designs : sequence of Assembly
        The designs.
    interfaces : sequence of Interfaces or None
        Their joints; None where they have to be searched for.

    Returns
    -------
    list of (Assembly, dict)
        What `with_options` takes.

    Raises
    ------
    InputError
        For interfaces of another number of designs.
    """
    if interfaces is None:
        return [(design, {}) for design in designs]
    if len(interfaces) != len(designs):
        raise InputError(f"interfaces of {len(interfaces)} assemblies are given; there are {len(designs)} assemblies")
    return [(design, {"interfaces": joints}) for design, joints in zip(designs, interfaces, strict=True)]


def with_options(function: Callable[..., T], task: tuple[Any, dict[str, Any]]) -> T:
    """Call a function; what a process of the pool does where each argument has options of its own.

    Parameters
    ----------
    function : callable
        Called with the argument.
    task : tuple of object and dict
        The argument and its options.

    Returns
    -------
    object
        What the function returns.
    """
    argument, options = task
    return function(argument, **options)


@known_options
def run_many(
    function: Callable[[Any], T],
    arguments: Sequence[Any],
    *,
    names: Sequence[str] | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    progress: Callable[[int, Row[T]], None] | None = None,
) -> Rows[T]:
    """Call a function for each argument, in processes of their own, and keep the order.

    A call that fails, dies or takes too long loses its own row only, which says why. An interrupt (Ctrl-C) ends what
    runs, and rows done by then are kept.

    Parameters
    ----------
    function : callable
        One that can be imported from a module.
    arguments : sequence
        What it is called with, one argument a call.
    names : sequence of str, optional
        Names of the rows; numbers when None.
    jobs : int, optional
        Processes at a time; all cores when None.
    timeout : float, optional
        Time by the clock that one call may take, with the start of its process (about a second) where it needs one [s].
    progress : callable, optional
        Called with the number and the row of each task as it ends.

    Returns
    -------
    Rows
        In the order of the arguments.

    Raises
    ------
    InputError
        For a bad number of processes or timeout. Also for an option that does not exist.

    Examples
    --------
    >>> from dynsim import run_many
    >>> [row.result for row in run_many(abs, [-1, 2], jobs=1)]
    [1, 2]
    """
    names = [str(i) for i in range(len(arguments))] if names is None else list(names)
    jobs = min(jobs_checked(jobs), max(len(arguments), 1))
    if timeout is not None:
        check_positive("timeout", timeout)
    if len(names) != len(arguments):
        raise InputError(f"names: there are {len(names)} for {len(arguments)} arguments")
    waiting: Waiting = queue.SimpleQueue()
    for index in (*range(len(arguments)), *[None] * jobs):
        waiting.put(index)
    done: queue.SimpleQueue[tuple[int, Answer]] = queue.SimpleQueue()
    found: dict[int, Row[T]] = {}
    finished = True
    # A process that is killed leaves its files behind: they go with this directory.
    scratch = tempfile.TemporaryDirectory(prefix="dynsim-pool-")
    lines = [Line(function, arguments, waiting, done, timeout, scratch.name) for _ in range(jobs)]
    try:
        for line in lines:
            line.start()
        while len(found) < len(arguments):
            index, answer = done.get()
            found[index] = Row(names[index], *answer)
            if progress is not None:
                progress(index, found[index])
    except KeyboardInterrupt:
        finished = False
    finally:
        for line in lines:
            line.stop()
        scratch.cleanup()
    rows = tuple(found.get(i, Row(name, None, INTERRUPTED)) for i, name in enumerate(names))
    return Rows(rows, finished)


def jobs_checked(jobs: int | None) -> int:
    """Return the number of processes: as asked, or one a core that this process may use.

    Parameters
    ----------
    jobs : int or None
        What was asked for.

    Returns
    -------
    int
        At least 1.

    Raises
    ------
    InputError
        For a number below 1.
    """
    if jobs is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    check_count("jobs", jobs)
    return jobs


def ready(function: Callable[[Any], Any]) -> bool:
    """Import a function ahead of the first task: a process that is told of it has imported it.

    Parameters
    ----------
    function : callable
        What the process will be asked to call.

    Returns
    -------
    bool
        True.
    """
    return callable(function)


class Line(threading.Thread):
    """A thread with one process at a time that takes waiting tasks; a process that dies is replaced."""

    def __init__(
        self,
        function: Callable[[Any], Any],
        arguments: Sequence[Any],
        waiting: Waiting,
        done: queue.SimpleQueue[tuple[int, Answer]],
        timeout: float | None,
        scratch: str,
        *,
        early: bool = False,
    ) -> None:
        """Prepare a process; it starts with the first task.

        Parameters
        ----------
        function : callable
            What is called.
        arguments : sequence
            What it is called with.
        waiting : queue of int or None
            Numbers of tasks; None ends the line.
        done : queue of (int, Answer)
            Gets what came of each task.
        timeout : float or None
            Time that one task may take [s].
        scratch : str
            Directory of temporary files.
        early : bool
            Whether the process starts before there is a task.
        """
        super().__init__(daemon=True)
        self._early = early
        self._function, self._arguments = function, arguments
        self._waiting, self._done, self._timeout = waiting, done, timeout
        path = os.pathsep.join([str(Path(__file__).parents[2]), *filter(None, sys.path)])
        self._environment = os.environ | ONE_THREAD | {"PYTHONPATH": path, "TMPDIR": scratch}
        self._lock = threading.Lock()
        self._stopped = False
        self._process: subprocess.Popen[bytes] | None = None

    def run(self) -> None:
        """Take tasks until there are no more."""
        if self._early:
            self._answer(ready, self._function)  # what fails here fails with the first task, which says so
        while not self._stopped and (index := self._waiting.get()) is not None:
            self._done.put((index, self._answer(self._function, self._arguments[index])))
        self.stop()

    def stop(self) -> None:
        """End the process, whatever it is doing."""
        with self._lock:
            self._stopped = True
            _end(self._process)

    def _answer(self, function: Callable[[Any], Any], argument: Any) -> Answer:
        """What came of a task, whatever fails: who waits for it waits for ever if this thread ends."""
        try:
            return self._ask(function, argument)
        except Exception as failure:
            return None, f"internal error ({type(failure).__name__}: {failure})", ()

    def _ask(self, function: Callable[[Any], Any], argument: Any) -> Answer:
        task = pickle.dumps((function, argument), protocol=pickle.HIGHEST_PROTOCOL)
        process = self._living()
        if process is None:
            return None, INTERRUPTED, ()
        assert process.stdin is not None
        assert process.stdout is not None
        late = threading.Event()

        def give_up() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(self._timeout, give_up) if self._timeout is not None else None
        try:
            if timer is not None:
                timer.start()
            process.stdin.write(task)
            process.stdin.flush()
            return pickle.load(process.stdout)
        except (EOFError, OSError, pickle.UnpicklingError):
            process.kill()
            status = process.wait()
            if late.is_set():
                return None, f"took longer than {self._timeout:g} s", ()
            return None, INTERRUPTED if self._stopped else f"its process {_death(status)}", ()
        finally:
            if timer is not None:
                timer.cancel()

    def _living(self) -> subprocess.Popen[bytes] | None:
        """Return the process, a new one if the last has died; None when told to stop."""
        with self._lock:
            if self._stopped:
                return None
            if self._process is None or self._process.poll() is not None:
                _end(self._process)
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "dynsim.parallel.worker"],
                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                    env=self._environment,
                    start_new_session=True,  # an interrupt at the terminal is for the caller alone
                )  # fmt: skip
            return self._process


def _end(process: subprocess.Popen[bytes] | None) -> None:
    if process is None:
        return
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            try:
                stream.close()
            except OSError:
                pass


def _death(status: int) -> str:
    """How a process ended, in words."""
    if status < 0:
        return f"was killed by {signal.Signals(-status).name}"
    return f"ended by itself (status {status})"
