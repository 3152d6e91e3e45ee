"""Names that a package hands to users, imported from their modules when they are first asked for."""

from __future__ import annotations

from blockstat.system.old_names import NAMES, keep_old_modules, moved

TYPE_CHECKING = False  # as typing has it, which takes longer to import than this module
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any


def on_demand(package: str, homes: Mapping[str, str], scope: dict[str, Any]) -> Callable[[str], Any]:
    """Return the function `__getattr__` of a package (PEP 562), and let its old modules be imported.

    Parameters
    ----------
    package : str
        The package.
    homes : mapping of str to str
        The module of each name, relative to the package.
    scope : dict
        The globals of the package, which keep what was imported.

    Returns
    -------
    callable
        It returns one of the names, what a name of version 0.1 stands for, or a module of the package, and raises
        AttributeError for anything else.
    """
    keep_old_modules(package)

    def get(name: str) -> Any:
        from importlib import import_module

        if name in homes:
            scope[name] = getattr(import_module(f"{package}.{homes[name]}"), name)
            return scope[name]
        if f"{package}.{name}" in NAMES:
            return moved(package, name)
        if not name.startswith("_"):
            try:
                return import_module(f"{package}.{name}")
            except ModuleNotFoundError as error:
                if error.name != f"{package}.{name}":
                    raise
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return get
