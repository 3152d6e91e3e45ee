"""The scenes of `evidence.same_figures`: what the suite computes on, and a few dozen more from fixed seeds.

Only public names of `blockstat` are used, here and in the modules that build the scenes, so the same scenes can be
computed by an earlier source. The files of the examples are those of a checkout.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import blockstat
from evidence.hard.cases import CASES
from evidence.hard.piles import pile
from evidence.references import SECTIONS
from evidence.scenes import families, small

Make = Callable[[], blockstat.Assembly]


@dataclass(frozen=True)
class Scene:
    """One assembly to compute on."""

    name: str
    make: Make
    options: dict[str, Any] = field(default_factory=dict)  #: of `assess`
    short: bool = False  #: verdicts only


def cases_folder(checkout: Path) -> Path:
    """Where the assemblies of other projects are, as the tests find them. Stops where they are absent."""
    folder = Path(os.environ.get("BLOCKSTAT_CASES", checkout.parent / "shared" / "cases"))
    if not folder.is_dir():
        raise SystemExit(f"no directory {folder}; set BLOCKSTAT_CASES to the one of the cases")
    return folder


def scenes(checkout: Path) -> Iterator[Scene]:
    """Every scene, those of the cases first, the largest examples last."""
    for file in sorted(cases_folder(checkout).glob("*.json")):
        if file.stem != "expected":
            yield Scene(f"case {file.stem}", lambda file=file: blockstat.read(file))
    for name, make, options in small.SCENES:
        yield Scene(f"problem {name}", make, options)
    for name, data in small.FERRIS.items():
        yield Scene(f"wall {name} of Ferris and Tin-Loi", lambda data=data: small.ferris_wall(data[0]))
    yield from _walls()
    yield from _bonded()
    for seed in range(200):
        yield Scene(f"pile {seed}", lambda seed=seed: pile(seed), short=seed >= 20)
    for case in CASES:
        yield Scene(f"hard {case.family}: {case.name}", case.make, case.options, short=True)
    for name, element in ELEMENTS.items():
        yield Scene(f"element {name}", lambda element=element: of_elements({"own": element}))
    for family, make in FAMILIES.items():
        for seed in range(8):
            yield Scene(f"{family} {seed}", lambda make=make, seed=seed: make(np.random.default_rng(seed)))
    for file in sorted((checkout / "examples").glob("*.toml")):
        yield Scene(f"example {file.stem}", lambda file=file: blockstat.build(blockstat.load_scene(file)))
    yield Scene("chapel of small bricks", small_bricks)


def reference_rows() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Reference values of the validation with what computes them: name and a function of a value and a bracket."""
    for section, module in SECTIONS.items():
        for row in module.ROWS:
            if not row.missing:
                yield f"reference {section}: {row.test} ({row.source})", row.compute


def _walls() -> Iterator[Scene]:
    """A wall of 400 bricks under its weight, pushed out of its plane, along it, and three times over."""
    pushes = {
        "standing": (0.0, 0.0),
        "pushed out": (0.0, 0.25 * 0.2 / 3.5),
        "falling": (0.0, 0.75 * 0.2 / 3.5),
        "along": (0.1, 0.0),
    }
    for name, (x, y) in pushes.items():
        yield Scene(f"wall of 400, {name}", lambda x=x, y=y: small.running_bond(20, 20, gravity=(x, y, -1.0)))


def _bonded() -> Iterator[Scene]:
    """Joints that carry tension, a cohesion, or a limited pressure."""
    law = blockstat.JointLaw
    laws = {
        "tension and cohesion": law(("*", "*"), tension=0.02, cohesion=0.05),
        "compression": law(("*", "*"), compression=3.0),
        "compression in cells": law(("*", "*"), compression=4.0, cells=4),
    }
    for name, own in laws.items():
        yield Scene(f"arch with {name}", lambda own=own: small.arch(12, 0.2, joints=[own]))
    yield Scene("glued arch", lambda: blockstat.glued(small.arch(12, 0.1), 0.2))
    yield Scene(
        "glued wall", lambda: blockstat.glued(small.running_bond(4, 4, gravity=(0, 0.3, -1)), 0.05, moment=0.01)
    )


def of_elements(elements: dict[str, Any], friction: float = 0.7) -> blockstat.Assembly:
    scene = {"name": "elements", "elements": elements, "material": {"friction": friction}}
    return blockstat.build(blockstat.scene_from(scene))


