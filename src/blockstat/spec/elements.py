"""The kinds of element that a composition is made of: their keys are the options of the builders in `blockstat.model`.

Each element is built about its own origin, then turned, moved and repeated as its keys of placing say.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from blockstat.spec.element import Count, Element, Ends, Length, Size
from blockstat.spec.walls import ArcWall, Buttress, Walls

Bond = Literal["running", "stack"]
Groins = Literal["solid", "mitred"]
Edge = Literal["south", "north", "west", "east"]
EDGES: tuple[Edge, ...] = ("south", "north", "west", "east")


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
    bond: Literal["single", "halves"] = "single"  #: one stone a course, or two with a joint across x and y in turn
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
    groins: Groins = "solid"  #: stones of both webs in one, or a joint in the diagonal plane
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
    bond: Bond = "running"  #: staggered, or with continuous meridian joints
    springers: Size = 0.0  #: height of the blocks under the first ring, 0 for none [m]


class Rib(Element, tag="rib", kw_only=True, frozen=True):
    """A rib under a barrel vault that spans x; its extrados corners are the corners of the vault's intrados."""

    shape: str = "semicircular"  #: of the vault above
    span: Length  #: of the vault above [m]
    rise: Length | None = None  #: of the vault above [m]
    thickness: Length  #: inwards from the vault's intrados [m]
    depth: Length  #: along y [m]
    voussoirs: int | None = None  #: of the vault above
    voussoir: Length | None = None  #: or their length along the vault's intrados [m]
    springers: Size = 0.0  #: height of the blocks under the springings, 0 for none [m]


class Drum(Element, tag="drum", kw_only=True, frozen=True):
    """The round wall under a dome of the same span and voussoirs, from z = 0 up, about its origin."""

    span: Length  #: clear diameter [m]
    thickness: Length  #: [m]
    height: Length  #: [m]
    courses: Count  #: their number
    voussoirs: Annotated[int, msgspec.Meta(ge=3)]  #: stones in each course
    bond: Bond = "running"  #: staggered, or with continuous joints


class Sail(Element, tag="sail", kw_only=True, frozen=True):
    """A sail vault: a sphere over a rectangle through its corners at z = 0, centred on its origin."""

    spans: tuple[Length, Length]  #: along x and y [m]
    rise: Length  #: of the crown above the corners [m]
    thickness: Length  #: normal to the sphere, which is the middle surface [m]
    courses: Annotated[int, msgspec.Meta(ge=2)]  #: along y
    voussoirs: Count  #: in each course
    supports: tuple[Edge, ...] = EDGES  #: edges that have springers
    springers: Size = 0.0  #: length of the blocks beyond these edges, 0 for none [m]


class Fan(Element, tag="fan", kw_only=True, frozen=True):
    """A fan vault: four conoids about the corners of a bay, springing at z = 0, centred on its origin."""

    spans: tuple[Length, Length]  #: between the axes of the conoids, along x and y [m]
    rise: Length  #: of the intrados at the middle of the bay [m]
    thickness: Length  #: normal to the surface [m]
    foot: Length  #: radius of the conoids' intrados at the springing, at least the thickness [m]
    rings: Annotated[int, msgspec.Meta(ge=2)]  #: of each quarter conoid
    voussoirs: Annotated[int, msgspec.Meta(ge=2)]  #: in each ring of a quarter, an even number
    springers: Size = 0.0  #: height of the blocks under the conoids, 0 for none [m]


class Freeform(Element, tag="freeform", kw_only=True, frozen=True):
    """A vault in bonded courses over a surface above a rectangle: a formula, or a mesh file."""

    height: str | None = None  #: of the middle surface [m], arithmetic over x, y and the constants: "2 * (1 - y ** 2)"
    constants: dict[str, float] = msgspec.field(default_factory=dict)  #: names that the formula may use
    file: str | None = None  #: or a mesh of it, beside the scene: .obj, .ply, .stl or .glb
    units: str = "m"  #: of the file
    x: Ends | None = None  #: ends of the rectangle [m]; by default those of the mesh
    y: Ends | None = None  #: ends of the rectangle [m]; by default those of the mesh
    courses: Annotated[int, msgspec.Meta(ge=2)]  #: along y
    voussoirs: Count  #: in each course, along x
    thickness: Length  #: normal to the surface [m]
    supports: tuple[Edge, ...] = ("south", "north")  #: edges that have springers
    springers: Size = 0.0  #: length of the blocks beyond these edges, 0 for none [m]
    bond: Bond = "running"  #: staggered, or with continuous joints


class MeshVault(Element, tag="mesh_vault", kw_only=True, frozen=True):
    """A vault whose voussoirs are the faces of a mesh, with joints normal to it."""

    file: str  #: the middle surface, beside the scene: .obj (polygons), .ply, .stl or .glb
    units: str = "m"  #: of the file
    thickness: Length  #: normal to the surface [m]
    supports: Literal["lowest", "all"] = "lowest"  #: edges of the boundary that have springers
    springers: Size = 0.0  #: length of the blocks beyond these edges, 0 for none [m]


class Mesh(Element, tag="mesh", kw_only=True, frozen=True):
    """Blocks of a file, as they are."""

    file: str  #: beside the scene: .json, .obj, .glb, .stl, .ply or a directory, one solid a block
    units: str | None = None  #: of the file, by default metres


class FlyingButtress(Element, tag="flying_buttress", kw_only=True, frozen=True):
    """A raking arch in the plane x, z from a wall's face at x = 0 to a pier's face at x = span."""

    form: str = "arc"  #: a ring whose soffit is level at the wall, or a "straight" strut
    span: Length  #: clear between the faces [m]
    low: Size  #: height of the soffit at the pier [m]
    high: Length  #: height of the soffit at the wall [m]
    depth: Length  #: of the voussoirs, normal to the soffit [m]
    width: Length  #: along y [m]
    voussoirs: Annotated[int, msgspec.Meta(ge=2)]  #: their number
    pier: tuple[Length, Length] | None = None  #: its size along x and y, none by default [m]
    pier_height: Length | None = None  #: by default the top of the flyer there [m]
    courses: Count = 1  #: of the pier
    pinnacle: Size = 0.0  #: height of a block that weighs the pier down, 0 for none [m]


KIND_LIST: tuple[type[Element], ...] = (
    Walls, ArcWall, Buttress, FlyingButtress, Box, Column, Pier, Arch, JackArch, Rib, Barrel, Groin, Pavilion, Dome,
    Drum, Sail, Fan, Freeform, MeshVault, Mesh,
)  # fmt: skip
KINDS: dict[str, type[Element]] = {str(kind.__struct_config__.tag): kind for kind in KIND_LIST}
