"""Orders in which an assembly can be built with few hands, found by taking the finished assembly down.

Hands move one at a time: a new block arrives in a hand, and a hand lets go or takes hold of a block only while all
stands. The search runs backwards from the finished assembly: a block in a hand is taken out, or a hand is opened. Where
the state that follows falls, its mechanism stays admissible until one of the blocks that move in it is held. So only
these are tried, and a search that ends without an order has proven that there is none.

What stands at some friction stands at any larger one. So the least friction at which an order with so many hands exists
divides those at which none does from those at which some does, and bisection finds it. An order found at some friction
stands from its own least friction on, which narrows the bracket from above; a search that proves that there is none
narrows it from below.

Of a small assembly all sets of blocks are judged: how many orders there are, and the least numbers of hands.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_choice, check_count, check_seconds, known_options
from blockstat.result import Result, finite, listed
from blockstat.sequence.plan import Plan, least_friction
from blockstat.sequence.search import Constraints, Journal, OrderOutcome, Search
from blockstat.sequence.states import Whole

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Free blocks up to which all states are tried: some ten thousand.
SMALL = 14
#: The bracket of the least friction is narrowed to this, or to this share of it.
NARROW = 1e-3
#: Blocks that a line names.
FEW = 5


@dataclass(frozen=True, eq=False)
class OrderResult(Result):
    """An order with at most so many held blocks, or why there is none."""

    outcome: OrderOutcome
    plan: Plan | None
    held_at_most: int
    states: int  #: states judged
    solved: int  #: of these, solved for; the others rest on the forces or the mechanism of an earlier state
    seconds: float
    #: the finished assembly with nothing held, with which every order ends; None where the search ended before it
    finished: Outcome | None = Outcome.STABLE
    moving: tuple[str, ...] = ()  #: blocks that move first where the finished assembly falls
    undecided: int = 0  #: states that could be proven neither stable nor unstable
    barred: tuple[str, ...] = ()  #: blocks with no straight motion found beside others, though none is excluded
    time_limit: float | None = None  #: where it was stopped by its limit of time, that limit [s]

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With the steps of the plan; `finished` is the verdict on the finished assembly with nothing held, None where
            the search was interrupted before it.
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
            "undecided": self.undecided,
            "finished": self.finished and self.finished.word,
            "moving": list(self.moving),
            "barred": list(self.barred),
            "seconds": self.seconds,
            "time_limit": self.time_limit,
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
        if self.time_limit is not None:
            lines = [f"Stopped: the limit of {self.time_limit:g} s was over before the search found an order."]
        if self.finished is None:
            lines.append("The finished assembly itself, with which every order ends, was not judged.")
        elif self.finished is Outcome.UNSTABLE:
            what = "the finished assembly itself does not stand, and every order ends with it"
            lines = [f"None: {what}; first to move: {listed(self.moving, FEW)}."]
        elif self.finished is not Outcome.STABLE:
            what = "the finished assembly itself, with which every order ends, could be proven neither to stand nor to"
            lines = [f"Undecided: {what} fall."]
        elif self.outcome is OrderOutcome.UNDECIDED:
            lines += [f"{self.undecided} states could be proven neither stable nor unstable."] * bool(self.undecided)
            lines += [f"No straight motion was found for {listed(self.barred, FEW)}, nor proven not to exist."] * bool(
                self.barred
            )
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
    groups: Sequence[Sequence[str]] = (),
    reach: Callable[[str, frozenset[str]], bool] | None = None,
    insertion: bool = False,
    journal: str | Path | None = None,
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
    groups : sequence of sequences of str, optional
        Blocks that are put in together, as one in one hand.
    reach : callable, optional
        Called with the name of a block and the names of all that are there before it, supports among them; False where
        a crane or an arm cannot put it in.
    insertion : bool, optional
        Whether each block, or group as one, must come in by a straight motion that collides with nothing (see
        `blockstat.sequence.insertion`); the directions are in `plan.metadata["insertion"]`. Not all directions are
        tried: a search that ends because none of them is free is "undecided", unless joints block every direction.
    journal : str or Path, optional
        A file in which each judged state is kept. A search that has ended in any way goes on from it.
    seconds : float, optional
        Time after which the search stops; an interrupt from the keyboard stops it, too.

    Returns
    -------
    OrderResult
        The plan, every state of which is proven stable; or none, with the reason.

    Raises
    ------
    InputError
        For fewer than one hand, a group of blocks that are not free or in two groups, or a journal of something else.

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
    check_choice("flow", flow, FLOWS)
    check_count("held_at_most", held_at_most)
    check_seconds(seconds)
    whole = Whole(assembly, friction=friction, gap=gap, interfaces=interfaces)
    kept = None if journal is None else Journal(journal, whole, flow)
    search = Search(whole, held_at_most, flow, Constraints(groups, reach, insertion), kept)
    began, over = monotonic(), None
    try:
        outcome, path = search.run(None if seconds is None else began + seconds)
        over = seconds if outcome is OrderOutcome.STOPPED else None
    except KeyboardInterrupt:
        outcome, path = OrderOutcome.STOPPED, None
    plan = None if path is None else search.plan(path)
    finished, moving = Outcome.STABLE if search.stands else None, list[int]()
    if search.fallen is not None:
        finished = Outcome.UNDECIDED if search.undecided else Outcome.UNSTABLE
        moving = [] if search.undecided else search.fallen
    names, solved = assembly.names, whole.evidence.statistics["solved"]
    moved, barred = (tuple(names[k] for k in blocks) for blocks in (moving, search.barred))
    known = finished, moved, search.undecided, barred, over
    return OrderResult(outcome, plan, held_at_most, search.judged, solved, monotonic() - began, *known)


@dataclass(frozen=True, eq=False)
class SafestOrder(Result):
    """The order that stands at the least friction, and with it at the largest reserve."""

    found: OrderResult  #: the order, or why there is none; its states and seconds are those of all searches
    friction: float  #: of the assembly
    #: no order with so few hands stands at the first, which is 0 where that is not proven; the plan does at the second
    least_friction: tuple[float, float] | None
    ended: OrderOutcome = OrderOutcome.FOUND  #: of the last search: "stopped" or "undecided" leave the bracket wide

    @property
    def reserve(self) -> float:
        """Friction over the least at which every step of the plan stands; nan without a plan."""
        if self.least_friction is None:
            return float("nan")
        return self.friction / self.least_friction[1] if self.least_friction[1] > 0 else float("inf")

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Those of the order, with `least_friction` and `reserve`.
        """
        least = self.least_friction and [finite(value) for value in self.least_friction]
        return {**self.found.summary(), "least_friction": least, "reserve": finite(self.reserve)}

    def explain(self) -> str:
        """Return the result in words.

        Returns
        -------
        str
            One fact a line.
        """
        if self.least_friction is None:
            return self.found.explain()
        low, high = self.least_friction
        if high == np.inf:
            return (
                f"{self.found.explain()}\nEvery step stands at infinite friction; that any less will do is not proven."
            )
        reserve = f": reserve {self.reserve:.3f}" if high > 0 else ""
        line = f"Every step stands from a friction of {high:.5f}{reserve}."
        if high - low > NARROW * max(high, 1.0):
            line += f" {self.ended.word.capitalize()}: orders that stand at less are not excluded above {low:.5f}."
        elif low > 0:
            line += f" No order does at {low:.5f}."
        return f"{self.found.explain()}\n{line}"


