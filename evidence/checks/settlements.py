"""Arches on a support that moves outwards until they fall: statics at finite displacement beside Bullet.

    python -m evidence.checks.settlements [--speed V] [--json] [--write FILE]

In Bullet the right springer moves at a constant speed. The arch counts as falling where its crown is lower by a tenth
than at the end of the path of statics. By then it has been falling for a while, during which the support moves on. So a
fast support overstates the movement; a slow one gives the contacts time to creep.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from time import process_time

import numpy as np

from blockstat import settle_to_collapse
from dynsim import Settlement, simulate
from evidence import results
from evidence.scenes.small import arch
from evidence.tables import table

#: Voussoirs and thickness of semicircular arches of radius 1 m.
ARCHES = ((10, 0.15), (20, 0.15), (20, 0.20))
FRICTION, GRAVITY = 0.7, (0.0, 0.0, -9.81)
#: Parts of the movement at collapse where the crowns are compared.
PARTS = (0.25, 0.5, 0.75, 0.9)


@dataclass(frozen=True)
class Row:
    """One arch."""

    voussoirs: int
    thickness: float
    collapse: float  #: movement at which statics has the arch fall [m]
    falls: float  #: where it falls in Bullet [m]
    crown: tuple[float, ...]  #: how far it has sunk in Bullet over how far in statics, at each of `PARTS`
    seconds: float  #: process time of Bullet


def row(voussoirs: int, thickness: float, speed: float) -> Row:
    """Statics and Bullet of one arch, whose right springer moves at a speed [m/s]."""
    ring = arch(voussoirs, thickness, friction=FRICTION, gravity=GRAVITY)
    crown = int(np.argmax(np.where(ring.support, -np.inf, ring.centroid[:, 2])))
    path = settle_to_collapse(ring, {"right": (1, 0, 0)})
    sunk = [-pose.displacement[crown, 2] for pose in path.poses]
    assert path.collapse is not None
    move = Settlement("right", path=(1.2 * path.collapse, 0, 0), speed=speed)
    begin = process_time()
    run = simulate(ring, loads=[move], hold=move.end, stop=lambda _, moved, __: np.abs(moved).max() > 3 * sunk[-1])
    seconds = process_time() - begin
    seen = -run.since_release[:, crown, 2]
    moved = np.clip(run.times[-len(seen) :] * speed, 0, None)
    fallen = np.flatnonzero(seen > 1.1 * sunk[-1])
    at = np.array(PARTS) * path.collapse
    ratio = np.interp(at, moved, seen) / np.interp(at, path.displacement, sunk)
    falls = float(moved[fallen[0]]) if len(fallen) else np.inf
    return Row(voussoirs, thickness, path.collapse, falls, tuple(map(float, ratio)), seconds)


def main() -> None:
    """Print and write the table."""
    parser = results.parser(__doc__)
    parser.add_argument("--speed", type=float, default=0.005, metavar="V", help="of the support [m/s]")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = [row(*shape, options.speed) for shape in ARCHES]
    bullet = f"Bullet, at {1e3 * options.speed:g} mm/s"
    head = ["voussoirs, t / R", "statics: falls at [mm]", bullet, "ratio", "crown sunk, Bullet / statics", "seconds"]
    cells = [
        [f"{one.voussoirs}, {one.thickness}", f"{1e3 * one.collapse:.1f}", f"{1e3 * one.falls:.1f}",
         f"{one.falls / one.collapse:.3f}", ", ".join(f"{part:.3f}" for part in one.crown), f"{one.seconds:.0f}"]
        for one in rows
    ]  # fmt: skip
    results.report(options, [one.__dict__ for one in rows], {"arches": table(head, cells)})


if __name__ == "__main__":
    main()
