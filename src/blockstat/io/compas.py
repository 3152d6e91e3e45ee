"""COMPAS 2 JSON: assemblies of compas_assembly and models of compas_model (compas_dem's BlockModel is one).

COMPAS writes every object as {dtype: "package.module/Class", data, name?, guid?, inheritance?: [dtype]}. Of interest
here are

    compas_assembly.datastructures/Assembly  {attributes, graph: Graph of nodes {block: Mesh, is_support}}
    compas_model.models/Model                {transformation, elements: {guid: Element}, materials: {guid: Material},
                                              tree: {root: {element: guid, children: [...]}}, graph}
    an Element with a mesh                   {name, transformation, geometry: Mesh, is_support, material: guid}
    compas.datastructures/Mesh               {attributes, vertex: {key: {x, y, z}}, default_vertex_attributes,
                                              face: {key: [key, ...]}}

and classes derived from them. An element stands where the transformations of the model, of its ancestors in the tree
and its own put it; groups above it make its group. Recorded interfaces are not read: `find_interfaces` finds them.

Sources: `__data__` and `__jsondump__` of the classes in compas 2.15.1, compas_assembly 0.7.1, compas_model 0.9.3 and
compas_dem 0.6.0.
"""

from __future__ import annotations

import warnings
from ast import literal_eval
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import msgspec
import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, InputWarning
from blockstat.io.names import distinct_names
from blockstat.io.parts import Parts, chosen_supports
from blockstat.typing import Floats

ASSEMBLY = "compas_assembly.datastructures/Assembly"
MODEL = "compas_model.models/Model"
BLOCK_MODEL = "compas_dem.models/BlockModel"
GROUP = "compas_model.elements/Group"
MESH = "compas.datastructures/Mesh"


class _Object(msgspec.Struct):
    """Any COMPAS object."""

    dtype: str
    data: dict[str, Any]
    name: str | None = None
    inheritance: list[str] = []

    def is_a(self, *classes: str) -> bool:
        return any(name in classes for name in (self.dtype, *self.inheritance))


class _Graph(msgspec.Struct):
    node: dict[str, dict[str, Any]]
    attributes: dict[str, Any] = {}
    default_node_attributes: dict[str, Any] = {}
    edge: dict[str, dict[str, dict[str, Any]]] = {}


class _Assembly(msgspec.Struct):
    graph: _Object
    attributes: dict[str, Any] = {}


class _Node(msgspec.Struct):
    element: str | None = None
    children: list[_Node] = []


class _Tree(msgspec.Struct):
    root: _Node


class _Model(msgspec.Struct):
    elements: dict[str, _Object]
    tree: _Tree
    graph: _Graph
    transformation: _Object | None = None
    materials: dict[str, _Object] = {}


class _Mesh(msgspec.Struct):
    vertex: dict[str, dict[str, Any]]
    face: dict[str, list[int | str]]
    attributes: dict[str, Any] = {}
    default_vertex_attributes: dict[str, Any] = {}


class _Solid(msgspec.Struct):
    """A block before names are made distinct."""

    block: Block
    support: bool


Kind = TypeVar("Kind", bound=msgspec.Struct)


def is_compas(data: Any) -> bool:
    """Tell whether JSON data are an object that COMPAS wrote.

    Parameters
    ----------
    data : object
        What a JSON file holds.

    Returns
    -------
    bool
    """
    return isinstance(data, dict) and "dtype" in data and "blocks" not in data


def compas_parts(data: dict[str, Any], name: str, *, supports: Iterable[int | str] | None = None) -> Parts:
    """Read an assembly or a model of COMPAS.

    Parameters
    ----------
    data : dict
        What the JSON file holds.
    name : str
        Of the assembly where the file has none.
    supports : iterable of int or str, optional
        Names or numbers of the blocks that cannot move, in place of those that the file marks.

    Returns
    -------
    Parts
        In the unit of the file.

    Raises
    ------
    InputError
        Naming the block or the key at fault, for a dtype that is not known, or without supports.

    Warns
    -----
    InputWarning
        Where a model has modifiers between elements, which are not applied, or blocks share a name.
    """
    if "value" in data and "data" not in data:
        raise InputError("written by COMPAS 1; load it in COMPAS 2 and save it again")
    found = _as(data, _Object, "COMPAS object")
    if found.is_a(ASSEMBLY):
        solids, said = _assembly_solids(_as(found.data, _Assembly, found.dtype))
    elif found.is_a(MODEL, BLOCK_MODEL):
        solids, said = _model_solids(_as(found.data, _Model, found.dtype))
    else:
        raise InputError(
            f'dtype is "{found.dtype}"; known are: {ASSEMBLY}, {MODEL}, {BLOCK_MODEL} and their subclasses'
        )
    names = [solid.block.name for solid in solids]
    chosen = chosen_supports([i for i, s in enumerate(solids) if s.support], supports, names, "the file")
    blocks = [
        Block(s.block.vertices, s.block.faces, label, s.block.group, s.block.density)
        for s, label in zip(solids, distinct_names(names, chosen), strict=True)
    ]
    options = {key: said[key] for key in ("friction", "gravity") if key in said}
    return Parts(blocks, chosen, {"name": str(found.name or said.get("name") or name), **options})


