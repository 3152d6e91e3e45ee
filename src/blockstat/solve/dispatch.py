"""The dual programs: which solver takes them, and the three that a verdict asks for."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from blockstat.certificate.check import FORCE_TOLERANCE, balance, check, force_errors, opening_room
from blockstat.certificate.interior_motions import cheapest, opened
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve import clarabel_dual, clarabel_primal, structured
from blockstat.solve.answer import ACCEPTED, MECHANISM, OPTIMUM, DualAnswer, DualProgram, Enough, RawSolution
from blockstat.solve.components import solve_apart
from blockstat.typing import Floats

#: Joints open by more than this many violations need no watching when a mechanism is mended.
WIDE_OPEN = 1e3
#: A point with a cap that closes faster than this fraction of the fastest joint crushes or yields.
YIELDS = 1e-6
#: Unknowns from which the structured method is the faster one; below, its many small steps in Python cost more.
STRUCTURED = 500
#: Unknowns from which it pays to look for parts that do not touch.
APART = 3_000
#: Of the load and the adhesion, what the answer of a penalty program may leave unbalanced.
BALANCED = 1e-6
#: Of what a proof may leave unbalanced, what forces may leave that are not balanced any better.
ALREADY = 0.01
CHOICES = ("auto", "interior-point", "clarabel")


def solve_dual(problem: DualProgram, enough: Enough = OPTIMUM) -> DualAnswer:
    """Solve a dual program with the structured method where it fits and pays, else with Clarabel.

    enough : may end the structured method before the optimum; Clarabel does not ask.
    The choice is the program's `solver`: "auto", "interior-point" or "clarabel". Where the structured method does not
    fit (friction without limit) or gets stuck, Clarabel takes over; the answer says who gave it.
    """
    whole = _structured(problem)
    if whole or (enough.approach and problem.program.solver == "auto" and structured.fits(problem)):
        answer = structured.solve_dual(problem, enough if whole else replace(enough, optimise=False))
        if not answer.status.startswith("Stalled"):
            return answer
    return clarabel_dual.solve_dual(problem)


def _structured(problem: DualProgram) -> bool:
    """Whether the structured method is asked for, pays, and fits."""
    solver = problem.program.solver
    unknowns = len(problem.program.load) // (1 if problem.plane is None else 2)
    wanted = solver == "interior-point" or (solver == "auto" and unknowns >= STRUCTURED)
    return wanted and structured.fits(problem)


def solve_pressure(program: PenaltyProgram, cost: Floats, compliance: float) -> tuple[Floats, Floats, str]:
    """Minimise cost' f_n + compliance/2 |f|^2 subject to A f + w = 0, f in K, for positive finite friction.

    cost : of the normal force at each point, shape (m,). Returns the forces, shape (m, 3), the cone multipliers
    z in K* (relative velocities with the closing and the dilatancy taken off), shape (m, 3), and the status.
    """
    unit = max(float(cost.max()), 1.0)
    offset = np.zeros((len(cost), 3))
    offset[:, 0] = cost / unit
    problem = DualProgram(program, -program.load, offset=offset.reshape(-1), compliance=compliance / unit)
    if not _structured(problem):
        return clarabel_primal.solve_pressure(program, cost, compliance)
    answer = structured.solve_dual(problem)
    if answer.status.startswith("Stalled"):
        return clarabel_primal.solve_pressure(program, cost, compliance)
    slip = np.minimum(program.friction, 1.0)
    scale = np.column_stack([slip / program.friction, slip, slip])
    rate = (program.matrix.T @ answer.twist).reshape(-1, 3)
    return answer.force, unit * (rate + offset + problem.compliance * answer.force / scale**2), answer.status


def solve(program: PenaltyProgram, *, score: bool = True) -> RawSolution:
    """Minimise 1/2 ||E' A' u||^2 - w' u over twists with A' u in K*; at points with a cap, 1/2 |g_n + y|^2.

    score : False allows to end with the first mechanism that is found, whose adhesion is not known. Large programs
    are solved in parts that do not touch each other (see `blockstat.solve.components`).
    """
    if len(program.load) >= APART and program.plane is None:
        return solve_apart(program, partial(_solve, score=score))
    return _solve(program, score=score)


def _solve(program: PenaltyProgram, *, score: bool = True) -> RawSolution:
    """Solve a penalty program as a whole."""
    proven: list[Floats] = []

    def accept(force: Floats) -> bool:
        """Forces on the way to the optimum that, balanced, prove stability are as good as the optimum's."""
        proven[:] = [force]
        if max(force_errors(program, force)) <= ALREADY * FORCE_TOLERANCE:
            return True
        proven[:] = [balance(program, force)]
        return max(force_errors(program, proven[0])) <= FORCE_TOLERANCE

    way = _Way(program)
    # Who asks for no score expects most designs to fall, and then it is mostly in vain to look for forces for long.
    enough = Enough(accept, way.noted if score else way.falls, approach=True, brief=not score)
    answer = solve_dual(DualProgram(program, -program.load, penalty=True), enough)
    if answer.status in (ACCEPTED, MECHANISM):
        stands = answer.status == ACCEPTED
        return RawSolution(
            force=proven[0] if stands else 0 * answer.force,
            adhesion=np.full(program.n_points, 0.0 if stands else np.nan),
            twist=0 * answer.twist if stands else way.mechanism,
            bounded=True,
            status=answer.status,
            iterations=answer.iterations,
            solver=answer.solver,
        )
    adhesion = np.maximum(program.opening.T @ answer.twist + answer.crushing[: program.n_points], 0.0)
    return RawSolution(
        force=answer.force,
        adhesion=adhesion,
        twist=answer.twist,
        bounded=_balances(program, answer.force, adhesion),
        status=answer.status,
        iterations=answer.iterations,
        solver=answer.solver,
        inside=way.inside(),
    )


