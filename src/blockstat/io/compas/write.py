"""Write COMPAS 2 JSON, as `blockstat.io.compas.objects` describes it.

Names, supports and groups are where COMPAS has them. Densities are materials of a model; COMPAS has no place for
densities in an assembly, nor for friction and gravity, so these are attributes of the meshes and of the graph, which
COMPAS keeps. Joints are interfaces of compas_assembly or contacts of compas_dem at the edges of the graph.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import NAMESPACE_OID, uuid5

import numpy as np

from blockstat.io.compas.objects import ASSEMBLY, BLOCK_MODEL, GROUP, MESH, MODEL

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
from blockstat.io.parts import friction_said

INTERFACE = "compas_assembly.datastructures/Interface"
CONTACT = "compas_dem.interactions/FrictionContact"


@dataclass(frozen=True)
class CompasJoint:
    """A joint with its forces, as COMPAS stores it."""

    blocks: tuple[int, int]  #: numbers of the two blocks; the z axis points from the first to the second
    points: list[list[float]]  #: shape (n, 3) [m]
    frame: list[list[float]]  #: rows z, x and y
    area: float  #: [m2]
    forces: list[dict[str, float]]  #: one {"c_np", "c_nn", "c_u", "c_v"} a point [N]

    def as_data(self, dtype: str) -> dict[str, Any]:
        """Return the joint as an object of COMPAS.

        Parameters
        ----------
        dtype : str
            Its class.

        Returns
        -------
        dict
            An interface of compas_assembly or a contact of compas_dem.
        """
        centre = np.mean(self.points, axis=0).tolist()
        frame = {"point": centre, "xaxis": self.frame[1], "yaxis": self.frame[2]}
        data = {
            "points": self.points,
            "frame": {"dtype": "compas.geometry/Frame", "data": frame},
            "size": self.area,
            "mesh": None,
            "forces": self.forces,
        }
        return {"dtype": dtype, "data": data if dtype == INTERFACE else data | {"holes": None, "name": None}}


def write_compas(
    assembly: Assembly,
    path: Path,
    format: str,
    *,
    joints: Sequence[CompasJoint] = (),
    attributes: Mapping[str, Any] | None = None,
    motion: Sequence[Sequence[float]] | None = None,
) -> None:
    """Write an assembly of compas_assembly or a block model of compas_dem.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    path : Path
        The file.
    format : {"compas-assembly", "compas-model"}
        Which of the two.
    joints : sequence of CompasJoint, optional
        Joints with their forces.
    attributes : mapping, optional
        Further attributes of the assembly, or of the graph of the model.
    motion : sequence of sequence of float, shape (n_blocks, 6), optional
        The displacement of each block [m, rad], an attribute of its node.
    """
    make, key, dtype = {
        "compas-assembly": (_assembly, "interfaces", INTERFACE),
        "compas-model": (_model, "contacts", CONTACT),
    }[format]
    data = make(assembly, dict(attributes or {}))
    graph = data["data"]["graph"]
    graph = graph["data"] if format == "compas-assembly" else graph
    for joint in joints:
        a, b = map(str, joint.blocks)
        graph["edge"][a].setdefault(b, {key: []})[key].append(joint.as_data(dtype))
    for node, moved in enumerate(motion or ()):
        graph["node"][str(node)]["displacement"] = list(moved)
    path.write_text(json.dumps(data), encoding="utf-8")


def _assembly(assembly: Assembly, attributes: dict[str, Any]) -> dict[str, Any]:
    nodes: dict[str, Any] = {}
    for i, name in enumerate(assembly.names):
        own = {"density": float(assembly.density[i]), "group": assembly.groups[i], "node": i}
        block = _mesh(assembly, i, own, dtype="compas_assembly.datastructures/Block") | {
            "name": name,
            "inheritance": [MESH],
        }
        nodes[str(i)] = {"block": block, "is_support": bool(assembly.support[i])}
    graph = _graph(nodes, {"block": None, "is_support": False}, {"interfaces": None})
    data = {
        "attributes": {"name": assembly.name, **_shared(assembly), **attributes},
        "graph": _object("compas.datastructures/Graph", graph, assembly.name, "graph") | {"inheritance": []},
    }
    return _object(ASSEMBLY, data, assembly.name, "assembly") | {"inheritance": [], "name": assembly.name}


def _model(assembly: Assembly, attributes: dict[str, Any]) -> dict[str, Any]:
    materials = {
        float(value): _object(
            "compas_dem.material/GenericMaterial",
            {"name": f"{value:g} kg/m3", "fck": None, "ft": None, "Ecm": None, "density": float(value), "poisson": 0.2},
            assembly.name,
            f"material {value!r}",
        )
        for value in np.unique(assembly.density)
    }
    root: dict[str, Any] = {"name": "root", "children": []}
    elements: dict[str, Any] = {}
    folders = {"": root}
    for i, name in enumerate(assembly.names):
        data = _element(name) | {
            "material": materials[float(assembly.density[i])]["guid"],
            "geometry": _mesh(assembly, i, {}, dtype=MESH) | {"inheritance": []},
            "is_support": bool(assembly.support[i]),
        }
        element = _object("compas_dem.elements/Block", data, assembly.name, f"element {i}") | {"name": name}
        folder = _folder(assembly, assembly.groups[i], folders, elements)
        elements[element["guid"]] = element
        folder["children"].append({"name": "ElementNode", "element": element["guid"]})
    # The nodes of the blocks come first, in their order; joints name them by number.
    ordered = sorted(elements, key=lambda guid: elements[guid]["dtype"] == GROUP)
    nodes = {str(i): {"element": guid} for i, guid in enumerate(ordered)}
    data = {
        "transformation": None,
        "elements": elements,
        "materials": {material["guid"]: material for material in materials.values()},
        "tree": {"attributes": {}, "root": root},
        "graph": _graph(
            nodes, {"element": None}, {"modifiers": None, "contacts": None}, _shared(assembly) | attributes
        ),
    }
    return _object(BLOCK_MODEL, data, assembly.name, "model") | {"inheritance": [MODEL], "name": assembly.name}


def _folder(assembly: Assembly, group: str, folders: dict[str, Any], elements: dict[str, Any]) -> dict[str, Any]:
    """The node of the tree that a group's blocks hang from; "wall.north" hangs from "wall"."""
    if group not in folders:
        parent, _, name = group.rpartition(".")
        above = _folder(assembly, parent, folders, elements)
        element = _object(GROUP, _element(name) | {"material": None}, assembly.name, f"group {group}")
        elements[element["guid"]] = element | {"name": name}
        folders[group] = {"name": "ElementNode", "element": element["guid"], "children": []}
        above["children"].append(folders[group])
    return folders[group]


