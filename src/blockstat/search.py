"""Search the space of a scene's parameters: statics prune, a dynamic verifier confirms.

The paper's procedure: every parameter starts at its largest value and goes down step by step. Each value is
built and judged; the smallest one that stands is kept while the next parameter goes down. Statics are asked
first: a design without any admissible force field cannot stand, so pruning it is safe, and the far slower
dynamic verifier sees only the rest. All values of a range are tried, because standing need not be monotone.
"""

from __future__ import annotations

import csv
import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import isnan
from pathlib import Path
from time import process_time
from typing import Any, Protocol

import msgspec

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.model import build
from blockstat.result import Outcome, Verdict
from blockstat.spec import Scene, parameters, with_values

PRUNED = "pruned"
COLUMNS = ("static", "score", "dynamic", "volume", "blocks", "static_seconds", "dynamic_seconds", "note")
SCENE = "scene"  #: last column: a digest of the scene, so that rows of another scene are never taken for its own


class Dynamic(Protocol):
    """What the search needs of a dynamic verdict: `outcome.word` is "stands" or something else."""

    @property
    def outcome(self) -> Any: ...


@dataclass(frozen=True)
class Candidate:
    """One design that was judged: a row of the history."""

    parameters: dict[str, float]
    static: str  #: "stable", "unstable", "undecided", or "error" when it could not be built
    score: float | None  #: None also where an earlier mechanism decided
    dynamic: str  #: "stands", "falls", "creeps", "pruned" when statics ruled it out, or "" when it could not be built
    volume: float | None  #: of the free blocks [m3]
    blocks: int | None
    static_seconds: float  #: process time of building and statics
    dynamic_seconds: float
    note: str = ""

    @property
    def stands(self) -> bool:
        """Statics do not rule it out and the dynamic verifier saw it stand."""
        return self.dynamic == "stands"

    def row(self) -> dict[str, Any]:
        values = {name: getattr(self, name) for name in COLUMNS}
        return {**self.parameters, **{k: "" if v is None else v for k, v in values.items()}}


@dataclass(frozen=True)
class SearchResult:
    """History and best design of a search."""

    building: Scene  #: where the search started: every parameter at its largest
    best: Scene | None  #: the last design that stood, None when none did
    best_parameters: dict[str, float] | None
    history: tuple[Candidate, ...]
    verdicts: dict[tuple[float, ...], Verdict] = field(repr=False)  #: static verdicts of this run by parameter values
    confirmation: Any = field(default=None, repr=False)  #: dynamic verdict of the best design, if judged in this run
    finished: bool = True  #: False when it was interrupted


def search(
    building: Scene,
    *,
    static: Callable[[Assembly], Verdict],
    verify: Callable[[Assembly], Dynamic],
    names: Sequence[str] | None = None,
    history: str | Path | None = None,
    progress: Callable[[int, int, Candidate], None] | None = None,
    remark: Callable[[Verdict, Any], str] | None = None,
    conditions: str = "",
) -> SearchResult:
    """Take parameters down from their largest values, one after the other, keeping what stands.

    static : judges by forces; a design it calls unstable is pruned. verify : judges by motion; called only
    for designs that statics allow. names : the parameters to move, in order; by default all ranges of the scene.
    history : CSV file that gets each row as soon as it is known; rows found there are not computed again, so an
    interrupted search goes on where it stopped. progress : called with the number of candidates judged, the
    number expected, and the last one. remark : gives the note of a candidate from its two verdicts.
    conditions : what else the verdicts depend on (friction, thresholds); a history under others is not taken up.

    A KeyboardInterrupt ends the search and returns what is known. Raises InputError for an unknown parameter,
    a scene without ranges, or a history file of another search.
    """
    ranges = parameters(building)
    chosen = check_names(building, [names] if isinstance(names, str) else names)
    start = {name: ranges[name].max for name in chosen}
    building = with_values(building, start)
    log = _Log(Path(history), chosen, _digest(building, conditions)) if history is not None else None
    state = _State(building, chosen, static, verify, log, remark)
    expected = 1 + sum(len(ranges[name].steps()) - 1 for name in chosen)

    best = dict(start)
    finished, stood = True, False
    try:
        for name in chosen:
            for value in ranges[name].steps():
                values = {**best, name: value}
                candidate, new = state.judge(values)
                if new and progress is not None:
                    progress(len(state.rows), expected, candidate)
                if candidate.stands:
                    best, stood = values, True
    except KeyboardInterrupt:
        finished = False
    return SearchResult(
        building=building,
        best=with_values(building, best) if stood else None,
        best_parameters=best if stood else None,
        history=tuple(state.rows.values()),
        verdicts=state.verdicts,
        confirmation=state.dynamics.get(_key(best)) if stood else None,
        finished=finished,
    )


