"""What a mason is told about a wall: runs, openings, copings, through-stones, buttresses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from blockstat.errors import InputError
from blockstat.model.arches.profile import at_least, positive

ALIGN = ("centre", "left", "right")
BONDS = ("running", "stack", "english", "flemish")
HEADER_BONDS = ("english", "flemish")  #: with stones through the thickness, so of two leaves at least
HEADS = ("lintel", "flat", "semicircular", "segmental", "pointed", "elliptic")


@dataclass(frozen=True, kw_only=True)
class Opening:
    """One or several equal openings of a run: doors (sill 0) or windows.

    width : clear [m]. height : of the jambs, from the sill to the springing or to the soffit of a lintel [m]; sill and
    springing go to the nearest bed. segment : which stretch of a path with several. at : where their centres are
    along it from its first point [m]; without it `number` of them are evenly spaced, at length x k / (number + 1).
    head : "lintel", "flat" (a jack arch) or the shape of a voussoir arch, with its `rise` [m] (none for
    "semicircular"). depth : of lintel or arch, normal to the soffit [m], by default one course; a lintel's goes to
    whole courses. voussoirs : their number, by default as many as courses are high. bearing : of a lintel on each
    side [m], by default half a brick. skew : of the skewbacks of a flat arch against the vertical [degrees].
    """

    width: float
    height: float
    sill: float = 0.0
    number: int = 1
    at: Sequence[float] | None = None
    segment: int = 0
    head: str = "lintel"
    rise: float | None = None
    depth: float | None = None
    voussoirs: int | None = None
    bearing: float | None = None
    skew: float = 20.0


@dataclass(frozen=True, kw_only=True)
class Coping:
    """The last course, or the slopes of a gable, in longer stones that overhang both faces.

    overhang : beyond each face [m]; length : of the stones [m], by default two bricks; height : of raked stones on
    a gable, normal to the slope [m], by default one course. Raked stones have no kneelers: they slide off a slope that
    is steeper than the angle of friction.
    """

    overhang: float = 0.05
    length: float | None = None
    height: float | None = None


@dataclass(frozen=True, kw_only=True)
class Through:
    """Through-stones of a wall of several leaves: every so many courses, every so many bricks along the course."""

    courses: int = 3
    bricks: int = 3


@dataclass(frozen=True, kw_only=True)
class Run:
    """A straight wall, or a chain of them along a polyline, from z = 0 up.

    name : its group is "wall.<name>". path : points (x, y) [m]; closed : whether the last joins the first.
    thickness, height [m]. align : where the wall lies: the path is its centre line ("centre"), or the wall is to the
    "left" or the "right" of it, looking along the path.
    bond : "running" (each leaf of half-overlapping stretchers), "stack" (head joints above each other), "english"
    (courses of stretchers and of headers in turn) or "flemish" (a stretcher and a header in turn).
    leaves : in the thickness, through which headers and through-stones reach; 2 for English and Flemish bond.
    half : length of the half brick of running bond, as a fraction of a whole one. batter : inward slope of the left
    and of the right face [m per m of height]. gable : height of the ridge above `height` [m], 0 for none.
    """

    name: str
    path: Sequence[Sequence[float]]
    thickness: float
    height: float
    align: str = "centre"
    closed: bool = False
    bond: str = "running"
    leaves: int = 1
    half: float = 0.5
    closers: bool = False
    through: Through | None = None
    batter: tuple[float, float] = (0.0, 0.0)
    gable: float = 0.0
    coping: Coping | None = None
    openings: Sequence[Opening] = ()

    @property
    def leaves_laid(self) -> int:
        """Leaves in the thickness as they are laid."""
        return max(self.leaves, 2) if self.bond in HEADER_BONDS else self.leaves


@dataclass(frozen=True, kw_only=True)
class Buttress:
    """Buttresses of one run, perpendicular to it.

    wall : name of the run; segment : which stretch of its path; side : "left" or "right" of the path, where they stand.
    width : along the wall; projection : from its face; height [m]. number : of evenly spaced ones, at
    length x k / (number + 1) (the procedural-masonry paper, Eqs. 3-5), or at : where their centres are [m].
    bonded : whether every other course passes through the wall; else they stand against it.
    steps : (height, projection) pairs, lowest first: above that height the projection is reduced to that. weathering :
    height over which a step slopes back [m], in whole courses, 0 for a flat step. rake : slope of the outer face
    [m per m of height].
    """

    wall: str
    width: float
    projection: float
    height: float
    number: int = 1
    at: Sequence[float] | None = None
    segment: int = 0
    side: str = "right"
    bonded: bool = True
    courses: int | None = None
    steps: Sequence[tuple[float, float]] = ()
    weathering: float = 0.0
    rake: float = 0.0


def check_run(run: Run) -> None:
    """Raise InputError naming the run and what about it cannot be built."""
    label = f'wall "{run.name}"'
    if not run.name or not isinstance(run.name, str):
        raise InputError(f"name of a run is {run.name!r}; it must be a word")
    positive(**{f"{label}: thickness": run.thickness, f"{label}: height": run.height})
    one_of(label, align=(run.align, ALIGN), bond=(run.bond, BONDS))
    at_least(1, **{f"{label}: leaves": run.leaves})
    if len(run.path) < 2 or any(len(p) != 2 or not all(math.isfinite(c) for c in p) for p in run.path):
        raise InputError(f"{label}: path is {run.path!r}; it must be two or more points [x, y]")
    if not 0.2 <= run.half <= 0.8:
        raise InputError(f"{label}: half is {run.half!r}; it must be a fraction of a brick from 0.2 to 0.8")
    if len(run.batter) != 2 or not all(0 <= b < 1 for b in run.batter):
        raise InputError(f"{label}: batter is {run.batter!r}; it must be two slopes from 0 to 1, left and right face")
    if sum(run.batter) * (run.height + run.gable) >= 0.9 * run.thickness:
        raise InputError(f"{label}: batter {run.batter!r} leaves no thickness at the top")
    if not 0 <= run.gable < math.inf:
        raise InputError(f"{label}: gable is {run.gable!r}; it must be the height of the ridge above the wall [m]")
    if run.gable and (len(run.path) > 2 or run.closed):
        raise InputError(f"{label}: a gable needs a straight path of two points")
    if run.coping is not None and not run.coping.overhang >= 0:
        raise InputError(f"{label}: coping.overhang is {run.coping.overhang!r}; it must be at least 0 [m]")
    if run.through is not None:
        at_least(1, **{f"{label}: through.courses": run.through.courses})
        at_least(2, **{f"{label}: through.bricks": run.through.bricks})
        if run.leaves < 2 or run.bond not in ("running", "stack"):
            raise InputError(f"{label}: through-stones need several leaves in running or stack bond")
    for k, opening in enumerate(run.openings):
        check_opening(f"{label}: openings[{k}]", opening)


def check_opening(label: str, opening: Opening) -> None:
    """Raise InputError naming the opening."""
    positive(**{f"{label}: width": opening.width, f"{label}: height": opening.height})
    one_of(label, head=(opening.head, HEADS))
    at_least(0, **{f"{label}: number": opening.number})
    if not 0 <= opening.sill < math.inf:
        raise InputError(f"{label}: sill is {opening.sill!r}; it must be a height of at least 0 [m]")
    of_heads = {
        "rise": ("segmental", "pointed", "elliptic", "semicircular"),
        "voussoirs": tuple(head for head in HEADS if head != "lintel"),
        "bearing": ("lintel",),
    }
    for key, allowed in of_heads.items():
        if getattr(opening, key) is not None and opening.head not in allowed:
            raise InputError(
                f"{label}: {key} says nothing about a {opening.head} head; it is for: {', '.join(allowed)}"
            )


def one_of(label: str, **words: tuple[str, Sequence[str]]) -> None:
    """Raise InputError for a word that is not among those allowed."""
    for key, (given, allowed) in words.items():
        if given not in allowed:
            raise InputError(f"{label}: {key} is {given!r}; it must be one of: {', '.join(allowed)}")


def spaced(length: float, number: int) -> list[float]:
    """Centres of things evenly spaced along a wall [m].

    DistanceAmongButtresses = LongitudeRow / (number + 1), centred between the wall's ends (the procedural-masonry
    paper, Eqs. 3-5).
    """
    return [length * (k + 1) / (number + 1) for k in range(number)]
