"""Quantities and plans with a known answer, and what becomes of them: the same for the tests and for the page."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from time import process_time
from typing import Any

from blockstat import Assembly, InputError, Plan, assess_plan, capacity, limit_load
from evidence.hard.cases import UNDECIDED, Case

Make = Callable[[], Assembly]
DIGITS = 1e-4  #: of a limit load: the tolerance that `limit_load` states
TEN = 1e-8  #: of a limit load with `optimum`: ten digits are stated, of which two are left to the last solve


@dataclass(frozen=True)
class Found:
    """An answer: its word, and the ends of its bracket, which are the same for a value without one."""

    word: str
    lower: float
    upper: float
    told: tuple[str, ...] = ()


@dataclass(frozen=True)
class Figure:
    """A quantity with a known value."""

    name: str
    ask: Callable[[], Found]
    truth: float | Callable[[], float]
    why: str  #: where the truth comes from
    within: float = DIGITS  #: how far the answer may be off, relative to `scale`
    scale: float | None = None  #: by default the truth
    word: str = "limit"  #: of the right outcome
    bracket: bool = True  #: whether the answer claims to prove both of its ends
    flaw: str = ""  #: what falls short, where that is known
    slow: bool = False

    @cached_property
    def value(self) -> float:
        """The truth."""
        return float(self.truth() if callable(self.truth) else self.truth)


@dataclass(frozen=True)
class Stages:
    """A plan, and the outcome of each of its steps."""

    name: str
    make: Make
    plan: Plan
    right: tuple[str, ...]
    why: str


@dataclass(frozen=True)
class Section:
    """A family of cases, with where the truth about them comes from."""

    title: str
    text: str
    cases: tuple[Case, ...] = ()
    figures: tuple[Figure, ...] = ()
    stages: tuple[Stages, ...] = ()


@dataclass(frozen=True)
class FigureRow:
    """One figure as it came out."""

    figure: Figure
    found: Found
    seconds: float

    @property
    def off(self) -> float:
        """How far the end of the bracket that is further from the truth is off, relative to the scale."""
        value = self.figure.value
        return max(abs(self.found.lower - value), abs(self.found.upper - value)) / (self.figure.scale or abs(value))

    @property
    def judged(self) -> str:
        """Right, wide (the bracket holds the truth, but less sharply than is stated), off, or wrong."""
        figure, found = self.figure, self.found
        if found.word in ("crash", "hang", "rejected"):
            return found.word
        if found.word != figure.word:
            return "off"
        allowed = figure.within * (figure.scale or abs(figure.value))
        if found.lower > figure.value + allowed or found.upper < figure.value - allowed:
            return "WRONG" if figure.bracket else "off"
        return "right" if self.off <= figure.within else "wide"


@dataclass(frozen=True)
class StagesRow:
    """One plan as it came out."""

    stages: Stages
    words: tuple[str, ...]
    seconds: float

    @property
    def judged(self) -> str:
        """Right, undecided, or wrong."""
        pairs = list(zip(self.words, self.stages.right, strict=True))
        if all(word == right for word, right in pairs):
            return "right"
        return UNDECIDED if all(word in (right, UNDECIDED) for word, right in pairs) else "WRONG"


def figure_row(figure: Figure) -> FigureRow:
    """Ask for a figure. What the independent checks reject, and what ends in an error of Python, are answers too."""
    begin, nan = process_time(), float("nan")
    try:
        found = figure.ask()
    except InputError as error:
        found = Found("refused", nan, nan, (str(error),))
    except AssertionError as error:
        found = Found("rejected", nan, nan, (f"independent check: {error}",))
    except TimeoutError as error:
        found = Found("hang", nan, nan, (str(error),))
    except Exception as error:
        found = Found("crash", nan, nan, (f"{type(error).__name__}: {error}",))
    return FigureRow(figure, found, process_time() - begin)


def stages_row(stages: Stages) -> StagesRow:
    """Judge every step of a plan."""
    begin = process_time()
    found = assess_plan(stages.make(), stages.plan)
    return StagesRow(stages, tuple(outcome.word for outcome in found.outcomes), process_time() - begin)


def patient(ask: Callable[[], Found], seconds: int) -> Callable[[], Found]:
    """The question, given up after so many seconds; in the main thread alone."""

    def give_up(*_: Any) -> None:
        raise TimeoutError(f"no answer in {seconds} s")

    def asked() -> Found:
        before = signal.signal(signal.SIGALRM, give_up)
        signal.alarm(seconds)
        try:
            return ask()
        finally:
            signal.alarm(0)
            signal.signal(signal.SIGALRM, before)

    return asked


def limit(make: Make, load: Any, **options: Any) -> Callable[[], Found]:
    """The question for a limit load."""

    def ask() -> Found:
        found = limit_load(make(), load, **options)
        return Found(found.outcome.word, found.lower, found.upper, found.warnings)

    return ask


def end_of_curve(make: Make, load: Any, control: Any, **options: Any) -> Callable[[], Found]:
    """The question for the displacement at which a capacity curve ends."""

    def ask() -> Found:
        found = capacity(make(), load, control=control, **options)
        end = float(found.displacement[-1])
        return Found(found.outcome.word, end, end, found.warnings)

    return ask


def at_change(
    make: Make, load: Any, control: Any, *, what: str = "parameter", number: int = 0, **options: Any
) -> Callable[[], Found]:
    """The question for a change of the mechanism on a capacity curve: its place, or the multiplier before or after."""

    def ask() -> Found:
        found = capacity(make(), load, control=control, **options)
        value = float(getattr(found.events[number], what)) if number < len(found.events) else float("nan")
        word = found.events[number].kind if number < len(found.events) else found.outcome.word
        return Found(word, value, value, found.warnings)

    return ask
