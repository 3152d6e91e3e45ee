"""The first user function: does it stand?"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.coulomb import coulomb_state
from blockstat.analysis.decision import Proof, decide
from blockstat.analysis.problem import Problem, free_fall, gap_warnings, pose, timed
from blockstat.analysis.verdict import Outcome, Verdict, unit_motion
from blockstat.certificate.check import Certificate
from blockstat.contact.edges import edge_warnings
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import check_choice, known_options
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve import cvxpy as cvxpy_primal
from blockstat.solve import dispatch as dual
from blockstat.solve.answer import MECHANISM, RawSolution
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

FLOWS = ("associated", "coulomb")
SOLVERS = (*dual.CHOICES, "cvxpy")
#: Status of an answer that is evidence of an earlier design.
RECALLED = "Recalled"


@known_options
def assess(
    assembly: Assembly,
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
    flow: str = "associated",
    memory: Memory | None = None,
    score: bool = True,
) -> Verdict:
    """Static verdict on an assembly of rigid blocks with dry Coulomb joints.

    Solves the penalty program of Whiting et al. (2009) with the exact friction cone in its dual form, then
    checks the answer with our own code: stable rests on a force field, unstable on a mechanism.

    friction : replaces the assembly's coefficient. gravity : replaces its vector [m/s2], shape (3,).
    loads : further wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].
    gap : tolerance of the joint search, relative to block size. interfaces : use these instead of searching.
    solver : "auto", "interior-point" or "clarabel" for the dual (see `blockstat.solve.dispatch`), "cvxpy" for the
    literal primal, the reference. The verdict says which one answered.
    memory : evidence of earlier designs with the same joints, which may decide without a solve (see
    `blockstat.analysis.certificate_cache`); an instability proven so has no score (nan).
    score : False ends at the first mechanism found, several times sooner; an unstable assembly then has no score (nan),
    and its mechanism is one of many, not that of least adhesion.
    flow : "associated" asks whether an admissible force field exists; "coulomb" asks in addition whether one exists
    without dilatancy and self-stress (see `blockstat.analysis.coulomb`), and answers STABLE_ONLY_BY_SELF_STRESS if not.

    Raises InputError when nothing supports the assembly, when blocks overlap, or for a bad option.
    """
    check_choice("solver", solver, SOLVERS)
    check_choice("flow", flow, FLOWS)
    problem = pose(
        assembly, friction=friction, gravity=gravity, loads=loads, gap=gap, interfaces=interfaces, solver=solver
    )
    timings = dict(problem.timings)
    raw = proof = state = None
    if problem.program is not None:
        raw, proof = _solved(problem, problem.program, solver, memory, timings, score)
        if flow == "coulomb" and problem.slips and proof.outcome is Outcome.STABLE:
            with timed(timings, "coulomb"):
                state = coulomb_state(problem.program)
    timings["total"] = sum(timings.values())
    verdict = _verdict(problem, raw, proof, timings)
    if raw is not None and raw.status in (MECHANISM, RECALLED) and verdict.outcome is Outcome.UNDECIDED:
        # The mechanism of least adhesion moves fewer blocks, so it may not press on contacts that are not modelled.
        return assess(
            assembly, friction=friction, gravity=gravity, loads=loads, gap=gap, interfaces=problem.interfaces,
            solver=solver, flow=flow,
        )  # fmt: skip
    if flow == "associated":
        return verdict
    outcome = verdict.outcome
    if state is not None and outcome is Outcome.STABLE and state.settles is not True:
        outcome = Outcome.STABLE_ONLY_BY_SELF_STRESS if state.settles is False else Outcome.UNDECIDED
    return replace(verdict, outcome=outcome, flow=flow, coulomb=state)


def _solved(
    problem: Problem,
    program: PenaltyProgram,
    solver: str,
    memory: Memory | None,
    timings: dict[str, float],
    score: bool,
) -> tuple[RawSolution, Proof]:
    """An answer and what it proves: an earlier one if there is one that does, else a new one."""
    if memory is not None:
        with timed(timings, "memory"):
            known = memory.recall(problem)
        if known is not None:
            proof, kind = known
            none = np.full(program.n_points, np.nan)
            return RawSolution(proof.force, none, proof.twist, True, RECALLED, 0, f"earlier {kind}"), proof
    with timed(timings, "solve"):
        raw = cvxpy_primal.solve(program) if solver == "cvxpy" else dual.solve(program, score=score)
    with timed(timings, "certificate"):
        proof = decide(program, raw)
    if memory is not None:
        memory.keep(problem, proof)
    return raw, proof


def _verdict(problem: Problem, raw: RawSolution | None, proof: Proof | None, timings: dict[str, float]) -> Verdict:
    """Back to SI units and to all blocks and points; blocks that nothing holds fall freely."""
    outcome, checked, score = Outcome.STABLE, Certificate(0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    force, adhesion, twist = np.empty((0, 3)), np.empty(0), np.empty(0)
    if raw is not None and proof is not None and problem.program is not None:
        outcome, checked = proof.outcome, proof.certificate
        if outcome is Outcome.STABLE:
            force, adhesion, twist = proof.force, np.zeros(problem.eq.n_points), np.zeros_like(proof.twist)
        else:
            force, adhesion, twist = raw.force, np.nan_to_num(raw.adhesion), proof.twist
            score = float(np.linalg.norm(raw.adhesion)) / problem.program.total_load if raw.bounded else np.inf
    mechanism = problem.to_blocks(twist)
    if len(problem.floating):
        # Each group moves along its load as one: no joint closes, so this is a proof without any error.
        falling = free_fall(problem)
        work = float((falling * problem.load).sum() / (np.abs(problem.load).sum() or 1.0))
        if work > 0:
            outcome, score, mechanism = Outcome.UNSTABLE, np.inf, falling
            checked = Certificate(checked.residual, checked.cone_violation, work, 0.0, np.inf)
        elif outcome is Outcome.STABLE:
            outcome = Outcome.UNDECIDED  # loads that happen to balance on nothing
    blocked: list[str] = []
    if outcome is Outcome.UNSTABLE:
        blocked = edge_warnings(
            problem.assembly, problem.interfaces, problem.gap, unit_motion(problem.assembly, mechanism)
        )
        outcome = Outcome.UNDECIDED if blocked else outcome
    return Verdict(
        outcome=outcome,
        score=score,
        forces=problem.to_points(force),
        adhesion=problem.adhesion_at_points(adhesion),
        mechanism=unit_motion(problem.assembly, mechanism),
        certificate=checked,
        interfaces=problem.interfaces,
        assembly=problem.assembly,
        solver=raw.solver if raw is not None else "none",
        timings=timings,
        floating=problem.floating,
        warnings=(*problem.warnings, *blocked, *gap_warnings(problem, outcome)),
        bonds=problem.to_bonds(force),
    )
