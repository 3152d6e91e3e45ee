"""PLY: polygons in the order of the file, as text or binary. trimesh reads binary faces of one number of corners only.

A text is turned into double precision and read as a binary file of nothing else. So one reader serves both.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from struct import Struct, error
from typing import Any

import numpy as np

from blockstat.errors import HUGE, InputError
from blockstat.geometry.triangulation import triangulate
from blockstat.typing import Floats, Ints

CORNERS = ("vertex_indices", "vertex_index")  #: what exporters call the corners of a face
#: Types by the names that exporters give them.
TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float16": "f2", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
#: The same as `struct` has them.
CODES: dict[str, str] = dict(zip("i1 u1 i2 u2 i4 u4 i8 u8 f2 f4 f8".split(), "bBhHiIqQefd", strict=True))
ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
END = re.compile(rb"^end_header[ \t]*(\r?\n|\Z)", re.MULTILINE)
WHOLE = 2.0**53  #: double precision holds all whole numbers up to this one

#: A coordinate of a vertex in single precision, in the header.
SINGLE = re.compile(rb"^property[ \t]+float(32)?[ \t]+[xyz][ \t\r]*$", re.MULTILINE)


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str  #: of the numbers, with the order of their bytes
    count: str = ""  #: of the length of a list


@dataclass(frozen=True)
class _Element:
    name: str
    length: int
    properties: list[_Property] = field(default_factory=list)


NONE = _Element("", 0)


def is_single(path: Path) -> bool:
    """Return whether a PLY says that its coordinates are in single precision; they are read so from a text, too.

    Parameters
    ----------
    path : Path
        A file that was read.

    Returns
    -------
    bool
    """
    return bool(SINGLE.search(path.read_bytes().partition(b"end_header")[0]))


def surface(data: bytes) -> tuple[Floats, Ints | list[Ints]]:
    """Return vertices and faces as the file has them.

    Parameters
    ----------
    data : bytes
        The file.

    Returns
    -------
    vertices : array of float, shape (n, 3)
        In the unit of the file.
    faces : array of int, or list of arrays of int
        One array where all faces have as many corners; these are not yet checked to exist.

    Raises
    ------
    InputError
        For what is no PLY, a header that cannot be used, and a file with less or more than its header says. No message
        quotes the file.
    """
    if not data.partition(b"\n")[0].strip().lower() == b"ply":
        raise InputError('its first line is not "ply"')
    end = END.search(data)
    if not end:
        raise InputError('its header has no line "end_header"')
    elements, text = _header(data[: end.start()].decode("utf-8", "replace").splitlines()[1:])
    body, said = data[end.end() :], {element.name: element for element in elements}
    if text:
        body, elements = _in_doubles(body), list(map(_of_doubles, elements))
    columns: dict[str, dict[str, Any]] = {}
    place = 0
    for element in elements:
        columns[element.name], place = _columns(element, body, place)
    if place < len(body):
        raise InputError("it holds more than its header says")
    vertex, face = said.get("vertex", NONE), said.get("face", NONE)
    vertices = _vertices(vertex, columns["vertex"]) if vertex.length else np.empty((0, 3))
    return vertices, _faces(face, columns["face"]) if face.length else np.empty((0, 3), dtype=np.int64)


def _header(lines: Sequence[str]) -> tuple[list[_Element], bool]:
    """Elements in the order of the file, and whether they are a text."""
    elements: list[_Element] = []
    form = ""
    for words in filter(None, map(str.split, lines)):
        match words:
            case ["format", name, *_] if name.lower() in ORDERS:
                form = name.lower()
            case ["element", name, length] if length.isdecimal():
                elements.append(_Element(name, int(length)))
            case ["property", *_] if not elements:
                raise InputError("its header has a property before the first element")
            case ["property", "list", count, kind, name] if {count, kind} <= set(TYPES) and "f" not in TYPES[count]:
                elements[-1].properties.append(_Property(name, ORDERS[form] + TYPES[kind], ORDERS[form] + TYPES[count]))
            case ["property", kind, name] if kind in TYPES:
                elements[-1].properties.append(_Property(name, ORDERS[form] + TYPES[kind]))
            case ["comment" | "obj_info", *_]:
                pass
            case _:
                raise InputError("its header has a line that is not understood")
        if not form and elements:
            raise InputError("its header does not say whether it is a text (ascii) or binary, before its elements")
    if any(len({own.name for own in element.properties}) < len(element.properties) for element in elements):
        raise InputError("its header names a property twice")
    return elements, form == "ascii"


def _in_doubles(text: bytes) -> bytes:
    """The numbers of a text in double precision."""
    words = text.split()
    try:
        return np.fromiter(map(float, words), "<f8", len(words)).tobytes()
    except ValueError:
        raise InputError("it holds a word where a number should be") from None


def _of_doubles(element: _Element) -> _Element:
    own = [replace(each, kind="<f8", count="<f8" if each.count else "") for each in element.properties]
    return replace(element, properties=own)


def _vertices(element: _Element, columns: dict[str, Any]) -> Floats:
    """Coordinates, in single precision where the header says so: a text may hold more digits than are meant."""
    kinds = {own.name: own.kind for own in element.properties if not own.count}
    if set("xyz") - set(kinds):
        raise InputError("its header names no vertices with x, y and z")
    with np.errstate(over="ignore"):  # what is too large is refused later
        axes = [columns[axis].astype(kinds[axis]) if "f" in kinds[axis] else columns[axis] for axis in "xyz"]
    return np.column_stack(axes).astype(float)


def _faces(element: _Element, columns: dict[str, Any]) -> Ints | list[Ints]:
    """Corners of each face; other lists, as of texture coordinates, are passed over."""
    lists = [own.name for own in element.properties if own.count]
    found = [name for name in CORNERS if name in lists] or lists
    if not found or (len(found) > 1 and found == lists):
        raise InputError(f'its faces have no list "{CORNERS[0]}"')
    rows = columns[found[0]]
    flat = rows.reshape(-1) if isinstance(rows, np.ndarray) else np.concatenate(rows)
    if "f" in flat.dtype.str and not ((np.abs(flat) < WHOLE) & (flat == np.rint(flat))).all():
        raise InputError("a corner of a face has a number that is not whole")
    flat = flat.astype(np.int64)
    return flat.reshape(rows.shape) if isinstance(rows, np.ndarray) else _split(flat, [len(row) for row in rows])


def _columns(element: _Element, data: bytes, start: int) -> tuple[dict[str, Any], int]:
    """What the properties of an element hold, and where the next begins; lists of one length are one array."""
    own = element.properties
    least = sum(np.dtype(each.count or each.kind).itemsize for each in own)
    if element.length * least > len(data) - start:
        raise _short(element)
    if not element.length or not own:
        return {each.name: np.empty(0) for each in own}, start
    counts = [int(n[0]) for _, n in _walk(element, 1, data, start)[0]]
    parts = zip(own, counts, strict=True)
    row = np.dtype([part for k, (each, count) in enumerate(parts) for part in _fields(k, each, count)])
    if (end := start + row.itemsize * element.length) <= len(data):
        rows = np.frombuffer(data, row, element.length, start)
        if all((rows[f"n{k}"] == counts[k]).all() for k, each in enumerate(own) if each.count):
            return {each.name: rows[f"v{k}"] for k, each in enumerate(own)}, end
    found, end = _walk(element, element.length, data, start)
    raw = np.frombuffer(data, np.uint8)
    columns: dict[str, Any] = {}
    for each, (place, count) in zip(own, found, strict=True):
        width = np.dtype(each.kind).itemsize
        after = np.cumsum(count * width)
        index = np.arange(int(after[-1])) + np.repeat(place - after + count * width, count * width)
        flat = raw[index].view(each.kind)
        columns[each.name] = _split(flat, count) if each.count else flat
    return columns, end


def _fields(number: int, own: _Property, count: int) -> list[Any]:
    """Fields of a property in rows whose lists are as long as those of the first."""
    if own.count:
        return [(f"n{number}", own.count), (f"v{number}", own.kind, (count,))]
    return [(f"v{number}", own.kind)]


def _walk(element: _Element, length: int, data: bytes, start: int) -> tuple[list[tuple[Ints, Ints]], int]:
    """Where the values of each property begin in so many rows, how many there are, and where the rows end."""
    steps = [
        (Struct(own.count[0] + CODES[own.count[1:]]) if own.count else None, np.dtype(own.kind).itemsize, [], [])
        for own in element.properties
    ]
    at = start
    try:
        for _ in range(length):
            for lengths, width, places, counts in steps:
                count = 1
                if lengths:
                    (count,) = lengths.unpack_from(data, at)
                    at += lengths.size
                    if not 0 <= count < WHOLE or count % 1:
                        raise InputError("the length of a list is not a whole number from 0")
                places.append(at)
                counts.append(count)
                at += width * int(count)
    except error:
        raise _short(element) from None
    if at > len(data):
        raise _short(element)
    return [(np.array(places), np.array(counts, dtype=np.int64)) for _, _, places, counts in steps], at


def _short(element: _Element) -> InputError:
    """What is missing; of a header, only the names that every PLY may have are passed on."""
    missing = {"vertex": "vertices", "face": "faces"}.get(element.name, "rows of another element")
    return InputError(f"it is cut short: it holds fewer {missing} than its header says")


def _split(flat: np.ndarray, counts: Sequence[int] | Ints) -> list[np.ndarray]:
    return np.split(flat, np.cumsum(counts)[:-1])


def in_triangles(vertices: Floats, faces: Ints | list[Ints]) -> Ints:
    """Cut faces into triangles that follow one another as the faces do, and use every edge of these.

    Parameters
    ----------
    vertices : array of float, shape (n, 3)
        In the unit of the file.
    faces : array of int, or list of arrays of int
        As `surface` returns them.

    Returns
    -------
    array of int, shape (n_triangles, 3)
        Corners of each triangle.
    """
    if isinstance(faces, np.ndarray) and faces.shape[1] == 3:
        return faces
    vertices = np.where(np.abs(vertices) < HUGE, vertices, 0.0)  # others are refused later
    triangles = [_cut(vertices, face) for face in faces if len(face) > 2]
    return np.concatenate(triangles) if triangles else np.empty((0, 3), dtype=np.int64)


def _cut(vertices: Floats, face: Ints) -> Ints:
    """Triangles of one face: by ears, or as a fan where these leave out a corner that is in line with others."""
    if len(face) == 3:
        return face[None]
    ears = triangulate(vertices, [face])
    if len(ears) == len(face) - 2:
        return ears
    return np.column_stack([np.full(len(face) - 2, face[0]), face[1:-1], face[2:]])
