"""Small assemblies with known answers."""

from __future__ import annotations

import numpy as np

from blockstat import Assembly, Block, JointLaw

BOX_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def hexahedron(bottom, top, **options) -> Block:
    """A block between two quadrilaterals, each counter-clockwise seen from above."""
    return Block(np.vstack([bottom, top]), BOX_FACES, **options)


def box(lower, upper, **options) -> Block:
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    plan = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return hexahedron([(x, y, z0) for x, y in plan], [(x, y, z1) for x, y in plan], **options)


def slice_(outline, depth: float, **options) -> Block:
    """A block with a quadrilateral outline in the plane x, z, counter-clockwise seen from -y, from y = 0 to `depth`."""
    return hexahedron([(x, depth, z) for x, z in outline], [(x, 0, z) for x, z in outline], **options)


def prism(outline, depth: float, **options) -> Block:
    """A block with any outline in the plane x, z, counter-clockwise seen from -y, from y = 0 to `depth`."""
    n = len(outline)
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    corners = [(x, 0, z) for x, z in outline] + [(x, depth, z) for x, z in outline]
    faces = [list(range(n)), list(range(n, 2 * n))[::-1], *[side[::-1] for side in sides]]
    return Block(np.array(corners, dtype=float), faces, **options)


def bevelled(width: float, degrees: float, scale: float = 1.0) -> Assembly:
    """A slab of 0.05 x 3 x 3 m whose foot is flat but for bevels of a width along its long edges, on the ground."""
    rise, half = width * np.tan(np.radians(degrees)), 0.025
    foot = [(width - half, 0), (half - width, 0), (half, rise), (half, 3), (-half, 3), (-half, rise)]
    ground = box((-9 * scale, -9 * scale, -scale), (9 * scale, 9 * scale, 0), name="ground")
    return assembly([ground, prism(scale * np.array(foot), 3 * scale, name="slab")], supports=["ground"])


def pitted(slab: float, thick: float, pit: float, deep: float, **options) -> Block:
    """A square slab below z = 0 with a square pit, given by half their widths; less than 0 deep it is a pedestal."""
    rings = ((-thick, slab), (0, slab), (0, pit), (-deep, pit))
    corners = [(x, y, z) for z, r in rings for x, y in ((-r, -r), (r, -r), (r, r), (-r, r))]
    sides = [[k + i, k + (i + 1) % 4, k + (i + 1) % 4 + 4, k + i + 4] for k in (0, 4, 8) for i in range(4)]
    return Block(np.array(corners, dtype=float), [[3, 2, 1, 0], *sides, [12, 13, 14, 15]], **options)


def pinched() -> list[Block]:
    """A light block between two heavy ones that slide towards it down slopes of 45 degrees on two supports."""
    return [
        prism([(-3, -1), (0, -1), (0, 0), (-3, 3)], 1.0, name="left"),
        prism([(0, -1), (3, -1), (3, 3), (0, 0)], 1.0, name="right"),
        prism([(-0.25, 0.25), (-0.25, 2), (-2, 2)], 1.0, name="one", density=2500.0),
        prism([(0.25, 0.25), (2, 2), (0.25, 2)], 1.0, name="other", density=2500.0),
        prism([(-0.25, 1.2), (0.25, 1.2), (0.25, 1.6), (-0.25, 1.6)], 1.0, name="pinched", density=250.0),
    ]


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
    ("sticky arch", lambda: arch(10, 0.13), {"friction": np.inf}),
    ("thin sticky arch", lambda: arch(10, 0.09), {"friction": np.inf}),
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


def ferris_wall(rows, block=0.4, height=0.175, depth=1.0, head_friction=None):
    """Courses from the bottom: 1 a whole block, .5 a half one, -1 an opening one block long."""
    blocks = [box((0, 0, -height), (block * sum(map(abs, rows[0])), depth, 0), name="base")]
    for course, row in enumerate(rows):
        x = 0.0
        for item in row:
            if item > 0:
                top = (x + item * block, depth, (course + 1) * height)
                blocks.append(box((x, 0, course * height), top, group=f"course{course}"))
            x += abs(item) * block
    courses = [f"course{k}" for k in range(len(rows))]
    laws = [] if head_friction is None else [JointLaw((name, name), friction=head_friction) for name in courses]
    return assembly(blocks, friction=0.65, joints=laws)


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


