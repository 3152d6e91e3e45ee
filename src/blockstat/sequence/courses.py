"""Building course by course: what must be held after each course, with bounds on how few blocks that is.

All blocks of a course are held until it is complete. So every state within a course is one of two kinds: blocks that
stood before, in balance with the forces that they had, and blocks that are held. Then some are let go. Where the state
after a course is stable with H held it is so with more blocks held, whatever the order of letting go. A plan of courses
is therefore proven by one state a course.

The least number held, of a state that falls, has bounds from two sides. A mechanism of the state asks for one of the
blocks that move in it. Blocks that fall alone beside all others, fixed, must each be held. Of further mechanisms those
that share no block each ask for one more. From above, one block of each mechanism is held until the state stands, and
those that turn out not to be needed are let go.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import check_seconds, check_vector, known_options
from blockstat.geometry.components import connected_components
from blockstat.result import Result, Sentence, listed
from blockstat.sequence.plan import Plan, Step
from blockstat.sequence.search import Journal
from blockstat.sequence.states import Evidence, Whole
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Directions of courses, as `build_by_courses` takes them.
Along = Sequence[float] | Mapping[str, Sequence[float]] | None
#: Blocks whose centroids are no further apart along the order than this share of the smallest are of one course.
LEVEL = 1e-3
#: Blocks that a line names.
FEW = 5
#: Of the fastest block, below which a block is at rest in a mechanism.
AT_REST = 1e-6


class CoursesOutcome(Sentence):
    """What came of building by courses."""

    BUILT = "Built: after each course every block is proven to stand, if need be while some of them are held."
    UNDECIDED = "Undecided: after some course the blocks could be proven neither to stand nor to fall."
    STOPPED = "Stopped: the search was ended before the last course."


@dataclass(frozen=True)
class Course:
    """A course and what must be held once it is complete."""

    blocks: tuple[str, ...]  #: put in, and held until all of them are there
    held: tuple[str, ...]  #: held when the next course begins; the state is proven stable with them
    at_least: int  #: no fewer blocks hold it, by mechanisms


@dataclass(frozen=True, eq=False)
class CoursesResult(Result):
    """A building put up course by course."""

    outcome: CoursesOutcome
    courses: tuple[Course, ...]  #: those that were looked at
    plan: Plan | None  #: one step a course; None where the outcome is not "built"
    states: int  #: states judged
    seconds: float
    planned: int = 0  #: courses that the building has
    time_limit: float | None = None  #: where it was stopped by its limit of time, that limit [s]

    @property
    def most_held(self) -> int:
        """The largest number of blocks held between two courses."""
        return max((len(course.held) for course in self.courses), default=0)

    @property
    def at_least(self) -> int:
        """No fewer blocks need to be held when these courses are built in this order."""
        return max((course.at_least for course in self.courses), default=0)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With one row a course, numbered from 0.
        """
        return {
            "outcome": self.outcome.word,
            "courses": len(self.courses),
            "planned": self.planned,
            "most_held": self.most_held,
            "at_least": self.at_least,
            "states": self.states,
            "seconds": self.seconds,
            "time_limit": self.time_limit,
            "rows": [
                {"course": k, "blocks": len(c.blocks), "held": list(c.held), "at_least": c.at_least}
                for k, c in enumerate(self.courses)
            ],
        }

    def explain(self) -> str:
        """Return the result in words.

        Returns
        -------
        str
            One fact a line.
        """
        lines, every = [self.outcome.value], max(self.planned, len(self.courses))
        if self.time_limit is not None:
            lines = [f"Stopped: the limit of {self.time_limit:g} s was over before the last course."]
        last = self.courses[-1].held if self.courses else ()
        if last and self.outcome is CoursesOutcome.BUILT:
            held = f"{listed(last, FEW)} {'is' if len(last) == 1 else 'are'} held"
            lines.append(f"The finished assembly is proven to stand only while {held}.")
        free = sum(not course.held for course in self.courses)
        done = f"{len(self.courses)} of {every}" if len(self.courses) < every else f"{every}"
        lines.append(f"{done} courses; {free} of them stand by themselves.")
        if self.most_held:
            worst = max(range(len(self.courses)), key=lambda k: len(self.courses[k].held))
            where = f"after course {worst + 1} of {every}"
            lines.append(f"Most blocks are held {where}: {self.most_held}; no fewer than {self.at_least} will do.")
        lines.append(f"{self.states} states judged in {self.seconds:.1f} s.")
        return "\n".join(lines)


