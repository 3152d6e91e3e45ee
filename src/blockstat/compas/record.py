"""Write forces, motions and verdicts where the COMPAS packages have them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.compas.objects import Recorded, Source
from blockstat.errors import InputError
from blockstat.io.compas.write import CompasJoint
from blockstat.typing import Floats

#: Names of the components in COMPAS: compression, tension, along x and along y.
COMPONENTS: tuple[str, ...] = ("c_np", "c_nn", "c_u", "c_v")

#: How far the fastest corner moves in a motion that is written [m].
MOTION = 0.1


def record(source: Source, verdict: Verdict, recorded: Recorded | None, *, motion: float | None) -> None:
    """Write the forces, the motion and the verdict on an assembly or a model.

    Parameters
    ----------
    source : Source
        The COMPAS object.
    verdict : Verdict
        On the blocks of the source.
    recorded : Recorded or None
        The joints of the source; None writes those of the verdict in their place.
    motion : float or None
        Factor on the motion of the verdict, whose fastest corner moves by 1 m; None writes no motion.
    """
    if recorded is None:
        _replace_joints(source, verdict)
    else:
        for (u, v, joint), forces in zip(recorded.joints, _components(verdict, recorded), strict=True):
            _with_forces(source, u, v, joint, forces)
    if motion is not None:
        for node, support, moved in zip(
            source.nodes, verdict.assembly.support, motion_of(verdict, motion), strict=True
        ):
            if not support:
                source.graph.node_attribute(node, "displacement", moved.tolist())
    attributes = source.made.attributes if source.key == "interfaces" else source.graph.attributes
    attributes["verdict"] = verdict.summary()


def joints_of(verdict: Verdict) -> list[CompasJoint]:
    """Return the joints of a verdict with their forces, as COMPAS stores them.

    Parameters
    ----------
    verdict : Verdict
        The verdict.

    Returns
    -------
    list of CompasJoint
        One an interface.
    """
    joints = verdict.interfaces
    return [
        CompasJoint(
            blocks=(int(joints.pair[k, 0]), int(joints.pair[k, 1])),
            points=joints.point[joints.start[k] : joints.start[k + 1]].tolist(),
            frame=joints.frame[k].tolist(),
            area=float(joints.area[k]),
            forces=forces,
        )
        for k, forces in enumerate(_components(verdict, None))
    ]


def motion_of(verdict: Verdict, factor: float) -> Floats:
    """Return the mechanism of an unstable assembly, or the displacement of a Coulomb state.

    Parameters
    ----------
    verdict : Verdict
        The verdict, whose fastest corner moves by 1 m.
    factor : float
        How far it is to move [m].

    Returns
    -------
    array of float, shape (n_blocks, 6)
        Translation [m] and rotation [rad] of each block about its centroid; zero where neither exists.
    """
    moved = verdict.mechanism if verdict.outcome is Outcome.UNSTABLE else verdict.displacement
    return np.zeros((verdict.assembly.n_blocks, 6)) if moved is None else factor * moved


def _components(verdict: Verdict, recorded: Recorded | None) -> list[list[dict[str, float]]]:
    """Forces of each joint, one dictionary a point, along the axes of its own frame and on the block z points into."""
    joints = verdict.interfaces
    k = joints.point_interface
    world = np.einsum("pi,pij->pj", verdict.forces, joints.frame[k])
    if recorded is None:
        local = verdict.forces
    else:
        local = np.einsum("pij,pj->pi", recorded.axes[k], world) * recorded.onto[k][:, None]
    tension = np.zeros(len(local)) if verdict.outcome is Outcome.STABLE else verdict.adhesion
    normal = local[:, 0] - tension
    parts = np.column_stack([np.maximum(normal, 0.0), np.maximum(-normal, 0.0), local[:, 1:]]).tolist()
    rows = [dict[str, float](zip(COMPONENTS, row, strict=True)) for row in parts]
    return [rows[first:last] for first, last in zip(joints.start[:-1], joints.start[1:], strict=True)]


def _with_forces(source: Source, u: Any, v: Any, joint: Any, forces: list[dict[str, float]]) -> Any:
    """The joint with its forces; a contact of compas_model, which has no place for them, becomes one of compas_dem."""
    if hasattr(joint, "forces"):
        joint.forces = forces
        return joint
    made = _friction_contact(points=joint.points, frame=joint.frame, size=joint.size, forces=forces)
    contacts = source.graph.edge_attribute((u, v), source.key)
    contacts[next(i for i, own in enumerate(contacts) if own is joint)] = made
    return made


def _replace_joints(source: Source, verdict: Verdict) -> None:
    """Put the joints of a verdict, with their forces, in the place of all that the graph has."""
    graph = source.graph
    for edge in list(graph.edges()):
        graph.edge_attribute(edge, source.key, [])
    for joint in joints_of(verdict):
        u, v = (source.nodes[block] for block in joint.blocks)
        made = _joint(source, joint)
        if not graph.has_edge((u, v), directed=False):
            graph.add_edge(u, v)
            graph.edge_attribute((u, v), source.key, [])
        elif not graph.has_edge((u, v)):
            graph.delete_edge((v, u))  # a frame points along its edge
            graph.add_edge(u, v)
            graph.edge_attribute((u, v), source.key, [])
        graph.edge_attribute((u, v), source.key, [*graph.edge_attribute((u, v), source.key), made])


def _joint(source: Source, joint: CompasJoint) -> Any:
    from compas.geometry import Frame  # pyright: ignore[reportMissingImports]

    frame = Frame(np.mean(joint.points, axis=0).tolist(), joint.frame[1], joint.frame[2])
    fields = {"points": joint.points, "frame": frame, "size": joint.area, "forces": joint.forces}
    if source.key == "contacts":
        return _friction_contact(**fields)
    from compas_assembly.datastructures import Interface  # pyright: ignore[reportMissingImports]

    return Interface(**fields)


def _friction_contact(**fields: Any) -> Any:
    try:
        from compas_dem.interactions import FrictionContact  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InputError("forces of a model are written as contacts of compas_dem: pip install compas_dem") from None
    return FrictionContact(**fields)


def results_of(problem: Any, source: Source, verdict: Verdict, recorded: Recorded | None, *, motion: float) -> Any:
    """Return what the solvers of compas_dem return, and leave the model as it is.

    Parameters
    ----------
    problem : Problem of compas_dem
        Whose results they are.
    source : Source
        The model of the problem.
    verdict : Verdict
        On the blocks of the model.
    recorded : Recorded or None
        The joints of the model; None for those of the verdict.
    motion : float
        Factor on the motion of the verdict, whose fastest corner moves by 1 m.

    Returns
    -------
    Results of compas_dem
        A transformation of each node, and of each edge with a joint the forces of the joint that carries most. Its
        metadata hold the verdict.
    """
    from compas.geometry import Transformation  # pyright: ignore[reportMissingImports]
    from compas_dem.problem.results import Results  # pyright: ignore[reportMissingImports]

    results = Results(model_id=str(source.made.guid), problem_id=str(problem.guid))
    for node, centre, moved in zip(source.nodes, verdict.assembly.centroid, motion_of(verdict, motion), strict=True):
        results.set_node(node, "transformation", Transformation.from_matrix(_matrix(centre, moved).tolist()))
    most: dict[Any, float] = {}
    for (u, v), joint in _with_nodes(source, verdict, recorded):
        normal, along, across = np.sum([_local(own) for own in joint.forces], axis=0)
        resultant = np.array([normal, along, across]) @ np.array(joint.frame)
        size = float(np.linalg.norm(resultant))
        if size < most.get((u, v), 0.0):
            continue
        most[u, v] = size
        contact = _joint(source, joint)
        for name, value in {
            "contact_data": contact, "face_contact": len(joint.points) > 2, "edge_contact": len(joint.points) == 2,
            "point_contact": len(joint.points) == 1, "contact_points": joint.points,
            "contact_polygon": contact.polygon, "contact_frame": contact.frame, "resultant_global": resultant.tolist(),
            "resultant_local": [float(along), float(across), float(normal)], "force_magnitude": size,
        }.items():  # fmt: skip
            results.set_edge((u, v), name, value)
    results.metadata |= {"mu": verdict.assembly.friction, "verdict": verdict.summary()}
    return results


def _with_nodes(source: Source, verdict: Verdict, recorded: Recorded | None) -> list[tuple[Any, CompasJoint]]:
    """Joints with the edges that hold them, in the frames that they have there."""
    found = joints_of(verdict)
    if recorded is None:
        return [((source.nodes[own.blocks[0]], source.nodes[own.blocks[1]]), own) for own in found]
    rows = zip(recorded.joints, found, recorded.axes.tolist(), _components(verdict, recorded), strict=True)
    return [((u, v), replace(own, frame=axes, forces=forces)) for (u, v, _), own, axes, forces in rows]


def _local(force: dict[str, float]) -> list[float]:
    return [force["c_np"] - force["c_nn"], force["c_u"], force["c_v"]]


def _matrix(centre: Floats, moved: Floats) -> Floats:
    """The 4 by 4 matrix of a small translation and rotation about a centroid."""
    from scipy.spatial.transform import Rotation

    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_rotvec(moved[3:]).as_matrix()
    matrix[:3, 3] = centre + moved[:3] - matrix[:3, :3] @ centre
    return matrix
