"""COMPAS 2 JSON: assemblies of compas_assembly and models of compas_model (compas_dem's BlockModel is one).

COMPAS writes every object as {dtype: "package.module/Class", data, name?, guid?, inheritance?: [dtype]}. Of interest
here are

    compas_assembly.datastructures/Assembly  {attributes, graph: Graph of nodes {block: Mesh, is_support}}
    compas_model.models/Model                {transformation, elements: {guid: Element}, materials: {guid: Material},
                                              tree: {root: {element: guid, children: [...]}}, graph}
    an Element with a mesh                   {name, transformation, geometry: Mesh, is_support, material: guid}
    compas.datastructures/Mesh               {attributes, vertex: {key: {x, y, z}}, default_vertex_attributes,
                                              face: {key: [key, ...]}}

and classes derived from them. `inheritance` names the bases of a class; files of older versions have no such list, and
what an object holds tells there what it is (a `CRA_Assembly` of compas_cra or a `GridModel` of compas_grid). An element
stands where the transformations of the model, of its ancestors in the tree and its own put it; groups above it make its
group. Recorded interfaces are not read: `find_interfaces` finds them.

Sources: `__data__` and `__jsondump__` of the classes in compas 2.15.1, compas_assembly 0.7.1, compas_model 0.9.3 and
compas_dem 0.6.0.
"""

from __future__ import annotations

import warnings
from ast import literal_eval
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial, reduce
from typing import Any, TypeVar

import msgspec
import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, InputWarning, gathered, some
from blockstat.io.names import distinct_names
from blockstat.io.parts import Parts, chosen_supports, is_marked
from blockstat.system.faults import faults
from blockstat.typing import Floats

ASSEMBLY = "compas_assembly.datastructures/Assembly"
MODEL = "compas_model.models/Model"
BLOCK_MODEL = "compas_dem.models/BlockModel"
GROUP = "compas_model.elements/Group"
MESH = "compas.datastructures/Mesh"
#: What an object of each of these classes holds, whatever its own class.
HELD = {ASSEMBLY: {"graph"}, MODEL: {"elements", "tree", "graph"}, MESH: {"vertex", "face"}}
CELLS = "cell"  #: what a cell network holds beside what a mesh does
EXACT = 1e-9  #: the last row of a matrix may be off by this, as inverses of COMPAS are
PARALLEL = 1e-9  #: axes of a frame span no plane when the sine of their angle is at most this; rounding leaves 1e-16


class _Object(msgspec.Struct):
    """Any COMPAS object."""

    dtype: str
    data: dict[str, Any]
    name: str | None = None
    inheritance: list[str] | None = None  #: none in a file of an older version

    def is_a(self, *classes: str) -> bool:
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
            nodes = msgspec.convert(self.data["graph"], _Object).data.get("node")
        except msgspec.ValidationError:
            return False
        return isinstance(nodes, dict) and all(isinstance(own, dict) and "block" in own for own in nodes.values())


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
T = TypeVar("T")


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
        Naming each block or key at fault, for a dtype that is not known, a transformation that is none of solids (a
        projection), a mark of a support that is no truth value, or without supports.

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
    solids = gathered(partial(_of_node, graph, key) for key in graph.node)
    return solids, assembly.attributes


def _of_node(graph: _Graph, key: str) -> _Solid:
    own, label = graph.node[key], f"node {key}"
    block = _as(own.get("block"), _Object, f"{label}: block")
    mesh = _mesh(block, label)
    attributes = {**graph.default_node_attributes, **mesh.attributes, **own}
    return _solid(mesh, block.name or _key(key), attributes, key)


def _model_solids(model: _Model) -> tuple[list[_Solid], dict[str, Any]]:
    if any(pair.get("modifiers") for pairs in model.graph.edge.values() for pair in pairs.values()):
        warnings.warn(InputWarning("the modifiers between elements are not applied"), stacklevel=4)
    blocks = [guid for guid, element in model.elements.items() if not element.is_a(GROUP)]
    origin, own, solids, above = gathered(
        (
            partial(_matrix, model.transformation, "model"),
            lambda: dict(gathered(partial(_own_matrix, guid, element) for guid, element in model.elements.items())),
            lambda: gathered(partial(_of_element, model, guid) for guid in blocks),
            partial(_ancestors, model),
        )
    )
    placed = []
    for guid, solid in zip(blocks, solids, strict=True):
        chain = [*above[guid], guid]
        matrix = reduce(np.matmul, (own[k] for k in chain), origin)
        groups = (_name(model.elements[k]) for k in chain if model.elements[k].is_a(GROUP))
        placed.append(_placed(solid, matrix, ".".join(filter(None, groups))))
    return placed, model.graph.attributes


def _of_element(model: _Model, guid: str) -> _Solid:
    """The block of an element where its mesh has it."""
    element = model.elements[guid]
    label = _label(guid, element)
    if not isinstance(element.data.get("geometry"), dict):
        raise InputError(f'{label}: a "{element.dtype}" stores no mesh; only blocks with a mesh are read')
    mesh = _mesh(_as(element.data["geometry"], _Object, f"{label}: geometry"), label)
    made_of = element.data.get("material")
    if made_of and str(made_of) not in model.materials:
        raise InputError(f'{label}: no material "{made_of}" in the model')
    material = model.materials[str(made_of)] if made_of else None
    attributes = {**mesh.attributes, **(material.data if material else {}), **element.data}
    return _solid(mesh, _name(element), attributes, guid)


def _own_matrix(guid: str, element: _Object) -> tuple[str, Floats]:
    """An element and its transformation, without those of the elements above it."""
    label = _label(guid, element)
    given = element.data.get("transformation")
    return guid, _matrix(_as(given, _Object, f"{label}: transformation") if given else None, label)


