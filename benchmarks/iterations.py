"""How far Bullet's limit of a sliding wall hangs on the iterations of its contact solver.

python benchmarks/iterations.py [--json] [--write FILE]

Four small walls in bond, tilted, are pushed along one of them until blocks slide. Statics give the limit of force
fields and the one without dilatancy and self-stress; between the two, equilibria hang on history.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import results
from families import wall

from blockstat import Assembly, assess, limit_load
from dynsim import Settings, verify

GRAVITY = 9.81
WIDTH = 0.01  #: of a bracket [g]
ITERATIONS = (30, 50, 100, 200, 400)
#: The wall: a seed of `families.wall`.
SEED = (77, 2, 1)


def pushed(asm: Assembly, share: float) -> Assembly:
    return asm.with_(gravity=tuple(np.add(asm.gravity, (share * GRAVITY, 0.0, 0.0))))


def bracket(stands, high: float) -> tuple[float, float]:
    """Largest push seen to stand and smallest seen not to [g]."""
    low = 0.0
    while high - low > WIDTH:
        middle = (low + high) / 2
        low, high = (middle, high) if stands(middle) else (low, middle)
    return low, high


def figures() -> dict:
    asm = wall(np.random.default_rng(SEED))
    fields = limit_load(asm, (1, 0, 0))

    def coulomb(share: float) -> bool:
        return assess(pushed(asm, share), flow="coulomb").outcome.word == "stable"

    found = {}
    for number in ITERATIONS:
        settings = Settings(iterations=number, fine_iterations=max(number, Settings().fine_iterations))

        def rests(share: float, settings: Settings = settings) -> bool:
            return verify(pushed(asm, share), settings=settings).outcome.word == "stands"

        found[number] = bracket(rests, 1.2 * fields.upper)
    return {"fields": (fields.lower, fields.upper), "coulomb": bracket(coulomb, fields.upper), "bullet": found}


def table(found: dict) -> str:
    rows = ["| limit of the push [g] | from | to |", "|---|---|---|"]
    named = {
        "force fields": found["fields"],
        "without dilatancy and self-stress": found["coulomb"],
        **{f"Bullet, {number} iterations": limits for number, limits in found["bullet"].items()},
    }
    return "\n".join([*rows, *(f"| {name} | {low:.3f} | {high:.3f} |" for name, (low, high) in named.items())])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--write", type=Path, help="put the table into this file of docs/results")
    options = parser.parse_args()
    found = figures()
    print(json.dumps(found) if options.json else table(found))
    if options.write:
        results.save(options.write, {"table": table(found)})


if __name__ == "__main__":
    main()
