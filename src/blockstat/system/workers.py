"""Independent tasks side by side: on processes of this machine, or where joblib is told to send them.

Tasks for dask go to its client directly. By the backend of joblib a large array that is an argument would lie on one
worker alone, which takes it along when it dies; a task that no worker survives would be waited for without end; and a
cluster of one worker would get no task.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import islice
from typing import Any, TypeVar

from blockstat.errors import InputError
from blockstat.typing import Floats

T = TypeVar("T")
#: Stretches a worker: few, so that neighbours share evidence, and more than one, for no worker waits for the last long.
STRETCHES = 4


def count_workers(jobs: int | None) -> int:
    """Return to how many workers tasks go.

    Parameters
    ----------
    jobs : int or None
        Processes; None for all workers of the backend of joblib that is in force, if there is one.

    Returns
    -------
    int
        0 where this process does all of the work.

    Raises
    ------
    InputError
        For fewer than one process.
    """
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs is {jobs}; at least one process is needed")
    from joblib.parallel import get_active_backend

    found: Any = get_active_backend()
    backend, told = found
    asked = jobs or told or backend.default_n_jobs
    return 0 if asked == 1 else backend.effective_n_jobs(asked)


def as_they_come(
    function: Callable[[Any], T], tasks: Iterable[Any], jobs: int | None, *, ahead: int | None = None
) -> Iterator[T]:
    """Call a function for each task, side by side, and yield the answers in the order in which they come.

    Parameters
    ----------
    function : callable
        One that the processes can import.
    tasks : iterable
        What it is called with. They are read as they are needed.
    jobs : int or None
        As of `count_workers`; -1 for one a core.
    ahead : int, optional
        Tasks that are sent before the first answer, by default two a worker.

    Returns
    -------
    iterator
        What the function returns.
    """
    from joblib import Parallel, delayed
    from joblib.parallel import get_active_backend

    backend: Any = get_active_backend()[0]
    if hasattr(backend, "client"):
        return _on_dask(backend.client, function, tasks, ahead or 2 * backend.effective_n_jobs(jobs))
    options: Any = {"return_as": "generator_unordered", "batch_size": 1, "pre_dispatch": ahead or "2 * n_jobs"}
    found: Any = Parallel(n_jobs=jobs, **options)(delayed(function)(task) for task in tasks)
    return found


def _on_dask(client: Any, function: Callable[[Any], T], tasks: Iterable[Any], ahead: int) -> Iterator[T]:
    """The same by a client of dask. Others do the tasks of a worker that dies; a task that kills four is an error."""
    from distributed import as_completed

    # A task goes along with the function: dask looks for tasks of its own in arguments.
    calls = (client.submit(partial(function, task), pure=False) for task in tasks)
    running = as_completed(list(islice(calls, ahead)), loop=client.loop)
    for future in running:
        yield future.result()
        running.update(list(islice(calls, 1)))


def in_stretches(
    function: Callable[[Any], list[T]],
    items: Sequence[Any] | Floats,
    jobs: int | None,
    progress: Callable[[int, int], None] | None = None,
) -> list[T]:
    """Call a function for stretches of a sequence, side by side, and join what it returns.

    Parameters
    ----------
    function : callable
        One that the processes can import; it returns one answer for each item of a stretch.
    items : sequence
        The items. Where this process does all of the work, they are one stretch.
    jobs : int or None
        As of `count_workers`.
    progress : callable, optional
        Called with the items done and all of them. Where this process does all of the work, it is called after each
        item, and a KeyboardInterrupt after the first ends the work; with others, and without it, that is raised.

    Returns
    -------
    list
        An answer for each item, in the order of the items; for the first ones alone after an interrupt.

    Examples
    --------
    >>> from blockstat.system.workers import in_stretches
    >>> in_stretches(sorted, [1, 2, 3], jobs=1)
    [1, 2, 3]
    """
    workers = count_workers(jobs)
    if not workers or len(items) < 2:
        return function(items) if progress is None else _until_interrupted(function, items, progress)
    n = min(STRETCHES * workers, len(items))
    stretches = [(k, items[len(items) * k // n : len(items) * (k + 1) // n]) for k in range(n)]
    # The last ones first: later states of a building have more blocks.
    found, done = dict[int, list[T]](), 0
    for number, answers in as_they_come(partial(_numbered, function), reversed(stretches), jobs):
        found[number] = answers
        done += len(answers)
        if progress is not None:
            progress(done, len(items))
    return [answer for k in range(n) for answer in found[k]]


def _until_interrupted(
    function: Callable[[Any], list[T]], items: Sequence[Any] | Floats, progress: Callable[[int, int], None]
) -> list[T]:
    """What a function returns for each item, of the first ones alone after an interrupt."""
    done = list[T]()
    try:
        for k in range(len(items)):
            done += function(items[k : k + 1])
            progress(len(done), len(items))
    except KeyboardInterrupt:
        if not done:
            raise
    return done


def _numbered(function: Callable[[Any], list[T]], stretch: tuple[int, Any]) -> tuple[int, list[T]]:
    """What a function returns for a stretch, with its number."""
    number, items = stretch
    return number, function(items)
