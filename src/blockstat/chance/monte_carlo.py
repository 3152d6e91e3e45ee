"""Probability of falling by Monte Carlo, with evidence of earlier draws, and fragility."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import betaincinv, gammaincinv

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.analysis.verdict import Outcome
from blockstat.chance.first_order import FirstOrder
from blockstat.chance.population import Population, population_of
from blockstat.chance.trials import Trials, judge_all
from blockstat.chance.variables import Random, check_strength
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_choice, check_count, check_seed, known_options
from blockstat.loads import Loads
from blockstat.result import Result, Sentence
from blockstat.system.workers import in_stretches
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


#: Of fewer failures the largest weight says nothing of what others may weigh. Chosen by the coverage of known cases.
FEW = 10
#: What each draw is asked.
ASSOCIATED = (
    "A draw falls when no admissible forces balance it, with associated friction and self-stress. Without them more "
    'may fall (see flow="coulomb").'
)
CAUTIOUS = (
    'A draw falls when no state without dilatancy and self-stress is found (flow="coulomb"); self-stress would hold {} '
    "of those. Where there is a state, how tight the joints are may still decide: see `tightnesses` of `assess`."
)


class ReliabilityOutcome(Sentence):
    """The answer of `reliability`; the value is the sentence a user reads."""

    ESTIMATED = "Estimated: the probability that the assembly does not stand, from random draws."
    STOPPED = "Stopped: the probability that the assembly does not stand, from the draws until then."


@dataclass(frozen=True, eq=False)
class Reliability(Result):
    """A probability of falling from draws."""

    probability: float  #: estimate
    interval: tuple[float, float]  #: contains the probability with the confidence asked for
    confidence: float
    draws: int
    failures: int  #: draws in which the assembly falls; with flow "coulomb" those that only self-stress holds, too
    undecided: int  #: draws that are neither; they widen the interval to both sides
    reused: int  #: draws that evidence of earlier draws decided without a solve
    sampled_about: str = "the mean"  #: or "the design point", with its mirror image and the mean
    seconds: float = 0.0  #: process time of all draws, those of earlier runs too
    flow: str = "associated"  #: the flow rule of each draw, "associated" or "coulomb"
    self_stress: int = 0  #: of the failures, those that only self-stress holds
    #: of draws about a design point: what the probability is at most by those about the mean, wherever it falls
    at_most: float | None = None
    stopped: bool = False  #: whether an interrupt came before all draws were made

    @property
    def outcome(self) -> ReliabilityOutcome:
        """What kind of answer this is."""
        return ReliabilityOutcome.STOPPED if self.stopped else ReliabilityOutcome.ESTIMATED

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
        where = (
            "" if self.at_most is None else ", drawn about the mean, the design point and its mirror image, weighted"
        )
        lines.append(f"{self.failures} of {self.draws} draws fall, {self.undecided} undecided{where}.")
        if self.at_most is not None:
            lines.append(
                f"What falls far from both points is seen by draws about the mean alone: at most {self.at_most:.4g}."
            )
        cost = 1e3 * self.seconds / self.draws
        lines.append(f"Evidence of earlier draws decided {self.reused}. A draw took {cost:.3g} ms of process time.")
        lines.append(ASSOCIATED if self.flow == "associated" else CAUTIOUS.format(self.self_stress))
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
            "seconds": self.seconds,
            "flow": self.flow,
            "self_stress": self.self_stress,
            "at_most": self.at_most,
        }


@known_options
def reliability(
    assembly: Assembly,
    uncertain: Mapping[str, Random] | None = None,
    *,
    load: Any = None,
    loads: Loads | None = None,
    draws: int = 1000,
    seed: int = 0,
    confidence: float = 0.95,
    flow: str = "associated",
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    about: FirstOrder | None = None,
    reuse: bool = True,
    file: str | Path | None = None,
    jobs: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Reliability:
    """Estimate the probability that an assembly does not stand when some of its data are random.

    Parameters
    ----------
    assembly
        The blocks as drawn.
    uncertain
        Random variables by key, independent of each other: "friction", the coefficient of joints; "edge", what joints
        lose along each edge [m]; "corner", a displacement of each shared corner in each direction [m];
        "density.GROUP" [kg/m3] and "loads.GROUP", a factor on the permanent loads, by group ("*" for all); "push", a
        factor on `load`. Whether joints and blocks share one value says `each` of `blockstat.Random`. None for those
        of the scene.
    load
        An acceleration direction or a wrench on each block, as in `blockstat.limit_load`, which acts "push" times; None
        for that of the scene, if it names one; its "push" is then random as the scene says, unless `uncertain` does.
        A direction has no size and is as strong as gravity: a tenth of that is ``0.1 * acceleration(assembly, (1, 0,
        0))``, of the masses of `assembly`, or a "push" of ``Random("uniform", 0.1, 0.1)``, which follows random
        densities. Without a "push" three numbers must be a unit vector.
    loads
        Permanent loads, shape (n_blocks, 6) [N, N m]. Those of a load case are its `weighted_loads`: its factor on the
        weight is then that of the densities and corners drawn.
    draws
        How many.
    seed
        Of the random numbers.
    confidence
        Of the interval.
    flow, gap, interfaces
        As in `blockstat.assess`. With flow="coulomb" what only self-stress holds has fallen. A draw then takes much
        longer.
    about
        Draw about this design point and weigh the draws (importance sampling): small probabilities need fewer. Half of
        them are about the point, a quarter about its mirror image and a quarter about the mean.
    reuse
        Whether evidence of earlier draws is tried before a solve; the verdicts are the same.
    file
        Keeps a row of each draw as lines of JSON. What has a row there is not judged again, so an interrupted run goes
        on where it stopped, and one of more draws goes on from those it has.
    jobs
        Processes side by side, by default one; the draws are the same. Under `joblib.parallel_config(backend="dask")`,
        or another backend, draws go to all of its workers instead.
    progress
        Called with the draws done and those asked for. With it a KeyboardInterrupt after some draws gives the outcome
        "stopped" and the estimate of those; without it, it is raised.

    Returns
    -------
    Reliability
        The estimate with its interval.

    Raises
    ------
    InputError
        For a variable that there is not, a direction whose length would be dropped, fewer than one draw, a file of
        other draws, an `about` of other variables or without a design point,
        blocks that overlap as drawn, and for corners and edges (or joint laws) of joints of several patches.

    Notes
    -----
    The interval is that of Clopper and Pearson (1934), which contains the probability at least as often as it says,
    with undecided draws as standing at its lower end and as fallen at its upper one.

    About a design point it is that of Fay and Feuer (1997) for weighted counts, with the largest weight of those that
    fell; where fewer than ten fell, with the largest weight there can be. So it holds where all that falls is near the
    point or its mirror image. What falls elsewhere is seen by the quarter of the draws about the mean, and `at_most` is
    the bound of Clopper and Pearson by these alone. Where the mean falls (a negative beta), draws that stand are
    counted, which are then beyond the point, and the probability is 1 less theirs: what stands elsewhere makes it
    smaller. Sums of weights scatter; an estimate or an end of its interval below 0 or above 1 is given as 0 or 1.

    References
    ----------
    Clopper & Pearson: The use of confidence or fiducial limits illustrated in the case of the binomial, 1934.
    Fay & Feuer: Confidence intervals for directly standardized rates, 1997. Hesterberg: Weighted average importance
    sampling and defensive mixture distributions, 1995.

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
    check_choice("flow", flow, FLOWS)
    population, load = population_of(assembly, uncertain, load, loads, gap=gap, interfaces=interfaces)
    check_strength(population.uncertain, load)
    _check_draws(draws, seed, jobs)
    if not 0 < confidence < 1:
        raise InputError(f"confidence is {confidence!r}; it must be between 0 and 1")
    centre = np.zeros(population.size) if about is None else about.point
    if centre.shape != (population.size,):
        raise InputError(
            f"about has a design point of {centre.size} random values and uncertain has {population.size}; "
            "give the one of the same random variables"
        )
    if not np.isfinite(centre).all():
        raise InputError("about has no design point, as none was found; leave it out, to draw about the mean")
    trials = Trials(population, load, centre, seed, reuse, flow)
    rows = judge_all(trials, asked := draws, file, jobs, progress)
    draws = len(rows)
    words = np.array([row.outcome for row in rows])
    held = words == Outcome.STABLE_ONLY_BY_SELF_STRESS.word
    failed, undecided = (words == "unstable") | held, words == "undecided"
    at_most: float | None = None
    if about is None:
        probability, interval = _binomial(int(failed.sum()), int(undecided.sum()), draws, confidence)
    else:
        weight, mean = trials.weights(draws), trials.turns(draws) == 0
        fallen = failed | undecided
        probability, interval = _about(about.beta, weight, failed, fallen, draws / mean.sum(), confidence)
        at_most = _binomial(int(fallen[mean].sum()), 0, int(mean.sum()), 2 * confidence - 1)[1][1]
    return Reliability(
        probability=probability,
        interval=interval,
        confidence=confidence,
        draws=draws,
        failures=int(failed.sum()),
        undecided=int(undecided.sum()),
        reused=sum(row.evidence != "solved" for row in rows),
        sampled_about="the mean" if about is None else "the design point",
        seconds=sum(row.seconds for row in rows),
        flow=flow,
        self_stress=int(held.sum()),
        at_most=at_most,
        stopped=draws < asked,
    )


