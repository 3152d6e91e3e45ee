"""From a scene or from parameters to blocks."""

from blockstat.model.arc_wall import arc_wall
from blockstat.model.arch import arch, jack_arch, rib
from blockstat.model.build import build
from blockstat.model.buttresses import buttress
from blockstat.model.column import column, pier
from blockstat.model.dome import dome, drum
from blockstat.model.fan import fan_vault, sail_vault
from blockstat.model.flyer import flying_buttress
from blockstat.model.freeform import freeform, height_field
from blockstat.model.mesh_vault import mesh_vault, surface_points
from blockstat.model.placing import assemble, moved
from blockstat.model.run import Buttress, Coping, Opening, Run, Through
from blockstat.model.vaults import barrel_vault, groin_vault, pavilion_vault
from blockstat.model.walls import walls

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
