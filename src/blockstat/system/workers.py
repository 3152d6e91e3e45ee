"""Independent tasks side by side: on processes of this machine, or where joblib is told to send them.

A task is one argument, a tuple where there are several. Where an argument itself is a large array, the backend of
joblib for dask leaves it on one worker, from which others fetch it, and a worker that dies takes it along.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
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
    function: Callable[[Any], T], tasks: Iterable[Any], jobs: int | None, *, ahead: int | str = "2 * n_jobs"
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
    ahead : int or str, optional
        Tasks that are sent before the first answer, as joblib writes it.

    Returns
    -------
    iterator
        What the function returns.
    """
    from joblib import Parallel, delayed

    options: Any = {"return_as": "generator_unordered", "batch_size": 1, "pre_dispatch": ahead}
    found: Any = Parallel(n_jobs=jobs, **options)(delayed(function)(task) for task in tasks)
    return found


def in_stretches(function: Callable[[Any], list[T]], items: Sequence[Any] | Floats, jobs: int | None) -> list[T]:
    """Call a function for stretches of a sequence, side by side, and join what it returns.

    Parameters
    ----------
    function : callable
        One that the processes can import; it returns one answer for each item of a stretch.
    items : sequence
        The items. Where this process does all of the work, they are one stretch.
    jobs : int or None
        As of `count_workers`.

    Returns
    -------
    list
        An answer for each item, in the order of the items.

    Examples
    --------
    >>> from blockstat.system.workers import in_stretches
    >>> in_stretches(sorted, [1, 2, 3], jobs=1)
    [1, 2, 3]
    """
    workers = count_workers(jobs)
    if not workers or len(items) < 2:
        return function(items)
    from joblib import Parallel, delayed

    n = min(STRETCHES * workers, len(items))
    stretches = [items[a:b] for a, b in pairwise(len(items) * k // n for k in range(n + 1))]
    # The last ones first: later states of a building have more blocks.
    tasks = (delayed(function)(stretch) for stretch in reversed(stretches))
    options: Any = {"batch_size": 1}
    found: Any = Parallel(n_jobs=jobs, **options)(tasks)
    return [answer for answers in reversed(found) for answer in answers]
