"""What a mason is told about a wall: runs, openings, copings, through-stones, buttresses.

These records are the tables of a scene file and the arguments of `walls` alike.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import msgspec

from blockstat.errors import InputError, check_choice, with_article
from blockstat.model.arches.profile import at_least, positive
from blockstat.model.quantities import Count, Ends, Length, Number, Size, Two

ALIGN = ("centre", "left", "right")
BONDS = ("running", "stack", "english", "flemish")
HEADER_BONDS = ("english", "flemish")  #: with stones through the thickness, so of two leaves at least
#: Of openings and buttresses.
EITHER = "give either number (evenly spaced) or at (where their centres are)"
HEADS = ("lintel", "flat", "semicircular", "segmental", "pointed", "elliptic")


class Opening(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """One or several equal openings of a run; sill and springing go to the nearest bed.

    Doors have their sill at 0. Evenly spaced ones are at length x k / (number + 1).
    """

    present: bool = True  #: true, false or "search"
    width: Length  #: clear [m]
    height: Length  #: of the jambs, from the sill to the springing or to the soffit of a lintel [m]
    sill: Size = 0.0  #: above the ground, 0 for a door [m]
    number: Number | None = None  #: evenly spaced along the run, by default 1
    at: Sequence[float] | None = None  #: or where their centres are, along the stretch from its first point [m]
    segment: int = 0  #: which stretch of a path with several, 0 for the first
    head: str = "lintel"  #: lintel, flat, semicircular, segmental, pointed or elliptic
    rise: Length | None = None  #: of an arch [m]; none for semicircular
    depth: Length | None = None  #: of lintel or arch, normal to the soffit, by default one course [m]
    voussoirs: Count | None = None  #: their number, by default as many as courses are high
    bearing: Length | None = None  #: of a lintel on each side, by default half a brick [m]
    skew: float | None = None  #: of the skewbacks of a flat arch against the vertical, by default 20 [degrees]

    @property
    def count(self) -> int:
        """How many openings they are."""
        return _count(self.number, self.at)


class Coping(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """The last course, or the slopes of a gable, in longer stones that overhang both faces.

    Raked stones have no kneelers: they slide off a slope that is steeper than the angle of friction.
    """

    overhang: Size = 0.05  #: beyond each face [m]
    length: Length | None = None  #: of the stones, by default two bricks; of a round wall up to 45 degrees [m]
    height: Length | None = None  #: of raked stones on a gable, normal to the slope, by default one course [m]


class Through(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """Through-stones of a wall of several leaves."""

    courses: Count = 3  #: every so many courses
    bricks: Two = 3  #: every so many bricks along the course


class Run(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """A straight wall, or a chain of them along a polyline, from z = 0 up.

    Bonds: "running" (each leaf of half-overlapping stretchers), "stack" (head joints above each other), "english"
    (courses of stretchers and of headers in turn) or "flemish" (a stretcher and a header in turn). Headers and
    through-stones reach through all leaves.
    """

    name: str = ""  #: its group is "wall.<name>"; in a scene the key of its table
    present: bool = True  #: true, false or "search"
    path: Sequence[Ends]  #: points x, y [m]
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
    openings: Sequence[Opening] = ()  #: doors and windows

    @property
    def leaves_laid(self) -> int:
        """Leaves in the thickness as they are laid."""
        return max(self.leaves, 2) if self.bond in HEADER_BONDS else self.leaves


class Buttress(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """Buttresses of one run, perpendicular to it.

    A bonded one passes through the wall in every other course; else it stands against the wall. Its height and its
    steps go to the nearest bed of the wall; one with courses of its own is as high as asked.
    """

    present: bool = True  #: true, false or "search"
    wall: str  #: name of the run
    width: Length  #: along the wall [m]
    projection: Length  #: from its face [m]
    height: Length  #: [m]
    number: Number | None = None  #: evenly spaced, by Eqs. 3-5 of the procedural-masonry paper, by default 1
    at: Sequence[float] | None = None  #: or where their centres are, along the stretch from its first point [m]
    segment: int = 0  #: which stretch of a path with several, 0 for the first
    side: Literal["left", "right"] = "right"  #: of the path
    bonded: bool = True  #: into the wall, or standing against it
    courses: Count | None = None  #: of one stone each with beds of its own, where it stands against an upright face
    steps: Sequence[Ends] = ()  #: height and projection above it, lowest first [m]
    weathering: Size = 0.0  #: height over which a step slopes back, in whole courses, 0 for a flat step [m]
    rake: Size = 0.0  #: slope of the outer face [m per m of height]

    @property
    def count(self) -> int:
        """How many buttresses they are."""
        return _count(self.number, self.at)


def _count(number: int | None, at: Sequence[float] | None) -> int:
    if at is not None:
        return len(at)
    return 1 if number is None else number


def check_run(run: Run) -> None:
    """Check that a run can be built.

    Parameters
    ----------
    run : Run
        As it was written.

    Raises
    ------
    InputError
        Naming the run and what about it cannot be built.
    """
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
    _check_top(run, label)
    if run.through is not None:
        at_least(1, **{f"{label}: through.courses": run.through.courses})
        at_least(2, **{f"{label}: through.bricks": run.through.bricks})
        if run.leaves < 2 or run.bond not in ("running", "stack"):
            raise InputError(f"{label}: through-stones need several leaves in running or stack bond")
    for k, opening in enumerate(run.openings):
        if opening.present:
            check_opening(f"{label}: openings[{k}]", opening)


def _check_top(run: Run, label: str) -> None:
    if not 0 <= run.gable < math.inf:
        raise InputError(f"{label}: gable is {run.gable!r}; it must be the height of the ridge above the wall [m]")
    if run.gable and (len(run.path) > 2 or run.closed):
        raise InputError(f"{label}: a gable needs a straight path of two points")
    if run.coping is not None and not run.coping.overhang >= 0:
        raise InputError(f"{label}: coping.overhang is {run.coping.overhang!r}; it must be at least 0 [m]")


def check_opening(label: str, opening: Opening) -> None:
    """Check that an opening can be built.

    Parameters
    ----------
    label : str
        What messages call it.
    opening : Opening
        As it was written.

    Raises
    ------
    InputError
        Naming the opening.
    """
    positive(**{f"{label}: width": opening.width, f"{label}: height": opening.height})
    one_of(label, head=(opening.head, HEADS))
    check_places(label, opening)
    if not 0 <= opening.sill < math.inf:
        raise InputError(f"{label}: sill is {opening.sill!r}; it must be a height of at least 0 [m]")
    of_heads = {
        "rise": ("segmental", "pointed", "elliptic", "semicircular"),
        "voussoirs": tuple(head for head in HEADS if head != "lintel"),
        "bearing": ("lintel",),
        "skew": ("flat",),
    }
    for key, allowed in of_heads.items():
        if getattr(opening, key) is not None and opening.head not in allowed:
            raise InputError(
                f"{label}: {key} says nothing about {with_article(opening.head)} head; it is for: {', '.join(allowed)}"
            )


def check_places(label: str, these: Opening | Buttress) -> None:
    """Check the number of openings or buttresses, and that it is that of the places where they are put.

    Parameters
    ----------
    label : str
        What messages call it.
    these : Opening or Buttress
        As it was written.

    Raises
    ------
    InputError
        For a number below 0, or beside a list of another length.
    """
    if these.number is None:
        return
    at_least(0, **{f"{label}: number": these.number})
    if these.at is not None and these.number != len(these.at):
        raise InputError(f"{label}: number is {these.number}, and the list of at has {len(these.at)}; {EITHER}")


def one_of(label: str, **words: tuple[str, Sequence[str]]) -> None:
    """Check words against those allowed.

    Parameters
    ----------
    label : str
        What messages call the whole.
    **words : tuple
        By key: the word given, and those allowed.

    Raises
    ------
    InputError
        For a word that is not among them.
    """
    for key, (given, allowed) in words.items():
        check_choice(f"{label}: {key}", given, allowed)


def spaced(length: float, number: int) -> list[float]:
    """Centres of things evenly spaced along a wall.

    DistanceAmongButtresses = LongitudeRow / (number + 1), centred between the wall's ends (the procedural-masonry
    paper, Eqs. 3-5).

    Parameters
    ----------
    length : float
        Of the wall [m].
    number : int
        Of the things.

    Returns
    -------
    list of float
        Distances from the beginning of the wall [m].

    Examples
    --------
    >>> spaced(6.0, 2)
    [2.0, 4.0]
    """
    return [length * (k + 1) / (number + 1) for k in range(number)]
