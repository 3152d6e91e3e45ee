"""The option that asks for the worst case of imperfections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.options import once
from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.imperfection.imperfections import Imperfections

FORM = "edge=LENGTH or edge=SHARE%, friction=DIVISOR, density.GROUP=LEAST,GREATEST or loads.GROUP=LEAST,GREATEST"

Imperfect = Annotated[
    list[str] | None,
    typer.Option(
        "--imperfection",
        metavar="KEY=VALUE",
        help="Ask for the worst case: 'edge=3 mm' that joints lose at each edge (or 'edge=5 %' of their width), "
        "friction=1.2 that divides friction, density.wall=1800,2200 [kg/m3], loads.vault=0,1.5 as factors. "
        "May be given several times.",
    ),
]


def imperfections_of(given: list[str] | None) -> Imperfections | None:
    """Return what the options allow for.

    Parameters
    ----------
    given : list of str or None
        Values of `--imperfection`.

    Returns
    -------
    Imperfections or None
        None where the option is not given.

    Raises
    ------
    InputError
        For a key or a value that there is not.

    Examples
    --------
    >>> imperfections_of(["edge=3 mm", "density.wall=1800,2200"]).density
    {'wall': (1800.0, 2200.0)}
    """
    if not given:
        return None
    from blockstat.imperfection.imperfections import Imperfections

    found: dict[str, Any] = {}
    seen = set[str]()
    for text in given:
        key, equals, value = (part.strip() for part in text.partition("="))
        kind, _, group = key.partition(".")
        once(seen, key, "--imperfection")
        seen.add(key)
        try:
            if equals and key == "edge":
                found["edge"] = value
            elif equals and key == "friction":
                found["friction"] = float(value)
            elif equals and kind in ("density", "loads") and group:
                low, high = value.split(",")
                found.setdefault(kind, {})[group] = (float(low), float(high))
            else:
                raise ValueError
        except ValueError:
            raise InputError(f'--imperfection is "{text}"; it must read {FORM}') from None
    return Imperfections(**found)
