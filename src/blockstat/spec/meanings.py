"""What the keys of a scene file mean, from where each of them is declared: for the reference of the scene language."""

from __future__ import annotations

import inspect
import re
from typing import Any

import msgspec

from blockstat.model import kinds
from blockstat.spec.element import Element
from blockstat.spec.elements import KINDS, kind_of

_ENTRY = re.compile(r"^(\w+(?:, \w+)*) : .*\n((?:    .*\n?)+)", flags=re.MULTILINE)
_FIELD = re.compile(r"^    (\w+): .*?(?:  #: (.*))?$")


def meanings(table: type[msgspec.Struct]) -> dict[str, str]:
    """What each key of a table means.

    Parameters
    ----------
    table : type
        A struct of the scene language.

    Returns
    -------
    dict of str
        From the docstring of the builder of an element, or from the comments behind the fields.
    """
    if issubclass(table, Element) and table in KINDS.values():
        kind = kinds.KINDS[kind_of(table)]
        return meanings(Element) | (said(kind.more) if kind.more else {}) | said(kind.build)
    found: dict[str, str] = {}
    for base in reversed(table.__mro__):
        if issubclass(base, msgspec.Struct) and base is not msgspec.Struct:
            found |= _comments(base)
    return found


def said(taker: Any) -> dict[str, str]:
    """What the Parameters of a docstring say, or the comments of a struct.

    Parameters
    ----------
    taker : callable or type
        A function with a numpy docstring, or a struct.

    Returns
    -------
    dict of str
        By name.
    """
    if isinstance(taker, type):
        return meanings(taker)
    entries = _ENTRY.findall(inspect.getdoc(taker) or "")
    words = {
        name: re.sub(r"\s+", " ", text).strip().rstrip(".") for names, text in entries for name in names.split(", ")
    }
    return {name: text if text[1:2] == ":" else text[0].lower() + text[1:] for name, text in words.items()}


def _comments(table: type) -> dict[str, str]:
    """What the source says after `#:` about each field, behind it or on the line before."""
    found: dict[str, str] = {}
    before = ""
    for line in inspect.getsource(table).splitlines():
        if line.strip().startswith("#: "):
            before = line.strip()[3:]
        elif match := _FIELD.match(line):
            found[match[1]] = match[2] or before
            before = ""
    return found