@known_options
def safest_order(
    assembly: Assembly,
    *,
    held_at_most: int,
    friction: float | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    groups: Sequence[Sequence[str]] = (),
    reach: Callable[[str, frozenset[str]], bool] | None = None,
    insertion: bool = False,
    seconds: float | None = None,
) -> SafestOrder:
    """Search the order of building whose least reserve of friction over all steps is the largest.

    Every order ends with the finished assembly, so none stands at less friction than that does.

    Parameters
    ----------
    assembly : Assembly
        The finished assembly, with one coefficient of friction.
    held_at_most, friction, gap, interfaces, groups, reach, insertion
        As of `find_order`.
    seconds : float, optional
        Time after which it stops with the best order so far; an interrupt from the keyboard stops it, too.

    Returns
    -------
    SafestOrder
        The order and the bracket of the least friction, at most a thousandth wide unless it was stopped.

    Raises
    ------
    InputError
        As of `find_order`, and where joint laws give joints a friction of their own.

    Examples
    --------
    A block on a ledge of its own needs little friction, whatever the order.

    >>> from blockstat import Assembly, box, safest_order
    >>> blocks = [box((-1, 0, -1), (0, 1, 0), name="ground"), box((-0.6, 0, 0), (0.3, 1, 1), name="low")]
    >>> safest_order(Assembly.from_blocks(blocks, supports=["ground"]), held_at_most=1).reserve > 1000
    True
    """
    whole = Whole(assembly, friction=friction, gap=gap, interfaces=interfaces)
    options: dict[str, Any] = {
        "held_at_most": held_at_most, "gap": gap, "interfaces": whole.interfaces, "groups": groups, "reach": reach,
        "insertion": insertion,
    }  # fmt: skip
    began, own = monotonic(), whole.assembly.friction
    best = find_order(whole.assembly, seconds=seconds, **options)
    states, solved, ended = best.states, best.solved, best.outcome
    least = None if best.plan is None else (0.0, own)
    until = None if seconds is None else began + seconds
    try:
        if least is not None:
            least = 0.0, min(own, _needed(whole, best, until))
            finished = np.ones(assembly.n_blocks, dtype=bool), whole.assembly.support
            low = least_friction(whole, [finished], until)[0]
            falls = whole.at_friction(low).assess(*finished, score=False).outcome is Outcome.UNSTABLE
            least = low if falls else 0.0, least[1]
        while least is not None and least[1] - least[0] > NARROW * max(least[1], 1.0):
            left = None if until is None else max(until - monotonic(), 0.0)
            middle = sum(least) / 2
            found = find_order(whole.assembly, friction=middle, seconds=left, **options)
            states, solved, ended = states + found.states, solved + found.solved, found.outcome
            if found.plan is not None:
                best, least = found, (least[0], middle)
                least = least[0], min(middle, _needed(whole, found, until))
            elif found.outcome is OrderOutcome.NONE:
                least = middle, least[1]
            else:
                break
    except KeyboardInterrupt:
        ended = OrderOutcome.STOPPED
    spent = monotonic() - began
    return SafestOrder(replace(best, states=states, solved=solved, seconds=spent), own, least, ended)


