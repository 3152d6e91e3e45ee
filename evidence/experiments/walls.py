"""The 21 dry-joint shear walls of the EPFL stone masonry database, as blocks.

Only what the database gives goes in: lengths, the axial load, the compressive strength. Nothing is fitted. What it does
not give is assumed, for all walls alike, and listed in `ASSUMED`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstat import Assembly, JointLaw, point_load
from blockstat.typing import Floats
from evidence.paths import EXPERIMENTS
from evidence.scenes.small import box

FILE = EXPERIMENTS / "shear_walls" / "walls.json"
UNIT_WEIGHT = 20e3  #: of every stone, as the database takes it [N/m3]
GRAVITY = 9.81
#: Courses of whole blocks are the odd ones of a WS wall and the even ones of an SW wall, as its crack maps draw them.
WHOLE_AT_THE_FOOT = {"WS": True, "SW": False}
ASSUMED = (
    "The axial load stands at the centre of a rigid cap of no weight of its own, which is free to turn. The database "
    "says nothing about the cap or its guides.",
    "The horizontal force acts at the height of zero moment, H0, which the database calls the shear span.",
    "The coefficient of friction is not in the database. It is .5, .6, .7 and .8 on all joints, those of the base and "
    "the cap too.",
    "Every stone weighs 20 kN/m3, as the database assumes for the self weight.",
    "The bond is read off the crack maps: courses of whole blocks alternate with courses with half blocks at both "
    "ends. The lowest course of the granite walls is of whole blocks; that of the sandstone walls begins with half "
    "blocks.",
    "A joint crushes at the strength of the masonry in the database, from tests of prisms.",
)


@dataclass(frozen=True)
class Wall:
    """What a test gives to the statics; nothing of what was measured at failure."""

    name: str
    series: str
    length: float  #: [m]
    height: float  #: [m]
    thickness: float  #: [m]
    block_length: float  #: [m]
    courses: int
    shear_span: float  #: height of the horizontal force above the base [m]
    axial: float  #: [N]
    strength: float  #: of the masonry in compression [Pa]

    def blocks(self, friction: float, *, crushing: bool = False) -> Assembly:
        """The wall on its base under its cap, whose weight is the axial load."""
        depth, step = self.thickness, self.height / self.courses
        bricks = [box((-0.5, -0.5, -0.3), (self.length + 0.5, depth + 0.5, 0), name="base", group="base")]
        for course in range(self.courses):
            ends = self._ends((course % 2 == 0) == WHOLE_AT_THE_FOOT[self.series])
            for k, (left, right) in enumerate(zip(ends[:-1], ends[1:], strict=True)):
                corners = (left, 0, course * step), (right, depth, (course + 1) * step)
                bricks.append(box(*corners, name=f"{course}.{k}", group="wall", density=UNIT_WEIGHT / GRAVITY))
        top = 2 * self.shear_span - self.height  # the force acts at the middle of the cap
        volume = self.length * depth * (top - self.height)
        cap = box((0, 0, self.height), (self.length, depth, top), name="cap", density=self.axial / GRAVITY / volume)
        laws = (JointLaw(("*", "*"), compression=self.strength),) if crushing else ()
        options: dict[str, Any] = {"friction": friction, "joints": laws, "gravity": (0, 0, -GRAVITY), "name": self.name}
        return Assembly.from_blocks([*bricks, cap], supports=["base"], **options)

    def push(self, assembly: Assembly) -> Floats:
        """A horizontal force of 1 kN on the cap at the shear span."""
        return point_load(assembly, "cap", (self.length / 2, self.thickness / 2, self.shear_span), (1e3, 0, 0))

    def _ends(self, whole: bool) -> Floats:
        """Where the blocks of a course begin and end."""
        number = round(self.length / self.block_length)
        joints = np.arange(number + 1.0) if whole else np.concatenate([[0.0], np.arange(number) + 0.5, [number]])
        return joints * self.length / number


def tests() -> list[dict[str, Any]]:
    """All that is known of the tests, in the order of the file."""
    return json.loads(FILE.read_text())["tests"]


def walls() -> list[Wall]:
    """The walls as the statics see them."""
    return [
        Wall(
            name=test["id"],
            series=test["series"],
            length=(shape := test["geometry"])["length_m"],
            height=shape["height_m"],
            thickness=shape["thickness_m"],
            block_length=shape["block_length_m"],
            courses=round(shape["courses_if_height_over_block_height"]),
            shear_span=shape["H0_m"],
            axial=1e3 * test["axial"]["load_kN"],
            strength=1e6 * test["material"]["fc_masonry_MPa"],
        )
        for test in tests()
    ]
