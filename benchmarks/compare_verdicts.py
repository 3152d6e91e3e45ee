"""Random vaulted huts: statics, statics with Coulomb friction, and Bullet, counted against each other.

python benchmarks/compare_verdicts.py [--scenes 60] [--seed 7] [--json]
"""

from __future__ import annotations

import argparse
import json
from collections import Counter

import numpy as np
from families import hut

from blockstat import InputError, assess
from dynsim import verify


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    counts: Counter[tuple[str, str, str]] = Counter()
    for number in range(options.scenes):
        try:
            assembly = hut(rng, walls=(0.25, 0.8), vaults=(0.15, 0.4), name=f"hut {number}")
        except InputError:
            continue
        words = [assess(assembly, flow=flow).outcome.word for flow in ("associated", "coulomb")]
        counts[(words[0], words[1], verify(assembly).outcome.word)] += 1
    if options.json:
        print(json.dumps([{"static": s, "coulomb": c, "bullet": d, "scenes": n} for (s, c, d), n in counts.items()]))
        return
    print(f"{'static':>10} {'with Coulomb friction':>28} {'Bullet':>8} {'scenes':>7}")
    for (static, coulomb, bullet), n in sorted(counts.items()):
        print(f"{static:>10} {coulomb:>28} {bullet:>8} {n:7}")


if __name__ == "__main__":
    main()
