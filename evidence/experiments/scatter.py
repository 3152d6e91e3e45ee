"""Intervals predicted with one imperfection, the same for all: joints lose up to a tenth of their width at each edge.

    python -m evidence.experiments.scatter [--write docs/results/scatter.md]

Less of a joint and less friction carry less, so the ends of an interval are two limit loads. Where friction was not
measured it is .5 to .8.
"""

from __future__ import annotations

import math
from typing import Any

from blockstat import Imperfections, limit_load, tilt_limit
from evidence import results
from evidence.experiments.compare import measured
from evidence.experiments.predict import FRICTIONS
from evidence.experiments.walls import FILE, Wall, tests, walls
from evidence.scenes.small import arch
from evidence.tables import table

LOST = Imperfections(edge="10 %")
#: Shin et al. 2016: an arch of 36 voussoirs, .15 of its radius thick, friction 43 degrees, fell at 4.7 +- .2 degrees.
ARCH, TILT, SPREAD = arch(36, 0.15, friction=math.tan(math.radians(43))), 4.7, 0.2


def tilted() -> tuple[float, float]:
    """Tilts [degrees] of the arch with all of the imperfection and with none of it."""
    return tilt_limit(ARCH, "y", imperfections=LOST).stands, tilt_limit(ARCH, "y").stands


def pushed(wall: Wall) -> tuple[float, float]:
    """Forces [kN] with all of the imperfection and the least friction, and with none of it and the most."""
    worst, best = (wall.blocks(friction) for friction in (FRICTIONS[0], FRICTIONS[-1]))
    return limit_load(worst, wall.push(worst), imperfections=LOST).lower, limit_load(best, wall.push(best)).lower


def where(value: float, low: float, high: float) -> str:
    """Where a measured value lies."""
    if low <= value <= high:
        return "inside"
    return f"{100 * (1 - value / low):.1f} % below" if value < low else f"{100 * (value / high - 1):.1f} % above"


def rows() -> list[list[Any]]:
    """The arch and all walls: what is predicted, what was measured, and where it lies."""
    low, high = tilted()
    found = [["arch, tilt [degrees]", "-", f"{low:.2f} to {high:.2f}", f"{TILT} ± {SPREAD}", where(TILT, low, high)]]
    known: dict[Any, tuple[float, float]] = {}
    for wall, test in zip(walls(), tests(), strict=True):
        key = (wall.series, wall.length, wall.height, wall.axial, wall.shear_span)
        if key not in known:
            known[key] = pushed(wall)
        low, high = known[key]
        peaks = measured(test)
        said = " / ".join(where(peak, low, high) for peak in peaks)
        forces = " / ".join(f"{peak:g}" for peak in peaks)
        found.append([f"{wall.name} [kN]", f"{wall.axial / 1e3:g}", f"{low:.1f} to {high:.1f}", forces, said])
    return found


def counted(found: list[list[Any]]) -> str:
    """How many measured values lie inside, by series."""
    lines = []
    for series, name in (("WS", "granite"), ("SW", "sandstone")):
        places = [place for row in found if row[0].startswith(series) for place in row[-1].split(" / ")]
        below, above = (sum(place.endswith(word) for place in places) for word in ("below", "above"))
        inside = f"{places.count('inside')} of {len(places)} forces inside"
        lines.append(f"- Walls of {name}: {inside}, {below} below and {above} above.")
    return "\n".join(lines)


def main() -> None:
    options = results.parser(__doc__).parse_args()
    if not FILE.is_file():
        raise SystemExit(f"no file {FILE}; set BLOCKSTAT_EXPERIMENTS to the directory of the experiments")
    found = rows()
    heads = ("test", "axial [kN]", "predicted", "measured", "where")
    results.report(options, found, {"intervals": table(heads, found), "counted": counted(found)})


if __name__ == "__main__":
    main()