def _check_draws(draws: Any, seed: Any, jobs: Any) -> None:
    check_count("draws", draws)
    check_seed(seed)
    if jobs is not None:
        check_count("jobs", jobs)


def _binomial(failures: int, undecided: int, draws: int, confidence: float) -> tuple[float, tuple[float, float]]:
    """Share and Clopper-Pearson interval."""
    tail, most = (1 - confidence) / 2, failures + undecided
    low = float(betaincinv(failures, draws - failures + 1, tail)) if failures else 0.0
    high = float(betaincinv(most + 1, draws - most, 1 - tail)) if most < draws else 1.0
    return failures / draws, (low, high)


def _about(
    beta: float, weight: Floats, failed: np.ndarray, fallen: np.ndarray, largest: float, confidence: float
) -> tuple[float, tuple[float, float]]:
    """Mean and interval of the draws about a design point, from those beyond it, seen from the mean.

    failed, fallen : draws that fall, without and with undecided ones, shape (draws,).
    """
    if not beta < 0:
        probability, (low, high) = _weighted(weight, failed, fallen, largest, confidence)
    else:
        _, (low, high) = _weighted(weight, ~fallen, ~failed, largest, confidence)
        probability, low, high = 1.0 - _moments(weight[~failed] / len(weight))[0], 1.0 - high, 1.0 - low
    # Weights sum to as many as there are draws in the mean only, so that a weighted share may come out of its range.
    probability, low, high = (float(np.clip(own, 0.0, 1.0)) for own in (probability, low, high))
    return probability, (low, high)


