"""Small assemblies whose construction sequences are known exactly."""

from functools import cache

import numpy as np
from scipy.optimize import linprog

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


def wrench(force, point):
    """A force in x and z, and its moment about the origin."""
    return np.array([*force, point[0] * force[1] - point[1] * force[0]])


@cache
def least_force(hoisted, there):
    """The least total force [stone weights] that holds some stones of `arch()`: a plane program of its own.

    Contact forces act at both ends of each bed, along both edges of the cone of friction. A stone hangs at its
    centroid, or bears on both ends of its intrados, normal to it.
    """
    inside, outside, friction = 0.9, 1.1, 0.6
    radial = [np.array([np.cos(angle), np.sin(angle)]) for angle in np.pi * (1 - np.arange(8) / 7)]
    middle = [np.array([np.cos(angle), np.sin(angle)]) for angle in np.pi * (1 - (np.arange(7) + 0.5) / 7)]
    centroid = np.cos(np.pi / 14) * (inside + (outside - inside) * (inside + 2 * outside) / 3 / (inside + outside))
    weight = {k: wrench((0, -1), centroid * middle[k]) for k in there}
    contacts, props = [], []
    for bed, (x, z) in enumerate(radial):
        if {bed - 1, bed} <= {-1, *there, 7}:  # the supports are -1 and 7
            for radius in (inside, outside):
                for slope in (friction, -friction):
                    push = wrench(np.array([z, -x]) + slope * radial[bed], radius * radial[bed])
                    contacts.append({bed: push, bed - 1: -push})
    for k in there:
        bears = [wrench(middle[k], inside * radial[bed]) for bed in (k, k + 1)]
        props += [{k: push} for push in ([-weight[k]] if hoisted else bears)]
    columns = [np.concatenate([push.get(k, np.zeros(3)) for k in there]) for push in (*contacts, *props)]
    cost = np.repeat([0.0, 1.0], [len(contacts), len(props)])
    dead = np.concatenate([weight[k] for k in there])
    found = linprog(cost, A_eq=np.array(columns).T, b_eq=-dead, method="highs")
    assert found.status in {0, 2}  # solved, or nothing holds the stones
    return found.fun if found.status == 0 else np.inf
