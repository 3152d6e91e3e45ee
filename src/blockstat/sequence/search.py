"""The search for an order of building: backwards from the finished assembly, best first.

A journal keeps what came of each state, written before the search goes on. The search is determined by these outcomes.
So it is run again from the beginning, and states in the journal cost nothing. A last line cut short is left out.
"""

from __future__ import annotations

import hashlib
import heapq
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import count
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.errors import InputError
from blockstat.loads import up_of
from blockstat.result import Sentence
from blockstat.sequence.insertion import StraightMotion, StraightMotions
from blockstat.sequence.plan import Plan, Step
from blockstat.sequence.states import Whole
from blockstat.solve.phase_one import STEEP
from blockstat.system.rows import kept_rows
from blockstat.typing import Floats

#: Blocks present and held, as bits of two numbers.
Node = tuple[int, int]
#: Blocks that move slower than this share of the fastest are at rest where the mechanism is one without them, too.
#: Elsewhere it may rest on them: to hold one of them is tried, too, and it is not taken for one of other states.
AT_REST = 1e-9


class OrderOutcome(Sentence):
    """What a search for an order found."""

    FOUND = "Found: an order in which every state is proven stable."
    NONE = "None: no order with so few held blocks exists; every way has been tried."
    UNDECIDED = "Undecided: no order found, but not every way to one is excluded."
    STOPPED = "Stopped: the search was ended before it found an order."


@dataclass(frozen=True)
class Constraints:
    """What a step asks for besides statics."""

    groups: Sequence[Sequence[str]] = ()  #: blocks that are put in together
    reach: Callable[[str, frozenset[str]], bool] | None = None  #: whether a block can be put in beside others
    insertion: bool = False  #: whether a straight motion must bring it there


class Journal:
    """Outcomes of states on disk.

    Parameters
    ----------
    path : str or Path
        A file of lines of JSON; it is made if it is not there.
    whole : Whole
        The assembly with its joints.
    flow : str
        "associated" or "coulomb".

    Raises
    ------
    InputError
        For a file that is no journal, or that of another assembly, joints, friction or flow.
    """

    def __init__(self, path: str | Path, whole: Whole, flow: str) -> None:
        self._path = Path(path)
        head = {"journal": "blockstat sequence", "of": _fingerprint(whole), "flow": flow}
        other = "outcomes of another assembly, joints, friction or flow"
        try:
            #: what `note` was given, by state
            self.known: dict[Node, Any] = dict(kept_rows(self._path, head, _noted, other=other))
            self._path.open("a").close()  # whether it can be written to is known before the search
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}") from None

    def note(self, state: Node, outcome: Any) -> None:
        """Write down what came of a state.

        Parameters
        ----------
        state : (int, int)
            Blocks present and held, as bits.
        outcome : object
            Anything that JSON can hold.
        """
        with self._path.open("a") as file:
            file.write(json.dumps([hex(state[0]), hex(state[1]), outcome]) + "\n")


def _noted(row: list[Any]) -> tuple[Node, Any]:
    """A state and what came of it."""
    present, held, outcome = row
    return (int(present, 16), int(held, 16)), outcome


def _fingerprint(whole: Whole) -> str:
    """A digest of all that the verdict on a state depends on: blocks, supports, laws, groups, joints and tolerance."""
    digest = hashlib.sha256()

    def add(value: Any, but: tuple[str, ...] = ()) -> None:
        if isinstance(value, np.ndarray):
            digest.update(repr((value.dtype.str, value.shape)).encode() + value.tobytes())
        elif is_dataclass(value):
            for field in fields(value):
                if field.name not in but:
                    digest.update(f"{field.name}=".encode())
                    add(getattr(value, field.name))
        elif isinstance(value, tuple | list):
            digest.update(f"{len(value)} of".encode())
            for one in value:
                add(one)
        else:
            digest.update(repr(value).encode() + b";")

    add(whole.assembly, but=("name", "metadata"))
    add(whole.interfaces)
    add(whole.gap)
    return digest.hexdigest()


@dataclass(frozen=True)
class _Move:
    """How a state is reached: from which other, the blocks to be taken out, and the hands that this takes."""

    parent: Node
    wanted: int = 0
    hands: int = 0


