"""Bullet's limits against exact ones: which multiples of the limit stand and which fall.

    python benchmarks/bullet.py [--json]

S stands, F falls. A perfect verifier turns from one to the other at 1.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from blockstat import limit_load
from dynsim import verify
from problems import arch, running_bond, stack

FACTORS = (0.90, 0.94, 0.96, 0.98, 0.99, 1.01, 1.02, 1.04, 1.06, 1.10)


def pushed(asm, limit):
    return lambda factor: asm.with_(gravity=(*[limit[k] * factor for k in (0, 1)], -1.0))


WALL = running_bond(8, 4)

#: (name, scene at a multiple of its exact limit, source of the limit); more of it means less safe.
SCENES = (
    ("block tipping", pushed(stack(1, 0.5, 2.0), (0.25, 0)), "b/h"),
    ("block sliding", pushed(stack(1, 2.0, 0.4), (0.7, 0)), "mu"),
    ("wall 10 x 4 out of plane", pushed(running_bond(10, 4), (0, 0.2 / 1.75)), "t/H"),
    ("wall 8 x 4 in plane", pushed(WALL, (limit_load(WALL, (1, 0, 0)).lower, 0)), "associated limit, an upper bound"),
    ("arch of 15, 1 / thickness", lambda f: arch(15, 0.10705 / f), "static bisection"),
    ("arch of 31, 1 / thickness", lambda f: arch(31, 0.10736 / f), "static bisection"),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = []
    for name, scene, source in SCENES:
        begin = process_time()
        words = [verify(scene(factor)).outcome.word for factor in FACTORS]
        rows.append({"scene": name, "limit": source, "words": words, "seconds": process_time() - begin})
    if options.json:
        print(json.dumps({"factors": FACTORS, "rows": rows}))
        return
    print(f"{'scene':28}" + "".join(f"{factor:6.2f}" for factor in FACTORS) + "  process s  limit from")
    for row in rows:
        marks = "".join(f"{'S' if word == 'stands' else 'F':>6}" for word in row["words"])
        print(f"{row['scene']:28}{marks}{row['seconds']:11.1f}  {row['limit']}")


if __name__ == "__main__":
    main()
