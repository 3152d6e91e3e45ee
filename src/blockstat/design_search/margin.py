"""The reserve that a design must have, and its derivatives by each parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.tilt_friction.tilt import AXES
from blockstat.analysis.verdict import Outcome
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import InputError, check_choice, check_number, check_vector
from blockstat.imperfection.imperfections import Imperfections, realisations
from blockstat.loads import acceleration
from blockstat.sensitivity.parameters import slopes_of_limit, slopes_of_score
from blockstat.typing import Floats

STABLE = Outcome.STABLE.word
Make = Callable[[Mapping[str, float]], Assembly]

TOP = 10.0  #: reserves are told apart up to this multiple of the load
#: Step of differences, relative to a parameter: of volumes, and of limit loads where joints change on the way.
SMALL, WIDE = 1e-6, 1e-4
#: A bracket no wider than this [g] is a limit: between designs that differ by less there is nothing to choose.
NARROW = 1e-5
LEVEL = 1e-9  #: sine of the slope of a direction that is horizontal but for rounding
#: Where only the assemblies of imperfections are asked for.
NO_JOINTS = Interfaces(
    np.empty((0, 2), np.int64), np.empty((0, 3, 3)), np.empty(0), np.empty(0), np.empty((0, 3)), np.zeros(1, np.int64)
)


@dataclass(frozen=True)
class Margin:
    """A reserve that a design must have: a horizontal acceleration that it carries, with less friction than it has.

    Parameters
    ----------
    direction : tuple of float, shape (3,)
        Of the acceleration; a multiplier of 1 is an acceleration of g.
    least : float
        Multiplier that the design must carry; 0 asks only that it stands.
    friction : float
        The design must do with its coefficient of friction divided by this, at least 1.
    imperfections : Imperfections, optional
        The design must carry the multiplier in their worst case.
    gap : float or str
        Largest gap of a joint, as in `blockstat.assess`; `blockstat.search` sets its own.
    """

    direction: tuple[float, float, float] = (0.0, 1.0, 0.0)
    least: float = 0.0
    friction: float = 1.0
    imperfections: Imperfections | None = None
    gap: float | str = field(default=GAP, repr=False)  # a history names it otherwise

    def __post_init__(self) -> None:
        check_vector("margin: direction", self.direction)
        check_number("margin: least", self.least)
        if not 0 <= self.least < TOP:
            raise InputError(f"margin: least is {self.least!r}; it must be from 0 to below {TOP:g}")
        check_number("margin: friction", self.friction, least=1.0)

    @classmethod
    def tilt(cls, axis: str | Sequence[float], degrees: float) -> Margin:
        """Return the reserve of a design that stands though the ground is tilted.

        Parameters
        ----------
        axis : str or sequence of float, shape (3,)
            Horizontal axis of the tilt, "x", "y" or three numbers; z is up.
        degrees : float
            Angle of the tilt, from 0 to below 80.

        Returns
        -------
        Margin

        Raises
        ------
        InputError
            For an axis that is none or not horizontal, and an angle out of range.

        Examples
        --------
        >>> from blockstat import Margin
        >>> round(Margin.tilt("x", 45).least, 12)
        1.0
        """
        if isinstance(axis, str):
            check_choice("margin: axis", axis, ("x", "y"))
        unit = check_vector("margin: axis", AXES[axis] if isinstance(axis, str) else axis)
        if abs(unit[2]) > LEVEL * np.linalg.norm(unit):
            raise InputError(f"margin: axis is {axis!r}; it must be horizontal: x, y, or three numbers of which z is 0")
        check_number("margin: degrees", degrees)
        if not 0 <= degrees < 80:
            raise InputError(f"margin: a tilt of {degrees!r} degrees; it must be from 0 to below 80")
        x, y, z = np.cross(unit, (0.0, 0.0, -1.0)) / np.linalg.norm(unit)
        return cls((float(x), float(y), float(z)), math.tan(math.radians(degrees)))

    def applied(self, assembly: Assembly) -> Assembly:
        """Return an assembly with the friction that it must do with.

        Parameters
        ----------
        assembly : Assembly
            The design.

        Returns
        -------
        Assembly

        Raises
        ------
        InputError
            When joint laws have a friction of their own, which is not divided.
        """
        if self.friction == 1.0:
            return assembly
        if any(law.friction is not None for law in assembly.joints):
            raise InputError("margin: friction of joint laws is not divided; ask for a reserve of load instead")
        return assembly.with_(friction=assembly.friction / self.friction)

    def cases(self, assembly: Assembly) -> list[Assembly]:
        """Return the assemblies among which the worst case of a design is.

        Parameters
        ----------
        assembly : Assembly
            The design.

        Returns
        -------
        list of Assembly
            As many for all designs of a scene.

        Raises
        ------
        InputError
            As `applied`, and for imperfections of groups that the design has not.
        """
        weaker = self.applied(assembly)
        if self.imperfections is None:
            return [weaker]
        own = replace(self.imperfections, edge=0.0)  # of the joints `joints` says
        return [case.assembly for case in realisations(weaker, NO_JOINTS, None, own)]

    def joints(self, assembly: Assembly) -> Interfaces:
        """Return the joints of one of the cases.

        Parameters
        ----------
        assembly : Assembly
            The case.

        Returns
        -------
        Interfaces
            Without the edges that they lose.
        """
        found = find_interfaces(assembly, gap=self.gap)
        return found if self.imperfections is None else self.imperfections.joints(assembly, found)


@dataclass(frozen=True)
class Measured:
    """Volume of the free blocks [m3] and reserve of a design, and their derivatives by each parameter."""

    volume: float
    reserve: float  #: limit load multiplier; minus the score where the design does not stand; at most `TOP`
    static: str
    blocks: int
    volume_slopes: Floats
    reserve_slopes: Floats


def measure(make: Make, values: Mapping[str, float], moved: Sequence[str], margin: Margin) -> Measured:
    """Measure the volume and the reserve of a design, and their derivatives.

    Parameters
    ----------
    make : callable
        Builds the assembly of some values, of which those of `moved` may lie a little out of bounds.
    values : mapping of str to float
        Parameter values of the design.
    moved : sequence of str
        The parameters to take derivatives by.
    margin : Margin
        Reserve to measure.

    Returns
    -------
    Measured
        With slopes in the order of `moved`.

    Raises
    ------
    InputError
        For a design that cannot be built.

    Notes
    -----
    The reserve is continuous: at the limit both the multiplier and the score are zero. Its derivatives are exact where
    the joints stay the same and differences where they do not.
    """
    assembly = make(values)
    cases = margin.cases(assembly)
    worst = 0 if len(cases) == 1 else int(np.argmin([_multiplier(case, margin) for case in cases]))
    others = {name: value for name, value in values.items() if name not in moved}

    def made(changed: Mapping[str, float]) -> Assembly:
        return margin.cases(make({**{name: 0.0 for name in values}, **others, **changed}))[worst]

    point = {name: values[name] for name in moved}
    volume_slopes = _slopes(lambda v: _volume(made(v)), point, SMALL)
    reserve, slopes, word = _reserve(made, point, margin)
    return Measured(_volume(assembly), reserve, word, assembly.n_blocks, volume_slopes, slopes)


def _multiplier(case: Assembly, margin: Margin) -> float:
    """What a case carries; a negative score where it does not stand, and where that is left open."""
    joints = margin.joints(case)
    found = limit_load(case, margin.direction, interfaces=joints, gap=joints.searched)
    if found.outcome is not LoadOutcome.DEAD_LOAD_UNSTABLE and found.lower > -math.inf:
        return found.lower
    return -assess(case, interfaces=joints, gap=joints.searched).score


def _reserve(made: Make, point: Mapping[str, float], margin: Margin) -> tuple[float, Floats, str]:
    case = made(point)
    joints = margin.joints(case)
    verdict = assess(case, interfaces=joints, gap=joints.searched)
    limit = None if verdict.outcome is Outcome.UNSTABLE else _limit(case, joints, margin)
    if limit is not None and limit.outcome is LoadOutcome.UNBOUNDED:
        return TOP, np.zeros(len(point)), STABLE
    if limit is not None and (limit.outcome is LoadOutcome.LIMIT or limit.lower > 0):  # a wide bracket, too
        try:
            slopes = slopes_of_limit(limit, made, point, partial(_load, margin), joints=margin.joints)
        except InputError:
            return limit.lower, _slopes(lambda v: _lower(made(v), margin), point, WIDE), STABLE
        return limit.lower, _by_name(slopes, point), STABLE
    if not math.isfinite(verdict.score):
        return -TOP, np.zeros(len(point)), verdict.outcome.word
    try:
        slopes = slopes_of_score(verdict, made, point, joints=margin.joints)
    except InputError:
        return -verdict.score, _slopes(lambda v: _multiplier(made(v), margin), point, WIDE), verdict.outcome.word
    return -verdict.score, -_by_name(slopes, point), verdict.outcome.word


def _limit(case: Assembly, joints: Interfaces, margin: Margin) -> LimitLoad:
    found = limit_load(case, _load(margin, case), interfaces=joints, gap=joints.searched, optimum=True)
    if found.outcome is LoadOutcome.UNDECIDED and found.upper - found.lower <= NARROW:
        return replace(found, outcome=LoadOutcome.LIMIT)
    return found


def _lower(case: Assembly, margin: Margin) -> float:
    return _limit(case, margin.joints(case), margin).lower


def _load(margin: Margin, case: Assembly) -> Floats:
    return acceleration(case, margin.direction)


def _by_name(slopes: Mapping[str, float], point: Mapping[str, float]) -> Floats:
    return np.array([slopes[name] for name in point])


def _slopes(value: Callable[[Mapping[str, float]], float], point: Mapping[str, float], step: float) -> Floats:
    """Differences: central where both neighbours have a value, else to the side that has one, 0 where none has."""
    slopes = []
    for name, at in point.items():
        width = step * max(abs(at), 1.0)
        ends = [found for place in (at - width, at + width) for found in _value_at(value, point, name, place)]
        if len(ends) == 1:
            ends += _value_at(value, point, name, at)
        slopes.append((ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0]) if len(ends) > 1 else 0.0)
    return np.array(slopes)


def _value_at(
    value: Callable[[Mapping[str, float]], float], point: Mapping[str, float], name: str, place: float
) -> list[tuple[float, float]]:
    """A parameter's value and what it gives there; nothing where that is no number."""
    try:
        found = value({**point, name: place})
    except InputError:
        return []
    return [(place, found)] if math.isfinite(found) else []


def _volume(assembly: Assembly) -> float:
    return float(assembly.volume[assembly.free].sum())
