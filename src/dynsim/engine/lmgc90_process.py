"""The process in which LMGC90 runs: it prints, keeps one simulation a process, and ends its process on an error.

It reads a pickled `Scene` from its standard input and then numbers of time steps, and answers each on its standard
output with a pickled `State`. What LMGC90 prints goes to the file that the first argument names.
"""

from __future__ import annotations

import os
import pickle
import sys
from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np

from blockstat.typing import Floats, Ints
from dynsim.engine.bodies import outward_hull
from dynsim.engine.lmgc90_pieces import add_pieces

FREEDOMS = range(1, 7)  #: of a block, as LMGC90 counts them


@dataclass(frozen=True, eq=False)
class Scene:
    """What is simulated, with gravity 9.81 m/s2 down the third axis."""

    step: float  #: [s]
    theta: float  #: weight of the new velocity in a step
    friction: float
    alert: float  #: distance below which blocks may touch within a step [m]
    density: Floats  #: of each block [kg/m3]
    centre: Floats  #: point that the corners of a block refer to, shape (n_blocks, 3) [m]
    pieces: tuple[tuple[Floats, ...], ...]  #: corners of the convex pieces of each block [m]
    support: np.ndarray  #: which blocks cannot move


@dataclass(frozen=True, eq=False)
class State:
    """Where the bodies are, and what acts between them."""

    place: Floats  #: centres of mass, shape (n_blocks, 3) [m]
    frame: Floats  #: axes, the columns, shape (n_blocks, 3, 3)
    place_before: Floats  #: one time step earlier
    frame_before: Floats
    pairs: Ints  #: the two blocks of each contact point, shape (k, 2)
    point: Floats  #: shape (k, 3) [m]
    force: Floats  #: on the second block, shape (k, 3) [N]
    seconds: float = 0.0  #: process time so far [s]


def started(module: Any, scene: Scene) -> Any:
    """Hand a scene to LMGC90.

    Parameters
    ----------
    module : module
        compas_lmgc90._lmgc90.
    scene : Scene
        The scene.

    Returns
    -------
    LMGC90Solver
        Ready for its first time step.
    """
    solver = module.LMGC90Solver()
    solver.initialize(scene.step, scene.theta, False)
    solver.add_one_tact_behav("iqsc0", "IQS_CLB", [scene.friction])
    solver.set_materials(scene.density)
    solver.set_see_tables(scene.alert)
    solver.set_nb_bodies(len(scene.pieces))
    for block, pieces in enumerate(scene.pieces):
        driven = len(FREEDOMS) if scene.support[block] else 0
        name, centre = f"s{block + 1:04d}", scene.centre[block]
        if len(pieces) == 1:
            faces = (outward_hull(pieces[0])[0] + 1).ravel().tolist()
            solver.set_one_polyr(name, centre.tolist(), faces, pieces[0].ravel().tolist(), driven, 0)
        else:
            add_pieces(module, name, centre, pieces, driven)
        for freedom in FREEDOMS[:driven]:
            solver.set_drvdof(block + 1, freedom, np.zeros(6), True, False)
    solver.close_before_computing()
    return solver


def bodies(result: Any) -> tuple[Floats, Floats]:
    """Return centres of mass and frames.

    Parameters
    ----------
    result : SimResult
        Of LMGC90.

    Returns
    -------
    place : array of float, shape (n_blocks, 3)
        Centres [m].
    frame : array of float, shape (n_blocks, 3, 3)
        Axes, the columns.
    """
    frames = np.array([np.reshape(frame, (3, 3)).T for frame in result.body_frames])
    return np.array([list(body) for body in result.bodies]), frames


def advanced(solver: Any, last: tuple[Floats, Floats], steps: int) -> State:
    """Go forward by some time steps.

    Parameters
    ----------
    solver : LMGC90Solver
        With a scene in it.
    last : tuple of arrays
        Where the bodies are.
    steps : int
        How many, at least one.

    Returns
    -------
    State
        At the end of the last.
    """
    now = result = None
    for _ in range(steps):
        result = solver.compute_one_step()
        last, now = now or last, bodies(result)
    assert result is not None
    assert now is not None
    pairs = np.array([list(pair) for pair in result.interaction_bodies], dtype=np.int64).reshape(-1, 2) - 1
    point = np.array([list(p) for p in result.interaction_coords]).reshape(-1, 3)
    on_first = np.array([list(f) for f in result.interaction_force_global]).reshape(-1, 3)
    return State(*now, *last, pairs, point, -on_first, process_time())


def main() -> None:
    """Answer on standard output what standard input asks for."""
    answers = os.fdopen(os.dup(1), "wb")
    log = os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(log, stream)
    from compas_lmgc90 import _lmgc90  # pyright: ignore[reportMissingImports]

    solver = started(_lmgc90, pickle.load(sys.stdin.buffer))
    last = bodies(solver.get_initial_state())
    none = np.zeros((0, 3))
    state = State(*last, *last, np.zeros((0, 2), dtype=np.int64), none, none)
    while True:
        pickle.dump(state, answers, protocol=pickle.HIGHEST_PROTOCOL)
        answers.flush()
        state = advanced(solver, (state.place, state.frame), pickle.load(sys.stdin.buffer))
