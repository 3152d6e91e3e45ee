"""How exact, for how long: the tables of docs/choosing.md and its picture.

    python -m evidence.choosing.page [--only limits curves runs draws] [--steps N] [--draws N]
        [--tolerance T] [--within SHARE] [--json] [--write docs/results/choosing.md]

Seconds are process time. `--write` takes all four parts, and draws docs/choosing.png.
"""

from __future__ import annotations

import sys
from dataclasses import asdict
from functools import partial
from typing import Any

from evidence.choosing import curves, draws, limits, runs
from evidence.choosing.picture import TITLES, draw
from evidence.paths import DOCS
from evidence.plotting import save
from evidence.results import parser, report


def parts_of(found: dict[str, Any]) -> dict[str, str]:
    """Tables and advice of what was measured."""
    parts: dict[str, str] = {}
    if "limits" in found:
        parts["limits"] = limits.rows_table(found["limits"])
        parts["limits-advice"] = limits.advice(found["limits"])
    if "curves" in found:
        linkages, walls = found["curves"]
        parts["linkages"], parts["walls"] = curves.linkages_table(linkages), curves.walls_table(walls)
        parts["curves-advice"] = curves.advice(linkages, walls)
    if "runs" in found:
        parts["runs"], parts["runs-advice"] = runs.rows_table(found["runs"]), runs.advice(found["runs"])
    if "draws" in found:
        parts["draws"], parts["draws-advice"] = draws.rows_table(*found["draws"]), draws.advice(*found["draws"])
    return parts


def figures_of(found: dict[str, Any]) -> dict[str, Any]:
    """What was measured, as plain values."""
    linkages, walls = found.get("curves", ((), ()))
    samples, first = found.get("draws", ((), None))
    rows = {"limits": found.get("limits", ()), "linkages": linkages, "walls": walls, "runs": found.get("runs", ())}
    figures: dict[str, Any] = {name: [asdict(row) for row in own] for name, own in (rows | {"draws": samples}).items()}
    return figures | ({} if first is None else {"first_order": asdict(first)})


def main() -> None:
    """Measure, print, and write what the options ask."""
    options = parser(__doc__)
    options.add_argument("--only", nargs="+", choices=list(TITLES), default=list(TITLES))
    options.add_argument("--steps", type=int, default=max(curves.STEPS), metavar="N", help="of the walls, at most")
    options.add_argument("--draws", type=int, default=max(draws.DRAWS), metavar="N", help="at most")
    options.add_argument("--tolerance", type=float, default=min(limits.TOLERANCES), metavar="T", help="at least")
    options.add_argument("--within", type=float, default=runs.WITHIN, metavar="SHARE", help="of the limits in Bullet")
    chosen = options.parse_args()
    if chosen.write and set(chosen.only) != set(TITLES):
        options.error("--write takes all parts; leave --only out")
    measure = {
        "limits": partial(limits.measured, chosen.tolerance),
        "curves": partial(curves.measured, chosen.steps),
        "runs": partial(runs.measured, chosen.within),
        "draws": partial(draws.measured, chosen.draws),
    }
    found: dict[str, Any] = {}
    for name in chosen.only:
        print(name, file=sys.stderr, flush=True)
        found[name] = measure[name]()
    report(chosen, figures_of(found), parts_of(found))
    if chosen.write:
        figure = draw(found["limits"], found["curves"], found["runs"], found["draws"][0])
        save(figure, DOCS / "choosing.png")


if __name__ == "__main__":
    main()
