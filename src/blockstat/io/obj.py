"""Wavefront OBJ, one named object a block, polygons kept as they are.

Written here because mesh libraries cut polygons into fans of triangles, which is wrong for concave ones. What the
format has no word for follows `o` as a comment, `# blockstat {"support": true, ...}` in JSON: support, density, values,
and names that a line of OBJ cannot hold; one before the first object holds friction and gravity. Groups are `g` too.
"""

from __future__ import annotations

import json
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from blockstat.errors import InputError
from blockstat.io.raw.runs import closed_parts, with_cavities
from blockstat.system.reading import check_file

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

NOTE = "# blockstat {"
NO_GROUP = ("", "default", "off")  #: what exporters write for no group


class Solid(NamedTuple):
    """One object of a file."""

    name: str
    vertices: Any  #: one row a vertex
    faces: list[list[int]]
    extras: dict[str, Any]


def read_obj(path: Path) -> tuple[list[Solid], dict[str, Any]]:
    """Read the objects of a file, or its groups where it has no objects.

    Parameters
    ----------
    path : Path
        An .obj file.

    Returns
    -------
    solids : list of Solid
        In the order of the file and in its unit.
    shared : dict of str to object
        What is noted of all of them.

    Raises
    ------
    InputError
        With the lines of all that is not well-formed.
    """
    vertices: list[tuple[float, float, float]] = []
    labels: dict[str, list[str]] = {"o": [], "g": []}
    notes: dict[int, dict[str, Any]] = {}
    faces: list[tuple[int, int, list[int]]] = []
    wrong: list[str] = []
    check_file(path)
    data = path.read_bytes()
    encoding = "utf-16" if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) else "utf-8-sig"
    for number, line in _lines(data.decode(encoding, "replace")):
        word, *rest = line.split("#")[0].split() or [""]
        try:
            if word == "v":
                x, y, z = map(float, rest[:3])
                vertices.append((x, y, z))
            elif word == "f":
                faces.append((len(labels["o"]), len(labels["g"]), _corners(rest, len(vertices))))
            elif word in labels:
                labels[word].append(" ".join(line.split()[1:]))
            elif line.startswith(NOTE):
                notes.setdefault(len(labels["o"]), dict(json.loads(line[len(NOTE) - 1 :])))
        except InputError as error:
            wrong.append(f"line {number}: {error}")
        except (ValueError, RecursionError):  # a note may be nested without end
            wrong.append(f'line {number}: cannot be read as "{word or "# blockstat"}" of an OBJ file')
            if word == "v":  # faces count the corners
                vertices.append((np.nan, np.nan, np.nan))
    if wrong:
        raise InputError(*wrong)
    objects = bool(labels["o"])
    names = ["", *labels["o" if objects else "g"]]
    first = {name: number for number, name in reversed([*enumerate(names)])}
    own: dict[int, list[list[int]]] = {}
    group_of: dict[int, str] = {}
    for in_object, in_group, corners in faces:
        # A group goes on where its name comes again.
        number = in_object if objects else first[names[in_group]]
        own.setdefault(number, []).append(corners)
        group_of.setdefault(number, ["", *labels["g"]][in_group] if objects else "")
    solids = []
    for number, found in own.items():
        name, group = names[number], group_of[number]
        extras: dict[str, Any] = {"name": name, "group": "" if group in (name, *NO_GROUP) else group}
        extras |= notes.get(number, {}) if objects and number else {}
        solids.append(_solid(str(extras["name"]), vertices, found, extras))
    return solids, notes.get(0, {})


def _corners(items: list[str], n_vertices: int) -> list[int]:
    """Corners of a face, which counts from one, or backwards from the last vertex before it."""
    given = [int(item.split("/")[0]) for item in items]
    if not given:
        raise ValueError
    for corner in given:
        if not 1 <= abs(corner) <= n_vertices:
            raise InputError(f'"f" has the corner {corner}, and {n_vertices} vertices come before it')
    return [c - 1 if c > 0 else n_vertices + c for c in given]


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines of a file with their numbers; corners and faces may go on after a line that ends in a backslash."""
    first, begun = 0, ""
    for number, line in enumerate(text.splitlines(), 1):
        whole = begun + line
        if not begun:
            first = number
        if whole.split()[:1] in (["v"], ["f"]) and whole.rstrip().endswith("\\"):  # a name or comment may, too
            begun = whole.rstrip()[:-1] + " "
            continue
        yield first, whole
        begun = ""
    if begun:
        yield first, begun


def split_solids(solid: Solid) -> list[Solid]:
    """Split the only object of a file into its closed parts.

    Parts share no vertices, or one is closed in the order of the file before the next begins: bricks that touch may
    share vertices. Where that leaves a part open, as the faces of a cube that list their own vertices, vertices at one
    place are one.

    Parameters
    ----------
    solid : Solid
        The object.

    Returns
    -------
    list of Solid
        Each a block without a name; the object itself where it is one part, or a part stays open.
    """
    places: dict[tuple[float, float, float], int] = {}
    place = [places.setdefault(vertex, len(places)) for vertex in solid.vertices]
    for number in (range(len(place)), place):
        runs = closed_parts([[number[corner] for corner in face] for face in solid.faces], len(place))
        runs = with_cavities(np.array(solid.vertices), solid.faces, runs) if runs else runs
        if len(runs) == 1:
            return [solid]
        if runs:
            return [_solid("", solid.vertices, [solid.faces[k] for k in run], {}) for run in runs]
    return [solid]


def _solid(
    name: str, vertices: list[tuple[float, float, float]], faces: list[list[int]], extras: dict[str, Any]
) -> Solid:
    used = sorted({corner for face in faces for corner in face})
    index = {corner: i for i, corner in enumerate(used)}
    return Solid(name, [vertices[corner] for corner in used], [[index[c] for c in face] for face in faces], extras)


def write_obj(
    assembly: Assembly,
    path: Path,
    extras: list[dict[str, Any]],
    shared: Mapping[str, Any],
    *,
    frame: tuple[str, str] = ("m", "z"),
) -> None:
    """Write one object a block, with all digits.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    path : Path
        The file.
    extras : list of dict
        What is noted of each block.
    shared : mapping of str to object
        What is noted of all.
    frame : tuple of str, optional
        Unit of the coordinates and axis that is up, for the first line.
    """
    units, up = frame
    lines = [f"# {' '.join(assembly.name.split())}: {assembly.n_blocks} blocks, in {units}, {up} up", _note(shared)]
    offset = 1
    for block, name in enumerate(assembly.names):
        vertices = assembly.block_vertices(block)
        label = " ".join(name.split())
        note = {key: value for key, value in extras[block].items() if key != "name" or label != name}
        lines += [f"o {label}", _note(note)]
        if any(assembly.groups):
            lines.append(f"g {' '.join(assembly.groups[block].split())}")
        lines += ["v " + " ".join(repr(float(x)) for x in vertex) for vertex in vertices]
        lines += ["f " + " ".join(str(int(corner) + offset) for corner in face) for face in assembly.faces_of(block)]
        offset += len(vertices)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _note(values: Mapping[str, Any]) -> str:
    return NOTE[:-1] + json.dumps(values)
