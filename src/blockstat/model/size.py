"""How many blocks an element asks for, told from its keys before anything is built."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

from blockstat.errors import InputError

MOST_BLOCKS = 300_000  #: built unless more are allowed; some 2 GB of memory
ALLOWED = "BLOCKSTAT_MOST_BLOCKS"  #: variable of the environment that allows more, set by `--most-blocks`
#: Kinds whose blocks are the cells of a grid of two numbers.
GRIDS = ("dome", "drum", "sail", "fan", "freeform")
HUGE = 1e300


def most_blocks() -> float:
    """Return the number of blocks that a scene may have.

    Returns
    -------
    float
        `MOST_BLOCKS`, or what the environment says.

    Raises
    ------
    InputError
        When the environment says no positive number.
    """
    text = os.environ.get(ALLOWED, str(MOST_BLOCKS))
    try:
        most = float(text)
    except ValueError:
        most = math.nan
    if not most > 0:
        raise InputError(f'{ALLOWED} is "{text}"; it must be a positive number of blocks')
    return most


def check_block_count(label: str, number: float) -> None:
    """Refuse more blocks than may be built.

    Parameters
    ----------
    label : str
        What asks for them, as the scene calls it.
    number : float
        About how many.

    Raises
    ------
    InputError
        With the number asked for, the cap, and how to raise it.

    Examples
    --------
    >>> check_block_count("elements.post", 1e9)
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: elements.post: about 1,000,000,000 blocks are asked for; at most 300,000 are built \
(`--most-blocks N` before the name of the command allows more)
    """
    if number > (most := most_blocks()):
        asked = f"{number:,.0f}" if number < 1e15 else f"{number:.3g}"
        raise InputError(
            f"{label}: about {asked} blocks are asked for; at most {most:,.0f} are built "
            "(`--most-blocks N` before the name of the command allows more)"
        )


def blocks_asked(kind: str, keys: Mapping[str, Any]) -> float:
    """Return about how many blocks an element makes; of what has no such number, such as sides, the corners.

    Parameters
    ----------
    kind : str
        Of the element.
    keys : mapping
        Its keys, within the bounds of their types.

    Returns
    -------
    float
        Openings are not taken off. Files count as one.

    Examples
    --------
    >>> blocks_asked("dome", {"rings": 10, "voussoirs": 20})
    200.0
    """
    counts = [min(value, 10**15) for value in keys.values() if isinstance(value, int) and not isinstance(value, bool)]
    largest = float(max([1, *counts]))
    if kind in GRIDS:
        return float(math.prod(counts))
    if kind in ("arch", "rib", "barrel") and keys.get("voussoir"):
        largest = max(largest, _ratio(keys["span"], keys["voussoir"]))
    if kind == "barrel":
        return largest * max(1.0, _ratio(keys["length"], keys["brick"]))
    if kind in ("groin", "pavilion"):
        return largest * max(1.0, _ratio(sum(keys["spans"]), keys["brick"]))
    if kind == "arc_wall":
        turn = math.radians(min(abs(keys["end"] - keys["start"]), 360.0))
        return max(largest, _bricks(keys["radius"] * turn + sum(keys["tails"]), keys["height"], keys) * largest)
    if kind == "buttress":
        return max(largest, _bricks(keys["width"], keys["height"], keys))
    if kind == "walls":
        runs = keys["runs"].values()
        own = sum(_bricks(_length(run.path), run.height, keys) * min(run.leaves, 10**15) for run in runs)
        buttresses = keys.get("buttresses", ())
        return own + sum(min(b.count, 10**15) * float(min(b.courses or 1, 10**15)) for b in buttresses)
    return largest


def _length(path: Any) -> float:
    return sum(math.dist(a, b) for a, b in zip(path, path[1:], strict=False))


def _bricks(length: float, height: float, keys: Mapping[str, Any]) -> float:
    """Bricks of a face."""
    brick = keys["brick"]
    return max(1.0, _ratio(length, brick[0])) * max(1.0, _ratio(height, brick[1]))


def _ratio(whole: float, part: float) -> float:
    """A quotient that does not overflow."""
    return min(whole / part if part * HUGE > whole else HUGE, 1e100)
