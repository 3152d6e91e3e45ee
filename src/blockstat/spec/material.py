"""Intrinsic parameters: of the stone, of the joints and of ties; how uncertain they are; and stages of construction."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Annotated, Any, Literal

import msgspec

from blockstat.errors import InputError, gathered
from blockstat.model.quantities import Point
from blockstat.spec.reading import joined, read_as
from blockstat.system.faults import faults

#: What may be random; density and loads go with a group, as in "density.wall".
KEYS = ("friction", "edge", "corner", "push")
GROUP_KEYS = ("density", "loads")
KNOWN_KEYS = ", ".join((*KEYS, *(f"{kind}.GROUP" for kind in GROUP_KEYS)))


class Material(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Intrinsic parameters with the defaults of the procedural-masonry paper.

    Joints are dry. The paper's glue of 10 is a threshold on accumulated impacts in its host program and its rotational
    stiffness scales the inertia there; neither is a property of a joint, so both are kept with the scene and not
    modelled. Glue with a strength in newtons is asked for: `blockstat.glued(build(building), strength)`, rotational
    stiffness too: `dynsim.InertiaScale`, `dynsim.AngularSprings`.
    """

    density: Annotated[float, msgspec.Meta(gt=0)] = 2691.0  #: [kg/m3]
    friction: Annotated[float, msgspec.Meta(ge=0)] = 0.7  #: coefficient on every joint
    glue: Annotated[float, msgspec.Meta(ge=0)] = 10.0  #: kept with the scene; joints are dry
    rotational_stiffness: Annotated[float, msgspec.Meta(ge=0)] = 7000.0  #: [N m/rad], kept with the scene


