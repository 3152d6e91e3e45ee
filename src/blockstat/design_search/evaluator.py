"""Evaluate designs: statics, then dynamics where they are asked for, each once, all of it in the history."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from time import process_time
from typing import Any, Protocol

from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.assembly import Assembly
from blockstat.design_search.candidate import BY_STATICS, ERROR, FORCES, MECHANISM, PRUNED, SOLVED, UNASKED, Candidate
from blockstat.design_search.history import History, Key
from blockstat.design_search.space import Space, Values
from blockstat.errors import InputError
from blockstat.spec import build
from blockstat.spec.compose import FreeVolumes

#: What a verdict says of where it comes from.
EVIDENCE = {"earlier forces": FORCES, "earlier mechanism": MECHANISM, "none": ""}


class Dynamic(Protocol):
    """What the search needs of a dynamic verdict: `outcome.word` is "stands" or something else.

    One that was found in another process may say how long it took, as `process_seconds`.
    """

    @property
    def outcome(self) -> Any:
        """The answer."""
        ...


@dataclass(frozen=True)
class Callbacks:
    """The functions that an evaluator calls, and what they share."""

    static: Callable[[Assembly], Verdict]  #: by forces
    verify: Callable[[Assembly], Dynamic] | None  #: by motion; None: statics alone decide
    begin: Callable[[Assembly], None] | None = None  #: told what `verify` will probably be asked about
    speculative: int = 0  #: how many such designs at a time
    under: Callable[[Assembly], Assembly] = lambda assembly: assembly  #: another friction or gravity
    memory: Memory | None = None  #: the one that `static` hands to `assess`, if any
    remark: Callable[[Verdict, Any], str] | None = None  #: gives the note of a candidate from its two verdicts
    progress: Callable[[int, int, Candidate], None] | None = None  #: judged, expected, the last one
    cancel: Callable[[], bool] | None = None  #: asked before each verdict; True ends the search


@dataclass
class Evaluator:
    """Verdicts on the designs of a space."""

    space: Space
    callbacks: Callbacks
    history: History | None
    expected: int = 0  #: number of designs that the strategy looks at, at most
    unbuilt: int = 0  #: designs that were passed over without a row, because they cannot be built
    rows: dict[Key, Candidate] = field(default_factory=dict)  #: in the order in which they were asked for
    known: dict[Key, Candidate] = field(default_factory=dict)  #: of an earlier run
    standing: dict[Key, Any] = field(default_factory=dict)  #: dynamic verdicts of this run on designs that stand
    #: judged by statics before they are asked for, each with the state of the memory before
    _foreseen: dict[Key, tuple[Candidate, Any]] = field(default_factory=dict)
    _evaluated: dict[Key, tuple[Assembly, Verdict]] = field(default_factory=dict)  #: until dynamics have been asked
    _begun: set[Key] = field(default_factory=set)
    _ruled: dict[Key, Candidate] = field(default_factory=dict)  #: what `static` says of designs that were measured
    _volumes: FreeVolumes = field(default_factory=FreeVolumes)
    _restored: bool = False

    def __post_init__(self) -> None:
        rows = self.history.read() if self.history else {}
        self.known = {key: self._taken_up(candidate) for key, candidate in rows.items()}

    def _taken_up(self, candidate: Candidate) -> Candidate:
        """A row of an earlier run; where that run had no dynamic verdict it counts as judged by statics in this one."""
        if candidate.dynamic not in (UNASKED, BY_STATICS, ERROR):
            return candidate
        note = "" if candidate.dynamic == ERROR else candidate.note
        return replace(candidate, dynamic=self._unsimulated(candidate.static), dynamic_seconds=0.0, note=note)

    def _unsimulated(self, static: str) -> str:
        """The dynamic verdict of a design that was not simulated, by the static one."""
        if static == Outcome.UNSTABLE.word:
            return PRUNED
        return BY_STATICS if self.callbacks.verify is None and static == Outcome.STABLE.word else UNASKED

    def make(self, values: Mapping[str, float]) -> Assembly:
        """Build a design as it is judged.

        Parameters
        ----------
        values : mapping of str to float
            Parameter values of the design.

        Returns
        -------
        Assembly
            Under the friction and gravity of the search.

        Raises
        ------
        InputError
            When its parts do not fit together, or for a value outside its bounds.
        """
        return self.callbacks.under(build(self.space.at(values)))

    def weigh(self, values: Values) -> float:
        """Return the volume of a design, of which only the elements are built that no design before had.

        Parameters
        ----------
        values : dict of str to float
            Parameter values of the design.

        Returns
        -------
        float
            Volume of the free blocks [m3].

        Raises
        ------
        InputError
            For a design with an element that cannot be built.
        """
        return self._volumes.of(self.space.at(values))

    def ask(self, values: Mapping[str, float], *, dynamics: bool = True, always: bool = False) -> Candidate:
        """Return the candidate with some values, and judge it if that was not done before.

        Parameters
        ----------
        values : mapping of str to float
            Parameter values of the design, in the order of the space.
        dynamics : bool, optional
            Simulate it where statics allow it.
        always : bool, optional
            Simulate it in any case.

        Returns
        -------
        Candidate
            Its verdict is "error" where the design cannot be built.

        Raises
        ------
        KeyboardInterrupt
            When the search was cancelled.
        """
        key = tuple(values.values())
        before = self.rows.get(key, self.known.get(key))
        foreseen = self._foreseen.pop(key, None)
        candidate = before or (foreseen[0] if foreseen else self._static(key, dict(values)))
        wanted = (UNASKED, PRUNED) if always else (UNASKED,)
        if dynamics and candidate.static != ERROR and candidate.dynamic in wanted:
            candidate = self._dynamic(key, candidate)
        self._evaluated.pop(key, None)
        return self.enter(key, candidate, new=candidate is not before)

    def offer(self, values: Mapping[str, float]) -> Candidate:
        """Return the candidate with some values as `ask` does, after `static` has judged it, too.

        A design that was only measured has its static verdict from its reserve.

        Parameters
        ----------
        values : mapping of str to float
            Parameter values of the design, in the order of the space.

        Returns
        -------
        Candidate
            It may be offered if it stands.

        Raises
        ------
        KeyboardInterrupt
            When the search was cancelled before a simulation.
        """
        key = tuple(values.values())
        row = self.rows.get(key, self.known.get(key))
        if row is not None and row.reserve is not None:
            if key not in self._ruled:
                self._ruled[key] = self._judged(key, dict(values))
            ruled = self._ruled[key]
            if ruled.static != row.static:
                dynamic = row.dynamic if row.simulated and not ruled.excluded else ruled.dynamic
                said = {"static": ruled.static, "score": ruled.score, "evidence": ruled.evidence}
                self.enter(key, replace(row, **said, dynamic=dynamic, note=ruled.note or row.note), new=True)
        return self.ask(values)

    def first_that_stands(self, line: Sequence[Values]) -> Values | None:
        """Return the first of some designs that stands.

        They are judged in their order, and none behind the answer is entered.

        Parameters
        ----------
        line : sequence of dict
            Parameter values of the designs.

        Returns
        -------
        dict of str to float, or None
            Parameter values of the first that stands; None where none does.

        Raises
        ------
        KeyboardInterrupt
            When the search was cancelled.
        """
        try:
            for number, values in enumerate(line):
                self._look_ahead(line[number:])
                if self.ask(values).stands:
                    return values
        finally:
            self._forget_foreseen()
        return None

    def _look_ahead(self, line: Iterable[Values]) -> None:
        """Begin the simulations of the next designs that statics allow.

        Statics judge in the same order as without, so that verdicts rest on the same evidence.
        """
        if self.callbacks.begin is None:
            return
        running = 0
        for values in line:
            key = tuple(values.values())
            candidate = self.rows.get(key, self.known.get(key))
            if candidate is None:
                candidate = self._foresee(key, dict(values))
            if candidate.dynamic != UNASKED or candidate.static == ERROR:
                continue
            if key not in self._begun:
                self._begun.add(key)
                self.callbacks.begin(self._of(key, candidate)[0])
            running += 1
            if running == self.callbacks.speculative:
                return

    def _foresee(self, key: Key, values: dict[str, float]) -> Candidate:
        """Judge a design by statics, unless that was done."""
        if key not in self._foreseen:
            self.restore()
            memory = self.callbacks.memory
            state = memory.state() if memory is not None else None
            self._foreseen[key] = self._static(key, values), state
        return self._foreseen[key][0]

    def _forget_foreseen(self) -> None:
        """Forget designs that were foreseen and not asked for: what follows rests on no evidence of theirs."""
        if self._foreseen and self.callbacks.memory is not None:
            self.callbacks.memory.go_back(next(iter(self._foreseen.values()))[1])
        for key in self._foreseen:
            self._evaluated.pop(key, None)
        self._foreseen.clear()

    def _of(self, key: Key, candidate: Candidate) -> tuple[Assembly, Verdict]:
        """The assembly of a candidate and what statics say of it."""
        if key not in self._evaluated:
            assembly = self.make(candidate.parameters)
            self._evaluated[key] = assembly, self.callbacks.static(assembly)
        return self._evaluated[key]

    def enter(self, key: Key, candidate: Candidate, *, new: bool) -> Candidate:
        """Enter a candidate into the rows, and into the history file if it is new.

        Parameters
        ----------
        key : tuple of float
            Its parameter values in the order of the space.
        candidate : Candidate
            Replaces the row with the same key.
        new : bool
            Whether the history file has no such line yet.

        Returns
        -------
        Candidate
            The same.
        """
        if new and self.history:
            self.history.append(candidate)
        first = key not in self.rows
        self.rows[key] = candidate
        if first and self.callbacks.progress is not None:
            self.callbacks.progress(len(self.rows), max(self.expected, len(self.rows)), candidate)
        return candidate

    def _static(self, key: Key, values: dict[str, float]) -> Candidate:
        self.restore()
        self.check_cancelled()
        return self._judged(key, values)

    def _judged(self, key: Key, values: dict[str, float]) -> Candidate:
        begin = process_time()
        try:
            assembly = self.make(values)
            verdict = self.callbacks.static(assembly)
        except InputError as error:
            return Candidate(values, ERROR, None, UNASKED, None, None, process_time() - begin, 0.0, error.line)
        self._evaluated[key] = assembly, verdict
        return Candidate(
            parameters=values,
            static=verdict.outcome.word,
            score=verdict.score if isfinite(verdict.score) else None,
            dynamic=self._unsimulated(verdict.outcome.word),
            volume=float(assembly.volume[assembly.free].sum()),
            blocks=assembly.n_blocks,
            static_seconds=process_time() - begin,
            dynamic_seconds=0.0,
            evidence=EVIDENCE.get(verdict.solver, SOLVED),
        )

    def _dynamic(self, key: Key, candidate: Candidate) -> Candidate:
        if self.callbacks.verify is None:
            return candidate
        self.check_cancelled()
        assembly, verdict = self._of(key, candidate)
        begin = process_time()
        try:
            found = self.callbacks.verify(assembly)
        except InputError as error:
            return replace(candidate, dynamic=ERROR, dynamic_seconds=process_time() - begin, note=error.line)
        seconds = max(process_time() - begin, getattr(found, "process_seconds", 0.0))
        candidate = replace(candidate, dynamic=_checked_word(found), dynamic_seconds=seconds)
        if candidate.stands:
            self.standing[key] = found
        note = self.callbacks.remark(verdict, found) if self.callbacks.remark else ""
        return replace(candidate, note=note or candidate.note)

    def restore(self) -> None:
        """Bring back the evidence that an interrupted run had: solve again what it solved, in its order.

        Only so do the rows that follow rest on the same evidence as those of an uninterrupted run.
        """
        if self._restored:
            return
        self._restored = True
        if self.callbacks.memory is None:
            return
        for candidate in self.known.values():
            if candidate.evidence == SOLVED and candidate.reserve is None:  # measuring leaves no evidence
                self.callbacks.static(self.make(candidate.parameters))

    def check_cancelled(self) -> None:
        """Ask whether the search was cancelled.

        Raises
        ------
        KeyboardInterrupt
            When it was.
        """
        if self.callbacks.cancel is not None and self.callbacks.cancel():
            raise KeyboardInterrupt


def _checked_word(found: Any) -> str:
    """The outcome of a dynamic verdict in one word; a static one never stands."""
    word = getattr(getattr(found, "outcome", None), "word", None)
    if word is None or isinstance(found, Verdict):
        what = "a static verdict" if isinstance(found, Verdict) else f"a {type(found).__name__}"
        raise InputError(f"verify gave {what}; it must give a verdict that stands or falls, as `dynsim.verify` does")
    return word
