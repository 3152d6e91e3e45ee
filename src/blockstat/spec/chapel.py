"""The short form: a rectangular building of walls, openings, buttresses and a barrel vault.

Every constructive parameter is a number or a range {value, min, max, step}; the search moves ranges. Lengths are in
metres. Unknown keys are refused with their path. `lowered` says the same building in the general elements.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec

from blockstat.errors import InputError
from blockstat.model.size import blocks_asked, check_block_count
from blockstat.model.walling import run as walling
from blockstat.model.walling.heads import tell_moved
from blockstat.spec.composition import Plan, load_tables, ties_of
from blockstat.spec.element import Element
from blockstat.spec.elements import element
from blockstat.spec.material import Joint, Material, uncertain_of
from blockstat.spec.ranges import Count, Height, Length, Presence, Range, is_present, value_of
from blockstat.spec.reading import check_name

WALLS = ("south", "north", "west", "east")
WallName = Literal["south", "north", "west", "east"]


class Brick(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Nominal brick; the length is stretched a little so that each row is whole bricks and one half brick."""

    length: Length = 0.8  #: nominal [m]
    height: Length = 0.3  #: nominal, of a course [m]


class Wall(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The four walls, one leaf thick."""

    thickness: Length = 0.8  #: [m]
    height: Length = 2.4  #: from the ground to the springing [m]


class Opening(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Doors or windows of one wall, evenly spaced, each under a lintel; heights are rounded to whole courses."""

    width: Length  #: clear [m]
    height: Length  #: clear [m]
    sill: Height = 0.0  #: above the ground [m]
    number: Count = 1  #: evenly spaced
    present: Presence = True  #: true, false or "search"


class Buttress(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Buttresses of one wall, evenly spaced, standing against it."""

    number: Count  #: evenly spaced
    thickness: Length  #: projection from the wall [m]
    width: Length  #: along the wall [m]
    height: Length  #: [m]
    present: Presence = True  #: true, false or "search"


class Vault(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A semicircular barrel vault from the south to the north wall."""

    thickness: Length = 0.3  #: normal to the intrados [m]
    voussoirs: Annotated[int, msgspec.Meta(ge=3)] | Range = 13  #: round the arch
    present: Presence = True  #: true, false or "search"


class Building(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A rectangular building on a fixed ground slab.

    The long walls run along x, south at y < 0 and north at y > span; the end walls stand between them, so
    that the layout of a wall does not depend on the thickness of another.
    """

    name: str  #: by default that of the file
    length: Length  #: of the long walls, end to end [m]
    span: Length  #: clear width between the long walls [m]
    brick: Brick = Brick()  #: nominal brick
    wall: Wall = Wall()  #: the four walls
    doors: dict[WallName, Opening] = {}  #: by wall
    windows: dict[WallName, Opening] = {}  #: by wall
    buttresses: dict[WallName, Buttress] = {}  #: by wall
    vault: Vault | None = None  #: from the south to the north wall
    material: Material = Material()  #: stone and joints
    joints: tuple[Joint, ...] = ()  #: laws of particular joints
    loads: dict[str, dict[str, Any]] = {}  #: by name: each has a `kind` and the keys of that kind
    cases: dict[str, dict[str, Any]] = {}  #: by name: combinations of loads with factors
    ties: dict[str, dict[str, Any]] = {}  #: by name: ties and struts between two blocks
    uncertain: dict[str, dict[str, Any]] = {}  #: random variables, for `blockstat reliability`
    stages: list[dict[str, Any]] = []  #: what is put in one after the other: see `blockstat.sequence.stages`
    description: str = ""  #: one line

    def __post_init__(self) -> None:
        check_name(self.name)


def lowered(building: Building) -> Plan:
    """The plan of the general elements that a building stands for: walls and a barrel vault.

    The end walls butt against the long walls, without a bond. Groups are "ground" (the support), "wall.<side>",
    "wall.<side>.lintel", "buttress.<side>.<k>" and "vault".

    Parameters
    ----------
    building : Building
        Its ranges count with their values.

    Returns
    -------
    Plan
        In numbers only.

    Raises
    ------
    InputError
        Where the end walls overlap, and before a slip of the pen makes millions of blocks.
    """
    _check_size(building)
    _check_beside_vault(building)
    walls, keys = _walls(building)
    elements: dict[str, Element] = {"walls": walls}
    if building.vault is not None:
        length, span = value_of(building.length), value_of(building.span)
        elements["vault"] = element(
            "barrel",
            span=span,
            length=length,
            thickness=value_of(building.vault.thickness),
            voussoirs=round(value_of(building.vault.voussoirs)),
            brick=value_of(building.brick.length),
            at=(length / 2, span / 2, value_of(building.wall.height)),
            prefix="",
            present=is_present(building.vault.present),
        )
    return Plan(
        name=building.name,
        elements={name: own for name, own in elements.items() if own.present},
        left_out={name: own for name, own in elements.items() if not own.present},
        material=building.material,
        joints=building.joints,
        no_overlap=True,
        **load_tables(building.loads, building.cases),
        ties=ties_of(building.ties),
        uncertain=uncertain_of(building.uncertain),
        stages=tuple(building.stages),
        keys={"elements.vault": "vault", "elements.walls: ": ""} | keys,
    )


def _walls(building: Building) -> tuple[Element, dict[str, str]]:
    """The walls with their openings and buttresses, and what errors call them."""
    height, nominal = value_of(building.wall.height), value_of(building.brick.height)
    course = height / _courses(height, nominal)
    keys, runs, buttresses = {}, {}, []
    for side, (path, align) in _paths(building).items():
        tables = {f"doors.{side}": building.doors.get(side), f"windows.{side}": building.windows.get(side)}
        said = {key: own for key, own in tables.items() if own is not None}
        keys |= {f'wall "{side}": openings[{k}]': key for k, key in enumerate(said)}
        runs[side] = walling.Run(
            path=path,
            align=align,
            thickness=value_of(building.wall.thickness),
            height=height,
            closers=True,
            openings=tuple(_opening(key, own, height, course) for key, own in said.items()),
        )
    for side in WALLS:
        own = building.buttresses.get(side)
        if own is not None:
            keys[f'buttresses[{len(buttresses)}] of wall "{side}"'] = f"buttresses.{side}"
            buttresses.append(_buttress(side, own, course))
    brick = (value_of(building.brick.length), min(nominal, height))
    return element("walls", runs=runs, brick=brick, buttresses=buttresses, bonded=False, prefix=""), keys


def _paths(building: Building) -> dict[WallName, tuple[tuple[tuple[float, float], ...], Literal["left", "right"]]]:
    """A line along each wall, and the side of it on which the wall is; the end walls stand between the long ones."""
    length, span = value_of(building.length), value_of(building.span)
    return {
        "south": (((0.0, 0.0), (length, 0.0)), "right"),
        "north": (((0.0, span), (length, span)), "left"),
        "west": (((0.0, 0.0), (0.0, span)), "right"),
        "east": (((length, 0.0), (length, span)), "left"),
    }


def _opening(key: str, own: Opening, wall: float, course: float) -> walling.Opening:
    """An opening whose sill and soffit are on beds; halves go to the even bed."""
    if not is_present(own.present):
        return walling.Opening(width=value_of(own.width), height=value_of(own.height), present=False)
    low, high = value_of(own.sill), value_of(own.sill) + value_of(own.height)
    if high > wall + course:
        raise InputError(f"{key}: sill and height reach beyond the wall of {wall:.3g} m")
    sill = round(low / course)
    soffit = max(round(high / course), sill + 1)
    tell_moved(key, (low, high), (sill * course, soffit * course))
    number = round(value_of(own.number))
    return walling.Opening(
        width=value_of(own.width), height=(soffit - sill) * course, sill=sill * course, number=number
    )


def _buttress(side: WallName, own: Buttress, course: float) -> walling.Buttress:
    """Buttresses of one stone a course against the outer face; the builder spaces them (Eqs. 3-5 of the paper)."""
    height = value_of(own.height)
    return walling.Buttress(
        wall=side,
        present=is_present(own.present),
        width=value_of(own.width),
        projection=value_of(own.thickness),
        height=height,
        number=round(value_of(own.number)),
        side="right" if side in ("south", "east") else "left",
        bonded=False,
        courses=_courses(height, course),
    )


def _courses(height: float, nominal: float) -> int:
    """The number of equal courses that fill a height, as near the nominal height as fit."""
    return max(round(height / nominal), 1)


def _check_beside_vault(building: Building) -> None:
    """Refuse buttresses higher than their wall where the vault, thicker than the wall, lies over them."""
    vault, wall = building.vault, building.wall
    if vault is None or not is_present(vault.present):
        return
    thick, top = value_of(wall.thickness), value_of(wall.height)
    if value_of(vault.thickness) <= thick * (1 + 1e-9):
        return
    for side in ("south", "north"):
        own = building.buttresses.get(side)
        stand = own is not None and is_present(own.present) and round(value_of(own.number)) > 0
        if own is not None and stand and value_of(own.height) > top * (1 + 1e-9):
            raise InputError(
                f"buttresses.{side}.height: it is {value_of(own.height):g} m; a vault thicker than its wall "
                f"({thick:g} m) lies over them from the springing: they may be up to {top:g} m high"
            )


def _check_size(building: Building) -> None:
    """Refuse too many courses, voussoirs, windows or buttresses, which are lists before they are blocks."""
    length, height = value_of(building.length), value_of(building.wall.height)
    bricks = {"brick": (value_of(building.brick.length), value_of(building.brick.height))}
    round_all = [(0.0, 0.0), (2 * (length + value_of(building.span)), 0.0)]
    run = walling.Run(path=round_all, thickness=value_of(building.wall.thickness), height=height)
    about = blocks_asked("walls", {"runs": {"": run}, **bricks})
    if building.vault is not None:
        voussoirs = round(value_of(building.vault.voussoirs))
        about += blocks_asked("barrel", {"voussoirs": voussoirs, "length": length, "brick": bricks["brick"][0]})
    check_block_count("brick, wall and vault", about)
    for key, tables in (("doors", building.doors), ("windows", building.windows), ("buttresses", building.buttresses)):
        for side, table in tables.items():
            check_block_count(f"{key}.{side}.number", value_of(table.number))
    thickness = value_of(building.wall.thickness)
    if 2 * thickness > length * (1 + 1e-9):
        raise InputError(f"wall.thickness: end walls of {thickness:g} m overlap in a building of {length:g} m length")
