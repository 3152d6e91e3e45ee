"""First-order reliability: the design point, the most probable draw at which the assembly is at its limit.

In the space of independent standard normal variables z the limit state g(z) = lambda(z) - push(z) is replaced by its
tangent plane at the point of it that is nearest the origin. With beta its distance the probability is Phi(-beta), and
the squares of the direction cosines are the shares of the variables in the variance of g. Found by the recursion of
Hasofer, Lind, Rackwitz and Fiessler, with the exact derivatives of `blockstat.sensitivity.reserve`: one limit load a
step, however many variables there are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import ndtr

from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.analysis.problem import checked_loads
from blockstat.chance.population import Population, population_of
from blockstat.chance.variables import Random, check_strength
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.loads import Loads, as_load
from blockstat.result import Result, Sentence, finite
from blockstat.sensitivity.parameters import pinned
from blockstat.sensitivity.reserve import reserve_map
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Steps of the recursion at most; after each so many they are shorter, where it goes to and fro between mechanisms.
STEPS, PATIENCE = 60, 10
#: The recursion ends where the point moves by less.
CLOSE = 1e-4
#: Standard deviations beyond which a probability is none: that of the normal distribution is below all doubles.
FARTHEST = 38.5
#: Multipliers beyond this are not told apart.
MANY = 1e6


class FirstOrderOutcome(Sentence):
    """The answers of `first_order`; each value is the sentence a user reads."""

    FOUND = "Found: the design point, to first order."
    NOT_FOUND = "Not found: the recursion did not settle on a design point; use draws."


@dataclass(frozen=True, eq=False)
class FirstOrder(Result):
    """The design point and what follows from it."""

    outcome: FirstOrderOutcome
    #: distance of the limit state from the mean, in standard deviations; negative where the mean falls, and nan where
    #: the recursion came to a place where nothing has a slope
    beta: float
    point: Floats  #: the design point in standard normal variables, shape (n,)
    values: dict[str, float]  #: the random variables there; of many values their mean
    shares: dict[str, float]  #: part of each variable in the variance of the limit state; they sum to 1
    #: the same by standard normal variable: of what values have in common, if they do, and of each value; by key
    shares_by_value: dict[str, Floats]

    @property
    def probability(self) -> float:
        """Phi(-beta)."""
        return float(ndtr(-self.beta))

    def explain(self) -> str:
        """Return the design point in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        known = [] if np.isnan(self.beta) else [f"Probability {self.probability:.4g} (beta {self.beta:.4g})."]
        lines = [self.outcome.value, *known]
        for key, share in sorted(self.shares.items(), key=lambda item: -item[1]):
            lines.append(f"{key}: {self.values[key]:.6g} at the design point, {share:.0%} of the variance.")
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; None for what is not known.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "probability": finite(self.probability),
            "beta": finite(self.beta),
            "values": self.values,
            "shares": self.shares,
        }


@known_options
def first_order(
    assembly: Assembly,
    uncertain: Mapping[str, Random] | None = None,
    load: Any = None,
    *,
    loads: Loads | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> FirstOrder:
    """Estimate to first order the probability that a load is not carried, and which variable matters.

    Parameters
    ----------
    assembly, uncertain, loads, gap, interfaces
        As in `blockstat.reliability`.
    load
        As in `blockstat.reliability`; it acts "push" times, or once. None for that of the scene.

    Returns
    -------
    FirstOrder
        The design point, about which `blockstat.reliability` may draw.

    Raises
    ------
    InputError
        For a variable that there is not, without a load, for a direction whose length would be dropped, for blocks that
        overlap as drawn, and for "edge" beside "corner" or joints that are divided into cells.

    References
    ----------
    Hasofer & Lind: Exact and invariant second-moment code format, 1974. Rackwitz & Fiessler: Structural reliability
    under combined random load sequences, 1978.

    Examples
    --------
    A block half as wide as high tips at half its weight; the push is normal.

    >>> from blockstat import Assembly, Random, box, first_order
    >>> blocks = [box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (1, 1, 2))]
    >>> tower = Assembly.from_blocks(blocks, supports=[0])
    >>> print(f"{first_order(tower, {'push': Random('normal', 0.3, 0.1)}, (1, 0, 0)).beta:.4f}")
    2.0000
    """
    population, load = population_of(assembly, uncertain, load, loads, gap=gap, interfaces=interfaces)
    if load is None:
        raise InputError("the first-order estimate asks when a load is not carried; give it as load")
    check_strength(population.uncertain, load)
    point, outcome = np.zeros(population.size), FirstOrderOutcome.NOT_FOUND
    slope, side = np.zeros(population.size), 1.0
    for count in range(STEPS):
        value, slope = limit_state(population, load, point)
        steep, away = float(slope @ slope), float(slope @ point - value)
        if abs(away) >= FARTHEST * np.sqrt(steep):  # the slope is none, or rounding
            side, slope = np.nan, np.zeros_like(slope)
            break
        nearer = away / steep * slope
        step = (nearer - point) / (1 + count // PATIENCE)
        point, side = point + step, -float(np.sign(slope @ nearer))
        if float(np.linalg.norm(step)) <= CLOSE:
            outcome = FirstOrderOutcome.FOUND
            break
    share = slope**2 / (float(slope @ slope) or 1.0)
    own = {part.key: share[part.first : part.first + part.normals] for part in population.parts}
    return FirstOrder(
        outcome,
        (side or 1.0) * float(np.linalg.norm(point)),
        point,
        {part.key: float(np.mean(part.variable.value(part.standard(point)))) for part in population.parts},
        {key: float(part.sum()) for key, part in own.items()},
        own,
    )


def limit_state(population: Population, load: Any, normal: Floats) -> tuple[float, Floats]:
    """Return the limit state, limit load multiplier less push, and its derivative.

    Parameters
    ----------
    population
        What is random.
    load
        As in `blockstat.limit_load`.
    normal
        Standard normal variables, shape (size,).

    Returns
    -------
    value : float
        Negative where the load is not carried.
    slope : Floats
        Shape (size,). Where the dead load is not carried, or any multiple of the load, that of the push alone.

    Raises
    ------
    InputError
        For a random "edge" beside a random "corner" or joints that are divided into cells: there is no derivative.
    """
    divided = any(law.divisions for law in population.assembly.joints)
    if "edge" in population.uncertain and ("corner" in population.uncertain or divided):
        beside = "joints that are divided into cells" if divided else '"corner"'
        raise InputError(f'uncertain "edge" beside {beside} has no derivative to first order; leave one out, or draw')
    draw = population.realise(normal)
    options: dict[str, Any] = {"loads": draw.loads, "gap": population.gap, "interfaces": draw.interfaces}
    found = limit_load(draw.assembly, load, optimum=True, **options)
    carried = 0.0 if found.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE else min(found.lower, MANY)
    corners = "corner" in population.uncertain
    if found.outcome is LoadOutcome.LIMIT:
        _, twist = pinned(found, as_load(draw.assembly, load), checked_loads(draw.assembly, draw.loads))
        derivatives = reserve_map(found, load, loads=draw.loads, corners=corners)
        return carried - draw.push, population.gradient(normal, draw, derivatives, twist)
    return carried - draw.push, population.gradient(normal, draw, None, np.zeros((draw.assembly.n_blocks, 6)))
