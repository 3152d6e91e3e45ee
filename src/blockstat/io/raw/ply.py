"""Faces of a PLY: trimesh cuts polygons into triangles and changes their order."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import HUGE
from blockstat.geometry.triangulation import triangulate
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    import trimesh

CORNERS = ("vertex_indices", "vertex_index")  #: what exporters call the corners of a face

#: A coordinate of a vertex in single precision, in the header.
SINGLE = re.compile(rb"^property[ \t]+float(32)?[ \t]+[xyz][ \t\r]*$", re.MULTILINE)


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


def as_written(mesh: trimesh.Trimesh) -> tuple[Floats, Ints | list[Ints]]:
    """Return vertices and faces as the file has them: trimesh puts the halves of quads and other polygons last.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        As it was loaded, without processing; meshes of other formats stay as they are.

    Returns
    -------
    vertices : array of float, shape (n, 3)
        In the unit of the file.
    faces : array of int, or list of arrays of int
        One array where all faces have as many corners; these are not yet checked to exist.
    """
    raw: dict[str, Any] = mesh.metadata.get("_ply_raw") or {}
    data = raw.get("face", {}).get("data")
    names = list(data) if isinstance(data, dict) else list(getattr(data, "dtype", np.dtype(int)).names or ())
    found = [name for name in CORNERS if name in names] or names
    if not found:
        return np.asarray(mesh.vertices), np.asarray(mesh.faces).reshape(-1, 3)
    rows = data[found[0]] if isinstance(data, dict) else data[found[0]]["f1"]
    vertices = np.column_stack([raw["vertex"]["data"][axis] for axis in "xyz"]).astype(float)
    if np.ndim(rows) == 2:
        return vertices, np.asarray(rows, dtype=np.int64)
    return vertices, [np.asarray(row, dtype=np.int64).reshape(-1) for row in rows]


def in_triangles(vertices: Floats, faces: Ints | list[Ints]) -> Ints:
    """Cut faces into triangles that follow one another as the faces do, and use every edge of these.

    Parameters
    ----------
    vertices : array of float, shape (n, 3)
        In the unit of the file.
    faces : array of int, or list of arrays of int
        As `as_written` returns them.

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
