"""Limit analysis: how much of a load an assembly carries, with a proven bracket.

The kinematic program min -w' u subject to l' u = 1, A' u in K* (Livesley 1978, with the exact cone) gives the
mechanism and, as multipliers, the forces. Neither is trusted: the lower bound comes from a force field and the
upper bound from a mechanism that our own code has checked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import FLOWS, falls_unloaded
from blockstat.analysis.coulomb import multiplier_brackets
from blockstat.analysis.decision import Bound, decide, narrowed, outcome_of, proven_bounds
from blockstat.analysis.problem import Problem, cases_of, crushes, free_fall, pose, timed, with_joints
from blockstat.analysis.reserve import limit_warning
from blockstat.analysis.rims import gap_warnings, judged_with_rims, overlap_warnings, rim_warnings
from blockstat.analysis.verdict import Outcome, fastest_first, mechanism_words, moving_joints, unit_motion
from blockstat.certificate.bracket import ROUNDING, Bracket, Progress, in_units, is_closed, without_rounding
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_choice, known_options
from blockstat.imperfection.imperfections import Imperfections
from blockstat.loads import Loads, as_load
from blockstat.program.bonds import Bonds
from blockstat.program.conic import ConicProgram, conic_program
from blockstat.program.penalty import PenaltyProgram, as_strong_as_the_weight
from blockstat.result import Result, Sentence, finite
from blockstat.solve import interior_point
from blockstat.solve.answer import Answer, EarlyEnd, Status, no_answer
from blockstat.solve.dispatch import CHOICES, pays, solve
from blockstat.solve.penalty import solve_penalty
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A load that is carried until it is so many times as strong as the weight is called unbounded: no stone of 0.2 m
#: bears that, as granite of 500 MPa carries a column of its own of 20 km at most.
UNBOUNDED = 1e5
#: A bracket wider than this, relative to its upper end, is asked of the other solver too: up to so many unknowns, and
#: beyond, where that costs more than all the rest.
SHARP, CHEAP, LOOSE = 1e-7, 2_000, 1e-3
#: From this tolerance on the bracket is proven on the way. Narrower ones need the optimum, and what corrects its forces
#: and its mechanism: near it the normal equations no longer keep the forces of the iterates in balance.
ON_THE_WAY = 1e-5
#: Width of a bracket, relative to its upper end, that tells a limit well enough for an engineer.
TOLERANCE = 1e-4


#: What a multiplier alone leaves open.
DILATES = 'Friction is associated: joints dilate as they slide, and real ones may carry less (see flow="coulomb").'
INTERRUPTED = "stopped before every kind of joints without dilatancy was bracketed"
JAMS = "joints that dilate as they slide carry any multiple; without dilatancy some kinds of joints were not found to"


class LoadOutcome(Sentence):
    """The answers of a limit analysis; each value is the sentence a user reads."""

    LIMIT = "Limit: the assembly carries the load up to the lower bound, and not beyond the upper one."
    UNBOUNDED = "Unbounded: the assembly carries any multiple of the load."
    DEAD_LOAD_UNSTABLE = "Infeasible under dead load: the assembly does not stand without the load."
    UNDECIDED = "Undecided: no bracket as narrow as the tolerance could be proven."
    STOPPED = "Stopped: the assembly carries the load up to the lower bound, and not beyond the upper one."


@dataclass(frozen=True, eq=False)
class LimitLoad(Result):
    """A bracket on the limit load multiplier and the evidence for it."""

    outcome: LoadOutcome
    lower: float  #: multiplier that `forces` carry
    upper: float  #: multiplier at which `mechanism` moves
    forces: Floats  #: shape (n_points, 3) [N], balance dead load + lower x load; the dead load alone where unbounded
    mechanism: Floats  #: shape (n_blocks, 6), scaled so that the fastest corner moves by 1 m
    interfaces: Interfaces
    assembly: Assembly
    warnings: tuple[str, ...]
    timings: dict[str, float]
    #: With flow="coulomb", for stiff joints, elastic ones, and both (`blockstat.analysis.coulomb.FAMILY`):
    #: the multiplier up to which a checked state without dilatancy and self-stress was found, and the next at which
    #: there was none; infinite where one was found for a load `UNBOUNDED` times as strong as the weight. Not a theorem:
    #: these limits are not unique, as friction depends on history.
    coulomb_kinds: tuple[tuple[float, float], ...] = ()
    bonds: Bonds | None = None  #: what the bonds at the centres of joints carry with `forces`
    ties: Floats | None = None  #: tension of each tie, or compression of each strut, with `forces`, (n_ties,) [N]
    iterations: int = 0  #: factorisations of the programs of the dead load and of the multiplier
    worst: str = ""  #: the case of the imperfections that this bracket is of, the worst one, in words
    loads: Loads | None = None  #: permanent loads beside the weight that it was found under, of the worst case

    @property
    def coulomb(self) -> tuple[float, float] | None:
        """The bracket of those joints that carry most without dilatancy and self-stress; None if not asked for."""
        return max(self.coulomb_kinds, default=None)

    @property
    def coulomb_least(self) -> tuple[float, float] | None:
        """The bracket of those joints that carry least; None if not asked for."""
        return min(self.coulomb_kinds, default=None)

    @property
    def moving(self) -> Ints:
        """Blocks that move in the mechanism, fastest first."""
        return fastest_first(self.assembly, self.mechanism)

    @property
    def gap(self) -> float:
        """Width of the bracket relative to its larger end."""
        if np.isinf(self.lower) or np.isinf(self.upper):
            return 0.0 if self.lower == self.upper else np.inf
        return (self.upper - self.lower) / max(abs(self.upper), abs(self.lower), 1e-300)

    def joints(self, *, tolerance: float = 1e-4) -> dict[str, list[tuple[str, str]]]:
        """Return the joints that move in the mechanism, by kind.

        A hinge opens at one side and not at the other. A sliding joint shifts along itself (and opens at the rate
        friction asks for). An opening one loses contact everywhere. An edge or a corner that stays where it is, while
        its block turns about it, is a hinge too.

        Parameters
        ----------
        tolerance
            Of motion, relative to the fastest corner.

        Returns
        -------
        dict of str to list of tuple of str
            "hinges", "sliding" and "opening" pairs of block names.
        """
        return moving_joints(self.assembly, self.interfaces, self.mechanism, tolerance)

    def explain(self) -> str:
        """Return the answer in words.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value, *([f"Worst case of the imperfections: {self.worst}."] if self.worst else [])]
        if self.outcome in (LoadOutcome.LIMIT, LoadOutcome.STOPPED, LoadOutcome.UNDECIDED):
            below = f"{self.lower:.9g} <= " if np.isfinite(self.lower) else ""
            above = f" <= {self.upper:.9g}" if np.isfinite(self.upper) else ""
            lines += [f"{below}multiplier{above}"] if below or above else []
        if self.coulomb is not None and self.coulomb_least is not None:
            (low, high), (least, above) = self.coulomb, self.coulomb_least
            end = f"to {high:.5g}" if np.isfinite(low) else f"({UNBOUNDED:g} times the weight was tried)"
            lines.append(f"Without dilatancy and self-stress: {low:.5g} {end}")
            if above < low:
                lines.append(f"In the kind of joints that carries least: {least:.5g} to {above:.5g}")
        elif self.outcome in (LoadOutcome.LIMIT, LoadOutcome.STOPPED, LoadOutcome.UNBOUNDED):
            lines.append(DILATES)
        if self.outcome in (LoadOutcome.LIMIT, LoadOutcome.STOPPED):
            lines += mechanism_words(self.assembly, self.joints(), self.moving)
        if words := self.interfaces.contact_words:
            lines.append(f"Contacts: {words}.")
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; infinite bounds are None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "status": self.outcome.word,
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "lower": finite(self.lower),
            "upper": finite(self.upper),
            "iterations": self.iterations,
            "coulomb_lower": None if self.coulomb is None else finite(self.coulomb[0]),
            "coulomb_upper": None if self.coulomb is None else finite(self.coulomb[1]),
            "coulomb_least": None if self.coulomb_least is None else finite(self.coulomb_least[0]),
            "branch": None if self.coulomb is None else "without dilatancy and self-stress",
            "joints": self.joints(),
            "moving": [self.assembly.names[i] for i in self.moving],
            "blocks": self.assembly.n_blocks,
            "interfaces": self.interfaces.n_interfaces,
            "contacts": self.interfaces.contacts,
            "imperfections": self.worst or None,
            "warnings": list(self.warnings),
            "timings": self.timings,
        }


