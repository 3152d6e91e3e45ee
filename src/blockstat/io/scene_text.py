"""A scene as TOML (version 1.0): what `load_scene` reads back to the same scene."""

from __future__ import annotations

import json
import re
from typing import Any

import msgspec

PLAIN = re.compile(r"[A-Za-z0-9_-]+")


def scene_text(scene: Any) -> str:
    """Return the text of a scene file.

    Every key is written, those with their defaults too; comments are lost.

    Parameters
    ----------
    scene : Building or Composition
        The scene.

    Returns
    -------
    str
        TOML 1.0, which `load_scene` reads back to the same scene; a file of it is in UTF-8.

    Examples
    --------
    >>> from blockstat import scene_from, scene_text
    >>> print(scene_text(scene_from({"name": "hut", "length": 3.0, "span": 2.0})).splitlines()[0])
    name = "hut"
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
    return name if PLAIN.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    """A text in quotes: TOML knows JSON's escapes of single characters, but no pairs of surrogates."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items() if v is not None) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    return repr(value)
