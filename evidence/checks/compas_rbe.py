"""Rigid-block equilibrium by compas_cra 0.8 (Kao et al. 2022), in an environment that has it and not blockstat.

    python compas_rbe.py GIVEN.npz FOUND.npz

The joints are those given; forces are found in units of the mean weight, with gravity turned onto -z. Seconds are
process time of Ipopt alone, without the set-up of its matrices in Python.
"""

from __future__ import annotations

import sys
from time import process_time

import numpy as np
from compas.geometry import Frame
from compas_assembly.datastructures import Block
from compas_cra.datastructures import CRA_Assembly
from compas_cra.equilibrium import rbe_problem
from compas_cra.nlp import solve_nlp


def turned(gravity: np.ndarray) -> np.ndarray:
    """The rotation that takes gravity to -z."""
    down = -gravity / np.linalg.norm(gravity)
    side = np.cross([0.0, 1.0, 0.0] if abs(down[1]) < 0.9 else [1.0, 0.0, 0.0], down)
    side /= np.linalg.norm(side)
    return np.array([side, np.cross(down, side), down])


def assembled(data: dict) -> tuple[CRA_Assembly, float]:
    """The assembly, and the mean volume of the blocks that are free."""
    turn = turned(data["gravity"])
    corners, points = data["vertices"] @ turn.T, data["point"] @ turn.T
    frames = data["frame"] @ turn.T
    assembly = CRA_Assembly()
    volumes = []
    starts, faces = data["vertex_start"], np.split(data["face_vertices"], data["face_start"][1:-1])
    by_block = np.searchsorted(data["face_block"], np.arange(len(starts)))
    for number, support in enumerate(data["support"]):
        own = [(face - starts[number]).tolist() for face in faces[by_block[number] : by_block[number + 1]]]
        block = Block.from_vertices_and_faces(corners[starts[number] : starts[number + 1]].tolist(), own)
        assembly.add_block(block, node=number)
        if support:
            assembly.set_boundary_condition(number)
        else:
            volumes.append(block.volume())
    for k, (a, b) in enumerate(data["pair"].tolist()):
        own = points[data["start"][k] : data["start"][k + 1]]
        frame = Frame(own.mean(axis=0).tolist(), frames[k, 1].tolist(), frames[k, 2].tolist())
        assembly.add_to_interfaces(a, b, 1.0, own.tolist(), frame)
    return assembly, float(np.mean(volumes))


def main() -> None:
    data = dict(np.load(sys.argv[1]))
    assembly, volume = assembled(data)
    problem, _ = rbe_problem(assembly, mu=float(data["friction"]), density=1.0 / volume)
    begin = process_time()
    result = solve_nlp(problem, backend="native")
    seconds = process_time() - begin
    force, adhesion = np.zeros((len(data["point"]), 3)), np.zeros(len(data["point"]))
    # compas keeps its joints by edge of the graph; each goes back to the place it was given at.
    place = {(a, b): [] for a, b in data["pair"].tolist()}
    for k, (a, b) in enumerate(data["pair"].tolist()):
        place[a, b].append(k)
    done = 0
    for a, b in assembly.graph.edges():
        for k in place[a, b] if (a, b) in place else place[b, a]:
            first, last = data["start"][k], data["start"][k + 1]
            own = result.x[4 * done : 4 * (done + last - first)].reshape(-1, 4)
            force[first:last] = np.column_stack([own[:, 0] - own[:, 1], own[:, 2], own[:, 3]])
            adhesion[first:last] = own[:, 1]
            done += last - first
    np.savez(
        sys.argv[2], force=force, adhesion=adhesion, seconds=seconds,
        iterations=result.iterations or 0, status=result.status,
    )  # fmt: skip


if __name__ == "__main__":
    main()
