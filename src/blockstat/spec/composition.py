"""The general form of a scene: elements of many kinds, put where their keys say, with parameters they share.

A composition is kept as it was written: any number of it may be a range {value, min, max, step} or arithmetic over
the parameters ("= bays * 4"). `resolve` computes what stands there now.
"""

from __future__ import annotations

import re
from functools import partial
from keyword import iskeyword
from typing import Any

import msgspec

from blockstat.errors import InputError, gathered
from blockstat.joint import Tie
from blockstat.loading.cases import check_tables
from blockstat.model.expression import RESERVED, evaluate, is_expression
from blockstat.spec.element import Element
from blockstat.spec.elements import KINDS, check_all_places
from blockstat.spec.material import Joint, Material, TieTable, stages_from, uncertain_of
from blockstat.spec.ranges import Range, is_presence, is_range, meant_as_range
from blockstat.spec.reading import check_name, entries, joined, read_as
from blockstat.system.faults import faults, unknown_keys

GROUND = "ground"  #: among the supports: a slab under all that stands at z = 0
#: Parameters that follow from one another before the next is known: each takes some frames of Python's stack.
DEEPEST = 50
NAME = r"[A-Za-z_][A-Za-z0-9_-]*"


class Composition(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A building of elements as it was written; made by `scene_from`."""

    name: str  #: by default that of the file
    elements: dict[str, dict[str, Any]]  #: by name: each has a `kind`, the keys of that kind, and those of placing
    parameters: dict[str, Any] = {}  #: by name: a number, true or false, a range, arithmetic, or "search"
    material: dict[str, Any] = {}  #: stone and joints
    joints: list[dict[str, Any]] = []  #: laws of particular joints
    #: groups that cannot move; "ground" is a slab under all that stands at z = 0, "*" any one part of a name
    supports: tuple[str, ...] = (GROUND,)
    loads: dict[str, dict[str, Any]] = {}  #: by name: each has a `kind` and the keys of that kind
    cases: dict[str, dict[str, Any]] = {}  #: by name: combinations of loads with factors
    ties: dict[str, dict[str, Any]] = {}  #: by name: ties and struts between two blocks
    uncertain: dict[str, dict[str, Any]] = {}  #: random variables, for `blockstat reliability`
    stages: list[dict[str, Any]] = []  #: what is put in one after the other: see `blockstat.sequence.stages`
    description: str = ""  #: one line

    def __post_init__(self) -> None:
        check_name(self.name)


FIELDS = {field.name: field.type for field in msgspec.structs.fields(Composition)}


class Plan(msgspec.Struct, frozen=True, kw_only=True):
    """What a scene says now, in numbers only: the input of the builders."""

    name: str
    elements: dict[str, Element]  #: those that are present
    left_out: dict[str, Element] = {}  #: those that are not
    material: Material
    joints: tuple[Joint, ...]
    supports: tuple[str, ...] = (GROUND,)
    loads: dict[str, Any] = {}  #: tables of loads, as `blockstat.load_cases` takes them
    cases: dict[str, Any] = {}  #: and of their combinations
    ties: tuple[Tie, ...] = ()
    uncertain: dict[str, Any] = {}  #: plain values of the random variables, by key
    stages: tuple[dict[str, Any], ...] = ()  #: tables of stages, as `blockstat.assess_stages` takes them
    no_overlap: bool = False  #: whether the elements are known not to overlap, so that this need not be checked
    #: what errors call a part of the plan, and what the scene calls it
    keys: dict[str, str] = {}


def composition_from(data: dict[str, Any]) -> Composition:
    """A composition from plain data.

    Parameters
    ----------
    data : dict
        As a TOML file gives it, with a range in place of each presence to be searched.

    Returns
    -------
    Composition
        As it was written.

    Raises
    ------
    InputError
        With the path of a bad key, kind, name or number.
    """
    sound = {key: data[key] for key in FIELDS if key in data and not faults(FIELDS[key], data[key])}
    if {"elements", "parameters"} & set(data) - set(sound) or "elements" not in data:
        return read_as(Composition, data)  # what the rest stands on cannot be read
    composition, _ = gathered((partial(read_as, Composition, data), partial(_check, sound)))
    return composition


def _check(data: dict[str, Any]) -> None:
    """Check the tables of a composition that are of the right form."""
    composition = msgspec.convert(data | {"name": "scene"}, Composition)
    if not composition.elements:
        raise InputError("elements: there are none; write one as [elements.NAME]")
    gathered(
        (*(partial(_check_name, name, "elements") for name in composition.elements), partial(resolve, composition))
    )


def _check_name(name: str, table: str) -> None:
    if not re.fullmatch(NAME, name):
        raise InputError(f'{table}: "{name}" is no name; it must be of letters, digits, _ and -')


def _check_parameter(name: str, value: Any) -> None:
    _check_name(name, "parameters")
    if name in RESERVED or iskeyword(name) or not name.isidentifier():
        raise InputError(f'parameters.{name}: "{name}" is no name of a parameter; expressions could not say it')
    if not (isinstance(value, (bool, int, float)) or is_range(value) or is_expression(value)):
        if isinstance(value, dict):
            read_as(Range, value, f"parameters.{name}")
        raise InputError(
            f"parameters.{name}: {value!r} is not a number, true, false, "
            '"search", {value, min, max, step} or arithmetic ("= ...")'
        )


def resolve(composition: Composition) -> Plan:
    """The plan of a composition: every range at its value and every expression computed.

    Parameters
    ----------
    composition : Composition
        As it was written.

    Returns
    -------
    Plan
        In numbers only.

    Raises
    ------
    InputError
        With the path of a bad key, kind or number.
    """
    names = _Names(composition.parameters)
    _, elements, material, joints, tables, ties, uncertain, _ = gathered(
        (
            names.check,
            partial(_elements, composition.elements, names),
            lambda: read_as(Material, _plain(composition.material, "material", names), "material"),
            partial(_joints, composition.joints, names),
            partial(load_tables, composition.loads, composition.cases, names),
            partial(ties_of, composition.ties, names),
            lambda: uncertain_of(_plain(composition.uncertain, "uncertain", names)),
            partial(stages_from, composition.stages),
        )
    )
    return Plan(
        name=composition.name,
        elements={name: element for name, element in elements.items() if element.present},
        left_out={name: element for name, element in elements.items() if not element.present},
        material=material,
        joints=joints,
        supports=composition.supports,
        **tables,
        ties=ties,
        uncertain=uncertain,
        stages=tuple(composition.stages),
    )


def _elements(tables: dict[str, dict[str, Any]], names: _Names) -> dict[str, Element]:
    read = gathered(partial(_element, keys, f"elements.{name}", names) for name, keys in tables.items())
    return dict(zip(tables, read, strict=True))


def _joints(tables: list[dict[str, Any]], names: _Names) -> tuple[Joint, ...]:
    plain = _plain(tables, "joints", names)
    return tuple(gathered(partial(read_as, Joint, joint, f"joints.{i}") for i, joint in enumerate(plain)))


def ties_of(tables: dict[str, Any], names: _Names | None = None) -> tuple[Tie, ...]:
    """The ties that tables stand for.

    Parameters
    ----------
    tables : dict
        By name, as they were written.
    names : optional
        Parameters that their expressions may name.

    Returns
    -------
    tuple of Tie
        In their order.

    Raises
    ------
    InputError
        With the path of a bad key or value.
    """
    plain = _plain(tables, "ties", _Names({}) if names is None else names)
    return tuple(gathered(partial(_tie, name, table) for name, table in plain.items()))


def _tie(name: str, table: Any) -> Tie:
    own = read_as(TieTable, table, f"ties.{name}")
    try:
        return Tie(**msgspec.structs.asdict(own), name=name)
    except InputError as error:
        raise error.under(f"ties.{name}") from None


def load_tables(loads: dict[str, Any], cases: dict[str, Any], names: _Names | None = None) -> dict[str, Any]:
    """The tables of loads and cases in numbers, checked as far as no blocks are needed.

    Parameters
    ----------
    loads, cases : dict
        As they were written.
    names : optional
        Parameters that their expressions may name.

    Returns
    -------
    dict
        Of "loads" and "cases".

    Raises
    ------
    InputError
        With the path of a bad key, kind, name or number.
    """
    names = _Names({}) if names is None else names
    found = {key: _plain(table, key, names) for key, table in (("loads", loads), ("cases", cases))}
    check_tables(found["loads"], found["cases"])
    return found


class _Names:
    """Values of the parameters; one may be arithmetic over others."""

    def __init__(self, parameters: dict[str, Any]) -> None:
        self.parameters = parameters
        self.values: dict[str, float] = {}
        self.refused: dict[str, InputError] = {}
        self.deep: InputError | None = None
        self.asked: list[str] = []

    def check(self) -> None:
        gathered(partial(self.value, name) for name in self.parameters)

    def value(self, name: str) -> float:
        if name in self.refused:
            raise self.refused[name]
        if name not in self.values:
            if name in self.asked:
                circle = " -> ".join([*self.asked[self.asked.index(name) :], name])
                raise InputError(f"parameters.{name}: it depends on itself: {circle}")
            if len(self.asked) > DEEPEST:
                first = f"parameters.{self.asked[0]}: it follows from more than {DEEPEST} others in a row"
                self.deep = self.deep or InputError(first)
                raise self.deep  # others in the same row are not at another fault
            self.asked.append(name)
            try:
                _check_parameter(name, self.parameters[name])
                self.values[name] = float(_plain(self.parameters[name], f"parameters.{name}", self))
            except InputError as error:
                self.refused[name] = error  # all that names it is at the same fault
                raise
            finally:
                self.asked.pop()
        return self.values[name]

    def computed(self, text: str, path: str) -> float | int:
        """The number of an expression, whole where it can be."""
        try:
            return _whole(evaluate(text, self.value, self.parameters))
        except InputError as error:
            # Another parameter's fault keeps its own path.
            raise error if str(error).startswith("parameters.") else error.under(path) from None


def _whole(value: float) -> float | int:
    return int(value) if float(value).is_integer() else value


def _rounded(node: Any) -> Any:
    """Plain data with whole numbers in place of those that arithmetic left beside them, as 0.3 / 0.1 is."""
    if isinstance(node, dict):
        return {key: _rounded(child) for key, child in node.items()}
    if isinstance(node, list):
        return [_rounded(child) for child in node]
    near = round(node) if isinstance(node, float) else node
    return near if isinstance(node, float) and abs(node - near) <= 1e-12 * abs(node) else node


def _plain(node: Any, path: str, names: _Names) -> Any:
    """A part of the scene with its numbers in place of ranges and expressions."""
    if is_expression(node):
        node = names.computed(node, path)
    elif meant_as_range(node):
        node = _whole(read_as(Range, node, path).value)
    elif isinstance(node, (dict, list, tuple)):
        plain = gathered(partial(_plain, child, joined(path, key), names) for key, child in entries(node))
        return dict(zip(node, plain, strict=True)) if isinstance(node, dict) else plain
    return bool(node) if is_presence(path) and node in (0, 1) else node


def _as_arithmetic(told: str, bare: dict[str, str]) -> str:
    """A fault, with what to write where the name of a parameter stands for its value, by the place of each."""
    name = next((name for place, name in bare.items() if told.startswith(place)), None)
    return told if name is None else f'{told}; write "= {name}" for the value of the parameter'


def _element(table: dict[str, Any], path: str, names: _Names) -> Element:
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        given = f'no kind "{kind}"' if kind is not None else "the kind is missing"
        raise InputError(f"{path}.kind: {given}; kinds are: {', '.join(KINDS)}")
    keys = {key: value for key, value in table.items() if key != "kind"}
    try:
        plain = _plain(keys, path, names)
    except InputError as error:  # unknown keys are told all the same
        raise InputError(*error.args, *unknown_keys(KINDS[kind], keys, path)) from None
    try:
        element = read_as(KINDS[kind], plain, path)
    except InputError:
        try:
            element = read_as(KINDS[kind], _rounded(plain), path)
        except InputError as error:
            bare = {f"{path}.{key}: ": text for key, text in keys.items() if text in [*names.parameters]}
            raise InputError(*(_as_arithmetic(text, bare) for text in error.args)) from None
    check_all_places(element, keys, path)
    prefix = path.removeprefix("elements.") if element.prefix is None else element.prefix
    if prefix.split(".")[0] == GROUND:
        key = path if element.prefix is None else f"{path}.prefix"
        raise InputError(f'{key}: "{GROUND}" is the name of the slab; an element needs another')
    return element
