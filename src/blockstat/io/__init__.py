"""Files in and out: the format is picked by the suffix."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

MESHES = (".obj", ".glb", ".stl", ".ply")
READABLE = (".json", ".toml", *MESHES)
WRITABLE = (".json", *MESHES)


def read(path: str | Path, *, supports: Iterable[int | str] | None = None) -> Assembly:
    """Read an assembly: native JSON, a scene in TOML (built on the spot), or a mesh with one solid a block.

    supports : replaces the supports named in the file; a mesh without them needs this.
    Raises InputError naming the file and the block or key at fault.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: is a directory")
    suffix = path.suffix.lower()
    if suffix not in READABLE:
        raise InputError(f'{path}: cannot read "{suffix}"; formats are: {", ".join(READABLE)}')
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        if suffix == ".json":
            from blockstat.io.native import read_json

            return read_json(path, supports=supports)
        if suffix == ".toml":
            from blockstat.io.scene import load_scene
            from blockstat.model import build

            if supports is not None:
                raise InputError("a scene stands on its ground; supports cannot be chosen for it")
            return build(load_scene(path))
        from blockstat.io.mesh import read_mesh

        return read_mesh(path, supports=supports)
    except InputError as error:
        message = str(error)
        raise InputError(message if message.startswith(str(path)) else f"{path}: {message}") from None


def write(assembly: Assembly, path: str | Path) -> Path:
    """Write an assembly as native JSON (exact) or as a mesh with one named object a block; returns the path."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in WRITABLE:
        raise InputError(f'{path}: cannot write "{suffix}"; formats are: {", ".join(WRITABLE)}')
    if not path.parent.is_dir():
        raise InputError(f"{path}: no such directory: {path.parent}")
    if suffix == ".json":
        from blockstat.io.native import write_json

        write_json(assembly, path)
    else:
        from blockstat.io.mesh import write_mesh

        write_mesh(assembly, path)
    return path
