"""What a file says, before anything is checked: readers make it, `read` and `repair` turn it into an assembly."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from blockstat.assembly import Assembly, Block
from blockstat.errors import InputError

#: Metres in one unit of length.
UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}


@dataclass(frozen=True)
class Parts:
    """Blocks as a file gives them, perhaps open or inverted, and what else it says."""

    blocks: Sequence[Block]
    supports: Sequence[int | str]
    options: dict[str, Any] = field(default_factory=dict)  #: keyword arguments of `Assembly.from_blocks`

    def assembled(self) -> Assembly:
        """Return the assembly.

        Returns
        -------
        Assembly

        Raises
        ------
        InputError
            For blocks that are no closed solids (see `Assembly.from_blocks`).
        """
        return Assembly.from_blocks(self.blocks, supports=self.supports, **self.options)

    def scaled(self, metres: float) -> Parts:
        """Return the same with coordinates multiplied.

        Densities and strengths are in SI units in every file.

        Parameters
        ----------
        metres : float
            Metres in one unit of the coordinates.

        Returns
        -------
        Parts
            In metres.
        """
        if metres == 1.0:
            return self
        return replace(self, blocks=[replace(b, vertices=_times(b.vertices, metres)) for b in self.blocks])


def metres_in(units: str | None) -> float:
    """Return the metres in a unit of length.

    Parameters
    ----------
    units : str or None
        One of `UNITS`; None for metres.

    Returns
    -------
    float

    Raises
    ------
    InputError
        For a unit that is not known.

    Examples
    --------
    >>> metres_in("cm")
    0.01
    """
    if units is None:
        return 1.0
    if units not in UNITS:
        raise InputError(f"units are {units!r}; known are: {', '.join(UNITS)}")
    return UNITS[units]


def chosen_supports(
    marked: Sequence[int], given: Iterable[int | str] | None, names: Sequence[str], kind: str
) -> list[int | str]:
    """Return supports as they were given, or else those that the file marks.

    Parameters
    ----------
    marked : sequence of int
        Numbers of the blocks that the file marks.
    given : iterable of int or str, or None
        Names or numbers of blocks, or one of them.
    names : sequence of str
        Of all blocks, for the message.
    kind : str
        What the file is called in the message.

    Returns
    -------
    list of int or str

    Raises
    ------
    InputError
        Naming some blocks when there are no supports.
    """
    chosen: list[int | str] = [given] if isinstance(given, (int, str)) else list(marked if given is None else given)
    if not chosen:
        some = ", ".join(name or f"block{i}" for i, name in enumerate(names[:8]))
        some += f" and {len(names) - 8} more" if len(names) > 8 else ""
        raise InputError(f"{kind} does not say which blocks are supports; give their names or numbers (blocks: {some})")
    return chosen


def _times(vertices: Any, metres: float) -> Any:
    try:
        return np.asarray(vertices, dtype=float) * metres
    except (TypeError, ValueError):
        return vertices  # not numbers: refused, with the block's name, where the assembly is made
