"""Seconds of `assess` on walls, step by step: process time, one run, this machine.

python -m evidence.benchmarks.assess [--sizes 100 1000 3000] [--json]
"""

from __future__ import annotations

import argparse
import json
from time import process_time

from blockstat import assess
from evidence.scenes.sized import wall

STEPS = ("build", "interfaces", "equilibrium", "solve", "certificate", "total")


def measure(blocks: int, push: float) -> dict:
    """One row: a wall at rest (push 0) or with a horizontal load of that share of its weight."""
    begin = process_time()
    asm = wall(blocks)
    built = process_time() - begin
    gravity = (9.81 * push, 0.0, -9.81)
    verdict = assess(asm, gravity=gravity)
    return {
        "blocks": asm.n_blocks, "points": verdict.interfaces.n_points, "push": push,
        "verdict": verdict.outcome.word, "build": built, **verdict.timings,
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=[100, 1000, 3000])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    measure(20, 0.0)  # imports are not part of any row
    rows = [measure(size, push) for size in options.sizes for push in (0.0, 1.0)]
    if options.json:
        print(json.dumps(rows))
        return
    print(f"{'blocks':>7} {'points':>7} {'push':>5} {'verdict':>9} " + " ".join(f"{s:>11}" for s in STEPS))
    for row in rows:
        seconds = " ".join(f"{row[s]:11.3f}" for s in STEPS)
        print(f"{row['blocks']:7} {row['points']:7} {row['push']:5.1f} {row['verdict']:>9} {seconds}")


if __name__ == "__main__":
    main()