def _assembly_solids(assembly: _Assembly) -> tuple[list[_Solid], dict[str, Any]]:
    graph = _as(assembly.graph.data, _Graph, "graph")
    solids = []
    for key, own in graph.node.items():
        label = f"node {key}"
        block = _as(own.get("block"), _Object, f"{label}: block")
        mesh = _mesh(block, label)
        attributes = {**graph.default_node_attributes, **mesh.attributes, **own}
        solids.append(_solid(mesh, block.name or _key(key), np.eye(4), attributes))
    return solids, assembly.attributes


def _model_solids(model: _Model) -> tuple[list[_Solid], dict[str, Any]]:
    if any(pair.get("modifiers") for pairs in model.graph.edge.values() for pair in pairs.values()):
        warnings.warn(InputWarning("the modifiers between elements are not applied"), stacklevel=4)
    places: dict[str, tuple[Floats, str]] = {}
    _place(model, model.tree.root, _matrix(model.transformation, "model"), "", places)
    solids = []
    for guid, element in model.elements.items():
        if element.is_a(GROUP):
            continue
        label = f'element "{_name(element)}"'
        if not isinstance(element.data.get("geometry"), dict):
            raise InputError(f'{label}: a "{element.dtype}" stores no mesh; only blocks with a mesh are read')
        if guid not in places:
            raise InputError(f"{label}: is not in the tree of the model")
        mesh = _mesh(_as(element.data["geometry"], _Object, f"{label}: geometry"), label)
        matrix, group = places[guid]
        material = model.materials.get(element.data.get("material") or "")
        attributes = {**mesh.attributes, **(material.data if material else {}), **element.data}
        attributes |= {"group": group} if group else {}
        solids.append(_solid(mesh, _name(element), matrix, attributes))
    return solids, model.graph.attributes


def _place(model: _Model, node: _Node, matrix: Floats, group: str, places: dict[str, tuple[Floats, str]]) -> None:
    """Where the elements below a node of the tree stand, and the groups they belong to."""
    for child in node.children:
        if child.element not in model.elements:
            raise InputError(f'tree: no element "{child.element}"')
        element = model.elements[child.element]
        own = (
            _as(element.data["transformation"], _Object, f'element "{_name(element)}": transformation')
            if element.data.get("transformation")
            else None
        )
        there = matrix @ _matrix(own, f'element "{_name(element)}"')
        places[child.element] = there, group
        inner = ".".join(filter(None, (group, _name(element)))) if element.is_a(GROUP) else group
        _place(model, child, there, inner, places)


def _solid(mesh: _Mesh, name: str, matrix: Floats, attributes: Mapping[str, Any]) -> _Solid:
    index = {key: i for i, key in enumerate(mesh.vertex)}
    origin = mesh.default_vertex_attributes
    try:
        points = [[float((origin | own)[axis]) for axis in "xyz"] for own in mesh.vertex.values()]
        faces = [[index[str(corner)] for corner in face] for face in mesh.face.values()]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f'block "{name}": the mesh has a bad vertex or corner: {error}') from None
    vertices = np.array(points, dtype=float).reshape(-1, 3)
    if (matrix != np.eye(4)).any():
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    block = Block(vertices, faces, name, str(attributes.get("group") or ""), attributes.get("density"))
    return _Solid(block, bool(attributes.get("is_support")))


def _mesh(found: _Object, label: str) -> _Mesh:
    if not found.is_a(MESH, "compas_assembly.datastructures/Block"):
        raise InputError(f'{label}: geometry is a "{found.dtype}"; only meshes ("{MESH}") are read')
    return _as(found.data, _Mesh, label)


def _matrix(found: _Object | None, label: str) -> Floats:
    """The 4 by 4 matrix of a transformation (any class: all store `matrix`) or of a frame."""
    if found is None:
        return np.eye(4)
    try:
        if "matrix" in found.data:
            matrix = np.array(found.data["matrix"], dtype=float)
        else:
            point, x, y = (np.array(found.data[key], dtype=float) for key in ("point", "xaxis", "yaxis"))
            z = np.cross(x, y)
            matrix = np.eye(4)
            matrix[:3] = np.column_stack([x, np.cross(z / np.linalg.norm(z), x), z / np.linalg.norm(z), point])
        if matrix.shape == (4, 4) and np.isfinite(matrix).all():
            return matrix
    except (KeyError, TypeError, ValueError):
        pass
    raise InputError(f'{label}: a "{found.dtype}" is neither a 4 by 4 matrix nor a frame')


def _name(element: _Object) -> str:
    return str(element.data.get("name") or element.name or "")


def _key(key: str) -> str:
    """COMPAS writes the key of a node as Python would print it."""
    try:
        return str(literal_eval(key))
    except (ValueError, SyntaxError):
        return key


def _as(value: Any, kind: type[Kind], label: str) -> Kind:
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise InputError(f"{label}: {str(error).replace(' - at `$', ' at `')}") from None
