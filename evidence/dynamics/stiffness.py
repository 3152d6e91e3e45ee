"""What rotational stiffness does to a vault on walls: drop by Eq. 1 against simulated time.

    python -m evidence.dynamics.stiffness [--json] [--write FILE]

The walls are 0.5, 1 and 2 m thick; statics, which see no inertia, hold only the last. The inertia of every block is
scaled, or every joint has an angular spring.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from time import process_time

import numpy as np

from blockstat import Assembly, assess, limit_load
from dynsim import Action, AngularSprings, InertiaScale, Settings
from evidence import results
from evidence.dynamics.drops import TIMES, vault_drop, watched
from evidence.scenes.small import assembly, box, slice_
from evidence.tables import table

WALLS = (0.5, 1.0, 2.0)  #: [m]
#: A reading and its value: dimensionless, or N m/rad.
READINGS = (
    ("inertia", 1.0), ("inertia", 7e3), ("inertia", 7e4), ("springs", 7e3), ("springs", 7e4), ("springs", 7e6),
)  # fmt: skip


def vault_on_walls(wall: float) -> Assembly:
    """A barrel 1 m long, 0.5 m thick, of 8 m span in 21 courses, on two walls 5 m high in 10 courses."""
    inner, thickness, height, courses, voussoirs = 3.75, 0.5, 5.0, 10, 21
    blocks = [box((-9, 0, -1), (9, 1, 0), name="ground")]
    for side, name in ((-1, "left"), (1, "right")):
        low, high = sorted((side * inner, side * (inner + wall)))
        levels = np.linspace(0, height, courses + 1)
        blocks += [
            box((low, 0, a), (high, 1, b), name=f"{name}{k}", group=f"wall.{name}")
            for k, (a, b) in enumerate(zip(levels[:-1], levels[1:], strict=True))
        ]

    def joint(angle: float) -> list[tuple[float, float]]:
        return [(r * math.cos(angle), r * math.sin(angle) + height) for r in (inner, inner + thickness)]

    angles = np.linspace(math.pi, 0, voussoirs + 1)
    blocks += [
        slice_([*joint(a)[::-1], *joint(b)], 1.0, name=f"voussoir{k}", group="vault")
        for k, (a, b) in enumerate(zip(angles[:-1], angles[1:], strict=True))
    ]
    return assembly(blocks, density=2691.0, gravity=(0, 0, -9.81), friction=0.7)


def rows(walls: Sequence[float]) -> list[dict]:
    found = []
    for wall in walls:
        asm = vault_on_walls(wall)
        verdict = assess(asm)
        push = limit_load(asm, (1, 0, 0)).lower if verdict.outcome.word == "stable" else None
        for reading, value in READINGS:
            begin = process_time()
            actions: list[Action] = [InertiaScale(value) if reading == "inertia" else AngularSprings(value)]
            values = vault_drop(watched(asm, Settings(), [] if value == 1.0 else actions))
            found.append(
                {
                    "wall": wall, "static": verdict.outcome.word, "push": push, "blocks": asm.n_blocks,
                    "reading": reading, "value": value, "drop_mm": [1e3 * float(v) for v in values],
                    "process_seconds": process_time() - begin,
                }
            )  # fmt: skip
    return found


def parts(found: list[dict]) -> dict[str, str]:
    """What statics say of each wall, and the drops in mm."""
    statics = []
    for wall in dict.fromkeys(row["wall"] for row in found):
        first = next(row for row in found if row["wall"] == wall)
        push = "" if first["push"] is None else f", up to a push of {first['push']:.3f} of the weight"
        statics.append(f"- walls of {wall:g} m, {first['blocks']} blocks: {first['static']} by statics{push}")
    drops = []
    for reading, value in READINGS:
        for row in found:
            if (row["reading"], row["value"]) == (reading, value):
                name = f"inertia x {value:,.0f}" if reading == "inertia" else f"springs of {value:,.0f} N m/rad"
                cells = (f"{round(v)}" if v < 5000 else "fallen" for v in row["drop_mm"])
                drops.append([name, f"{row['wall']:g} m", *cells])
    heads = ["reading", "walls", *(f"{t:g} s" for t in TIMES)]
    return {"statics": "\n".join(statics), "drops": table(heads, drops)}


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--walls", type=int, metavar="N", help="so many of the three alone")
    options = parser.parse_args()
    found = rows(WALLS[: options.walls])
    results.report(options, {"times": TIMES, "rows": found}, parts(found))


if __name__ == "__main__":
    main()
