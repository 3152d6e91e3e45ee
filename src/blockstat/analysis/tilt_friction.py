"""How far an assembly is from falling: the tilt it bears and the least friction it needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.contact.point_law import LEAST_FRICTION
from blockstat.errors import InputError
from blockstat.loads import acceleration
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
#: Past a right angle there is no load multiplier; tilts are tried in steps of this many degrees and then halved.
STEP = 5.0
#: Bisections stop at this width (degrees, or friction).
WIDTH = 1e-6


@dataclass(frozen=True)
class Bracket:
    """Two neighbouring values of a parameter with proven verdicts on both sides of a limit."""

    stands: float  #: the assembly is statically stable here; nan if nowhere
    falls: float  #: and unstable here; nan if nowhere in the range

    @property
    def value(self) -> float:
        """The end that is certain: the one at which the assembly stands."""
        return self.stands


def tilt_limit(
    assembly: Assembly, axis: str | Sequence[float], *, friction: float | None = None, gap: float = GAP
) -> Bracket:
    """Angle [deg] by which gravity may be rotated about an axis before the assembly falls, in 0 to 180.

    axis : "x", "y", "z" or three numbers; the rotation is right-handed, so -axis tilts the other way.
    friction, gap : as in `assess`.
    Up to a right angle this is the limit load of a horizontal acceleration, tan(angle); beyond, and where joints have
    a strength that does not grow with the weight, verdicts are asked for angle by angle. `falls` is nan when the
    assembly stands at every angle.
    """
    direction = np.asarray(AXES[axis] if isinstance(axis, str) and axis in AXES else axis, dtype=object)
    try:
        unit = direction.astype(float)
    except (TypeError, ValueError):
        unit = np.zeros(3)
    if unit.shape != (3,) or not np.isfinite(unit).all() or not unit.any():
        raise InputError(f"axis is {axis!r}; it must be x, y, z or three numbers, not all zero")
    unit = unit / np.abs(unit).max()
    unit = unit / np.linalg.norm(unit)
    if not len(assembly.free):
        return Bracket(180.0, math.nan)
    asm = assembly if friction is None else assembly.with_(friction=friction)
    interfaces = find_interfaces(asm, gap=gap)
    sideways = np.cross(unit, asm.gravity)
    size = float(np.linalg.norm(asm.gravity))

    def verdict(degrees: float) -> Verdict:
        turned = _rotate(asm.gravity, unit, math.radians(degrees))
        return assess(asm, gravity=turned, interfaces=interfaces)

    if np.linalg.norm(sideways) < 1e-9 * size:
        return Bracket(180.0, math.nan) if verdict(0.0).outcome is Outcome.STABLE else Bracket(math.nan, 0.0)
    if abs(unit @ asm.gravity) < 1e-9 * size and not any(law.strong for law in asm.joints):
        limit = limit_load(asm, acceleration(asm, sideways.tolist()), interfaces=interfaces)
        if limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE:
            return Bracket(math.nan, 0.0)
        if limit.outcome is LoadOutcome.LIMIT:
            return Bracket(math.degrees(math.atan(limit.lower)), math.degrees(math.atan(limit.upper)))
    return _scan(lambda degrees: verdict(degrees).outcome, 180.0)


def _scan(outcome: Callable[[float], Outcome], top: float) -> Bracket:
    """First change from stable to not stable on the way up in steps, then by bisection."""
    if outcome(0.0) is not Outcome.STABLE:
        return Bracket(math.nan, 0.0)
    low = 0.0
    while low < top:
        high = min(low + STEP, top)
        if outcome(high) is Outcome.STABLE:
            low = high
            continue
        return _halve(outcome, low, high)
    return Bracket(top, math.nan)


def _halve(outcome: Callable[[float], Outcome], stands: float, falls: float, width: float = WIDTH) -> Bracket:
    """Bisect between a value that stands and one that does not; undecided values count as neither and end it."""
    while abs(falls - stands) > width:
        middle = (stands + falls) / 2
        found = outcome(middle)
        if found is Outcome.UNDECIDED:
            break
        stands, falls = (middle, falls) if found is Outcome.STABLE else (stands, middle)
    return Bracket(stands, falls)


def friction_limit(
    assembly: Assembly,
    *,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float = GAP,
    top: float = 10.0,
    width: float = WIDTH,
) -> Bracket:
    """Least coefficient of friction with which the assembly still stands, between two values at most `width` apart.

    gravity, loads, gap : as in `assess`. top : the most friction that is tried.
    More friction only adds admissible forces, so bisection is exact. `stands` is nan when not even `top` is enough;
    `falls` is nan when the assembly stands without friction (or, with cohesion, with the least that it may go with).
    """
    interfaces: Interfaces = find_interfaces(assembly, gap=gap)

    def outcome(mu: float) -> Outcome:
        return assess(assembly, friction=mu, gravity=gravity, loads=loads, interfaces=interfaces).outcome

    if outcome(top) is not Outcome.STABLE:
        return Bracket(math.nan, top)
    least = LEAST_FRICTION if any(law.cohesion for law in assembly.joints) else 0.0
    if outcome(least) is Outcome.STABLE:
        return Bracket(least, math.nan)
    return _halve(outcome, top, least, width)


def _rotate(vector: Floats, axis: Floats, angle: float) -> Floats:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angle * axis).apply(vector)