@known_options
def build_by_courses(
    assembly: Assembly,
    *,
    along: Along = None,
    friction: float | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    journal: str | Path | None = None,
    seconds: float | None = None,
) -> CoursesResult:
    """Build an assembly course by course and find how few blocks must be held after each.

    Parameters
    ----------
    assembly : Assembly
        The finished assembly; its supports stand from the beginning.
    along : sequence of float, or dict of str to sequence of float, optional
        The direction in which courses follow each other, shape (3,); against gravity by default. Blocks whose centroids
        are level along it are one course. A dict gives the directions of groups, which are built one after the other:
        walls upwards, then a vault along the nave, ring by ring. What is in none of them comes last, upwards.
    friction, gap, interfaces
        As of `assess_states`.
    journal : str or Path, optional
        A file in which what came of each course is kept. A search that has ended in any way goes on from it.
    seconds : float, optional
        Time after which it stops; an interrupt from the keyboard stops it, too.

    Returns
    -------
    CoursesResult
        What is held after each course, with a proof that no fewer than so many will do, and the plan.

    Raises
    ------
    InputError
        For an unknown group, a direction of no length, or a journal of something else.

    Examples
    --------
    The stones of an arch fall alone, all but those on the springers.

    >>> from blockstat import build_by_courses
    >>> from blockstat.model import arch, assemble
    >>> ring = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=7, springers=0.3))
    >>> found = build_by_courses(ring)
    >>> [(len(course.blocks), len(course.held), course.at_least) for course in found.courses]
    [(2, 0, 0), (2, 2, 2), (2, 2, 2), (1, 0, 0)]
    """
    whole = Whole(assembly, friction=friction, gap=gap, interfaces=interfaces)
    check_seconds(seconds)
    courses = courses_of(assembly, along)
    site = _Site(whole, None if journal is None else Journal(journal, whole, "courses"))
    began, built, outcome, over = monotonic(), list[Course](), CoursesOutcome.BUILT, None
    present, held = assembly.support.copy(), np.zeros(assembly.n_blocks, dtype=bool)
    try:
        for course in courses:
            if seconds is not None and monotonic() > began + seconds:
                outcome, over = CoursesOutcome.STOPPED, seconds
                break
            present[course] = True
            held, least, is_proven = site.held_after(present, held, course)
            outcome = outcome if is_proven else CoursesOutcome.UNDECIDED
            built.append(Course(_names(assembly, course), _names(assembly, np.flatnonzero(held)), least))
    except KeyboardInterrupt:
        outcome = CoursesOutcome.STOPPED
    plan = None
    if outcome is CoursesOutcome.BUILT:
        boundary = _names(assembly, np.flatnonzero(assembly.support))
        steps = tuple(Step(course.blocks, course.held) for course in built)
        plan = Plan(steps, boundary, name=f"{assembly.name}, built by courses")
    return CoursesResult(outcome, tuple(built), plan, site.judged, monotonic() - began, len(courses), over)


def courses_of(assembly: Assembly, along: Along = None) -> list[Ints]:
    """Return the free blocks by courses, in the order of building.

    Parameters
    ----------
    assembly, along
        As of `build_by_courses`.

    Returns
    -------
    list of array of int
        The blocks of each course.

    Raises
    ------
    InputError
        As of `build_by_courses`.
    """
    upwards = (-assembly.gravity).tolist()
    directions: dict[str | None, Sequence[float]] = {}
    if isinstance(along, Mapping):
        directions.update(along)
    directions[None] = upwards if along is None or isinstance(along, Mapping) else along
    left, found = ~assembly.support, list[Ints]()
    for group, direction in directions.items():
        axis = check_vector("along", direction)
        own = left.copy()
        if group is not None:
            own &= np.isin(np.arange(assembly.n_blocks), assembly.in_group(group))
        left &= ~own
        found += levels(assembly, np.flatnonzero(own), axis)
    return found


def levels(assembly: Assembly, blocks: Ints, axis: Floats) -> list[Ints]:
    """Return blocks by courses: those whose centroids are level along an axis are one.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    blocks : array of int
        Some of them.
    axis : array of float, shape (3,)
        The direction in which courses follow each other, of any length.

    Returns
    -------
    list of array of int
        The blocks of each course; none without blocks.
    """
    if not len(blocks):
        return []
    place = assembly.centroid @ (axis / np.linalg.norm(axis))
    order = blocks[np.argsort(place[blocks], kind="stable")]
    step = np.diff(place[order]) > LEVEL * assembly.size[blocks].min()
    return np.split(order, np.flatnonzero(step) + 1)


