"""Walls of many runs, bonded where they meet."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.arches.profile import positive
from blockstat.model.quantities import Lengths
from blockstat.model.walling.brickwork import SLIVER, Numbers, brickwork, head_stones
from blockstat.model.walling.gable import raked_coping, slopes
from blockstat.model.walling.heads import Head, heads
from blockstat.model.walling.junction import LEAST_ANGLE, Join, joins
from blockstat.model.walling.pattern import Pattern, fitted
from blockstat.model.walling.row import Gap, Row
from blockstat.model.walling.run import Buttress, Run, check_run
from blockstat.model.walling.stems import coursed_stem, stem_strip, stems
from blockstat.model.walling.strip import Line, Strip, bed_levels, nearest, upright

STRAIGHT_ON = 1e-6  #: sine of a bend that is none


def walls(
    runs: Sequence[Run] | Run,
    *,
    brick: Lengths = (0.5, 0.25),
    buttresses: Sequence[Buttress] = (),
    bonded: bool = True,
    sliver: float = SLIVER,
) -> list[Block]:
    """Walls along straight runs and polylines, from z = 0 up, bonded at their corners and T-junctions.

    All runs share their beds: every height is met exactly by courses as near the nominal height as fit. Where two runs
    meet, the stones of one reach through the other in every second course. At a free end, and between two of them, a
    course is whole bricks and one half brick (Eq. 4 of the procedural-masonry paper); bricks are as near the nominal
    length as that allows.

    Parameters
    ----------
    runs : sequence of Run
        Of two runs that meet at a corner the first has the corner stone of the lowest course.
    brick : tuple of float
        Nominal length and height [m].
    buttresses : sequence of Buttress
        Of the runs.
    bonded : bool
        False leaves straight joints where runs meet.
    sliver : float
        A rest shorter than this fraction of a brick is joined to its neighbour.

    Returns
    -------
    list of Block
        Convex blocks of the groups "wall.<run>", "wall.<run>.lintel", "wall.<run>.arch" (voussoirs),
        "wall.<run>.coping" and "buttress.<run>.<k>". Names are group, course and number in the course; for heads and
        raked coping stones the number of the opening or 0, and of the stone.

    Raises
    ------
    InputError
        Naming the run and what about it cannot be built. Where a rest cannot be joined to a neighbour, as between an
        opening and a corner, the run is refused unless its `closers` allow it.

    Examples
    --------
    >>> from blockstat.model import Run, walls
    >>> run = Run(name="south", path=[(0, 0), (2, 0)], thickness=0.3, height=0.5)
    >>> [block.name for block in walls(run)][:2]
    ['wall.south.0.0', 'wall.south.0.1']
    """
    given = [runs] if isinstance(runs, Run) else list(runs)
    runs = [run for run in given if run.present]
    if given and not runs:
        return []
    check_sizes(runs, brick, sliver)
    marks = [h for run in runs for h in ((run.height, run.height + run.gable) if run.gable else (run.height,))]
    levels = bed_levels(marks, brick[1], sliver)
    strips = [strip for run in runs for strip in _strips(run, levels)]
    loose: list[tuple[int, int]] = []
    beside: list[Block] = []
    absent = {run.name for run in given if not run.present}
    for stem in list(stems(strips, buttresses, absent)):
        if stem.spec.courses is not None:
            beside += coursed_stem(strips[stem.host], stem)
            continue
        loose += [] if stem.tied else [(stem.host, len(strips))]
        strips.append(stem_strip(strips[stem.host], stem))
    blocks: list[Block] = []
    numbers: Numbers = {}
    for strip, of_strip in zip(strips, joins(strips, loose, bonded=bonded), strict=True):
        blocks += _build(strip, of_strip, brick, sliver, numbers)
    return blocks + beside


def check_sizes(runs: Sequence[Run], brick: Sequence[float], sliver: float) -> None:
    """Check what concerns all runs together, and each run.

    Parameters
    ----------
    runs : sequence of Run
        As they were written.
    brick : sequence of float
        Nominal length and height [m].
    sliver : float
        Fraction of a brick.

    Raises
    ------
    InputError
        Naming what cannot be built.
    """
    if len(brick) != 2:
        raise InputError(f"brick is {brick!r}; it must be its nominal length and height [m]")
    positive(**{"brick[0]": brick[0], "brick[1]": brick[1]})
    if not 0 < sliver <= 0.45:
        raise InputError(f"sliver is {sliver!r}; it must be a fraction of a brick above 0 and up to 0.45")
    if not runs:
        raise InputError("runs is empty; walls need at least one run")
    for run in runs:
        check_run(run)
    names = [run.name for run in runs]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f'two runs are named "{name}"; names must be unique')


def _strips(run: Run, levels: tuple[float, ...]) -> list[Strip]:
    """The straight stretches of a run."""
    points = [np.array(p, dtype=float) for p in run.path]
    if run.closed:
        points.append(points[0])
    t, (left, right) = run.thickness, run.batter
    low = {"centre": -t / 2, "left": 0.0, "right": -t}[run.align]
    strips: list[Strip] = []
    axes: list[Line] = []
    for k, (a, b) in enumerate(zip(points, points[1:], strict=False)):
        length = float(np.linalg.norm(b - a))
        if not length > 1e-9 * t:
            raise InputError(f'wall "{run.name}": path has the point {a.tolist()} twice in a row')
        axes.append(Line(a, (b - a) / length, length))
        top, ridge = nearest(levels, run.height), nearest(levels, run.height + run.gable)
        strips.append(Strip(run, axes[k], (low, right), (low + t, -left), levels, top, ridge, f"wall.{run.name}", k))
    _check_bends(run, axes)
    for opening in run.openings:
        if opening.present and not 0 <= opening.segment < len(strips):
            raise InputError(
                f'wall "{run.name}": segment of an opening is {opening.segment}; its path has {len(strips)} stretches'
            )
    return strips


def _check_bends(run: Run, axes: list[Line]) -> None:
    """Refuse points of a path at which it goes straight on or turns little: the stretches are not bonded there."""
    following = axes[1:] + axes[:1] if run.closed else axes[1:]
    for a, b in zip(axes, following, strict=False):
        sine, point = abs(float(a.along @ b.across)), b.origin.tolist()
        if a.along @ b.along <= 0 or sine >= math.sin(math.radians(LEAST_ANGLE)):
            continue
        if sine < STRAIGHT_ON:
            raise InputError(
                f'wall "{run.name}": path goes straight on at {point}; leave out the point, for bricks are not bonded '
                "there"
            )
        raise InputError(
            f'wall "{run.name}": path turns by less than {LEAST_ANGLE:g} degrees at {point}; turn more sharply, or use '
            "an arc"
        )


def _build(
    strip: Strip, of_strip: Sequence[Join], brick: tuple[float, float], sliver: float, numbers: Numbers
) -> list[Block]:
    """Blocks of one strip."""
    pattern = _pattern(strip, of_strip, brick[0])
    found = heads(strip, pattern.brick, brick[1])
    foot = _feet(strip, of_strip)
    rows = [_row(strip, course, of_strip, found, foot) for course in range(strip.ridge)]
    blocks = brickwork(rows, pattern, sliver, numbers) + head_stones(strip, found, numbers)
    if strip.run.coping is not None and strip.ridge > strip.top:
        blocks += raked_coping(strip, foot, strip.run.coping, (pattern.brick, brick[1]))
    return blocks


def _pattern(strip: Strip, of_strip: Sequence[Join], nominal: float) -> Pattern:
    """The bond of a strip between its ends: whole bricks from the corners in the courses that butt there."""
    places: list[tuple[float, int | None]] = [(0.0, None), (strip.far_end(0)[0], None)]
    centre = (strip.right[0] + strip.left[0]) / 2
    for join in of_strip:
        if join.role == "across":
            continue
        side = 0 if join.role == "start" else 1
        near = join.edges(0)[1 - side]
        phase = (1 if join.first else 0) if join.bonded else None
        if not join.bonded and join.first:
            near = join.edges(0)[side]
        places[side] = (near[0] + near[1] * centre, phase)
    if not places[1][0] > places[0][0]:
        raise InputError(f'wall "{strip.run.name}" has no length between the walls that it meets')
    return fitted(strip.run, nominal, *places)


def _feet(strip: Strip, of_strip: Sequence[Join]) -> tuple[float, float]:
    """Where the slopes of a gable begin: the outermost s of the strip at both ends."""
    low, high = 0.0, strip.axis.length
    z = strip.levels[strip.top]
    for join in of_strip:
        for edge in join.edges(strip.top - 1):
            places = [edge[0] + edge[1] * (c + k * z) + edge[2] * z for c, k in (strip.right, strip.left)]
            if join.role == "start":
                low = min(low, max(places))
            elif join.role == "end":
                high = max(high, min(places))
    return low, high


def _row(strip: Strip, course: int, of_strip: Sequence[Join], found: Sequence[Head], foot: tuple[float, float]) -> Row:
    end = strip.far_end(course)
    bounds = [Gap(upright(0.0), upright(0.0), "its end"), Gap(end, end, "its end")]
    gaps = [head.gaps[course] for head in found if course in head.gaps]
    if course >= strip.top:
        bounds = list(slopes(strip, foot))
        return Row(strip, course, bounds[0], bounds[1], gaps, pointed=True)
    avoid: list[tuple[float, float]] = []
    plain = Row(strip, course, bounds[0], bounds[1])
    for join in of_strip:
        edges, what = join.edges(course), f'"{join.other.group}"'
        owned = join.owns(course)
        tied = join.bonded and course <= join.other.top  # the course below or above is cut there
        if join.role == "across":
            if not owned:
                gaps.append(Gap(*edges, what))
            elif tied:
                avoid += [place for edge in join.joints(course) for place in plain.at_faces(edge)]
            continue
        side = 0 if join.role == "start" else 1
        cut = edges[side] if owned else edges[1 - side]
        bounds[side] = Gap(cut, cut, what)
        if owned and tied:
            avoid += [place for edge in join.joints(course) for place in plain.at_faces(edge)]
    return Row(strip, course, bounds[0], bounds[1], gaps, avoid, pointed=bool(strip.ends))