#: Outcome, lower and upper bound, scaled forces, scaled mechanism, iterations.
Found = tuple[LoadOutcome, float, float, Floats, Floats, int]


@known_options
def limit_load(
    assembly: Assembly,
    load: Any,
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Loads | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
    flow: str = "associated",
    tolerance: float = TOLERANCE,
    imperfections: Imperfections | None = None,
    optimum: bool = False,
    progress: Progress | None = None,
) -> LimitLoad:
    """Find the largest multiplier of a load that an assembly carries on top of its weight.

    The friction is associated: sliding joints dilate, so for real stone the multiplier is an upper bound. With
    flow="coulomb" the multiplier without dilatancy and self-stress is looked for below it, by bisection on
    `blockstat.analysis.coulomb`. It is not unique; the least and the largest of three kinds of joints are given. A load
    without limit is "unbounded" then only where all of them carry it, and "undecided" elsewhere.

    Parameters
    ----------
    assembly
        The blocks, their supports, friction, gravity and joint laws.
    load
        Three numbers, an acceleration direction (the multiplier is then in units of gravity), or a wrench on each
        block, shape (n_blocks, 6) [N, N m], as `blockstat.loads` makes them.
    friction
        Replaces the assembly's coefficient of friction.
    gravity
        Replaces its vector, shape (3,) [m/s2].
    loads
        Further wrench on each block about its centroid, shape (n_blocks, 6) [N, N m], which does not grow; of a load
        case with imperfect densities its `weighted_permanent`, or its `weighted_loads`, as in `blockstat.assess`.
    gap
        Tolerance of the joint search: a share of the block size, or a length such as "2 mm".
    interfaces
        Use these joints instead of searching.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.
    flow
        "associated" or "coulomb".
    tolerance
        Largest width of the bracket, relative to its upper end, with the outcome "limit"; widths below 2e-9 of a load
        as strong as the weight count as none, and an end is zero that adds to each block less than 2e-9 of what acts on
        it. Above 500 unknowns the solve ends as soon as the bracket is so narrow. Where one solver leaves it wider, the
        other is asked. A tolerance below 1e-5 asks for the optimum.
    imperfections
        Bracket the worst case of these (see `blockstat.Imperfections`), exactly. Its assembly and joints are those of
        the result.
    optimum
        Go on to the optimum, with all digits that the arithmetic leaves, where a wider bracket would do: for
        derivatives and differences.
    progress
        Told the iteration, the multiplier reached (not yet proven) and the proven upper bound, above 500 unknowns.
        With flow="coulomb" then, for each kind of joints from 0 on, the trial and the bracket until then. With it a
        KeyboardInterrupt ends the solve, and the outcome is "stopped" with the brackets until then; without it, and
        where several cases of `imperfections` are bracketed, it is raised.

    Returns
    -------
    LimitLoad
        A proven bracket, with the forces that carry the lower bound and the mechanism of the upper one.

    Raises
    ------
    InputError
        When nothing supports the assembly or all of it, when blocks overlap, for a tolerance that is not between 0 and
        0.1, or for an option that does not exist.

    References
    ----------
    Livesley: Limit analysis of structures formed from rigid blocks, 1978.

    Examples
    --------
    A block twice as high as wide tips when the push reaches half its weight.

    >>> from blockstat import Assembly, limit_load
    >>> from blockstat.model.solids import box
    >>> ground = box((-5, -5, -1), (5, 5, 0), name="ground", group="ground")
    >>> blocks = [ground, box((0, 0, 0), (1, 1, 2), name="block", group="block")]
    >>> found = limit_load(Assembly.from_blocks(blocks, supports=["ground"]), (1, 0, 0))
    >>> print(f"{found.lower:.6f} {found.upper:.6f}")
    0.500000 0.500000
    """
    check_choice("solver", solver, CHOICES)
    check_choice("flow", flow, FLOWS)
    if not (isinstance(tolerance, (int, float)) and 0 < tolerance <= 0.1):
        raise InputError(f"tolerance is {tolerance!r}; it must be above 0 and at most 0.1 of the limit")
    problem = pose(assembly, friction=friction, gravity=gravity, loads=loads, gap=gap, interfaces=interfaces)
    how: dict[str, Any] = {"solver": solver, "tolerance": tolerance, "optimum": optimum, "progress": progress}
    if imperfections is not None:
        options = {**how, "gap": gap, "flow": flow}
        brackets = []
        for case in cases_of(problem, loads, imperfections):
            own = limit_load(case.assembly, load, loads=case.loads, interfaces=case.interfaces, **options)
            if own.outcome is LoadOutcome.STOPPED:
                raise KeyboardInterrupt  # of the other cases nothing is known
            brackets.append(replace(own, worst=case.words, warnings=problem.warnings_with(own.warnings)))
        return min(brackets, key=lambda own: _carried(own, flow))
    if not len(problem.assembly.free):
        raise InputError(f'"{assembly.name}": all blocks are supports; there is nothing to load')
    return limited(problem, as_load(problem.assembly, load), loads, flow=flow, **how)


