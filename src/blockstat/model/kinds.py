"""The kinds of element that a scene is made of, and what builds each: a new kind is a line of `KINDS`.

The keys of an element are the options of its builder: their names, their types with bounds and their defaults are those
of its signature, and what they mean is said in the Parameters of its docstring. Nothing of this is written a second
time: `blockstat.spec.elements` reads it here.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np

from blockstat.assembly import FRICTION, Block
from blockstat.errors import InputError, InputWarning
from blockstat.model.arches.arch import arch, jack_arch, rib
from blockstat.model.arches.column import column, pier
from blockstat.model.buttresses.buttress import buttress
from blockstat.model.buttresses.flying_buttress import flying_buttress
from blockstat.model.expression import CONSTANTS, evaluate
from blockstat.model.quantities import Count, Ends, Length, Two
from blockstat.model.solids import box
from blockstat.model.vaults.cylindrical import barrel_vault, groin_vault, pavilion_vault
from blockstat.model.vaults.dome import dome, drum
from blockstat.model.vaults.freeform import freeform, height_field
from blockstat.model.vaults.mesh_vault import mesh_vault, surface_points
from blockstat.model.vaults.sail_fan import fan_vault, sail_vault
from blockstat.model.walling.arc_wall import STRAIGHT, arc_wall
from blockstat.model.walling.run import Run
from blockstat.model.walling.walls import walls
from blockstat.typing import Floats


@dataclass(frozen=True)
class Kind:
    """How an element is built."""

    build: Callable[..., list[Block]]  #: its blocks about its own origin; the options are the element's keys
    more: Callable[..., Any] | None = None  #: what takes the `**options` of the builder
    without: tuple[str, ...] = ()  #: options that are no keys


def one_box(*, size: tuple[Length, Length, Length]) -> list[Block]:
    """One block from z = 0 up, centred on its origin: an abutment, an abacus, a statue.

    Parameters
    ----------
    size : tuple of float
        Along x, y and z [m].

    Returns
    -------
    list of Block
        One, without a name and a group of its own.
    """
    x, y, z = size
    return [box((-x / 2, -y / 2, 0.0), (x / 2, y / 2, z), name="", group="")]


def walls_by_name(*, runs: dict[str, Run], **options: Any) -> list[Block]:
    """Walls from z = 0 up, bonded at their corners and T-junctions.

    Parameters
    ----------
    runs : dict of Run
        By name; of two that meet, the first has the corner stone of the lowest course.
    **options
        Those of `walls`.

    Returns
    -------
    list of Block
        As of `walls`.

    Raises
    ------
    InputError
        As `walls`, and for a run with another name than its key.
    """
    for name, run in runs.items():
        if run.name not in ("", name):
            raise InputError(f'runs.{name}.name: it is "{run.name}"; the name of a run is the key of its table')
    return walls([msgspec.structs.replace(run, name=name) for name, run in runs.items()], **options)


def surface_vault(
    *,
    height: str | None = None,
    constants: dict[str, float] | None = None,
    file: str | None = None,
    units: str = "m",
    x: Ends | None = None,
    y: Ends | None = None,
    courses: Two,
    voussoirs: Count,
    thickness: Length,
    **options: Any,
) -> list[Block]:
    """A vault in bonded courses over a surface above a rectangle: a formula, or a mesh file.

    Parameters
    ----------
    height : str, optional
        Of the middle surface [m], arithmetic over x, y and the constants: "2 * (1 - y ** 2)".
    constants : dict of float, optional
        Names that the formula may use.
    file : str, optional
        Or a mesh of it, beside the scene: .obj, .ply, .stl or .glb.
    units : str
        Of the file.
    x : tuple of float, optional
        Ends of the rectangle [m]; by default those of the mesh.
    y : tuple of float, optional
        Ends of the rectangle [m]; by default those of the mesh.
    courses : int
        Their number along y.
    voussoirs : int
        In each course, along x.
    thickness : float
        Normal to the surface [m].
    **options
        Those of `freeform`.

    Returns
    -------
    list of Block
        As of `freeform`.

    Raises
    ------
    InputError
        For a formula that cannot be computed, or a file that cannot be read.
    """
    if (height is None) == (file is None):
        raise InputError("give either height (a formula over x and y) or file (a mesh)")
    if file is not None:
        from blockstat.io.surface import read_surface

        points = surface_points(*read_surface(file, units=units), x=x, y=y, courses=courses, voussoirs=voussoirs)
    else:
        if x is None or y is None:
            raise InputError("x and y are missing; a formula needs the ends of its rectangle [m]")
        surface = _formula(str(height), constants or {})
        points = height_field(surface, x=x, y=y, courses=courses, voussoirs=voussoirs)
    return freeform(points, thickness=thickness, **options)


def _formula(text: str, constants: dict[str, float]) -> Callable[[Floats, Floats], Floats]:
    """The height of a surface over arrays of x and y."""
    for name in ("x", "y"):
        if name in constants:
            raise InputError(f"constants.{name}: {name} is a coordinate")
    for name in CONSTANTS:
        if name in constants:
            raise InputError(f"constants.{name}: {name} is a number by itself; another name is needed")

    def height(x: Floats, y: Floats) -> Floats:
        places = [constants | {"x": float(u), "y": float(v)} for u, v in zip(x.flat, y.flat, strict=True)]
        try:
            return np.array([evaluate(f"= {text}", names.__getitem__, names) for names in places]).reshape(x.shape)
        except InputError as error:
            raise InputError(f"height: {error}") from None

    return height


def mesh_vault_of_file(*, file: str, units: str = "m", **options: Any) -> list[Block]:
    """A vault whose voussoirs are the faces of a mesh, with joints normal to it.

    Parameters
    ----------
    file : str
        The middle surface, beside the scene: .obj (polygons), .ply, .stl or .glb.
    units : str
        Of the file.
    **options
        Those of `mesh_vault`.

    Returns
    -------
    list of Block
        As of `mesh_vault`.

    Raises
    ------
    InputError
        For a file that cannot be read, and as `mesh_vault`.
    """
    from blockstat.io.surface import read_surface

    return mesh_vault(*read_surface(file, units=units), **options)


def blocks_of_file(*, file: str, units: str | None = None) -> list[Block]:
    """Blocks of a file, as they are.

    Parameters
    ----------
    file : str
        Beside the scene: .json, .obj, .glb, .stl, .ply or a directory, one solid a block.
    units : str, optional
        Of the file, by default metres.

    Returns
    -------
    list of Block
        With the names, groups and densities that they have in the file.

    Raises
    ------
    InputError
        For a file that cannot be read.

    Warns
    -----
    InputWarning
        Where the file has joints, ties or another friction than the default: these are the scene's to say.
    """
    from blockstat.io.files import read_parts

    # Which blocks cannot move is the scene's to say.
    parts = read_parts(file, supports=[0], units=units)
    said = parts.options
    left = [key for key in ("joints", "ties") if said.get(key)]
    left += ["friction"] if said.get("friction", FRICTION) != FRICTION else []
    if left:
        text = f"{file}: {', '.join(left)} of the file are not taken; a scene says its own"
        warnings.warn(InputWarning(text), stacklevel=2)
    density = said.get("density")
    return [replace(block, density=density) if block.density is None else block for block in parts.blocks]


KINDS: dict[str, Kind] = {
    "walls": Kind(walls_by_name, more=walls),
    "arc_wall": Kind(arc_wall, more=Run, without=("centre", *STRAIGHT)),
    "buttress": Kind(buttress),
    "flying_buttress": Kind(flying_buttress),
    "box": Kind(one_box),
    "column": Kind(column),
    "pier": Kind(pier),
    "arch": Kind(arch),
    "jack_arch": Kind(jack_arch),
    "rib": Kind(rib),
    "barrel": Kind(barrel_vault),
    "groin": Kind(groin_vault),
    "pavilion": Kind(pavilion_vault),
    "dome": Kind(dome),
    "drum": Kind(drum),
    "sail": Kind(sail_vault),
    "fan": Kind(fan_vault),
    "freeform": Kind(surface_vault, more=freeform),
    "mesh_vault": Kind(mesh_vault_of_file, more=mesh_vault),
    "mesh": Kind(blocks_of_file),
}
