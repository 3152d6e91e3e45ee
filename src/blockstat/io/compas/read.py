"""Read COMPAS 2 JSON: assemblies of compas_assembly, models of compas_model, problems and analyses of compas_dem.

An element stands where the transformations of the model, of its ancestors in the tree and its own put it; groups above
it make its group. Recorded interfaces are not read: `find_interfaces` finds them. `blockstat.io.compas.objects` says
how COMPAS writes its objects, and `blockstat.io.compas.problem` what is read of a problem.
"""

from __future__ import annotations

import warnings
from ast import literal_eval
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial, reduce
from typing import Any, TypeVar

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import InputError, InputWarning, gathered, some
from blockstat.io.compas.objects import (
    ANALYSIS,
    ASSEMBLY,
    BLOCK_MODEL,
    GROUP,
    MESH,
    MODEL,
    PROBLEM,
    AssemblyData,
    CompasObject,
    CompasSolid,
    Graph,
    MeshData,
    ModelData,
    TreeNode,
    as_struct,
    model_data,
)
from blockstat.io.compas.problem import problem_of
from blockstat.io.names import distinct_names
from blockstat.io.parts import Parts, chosen_supports, is_marked
from blockstat.typing import Floats

LISTED = "meshes"  #: in the place of the dtype of a list of meshes, which has none
OLD_KEYS = {"attributes", "dea"}  #: of a network or a mesh before COMPAS 2, which may say no dtype
EXACT = 1e-9  #: the last row of a matrix may be off by this, as inverses of COMPAS are
PARALLEL = 1e-9  #: axes of a frame span no plane when the sine of their angle is at most this; rounding leaves 1e-16


T = TypeVar("T")


def is_compas(data: Any) -> bool:
    """Tell whether JSON data are an object that COMPAS wrote, of any version.

    Parameters
    ----------
    data : object
        What a JSON file holds.

    Returns
    -------
    bool
    """
    if isinstance(data, list):
        listed = [*_listed(data)]
        return bool(listed) and all(
            isinstance(own, dict) and (isinstance(own.get("data"), dict) or _is_old(own)) for _, own in listed
        )
    return isinstance(data, dict) and (("dtype" in data and "blocks" not in data) or _is_old(data))


def _is_old(data: Any) -> bool:
    """Whether COMPAS 1 or an older version wrote an object: data by other names, or blocks in a table by number."""
    if not isinstance(data, dict):
        return False
    held = data.get("blocks")
    return (
        ("datatype" in data and held is None)
        or ("dtype" in data and "value" in data and "data" not in data)
        or OLD_KEYS <= data.keys()
        or (isinstance(held, dict) and any(isinstance(own, dict) and "vertex" in own for own in held.values()))
    )


def compas_parts(data: Any, name: str, *, supports: Iterable[int | str] | None = None) -> Parts:
    """Read an assembly, a model, a problem or an analysis of COMPAS, or a list of meshes or of such lists.

    Parameters
    ----------
    data : object
        What the JSON file holds; `is_compas` tells whether it can be read.
    name : str
        Of the assembly where the file has none.
    supports : iterable of int or str, optional
        Names or numbers of the blocks that cannot move, in place of those that the file marks.

    Returns
    -------
    Parts
        In the unit of the file. The loads of a problem are load cases of its metadata.

    Raises
    ------
    InputError
        Naming each block or key at fault, for a dtype that is not known, a transformation that is none of solids (a
        projection), a mark of a support that is no truth value, a problem that cannot be read in full, or without
        supports.

    Warns
    -----
    InputWarning
        Where a model has modifiers between elements, which are not applied, or blocks share a name; and for what of a
        problem is not applied.
    """
    if any(map(_is_old, (own for _, own in _listed(data)) if isinstance(data, list) else [data])):
        raise InputError("written by COMPAS 1 or an older version; load it in COMPAS 2 and save it again")
    if isinstance(data, list):
        data = {"dtype": LISTED, "data": {"meshes": data}}
    found = as_struct(data, CompasObject, "COMPAS object")
    problem = problem_of(found)
    made = found if problem is None else problem.model
    if made.is_a(ASSEMBLY):
        solids, said = _assembly_solids(as_struct(made.data, AssemblyData, made.dtype))
    elif made.is_a(MODEL, BLOCK_MODEL):
        solids, said = _model_solids(model_data(made))
    elif made.dtype == LISTED:
        solids, said = gathered(partial(_of_list, *own) for own in _listed(made.data["meshes"])), {}
    else:
        known = ", ".join((ASSEMBLY, MODEL, BLOCK_MODEL, PROBLEM, ANALYSIS))
        raise InputError(f'dtype is "{made.dtype}"; known are: {known} and their subclasses')
    marked = [i for i, s in enumerate(solids) if s.support]
    if problem is not None:
        said, marked = said | problem.said, sorted({*marked, *problem.supports(solids)})
    names = [solid.block.name for solid in solids]
    chosen = chosen_supports(marked, supports, names, "the file")
    blocks = [
        Block(s.block.vertices, s.block.faces, label, s.block.group, s.block.density)
        for s, label in zip(solids, distinct_names(names, chosen), strict=True)
    ]
    options = {key: said[key] for key in ("friction", "gravity") if key in said}
    if problem is not None:
        options["metadata"] = problem.load_tables(solids, [block.name for block in blocks], marked)
    return Parts(blocks, chosen, {"name": str(found.name or said.get("name") or name), **options})


