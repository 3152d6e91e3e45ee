"""Scene files in TOML (version 1.0)."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import msgspec
import tomllib

from blockstat.errors import InputError
from blockstat.spec import Scene, scene_from

BLOCKS = (".json", ".obj", ".glb", ".stl", ".ply")  #: suffixes of files that are no scenes
#: Keys that need no quotes.
PLAIN = re.compile(r"[A-Za-z0-9_-]+")


def load_scene(path: str | Path) -> Scene:
    """Read a scene file; a mesh file named in it is looked for beside it.

    Parameters
    ----------
    path : str or Path
        A .toml file.

    Returns
    -------
    Scene
        A `Building` or a `Composition`.

    Raises
    ------
    InputError
        With the line for bad TOML, and the key for a bad value.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if path.suffix.lower() in BLOCKS:
        raise InputError(f"{path}: a scene file (.toml) is needed; this holds blocks, which have no parameters")
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    data.setdefault("name", path.stem)
    elements = data.get("elements")
    for element in elements.values() if isinstance(elements, dict) else ():
        if isinstance(element, dict) and isinstance(element.get("file"), str):
            element["file"] = str(path.parent / element["file"])
    try:
        return scene_from(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def scene_text(scene: Any) -> str:
    """Return the text of a scene file: what `load_scene` reads back to the same scene.

    Parameters
    ----------
    scene : Scene
        The scene.

    Returns
    -------
    str
        TOML. Every key is written, those with their defaults too; comments are lost.
    """
    return _table(msgspec.to_builtins(scene), "")


def _table(data: dict[str, Any], path: str) -> str:
    """A table under its heading: its own values first, then the tables in it; what is None is left out."""
    own = [f"{_key(k)} = {_value(v)}\n" for k, v in data.items() if v is not None and not _nested(v)]
    text = "".join(own)
    for key, value in data.items():
        inner = f"{path}.{_key(key)}" if path else _key(key)
        if isinstance(value, dict) and _nested(value):
            text += f"\n[{inner}]\n{_table(value, inner)}"
    return text


def _nested(value: Any) -> bool:
    """Whether a value gets a heading; ranges {value, min, max, step} and empty tables stand on one line."""
    return isinstance(value, dict) and bool(value) and "min" not in value


def _key(name: str) -> str:
    return name if PLAIN.fullmatch(name) else json.dumps(name)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items() if v is not None) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    return repr(value)
