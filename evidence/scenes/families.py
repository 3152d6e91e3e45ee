"""Random assemblies on both sides of their limits, small enough to be simulated in seconds.

Each family takes a generator of random numbers and builds one assembly; it may raise InputError for numbers that make
no building.
"""

from __future__ import annotations

import numpy as np
import shapely

from blockstat import Assembly, Block, box, build, scene_from
from evidence.fuzz import shapes
from evidence.fuzz.solids import extruded

Random = np.random.Generator


def arch(rng: Random) -> Assembly:
    """An arch of 4 to 20 voussoirs about as thick as the least it needs."""
    n, t = int(rng.integers(4, 21)), rng.uniform(0.07, 0.14)
    element = {"kind": "arch", "span": 2 - t, "thickness": t, "depth": rng.uniform(0.2, 0.6), "voussoirs": n}
    friction = float(rng.uniform(0.3, 0.9))
    return build(scene_from({"name": "arch", "elements": {"arch": element}, "material": {"friction": friction}}))


def portal(rng: Random) -> Assembly:
    """An arch on two piers about as wide as they need to be."""
    t, height, width = rng.uniform(0.12, 0.3), rng.uniform(0.4, 2.0), rng.uniform(0.15, 0.7)
    pier = {"kind": "pier", "size": [width, 0.5], "height": height, "courses": int(rng.integers(1, 4))}
    elements = {
        "arch": {
            "kind": "arch", "span": 2.0, "thickness": t, "depth": 0.5, "voussoirs": int(rng.integers(5, 14)),
            "at": [0, 0, height],
        },
        "left": {**pier, "at": [-1 - width / 2, 0, 0]},
        "right": {**pier, "at": [1 + width / 2, 0, 0]},
    }  # fmt: skip
    return build(scene_from({"name": "portal", "elements": elements}))


def wall(rng: Random) -> Assembly:
    """Four small walls without a roof on ground that is tilted a good deal."""
    thickness = rng.uniform(0.15, 0.5)
    scene = {
        "name": "walls", "length": rng.uniform(1.5, 2.5), "span": rng.uniform(0.8, 1.5), "vault": None,
        "brick": {"length": 0.6, "height": 0.3}, "wall": {"thickness": thickness, "height": rng.uniform(0.6, 1.5)},
    }  # fmt: skip
    return tilted(build(scene_from(scene)), rng)


def rubble(rng: Random) -> Assembly:
    """A wall of irregular stones, the cells of random points in its plane, on ground that is tilted a good deal."""
    columns, rows, depth = int(rng.integers(2, 6)), int(rng.integers(2, 6)), rng.uniform(0.15, 0.6)
    grid = np.stack(np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5), axis=-1).reshape(-1, 2)
    points = (grid + rng.uniform(-0.35, 0.35, grid.shape)) * [0.4, 0.3]
    outline = shapely.box(0, 0, 0.4 * columns, 0.3 * rows)
    cells = shapely.voronoi_polygons(shapely.MultiPoint(points), extend_to=outline.buffer(1))
    flat = [shapely.get_coordinates(cell.intersection(outline).normalize())[:-1][::-1] for cell in cells.geoms]
    stones = [extruded([polygon], 0.0, depth) for polygon in flat]
    blocks = [Block(stone.vertices, stone.faces) for stone in stones]
    ground = box((-1, -1, -0.5), (0.4 * columns + 1, depth + 1, 0), name="ground")
    return tilted(
        Assembly.from_blocks([ground, *blocks], supports=["ground"], friction=float(rng.uniform(0.4, 0.8))), rng
    )


def heap(rng: Random) -> Assembly:
    """Convex blocks of four to eight corners that were let down one on the other, on edges and corners too."""
    parts, support = shapes.heap(rng)
    blocks = [Block(part.vertices, part.faces) for part in parts]
    return Assembly.from_blocks(
        blocks, supports=np.flatnonzero(support).tolist(), friction=float(rng.uniform(0.3, 0.9))
    )


def tilted(assembly: Assembly, rng: Random) -> Assembly:
    """The assembly on ground tilted by 8 to 40 degrees to any side."""
    angle, side = np.radians(rng.uniform(8.0, 40.0)), rng.uniform(0.0, 2 * np.pi)
    pull = 9.81 * np.array([np.sin(angle) * np.cos(side), np.sin(angle) * np.sin(side), -np.cos(angle)])
    return assembly.with_(gravity=tuple(pull))


def hut(
    rng: Random, walls: tuple[float, float] = (0.2, 0.6), vaults: tuple[float, float] = (0.1, 0.35), name: str = "hut"
) -> Assembly:
    """Four walls and a barrel vault of some fifty blocks; walls, vaults : thicknesses from and to [m]."""
    return build(
        scene_from(
            {
                "name": name, "length": rng.uniform(1.5, 3.0), "span": rng.uniform(1.5, 3.5),
                "brick": {"length": 0.8, "height": float(rng.choice([0.4, 0.5]))},
                "wall": {"thickness": rng.uniform(*walls), "height": rng.uniform(1.0, 2.2)},
                "vault": {"thickness": rng.uniform(*vaults), "voussoirs": int(rng.integers(5, 12))},
                "material": {"friction": float(rng.choice([0.5, 0.7]))},
            }
        )
    )  # fmt: skip


def chapel(rng: Random) -> Assembly:
    """A vaulted nave of large bricks with a door, a window on each side and, on most sides, a buttress."""
    height = rng.uniform(1.9, 2.6)
    scene = {
        "name": "chapel", "length": rng.uniform(2.7, 3.6), "span": rng.uniform(2.3, 3.4),
        "brick": {"length": 1.2, "height": 0.6}, "wall": {"thickness": rng.uniform(0.25, 0.7), "height": height},
        "doors": {"west": {"width": 0.7, "height": 1.2}},
        "windows": {
            side: {"width": rng.uniform(0.3, 0.5), "height": 0.6, "sill": 0.6} for side in ("south", "north")
        },
        "buttresses": {
            side: {"number": 1, "thickness": rng.uniform(0.2, 0.6), "width": 0.5, "height": 1.2}
            for side in ("south", "north") if rng.random() < 0.7
        },
        "vault": {"thickness": rng.uniform(0.15, 0.4), "voussoirs": int(rng.integers(5, 10))},
        "material": {"friction": float(rng.choice([0.5, 0.6, 0.7]))},
    }  # fmt: skip
    return build(scene_from(scene))
