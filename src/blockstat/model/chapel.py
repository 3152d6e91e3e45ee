"""The rectangular building of the short form of a scene."""

from __future__ import annotations

import msgspec

from blockstat.assembly import Assembly, Block
from blockstat.errors import InputError
from blockstat.joint import JointLaw
from blockstat.model.buttresses.short_buttress import build_buttresses
from blockstat.model.ground import ground
from blockstat.model.vaults.short_barrel import build_barrel
from blockstat.model.walling.short_wall import Courses, WallFrame, build_wall
from blockstat.spec import WALLS, Building, is_present, parameters, value_of

MOST_BLOCKS = 300_000


def build_chapel(building: Building) -> Assembly:
    """The assembly of a building: "ground" (the support), "wall.<side>", "buttress.<side>.<k>", "vault".

    Raises InputError naming the key when the parts do not fit together.
    """
    brick = (value_of(building.brick.length), value_of(building.brick.height))
    _check_size(building)
    frames = wall_frames(building)
    height = value_of(building.wall.height)
    course_height = Courses.filling(height, brick[1]).height
    blocks: list[Block] = []
    for side in WALLS:
        openings = [
            (f"{kind}.{side}", table[side])
            for kind, table in (("doors", building.doors), ("windows", building.windows))
            if side in table and is_present(table[side].present)
        ]
        blocks += build_wall(frames[side], brick, openings)
    for side in WALLS:
        if side in building.buttresses and is_present(building.buttresses[side].present):
            blocks += build_buttresses(frames[side], building.buttresses[side], course_height)
    if building.vault is not None and is_present(building.vault.present):
        blocks += build_barrel(
            length=value_of(building.length),
            span=value_of(building.span),
            springing=height,
            thickness=value_of(building.vault.thickness),
            courses=round(value_of(building.vault.voussoirs)),
            brick=brick[0],
        )
    material = building.material
    values = {path: value.value for path, value in parameters(building).items()}
    return Assembly.from_blocks(
        [ground(blocks), *blocks],
        supports=[0],
        name=building.name,
        density=material.density,
        friction=material.friction,
        joints=[JointLaw(**msgspec.structs.asdict(j)) for j in building.joints],
        metadata={"parameters": values, "material": msgspec.to_builtins(material)},
    )


def _check_size(building: Building) -> None:
    """Raise InputError before a slip of the pen makes millions of blocks."""
    brick = value_of(building.brick.length) * value_of(building.brick.height)
    length, height = value_of(building.length), value_of(building.wall.height)
    about = 2 * (length + value_of(building.span)) * height / brick
    if building.vault is not None:
        about += value_of(building.vault.voussoirs) * length / value_of(building.brick.length)
    if about > MOST_BLOCKS:
        raise InputError(f"brick, wall and vault make about {about:.2g} blocks; at most {MOST_BLOCKS} are built")


def wall_frames(building: Building) -> dict[str, WallFrame]:
    """The four walls: long ones along x outside 0 <= y <= span, end walls between them."""
    length, span = value_of(building.length), value_of(building.span)
    thickness, height = value_of(building.wall.thickness), value_of(building.wall.height)

    def frame(name: str, run: float, place, outward: float) -> WallFrame:
        return WallFrame(name, run, thickness, height, place, outward)

    return {
        "south": frame("south", length, lambda s, d, z: (s, d - thickness, z), 0.0),
        "north": frame("north", length, lambda s, d, z: (s, span + d, z), thickness),
        "west": frame("west", span, lambda s, d, z: (d, s, z), 0.0),
        "east": frame("east", span, lambda s, d, z: (length - thickness + d, s, z), thickness),
    }
