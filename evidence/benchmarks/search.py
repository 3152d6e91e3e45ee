"""The chapel of some 300 blocks optimised three ways: Bullet alone on every design, pruned by statics, by gradients.

    python -m evidence.benchmarks.search [--widest 2.0] [--sample 16] [--seed 1] [--lighter] [--no-gradient] [--json]
        [--write FILE]

Three thicknesses and the presence of a buttress move; walls from the widest of the procedural-masonry paper, 2 m, down
to 0.4 m. Bullet alone is timed on a random sample of the designs and extrapolated, also over the designs with walls of
no more than 0.8 m; with --lighter it also simulates every design lighter than the pruned answer, which shows that
Bullet alone would have found the same one. Seconds are process time.
"""

from __future__ import annotations

import sys
from functools import partial
from time import perf_counter, process_time
from typing import Any

import msgspec
import numpy as np

from blockstat import Memory, assess, build, search
from blockstat.design_search.search import Margin, SearchResult, space_of
from blockstat.spec import Scene, scene_from
from dynsim import SpeculativeRuns
from dynsim import verify as verify_alone
from dynsim.comparison.causes import likely_reason
from dynsim.parallel.pool import jobs_checked
from evidence import results
from evidence.scenes.sized import chapel_scene
from evidence.tables import table

WIDEST, NARROW = 2.0, 0.8  #: walls of the paper, and of a designer who knows the answer already [m]
NAMES = ("wall.thickness", "vault.thickness", "buttresses.south.thickness", "buttresses.north.present")
MAIN = ("pruned", "gradient")  #: ways whose designs are listed
PUSH = (0.0, 1.0, 0.0)  #: across the nave
verify = partial(verify_alone, statics=True)  #: as `dynsim optimise` asks


def scene(blocks: int = 300, widest: float = NARROW) -> Scene:
    """The chapel of the examples in smaller bricks, with three thicknesses and one presence to move."""
    data = msgspec.to_builtins(chapel_scene(blocks))
    data["wall"]["thickness"] = {"value": widest, "min": 0.4, "max": widest, "step": 0.1}
    data["vault"]["thickness"] = {"value": 0.35, "min": 0.2, "max": 0.35, "step": 0.05}
    data["buttresses"]["south"]["thickness"] = {"value": 0.9, "min": 0.3, "max": 0.9, "step": 0.2}
    data["buttresses"]["north"]["present"] = "search"
    return scene_from(data)


def row(name: str, result: SearchResult, seconds: float) -> dict:
    found = {tuple(c.parameters.values()): c for c in result.history}
    best = found[tuple(result.best_parameters.values())] if result.best_parameters else None
    return {
        "way": name, "designs": len(result.history), "static_solves": result.static_solves,
        "certificates_reused": result.certificates_reused, "dynamic_runs": result.dynamic_runs, "seconds": seconds,
        "best": result.best_parameters, "volume": best.volume if best else None,
        "disagreements": [(c.parameters, c.dynamic, c.note) for c in result.disagreements],
    }  # fmt: skip


def pruned(chapel: Scene, way: str = "pruned", **ahead: Any) -> tuple[dict, SearchResult]:
    begin, memory = process_time(), Memory()
    options = {"verify": verify, **ahead}
    result = search(
        chapel, names=NAMES, over="grid", memory=memory,
        static=lambda assembly: assess(assembly, memory=memory, score=False), **options,
    )  # fmt: skip
    return row(way, result, process_time() - begin), result


def side_by_side(chapel: Scene, alone: SearchResult) -> dict:
    """The same with a simulation on each core, timed by the clock, as `dynsim optimise` does it."""
    jobs, begin = jobs_checked(None), perf_counter()
    with SpeculativeRuns(verify, jobs) as dynamic:
        _, result = pruned(chapel, verify=dynamic, begin=dynamic.begin, speculative=jobs)
    seconds = perf_counter() - begin
    words = [[(c.parameters, c.static, c.dynamic) for c in found.history] for found in (alone, result)]
    return {"jobs": jobs, "seconds": seconds, "same": words[0] == words[1]}


def reasons(chapel: Scene, result: SearchResult) -> list[tuple]:
    """Why statics and Bullet differ, asked afterwards: Coulomb states take longer than the search itself."""
    found = []
    for candidate in result.disagreements:
        assembly = build(space_of(chapel, NAMES).at(candidate.parameters))
        note = likely_reason(assess(assembly), verify(assembly))
        found.append((candidate.parameters, candidate.dynamic, note))
    return found


def gradient(chapel: Scene, least: float) -> dict:
    begin = process_time()
    result = search(chapel, names=NAMES, strategy="gradient", margin=Margin(PUSH, least), verify=verify)
    return {**row("gradient", result, process_time() - begin), "least": least}


def bullet_alone(chapel: Scene, sample: int, seed: int, way: str = "Bullet alone") -> dict:
    """Bullet on some designs of the grid, and what the whole of it would take."""
    designs = list(space_of(chapel, NAMES).grid())
    chosen = np.random.default_rng(seed).choice(len(designs), sample, replace=False)
    seconds = []
    for number in chosen:
        begin = process_time()
        verify_alone(build(space_of(chapel, NAMES).at(designs[number])))
        seconds.append(process_time() - begin)
    mean, error = float(np.mean(seconds)), float(np.std(seconds, ddof=1) / np.sqrt(sample))
    return {
        "way": way, "designs": len(designs), "static_solves": 0, "certificates_reused": 0,
        "dynamic_runs": len(designs), "sample": sample, "mean": mean, "error": error, "seconds": mean * len(designs),
    }  # fmt: skip


