"""The limit load over the horizon: in which direction an assembly carries least.

The horizontal accelerations that an assembly carries form a convex set, because the friction is associated. The force
field of each direction is a point of the set, and its mechanism a half-plane around it. So a few directions bound the
multiplier in all others: from below by the polygon of the points, from above by the half-planes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.limit_load import DILATES, TOLERANCE, UNBOUNDED, LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, known_options
from blockstat.loads import Loads, acceleration, horizontal
from blockstat.result import Result, Sentence, both_ends, finite
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Directions looked at unless the caller says how many.
DIRECTIONS = 16
MOST_DIRECTIONS = 3600  #: a tenth of a degree apart
#: The search for the weakest direction ends when its bracket is so narrow, or after so many further directions. About a
#: single weakest direction a chord of a round set shrinks fourfold with each. Where the set is round about the origin,
#: as of what slides, all chords are equally near: to narrow the bracket fourfold takes twice as many directions.
NARROW, FURTHER = 1e-3, 8
#: What counts as the same direction [rad].
SAME = 1e-6
#: Outcomes whose bounds are not as close as was asked.
OPEN = (LoadOutcome.UNDECIDED, LoadOutcome.STOPPED)
AXES = ("+x", "-x", "+y", "-y", "+z", "-z")  #: names of the directions along the axes


class DirectionOutcome(Sentence):
    """The answers of `limit_load_by_direction`; each value is the sentence a user reads."""

    LIMIT = "Limit: the least limit load of the directions of the horizon is proven from both sides."
    UNBOUNDED = "Unbounded: the assembly carries any multiple of a horizontal load, in every direction asked for."
    DEAD_LOAD_UNSTABLE = "Infeasible under dead load: the assembly does not stand without the load."
    UNDECIDED = "Undecided: the bounds of a direction that may be the weakest could not be proven."
    STOPPED = "Stopped: only some directions of the horizon were looked at."


@dataclass(frozen=True, eq=False)
class DirectionalLimits(Result):
    """Limit loads over the horizon, and a bracket of the least of all directions.

    All of it is with associated friction but `coulomb_least` and `weakest_coulomb`.
    """

    angles: Floats  #: shape (n,) [rad], from +x (or its horizontal part) towards +y, ascending
    directions: Floats  #: shape (n, 3), unit vectors at right angles to gravity
    limits: tuple[LimitLoad, ...]  #: one a direction
    #: Least multiplier of all directions of the horizon, those between included: proven from below and from above.
    horizon: tuple[float, float]
    assembly: Assembly
    warnings: tuple[str, ...] = ()
    stopped: bool = False  #: whether an interrupt came before all directions were looked at

    @property
    def outcome(self) -> DirectionOutcome:
        """What the limit loads have in common."""
        found = {limit.outcome for limit in self.limits}
        if LoadOutcome.DEAD_LOAD_UNSTABLE in found:
            return DirectionOutcome.DEAD_LOAD_UNSTABLE
        if self.stopped:
            return DirectionOutcome.STOPPED
        if self.open:
            return DirectionOutcome.UNDECIDED
        return DirectionOutcome.UNBOUNDED if found == {LoadOutcome.UNBOUNDED} else DirectionOutcome.LIMIT

    @property
    def open(self) -> list[int]:
        """Numbers of the directions whose bounds are not close, and that may carry less than the weakest one."""
        # Wide bounds do not matter in a direction that is proven to carry more than the weakest one.
        unproven = [k for k, limit in enumerate(self.limits) if limit.outcome in OPEN]
        endless = np.isposinf(self.least.upper)  # with dilatancy, in every direction
        return [k for k in unproven if self.limits[k].lower < self.least.upper or k == self.weakest or endless]

    @property
    def undecided(self) -> dict[str, list[str]]:
        """Why bounds are not as close as was asked: by each reason the names of the directions that it is of."""
        reasons: dict[str, list[str]] = {}
        for name, limit in zip(self.names, self.limits, strict=True):
            for text in limit.warnings if limit.outcome in OPEN else ():
                reasons.setdefault(text, []).append(name)
        return reasons

    @property
    def told(self) -> list[str]:
        """The warnings of a report: why directions are undecided, with their names, and then the others."""
        reasons = [f"undecided towards {', '.join(names)}: {text}" for text, names in self.undecided.items()]
        return [*reasons, *(text for text in self.warnings if text not in self.undecided)]

    @property
    def notable(self) -> list[int]:
        """Numbers of the directions along the axes, of the weakest one, and of those that may carry less than it."""
        chosen = {self.weakest, *self.open}
        return [k for k, name in enumerate(self.names) if name in AXES or k in chosen]

    @property
    def has_limits(self) -> bool:
        """Whether there is a limit load: the assembly stands, and some direction has an upper bound."""
        return self.outcome is not DirectionOutcome.DEAD_LOAD_UNSTABLE and bool(np.isfinite(self.least.upper))

    @property
    def lower(self) -> Floats:
        """Multipliers that are carried, shape (n,)."""
        return np.array([limit.lower for limit in self.limits])

    @property
    def upper(self) -> Floats:
        """Multipliers at which the mechanisms move, shape (n,)."""
        return np.array([limit.upper for limit in self.limits])

    @property
    def names(self) -> tuple[str, ...]:
        """One name a direction: "+x", "-y", or its angle, such as "22.5 deg"."""
        return tuple(_name(*where) for where in zip(self.angles, self.directions, strict=True))

    @property
    def weakest(self) -> int:
        """Number of the direction with the least multiplier; the first of equal ones."""
        return _first_of_the_least(self.upper)

    @property
    def least(self) -> LimitLoad:
        """The limit load in the weakest direction."""
        return self.limits[self.weakest]

    @property
    def coulomb_least(self) -> Floats:
        """Brackets without dilatancy, of the joints that carry least, shape (n, 2); nan where there are none."""
        asked = any(limit.coulomb_kinds for limit in self.limits)
        return np.array([_without_dilatancy(limit) if asked else (np.nan, np.nan) for limit in self.limits])

    @property
    def weakest_coulomb(self) -> int | None:
        """Number of the direction, of those looked at, that carries least without dilatancy; None if not asked for."""
        values = self.coulomb_least[:, 0]
        return None if np.isnan(values).all() else _first_of_the_least(values)

    @property
    def said(self) -> str:
        """The least multiplier in two sentences, for those who do not know what associated friction is."""
        low, high = self.horizon
        return (
            "The least horizontal acceleration that moves joints which dilate as they slide is "
            f"{self.least.upper:.4g} times gravity, towards {self.names[self.weakest]}. Over all directions of the "
            f"horizon the least lies between {low:.4g} and {high:.4g}. Real joints may carry less."
        )

    def said_without_dilatancy(self, least: LimitLoad | None) -> str:
        """Return what is carried without dilatancy towards the weakest direction, or the command that finds it.

        Parameters
        ----------
        least : LimitLoad or None
            The limit load in that direction with flow="coulomb", where it was looked for.

        Returns
        -------
        str
            One sentence.
        """
        if least is not None and least.coulomb_least is not None:
            low, high = both_ends(*least.coulomb_least, 4)
            return f"Without dilatancy and self-stress {low} is carried in that direction, and {high} is not."
        push = ",".join(f"{part + 0.0:.3g}" for part in self.directions[self.weakest])
        return f"blockstat limit FILE --load={push} --flow coulomb finds how much without dilatancy and self-stress."

    def explain(self) -> str:
        """Return the answer and its evidence in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value]
        if self.outcome in (DirectionOutcome.LIMIT, DirectionOutcome.STOPPED):
            lines += self._least_words()
            width = max(map(len, self.names))
            lines += [
                f"  {name:>{width}}  {limit.lower:.6g} to {limit.upper:.6g}{_beside(limit, bounds)}"
                for name, limit, bounds in zip(self.names, self.limits, self.coulomb_least, strict=True)
            ]
        lines += [f"Undecided towards {', '.join(names)}: {text}." for text, names in self.undecided.items()]
        told = [text for text in self.warnings if text not in self.undecided]
        return "\n".join([*lines, *(f"Warning: {text}" for text in told)])

    def _least_words(self) -> list[str]:
        """The least multiplier: without dilatancy where that was asked for, and with associated friction."""
        if not np.isfinite(self.least.upper):  # nothing but unbounded ones until an interrupt
            return []
        (low, high), weakest, lines, basis = self.horizon, self.weakest_coulomb, [], ""
        if weakest is not None:
            bounds, basis = self.coulomb_least, " with associated friction"
            (below, above), known = bounds[weakest], np.isfinite(bounds[:, 0]).sum()
            lines.append(
                f"Least without dilatancy, of {known} directions: {below:.5g} to {above:.5g} "
                f"towards {self.names[weakest]}, in the kind of joints that carries least."
            )
        least = "Least so far" if self.stopped else "Least"
        lines.append(f"{least}{basis}: {self.least.upper:.6g} towards {self.names[self.weakest]}.")
        lines.append(f"Over the whole horizon{basis}: {low:.6g} <= least multiplier <= {high:.6g}")
        return lines if basis else [*lines, DILATES]

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; infinite bounds are None.

        Returns
        -------
        dict
            Values by name. "lower", "upper", "least" and "horizon" are with associated friction, the first two those of
            the weakest direction. "coulomb_least" is what the joints that carry least carry without dilatancy towards
            "coulomb_towards", the weakest direction then; None if not asked for. "undecided" has each reason why bounds
            are wide, and the directions that it is of.
        """
        rows = zip(
            self.names, np.rad2deg(self.angles), self.directions, self.limits, self.coulomb_least[:, 0], strict=True
        )
        weakest = self.weakest_coulomb
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "least": self.names[self.weakest],
            "lower": finite(self.least.lower),
            "upper": finite(self.least.upper),
            "horizon": {"lower": finite(self.horizon[0]), "upper": finite(self.horizon[1])},
            "coulomb_least": None if weakest is None else float(self.coulomb_least[weakest, 0]),
            "coulomb_towards": None if weakest is None else self.names[weakest],
            "directions": [
                {
                    "name": name,
                    "angle_deg": round(float(angle), 6),
                    "direction": [float(value) for value in direction],
                    "status": limit.outcome.word,
                    "lower": finite(limit.lower),
                    "upper": finite(limit.upper),
                    "coulomb_lower": None if limit.coulomb is None else finite(limit.coulomb[0]),
                    "coulomb_upper": None if limit.coulomb is None else finite(limit.coulomb[1]),
                    "coulomb_least": finite(carried),
                }
                for name, angle, direction, limit, carried in rows
            ],
            "undecided": [{"reason": text, "towards": names} for text, names in self.undecided.items()],
            "blocks": self.assembly.n_blocks,
            "warnings": list(self.warnings),
        }


@known_options
def limit_load_by_direction(
    assembly: Assembly,
    directions: int = DIRECTIONS,
    *,
    refine: bool = True,
    friction: float | None = None,
    gravity: Any = None,
    loads: Loads | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
    flow: str = "associated",
    tolerance: float = TOLERANCE,
    progress: Callable[[int, str, LimitLoad], None] | None = None,
) -> DirectionalLimits:
    """Find the largest horizontal acceleration that an assembly carries, in directions all round, and the least one.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand for there to be a limit.
    directions : int, optional
        How many directions, evenly spread from +x on: a multiple of 4, so that +x, -x, +y and -y are among them.
    refine : bool, optional
        Look between the directions for the weakest one of all, until the bracket of the least multiplier is narrower
        than a thousandth, in at most eight further directions. It stays wider where many directions are equally weak,
        as where all slides: each has a bound of its own. Ask for more `directions` then: between 16 of them a round set
        is known to 1.9 %, between 64 to 0.12 %.
    friction, gravity, loads, gap, interfaces, solver, flow, tolerance
        As in `blockstat.limit_load`.
    progress : callable, optional
        Called after each direction with how many are done, its name and its limit load. With it a KeyboardInterrupt
        after the first direction ends the search, and the outcome is "stopped"; without it, it is raised.

    Returns
    -------
    DirectionalLimits
        The limit loads, the weakest direction, and a proven bracket of the least multiplier over the horizon.

    Raises
    ------
    InputError
        For a number of directions that is no multiple of 4 up to 3,600, or as `blockstat.limit_load`.

    Notes
    -----
    The set of horizontal accelerations that are carried is convex (associated flow). The least multiplier of all
    directions is the distance of the origin from the rim of this set. It lies between the distances of the polygon of
    the force fields and of the half-planes of the mechanisms. With flow="coulomb" no such bracket is known: `horizon`
    is that of associated friction, and `coulomb_least` has the directions that were looked at.

    Examples
    --------
    A slab 1 m wide, .5 m deep and 2 m high is weakest across: it tips at .25, along its width at .5.

    >>> from blockstat import Assembly, box, limit_load_by_direction
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 0.5, 2), name="slab")]
    >>> found = limit_load_by_direction(Assembly.from_blocks(blocks, supports=["ground"]), 4)
    >>> found.names[found.weakest], round(found.least.upper, 4), round(float(found.upper[0]), 4)
    ('+y', 0.25, 0.5)
    >>> [round(bound, 4) for bound in found.horizon]
    [0.25, 0.25]
    """
    if not isinstance(directions, (int, np.integer)) or not 4 <= directions <= MOST_DIRECTIONS or directions % 4:
        raise InputError(
            f"directions is {directions!r}; it must be a multiple of 4, for +-x and +-y to be among them, "
            f"and at most {MOST_DIRECTIONS:,}"
        )
    assembly = assembly if gravity is None else assembly.with_(gravity=gravity)
    axes = horizontal(assembly)
    problem = pose(assembly, friction=friction, gravity=None, loads=loads, gap=gap, interfaces=interfaces)

    options: dict[str, Any] = {"friction": friction, "loads": loads, "gap": gap, "interfaces": problem.given}
    options |= {"solver": solver, "flow": flow, "tolerance": tolerance}
    angles: list[float] = []
    limits: list[LimitLoad] = []
    stopped = False
    try:
        for angle in _to_look_at(directions, angles, limits, axes, refine):
            towards = _towards(axes, angle)
            found = limit_load(assembly, towards, **options)
            limits.append(found)
            angles.append(angle)
            if progress is not None:
                progress(len(limits), _name(angle, towards), found)
            if found.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE:  # so it is in every direction
                angles = [2 * np.pi * k / directions for k in range(directions)]
                limits = [found] * directions
                break
    except KeyboardInterrupt:
        if progress is None or not angles:
            raise
        stopped, limits = True, limits[: len(angles)]
    first = limits[0]
    stands = first.outcome is not LoadOutcome.DEAD_LOAD_UNSTABLE
    low, high, _ = _least(angles, limits, axes) if stands else (-np.inf, first.upper, 0.0)
    order = np.argsort(angles, kind="stable")
    # Those of a direction that is undecided are told with its name.
    told = [text for limit in limits if limit is first or limit.outcome not in OPEN for text in limit.warnings]
    return DirectionalLimits(
        angles=np.array(angles)[order],
        directions=np.array([_towards(axes, angles[k]) for k in order]),
        limits=tuple(limits[k] for k in order),
        horizon=(low, high),
        assembly=first.assembly,
        warnings=tuple(dict.fromkeys([*problem.warnings, *told])),
        stopped=stopped,
    )


def _to_look_at(
    directions: int, angles: list[float], limits: list[LimitLoad], axes: Floats, refine: bool
) -> Iterator[float]:
    """The angles of the directions, and then, from what was found so far, those that may be weaker."""
    yield from (2 * np.pi * k / directions for k in range(directions))
    for _ in range(FURTHER if refine else 0):
        low, high, weakest = _least(angles, limits, axes)
        known = np.abs(np.exp(1j * np.array(angles)) - np.exp(1j * weakest)).min() < SAME
        narrow = high - low <= NARROW * high and min(found.upper for found in limits) <= high * (1 + NARROW)
        if known or narrow or not np.isfinite(high):
            return
        yield weakest


def _towards(axes: Floats, angle: float) -> Floats:
    """The unit vector at an angle; exact along the axes."""
    turn = np.array([np.cos(angle), np.sin(angle)])
    turn[np.abs(turn) < 1e-12] = 0.0
    return np.asarray(turn @ axes, dtype=float)


def _name(angle: float, direction: Floats) -> str:
    """The coordinate axis nearest to a direction at right angles to the first one or along it; or its angle."""
    quarter = angle / (np.pi / 2)
    if abs(quarter - round(quarter)) < SAME:
        k = int(np.argmax(np.abs(direction)))
        return f"{'+' if direction[k] > 0 else '-'}{'xyz'[k]}"
    return f"{np.rad2deg(angle):.4g} deg"


def _first_of_the_least(values: Floats) -> int:
    least = np.nanmin(values)
    equal = 1e-9 * abs(least) if np.isfinite(least) else 0.0  # -inf where what touches nothing is free
    return int(np.flatnonzero(values <= least + equal)[0])


def _without_dilatancy(limit: LimitLoad) -> tuple[float, float]:
    """The bracket of the joints that carry least, if they have a limit."""
    unknown = (np.nan, np.nan)
    return unknown if limit.outcome is LoadOutcome.UNBOUNDED else limit.coulomb_least or unknown


def _beside(limit: LimitLoad, bounds: Floats) -> str:
    word = "" if limit.outcome is LoadOutcome.LIMIT else f" ({limit.outcome.word})"
    return word if np.isnan(bounds[0]) else f"{word}, without dilatancy {bounds[0]:.5g} to {bounds[1]:.5g}"


def _least(angles: list[float], limits: list[LimitLoad], axes: Floats) -> tuple[float, float, float]:
    """Bounds of the least multiplier over the horizon, and the angle at which to look next.

    The polygon of what is carried has its corners at `lower`; the mechanism of each direction gives a half-plane
    a . x <= c, c = upper a . d, and so the bound c / |a| towards a.
    """
    turn = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = turn * np.minimum([max(limit.lower, 0.0) for limit in limits], UNBOUNDED)[:, None]
    inner, facing = _distance(corners)
    least, weakest = np.inf, facing
    for direction, limit in zip(turn, limits, strict=True):
        if not np.isfinite(limit.upper):
            continue
        rate = np.array([float((acceleration(limit.assembly, axis) * limit.mechanism).sum()) for axis in axes])
        bound = limit.upper * float(rate @ direction) / float(np.linalg.norm(rate))
        if bound < least:
            least, weakest = bound, float(np.arctan2(rate[1], rate[0])) % (2 * np.pi)
    # Where a direction that is known is as weak already, it is the polygon's nearest side that is not known well.
    known = min(limit.upper for limit in limits) <= least * (1 + NARROW)
    return min(inner, least), least, facing if known else weakest


def _distance(corners: Floats) -> tuple[float, float]:
    """Distance of the origin from the convex hull's sides, and the angle of the nearest one."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(corners)
    except QhullError:  # all points in a line: something is not carried at all
        return 0.0, 0.0
    nearest = int(np.argmax(hull.equations[:, 2]))
    normal = hull.equations[nearest]
    return max(-float(normal[2]), 0.0), float(np.arctan2(normal[1], normal[0])) % (2 * np.pi)
