"""The user functions: does it stand?"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact import GAP, Interfaces, find_interfaces
from blockstat.equilibrium import Equilibrium, equilibrium, split_floating, weight
from blockstat.errors import InputError
from blockstat.overlap import check_overlaps
from blockstat.polyhedron import Floats, Ints
from blockstat.program import PenaltyProgram, penalty_program
from blockstat.result import Outcome, Verdict, corner_speed
from blockstat.solve import certificate, clarabel_dual, cvxpy_primal
from blockstat.solve.certificate import Certificate
from blockstat.solve.raw import RawSolution

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A joint open by more than this fraction of the block size is mentioned when the verdict rests on it.
LOOSE = 1e-3

SOLVERS = {"clarabel": clarabel_dual.solve, "cvxpy": cvxpy_primal.solve}


def assess(
    assembly: Assembly,
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "clarabel",
) -> Verdict:
    """Static verdict on an assembly of rigid blocks with dry Coulomb joints.

    Solves the penalty program of Whiting et al. (2009) with the exact friction cone in its dual form, then
    checks the answer with our own code: stable rests on a force field, unstable on a mechanism.

    friction : replaces the assembly's coefficient. gravity : replaces its vector [m/s2], shape (3,).
    loads : further wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].
    gap : tolerance of the joint search, relative to block size. interfaces : use these instead of searching.
    solver : "clarabel" (the dual, fast) or "cvxpy" (the literal primal, the reference).

    Raises InputError when nothing supports the assembly, when blocks overlap, or for a bad option.
    """
    if solver not in SOLVERS:
        raise InputError(f"no solver {solver!r}; solvers are: {', '.join(SOLVERS)}")
    changes = {k: v for k, v in (("friction", friction), ("gravity", gravity)) if v is not None}
    assembly = assembly.with_(**changes) if changes else assembly
    if not assembly.support.any():
        raise InputError(f'"{assembly.name}" has no supports; list the blocks that cannot move under "supports"')
    total_load = weight(assembly) + _checked_loads(assembly, loads)

    timings: dict[str, float] = {}
    warnings: list[str] = []
    with _timed(timings, "interfaces"):
        if interfaces is None:
            interfaces = find_interfaces(assembly, gap=gap)
            warnings += check_overlaps(assembly, gap=gap)
    with _timed(timings, "equilibrium"):
        held, floating = split_floating(assembly, interfaces)
        touched = np.isin(interfaces.pair, held)
        points = np.flatnonzero((touched[:, 0] | touched[:, 1])[interfaces.point_interface])
        eq = equilibrium(assembly, interfaces, total_load, held, points)
        program = penalty_program(eq, np.full(len(points), assembly.friction)) if len(held) else None
    with _timed(timings, "solve"):
        raw = SOLVERS[solver](program) if program else None
    with _timed(timings, "certificate"):
        solved = _decide(eq, program, raw) if program and raw else _NOTHING_TO_SOLVE
        verdict = _verdict(assembly, interfaces, total_load, eq, program, solved, floating)
    timings["total"] = sum(timings.values())
    warnings += _floating_warnings(assembly, floating, interfaces)
    warnings += _gap_warnings(assembly, interfaces, verdict["outcome"], gap)
    return Verdict(
        **verdict, interfaces=interfaces, assembly=assembly, solver=solver, timings=timings, floating=floating,
        warnings=tuple(warnings),
    )  # fmt: skip


_NO_PROOF_NEEDED = Certificate(0.0, 0.0, 0.0, 0.0, 0.0)
_NOTHING_TO_SOLVE = (Outcome.STABLE, 0.0, np.empty((0, 3)), np.empty(0), np.empty(0), _NO_PROOF_NEEDED)


def _decide(
    eq: Equilibrium, program: PenaltyProgram, raw: RawSolution
) -> tuple[Outcome, float, Floats, Floats, Floats, Certificate]:
    """Outcome, score, and the scaled forces, adhesion and twist that the certificate was computed from."""
    outcome, force, twist, proof = _prove(eq, program, raw)
    if outcome is Outcome.UNDECIDED:
        closer = _prove(eq, program, clarabel_dual.solve_margin(program), mend=True)
        if closer[0] is not Outcome.UNDECIDED or closer[3].required_force > proof.required_force:
            outcome, force, twist, proof = closer
    if outcome is Outcome.STABLE:
        return outcome, 0.0, force, np.zeros(len(force)), np.zeros_like(twist), proof
    total = float(np.linalg.norm(program.load.reshape(-1, 6)[:, :3], axis=1).sum()) or 1.0
    score = float(np.linalg.norm(raw.adhesion)) / total if raw.bounded else np.inf
    return outcome, score, raw.force, raw.adhesion, twist, proof


def _prove(
    eq: Equilibrium, program: PenaltyProgram, raw: RawSolution, *, mend: bool = False
) -> tuple[Outcome, Floats, Floats, Certificate]:
    """What our own checks make of a solver's answer: outcome, balanced forces, twist, certificate."""
    force = certificate.balance(program, raw.force)
    twist = raw.twist
    proof = certificate.check(eq, program, force, twist)
    if mend and proof.required_force > 0 and not (proof.proves_stable or proof.proves_unstable):
        twist = clarabel_dual.open_joints(program, twist)
        proof = certificate.check(eq, program, force, twist)
    if proof.proves_stable == proof.proves_unstable:
        return Outcome.UNDECIDED, force, twist, proof
    return Outcome.STABLE if proof.proves_stable else Outcome.UNSTABLE, force, twist, proof


