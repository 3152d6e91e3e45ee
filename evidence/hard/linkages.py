"""Arches as linkages, by their own kinematics: what `evidence.hard.jumps` knows of capacity curves and settlements.

Plane geometry and plain numpy; nothing of blockstat. An arch that moves on four hinges is a four-bar linkage, so a
state follows from the turn of its first bar and needs no steps. The work of weight and load gives the multiplier, the
equilibrium of one bar after the other gives the thrust, and the mechanism changes where the thrust reaches an edge.
An arch on spreading supports is three hinges, and determinate. Hinges are numbers of joints from the left, and are at
the intrados and the extrados in turn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

Array = np.ndarray
PROBE = 1e-6  #: half of the turn over which rates are taken [rad]
SMALL = 1e-7  #: turn at which a mechanism has begun [rad]


def cross(a: Array, b: Array) -> float:
    """The component of a x b across the plane."""
    return float(a[0] * b[1] - a[1] * b[0])


def turned(point: Array, angle: float) -> Array:
    """A point turned about the origin, counter-clockwise."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])


@dataclass(frozen=True, eq=False)
class Ring:
    """Straight-sided blocks between radial joints; `angle` from the left foot, descending, `thickness` radial."""

    angle: Array
    thickness: float
    radius: float = 1.0

    @cached_property
    def edges(self) -> dict[str, Array]:
        """Corners of the joints at the intrados and the extrados."""
        ray = np.column_stack([np.cos(self.angle), np.sin(self.angle)])
        return {side: (self.radius + sign * self.thickness / 2) * ray for side, sign in (("I", -1), ("E", 1))}

    @cached_property
    def masses(self) -> tuple[Array, Array]:
        """Areas and centroids of the blocks."""
        inner, outer = self.edges["I"], self.edges["E"]
        corner = np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1)
        (x, y), (u, v) = np.moveaxis(corner, 2, 0), np.moveaxis(np.roll(corner, -1, axis=1), 2, 0)
        part = x * v - u * y
        area = part.sum(axis=1) / 2
        centre = np.column_stack([((x + u) * part).sum(axis=1), ((y + v) * part).sum(axis=1)]) / (6 * area)[:, None]
        return np.abs(area), centre


def semicircle(voussoirs: int, thickness: float) -> Ring:
    """A semicircular arch of equal voussoirs."""
    return Ring(np.linspace(np.pi, 0, voussoirs + 1), thickness)


def bedded(voussoirs: int, thickness: float, bed: float) -> Ring:
    """The same with a bed in every joint, half of it taken from either voussoir; `bed` is an angle."""
    joint = np.linspace(np.pi, 0, voussoirs + 1)
    return Ring(np.sort(np.concatenate([joint + bed / 2, joint - bed / 2]))[::-1], thickness)


@dataclass(frozen=True, eq=False)
class FourBar:
    """A ring that turns about four of its joints, pushed to the right; what is outside of the hinges does not move."""

    ring: Ring
    hinges: tuple[int, int, int, int]

    @cached_property
    def pivots(self) -> Array:
        """The hinges at rest."""
        return np.array([self.ring.edges[side][joint] for side, joint in zip("IEIE", self.hinges, strict=True)])

    def bars(self, turn: float) -> list[tuple[Array, Array, float]]:
        """Of each bar a point at rest, where it is, and the turn of the bar, when the first one has turned."""
        a, b, c, d = self.pivots
        lengths = np.linalg.norm(c - b), np.linalg.norm(d - c)
        second = a + turned(b - a, -turn)
        base = d - second
        along = (base @ base + lengths[0] ** 2 - lengths[1] ** 2) / (2 * np.linalg.norm(base))
        aside = np.sqrt(lengths[0] ** 2 - along**2) * np.sign(cross(d - b, c - b))
        unit = base / np.linalg.norm(base)
        third = second + along * unit + aside * np.array([-unit[1], unit[0]])
        turns = [-turn, _between(c - b, third - second), _between(d - c, d - third)]
        return list(zip((a, b, d), (a, second, d), turns, strict=True))

    def _bar(self, joint: int) -> int | None:
        """Which bar is to the right of a joint."""
        bar = int(np.searchsorted(self.hinges, joint, side="right")) - 1
        return bar if 0 <= bar < 3 else None

    def pose(self, turn: float) -> Array:
        """Centroids of the blocks."""
        bars, centre = self.bars(turn), self.ring.masses[1].copy()
        for k in range(len(centre)):
            if (bar := self._bar(k)) is not None:
                rest, there, angle = bars[bar]
                centre[k] = there + turned(centre[k] - rest, angle)
        return centre

    def displacement(self, turn: float) -> float:
        """Mean horizontal displacement of the mass."""
        area, centre = self.ring.masses
        return float(area @ (self.pose(turn) - centre)[:, 0] / area.sum())

    def multiplier(self, turn: float) -> float:
        """The horizontal load, in weights, under which the work of weight and load is none."""
        rate = self.ring.masses[0] @ (self.pose(turn + PROBE) - self.pose(turn - PROBE))
        return float(rate[1] / rate[0])

    def thrust(self, turn: float) -> dict[int, float]:
        """Where the resultant meets each joint: 0 at the intrados, 1 at the extrados, and there at the hinges."""
        area, bars, centre = self.ring.masses[0], self.bars(turn), self.pose(turn)
        force = np.column_stack([self.multiplier(turn) * area, -area])
        first = self.hinges[0]
        places = [there + turned(p - rest, angle) for p, (rest, there, angle) in zip(self.pivots, bars, strict=False)]
        # No moment at the second and the third hinge: the force at the first one.
        arms, moments = [], []
        for place, joint in zip(places[1:], self.hinges[1:3], strict=True):
            arms.append([place[1] - places[0][1], places[0][0] - place[0]])
            moments.append(-sum(cross(centre[k] - place, force[k]) for k in range(first, joint)))
        reaction = np.linalg.solve(arms, moments)
        found = {}
        for joint in range(len(area) + 1):
            inner, outer = (self._place(bars, joint, side) for side in "IE")
            sign, between = (1, range(first, joint)) if joint > first else (-1, range(joint, first))
            total = reaction + sign * force[list(between)].sum(axis=0)
            moment = cross(places[0] - inner, reaction)
            moment += sign * sum(cross(centre[k] - inner, force[k]) for k in between)
            found[joint] = moment / cross(outer - inner, total)
        return found

    def _place(self, bars: list[tuple[Array, Array, float]], joint: int, side: str) -> Array:
        point, bar = self.ring.edges[side][joint], self._bar(joint)
        if bar is None:
            return point
        rest, there, angle = bars[bar]
        return there + turned(point - rest, angle)

    def slack(self, turn: float) -> float:
        """How far inside the joints but the hinges the thrust is, in thicknesses, where it is nearest to an edge."""
        places = {joint: place for joint, place in self.thrust(turn).items() if joint not in self.hinges}
        return min(min(place, 1 - place) for place in places.values())

    def change(self, *, start: float = SMALL, largest: float = 0.5, steps: int = 400) -> tuple[str, float]:
        """How this mechanism ends, "jump" (the thrust leaves) or "zero" (of the multiplier), and at which turn."""
        turns = np.linspace(start, largest, steps)
        for low, high in zip(turns[:-1], turns[1:], strict=True):
            if self.slack(high) < 0:
                return "jump", root(self.slack, low, high)
            if self.multiplier(high) < 0:
                return "zero", root(self.multiplier, low, high)
        raise ValueError("the mechanism goes on")

    def at(self, displacement: float) -> float:
        """The turn at a mean displacement."""
        return root(lambda turn: displacement - self.displacement(turn), SMALL, 0.4)


