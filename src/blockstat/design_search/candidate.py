"""What a search says of one design, and of all of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from blockstat.analysis.verdict import Outcome
from blockstat.design_search.space import is_boolean
from blockstat.result import Result, Sentence, counted, finite
from blockstat.spec import Scene, parameters

PRUNED = "pruned"  #: statics ruled it out, so nothing was simulated
UNASKED = ""  #: statics allow it and no simulation was needed, or it could not be built
BY_STATICS = "static"  #: the search was told to simulate nothing, and statics call it stable
ERROR = "error"  #: no verdict; the note says why
SOLVED, FORCES, MECHANISM = "solved", "forces", "mechanism"  #: what a static verdict rests on


@dataclass(frozen=True)
class Candidate:
    """One design that was evaluated: a row of the history."""

    parameters: dict[str, float]
    static: str  #: "stable", "unstable", "undecided", ..., or "error" when it could not be built
    score: float | None  #: None also where an earlier mechanism decided
    dynamic: str  #: "stands", "falls", "creeps", "pruned", "static", "error" or ""
    volume: float | None  #: of the free blocks [m3]
    blocks: int | None
    static_seconds: float  #: process time of building and statics
    dynamic_seconds: float
    note: str = ""
    evidence: str = (
        ""  #: "solved", or "forces" or "mechanism" of an earlier design (see `blockstat.analysis.certificate_cache`)
    )
    reserve: float | None = None  #: limit load multiplier of the margin asked for; minus the score where unstable
    slopes: tuple[float, ...] = ()  #: of the volume and then of the reserve, by each continuous parameter

    @property
    def excluded(self) -> bool:
        """Statics rule it out, or it cannot be built."""
        return self.static in ("unstable", ERROR)

    @property
    def failed(self) -> bool:
        """It could not be built, or the dynamic verifier ended in an error."""
        return ERROR in (self.static, self.dynamic)

    @property
    def simulated(self) -> bool:
        """The dynamic verifier was asked about it."""
        return self.dynamic not in (PRUNED, UNASKED, BY_STATICS)

    @property
    def stands(self) -> bool:
        """Both agree: statics do not rule it out and the dynamic verifier saw it stand."""
        return not self.excluded and self.dynamic in ("stands", BY_STATICS)


class SearchOutcome(Sentence):
    """The answers of a search; each value is the sentence a user reads."""

    FOUND = "Found: the search has a design that stands."
    NONE_STANDS = "None stands: of the designs that were examined none was found to stand."
    NO_RESERVE = "No reserve: designs stand, and none was found with the reserve or the safety asked for."
    FAILED = "Failed: no design could be judged."
    INTERRUPTED = "Interrupted: the search was ended before all designs were evaluated."


def failures(rows: Iterable[Mapping[str, Any]]) -> str:
    """Say how many designs have no verdict, and why.

    Parameters
    ----------
    rows : iterable of mapping
        With the static verdict under "static", the dynamic one (if any) under "dynamic", and a note.

    Returns
    -------
    str
        One sentence with the commonest reasons; empty where no design failed.

    Examples
    --------
    >>> failures([{"static": "stable"}, {"static": "error", "note": "wall.height: too low"}])
    '1 of 2 designs could not be judged: wall.height: too low (1).'
    """
    notes, number = Counter[str](), 0
    for row in rows:
        number += 1
        if ERROR in (row.get("static"), row.get("dynamic")):
            notes[str(row.get("note") or "no reason is known")] += 1
    if not notes:
        return ""
    said = "; ".join(f"{note} ({count})" for note, count in notes.most_common(3))
    others = f"; and {len(notes) - 3} other reasons" if len(notes) > 3 else ""
    return f"{sum(notes.values())} of {counted(number, 'design')} could not be judged: {said}{others}."


@dataclass(frozen=True)
class SearchResult(Result):
    """History and best design of a search."""

    building: Scene  #: where the search started: every parameter at its largest, if there is such a design
    best: Scene | None  #: None when no design stood
    best_parameters: dict[str, float] | None
    history: tuple[Candidate, ...]  #: one a design, in the order in which they were evaluated
    confirmation: Any = field(default=None, repr=False)  #: dynamic verdict of the best design, if simulated in this run
    finished: bool = True  #: False when it was interrupted
    front: tuple[Candidate, ...] = ()  #: strategy "pareto": designs none of which is better than another in all
    #: strategy "robust" with a target: the best design's probability of failure, `first` (`FirstOrder`) and `draws`
    #: (`Reliability`)
    assured: Any = None
    unexamined: float = 0  #: other designs of the space; inf where numbers are searched between their steps, too
    unbuilt: int = 0  #: designs that were examined and have no row, because they cannot be built

    @property
    def outcome(self) -> SearchOutcome:
        """Whether the search was finished, and whether any design stood."""
        if not self.finished:
            return SearchOutcome.INTERRUPTED
        if self.history and all(c.failed for c in self.history):
            return SearchOutcome.FAILED
        if self.best is not None:
            return SearchOutcome.FOUND
        # One that lacks reserve is not simulated.
        stand = any(c.static == "stable" and c.dynamic in ("stands", BY_STATICS, UNASKED) for c in self.history)
        return SearchOutcome.NO_RESERVE if stand else SearchOutcome.NONE_STANDS

    @property
    def at_ends(self) -> str:
        """In words which numbers of the best design are the least or the greatest of their ranges; empty for none."""
        best, found = self.best_parameters or {}, parameters(self.building)
        ranges = {name: found[name] for name in best if name in found and not is_boolean(found[name])}
        ends = [name for name, own in ranges.items() if own.min < own.max and not own.min < best[name] < own.max]
        return f"At an end of its range: {', '.join(ends)}; a wider range may hold a lighter design." if ends else ""

    @property
    def none_stood(self) -> str:
        """In words that no design stood, of how many, or that none was safe enough."""
        if self.outcome is SearchOutcome.NO_RESERVE:
            return "designs stand, and none was found with the reserve or the safety asked for"
        failed = sum(c.failed for c in self.history)
        counts = {"undecided": self.undecided, "not judged": failed, "cannot be built": self.unbuilt}
        left_open = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
        examined = len(self.history) + self.unbuilt
        if not left_open and not self.unexamined:
            return "no design of the space stood"
        words = f"no design stood of the {examined:,} examined{left_open and f' ({left_open})'}"
        if self.unexamined == math.inf:
            return f"{words}; the ranges hold more"
        return f"{words}; the space has {examined + int(self.unexamined):,}" if self.unexamined else words

    def explain(self) -> str:
        """Return the best design and how many designs were evaluated in which way, one fact a line.

        Returns
        -------
        str
        """
        lines = [self.outcome.value]
        if self.outcome is SearchOutcome.NONE_STANDS:
            lines.append(f"{self.none_stood[0].upper()}{self.none_stood[1:]}.")
        if self.best_parameters is not None:
            lines.append(f"Best: {', '.join(f'{name} {value:g}' for name, value in self.best_parameters.items())}.")
            if told := self.at_ends:
                lines.append(told)
        if self.assured is not None:
            low, high = self.assured.draws.interval
            first, drawn = (own.probability for own in (self.assured.first, self.assured.draws))
            plane = "not found" if math.isnan(first) else f"{first:.3g}"
            words = f"Probability of failure {plane} to first order; by draws {drawn:.3g}"
            lines.append(f"{words} ({low:.3g} to {high:.3g}).")
        pruned = sum(c.dynamic == PRUNED for c in self.history)
        lines.append(
            f"{counted(len(self.history), 'design')}: {counted(self.static_solves, 'static solve')}, "
            f"{self.certificates_reused} decided by earlier certificates, {pruned} pruned, "
            f"{self.dynamic_runs} simulated."
        )
        if failed := failures(asdict(c) for c in self.history):
            lines.append(failed)
        if self.disagreements:
            lines.append(f"Statics and dynamics disagree on {len(self.disagreements)}.")
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict of str to object
            The outcome and its sentence, the best parameters, numbers of designs (None for `unexamined` where the
            ranges hold more than can be counted), verdicts and disagreements, the front, and whether the search was
            finished.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "best": self.best_parameters,
            "designs": len(self.history),
            "unexamined": finite(self.unexamined),
            "undecided": self.undecided,
            "static_solves": self.static_solves,
            "certificates_reused": self.certificates_reused,
            "dynamic_runs": self.dynamic_runs,
            "disagreements": len(self.disagreements),
            "front": [{**c.parameters, "volume": c.volume, "reserve": c.reserve} for c in self.front],
            "finished": self.finished,
            "failure": None if self.assured is None else self.assured.draws.summary(),
        }

    @property
    def undecided(self) -> int:
        """Designs that statics left open and that were not simulated."""
        known = (Outcome.STABLE.word, Outcome.UNSTABLE.word, ERROR)
        return sum(c.dynamic == UNASKED and c.static not in known for c in self.history)

    @property
    def static_solves(self) -> int:
        """Static verdicts that were solved for."""
        return sum(c.evidence == SOLVED for c in self.history)

    @property
    def certificates_reused(self) -> int:
        """Static verdicts that rest on evidence of an earlier design."""
        return sum(c.evidence in (FORCES, MECHANISM) for c in self.history)

    @property
    def dynamic_runs(self) -> int:
        """Designs that the dynamic verifier was asked about."""
        return sum(c.simulated for c in self.history)

    @property
    def disagreements(self) -> tuple[Candidate, ...]:
        """Designs that statics call stable and that did not stand; their note gives the likely reason."""
        fell = (c for c in self.history if c.simulated and c.dynamic not in ("stands", ERROR))
        return tuple(c for c in fell if c.static == "stable")