@dataclass(frozen=True)
class _Fall:
    """A mechanism, as what it asks of a state: that these blocks are present and free, and those others absent."""

    moving: list[int]
    moved: int
    absent: int

    def holds_in(self, state: Node) -> bool:
        present, held = state
        return not (self.moved & ~present or self.moved & held or self.absent & present)


class Search:
    """Best first: fewest blocks left, then fewest hands, then blocks with few joints. A state is judged when taken.

    A mechanism found in one state is one of every other state in which the blocks that it moves are present and free,
    and touch no others than they did. So most states that fall are known to without a solve.
    """

    def __init__(
        self,
        whole: Whole,
        hands: int,
        flow: str,
        constraints: Constraints = Constraints(),
        journal: Journal | None = None,
    ) -> None:
        self.whole, self.hands, self._flow, self._journal = whole, hands, flow, journal
        assembly = whole.assembly
        self.free = assembly.free
        self._full = sum(1 << int(k) for k in self.free)
        height = -assembly.centroid @ assembly.gravity
        self._rank = {int(b): k for k, b in enumerate(sorted(self.free.tolist(), key=lambda b: -height[b]))}
        self._touching = [0] * assembly.n_blocks
        for a, b in whole.touching.tolist():
            self._touching[a] |= 1 << b
            self._touching[b] |= 1 << a
        self._above = _above(whole)
        self._units = _units(whole, constraints.groups)
        self._access = _Access(whole, constraints)
        self.judged, self.undecided = 0, 0
        self.stands = False  #: whether the finished assembly is proven to stand
        self.fallen: list[int] | None = None  #: what moves where it is not proven to
        self._before: dict[Node, Node | None] = {}
        self._known: dict[Node, list[int] | None] = {}
        self._falls: list[_Fall] = []
        self._queue: list[Any] = []
        self._tick = count()

    def run(self, until: float | None) -> tuple[OrderOutcome, list[Node] | None]:
        """Search from the finished assembly back to nothing.

        Parameters
        ----------
        until : float or None
            Reading of `time.monotonic` at which the search stops [s]; None for no bound. It is asked before each state
            is taken, but the finished assembly is judged in any case.

        Returns
        -------
        outcome : OrderOutcome
            What was found.
        path : list of Node or None
            The states from nothing to the finished assembly, in the order of building; None for any outcome but
            `FOUND`.
        """
        finished = self._full, 0
        self.fallen = self.falls(finished)
        if self.fallen is None:
            self.stands = True
            self._push(finished, _Move(finished))
        while self._queue:
            if until is not None and monotonic() > until:
                return OrderOutcome.STOPPED, None
            *_, state, move = heapq.heappop(self._queue)
            if state in self._before:
                continue
            moving = self.falls(state)
            if moving is not None:
                self._hold_one_of(moving, move)
                continue
            self._before[state] = move.parent if state != move.parent else None
            if not state[0]:
                return OrderOutcome.FOUND, self._path(state)
            self._expand(state, move.wanted)
        return (OrderOutcome.UNDECIDED if self.undecided or self.barred else OrderOutcome.NONE), None

    @property
    def barred(self) -> list[int]:
        """Blocks for which no straight motion was found beside others, though none is excluded."""
        return sorted(self._access.barred)

    def falls(self, state: Node) -> list[int] | None:
        """Return the blocks that move where a state is not proven stable.

        Parameters
        ----------
        state : (int, int)
            Blocks present and held, as bits; supports are in neither.

        Returns
        -------
        list of int or None
            Their numbers, the fastest first in the state in which their mechanism was found; where the state is
            undecided, all that are present and free, ascending. None where it is proven stable.
        """
        if state not in self._known:
            known = next((fall for fall in self._falls if fall.holds_in(state)), None)
            self._known[state] = self._judge(state) if known is None else known.moving
        return self._known[state]

    def _judge(self, state: Node) -> list[int] | None:
        noted = None if self._journal is None else self._journal.known.get(state)
        if noted is None:
            noted = self._outcome(state)
            if self._journal is not None:
                self._journal.note(state, noted)
        self.judged += 1
        self.undecided += noted["outcome"] == Outcome.UNDECIDED.word
        if noted["outcome"] == Outcome.STABLE.word:
            return None
        moving: list[int] = noted["moving"]
        if noted["complete"]:
            around = 0
            for b in moving:
                around |= self._touching[b]
            self._falls.insert(0, _Fall(moving, sum(1 << b for b in moving), around & ~state[0]))
        return moving

    def _outcome(self, state: Node) -> dict[str, Any]:
        """What the statics say of a state: its outcome and the blocks that move, if these are all, fastest first."""
        present, fixed = (_mask(bits, self.whole.assembly.support) for bits in state)
        verdict = self.whole.assess(present, fixed, flow=self._flow, score=False)
        if verdict.outcome is Outcome.STABLE:
            return {"outcome": verdict.outcome.word}
        if verdict.outcome is not Outcome.UNSTABLE:
            moving = np.flatnonzero(present & ~fixed).tolist()
            return {"outcome": Outcome.UNDECIDED.word, "moving": moving, "complete": False}
        speed = verdict.motion
        slow = (speed > 0) & (speed <= AT_REST)
        without = np.where(slow[:, None], 0.0, verdict.mechanism)
        complete = not slow.any() or self.whole.falls_by(without, present, fixed)
        moving = [int(b) for b in np.argsort(-speed, kind="stable") if speed[b] > (AT_REST if complete else 0.0)]
        return {"outcome": verdict.outcome.word, "moving": moving, "complete": complete}

    def _hands(self, held: int) -> int:
        """Hands that hold some blocks; a group is in one."""
        return held.bit_count() if not self._units.groups else sum(bool(held & unit) for unit in self._units.all)

    def _hold_one_of(self, moving: list[int], move: _Move) -> None:
        """Before a move whose state falls: take hold of a block that moves, of those beside it first."""
        present, held = move.parent
        beside = self._around(move.wanted)
        for place, block in enumerate(sorted(moving, key=lambda b: not beside >> b & 1)):
            more = held | 1 << block
            if more != held and present >> block & 1 and self._hands(more) + move.hands <= self.hands:
                self._push((present, more), _Move(move.parent, wanted=move.wanted), (place,))

    def _around(self, unit: int) -> int:
        """The blocks that touch those of a unit."""
        found = 0
        for block in _bits(unit):
            found |= self._touching[block]
        return found & ~unit

    def _expand(self, state: Node, wanted: int) -> None:
        present, held = state
        for block in _bits(held):
            self._push((present, held & ~(1 << block)), _Move(state, wanted=wanted))
        hands = self._hands(held)
        for unit in self._units.all:
            # The block is in a hand while it is taken out, which leaves one hand less for others.
            if not unit & present or not (held & unit or hands < self.hands):
                continue
            joints = (self._around(unit) & present).bit_count()
            burden = sum((self._above[b] & present & ~unit).bit_count() for b in _bits(unit))
            if self._access.free(unit, present & ~unit):
                order = (unit != wanted, joints + burden, self._rank[unit.bit_length() - 1])
                self._push((present & ~unit, held & ~unit), _Move(state, unit, hands=0 if held & unit else 1), order)

    def _push(self, state: Node, move: _Move, order: tuple[int, ...] = ()) -> None:
        if state not in self._before:
            key = state[0].bit_count(), state[1].bit_count(), order, next(self._tick)
            heapq.heappush(self._queue, (*key, state, move))

    def _path(self, state: Node) -> list[Node]:
        path: list[Node] = [state]
        while (before := self._before[path[-1]]) is not None:
            path.append(before)
        return path

    def plan(self, path: list[Node]) -> Plan:
        """Return the plan of a path of states: at each step a block arrives in a hand, or hands change.

        Parameters
        ----------
        path : list of Node
            States from nothing to the finished assembly, as `run` returns them.

        Returns
        -------
        Plan
            What is put in is held in the step in which it arrives; where it is not held in the state, a step without it
            in a hand follows. The directions of straight motions, by name, are in `metadata["insertion"]` where they
            were asked for.
        """
        names = self.whole.assembly.names
        steps, insertion = [], {}
        for (before, _), (present, held) in zip(path, path[1:], strict=False):
            new = present & ~before
            if new and (way := self._access.direction(new, before)) is not None:
                insertion |= {names[b]: way.tolist() for b in _bits(new)}
            hold = [names[b] for b in _bits(held | new)]
            steps.append(Step(tuple(names[b] for b in _bits(new)), tuple(hold)))
            if new & ~held:
                steps.append(Step((), tuple(names[b] for b in _bits(held))))
        metadata = {"insertion": insertion} if insertion else {}
        boundary = tuple(name for name, fixed in zip(names, self.whole.assembly.support, strict=True) if fixed)
        return Plan(tuple(steps), boundary, name=f"{self.whole.assembly.name}, built", metadata=metadata)


