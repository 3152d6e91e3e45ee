"""A directory of PLY or STL files, one block a file: the file is named like the block, its directory is the group.

The parts of a dotted group are directories in one another. Characters that file systems refuse are written as %XX.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.assembly import Block
from blockstat.errors import InputError, InputWarning, gathered, some
from blockstat.io.mesh import block_mesh, read_whole
from blockstat.io.names import distinct_names
from blockstat.io.parts import Parts, chosen_supports, spacings
from blockstat.system.writing import written_whole

if TYPE_CHECKING:
    import numpy as np

    from blockstat.assembly import Assembly

SOLIDS = (".ply", ".stl")
OBJECTS = (".obj", ".glb")  #: meshes of several blocks, which are read one by one
#: What some file system does not allow in a name, and % itself; on Windows, CON and the like are devices.
REFUSED = re.compile(r'[%/\\:*?"<>|\x00-\x1f]|^\.|[. ]$|(?i:^(?=(?:con|prn|aux|nul|com\d|lpt\d)(?:\.|$))\w)')
LONGEST = 255  #: bytes in the name of a file or a directory
EMPTY = "%"  #: stands for a part of a group that is empty


def folder_parts(path: Path, *, supports: Iterable[int | str] | None = None) -> Parts:
    """Read the files of a directory and of those below it, in the natural order of their names (2 before 10).

    Parameters
    ----------
    path : Path
        The directory.
    supports : iterable of int or str, optional
        Names or numbers of the blocks that cannot move; without them the directory is refused.

    Returns
    -------
    Parts
        One block a file, in the unit of the files.

    Raises
    ------
    InputError
        For a directory without such files, each file that holds no surface, or without supports.

    Warns
    -----
    InputWarning
        Where files share a name, or the directory holds .obj and .glb files, which are not read.
    """
    files = sorted((p for p in path.rglob("*") if p.suffix.lower() in SOLIDS and p.is_file()), key=_natural)
    if not files:
        raise InputError(f"the directory holds no {' or '.join(SOLIDS)} files")
    if others := sorted((p for p in path.rglob("*") if p.suffix.lower() in OBJECTS and p.is_file()), key=_natural):
        text = f"{path}: of a directory {' and '.join(SOLIDS)} are read, and not "
        text += some([p.relative_to(path).as_posix() for p in others])
        warnings.warn(InputWarning(text), stacklevel=3)
    groups = [".".join(map(_plain, file.relative_to(path).parts[:-1])) for file in files]
    names = [_plain(file.stem) for file in files]
    chosen = chosen_supports([], supports, names, "a mesh")
    labels = distinct_names(names, chosen)
    surfaces = gathered(partial(_surface, path, file) for file in files)
    blocks = [
        Block(vertices, faces, name, group)
        for (vertices, faces), name, group in zip(surfaces, labels, groups, strict=True)
    ]
    apart = [spacings(file, [vertices])[0] for file, (vertices, _) in zip(files, surfaces, strict=True)]
    return Parts(blocks, chosen, {"name": path.name}, spacing=apart)


def _surface(path: Path, file: Path) -> tuple[np.ndarray, list[list[int]]]:
    try:
        return read_whole(file)
    except InputError as error:
        raise error.under(file.relative_to(path).as_posix()) from None


def write_folder(assembly: Assembly, path: Path, suffix: str) -> None:
    """Write one file a block into a directory, which is made if need be.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    path : Path
        The directory.
    suffix : {".ply", ".stl"}
        Format of the files.

    Raises
    ------
    InputError
        For a directory that holds such files already, or a block whose name or group is too long for a file system;
        nothing is written then.
    """
    if path.is_dir() and any(p.suffix.lower() in SOLIDS for p in path.rglob("*")):
        raise InputError(f"{path}: already holds {' or '.join(SOLIDS)} files, which would be read as blocks too")
    files = [
        path.joinpath(*(map(_quoted, group.split(".")) if group else ()), f"{_quoted(name)}{suffix}")
        for name, group in zip(assembly.names, assembly.groups, strict=True)
    ]
    gathered(partial(_check_length, path, *own) for own in zip(files, assembly.names, strict=True))
    for block, file in enumerate(files):
        file.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(file) as place:
            block_mesh(assembly, block).export(place)


def _check_length(path: Path, file: Path, name: str) -> None:
    """Raise InputError for a block whose file or directories have names that no file system takes."""
    longest = max(len(os.fsencode(part)) for part in file.relative_to(path).parts)
    if longest > LONGEST:
        shown = name if len(name) < 40 else f"{name[:30]}..."
        raise InputError(
            f'{path}: block "{shown}" would need a name of {longest} bytes for its file or directory, and file systems '
            f"take {LONGEST}; .obj, .glb and .json take any name"
        )


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.as_posix())]


def _quoted(name: str) -> str:
    return REFUSED.sub(lambda found: f"%{ord(found[0]):02X}", name) or EMPTY


def _plain(text: str) -> str:
    return "" if text == EMPTY else re.sub("%([0-9A-F]{2})", lambda found: chr(int(found[1], 16)), text)