def _assembly_solids(assembly: AssemblyData) -> tuple[list[CompasSolid], dict[str, Any]]:
    graph = as_struct(assembly.graph.data, Graph, "graph")
    solids = gathered(partial(_of_node, graph, key) for key in graph.node)
    return solids, assembly.attributes


def _listed(given: list[Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """What is in a list and in the lists in it, by number: "2", or "1.2" in the second list."""
    for number, own in enumerate(given):
        if isinstance(own, list):
            yield from _listed(own, f"{above}{number}.")
        else:
            yield f"{above}{number}", own


def _of_list(number: str, given: dict[str, Any]) -> CompasSolid:
    """A mesh in a list; those of older versions do not say that they are one."""
    label = f"mesh {number}"
    found = as_struct({"dtype": MESH, **given}, CompasObject, label)
    mesh = _mesh(found, label)
    return _solid(mesh, str(found.name or mesh.attributes.get("name") or ""), mesh.attributes, number)


def _of_node(graph: Graph, key: str) -> CompasSolid:
    own, label = graph.node[key], f"node {key}"
    block = as_struct(own.get("block"), CompasObject, f"{label}: block")
    mesh = _mesh(block, label)
    attributes = {**graph.default_node_attributes, **mesh.attributes, **own}
    return _solid(mesh, block.name or _key(key), attributes, key)


def _model_solids(model: ModelData) -> tuple[list[CompasSolid], dict[str, Any]]:
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
    node_of = {own.get("element"): key for key, own in model.graph.node.items()}
    for guid, solid in zip(blocks, solids, strict=True):
        chain = [*above[guid], guid]
        matrix = reduce(np.matmul, (own[k] for k in chain), origin)
        groups = (_name(model.elements[k]) for k in chain if model.elements[k].is_a(GROUP))
        placed.append(_placed(replace(solid, node=node_of.get(guid)), matrix, ".".join(filter(None, groups))))
    return placed, model.graph.attributes


def _of_element(model: ModelData, guid: str) -> CompasSolid:
    """The block of an element where its mesh has it."""
    element = model.elements[guid]
    label = _label(guid, element)
    geometry = element.data.get("geometry") or element.data.get("shape")
    if not isinstance(geometry, dict):
        raise InputError(f'{label}: a "{element.dtype}" stores no mesh; only blocks with a mesh are read')
    mesh = _mesh(as_struct(geometry, CompasObject, f"{label}: geometry"), label)
    made_of = element.data.get("material")
    if made_of and str(made_of) not in model.materials:
        raise InputError(f'{label}: no material "{made_of}" in the model')
    material = model.materials[str(made_of)] if made_of else None
    attributes = {**mesh.attributes, **(material.data if material else {}), **element.data}
    return _solid(mesh, _name(element), attributes, guid)


def _own_matrix(guid: str, element: CompasObject) -> tuple[str, Floats]:
    """An element and its transformation, without those of the elements above it."""
    label = _label(guid, element)
    given = element.data.get("transformation")
    return guid, _matrix(as_struct(given, CompasObject, f"{label}: transformation") if given else None, label)


def _ancestors(model: ModelData) -> dict[str, tuple[str, ...]]:
    """The elements above each element, from the root of the tree down."""
    found: dict[str, tuple[str, ...]] = {}
    unknown: list[str] = []
    pending: list[tuple[TreeNode, tuple[str, ...]]] = [(child, ()) for child in model.tree.root.children]
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


def _solid(mesh: MeshData, name: str, attributes: Mapping[str, Any], key: str) -> CompasSolid:
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
    return CompasSolid(block, is_marked(name or key, "is_support", attributes.get("is_support")), tuple(mesh.face))


def _placed(solid: CompasSolid, matrix: Floats, group: str) -> CompasSolid:
    """The same block elsewhere, in a group if it is named."""
    block = solid.block
    vertices = block.vertices
    if (matrix != np.eye(4)).any():
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    # A mirror image lists the corners of its faces the other way round.
    faces = [face[::-1] for face in block.faces] if np.linalg.det(matrix[:3, :3]) < 0 else block.faces
    return replace(solid, block=replace(block, vertices=vertices, faces=faces, group=group or block.group))


def _mesh(found: CompasObject, label: str) -> MeshData:
    if not found.is_a(MESH, "compas_assembly.datastructures/Block"):
        raise InputError(f'{label}: geometry is a "{found.dtype}"; only meshes ("{MESH}") are read')
    return as_struct(found.data, MeshData, label)


def _matrix(found: CompasObject | None, label: str) -> Floats:
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


def _name(element: CompasObject) -> str:
    return str(element.data.get("name") or element.name or "")


def _label(guid: str, element: CompasObject) -> str:
    return f'element "{_name(element) or guid}"'


def _key(key: str) -> str:
    """COMPAS writes the key of a node as Python would print it."""
    try:
        return str(literal_eval(key))
    except (ValueError, SyntaxError):
        return key
