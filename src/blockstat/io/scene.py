"""Scene files in TOML."""

from __future__ import annotations

from pathlib import Path

import tomllib

from blockstat.errors import InputError
from blockstat.spec import Building, building_from


def load_scene(path: str | Path) -> Building:
    """Read a scene. Raises InputError with the line for bad TOML and the key for a bad value."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    data.setdefault("name", path.stem)
    try:
        return building_from(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
