"""First-order reliability: the design point, the most probable draw at which the assembly is at its limit.

In the space of independent standard normal variables z the limit state g(z) = lambda(z) - push(z) is replaced by its
tangent plane at the point of it that is nearest the origin. With beta its distance the probability is Phi(-beta), and
the squares of the direction cosines are the shares of the variables in the variance of g. Found by the recursion of
Hasofer, Lind, Rackwitz and Fiessler, with derivatives by central differences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import ndtr

from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.chance.variables import Random, checked, realise
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import known_options
from blockstat.result import Result, Sentence
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Step of the differences, and steps of the recursion at most.
STEP, STEPS = 1e-3, 30
#: The recursion ends where the point moves by less.
CLOSE = 1e-4
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
    beta: float  #: distance of the limit state from the mean, in standard deviations; negative where the mean falls
    point: Floats  #: the design point in standard normal variables, shape (n,)
    values: dict[str, float]  #: the random variables there
    shares: dict[str, float]  #: part of each variable in the variance of the limit state; they sum to 1

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
        lines = [self.outcome.value, f"Probability {self.probability:.4g} (beta {self.beta:.4g})."]
        for key, share in sorted(self.shares.items(), key=lambda item: -item[1]):
            lines.append(f"{key}: {self.values[key]:.6g} at the design point, {share:.0%} of the variance.")
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "probability": self.probability,
            "beta": self.beta,
            "values": self.values,
            "shares": self.shares,
        }


@known_options
def first_order(
    assembly: Assembly,
    uncertain: Mapping[str, Random],
    load: Any,
    *,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> FirstOrder:
    """Estimate to first order the probability that a load is not carried, and which variable matters.

    Parameters
    ----------
    assembly, uncertain, loads, gap, interfaces
        As in `blockstat.reliability`.
    load
        As in `blockstat.limit_load`; it acts "push" times, or once.

    Returns
    -------
    FirstOrder
        The design point, about which `blockstat.reliability` may draw.

    Raises
    ------
    InputError
        For a variable that there is not.

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
    checked(assembly, uncertain, loads)
    faces = find_interfaces(assembly, gap=gap) if interfaces is None else interfaces
    n = len(uncertain)

    def margin(normal: Floats) -> float:
        draw = realise(assembly, faces, loads, uncertain, normal)
        found = limit_load(draw.assembly, load, loads=draw.loads, interfaces=draw.interfaces)
        carried = 0.0 if found.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE else min(found.lower, MANY)
        return carried - draw.push

    point, outcome = np.zeros(n), FirstOrderOutcome.NOT_FOUND
    slope, side = np.zeros(n), 1.0
    for _ in range(STEPS):
        value = margin(point)
        slope = np.array([(margin(point + STEP * e) - margin(point - STEP * e)) / (2 * STEP) for e in np.eye(n)])
        steep = float(slope @ slope)
        if steep == 0.0:
            break
        nearer = (slope @ point - value) / steep * slope
        moved = float(np.linalg.norm(nearer - point))
        point, side = nearer, -float(np.sign(slope @ nearer))
        if moved <= CLOSE:
            outcome = FirstOrderOutcome.FOUND
            break
    total = float(slope @ slope) or 1.0
    values = {key: v.value(z) for (key, v), z in zip(uncertain.items(), point.tolist(), strict=True)}
    shares = {key: float(part) for key, part in zip(uncertain, slope**2 / total, strict=True)}
    return FirstOrder(outcome, (side or 1.0) * float(np.linalg.norm(point)), point, values, shares)
