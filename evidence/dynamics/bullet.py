"""Bullet's error and cost by preset, and its cost by size: `--json` prints, `--write` makes docs/bullet.md and a plot.

Error: how far the multiple of a known limit at which a scene stops standing is from 1, by bisection. Cost: process
seconds of one verdict on chapels that stand and chapels that fall, from settling to the early exit.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import tomllib

from blockstat import Assembly, assess, build, limit_load
from blockstat.spec import scene_from
from dynsim import Settings, verify
from dynsim.settings import PRESETS
from evidence import results
from evidence.dynamics import edges
from evidence.paths import DOCS, EXAMPLES, RESULTS
from evidence.plotting import panels, save
from evidence.references.dynamics import LIMITS
from evidence.tables import head, row, table

#: Families whose limits are cheap to bracket.
FAMILIES = ("harmonic stack of 10", "wall of 6 courses, out of plane", "arch of 15, 1 / thickness",
            "arch of 31, 1 / thickness", "wall of 8 x 4, in plane")  # fmt: skip
#: Chapels by the edge of their bricks [m]: length, height, and voussoirs along the arch.
CHAPELS = {"S": (1.35, 0.6, 9), "M": (0.82, 0.3, 13), "L": (0.42, 0.175, 25), "XL": (0.26, 0.09, 41)}
WALLS = {"stands": 0.8, "falls": 0.3}
ACROSS = (0.0, 1.0, 0.0)  #: the load of a limit load, in units of gravity
#: Smallest imbalance that runs have to see, the chapel they are timed on, and the family their error is measured on.
RESOLUTIONS = (1e-2, 1e-3, 1e-4, 1e-5)
TIMED, MEASURED = "S", "block tipping"


def errors(preset: str) -> list[dict]:
    settings = Settings.named(preset)
    rows = []
    for limit in LIMITS:
        if limit.name in FAMILIES:
            begin = process_time()
            low, high = replace(limit, within=0.03).bracket(settings)
            rows.append({"scene": limit.name, "preset": preset, "error": (low + high) / 2 - 1,
                         "bracket": high - low, "seconds": process_time() - begin})  # fmt: skip
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def chapel(size: str, wall: float) -> Assembly:
    length, height, voussoirs = CHAPELS[size]
    scene = tomllib.loads((EXAMPLES / "chapel.toml").read_text())
    scene["brick"] = {"length": length, "height": height}
    scene["wall"]["thickness"] = wall
    scene["vault"]["voussoirs"] = voussoirs
    return build(scene_from(scene))


def costs(preset: str, sizes: list[str]) -> list[dict]:
    rows = []
    for size in sizes:
        for expected, wall in WALLS.items():
            verdict = verify(chapel(size, wall), settings=Settings.named(preset))
            rows.append({"preset": preset, "blocks": verdict.run.assembly.n_blocks, "expected": expected,
                         "verdict": verdict.outcome.word, "seconds": verdict.run.process_seconds,
                         "simulated": float(verdict.run.times[-1]), "time_step": verdict.run.time_step})  # fmt: skip
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def statics(sizes: list[str]) -> list[dict]:
    """Seconds of statics on the same chapels, from the blocks to the answer, the search for joints included."""
    rows = []
    for size in sizes:
        for expected, wall in WALLS.items():
            timed(assess, size, wall)  # the first answer of a size also pays for the memory that it takes
            verdict, seconds = timed(lambda blocks: assess(blocks, score=False), size, wall)
            score, scored = timed(assess, size, wall)
            limit, limited = timed(lambda blocks: limit_load(blocks, ACROSS), size, wall)
            rows.append({"blocks": verdict.assembly.n_blocks, "expected": expected, "verdict": verdict.outcome.word,
                         "seconds": seconds, "score": score.score, "scored": scored, "lower": limit.lower,
                         "upper": limit.upper, "limit": limited})  # fmt: skip
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def timed(answer: Callable[[Assembly], Any], size: str, wall: float) -> tuple[Any, float]:
    """An answer on blocks of which nothing is known yet, and its process time [s]."""
    blocks = chapel(size, wall)
    begin = process_time()
    return answer(blocks), process_time() - begin


def headline(found: dict) -> str:
    """What an answer costs on the chapel that stands and on the one that falls."""
    heads = ["blocks", "statics", "verdict [s]", "with score [s]", "limit load [s]", "Bullet", "run [s]"]
    seconds = {(r["blocks"], r["expected"]): r for r in found["costs"] if r["preset"] == "default"}
    rows = []
    for r in found["statics"]:
        run = seconds[r["blocks"], r["expected"]]
        limit = f"{r['limit']:.2f}" if r["verdict"] == "stable" else "-"
        rows.append([f"{r['blocks']:,}", r["verdict"], f"{r['seconds']:.2f}", f"{r['scored']:.2f}", limit,
                     run["verdict"], f"{run['seconds']:.1f}"])  # fmt: skip
    return table(heads, rows)


def resolutions() -> list[dict]:
    """Seconds and error by resolution: a stand takes as long as its window, and the error shrinks with it."""
    rows = []
    tipping = next(limit for limit in LIMITS if limit.name == MEASURED)
    for resolution in RESOLUTIONS:
        settings = Settings(resolution=resolution)
        low, high = replace(tipping, within=0.004).bracket(settings)
        verdict = verify(chapel(TIMED, WALLS["stands"]), settings=settings)
        rows.append({"resolution": resolution, "window": settings.window, "verdict": verdict.outcome.word,
                     "blocks": verdict.run.assembly.n_blocks, "seconds": verdict.process_seconds,
                     "simulated": float(verdict.run.times[-1]), "low": low - 1, "high": high - 1})  # fmt: skip
        print(rows[-1], file=sys.stderr, flush=True)
    return rows


def resolution_section(rows: list[dict]) -> list[str]:
    lines = ["", "## Resolution", "", "The smallest imbalance that a run has to see decides how long a stand takes: "
             "blocks are watched for half the window of the second column at least, at the scale of blocks of 0.3 m, "
             "and longer where noise could hide the imbalance. Seconds are the "
             f"process time of a verdict on the chapel of {rows[0]['blocks']} blocks that stands. The error is that of "
             "the slope at which a pillar tips, between the two last columns. Bullet's own error of other limits is in "
             "the first table, and a finer resolution does not reduce it.", "",
             head(["resolution", "window s", "verdict", "process s", "simulated s", "error from", "to"])]  # fmt: skip
    return lines + [
        row([f"{r['resolution']:g}", f"{r['window']:.2f}", r["verdict"], f"{r['seconds']:.1f}", f"{r['simulated']:.2f}",
             f"{r['low']:+.4f}", f"{r['high']:+.4f}"]) for r in rows
    ]  # fmt: skip


def page(found: dict) -> str:
    lines = [
        "# Bullet: error and cost", "", "Written by `python -m evidence.dynamics.bullet --write`.", "",
        "![two plots in the colours of three presets: dots of error over seconds, and rising lines](bullet.png)", "",
        "*Left: the error of each limit against the seconds of its bisection. Right: the seconds of one verdict "
        "against the number of blocks.*", "",
        "The error is the multiple of the known limit at which a scene ceases to stand, minus 1. Below 0 the scene "
        "falls too early, which is on the safe side. Seconds are the process time of the whole bisection.", "",
        head(["scene", *(name for p in PRESETS for name in (f"{p} error", "s"))]),
    ]  # fmt: skip
    for name in FAMILIES:
        cells = [r for p in PRESETS for r in found["errors"] if (r["scene"], r["preset"]) == (name, p)]
        lines.append(row([name, *(text for r in cells for text in (f"{r['error']:+.4f}", f"{r['seconds']:.1f}"))]))
    lines += ["", "The next table has the seconds of one verdict on the chapel of `examples/chapel.toml` with smaller "
              f"and smaller bricks. Walls of {WALLS['stands']} m stand, and walls of {WALLS['falls']} m fall.", "",
              head(["preset", "blocks", "should", "verdict", "process s", "simulated s", "time step"])]  # fmt: skip
    for r in found["costs"]:
        words = [r[name] for name in ("preset", "blocks", "expected", "verdict")]
        lines.append(row([*words, f"{r['seconds']:.1f}", f"{r['simulated']:.2f}", f"{r['time_step']:g}"]))
    lines += resolution_section(found["resolutions"])
    return "\n".join(lines + edges.section(found["edges"])) + "\n"


def plot(found: dict, path: Path) -> None:
    figure, axes = panels((10, 4), 1, 2)
    for preset, colour in zip(PRESETS, ("tab:orange", "tab:blue", "tab:green"), strict=True):
        rows = [r for r in found["errors"] if r["preset"] == preset]
        axes[0].plot(
            [r["seconds"] for r in rows], [100 * abs(r["error"]) for r in rows], "o", color=colour, label=preset
        )
        for expected, style in (("stands", "o-"), ("falls", "s--")):
            cost = [r for r in found["costs"] if (r["preset"], r["expected"]) == (preset, expected)]
            if cost:
                x, y = [r["blocks"] for r in cost], [r["seconds"] for r in cost]
                axes[1].plot(x, y, style, color=colour, label=f"{preset}, {expected}")
    axes[0].set(xscale="log", xlabel="process seconds of a bisection", ylabel="size of the error [%]", ylim=(0, None))
    axes[1].set(xscale="log", yscale="log", xlabel="blocks", ylabel="process seconds of a verdict")
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.legend(frameon=False)
    save(figure, path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")
    parser.add_argument("--write", action="store_true", help="write docs/bullet.md and docs/bullet.png")
    parser.add_argument("--sizes", nargs="+", default=list(CHAPELS), choices=list(CHAPELS))
    parser.add_argument("--presets", nargs="+", default=list(PRESETS), choices=list(PRESETS))
    options = parser.parse_args()
    found = {"costs": costs("default", options.sizes), "statics": statics(options.sizes)}
    for preset in [name for name in options.presets if name != "default"]:
        found["costs"] += costs(preset, options.sizes[:2])
    found["resolutions"] = resolutions()
    found["edges"] = edges.rows()
    found["errors"] = [row for preset in options.presets for row in errors(preset)]
    print(json.dumps(found) if options.json else f"{headline(found)}\n\n{page(found)}")
    if options.write:
        (DOCS / "bullet.md").write_text(page(found))
        plot(found, DOCS / "bullet.png")
        results.save(RESULTS / "bullet.md", {"headline": headline(found)})


if __name__ == "__main__":
    main()