def limited(
    problem: Problem, load: Floats, loads: Loads | None, *, flow: str = "associated", reserve: bool = True, **how: Any
) -> LimitLoad:
    """Give the limit load of a posed problem.

    Parameters
    ----------
    problem
        The problem.
    load
        The load, shape (n_blocks, 6) [N, N m].
    loads
        Those that the problem was posed with.
    flow
        As in `limit_load`.
    reserve
        False does not ask which doubtful joints it rests on.
    **how
        The solver, tolerance, optimum and progress of `limit_load`; all but the last are needed.

    Returns
    -------
    LimitLoad
        As of `limit_load`.
    """
    timings, tolerance, progress = dict(problem.timings), how["tolerance"], how.pop("progress", None)

    def again(joints: Interfaces) -> LimitLoad:
        return limited(with_joints(problem, joints, loads), load, loads, reserve=False, **how)

    def carried_by(joints: Interfaces) -> float:
        return _bracket(with_joints(problem, joints, loads), load, **how)[1]

    with timed(timings, "solve"):
        outcome, lower, upper, force, twist, iterations = _bracket(problem, load, **how, progress=progress)
    bounded = outcome is not LoadOutcome.UNBOUNDED
    motion = unit_motion(problem.assembly, problem.to_blocks(twist))
    doubts = gap_warnings(problem, more_may_help=bounded, mechanism=motion) + ([] if bounded else problem.strengths)
    found = LimitLoad(
        outcome=outcome, lower=lower, upper=upper, forces=problem.to_points(force), mechanism=motion,
        interfaces=problem.interfaces, assembly=problem.assembly, warnings=(*problem.warnings, *doubts),
        bonds=problem.to_bonds(force), ties=problem.to_ties(force), loads=loads, iterations=iterations, timings=timings,
    )  # fmt: skip
    with timed(timings, "contacts without a normal or a width"):
        found = _beyond_doubt(problem, found, again, tolerance)
        if reserve and outcome is not LoadOutcome.STOPPED:  # who stops it does not wait for another
            thin = limit_warning(problem, found.forces, found.lower, tolerance, carried_by)
            found = replace(found, warnings=(*found.warnings, *thin))
    if flow == "coulomb" and outcome in (LoadOutcome.LIMIT, LoadOutcome.UNBOUNDED, LoadOutcome.STOPPED):
        with timed(timings, "coulomb"):
            found = _without_dilatancy(problem, found, load, loads, solver=how["solver"], progress=progress)
    timings["total"] = sum(timings.values())
    return found