class Joint(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """What is different about the joints between two groups (see `blockstat.joint.JointLaw`)."""

    between: tuple[str, str]  #: two groups, each with its subgroups; "*" is every block
    friction: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: coefficient, by default the material's
    tension: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: strength [Pa]
    bond: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: tensile capacity of each joint whatever its area [N]
    cohesion: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: shear strength without pressure [Pa]
    bond_moment: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: bending and torsion that a bond holds [N m]
    compression: Annotated[float, msgspec.Meta(gt=0)] | None = None  #: strength [Pa], by default without limit
    cells: Annotated[int, msgspec.Meta(ge=0, le=64)] = 0  #: contact cells along each side of a joint


class TieTable(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A tie, an anchor or a strut between two blocks (see `blockstat.Tie`).

    An anchor plate is an element of the kind "box" that lies against the wall, with a tie that ends on it. A tie that
    ends in a single stone pulls it out. `blockstat build` writes the names of the blocks; that of a box is the name of
    its element.
    """

    between: tuple[str, str]  #: two blocks by name; "ground" for an anchor in the ground
    points: tuple[Point, Point]  #: where it holds each of them [m]
    least: Annotated[float, msgspec.Meta(ge=0)] = 0.0  #: least force [N]
    greatest: Annotated[float, msgspec.Meta(ge=0)] = float("inf")  #: greatest force [N]; as the least: given
    strut: bool = False  #: whether it pushes


class Uncertain(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A random variable: `friction`, `edge`, `corner`, `push`, `density.GROUP` or `loads.GROUP`.

    `blockstat.reliability` says what they are. A group with a dot in its name is quoted: `density."wall.north"`.
    """

    kind: Literal["normal", "lognormal", "uniform"]  #: distribution
    mean: float | None = None  #: of a normal or lognormal one; of friction, metres, kg/m3 or factors
    deviation: Annotated[float, msgspec.Meta(ge=0)] | None = None  #: standard deviation of a normal or lognormal one
    least: float | None = None  #: lower end of a uniform one
    most: float | None = None  #: upper end of a uniform one
    #: what has a value of its own; a joint counts with the higher of its blocks, a course is of blocks at one height
    each: Literal["all", "group", "course", "block", "joint"] = "all"
    #: of any two values: the part of the variance that they share
    correlation: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0
    #: of `push`: the acceleration that it is a multiple of, in units of gravity
    direction: Point | None = None


class Stage(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """One stage of construction as it is written."""

    name: str
    place: tuple[str, ...] = ()  #: groups put in at its beginning
    centring: tuple[str, ...] = ()  #: groups that rest on a centring at its end
    courses: bool = False  #: whether it is judged after each course


def stages_from(tables: Iterable[Any]) -> tuple[Stage, ...]:
    """Return the stages that tables stand for.

    Parameters
    ----------
    tables : iterable of dict
        As they were written.

    Returns
    -------
    tuple of Stage
        In their order.

    Raises
    ------
    InputError
        With the path of a bad or unknown key, of a name that is empty, and of one that an earlier stage has.

    Examples
    --------
    >>> stages_from([{"name": "walls", "plase": ["wall"]}])
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: stages.0.plase: unknown key; keys here are: name, place, centring, courses
    """
    tables = list(tables)
    if wrong := [text for k, table in enumerate(tables) for text in faults(Stage, table, f"stages.{k}")]:
        raise InputError(*wrong)
    stages = tuple(msgspec.convert(table, Stage) for table in tables)
    first: dict[str, int] = {}  # results tell stages by their names
    for k, stage in enumerate(stages):
        if not stage.name.strip():
            wrong.append(f'stages.{k}.name: it is "{stage.name}"; a stage needs a name')
        elif first.setdefault(stage.name, k) < k:
            earlier = f"stages.{first[stage.name]}"
            wrong.append(f'stages.{k}.name: {earlier} is named "{stage.name}", too; each stage needs a name of its own')
    if wrong:
        raise InputError(*wrong)
    return stages


def is_random_key(key: str) -> bool:
    """Return whether a key says what may be random.

    Parameters
    ----------
    key : str
        As in `[uncertain.KEY]`.

    Returns
    -------
    bool
        False for a misspelt one.

    Examples
    --------
    >>> [key for key in ("friction", "frction", "density.wall", "density") if is_random_key(key)]
    ['friction', 'density.wall']
    """
    kind, _, group = key.partition(".")
    return key in KEYS or (kind in GROUP_KEYS and group != "")


def uncertain_of(tables: dict[str, Any], path: str = "uncertain") -> dict[str, dict[str, Any]]:
    """The random variables that tables stand for.

    Parameters
    ----------
    tables : dict
        As they were written; those of groups inside those of their kind.
    path : str, optional
        Where they are in the scene.

    Returns
    -------
    dict of dict
        Plain values by key, such as "density.wall".

    Raises
    ------
    InputError
        With the path of an unknown or bad key or value, and for numbers that do not belong to the distribution.
    """
    found = gathered(partial(_variables, name, table, joined(path, name)) for name, table in tables.items())
    return {key: values for inner in found for key, values in inner.items()}


def _variables(name: str, table: Any, path: str) -> dict[str, dict[str, Any]]:
    """The random variable of a table, or those of the groups in it, by key."""
    if not isinstance(table, dict):
        raise InputError(f"{path}: {table!r} is no table; write kind, and mean and deviation or least and most")
    if "kind" not in table and table and all(isinstance(inner, dict) for inner in table.values()):
        return {f"{name}.{key}": values for key, values in uncertain_of(table, path).items()}
    key = path.removeprefix("uncertain.")
    if not is_random_key(key):
        raise InputError(f"{path}: unknown key; keys here are: {KNOWN_KEYS}")
    read = read_as(Uncertain, table, path)
    needed = ("least", "most") if read.kind == "uniform" else ("mean", "deviation")
    wrong = []
    for key in ("mean", "deviation", "least", "most"):
        if (getattr(read, key) is None) == (key in needed):
            what = "is needed" if key in needed else "does not belong here"
            wrong.append(f"{path}.{key}: it {what}; {read.kind} has {needed[0]} and {needed[1]}")
    if read.direction is not None and name != "push":
        wrong.append(f"{path}.direction: push alone has one")
    if wrong:
        raise InputError(*wrong)
    values = msgspec.structs.asdict(read)
    return {name: {key: value for key, value in values.items() if value is not None}}
