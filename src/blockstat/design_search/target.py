"""The lightest design with a probability of failure below a target.

Sequential optimisation and reliability assessment: the design is first made as light as it can be with the random
variables at their medians. Then the worst of the values as probable as the target is looked for (the point of least
limit state on the sphere of radius beta), and the design is made as light as it can be with these. Repeated until the
design carries its own worst point, and until the draws about its design point have an interval below the target: where
the upper end of that is above it, the next sphere is as much larger.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import ndtri

from blockstat.assembly import Assembly
from blockstat.chance.first_order import FirstOrder, first_order
from blockstat.chance.limit_state import limit_state
from blockstat.chance.monte_carlo import Reliability, reliability
from blockstat.chance.population import Population
from blockstat.chance.variables import Random, as_strong_as, random_variables
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.design_search.descent import descents, lightest
from blockstat.design_search.evaluator import Evaluator
from blockstat.design_search.margin import Margin
from blockstat.design_search.space import Values
from blockstat.errors import InputError, check_count, check_number, check_vector
from blockstat.typing import Floats

#: Points on the sphere and designs at most, and the multiplier that a design may lack at its worst point.
POINTS, ROUNDS, LACKING = 12, 20, 1e-4
#: A point on the sphere has settled when it moves by less.
CLOSE = 1e-4
#: How much further out the next point is where there is no first order, in standard deviations.
FURTHER = 0.1
#: How much further out it is at least and at most, where draws do not show that the target is met.
LEAST, MOST = 0.01, 0.5
#: How much further out it is, in terms of what the design lacks, where the descent leaves a design too light.
OVER = 1.5


@dataclass(frozen=True)
class FailureTarget:
    """A probability of failure that a design must stay below, under a push that may be random.

    Parameters
    ----------
    probability : float
        Above 0 and below 0.5.
    uncertain : mapping of str to Random, optional
        As in `blockstat.reliability`, with one value for all blocks or joints; by default those of the scene.
    direction : tuple of float, shape (3,), optional
        Of the push, "push" times gravity, or once; by default that of the scene, whose "push" is then random as the
        scene says, unless `uncertain` does.
    draws : int, optional
        About the design point, that check the answer: their interval must lie below the probability. More draws have
        a narrower one, and the design is then as much lighter.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`; `blockstat.search` sets its own.
    """

    probability: float
    uncertain: Mapping[str, Random] | None = None
    direction: tuple[float, float, float] | None = None
    draws: int = 400
    gap: float | str = field(default=GAP, repr=False)  # a history names it otherwise

    def __post_init__(self) -> None:
        check_number("target: probability", self.probability)
        if not 0 < self.probability < 0.5:
            raise InputError(f"target: probability is {self.probability!r}; it must be above 0 and below 0.5")
        if self.direction is not None:
            check_vector("target: direction", self.direction)
        check_count("target: draws", self.draws)

    @property
    def beta(self) -> float:
        """Distance of the limit state from the mean that goes with the probability, in standard deviations."""
        return float(-ndtri(self.probability))

    def variables(self, assembly: Assembly) -> tuple[dict[str, Random], tuple[float, float, float]]:
        """Return the random variables and the direction of the push.

        Parameters
        ----------
        assembly : Assembly
            A design.

        Returns
        -------
        uncertain : dict of Random
            By key.
        direction : tuple of float
            Of the push.

        Raises
        ------
        InputError
            Where there are none, where nothing pushes, and for values that not all designs have.
        """
        own, direction = random_variables(assembly)
        uncertain = dict(own if self.uncertain is None else self.uncertain)
        if self.direction is not None:
            direction = list(self.direction)
        elif direction is not None:
            uncertain.setdefault("push", own["push"])
        if direction is None:
            raise InputError("target: nothing pushes; give a direction, or write uncertain.push.direction in the scene")
        for key, variable in uncertain.items():
            if key == "corner" or variable.each != "all":
                raise InputError(
                    f'target: "{key}" has values of its own, which other designs have not; each must be all'
                )
        x, y, z = (float(part) for part in direction)
        return as_strong_as(uncertain, float(np.linalg.norm(direction))), (x, y, z)


@dataclass(frozen=True)
class AtPoint(Margin):
    """The push that a design must carry at one value of the random variables."""

    uncertain: Mapping[str, Random] = field(default_factory=dict)
    place: tuple[float, ...] = ()  #: standard normal variables

    def cases(self, assembly: Assembly) -> list[Assembly]:
        """Return the design with these values.

        Parameters
        ----------
        assembly : Assembly
            The design.

        Returns
        -------
        list of Assembly
            One.
        """
        return [self._population(assembly).realise(np.array(self.place)).assembly]

    def joints(self, assembly: Assembly) -> Interfaces:
        """Return the joints with these values.

        Parameters
        ----------
        assembly : Assembly
            The design.

        Returns
        -------
        Interfaces
            Without the edges that they lose.
        """
        return self._population(assembly).realise(np.array(self.place)).interfaces

    def _population(self, assembly: Assembly) -> Population:
        return Population(assembly, find_interfaces(assembly, gap=self.gap), None, self.uncertain, self.gap)


@dataclass(frozen=True, eq=False)
class Assured:
    """How probable it is that a design fails."""

    first: FirstOrder
    draws: Reliability


def lightest_assured(evaluator: Evaluator, target: FailureTarget) -> tuple[Values | None, Assured | None]:
    """Find the lightest design whose probability of failure is below a target.

    Parameters
    ----------
    evaluator : Evaluator
        Of the space; designs that are offered are asked for there.
    target : FailureTarget
        What is random, and the target.

    Returns
    -------
    values : dict of str to float, or None
        Of the design; None where none was found whose draws have an interval below the target.
    assured : Assured or None
        Its probability of failure.

    References
    ----------
    Du, X. & Chen, W. (2004). Sequential optimization and reliability assessment method for efficient probabilistic
    design. Journal of Mechanical Design 126(2), 225-233.
    """
    largest = _largest(evaluator, target)
    if largest is None:
        return None, None
    uncertain, direction = target.variables(largest)
    size = Population(largest, find_interfaces(largest, gap=target.gap), None, uncertain).size
    place, beta = np.zeros(size), target.beta
    best: Values | None = None
    for _ in range(ROUNDS):
        push = float(uncertain["push"].value(place[list(uncertain).index("push")])) if "push" in uncertain else 1.0
        own = {"uncertain": uncertain, "place": tuple(place.tolist())}
        margin = AtPoint(direction, max(push, 0.0), gap=target.gap, **own)
        best = _lightest_at(evaluator, margin)
        if best is None:
            return None, None
        assembly = evaluator.make(best)
        population = Population(assembly, find_interfaces(assembly, gap=target.gap), None, uncertain, target.gap)
        before = place
        place, value = _worst(population, direction, beta)
        if value < -LACKING and np.linalg.norm(place - before) > CLOSE:
            continue
        joints = {"gap": target.gap, "interfaces": population.interfaces}
        first = first_order(assembly, uncertain, direction, **joints)
        settled = first.outcome.word == "found"
        if value < -LACKING:
            # The design is as the descent leaves it, a little lighter than its worst point asks for: aim further out.
            short = target.beta - first.beta
            if not settled or short > 0:
                beta += OVER * short if settled else FURTHER
                continue
        about = first if settled else replace(first, point=place)
        found = reliability(assembly, uncertain, load=direction, draws=target.draws, about=about, **joints)
        if found.interval[1] <= target.probability and evaluator.ask(best).stands:
            return best, Assured(first, found)
        beta += float(np.clip(target.beta + ndtri(found.interval[1]), LEAST, MOST))
    return None, None


def _largest(evaluator: Evaluator, target: FailureTarget) -> Assembly | None:
    """The first design that can be built, from the largest on; where there is none, rows say why."""
    ways = [(descent, x) for descent in descents(evaluator, Margin(gap=target.gap)) for x in descent.starts()]
    for descent, x in ways:
        try:
            return evaluator.make(descent.values(x))
        except InputError:
            continue
    for descent, x in ways:
        descent.measured(x)
    return None


def _lightest_at(evaluator: Evaluator, margin: AtPoint) -> Values | None:
    """The lightest design that carries one value of the random variables; what was simulated is entered.

    What is measured depends on the value, so each round has rows of its own. What the dynamic verifier says does not.
    """
    own = replace(evaluator, history=None, rows={})
    own.known = evaluator.known | evaluator.rows
    try:
        return lightest(own, margin)
    finally:
        for key, row in own.rows.items():
            if row.simulated and key not in evaluator.rows:
                before = evaluator.known.get(key)
                new = before is None or before.dynamic != row.dynamic
                evaluator.enter(key, replace(row, reserve=None, slopes=()), new=new)


def _worst(population: Population, direction: tuple[float, float, float], beta: float) -> tuple[Floats, float]:
    """The point of least limit state on a sphere, and the limit state there."""
    place = np.zeros(population.size)
    value = np.inf
    for _ in range(POINTS):
        value, slope = limit_state(population, direction, place)
        steep = float(np.linalg.norm(slope))
        if steep == 0.0:
            break
        further = -beta * slope / steep
        if np.linalg.norm(further - place) <= CLOSE:
            break
        place = further
    return place, float(value)
