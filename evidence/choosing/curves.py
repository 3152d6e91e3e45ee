"""Capacity curves by steps and tolerance: error of the multiplier and of the last displacement, and seconds.

A block and a portal are linkages with known curves. Walls of bricks in their plane are followed by finite steps, and
are compared with the run of most steps.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any

import numpy as np

from blockstat import Assembly, CapacityCurve, capacity
from evidence.choosing.clock import timed
from evidence.dynamics.capacity import portal
from evidence.references.linkages import DIGITS, PORTALS, overturning
from evidence.scenes.small import running_bond, stack
from evidence.tables import table

DEFAULT = {name: signature(capacity).parameters[name].default for name in ("steps", "tolerance")}
#: Steps and tolerances of the known curves.
CHOICES = (
    *((steps, DEFAULT["tolerance"]) for steps in (3, 10, 30, 100)),
    *((3, tolerance) for tolerance in (1e-2, 1e-3, 1e-5, 1e-6)),
)
#: Steps of the walls; the curve of the most is the reference of the others.
STEPS = (5, 10, 20, 40, 80, 160)
WIDTH, HEIGHT = 0.5, 2.0


@dataclass(frozen=True)
class Known:
    """A scene whose curve is known at some displacements and at its end."""

    name: str
    scene: Callable[[], Assembly]
    control: str
    places: np.ndarray  #: displacements [m]
    values: np.ndarray  #: multipliers there
    end: float  #: displacement at which the multiplier is zero [m]


def known() -> list[Known]:
    """A block that turns over its toe, and a portal that jumps once to other hinges."""
    tall, (values, end, _) = 2.5, PORTALS[2.5]
    tenths = np.arange(1, 10) / 10
    turned = overturning(WIDTH, HEIGHT, tenths * WIDTH / 2)
    return [
        Known("block", lambda: stack(1, WIDTH, HEIGHT, friction=0.9), "stone0", tenths * WIDTH / 2, turned, WIDTH / 2),
        Known("portal", lambda: portal(4.5, 0.5, 1.0, tall, 20).with_(friction=0.7), "mean", tenths * end,
              np.array(values), end),
    ]  # fmt: skip


#: Walls in running bond: courses and bricks a course.
WALLS = {"wall of 4 courses": (4, 3), "wall of 5 courses": (5, 3)}


@dataclass(frozen=True)
class Followed:
    """One curve."""

    scene: str
    steps: int
    tolerance: float
    points: int
    outcome: str
    error: float  #: largest error of the multiplier, relative to that at rest
    last: float  #: displacement at the end [m]
    end: float  #: its relative error
    seconds: float


def largest_error(curve: CapacityCurve, places: np.ndarray, values: np.ndarray) -> float:
    """Largest distance of either bound from known multipliers as far as the curve goes, relative to that at rest."""
    reached = places <= curve.displacement.max()
    found = np.array([curve.at(there) for there in places[reached]]).reshape(-1, 2)
    return float(np.abs(found - values[reached, None]).max(initial=0.0) / curve.lower[0])


def curve_of(scene: Assembly, **options: Any) -> tuple[CapacityCurve, float]:
    """A curve along x and its seconds."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return timed(lambda: capacity(scene, (1, 0, 0), **options))


def against_known(one: Known, choices: Sequence[tuple[int, float]] = CHOICES) -> list[Followed]:
    """Curves of a scene whose curve is known."""
    scene, rows = one.scene(), []
    for steps, tolerance in choices:
        curve, seconds = curve_of(scene, control=one.control, steps=steps, tolerance=tolerance)
        last = float(curve.displacement[-1])
        error = largest_error(curve, one.places, one.values)
        rows.append(
            Followed(one.name, steps, tolerance, len(curve.points), curve.outcome.word, error, last,
                     abs(last / one.end - 1), seconds)
        )  # fmt: skip
    return rows


def against_finest(name: str, scene: Assembly, steps: Sequence[int] = STEPS) -> list[Followed]:
    """Curves of a wall, against the one of most steps at tenths of its last displacement."""
    found = {number: curve_of(scene, control="mean", steps=number) for number in steps}
    finest = found[max(steps)][0]
    end = float(finest.displacement[-1])
    places = np.arange(1, 10) * end / 10
    values = np.array([finest.at(there)[0] for there in places])
    return [
        Followed(name, number, DEFAULT["tolerance"], len(curve.points), curve.outcome.word,
                 largest_error(curve, places, values), float(curve.displacement[-1]),
                 abs(float(curve.displacement[-1]) / end - 1), seconds)
        for number, (curve, seconds) in found.items()
    ]  # fmt: skip


def measured(most: int = max(STEPS)) -> tuple[list[Followed], list[Followed]]:
    """Curves of the linkages, and of the walls with so many steps at most."""
    numbers = [number for number in STEPS if number <= most]
    linkages = [row for one in known() for row in against_known(one)]
    walls = [
        row
        for name, (courses, bricks) in WALLS.items()
        for row in against_finest(name, running_bond(courses, bricks).with_(friction=0.65), numbers)
    ]
    return linkages, walls


def _end(error: float) -> str:
    return f"below {DIGITS:.0e}" if error < DIGITS else f"{error:.1e}"


def linkages_table(rows: Sequence[Followed]) -> str:
    """A line a choice, columns by scene."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    lines = []
    for choice in dict.fromkeys((row.steps, row.tolerance) for row in rows):
        own = [row for row in rows if (row.steps, row.tolerance) == choice]
        cells = (text for r in own for text in (r.points, f"{r.error:.1e}", _end(r.end), f"{r.seconds:.2f}"))
        lines.append([choice[0], f"{choice[1]:.0e}", *cells])
    heads = (text for name in scenes for text in (f"{name}: points", "error", "error of the end", "s"))
    return table(["steps", "tolerance", *heads], lines)


def walls_table(rows: Sequence[Followed]) -> str:
    """A line a curve."""
    most = max(row.steps for row in rows)
    lines = []
    for r in rows:
        difference = "-" if r.steps == most else f"{r.error:.1e}"
        lines.append([r.scene, r.steps, r.points, r.outcome, f"{1e3 * r.last:.2f}", difference, f"{r.seconds:.1f}"])
    return table(["", "steps", "points", "end", "at [mm]", "difference", "s"], lines)


def advice(linkages: Sequence[Followed], walls: Sequence[Followed]) -> str:
    """What steps are good for, from the rows."""
    few = min(row.steps for row in linkages)
    coarse = [row for row in linkages if (row.steps, row.tolerance) == (few, DEFAULT["tolerance"])]
    exact = max(row.error for row in coarse)
    most = max(row.steps for row in walls)
    others = [row for row in walls if row.steps < most]
    apart, ends = (100 * max(getattr(row, name) for row in others) for name in ("error", "end"))
    return (
        f"- The curves of the linkages are wrong by interpolation between points: with {few} steps and the default "
        f"tolerance by at most {exact:.0e} of the multiplier at rest. `tolerance` bounds that error.\n"
        f"- The curves of the walls with fewer steps differ from those with {most} by up to {apart:.1f} % of the "
        f"multiplier at rest, and their ends by up to {ends:.0f} %. The path of such a wall is not unique, so a "
        "difference may come from another path as well as from the length of the steps. Follow such a wall with two "
        "numbers of steps, and count on the lower multiplier alone."
    )
