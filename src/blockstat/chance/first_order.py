"""First-order reliability: the design point, the most probable draw at which the assembly is at its limit.

In the space of independent standard normal variables z the limit state g(z) = lambda(z) - push(z) is replaced by its
tangent plane at the point of it that is nearest the origin. With beta its distance the probability is Phi(-beta), and
the squares of the direction cosines are the shares of the variables in the variance of g. Found by the recursion of
Hasofer, Lind, Rackwitz and Fiessler, with the exact derivatives of `blockstat.sensitivity.reserve`: one limit load a
step, however many variables there are (and some more where the dead load falls). That the point is on the border of
falling is then judged as draws are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import ndtr

from blockstat.analysis.verdict import Outcome
from blockstat.chance.limit_state import limit_state
from blockstat.chance.population import Population, population_of
from blockstat.chance.trials import Trials
from blockstat.chance.variables import Random, check_strength
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.loads import Loads
from blockstat.result import Result, Sentence, finite
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Steps of the recursion at most; after each so many they are shorter, where it goes to and fro between mechanisms.
STEPS, PATIENCE = 60, 10
#: The recursion ends where the point moves by less.
CLOSE = 1e-4
#: Standard deviations beyond which a probability is none: that of the normal distribution is below all doubles.
FARTHEST = 38.5
#: So far to either side of the design point the verdict is asked for, in standard deviations: a hundred times as far as
#: the recursion still moves it, and a part of beta that does not matter.
BESIDE = 1e-2
#: Why there is no design point.
CARRIES_NONE = "With the mean values no multiple of the load is found to be carried, so that nothing has a slope."
MOVES_NOTHING = "With the mean values nothing that is random moves the limit enough."
OFF_BORDER = "The recursion settled on a point where the assembly is not seen to be at its limit"


class FirstOrderOutcome(Sentence):
    """The answers of `first_order`; each value is the sentence a user reads."""

    FOUND = "Found: the design point, to first order."
    NOT_FOUND = "Not found: the recursion came to no design point; use draws."


@dataclass(frozen=True, eq=False)
class FirstOrder(Result):
    """The design point and what follows from it."""

    outcome: FirstOrderOutcome
    #: distance of the limit state from the mean, in standard deviations; negative where the mean falls, and nan where
    #: no design point is found
    beta: float
    point: Floats  #: the design point in standard normal variables, shape (n,); nan where none is found
    #: the random variables there, of many values their mean; empty where no design point is found
    values: dict[str, float]
    #: part of each variable in the variance of the limit state; they sum to 1, and are 0 where no design point is found
    shares: dict[str, float]
    #: the same by standard normal variable: of what values have in common, if they do, and of each value; by key
    shares_by_value: dict[str, Floats]
    reason: str = ""  #: why no design point is found, a sentence

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
        if self.outcome is FirstOrderOutcome.NOT_FOUND:
            return f"{self.outcome.value}\n{self.reason}"
        lines = [self.outcome.value, f"Probability {self.probability:.4g} (beta {self.beta:.4g})."]
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
            "reason": self.reason or None,
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
        The design point, about which `blockstat.reliability` may draw; or why there is none.

    Raises
    ------
    InputError
        For a variable that there is not, without a load, for a direction whose length would be dropped, for blocks that
        overlap as drawn, and for "edge" beside "corner" or joints that are divided into cells.

    Notes
    -----
    A point is called found where the verdicts agree with it: beside it the assembly stands on one side and falls on the
    other, and the mean does what the sign of beta says. Where the dead load falls, the limit state goes on as long as
    some multiple of the load is carried.

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
    point, slope, beta, reason = _design_point(population, load)
    share = slope**2 / (float(slope @ slope) or 1.0)
    own = {part.key: share[part.first : part.first + part.normals] for part in population.parts}
    told = [] if reason else population.parts
    return FirstOrder(
        FirstOrderOutcome.NOT_FOUND if reason else FirstOrderOutcome.FOUND,
        beta,
        point,
        {part.key: float(np.mean(part.variable.value(part.standard(point)))) for part in told},
        {key: float(part.sum()) for key, part in own.items()},
        own,
        reason,
    )


def _design_point(population: Population, load: Any) -> tuple[Floats, Floats, float, str]:
    """The design point, the slope there and beta; or nan, zero and nan, and why."""
    point, slope, beta, reason = _settled(population, load)
    reason = reason or _contradicted(population, load, point, slope, beta)
    if reason:
        return np.full(population.size, np.nan), np.zeros(population.size), np.nan, reason
    return point, slope, beta, ""


def _settled(population: Population, load: Any) -> tuple[Floats, Floats, float, str]:
    """What the recursion settles on: the point, the slope there and beta; or why it does not."""
    point, before = np.zeros(population.size), None
    for count in range(STEPS):
        value, slope = limit_state(population, load, point)
        steep, away = float(slope @ slope), float(slope @ point - value)
        if abs(away) >= FARTHEST * np.sqrt(steep):  # the slope is none, or rounding
            if before is None:
                return point, slope, np.nan, CARRIES_NONE if np.isneginf(value) else MOVES_NOTHING
            point = (before + point) / 2  # where the step led there is no slope: it was too long
            continue
        nearer = away / steep * slope
        step = (nearer - point) / (1 + count // PATIENCE)
        before, point = point, point + step
        if float(np.linalg.norm(step)) <= CLOSE:
            side = -float(np.sign(slope @ nearer)) or 1.0
            return point, slope, side * float(np.linalg.norm(point)), ""
    return point, slope, np.nan, f"The recursion did not settle in {STEPS} steps."


def _contradicted(population: Population, load: Any, point: Floats, slope: Floats, beta: float) -> str:
    """What speaks against a design point by the verdicts on draws beside it and at the mean; empty if nothing does."""
    trials, step = Trials(population, load, point, 0, reuse=False), BESIDE * slope / float(np.linalg.norm(slope))
    stable, unstable = Outcome.STABLE.word, Outcome.UNSTABLE.word
    words = [trials.judge(0, place, None).outcome for place in (point + step, point - step, np.zeros_like(point))]
    if words[:2] != [stable, unstable]:
        return f"{OFF_BORDER}: {BESIDE:g} standard deviations up and down its slope it is {words[0]} and {words[1]}."
    if abs(beta) > BESIDE and words[2] != (stable if beta > 0 else unstable):
        return f"With the mean values the assembly is {words[2]}, which the tangent plane at the point found denies."
    return ""
