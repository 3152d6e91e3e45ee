"""What a scene file says, with bounds: the short form of a chapel, and compositions of elements."""

from blockstat.spec.chapel import WALLS, Brick, Building, Buttress, Opening, Vault, Wall, lowered
from blockstat.spec.composition import Composition, Plan, resolve
from blockstat.spec.material import Joint, Material
from blockstat.spec.ranges import Range, is_present, value_of
from blockstat.spec.scene import Scene, parameters, scene_from, with_values

__all__ = [
    "WALLS",
    "Brick",
    "Building",
    "Buttress",
    "Composition",
    "Joint",
    "Material",
    "Opening",
    "Plan",
    "Range",
    "Scene",
    "Vault",
    "Wall",
    "is_present",
    "lowered",
    "parameters",
    "resolve",
    "scene_from",
    "value_of",
    "with_values",
]