@dataclass(frozen=True)
class _Units:
    """What is put in together, as bits."""

    all: list[int]
    groups: bool  #: whether some have more than one block


def _units(whole: Whole, groups: Sequence[Sequence[str]]) -> _Units:
    assembly = whole.assembly
    found, taken = [], 0
    for group in groups:
        unit = 0
        for block in assembly.blocks_named(group, "groups").tolist():
            if assembly.support[block] or (taken | unit) >> block & 1:
                why = "a support" if assembly.support[block] else "in two groups, or twice in one"
                raise InputError(f'groups: block "{assembly.names[block]}" is {why}')
            unit |= 1 << block
        found.append(unit)
        taken |= unit
    alone = [1 << b for b in assembly.free.tolist() if not taken >> b & 1]
    return _Units(sorted([*found, *alone]), bool(found))


class _Access:
    """Whether units can be put in beside others. What is free beside some is free beside fewer."""

    def __init__(self, whole: Whole, constraints: Constraints) -> None:
        self._whole, self._constraints = whole, constraints
        self._motions = StraightMotions(whole.assembly, whole.interfaces) if constraints.insertion else None
        self._free: dict[int, int] = {}
        self._found: dict[tuple[int, int], StraightMotion] = {}
        self.barred = set[int]()

    def free(self, unit: int, others: int) -> bool:
        """Whether a unit can be put in while others are there."""
        reach, names = self._constraints.reach, self._whole.assembly.names
        if reach is not None:
            there = frozenset(names[b] for b in np.flatnonzero(_mask(others, self._whole.assembly.support)))
            if not all(reach(names[b], there) for b in _bits(unit)):
                return False
        if unit in self._free and not others & ~self._free[unit]:
            return True
        found = self._motion(unit, others)
        if found is None or found.direction is not None:
            self._free[unit] = others
            return True
        if not found.is_excluded:
            self.barred |= set(_bits(unit))
        return False

    def _motion(self, unit: int, others: int) -> StraightMotion | None:
        if self._motions is None:
            return None
        if (unit, others) not in self._found:
            present = _mask(others, self._whole.assembly.support)
            self._found[unit, others] = self._motions.find(_bits(unit), present)
        return self._found[unit, others]

    def direction(self, unit: int, others: int) -> Floats | None:
        """The direction in which a unit comes in beside others; None for none, or where none is asked for."""
        found = self._motion(unit, others)
        if found is None or found.direction is not None:
            return None if found is None else found.direction
        # Joints suggest what is tried: beside fewer, what is free beside more may not be found again.
        beside_more = (
            way.direction for (one, there), way in self._found.items() if one == unit and not others & ~there
        )
        return next((direction for direction in beside_more if direction is not None), None)


def _above(whole: Whole) -> list[int]:
    """For each block, as bits, those that rest on it: the normal of their joint with it points up."""
    faces, found = whole.interfaces, [0] * whole.assembly.n_blocks
    down = -up_of(whole.assembly)
    rise = -faces.frame[:, 0] @ down
    for (a, b), up in zip(faces.pair.tolist(), rise.tolist(), strict=True):
        if abs(up) > STEEP:
            low, high = (a, b) if up > 0 else (b, a)
            found[low] |= 1 << high
    return found


def _bits(number: int) -> list[int]:
    return [k for k in range(number.bit_length()) if number >> k & 1]


def _mask(bits: int, support: np.ndarray) -> np.ndarray:
    mask = support.copy()
    mask[_bits(bits)] = True
    return mask
