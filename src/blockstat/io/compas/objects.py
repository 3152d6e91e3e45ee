"""Objects as COMPAS writes them in JSON: what each holds, as far as it is read here.

COMPAS writes every object as {dtype: "package.module/Class", data, name?, guid?, inheritance?: [dtype]}. Of interest
here are

    compas_assembly.datastructures/Assembly  {attributes, graph: Graph of nodes {block: Mesh, is_support}}
    compas_model.models/Model                {transformation, elements: {guid: Element}, materials: {guid: Material},
                                              tree: {root: {element: guid, children: [...]}}, graph}
    an Element with a mesh                   {name, transformation, geometry: Mesh, is_support, material: guid}
    compas.datastructures/Mesh               {attributes, vertex: {key: {x, y, z}}, default_vertex_attributes,
                                              face: {key: [key, ...]}}

and classes derived from them. `inheritance` names the bases of a class; files of older versions have no such list, and
what an object holds tells there what it is (a `CRA_Assembly` of compas_cra or a `GridModel` of compas_grid). Models of
older versions list elements and materials instead of naming them by guid, and their meshes are the `shape` of a block.

Sources: `__data__` and `__jsondump__` of the classes in compas 2.15.1, compas_assembly 0.7.1, compas_model 0.9.3 and
compas_dem 0.6.0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import msgspec

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.system.faults import faults

ASSEMBLY = "compas_assembly.datastructures/Assembly"
MODEL = "compas_model.models/Model"
BLOCK_MODEL = "compas_dem.models/BlockModel"
PROBLEM = "compas_dem.problem/Problem"
ANALYSIS = "compas_dem.models/Analysis"
GROUP = "compas_model.elements/Group"
MESH = "compas.datastructures/Mesh"
#: What an object of each of these classes holds, whatever its own class.
HELD = {ASSEMBLY: {"graph"}, MODEL: {"elements", "tree", "graph"}, MESH: {"vertex", "face"}}
CELLS = "cell"  #: what a cell network holds beside what a mesh does

Kind = TypeVar("Kind", bound=msgspec.Struct)


class CompasObject(msgspec.Struct):
    """Any COMPAS object."""

    dtype: str
    data: dict[str, Any]
    name: str | None = None
    inheritance: list[str] | None = None  #: none in a file of an older version
    guid: str | None = None

    def is_a(self, *classes: str) -> bool:
        """Tell whether it is of one of these classes, or of one derived from them."""
        bases = self._bases() if self.inheritance is None else self.inheritance
        return any(name in classes for name in (self.dtype, *bases))

    def _bases(self) -> Iterator[str]:
        """The known classes that it may be derived from, where a file has no list of bases, by what it holds."""
        for base, keys in HELD.items():
            if keys <= self.data.keys() and CELLS not in self.data and (base != ASSEMBLY or self._has_blocks()):
                yield base

    def _has_blocks(self) -> bool:
        """Whether its graph has a block at every node: that of another object has not."""
        try:
            nodes = msgspec.convert(self.data["graph"], CompasObject).data.get("node")
        except msgspec.ValidationError:
            return False
        return isinstance(nodes, dict) and all(isinstance(own, dict) and "block" in own for own in nodes.values())


class Graph(msgspec.Struct):
    """A graph of nodes, with attributes of each."""

    node: dict[str, dict[str, Any]]
    attributes: dict[str, Any] = {}
    default_node_attributes: dict[str, Any] = {}
    edge: dict[str, dict[str, dict[str, Any]]] = {}


class AssemblyData(msgspec.Struct):
    """What an assembly holds."""

    graph: CompasObject
    attributes: dict[str, Any] = {}


class TreeNode(msgspec.Struct):
    """An element in the tree of a model, and those below it."""

    element: str | None = None
    children: list[TreeNode] = []


class Tree(msgspec.Struct):
    """The tree of the elements of a model."""

    root: TreeNode


class ModelData(msgspec.Struct):
    """What a model holds."""

    elements: dict[str, CompasObject]
    tree: Tree
    graph: Graph
    transformation: CompasObject | None = None
    materials: dict[str, CompasObject] = {}


class MeshData(msgspec.Struct):
    """What a mesh holds."""

    vertex: dict[str, dict[str, Any]]
    face: dict[str, list[int | str]]
    attributes: dict[str, Any] = {}
    default_vertex_attributes: dict[str, Any] = {}


@dataclass(frozen=True)
class CompasSolid:
    """A block before names are made distinct."""

    block: Block
    support: bool
    faces: tuple[str, ...]  #: keys of its faces in the mesh
    node: str | None = None  #: key of its node in the graph of a model


def model_data(found: CompasObject) -> ModelData:
    """Return what a model holds; lists of elements and materials, as in older versions, become tables by guid.

    Parameters
    ----------
    found : CompasObject
        The model.

    Returns
    -------
    ModelData

    Raises
    ------
    InputError
        Naming each key at fault.
    """
    data = dict(found.data)
    for key in ("elements", "materials"):
        if isinstance(data.get(key), list):
            objects = as_struct({"listed": data[key]}, _Listed, f"{found.dtype}: {key}").listed
            data[key] = {own.guid or f"{key} {i}": own for i, own in enumerate(objects)}
    made = as_struct(data, ModelData, found.dtype)
    for guid, material in (data.get("element_material") or {}).items():
        if guid in made.elements:
            made.elements[guid].data.setdefault("material", material)
    return made


class _Listed(msgspec.Struct):
    listed: list[CompasObject]


def as_struct(value: Any, kind: type[Kind], label: str) -> Kind:
    """Return a value of JSON as a structure.

    Parameters
    ----------
    value : object
        What the file holds.
    kind : type
        The structure.
    label : str
        What the value is of, for messages.

    Returns
    -------
    Struct
        Of this kind.

    Raises
    ------
    InputError
        Naming each key at fault.
    """
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError:
        raise InputError(*(f"{label}: {text}" for text in faults(kind, value))) from None
