"""The protocol of loads, and the loads that a call is handed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.typing import Floats
from dynsim.engine.world import Action
from dynsim.loads.loading import Constant


@runtime_checkable
class Load(Action, Protocol):
    """An action that comes to an end, so that what is left has a verdict."""

    @property
    def end(self) -> float:
        """Time since release after which the load no longer changes [s]; -inf for one that is there throughout."""
        ...

    @property
    def travel(self) -> float:
        """How far the load itself carries blocks [m]; that is not counted as falling."""
        ...


#: What the option `loads` takes: loads of this package, and wrenches as `blockstat.assess` takes them.
Loads: TypeAlias = "Load | Floats | Sequence[Load | Floats]"


def as_loads(assembly: Assembly, loads: Loads | None) -> tuple[Load, ...]:
    """Return what acts on an assembly besides its weight as loads.

    Parameters
    ----------
    assembly : Assembly
        What the loads act on.
    loads : Load, array of shape (n_blocks, 6), or a sequence of them
        An array holds a wrench on each block about its centroid [N, N m], as the option of the same name of
        `blockstat.assess`; it acts from the first step of settling on.

    Returns
    -------
    tuple of Load
        An array becomes a `Constant`; one of zeros is left out.

    Raises
    ------
    InputError
        For what is no load, and for an array of another shape or with values that are not finite.
    """
    if loads is None:
        return ()
    entries = [loads] if isinstance(loads, (Load, np.ndarray)) else list(loads)
    found: list[Load] = []
    for entry in entries:
        if isinstance(entry, Load) and not isinstance(entry, type):
            found.append(entry)
        elif isinstance(entry, np.ndarray):
            found += _constant(assembly, entry)
        else:
            raise InputError(
                f"loads: {entry!r} is no load; loads are Constant, Tilt, Settlement, Removal, Push, Pulse, Ramp, "
                f"Record and arrays of shape ({assembly.n_blocks}, 6); what has no end, such as a spring, is an action"
            )
    return tuple(found)


def as_actions(actions: Action | Sequence[Action] | None) -> tuple[Action, ...]:
    """Return what else acts on the blocks of an assembly, as a tuple.

    Parameters
    ----------
    actions : Action, or a sequence of them
        What has no end, such as a spring.

    Returns
    -------
    tuple of Action
        The actions.

    Raises
    ------
    InputError
        For what is no action, and for a load: whoever judges a run must know when it ends.
    """
    if actions is None:
        return ()
    given = tuple(actions) if isinstance(actions, Iterable) else (actions,)
    for entry in given:
        if isinstance(entry, type) or not (hasattr(entry, "begin") and hasattr(entry, "act")):
            raise InputError(f"actions: {entry!r} is no action, as AngularSprings and InertiaScale are")
        if isinstance(entry, Load):
            raise InputError(f"actions: {entry!r} is a load; it must be given as one of the loads")
    return given


def _constant(assembly: Assembly, wrenches: Floats) -> list[Load]:
    if wrenches.shape != (assembly.n_blocks, 6) or not np.isfinite(wrenches).all():
        raise InputError(
            f"loads have shape {wrenches.shape}; finite values of shape ({assembly.n_blocks}, 6) are needed"
        )
    return [Constant(wrenches)] if wrenches.any() else []
