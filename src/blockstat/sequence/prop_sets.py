"""Fewest props, and orders of building with the least force in a centring, both proven.

What some props hold, more of them hold. So a set that does not hold a state asks for one of the others, and where a
mechanism of the state with that set is known, for one of those that the mechanism moves against. The smallest sets that
meet all such demands are tried, until one holds: it is smallest (an implicit hitting set, after Moreno-Centeno & Karp
2013).
"""

from __future__ import annotations

import heapq
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations, count
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.certificate.check import FORCE_LIMIT, power
from blockstat.errors import InputError, InputWarning, check_choice, known_options
from blockstat.result import Result, counted
from blockstat.sequence.props import Falsework, FalseworkOutcome, Prop, held_by_props, pushes_of
from blockstat.sequence.states import State

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A prop resists a mechanism that moves against it by more than this share of the fastest joint.
AGAINST = 1e-7


@known_options
def fewest_props(
    assembly: Assembly, state: State, props: Sequence[Prop], *, friction: float | None = None
) -> Falsework | None:
    """Find the smallest set of props that holds a state.

    Parameters
    ----------
    assembly : Assembly
        All blocks, with dry joints.
    state : (sequence of str, sequence of str)
        As of `assess_states`.
    props : sequence of Prop
        Those to choose from.
    friction : float, optional
        Replaces the assembly's coefficient of friction.

    Returns
    -------
    Falsework or None
        The least total force of the smallest set that is proven to hold the state; None where all of them together
        are proven not to. Undecided, with all of them, where neither is.

    Warns
    -----
    InputWarning
        For smaller sets that are proven neither to hold the state nor not to.

    Examples
    --------
    Of three props below a stone, one at its middle does.

    >>> from blockstat import Assembly, Prop, box, fewest_props
    >>> blocks = [box((-2, 0, -1), (-1, 1, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="stone")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> props = [Prop("stone", (x, 0.5, 1.0), (0.0, 0.0, 1.0)) for x in (0.1, 0.5, 0.9)]
    >>> [prop.point[0] for prop in fewest_props(assembly, (["stone"], []), props).props]
    [0.5]
    """
    props = tuple(props)
    everything = held_by_props(assembly, state, props, least="total", friction=friction)[1]
    if everything.outcome is not FalseworkOutcome.HELD:
        return None if everything.outcome is FalseworkOutcome.NOT_HELD else everything
    demands: list[frozenset[int]] = []
    undecided: list[int] = []  # sizes of sets
    n = len(props)
    for size in range(n + 1):
        for chosen in combinations(range(n), size):
            if not all(demand.intersection(chosen) for demand in demands):
                continue
            some = [props[k] for k in chosen]
            problem, found, twist = held_by_props(assembly, state, some, least="total", friction=friction)
            if found.outcome is FalseworkOutcome.HELD:
                if smaller := sum(other < size for other in undecided):
                    sets = counted(smaller, "smaller set")
                    text = f"fewest_props: {sets} may hold the blocks, too; neither that is proven nor that none does"
                    warnings.warn(InputWarning(text), stacklevel=3)
                return found
            undecided += [size] * (found.outcome is FalseworkOutcome.UNDECIDED)
            demand = frozenset(range(n)) - set(chosen)
            if problem.program is not None and np.abs(twist).max(initial=0.0) > 0:
                u = twist / np.abs(twist).max()
                work, closing = power(problem.program, u)
                if work > closing * FORCE_LIMIT * problem.program.total_load:
                    against = np.flatnonzero(pushes_of(problem, props).T @ u < -AGAINST)
                    demand = frozenset(against.tolist()) if not set(against) & set(chosen) else demand
            demands.append(demand)
    return everything


