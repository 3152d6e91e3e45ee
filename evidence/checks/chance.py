"""Probabilities of falling: known ones, the time of 10,000 draws of the chapel, and cost a draw.

    python -m evidence.checks.chance [--only known cost] [--draws N] [--rows FILE] [--write docs/results/chance.md]

With --rows the draws of the chapel are kept in a file, and an interrupted run goes on from it. Clock time is then not
given.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.stats import binom, binomtest, norm

from blockstat import Assembly, Random, acceleration, build, first_order, load_scene, reliability
from evidence.paths import EXAMPLES
from evidence.results import parser, report
from evidence.scenes.small import stack
from evidence.tables import table

SIDE = (1, 0, 0)
SEEDS, EACH = 100, 60
#: Of an interval of 60 draws, and of the counts of 100 seeds.
CONFIDENCE = 0.95
FRICTION, PUSH = norm(0.6, 0.1), norm(0.3, 0.15)
#: What is random about the chapel: friction, rounded edges and a push along its walls.
CHAPEL = {
    "friction": Random("lognormal", 0.6, 0.1),
    "edge": Random("uniform", 0.0, 0.005),
    "push": Random("normal", 0.3, 0.1),
}
#: Draws judged without earlier evidence, for the cost of a draw.
ALONE = 200


@dataclass(frozen=True)
class Known:
    """A scene of which the probability of falling is known."""

    name: str
    scene: Assembly
    uncertain: dict[str, Random]
    push: float  #: times gravity
    falls: Callable[[Any], Any]  #: whether it falls, by standard normal variables in the last axis
    exact: float

    @property
    def load(self) -> np.ndarray:
        """The push on each block."""
        return self.push * acceleration(self.scene, SIDE)

    def enumerated(self, steps: int = 2000) -> float:
        """The probability as a sum over a grid of equal parts of the standard normal variables."""
        middle = norm.ppf((np.arange(steps) + 0.5) / steps)
        grids = np.meshgrid(*[middle] * len(self.uncertain), indexing="ij")
        return float(np.mean(self.falls(np.stack(grids, axis=-1))))


#: A slab slides; a block tips at b / h = .5; a block slides or tips, whichever comes first.
KNOWN = (
    Known(
        "slides",
        stack(1, 2.0, 0.5, friction=0.6),
        {"friction": Random("normal", 0.6, 0.1)},
        0.5,
        lambda z: 0.6 + 0.1 * z[..., 0] < 0.5,
        float(FRICTION.cdf(0.5)),
    ),
    Known(
        "tips",
        stack(1, 1.0, 2.0, friction=2.0),
        {"push": Random("normal", 0.3, 0.15)},
        1.0,
        lambda z: 0.3 + 0.15 * z[..., 0] > 0.5,
        float(PUSH.sf(0.5)),
    ),
    Known(
        "slides or tips",
        stack(1, 1.0, 2.0, friction=0.6),
        {"friction": Random("normal", 0.6, 0.1), "push": Random("normal", 0.3, 0.15)},
        1.0,
        lambda z: np.abs(0.3 + 0.15 * z[..., 1]) > np.minimum(0.6 + 0.1 * z[..., 0], 0.5),
        quad(lambda mu: FRICTION.pdf(mu) * (PUSH.sf(min(mu, 0.5)) + PUSH.cdf(-min(mu, 0.5))), 0, 2, points=[0.5])[0],
    ),
)


def coverage(exact: float) -> float:
    """How often the interval of Clopper and Pearson from so many draws holds a probability: a sum over all counts."""
    ends = [binomtest(k, EACH).proportion_ci(CONFIDENCE, method="exact") for k in range(EACH + 1)]
    holds = [interval.low <= exact <= interval.high for interval in ends]
    return float(binom.pmf(np.flatnonzero(holds), EACH, exact).sum())


def known() -> list[list[object]]:
    """Probabilities by integral, by a sum over a grid and to first order, and how often intervals hold the first."""
    rows: list[list[object]] = []
    for case in KNOWN:
        first = first_order(case.scene, case.uncertain, case.load)
        found = [reliability(case.scene, case.uncertain, load=case.load, draws=EACH, seed=k) for k in range(SEEDS)]
        held = sum(low <= case.exact <= high for low, high in (own.interval for own in found))
        pooled = sum(own.failures for own in found) / (SEEDS * EACH)
        figures = [f"{p:.5f}" for p in (case.exact, case.enumerated(), first.probability, pooled)]
        share = coverage(case.exact)
        low, high = binom(SEEDS, share).interval(CONFIDENCE)
        rows.append([case.name, *figures, f"{held} of {SEEDS}", f"{SEEDS * share:.1f}", f"{low:.0f} to {high:.0f}"])
        print(*rows[-1], file=sys.stderr)
    return rows


def cost(draws: int, rows: Path | None) -> list[list[object]]:
    """Process time of the draws of the chapel, and of a draw with and without earlier evidence."""
    chapel = build(load_scene(EXAMPLES / "chapel.toml"))
    options: dict[str, Any] = {"load": SIDE}

    def told(done: int, asked: int) -> None:
        print(f"{done} of {asked} draws", file=sys.stderr)

    load, start = os.getloadavg()[0], perf_counter()
    found = reliability(chapel, CHAPEL, draws=draws, jobs=2, file=rows, progress=told, **options)
    clock = [
        ["clock time on two processes [s]", f"{perf_counter() - start:.0f}"],
        [f"load of the {os.cpu_count()} cores before", f"{load:.1f}"],
    ]
    alone = reliability(chapel, CHAPEL, draws=ALONE, reuse=False, **options)
    low, high = found.interval
    return [
        ["blocks", chapel.n_blocks],
        ["draws", found.draws],
        ["probability of falling", f"{found.probability:.4f} ({low:.4f} to {high:.4f})"],
        ["undecided", found.undecided],
        ["decided by earlier evidence", f"{found.reused / found.draws:.0%}"],
        *(clock if rows is None else []),
        ["process time of all draws [s]", f"{found.seconds:.0f}"],
        ["mean of all draws, earlier evidence tried first [ms]", f"{1e3 * found.seconds / found.draws:.1f}"],
        [f"mean of {ALONE} draws without it [ms]", f"{1e3 * alone.seconds / alone.draws:.1f}"],
    ]


if __name__ == "__main__":
    options = parser(__doc__)
    options.add_argument("--only", nargs="+", choices=["known", "cost"], default=["known", "cost"])
    options.add_argument("--draws", type=int, default=10_000)
    options.add_argument("--rows", type=Path)
    chosen = options.parse_args()
    figures: dict[str, Any] = {}
    parts: dict[str, str] = {}
    if "known" in chosen.only:
        figures["known"] = known()
        names = ("scene", "exact", "grid", "first order", f"{SEEDS * EACH} draws", "intervals that hold it")
        names += ("expected", f"{CONFIDENCE:.0%} of such counts")
        parts["known"] = table(names, figures["known"])
    if "cost" in chosen.only:
        figures["cost"] = cost(chosen.draws, chosen.rows)
        parts["cost"] = table(("", "chapel"), figures["cost"])
    report(chosen, figures, parts)
