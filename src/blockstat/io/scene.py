"""Scene files in TOML."""

from __future__ import annotations

from pathlib import Path

import tomllib

from blockstat.errors import InputError
from blockstat.spec import Scene, scene_from

BLOCKS = (".json", ".obj", ".glb", ".stl", ".ply")  #: suffixes of files that are no scenes


def load_scene(path: str | Path) -> Scene:
    """Read a scene; a mesh file named in it is looked for beside it.

    Raises InputError with the line for bad TOML and the key for a bad value.
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
