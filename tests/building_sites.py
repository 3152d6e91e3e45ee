"""Small assemblies whose construction sequences are known exactly."""

import numpy as np

from blockstat import Assembly, Block, box


def prism(polygon, name):
    """A block of depth 1 over a polygon in x and z."""
    n = len(polygon)
    corners = [(x, y, z) for y in (0, 1) for x, z in polygon]
    sides = [[i, i + n, (i + 1) % n + n, (i + 1) % n] for i in range(n)]
    return Block(corners, [list(range(n)), list(range(2 * n - 1, n - 1, -1)), *sides], name)


def slab(x0, x1, z0, z1, name):
    return box((x0, 0, z0), (x1, 1, z1), name=name)


def arch(stones=7, thickness=0.2):
    """A semicircular arch of mean radius 1 between two fixed blocks."""
    angle = np.pi * np.arange(stones + 1) / stones

    def at(radius, k):
        return -radius * np.cos(angle[k]), radius * np.sin(angle[k])

    low, high = 1 - thickness / 2, 1 + thickness / 2
    blocks = [prism([at(low, k), at(low, k + 1), at(high, k + 1), at(high, k)], f"s{k}") for k in range(stones)]
    blocks += [slab(-1.3, -0.7, -0.3, 0, "west"), slab(0.7, 1.3, -0.3, 0, "east")]
    return Assembly.from_blocks(blocks, supports=["west", "east"], friction=0.6)


def tee():
    blocks = [
        slab(-0.5, 0.5, -0.25, 0, "ground"),
        slab(-0.5, 0.5, 0, 0.25, "base"),
        slab(-1.1, -0.1, 0.25, 0.5, "left"),
    ]
    blocks += [slab(0.1, 1.1, 0.25, 0.5, "right"), slab(-0.5, 0.5, 0.5, 0.75, "top")]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)
