"""Runs of scaled records: what became of each, and the file that keeps them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.system.lock import locked
from blockstat.system.rows import append_rows, kept_rows
from dynsim.earthquake.motion import Motion, scaled
from dynsim.engine.world import Action
from dynsim.judge.verdict import DynamicOutcome
from dynsim.judge.verify import verify
from dynsim.loads.load import Load
from dynsim.settings import Settings

FILE = "runs.jsonl"  #: in the directory of an analysis
REST = ""  #: in place of a record's name, of the run without one


@dataclass(frozen=True)
class ScaledRun:
    """What became of an assembly under one record at one intensity."""

    record: str
    motion: str  #: digest of the record before it was scaled
    intensity: float  #: of the scaled record, in the unit of the intensity measure
    scale: float  #: factor on the accelerations of the record
    outcome: str  #: word of the `DynamicOutcome`
    max_displacement: float  #: largest of a block relative to the ground at any time [m]; a fall ends the run
    max_rotation: float  #: largest of a block at any time [degrees]
    first_block: str | None  #: the block that crossed the threshold first
    first_time: float | None  #: when it did [s]
    process_seconds: float
    warnings: tuple[str, ...] = ()  #: of the verdict

    @property
    def fell(self) -> bool:
        """Whether a block fell."""
        return self.outcome == DynamicOutcome.FALLS.word


@dataclass(frozen=True, eq=False)
class Shaking:
    """What all runs of an analysis have in common."""

    assembly: Assembly
    settings: Settings
    loads: tuple[Load, ...]  #: that last throughout
    actions: tuple[Action, ...]
    interfaces: Interfaces

    def run(self, task: tuple[str, Motion | None, float, float]) -> ScaledRun:
        """Simulate one record at one intensity, in a process of its own.

        Parameters
        ----------
        task : tuple
            Name of the record, the record as it was recorded (None for a run without one), intensity and scale.

        Returns
        -------
        ScaledRun
            What became of the blocks.
        """
        name, motion, intensity, scale = task
        shaking = [] if motion is None else [scaled(motion, scale)]
        verdict = verify(
            self.assembly, settings=self.settings, loads=[*self.loads, *shaking], actions=self.actions,
            interfaces=self.interfaces,
        )  # fmt: skip
        return ScaledRun(
            name, "" if motion is None else digest(motion), intensity, scale, verdict.outcome.word,
            verdict.max_displacement, verdict.max_rotation, verdict.first_block, verdict.first_time,
            verdict.process_seconds, verdict.warnings,
        )  # fmt: skip

    def digest(self, measure: str) -> str:
        """Return what tells these runs from those of another scene.

        Parameters
        ----------
        measure : str
            The intensity measure.

        Returns
        -------
        str
            Of the blocks, their data, the joints, the settings, the loads, the actions and the measure.
        """
        own = {
            f.name: getattr(self.assembly, f.name) for f in fields(self.assembly) if f.name not in ("name", "metadata")
        }
        # To a nanometre: beyond that, coordinates are rounding.
        points = np.round(self.interfaces.point, 9)
        joints = (self.interfaces.pair, points, self.interfaces.friction, self.interfaces.searched)
        return digest([sorted(own.items()), joints, self.settings, self.loads, self.actions, measure])


def digest(thing: Any) -> str:
    """Return a digest of plain data, arrays and dataclasses.

    Parameters
    ----------
    thing : object
        The data.

    Returns
    -------
    str
        Sixteen hexadecimal digits.

    Examples
    --------
    >>> digest([1, np.zeros(2)]) == digest([1, np.zeros(2)]) != digest([1, np.ones(2)])
    True
    """
    found = hashlib.sha256()
    for part in _parts(thing):
        found.update(part)
    return found.hexdigest()[:16]


def _parts(thing: Any) -> Iterator[bytes]:
    """Bytes that stand for data, each with its kind and size before it."""
    if isinstance(thing, np.ndarray):
        yield f"{thing.dtype}{thing.shape}".encode()
        yield np.ascontiguousarray(thing).tobytes()
    elif isinstance(thing, (list, tuple)):
        yield f"{len(thing)}:".encode()
        for part in thing:
            yield from _parts(part)
    elif hasattr(thing, "__dataclass_fields__"):
        yield type(thing).__name__.encode()
        yield from _parts([getattr(thing, field.name) for field in fields(thing) if field.compare])  # no caches
    elif type(thing).__repr__ is object.__repr__ and hasattr(thing, "__dict__"):
        # Loads and actions of a user's own: where they lie in memory is told by `repr`, and differs every time.
        yield type(thing).__name__.encode()
        yield from _parts(sorted(vars(thing).items()))
    else:
        yield repr(thing).encode() + b";"


class Kept:
    """The runs that are there, in memory and, where there is a file, on the disk."""

    def __init__(self, runs: Sequence[ScaledRun] = (), file: Any = None) -> None:
        self.runs, self._file = list(runs), file

    def add(self, run: ScaledRun) -> None:
        """Keep a run; it is on the disk before this returns.

        Parameters
        ----------
        run : ScaledRun
            The run.
        """
        if self._file is not None:
            append_rows(self._file, [asdict(run)])
        self.runs.append(run)

    def of(self, record: str) -> dict[float, ScaledRun]:
        """Return the runs of one record.

        Parameters
        ----------
        record : str
            Its name.

        Returns
        -------
        dict of float to ScaledRun
            By intensity.
        """
        return {run.intensity: run for run in self.runs if run.record == record}


def _run_of(row: dict[str, Any]) -> ScaledRun:
    """Return the run of a line."""
    return ScaledRun(**{**row, "warnings": tuple(row["warnings"])})


@contextmanager
def kept(directory: str | Path | None, shaking: Shaking, measure: str, motions: dict[str, Motion]) -> Iterator[Kept]:
    """Open the file of an analysis, and keep its directory to this process.

    Parameters
    ----------
    directory : str, Path or None
        Made if it is not there; None to keep runs in memory alone.
    shaking : Shaking
        What all runs have in common.
    measure : str
        The intensity measure.
    motions : dict of str to Record or Pulse
        The records by name.

    Yields
    ------
    Kept
        The runs of earlier calls.

    Raises
    ------
    InputError
        For a directory of another analysis, or one that another process writes to, for a record that differs from that
        of the runs, and for a damaged line.
    """
    if directory is None:
        yield Kept()
        return
    folder = Path(directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    head = {"runs": "dynsim ida", "of": shaking.digest(measure)}
    with locked(folder):
        other = "runs of another scene, other settings or another intensity measure"
        runs = kept_rows(folder / FILE, head, _run_of, other=other)
        for run in runs:
            if run.record in motions and run.motion != digest(motions[run.record]):
                raise InputError(
                    f'{folder / FILE}: its runs of "{run.record}" are of another record; rename the record, or choose '
                    "another directory"
                )
        with (folder / FILE).open("a") as file:
            yield Kept(runs, file)
