"""Limit loads by tolerance: the width of the bracket, the error of its safe end, iterations and seconds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

from blockstat import Assembly, build, limit_load, load_scene
from blockstat.analysis.limit_load import ON_THE_WAY, TOLERANCE, LoadOutcome
from evidence.choosing.clock import timed
from evidence.paths import EXAMPLES
from evidence.scenes.sized import wall
from evidence.scenes.small import arch
from evidence.tables import table

TOLERANCES = tuple(10.0**-k for k in range(2, 10))
Load = tuple[float, float, float]
#: Scene and load.
SCENES: dict[str, tuple[Callable[[], Assembly], Load]] = {
    "arch in its plane": (lambda: arch(20, 0.2, friction=0.7), (1, 0, 0)),
    "wall in its plane": (lambda: wall(1024), (1, 0, 0)),
    "rotunda": (lambda: build(load_scene(EXAMPLES / "rotunda.toml")), (1, 0, 0)),
}


@dataclass(frozen=True)
class Bracketed:
    """One bracket, and the tolerances that led to it."""

    scene: str
    blocks: int
    tolerances: tuple[float, ...]
    outcome: str
    width: float  #: relative to the upper end
    error: float  #: of the lower end, relative to the middle of the tightest bracket
    iterations: int
    seconds: float


def series(name: str, assembly: Assembly, load: Load, tolerances: Sequence[float] = TOLERANCES) -> list[Bracketed]:
    """Brackets by falling tolerance until one is undecided; tolerances with the same bracket share a row."""
    limit_load(assembly, load, tolerance=tolerances[0])  # imports and first calls are no part of any row
    found = []
    for tolerance in tolerances:
        limit, seconds = timed(lambda t=tolerance: limit_load(assembly, load, tolerance=t))
        found.append((tolerance, limit, seconds))
        if limit.outcome is not LoadOutcome.LIMIT:
            break
    tightest = min((limit for _, limit, _ in found), key=lambda limit: limit.gap)
    exact = (tightest.lower + tightest.upper) / 2
    rows = []
    for _, group in groupby(found, key=lambda one: (one[1].lower, one[1].upper, one[1].outcome)):
        asked, limits, seconds = zip(*group, strict=True)
        one = limits[0]
        rows.append(
            Bracketed(name, assembly.n_blocks, asked, one.outcome.word, one.gap, (exact - one.lower) / exact,
                      one.iterations, min(seconds))
        )  # fmt: skip
    return rows


def measured(least: float = min(TOLERANCES)) -> list[Bracketed]:
    """All scenes, with tolerances down to the least."""
    asked = [tolerance for tolerance in TOLERANCES if tolerance >= least]
    return [row for name, (make, load) in SCENES.items() for row in series(name, make(), load, asked)]


def rows_table(rows: Sequence[Bracketed]) -> str:
    """A line a bracket."""
    lines = []
    for r in rows:
        asked = " to ".join(f"{t:.0e}" for t in dict.fromkeys((r.tolerances[0], r.tolerances[-1])))
        figures = [f"{r.width:.1e}", f"{r.error:.1e}", r.iterations, f"{r.seconds:.3f}"]
        lines.append([r.scene, f"{r.blocks:,}", asked, r.outcome, *figures])
    return table(["scene", "blocks", "tolerance", "outcome", "width", "error", "iterations", "s"], lines)


def seconds_at(rows: Sequence[Bracketed], scene: str, tolerance: float) -> float:
    """Seconds of a scene at a tolerance, or at the tightest that was asked for."""
    own = [row for row in rows if row.scene == scene]
    return next((row.seconds for row in own if min(row.tolerances) <= tolerance * 1.001), own[-1].seconds)


def advice(rows: Sequence[Bracketed]) -> str:
    """What the tolerances cost, from the rows."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    loose = max(row.tolerances[0] for row in rows)
    cheap = max(seconds_at(rows, scene, ON_THE_WAY) / seconds_at(rows, scene, loose) for scene in scenes)
    dear = max(seconds_at(rows, scene, 0.0) / seconds_at(rows, scene, TOLERANCE) for scene in scenes)
    undecided = sum(row.outcome != LoadOutcome.LIMIT.word for row in rows)
    wide = max((row.width for row in rows if row.outcome != LoadOutcome.LIMIT.word), default=0.0)
    text = f"- A tolerance of {ON_THE_WAY:.0e} takes at most {cheap:.1f} times the seconds of {loose:.0e}. "
    text += f"The narrowest bracket takes up to {dear:.0f} times the seconds of the default, {TOLERANCE:.0e}"
    if undecided:
        text += f"; {undecided} of {len(scenes)} scenes end undecided, with widths of up to {wide:.0e}"
    return f"{text}. So keep the default, and ask for less than {ON_THE_WAY:.0e} only for differences of limits."