def _carried(found: LimitLoad, flow: str) -> float:
    """The multiplier by which cases are ranked: nothing is known without dilatancy where no joints were tried."""
    return found.coulomb_least[0] if found.coulomb_least else min(found.lower, np.inf if flow == "associated" else 0.0)


def _without_dilatancy(problem: Problem, found: LimitLoad, load: Floats, loads: Any, **options: Any) -> LimitLoad:
    """The bracket with those of each kind of joints, all of which are to carry a load without limit."""
    outcome, warnings, kinds = found.outcome, found.warnings, ((found.lower, found.upper),)
    if (stopped := outcome is LoadOutcome.STOPPED) or found.lower <= 0:
        kinds = ((0.0, max(found.upper, 0.0)),)
    elif problem.program is not None and problem.slips:
        options |= {"falls": falls_unloaded(problem, loads, options["solver"]), "most": UNBOUNDED}
        kinds, stopped = multiplier_brackets(problem.program, problem.scaled(load), found.lower, **options)
    if stopped:
        outcome, warnings = LoadOutcome.STOPPED, (*warnings, INTERRUPTED)
    elif outcome is LoadOutcome.UNBOUNDED and np.isfinite(min(kinds)[0]):
        outcome, warnings = LoadOutcome.UNDECIDED, (*warnings, JAMS)
    return replace(found, outcome=outcome, coulomb_kinds=kinds, warnings=warnings)


