"""Walls along an arc: wedge-shaped bricks between radial head joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from msgspec.structs import replace as replace_keys

from blockstat.assembly import Block
from blockstat.errors import InputError, no_such
from blockstat.model.arches.profile import positive
from blockstat.model.quantities import Length, Lengths, Size
from blockstat.model.walling.brickwork import SLIVER, brickwork, head_stones
from blockstat.model.walling.heads import Head, bearing_of, heads
from blockstat.model.walling.pattern import HEADER, Pattern, fitted
from blockstat.model.walling.row import Gap, Row
from blockstat.model.walling.run import Run
from blockstat.model.walling.strip import Edge, Ring, Strip, bed_levels, upright
from blockstat.model.walling.walls import check_sizes

#: Keys of a run that say nothing about a round one.
STRAIGHT = ("name", "present", "path", "align", "closed", "gable")
#: Angle of one brick, lintel or coping stone: a straight side of it is then inside the thickness.
WIDEST = math.radians(60.0)
LEAST_BEARING = 0.25  #: of half a brick: to so little the bearing of a lintel is shortened where none is asked


def arc_wall(
    name: str = "round",
    *,
    centre: Sequence[float] = (0.0, 0.0),
    radius: Length,
    start: float = 0.0,
    end: float = 360.0,
    tails: tuple[Size, Size] = (0.0, 0.0),
    brick: Lengths = (0.5, 0.25),
    sliver: float = SLIVER,
    **options: Any,
) -> list[Block]:
    """A round wall from z = 0 up about its origin: an apse, or with a full turn a tower.

    Bricks have straight sides; their corners lie on the two circles. Joints of all leaves are above each other in plan,
    so that their straight sides match. Openings have jambs towards the centre and lintels; `Opening.at` is measured
    along the middle of the wall from its start. The batter is that of the inner and of the outer face.

    Parameters
    ----------
    name : str
        Of its group "wall.<name>".
    centre : sequence of float
        x and y of the middle of the arc [m].
    radius : float
        Of the middle of the wall [m].
    start : float
        Angle from the x axis, counter-clockwise [degrees].
    end : float
        360 beyond the start for a closed ring [degrees].
    tails : tuple of float
        Lengths of straight stretches before and after the arc, along its tangents and in the same bond [m].
    brick : tuple of float
        Nominal length and height [m].
    sliver : float
        A rest shorter than this fraction of a brick is joined to its neighbour.
    **options
        Those of `Run`: thickness, height, bond, leaves, half, closers, through, batter, coping and openings.

    Returns
    -------
    list of Block
        Groups "wall.<name>", "wall.<name>.lintel" and "wall.<name>.coping".

    Raises
    ------
    InputError
        Naming the option that cannot be built, or does not exist.
    """
    known = set(Run.__struct_fields__) - set(STRAIGHT)
    for key in options:
        if key not in known:
            raise InputError(f"arc_wall: {no_such('option', key, sorted(known))}")
    for key in ("thickness", "height"):
        if key not in options:
            raise InputError(f"arc_wall: {key} is missing; a round wall needs one [m]")
    run = Run(name=name, path=[(0.0, 0.0), (1.0, 0.0)], **options)
    check_sizes([run], brick, sliver)
    strip = _strip(run, centre, radius, (start, end), tails, bed_levels([run.height], brick[1], sliver))
    closed = math.isclose(end - start, 360.0)
    pattern = _closed(strip, brick[0]) if closed else fitted(run, brick[0], (0.0, None), (strip.axis.length, None))
    pattern = replace(pattern, staggered=False)
    if pattern.brick / radius > WIDEST:
        raise InputError(f'wall "{name}": bricks of {pattern.brick:.3g} m are too long for a radius of {radius:g} m')
    strip = _with_coping(_with_bearings(strip, pattern.brick, radius), pattern.brick, radius, sliver)
    found = heads(strip, pattern.brick, brick[1])
    rows = [_row(strip, course, found, pattern, closed) for course in range(strip.top)]
    return brickwork(rows, pattern, sliver, {}, round_the_ring=closed) + head_stones(strip, found, {})


def _strip(
    run: Run,
    centre: Sequence[float],
    radius: float,
    angles: tuple[float, float],
    tails: tuple[float, float],
    levels: tuple[float, ...],
) -> Strip:
    positive(radius=radius)
    label, t = f'wall "{run.name}"', run.thickness
    if not radius > t / 2:
        raise InputError(f"{label}: radius is {radius:g}; it must be more than half the thickness, {t / 2:g} m")
    turn = angles[1] - angles[0]
    if not 0 < turn <= 360 * (1 + 1e-12):
        raise InputError(f"{label}: start is {angles[0]:g} and end {angles[1]:g}; end must be up to 360 degrees beyond")
    if len(tails) != 2 or not all(0 <= tail < math.inf for tail in tails):
        raise InputError(f"{label}: tails is {tails!r}; it must be two lengths of at least 0 [m]")
    if any(tails) and turn > 180:
        raise InputError(f"{label}: tails of an arc of more than 180 degrees run into each other")
    if any(tails) and any(run.batter) and run.leaves_laid > 1:
        raise InputError(
            f"{label}: batter is {list(run.batter)!r}; a wall with tails has one only where it is of one leaf: leaves "
            "that pass the ends of the arc would overlap"
        )
    for k, opening in enumerate(run.openings):
        if not opening.present:
            continue
        if opening.segment:
            raise InputError(f"{label}: openings[{k}]: segment is {opening.segment}; a round wall has one, 0")
        if opening.head != "lintel":
            raise InputError(f"{label}: openings[{k}]: head is {opening.head!r}; a round wall has lintels only")
    axis = Ring(np.array(centre, dtype=float), radius, math.radians(angles[0]), radius * math.radians(turn), tails)
    left, right = run.batter
    top = len(levels) - 1
    return Strip(run, axis, (-t / 2, right), (t / 2, -left), levels, top, top, f"wall.{run.name}")


def _with_bearings(strip: Strip, brick: float, radius: float) -> Strip:
    """The strip with the bearings of its lintels said, by default as short as the radius needs."""
    run, most, openings = strip.run, WIDEST * radius, []
    for k, opening in enumerate(run.openings):
        bearing = bearing_of(opening, brick)
        if opening.bearing is None:
            bearing = max(min(bearing, (most - opening.width) / 2), bearing * LEAST_BEARING)
        if opening.present and opening.count and opening.width + 2 * bearing > most:
            raise InputError(
                f'wall "{run.name}": openings[{k}]: width is {opening.width:g} and bearing {bearing:.3g}; the lintel '
                f"is too long for the radius: width and two bearings must be up to {most:.3g} m together"
            )
        openings.append(replace_keys(opening, bearing=bearing))
    return replace(strip, run=replace_keys(run, openings=openings))


def _with_coping(strip: Strip, brick: float, radius: float, sliver: float) -> Strip:
    """The strip with the length of its coping stones said, by default as short as the radius needs."""
    run, coping = strip.run, strip.run.coping
    most = WIDEST * radius / (1 + sliver)  # a short rest is one with its neighbour
    if coping is None:
        return strip
    if coping.length is not None and coping.length > most:
        raise InputError(
            f'wall "{run.name}": coping.length is {coping.length:g}; it must be up to {most:.3g} m, as the radius is '
            f"{radius:g} m"
        )
    said = replace_keys(coping, length=coping.length or min(2 * brick, most))
    return replace(strip, run=replace_keys(run, coping=said))


def _closed(strip: Strip, nominal: float) -> Pattern:
    """The bond of a closed ring: a whole number of bricks, or of a stretcher and a header."""
    run, around = strip.run, strip.axis.length
    unit = 1 + HEADER if run.bond == "flemish" else 1.0
    brick = around / (max(round(around / (nominal * unit)), 3) * unit)
    return Pattern(run.bond, brick, 0.0, 0, run.half if run.bond == "running" else 0.5, run.leaves_laid, run.through)


def _row(strip: Strip, course: int, found: Sequence[Head], pattern: Pattern, closed: bool) -> Row:
    around = strip.axis.length
    gaps = sorted((head.gaps[course] for head in found if course in head.gaps), key=lambda gap: gap.low[0])
    if not closed:
        ends = [Gap(upright(s), upright(s), "its end") for s in (0.0, around)]
        return Row(strip, course, ends[0], ends[1], gaps)
    if gaps:
        first = gaps[0]
        return Row(strip, course, first, Gap(_on(first.low, around), _on(first.high, around), first.what), gaps[1:])
    headers = pattern.headers(course, 0.0, around)
    seam = float(headers[0, 0] if pattern.bond == "flemish" else pattern.joints(course, 0, 0.0, around)[0])
    ends = [Gap(upright(s), upright(s), "its seam") for s in (seam, seam + around)]
    return Row(strip, course, ends[0], ends[1])


def _on(edge: Edge, by: float) -> Edge:
    return (edge[0] + by, edge[1], edge[2])
