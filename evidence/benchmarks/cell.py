"""One cell of the table of solvers: a scene of some size, one solver, in this process; prints JSON.

    python -m evidence.benchmarks.cell SCENE SIZE SOLVER

The program is solved in space, except that `blockstat` takes the plane if there is one, as `assess` does. Seconds are
process time of the solver's call alone, best of three where it is short, without imports and without a pattern kept
from an earlier call. Every answer is judged by the same certificate, from its own numbers.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import process_time

import clarabel
import numpy as np
from scipy import sparse

from blockstat.analysis.decision import outcome_of
from blockstat.analysis.problem import Problem, pose
from blockstat.analysis.verdict import Outcome
from blockstat.certificate import check as certificate
from blockstat.certificate.interior_motions import with_interior_motion
from blockstat.contact.interfaces import GAP
from blockstat.linear_algebra import normal_equations as normal
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer, Status
from blockstat.solve.clarabel import MAX_ITERATIONS, STATUS, TOLERANCE
from blockstat.solve.cvxpy import solve_on_paper
from blockstat.solve.penalty import solve_penalty
from evidence.paths import ROOT
from evidence.scenes.sized import SCENES

#: The interpreter of an environment with compas_cra.
COMPAS = "BLOCKSTAT_COMPAS_PYTHON"
SHORT = 2.0  #: a call that takes fewer seconds than this is repeated

Solved = tuple[Answer, float]


def clarabel_primal(problem: Problem) -> Answer:
    """The penalty program over forces and adhesion, min 1/2 |s|^2 with A (f - E s) + w = 0, f in K, s >= 0."""
    program = solvable(problem)
    m, n = len(program.friction), program.n_points
    slip = np.minimum(program.friction, 1.0)
    head = slip / program.friction
    into = sparse.diags_array(np.column_stack([slip, head, head]).reshape(-1))  # |f_t| / mu <= f_n, scaled
    nothing = sparse.csr_array((3 * m, n))
    rows = sparse.block_array(
        [
            [program.matrix, -program.normal_columns],
            [-into, nothing],
            [sparse.csr_array((n, 3 * m)), -sparse.eye_array(n)],
        ]
    )
    cones = [clarabel.ZeroConeT(len(program.load)), *[clarabel.SecondOrderConeT(3)] * m, clarabel.NonnegativeConeT(n)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.direct_solve_method = "qdldl"
    settings.max_iter = MAX_ITERATIONS
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    hessian = sparse.diags_array(np.repeat([0.0, 1.0], [3 * m, n])).tocsc()
    bound = np.concatenate([-program.load, np.zeros(3 * m + n)])
    answer = clarabel.DefaultSolver(hessian, np.zeros(3 * m + n), rows.tocsc(), bound, cones, settings).solve()
    x, twist = np.array(answer.x), np.array(answer.z)[: len(program.load)]
    twist = -twist if twist @ program.load < 0 else twist
    status = STATUS.get(str(answer.status), Status.STALLED)
    force, adhesion = x[: 3 * m].reshape(-1, 3), x[3 * m :]
    return Answer(force, twist, status, int(answer.iterations), "clarabel-primal", adhesion=adhesion)


def compas_rbe(problem: Problem) -> Solved:
    """Rigid-block equilibrium of compas_cra in its own environment, by Ipopt with a friction octagon."""
    faces, asm, program = problem.interfaces, problem.assembly, solvable(problem)
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "given.npz"), Path(folder, "found.npz")
        blocks = {name: getattr(asm, name) for name in ("vertices", "face_vertices", "face_start", "face_block")}
        joints = {name: getattr(faces, name) for name in ("pair", "frame", "point", "start")}
        arrays = {**blocks, **joints, "support": asm.support, "gravity": asm.gravity}
        np.savez(given, **arrays, vertex_start=asm.vertex_start, friction=asm.friction)
        worker = ROOT / "evidence" / "checks" / "compas_rbe.py"
        subprocess.run([os.environ[COMPAS], str(worker), str(given), str(found)], check=True, stdout=subprocess.DEVNULL)
        answer = dict(np.load(found))
    force = answer["force"][problem.eq.points]
    adhesion = answer["adhesion"][problem.eq.points]
    raw = Answer(
        force=force + adhesion[:, None] * np.array([1.0, 0.0, 0.0]),
        adhesion=adhesion,
        twist=np.zeros_like(program.load),
        status=Status.SOLVED,  # what Ipopt says of it is not asked
        iterations=int(answer["iterations"]),
        solver="compas_cra",
    )
    return raw, float(answer["seconds"])


def forget() -> None:
    """Let go of the patterns and orderings of earlier calls."""
    normal.known.normals.clear()
    normal.known.graphs.clear()


def blockstat(problem: Problem) -> Answer:
    """What `assess` does."""
    assert problem.program is not None
    forget()
    return solve_penalty(problem.program, motions=problem.motions)


def through(solver: str) -> Callable[[Problem], Answer]:
    """A dual program in space through one of blockstat's own solvers."""

    def solve(problem: Problem) -> Answer:
        forget()
        return solve_penalty(solvable(problem), solver=solver, motions=problem.motions)

    return solve


