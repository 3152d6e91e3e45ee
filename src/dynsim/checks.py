"""Checks of the names of engines."""

from __future__ import annotations

from blockstat.errors import InputError

ENGINES = ("bullet", "lmgc90")


def check_engine(name: str) -> None:
    """Check that there is an engine of a name.

    Parameters
    ----------
    name : str
        "bullet" or "lmgc90".

    Raises
    ------
    InputError
        For another name.
    """
    if name not in ENGINES:
        raise InputError(f"no engine {name!r}; engines are: {', '.join(ENGINES)}")
