"""Whether a curve begins where only self-stress holds: a look at friction without dilatancy and self-stress at rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.coulomb import coulomb_state
from blockstat.analysis.limit_load import limit_load
from blockstat.analysis.problem import pose
from blockstat.contact.interfaces import Interfaces
from blockstat.large_displacement.finite_steps.whole_path import IMPLICIT_ABOVE
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A curve may begin above what is carried without self-stress by this, relative to it. Chosen: next to a limit states
#: are found slowly, and no engineer needs to know of less.
ALLOWED = 0.01


def carried_without_self_stress(
    assembly: Assembly, live: Floats, dead: Floats, interfaces: Interfaces, solver: str
) -> tuple[float, float] | None:
    """Return the multiplier that is carried at rest without dilatancy and self-stress.

    Parameters
    ----------
    assembly
        The blocks.
    live, dead
        Wrenches of the load and of the permanent loads besides the weight, shape (n_blocks, 6) [N, N m].
    interfaces
        The joints.
    solver
        As in `blockstat.limit_load`.

    Returns
    -------
    tuple of float or None
        As `LimitLoad.coulomb`. None where that is not known: above `IMPLICIT_ABOVE` blocks it is not asked.
    """
    if assembly.n_blocks > IMPLICIT_ABOVE:
        return None
    options: dict[str, Any] = {"loads": dead, "interfaces": interfaces, "solver": solver}
    return limit_load(assembly, live, flow="coulomb", **options).coulomb


def carried_below_the_beginning(
    assembly: Assembly, live: Floats, dead: Floats, interfaces: Interfaces, solver: str, multiplier: float
) -> tuple[float, float] | None:
    """Return what is carried without dilatancy and self-stress, where a curve begins above it.

    Parameters
    ----------
    assembly, live, dead, interfaces, solver
        As in `carried_without_self_stress`.
    multiplier
        With which the curve begins.

    Returns
    -------
    tuple of float or None
        As `carried_without_self_stress`. None where a state without self-stress carries the multiplier, or nearly it.
    """
    if assembly.n_blocks > IMPLICIT_ABOVE or not multiplier > 0:
        return None
    loads = dead + (1.0 - ALLOWED) * multiplier * live
    if any(_settles(each, loads, interfaces, solver) for each in _with_and_without_ties(assembly)):
        return None
    found = carried_without_self_stress(assembly, live, dead, interfaces, solver)
    if found is None or not np.isfinite(found[1]) or multiplier <= (1.0 + ALLOWED) * found[1]:
        return None
    return found


def told_of_self_stress(found: tuple[float, float], multiplier: float) -> str:
    """Return what must be told of a curve that begins where only self-stress holds.

    Parameters
    ----------
    found
        What `carried_below_the_beginning` returns.
    multiplier
        With which the curve begins.

    Returns
    -------
    str
        A warning.
    """
    return (
        f"with joints that slide without dilatancy and self-stress {found[0]:.4g} to {found[1]:.4g} is carried at "
        f"rest; this curve begins at {multiplier:.4g}, which only self-stress holds"
    )


def _with_and_without_ties(assembly: Assembly) -> Iterator[Assembly]:
    """The assembly without the ties that may be without force, if it has any, and the assembly.

    What is carried while ties are not yet taut needs no self-stress of them. A state in which no tie happens to bear is
    seldom found with the ties, as any lengthening by the elasticity of joints makes them bear.
    """
    bear = tuple(tie for tie in assembly.ties if tie.least > 0)
    if len(bear) < len(assembly.ties):
        yield assembly.with_(ties=bear)
    yield assembly


def _settles(assembly: Assembly, loads: Floats, interfaces: Interfaces, solver: str) -> bool:
    """Whether a state without dilatancy and self-stress carries loads."""
    problem = pose(assembly, friction=None, gravity=None, loads=loads, gap=0.0, interfaces=interfaces)
    return problem.program is None or bool(coulomb_state(problem.program, solver=solver).settles)
