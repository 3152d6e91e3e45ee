"""Wavefront OBJ, one named object a block, polygons kept as they are.

Written here because mesh libraries cut polygons into fans of triangles, which is wrong for concave ones.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

Solid = tuple[str, list[tuple[float, float, float]], list[list[int]]]


def read_obj(path: Path) -> list[Solid]:
    """Objects (or groups, in a file without objects) as (name, vertices, faces), in the order of the file.

    Raises InputError with the line for anything that is not well-formed.
    """
    vertices: list[tuple[float, float, float]] = []
    labels: dict[str, list[str]] = {"o": [], "g": []}
    faces: list[tuple[int, int, list[int]]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        word, *rest = line.split("#")[0].split() or [""]
        try:
            if word == "v":
                x, y, z = map(float, rest[:3])
                vertices.append((x, y, z))
            elif word == "f":
                corners = [int(item.split("/")[0]) for item in rest]
                corners = [c - 1 if c > 0 else len(vertices) + c for c in corners]
                if not all(0 <= c < len(vertices) for c in corners):
                    raise ValueError
                faces.append((len(labels["o"]), len(labels["g"]), corners))
            elif word in labels:
                labels[word].append(" ".join(rest))
        except ValueError:
            raise InputError(f"line {number}: cannot read {line.strip()!r}") from None
    kind = 0 if labels["o"] else 1
    names = labels["o" if kind == 0 else "g"]
    named_faces: dict[int, list[list[int]]] = {}
    for face in faces:
        named_faces.setdefault(face[0] if kind == 0 else face[1], []).append(face[2])
    return [_solid(names[i - 1] if i else "", vertices, own) for i, own in named_faces.items()]


def split_solids(name: str, vertices: list[tuple[float, float, float]], faces: list[list[int]]) -> list[Solid]:
    """The parts of a file without objects that share no vertices, each a block."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    edges = [(face[0], corner) for face in faces for corner in face[1:]]
    rows, cols = zip(*edges, strict=True)
    n = len(vertices)
    _, label = connected_components(sparse.coo_array(([1.0] * len(edges), (rows, cols)), shape=(n, n)), directed=False)
    parts: dict[int, list[list[int]]] = {}
    for face in faces:
        parts.setdefault(int(label[face[0]]), []).append(face)
    return [_solid(name, vertices, own) for own in parts.values()]


def _solid(name: str, vertices: list[tuple[float, float, float]], faces: list[list[int]]) -> Solid:
    used = sorted({corner for face in faces for corner in face})
    index = {corner: i for i, corner in enumerate(used)}
    return name, [vertices[corner] for corner in used], [[index[corner] for corner in face] for face in faces]


def write_obj(assembly: Assembly, path: Path) -> None:
    """All digits, metres, z up; names may not hold blanks in this format."""
    lines = [f"# {assembly.name}: {assembly.n_blocks} blocks, metres, z up"]
    offset = 1
    for block, name in enumerate(assembly.names):
        vertices = assembly.block_vertices(block)
        lines.append(f"o {'_'.join(name.split())}")
        lines += ["v " + " ".join(repr(float(x)) for x in vertex) for vertex in vertices]
        lines += ["f " + " ".join(str(int(corner) + offset) for corner in face) for face in assembly.faces_of(block)]
        offset += len(vertices)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