#: Each gives an answer, or an answer and the seconds it took elsewhere.
SOLVERS: dict[str, Callable[[Problem], Answer | Solved]] = {
    "cvxpy": lambda problem: solve_on_paper(solvable(problem)),
    "clarabel-primal": clarabel_primal,
    "clarabel-dual": through("clarabel"),
    "structured": through("interior-point"),
    "blockstat": blockstat,
    "compas-rbe": compas_rbe,
}


def solvable(problem: Problem) -> PenaltyProgram:
    """The program of a problem, in space."""
    assert problem.program is not None
    return replace(problem.program, plane=None)


def timed(problem: Problem, solver: str) -> Solved:
    """An answer and its seconds."""
    best = np.inf
    for _ in range(3):
        begin = process_time()
        answer = SOLVERS[solver](problem)
        seconds = process_time() - begin
        raw, seconds = answer if isinstance(answer, tuple) else (answer, seconds)
        best = min(best, seconds)
        if seconds > SHORT:
            break
    return raw, best


def judge(problem: Problem, raw: Answer) -> dict:
    """Residuals relative to the weight before and after the correction, the score, and what the certificate says."""
    program = solvable(problem)

    def residual(force: np.ndarray, adhesion: np.ndarray) -> float:
        rest = program.matrix @ force.reshape(-1) - program.normal_columns @ adhesion + program.load
        return float(np.linalg.norm(rest)) / program.total_load

    balanced = raw.force if raw.status is Status.ACCEPTED else certificate.balance(program, raw.force)
    verdict = outcome_of(certificate.check(program, balanced, raw.twist))
    if verdict is Outcome.UNDECIDED:
        opened = with_interior_motion(program, raw.twist, problem.motions())
        verdict = outcome_of(certificate.check(program, balanced, opened))
    return {
        "residual": residual(raw.force, raw.adhesion),
        "balanced": residual(balanced, 0 * raw.adhesion),
        "score": float(np.linalg.norm(raw.adhesion)) / program.total_load,
        "verdict": verdict.word,
    }


def posed(scene: str, size: int) -> Problem:
    return pose(SCENES[scene](size), friction=None, gravity=None, loads=None, gap=GAP, interfaces=None)


def measure(scene: str, size: int, solver: str) -> dict:
    """One cell."""
    SOLVERS[solver](posed("wall", 20))  # imports are no part of it
    problem = posed(scene, size)
    begin = process_time()
    raw, seconds = timed(problem, solver)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN if solver == "compas-rbe" else resource.RUSAGE_SELF).ru_maxrss
    begin = process_time()
    judged = judge(problem, raw)
    return {
        "scene": scene, "size": size, "solver": solver, "blocks": problem.eq.n_blocks, "points": problem.eq.n_points,
        "seconds": seconds, "iterations": raw.iterations, **judged, "memory": peak / 1024, "status": raw.status.word,
        "answered": raw.solver, "interfaces": problem.timings["interfaces"],
        "equilibrium": problem.timings["equilibrium"], "certificate": process_time() - begin,
    }  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1], int(sys.argv[2]), sys.argv[3])))
