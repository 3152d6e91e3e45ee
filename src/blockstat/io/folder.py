"""A directory of PLY, STL or OBJ files, one block a file: the file is named like the block, its directory is the group.

The parts of a dotted group are directories in one another. Characters that file systems refuse are written as %XX.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from blockstat.assembly import Block
from blockstat.errors import InputError, InputWarning, gathered, some
from blockstat.io.mesh import block_mesh, read_whole
from blockstat.io.names import distinct_names
from blockstat.io.obj import Solid, read_obj
from blockstat.io.parts import Parts, chosen_supports, is_marked, spacings
from blockstat.system.writing import written_whole

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

SOLIDS = (".ply", ".stl", ".obj")
OBJECTS = (".glb",)  #: scenes of objects that are placed and turned, which are read one by one
#: What some file system does not allow in a name, and % itself; on Windows, CON and the like are devices.
REFUSED = re.compile(r'[%/\\:*?"<>|\x00-\x1f]|^\.|[. ]$|(?i:^(?=(?:con|prn|aux|nul|com\d|lpt\d)(?:\.|$))\w)')
LONGEST = 255  #: bytes in the name of a file or a directory
EMPTY = "%"  #: stands for a part of a group that is empty


def folder_files(path: Path) -> list[Path]:
    """Return the files of a directory that are read, and of those below it, in the natural order of their names.

    Parameters
    ----------
    path : Path
        The directory.

    Returns
    -------
    list of Path
    """
    return sorted((p for p in path.rglob("*") if p.suffix.lower() in SOLIDS and p.is_file()), key=_natural)


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
        One block a file, and one an object of an OBJ of several, named "file.object"; in the unit of the files.

    Raises
    ------
    InputError
        For a directory without such files, a stone that it holds in several formats, each file that holds no surface,
        files that differ in what they note of all blocks, or without supports.

    Warns
    -----
    InputWarning
        Where blocks share a name, or the directory holds .glb files, which are not read.
    """
    files = folder_files(path)
    if not files:
        raise InputError(f"the directory holds no {_listed('or')} files")
    _check_formats(path, files)
    if others := sorted((p for p in path.rglob("*") if p.suffix.lower() in OBJECTS and p.is_file()), key=_natural):
        text = f"{path}: of a directory {_listed('and')} are read, and not "
        text += some([p.relative_to(path).as_posix() for p in others])
        warnings.warn(InputWarning(text), stacklevel=3)
    found = gathered(partial(_solids, path, file) for file in files)
    solids = [solid for own, _ in found for solid in own]
    names = [solid.name for solid in solids]
    marks = gathered(partial(is_marked, own.name, "support", own.extras.get("support")) for own in solids)
    chosen = chosen_supports([i for i, mark in enumerate(marks) if mark], supports, names, "a mesh")
    blocks = [
        Block(own.vertices, own.faces, name, str(own.extras["group"]), own.extras.get("density"))
        for own, name in zip(solids, distinct_names(names, chosen), strict=True)
    ]
    apart = [
        spacing
        for file, (own, _) in zip(files, found, strict=True)
        for spacing in spacings(file, [solid.vertices for solid in own])
    ]
    return Parts(blocks, chosen, {"name": path.name, **_said([said for _, said in found])}, spacing=apart)


def _check_formats(path: Path, files: list[Path]) -> None:
    """Raise InputError for files of one name in several formats, which would be the same stone several times."""
    formats: dict[Path, dict[str, Path]] = {}
    for file in files:
        formats.setdefault(file.with_suffix(""), {})[file.suffix.lower()] = file
    if twice := [list(own.values()) for own in formats.values() if len(own) > 1]:
        pairs = [" and ".join(file.relative_to(path).as_posix() for file in own) for own in twice]
        stones = "one stone" if len(twice) == 1 else "the same stones"
        raise InputError(
            f"{some(pairs, 4)} are {stones} in several formats, and each file is read as a block; "
            "keep the files of one format here, and move the others to another directory"
        )


def _listed(word: str) -> str:
    return f"{', '.join(SOLIDS[:-1])} {word} {SOLIDS[-1]}"


def _solids(path: Path, file: Path) -> tuple[list[Solid], dict[str, Any]]:
    """The solids of a file, named and grouped by where it is, and what it says of all of them.

    An OBJ of several objects holds several blocks; all else is one block, also where it is several surfaces.
    """
    place = file.relative_to(path)
    name, group = _plain(file.stem), ".".join(map(_plain, place.parts[:-1]))
    try:
        if file.suffix.lower() != ".obj":
            vertices, faces = read_whole(file)
            return [Solid(name, vertices, faces, {"group": group})], {}
        solids, said = read_obj(file)
        if not solids:
            raise InputError("is no surface of faces")
    except InputError as error:
        raise error.under(place.as_posix()) from None
    labels = [name if len(solids) == 1 else f"{name}.{own.name or k}" for k, own in enumerate(solids)]
    return [
        own._replace(name=label, extras=own.extras | {"group": ".".join(filter(None, (group, own.extras["group"])))})
        for own, label in zip(solids, labels, strict=True)
    ], said


def _said(notes: list[dict[str, Any]]) -> dict[str, Any]:
    """Friction and gravity that files note. Raises InputError where they differ: an assembly has one of each."""
    found = {key: [said[key] for said in notes if key in said] for key in ("friction", "gravity")}
    if wrong := [f"its files say different values of {key}" for key, own in found.items() if own != own[:1] * len(own)]:
        raise InputError(*wrong)
    return {key: own[0] for key, own in found.items() if own}


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
        raise InputError(f"{path}: already holds {_listed('or')} files, which would be read as blocks too")
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
