"""Buttresses of a wall as stems: strips square to it, with a far end that steps or slopes back."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.arches.profile import at_least, positive
from blockstat.model.walling.brickwork import SLIVER, brickwork
from blockstat.model.walling.heads import tell_moved
from blockstat.model.walling.pattern import Pattern, fitted
from blockstat.model.walling.row import Gap, Row
from blockstat.model.walling.run import Buttress, Run, check_places, one_of, spaced
from blockstat.model.walling.strip import Line, Strip, nearest, upright


@dataclass(frozen=True)
class Stem:
    """One buttress and where it stands."""

    spec: Buttress
    host: int  #: index of its strip of wall
    s: float  #: along that strip [m]
    group: str
    label: str  #: for messages

    @property
    def tied(self) -> bool:
        """Whether it is bonded into the wall."""
        return self.spec.bonded

    @property
    def sign(self) -> float:
        """1 for a buttress on the left of its wall, -1 on the right."""
        return 1.0 if self.spec.side == "left" else -1.0


def stems(strips: Sequence[Strip], buttresses: Sequence[Buttress], absent: Collection[str] = ()) -> Iterator[Stem]:
    """The buttresses of walls one by one.

    Groups are "buttress.<run>.<k>", k from 1 in the order given along each run.

    Parameters
    ----------
    strips : sequence of Strip
        Stretches of wall.
    buttresses : sequence of Buttress
        As they were written.
    absent : collection of str
        Names of runs that are not there, and so have no buttresses.

    Yields
    ------
    Stem
        One buttress and where it stands.

    Raises
    ------
    InputError
        For an unknown wall, or buttresses that do not fit.
    """
    count: dict[str, int] = {}
    for number, spec in enumerate(buttresses):
        if not spec.present or spec.wall in absent:
            continue
        label = f'buttresses[{number}] of wall "{spec.wall}"'
        host = _host(strips, spec, label)
        check_buttress(spec, label)
        length = strips[host].axis.length
        places = spaced(length, spec.count) if spec.at is None else [float(s) for s in spec.at]
        for s in places:
            if not spec.width / 2 <= s <= length - spec.width / 2:
                raise InputError(f"{label}: a width of {spec.width:g} m at {s:g} m does not fit {length:g} m of wall")
        nearby = np.diff(np.sort(places))
        if len(nearby) and nearby.min() < spec.width * (1 - 1e-9):
            raise InputError(
                f"{label}: {len(places)} buttresses of {spec.width:.3g} m width do not fit {length:g} m of wall"
            )
        for s in places:
            k = count[spec.wall] = count.get(spec.wall, 0) + 1
            yield Stem(spec, host, s, f"buttress.{spec.wall}.{k}", label)


def _host(strips: Sequence[Strip], spec: Buttress, label: str) -> int:
    found = [i for i, strip in enumerate(strips) if strip.run.name == spec.wall]
    if not found:
        known = ", ".join(dict.fromkeys(strip.run.name for strip in strips))
        raise InputError(f"{label}: there is no such wall; walls are: {known}")
    if not 0 <= spec.segment < len(found):
        raise InputError(f"{label}: segment is {spec.segment}; its path has {len(found)} stretches")
    return found[spec.segment]


def check_buttress(spec: Buttress, label: str) -> None:
    """Check that a buttress can be built.

    Parameters
    ----------
    spec : Buttress
        As it was written.
    label : str
        What messages call it.

    Raises
    ------
    InputError
        Naming the buttress and what about it cannot be built.
    """
    positive(
        **{f"{label}: width": spec.width, f"{label}: projection": spec.projection, f"{label}: height": spec.height}
    )
    one_of(label, side=(spec.side, ("left", "right")))
    check_places(label, spec)
    if spec.courses is not None:
        at_least(1, **{f"{label}: courses": spec.courses})
        if spec.bonded:
            raise InputError(f"{label}: courses of its own are for a buttress with bonded = false")
    if not 0 <= spec.weathering or not 0 <= spec.rake:
        raise InputError(f"{label}: weathering and rake must be at least 0")


def stem_strip(host: Strip, stem: Stem) -> Strip:
    """The strip of a buttress that shares the beds of its wall.

    Parameters
    ----------
    host : Strip
        The stretch of wall.
    stem : Stem
        The buttress.

    Returns
    -------
    Strip
        Its axis begins on the middle of the wall.

    Raises
    ------
    InputError
        For a buttress that is higher than the walls, or so low that it has no course.

    Warns
    -----
    InputWarning
        With both heights, where it or one of its steps is built higher or lower than asked.
    """
    assert isinstance(host.axis, Line)
    spec, axis, middle = stem.spec, host.axis, (host.right[0] + host.left[0]) / 2
    face = (host.left[0] - host.right[0]) / 2
    origin = axis.origin + stem.s * axis.along + middle * axis.across
    top = nearest(host.levels, spec.height)
    if spec.height > host.levels[-1] + (host.levels[-1] - host.levels[-2]) / 2:
        raise InputError(f"{stem.label}: height is {spec.height:g} m; the walls reach {host.levels[-1]:g} m")
    if not top:
        least = f"it takes at least half of the lowest course, which is {host.levels[1]:.4g} m high"
        raise InputError(f"{stem.label}: height is {spec.height:g} m; {least}")
    tell_moved(stem.label, (0, spec.height), (0, host.levels[top]), "its height goes to the nearest bed")
    return _strip(stem.group, spec, Line(origin, stem.sign * axis.across, 1.0), host.levels, top, face, stem.label)


def coursed_stem(host: Strip, stem: Stem) -> list[Block]:
    """A buttress of one stone a course that stands against its wall, in beds of its own.

    Parameters
    ----------
    host : Strip
        The stretch of wall.
    stem : Stem
        The buttress; it says the number of courses.

    Returns
    -------
    list of Block
        From the ground up.

    Raises
    ------
    InputError
        For a wall whose face has a batter.
    """
    assert isinstance(host.axis, Line)
    spec, axis = stem.spec, host.axis
    face, batter = host.left if spec.side == "left" else host.right
    if batter:
        raise InputError(f"{stem.label}: courses of its own need an upright face; this one has a batter")
    assert spec.courses is not None
    levels = tuple(np.linspace(0.0, spec.height, spec.courses + 1).tolist())
    place = Line(axis.origin + stem.s * axis.along + face * axis.across, stem.sign * axis.across, spec.projection)
    return against_face(spec, place, levels, stem.group, None, stem.label)


def against_face(
    spec: Buttress, place: Line, levels: tuple[float, ...], group: str, brick: float | None, label: str
) -> list[Block]:
    """Blocks of a buttress that stands against an upright face.

    Parameters
    ----------
    spec : Buttress
        Its sizes.
    place : Line
        Its axis, from the face outwards.
    levels : tuple of float
        Heights of the beds [m].
    group : str
        Of the blocks.
    brick : float or None
        Nominal length of its bricks [m]; None for one stone a course.
    label : str
        What messages call it.

    Returns
    -------
    list of Block
        From the ground up.
    """
    strip = _strip(group, spec, place, levels, len(levels) - 1, 0.0, label)
    whole = Pattern("stack", spec.projection, 0.0, 0)
    pattern = whole if brick is None else fitted(strip.run, brick, (0.0, None), (spec.projection, None))
    foot = Gap(upright(0.0), upright(0.0), "the wall")
    rows = []
    for course in range(strip.top):
        end = strip.far_end(course)
        rows.append(Row(strip, course, foot, Gap(end, end, "its end"), pointed=True))
    return brickwork(rows, pattern, SLIVER, {})


def _strip(
    group: str, spec: Buttress, place: Line, levels: tuple[float, ...], top: int, face: float, label: str
) -> Strip:
    """The strip of a buttress whose face is s = face, as long as its foot."""
    run = Run(name=group, path=((0, 0), (0, 1)), thickness=spec.width, height=spec.height)
    ends = _far_end(levels[: top + 1], spec, face, label)
    half = spec.width / 2
    axis = Line(place.origin, place.along, ends[0][1])
    return Strip(run, axis, (-half, 0.0), (half, 0.0), levels, top, top, group, ends=ends)


def _far_end(levels: Sequence[float], spec: Buttress, face: float, label: str) -> tuple[tuple[float, float], ...]:
    """Outline (z, s) of the far end from the ground up, corners on beds, over s = face at its foot [m]."""
    outline = [(0.0, spec.projection)]
    before = spec.projection
    for height, projection in spec.steps:
        low = levels[nearest(levels, height)]
        high = levels[nearest(levels, low + spec.weathering)]
        if not outline[-1][0] <= low < levels[-1] or not 0 <= projection < before:
            raise InputError(f"{label}: steps is {list(spec.steps)!r}; heights must grow and projections decrease")
        ends = 2 if spec.weathering else 1
        asked, built = (height, height + spec.weathering)[:ends], (low, high)[:ends]
        tell_moved(f"{label}: a step", asked, built, "steps go to the nearest bed")
        outline += [(low, before), (high, projection)]
        before = projection
    outline.append((levels[-1], before))
    corners = [(z, face + p - spec.rake * z) for z, p in outline]
    if min(s for _, s in corners) < face - 1e-9 * spec.projection:
        raise InputError(f"{label}: its outer face slopes back into the wall; reduce rake or raise the projection")
    return tuple((float(z), float(s)) for z, s in corners)
