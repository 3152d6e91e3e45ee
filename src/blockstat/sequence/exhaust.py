"""All orders of a small assembly: how many there are, and the least number of hands, proven by exhaustion."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.sequence.search import Search
from blockstat.sequence.states import Whole

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Free blocks up to which all states are tried: some ten thousand.
SMALL = 14


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
