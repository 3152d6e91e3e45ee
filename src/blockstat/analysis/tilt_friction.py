"""How far an assembly is from falling: the tilt it bears and the least friction it needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS, judged
from blockstat.analysis.coulomb import FAMILY
from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.analysis.problem import pose
from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.contact.point_law import LEAST_FRICTION
from blockstat.errors import InputError, check_choice, known_options
from blockstat.imperfection.imperfections import Imperfections, realisations
from blockstat.loads import acceleration
from blockstat.result import Result, Sentence, finite
from blockstat.solve.dispatch import CHOICES
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
#: Past a right angle there is no load multiplier; tilts are tried in steps of this many degrees and then halved.
STEP = 5.0
#: Bisections stop at this width (degrees, or friction).
WIDTH = 1e-6
#: And at this one (degrees) without dilatancy, as the programs leave 1e-4 of the friction unused.
COULOMB_WIDTH = 1e-2
#: The same of a friction.
COULOMB_FRICTION = 1e-4


class BracketOutcome(Sentence):
    """The answers of `tilt_limit` and `friction_limit`; each value is the sentence a user reads."""

    LIMIT = "Limit: the assembly stands on one side of the limit and not on the other."
    ALWAYS_STANDS = "Always stands: the assembly is stable in the whole range."
    NEVER_STANDS = "Never stands: the assembly is stable nowhere in the range."


@dataclass(frozen=True)
class Bracket(Result):
    """Two neighbouring values of a parameter with proven verdicts on both sides of a limit."""

    stands: float  #: the assembly is statically stable here; nan if nowhere
    falls: float  #: and unstable here; nan if nowhere in the range
    parameter: str = "parameter"  #: what is varied, "tilt" or "friction"
    unit: str = ""  #: of both values, "deg" or none
    #: with flow="coulomb", both values for each kind of joints (`blockstat.analysis.coulomb.FAMILY`): stiff ones,
    #: elastic ones, and both; the outer values are those of the joints that bear most
    kinds: tuple[tuple[float, float], ...] = ()
    worst: str = ""  #: the case of the imperfections that this bracket is of, the worst one, in words

    @property
    def value(self) -> float:
        """The end that is certain: the one at which the assembly stands."""
        return self.stands

    @property
    def outcome(self) -> BracketOutcome:
        """Whether there is a limit in the range."""
        if math.isnan(self.stands):
            return BracketOutcome.NEVER_STANDS
        return BracketOutcome.ALWAYS_STANDS if math.isnan(self.falls) else BracketOutcome.LIMIT

    def explain(self) -> str:
        """Return the answer in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines, unit = [self.outcome.value], f" {self.unit}" if self.unit else ""
        if self.worst:
            lines.append(f"Worst case of the imperfections: {self.worst}.")
        if not math.isnan(self.stands):
            lines.append(f"Stable at a {self.parameter} of {self.stands:.9g}{unit}.")
        if not math.isnan(self.falls):
            lines.append(f"Not stable at a {self.parameter} of {self.falls:.9g}{unit}.")
        if self.kinds:
            ends = ", ".join(f"{stands:.6g}" for stands, _ in self.kinds)
            to = "up to" if self.parameter == "tilt" else "down to"
            lines.append(f"In stiff joints, elastic ones and both in one a Coulomb state is found {to} {ends}{unit}.")
        return "\n".join(lines)

    @property
    def least(self) -> tuple[float, float]:
        """Both values for the joints that bear least; the limit is not unique without dilatancy."""
        return self.kinds[_order(self.kinds, self.parameter)[-1]] if self.kinds else (self.stands, self.falls)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; a side that does not exist is None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "parameter": self.parameter,
            "unit": self.unit,
            "stands": finite(self.stands),
            "falls": finite(self.falls),
            "imperfections": self.worst or None,
            "kinds": [[finite(stands), finite(falls)] for stands, falls in self.kinds],
        }


def _order(kinds: Sequence[tuple[float, float]], parameter: str) -> list[int]:
    """Numbers of the kinds of joints, those that bear most first: the most tilt, the least friction."""
    sign = -1.0 if parameter == "tilt" else 1.0
    return sorted(range(len(kinds)), key=lambda k: math.inf if math.isnan(kinds[k][0]) else sign * kinds[k][0])


