"""Least volume with a required reserve, by exact derivatives; what must be counted is gone through one by one.

Linear programs (scipy's HiGHS) with tangents as cutting planes (Kelley 1960), in a box that grows and shrinks with
success, move the continuous parameters of each combination of the others. A design is offered when its limit load
is certified and statics and the dynamic verifier agree; where one does not, more reserve is asked for, and the search
goes on.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice, product
from math import prod
from time import process_time

import numpy as np

from blockstat.design_search.candidate import BY_STATICS, ERROR, PRUNED, SOLVED, UNASKED, Candidate
from blockstat.design_search.evaluator import Evaluator
from blockstat.design_search.margin import NARROW, TOP, Margin, measure
from blockstat.design_search.space import Values, is_discrete
from blockstat.errors import InputError
from blockstat.spec import build
from blockstat.typing import Floats

#: More combinations of what must be counted than this are a grid, not a descent.
MOST = 64
#: The optimiser aims this much above the reserve asked for, so that it ends on the side that has it.
AIM = NARROW
#: Where a design does not stand in the dynamic verifier, this much reserve more is asked for, then twice that, ...
MORE, TRIES = 0.01, 6
#: Where one stands at last, so many times the middle is tried between its reserve and that of the last one that fell.
HALVINGS = 2
#: Where no more reserve helps, designs met on the way are tried, each so many times heavier than the last that fell.
HEAVIER = 1.05
#: Price of reserve that is lacking, in volumes of the largest design; more than any reserve costs.
PENALTY = 50.0
#: A descent ends after this many designs, when it can gain less than this share, or within this distance (scaled).
DESIGNS, GAIN, CLOSE = 60, 1e-5, 1e-4
#: Designs on the steps of the ranges that are looked at about another, and so many times as many more where none is
#: found. Three steps of each of four parameters are 81.
NEAR, ROUNDS = 64, 2
SAME = 1e-9  #: volumes that differ by this share do so by rounding
#: Where the largest design is not built, smaller ones are tried in so many equal parts of the ranges.
PARTS = 8


@dataclass(frozen=True)
class Descent:
    """Least volume at one combination of what is counted."""

    evaluator: Evaluator
    margin: Margin
    counted: Values
    moved: tuple[str, ...]

    def measured(self, x: Floats) -> Candidate:
        """Measure a design, or return the row it already has.

        Parameters
        ----------
        x : ndarray, shape (n_moved,)
            Scaled parameters, each from 0 (least) to 1 (most); what is outside is clipped.

        Returns
        -------
        Candidate
            With its reserve and its slopes; its static verdict is "error" where the design cannot be built.

        Raises
        ------
        KeyboardInterrupt
            When the search was cancelled.
        """
        evaluator, values = self.evaluator, self.values(x)
        key = tuple(values.values())
        before = evaluator.rows.get(key, evaluator.known.get(key))
        if before is not None and before.reserve is not None:
            return evaluator.enter(key, before, new=False)
        evaluator.check_cancelled()
        return evaluator.enter(key, self._computed(values, before), new=True)

    def values(self, x: Floats) -> Values:
        """Return the parameter values of a design.

        Parameters
        ----------
        x : ndarray, shape (n_moved,)
            As `measured` takes them.

        Returns
        -------
        dict of str to float
            In the order of the space.
        """
        low, high = self._bounds()
        place = dict(zip(self.moved, np.clip((low + x * (high - low)).round(12), low, high).tolist(), strict=True))
        return {name: place.get(name, self.counted.get(name, 0.0)) for name in self.evaluator.space.names}

    def _bounds(self) -> tuple[Floats, Floats]:
        ranges = [self.evaluator.space.ranges[name] for name in self.moved]
        return np.array([r.min for r in ranges]), np.array([r.max for r in ranges])

    def _computed(self, values: Values, before: Candidate | None) -> Candidate:
        begin, space, under = process_time(), self.evaluator.space, self.evaluator.callbacks.under
        try:
            found = measure(lambda v: under(build(space.near(v))), values, self.moved, self.margin)
        except InputError as error:
            seconds, zeros = process_time() - begin, (0.0,) * (2 * len(self.moved))
            return Candidate(values, ERROR, None, UNASKED, None, None, seconds, 0.0, error.line, "", -TOP, zeros)
        seconds = process_time() - begin
        slopes = (*found.volume_slopes.tolist(), *found.reserve_slopes.tolist())
        if before is not None:
            return replace(before, reserve=found.reserve, slopes=slopes)
        word = PRUNED if found.static == "unstable" else UNASKED
        if self.evaluator.callbacks.verify is None and found.static == "stable":
            word = BY_STATICS
        return Candidate(
            parameters=values, static=found.static, score=max(-found.reserve, 0.0), dynamic=word, volume=found.volume,
            blocks=found.blocks, static_seconds=seconds, dynamic_seconds=0.0, evidence=SOLVED,
            reserve=found.reserve, slopes=slopes,
        )  # fmt: skip

    def starts(self) -> Iterator[Floats]:
        """Go from the largest design to smaller ones, for where it cannot be built.

        All parameters are lowered together, and then each by itself, with the others at their most.

        Yields
        ------
        ndarray, shape (n_moved,)
            Scaled parameters, as `measured` takes them.
        """
        n = len(self.moved)
        shares = np.arange(PARTS)[::-1] / PARTS
        alone = (np.where(np.eye(n)[k] > 0, share, 1.0) for k in range(n if n > 1 else 0) for share in shares)
        together = (np.full(n, share) for share in (shares if n else ()))
        return chain([np.ones(n)], together, alone)

    def largest(self) -> Candidate:
        """Measure the largest design, or, where it cannot be built, find a smaller one that can.

        Returns
        -------
        Candidate
            The first of `starts` that is built; the largest itself where none of them is. All have a row.
        """
        found = map(self.measured, self.starts())
        first = next(found)
        return next(filter(_built, chain([first], found)), first)

    def down(self, least: float) -> Candidate | None:
        """Find the lightest design with a reserve.

        Parameters
        ----------
        least : float
            Limit load multiplier that the design must have.

        Returns
        -------
        Candidate or None
            The lightest of the designs that were met and have the reserve; None if there was none.

        Notes
        -----
        Around the best design so far, the volume is taken as linear and the reserve as the least of the tangents at all
        designs seen nearby, also for other reserves, for it has kinks where one mechanism gives way to another. The
        linear program that follows gives the next design; where it is no better, the next one is looked for closer by.

        References
        ----------
        Kelley, J. E. (1960). The cutting-plane method for solving convex programs. Journal of the Society for
        Industrial and Applied Mathematics 8(4), 703-712.
        """
        seen = [self.largest(), *self._measured_before()]
        reach, spent = 1.0, 0

        def cost(found: Candidate) -> float:
            lacking = max(least + AIM - (found.reserve if found.reserve is not None else -TOP), 0.0)
            return (found.volume or 0.0) / (seen[0].volume or 1.0) + PENALTY * lacking if _built(found) else np.inf

        while self.moved and _built(seen[0]) and spent < DESIGNS and reach > CLOSE:
            centre = min(seen, key=cost)
            x, promised = self._step(centre, seen, least, reach)
            if cost(centre) - promised < GAIN:
                reach /= 4  # tangents at designs further away may stand in the way for no reason
                continue
            seen.append(self.measured(x))
            spent += 1
            reach = min(2 * reach, 1.0) if cost(seen[-1]) < cost(centre) else reach / 2
        return min((c for c in seen if _enough(c, least)), key=lambda c: c.volume or 0.0, default=None)

    def _measured_before(self) -> list[Candidate]:
        """Designs of descents to other reserves: their tangents hold for all of them."""
        own = self.counted.items()
        return [c for c in self.evaluator.rows.values() if c.slopes and own <= c.parameters.items()]

    def _step(self, centre: Candidate, seen: list[Candidate], least: float, reach: float) -> tuple[Floats, float]:
        """Least cost of the linear model in a box about a design, in scaled parameters, and that cost."""
        from scipy.optimize import linprog

        n, unit = len(self.moved), seen[0].volume or 1.0
        (low, high), middle = self._bounds(), self._place(centre)
        scale = high - low
        near = [c for c in seen if _built(c) and np.abs(self._place(c) - middle).max() <= max(2 * reach, CLOSE)]
        tangents = np.array([np.array(c.slopes[n:]) * scale for c in near])
        offset = np.array([(c.reserve or 0.0) - t @ self._place(c) for c, t in zip(near, tangents, strict=True)])
        # Where the reserve is not concave a tangent may pass below what the centre has; it is lifted up to it.
        offset += np.maximum((centre.reserve or 0.0) - offset - tangents @ middle, 0.0)
        # offset + tangent x + lacking >= least + AIM
        slack = offset - least - AIM
        slope = np.array(centre.slopes[:n]) * scale / unit
        box = np.column_stack([np.maximum(middle - reach, 0.0), np.minimum(middle + reach, 1.0)])
        answer = linprog(
            np.append(slope, PENALTY), A_ub=np.column_stack([-tangents, -np.ones(len(near))]), b_ub=slack,
            bounds=[*box.tolist(), (0.0, None)],
        )  # fmt: skip
        if not answer.success:
            return middle, np.inf
        return answer.x[:n], float(answer.fun + (centre.volume or 0.0) / unit - slope @ middle)

    def _place(self, found: Candidate) -> Floats:
        """Scaled parameters of a candidate."""
        low, high = self._bounds()
        return (np.array([found.parameters[name] for name in self.moved]) - low) / np.where(high > low, high - low, 1.0)

    def snapped(self, least: float, found: Candidate | None) -> Candidate | None:
        """Find the lightest design with a reserve on the steps of the ranges near a design.

        Parameters
        ----------
        least : float
            Limit load multiplier that the answer must have.
        found : Candidate or None
            The lightest design off the steps; None where none has the reserve.

        Returns
        -------
        Candidate or None
            None where no design has the reserve of those that were looked at.

        Notes
        -----
        The reserve need not grow with a parameter: a thicker ring is heavier on the same piers. So steps to both sides
        count. All designs are looked at where they are `NEAR` at most, from the lightest on, and the answer is exact.
        Where there are more, it is the nearest ones, then those near the best of them, until none is lighter.
        """
        ranges, own = self.evaluator.space.ranges, self._measured_before()
        every = prod(len(ranges[name].steps()) for name in self.moved) <= NEAR
        on_steps = (c for c in own if _enough(c, least) and self.evaluator.space.is_on_steps(c.parameters))
        best = min(on_steps, key=_volume, default=None)
        # Where none has the reserve off the steps, it is not looked for among many on them.
        centre = max((c for c in own if _built(c)), key=_reserve, default=None) if found is None and every else found
        # Where there are many designs, those lighter than the optimum off the steps are taken not to have the reserve.
        lowest = 0.0 if every or found is None else _volume(found) * (1 - SAME)
        while centre is not None:
            lighter = self._lighter(centre, least, lowest, best)
            if lighter is None and (every or best is None or centre is best):
                break
            centre = best = lighter or best
        return best

    def _lighter(self, centre: Candidate, least: float, lowest: float, best: Candidate | None) -> Candidate | None:
        """The lightest design on the steps near a design that has a reserve, if it is lighter than the best so far."""
        around = self.evaluator.space.around(centre.parameters, self.moved)
        low, high = self._bounds()
        for _ in range(ROUNDS):
            weighed = [(self._weight(values), values) for values in islice(around, NEAR)]
            for volume, values in sorted(weighed, key=lambda pair: pair[0]):
                if not lowest <= volume < (_volume(best) * (1 - SAME) if best else np.inf):
                    continue
                x = (np.array([values[name] for name in self.moved]) - low) / np.where(high > low, high - low, 1.0)
                if _enough(asked := self.measured(x), least):
                    return asked
        return None

    def _weight(self, values: Values) -> float:
        """The volume of a design, infinite where it cannot be built."""
        try:
            return self.evaluator.weigh(values)
        except InputError:
            return np.inf


def _volume(found: Candidate) -> float:
    return found.volume or 0.0


def _reserve(found: Candidate) -> float:
    return -TOP if found.reserve is None else found.reserve


def _enough(found: Candidate, least: float) -> bool:
    """Whether a design was built and has the reserve."""
    return _built(found) and found.reserve is not None and found.reserve >= least


def _built(found: Candidate) -> bool:
    return found.volume is not None


def descents(evaluator: Evaluator, margin: Margin) -> Iterator[Descent]:
    """Go through the combinations of what is counted: presences, numbers of things.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.
    margin : Margin
        Reserve that is measured.

    Yields
    ------
    Descent
        One for each combination.

    Raises
    ------
    InputError
        For more combinations than `MOST`.
    """
    ranges = evaluator.space.ranges
    counted = [name for name, found in ranges.items() if is_discrete(found)]
    moved = tuple(name for name in ranges if name not in counted)
    combinations = list(product(*(evaluator.space.line(name) for name in counted)))
    if len(combinations) > MOST:
        raise InputError(
            f"{', '.join(counted)} are counted, which makes {len(combinations)} combinations; a search by gradients "
            f'goes through {MOST} at most: name fewer parameters, or take strategy "pruned"'
        )
    for values in combinations:
        yield Descent(evaluator, margin, dict(zip(counted, values, strict=True)), moved)


def lightest(evaluator: Evaluator, margin: Margin, *, snap: bool = False) -> Values | None:
    """Find the lightest design that has the margin and stands.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.
    margin : Margin
        Reserve that the design must have.
    snap : bool, optional
        Only designs on the steps of the ranges are offered.

    Returns
    -------
    dict of str to float, or None
        Parameter values of the design; None where none was found.

    Raises
    ------
    InputError
        For more combinations of what is counted than `MOST`.
    """
    queue: list[tuple[float, int, int, float, float, Candidate, Descent]] = []

    def push(number: int, tries: int, fallen: float, least: float, descent: Descent) -> None:
        found = _descended(descent, least, snap)
        if found is not None and found.volume is not None:
            heapq.heappush(queue, (found.volume, number, tries, fallen, least, found, descent))

    for number, descent in enumerate(descents(evaluator, margin)):
        push(number, 0, margin.least, margin.least, descent)
    while queue:
        _, number, tries, fallen, least, found, descent = heapq.heappop(queue)
        if evaluator.offer(found.parameters).stands:
            return _between(evaluator, descent, fallen, least, found, snap=snap).parameters
        if tries < TRIES:
            fallen = max(least, found.reserve or 0.0)
            push(number, tries + 1, fallen, fallen + MORE * 2**tries, descent)
    return _met(evaluator, margin.least, snap=snap)


def _descended(descent: Descent, least: float, snap: bool) -> Candidate | None:
    """The lightest design of a descent that has a reserve, on the steps of the ranges where these are asked for."""
    found = descent.down(least)
    return descent.snapped(least, found) if snap else found


def _between(
    evaluator: Evaluator, descent: Descent, fallen: float, least: float, stands: Candidate, *, snap: bool
) -> Candidate:
    """The lightest that stands of a design and those with reserves between its own and that of the last that fell."""
    for _ in range(HALVINGS):
        middle = 0.5 * (fallen + least)
        found = _descended(descent, middle, snap) if fallen < least else None
        if found is None or (found.volume or 0.0) >= (stands.volume or 0.0):
            break
        if evaluator.offer(found.parameters).stands:
            least, stands = middle, found
        else:
            fallen = max(middle, found.reserve or 0.0)
    return stands


def _met(evaluator: Evaluator, least: float, *, snap: bool) -> Values | None:
    """The first that stands of the designs that were measured and have the reserve, from the lightest on."""
    fallen = 0.0
    for found in sorted(evaluator.rows.values(), key=lambda c: c.volume or 0.0):
        on_steps = not snap or evaluator.space.is_on_steps(found.parameters)
        if _enough(found, least) and on_steps and (found.volume or 0.0) >= HEAVIER * fallen:
            if evaluator.offer(found.parameters).stands:
                return found.parameters
            fallen = found.volume or 0.0
    return None


def front(evaluator: Evaluator, margin: Margin, points: int) -> tuple[Candidate, ...]:
    """Find designs of which none is both lighter and safer than another (epsilon constraint).

    Parameters
    ----------
    evaluator : Evaluator
        Of the space.
    margin : Margin
        Direction of the reserve, and the least reserve that is asked for.
    points : int
        Number of reserves asked for, from that of the margin up to the most that any combination has at its largest.

    Returns
    -------
    tuple of Candidate
        By growing volume and reserve.

    Raises
    ------
    InputError
        For more combinations of what is counted than `MOST`.
    """
    paths = list(descents(evaluator, margin))
    most = max((d.largest().reserve or 0.0) for d in paths)
    found: list[Candidate] = []
    for least in np.linspace(margin.least, max(most - AIM, margin.least), points):
        lowest = [c for c in (d.down(float(least)) for d in paths) if c is not None]
        for candidate in sorted(lowest, key=lambda c: c.volume or 0.0):
            if (asked := evaluator.offer(candidate.parameters)).stands:
                found.append(asked)
                break
    return undominated(found)


def undominated(candidates: list[Candidate]) -> tuple[Candidate, ...]:
    """Keep the designs to which no other is as light and as safe and better in one.

    Parameters
    ----------
    candidates : list of Candidate
        Designs with their volume and reserve; one that is None counts as 0.

    Returns
    -------
    tuple of Candidate
        From the lightest on.
    """
    kept: list[Candidate] = []
    for candidate in sorted(candidates, key=lambda c: (c.volume or 0.0, -(c.reserve or 0.0))):
        if not kept or (candidate.reserve or 0.0) > (kept[-1].reserve or 0.0):
            kept.append(candidate)
    return tuple(kept)
