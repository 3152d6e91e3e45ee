"""Probability of falling by Monte Carlo, with evidence of earlier draws, and fragility."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import betaincinv, ndtri

from blockstat.analysis.assess import judged
from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.analysis.problem import pose
from blockstat.analysis.verdict import Outcome
from blockstat.chance.first_order import FirstOrder
from blockstat.chance.variables import Random, checked, realise
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import InputError, known_options
from blockstat.loads import as_load
from blockstat.result import Result, Sentence
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


class ReliabilityOutcome(Sentence):
    """The answer of `reliability`; the value is the sentence a user reads."""

    ESTIMATED = "Estimated: the probability that the assembly does not stand, from random draws."


@dataclass(frozen=True, eq=False)
class Reliability(Result):
    """A probability of falling from draws."""

    probability: float  #: estimate
    interval: tuple[float, float]  #: contains the probability with the confidence asked for
    confidence: float
    draws: int
    failures: int  #: draws in which the assembly falls
    undecided: int  #: draws that are neither; they widen the interval to both sides
    reused: int  #: draws that evidence of earlier draws decided without a solve
    sampled_about: str = "the mean"  #: or "the design point"

    @property
    def outcome(self) -> ReliabilityOutcome:
        """What kind of answer this is."""
        return ReliabilityOutcome.ESTIMATED

    def explain(self) -> str:
        """Return the probability in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        low, high = self.interval
        lines = [self.outcome.value]
        lines.append(
            f"Probability {self.probability:.4g}; with {self.confidence:.0%} confidence {low:.4g} to {high:.4g}."
        )
        lines.append(
            f"{self.failures} of {self.draws} draws about {self.sampled_about} fall, {self.undecided} undecided."
        )
        lines.append(f"Evidence of earlier draws decided {self.reused}.")
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
            "interval": list(self.interval),
            "confidence": self.confidence,
            "draws": self.draws,
            "failures": self.failures,
            "undecided": self.undecided,
            "reused": self.reused,
            "sampled_about": self.sampled_about,
        }


