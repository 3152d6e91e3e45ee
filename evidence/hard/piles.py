"""Random piles of blocks: bricks on courses, sheared and turned, of any friction, weight and load, from a seed."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from blockstat import Assembly
from evidence.scenes.small import assembly, box

FRICTION = (0.0, 0.1, 0.3, 0.7, 1.2, np.inf)


def pile(seed: int) -> Assembly:
    """A pile of 1 to 15 blocks on a fixed slab.

    Courses of bricks of random length and place, gaps between them allowed, so that some bricks hang, tip or float;
    the whole sheared, scaled and turned by a random map that keeps its faces plane, under a random body force.
    """
    random = np.random.default_rng(seed)
    blocks = [box((-4, -2, -1), (12, 4, 0), name="ground")]
    bottom = 0.0
    for course in range(random.integers(1, 5)):
        height = random.choice([0.5, 1.0])
        start = random.uniform(0, 2)
        for _ in range(random.integers(1, 4)):
            length = random.choice([0.5, 1.0, 2.0, 3.0])
            y = random.choice([0.0, 0.0, 0.0, 0.5, -0.25])
            blocks.append(
                box(
                    (start, y, bottom), (start + length, y + 1, bottom + height),
                    name=f"{course}.{len(blocks)}", density=float(10.0 ** random.choice([0, 0, 0, 1, -2, 3])),
                )
            )  # fmt: skip
            start += length + random.choice([0.0, 0.0, 0.3, 1.5])
        bottom += height
    asm = assembly(blocks, friction=float(random.choice(FRICTION)))
    shear = np.eye(3) + np.triu(random.choice([0.0, 0.3]) * random.uniform(-1, 1, (3, 3)), 1)
    turn = Rotation.random(random_state=int(seed)).as_matrix() if random.random() < 0.5 else np.eye(3)
    size = 10.0 ** random.choice([-3, 0, 0, 0, 3])
    tilt = random.choice([0.0, 0.05, 0.3]) * random.uniform(-1, 1, 3)
    down = turn @ (np.array([0.0, 0.0, -1.0]) + tilt)
    return asm.with_(vertices=size * asm.vertices @ (turn @ shear).T, gravity=down)
