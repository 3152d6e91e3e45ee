"""Scene files in TOML, and assemblies from any file."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from blockstat.assembly import Assembly
from blockstat.errors import NAMELESS, InputError, gathered, known_options
from blockstat.io.files import blaming, read_parts
from blockstat.spec.compose import build
from blockstat.spec.composition import load_tables
from blockstat.spec.reading import check_finite
from blockstat.spec.scene import Scene, scene_from
from blockstat.system.reading import check_depth, text_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

#: Tables whose errors name the line.
LOCATED = ("loads", "cases", "ties", "uncertain")
WORD = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""  #: of a key
#: A table's name in brackets and no more; rows of a list have commas, or end with one.
HEADING = re.compile(r"""\s*\[\[?\s*(WORD(?:\s*\.\s*WORD)*)\s*\]\]?\s*(?:#.*)?$""".replace("WORD", WORD))
LOADS = ("loads", "cases")  #: tables of a file of loads
BLOCKS = (".json", ".obj", ".glb", ".stl", ".ply")  #: suffixes of files that are no scenes


@known_options
def load_scene(path: str | Path, *, folder: str | Path | None = None) -> Scene:
    """Read a scene; a mesh file named in it is looked for beside it.

    Parameters
    ----------
    path : str or Path
        A file in TOML.
    folder : str or Path, optional
        For a scene of someone else: the files that it names are inside this folder, at relative paths without "..".

    Returns
    -------
    Building or Composition
        What the file says.

    Raises
    ------
    InputError
        With the line for bad TOML and the key for a bad value, and for a file outside `folder`.

    Examples
    --------
    >>> from pathlib import Path
    >>> from blockstat import load_scene, scene_from, scene_text
    >>> hut = scene_from({"name": "hut", "length": 3.0, "span": 2.0})
    >>> _ = Path("hut.toml").write_text(scene_text(hut), encoding="utf-8")
    >>> load_scene("hut.toml") == hut
    True
    """
    path = Path(path)
    if path.suffix.lower() in BLOCKS:
        raise InputError(f"{path}: a scene file (.toml) is needed; this holds blocks, which have no parameters")
    data = _tables(path)
    data.setdefault("name", path.stem)
    elements = data.get("elements")
    for name, element in elements.items() if isinstance(elements, dict) else ():
        if isinstance(element, dict) and isinstance(element.get("file"), str):
            if folder is not None and not _is_inside(Path(folder), element["file"]):
                raise InputError(
                    f"{path}: elements.{name}.file: a file of this scene is named by a relative path inside the folder "
                    "that was chosen at the start"
                )
            element["file"] = str(Path(folder or path.parent) / element["file"])
    try:
        return scene_from(data)
    except InputError as error:
        raise located(path, error) from None


def _is_inside(folder: Path, name: str) -> bool:
    """Whether a name stays in a folder, in the words of any system and after all links are followed."""
    ways = (PurePosixPath(name), PureWindowsPath(name))
    if "\0" in name or any(way.anchor or ".." in way.parts for way in ways):
        return False
    return (folder / name).resolve().is_relative_to(folder.resolve())


def load_file(path: str | Path) -> dict[str, dict[str, Any]]:
    """Read load cases from a file of their own, for blocks that come from a mesh or from JSON.

    Parameters
    ----------
    path : str or Path
        A file in TOML with tables [loads.NAME] and [cases.NAME].

    Returns
    -------
    dict of dict
        Of "loads" and "cases", as `blockstat.load_cases` takes them.

    Raises
    ------
    InputError
        With the line for bad TOML and the key for a bad value.
    """
    path = Path(path)
    data = _tables(path)
    try:
        check_finite(data)
        tables = [data[key] if isinstance(data.get(key), dict) else {} for key in LOADS]
        _, found = gathered((partial(_check_loads, data), partial(load_tables, *tables)))
        return found
    except InputError as error:
        raise located(path, error) from None


def _check_loads(data: dict[str, Any]) -> None:
    """Check the keys of a file of loads."""
    wrong = [f"{key}: unknown key; keys here are: {', '.join(LOADS)}" for key in data if key not in LOADS]
    wrong += [f"{key}: it must be a table of tables" for key in LOADS if not isinstance(data.get(key, {}), dict)]
    if wrong:
        raise InputError(*wrong)


def _tables(path: Path) -> dict[str, Any]:
    """What a file in TOML says."""
    text = text_of(path)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}{_as_number(text, str(error))}") from None
    except RecursionError:
        raise InputError(f"{path}: tables and lists are nested too deeply") from None
    except ValueError:  # Python reads no integer of so many digits
        raise InputError(f"{path}: holds a number of thousands of digits") from None
    if not data:
        raise InputError(f"{path}: the file is empty")
    blaming(path, lambda: check_depth(data))
    return data


