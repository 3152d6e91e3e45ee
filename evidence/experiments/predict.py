"""Predict the greatest horizontal force of 21 shear walls, before anything is compared with it.

The script reads what a test gives to the statics and none of its results.
"""

from __future__ import annotations

from blockstat import LoadOutcome, limit_load
from evidence import results
from evidence.experiments.walls import ASSUMED, FILE, Wall, walls
from evidence.paths import RESULTS
from evidence.tables import table

FRICTIONS = (0.5, 0.6, 0.7, 0.8)
KINDS = ("associated", "Coulomb", "crushing")


def forces(wall: Wall, friction: float) -> tuple[float, float, float]:
    """Greatest horizontal force [kN]: associated, without dilatancy, and associated with joints that crush."""
    found = []
    for crushing, flow in ((False, "coulomb"), (True, "associated")):
        assembly = wall.blocks(friction, crushing=crushing)
        limit = limit_load(assembly, wall.push(assembly), flow=flow)
        if limit.outcome is not LoadOutcome.LIMIT:
            raise AssertionError(f"{wall.name}, friction {friction}: {limit.outcome.value}")
        found.append(limit)
    plain, crushed = found
    assert plain.coulomb is not None
    return plain.lower, plain.coulomb[0], crushed.lower


def predictions() -> dict[str, dict[tuple[str, float], float]]:
    """Forces that were written [kN], by wall, then by kind and friction."""
    _, parts = results.load(RESULTS / "experiments.md")
    heads, _, *rows = parts["predictions"].splitlines()
    columns = [tuple(name.strip().rsplit(" ", 1)) for name in heads.strip("|").split("|")[1:]]
    found = {}
    for line in rows:
        name, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        found[name] = {(kind, float(mu)): float(cell) for (kind, mu), cell in zip(columns, cells, strict=True)}
    return found


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--walls", type=int, metavar="N", help="so many alone, the first of the folder")
    options = parser.parse_args()
    if not FILE.is_file():
        raise SystemExit(f"no file {FILE}; set BLOCKSTAT_EXPERIMENTS to the directory of the experiments")
    rows = []
    for wall in walls()[: options.walls]:
        by_friction = [forces(wall, friction) for friction in FRICTIONS]
        rows.append([wall.name, *(f"{found[kind]:.3f}" for kind in range(len(KINDS)) for found in by_friction)])
    heads = ["wall", *(f"{kind} {friction:g}" for kind in KINDS for friction in FRICTIONS)]
    assumed = "\n".join(f"{number}. {text}" for number, text in enumerate(ASSUMED, 1))
    results.report(options, rows, {"assumptions": assumed, "predictions": table(heads, rows)})


if __name__ == "__main__":
    main()
