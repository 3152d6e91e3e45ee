"""The elements of masonry: from dimensions to blocks.

Each builder takes options in metres and returns blocks about its own origin; `moved` puts them in place and `assemble`
makes an assembly of them. They stand by family: `arches` (with columns and piers), `walling` (walls, their openings and
their buttresses), `vaults` (with domes) and `buttresses` (standing by themselves, and flying).

A new element, such as a vault type, is a function in the room of its family with typed keyword options and a numpy
docstring, and a line in `kinds.KINDS`. That line makes it a kind of element in scene files: its keys, their bounds and
the reference of the scene language come from the signature and the docstring. Export it here to hand it to users, and
draw it in the gallery.

This room imports `geometry`, `io` (elements may come from files), `system` (old names) and the root.
"""

from blockstat.model.arches.arch import arch, jack_arch, rib
from blockstat.model.arches.column import column, pier
from blockstat.model.buttresses.buttress import buttress
from blockstat.model.buttresses.flying_buttress import flying_buttress
from blockstat.model.placing import assemble, moved
from blockstat.model.vaults.cylindrical import barrel_vault, groin_vault, pavilion_vault
from blockstat.model.vaults.dome import dome, drum
from blockstat.model.vaults.freeform import freeform, height_field
from blockstat.model.vaults.mesh_vault import mesh_vault, surface_points
from blockstat.model.vaults.sail_fan import fan_vault, sail_vault
from blockstat.model.walling.arc_wall import arc_wall
from blockstat.model.walling.run import Buttress, Coping, Opening, Run, Through
from blockstat.model.walling.walls import walls
from blockstat.system.old_names import old_names

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
__getattr__ = old_names(__name__)
