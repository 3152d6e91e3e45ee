"""What a scene file says: a rectangular building of walls, openings, buttresses and a barrel vault.

Every constructive parameter is a number or a range {value, min, max, step}; the search moves ranges. Lengths
are in metres. Unknown keys are refused with their path.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

import msgspec
import numpy as np

from blockstat.errors import InputError

WALLS = ("south", "north", "west", "east")
WallName = Literal["south", "north", "west", "east"]


#: A range with more values than this is a slip of the pen.
MOST_STEPS = 10_000


class Range(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A parameter that may move: its present value, its bounds (both included) and its step."""

    value: float
    min: float
    max: float
    step: Annotated[float, msgspec.Meta(gt=0)]

    def __post_init__(self) -> None:
        if not np.isfinite([self.value, self.min, self.max, self.step]).all():
            raise ValueError("value, min, max and step must be finite")
        if (self.max - self.min) / self.step > MOST_STEPS:
            raise ValueError(f"a step of {self.step:g} makes more than {MOST_STEPS} values")
        if not self.min <= self.value <= self.max:
            raise ValueError(f"value {self.value:g} must lie between min {self.min:g} and max {self.max:g}")

    def steps(self) -> list[float]:
        """Values from the largest down to the smallest, shape (n,)."""
        count = int(np.floor((self.max - self.min) / self.step + 1e-9))
        values = [round(self.max - i * self.step, 12) for i in range(count + 1)]
        return values if values[-1] <= self.min + 1e-9 * self.step else [*values, self.min]


Length = Annotated[float, msgspec.Meta(gt=0)] | Range
Height = Annotated[float, msgspec.Meta(ge=0)] | Range
Count = Annotated[int, msgspec.Meta(ge=0)] | Range


