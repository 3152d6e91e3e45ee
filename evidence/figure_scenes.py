"""The scenes of `evidence.same_figures`: what the suite computes on, and a few dozen more from fixed seeds.

Only the public names of `blockstat` are used. Scenes of the suite come from the examples and the tests of a checkout;
the tests' own modules are loaded from their files, so that no path has to be edited.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

import blockstat

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


def loaded(folder: Path, name: str) -> ModuleType:
    """A module or package from a folder that is on no path."""
    if name not in sys.modules:
        package = folder / name / "__init__.py"
        file = package if package.is_file() else folder / f"{name}.py"
        inside = [str(package.parent)] if package.is_file() else None
        spec = importlib.util.spec_from_file_location(name, file, submodule_search_locations=inside)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


def scenes(checkout: Path) -> Iterator[Scene]:
    """Every scene, those of the cases first, the largest examples last."""
    for file in sorted(cases_folder(checkout).glob("*.json")):
        if file.stem != "expected":
            yield Scene(f"case {file.stem}", lambda file=file: blockstat.read(file))
    problems = loaded(checkout / "tests", "problems")
    for name, make, options in problems.SCENES:
        yield Scene(f"problem {name}", make, options)
    for name, data in problems.FERRIS.items():
        yield Scene(f"wall {name} of Ferris and Tin-Loi", lambda data=data: problems.ferris_wall(data[0]))
    yield from _walls(problems)
    yield from _bonded(problems)
    loaded(checkout / "tests", "hard")
    piles = importlib.import_module("hard.piles")
    for seed in range(200):
        yield Scene(f"pile {seed}", lambda seed=seed: piles.pile(seed), short=seed >= 20)
    for case in importlib.import_module("hard.cases").CASES:
        yield Scene(f"hard {case.family}: {case.name}", case.make, case.options, short=True)
    for name, element in ELEMENTS.items():
        yield Scene(f"element {name}", lambda element=element: of_elements({"own": element}))
    for family, make in FAMILIES.items():
        for seed in range(8):
            yield Scene(f"{family} {seed}", lambda make=make, seed=seed: make(np.random.default_rng(seed)))
    for file in sorted((checkout / "examples").glob("*.toml")):
        yield Scene(f"example {file.stem}", lambda file=file: blockstat.build(blockstat.load_scene(file)))
    yield Scene("chapel of small bricks", small_bricks)


def reference_rows(checkout: Path) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Reference values of the validation with what computes them: name and a function of a value and a bracket."""
    for name in ("problems", "vaults"):
        loaded(checkout / "tests", name)
    for section, module in loaded(checkout / "tests", "references").SECTIONS.items():
        for row in module.ROWS:
            if not row.missing:
                yield f"reference {section}: {row.test} ({row.source})", row.compute


def _walls(problems: ModuleType) -> Iterator[Scene]:
    """A wall of 400 bricks under its weight, pushed out of its plane, along it, and three times over."""
    pushes = {
        "standing": (0.0, 0.0),
        "pushed out": (0.0, 0.25 * 0.2 / 3.5),
        "falling": (0.0, 0.75 * 0.2 / 3.5),
        "along": (0.1, 0.0),
    }
    for name, (x, y) in pushes.items():
        yield Scene(f"wall of 400, {name}", lambda x=x, y=y: problems.running_bond(20, 20, gravity=(x, y, -1.0)))


def _bonded(problems: ModuleType) -> Iterator[Scene]:
    """Joints that carry tension, a cohesion, or a limited pressure."""
    law = blockstat.JointLaw
    laws = {
        "tension and cohesion": law(("*", "*"), tension=0.02, cohesion=0.05),
        "compression": law(("*", "*"), compression=3.0),
        "compression in cells": law(("*", "*"), compression=4.0, cells=4),
    }
    for name, own in laws.items():
        yield Scene(f"arch with {name}", lambda own=own: problems.arch(12, 0.2, joints=[own]))
    yield Scene("glued arch", lambda: blockstat.glued(problems.arch(12, 0.1), 0.2))
    yield Scene(
        "glued wall", lambda: blockstat.glued(problems.running_bond(4, 4, gravity=(0, 0.3, -1)), 0.05, moment=0.01)
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


def arch(rng: np.random.Generator) -> blockstat.Assembly:
    """An arch of 4 to 20 voussoirs about as thick as the least it needs."""
    n, t = int(rng.integers(4, 21)), rng.uniform(0.07, 0.14)
    element = {"kind": "arch", "span": 2 - t, "thickness": t, "depth": rng.uniform(0.2, 0.6), "voussoirs": n}
    return of_elements({"arch": element}, friction=float(rng.uniform(0.3, 0.9)))


def portal(rng: np.random.Generator) -> blockstat.Assembly:
    """An arch on two piers about as wide as they need to be."""
    t, height, width = rng.uniform(0.12, 0.3), rng.uniform(0.4, 2.0), rng.uniform(0.15, 0.7)
    pier = {"kind": "pier", "size": [width, 0.5], "height": height, "courses": int(rng.integers(1, 4))}
    ring = {"kind": "arch", "span": 2.0, "thickness": t, "depth": 0.5, "voussoirs": int(rng.integers(5, 14))}
    return of_elements(
        {
            "arch": {**ring, "at": [0, 0, height]},
            "left": {**pier, "at": [-1 - width / 2, 0, 0]},
            "right": {**pier, "at": [1 + width / 2, 0, 0]},
        }
    )


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
    "arch": arch, "portal": portal, "tilted walls": tilted_walls, "hut": hut,
}  # fmt: skip
