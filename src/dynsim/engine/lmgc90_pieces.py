"""A concave block in LMGC90: one rigid body with several convex polyhedra.

LMGC90 knows such bodies; its wrapper for Python makes bodies of one polyhedron only. The routines behind that wrapper
are in the same library, so they are called by name: `add_one_RBDY3`, `set_one_tactor_RBDY3` for each polyhedron and
`set_blmty_RBDY3`, which computes the centre of mass and the principal axes L of the body from those of its parts.

It then has to express the corners of each polyhedron in the frame L. LMGC90 (2024) multiplies by L where it should by
its transpose. `put_data` overwrites the corners with L' (v - c), c being the centroid of the polyhedron, which is right
with and without that fault.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats
from dynsim.engine.bodies import outward_hull

COLOUR = b"REDxx"  #: of every body in the wrapper's tables of what may touch what


class _Array(ctypes.Structure):
    """What gfortran (8 and later) hands over for an array of one dimension."""

    _fields_ = (
        ("base", ctypes.c_void_p), ("offset", ctypes.c_ssize_t), ("element", ctypes.c_size_t),
        ("version", ctypes.c_int), ("rank", ctypes.c_int8), ("type", ctypes.c_int8), ("attribute", ctypes.c_int16),
        ("span", ctypes.c_ssize_t), ("stride", ctypes.c_ssize_t), ("lower", ctypes.c_ssize_t),
        ("upper", ctypes.c_ssize_t),
    )  # fmt: skip


INTEGER, REAL = 1, 3  #: gfortran's codes of types


def add_pieces(module: Any, material: str, centre: Floats, pieces: Sequence[Floats], driven: int) -> None:
    """Add a rigid body of several convex polyhedra to LMGC90.

    Parameters
    ----------
    module : module
        compas_lmgc90._lmgc90, with a simulation to which bodies are being added.
    material : str
        Name of its material, five characters.
    centre : array of float, shape (3,)
        Point that the corners refer to [m].
    pieces : sequence of arrays of float, shape (k, 3)
        Corners of each polyhedron [m].
    driven : int
        Number of velocities that will be prescribed.

    Raises
    ------
    InputError
        Where the library does not have the routines by the names that gfortran gives them.
    """
    routine = _routines(module)
    routine["add_one_rbdy3"](_reals(centre), _integer(len(pieces)), _integer(driven), _integer(0))
    count = routine["get_nb_rbdy3"]
    count.restype = ctypes.c_int
    body, polyhedron = _integer(count()), _integer(_polyhedron(module))
    zero, none, square = _reals(np.zeros(1)), _reals(np.zeros(3)), _reals(np.zeros(9))
    for number, piece in enumerate(pieces):
        faces = outward_hull(piece)[0] + 1
        numbers = np.concatenate([[len(piece), len(faces)], faces.reshape(-1)]).astype(np.int32)
        corners = np.ascontiguousarray(piece, dtype=float).reshape(-1)
        routine["set_one_tactor_rbdy3"](
            body, _integer(number + 1), polyhedron, COLOUR, zero, none, square, none,
            ctypes.byref(_array(numbers, INTEGER)), ctypes.byref(_array(corners, REAL)), ctypes.c_size_t(len(COLOUR)),
        )  # fmt: skip
    routine["set_blmty_rbdy3"](body, material.encode(), zero, none, square, ctypes.c_size_t(len(material)))
    axes = _axes(module, count())
    for number, piece in enumerate(pieces):
        local = (piece - centroid_of_hull(piece)) @ axes
        routine["put_data"](body, _integer(number + 1), _reals(local.reshape(-1)))


def centroid_of_hull(points: Floats) -> Floats:
    """Return the centroid of a convex polyhedron.

    Parameters
    ----------
    points : array of float, shape (k, 3)
        Its corners [m].

    Returns
    -------
    array of float, shape (3,)
        Volume centroid: that of the tetrahedra between the triangles of the hull and the mean of the corners.
    """
    apex = points.mean(axis=0)
    corners = points[outward_hull(points)[0]] - apex
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return apex + volume @ corners.sum(axis=1) / (4 * volume.sum())


def _routines(module: Any) -> dict[str, Any]:
    library = ctypes.CDLL(module.__file__)
    names = ("add_one_rbdy3", "get_nb_rbdy3", "set_one_tactor_rbdy3", "set_blmty_rbdy3", "put_data")
    try:
        found = {name: getattr(library, f"__rbdy3_MOD_{name}") for name in names}
        return {**found, "id": library.__parameters_MOD_get_contactor_id_from_name}
    except AttributeError as error:
        raise InputError(
            "this build of compas_lmgc90 cannot be given concave blocks: its library does not have the routines of "
            'LMGC90 by the names that gfortran gives them; use the engine "bullet"'
        ) from error


def _axes(module: Any, count: int) -> Floats:
    """Principal axes (columns) of the last of the bodies that were added."""
    bodies = (ctypes.c_double * (12 * count))()  # of each the centre and, column by column, the axes
    ctypes.CDLL(module.__file__).lmgc90_get_all_bodies(bodies, ctypes.c_int(count))
    return np.array(bodies).reshape(count, 12)[-1, 3:].reshape(3, 3).T


def _polyhedron(module: Any) -> int:
    """LMGC90's number of a polyhedron among the shapes it knows."""
    number = _routines(module)["id"]
    number.restype = ctypes.c_int
    return number(b"POLYR", ctypes.c_size_t(5))


def _integer(value: int) -> Any:
    return ctypes.byref(ctypes.c_int(value))


def _reals(values: Floats) -> Any:
    return (ctypes.c_double * len(values))(*values)


def _array(values: np.ndarray, kind: int) -> _Array:
    """The description of an array, which must live as long as it is used."""
    return _Array(values.ctypes.data, -1, values.itemsize, 0, 1, kind, 0, values.itemsize, 1, 1, len(values))
