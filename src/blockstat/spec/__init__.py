"""What a scene file says, with bounds, and the assembly that it stands for.

A file has one of two forms: the short form of a chapel, and compositions of elements. Both become a `Plan` of elements
in numbers (`resolve`, `lowered`), and `build` puts the blocks of its elements together.

This room imports `model`, `io`, `loading`, `contact`, `system` and the root.
"""

from blockstat.spec.chapel import WALLS, Brick, Building, Buttress, Opening, Vault, Wall, lowered
from blockstat.spec.compose import build
from blockstat.spec.composition import Composition, Plan, resolve
from blockstat.spec.files import load_scene, read
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
    "build",
    "is_present",
    "load_scene",
    "lowered",
    "parameters",
    "read",
    "resolve",
    "scene_from",
    "value_of",
    "with_values",
]
