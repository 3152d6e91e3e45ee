"""Scenes that break solvers, each with the truth about it.

A case allows the right answer and, within a stated distance of its limit, "undecided"; never the wrong one. Bad input
is to be refused. `evidence.pages.hard` writes the page of outcomes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from blockstat import Assembly, Block
from evidence.scenes.small import arch, assembly, box, flat_arch, hexahedron, running_bond, stack, trilith

STABLE, UNSTABLE, UNDECIDED, REFUSED = "stable", "unstable", "undecided", "refused"
SELF_STRESS = "stable_only_by_self_stress"
#: The stated tolerance of a certificate, relative to the weight.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Case:
    """One hard scene."""

    family: str
    name: str
    make: Callable[[], Assembly]
    right: str
    why: str  #: where the truth comes from
    options: dict[str, Any] = field(default_factory=dict)  #: of `assess`
    near: bool = False  #: so close to its limit, or so poor a contact, that "undecided" is an honest answer
    within: bool = False  #: closer to its limit than the certificates' stated tolerance: any answer may come


def pushed(make: Callable[[], Assembly], share: float) -> Callable[[], Assembly]:
    """A scene of unit gravity with a horizontal body force of that share of the weight."""
    return lambda: make().with_(gravity=(share, 0.0, -1.0))


def tipping(ratio: float) -> list[Case]:
    """A block of width over height .25, pushed by 1 + ratio times what tips it."""
    return [
        Case(
            "at the limit",
            f"block pushed by 1 {sign} {ratio:.0e} of its limit",
            pushed(lambda: stack(1, 0.5, 2.0), 0.25 * (1 + factor * ratio)),
            right,
            "tips at b/h",
            near=ratio <= 1e-9,
            within=ratio <= TOLERANCE,
        )
        for sign, factor, right in (("-", -1, STABLE), ("+", 1, UNSTABLE))
    ]


def thin_arch(voussoirs: int, least: float, ratio: float) -> list[Case]:
    return [
        Case(
            "at the limit" if voussoirs < 500 else "long",
            f"arch of {voussoirs} voussoirs, 1 {sign} {ratio:.0e} of its least thickness",
            lambda factor=factor: arch(voussoirs, least * (1 + factor * ratio)),
            right,
            f"least t/R {least}",
            {"friction": np.inf},
        )
        for sign, factor, right in (("+", 1, STABLE), ("-", -1, UNSTABLE))
    ]


def tall(courses: int) -> list[Case]:
    return [
        Case(
            "long",
            f"tower of {courses} courses at {factor} of its limit",
            pushed(lambda: stack(courses), factor / courses),
            right,
            "tips at b/(n a)",
        )
        for factor, right in ((0.999, STABLE), (1.001, UNSTABLE))
    ]


def heavy(ratio: float) -> list[Case]:
    """A lintel that many times denser than its columns; the limit does not know."""
    limit = 0.25
    return [
        Case(
            "mass ratio",
            f"lintel {ratio:.0e} times denser than its columns, at {factor} of its limit",
            pushed(lambda: trilith(ratio), factor * limit),
            right,
            "tips at b/h whatever the lintel weighs",
        )
        for factor, right in ((0.999, STABLE), (1.001, UNSTABLE))
    ]


def on_a_ridge(width: float) -> Case:
    """A cube centred on a ridge that is so wide at its top."""

    def make() -> Assembly:
        ridge = hexahedron(
            [(-1, 0, -1), (1, 0, -1), (1, 1, -1), (-1, 1, -1)],
            [(-width / 2, 0, 0), (width / 2, 0, 0), (width / 2, 1, 0), (-width / 2, 1, 0)],
            name="ridge",
        )
        return assembly([ridge, box((-0.5, 0, 0), (0.5, 1, 1), name="cube")])

    why = "the weight passes through the joint"
    return Case("narrow joint", f"cube balanced on a ridge {width:.0e} wide", make, STABLE, why, near=width <= 1e-6)


def off_a_ridge(width: float) -> Case:
    def make() -> Assembly:
        asm = on_a_ridge(width).make()
        return asm.with_(gravity=(2.0 * width, 0.0, -1.0))

    return Case(
        "narrow joint",
        f"the same, {width:.0e} wide, pushed by twice its limit",
        make,
        UNSTABLE,
        "tips at width / height",
        near=width <= 1e-6,
    )


def plates(thickness: float) -> Case:
    return Case(
        "slivers",
        f"twenty plates {thickness:.0e} thick",
        lambda: stack(20, 1.0, thickness),
        STABLE,
        "a stack at rest",
    )


def needle() -> Assembly:
    return assembly([box((-5, -5, -1), (5, 5, 0)), box((0, 0, 0), (4, 1e-3, 1e-3), name="needle")])


def tiles(n: int) -> Assembly:
    """A slab on n x n fixed tiles that meet at their corners."""
    blocks = [box((i, j, -1), (i + 1, j + 1, 0), name=f"tile{i}.{j}") for i in range(n) for j in range(n)] + [
        box((0, 0, 0), (n, n, 1), name="slab")
    ]
    return assembly(blocks, supports=list(range(n * n)))


def colonnade(n: int) -> Assembly:
    """A slab on n free columns in a row."""
    ground = box((-1, -1, -1), (2 * n, 2, 0), name="ground")
    columns = [box((2 * k, 0, 0), (2 * k + 1, 1, 5), name=f"column{k}") for k in range(n)]
    return assembly([ground, *columns, box((0, 0, 5), (2 * n - 1, 1, 6), name="slab")])


def eight_cubes() -> Assembly:
    ground = box((-2, -2, -1), (2, 2, 0))
    return assembly(
        [ground, *(box((i, j, k), (i + 1, j + 1, k + 1)) for i in (-1, 0) for j in (-1, 0) for k in (0, 1))]
    )


def cake(n: int) -> Assembly:
    """n wedges that meet along one vertical line, on a fixed slab."""
    angle = 2 * np.pi * np.arange(n + 1) / n
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    blocks = [box((-2, -2, -1), (2, 2, 0), name="ground")]
    for k in range(n):
        plan = np.array([(0.0, 0.0), rim[k], rim[k + 1]])
        low, high = (np.column_stack([plan, np.full(3, z)]) for z in (0.0, 1.0))
        faces = [[2, 1, 0], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
        blocks.append(Block(np.vstack([low, high]), faces, name=f"wedge{k}"))
    return assembly(blocks)


def pebbles(size: float) -> Assembly:
    """A unit cube on four pebbles of a given size under its corners."""
    blocks = [box((-2, -2, -1), (2, 2, 0), name="ground")]
    blocks += [
        box((x, y, 0), (x + size, y + size, size), name=f"pebble{k}")
        for k, (x, y) in enumerate([(0, 0), (1 - size, 0), (1 - size, 1 - size), (0, 1 - size)])
    ]
    return assembly([*blocks, box((0, 0, size), (1, 1, 1 + size), name="cube")])


def scaled(make: Callable[[], Assembly], factor: float) -> Callable[[], Assembly]:
    def built() -> Assembly:
        asm = make()
        return asm.with_(vertices=factor * asm.vertices)

    return built


def moved(make: Callable[[], Assembly], by: float) -> Callable[[], Assembly]:
    def built() -> Assembly:
        asm = make()
        return asm.with_(vertices=asm.vertices + by * np.array([1.0, -1.0, 1.0]))

    return built


def skew_bed(angle: float) -> Assembly:
    """A cube whose underside leans by a small angle against the ground it stands on."""
    rise = np.tan(angle)
    cube = hexahedron(
        [(0, 0, 0), (1, 0, rise), (1, 1, rise), (0, 1, 0)], [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], name="cube"
    )
    return assembly([box((-2, -2, -1), (3, 3, 0), name="ground"), cube])


def slope(angle: float) -> Callable[[], Assembly]:
    return lambda: stack(1, 1.0, 0.5).with_(gravity=(np.sin(angle), 0.0, -np.cos(angle)))


def in_the_air() -> Assembly:
    return assembly([box((-2, -2, -1), (2, 2, 0)), box((0, 0, 1), (1, 1, 2), name="kite")])


def pair_in_the_air() -> Assembly:
    return assembly(
        [box((-2, -2, -1), (2, 2, 0)), box((0, 0, 1), (1, 1, 2), name="lower"), box((0, 0, 2), (1, 1, 3), name="upper")]
    )


def sunk(depth: float) -> Assembly:
    return assembly([box((-2, -2, -1), (2, 2, 0)), box((0, 0, -depth), (1, 1, 1), name="sunk")])


CASES = (
    *(case for ratio in (1e-3, 1e-6, 1e-9, 1e-12) for case in tipping(ratio)),
    *(case for ratio in (1e-2, 1e-4) for case in thin_arch(10, 0.107011, ratio)),
    *(case for case in thin_arch(500, 0.107478, 1e-2)),
    *tall(200),
    *(case for ratio in (1e-6, 1e-3, 1e3, 1e6) for case in heavy(ratio)),
    *(case(width) for width in (1e-3, 1e-5, 1e-7, 1e-9) for case in (on_a_ridge, off_a_ridge)),
    *(plates(thickness) for thickness in (1e-2, 1e-4, 1e-6)),
    Case("slivers", "needle 4000 times longer than thick", needle, STABLE, "a block at rest"),
    Case("redundant", "slab on 400 tiles that meet in corners", lambda: tiles(20), STABLE, "a block at rest"),
    Case("redundant", "slab on 60 columns, 0.99 of the limit", pushed(lambda: colonnade(60), 0.198), STABLE, "b/h"),
    Case("redundant", "slab on 60 columns, 1.01 of the limit", pushed(lambda: colonnade(60), 0.202), UNSTABLE, "b/h"),
    Case("coincident corners", "eight cubes about one point", eight_cubes, STABLE, "two layers at rest"),
    Case("coincident corners", "sixty wedges about one line", lambda: cake(60), STABLE, "wedges at rest"),
    *(
        Case("huge by tiny", f"cube on four pebbles of {size:.0e} of it", lambda size=size: pebbles(size), STABLE,
             "rest")
        for size in (1e-1, 1e-2, 1e-3)
    ),
    *(
        Case("units", f"arch at 1.01 of its least thickness, lengths x {factor:.0e}",
             scaled(lambda: arch(10, 0.107011 * 1.01), factor), STABLE, "a length is a length", {"friction": np.inf})
        for factor in (1e-6, 1e-3, 1e3, 1e6)
    ),
    *(
        Case("far away", f"pushed by {share} of its limit, {by:.0e} m from the origin",
             moved(pushed(lambda: stack(1, 0.5, 2.0), 0.25 * share), by), right, "a place is a place")
        for by in (1e3, 1e6) for share, right in ((0.999, STABLE), (1.001, UNSTABLE))
    ),
    *(
        Case("far away", f"wall of 38 bricks, {by:.0e} m from the origin", moved(lambda: running_bond(6, 6), by),
             STABLE, "a wall at rest")
        for by in (1e3, 1e6)
    ),
    *(
        Case("nearly parallel", f"bed that leans by {angle:.0e}", lambda angle=angle: skew_bed(angle), STABLE,
             "friction .7", {"friction": 0.7})
        for angle in (1e-3, 1e-6, 1e-9)
    ),
    *(
        Case("friction", f"slope of {angle:.0e} without friction", slope(angle), UNSTABLE, "slides", {"friction": 0.0},
             near=angle < 1e-9)
        for angle in (1e-1, 1e-3, 1e-6)
    ),
    Case("friction", "level ground without friction", lambda: stack(3), STABLE, "weight alone", {"friction": 0.0}),
    Case("friction", "infinite friction, 0.999 of tipping", pushed(lambda: stack(1, 0.5, 2.0), 0.25 * 0.999), STABLE,
         "b/h", {"friction": np.inf}),
    Case("friction", "infinite friction, 1.001 of tipping", pushed(lambda: stack(1, 0.5, 2.0), 0.25 * 1.001), UNSTABLE,
         "b/h", {"friction": np.inf}),
    Case("floating", "a block in the air", in_the_air, UNSTABLE, "nothing holds it"),
    Case("floating", "two blocks in the air, one on the other", pair_in_the_air, UNSTABLE, "nothing holds them"),
    Case("self-stress", "flat arch between rigid abutments, by forces", lambda: flat_arch(5), STABLE,
         "a thrust without end", {"friction": 0.3}),
    Case("self-stress", "flat arch between rigid abutments, Coulomb", lambda: flat_arch(5), SELF_STRESS,
         "nothing makes the thrust", {"friction": 0.3, "flow": "coulomb"}),
    Case("bad input", "cube sunk by a twentieth into the ground", lambda: sunk(0.05), UNDECIDED, "rests, or flies off"),
    Case("bad input", "cube sunk by a fifth into the ground", lambda: sunk(0.2), REFUSED, "blocks overlap"),
)  # fmt: skip