def _names(assembly: Assembly, blocks: Ints) -> tuple[str, ...]:
    return tuple(assembly.names[k] for k in blocks.tolist())


class _Site:
    """The states of a building by courses."""

    def __init__(self, whole: Whole, journal: Journal | None) -> None:
        self._whole, self._journal = whole, journal
        self._part = copy.copy(whole)  # states of a few blocks beside fixed ones, with evidence of their own
        self._part.evidence = Evidence(whole.assembly.n_blocks, whole.interfaces.n_points)
        self.judged = 0

    def held_after(self, present: np.ndarray, held: np.ndarray, course: Ints) -> tuple[np.ndarray, int, bool]:
        """Blocks held once a course is in, no fewer than how many will do, and whether the state is proven stable."""
        bits = sum(1 << int(k) for k in np.flatnonzero(present))
        noted = None if self._journal is None else self._journal.known.get((bits, 0))
        if noted is None:
            found, least, is_proven = self._least_held(present, np.union1d(np.flatnonzero(held), course))
            noted = {"held": np.flatnonzero(found).tolist(), "least": least, "proven": is_proven}
            if self._journal is not None:
                self._journal.note((bits, 0), noted)
        hold = np.zeros(len(present), dtype=bool)
        hold[noted["held"]] = True
        return hold, noted["least"], noted["proven"]

    def _least_held(self, present: np.ndarray, likely: Ints) -> tuple[np.ndarray, int, bool]:
        """Blocks that hold a state; those that are likely to fall alone are asked first."""
        hold, demands = np.zeros(len(present), dtype=bool), list[set[int]]()
        outcome, motion = self._judge(present, hold)
        if outcome is not Outcome.STABLE:
            asked = np.union1d(likely, np.flatnonzero(motion > AT_REST * motion.max(initial=0.0)))
            hold[[k for k in asked.tolist() if self._falls(present, [k])]] = True
            outcome, motion = self._judge(present, hold)
        alone = hold.copy()
        while outcome is Outcome.UNSTABLE:
            for part in self._mechanisms(present, motion):
                demands.append(set(part.tolist()))
                hold[part[motion[part].argmax()]] = True
            outcome, motion = self._judge(present, hold)
        if outcome is Outcome.UNDECIDED:
            hold[likely] = True
            outcome = self._judge(present, hold)[0]
        least = int(alone.sum()) + _disjoint(demands)
        if outcome is Outcome.STABLE:
            self._let_go(present, hold, alone, least)
        return hold, least, outcome is Outcome.STABLE

    def _let_go(self, present: np.ndarray, hold: np.ndarray, alone: np.ndarray, least: int) -> None:
        """Let go what is not needed; blocks that fall alone are."""
        for block in np.flatnonzero(hold & ~alone).tolist():
            if hold.sum() <= least:
                return
            hold[block] = False
            hold[block] = self._judge(present, hold)[0] is not Outcome.STABLE

    def _judge(self, present: np.ndarray, hold: np.ndarray) -> tuple[Outcome, Floats]:
        """The verdict on a state with some blocks held, and how fast each moves."""
        self.judged += 1
        verdict = self._whole.assess(present, self._whole.assembly.support | hold, score=False, stands=True)
        return verdict.outcome, verdict.motion

    def _falls(self, present: np.ndarray, blocks: Sequence[int] | Ints) -> bool:
        """Whether some blocks fall beside all others that are there, fixed."""
        fixed = np.ones(len(present), dtype=bool)
        fixed[blocks] = False
        return self._part.assess(present, fixed, score=False).outcome is Outcome.UNSTABLE

    def _mechanisms(self, present: np.ndarray, motion: Floats) -> list[Ints]:
        """Sets of blocks that fall beside all others, fixed: parts of what moves that do not touch, or all of it."""
        moving = motion > AT_REST * motion.max()
        pairs = self._whole.touching
        _, label = connected_components(len(motion), pairs[moving[pairs].all(axis=1)])
        parts = [np.flatnonzero(moving & (label == k)) for k in np.unique(label[moving])]
        return [part for part in parts if self._falls(present, part)] or [np.flatnonzero(motion > 0)]


def _disjoint(demands: list[set[int]]) -> int:
    """How many demands share no block, the smallest taken first."""
    taken, count = set[int](), 0
    for demand in sorted(demands, key=len):
        if not demand & taken:
            taken |= demand
            count += 1
    return count
