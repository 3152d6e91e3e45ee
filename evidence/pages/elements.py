"""One assembly of every element that `blockstat.model` builds, for the gallery."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from blockstat import Assembly
from blockstat.model import (
    Buttress,
    Coping,
    Opening,
    Run,
    Through,
    arc_wall,
    arch,
    assemble,
    barrel_vault,
    buttress,
    column,
    dome,
    drum,
    fan_vault,
    flying_buttress,
    freeform,
    groin_vault,
    height_field,
    jack_arch,
    mesh_vault,
    moved,
    pavilion_vault,
    pier,
    rib,
    sail_vault,
    walls,
)
from blockstat.model.ground import ground
from examples import canopy, cross_vault
from examples import freeform as waving

ARCH = {"span": 3.0, "depth": 0.6, "springers": 0.5}
BAY = {"spans": (4.0, 4.0), "thickness": 0.4, "brick": 0.7, "springers": 0.4}
WALL = {"path": [(0, 0), (6, 0)], "thickness": 0.5, "height": 2.5}
BRICK = (0.6, 0.25)


def standing(blocks: list) -> Assembly:
    """Blocks on a slab."""
    return assemble([ground(blocks), *blocks], supports="ground")


def one_wall(**options) -> Assembly:
    return standing(walls(Run(name="wall", **WALL | options), brick=BRICK))


def corners() -> Assembly:
    """Two walls that meet at a corner and one that meets the first in a T."""
    runs = [
        Run(name="south", path=[(0, 0), (5, 0)], thickness=0.5, height=2.0),
        Run(name="west", path=[(0, 0), (0, 3)], thickness=0.5, height=2.0),
        Run(name="inner", path=[(3, 0), (3, 3)], thickness=0.4, height=1.5),
    ]
    return standing(walls(runs, brick=BRICK))


def buttressed() -> Assembly:
    """Buttresses bonded into a wall: stepped, and raking."""
    stepped = {"width": 0.6, "projection": 0.8, "height": 2.25, "steps": [(1.25, 0.45)], "weathering": 0.25}
    raking = {"width": 0.6, "projection": 0.9, "height": 2.25, "rake": 0.35}
    return standing(walls(Run(name="wall", **WALL), brick=BRICK, buttresses=[
        Buttress(wall="wall", at=[1.5], **stepped), Buttress(wall="wall", at=[4.5], **raking)]))  # fmt: skip


def flyer() -> Assembly:
    """A flying buttress between a wall and its pier."""
    wall = walls(
        Run(name="wall", path=[(0, -1.5), (0, 1.5)], align="left", thickness=0.8, height=5.0), brick=(0.8, 0.4)
    )
    stones = flying_buttress(span=2.6, low=2.4, high=3.9, depth=0.4, width=0.6, voussoirs=8, pier=(1.4, 0.8), courses=8,
                             pinnacle=0.8)  # fmt: skip
    return standing([*wall, *stones])


def vault_on_ribs() -> Assembly:
    """A barrel vault with ribs under it; ribs and vault share the corners of their courses."""
    shape = {"span": 4.0, "voussoirs": 15}
    blocks = barrel_vault(length=4.4, thickness=0.3, brick=0.8, springers=0.4, **shape)
    for k, x in enumerate((-1.4, 0.0, 1.4)):
        blocks += moved(rib(thickness=0.3, depth=0.4, springers=0.4, **shape), (x, 0, 0), turn=90, prefix=f"rib{k}.")
    springers = ["springer", *(f"rib{k}.springer" for k in range(3))]
    return assemble(blocks, supports=springers)


def on_drum() -> Assembly:
    """A dome with an oculus on its drum."""
    plan = {"span": 5.0, "voussoirs": 20}
    stones = drum(thickness=0.8, height=2.0, courses=5, **plan)
    top = dome(thickness=0.35, rings=9, oculus=1.2, **plan)
    return standing([*stones, *moved(top, (0, 0, 2.0))])


def saddle() -> Assembly:
    points = height_field(lambda x, y: 0.25 * (x**2 - y**2), x=(-2, 2), y=(-2, 2), courses=12, voussoirs=6)
    return assemble(freeform(points, thickness=lambda x, y: 0.2 + 0.08 * np.abs(y), springers=0.4))


def wave() -> Assembly:
    points = height_field(waving.height, x=(-3, 3), y=(-2, 2), courses=13, voussoirs=8)
    return assemble(freeform(points, thickness=0.3, springers=0.4))


#: File, what it is, how it is built, and options of `picture`.
ELEMENTS: list[tuple[str, str, Callable[[], Assembly], dict]] = [
    ("wall-running", "wall in running bond with half bricks", one_wall, {}),
    ("wall-english", "wall in English bond", lambda: one_wall(bond="english", leaves=2), {}),
    ("wall-flemish", "wall in Flemish bond", lambda: one_wall(bond="flemish", leaves=2), {}),
    ("wall-through", "wall of three leaves with through-stones, battered",
     lambda: one_wall(thickness=0.9, leaves=3, through=Through(courses=2, bricks=3), batter=(0.08, 0.08)), {}),
    ("wall-corners", "walls with a corner and a T-junction in bond", corners, {"azimuth": 35.0}),
    ("wall-gable", "wall with a gable and a raked coping",
     lambda: one_wall(gable=1.75, coping=Coping(overhang=0.08)), {"elevation": 15.0}),
    ("wall-openings", "wall with a lintel, a flat arch and a round arch over its openings",
     lambda: one_wall(path=[(0, 0), (8, 0)], height=3.5, coping=Coping(), openings=[
         Opening(width=1.0, height=1.75, at=[1.5], head="lintel"),
         Opening(width=1.0, height=1.25, sill=0.75, at=[4.0], head="flat", depth=0.5),
         Opening(width=1.2, height=1.5, at=[6.5], head="semicircular", depth=0.3)]), {"elevation": 12.0}),
    ("wall-pointed", "wall with a pointed and a segmental arch over its windows",
     lambda: one_wall(path=[(0, 0), (7, 0)], height=3.5, openings=[
         Opening(width=1.2, height=1.0, sill=0.5, at=[1.8], head="pointed", rise=1.0, depth=0.3),
         Opening(width=1.6, height=1.0, sill=0.5, at=[5.2], head="segmental", rise=0.5, depth=0.3)]),
     {"elevation": 12.0}),
    ("wall-round", "round wall with openings",
     lambda: standing(arc_wall(radius=2.0, thickness=0.5, height=3.0, brick=BRICK, openings=[
         Opening(width=0.9, height=2.0, at=[10.5]),
         Opening(width=0.6, height=0.75, sill=1.25, at=[2.0, 5.0, 8.0])])),
     {"azimuth": -70.0}),
    ("buttress", "buttress, stepped, standing by itself",
     lambda: standing(buttress(width=0.6, projection=1.0, height=2.5, steps=[(1.5, 0.5)], weathering=0.5,
                               brick=BRICK)), {"azimuth": 40.0}),
    ("buttress-bonded", "buttresses bonded into a wall: stepped and raking", buttressed, {}),
    ("buttress-flying", "flying buttress and its pier with a pinnacle", flyer, {"elevation": 15.0}),
    ("arch-semicircular", "semicircular arch", lambda: assemble(arch(thickness=0.4, voussoirs=15, **ARCH)), {}),
    ("arch-segmental", "segmental arch",
     lambda: assemble(arch("segmental", rise=0.8, thickness=0.4, voussoirs=13, **ARCH)), {}),
    ("arch-pointed", "pointed arch",
     lambda: assemble(arch("pointed", rise=2.3, thickness=0.4, voussoirs=16, **ARCH)), {}),
    ("arch-elliptic", "elliptic arch",
     lambda: assemble(arch("elliptic", rise=1.0, thickness=0.5, voussoirs=15, **ARCH)), {}),
    ("arch-horseshoe", "horseshoe arch",
     lambda: assemble(arch("horseshoe", rise=1.95, thickness=0.5, voussoirs=19, **ARCH)), {}),
    ("arch-flat", "flat (jack) arch", lambda: assemble(jack_arch(thickness=0.6, voussoirs=11, **ARCH)), {}),
    ("arch-vertical", "segmental arch of vertical joints",
     lambda: assemble(arch("segmental", rise=0.8, thickness=0.4, voussoirs=13, joints="vertical", **ARCH)), {}),
    ("vault-barrel", "barrel vault, pointed",
     lambda: assemble(barrel_vault("pointed", span=4, rise=2.8, length=5, thickness=0.4, voussoirs=16, brick=0.8,
                                   springers=0.4)), {"azimuth": -25.0}),
    ("vault-groin", "groin (cross) vault", lambda: assemble(groin_vault(voussoirs=15, **BAY)), {}),
    ("vault-groin-below", "groin (cross) vault from below", lambda: assemble(groin_vault(voussoirs=15, **BAY)),
     {"elevation": -30.0}),
    ("vault-groin-bay", "groin vault over a rectangular bay, pointed, mitred groins",
     lambda: assemble(groin_vault("pointed", rise=2.9, voussoirs=16, groins="mitred",
                                  **BAY | {"spans": (5.0, 3.5)})), {}),
    ("vault-groin-piers", "groin vault on piers 1.2 m wide", lambda: cross_vault.on_piers(1.2), {"elevation": 15.0}),
    ("vault-groin-piers-thin", "groin vault on piers 0.6 m wide", lambda: cross_vault.on_piers(0.6),
     {"elevation": 15.0}),
    ("vault-pavilion", "pavilion (cloister) vault", lambda: assemble(pavilion_vault(voussoirs=15, **BAY)), {}),
    ("dome", "hemispherical dome",
     lambda: assemble(dome(span=5, thickness=0.4, rings=9, voussoirs=20, springers=0.4)), {"elevation": 35.0}),
    ("dome-oculus", "pointed dome with an oculus",
     lambda: assemble(dome("pointed", span=5, rise=3.2, thickness=0.35, rings=9, voussoirs=20, oculus=1.2,
                           springers=0.4)), {"elevation": 35.0}),
    ("vault-ribs", "barrel vault on ribs, from below", vault_on_ribs, {"azimuth": -35.0, "elevation": -25.0}),
    ("dome-drum", "dome on a drum", on_drum, {"elevation": 30.0}),
    ("vault-fan", "fan vault",
     lambda: assemble(fan_vault(spans=(4, 4), rise=2.2, thickness=0.25, foot=0.4, rings=8, voussoirs=6,
                                springers=0.3)), {"elevation": 15.0}),
    ("vault-fan-below", "fan vault over a rectangular bay, from below",
     lambda: assemble(fan_vault(spans=(5, 3.5), rise=2.2, thickness=0.25, foot=0.4, rings=8, voussoirs=6,
                                springers=0.3)), {"elevation": -30.0}),
    ("vault-sail", "sail vault, a sphere over a rectangle",
     lambda: assemble(sail_vault(spans=(4.5, 3.5), rise=1.4, thickness=0.25, courses=13, voussoirs=7, springers=0.3)),
     {}),
    ("vault-mesh", "vault from the faces of a mesh",
     lambda: assemble(mesh_vault(*canopy.surface(), thickness=0.25, springers=0.4)), {"elevation": 12.0}),
    ("freeform-wave", "waving barrel", wave, {}),
    ("freeform-saddle", "saddle, thicker towards its supports", saddle, {}),
    ("column", "round column",
     lambda: assemble(column(diameter=0.8, top=0.65, height=4.0, drums=6, sides=24, plinth=0.3), supports="plinth"),
     {"elevation": 12.0}),
    ("pier", "square pier in bond",
     lambda: assemble(pier(size=(0.8, 0.8), height=3.0, courses=9, bond="halves", plinth=0.3), supports="plinth"),
     {"elevation": 12.0}),
]  # fmt: skip