def check_names(building: Scene, names: Sequence[str] | None) -> list[str]:
    """The parameters to move, in order. Raises InputError for an unknown one, or when there is none."""
    ranges = parameters(building)
    chosen = list(names) if names is not None else list(ranges)
    for name in chosen:
        if name not in ranges:
            raise InputError(f'no parameter "{name}" to search; ranges are: {", ".join(ranges) or "none"}')
    if not chosen:
        raise InputError(f'"{building.name}" has no parameter to search; write one as {{value, min, max, step}}')
    return chosen


def _digest(building: Scene, conditions: str) -> str:
    return hashlib.sha256(msgspec.json.encode(building, order="sorted") + conditions.encode()).hexdigest()[:12]


def _key(values: dict[str, float]) -> tuple[float, ...]:
    return tuple(values.values())


class _State:
    """Candidates judged so far."""

    def __init__(
        self,
        building: Scene,
        names: list[str],
        static: Callable,
        verify: Callable,
        log: _Log | None,
        remark: Callable[[Verdict, Any], str] | None,
    ) -> None:
        self.building, self.names, self.static, self.verify, self.log = building, names, static, verify, log
        self.remark = remark
        self.rows: dict[tuple[float, ...], Candidate] = {}
        self.known = log.read() if log else {}
        self.verdicts: dict[tuple[float, ...], Verdict] = {}
        self.dynamics: dict[tuple[float, ...], Any] = {}

    def judge(self, values: dict[str, float]) -> tuple[Candidate, bool]:
        """The candidate, and whether it is new to this search (computed now or read from the history)."""
        key = _key(values)
        if key in self.rows:
            return self.rows[key], False
        candidate = self.known.get(key)
        if candidate is None:
            candidate = self._compute(key, values)
            if self.log:
                self.log.append(candidate)
        self.rows[key] = candidate
        return candidate, True

    def _compute(self, key: tuple[float, ...], values: dict[str, float]) -> Candidate:
        begin = process_time()
        try:
            assembly = build(with_values(self.building, values))
            verdict = self.static(assembly)
        except InputError as error:
            return Candidate(values, "error", None, "", None, None, process_time() - begin, 0.0, str(error))
        self.verdicts[key] = verdict
        middle = process_time()
        if verdict.outcome is Outcome.UNSTABLE:
            word = PRUNED
        else:
            self.dynamics[key] = self.verify(assembly)
            word = self.dynamics[key].outcome.word
        return Candidate(
            parameters=values,
            static=verdict.outcome.word,
            score=None if isnan(verdict.score) else verdict.score,
            dynamic=word,
            volume=float(assembly.volume[assembly.free].sum()),
            blocks=assembly.n_blocks,
            static_seconds=middle - begin,
            dynamic_seconds=process_time() - middle,
            note=self.remark(verdict, self.dynamics[key]) if self.remark and key in self.dynamics else "",
        )


class _Log:
    """The history on disk, one line a candidate, flushed as it comes."""

    def __init__(self, path: Path, names: list[str], scene: str) -> None:
        self.path, self.names, self.scene = path, names, scene
        self.columns = [*names, *COLUMNS, SCENE]

    def read(self) -> dict[tuple[float, ...], Candidate]:
        """Rows of an earlier run; a last line cut short by a kill is dropped from the file."""
        if not self.path.is_file() or not self.path.stat().st_size:
            with self.path.open("w", newline="") as file:
                csv.writer(file).writerow(self.columns)
            return {}
        text = self.path.read_text(errors="replace")
        if not text.endswith("\n"):
            text = text[: text.rfind("\n") + 1]
            replacement = self.path.with_suffix(".tmp")
            replacement.write_text(text)
            os.replace(replacement, self.path)
        reader = csv.DictReader(text.splitlines())
        rows = list(reader)
        if reader.fieldnames != self.columns or any(row[SCENE] != self.scene for row in rows):
            raise InputError(
                f"{self.path}: this history is of another search; move it away or choose another directory"
            )
        try:
            return {_key(c.parameters): c for c in map(self._candidate, rows)}
        except (ValueError, TypeError):
            raise InputError(f"{self.path}: a row is damaged; mend it or move the file away") from None

    def _candidate(self, row: dict[str, str]) -> Candidate:
        def number(name: str) -> float | None:
            return float(row[name]) if row[name] else None

        return Candidate(
            parameters={name: float(row[name]) for name in self.names},
            static=row["static"],
            score=number("score"),
            dynamic=row["dynamic"],
            volume=number("volume"),
            blocks=int(row["blocks"]) if row["blocks"] else None,
            static_seconds=float(row["static_seconds"]),
            dynamic_seconds=float(row["dynamic_seconds"]),
            note=row["note"],
        )

    def append(self, candidate: Candidate) -> None:
        with self.path.open("a", newline="") as file:
            csv.DictWriter(file, self.columns).writerow({**candidate.row(), SCENE: self.scene})
            file.flush()
            os.fsync(file.fileno())
