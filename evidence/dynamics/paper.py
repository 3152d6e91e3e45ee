"""The paper's experiment: walls of 2, 1 and 0.5 m under a vault, and the buttresses they need by Bullet and by statics.

    python -m evidence.dynamics.paper [--json] [--write] [--seconds 3] [--walls 3] [--figures FILE]

--write makes docs/paper.md and docs/paper.png anew; --figures takes the figures from an earlier --json.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from time import process_time

import msgspec

from blockstat import Assembly, Outcome, assess, build
from blockstat.spec import Building, scene_from
from dynsim import InertiaScale, Settings, verify
from dynsim.bonds.stiffness import AngularSprings
from dynsim.design_search.buttress_loop import buttress_loop
from evidence.dynamics.drops import TIMES, vault_drop, watched
from evidence.paths import DOCS

PAGE = DOCS / "paper.md"
WALLS = (2.0, 1.0, 0.5)  #: [m]
READINGS = {
    "dry, true inertia": (),
    "inertia x 7,000": (InertiaScale(7e3),),
    "inertia x 70,000": (InertiaScale(7e4),),
    "springs of 7,000 N m/rad": (AngularSprings(7e3),),
    "springs of 70,000 N m/rad": (AngularSprings(7e4),),
}
LOOPS = ("dry, true inertia", "inertia x 7,000", "inertia x 70,000")
SIDES = ("south", "north", "west", "east")


def chapel(thickness: float) -> Building:
    """Walls 3 m high of large blocks, 4 m apart, under a barrel 0.3 m thick; buttresses 0.5 m wide and 2 m high."""
    buttress = {"number": 1, "thickness": 0.6, "width": 0.5, "height": 2.0}
    scene = scene_from(
        {
            "name": f"walls of {thickness:g} m", "length": 6.0, "span": 4.0,
            "brick": {"length": 1.5, "height": 0.75}, "wall": {"thickness": thickness, "height": 3.0},
            "vault": {"thickness": 0.3, "voussoirs": 9},
            "material": {"density": 2691.0, "friction": 0.7, "glue": 10.0, "rotational_stiffness": 7000.0},
            "buttresses": {side: buttress for side in SIDES},
        }
    )  # fmt: skip
    assert isinstance(scene, Building)
    return scene


def bare(thickness: float) -> Assembly:
    """The chapel without buttresses."""
    return build(msgspec.structs.replace(chapel(thickness), buttresses={}))


def drop_rows(settings: Settings, walls: Sequence[float]) -> list[dict]:
    """Drop of the vault by Eq. 1 [mm] at `TIMES`, without buttresses."""
    rows = []
    for name in READINGS:
        for thickness in walls:
            asm = bare(thickness)
            print(f"drop: {name}, walls of {thickness:g} m", file=sys.stderr, flush=True)
            begin = process_time()
            fell = vault_drop(watched(asm, settings, READINGS[name]))
            rows.append(
                {
                    "reading": name, "wall": thickness, "blocks": asm.n_blocks,
                    "drop_mm": [1e3 * float(v) for v in fell], "seconds": process_time() - begin,
                }
            )  # fmt: skip
    return rows


def loop_rows(settings: Settings, walls: Sequence[float]) -> list[dict]:
    """The paper's buttress loop for each wall and reading."""
    rows = []
    for name in LOOPS:
        for thickness in walls:
            begin = process_time()
            print(f"{name}, walls of {thickness:g} m", file=sys.stderr, flush=True)
            found = buttress_loop(
                chapel(thickness), lambda asm, name=name: verify(asm, settings=settings, actions=READINGS[name])
            )
            static = assess(build(found.building)).outcome
            rows.append(
                {
                    "reading": name, "wall": thickness, "number": found.steps[-1].number, "sound": found.sound,
                    "runs": len(found.steps), "static": static.word, "seconds": process_time() - begin,
                }
            )  # fmt: skip
    return rows


def static_rows(walls: Sequence[float]) -> list[dict]:
    """The least number of buttresses with which statics find an equilibrium, the same on both springing walls."""
    rows = []
    for thickness in walls:
        least = None
        for number in range(9):
            scene = chapel(thickness)
            some = {
                side: msgspec.structs.replace(spec, number=number)
                for side, spec in scene.buttresses.items()
                if number and side in ("south", "north")
            }
            if assess(build(msgspec.structs.replace(scene, buttresses=some))).outcome is Outcome.STABLE:
                least = number
                break
        rows.append({"wall": thickness, "least": least})
    return rows


def figures(seconds: float, walls: Sequence[float]) -> dict:
    # The paper watches for a given time; with scaled inertia blocks come to rest much later than that.
    fast = Settings.named("fast", end=seconds)
    return {
        "seconds": seconds,
        "blocks": bare(WALLS[0]).n_blocks,
        "static": static_rows(walls),
        "loops": loop_rows(fast, walls),
        "drops": drop_rows(Settings.named("fast"), walls),
        "times": TIMES,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--seconds", type=float, default=3.0, help="simulated at most by the buttress loop")
    parser.add_argument("--walls", type=int, default=len(WALLS), metavar="N", help="the thinnest so many")
    parser.add_argument("--figures", type=Path, help="of an earlier run with --json")
    options = parser.parse_args()
    from evidence.dynamics.paper_page import page, picture

    if options.figures:
        found = json.loads(options.figures.read_text())
    else:
        found = figures(options.seconds, WALLS[-options.walls :])
    print(json.dumps(found, indent=1) if options.json else page(found))
    if options.write:
        PAGE.write_text(page(found))
        picture(found, PAGE.with_suffix(".png"))


if __name__ == "__main__":
    main()