def _weighted(
    weight: Floats, least: np.ndarray, most: np.ndarray, largest: float, confidence: float
) -> tuple[float, tuple[float, float]]:
    """Mean and interval of Fay and Feuer of weighted failures, without and with undecided draws."""
    draws, tail = len(weight), (1 - confidence) / 2
    low, spread = _moments(weight[least] / draws)
    below = spread / low * float(gammaincinv(low**2 / spread, tail)) if low > 0 else 0.0
    more = float(weight[most].max() if most.sum() >= FEW else largest) / draws
    high, spread = (own + more**k for k, own in enumerate(_moments(weight[most] / draws), 1))
    above = spread / high * float(gammaincinv(high**2 / spread, 1 - tail))
    return low, (below, above)


def _moments(values: Floats) -> tuple[float, float]:
    """Sums of values and of their squares."""
    return float(values.sum()), float(values @ values)


@known_options
def fragility(
    assembly: Assembly,
    uncertain: Mapping[str, Random],
    load: Any,
    *,
    loads: Loads | None = None,
    draws: int = 200,
    seed: int = 0,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    jobs: int | None = None,
) -> Floats:
    """Draw limit load multipliers: the share of them below a value is the probability of falling at that value.

    Parameters
    ----------
    assembly, uncertain, loads, draws, seed, gap, interfaces, jobs
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
    if not isinstance(uncertain, Mapping):
        raise InputError(f"uncertain is {uncertain!r}; it must be random variables by key")
    if "push" in uncertain:
        raise InputError('the multiplier itself is what "push" would be; leave it out')
    population, load = population_of(assembly, uncertain, load, loads, gap=gap, interfaces=interfaces)
    _check_draws(draws, seed, jobs)
    normals = np.random.default_rng(seed).standard_normal((draws, population.size))
    return np.sort(np.array(in_stretches(partial(_multipliers, population, load), normals, jobs), dtype=float))


def _multipliers(population: Population, load: Any, normals: Floats) -> list[float]:
    """The multiplier that each of some draws carries."""
    found = []
    for normal in normals:
        draw = population.realise(normal)
        options: dict[str, Any] = {"loads": draw.loads, "gap": population.gap, "interfaces": draw.interfaces}
        limit = limit_load(draw.assembly, load, **options)
        found.append(0.0 if limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE else limit.lower)
    return found
