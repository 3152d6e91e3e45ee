"""Scenes of any size for the benchmarks: walls, a barrel vault, a chapel.

Only the wall pushed along itself is prismatic under its load, so only it can be solved in a plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import msgspec
import numpy as np

from blockstat import Assembly, Block, build, load_scene
from blockstat.model import barrel_vault, moved
from blockstat.model.solids import box
from blockstat.model.walling.pattern import plain_row
from blockstat.spec import Brick, Building, Vault, value_of
from evidence.paths import EXAMPLES

BRICK = (0.4, 0.2, 0.175)  #: length, depth and height of a brick of the wall [m]


def wall(blocks: int) -> Assembly:
    """A free-standing running-bond wall of about that many bricks on a fixed slab, as many courses as bricks."""
    side = max(round(np.sqrt(blocks)), 2)
    length, depth, height = BRICK
    row = (side - 0.5) * length
    bricks: list[Block] = [box((-1, -1, -0.2), (row + 1, depth + 1, 0), name="ground", group="ground")]
    cuts = [ends.tolist() for ends in plain_row(row, length)]
    for course in range(side):
        z, ends = course * height, cuts[course % 2]
        for i, (a, b) in enumerate(zip(ends, ends[1:], strict=False)):
            bricks.append(box((a, 0, z), (b, depth, z + height), name=f"{course}.{i}", group="wall"))
    return Assembly.from_blocks(bricks, supports=[0], name=f"wall of {blocks}")


def pushed_wall(blocks: int, share: float = 0.25) -> Assembly:
    """The wall under an acceleration out of its plane, a share of the one that tips it (depth / height)."""
    asm = wall(blocks)
    height = asm.vertices[:, 2].max()
    return asm.with_(gravity=(0.0, share * 9.81 * BRICK[1] / height, -9.81))


def wall_along(blocks: int) -> Assembly:
    """The wall under an acceleration of a tenth of gravity along itself."""
    return wall(blocks).with_(gravity=(0.981, 0.0, -9.81))


def falling_wall(blocks: int) -> Assembly:
    """The wall under three times the acceleration that tips it."""
    return pushed_wall(blocks, share=3.0)


def vault(blocks: int) -> Assembly:
    """A semicircular barrel of about that many voussoirs in bonded courses on two fixed springers."""
    courses = max(round(0.6 * np.sqrt(blocks)), 5)
    row = max(round(blocks / courses), 2)
    span, thickness = 4.0, 0.5
    brick = 1.5 * np.pi * (span + thickness) / 2 / courses  # half as long again as it is wide
    length = (row - 0.5) * brick
    barrel = barrel_vault(span=span, length=length, thickness=thickness, brick=brick, voussoirs=courses)
    voussoirs = moved(barrel, (length / 2, span / 2, 0.0))
    springers = [
        box((-0.5, y, -0.5), (length + 0.5, y + thickness, 0.0), name=f"springer.{k}", group="springer")
        for k, y in enumerate((-thickness, span))
    ]
    return Assembly.from_blocks([*springers, *voussoirs], supports=[0, 1], name=f"vault of {blocks}")


def chapel(blocks: int) -> Assembly:
    """The chapel of the examples in about that many blocks: smaller bricks, more and smaller voussoirs."""
    return build(chapel_scene(blocks))


def chapel_scene(blocks: int) -> Building:
    """The scene of `chapel`."""
    scene = load_scene(EXAMPLES / "chapel.toml")
    assert scene.vault is not None
    length, height = value_of(scene.brick.length), value_of(scene.brick.height)
    finer = 1.0
    found = scene
    for _ in range(4):
        # Openings and whole courses spoil the square root a little.
        finer *= math.sqrt(blocks / build(found).n_blocks)
        found = _finer(scene, length / finer, height / finer, round(value_of(scene.vault.voussoirs) * finer))
    return found


def _finer(scene: Building, length: float, height: float, voussoirs: int) -> Building:
    assert scene.vault is not None
    ring = Vault(thickness=scene.vault.thickness, voussoirs=max(voussoirs, 3))
    return msgspec.structs.replace(scene, brick=Brick(length=length, height=height), vault=ring)


SCENES: dict[str, Callable[[int], Assembly]] = {
    "wall": pushed_wall,
    "along": wall_along,
    "vault": vault,
    "chapel": chapel,
    "falling": falling_wall,
}