def _of_kinds(found: Sequence[tuple[float, float]], parameter: str, unit: str = "") -> Bracket:
    """The bracket of the joints that bear most, with those of all kinds."""
    return Bracket(*found[_order(found, parameter)[0]], parameter, unit, tuple(found))


@known_options
def tilt_limit(
    assembly: Assembly,
    axis: str | Sequence[float],
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
    flow: str = "associated",
    imperfections: Imperfections | None = None,
) -> Bracket:
    """Find the angle by which gravity may be rotated about an axis before the assembly falls, from 0 to 180 degrees.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    axis : str or sequence of float, shape (3,)
        "x", "y", "z" or three numbers. The rotation is right-handed, so -axis tilts the other way.
    friction, gravity, loads, gap, interfaces, solver, flow
        As in `blockstat.assess`. `loads` stay as they are while gravity rotates.
    imperfections : Imperfections, optional
        Find the angle of the worst case of these.

    Returns
    -------
    Bracket
        Angles [deg]. `falls` is nan when the assembly stands at every angle, `stands` is nan when it does not stand as
        it is.

    Raises
    ------
    InputError
        For a bad axis or option.

    Notes
    -----
    Up to a right angle the tilt is the limit load of a horizontal acceleration, tan(angle). Beyond it, with permanent
    loads, and where joints have a strength that does not grow with the weight, verdicts are asked for angle by angle.
    With flow="coulomb" they always are, for each kind of joints (`Bracket.kinds`), and "stands" is the largest angle at
    which a checked state was found. Limits without dilatancy are not unique: `Bracket.least` has the least.

    Examples
    --------
    A block half as thick as it is high tips at atan(1/2) = 26.565 degrees.

    >>> import blockstat
    >>> from blockstat import Assembly
    >>> from blockstat import box
    >>> blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 2))]
    >>> tower = Assembly.from_blocks(blocks, supports=[0], friction=1.0)
    >>> print(f"{blockstat.tilt_limit(tower, 'y').value:.3f} degrees")
    26.565 degrees
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
    check_choice("solver", solver, CHOICES)
    check_choice("flow", flow, FLOWS)
    if not len(assembly.free):
        return _tilts(180.0, math.nan)
    changes = {name: value for name, value in (("friction", friction), ("gravity", gravity)) if value is not None}
    asm = assembly.with_(**changes) if changes else assembly
    shared = find_interfaces(asm, gap=gap) if interfaces is None else interfaces
    if imperfections is not None:
        options: dict[str, Any] = {"solver": solver, "flow": flow}
        brackets = []
        for case in realisations(asm, shared, loads, imperfections):
            own = tilt_limit(case.assembly, axis, loads=case.loads, interfaces=case.interfaces, **options)
            brackets.append(replace(own, worst=case.words))
        return min(brackets, key=lambda own: -1.0 if math.isnan(own.stands) else own.stands)
    sideways = np.cross(unit, asm.gravity)
    size = float(np.linalg.norm(asm.gravity))

    def outcome(degrees: float, kinds: Sequence[tuple[float, float]] = FAMILY) -> Outcome:
        turned = _rotate(asm.gravity, unit, math.radians(degrees))
        problem = pose(asm, friction=None, gravity=turned, loads=loads, gap=gap, interfaces=shared)
        return judged(problem, loads=loads, solver=solver, flow=flow, reserve=False, kinds=kinds).outcome

    if np.linalg.norm(sideways) < 1e-9 * size:
        stable = outcome(0.0) is Outcome.STABLE
        return _tilts(180.0, math.nan) if stable else _tilts(math.nan, 0.0)
    follows = loads is None and not any(law.strong for law in asm.joints)  # all forces grow with the weight
    if flow == "associated" and abs(unit @ asm.gravity) < 1e-9 * size and follows:
        limit = limit_load(asm, acceleration(asm, sideways.tolist()), interfaces=shared, solver=solver, optimum=True)
        if limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE:
            return _tilts(math.nan, 0.0)
        if limit.outcome is LoadOutcome.LIMIT:
            return _tilts(math.degrees(math.atan(limit.lower)), math.degrees(math.atan(limit.upper)))
    if flow == "associated":
        return _tilts(*_scan(outcome, 180.0, WIDTH))
    scans = [_scan(lambda degrees, k=kind: _decided(outcome(degrees, [k])), 180.0, COULOMB_WIDTH) for kind in FAMILY]
    return _of_kinds(scans, "tilt", "deg")


def _decided(outcome: Outcome) -> Outcome:
    """An outcome without dilatancy: where no state is found, the limit is that of finding one."""
    return Outcome.STABLE_ONLY_BY_SELF_STRESS if outcome is Outcome.UNDECIDED else outcome


def _tilts(stands: float, falls: float) -> Bracket:
    return Bracket(stands, falls, "tilt", "deg")


def _scan(outcome: Callable[[float], Outcome], top: float, width: float) -> tuple[float, float]:
    """First change from stable to not stable on the way up in steps, then by bisection."""
    if outcome(0.0) is not Outcome.STABLE:
        return math.nan, 0.0
    low = 0.0
    while low < top:
        high = min(low + STEP, top)
        if outcome(high) is Outcome.STABLE:
            low = high
            continue
        return _halve(outcome, low, high, width)
    return top, math.nan


def _halve(
    outcome: Callable[[float], Outcome], stands: float, falls: float, width: float = WIDTH
) -> tuple[float, float]:
    """Bisect between a value that stands and one that does not; undecided values count as neither and end it."""
    while abs(falls - stands) > width:
        middle = (stands + falls) / 2
        found = outcome(middle)
        if found is Outcome.UNDECIDED:
            break
        stands, falls = (middle, falls) if found is Outcome.STABLE else (stands, middle)
    return stands, falls


@known_options
def friction_limit(
    assembly: Assembly,
    *,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
    flow: str = "associated",
    top: float = 10.0,
    width: float = WIDTH,
) -> Bracket:
    """Find the least coefficient of friction with which an assembly still stands.

    Parameters
    ----------
    assembly : Assembly
        The blocks; their own coefficient of friction plays no part.
    gravity, loads, gap, interfaces, solver, flow
        As in `blockstat.assess`.
    top : float, optional
        The most friction that is tried.
    width : float, optional
        The two coefficients that are returned are at most so far apart.

    Returns
    -------
    Bracket
        Coefficients of friction. `stands` is nan when not even `top` is enough. `falls` is nan when the assembly stands
        without friction (or, with cohesion, with the least friction that cohesion may go with).

    Raises
    ------
    InputError
        For a bad option.

    Notes
    -----
    More friction only adds admissible forces, so bisection is exact. With flow="coulomb" that is not a theorem; it
    bisects for each kind of joints (`Bracket.kinds`), and "stands" is the least friction with a checked state.

    Examples
    --------
    A block on a slope of 20 degrees needs a friction of tan(20 deg) = 0.364.

    >>> import blockstat, math
    >>> from blockstat import Assembly
    >>> from blockstat import box
    >>> slope = [9.81 * math.sin(math.radians(20)), 0, -9.81 * math.cos(math.radians(20))]
    >>> blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 0.5))]
    >>> pair = Assembly.from_blocks(blocks, supports=[0], gravity=slope)
    >>> print(f"{blockstat.friction_limit(pair).value:.3f}")
    0.364
    """
    check_choice("solver", solver, CHOICES)
    check_choice("flow", flow, FLOWS)
    shared = find_interfaces(assembly, gap=gap) if interfaces is None else interfaces
    least = LEAST_FRICTION if any(law.cohesion for law in assembly.joints) else 0.0

    def outcome(mu: float, kinds: Sequence[tuple[float, float]] = FAMILY) -> Outcome:
        problem = pose(assembly, friction=mu, gravity=gravity, loads=loads, gap=gap, interfaces=shared)
        return judged(problem, loads=loads, solver=solver, flow=flow, reserve=False, kinds=kinds).outcome

    def bracket(stands: Callable[[float], Outcome], width: float) -> tuple[float, float]:
        if stands(top) is not Outcome.STABLE:
            return math.nan, top
        return (least, math.nan) if stands(least) is Outcome.STABLE else _halve(stands, top, least, width)

    if flow == "associated":
        return Bracket(*bracket(outcome, width), "friction")
    width = max(width, COULOMB_FRICTION)
    return _of_kinds([bracket(lambda mu, k=kind: _decided(outcome(mu, [k])), width) for kind in FAMILY], "friction")


def _rotate(vector: Floats, axis: Floats, angle: float) -> Floats:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angle * axis).apply(vector)
