"""Hunts of several records side by side, each run in a process that may die without harm to the others."""

from __future__ import annotations

import queue
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

from blockstat.errors import InputError, InputWarning
from dynsim.earthquake.hunt import Hunt
from dynsim.earthquake.motion import Motion
from dynsim.earthquake.runs import REST, Kept, ScaledRun, Shaking
from dynsim.parallel.pool import Answer, Line, Waiting

#: Name of a record, the record, intensity and scale.
Task = tuple[str, Motion | None, float, float]


@dataclass
class Hunted:
    """How the hunts ended."""

    finished: bool = True  #: False after an interrupt
    errors: dict[str, str] = field(default_factory=dict)  #: why a record has no more runs, by name


def hunt_all(
    shaking: Shaking,
    hunt: Hunt,
    motions: dict[str, Motion],
    units: dict[str, float],
    kept: Kept,
    jobs: int,
    progress: Callable[[ScaledRun], None] | None,
) -> Hunted:
    """Run every record until its hunt is over, and the assembly once without a record.

    Parameters
    ----------
    shaking : Shaking
        What all runs have in common.
    hunt : Hunt
        The intensities.
    motions : dict of str to Record or Pulse
        The records by name.
    units : dict of str to float
        The intensity of each record as it was recorded.
    kept : Kept
        The runs that are there; new ones are added.
    jobs : int
        Processes at a time.
    progress : callable, optional
        Called with each new run.

    Returns
    -------
    Hunted
        Whether it was finished, and what went wrong.

    Raises
    ------
    InputError
        For an assembly that cannot be simulated.
    """
    found = Hunted()
    tasks = _Tasks(hunt, motions, units, kept)
    if tasks.fell_at_rest:
        return found
    for name in (REST, *motions):
        tasks.ask(name)
    answers: queue.SimpleQueue[tuple[int, Answer]] = queue.SimpleQueue()
    # A process that is killed leaves its files behind: they go with this directory.
    scratch = tempfile.TemporaryDirectory(prefix="dynsim-pool-")
    count = min(jobs, tasks.under_way)
    lines = [Line(shaking.run, tasks.all, tasks.waiting, answers, None, scratch.name) for _ in range(count)]
    told: set[str] = set()
    try:
        for line in lines:
            line.start()
        while tasks.under_way and not tasks.fell_at_rest:
            index, (run, error, texts) = answers.get()
            name = tasks.ended(index)
            for text in sorted(set(texts) - told):  # runs of one assembly warn of the same
                warnings.warn(InputWarning(text), stacklevel=2)
            told |= set(texts)
            if run is not None:
                kept.add(run)
                tasks.ask(name)
                if progress is not None:
                    progress(run)
            elif name == REST:
                raise InputError(error)
            else:
                found.errors[name] = error
    except KeyboardInterrupt:
        found.finished = False
    finally:
        for line in lines:
            line.stop()
            tasks.waiting.put(None)
        scratch.cleanup()
    return found


class _Tasks:
    """The runs that were asked for, one at a time of each record."""

    def __init__(self, hunt: Hunt, motions: dict[str, Motion], units: dict[str, float], kept: Kept) -> None:
        self._hunt, self._motions, self._units, self._kept = hunt, motions, units, kept
        self.all: list[Task] = []
        self.waiting: Waiting = queue.SimpleQueue()
        self.under_way = 0

    @property
    def fell_at_rest(self) -> bool:
        """Whether a block fell without a record."""
        return any(run.fell for run in self._kept.of(REST).values())

    def ask(self, name: str) -> None:
        """Ask for the next run of a record, unless its hunt is over."""
        known = self._kept.of(name)
        if name == REST:
            intensity = None if known else 0.0
        else:
            intensity = self._hunt.following({at: run.fell for at, run in known.items()})
        if intensity is not None:
            scale = intensity / self._units.get(name, 1.0)
            self.all.append((name, self._motions.get(name), intensity, scale))
            self.waiting.put(len(self.all) - 1)
            self.under_way += 1

    def ended(self, index: int) -> str:
        """Count a task as done, and return the name of its record."""
        self.under_way -= 1
        return self.all[index][0]
