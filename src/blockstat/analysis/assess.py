"""The static verdict on an assembly: whether it stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.coulomb import FAMILY, CoulombState, coulomb_state, state_in_every_kind
from blockstat.analysis.decision import decide, outcome_of
from blockstat.analysis.problem import Problem, cases_of, crushes, free_fall, pose, timed, with_joints
from blockstat.analysis.reserve import neutral_blocks, neutral_warning, resting_warning
from blockstat.analysis.rims import (
    falling_freely,
    gap_warnings,
    judged_with_rims,
    near_edge_warnings,
    overlap_warnings,
    rim_warnings,
)
from blockstat.analysis.verdict import Outcome, Verdict, unit_motion
from blockstat.certificate.check import Certificate, check
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import check_choice, known_options
from blockstat.imperfection.imperfections import Imperfections
from blockstat.loads import Loads
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer
from blockstat.solve.cvxpy import solve_on_paper
from blockstat.solve.dispatch import CHOICES
from blockstat.solve.penalty import solve_penalty
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

FLOWS = ("associated", "coulomb")
NONE = np.empty(0, dtype=np.int64)
#: What leaves an answer undecided, other than the accuracy of the numbers.
RIMS = "the blocks touch where forces have no definite direction, and these contacts may hold what falls without them"
OVERLAPS = "blocks overlap too far to have a joint, and may hold each other there"
CRUSHES = "contacts without area carry nothing, but the blocks would be driven into each other there"
BALANCED = "nothing holds some blocks, and the loads on them balance"
TIGHT = "without dilatancy and self-stress the blocks stand or fall with how tight the joints are"
NO_STATE = "a force field exists, but whether one does without dilatancy and self-stress was not found out"
#: Where all blocks are supports.
NOTHING_TO_CHECK = Certificate(0.0, 0.0, 0.0, 0.0, 0.0)


@known_options
def assess(
    assembly: Assembly,
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Loads | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
    flow: str = "associated",
    tightnesses: int = 0,
    memory: Memory | None = None,
    score: bool = True,
    imperfections: Imperfections | None = None,
) -> Verdict:
    """Give a static verdict on an assembly of rigid blocks with Coulomb joints.

    Solves the penalty program of Whiting et al. (2009) with the exact friction cone in its dual form. The independent
    check then judges the answer: stable rests on a force field, unstable on a mechanism.

    Parameters
    ----------
    assembly
        The blocks, their supports, friction, gravity and joint laws.
    friction
        Replaces the assembly's coefficient of friction.
    gravity
        Replaces its vector, shape (3,) [m/s2].
    loads
        Further wrench on each block about its centroid, shape (n_blocks, 6) [N, N m]. Those of a load case are its
        `weighted_loads` where densities are imperfect: its factor on the weight is then that of the densities judged.
    gap
        Tolerance of the joint search: a share of the block size, or a length such as "2 mm".
    interfaces
        Use these joints instead of searching.
    solver
        "auto", "interior-point" or "clarabel" for the dual program (see `blockstat.solve.dispatch`), "cvxpy" for the
        program as it is on paper, the reference. The verdict says which one answered.
    flow
        "associated" asks whether an admissible force field exists. "coulomb" asks in addition whether one exists
        without dilatancy and self-stress (see `blockstat.analysis.coulomb`), and answers STABLE_ONLY_BY_SELF_STRESS if
        not.
    tightnesses
        With flow="coulomb", at how many random tightnesses of the joints a state is looked for too. Each costs about as
        much as the verdict.
    memory
        Evidence of earlier designs with the same joints, which may decide without a solve (see
        `blockstat.analysis.certificate_cache`). An instability proven so has no score (nan).
    score
        False ends at the first mechanism found, several times sooner. An unstable assembly then has no score (nan), and
        its mechanism is one of many, not that of least adhesion: edges and corners in its way beyond the tolerance are
        not looked for.
    imperfections
        Judge the worst case of these (see `blockstat.Imperfections`). Its assembly and joints are those of the verdict.
        Without dilatancy and self-stress that the worst case is among those judged is no theorem.

    Returns
    -------
    Verdict
        The outcome with the forces or the mechanism that prove it.

    Raises
    ------
    InputError
        When nothing supports the assembly, when blocks overlap, or for an option that does not exist.

    References
    ----------
    Whiting, Ochsendorf & Durand: Procedural modeling of structurally-sound masonry buildings, 2009.

    Examples
    --------
    >>> from blockstat import Assembly, assess
    >>> from blockstat.model.solids import box
    >>> ground = box((-1, -1, -1), (2, 2, 0), name="ground", group="ground")
    >>> blocks = [ground, box((0, 0, 0), (1, 1, 1), name="block", group="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> assess(assembly).outcome.word
    'stable'
    >>> assess(assembly, gravity=(9.0, 0.0, -9.81), friction=2.0).outcome.word
    'stable'
    >>> assess(assembly, gravity=(9.0, 0.0, -9.81), friction=0.7).outcome.word
    'unstable'
    """
    check_choice("solver", solver, CHOICES)
    check_choice("flow", flow, FLOWS)
    problem = pose(assembly, friction=friction, gravity=gravity, loads=loads, gap=gap, interfaces=interfaces)
    options: dict[str, Any] = {"solver": solver, "flow": flow, "tightnesses": tightnesses, "score": score}
    if imperfections is not None:
        return _worst(problem, loads, imperfections, {"gap": gap, **options})
    verdict = judged(problem, loads=loads, memory=memory, **options)
    if not score or verdict.outcome is not Outcome.UNSTABLE:
        return verdict
    return replace(verdict, warnings=(*verdict.warnings, *near_edge_warnings(problem, verdict.mechanism)))


def _worst(problem: Problem, loads: Loads | None, imperfections: Imperfections, options: dict[str, Any]) -> Verdict:
    """The first case that does not stand, or else the one whose forces have the least slack."""
    verdicts = []
    for case in cases_of(problem, loads, imperfections):
        own = assess(case.assembly, loads=case.loads, interfaces=case.interfaces, **options)
        own = replace(own, worst=case.words, warnings=problem.warnings_with(own.warnings))
        if own.outcome is Outcome.UNSTABLE:
            return own
        verdicts.append(own)
    ranks = (Outcome.UNDECIDED, Outcome.STABLE_ONLY_BY_SELF_STRESS, Outcome.STABLE)
    return min(verdicts, key=lambda own: (ranks.index(own.outcome), own.certificate.slack))


def judged(
    problem: Problem,
    *,
    loads: Loads | None = None,
    solver: str = "auto",
    flow: str = "associated",
    tightnesses: int = 0,
    memory: Memory | None = None,
    score: bool = True,
    reserve: bool = True,
    guess: Floats | None = None,
    kinds: Sequence[tuple[float, float]] = FAMILY,
) -> Verdict:
    """Give the verdict on a posed problem.

    Parameters
    ----------
    problem
        The problem.
    loads, solver, flow, tightnesses, memory, score
        As in `assess`; the loads are those that the problem was posed with.
    reserve
        False does not ask whether a stable assembly is balanced without reserve, nor which doubtful joints it rests on.
    guess
        Forces from which to look for forces in balance first, in the units of the program, shape (m, 3).
    kinds
        With flow="coulomb", the kinds of joints in which a state is looked for.

    Returns
    -------
    Verdict
        As of `assess`.
    """
    timings = dict(problem.timings)
    answer = checked = state = None
    falling = NONE
    if problem.program is not None:
        answer, checked = _solved(problem, problem.program, solver, memory, timings, score, guess)
        if flow == "coulomb" and problem.slips and outcome_of(checked.certificate) is Outcome.STABLE:
            with timed(timings, "coulomb"):
                state, falling = _settled(problem, problem.program, checked.force, loads, solver, kinds, tightnesses)
    timings["total"] = sum(timings.values())
    verdict = replace(_verdict(problem, answer, checked, timings), loads=loads)
    if reserve and verdict.outcome is Outcome.STABLE and checked is not None:
        verdict = _with_reserve(problem, verdict, checked, loads, _second(solver))
    if verdict.outcome is Outcome.UNSTABLE and (warnings := rim_warnings(problem, verdict.mechanism)):

        def judge(joints: Interfaces) -> Verdict:
            return judged(with_joints(problem, joints, loads), loads=loads, solver=solver, score=False)

        verdict = _beyond_doubt(verdict, judged_with_rims(problem, verdict.mechanism, judge), warnings)
    if flow == "associated":
        return verdict
    return replace(_with_state(problem, verdict, state), falling=falling)


def _settled(
    problem: Problem,
    program: PenaltyProgram,
    force: Floats,
    loads: Loads | None,
    solver: str,
    kinds: Sequence[tuple[float, float]],
    tightnesses: int,
) -> tuple[CoulombState, Ints]:
    """What is known of a Coulomb state, and the blocks of which it is proven that only self-stress holds them.

    Where blocks fall freely while the others rest without them, a state counts only if joints of every kind have one:
    then the others press on them as their joints give way, whatever these are. A state in joints of one kind alone is a
    thrust between blocks that have jammed, and its joints are as tight as it takes.
    """
    second = _second(solver)
    falling = _falling_from_the_others(problem, loads, solver)
    if not len(falling):
        return coulomb_state(program, kinds=kinds, tightnesses=tightnesses, solver=second), NONE
    if len(np.setdiff1d(problem.assembly.free, falling)):
        state = state_in_every_kind(program, tightnesses=tightnesses, solver=second)
        if state is not None:
            return replace(state, clamped=falling), NONE
    joint: Any = np.isin(problem.interfaces.pair, falling).any(axis=1)
    points = np.zeros(len(force), dtype=bool)
    points[: program.n_points] = joint[problem.interfaces.point_interface[problem.eq.points]]
    return CoulombState.of_falling(program, force, points), falling


def _falling_from_the_others(problem: Problem, loads: Loads | None, solver: str) -> Ints:
    """Blocks that fall freely from joints that nothing has pressed while the others rest without them.

    The largest set that may fall is tried first. Where the others move without it, those of its blocks that touch what
    moves may be what holds it: they are left with the others, and so is what rests on them.
    """
    held, pair = NONE, problem.interfaces.pair
    while len(falling := falling_freely(problem, loads, held)):
        if not len(np.setdiff1d(problem.assembly.free, falling)):
            return falling
        support = problem.assembly.support.copy()
        support[falling] = True
        apart = problem.interfaces.subset(np.flatnonzero(~np.isin(pair, falling).any(axis=1)))
        as_posed: Any = {"friction": None, "gravity": None, "loads": loads, "gap": problem.gap}
        posed = pose(problem.assembly.with_(support=support), interfaces=apart, **as_posed)
        others = judged(posed, loads=loads, solver=solver, flow="coulomb", reserve=False)
        if others.outcome is Outcome.STABLE:
            return falling
        leaned = np.intersect1d(falling, pair[np.isin(pair, others.moving).any(axis=1)])
        if others.outcome is not Outcome.UNSTABLE or not len(leaned):
            break
        held = np.union1d(held, leaned)
    return NONE


def falls_unloaded(problem: Problem, loads: Loads | None, solver: str) -> bool:
    """Return whether blocks fall freely under the dead load, so that only self-stress holds the assembly.

    Parameters
    ----------
    problem
        The posed problem of an assembly that is statically stable.
    loads
        Those that it was posed with.
    solver
        As in `assess`.

    Returns
    -------
    bool
        Whether that is proven.
    """
    if problem.program is None or not problem.slips or not len(falling_freely(problem, loads)):
        return False
    return bool(len(judged(problem, loads=loads, solver=solver, flow="coulomb", reserve=False).falling))


def _with_state(problem: Problem, verdict: Verdict, state: CoulombState | None) -> Verdict:
    """The verdict with a Coulomb state behind it, whose forces it then shows, or with what speaks against one."""
    verdict = replace(verdict, flow="coulomb")
    if state is None or problem.program is None or verdict.outcome is not Outcome.STABLE:
        return verdict
    points = problem.eq.points[state.held]
    held = np.unique(problem.interfaces.point_interface[points])
    if state.settles is not True:
        outcome = Outcome.STABLE_ONLY_BY_SELF_STRESS if state.settles is False else Outcome.UNDECIDED
        because = TIGHT if state.unequal else NO_STATE
        return replace(verdict, outcome=outcome, coulomb=state, held=held, because=because)
    return replace(
        verdict,
        coulomb=state,
        forces=problem.to_points(state.force),
        bonds=problem.to_bonds(state.force),
        ties=problem.to_ties(state.force),
        certificate=check(problem.program, state.force, np.zeros(len(problem.program.load))),
        displacement=unit_motion(problem.assembly, problem.to_blocks(state.displacement)),
    )


def _solved(
    problem: Problem,
    program: PenaltyProgram,
    solver: str,
    memory: Memory | None,
    timings: dict[str, float],
    score: bool,
    guess: Floats | None,
) -> tuple[Answer, Answer]:
    """An answer, and the same with what the independent check makes of it: an earlier one if there is one that proves.

    The forces of the first balance with its adhesion, those of the second without.
    """
    if memory is not None:
        with timed(timings, "memory"):
            known = memory.recall(problem)
        if known is not None:
            return known, known
    with timed(timings, "solve"):
        if solver == "cvxpy":
            answer = solve_on_paper(program)
        else:
            answer = solve_penalty(program, solver=solver, motions=problem.motions, score=score, guess=guess)
    with timed(timings, "certificate"):
        checked = decide(program, answer, solver=_second(solver), motions=problem.motions)
    if memory is not None:
        memory.keep(problem, checked)
    return answer, checked


def _with_reserve(problem: Problem, verdict: Verdict, checked: Answer, loads: Loads | None, solver: str) -> Verdict:
    """A stable verdict with what it has no reserve against, and the doubtful joints that it rests on."""
    neutral = neutral_blocks(problem, checked, solver=solver)
    warnings = neutral_warning(problem, neutral)

    def again(joints: Interfaces) -> Outcome | None:
        posed = with_joints(problem, joints, loads)
        bare = judged(posed, loads=loads, solver=solver, score=False, reserve=False)
        return Outcome.STABLE if bare.outcome is Outcome.STABLE else None

    warnings += resting_warning(problem, verdict.forces, Outcome.STABLE, again, "stable")
    return replace(verdict, neutral=neutral, warnings=(*verdict.warnings, *warnings)) if warnings else verdict


def _second(solver: str) -> str:
    """Who solves what follows the penalty program: cvxpy is the reference for that program alone."""
    return "clarabel" if solver == "cvxpy" else solver


def _verdict(problem: Problem, answer: Answer | None, checked: Answer | None, timings: dict[str, float]) -> Verdict:
    """Back to SI units and to all blocks and points; blocks that nothing holds fall freely."""
    outcome, certificate, score, because = Outcome.STABLE, NOTHING_TO_CHECK, 0.0, ""
    force, adhesion, twist = np.empty((0, 3)), np.empty(0), np.empty(0)
    if answer is not None and checked is not None and problem.program is not None:
        certificate, outcome = checked.certificate, outcome_of(checked.certificate)
        if outcome is Outcome.STABLE:
            force, adhesion, twist = checked.force, np.zeros(problem.eq.n_points), np.zeros_like(checked.twist)
        else:
            force, adhesion, twist = answer.force, np.nan_to_num(answer.adhesion), checked.twist
            pull = float(np.linalg.norm(problem.eq.load[:, :3], axis=1).sum()) or 1.0
            missing = float(np.linalg.norm(answer.adhesion)) * problem.program.force_unit
            score = missing / pull if answer.bounded else np.inf
    mechanism = problem.to_blocks(twist)
    if len(problem.floating):
        # Each group moves along its load as one: no joint closes, so this is a proof without any error.
        falling = free_fall(problem)
        work = float((falling * problem.load).sum() / (np.abs(problem.load).sum() or 1.0))
        if work > 0:
            outcome, score, mechanism = Outcome.UNSTABLE, np.inf, falling
            certificate = replace(certificate, work=work, mechanism_violation=0.0, required_force=np.inf)
        elif outcome is Outcome.STABLE:
            outcome, because = Outcome.UNDECIDED, BALANCED
    blocked: list[str] = []
    if outcome is Outcome.UNSTABLE:
        motion = unit_motion(problem.assembly, mechanism)
        blocked = overlap_warnings(problem, motion)
        if blocked or crushes(problem, motion):
            outcome, because = Outcome.UNDECIDED, OVERLAPS if blocked else CRUSHES
    return Verdict(
        outcome=outcome,
        score=score,
        forces=problem.to_points(force),
        adhesion=problem.adhesion_at_points(adhesion),
        mechanism=unit_motion(problem.assembly, mechanism),
        certificate=certificate,
        interfaces=problem.interfaces,
        assembly=problem.assembly,
        solver=answer.solver if answer is not None else "none",
        timings=timings,
        floating=problem.floating,
        warnings=(*problem.warnings, *blocked, *gap_warnings(problem, more_may_help=outcome is not Outcome.STABLE)),
        bonds=problem.to_bonds(force),
        ties=problem.to_ties(force),
        because=because,
    )


def _beyond_doubt(verdict: Verdict, held: Verdict, warnings: list[str]) -> Verdict:
    """Unstable where the blocks fall whatever contacts without a unique normal carry, undecided elsewhere."""
    if held.outcome is Outcome.UNSTABLE:
        return replace(verdict, mechanism=held.mechanism, certificate=held.certificate)
    return replace(verdict, outcome=Outcome.UNDECIDED, because=RIMS, warnings=(*verdict.warnings, *warnings))
