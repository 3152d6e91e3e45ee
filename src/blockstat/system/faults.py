"""All that is wrong with plain data, where msgspec tells the first fault alone."""

from __future__ import annotations

import re
import types
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import msgspec

ROWS = (list, tuple, Sequence)  #: types of lists
#: What msgspec calls a type, and what those who write files do. A number may always be whole; `null` is no key at all.
WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a text",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
}
BOUNDS = {">": "above", ">=": "of at least", "<": "below", "<=": "of at most"}


def faults(kind: Any, data: Any, path: str = "") -> list[str]:
    """Say what keeps plain data from being of a type, each part of them by itself.

    Parameters
    ----------
    kind : type
        A struct, or any other type that msgspec knows.
    data : object
        Tables, lists, numbers and texts.
    path : str, optional
        Where the data are.

    Returns
    -------
    list of str
        A sentence for each fault, with its place, as "wall.height: it must be a number, not a text".

    Examples
    --------
    >>> class Wall(msgspec.Struct, forbid_unknown_fields=True):
    ...     height: float
    ...     bond: Literal["running", "stack"] = "running"
    >>> for text in faults(Wall, {"hieght": 2, "bond": "flemish"}, "wall"):
    ...     print(text)
    wall.hieght: unknown key; keys here are: height, bond
    wall.bond: Invalid enum value 'flemish'; it must be one of: running, stack
    """
    try:
        msgspec.convert(data, kind)
    except msgspec.ValidationError as error:
        own = [*_of_keys(kind, data, path)]
        inner = [text for part, value, place in _parts(kind, data, path) for text in faults(part, value, place)]
        sentence = _sentence(error, kind, path)
        return [*own, *inner] or [sentence + (_as_number(data) if "number, not a text" in sentence else "")]
    return []


def unknown_keys(struct: type[msgspec.Struct], data: dict[str, Any], path: str = "") -> list[str]:
    """Say which keys of a table a struct does not have.

    Parameters
    ----------
    struct : type
        The struct.
    data : dict
        The table.
    path : str, optional
        Where the table is.

    Returns
    -------
    list of str
        A sentence for each unknown key, with the keys there are.
    """
    known = struct.__struct_fields__
    return [f"{_under(path, key)}: unknown key; keys here are: {', '.join(known)}" for key in data if key not in known]


def _sentence(error: msgspec.ValidationError, kind: Any, path: str) -> str:
    message, _, where = str(error).partition(" - at `$")
    message = re.sub(r"^Object missing required field `(.*)`$", r"\1 is missing", message)
    message = re.sub(r"^Expected `([^`]*)`(.*)$", _in_words, message)
    inner = where.rstrip("`").lstrip(".")
    if message.startswith("Invalid enum value") and (choices := _choices(kind)):
        message += f"; it must be one of: {', '.join(map(str, choices))}"
    whole = f"{path}.{inner}" if path and inner and not inner.startswith("[") else path + inner
    return f"{whole}: {message}" if whole else message


def _in_words(expected: re.Match[str]) -> str:
    """What msgspec expected and got, in the words of `WORDS`."""
    kinds = expected[1].split(" | ")
    words = [word for kind, word in WORDS.items() if kind in kinds and not (kind == "int" and "float" in kinds)]
    given = WORDS | {"float": "one with a decimal point"} if "int" in kinds else WORDS
    rest = re.sub(r", got `?(\w+)`?$", lambda got: f", not {given.get(got[1], got[1])}", expected[2])
    rest = re.sub(r"^ ([<>]=?) (\S+)$", lambda bound: f" {BOUNDS[bound[1]]} {float(bound[2]):g}", rest)
    return f"it must be {' or '.join(words) or expected[1]}{rest}"


def _as_number(data: Any) -> str:
    """What to write in place of a text that is a number, perhaps with a unit."""
    found = re.fullmatch(r"([+-]?\d+(?:[.,]\d+)?)\s*([^\W\d]\S*)?", data.strip()) if isinstance(data, str) else None
    if found is None:
        return ""
    if found[2]:
        return "; write it without quotes and without a unit: lengths are in metres"
    point = ", with a decimal point" if "," in found[1] else ""
    return f"; write {found[1].replace(',', '.')} without quotes{point}"


def _of_keys(kind: Any, data: Any, path: str) -> Iterator[str]:
    """What is wrong with the keys of a table themselves."""
    struct = _alternative(kind, _is_struct)
    if struct is not None and isinstance(data, dict):
        fields = {field.name: field for field in msgspec.structs.fields(struct)}
        unknown = unknown_keys(struct, data, path) if struct.__struct_config__.forbid_unknown_fields else []
        yield from unknown
        # A key that is missing is often the one that is misspelt.
        if not unknown and (lacking := [name for name, field in fields.items() if field.required and name not in data]):
            verb = "is" if len(lacking) == 1 else "are"
            told = f"{', '.join(lacking)} {verb} missing; keys here are: {', '.join(fields)}"
            yield f"{path}: {told}" if path else told
    table = _alternative(kind, _is_table)
    if table is not None and isinstance(data, dict):
        for key in data:
            yield from faults(get_args(table)[0], key, _under(path, key))


def _parts(kind: Any, data: Any, path: str) -> Iterator[tuple[Any, Any, str]]:
    """The parts of a table or a list: type, value and place."""
    if isinstance(data, dict):
        if (struct := _alternative(kind, _is_struct)) is not None:
            for field in msgspec.structs.fields(struct):
                if field.name in data:
                    yield field.type, data[field.name], _under(path, field.name)
        elif (table := _alternative(kind, _is_table)) is not None:
            for key, value in data.items():
                yield get_args(table)[1], value, _under(path, key)
    elif isinstance(data, (list, tuple)) and (row := _alternative(kind, _is_row)) is not None:
        items = get_args(row)
        same = get_origin(row) is not tuple or items[-1] is Ellipsis
        if same or len(items) == len(data):
            for number, value in enumerate(data):
                yield items[0] if same else items[number], value, f"{path}[{number}]"


def _alternative(kind: Any, fits: Any) -> Any:
    """The alternative of a type that fits, None without any."""
    if get_origin(kind) is Annotated:
        return _alternative(get_args(kind)[0], fits)
    if get_origin(kind) in (Union, types.UnionType):
        return next((found for part in get_args(kind) if (found := _alternative(part, fits)) is not None), None)
    return kind if fits(kind) else None


def _is_struct(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)


def _is_table(kind: Any) -> bool:
    return get_origin(kind) is dict


def _is_row(kind: Any) -> bool:
    return get_origin(kind) in ROWS


def _choices(kind: Any) -> tuple[Any, ...]:
    found = _alternative(kind, lambda part: get_origin(part) is Literal)
    return get_args(found) if found is not None else ()


def _under(path: str, key: Any) -> str:
    return f"{path}.{key}" if path else str(key)
