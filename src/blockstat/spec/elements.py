"""The kinds of element that a composition is made of: their keys are the options of the builders in `blockstat.model`.

Each element is built about its own origin, then turned, moved and repeated as its keys of placing say.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Length = Annotated[float, msgspec.Meta(gt=0)]
Size = Annotated[float, msgspec.Meta(ge=0)]
Count = Annotated[int, msgspec.Meta(ge=1)]
Ends = tuple[float, float]
Point = tuple[float, float, float]
Bond = Literal["running", "stack"]
Groins = Literal["solid", "mitred"]
Edge = Literal["south", "north", "west", "east"]


class Repeat(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Copies in a row or round a vertical axis: copy k is turned by k x turn about a point, and moved by k x by."""

    number: Count  #: of copies, the first included
    by: Point = (0.0, 0.0, 0.0)  #: step from one to the next [m]
    turn: float = 0.0  #: from one to the next, counter-clockwise seen from above [degrees]
    about: Ends = (0.0, 0.0)  #: x and y of the axis of turning [m]


class Element(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True, tag_field="kind"):
    """Keys that every element has."""

    present: bool = True  #: true, false or "search"; an element that is not there makes no block
    at: Point = (0.0, 0.0, 0.0)  #: where the element's origin goes: x, y, z [m]
    turn: float = 0.0  #: about the vertical through its origin, counter-clockwise seen from above [degrees]
    repeat: Repeat | tuple[Repeat, ...] = ()  #: copies; of several, each repeats what the one before made
    density: Length | None = None  #: [kg/m3], by default the material's


class Box(Element, tag="box", kw_only=True, frozen=True):
    """One block from z = 0 up, centred on its origin: an abutment, an abacus, a statue."""

    size: tuple[Length, Length, Length]  #: along x, y and z [m]


class Column(Element, tag="column", kw_only=True, frozen=True):
    """A round column of drums from z = 0 up, about its origin."""

    diameter: Length  #: at the foot, of the circle round its polygon [m]
    height: Length  #: [m]
    drums: Count  #: their number
    sides: Annotated[int, msgspec.Meta(ge=3)] = 16  #: of the polygon
    top: Length | None = None  #: diameter at the top, by default that of the foot [m]
    plinth: Size = 0.0  #: height of the block under the foot, 0 for none [m]


class Pier(Element, tag="pier", kw_only=True, frozen=True):
    """A rectangular pier of courses from z = 0 up, centred on its origin."""

    size: tuple[Length, Length]  #: along x and y [m]
    height: Length  #: [m]
    courses: Count  #: their number
    bond: Literal["single", "halves"] = "single"  #: one stone a course, or two with their joint across x and y in turn
    plinth: Size = 0.0  #: height of the block under the foot, 0 for none [m]


class Arch(Element, tag="arch", kw_only=True, frozen=True):
    """An arch in the plane x, z, springing at z = 0, centred on its origin."""

    shape: str = "semicircular"  #: semicircular, segmental, horseshoe, pointed or elliptic
    span: Length  #: clear, at the intrados [m]
    rise: Length | None = None  #: at the intrados [m]; not for semicircular
    thickness: Length  #: normal to the intrados [m]
    depth: Length  #: along y [m]
    voussoirs: int | None = None  #: their number
    voussoir: Length | None = None  #: or their length along the intrados [m]
    joints: str = "radial"  #: radial or vertical
    springers: Size = 0.0  #: height of the blocks under the springings, 0 for none [m]


class JackArch(Element, tag="jack_arch", kw_only=True, frozen=True):
    """A flat arch in the plane x, z, its intrados at z = 0, centred on its origin."""

    span: Length  #: clear, at the intrados [m]
    thickness: Length  #: its height [m]
    depth: Length  #: along y [m]
    voussoirs: Count  #: their number
    skew: float = 20.0  #: of the skewbacks against the vertical [degrees]
    springers: Size = 0.0  #: height of the blocks with the skewbacks, 0 for none [m]


class Barrel(Element, tag="barrel", kw_only=True, frozen=True):
    """A barrel vault along x, springing at z = 0, centred on its origin."""

    shape: str = "semicircular"  #: as of an arch
    span: Length  #: clear, along y [m]
    length: Length  #: along x [m]
    rise: Length | None = None  #: at the intrados [m]; not for semicircular
    thickness: Length  #: normal to the intrados [m]
    brick: Length  #: nominal length of a voussoir along x [m]
    voussoirs: int | None = None  #: number of courses
    voussoir: Length | None = None  #: or their length along the intrados [m]
    springers: Size = 0.0  #: height of the blocks under the springings, 0 for none [m]


class Bay(Element, kw_only=True, frozen=True):
    """Keys of groin and pavilion vaults."""

    shape: str = "semicircular"  #: of the profile along x, as of an arch; not horseshoe
    spans: tuple[Length, Length]  #: clear, along x and y [m]
    rise: Length | None = None  #: at the intrados [m]; not for semicircular
    thickness: Length  #: normal to the intrados, where the profile is that along x [m]
    voussoirs: Annotated[int, msgspec.Meta(ge=3)]  #: number of courses of a whole barrel
    brick: Length  #: nominal length of a voussoir along its course [m]
    groins: Groins = "solid"  #: stones of both webs, or a joint in the diagonal plane
    springers: Size = 0.0  #: height of the blocks under the springings, 0 for none [m]


class Groin(Bay, tag="groin", kw_only=True, frozen=True):
    """A groin (cross) vault over a bay, springing at z = 0 from its corners, centred on its origin."""


class Pavilion(Bay, tag="pavilion", kw_only=True, frozen=True):
    """A pavilion (cloister) vault over a bay, springing at z = 0 from its sides, centred on its origin."""


class Dome(Element, tag="dome", kw_only=True, frozen=True):
    """A dome about its origin, springing at z = 0."""

    shape: str = "semicircular"  #: of a meridian section, as of an arch
    span: Length  #: clear diameter [m]
    rise: Length | None = None  #: at the intrados [m]; not for semicircular
    thickness: Length  #: normal to the intrados [m]
    rings: Count  #: of equal height along the intrados
    voussoirs: Annotated[int, msgspec.Meta(ge=3)]  #: in each ring
    oculus: Size = 0.0  #: clear diameter of the opening at the crown, 0 for a keystone [m]
    bond: Bond = "running"  #: or stack, for continuous meridian joints
    springers: Size = 0.0  #: height of the blocks under the first ring, 0 for none [m]


KIND_LIST: tuple[type[Element], ...] = (Box, Column, Pier, Arch, JackArch, Barrel, Groin, Pavilion, Dome)
KINDS: dict[str, type[Element]] = {str(kind.__struct_config__.tag): kind for kind in KIND_LIST}


def repeats_of(element: Element) -> tuple[Repeat, ...]:
    """The repetitions of an element, none or several."""
    return (element.repeat,) if isinstance(element.repeat, Repeat) else element.repeat
