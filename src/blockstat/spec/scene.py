"""Scenes of either form: their parameters, and how they are moved."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from typing import Any, TypeAlias

import msgspec
import numpy as np

from blockstat.errors import InputError, gathered, known_options
from blockstat.model.expression import is_expression
from blockstat.spec.chapel import Building
from blockstat.spec.composition import Composition, composition_from, load_tables, ties_of
from blockstat.spec.material import stages_from, uncertain_of
from blockstat.spec.ranges import SEARCHED, Range, is_presence, is_range
from blockstat.spec.reading import at_path, check_finite, entries, joined, number_at, read_as

#: The short form for a rectangular building, or the general one.
Scene: TypeAlias = Building | Composition


def parameters(scene: Scene) -> dict[str, Range]:
    """The parameters that may move, by dotted path in the scene: "wall.thickness", "elements.rib.present".

    Something whose presence is to be searched has a range of 1 (there) and 0 (not there).

    Parameters
    ----------
    scene : Building or Composition
        As it was written.

    Returns
    -------
    dict of Range
        By path, in the order of the scene.

    Examples
    --------
    >>> from blockstat import parameters, scene_from
    >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
    >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.8, "step": 0.2}}
    >>> list(parameters(scene_from(hut)))
    ['wall.thickness']
    """
    found: dict[str, Range] = {}

    def visit(node: Any, path: str) -> None:
        if is_range(node):
            found[path] = read_as(Range, node, path)
            return
        for key, child in entries(node):
            visit(child, joined(path, key))

    data = _plain(scene)
    visit(data.get("parameters", {}), "parameters")
    for key, child in data.items():
        if key != "parameters":
            visit(child, key)
    return found


@known_options
def with_values(scene: Scene, values: Mapping[str, float], *, beyond: bool = False) -> Scene:
    """The scene with some of its ranges moved to other values.

    Parameters
    ----------
    scene : Building or Composition
        It is not changed.
    values : mapping of str to float
        By path, as `parameters` has them; the others stay as they are.
    beyond : bool, optional
        Values may lie outside their bounds, which then take them in.

    Returns
    -------
    Building or Composition
        With the same ranges, but for those that take in a value.

    Raises
    ------
    InputError
        For a path that is no range, or a value that is no number or outside its bounds.

    Examples
    --------
    >>> from blockstat import scene_from, with_values
    >>> hut = {"name": "hut", "length": 3.0, "span": 2.0}
    >>> hut["wall"] = {"thickness": {"value": 0.6, "min": 0.2, "max": 0.8, "step": 0.2}}
    >>> with_values(scene_from(hut), {"wall.thickness": 0.4}).wall.thickness.value
    0.4
    """
    ranges = parameters(scene)
    data = _plain(scene)
    for path, value in values.items():
        if path not in ranges:
            raise InputError(f'no parameter "{path}" to move; ranges are: {", ".join(ranges) or "none"}')
        table, key = at_path(data, path)
        table[key]["value"] = number = number_at(path, value)
        if beyond:
            table[key] |= {"min": min(number, ranges[path].min), "max": max(number, ranges[path].max)}
    check_finite(data)
    return _read(data)  # the ends of the ranges are where they were


def scene_from(data: Any) -> Scene:
    """A scene from plain dicts, or from structs in dicts; numbers and arrays of numpy will do.

    Parameters
    ----------
    data : object
        The tables of a scene file.

    Returns
    -------
    Building or Composition
        By the keys: a composition has elements.

    Raises
    ------
    InputError
        Naming the path of a bad or unknown key.

    Examples
    --------
    >>> from blockstat import scene_from
    >>> post = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}
    >>> type(scene_from({"name": "gate", "elements": {"post": post}})).__name__
    'Composition'
    >>> type(scene_from({"name": "hut", "length": 3.0, "span": 2.0})).__name__
    'Building'
    """
    data = _searched(msgspec.to_builtins(data, enc_hook=_from_numpy))
    if not isinstance(data, dict):
        raise InputError(f"a scene is a table of keys, not {data!r}")
    check_finite(data)
    scene = _read(data)
    gathered(partial(_check_ends, scene, path, found) for path, found in parameters(scene).items())
    return scene


def _check_ends(scene: Scene, path: str, found: Range) -> None:
    """The ends of a range must be values that the parameter could have by itself.

    What depends on other ranges, too, is a matter of each design: any that can be built is read back.
    """
    for end in {found.min, found.max, *found.steps()[1:2]}:
        plain = _plain(scene)
        table, key = at_path(plain, path)
        whole = int(end) if float(end).is_integer() else end
        table[key] = bool(whole) if is_presence(path) and whole in (0, 1) else whole
        try:
            _read(plain)
        except InputError as error:
            if own := [text for text in error.args if _ranges_behind(text, _plain(scene)) == {path}]:
                raise type(error)(*own) from None


def _ranges_behind(text: str, data: dict[str, Any]) -> set[str]:
    """Paths of the ranges that what an error tells of depends on; none where it tells of no key that is written."""
    place = re.sub(r"\[(\d+)\]", r".\1", text.partition(": ")[0])
    try:
        table, key = at_path(data, place)
        todo = [(place, table[key])]
    except (LookupError, TypeError, ValueError):
        return set()
    names, found = dict(data.get("parameters", {})), set[str]()
    while todo:
        path, node = todo.pop()
        if is_range(node):
            found.add(path)
        elif is_expression(node):
            told = names.keys() & set(re.findall(r"\w+", node))
            todo += [(f"parameters.{name}", names.pop(name)) for name in told]
        else:
            todo += [(joined(path, key), child) for key, child in entries(node)]
    return found


def _from_numpy(value: Any) -> Any:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise InputError(f"{value!r} is neither a number, a text, a list nor a table")


def _read(data: dict[str, Any]) -> Scene:
    if {"elements", "parameters"} & set(data):
        return composition_from(data)
    tables = {
        key: data[key] if isinstance(data.get(key), dict) else {} for key in ("loads", "cases", "ties", "uncertain")
    }
    stages = data.get("stages")
    building, *_ = gathered(
        (
            partial(read_as, Building, data),
            partial(load_tables, tables["loads"], tables["cases"]),
            partial(ties_of, tables["ties"]),
            partial(uncertain_of, tables["uncertain"]),
            partial(stages_from, stages if isinstance(stages, list) else ()),
        )
    )
    return building


def _plain(scene: Scene) -> dict[str, Any]:
    return _searched(msgspec.to_builtins(scene))


def _searched(node: Any, key: Any = None, above: Any = None) -> Any:
    """Plain data with a range in place of each presence to be searched."""
    if node == "search" and (key == "present" or above == "parameters"):
        return dict(SEARCHED)
    if isinstance(node, dict):
        return {name: _searched(child, name, key) for name, child in node.items()}
    return [_searched(child) for child in node] if isinstance(node, (list, tuple)) else node
