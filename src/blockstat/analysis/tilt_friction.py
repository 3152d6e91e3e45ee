"""How far an assembly is from falling: the tilt it bears and the least friction it needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS, judged
from blockstat.analysis.coulomb import FAMILY
from blockstat.analysis.limit_load import DILATES, LoadOutcome, limit_load
from blockstat.analysis.problem import Problem, cases_of, pose
from blockstat.analysis.rims import gap_warnings
from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.point_law import keeps_friction, kept_friction, least_friction
from blockstat.errors import InputError, check_choice, check_positive, known_options
from blockstat.imperfection.imperfections import Imperfections
from blockstat.loads import Loads, WeightedLoads, acceleration
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
#: Narrower brackets of friction are not asked for: the numbers between their ends run out.
LEAST_WIDTH = 1e-12
#: Two values so far (of that width) on either side of a limit are a bracket of less than the width.
BESIDE = 0.45
#: And at this one (degrees) without dilatancy, as the programs leave 1e-4 of the friction unused.
COULOMB_WIDTH = 1e-2
#: The same of a friction.
COULOMB_FRICTION = 1e-4


#: Joints whose cone has its apex at cohesion over friction, and a tensile strength beyond.
MIXED = (
    "joints have cohesion and tensile strength of their own: more friction carries less tension there, so the assembly "
    "may fall at more friction, or stand at less"
)
UPRIGHT = "loads stay as they are while gravity rotates"
#: An outcome and its score.
Answer = tuple[Outcome, float]
#: Gives the answer at a value.
Judge = Callable[[float], Answer]
#: A value that stands and one that falls.
Ends = tuple[float, float]


class BracketOutcome(Sentence):
    """The answers of `tilt_limit` and `friction_limit`; each value is the sentence a user reads."""

    LIMIT = "Limit: the assembly stands on one side of the limit and not on the other."
    ALWAYS_STANDS = "Always stands: the assembly is stable in the whole range."
    NEVER_STANDS = "Never stands: the assembly is stable nowhere in the range."
    CHANGE = (
        "Change: a Coulomb state was found at one of two neighbouring values and none at the other. Without dilatancy "
        "that says nothing of values that were not tried."
    )
    NOT_FOUND = (
        "Not found: there is no proof that the assembly never stands, but where it should stand first no Coulomb state "
        "was found."
    )
    OPEN = "Open: the assembly stands at the value given; what it does just beyond could not be proven."
    UNDECIDED = "Undecided: too close to the limit to prove either way, even where the assembly would stand first."


@dataclass(frozen=True)
class Bracket(Result):
    """Two values of a parameter with proven verdicts on both sides of a limit: neighbours, unless `open`."""

    stands: float  #: the assembly is statically stable here; nan if nowhere
    falls: float  #: and unstable here; nan if nowhere in the range, or where no fall could be proven
    parameter: str = "parameter"  #: what is varied, "tilt" or "friction"
    unit: str = ""  #: of both values, "deg" or none
    #: with flow="coulomb", both values for each kind of joints (`blockstat.analysis.coulomb.FAMILY`): stiff ones,
    #: elastic ones, and both; the outer values are those of the joints that bear most
    kinds: tuple[tuple[float, float], ...] = ()
    worst: str = ""  #: the case of the imperfections that this bracket is of, the worst one, in words
    warnings: tuple[str, ...] = ()
    flow: str = "associated"  #: or "coulomb", as it was asked
    #: whether verdicts just beyond `stands` are undecided, so that no fall is proven, or one further off than was asked
    open: bool = False

    @property
    def value(self) -> float:
        """The end that is certain: the one at which the assembly stands."""
        return self.stands

    @property
    def outcome(self) -> BracketOutcome:
        """Whether there is a limit in the range; open where one side is known, undecided where neither is.

        Without dilatancy an assembly may stand with less friction and fall with more, and values tried are all that is
        known: there is a change in place of a limit.
        """
        sampled = self.flow == "coulomb"
        if math.isnan(self.stands) and math.isnan(self.falls):
            return BracketOutcome.NOT_FOUND if sampled else BracketOutcome.UNDECIDED
        if math.isnan(self.stands):
            return BracketOutcome.NEVER_STANDS
        if self.open:
            return BracketOutcome.OPEN
        if math.isnan(self.falls):
            return BracketOutcome.ALWAYS_STANDS
        return BracketOutcome.CHANGE if sampled else BracketOutcome.LIMIT

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
        stands, falls = _told_apart(self.stands, self.falls)
        if not math.isnan(self.stands):
            lines.append(f"Stable at a {self.parameter} of {stands}{unit}.")
        if not math.isnan(self.falls):
            lines.append(f"Not stable at a {self.parameter} of {falls}{unit}.")
        if self.kinds:
            ends = ", ".join("none" if math.isnan(stands) else f"{stands:.6g}" for stands, _ in self.kinds)
            to = "up to" if self.parameter == "tilt" else "down to"
            lines.append(f"In stiff joints, elastic ones and both in one a Coulomb state is found {to} {ends}{unit}.")
        elif self.flow == "associated" and not math.isnan(self.stands):
            lines.append(DILATES)
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

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
            "warnings": list(self.warnings),
        }


def _told_apart(first: float, second: float) -> tuple[str, str]:
    """Two numbers with nine digits, or with as many as tell them apart."""
    pairs = [(f"{first:.{digits}g}", f"{second:.{digits}g}") for digits in range(9, 18)]
    return next((pair for pair in pairs if pair[0] != pair[1]), pairs[0])


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
    loads: Loads | None = None,
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
        As in `blockstat.assess`. `loads` stay as they are while gravity rotates, and a warning says so.
    imperfections : Imperfections, optional
        Find the angle of the worst case of these.

    Returns
    -------
    Bracket
        Angles [deg]. `falls` is nan when the assembly stands at every angle. `stands` is nan when it does not stand as
        it is. Where verdicts just beyond `stands` are undecided the outcome is "open". `falls` is then further off, or
        nan where no fall was proven.

    Raises
    ------
    InputError
        For a bad axis or option.

    Notes
    -----
    Up to a right angle the tilt is the limit load of a horizontal acceleration, tan(angle). Beyond it, with permanent
    loads, and with ties and strengths, which do not grow with the weight, verdicts are asked for in steps of 5 degrees,
    and the first change is closed in on: a fall that stands again within a step is not seen. The search ends with the
    first step whose verdict is undecided, and a fall beyond it is not looked for.
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
    problem = pose(assembly, friction=friction, gravity=gravity, loads=loads, gap=gap, interfaces=interfaces)
    told = [UPRIGHT] if np.any(loads.beside if isinstance(loads, WeightedLoads) else loads) else []
    if imperfections is not None:
        options: dict[str, Any] = {"solver": solver, "flow": flow, "gap": gap}
        brackets = []
        for case in cases_of(problem, loads, imperfections):
            own = tilt_limit(case.assembly, axis, loads=case.loads, interfaces=case.interfaces, **options)
            brackets.append(replace(own, worst=case.words))
        worst = min(brackets, key=lambda own: -1.0 if math.isnan(own.least[0]) else own.least[0])
        return replace(worst, warnings=problem.warnings_with(worst.warnings))
    return _with_warnings(replace(_tilt(problem, unit, loads, solver, flow), flow=flow), problem, loads, solver, *told)


def _with_warnings(found: Bracket, problem: Problem, loads: Loads | None, solver: str, *more: str) -> Bracket:
    """A bracket with what its reader must know of the joints; of near ones where the assembly does not stand.

    problem : as posed where the assembly would stand first
    """
    nowhere = math.isnan(found.stands)
    motion = judged(problem, loads=loads, solver=solver, reserve=False).mechanism if nowhere else None
    doubts = gap_warnings(problem, more_may_help=nowhere, mechanism=motion)
    return replace(found, warnings=(*problem.warnings, *doubts, *more))


def _tilt(problem: Problem, unit: Floats, loads: Loads | None, solver: str, flow: str) -> Bracket:
    """The tilt about an axis of unit length that an assembly bears."""
    asm, shared, gap = problem.assembly, problem.given, problem.gap
    if not len(asm.free):
        return _tilts(180.0, math.nan)
    sideways = np.cross(unit, asm.gravity)
    size = float(np.linalg.norm(asm.gravity))

    def judge(degrees: float, kinds: Sequence[tuple[float, float]] = FAMILY) -> Answer:
        turned = _rotate(asm.gravity, unit, math.radians(degrees))
        problem = pose(asm, friction=None, gravity=turned, loads=loads, gap=gap, interfaces=shared)
        found = judged(problem, loads=loads, solver=solver, flow=flow, reserve=False, kinds=kinds)
        return found.outcome, found.score

    if np.linalg.norm(sideways) < 1e-9 * size:
        return _tilts(180.0, math.nan) if (first := judge(0.0)[0]) is Outcome.STABLE else _tilts(*_nowhere(first, 0.0))
    follows = loads is None and not (asm.ties or any(law.strong for law in asm.joints))
    if flow == "associated" and abs(unit @ asm.gravity) < 1e-9 * size and follows:
        options: dict[str, Any] = {"interfaces": shared, "gap": gap, "solver": solver, "optimum": True}
        limit = limit_load(asm, acceleration(asm, sideways.tolist()), **options)
        if limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE:
            return _tilts(*_nowhere(judge(0.0)[0], 0.0))
        ends = math.degrees(math.atan(limit.lower)), math.degrees(math.atan(limit.upper))
        if limit.outcome is LoadOutcome.LIMIT:
            return replace(_tilts(*ends), open=False)
        if limit.outcome is LoadOutcome.UNDECIDED and limit.lower > 0:
            return _tilts(*_scan(judge, 180.0, WIDTH, ends[0], ends[1] if limit.upper < math.inf else math.nan))
    if flow == "associated":
        return _tilts(*_scan(judge, 180.0, WIDTH))
    scans = [_scan(lambda degrees, k=kind: _decided(judge(degrees, [k])), 180.0, COULOMB_WIDTH) for kind in FAMILY]
    return _of_kinds(scans, "tilt", "deg")


def _decided(answer: Answer) -> Answer:
    """An answer without dilatancy: no state found is none, and no score leads to the limit."""
    outcome = Outcome.STABLE_ONLY_BY_SELF_STRESS if answer[0] is Outcome.UNDECIDED else answer[0]
    return outcome, math.nan


def _tilts(stands: float, falls: float) -> Bracket:
    return Bracket(stands, falls, "tilt", "deg", open=stands < 180.0 and not _is_closed(stands, falls, WIDTH))


def _is_closed(stands: float, falls: float, width: float) -> bool:
    """Whether two values are as near as was asked, or no number lies between them; nan is near to nothing."""
    return abs(falls - stands) <= max(width, float(np.spacing(max(abs(stands), abs(falls)))))


def _scan(judge: Judge, top: float, width: float, stands: float = 0.0, falls: float = math.nan) -> Ends:
    """First change from stable to not stable on the way up in steps, then closed in.

    stands : where it is above 0, a value that is known to stand and close to the limit, so the first step is small
    falls : a value that is known to fall, or nan
    """
    if not stands and (first := judge(0.0)[0]) is not Outcome.STABLE:
        return _nowhere(first, 0.0)
    low, step = stands, width if stands else STEP
    while low < top:
        high = min(low + step, top)
        if (outcome := judge(high)[0]) is not Outcome.STABLE:
            beyond = {falls: Outcome.UNSTABLE} if falls > high else {}
            return _close_in(judge, low, {high: outcome, **beyond}, width)
        low, step = high, STEP
    return top, math.nan


def _nowhere(first: Outcome, value: float) -> tuple[float, float]:
    """The bracket of an assembly that does not stand at the value where it would stand first.

    Only a mechanism is a proof that it stands nowhere.
    """
    return math.nan, value if first is Outcome.UNSTABLE else math.nan


def _close_in(judge: Judge, stands: float, others: dict[float, Outcome], width: float = WIDTH) -> Ends:
    """Bring a value that stands and one that falls together; nan for the second where no fall is proven.

    Where values between are undecided, each is brought near to these on its own side.

    others : values that do not stand, on one side of the one that stands, at least one
    """
    tried = dict(others)

    def away(value: float) -> float:
        return abs(value - stands)

    stands, _ = _halved(judge, stands, min(others, key=away), width, tried, Outcome.STABLE)
    fell = [value for value, outcome in tried.items() if outcome not in (Outcome.STABLE, Outcome.UNDECIDED)]
    if not fell:
        return stands, math.nan
    falls = min(fell, key=away)
    doubts = [value for value, outcome in tried.items() if outcome is Outcome.UNDECIDED and away(value) < away(falls)]
    if doubts:
        # Quarters leave half of the width to undecided values that are only numerical.
        _, falls = _halved(judge, max(doubts, key=away), falls, width / 4, tried, Outcome.STABLE, Outcome.UNDECIDED)
        stands, _ = _halved(judge, stands, min(doubts, key=away), width / 4, tried, Outcome.STABLE)
    return stands, falls


def _halved(judge: Judge, near: float, far: float, width: float, tried: dict[float, Outcome], *inside: Outcome) -> Ends:
    """Bring a value whose outcome is `inside` and one whose outcome is not together; values tried are noted.

    The score of what falls vanishes towards the limit, nearly along a line. So the places just beside the zero of the
    line through the last two scores are tried, and the middle wherever that has not halved the bracket.
    """
    scores: list[tuple[float, float]] = []
    aims = True
    while (wide := abs(far - near)) > width:
        aim = _beside_the_zero(scores, near, far, width) if aims else None
        trial = (near + far) / 2 if aim is None else aim
        if trial in (near, far):
            break  # no number lies between them
        outcome, score = judge(trial)
        tried[trial] = outcome
        if outcome in inside:
            near = trial
        else:
            far = trial
            falls = outcome is not Outcome.UNDECIDED and math.isfinite(score) and score > 0
            scores = [*scores[-1:], (trial, score)] if falls else scores
        aims = aim is None or abs(far - near) <= wide / 2
    return near, far


def _beside_the_zero(scores: Sequence[tuple[float, float]], near: float, far: float, width: float) -> float | None:
    """A value next to the zero of the line through two scores, on the side not yet known; None where there is none."""
    if len(scores) < 2 or scores[0][1] <= scores[1][1]:
        return None
    (one, high), (other, low) = scores
    zero = other + low * (other - one) / (high - low)
    aside = math.copysign(BESIDE * width, near - far)
    inside = (value for value in (zero + aside, zero - aside) if min(near, far) < value < max(near, far))
    return next(inside, None)


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
        The blocks; their own coefficient of friction plays no part. Joints whose law has a friction keep it.
    gravity, loads, gap, interfaces, solver, flow
        As in `blockstat.assess`.
    top : float, optional
        The most friction that is tried, finite.
    width : float, optional
        The two coefficients that are returned are at most so far apart, unless the outcome is "open".

    Returns
    -------
    Bracket
        Coefficients of friction. `stands` is nan when not even `top` is enough. `falls` is nan when the assembly stands
        without friction (or, with cohesion, with the least friction that cohesion may go with). Where verdicts just
        below `stands` are undecided the outcome is "open". Both are then as near to the undecided values as `width`,
        and `falls` is nan where no fall was proven.

    Raises
    ------
    InputError
        For a bad option, for a `top` that is not finite, and where the laws of all joints have a friction.

    Notes
    -----
    More friction only adds admissible forces, so a bracket is closed in on exactly, by the scores of what falls and by
    bisection. With flow="coulomb" that is not a theorem. It bisects for each kind of joints (`Bracket.kinds`), and
    "stands" is the least friction with a checked state; the outcome is a change or "not found" where no mechanism
    proves more.

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
    check_positive("top", top)
    check_positive("width", width, least=LEAST_WIDTH)
    posed = pose(
        assembly.with_(friction=top), friction=None, gravity=gravity, loads=loads, gap=gap, interfaces=interfaces
    )
    shared, told = posed.given, _friction_of_laws(assembly, posed.interfaces)
    least = least_friction(assembly)
    mixed = any(law.cohesion and (law.tension or law.bond) for law in assembly.joints)
    told += [MIXED] if mixed else []

    def judge(mu: float, kinds: Sequence[tuple[float, float]] = FAMILY) -> Answer:
        varied = assembly.with_(friction=mu)
        problem = pose(varied, friction=None, gravity=gravity, loads=loads, gap=gap, interfaces=shared)
        found = judged(problem, loads=loads, solver=solver, flow=flow, reserve=False, kinds=kinds)
        return found.outcome, found.score

    def bracket(judge: Judge, width: float) -> tuple[float, float]:
        if (first := judge(top)[0]) is not Outcome.STABLE:
            return _nowhere(Outcome.UNDECIDED if mixed else first, top)
        if (last := judge(least)[0]) is Outcome.STABLE:
            return least, math.nan
        return _close_in(judge, top, {least: last}, width)

    if flow == "associated":
        stands, falls = bracket(judge, width)
        unknown = stands > least and not _is_closed(stands, falls, width)
        return _with_warnings(Bracket(stands, falls, "friction", open=unknown), posed, loads, solver, *told)
    width = max(width, COULOMB_FRICTION)
    found = [bracket(lambda mu, k=kind: _decided(judge(mu, [k])), width) for kind in FAMILY]
    return _with_warnings(replace(_of_kinds(found, "friction"), flow=flow), posed, loads, solver, *told)


def _friction_of_laws(assembly: Assembly, interfaces: Interfaces) -> list[str]:
    """What is said where joints have a friction of their own, which does not vary; refused where all have."""
    kept = keeps_friction(assembly, interfaces)
    if not kept.any():
        return []
    words = kept_friction(assembly, interfaces, kept)
    if kept.all():
        raise InputError(f'"{assembly.name}": all joints {words}; leave it out where friction is asked for')
    return [f"{kept.sum()} of {len(kept)} joints {words}"]


def _rotate(vector: Floats, axis: Floats, angle: float) -> Floats:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angle * axis).apply(np.array(vector))
