"""Walls of many runs: the keys of the element "walls"."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from blockstat.spec.element import Count, Element, Ends, Length, Size


class WallOpening(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """One or several equal openings of a run; sill and springing go to the nearest bed."""

    present: bool = True  #: true, false or "search"
    width: Length  #: clear [m]
    height: Length  #: of the jambs, from the sill to the springing or to the soffit of a lintel [m]
    sill: Size = 0.0  #: above the ground, 0 for a door [m]
    number: Annotated[int, msgspec.Meta(ge=0)] = 1  #: evenly spaced along the run
    at: tuple[float, ...] | None = None  #: or where their centres are along the run from its first point [m]
    segment: int = 0  #: which stretch of a path with several
    head: str = "lintel"  #: lintel, flat, semicircular, segmental, pointed or elliptic
    rise: Length | None = None  #: of an arch [m]; none for semicircular
    depth: Length | None = None  #: of lintel or arch, by default one course [m]
    voussoirs: Count | None = None  #: their number, by default as many as courses are high
    bearing: Length | None = None  #: of a lintel on each side, by default half a brick [m]
    skew: float = 20.0  #: of the skewbacks of a flat arch against the vertical [degrees]


class Coping(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """The last course, or the slopes of a gable, in longer stones that overhang both faces."""

    overhang: Size = 0.05  #: beyond each face [m]
    length: Length | None = None  #: of the stones, by default two bricks [m]
    height: Length | None = None  #: of raked stones on a gable, by default one course [m]


class Through(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """Through-stones of a wall of several leaves."""

    courses: Count = 3  #: every so many courses
    bricks: Annotated[int, msgspec.Meta(ge=2)] = 3  #: every so many bricks along the course


class Run(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """A straight wall, or a chain of them along a polyline."""

    present: bool = True  #: true, false or "search"
    path: tuple[Ends, ...]  #: points x, y [m]
    thickness: Length  #: [m]
    height: Length  #: [m]
    align: Literal["centre", "left", "right"] = "centre"  #: where the wall lies, looking along the path
    closed: bool = False  #: whether the last point joins the first
    bond: Literal["running", "stack", "english", "flemish"] = "running"  #: how its bricks are laid
    leaves: Count = 1  #: in the thickness; 2 for English and Flemish bond
    half: float = 0.5  #: length of the half brick of running bond, as a fraction of a whole one
    closers: bool = False  #: whether a stretch too narrow for a brick is one cut stone; otherwise it is refused
    through: Through | None = None  #: through-stones
    batter: Ends = (0.0, 0.0)  #: inward slope of the left and of the right face [m per m of height]
    gable: Size = 0.0  #: height of the ridge above the height, 0 for none [m]
    coping: Coping | None = None  #: longer stones on top
    openings: tuple[WallOpening, ...] = ()  #: doors and windows


class WallButtress(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """Buttresses of one run, perpendicular to it."""

    present: bool = True  #: true, false or "search"
    wall: str  #: name of the run
    width: Length  #: along the wall [m]
    projection: Length  #: from its face [m]
    height: Length  #: [m]
    number: Annotated[int, msgspec.Meta(ge=0)] = 1  #: evenly spaced, by Eqs. 3-5 of the procedural-masonry paper
    at: tuple[float, ...] | None = None  #: or where their centres are along the run from its first point [m]
    segment: int = 0  #: which stretch of a path with several
    side: Literal["left", "right"] = "right"  #: of the path
    bonded: bool = True  #: into the wall, or standing against it
    courses: Count | None = None  #: of one stone each with beds of its own, where it stands against an upright face
    steps: tuple[Ends, ...] = ()  #: height and projection above it, lowest first [m]
    weathering: Size = 0.0  #: height over which a step slopes back [m]
    rake: Size = 0.0  #: slope of the outer face [m per m of height]


class Walls(Element, tag="walls", kw_only=True, frozen=True):
    """Walls from z = 0 up, bonded at their corners and T-junctions."""

    runs: dict[str, Run]  #: by name; of two that meet, the first has the corner stone of the lowest course
    brick: tuple[Length, Length] = (0.5, 0.25)  #: nominal length and height [m]
    buttresses: tuple[WallButtress, ...] = ()  #: of the runs
    bonded: bool = True  #: false leaves straight joints where runs meet
    sliver: float = 1 / 3  #: a rest shorter than this fraction of a brick is joined to its neighbour


class ArcWall(Element, tag="arc_wall", kw_only=True, frozen=True):
    """A round wall from z = 0 up about its origin: an apse, or with a full turn a tower."""

    radius: Length  #: of the middle of the wall [m]
    start: float = 0.0  #: angle from the x axis, counter-clockwise [degrees]
    end: float = 360.0  #: 360 beyond the start for a closed ring [degrees]
    tails: tuple[Size, Size] = (0.0, 0.0)  #: lengths of straight stretches before and after the arc [m]
    thickness: Length  #: [m]
    height: Length  #: [m]
    brick: tuple[Length, Length] = (0.5, 0.25)  #: nominal length and height [m]
    bond: Literal["running", "stack", "english", "flemish"] = "running"  #: how its bricks are laid
    leaves: Count = 1  #: in the thickness; 2 for English and Flemish bond
    half: float = 0.5  #: length of the half brick of running bond, as a fraction of a whole one
    through: Through | None = None  #: through-stones
    batter: Ends = (0.0, 0.0)  #: inward slope of the inner and of the outer face [m per m of height]
    coping: Coping | None = None  #: longer stones on top
    openings: tuple[WallOpening, ...] = ()  #: doors and windows under lintels
    sliver: float = 1 / 3  #: a rest shorter than this fraction of a brick is joined to its neighbour


class Buttress(Element, tag="buttress", kw_only=True, frozen=True):
    """A buttress that stands against an upright face in the plane y = 0, centred on its origin, towards y > 0."""

    width: Length  #: along x [m]
    projection: Length  #: along y [m]
    height: Length  #: [m]
    steps: tuple[Ends, ...] = ()  #: height and projection above it, lowest first [m]
    weathering: Size = 0.0  #: height over which a step slopes back [m]
    rake: Size = 0.0  #: slope of the outer face [m per m of height]
    brick: tuple[Length, Length] = (0.5, 0.25)  #: nominal length and height of its stones [m]
