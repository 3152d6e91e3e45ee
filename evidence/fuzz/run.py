"""Random scenes: the verdicts of the statics against an independent judge.

    python -m evidence.fuzz [--scenes 300] [--seed 0] [--limits 0] [--places 25] [--jobs 1] [--only SEED] [--write FILE]

Every failure is printed with its seed, and `--only` repeats it alone. An interrupted run prints what is done.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TypeVar

from joblib import Parallel, delayed

from evidence.fuzz import report
from evidence.fuzz.compare import Result, compared
from evidence.fuzz.generate import FAMILIES, scene
from evidence.fuzz.judge import judge
from evidence.fuzz.limits import Limit, limit

T = TypeVar("T")


def options() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0, help="of the first scene; the others follow")
    parser.add_argument("--limits", type=int, default=0, help="limit loads of so many stable scenes")
    parser.add_argument("--places", type=int, default=25, help="every so many scenes are moved and reordered, too")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", type=int, metavar="SEED", help="one scene, with its contacts")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the page")
    return parser.parse_args()


def stream(task: Callable[[int], T], seeds: Iterable[int], jobs: int) -> Iterator[T]:
    """Results as they come, in any order."""
    if jobs == 1:
        yield from map(task, seeds)
        return
    yield from Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=20)(delayed(task)(s) for s in seeds)


def task_of(places: int) -> Callable[[int], Result]:
    """Compares a seed, at other places as well when its turn comes."""

    def task(seed: int) -> Result:
        return compared(seed, places=bool(places) and seed // len(FAMILIES) % places == 0)

    return task


def main() -> None:
    """Run as the command line says."""
    chosen = options()
    if chosen.only is not None:
        found = scene(chosen.only)
        for touch in judge(found).touches:
            print(report.contact(touch))
        print(f"friction {found.friction}, gravity {found.gravity}, supports {found.support}")
        print(report.line(compared(chosen.only, places=True)))
        return
    results: list[Result] = []
    limits: list[Limit] = []
    try:
        seeds = range(chosen.seed, chosen.seed + chosen.scenes)
        for result in stream(task_of(chosen.places), seeds, chosen.jobs):
            results.append(result)
            if result.fails:
                print(report.line(result), flush=True)
        for bracket in stream(limit, range(chosen.seed, chosen.seed + 3 * chosen.limits), chosen.jobs):
            if bracket is not None and len(limits) < chosen.limits:
                limits.append(bracket)
                if bracket.fails:
                    print(report.bracket_line(bracket), flush=True)
    except KeyboardInterrupt:
        print("interrupted; what is done:")
    print(report.summary(results, limits))
    if chosen.write:
        chosen.write.write_text(report.page(results, limits))


if __name__ == "__main__":
    main()
