"""Monte Carlo by the number of draws: error of a probability and of a median, width of the interval, and seconds.

A block that slides or tips has a known probability of falling, and a slab that slides a known median of its limit load.
Errors are root mean squares over seeds. The chapel has no known probability; its interval and its seconds are given.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from math import nan, pi, sqrt
from pathlib import Path

import numpy as np

from blockstat import Assembly, FirstOrder, Random, build, first_order, fragility, load_scene, reliability
from evidence.checks.chance import CHAPEL, FRICTION, KNOWN, SIDE, Known
from evidence.choosing.clock import timed
from evidence.paths import EXAMPLES
from evidence.tables import table

#: Draws, and the seeds over which their error is taken.
DRAWS = {25: 48, 100: 24, 400: 12, 1600: 4}
MEDIANS = {25: 32, 100: 16, 400: 4, 1600: 2}
MEAN, DESIGN = "the mean", "the design point"


@dataclass(frozen=True)
class Sampled:
    """Runs of so many draws."""

    scene: str
    about: str
    draws: int
    seeds: int
    error: float  #: root mean square over seeds, relative to the known value
    expected: float  #: the same by theory; nan where there is none
    interval: float  #: mean half width of the interval, relative to the known value or the estimate; nan: none
    seconds: float  #: process time of a run, with the design point if there is one


def probabilities(case: Known, number: Mapping[int, int] = DRAWS, about: str = MEAN) -> list[Sampled]:
    """Runs of a case with a known probability."""
    point: FirstOrder | None = None
    before, rows = 0.0, []
    if about == DESIGN:
        point, before = timed(lambda: first_order(case.scene, case.uncertain, case.load))
    for draws, seeds in number.items():
        options = {"load": case.load, "draws": draws, "about": point}
        runs = [
            timed(lambda k=seed, o=options: reliability(case.scene, case.uncertain, seed=k, **o), 1)
            for seed in range(seeds)
        ]
        found, spent = zip(*runs, strict=True)
        error = np.array([own.probability for own in found]) / case.exact - 1
        width = np.array([own.interval for own in found]) @ (-0.5, 0.5) / case.exact
        expected = sqrt((1 - case.exact) / (case.exact * draws)) if point is None else nan
        seconds = before + float(np.mean(spent))
        rows.append(Sampled(case.name, about, draws, seeds, _square(error), expected, float(width.mean()), seconds))
    return rows


def medians(number: Mapping[int, int] = MEDIANS) -> list[Sampled]:
    """Median of the limit load of a slab that slides at its friction, which is normal."""
    slab, friction = KNOWN[0].scene, KNOWN[0].uncertain
    exact, spread = float(FRICTION.mean()), float(FRICTION.std())
    rows = []
    for draws, seeds in number.items():
        runs = [
            timed(lambda n=draws, k=seed: fragility(slab, friction, SIDE, draws=n, seed=k), 1) for seed in range(seeds)
        ]
        found, seconds = zip(*runs, strict=True)
        error = np.array([np.median(own) for own in found]) / exact - 1
        expected = sqrt(pi / 2) * spread / exact / sqrt(draws)
        rows.append(
            Sampled("median of a slab", MEAN, draws, seeds, _square(error), expected, nan, float(np.mean(seconds)))
        )
    return rows


def building(assembly: Assembly, uncertain: Mapping[str, Random], numbers: list[int]) -> list[Sampled]:
    """More and more draws of a building; each number goes on from the rows of the one before."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for draws in sorted(numbers):
            found = reliability(assembly, uncertain, load=SIDE, draws=draws, file=Path(folder) / "rows.jsonl")
            half = (found.interval[1] - found.interval[0]) / 2 / (found.probability or nan)
            rows.append(Sampled(f"chapel, {assembly.n_blocks} blocks", MEAN, draws, 1, nan, nan, half, found.seconds))
    return rows


def _square(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error**2)))


@dataclass(frozen=True)
class First:
    """The estimate to first order."""

    error: float  #: relative
    seconds: float


def to_first_order(case: Known) -> First:
    """What the design point alone tells of a case."""
    found, seconds = timed(lambda: first_order(case.scene, case.uncertain, case.load))
    return First(abs(found.probability / case.exact - 1), seconds)


def measured(most: int = max(DRAWS)) -> tuple[list[Sampled], First]:
    """All runs of so many draws at most, and the first-order estimate of the block."""
    case = KNOWN[-1]
    number, of_medians = ({n: seeds for n, seeds in all_of.items() if n <= most} for all_of in (DRAWS, MEDIANS))
    rows = probabilities(case, number) + probabilities(case, number, DESIGN) + medians(of_medians)
    chapel = build(load_scene(EXAMPLES / "chapel.toml"))
    return rows + building(chapel, CHAPEL, list(number)), to_first_order(case)


def rows_table(rows: list[Sampled], first: First) -> str:
    """A line a number of draws."""

    def shown(value: float) -> str:
        return "-" if np.isnan(value) else f"{100 * value:.1f}"

    lines = [
        [r.scene, r.about, r.draws, r.seeds, shown(r.error), shown(r.expected), shown(r.interval), f"{r.seconds:.2f}"]
        for r in rows
    ]
    case = KNOWN[-1].name
    at = max(i for i, r in enumerate(rows) if r.scene == case) + 1
    lines.insert(at, [case, "first order", "-", "-", shown(first.error), "-", "-", f"{first.seconds:.2f}"])
    heads = ["", "drawn about", "draws", "seeds", "error [%]", "expected [%]", "interval ± [%]", "s"]
    return table(heads, lines)


def advice(rows: list[Sampled], first: First) -> str:
    """What more draws buy, from the rows."""
    known = [row for row in rows if row.scene == KNOWN[-1].name]
    plain = sorted((row for row in known if row.about == MEAN), key=lambda row: row.draws)
    weighted = sorted((row for row in known if row.about == DESIGN), key=lambda row: row.draws)
    few, many = plain[0], plain[-1]
    last = weighted[-1]
    return (
        f"- {many.draws // few.draws} times the draws divide the interval by {few.interval / many.interval:.1f}. With "
        f"{many.draws} draws about the design point it is {many.interval / last.interval:.1f} times narrower than with "
        f"as many about the mean, for {last.seconds / many.seconds:.1f} times the seconds. The first-order estimate "
        f"takes {first.seconds:.2f} s and is off by {100 * first.error:.0f} %. Choose the draws by the interval, which "
        "comes with each estimate: a run with `file` goes on from the rows of a shorter one."
    )