class Brick(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Nominal brick; the length is stretched a little so that each row is whole bricks and one half brick."""

    length: Length = 0.8
    height: Length = 0.3


class Wall(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The four walls, one leaf thick."""

    thickness: Length = 0.8
    height: Length = 2.4


class Opening(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Doors or windows of one wall, evenly spaced, each under a lintel; heights snap to whole courses."""

    width: Length
    height: Length
    sill: Height = 0.0
    number: Count = 1


class Buttress(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Buttresses of one wall, evenly spaced, standing against it."""

    number: Count
    thickness: Length  #: projection from the wall [m]
    width: Length
    height: Length


class Vault(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A semicircular barrel vault from the south to the north wall."""

    thickness: Length = 0.3
    voussoirs: Annotated[int, msgspec.Meta(ge=3)] | Range = 13


class Material(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Intrinsic parameters with the defaults of the procedural-masonry paper.

    Joints are dry. The paper's glue of 10 is a threshold on accumulated impacts in its host program and its rotational
    stiffness scales the inertia there; neither is a property of a joint, so both are kept with the scene and not
    modelled. Glue with a strength in newtons is asked for: `blockstat.glued(build(building), strength)`, rotational
    stiffness too: `dynsim.InertiaScale`, `dynsim.AngularSprings`.
    """

    density: Annotated[float, msgspec.Meta(gt=0)] = 2691.0  #: [kg/m3]
    friction: Annotated[float, msgspec.Meta(ge=0)] = 0.7
    glue: Annotated[float, msgspec.Meta(ge=0)] = 10.0
    rotational_stiffness: Annotated[float, msgspec.Meta(ge=0)] = 7000.0  #: [N m/rad]


class Joint(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What is different about the joints between two groups (see `blockstat.joint.JointLaw`)."""

    between: tuple[str, str]
    friction: Annotated[float, msgspec.Meta(ge=0)] | None = None
    tension: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: [Pa]
    bond: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: [N]
    cohesion: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: [Pa]
    bond_moment: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: [N m]
    compression: Annotated[float, msgspec.Meta(gt=0)] | None = None  #: [Pa]
    cells: Annotated[int, msgspec.Meta(ge=0, le=64)] = 0


class Building(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A rectangular building on a fixed ground slab.

    The long walls run along x, south at y < 0 and north at y > span; the end walls stand between them, so
    that the layout of a wall does not depend on the thickness of another.
    """

    name: str
    length: Length  #: of the long walls, end to end [m]
    span: Length  #: clear width between the long walls [m]
    brick: Brick = Brick()
    wall: Wall = Wall()
    doors: dict[WallName, Opening] = {}
    windows: dict[WallName, Opening] = {}
    buttresses: dict[WallName, Buttress] = {}
    vault: Vault | None = None
    material: Material = Material()
    joints: tuple[Joint, ...] = ()

    def __post_init__(self) -> None:
        if not self.name.strip() or set(self.name) & set("/\\") or self.name in (".", ".."):
            raise ValueError(f"name {self.name!r} must not be empty or hold a slash; it names the report's directory")


def value_of(parameter: float | Range) -> float:
    """The number a parameter stands for now."""
    return parameter.value if isinstance(parameter, Range) else parameter


def parameters(building: Building) -> dict[str, Range]:
    """The parameters that may move, by dotted path such as "wall.thickness" or "buttresses.south.number"."""
    found: dict[str, Range] = {}

    def visit(node: Any, path: str) -> None:
        if isinstance(node, Range):
            found[path] = node
        elif isinstance(node, msgspec.Struct):
            for name in node.__struct_fields__:
                visit(getattr(node, name), f"{path}.{name}" if path else name)
        elif isinstance(node, dict):
            for name, child in node.items():
                visit(child, f"{path}.{name}")

    visit(building, "")
    return found


def with_values(building: Building, values: dict[str, float]) -> Building:
    """The building with some of its ranges moved to other values.

    Raises InputError for a path that is no range, or a value outside its bounds.
    """
    ranges = parameters(building)
    data = msgspec.to_builtins(building)
    for path, value in values.items():
        if path not in ranges:
            raise InputError(f'no parameter "{path}" to move; ranges are: {", ".join(ranges) or "none"}')
        node = data
        for key in path.split("."):
            node = node[key]
        node["value"] = float(value)
    return building_from(data)


def building_from(data: Any) -> Building:
    """A building from plain dicts. Raises InputError naming the path of a bad or unknown key."""
    _finite(data, "")
    try:
        building = msgspec.convert(data, Building)
        for path, found in parameters(building).items():
            # The ends of a range must be values that the parameter could have by itself.
            for end in (found.min, found.max, found.max - found.step if found.max > found.min else found.max):
                plain = msgspec.to_builtins(building)
                node = plain
                *parents, last = path.split(".")
                for key in parents:
                    node = node[key]
                node[last] = int(end) if float(end).is_integer() else end
                msgspec.convert(plain, Building)
        return building
    except msgspec.ValidationError as error:
        message, _, where = str(error).partition(" - at `$")
        path = where.rstrip("`").lstrip(".")
        unknown = message.startswith("Object contains unknown field")
        if unknown:
            field = message.split("`")[1]
            message = f"unknown key; keys here are: {', '.join(_fields_at(path))}"
            path = f"{path}.{field}" if path else field
        raise InputError(f"{path}: {message}" if path else message) from None


def _finite(node: Any, path: str) -> None:
    """Raise InputError for a number that is not finite."""
    if isinstance(node, float) and not np.isfinite(node):
        raise InputError(f"{path}: {node} is not a finite number")
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in items:
        _finite(child, f"{path}.{key}" if path else str(key))


def _fields_at(path: str) -> tuple[str, ...]:
    """Names of the fields of the struct at a path; map keys show up as `[...]` in msgspec's paths."""
    kinds: dict[str, type[msgspec.Struct]] = {
        "": Building, "brick": Brick, "wall": Wall, "doors[...]": Opening, "windows[...]": Opening,
        "buttresses[...]": Buttress, "vault": Vault, "material": Material,
        "joints[...]": Joint,
    }  # fmt: skip
    return kinds.get(re.sub(r"\[\d+\]", "[...]", path), Range).__struct_fields__
