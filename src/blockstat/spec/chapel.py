"""The short form: a rectangular building of walls, openings, buttresses and a barrel vault.

Every constructive parameter is a number or a range {value, min, max, step}; the search moves ranges. Lengths
are in metres. Unknown keys are refused with their path.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from blockstat.spec.material import Joint, Material
from blockstat.spec.ranges import Count, Height, Length, Presence, Range
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
    """Doors or windows of one wall, evenly spaced, each under a lintel; heights snap to whole courses."""

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
    description: str = ""  #: one line

    def __post_init__(self) -> None:
        check_name(self.name)
