"""A scene from a seed: a family, then friction, density, gravity, split faces, and the place where statics see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from evidence.fuzz import shapes, stacks
from evidence.fuzz.scene import Place, Scene
from evidence.fuzz.solids import split
from evidence.fuzz.stacks import Parts, Random

FAMILIES: dict[str, Callable[[Random], Parts]] = {
    "piles": stacks.pile,
    "towers": stacks.tower,
    "sizes": stacks.sizes,
    "slivers": stacks.slivers,
    "gaps": stacks.gaps,
    "corbels": stacks.corbels,
    "sheets": stacks.sheets,
    "mid-air supports": stacks.midair,
    "rings": shapes.ring,
    "keystones": shapes.keystone,
    "ladders": shapes.ladder,
    "grooves": shapes.groove,
    "ridges": shapes.ridges,
    "crossed keels": shapes.keels,
    "points": shapes.points,
    "corners": shapes.corner,
    "wedges": shapes.wedge,
    "concave": shapes.concave,
    "heaps": shapes.heap,
}
FRICTION = (0.0, 1e-6, 1e-3, 0.1, 0.3, 0.5, 0.7, 1.0, 3.0, 10.0, np.inf)
LIKELY = (0.06, 0.02, 0.02, 0.1, 0.15, 0.2, 0.2, 0.1, 0.05, 0.05, 0.05)
SLIPPERY = (0.0, 0.1, 0.3, 1.0)
#: Families of which the details are lost in the rounding of coordinates far from the origin.
FINE = ("slivers", "gaps", "sizes")
UTM = np.array([692_000.0, 5_336_000.0, 520.0])


def scene(seed: int, family: str | None = None) -> Scene:
    """The scene of a seed, the families in turn."""
    random = np.random.default_rng(seed)
    name = list(FAMILIES)[seed % len(FAMILIES)] if family is None else family
    solids, support = FAMILIES[name](random)
    if random.random() < 0.3:
        triangles = bool(random.random() < 0.5)
        solids = [split(solid, random, triangles=triangles) for solid in solids]
    down = np.array([0.0, 0.0, -1.0])
    down += random.choice([0.0, 0.0, 0.05, 0.3, 0.7]) * random.uniform(-1, 1, 3) * [1, 1, 0]
    density = 10.0 ** (random.choice([0.0, 0.0, 1.0]) * random.uniform(-1, 1, len(solids)))
    sheets = stacks.thin(solids) if name == "sheets" else ()
    return Scene(
        name, tuple(solids), tuple(map(bool, support)), tuple(density.tolist()),
        float(random.choice(FRICTION, p=LIKELY)), down, place(random, far=name not in FINE), sheets,
        float(random.choice(SLIPPERY)),
    )  # fmt: skip


def place(random: Random, *, far: bool = True) -> Place:
    """Where the statics see a scene."""
    turn = Rotation.random(random_state=int(random.integers(2**31))).as_matrix()
    turn = turn if random.random() < 0.5 else np.eye(3)
    scale = float(10.0 ** random.choice([0.0, 0.0, random.uniform(-3, 3)]))
    shift = UTM * (random.random() < 0.3) * min(1.0, scale) if far else np.zeros(3)
    return Place(turn, scale, shift)


def shuffled(scene: Scene, random: Random) -> Scene:
    """The same blocks in another order."""
    order = tuple(random.permutation(len(scene.solids)).tolist())
    return replace(scene, place=replace(scene.place, order=order))
