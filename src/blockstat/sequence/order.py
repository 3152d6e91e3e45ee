"""Orders in which an assembly can be built with few hands, found by taking the finished assembly down.

Hands move one at a time: a new block arrives in a hand, and a hand lets go or takes hold of a block only while all
stands. The search runs backwards from the finished assembly: a block in a hand is taken out, or a hand is opened. Where
the state that follows falls, its mechanism stays admissible until one of the blocks that move in it is held. So only
these are tried, and a search that ends without an order has proven that there is none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.result import Result
from blockstat.sequence.plan import Plan
from blockstat.sequence.search import Constraints, Journal, OrderOutcome, Search
from blockstat.sequence.states import Whole

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


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
        Called with the name of a block and the names of all that are there before it; False where a crane or an arm
        cannot put it in.
    insertion : bool, optional
        Whether each block must come in by a straight motion that collides with nothing (see
        `blockstat.sequence.insertion`); the directions are in `plan.metadata["insertion"]`.
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
    if held_at_most < 1:
        raise InputError(f"held_at_most is {held_at_most}; a new block arrives in a hand, so at least 1 is needed")
    whole = Whole(assembly, friction=friction, gap=gap, interfaces=interfaces)
    kept = None if journal is None else Journal(journal, whole, flow)
    search = Search(whole, held_at_most, flow, Constraints(groups, reach, insertion), kept)
    began = monotonic()
    try:
        outcome, path = search.run(None if seconds is None else began + seconds)
    except KeyboardInterrupt:
        outcome, path = OrderOutcome.STOPPED, None
    plan = None if path is None else search.plan(path)
    statistics = whole.evidence.statistics
    return OrderResult(outcome, plan, held_at_most, search.judged, statistics["solved"], monotonic() - began)
