"""Single blocks taken out of an assembly: whether the rest stands, and which blocks fall.

Blocks fall that cannot stand even if all others are held. A mechanism of some blocks with all others at rest is one of
the whole, so some of these blocks move, whatever the others do. Few blocks tell more than many: the mechanism of all
may push aside a pier that would stand without what falls on it. So blocks are asked one by one, from the gap on. Where
none falls alone, the nearest blocks around the gap that fall together are, and of these a part is left out while the
others still fall. What falls is taken out, and what is left is asked again, until it stands.

What falls one by one is the same in any order: taking out others leaves fewer joints to hold a block. Of blocks that
fall only together all are counted, although some of them may stand once the others are gone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import check_choice, known_options
from blockstat.sequence.states import Whole
from blockstat.typing import Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


#: Blocks that fall together are asked in so many parts whether one could be held in vain: up to so many one by one.
PARTS = 16


@dataclass(frozen=True, eq=False)
class RemovalVerdict(Verdict):
    """The verdict on what is left when a block is taken out, with the blocks that fall then."""

    #: names of the blocks that cannot stand, few together, even if all others are held, and of those that cannot once
    #: these are gone, and so on until the rest stands; None where one of these answers is undecided
    falls: tuple[str, ...] | None = None


@known_options
def remove_each(
    assembly: Assembly,
    *,
    blocks: Iterable[str] | None = None,
    friction: float | None = None,
    flow: str = "associated",
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, RemovalVerdict]:
    """Take out every single block of an assembly in turn and judge what is left.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    blocks : iterable of str, optional
        The blocks that are taken out; by default all that are no supports.
    friction, flow, gap, interfaces
        As of `assess_states`.
    progress : callable, optional
        Called with the blocks taken out so far and those asked for. With it a KeyboardInterrupt after the first leaves
        the others out of the answer; without it, it is raised.

    Returns
    -------
    dict of str to RemovalVerdict
        By the block taken out; those with a stable verdict may go now, and what falls with the others needs a prop
        first. A state that falls has no score (nan).

    Notes
    -----
    What falls is a statement of statics: nothing is hit by what comes down, or shaken.

    Examples
    --------
    >>> from blockstat import Assembly, box, remove_each
    >>> blocks = [box((-1, 0, -1), (1, 1, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="low"),
    ...           box((0, 0, 1), (1, 1, 2), name="high")]
    >>> found = remove_each(Assembly.from_blocks(blocks, supports=["ground"]))
    >>> {name: (verdict.outcome.word, verdict.falls) for name, verdict in found.items()}
    {'low': ('unstable', ('high',)), 'high': ('stable', ())}
    """
    check_choice("flow", flow, FLOWS)
    whole = Whole(assembly, friction=friction, gap=gap, interfaces=interfaces)
    chosen = assembly.free if blocks is None else assembly.blocks_named(blocks, "remove_each")
    everything = np.ones(assembly.n_blocks, dtype=bool)
    whole.assess(everything, assembly.support, flow=flow, score=False)
    whole.evidence.pin()
    left = _Left(whole, flow)
    found = dict[str, RemovalVerdict]()
    try:
        for block in chosen.tolist():
            present = everything.copy()
            present[block] = False
            verdict = left.verdict(present, present)
            falls = left.falling(present, verdict)
            names = None if falls is None else tuple(assembly.names[k] for k in falls)
            given: dict[str, Any] = {one.name: getattr(verdict, one.name) for one in fields(verdict)}
            found[assembly.names[block]] = RemovalVerdict(**given, falls=names)
            if progress is not None:
                progress(len(found), len(chosen))
    except KeyboardInterrupt:
        if progress is None or not found:
            raise
    return found


class _Left:
    """What is left of an assembly when blocks are gone.

    Parameters
    ----------
    whole : Whole
        The assembly.
    flow : str
        As of `assess_states`.
    """

    def __init__(self, whole: Whole, flow: str) -> None:
        self.whole, self.flow = whole, flow
        self.support = whole.assembly.support
        self.beside: list[Ints] = [np.empty(0, dtype=np.int64)] * len(self.support)
        both = np.concatenate([whole.touching, whole.touching[:, ::-1]])
        for block in np.unique(both[:, 0]).tolist():
            self.beside[block] = both[both[:, 0] == block, 1]
        self._alone = dict[tuple[int, bytes], bool]()

    def verdict(self, present: np.ndarray, free: np.ndarray) -> Verdict:
        """Return the verdict on the blocks present, all of them held that are not free."""
        return self.whole.assess(present, present & (self.support | ~free), flow=self.flow, score=False)

    def _fall(self, present: np.ndarray, blocks: Ints) -> bool:
        """Whether some blocks fall with all others held."""
        return self.verdict(present, np.isin(np.arange(len(present)), blocks)).outcome is Outcome.UNSTABLE

    def falling(self, present: np.ndarray, verdict: Verdict) -> Ints | None:
        """Return which of the blocks present fall, in their order, or None where that is undecided.

        Parameters
        ----------
        present : array of bool, shape (n_blocks,)
            What is there.
        verdict : Verdict
            On these.

        Returns
        -------
        array of int, or None
            Numbers of blocks.
        """
        there, fallen = present.copy(), list[int]()
        gone = np.flatnonzero(~present).tolist()
        while verdict.outcome is Outcome.UNSTABLE:
            before = len(fallen)
            while gone:
                for block in self.beside[gone.pop()].tolist():
                    if there[block] and not self.support[block] and self._falls_alone(block, there):
                        there[block] = False
                        fallen.append(block)
                        gone.append(block)
            if len(fallen) == before:
                gone = self._fewest(there, verdict.moving).tolist()
                there[gone] = False
                fallen += gone
            if not (there & ~self.support).any():
                break
            verdict = self.verdict(there, there)
        decided = verdict.outcome in (Outcome.STABLE, Outcome.UNSTABLE)
        return np.array(fallen, dtype=np.int64) if decided else None

    def _falls_alone(self, block: int, there: np.ndarray) -> bool:
        """Whether a block falls with all others held, which depends on those beside it alone."""
        key = block, there[self.beside[block]].tobytes()
        if key not in self._alone:
            self._alone[key] = self._fall(there, np.array([block]))
        return self._alone[key]

    def _fewest(self, there: np.ndarray, moving: Ints) -> Ints:
        """Blocks next to the gap that fall together with all others held, and do not if one of `PARTS` is held, too.

        They are among those that move in a mechanism of the blocks present.
        """
        order = self._outwards(there)
        order = order[np.isin(order, moving)]
        low, high, step = 0, len(order), 1  # the first `high` fall together, the first `low` do not
        while low + step < high:
            if self._fall(there, order[: low + step]):
                high = low + step
            else:
                low, step = low + step, 2 * step
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if self._fall(there, order[:middle]) else (middle, high)
        needed, size = order[:high], high + 1
        while len(needed) < size:
            size, parts = len(needed), np.array_split(needed, min(PARTS, len(needed)))
            for part in parts[::-1]:
                fewer = np.setdiff1d(needed, part, assume_unique=True)
                if len(fewer) and self._fall(there, fewer):
                    needed = fewer
            if size <= PARTS:
                break
        return needed

    def _outwards(self, there: np.ndarray) -> Ints:
        """The free blocks that are present by the joints between them and what is gone; last those without a way."""
        reached, free = ~there, there & ~self.support
        order, rim = list[int](), np.flatnonzero(~there).tolist()
        while rim:
            beside = {block for one in rim for block in self.beside[one].tolist()}
            rim = sorted(block for block in beside if free[block] and not reached[block])
            reached[rim] = True
            order += rim
        return np.array([*order, *np.flatnonzero(free & ~reached).tolist()], dtype=np.int64)
