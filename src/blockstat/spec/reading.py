"""Plain data turned into what they say, with errors that name the key."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from typing import Any, TypeVar

import msgspec
import numpy as np

from blockstat.errors import InputError, check_number
from blockstat.spec.ranges import is_presence
from blockstat.system.faults import faults

T = TypeVar("T", bound=msgspec.Struct)


def read_as(kind: type[T], data: Any, path: str = "") -> T:
    """Plain data as a struct.

    Parameters
    ----------
    kind : type
        The struct.
    data : object
        Tables, lists, numbers and texts.
    path : str
        Where they are in the scene.

    Returns
    -------
    msgspec.Struct
        Of the kind.

    Raises
    ------
    InputError
        With the path of each bad or unknown key and the keys there are.
    """
    try:
        return msgspec.convert(data, kind)
    except msgspec.ValidationError:
        raise InputError(*map(_of_presence, faults(kind, data, path))) from None


def _of_presence(text: str) -> str:
    """A fault, in words of its own where it is that of a presence: "search" is no part of its type."""
    place = text.partition(": ")[0]
    there = is_presence(re.sub(r"\[(\d+)\]", r".\1", place))
    return f'{place}: it must be true, false or "search"' if there else text


def joined(path: str, key: str | int) -> str:
    """A dotted path and one more key.

    Parameters
    ----------
    path : str
        "" for the scene itself.
    key : str or int
        Of a table or a list; "" for none.

    Returns
    -------
    str
        Such as "elements.ring.at.2".
    """
    return f"{path}.{key}" if path and key != "" else path or str(key)


def entries(node: Any) -> Iterator[tuple[str | int, Any]]:
    """Keys and values of a table, numbers and items of a list, nothing of all else.

    Parameters
    ----------
    node : object
        Plain data.

    Yields
    ------
    tuple
        Key and value.
    """
    if isinstance(node, dict):
        yield from node.items()
    elif isinstance(node, (list, tuple)):
        yield from enumerate(node)


def check_finite(node: Any, path: str = "") -> None:
    """Check that all numbers are finite.

    Parameters
    ----------
    node : object
        Plain data.
    path : str
        Where they are in the scene.

    Raises
    ------
    InputError
        With the path of each number that is not.
    """
    if found := list(_not_finite(node, path)):
        raise InputError(*found)


def number_at(path: str, value: Any) -> float:
    """The number that a parameter is moved to.

    Parameters
    ----------
    path : str
        Of the parameter.
    value : object
        What was given: a number, of numpy too, or true or false of a presence.

    Returns
    -------
    float
        It is finite.

    Raises
    ------
    InputError
        With the path, for anything else.

    Examples
    --------
    >>> number_at("wall.height", "high")
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: wall.height is 'high'; it must be a finite number
    """
    check_finite(value, path)
    check_number(path, int(value) if isinstance(value, (bool, np.bool_)) else value)
    return float(value)


def _not_finite(node: Any, path: str) -> Iterator[str]:
    if isinstance(node, (int, float)) and not abs(node) <= sys.float_info.max:
        given = f"a whole number beyond {sys.float_info.max:.2g}" if isinstance(node, int) else node
        yield f"{path}: {given} is not a finite number"
    for key, child in entries(node):
        yield from _not_finite(child, joined(path, key))


def check_name(name: str) -> None:
    """Check that a name can be a directory's.

    Parameters
    ----------
    name : str
        Of a scene.

    Raises
    ------
    ValueError
        For an empty one, or one with a slash.
    """
    if not name.strip() or set(name) & set("/\\") or name in (".", ".."):
        raise ValueError(f"name {name!r} must not be empty or hold a slash; it names the report's directory")


def at_path(data: Any, path: str) -> tuple[Any, Any]:
    """The table or list that holds what a dotted path leads to, and the last key.

    Parameters
    ----------
    data : object
        Plain data.
    path : str
        Such as "elements.ring.at.2". A key may have dots: the longest that the rest of the path begins with is meant.

    Returns
    -------
    tuple
        Table or list, and key or index.
    """
    key = path.partition(".")[0]
    if isinstance(data, dict):
        key = max((name for name in data if f"{path}.".startswith(f"{name}.")), key=len, default=key)
    rest = path[len(key) + 1 :]
    own: Any = int(key) if isinstance(data, list) else key
    return at_path(data[own], rest) if rest else (data, own)
