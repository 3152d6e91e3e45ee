"""Blocks, supports and recorded joints of a COMPAS object in memory.

An assembly of compas_assembly has its blocks at the nodes of a graph and its joints at the edges, as lists named
"interfaces". A model of compas_model has elements, and its joints at the edges of its graph, as lists named "contacts".
A problem of compas_dem holds a model and loads. Both kinds of joints have points, and a frame whose z axis is the
normal and points from node u to node v of the edge (u, v).

Sources: `compas_assembly.datastructures.Assembly`, `compas_model.models.Model`, `compas_cra.equilibrium.cra_helper`
(the signs) and `compas_model.algorithms.contacts` (the direction of frames), in the versions that
`blockstat.io.compas.objects` names.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from blockstat.assembly import DENSITY, Assembly, Block
from blockstat.contact.features import ContactKind
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError, gathered, known_options
from blockstat.io.names import distinct_names
from blockstat.io.parts import chosen_supports, is_marked, with_friction
from blockstat.typing import Floats, Ints

#: Kinds of joints by their number of points.
KINDS = {1: ContactKind.CORNER, 2: ContactKind.EDGE}
#: How far the points of a joint may lie outside the box of either block, relative to the smaller one: the largest gap
#: of a joint that a search takes.
FARTHEST = 0.2


@dataclass(frozen=True)
class Source:
    """A COMPAS object as this room sees it."""

    made: Any  #: the assembly or the model itself
    nodes: list[Any]  #: node of the graph of each block
    meshes: list[Any]
    #: name, group, density and is_support of each block, and of elements whether they are mirrored
    marks: list[dict[str, Any]]
    said: dict[str, Any]  #: the friction and the gravity that the object states
    key: str  #: the attribute of an edge that lists its joints

    @property
    def graph(self) -> Any:
        """The graph whose edges have the joints."""
        return self.made.graph

    def joints(self) -> Iterator[tuple[Any, Any, Any]]:
        """Yield node u, node v and the joint itself, in the order of the edges."""
        for u, v in self.graph.edges():
            for joint in self.graph.edge_attribute((u, v), self.key) or ():
                yield u, v, joint


def source_of(thing: Any) -> Source:
    """Tell what a COMPAS object is, and list its blocks.

    Parameters
    ----------
    thing : Assembly of compas_assembly, or Model of compas_model
        The object; subclasses such as `CRA_Assembly` and `BlockModel` are read, too.

    Returns
    -------
    Source
        Its blocks in its own order.

    Raises
    ------
    InputError
        For another object, or an element without a mesh.
    """
    if hasattr(thing, "node_block"):
        nodes = list(thing.graph.nodes())
        meshes = [thing.node_block(node) for node in nodes]
        marks = []
        for node, mesh in zip(nodes, meshes, strict=True):
            own = {**thing.graph.default_node_attributes, **mesh.attributes, **thing.graph.node[node]}
            marks.append({**_marks(own), "name": str(getattr(mesh, "_name", None) or node)})
        return Source(thing, nodes, meshes, marks, _said(thing.attributes), "interfaces")
    if hasattr(thing, "elements") and hasattr(thing, "graph"):
        elements = [element for element in thing.elements() if type(element).__name__ != "Group"]
        meshes = [element.modelgeometry for element in elements]
        for element, mesh in zip(elements, meshes, strict=True):
            if not hasattr(mesh, "to_vertices_and_faces"):
                kind = type(mesh).__name__
                raise InputError(
                    f'element "{_name_of(element)}": its geometry is a {kind}; only blocks with a mesh are read'
                )
        marks = [_marks_of_element(element, mesh) for element, mesh in zip(elements, meshes, strict=True)]
        nodes, said = [element.graphnode for element in elements], _said(thing.graph.attributes)
        return Source(thing, nodes, meshes, marks, said, "contacts")
    raise InputError(
        f"a {type(thing).__name__} is neither an Assembly of compas_assembly, a Model of compas_model "
        "nor a Problem of compas_dem"
    )


def _marks(attributes: dict[str, Any]) -> dict[str, Any]:
    return {
        "group": str(attributes.get("group") or ""),
        "density": attributes.get("density"),
        "is_support": attributes.get("is_support"),
    }


def _said(attributes: dict[str, Any]) -> dict[str, Any]:
    said: dict[str, Any] = with_friction({key: attributes.get(key) for key in ("friction", "gravity")})
    return {key: value for key, value in said.items() if value is not None}


def _name_of(element: Any) -> str:
    return str(element._name or f"block{element.graphnode}")


def _marks_of_element(element: Any, mesh: Any) -> dict[str, Any]:
    """What an element says, and its mesh where it says nothing, as in a file."""
    groups, parent = [], element.parent
    while parent:
        if type(parent).__name__ == "Group" and parent._name:
            groups.insert(0, str(parent._name))
        parent = parent.parent
    own = {"density": getattr(element.material, "density", None), "is_support": getattr(element, "is_support", None)}
    marks = {**_marks(mesh.attributes), **{key: value for key, value in own.items() if value is not None}}
    placed = getattr(element, "modeltransformation", None)
    mirrored = placed is not None and float(np.linalg.det(np.array(placed.matrix, dtype=float)[:3, :3])) < 0
    named = {"name": _name_of(element), "group": ".".join(groups) or marks["group"], "mirrored": mirrored}
    return {**marks, **named}


@known_options
def from_compas(
    thing: Any,
    *,
    supports: Iterable[int | str] | None = None,
    density: float = DENSITY,
    friction: float | None = None,
    gravity: Any = None,
) -> Assembly:
    """Read a COMPAS object in memory; every function of blockstat takes what this returns.

    Parameters
    ----------
    thing : Assembly of compas_assembly, or Model of compas_model
        The object, in metres and with z up; subclasses such as `CRA_Assembly` and `BlockModel` are read, too.
    supports : iterable of int or str, optional
        Names or numbers of the blocks that cannot move, in place of those that the object marks.
    density : float, optional
        Of the blocks that have none of their own [kg/m3].
    friction : float, optional
        Coefficient of friction of all joints; by default the attribute "friction" of the object, or 0.7.
    gravity : sequence of float, shape (3,), optional
        [m/s2]; by default the attribute "gravity" of the object, or 9.81 downwards.

    Returns
    -------
    blockstat.Assembly
        The blocks in the order of the object. Its joints are not read: `blockstat.find_interfaces` finds all of them.

    Raises
    ------
    InputError
        For another object, an element without a mesh, no supports, or a block that is no closed solid.

    Examples
    --------
    ::

        import compas, blockstat
        from blockstat.compas import from_compas

        arch = from_compas(compas.json_load("arch.json"), friction=0.7)
        print(blockstat.limit_load(arch, (1, 0, 0)).explain())
    """
    return assembly_of(source_of(thing), supports=supports, density=density, friction=friction, gravity=gravity)


def assembly_of(source: Source, *, supports: Iterable[int | str] | None = None, **options: Any) -> Assembly:
    """Return the blocks of a source as an assembly.

    Parameters
    ----------
    source : Source
        The COMPAS object.
    supports : iterable of int or str, optional
        In place of those that the object marks.
    **options
        Keyword arguments of `Assembly.from_blocks`; None for what the object says.

    Returns
    -------
    blockstat.Assembly
        The blocks in the order of the source.
    """
    given = [mark["name"] for mark in source.marks]
    marks = gathered(partial(is_marked, mark["name"], "is_support", mark["is_support"]) for mark in source.marks)
    marked = [i for i, mark in enumerate(marks) if mark]
    chosen = chosen_supports(marked, supports, given, "the COMPAS object")
    names = distinct_names(given, chosen)
    blocks = []
    for mesh, mark, name in zip(source.meshes, source.marks, names, strict=True):
        vertices, faces = mesh.to_vertices_and_faces()
        if mark.get("mirrored"):  # its faces list their corners the other way round
            faces = [face[::-1] for face in faces]
        blocks.append(Block(vertices, faces, name, mark["group"], mark["density"]))
    said = source.said | {key: value for key, value in options.items() if value is not None}
    return Assembly.from_blocks(blocks, supports=chosen, name=str(source.made.name or "assembly"), **said)


@dataclass(frozen=True, eq=False)
class Recorded:
    """The joints that a COMPAS object holds itself."""

    joints: list[tuple[Any, Any, Any]]  #: nodes u and v, and the joint, as in `Source.joints`
    interfaces: Interfaces
    axes: Floats  #: shape (n, 3, 3), rows z, x and y of the frame of each joint
    onto: np.ndarray  #: shape (n,), 1 where z points into block b of the pair, -1 where it points into block a


def recorded_joints(source: Source, assembly: Assembly) -> Recorded | None:
    """Return the joints that a COMPAS object holds, as interfaces of its blocks.

    Parameters
    ----------
    source : Source
        The COMPAS object.
    assembly : blockstat.Assembly
        Its blocks, from `assembly_of`.

    Returns
    -------
    Recorded or None
        None if it holds no joints. Those between two supports are left out, for they carry nothing that matters.

    Raises
    ------
    InputError
        For an edge to a node without a block or from a node to itself, a joint without points or frame or elsewhere
        than between its blocks, or a frame that points from v to u on the edge (u, v).
    """
    index = {node: i for i, node in enumerate(source.nodes)}
    joints = list(source.joints())
    for node in (node for u, v, _ in joints for node in (u, v)):
        if node not in index:
            raise InputError(f"a joint ends at node {node!r}, which has no block")
    joints = [own for own in joints if not assembly.support[[index[own[0]], index[own[1]]]].all()]
    if not joints:
        return None
    uv = np.array([[index[u], index[v]] for u, v, _ in joints])
    for u, v, joint in joints:
        if u == v or not len(joint.points) or joint.frame is None:
            lacks = "a second node" if u == v else "a frame" if len(joint.points) else "points"
            raise InputError(f"a joint on the edge ({u}, {v}) lacks {lacks}")
    points = [np.array([list(point) for point in joint.points], dtype=float) for _, _, joint in joints]
    axes = np.array([[list(axis) for axis in _axes(joint.frame)] for _, _, joint in joints], dtype=float)
    for (u, v, _), pair, own, (normal, *_) in zip(joints, uv, points, axes, strict=True):
        _check_place(assembly, pair, own, f"({u}, {v})")
        _check_direction(assembly, int(pair[0]), own, normal, f"({u}, {v})")
    onto = np.where(uv[:, 0] < uv[:, 1], 1, -1)
    # Turned about, a frame (z, x, y) is right-handed as (-z, y, x).
    frame = np.where(onto[:, None, None] > 0, axes, axes[:, [0, 2, 1]] * np.array([-1.0, 1.0, 1.0])[:, None])
    interfaces = Interfaces(
        pair=np.sort(uv, axis=1),
        frame=frame,
        area=np.array([_area(own) for own in points]),
        gap=np.zeros(len(joints)),
        point=np.concatenate(points),
        start=np.concatenate([[0], np.cumsum([len(own) for own in points])]),
        kind=_kinds(points),
    )
    return Recorded(joints, interfaces, axes, onto)


def _axes(frame: Any) -> tuple[Any, Any, Any]:
    return frame.zaxis, frame.xaxis, frame.yaxis


def _kinds(points: list[Floats]) -> Ints:
    return np.array([KINDS.get(len(own), ContactKind.FACE) for own in points], dtype=np.int64)


def _area(points: Floats) -> float:
    """Of a plane polygon [m2]; zero for an edge or a corner."""
    arms = points - points[0]
    return float(np.linalg.norm(np.cross(arms[:-1], arms[1:]).sum(axis=0)) / 2)


def _check_place(assembly: Assembly, pair: Ints, points: Floats, label: str) -> None:
    """Raise InputError where points of a joint are not between its two blocks."""
    reach = FARTHEST * assembly.size[pair].min()
    lower, upper = (bound[pair][:, None] for bound in assembly.bounds)
    if not ((points >= lower - reach) & (points <= upper + reach)).all():
        raise InputError(f"the points of a joint on the edge {label} are not between the two blocks")


def _check_direction(assembly: Assembly, block: int, points: Floats, normal: Floats, label: str) -> None:
    """Raise InputError where all of block u lies on the side that the normal of the edge (u, v) points to."""
    height = (assembly.block_vertices(block) - points.mean(axis=0)) @ normal
    reach = np.ptp(height)
    if height.min() > -1e-3 * reach and height.max() > 1e-3 * reach:
        raise InputError(
            f"the frame of a joint on the edge {label} points from {label[1:-1].split(', ')[1]} to "
            f"{label[1:-1].split(', ')[0]}; its z axis must point the other way"
        )
