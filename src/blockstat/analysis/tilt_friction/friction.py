"""The least friction that an assembly needs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from blockstat.analysis.assess import FLOWS
from blockstat.analysis.coulomb import FAMILY
from blockstat.analysis.problem import pose
from blockstat.analysis.tilt_friction.bisection import WIDTH, Judge, close_in, is_closed, nowhere
from blockstat.analysis.tilt_friction.bracket import Bracket, of_kinds
from blockstat.analysis.tilt_friction.varied import Varied, with_warnings
from blockstat.analysis.verdict import Outcome
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.point_law import keeps_friction, kept_friction, least_friction
from blockstat.errors import InputError, check_choice, check_positive, known_options
from blockstat.solve.dispatch import CHOICES
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Narrower brackets of friction are not asked for: the numbers between their ends run out.
LEAST_WIDTH = 1e-12
#: Bisections stop at this width without dilatancy, as the programs leave 1e-4 of the friction unused.
COULOMB_FRICTION = 1e-4
#: Joints whose cone has its apex at cohesion over friction, and a tensile strength beyond.
MIXED = (
    "joints have cohesion and tensile strength of their own: more friction carries less tension there, so the assembly "
    "may fall at more friction, or stand at less"
)


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
    mixed = any(law.cohesion and (law.tension or law.bond) for law in assembly.joints)
    told = [*_friction_of_laws(assembly, posed.interfaces), *([MIXED] if mixed else [])]

    varied = Varied(posed, lambda own, mu: own.with_(friction=mu), loads, solver, flow)
    return with_warnings(varied, lambda own: _friction(own, top, width, mixed), *told)


def _friction(varied: Varied, top: float, width: float, mixed: bool) -> Bracket:
    """The least coefficient of friction up to some with which an assembly stands."""
    least = least_friction(varied.problem.assembly)

    def bracket(judge: Judge, width: float) -> tuple[float, float]:
        if (first := judge(top)[0]) is not Outcome.STABLE:
            return nowhere(Outcome.UNDECIDED if mixed else first, top)
        if (last := judge(least)[0]) is Outcome.STABLE:
            return least, math.nan
        return close_in(judge, top, {least: last}, width)

    if varied.flow == "associated":
        stands, falls = bracket(varied.answer, width)
        return Bracket(stands, falls, "friction", open=stands > least and not is_closed(stands, falls, width))
    width = max(width, COULOMB_FRICTION)
    return of_kinds([bracket(varied.decided(kind), width) for kind in FAMILY], "friction")


def _friction_of_laws(assembly: Assembly, interfaces: Interfaces) -> list[str]:
    """What is said where joints have a friction of their own, which does not vary; refused where all have."""
    kept = keeps_friction(assembly, interfaces)
    if not kept.any():
        return []
    words = kept_friction(assembly, interfaces, kept)
    if kept.all():
        raise InputError(f'"{assembly.name}": all joints {words}; leave it out where friction is asked for')
    return [f"{kept.sum()} of {len(kept)} joints {words}"]