def _beyond_doubt(problem: Problem, found: LimitLoad, again: Callable[..., LimitLoad], tolerance: float) -> LimitLoad:
    """The bracket with an upper bound that holds at contacts that are in no program, whatever these carry."""
    motion = unit_motion(problem.assembly, free_fall(problem)) if len(problem.floating) else found.mechanism
    if np.isposinf(found.upper) or not motion.any():
        return found
    upper, mechanism = np.inf, found.mechanism
    warnings = overlap_warnings(problem, motion)
    if not warnings and not crushes(problem, motion):
        warnings = rim_warnings(problem, motion)
        if not warnings:
            return found
        if found.outcome is not LoadOutcome.STOPPED:
            held = judged_with_rims(problem, motion, again)
            upper, mechanism = held.upper, held.mechanism
    closed = is_closed(found.lower, upper, tolerance)
    if closed if found.outcome is LoadOutcome.LIMIT else upper == found.upper == -np.inf:
        return replace(found, upper=upper, mechanism=mechanism)
    outcome = found.outcome if found.outcome is LoadOutcome.STOPPED else LoadOutcome.UNDECIDED
    return replace(found, outcome=outcome, upper=upper, mechanism=mechanism, warnings=(*found.warnings, *warnings))


def _bracket(problem: Problem, direction: Floats, solver: str, tolerance: float, **how: Any) -> Found:
    """What is found, with the iterations of the dead load."""
    program, eq = problem.program, problem.eq
    falls, unknown = (LoadOutcome.DEAD_LOAD_UNSTABLE, -np.inf, -np.inf), (LoadOutcome.UNDECIDED, -np.inf, np.inf)
    if program is None or len(problem.floating):
        # Where the loads of what floats balance each other, nothing moves it, and nothing holds it.
        known = falls if free_fall(problem).any() else unknown
        return *known, np.zeros((eq.n_columns, 3)), np.zeros(6 * eq.n_blocks), 0
    options = {"solver": solver, "motions": problem.motions}
    dead = decide(program, solve_penalty(program, **options, stands=True), **options)
    if (outcome := outcome_of(dead.certificate)) is not Outcome.STABLE:
        return *(falls if outcome is Outcome.UNSTABLE else unknown), dead.force, dead.twist, dead.iterations
    found = bracket(problem, dead.force, direction, solver, tolerance, **how)
    if found[0] is LoadOutcome.UNDECIDED and len(program.load) <= CHEAP:
        found = _by_verdicts(problem.scaled(direction), program, dead.force, found, tolerance, options)
    lower, upper = without_rounding(problem.scaled(direction), program.load, found[1], found[2])
    return found[0], lower, upper, found[3] if lower else dead.force, found[4], found[5] + dead.iterations


def _by_verdicts(
    load: Floats, program: PenaltyProgram, dead: Floats, found: Found, tolerance: float, options: dict[str, Any]
) -> Found:
    """A bracket that the optimum leaves undecided, narrowed by verdicts on single multipliers."""
    load, unit = as_strong_as_the_weight(program, load)
    ends = Bound(found[1] * unit, found[3]), Bound(found[2] * unit, found[4])
    low, high, spent = narrowed(program, load, *ends, tolerance=tolerance, most=UNBOUNDED, **options)
    if low.value >= UNBOUNDED:
        return LoadOutcome.UNBOUNDED, np.inf, np.inf, dead, np.zeros_like(load), found[-1] + spent
    outcome = LoadOutcome.LIMIT if is_closed(low.value, high.value, tolerance) else LoadOutcome.UNDECIDED
    return outcome, low.value / unit, high.value / unit, low.evidence, high.evidence, found[-1] + spent