@known_options
def reliability(
    assembly: Assembly,
    uncertain: Mapping[str, Random],
    *,
    load: Any = None,
    loads: Floats | None = None,
    draws: int = 1000,
    seed: int = 0,
    confidence: float = 0.95,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    about: FirstOrder | None = None,
    reuse: bool = True,
    jobs: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Reliability:
    """Estimate the probability that an assembly does not stand when some of its data are random.

    Parameters
    ----------
    assembly
        The blocks as drawn.
    uncertain
        Independent random variables by key: "friction", the coefficient of all joints; "edge", what joints lose along
        each edge [m]; "density.GROUP" [kg/m3] and "loads.GROUP", a factor on the permanent loads, by group ("*" for
        all); "push", a factor on `load`. Blocks of one group share one value.
    load
        An acceleration direction or a wrench on each block, as in `blockstat.limit_load`, which acts "push" times; None
        for none.
    loads
        Permanent loads, shape (n_blocks, 6) [N, N m].
    draws
        How many.
    seed
        Of the random numbers.
    confidence
        Of the interval.
    gap, interfaces
        As in `blockstat.assess`.
    about
        Draw about this design point and weigh the draws (importance sampling): small probabilities need fewer.
    reuse
        Whether evidence of earlier draws is tried before a solve; the verdicts are the same.
    jobs
        Processes side by side; the draws are the same, and each process has evidence of its own.
    progress
        Called with the draws done and those asked for, with one process.

    Returns
    -------
    Reliability
        The estimate with its interval.

    Raises
    ------
    InputError
        For a variable that there is not, or fewer than one draw.

    Notes
    -----
    The interval is that of Clopper and Pearson (1934), which contains the probability at least as often as it says,
    with undecided draws as standing at its lower end and as fallen at its upper one. About a design point it is that of
    the central limit theorem.

    References
    ----------
    Clopper & Pearson: The use of confidence or fiducial limits illustrated in the case of the binomial, 1934.

    Examples
    --------
    A block half as wide as high tips at half its weight. The push is uniform between 0.4 and 0.6.

    >>> from blockstat import Assembly, Random, box, reliability
    >>> blocks = [box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (1, 1, 2))]
    >>> tower = Assembly.from_blocks(blocks, supports=[0])
    >>> found = reliability(tower, {"push": Random("uniform", 0.4, 0.6)}, load=(1, 0, 0), draws=200)
    >>> found.interval[0] < 0.5 < found.interval[1]
    True
    """
    checked(assembly, uncertain, loads)
    if draws < 1 or jobs < 1 or not 0 < confidence < 1:
        given = f"draws is {draws}, jobs {jobs} and confidence {confidence}"
        raise InputError(f"{given}; one draw and one job are needed, and 0 < confidence < 1")
    if "push" in uncertain and load is None:
        raise InputError('uncertain "push" is a factor on load=, which is not given')
    faces = find_interfaces(assembly, gap=gap) if interfaces is None else interfaces
    centre = np.zeros(len(uncertain)) if about is None else about.point
    normal = centre + np.random.default_rng(seed).standard_normal((draws, len(uncertain)))
    weight = np.exp(0.5 * centre @ centre - normal @ centre)

    def judge(rows: Floats, told: Callable[[int, int], None] | None) -> tuple[list[Outcome], int]:
        memory, outcomes = Memory() if reuse else None, []
        for row in rows:
            outcomes.append(_outcome(assembly, faces, load, loads, uncertain, row, memory))
            if told is not None:
                told(len(outcomes), len(rows))
        statistics = {} if memory is None else memory.statistics
        return outcomes, statistics.get("forces", 0) + statistics.get("mechanism", 0)

    if jobs == 1:
        parts = [judge(normal, progress)]
    else:
        from joblib import Parallel, delayed

        parts: Any = Parallel(n_jobs=jobs)(delayed(judge)(rows, None) for rows in np.array_split(normal, jobs))
    outcomes = [outcome for own, _ in parts for outcome in own]
    failed = np.array([outcome is Outcome.UNSTABLE for outcome in outcomes])
    undecided = np.array([outcome is Outcome.UNDECIDED for outcome in outcomes])
    if about is None:
        probability, interval = _binomial(int(failed.sum()), int(undecided.sum()), draws, confidence)
    else:
        probability, interval = _weighted(weight * failed, weight * (failed | undecided), confidence)
    return Reliability(
        probability=probability,
        interval=interval,
        confidence=confidence,
        draws=draws,
        failures=int(failed.sum()),
        undecided=int(undecided.sum()),
        reused=sum(reused for _, reused in parts),
        sampled_about="the mean" if about is None else "the design point",
    )


def _outcome(
    assembly: Assembly,
    faces: Interfaces,
    load: Any,
    loads: Floats | None,
    uncertain: Mapping[str, Random],
    normal: Floats,
    memory: Memory | None,
) -> Outcome:
    """The verdict on one draw."""
    draw = realise(assembly, faces, loads, uncertain, normal)
    acting = draw.loads
    if load is not None:
        push = draw.push * as_load(draw.assembly, load)
        acting = push if acting is None else acting + push
    options: dict[str, Any] = {"friction": None, "gravity": None, "gap": GAP}
    problem = pose(draw.assembly, loads=acting, interfaces=draw.interfaces, **options)
    return judged(problem, loads=acting, memory=memory, score=False, reserve=False).outcome


def _binomial(failures: int, undecided: int, draws: int, confidence: float) -> tuple[float, tuple[float, float]]:
    """Share and Clopper-Pearson interval."""
    tail, most = (1 - confidence) / 2, failures + undecided
    low = float(betaincinv(failures, draws - failures + 1, tail)) if failures else 0.0
    high = float(betaincinv(most + 1, draws - most, 1 - tail)) if most < draws else 1.0
    return failures / draws, (low, high)


def _weighted(least: Floats, most: Floats, confidence: float) -> tuple[float, tuple[float, float]]:
    """Mean and normal interval of weighted failures, without and with undecided draws."""
    reach = float(ndtri(0.5 + confidence / 2)) / np.sqrt(len(least))
    low, high = least.mean() - reach * least.std(), most.mean() + reach * most.std()
    return float(least.mean()), (max(float(low), 0.0), min(float(high), 1.0))


@known_options
def fragility(
    assembly: Assembly,
    uncertain: Mapping[str, Random],
    load: Any,
    *,
    loads: Floats | None = None,
    draws: int = 200,
    seed: int = 0,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> Floats:
    """Draw limit load multipliers: the share of them below a value is the probability of falling at that value.

    Parameters
    ----------
    assembly, uncertain, loads, draws, seed, gap, interfaces
        As in `reliability`.
    load
        As in `blockstat.limit_load`.

    Returns
    -------
    Floats
        Multipliers that are carried, ascending, shape (draws,); 0 where the dead load is not.

    Raises
    ------
    InputError
        As in `reliability`, and for a random "push", which is what the multiplier is.
    """
    checked(assembly, uncertain, loads)
    if "push" in uncertain:
        raise InputError('the multiplier itself is what "push" would be; leave it out')
    faces = find_interfaces(assembly, gap=gap) if interfaces is None else interfaces
    rng, found = np.random.default_rng(seed), np.zeros(draws)
    for k in range(draws):
        draw = realise(assembly, faces, loads, uncertain, rng.standard_normal(len(uncertain)))
        limit = limit_load(draw.assembly, load, loads=draw.loads, interfaces=draw.interfaces)
        found[k] = 0.0 if limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE else limit.lower
    return np.sort(found)