def slab():
    """A flat slab on a fixed plane: it slides before it tips."""
    return assembly([box((-5, -5, -1), (5, 5, 0)), box((-1, -1, 0), (1, 1, 0.1))])


def trilith(lintel_density: float = 1.0):
    columns = [box((x, 0, 0), (x + 0.5, 0.5, 2), name=f"column{x}") for x in (0, 3)]
    lintel = box((0, 0, 2), (3.5, 0.5, 2.5), name="lintel", density=lintel_density)
    return assembly([box((-5, -5, -1), (9, 5, 0)), *columns, lintel])


def overhanging(n: int, overhang: float):
    """n unit blocks on a table's edge, each out by a common multiple of 1 / (2 k) over the next, k from the top."""
    steps = [1 / (2 * k) for k in range(n, 0, -1)]
    x, blocks = 0.0, [box((-3, 0, -1), (0, 1, 0), name="table")]
    for level, step in enumerate(steps):
        x += overhang / sum(steps) * step
        blocks.append(box((x - 1, 0, level), (x, 1, level + 1)))
    return assembly(blocks)


def pulled_slab():
    """Slab A on the ground, B on A, the end of B against a fixed wall; the load pulls A at the height of its base."""
    asm = assembly(
        [
            box((-3, 0, -1), (8, 1, 0), name="ground"),
            box((2, 0, 1.1), (3, 1, 2), name="wall"),  # clear of the edge of A
            box((-2, 0, 0), (2, 1, 1), name="A", density=0.25),
            box((-2, 0, 1), (2, 1, 2), name="B", density=0.25),
        ],
        supports=["ground", "wall"],
        friction=0.5,
    )
    pull = np.zeros((4, 6))
    pull[2, [0, 4]] = 1.0, -0.5
    return asm, pull


def flat_arch(n: int, span: float = 2.0, height: float = 1.0, **options):
    """n equal blocks with vertical joints between rigid abutments; the weight is span x height."""
    ends = np.linspace(0, span, n + 1)
    blocks = [box((-1, 0, 0), (0, 1, height), name="left"), box((span, 0, 0), (span + 1, 1, height), name="right")]
    blocks += [box((a, 0, 0), (b, 1, height)) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    return assembly(blocks, supports=["left", "right"], **options)


def cantilever(base: float, beyond: float):
    """A block of weight 1 whose centre of mass lies beyond the end of its base, one course high and one deep."""
    length = 2 * (base + beyond)
    return assembly([box((-1, 0, -1), (base, 1, 0)), box((0, 0, 0), (length, 1, 1), density=1 / length)])


def u_wall(courses: int):
    """A facade along x and two side walls in bond with it, of blocks 2 x 1 x 1."""
    blocks = [box((-2, -2, -1), (8, 7, 0), name="ground")]
    for z in range(courses):
        if z % 2 == 0:
            plans = [((x, 0), (x + 2, 1)) for x in (0, 2, 4)]
            plans += [((x, y), (x + 1, y + 2)) for x in (0, 5) for y in (1, 3)]
        else:
            plans = [((x, 0), (x + 2, 1)) for x in (1, 3)]
            plans += [((x, y), (x + 1, y + 2)) for x in (0, 5) for y in (0, 2)]
            plans += [((x, 4), (x + 1, 5)) for x in (0, 5)]
        blocks += [box((*low, z), (*high, z + 1)) for low, high in plans]
    return assembly(blocks)


def facade(courses: int):
    """The front of `u_wall` without its side walls."""
    blocks = [box((-2, -2, -1), (8, 7, 0))]
    for z in range(courses):
        ends = [(0, 2), (2, 4), (4, 6)] if z % 2 == 0 else [(0, 1), (1, 3), (3, 5), (5, 6)]
        blocks += [box((a, 0, z), (b, 1, z + 1)) for a, b in ends]
    return assembly(blocks)
