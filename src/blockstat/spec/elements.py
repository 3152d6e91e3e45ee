"""The kinds of element as tables of a scene file; their keys are the options of the builders in `blockstat.model`.

Each element is built about its own origin, then turned, moved and repeated as its keys of placing say.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from typing import Any, get_type_hints

import msgspec

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model import kinds
from blockstat.model.kinds import Kind
from blockstat.model.walling.run import EITHER, check_places
from blockstat.spec.element import Element
from blockstat.spec.ranges import is_range


def element(kind: str, **keys: Any) -> Element:
    """An element of a kind with some keys, as they are: they are not checked.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    **keys
        Those of the kind and those of placing.

    Returns
    -------
    Element
        An instance of `KINDS[kind]`.
    """
    return KINDS[kind](**keys)


def blocks_of(element: Element) -> list[Block]:
    """The blocks of an element about its own origin.

    Parameters
    ----------
    element : Element
        Of any kind.

    Returns
    -------
    list of Block
        As its builder gives them, not yet in place.

    Raises
    ------
    InputError
        For keys that do not fit together.
    """
    keys = {key: getattr(element, key) for key in element.__struct_fields__ if key not in Element.__struct_fields__}
    return kinds.KINDS[kind_of(element)].build(**keys)


def check_all_places(element: Element, table: Mapping[str, Any], path: str) -> None:
    """Check that openings and buttresses with places have no other number, nor one that a search may move.

    Parameters
    ----------
    element : Element
        Of any kind.
    table : mapping
        Its keys as they were written, with ranges and expressions.
    path : str
        Where they are in the scene.

    Raises
    ------
    InputError
        With the path of each number that is not that of the places.
    """
    wrong: list[str] = []
    for (place, own), (_, written) in zip(_in_places(element), _in_places(table), strict=True):
        if own.at is None:
            continue
        if is_range(written.get("number")):
            wrong.append(f"{path}{place}.number: a range moves it, and at says where {len(own.at)} are; {EITHER}")
            continue
        try:
            check_places(f"{path}{place}.number", own)
        except InputError as error:
            wrong += error.args
    if wrong:
        raise InputError(*wrong)


def _in_places(element: Any) -> Iterator[tuple[str, Any]]:
    """Openings and buttresses of an element, or of its table, and where they are in it."""

    def of(node: Any, key: str) -> Any:
        return (node.get(key) if isinstance(node, Mapping) else getattr(node, key, None)) or ()

    runs = of(element, "runs") or {}
    for place, holder in (("", element), *((f".runs.{name}", run) for name, run in runs.items())):
        for key in ("openings", "buttresses"):
            yield from ((f"{place}.{key}[{k}]", own) for k, own in enumerate(of(holder, key)))


def absent_parts(element: Element) -> list[str]:
    """Groups that an element would have if what is absent in it were present: runs, openings and buttresses.

    Parameters
    ----------
    element : Element
        Of any kind.

    Returns
    -------
    list of str
        Without the prefix of the element; each stands for all that is in it.
    """
    own: Any = element
    runs = getattr(own, "runs", {own.name: own} if hasattr(own, "openings") else {})
    absent = [name for name, run in runs.items() if not run.present]
    stones = {"lintel": "lintel"}  # of all other heads "arch"
    return [
        *(f"{part}.{name}" for name in absent for part in ("wall", "buttress")),
        *(
            f"wall.{name}.{stones.get(opening.head, 'arch')}"
            for name, run in runs.items()
            for opening in run.openings
            if not (opening.present and opening.count)
        ),
        *(f"buttress.{b.wall}" for b in getattr(own, "buttresses", ()) if not (b.present and b.count)),
    ]


def kind_of(element: Element | type[Element]) -> str:
    """The word that a scene file has for the kind of an element.

    Parameters
    ----------
    element : Element or type
        Of any kind.

    Returns
    -------
    str
        A key of `KINDS`.
    """
    return str(element.__struct_config__.tag)


def _options(kind: Kind) -> Iterator[tuple[str, Any, Any]]:
    """(name, type, default) of the options that are keys, `inspect.Parameter.empty` where there is no default."""
    found: dict[str, tuple[str, Any, Any]] = {}
    for taker in (kind.build, kind.more):
        if taker is None:
            continue
        hints = get_type_hints(taker, include_extras=True)
        for option in inspect.signature(taker).parameters.values():
            named = option.kind is option.KEYWORD_ONLY or (
                taker is kind.build and option.kind is not option.VAR_KEYWORD
            )
            if named and option.name not in kind.without:
                found.setdefault(option.name, (option.name, hints[option.name], option.default))
    yield from found.values()


def _table(tag: str, kind: Kind) -> type[Element]:
    """The keys of a kind as a struct."""
    empty = inspect.Parameter.empty
    fields: list[Any] = [
        (name, hint) if default is empty else (name, hint, default) for name, hint, default in _options(kind)
    ]
    summary = (inspect.getdoc(kind.build) or "").partition("\n\n")[0]
    made: Any = msgspec.defstruct(
        tag, fields, bases=(Element,), module=__name__, namespace={"__doc__": summary}, tag=tag, kw_only=True,
        frozen=True, forbid_unknown_fields=True,
    )  # fmt: skip
    return made


KINDS: dict[str, type[Element]] = {tag: _table(tag, kind) for tag, kind in kinds.KINDS.items()}