#: One of each kind of element, by the keys of a scene's file.
ELEMENTS: dict[str, dict[str, Any]] = {
    "column": {"kind": "column", "diameter": 0.6, "height": 3.0, "drums": 4, "top": 0.5},
    "pier": {"kind": "pier", "size": [0.6, 0.8], "height": 2.0, "courses": 5, "bond": "halves"},
    "pointed arch": {
        "kind": "arch", "shape": "pointed", "span": 2.0, "rise": 1.4, "thickness": 0.3, "depth": 0.5, "voussoirs": 12,
        "springers": 0.3, "at": [0, 0, 0.3],
    },
    "jack arch": {
        "kind": "jack_arch", "span": 1.2, "thickness": 0.5, "depth": 0.3, "voussoirs": 7, "springers": 0.3,
        "at": [0, 0, 0.3],
    },
    "barrel": {
        "kind": "barrel", "span": 4.0, "length": 5.0, "thickness": 0.5, "brick": 0.6, "voussoirs": 15, "springers": 0.5,
        "at": [0, 0, 0.5],
    },
    "groin": {
        "kind": "groin", "spans": [3.0, 3.0], "thickness": 0.4, "voussoirs": 9, "brick": 0.8, "springers": 0.4,
        "at": [0, 0, 0.4],
    },
    "pavilion": {
        "kind": "pavilion", "spans": [3.0, 2.5], "thickness": 0.3, "voussoirs": 9, "brick": 0.7, "springers": 0.3,
        "at": [0, 0, 0.3],
    },
    "dome": {
        "kind": "dome", "span": 5.0, "thickness": 0.2, "rings": 8, "voussoirs": 20, "oculus": 1.0, "springers": 0.4,
        "at": [0, 0, 0.4],
    },
    "walls": {
        "kind": "walls", "brick": [0.5, 0.25],
        "runs": {
            "front": {
                "path": [[0, 0], [4, 0]], "thickness": 0.4, "height": 2.0,
                "openings": [{"width": 0.8, "height": 0.5, "sill": 0.5, "head": "semicircular"}],
            },
            "side": {"path": [[4, 0], [4, 3]], "thickness": 0.4, "height": 2.0},
        },
        "buttresses": [{"wall": "side", "width": 0.5, "projection": 0.6, "height": 1.5}],
    },
    "arc wall": {"kind": "arc_wall", "radius": 2.0, "start": 0, "end": 180, "thickness": 0.4, "height": 1.5},
}  # fmt: skip


def small_bricks() -> blockstat.Assembly:
    """The chapel of the examples in bricks half as long and high, and more voussoirs."""
    window = {"number": 2, "width": 0.6, "height": 0.8, "sill": 0.8}
    buttress = {"number": 1, "thickness": 0.6, "width": 0.6, "height": 1.6}
    scene = {
        "name": "chapel", "length": 5.4, "span": 3.6,
        "brick": {"length": 0.45, "height": 0.2}, "wall": {"thickness": 0.8, "height": 2.4},
        "doors": {"west": {"width": 1.1, "height": 1.6}}, "windows": {"south": window, "north": window},
        "vault": {"thickness": 0.35, "voussoirs": 21}, "buttresses": {"south": buttress, "north": buttress},
        "material": {"density": 2691.0, "friction": 0.7},
    }  # fmt: skip
    return blockstat.build(blockstat.scene_from(scene))


def tilted_walls(rng: np.random.Generator) -> blockstat.Assembly:
    """Four small walls without a roof on ground that is tilted a good deal."""
    scene = {
        "name": "walls", "length": rng.uniform(1.5, 2.5), "span": rng.uniform(0.8, 1.5), "vault": None,
        "brick": {"length": 0.6, "height": 0.3},
        "wall": {"thickness": rng.uniform(0.15, 0.5), "height": rng.uniform(0.6, 1.5)},
    }  # fmt: skip
    angle, side = np.radians(rng.uniform(8.0, 40.0)), rng.uniform(0.0, 2 * np.pi)
    pull = 9.81 * np.array([np.sin(angle) * np.cos(side), np.sin(angle) * np.sin(side), -np.cos(angle)])
    return blockstat.build(blockstat.scene_from(scene)).with_(gravity=tuple(pull))


def hut(rng: np.random.Generator) -> blockstat.Assembly:
    """Four walls with a door, buttresses and a barrel vault, some sixty blocks."""
    scene = {
        "name": "hut", "length": rng.uniform(2.2, 3.0), "span": rng.uniform(1.5, 3.5),
        "brick": {"length": 0.8, "height": float(rng.choice([0.4, 0.5]))},
        "wall": {"thickness": rng.uniform(0.2, 0.6), "height": rng.uniform(1.6, 2.2)},
        "doors": {"south": {"width": 0.6, "height": 0.8}},
        "buttresses": {"north": {"number": 1, "thickness": 0.4, "width": 0.5, "height": 1.0}},
        "vault": {"thickness": rng.uniform(0.1, 0.35), "voussoirs": int(rng.integers(5, 12))},
        "material": {"friction": float(rng.choice([0.5, 0.7]))},
    }  # fmt: skip
    return blockstat.build(blockstat.scene_from(scene))


FAMILIES: dict[str, Callable[[np.random.Generator], blockstat.Assembly]] = {
    "arch": families.arch, "portal": families.portal, "tilted walls": tilted_walls, "hut": hut,
}  # fmt: skip
