"""From a scene or from parameters to blocks."""

from blockstat.model.arches.arch import arch, jack_arch, rib
from blockstat.model.arches.column import column, pier
from blockstat.model.buttresses.buttress import buttress
from blockstat.model.buttresses.flying_buttress import flying_buttress
from blockstat.model.placing import assemble, moved
from blockstat.model.compose import build
from blockstat.model.vaults.cylindrical import barrel_vault, groin_vault, pavilion_vault
from blockstat.model.vaults.dome import dome, drum
from blockstat.model.vaults.freeform import freeform, height_field
from blockstat.model.vaults.mesh_vault import mesh_vault, surface_points
from blockstat.model.vaults.sail_fan import fan_vault, sail_vault
from blockstat.model.walling.arc_wall import arc_wall
from blockstat.model.walling.run import Buttress, Coping, Opening, Run, Through
from blockstat.model.walling.walls import walls

__all__ = [
    "Buttress",
    "Coping",
    "Opening",
    "Run",
    "Through",
    "arc_wall",
    "arch",
    "assemble",
    "barrel_vault",
    "build",
    "buttress",
    "column",
    "dome",
    "drum",
    "fan_vault",
    "flying_buttress",
    "freeform",
    "groin_vault",
    "height_field",
    "jack_arch",
    "mesh_vault",
    "moved",
    "pavilion_vault",
    "pier",
    "rib",
    "sail_vault",
    "surface_points",
    "walls",
]
