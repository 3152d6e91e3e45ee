"""What builds each kind of element of a composition."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.arches.arch import arch, jack_arch, rib
from blockstat.model.arches.column import column, pier
from blockstat.model.buttresses.buttress import buttress
from blockstat.model.buttresses.flying_buttress import flying_buttress
from blockstat.model.solids import box
from blockstat.model.vaults.cylindrical import barrel_vault, groin_vault, pavilion_vault
from blockstat.model.vaults.dome import dome, drum
from blockstat.model.vaults.freeform import freeform, height_field
from blockstat.model.vaults.mesh_vault import mesh_vault, surface_points
from blockstat.model.vaults.sail_fan import fan_vault, sail_vault
from blockstat.model.walling import run
from blockstat.model.walling.arc_wall import arc_wall
from blockstat.model.walling.walls import walls
from blockstat.spec import elements
from blockstat.spec.element import Element
from blockstat.spec.expression import evaluate
from blockstat.spec.walls import ArcWall, Buttress, Run, Walls
from blockstat.typing import Floats

#: Builders whose options are the keys of the element.
PLAIN: dict[type[Element], Callable[..., list[Block]]] = {
    Buttress: buttress,
    elements.Column: column,
    elements.Pier: pier,
    elements.FlyingButtress: flying_buttress,
    elements.Arch: arch,
    elements.JackArch: jack_arch,
    elements.Rib: rib,
    elements.Barrel: barrel_vault,
    elements.Groin: groin_vault,
    elements.Pavilion: pavilion_vault,
    elements.Dome: dome,
    elements.Drum: drum,
    elements.Sail: sail_vault,
    elements.Fan: fan_vault,
}


def blocks_of(element: Element) -> list[Block]:
    """The blocks of an element about its own origin. Raises InputError for keys that do not fit together."""
    if type(element) in PLAIN:
        return PLAIN[type(element)](**_built(element))
    return _SPECIAL[type(element)](element)


def _own(keys: msgspec.Struct) -> dict[str, Any]:
    """The keys of a table but for its presence."""
    return {key: value for key, value in msgspec.structs.asdict(keys).items() if key != "present"}


def _built(element: Element) -> dict[str, Any]:
    """The keys of an element without those of placing."""
    return {key: value for key, value in _own(element).items() if key not in Element.__struct_fields__}


def _box(element: elements.Box) -> list[Block]:
    x, y, z = element.size
    return [box((-x / 2, -y / 2, 0.0), (x / 2, y / 2, z), name="", group="")]


def _walls(element: Walls) -> list[Block]:
    present = {name: own for name, own in element.runs.items() if own.present}
    if not present:
        return []
    runs = [_run(name, own) for name, own in present.items()]
    # A buttress goes with its run; one of an unknown run is refused by the builder.
    stand = [b for b in element.buttresses if b.present and (b.wall in present or b.wall not in element.runs)]
    return walls(
        runs,
        brick=element.brick,
        buttresses=[run.Buttress(**_own(b)) for b in stand],
        bonded=element.bonded,
        sliver=element.sliver,
    )


def _arc_wall(element: ArcWall) -> list[Block]:
    return arc_wall(**_built(element) | _parts(element))


def _run(name: str, keys: Run) -> run.Run:
    return run.Run(name=name, **_own(keys) | _parts(keys))


def _parts(keys: Run | ArcWall) -> dict[str, Any]:
    """Openings, coping and through-stones of a wall."""
    return {
        "openings": [run.Opening(**_own(opening)) for opening in keys.openings if opening.present],
        "coping": None if keys.coping is None else run.Coping(**_own(keys.coping)),
        "through": None if keys.through is None else run.Through(**_own(keys.through)),
    }


def _freeform(element: elements.Freeform) -> list[Block]:
    if (element.height is None) == (element.file is None):
        raise InputError("give either height (a formula over x and y) or file (a mesh)")
    size = {"courses": element.courses, "voussoirs": element.voussoirs}
    if element.file is not None:
        from blockstat.io.surface import read_surface

        surface = read_surface(element.file, units=element.units)
        points = surface_points(*surface, x=element.x, y=element.y, **size)
    else:
        if element.x is None or element.y is None:
            raise InputError("x and y are missing; a formula needs the ends of its rectangle [m]")
        points = height_field(_formula(element), x=element.x, y=element.y, **size)
    return freeform(
        points, thickness=element.thickness, supports=element.supports, springers=element.springers, bond=element.bond
    )


def _formula(element: elements.Freeform) -> Callable[[Floats, Floats], Floats]:
    """The height of a surface over arrays of x and y."""
    for name in ("x", "y"):
        if name in element.constants:
            raise InputError(f"constants.{name}: {name} is a coordinate")

    def height(x: Floats, y: Floats) -> Floats:
        places = [element.constants | {"x": float(u), "y": float(v)} for u, v in zip(x.flat, y.flat, strict=True)]
        text = f"= {element.height}"
        try:
            return np.array([evaluate(text, names.__getitem__, names) for names in places]).reshape(x.shape)
        except InputError as error:
            raise InputError(f"height: {error}") from None

    return height


def _mesh_vault(element: elements.MeshVault) -> list[Block]:
    from blockstat.io.surface import read_surface

    vertices, faces = read_surface(element.file, units=element.units)
    return mesh_vault(
        vertices, faces, thickness=element.thickness, supports=element.supports, springers=element.springers
    )


def _mesh(element: elements.Mesh) -> list[Block]:
    from blockstat.io.files import read_parts

    # Which blocks cannot move is the composition's to say.
    return list(read_parts(element.file, supports=[0], units=element.units).blocks)


_SPECIAL: dict[type[Element], Callable[[Any], list[Block]]] = {
    elements.Box: _box,
    Walls: _walls,
    ArcWall: _arc_wall,
    elements.Freeform: _freeform,
    elements.MeshVault: _mesh_vault,
    elements.Mesh: _mesh,
}