def bracket(
    problem: Problem,
    dead: Floats,
    direction: Floats,
    solver: str,
    tolerance: float = TOLERANCE,
    *,
    optimum: bool = False,
    progress: Progress | None = None,
) -> Found:
    """Bracket the multiplier of a load on an assembly that is known to stand.

    Parameters
    ----------
    problem
        The posed problem.
    dead
        Forces with slack that balance the dead load, scaled, shape (m, 3).
    direction
        The load, shape (n_blocks, 6) [N, N m].
    solver
        One of `blockstat.solve.dispatch.CHOICES`.
    tolerance, optimum, progress
        As in `limit_load`.

    Returns
    -------
    tuple
        Outcome, lower and upper bound, scaled forces, shape (m, 3), scaled mechanism, shape (6 n,), and iterations.
    """
    program = problem.program
    assert program is not None
    load, unit = as_strong_as_the_weight(program, problem.scaled(direction))
    conic = conic_program(program, -program.load, pinned=load)
    on_the_way = Bracket(program, load, dead, tolerance, problem.motions, in_units(progress, unit))
    answer, stopped = _solved(conic, on_the_way if tolerance >= ON_THE_WAY and not optimum else None, dead, solver)
    iterations = answer.iterations
    if on_the_way.closed or stopped:
        outcome = LoadOutcome.LIMIT if on_the_way.closed else LoadOutcome.STOPPED
        lower = min(on_the_way.lower, on_the_way.upper) / unit
        return outcome, lower, on_the_way.upper / unit, on_the_way.force, on_the_way.twist, iterations
    if answer.status is Status.PRIMAL_INFEASIBLE or answer.multiplier > UNBOUNDED:
        return *_beyond_bounds(on_the_way, answer, dead, unit), np.zeros_like(load), iterations
    low, high = proven_bounds(program, load, answer, dead, solver=solver, motions=problem.motions)
    low = max(filter(None, (low, Bound(on_the_way.lower, on_the_way.force))), key=lambda bound: bound.value)
    if np.isfinite(on_the_way.upper):
        high = min(filter(None, (high, Bound(on_the_way.upper, on_the_way.twist))), key=lambda bound: bound.value)
    sharp = min(SHARP if len(program.load) <= CHEAP else LOOSE, tolerance)
    if solver == "auto" and not (low and high and high.value - low.value <= sharp * abs(high.value)):
        other = "interior-point" if answer.solver == "clarabel" else "clarabel"
        again = solve(conic, solver=other, early=EarlyEnd(sharp=True))
        iterations += again.iterations
        if not again.status.is_infeasible:
            second = proven_bounds(program, load, again, dead, solver=solver, motions=problem.motions)
            low = max((bound for bound in (low, second[0]) if bound), key=lambda bound: bound.value, default=None)
            high = min((bound for bound in (high, second[1]) if bound), key=lambda bound: bound.value, default=None)
    if low and low.value >= UNBOUNDED:
        return LoadOutcome.UNBOUNDED, np.inf, np.inf, dead, np.zeros_like(load), iterations
    # The dead load is carried, so a negative bound contradicts forces that are proven, and proves nothing.
    low, high = (bound if bound and bound.value >= -ROUNDING else None for bound in (low, high))
    lower, field = (low.value, low.evidence) if low else (0.0, dead)
    upper, twist = (high.value, high.evidence) if high else (np.inf, answer.twist)
    lower = min(lower, upper)  # both are proven to a tolerance, within which they may cross
    outcome = LoadOutcome.LIMIT if is_closed(lower, upper, tolerance) else LoadOutcome.UNDECIDED
    return outcome, lower / unit, upper / unit, field, twist, iterations


def _beyond_bounds(way: Bracket, answer: Answer, dead: Floats, unit: float) -> tuple[LoadOutcome, float, float, Floats]:
    """What is carried, and the forces, where a solver finds no limit or one beyond what bounded forces can prove."""
    way.carry(dead + UNBOUNDED * answer.force / (answer.multiplier if answer.multiplier > 0 else 1), UNBOUNDED)
    if way.lower >= (1.0 - ROUNDING) * UNBOUNDED:
        return LoadOutcome.UNBOUNDED, np.inf, np.inf, dead
    return LoadOutcome.UNDECIDED, way.lower / unit, np.inf, way.force


def _solved(conic: ConicProgram, on_the_way: Bracket | None, dead: Floats, solver: str) -> tuple[Answer, bool]:
    """The answer that closes the bracket on the way, or that of the optimum; and whether who watches has stopped it."""
    spent = 0
    if on_the_way is not None and conic.has_structure and pays(conic, solver):
        try:
            answer = interior_point.solve(conic, EarlyEnd(pair=on_the_way.narrow, inside=dead))
        except KeyboardInterrupt:
            if not on_the_way.watched:
                raise
            on_the_way.close()
            return no_answer(conic, on_the_way.iterates), True
        if on_the_way.closed or answer.status.is_infeasible:
            return answer, False
        spent = answer.iterations
    answer = solve(conic, solver=solver, early=EarlyEnd(sharp=True))
    return replace(answer, iterations=spent + answer.iterations), False
