"""Seconds of a limit load by the width of the bracket that is asked for, and of the optimum.

    python -m evidence.benchmarks.anytime [--scenes wall-in nave ...] [--tolerances 1e-2 1e-4] [--largest] [--json]

Process time of everything from the assembly in memory to the bracket, with the search for joints; the least of
`--repeat` runs. The error is against the middle of the optimum's bracket. Only public names are used, so that with
PYTHONPATH an earlier source runs the same scenes; one without tolerances prints the optimum alone.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from time import process_time
from typing import Any

from blockstat import Assembly, build, limit_load, load_scene
from evidence import results
from evidence.paths import EXAMPLES
from evidence.scenes.sized import wall
from evidence.tables import table

TOLERANCES = tuple(10.0**-k for k in range(2, 10))


def example(name: str) -> Assembly:
    return build(load_scene(EXAMPLES / f"{name}.toml"))


#: Scene and load.
SCENES: dict[str, tuple[Callable[[], Assembly], tuple[float, float, float]]] = {
    "wall-in": (lambda: wall(1024), (1, 0, 0)),
    "wall-out": (lambda: wall(1024), (0, 1, 0)),
    "nave": (lambda: example("nave"), (0, 1, 0)),
    "tower": (lambda: example("tower"), (1, 0, 0)),
    "rotunda": (lambda: example("rotunda"), (1, 0, 0)),
    "wall-out-10000": (lambda: wall(10_000), (0, 1, 0)),
}
USUAL = tuple(SCENES)[:5]
LARGEST = "wall-out-10000"
SHARP = {"optimum": True} if "optimum" in signature(limit_load).parameters else {}


def timed(assembly: Assembly, load: tuple[float, float, float], repeat: int, **options: Any) -> tuple[Any, float]:
    best, found = float("inf"), None
    for _ in range(repeat):
        begin = process_time()
        found = limit_load(assembly, load, **options)
        best = min(best, process_time() - begin)
    return found, best


def measured(name: str, tolerances: tuple[float, ...], repeat: int) -> list[dict]:
    make, load = SCENES[name]
    assembly = make()
    sharp, seconds = timed(assembly, load, repeat, **SHARP)
    exact = (sharp.lower + sharp.upper) / 2
    rows = [row(name, assembly, "optimum", sharp, seconds, exact)]
    for tolerance in tolerances if SHARP else ():
        found, seconds = timed(assembly, load, repeat, tolerance=tolerance)
        rows.append(row(name, assembly, f"{tolerance:.0e}", found, seconds, exact))
    return rows


def row(name: str, assembly: Assembly, asked: str, found: Any, seconds: float, exact: float) -> dict:
    error = abs((found.lower + found.upper) / 2 - exact) / abs(exact)
    return {
        "scene": name, "blocks": assembly.n_blocks, "asked": asked, "outcome": found.outcome.word,
        "lower": found.lower, "upper": found.upper, "width": found.gap, "error": error,
        "iterations": getattr(found, "iterations", None), "seconds": seconds,
    }  # fmt: skip


def rows_table(rows: list[dict]) -> str:
    return table(
        ["scene", "blocks", "asked", "outcome", "width", "error", "iterations", "s"],
        (
            [r["scene"], f"{r['blocks']:,}", r["asked"], r["outcome"], f"{r['width']:.1e}", f"{r['error']:.1e}",
             "-" if r["iterations"] is None else r["iterations"], f"{r['seconds']:.2f}"] for r in rows
        ),
    )  # fmt: skip


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=USUAL)
    parser.add_argument("--tolerances", nargs="+", type=float, default=TOLERANCES)
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--largest", action="store_true", help="also the wall of 10,050 blocks, to 1e-3")
    options = parser.parse_args()
    rows = [one for name in options.scenes for one in measured(name, tuple(options.tolerances), options.repeat)]
    if options.largest:
        make, load = SCENES[LARGEST]
        assembly = make()
        found, seconds = timed(assembly, load, 1, tolerance=1e-3)
        rows.append(row(LARGEST, assembly, "1e-03", found, seconds, float("nan")))
    results.report(options, rows, {"tolerances": rows_table(rows)})


if __name__ == "__main__":
    main()