def _ancestors(model: _Model) -> dict[str, tuple[str, ...]]:
    """The elements above each element, from the root of the tree down."""
    found: dict[str, tuple[str, ...]] = {}
    unknown: list[str] = []
    pending: list[tuple[_Node, tuple[str, ...]]] = [(child, ()) for child in model.tree.root.children]
    while pending:
        node, above = pending.pop()
        guid = str(node.element)
        if guid in model.elements:
            found[guid] = above
        else:
            unknown.append(f'tree: no element "{guid}"')
        pending += [(child, (*above, guid)) for child in node.children]
    # An element that the tree lacks is often the one that it names wrongly.
    lost = [
        f"{_label(guid, element)}: is not in the tree of the model"
        for guid, element in model.elements.items()
        if guid not in found and not element.is_a(GROUP)
    ]
    if wrong := unknown or lost:
        raise InputError(*wrong)
    return found


def _solid(mesh: _Mesh, name: str, attributes: Mapping[str, Any], key: str) -> _Solid:
    index = {key: i for i, key in enumerate(mesh.vertex)}
    origin = mesh.default_vertex_attributes
    wrong: dict[str, list[str]] = {}  # keys by what is wrong with them

    def read(kind: str, part: Mapping[str, T], convert: Callable[[T], list[Any]]) -> list[Any]:
        """The vertices or faces that can be read; the keys of the others go into `wrong`."""
        found = []
        for key, given in part.items():
            try:
                found.append(convert(given))
            except (KeyError, TypeError, ValueError, OverflowError) as error:
                wrong.setdefault(f"{error} ({kind} ", []).append(key)
        return found

    points = read("vertex", mesh.vertex, lambda own: [float((origin | own)[axis]) for axis in "xyz"])
    faces = read("face", mesh.face, lambda face: [index[str(corner)] for corner in face])
    if wrong:
        text = f'block "{name or key}": the mesh has a bad vertex or corner'
        raise InputError(*(f"{text}: {error}{some(keys)})" for error, keys in wrong.items()))
    vertices = np.array(points, dtype=float).reshape(-1, 3)
    block = Block(vertices, faces, name, str(attributes.get("group") or ""), attributes.get("density"))
    return _Solid(block, is_marked(name or key, "is_support", attributes.get("is_support")))


def _placed(solid: _Solid, matrix: Floats, group: str) -> _Solid:
    """The same block elsewhere, in a group if it is named."""
    block = solid.block
    vertices = block.vertices
    if (matrix != np.eye(4)).any():
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    # A mirror image lists the corners of its faces the other way round.
    faces = [face[::-1] for face in block.faces] if np.linalg.det(matrix[:3, :3]) < 0 else block.faces
    return _Solid(replace(block, vertices=vertices, faces=faces, group=group or block.group), solid.support)


def _mesh(found: _Object, label: str) -> _Mesh:
    if not found.is_a(MESH, "compas_assembly.datastructures/Block"):
        raise InputError(f'{label}: geometry is a "{found.dtype}"; only meshes ("{MESH}") are read')
    return _as(found.data, _Mesh, label)


def _matrix(found: _Object | None, label: str) -> Floats:
    """The 4 by 4 matrix of a transformation (any class: all store `matrix`) or of a frame."""
    if found is None:
        return np.eye(4)
    rows = ["matrix"] if "matrix" in found.data else ["point", "xaxis", "yaxis"]
    try:
        given = np.array([found.data[key] for key in rows], dtype=float)
    except (KeyError, TypeError, ValueError, OverflowError):
        given = np.empty(0)
    if given.shape == (3, 3) and np.isfinite(given).all():
        matrix = np.eye(4)
        matrix[:3, :3] = _frame_axes(given[1], given[2], f'{label}: transformation: a "{found.dtype}"')
        matrix[:3, 3] = given[0]
    else:
        matrix = given[0] if len(given) else given
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise InputError(f'{label}: a "{found.dtype}" is neither a 4 by 4 matrix nor a frame')
    if not np.allclose(matrix[3], (0, 0, 0, 1), rtol=0, atol=EXACT):
        raise InputError(f'{label}: the last row of a "{found.dtype}" is {matrix[3].tolist()}; it must be 0, 0, 0, 1')
    return matrix


def _frame_axes(x: Floats, y: Floats, label: str) -> Floats:
    """The unit axes x, y and z of a frame as columns: as when COMPAS reads it, z = x cross y and y = z cross x."""
    units: list[Floats] = []
    for key, given in (("xaxis", x), ("yaxis", y)):
        if not given.any():
            raise InputError(f"{label} has the {key} {given.tolist()}; an axis must have a length")
        large = given / np.abs(given).max()  # so that no square is out of range
        units.append(large / np.linalg.norm(large))
    normal: Floats = np.cross(units[0], units[1])
    sine = float(np.linalg.norm(normal))
    if sine <= PARALLEL:
        text = f"has the xaxis {x.tolist()} and the yaxis {y.tolist()}, which are parallel"
        raise InputError(f"{label} {text}; they must span a plane")
    axes = np.empty((3, 3))
    axes[:, 0], axes[:, 2] = units[0], normal / sine
    axes[:, 1] = np.cross(axes[:, 2], axes[:, 0])
    return axes


def _name(element: _Object) -> str:
    return str(element.data.get("name") or element.name or "")


def _label(guid: str, element: _Object) -> str:
    return f'element "{_name(element) or guid}"'


def _key(key: str) -> str:
    """COMPAS writes the key of a node as Python would print it."""
    try:
        return str(literal_eval(key))
    except (ValueError, SyntaxError):
        return key


def _as(value: Any, kind: type[Kind], label: str) -> Kind:
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError:
        raise InputError(*(f"{label}: {text}" for text in faults(kind, value))) from None
