"""Orders in which an assembly can be built with few hands, found by taking the finished assembly down.

Hands move one at a time: a new block arrives in a hand, and a hand lets go or takes hold of a block only while all
stands. The search runs backwards from the finished assembly: a block in a hand is taken out, or a hand is opened. Where
the state that follows falls, its mechanism stays admissible until one of the blocks that move in it is held. So only
these are tried, and a search that ends without an order has proven that there is none.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import count
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.result import Result, Sentence
from blockstat.sequence.plan import Plan, Step
from blockstat.sequence.states import Whole
from blockstat.solve.phase_one import STEEP

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Blocks present and held, as bits of two numbers.
Node = tuple[int, int]
#: Blocks that move slower than this share of the fastest may not be what a mechanism rests on; they are tried, too.
AT_REST = 1e-9


class OrderOutcome(Sentence):
    """What a search for an order found."""

    FOUND = "Found: an order in which every state is proven stable."
    NONE = "None: no order with so few held blocks exists; every way has been tried."
    UNDECIDED = "Undecided: no order found, and some states could be proven neither stable nor unstable."
    STOPPED = "Stopped: the search was interrupted before it found an order."


@dataclass(frozen=True, eq=False)
class OrderResult(Result):
    """An order with at most so many held blocks, or why there is none."""

    outcome: OrderOutcome
    plan: Plan | None
    held_at_most: int
    states: int  #: states judged
    solved: int  #: of these, solved for; the others rest on the forces or the mechanism of an earlier state
    seconds: float

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With the steps of the plan.
        """
        steps = None
        if self.plan is not None:
            steps = [{"install": list(step.install), "hold": list(step.hold)} for step in self.plan.steps]
        return {
            "outcome": self.outcome.word,
            "held_at_most": self.held_at_most,
            "most_held": self.plan.most_held if self.plan is not None else None,
            "states": self.states,
            "solved": self.solved,
            "seconds": self.seconds,
            "steps": steps,
        }

    def explain(self) -> str:
        """Return the result in words.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value]
        if self.plan is not None:
            lines.append(f"{len(self.plan.steps)} steps, at most {self.plan.most_held} held at once.")
        each = 1e3 * self.seconds / max(self.states, 1)
        lines.append(f"{self.states} states judged ({self.solved} solved) in {self.seconds:.1f} s, {each:.1f} ms each.")
        return "\n".join(lines)


@known_options
def find_order(
    assembly: Assembly,
    *,
    held_at_most: int,
    friction: float | None = None,
    flow: str = "associated",
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    seconds: float | None = None,
) -> OrderResult:
    """Search an order of building in which never more than so many blocks are held at once.

    Parameters
    ----------
    assembly : Assembly
        The finished assembly; its supports stand from the beginning.
    held_at_most : int
        Hands, at least 1: a new block arrives in one.
    friction, flow, gap, interfaces
        As of `assess_states`.
    seconds : float, optional
        Time after which the search stops; an interrupt from the keyboard stops it, too.

    Returns
    -------
    OrderResult
        The plan, every state of which is proven stable; or none, with the reason.

    Raises
    ------
    InputError
        For fewer than one hand.

    Examples
    --------
    Two stones side by side and one on both.

    >>> from blockstat import Assembly, box, find_order
    >>> blocks = [box((-2, 0, -1), (2, 1, 0), name="ground"), box((-1, 0, 0), (0, 1, 1), name="left"),
    ...           box((0, 0, 0), (1, 1, 1), name="right"), box((-0.5, 0, 1), (0.5, 1, 2), name="top")]
    >>> found = find_order(Assembly.from_blocks(blocks, supports=["ground"]), held_at_most=1)
    >>> found.outcome.word, [step.install for step in found.plan.steps if step.install][-1]
    ('found', ('top',))
    """
    if held_at_most < 1:
        raise InputError(f"held_at_most is {held_at_most}; a new block arrives in a hand, so at least 1 is needed")
    search = Search(Whole(assembly, friction=friction, gap=gap, interfaces=interfaces), held_at_most, flow)
    began = monotonic()
    try:
        outcome, path = search.run(None if seconds is None else began + seconds)
    except KeyboardInterrupt:
        outcome, path = OrderOutcome.STOPPED, None
    plan = None if path is None else search.plan(path)
    statistics = search.whole.evidence.statistics
    return OrderResult(outcome, plan, held_at_most, search.judged, statistics["solved"], monotonic() - began)


@dataclass(frozen=True)
class _Move:
    """How a state is reached: from which other, which block is to be taken out, and the hands that this takes."""

    parent: Node
    wanted: int | None = None
    room: int = 0


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

    def __init__(self, whole: Whole, hands: int, flow: str) -> None:
        self.whole, self.hands, self._flow = whole, hands, flow
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
        self.judged, self.undecided = 0, 0
        self._before: dict[Node, Node | None] = {}
        self._known: dict[Node, list[int] | None] = {}
        self._falls: list[_Fall] = []
        self._queue: list[Any] = []
        self._tick = count()

    def run(self, until: float | None) -> tuple[OrderOutcome, list[Node] | None]:
        """The outcome, and the states from nothing to the finished assembly."""
        self._push((self._full, 0), _Move((self._full, 0)))
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
        return (OrderOutcome.UNDECIDED if self.undecided else OrderOutcome.NONE), None

    def falls(self, state: Node) -> list[int] | None:
        """The blocks that move where a state is not proven stable, the fastest first; None where it is."""
        if state not in self._known:
            known = next((fall for fall in self._falls if fall.holds_in(state)), None)
            self._known[state] = self._judge(state) if known is None else known.moving
        return self._known[state]

    def _judge(self, state: Node) -> list[int] | None:
        present, fixed = (_mask(bits, self.whole.assembly.support) for bits in state)
        verdict = self.whole.assess(present, fixed, flow=self._flow, score=False)
        self.judged += 1
        if verdict.outcome is Outcome.STABLE:
            return None
        if verdict.outcome is not Outcome.UNSTABLE:
            self.undecided += 1
            return np.flatnonzero(present & ~fixed).tolist()
        speed = verdict.motion
        moving = [int(b) for b in np.argsort(-speed, kind="stable") if speed[b] > AT_REST]
        if not (speed[speed <= AT_REST] > 0).any():
            moved = sum(1 << b for b in moving)
            around = 0
            for b in moving:
                around |= self._touching[b]
            self._falls.insert(0, _Fall(moving, moved, around & ~state[0]))
        return moving

    def _hold_one_of(self, moving: list[int], move: _Move) -> None:
        """Before a move whose state falls: take hold of a block that moves, of those beside it first."""
        present, held = move.parent
        if held.bit_count() + move.room >= self.hands:
            return
        beside = 0 if move.wanted is None else self._touching[move.wanted]
        for place, block in enumerate(sorted(moving, key=lambda b: not beside >> b & 1)):
            if not held >> block & 1 and present >> block & 1:
                self._push((present, held | 1 << block), _Move(move.parent, wanted=move.wanted), (place,))

    def _expand(self, state: Node, wanted: int | None) -> None:
        present, held = state
        for block in _bits(held):
            self._push((present, held & ~(1 << block)), _Move(state, wanted=wanted))
        for block in _bits(present):
            # The block is in a hand while it is taken out, which leaves one hand less for others.
            taken = held >> block & 1
            if taken or held.bit_count() < self.hands:
                rest = present & ~(1 << block), held & ~(1 << block)
                joints = (self._touching[block] & present).bit_count()
                burden = (self._above[block] & present).bit_count()
                order = (block != wanted, joints + burden, self._rank[block])
                self._push(rest, _Move(state, block, 0 if taken else 1), order)

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
        """The steps of a plan: a block arrives in a hand, or hands change."""
        names = self.whole.assembly.names
        steps = []
        for (before, _), (present, held) in zip(path, path[1:], strict=False):
            new = present & ~before
            hold = [names[b] for b in _bits(held | new)]
            steps.append(Step(tuple(names[b] for b in _bits(new)), tuple(hold)))
            if new & ~held:
                steps.append(Step((), tuple(names[b] for b in _bits(held))))
        boundary = tuple(name for name, fixed in zip(names, self.whole.assembly.support, strict=True) if fixed)
        return Plan(tuple(steps), boundary, name=f"{self.whole.assembly.name}, built")


def _above(whole: Whole) -> list[int]:
    """For each block, as bits, those that rest on it: the normal of their joint with it points up."""
    faces, found = whole.interfaces, [0] * whole.assembly.n_blocks
    rise = -faces.frame[:, 0] @ (whole.assembly.gravity / np.linalg.norm(whole.assembly.gravity))
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