def _between(before: Array, after: Array) -> float:
    """The turn from one direction to another."""
    return float(np.arctan2(cross(before, after), before @ after))


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function that is positive at the lower end changes its sign."""
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    return (low + high) / 2


def first_mechanism(ring: Ring) -> FourBar:
    """The four hinges with which the thrust stays inside all joints: the mechanism of the limit load, by enumeration.

    Hinges move by one place at a time to where the thrust is least outside.
    """
    count = len(ring.angle) - 1
    hinges = [0, count * 4 // 10, count * 7 // 10, count]
    for _ in range(4 * count):
        best = max(
            (FourBar(ring, near) for near in _neighbours(hinges, count)), key=lambda linkage: linkage.slack(SMALL)
        )
        if list(best.hinges) == hinges:
            return best
        hinges = list(best.hinges)
    raise ValueError("no mechanism found")


def _neighbours(hinges: list[int], count: int) -> Iterator[tuple[int, int, int, int]]:
    for step in product((-1, 0, 1), repeat=4):
        a, b, c, d = (joint + move for joint, move in zip(hinges, step, strict=True))
        if 0 <= a < b < c < d <= count:
            yield a, b, c, d


@dataclass(frozen=True, eq=False)
class Spread:
    """Half of a symmetrical arch whose supports move apart: a hinge at the crown's extrados, one at the intrados."""

    ring: Ring

    def _hinges(self, joint: int) -> tuple[Array, Array]:
        crown = (len(self.ring.angle) - 1) // 2
        return self.ring.edges["I"][joint], self.ring.edges["E"][crown]

    def least_thrust(self, joint: int, spread: float = 0.0) -> tuple[float, Array, Array]:
        """Thrust with the lower hinge at a joint, where that hinge is, and where the one at the crown is."""
        area, centre = self.ring.masses
        crown = (len(self.ring.angle) - 1) // 2
        low, top = self._hinges(joint)
        length, foot = np.linalg.norm(top - low), low - [spread / 2, 0]
        head = np.array([0.0, foot[1] + np.sqrt(length**2 - foot[0] ** 2)])
        turn = _between(top - low, head - foot)
        upper = range(joint, crown)
        moment = sum(area[k] * turned(centre[k] - low, turn)[0] for k in upper)
        # Half of the upper part about the lower hinge: weight outwards of its centroid against the thrust.
        return float(moment / (head - foot)[1]), foot, head

    @cached_property
    def joint(self) -> int:
        """The lower hinge: the least thrust is the largest that any of them asks for."""
        return max(range((len(self.ring.angle) - 1) // 2), key=lambda joint: self.least_thrust(joint)[0])

    def slack(self, spread: float) -> float:
        """How far inside the springing the thrust is, in thicknesses from the extrados."""
        area, centre = self.ring.masses
        crown = (len(self.ring.angle) - 1) // 2
        thrust, hinge, _ = self.least_thrust(self.joint, spread)
        inner, outer = (self.ring.edges[side][0] - [spread / 2, 0] for side in "IE")
        upper = area[self.joint : crown].sum()
        force = np.array([-thrust, -upper])  # on the lower part at its hinge
        moment = cross(hinge - inner, force)
        moment += sum(cross(centre[k] - [spread / 2, 0] - inner, np.array([0, -area[k]])) for k in range(self.joint))
        total = force - [0, area[: self.joint].sum()]
        return 1 - moment / cross(outer - inner, total)

    @cached_property
    def collapse(self) -> float:
        """Movement of the supports at which the thrust reaches the extrados of the springings."""
        return root(self.slack, 0.0, 0.6)
