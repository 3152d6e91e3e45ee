"""How far Bullet's limit of a sliding wall hangs on the iterations of its contact solver.

    python -m evidence.dynamics.iterations [--json] [--write FILE]

Four small walls in bond, tilted, are pushed along one of them until blocks slide. Statics give the limit of force
fields and the one without dilatancy and self-stress; between the two, equilibria hang on history.
"""

from __future__ import annotations

import numpy as np

from blockstat import Assembly, assess, limit_load
from dynsim import Settings, verify
from evidence import results
from evidence.bisection import bisect
from evidence.scenes.families import wall
from evidence.tables import table

GRAVITY = 9.81
WIDTH = 0.01  #: of a bracket [g]
ITERATIONS = (30, 50, 100, 200, 400)
#: The wall: a seed of `families.wall`.
SEED = (77, 2, 1)


def pushed(asm: Assembly, share: float) -> Assembly:
    return asm.with_(gravity=tuple(np.add(asm.gravity, (share * GRAVITY, 0.0, 0.0))))


def figures() -> dict:
    """Pushes seen to stand and seen not to [g], by the way they are judged."""
    asm = wall(np.random.default_rng(SEED))
    fields = limit_load(asm, (1, 0, 0))

    def coulomb(share: float) -> bool:
        return assess(pushed(asm, share), flow="coulomb").outcome.word == "stable"

    found = {}
    for number in ITERATIONS:
        settings = Settings(iterations=number, fine_iterations=max(number, Settings().fine_iterations))

        def rests(share: float, settings: Settings = settings) -> bool:
            return verify(pushed(asm, share), settings=settings).outcome.word == "stands"

        found[number] = bisect(rests, 0.0, 1.2 * fields.upper, WIDTH)
    return {
        "fields": (fields.lower, fields.upper),
        "coulomb": bisect(coulomb, 0.0, fields.upper, WIDTH),
        "bullet": found,
    }


def brackets(found: dict) -> str:
    named = {
        "force fields": found["fields"],
        "without dilatancy and self-stress": found["coulomb"],
        **{f"Bullet, {number} iterations": limits for number, limits in found["bullet"].items()},
    }
    rows = ([name, f"{low:.3f}", f"{high:.3f}"] for name, (low, high) in named.items())
    return table(["limit of the push [g]", "from", "to"], rows)


def main() -> None:
    options = results.parser(__doc__).parse_args()
    found = figures()
    results.report(options, found, {"table": brackets(found)})


if __name__ == "__main__":
    main()
