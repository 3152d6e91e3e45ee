"""The tilt that an assembly bears."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.coulomb import FAMILY
from blockstat.analysis.limit_load import TOLERANCE, LoadOutcome, limited
from blockstat.analysis.problem import cases_of, pose
from blockstat.analysis.tilt_friction.bisection import WIDTH, is_closed, nowhere, scan
from blockstat.analysis.tilt_friction.bracket import Bracket, of_kinds
from blockstat.analysis.tilt_friction.varied import Varied, with_warnings
from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_choice, known_options
from blockstat.imperfection.imperfections import Imperfections
from blockstat.loads import Loads, WeightedLoads, acceleration
from blockstat.solve.dispatch import CHOICES
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
#: And at this one (degrees) without dilatancy, as the programs leave 1e-4 of the friction unused.
COULOMB_WIDTH = 1e-2
UPRIGHT = "loads stay as they are while gravity rotates"


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
    varied = Varied(problem, lambda own, degrees: _turned(own, unit, degrees), loads, solver, flow)
    return with_warnings(varied, lambda own: _tilt(own, unit), *told)


def _tilt(varied: Varied, unit: Floats) -> Bracket:
    """The tilt about an axis of unit length that an assembly bears."""
    asm, judge = varied.problem.assembly, varied.answer
    if not len(asm.free):
        return _tilts(180.0, math.nan)
    sideways = np.cross(unit, asm.gravity)
    size = float(np.linalg.norm(asm.gravity))
    if np.linalg.norm(sideways) < 1e-9 * size:
        return _tilts(180.0, math.nan) if (first := judge(0.0)[0]) is Outcome.STABLE else _tilts(*nowhere(first, 0.0))
    follows = varied.loads is None and not (asm.ties or any(law.strong for law in asm.joints))
    if varied.flow == "associated" and abs(unit @ asm.gravity) < 1e-9 * size and follows:
        options: dict[str, Any] = {"solver": varied.solver, "tolerance": TOLERANCE, "optimum": True, "reserve": False}
        limit = limited(varied.problem, acceleration(asm, sideways.tolist()), None, **options)
        if limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE:
            return _tilts(*nowhere(judge(0.0)[0], 0.0))
        ends = math.degrees(math.atan(limit.lower)), math.degrees(math.atan(limit.upper))
        if limit.outcome is LoadOutcome.LIMIT:
            return replace(_tilts(*ends), open=False)
        if limit.outcome is LoadOutcome.UNDECIDED and limit.lower > 0:
            return _tilts(*scan(judge, 180.0, WIDTH, ends[0], ends[1] if limit.upper < math.inf else math.nan))
    if varied.flow == "associated":
        return _tilts(*scan(judge, 180.0, WIDTH))
    scans = [scan(varied.decided(kind), 180.0, COULOMB_WIDTH) for kind in FAMILY]
    return of_kinds(scans, "tilt", "deg")


def _tilts(stands: float, falls: float) -> Bracket:
    return Bracket(stands, falls, "tilt", "deg", open=stands < 180.0 and not is_closed(stands, falls, WIDTH))


def _turned(assembly: Assembly, axis: Floats, degrees: float) -> Assembly:
    """An assembly whose gravity has turned about an axis."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(math.radians(degrees) * axis)
    return assembly.with_(gravity=turn.apply(np.array(assembly.gravity)))