def _as_number(text: str, told: str) -> str:
    """What to write where the line at fault has a number with a decimal comma, or with a unit."""
    at = re.search(r"line (\d+)", told)
    line = text.splitlines()[int(at[1]) - 1 :][:1] if at and told.startswith("Expected") else []
    found = re.search(r"=\s*([+-]?\d+)(?:,(\d+)|(?:\.\d+)?\s*(?![eE][+-]?\d)[a-zA-Z])", line[0]) if line else None
    if found is None:
        return ""
    if found[2] is None:
        return "; a number stands without a unit: lengths are in metres"
    return f"; a number is written with a decimal point: {found[1]}.{found[2]}"


def located(path: str | Path, error: InputError) -> InputError:
    r"""Say in which file, and for a key of loads or cases in which line, an error is.

    Parameters
    ----------
    path : str or Path
        The file.
    error : InputError
        Its message begins with the dotted path of the key at fault.

    Returns
    -------
    InputError
        With the file, and the line where the file is TOML.

    Examples
    --------
    >>> _ = Path("hut.toml").write_text('name = "hut"\n[loads.wind]\nkind = "gale"')
    >>> str(located("hut.toml", InputError("loads.wind.kind: no such kind")))
    'hut.toml, line 3: loads.wind.kind: no such kind'
    """
    path = Path(path)
    text = text_of(path) if path.suffix.lower() == ".toml" else ""
    return type(error)(*(_located(path, text, str(told)) for told in error.args))


def _located(path: Path, text: str, message: str) -> str:
    key = message.partition(":")[0].split(".")
    line = _line_of(text, key) if key[0] in LOCATED else None
    return f"{path}, line {line}: {message}" if line else f"{path}: {message}"


def _line_of(text: str, key: list[str]) -> int | None:
    """The line that says the longest part of a key; of a table its heading."""
    best, found, table = 0, None, list[str]()
    for number, line in enumerate(text.splitlines(), 1):
        if heading := HEADING.match(line):
            table = own = _parts(heading[1])
        elif entry := re.match(r"\s*([\w.\"'-]+)\s*=", line):
            own = [*table, *_parts(entry[1])]
        else:
            continue
        if len(own) > best and own == key[: len(own)]:
            best, found = len(own), number
    return found


def _parts(key: str) -> list[str]:
    return [part.strip(" \"'") for part in key.split(".")]


@known_options
def read(
    path: str | Path,
    *,
    supports: Iterable[int | str] | None = None,
    units: str | None = None,
    up: str | None = None,
) -> Assembly:
    """Read an assembly of any file.

    Files are native or COMPAS JSON, a scene in TOML (built on the spot), a mesh with one solid a block, or a directory
    of PLY, STL or OBJ files with one block a file (named like it, groups are directories).

    Parameters
    ----------
    path : str or Path
        A file or a directory.
    supports : iterable of int or str, optional
        Replaces the supports named in the file; a mesh without them needs this.
    units : str, optional
        Of the coordinates in the file ("mm", "cm", "in", ...); they are converted to metres.
    up : str, optional
        The axis of the file that points up: "x", "y", "z", "-x", "-y" or "-z"; by default z, and y in GLB, as its
        specification says. Of a GLB that was written with z up give "z". With "y" a point (x, y, z) of the file becomes
        (x, -z, y). Gravity and ties that stand in the file turn with its blocks. All that is given beside the file
        (loads, another gravity, paths, further ties) is in the axes of the assembly, z up and in metres.

    Returns
    -------
    Assembly
        In metres, with z up.

    Raises
    ------
    InputError
        Naming the file and the block or key at fault. Also for an option that does not exist.

    Examples
    --------
    >>> from blockstat import Assembly, box, read, write
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], supports=[0])
    >>> write(cube, "cube.obj").name
    'cube.obj'
    >>> read("cube.obj", units="mm").volume.round(12).tolist()
    [1e-09]
    """
    if path == "":
        raise InputError(NAMELESS)
    path = Path(path)
    if path.suffix.lower() != ".toml" or path.is_dir():
        parts = read_parts(path, supports=supports, units=units)
        return blaming(path, lambda: parts.turned(up).assembled())
    check_scene_options(path, supports=supports, units=units, up=up)
    scene = load_scene(path)
    return blaming(path, lambda: build(scene))


def check_scene_options(
    path: Path, *, supports: object = None, units: str | None = None, up: str | None = None
) -> None:
    """Refuse for a scene what can be chosen for a file of blocks alone.

    Parameters
    ----------
    path : Path
        The scene file.
    supports, units, up : optional
        As in `read`; None for what is not chosen.

    Raises
    ------
    InputError
        Naming what is chosen.
    """
    if supports is not None:
        raise InputError(f"{path}: a scene stands on its ground; supports cannot be chosen for it")
    if units not in (None, "m"):
        raise InputError(f"{path}: a scene is in metres; units cannot be chosen for it")
    if up not in (None, "z"):
        raise InputError(f"{path}: a scene has z up; another axis cannot be chosen for it")