def _verdict(
    assembly: Assembly,
    interfaces: Interfaces,
    load: Floats,
    eq: Equilibrium,
    program: PenaltyProgram | None,
    solved: tuple[Outcome, float, Floats, Floats, Floats, Certificate],
    floating: Ints,
) -> dict[str, Any]:
    """Back to SI units and to all blocks and points; blocks that nothing holds fall freely."""
    outcome, score, force, adhesion, twist, proof = solved
    forces, tension = np.zeros((interfaces.n_points, 3)), np.zeros(interfaces.n_points)
    mechanism = np.zeros((assembly.n_blocks, 6))
    if program is not None:
        forces[eq.points] = force * program.force_unit
        tension[eq.points] = adhesion * program.force_unit
        mechanism[eq.blocks] = twist.reshape(-1, 6) / np.repeat([1.0, program.length_unit], 3)
    if len(floating):
        # The whole group moves along its load as one: no joint closes, so this is a proof without any error.
        outcome, score = Outcome.UNSTABLE, np.inf
        pull = load[floating, :3].sum(axis=0)
        mechanism *= 0.0
        mechanism[floating, :3] = pull / (np.linalg.norm(pull) or 1.0)
        work = float((mechanism * load).sum() / np.abs(load).sum())
        proof = Certificate(proof.residual, proof.cone_violation, work, 0.0, np.inf)
    fastest = corner_speed(assembly, mechanism).max(initial=0.0)
    return {
        "outcome": outcome,
        "score": score,
        "forces": forces,
        "adhesion": tension,
        "mechanism": mechanism / fastest if fastest > 0 else mechanism,
        "certificate": proof,
    }


def _checked_loads(assembly: Assembly, loads: Floats | None) -> Floats:
    if loads is None:
        return np.zeros((assembly.n_blocks, 6))
    loads = np.asarray(loads, dtype=float)
    if loads.shape != (assembly.n_blocks, 6) or not np.isfinite(loads).all():
        raise InputError(f"loads have shape {loads.shape}; finite values of shape ({assembly.n_blocks}, 6) are needed")
    return loads


def _floating_warnings(assembly: Assembly, floating: Ints, interfaces: Interfaces) -> list[str]:
    touched = np.unique(interfaces.pair)
    alone = np.setdiff1d(floating, touched)
    return [f'block "{assembly.names[i]}" touches nothing' for i in alone[:5]] + (
        [f"{len(alone) - 5} more blocks touch nothing"] if len(alone) > 5 else []
    )


def _gap_warnings(assembly: Assembly, interfaces: Interfaces, outcome: Outcome, gap: float) -> list[str]:
    """Say when the verdict may hang on the joint tolerance."""
    near = [d for d in interfaces.dropped if d.reason == "gap"]
    if outcome is not Outcome.STABLE and near:
        least = min(near, key=lambda d: d.value / d.limit)
        a, b = assembly.names[least.a], assembly.names[least.b]
        return [
            f"{len(near)} near joints were not taken (gap tolerance {gap:g} of the block size), the closest "
            f'"{a}" to "{b}" with {least.value:.2g} m: a larger tolerance may change the verdict'
        ]
    loose = interfaces.gap > LOOSE * assembly.size[interfaces.pair].min(axis=1)
    if outcome is Outcome.STABLE and loose.any():
        worst = interfaces.gap[loose].max()
        return [f"{loose.sum()} of {len(loose)} joints do not quite close (up to {worst:.2g} m) and count as touching"]
    return []


@contextmanager
def _timed(timings: dict[str, float], step: str) -> Iterator[None]:
    start = process_time()
    yield
    timings[step] = process_time() - start