def lighter(chapel: Scene, volume: float) -> dict:
    """Bullet on every design of the grid that is lighter."""
    space, words = space_of(chapel, NAMES), []
    for values in space.grid():
        assembly = build(space.at(values))
        if assembly.volume[assembly.free].sum() < volume * (1 - 1e-12):
            words.append(verify(assembly).outcome.word)
    return {"designs": len(words), **{word: words.count(word) for word in sorted(set(words))}}


def ways_table(ways: list[dict]) -> str:
    """A line a way."""

    def cells(found: dict) -> list:
        guessed = ""
        if "sample" in found:
            guessed = f" (from {found['sample']} designs, +- {found['error'] * found['designs']:.0f})"
        volume = "" if found.get("volume") is None else f"{found['volume']:.3f}"
        counts = [found[name] for name in ("way", "designs", "static_solves", "certificates_reused", "dynamic_runs")]
        return [*counts, f"{found['seconds']:.1f}{guessed}", volume]

    heads = ["designs tried", "static solves", "certificates reused", "Bullet runs", "seconds", "best [m3]"]
    return table(["", *heads], map(cells, ways))


def comparison(figures: dict) -> str:
    """The ways beside each other, the designs they found, and what statics saved."""
    lines = [f"{figures['blocks']} blocks, {figures['space']} designs.", "", ways_table(figures["ways"])]
    for found in figures["ways"]:
        if found.get("best") and found["way"] in MAIN:
            values = ", ".join(f"{name} {value:.4g}" for name, value in found["best"].items())
            lines += ["", f"Best, {found['way']}: {values}."]
        for parameters, word, note in found.get("disagreements", ()) if found["way"] in MAIN else ():
            values = " ".join(f"{value:.4g}" for value in parameters.values())
            lines.append(f"- statics allow {values}, Bullet: {word}; {note or 'the reason was not computed'}")
    both = figures["side_by_side"]
    lines += [
        "",
        f"The pruned search with {both['jobs']} processes takes {both['seconds']:.0f} s of clock time, and its history "
        f"is {'the same' if both['same'] else 'ANOTHER'}.",
    ]
    narrow = f"{figures['narrow_ratio']:.0f} times, {'the same' if figures['narrow_same'] else 'ANOTHER'} best design"
    lines += [
        "",
        f"Bullet alone takes {figures['ratio']:.0f} times as long as the pruned search; with walls up to {NARROW:g} m "
        f"{narrow}.",
        f"Of the seconds of the pruned search, {figures['static_seconds']:.0f} are statics and "
        f"{figures['dynamic_seconds']:.0f} are Bullet.",
    ]
    if "lighter" in figures:
        counts = ", ".join(f"{word} {number}" for word, number in figures["lighter"].items())
        lines.append(f"Bullet on every design that is lighter than the answer: {counts}.")
    return "\n".join(lines)


def summary(designs: int, ratio: float, sample: int) -> str:
    """One line."""
    return (
        f"- The simulation of all {designs} designs takes {ratio:.0f} times as long as the search (extrapolated from "
        f"{sample} of them)."
    )


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--widest", type=float, default=WIDEST, help="walls [m]")
    parser.add_argument("--sample", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--reserve", type=float, default=0.0, help="of the search by gradients [g]")
    parser.add_argument("--lighter", action="store_true")
    parser.add_argument("--no-gradient", action="store_true")
    parser.add_argument("--reasons", action="store_true", help="say why statics and Bullet differ")
    options = parser.parse_args()
    chapel, narrow = scene(widest=options.widest), scene(widest=NARROW)
    assess(build(chapel))  # libraries are loaded before anything is timed
    quick, result = pruned(chapel)
    both = side_by_side(chapel, result)
    print(both, file=sys.stderr, flush=True)
    ways = [bullet_alone(chapel, options.sample, options.seed), quick]
    few = f", walls up to {NARROW:g} m"
    ways += [
        bullet_alone(narrow, options.sample, options.seed, "Bullet alone" + few),
        pruned(narrow, "pruned" + few)[0],
    ]
    if not options.no_gradient:
        ways.insert(2, gradient(chapel, options.reserve))
    figures = {
        "blocks": build(chapel).n_blocks, "space": space_of(chapel, NAMES).size, "ways": ways,
        "side_by_side": both,
        "ratio": ways[0]["seconds"] / quick["seconds"],
        "narrow_ratio": ways[-2]["seconds"] / ways[-1]["seconds"],
        "narrow_same": ways[-1]["best"] == quick["best"],
        "static_seconds": sum(c.static_seconds for c in result.history),
        "dynamic_seconds": sum(c.dynamic_seconds for c in result.history),
    }  # fmt: skip
    if options.reasons:
        quick["disagreements"] = reasons(chapel, result)
    if options.lighter and quick["volume"] is not None:
        figures["lighter"] = lighter(chapel, quick["volume"])
    parts = {"table": comparison(figures), "summary": summary(figures["space"], figures["ratio"], options.sample)}
    results.report(options, figures, parts)


if __name__ == "__main__":
    main()
