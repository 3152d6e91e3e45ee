"""Names of version 0.1 that are elsewhere now. They work until 0.3, with a DeprecationWarning of the new name."""

from __future__ import annotations

import sys

TYPE_CHECKING = False  # as typing has it, which takes longer to import than this module
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, ParamSpec, TypeVar

    P = ParamSpec("P")
    T = TypeVar("T")

#: Names that are spelled in another way now, and those of modules that are rooms now.
NAMES = {
    "blockstat.heal": "blockstat.repair",
    "blockstat.model.build": "blockstat.build",
    "blockstat.plot.picture": "blockstat.plot",
    "blockstat.plot.picture_of_forces": "blockstat.plot_forces",
    "blockstat.plot.picture_of_help": "blockstat.plot_stone_sensitivity",
    "blockstat.plot.picture_of_mechanism": "blockstat.plot_mechanism",
    "blockstat.plot.picture_of_verdict": "blockstat.plot_verdict",
    "blockstat.program.PenaltyProgram": "blockstat.program.penalty.PenaltyProgram",
    "blockstat.program.penalty_program": "blockstat.program.penalty.penalty_program",
    "blockstat.sensitivity.lacking": "blockstat.sensitivity.parameters.penalty_optimum",
    "blockstat.sensitivity.limit_load_gradient": "blockstat.limit_load_gradient",
    "blockstat.sensitivity.pinned": "blockstat.sensitivity.parameters.pinned",
    "blockstat.sensitivity.score_gradient": "blockstat.score_gradient",
    "blockstat.sensitivity.stone_sensitivity": "blockstat.stone_sensitivity",
    "blockstat.solve.certificate.cone_room": "blockstat.certificate.check.cone_slack",
    "blockstat.solve.certificate.opening_room": "blockstat.certificate.check.opening_slack",
    "blockstat.solve.certificate.room_of": "blockstat.certificate.check.point_slack",
    "blockstat.solve.dual.solve": "blockstat.solve.penalty.solve_penalty",
    "blockstat.utilisation.picture_of_utilisation": "blockstat.plot_utilisation",
    "dynsim.first_motion.cosine": "dynsim.first_motion_cosine",
}
#: Modules that a user of 0.1 was told to import from, and where their other names are now, spelled as before.
MODULES = {
    "blockstat.animate": "blockstat.view.animation",
    "blockstat.coulomb": "blockstat.analysis.coulomb",
    "blockstat.equilibrium": "blockstat.program.equilibrium",
    "blockstat.paint": "blockstat.view.painter",
    "blockstat.plot": "blockstat.view.plot",
    "blockstat.report": "blockstat.view.report blockstat.view.document",
    "blockstat.reserve": "blockstat.analysis.tilt_friction.bracket blockstat.analysis.tilt_friction.tilt "
    "blockstat.analysis.tilt_friction.friction",
    "blockstat.search": "blockstat.design_search.search blockstat.design_search.candidate "
    "blockstat.design_search.evaluator blockstat.design_search.margin blockstat.design_search.space",
    "blockstat.solve.certificate": "blockstat.certificate.check",
    "blockstat.solve.dual": "blockstat.solve.penalty",
    "blockstat.sweep": "blockstat.design_search.sweep",
    "blockstat.utilisation": "blockstat.view.utilisation",
    "blockstat.vertex_sensitivity": "blockstat.sensitivity.vertices",
    "dynsim.buttresses": "dynsim.design_search.buttress_loop",
    "dynsim.causes": "dynsim.comparison.causes",
    "dynsim.compare": "dynsim.comparison.compare",
    "dynsim.cracks": "dynsim.judge.cracks",
    "dynsim.criteria": "dynsim.judge.criteria",
    "dynsim.film": "dynsim.view.film",
    "dynsim.first_motion": "dynsim.comparison.first_motion",
    "dynsim.optimise": "dynsim.design_search.optimise",
    "dynsim.pool": "dynsim.parallel.pool",
    "dynsim.stiffness": "dynsim.bonds.stiffness",
}
GOES = "and goes with 0.3"


def moved(module: str, name: str) -> Any:
    """Return what an old name of a module stands for, with a DeprecationWarning at the line that asked for it.

    Parameters
    ----------
    module, name : str
        Where the name was in version 0.1, and the name.

    Returns
    -------
    object
        What has the new name.

    Raises
    ------
    AttributeError
        If there is no such old name.
    """
    from importlib import import_module

    old = f"{module}.{name}"
    places = [NAMES[old]] if old in NAMES else [f"{home}.{name}" for home in MODULES.get(module, "").split()]
    for new in places if not name.startswith("_") else ():
        home, _, last = new.rpartition(".")
        found = getattr(import_module(home), last, None)
        if found is not None:
            package = import_module(home.partition(".")[0])
            if last in package.__all__ and getattr(package, last) is found:
                new = f"{package.__name__}.{last}"
            _warn(f"{old} is now {new}, {GOES}", 4)
            return found
    raise AttributeError(f"module {module!r} has no attribute {name!r}")


def _warn(text: str, level: int) -> None:
    import warnings

    warnings.warn(text, DeprecationWarning, stacklevel=level)


def old_names(room: str) -> Callable[[str], Any]:
    """Return the function `__getattr__` of a room that had the old names itself (PEP 562).

    Parameters
    ----------
    room : str
        The name of the room.

    Returns
    -------
    callable
        It returns what an old name stands for now, and raises AttributeError for anything else.
    """

    def get(name: str) -> Any:
        return moved(room, name)

    return get


class _OldModule(type(sys)):  # the class of modules, without an import of types
    def __getattr__(self, name: str) -> Any:
        return moved(self.__name__, name)


def keep_old_modules(package: str) -> None:
    """Let the old modules of a package be imported.

    A module that `sys.modules` has is not bound in its package by an import, so that `blockstat.search` is still the
    function after `from blockstat.search import Margin`.

    Parameters
    ----------
    package : str
        "blockstat" or "dynsim".
    """
    for name in MODULES:
        if name.startswith(f"{package}."):
            sys.modules.setdefault(name, _OldModule(name, "A module of version 0.1."))


def renamed_options(**options: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Let a function take options by their old names, too, with a DeprecationWarning.

    Parameters
    ----------
    **options : str
        The new name of each option, by the old one.

    Returns
    -------
    callable
        A decorator.
    """
    from functools import wraps

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        @wraps(function)
        def call(*args: P.args, **given: P.kwargs) -> T:
            for old in given.keys() & options.keys():
                new = options[old]
                if new in given:
                    raise TypeError(f"{function.__name__}() got both {new!r} and {old!r}, its old name")
                _warn(f"the option {old!r} of {function.__name__} is now {new!r}, {GOES}", 3)
                given[new] = given.pop(old)
            return function(*args, **given)

        return call

    return decorate