def _needed(whole: Whole, found: OrderResult, until: float | None) -> float:
    """The least friction at which every step of a plan stands."""
    assert found.plan is not None
    states = [whole.state_of(*state, f"step {k}") for k, state in enumerate(found.plan.states())]
    return least_friction(whole, states, until)[1]


@dataclass(frozen=True)
class OrderCount:
    """What exhaustion says about an assembly, "stable" meaning proven stable."""

    states: int  #: sets of blocks, 2^n with the empty one
    stable: int  #: of these, stable with nothing held
    undecided: int  #: of these, neither proven stable nor unstable
    orders: int  #: orders of all blocks in which every state is stable with nothing held
    rest: int  #: least over orders of the largest number that must be held when no hand moves
    #: the same where the block that is being placed is held and counts, and others may be regripped in between
    placing: int


@known_options
def count_orders(
    assembly: Assembly,
    *,
    friction: float | None = None,
    flow: str = "associated",
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> OrderCount:
    """Judge every set of blocks of a small assembly and count the orders in which it can be built.

    Parameters
    ----------
    assembly : Assembly
        Of at most 14 free blocks.
    friction, flow, gap, interfaces
        As of `assess_states`.

    Returns
    -------
    OrderCount
        The numbers of states and orders, and of hands in two ways of counting. For hands that move one at a time see
        `find_order`.

    Raises
    ------
    InputError
        For a larger assembly.

    Examples
    --------
    >>> from blockstat import Assembly, box, count_orders
    >>> blocks = [box((-1, 0, -1), (1, 1, 0), name="ground"), box((-1, 0, 0), (0, 1, 1), name="one"),
    ...           box((0, 0, 0), (1, 1, 1), name="two"), box((-0.4, 0, 1), (0.6, 1, 2), name="top")]
    >>> found = count_orders(Assembly.from_blocks(blocks, supports=["ground"]))
    >>> found.stable, found.orders, found.rest, found.placing
    (6, 3, 0, 1)
    """
    check_choice("flow", flow, FLOWS)
    n = len(assembly.free)
    if n > SMALL:
        raise InputError(f"{n} blocks have 2^{n} states; all orders are counted for at most {SMALL} free blocks")
    search = Search(Whole(assembly, friction=friction, gap=gap, interfaces=interfaces), n, flow)
    bits = [1 << int(block) for block in search.free]
    sets = sorted((_union(bits, k) for k in range(1 << n)), key=int.bit_count)
    stable = {one for one in sets if search.falls((one, 0)) is None}
    ways = {0: 1}
    for one in sets[1:]:
        ways[one] = sum(ways[one & ~b] for b in bits if one & b) if one in stable else 0
    undecided = search.undecided
    hands = _Hands(search, bits, sets)
    return OrderCount(1 << n, len(stable), undecided, ways[sets[-1]], hands.least(False), hands.least(True))


def _union(bits: list[int], chosen: int) -> int:
    return sum(bit for k, bit in enumerate(bits) if chosen >> k & 1)


class _Hands:
    """The least numbers of held blocks, by trying sets of them from small to large."""

    def __init__(self, search: Search, bits: list[int], sets: list[int]) -> None:
        self._search, self._bits, self._sets = search, bits, sets

    def least(self, placing: bool) -> int:
        """The least over orders of the largest number held."""
        for hands in range(int(placing), len(self._bits) + 1):
            reached = {0}
            for one in self._sets[1:]:
                below = [b for b in self._bits if one & b and one & ~b in reached]
                held = below if placing else [0] * bool(below)
                if any(self._stands(one, first, hands) for first in held):
                    reached.add(one)
            if self._sets[-1] in reached:
                return hands
        return len(self._bits)

    def _stands(self, present: int, first: int, hands: int) -> bool:
        """Whether a state stands with some so many held, `first` among them. Holding more never makes a state fall."""
        others = [b for b in self._bits if present & b and not first & b]
        spare = min(hands - first.bit_count(), len(others))
        return any(self._search.falls((present, first | sum(some))) is None for some in combinations(others, spare))