@dataclass(frozen=True, eq=False)
class CentringOrder(Result):
    """An order of building in which the centring never carries more than the least possible."""

    order: tuple[str, ...]
    forces: tuple[float, ...]  #: total force of the centring after each block [N]
    states: int  #: states solved for
    undecided: int = 0  #: of these, those that props were proven neither to hold nor not to hold; no order goes by them

    @property
    def peak(self) -> float:
        """The largest of the forces [N]; no order has a smaller one, unless it goes by a state that is undecided."""
        return max(self.forces, default=0.0)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            The order with the forces.
        """
        return {
            "peak": self.peak,
            "order": list(self.order),
            "forces": list(self.forces),
            "states": self.states,
            "undecided": self.undecided,
        }

    def explain(self) -> str:
        """Return the result in words.

        Returns
        -------
        str
            One fact a line.
        """
        steps = (f"{block}: {force:.6g} N" for block, force in zip(self.order, self.forces, strict=True))
        least = "no order needs less"
        if self.undecided:
            least += f", unless it goes by one of {self.undecided} states that props may or may not hold"
        return "\n".join([f"The centring carries {self.peak:.6g} N at most; {least}.", *steps])


@known_options
def least_centring(
    assembly: Assembly,
    props: Callable[[Assembly, list[str]], Sequence[Prop]],
    *,
    least: str = "total",
    friction: float | None = None,
) -> CentringOrder:
    """Find the order of building with the least peak of the force in the centring.

    Parameters
    ----------
    assembly : Assembly
        The finished assembly, with dry joints.
    props : callable
        Gives the props of some blocks, as `hoists` and `centring` do; a block may have several.
    least : str, optional
        "total" counts the sum of the forces of a state, "peak" the largest of them.
    friction : float, optional
        Replaces the assembly's coefficient of friction.

    Returns
    -------
    CentringOrder
        The order, its forces, and how many states were solved for.

    Raises
    ------
    InputError
        Where no order is found in which the props are proven to hold the blocks.

    Notes
    -----
    Best first by the largest force so far, so the first order that is complete has the least peak.

    Examples
    --------
    >>> from blockstat import Assembly, box, hoists, least_centring
    >>> blocks = [box((-1, 0, -1), (0, 1, 0), name="ground"), box((-0.9, 0, 0), (0.1, 1, 1), name="low"),
    ...           box((-0.5, 0, 1), (0.5, 1, 2), name="high")]
    >>> least_centring(Assembly.from_blocks(blocks, supports=["ground"]), hoists).order
    ('low', 'high')
    """
    check_choice("least", least, ("total", "peak"))
    names = [assembly.names[k] for k in assembly.free]
    options: dict[str, Any] = {"least": least, "friction": friction}
    every = list(props(assembly, names))
    force: dict[frozenset[str], float] = {frozenset(): 0.0}
    undecided = set[frozenset[str]]()

    def needed(present: frozenset[str]) -> float:
        if present not in force:
            own = [prop for prop in every if prop.block in present]
            there = [name for name in names if name in present]
            found = held_by_props(assembly, (there, []), own, **options)[1]
            size = found.total if least == "total" else found.peak
            force[present] = size if found.outcome is FalseworkOutcome.HELD else np.inf
            if found.outcome is FalseworkOutcome.UNDECIDED:
                undecided.add(present)
        return force[present]

    tick, done = count(), set[frozenset[str]]()
    queue: list[Any] = [(0.0, len(names), next(tick), frozenset(), ())]
    while queue:
        peak, left, _, present, order = heapq.heappop(queue)
        if present in done:
            continue
        done.add(present)
        if not left:
            forces = tuple(force[frozenset(order[: k + 1])] for k in range(len(order)))
            return CentringOrder(order, forces, len(force) - 1, len(undecided))
        for name in names:
            if name not in present and (more := present | {name}) not in done:
                worst = max(peak, needed(more))
                if worst < np.inf:
                    heapq.heappush(queue, (worst, left - 1, next(tick), more, (*order, name)))
    if undecided:
        why = f"in {len(undecided)} states they are proven neither to hold the blocks nor not to"
        raise InputError(f"least_centring: no order found in which these props hold the blocks; {why}")
    raise InputError("least_centring: these props cannot hold the blocks in any order")