def _element(name: str) -> dict[str, Any]:
    return {"transformation": None, "features": [], "name": name}


def _graph(nodes: Any, node_attributes: Any, edge_attributes: Any, attributes: Any = None) -> dict[str, Any]:
    return {
        "attributes": attributes or {},
        "default_node_attributes": {"x": 0.0, "y": 0.0, "z": 0.0, **node_attributes},
        "default_edge_attributes": edge_attributes,
        "node": nodes,
        "edge": {key: {} for key in nodes},
        "max_node": len(nodes) - 1,
    }


def _mesh(assembly: Assembly, block: int, attributes: dict[str, Any], dtype: str) -> dict[str, Any]:
    vertices, faces = assembly.block_vertices(block).tolist(), assembly.faces_of(block)
    data = {
        "attributes": attributes,
        "default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0},
        "default_edge_attributes": {},
        "default_face_attributes": {},
        "vertex": {str(k): dict(zip("xyz", point, strict=True)) for k, point in enumerate(vertices)},
        "face": {str(k): face.tolist() for k, face in enumerate(faces)},
        "facedata": {},
        "edgedata": {},
        "max_vertex": len(vertices) - 1,
        "max_face": len(faces) - 1,
    }
    return _object(dtype, data, assembly.name, f"mesh {block}")


def _object(dtype: str, data: dict[str, Any], name: str, part: str) -> dict[str, Any]:
    """An object with an identifier that is the same whenever the same assembly is written."""
    return {"dtype": dtype, "data": data, "guid": str(uuid5(NAMESPACE_OID, f"blockstat/{name}/{part}"))}


def _shared(assembly: Assembly) -> dict[str, Any]:
    return {"friction": friction_said(assembly.friction), "gravity": assembly.gravity.tolist()}
