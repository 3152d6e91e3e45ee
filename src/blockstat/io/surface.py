"""Surfaces from mesh files: the middle of a vault, open and of polygons."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from blockstat.errors import InputError
from blockstat.io.obj import read_obj
from blockstat.io.parts import metres_in
from blockstat.typing import Floats

SURFACES = (".obj", ".ply", ".stl", ".glb")
MERGE = 1e-6  #: corners closer than this fraction of the surface's size are one


def read_surface(path: str | Path, *, units: str | None = None) -> tuple[Floats, list[list[int]]]:
    """Read a surface from a mesh file; all objects of the file are one surface.

    Parameters
    ----------
    path : str or Path
        An .obj, .ply, .stl or .glb file.
    units : str, optional
        Of the coordinates in the file, by default metres.

    Returns
    -------
    corners : ndarray, shape (n, 3)
        [m]; those that coincide are one.
    faces : list of list of int
        Polygons of an .obj file are kept; other formats have triangles.

    Raises
    ------
    InputError
        Naming a file that cannot be read, or holds no faces or none that extends, or for a unit that is not known.
    """
    path = Path(path)
    if path.suffix.lower() not in SURFACES:
        raise InputError(f'{path}: cannot read a surface from "{path.suffix}"; formats are: {", ".join(SURFACES)}')
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    corners, faces = _of_obj(path) if path.suffix.lower() == ".obj" else _of_mesh(path)
    if not faces:
        raise InputError(f"{path}: the file holds no faces")
    if not np.isfinite(corners).all():
        raise InputError(f"{path}: its corners must be finite")
    step = MERGE * float(np.ptp(corners, axis=0).max())
    if not step:
        raise InputError(f"{path}: all corners of its faces are at one place; a surface must extend")
    _, first, index = np.unique(np.round(corners / step), axis=0, return_index=True, return_inverse=True)
    index = index.ravel()
    merged = [list(dict.fromkeys(int(index[k]) for k in face)) for face in faces]
    if not (kept := [face for face in merged if len(face) > 2]):
        raise InputError(f"{path}: no face has three corners that are apart")
    return corners[first] * metres_in(units), kept


def _of_obj(path: Path) -> tuple[Floats, list[list[int]]]:
    try:
        solids, _ = read_obj(path)
    except InputError as error:
        raise error.under(str(path)) from None
    corners: list[tuple[float, float, float]] = []
    faces: list[list[int]] = []
    for solid in solids:
        faces += [[k + len(corners) for k in face] for face in solid.faces]
        corners += solid.vertices
    return np.array(corners, dtype=float).reshape(-1, 3), faces


def _of_mesh(path: Path) -> tuple[Floats, list[list[int]]]:
    import trimesh

    from blockstat.io.mesh import Y_UP, loaded

    try:
        mesh = loaded(path, trimesh.load_mesh)
    except InputError as error:
        raise error.under(str(path)) from None
    corners = np.asarray(mesh.vertices, dtype=float)
    if path.suffix.lower() == ".glb":
        corners = corners @ Y_UP[:3, :3]
    return corners, [[int(k) for k in face] for face in mesh.faces]