class _Way:
    """The twists on the way to the optimum. They lie inside the cones until near its end.

    So mechanisms are among them long before it, and those that are none yet open the joints that later ones close.
    """

    def __init__(self, program: PenaltyProgram) -> None:
        self._program = program
        self._seen: list[Floats] = []
        self.mechanism = np.zeros_like(program.load)  #: the one that `falls` has found

    def noted(self, twist: Floats) -> bool:
        """Keep a twist; it ends nothing."""
        self._seen.append(twist)
        return False

    def falls(self, twist: Floats) -> bool:
        """Whether a twist, with a little of earlier ones, proves instability."""
        if float(self._program.load @ twist) > 0:
            if self._proves(twist) or self._proves(opened(self._program, twist, self.inside())):
                return True
        return self.noted(twist)

    def _proves(self, mechanism: Floats) -> bool:
        self.mechanism = mechanism
        no_force = np.zeros((len(self._program.friction), 3))
        return check(self._program, no_force, mechanism).proves_unstable

    def inside(self) -> Floats | None:
        """The cheapest of the last motions seen that open every joint."""
        return cheapest(self._program, reversed(self._seen))


def _balances(program: PenaltyProgram, force: Floats, adhesion: Floats) -> bool:
    """Whether forces and adhesion balance the load; where no adhesion could, a solver ends with some ray."""
    rest = program.matrix @ force.reshape(-1) - program.opening @ adhesion + program.load
    size = program.total_load + float(adhesion.sum()) + float(np.abs(program.load).max(initial=0.0))
    return bool(np.abs(rest).max(initial=0.0) <= BALANCED * size)


def solve_margin(program: PenaltyProgram) -> RawSolution:
    """The least adhesion tau, the same at every point, that lets an equilibrium exist; at least -1.

    Primal: min tau subject to A f + w = 0, f_i + tau n in K, tau >= -1, and f_n - tau <= cap where there is one.
    Dual: max w' u + sum g_n - 1 subject to A' u in K*, sum g_n <= 1, with 2 y added to g_n at a cap. The penalty
    program is quadratic, so near the limit its answer is good to the square root of the tolerance; this one is linear
    and good to the tolerance itself. It costs a second solve, so it is asked only where the first proved neither side.
    """
    total = np.asarray(program.opening.sum(axis=1)).reshape(-1)
    answer = solve_dual(DualProgram(program, -program.load - total, capped=total, crushing=2.0))
    own = program.capped[program.capped < program.n_points]
    crushed = answer.crushing[program.capped]
    earned = float(total @ answer.twist) + 2.0 * float(answer.crushing[own].sum()) - 1.0
    tau = float(program.load @ answer.twist) - float(program.cap[program.capped] @ crushed) + earned
    tau += _floored(program, answer)
    force = answer.force.copy()
    force[: program.n_points, 0] -= tau
    adhesion = np.full(program.n_points, max(tau, 0.0))
    return RawSolution(
        force,
        adhesion,
        answer.twist,
        bounded=True,
        status=answer.status,
        iterations=answer.iterations,
        solver=answer.solver,
    )


def _floored(program: PenaltyProgram, answer: DualAnswer) -> float:
    """What the floors pay for the opening beyond friction at their points."""
    rate = (program.matrix.T @ answer.twist).reshape(-1, 3)[program.floored]
    room = opening_room(rate, program.friction[program.floored]) + answer.crushing[program.floored]
    return float(program.floor[program.floored] @ np.maximum(room, 0.0))


def open_joints(program: PenaltyProgram, twist: Floats) -> Floats:
    """A twist next to the given one under which no joint closes at all.

    With eps the largest violation of A' u in K*, looks for the least d with A' (u / eps + d) in K* + n and
    returns u + eps d. The solver's error is then relative to eps and not to u. Returns u itself when there is
    nothing to mend or, in jammed assemblies, no such d.
    """
    gap_rate = (program.matrix.T @ twist).reshape(-1, 3)
    room = opening_room(gap_rate, program.friction)
    # Points that crush or bonds that yield may go on closing; those that close by an error are mended.
    room[program.capped[room[program.capped] < -YIELDS * np.abs(gap_rate).max(initial=0.0)]] = np.inf
    worst = -float(room.min(initial=0.0))
    if worst <= 0:
        return twist
    offset = np.zeros_like(gap_rate)
    sticky = np.isinf(program.friction)
    offset[:, 0] = np.minimum(np.where(sticky & np.isfinite(room), gap_rate[:, 0], room) / worst, WIDE_OPEN) - 1.0
    offset[sticky, 1:] = gap_rate[sticky, 1:] / worst
    answer = solve_dual(DualProgram(program, np.zeros(len(twist)), least_norm=True, offset=offset.reshape(-1)))
    return twist + worst * answer.twist if "Infeasible" not in answer.status else twist
