"""Small assemblies with known answers, shared by the tests."""

from __future__ import annotations

import numpy as np

from blockstat import Assembly, Block

BOX_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def hexahedron(bottom, top, **options) -> Block:
    """A block between two quadrilaterals, each counter-clockwise seen from above."""
    return Block(np.vstack([bottom, top]), BOX_FACES, **options)


def box(lower, upper, **options) -> Block:
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    plan = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return hexahedron([(x, y, z0) for x, y in plan], [(x, y, z1) for x, y in plan], **options)


def assembly(blocks, **options) -> Assembly:
    return Assembly.from_blocks(blocks, **{"supports": [0], "density": 1.0, "gravity": (0, 0, -1)} | options)


def stack(n: int, width: float = 1.0, height: float = 1.0, **options) -> Assembly:
    """n equal blocks on a fixed slab."""
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground")]
    blocks += [box((0, 0, i * height), (width, 1, (i + 1) * height), name=f"stone{i}") for i in range(n)]
    return assembly(blocks, **options)


def arch(
    n: int, thickness: float, *, radius: float = 1.0, embrace: float = np.pi, depth: float = 0.5, **options
) -> Assembly:
    """A circular arch of n straight-sided voussoirs with radial joints between two fixed springers.

    radius : of the centreline; thickness : radial.
    """
    angles = np.pi / 2 + embrace / 2 - np.linspace(0, embrace, n + 1)
    inner, outer = radius - thickness / 2, radius + thickness / 2

    def joint(angle, y):
        c, s = np.cos(angle), np.sin(angle)
        return (inner * c, y, inner * s), (outer * c, y, outer * s)

    blocks = [
        hexahedron(
            [*joint(a, depth)[::-1], *joint(b, depth)],
            [*joint(a, 0)[::-1], *joint(b, 0)],
            name=f"voussoir{i}",
        )
        for i, (a, b) in enumerate(zip(angles[:-1], angles[1:], strict=True))
    ]
    return assembly([*_springers(angles, inner, outer, depth), *blocks], **{"supports": [0, 1]} | options)


def _springers(angles, inner, outer, depth):
    for angle, name, turn in ((angles[0], "left", 0.3), (angles[-1], "right", -0.3)):
        rays = [(angle + turn, inner), (angle + turn, outer), (angle, outer), (angle, inner)]
        if turn > 0:
            rays = rays[::-1]
        plan = [(r * np.cos(a), r * np.sin(a)) for a, r in rays]
        yield hexahedron([(x, depth, z) for x, z in plan], [(x, 0, z) for x, z in plan], name=name)


def running_bond(
    courses: int, bricks: int, *, length: float = 0.4, height: float = 0.175, depth: float = 0.2, **options
) -> Assembly:
    """A wall of whole bricks, half bricks at the ends of every other course, on a fixed slab."""
    blocks = [box((-length, -length, -height), ((bricks + 1) * length, depth + length, 0), name="ground")]
    for course in range(courses):
        joints = np.arange(bricks + 1) * length
        if course % 2:
            joints = np.concatenate([[0], joints[:-1] + length / 2, [bricks * length]])
        for i, (x0, x1) in enumerate(zip(joints[:-1], joints[1:], strict=True)):
            z = course * height
            blocks.append(box((x0, 0, z), (x1, depth, z + height), name=f"{course}.{i}"))
    return assembly(blocks, **options)


#: Scenes on both sides of their limits: (name, maker, options of `assess`).
SCENES = [
    ("stack", lambda: stack(3), {}),
    ("stack tipping", lambda: stack(3), {"gravity": (0.4, 0, -1)}),
    ("stack sliding", lambda: stack(1, 2.0, 0.5), {"gravity": (0.9, 0.2, -1)}),
    ("arch", lambda: arch(20, 0.12), {}),
    ("thin arch", lambda: arch(20, 0.10), {}),
    ("slippery arch", lambda: arch(27, 0.15), {"friction": 0.33}),
    ("sticky arch", lambda: arch(10, 0.09), {"friction": np.inf}),
    ("wall", lambda: running_bond(6, 5), {}),
    ("wall pushed along", lambda: running_bond(6, 5), {"gravity": (0.8, 0, -1)}),
    ("wall pushed out", lambda: running_bond(6, 5), {"gravity": (0, 0.3, -1)}),
    ("offset cube", lambda: assembly([box((-0.5, 0, 0), (0.5, 1, 1)), box((0.25, 0, 1), (1.25, 1, 2))]), {}),
    ("heavy on light", lambda: assembly([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1)),
     box((0.2, 0, 1), (1.2, 1, 2), density=1e4)]), {}),
]  # fmt: skip

