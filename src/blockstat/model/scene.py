"""An assembly from any file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.io.files import blaming, read_parts
from blockstat.io.scene import load_scene
from blockstat.model.compose import build


def read(path: str | Path, *, supports: Iterable[int | str] | None = None, units: str | None = None) -> Assembly:
    """Read an assembly: native or COMPAS JSON, a scene in TOML (built on the spot), a mesh with one solid a block,
    or a directory of PLY or STL files with one block a file (named like it, groups are directories).

    supports : replaces the supports named in the file; a mesh without them needs this.
    units : of the coordinates in the file ("mm", "cm", "in", ...); they are converted to metres.
    Raises InputError naming the file and the block or key at fault.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml" or path.is_dir():
        parts = read_parts(path, supports=supports, units=units)
        return blaming(path, parts.assembled)
    if supports is not None:
        raise InputError(f"{path}: a scene stands on its ground; supports cannot be chosen for it")
    if units not in (None, "m"):
        raise InputError(f"{path}: a scene is in metres; units cannot be chosen for it")
    scene = load_scene(path)
    return blaming(path, lambda: build(scene))
