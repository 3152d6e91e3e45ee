"""Static against dynamic verdicts on hundreds of small scenes: how often they agree, and why they do not.

    python -m evidence.comparisons.verdicts [--scenes 330] [--limits 40] [--jobs N] [--write PAGE] [--csv FILE]
        [--json FILE]

References whose limit is known, and random arches, portals, walls, huts and chapels. What is done is kept in
build/compare.jsonl and not done again, unless a scene or the code that judges it has changed. --write makes the page
and its pictures, docs/comparison.md.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from functools import partial
from pathlib import Path

from dynsim import Comparison, Comparisons
from dynsim.comparison.compare import compare_one
from evidence.comparisons.kept import Kept
from evidence.comparisons.limits import limits
from evidence.comparisons.page import page, summary
from evidence.comparisons.scenes import randoms, references
from evidence.comparisons.tables import by_cause, matrix, ratios
from evidence.paths import ROOT

KEPT = ROOT / "build" / "compare.jsonl"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=330, help="about that many, references included")
    parser.add_argument("--limits", type=int, default=40, help="scenes whose limit under a push is looked for")
    parser.add_argument("--jobs", type=int, help="processes; one a core by default")
    parser.add_argument("--write", type=Path, metavar="PAGE")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    known = list(references())
    known = known[:: max(1, 2 * len(known) // options.scenes)]  # a small sample has some of them
    scenes = [*known, *randoms(options.scenes - len(known))]
    kept = Kept(KEPT)
    ask = partial(compare_one, closely=True)
    answers = kept.ask(ask, "verdicts", [scene.assembly for scene in scenes], asdict, options.jobs)
    rows = Comparisons(tuple(Comparison(**answer) for answer in answers))
    print(summary(rows), matrix(rows, "static"), matrix(rows, "coulomb"), sep="\n\n")
    for cause, own in by_cause(rows).items():
        print(f"\n{cause.word}: {', '.join(row.name for row in own)}")
    for row in rows:
        if row.static is None:
            print(f"\n{row.name}: no verdict: {row.note}")
    if options.csv:
        rows.write_csv(options.csv)
    if options.json:
        rows.write_json(options.json)
    found = limits(kept, scenes, rows, options.limits, options.jobs)
    if found:
        print(f"\n{ratios(found)}")
    if options.write:
        if not found or all(row.cosine is None for row in rows):
            parser.error("too few scenes for a page: some have to fall, and some to have a limit")
        page(options.write, scenes, rows, found)


if __name__ == "__main__":
    main()