#: A building small enough to be simulated in a second: 45 blocks.
HUT = {
    "name": "hut", "length": 2.0, "span": 2.4,
    "brick": {"length": 0.8, "height": 0.5},
    "wall": {"thickness": {"value": 0.8, "min": 0.2, "max": 0.8, "step": 0.2}, "height": 1.5},
    "vault": {"thickness": {"value": 0.3, "min": 0.2, "max": 0.3, "step": 0.1}, "voussoirs": 7},
}  # fmt: skip


def ferris_wall(rows, block=0.4, height=0.175, depth=1.0):
    """Courses from the bottom: 1 a whole block, .5 a half one, -1 an opening one block long."""
    blocks = [box((0, 0, -height), (block * sum(map(abs, rows[0])), depth, 0), name="base")]
    for course, row in enumerate(rows):
        x = 0.0
        for item in row:
            if item > 0:
                blocks.append(box((x, 0, course * height), (x + item * block, depth, (course + 1) * height)))
            x += abs(item) * block
    return assembly(blocks, friction=0.65)


A, B = [0.5, 1, 1, 1, 1, 0.5], [1] * 5
FE3, FU3, WE3, WU3 = [1] * 4, [0.5, 1, 1, 1, 0.5], [1, 0.5, -1, 0.5, 1], [0.5, 1, -1, 1, 0.5]
FE4, FU4 = [0.5, 1, 1, 1, 1, 0.5], [1] * 5
WU4, WE4 = [1, -1, 1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5]
#: Walls of Ferris & Tin-Loi (2001): rows, blocks, joints, associated factor as published and as derived.
FERRIS = {
    "W1": ([A, B] * 3, 33, 83, 0.643, 0.642859),
    "W3": ([FE3, FU3, FE3, WU3, WE3, WU3, WE3, WU3, FE3, FU3, FE3], 46, 102, 0.404, 0.403694),
    "W4": ([FE4, FU4, FE4, WU4, WE4, WU4, WE4, WU4, FE4, FU4, FE4], 55, 116, 0.332, 0.331948),
}


def pointed_arch(n: int, eccentricity: float, thickness: float, *, depth: float = 0.5) -> Assembly:
    """Two arcs of radius 1, centres at +-eccentricity on the springing line, n voussoirs each, meeting at the crown."""
    top = np.arccos(eccentricity)  # the left arc has its centre on the right

    def ring(angle):
        c, s = np.cos(angle), np.sin(angle)
        return [(eccentricity - r * c, r * s) for r in (1 - thickness / 2, 1 + thickness / 2)]

    rings = [ring(a) for a in np.linspace(0, top, n + 1)]
    # The joint at the crown is vertical: both ends of the last radial joint are moved along the arcs onto x = 0.
    rings[-1] = [(0.0, np.sqrt(r**2 - eccentricity**2)) for r in (1 - thickness / 2, 1 + thickness / 2)]
    left = [[*a[::-1], *b] for a, b in zip(rings[:-1], rings[1:], strict=True)]
    plans = left + [[(-x, z) for x, z in plan[::-1]] for plan in left]
    blocks = [
        hexahedron([(x, depth, z) for x, z in plan], [(x, 0, z) for x, z in plan], name=f"voussoir{i}")
        for i, plan in enumerate(plans)
    ]
    reach = 1 + thickness - eccentricity
    ground = [
        box((-2 * reach, 0, -0.2), (-0.2, depth, 0), name="left"),
        box((0.2, 0, -0.2), (2 * reach, depth, 0), name="right"),
    ]
    return assembly([*ground, *blocks], supports=[0, 1])
