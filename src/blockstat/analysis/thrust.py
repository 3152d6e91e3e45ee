"""Least and greatest thrust on supports: conic programs over the forces that an assembly admits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.decision import ASSUMED_FORCE, SHARES, decide, outcome_of
from blockstat.analysis.limit_load import UNBOUNDED
from blockstat.analysis.problem import Problem, crushes, pose, with_joints
from blockstat.analysis.reserve import SLIVER, moved, resting_warning
from blockstat.analysis.rims import overlap_warnings, rim_warnings
from blockstat.analysis.verdict import Outcome, unit_motion
from blockstat.certificate import check as certificate
from blockstat.certificate.check import FORCE_LIMIT
from blockstat.certificate.functional_bound import value_bound
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.overlap.penetration import overlaps
from blockstat.errors import InputError, check_choice, check_vector, known_options
from blockstat.loads import Loads
from blockstat.program.conic import conic_program
from blockstat.program.ties import bearing_ties, tie_wrenches
from blockstat.result import Result, Sentence, finite
from blockstat.solve.answer import Answer
from blockstat.solve.dispatch import CHOICES, solve
from blockstat.solve.penalty import solve_penalty
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.program.equilibrium import Columns
    from blockstat.program.penalty import PenaltyProgram

#: An extreme is proven when what is proven not to be exceeded lies no further from it than this, relative to it or to
#: the weight.
SHARP = 1e-5
#: A functional grows without end where forces in balance raise it by so many weights; more is tried first, where the
#: forces that it takes are not beyond what a certificate believes.
RAISED = (UNBOUNDED, 1e-1 * UNBOUNDED, 1e-2 * UNBOUNDED)
#: What a unit of normal force costs; the next is taken where the forces of one cannot be proven. Among forces that do
#: as well a solver takes any, and in jammed blocks these drift along a self-stress, beyond what a certificate believes.
#: At the last price only such rays pay that raise the functional by the least of `RAISED` within that.
PRICES = (0.0, 1e-11, 1e-9, 1e-7, 1e-5, RAISED[-1] / FORCE_LIMIT)
UNPROVEN = "an end of the range is not proven"
NO_FORCES = f"{UNPROVEN}: the solver found no forces for it"
NO_RAY = f"{UNPROVEN}: self-stress may move it without end, but none of up to a million weights in total shows that"


class ThrustOutcome(Sentence):
    """The answers of `thrust_range`; each value is the sentence a user reads."""

    BOUNDED = "Bounded: the thrust lies between a least and a greatest value, each carried by a proven force field."
    UNBOUNDED = "Unbounded: self-stress can raise the thrust without end; the least value is proven."
    NO_LEAST = "No least: self-stress can lower the thrust without end; the greatest value is proven."
    NO_ENDS = "No ends: self-stress can raise the thrust without end, and lower it."
    UNDECIDED = "Undecided: a proven force field carries each value told, but thrusts beyond them are not excluded."


@dataclass(frozen=True, eq=False)
class ThrustRange(Result):
    """Least and greatest force on some supports in one direction [N], each carried by a proven force field."""

    least: float  #: [N]
    greatest: float  #: [N], inf when self-stress can raise it without end
    least_forces: Floats  #: shape (n_points, 3) [N]
    greatest_forces: Floats  #: shape (n_points, 3) [N]; the ray for no greatest
    interfaces: Interfaces
    assembly: Assembly
    warnings: tuple[str, ...] = ()
    proven: bool = True  #: whether mechanisms prove that there is no thrust beyond both ends
    least_ties: Floats | None = None  #: force of each tie with `least_forces`, shape (n_ties,) [N]
    greatest_ties: Floats | None = None  #: with `greatest_forces`

    @property
    def outcome(self) -> ThrustOutcome:
        """Whether the thrust has a least and a greatest value."""
        if not self.proven:
            return ThrustOutcome.UNDECIDED
        if np.isfinite(self.greatest):
            return ThrustOutcome.BOUNDED if np.isfinite(self.least) else ThrustOutcome.NO_LEAST
        return ThrustOutcome.UNBOUNDED if np.isfinite(self.least) else ThrustOutcome.NO_ENDS

    def explain(self) -> str:
        """Return the answer and its evidence in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value, f"{self.least:.6g} N <= thrust <= {self.greatest:.6g} N"]
        return "\n".join([*lines, *(f"Warning: {text}" for text in self.warnings)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON; an infinite thrust is None.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "proven": self.proven,
            "least": finite(self.least),
            "greatest": finite(self.greatest),
            "blocks": self.assembly.n_blocks,
            "interfaces": self.interfaces.n_interfaces,
            "contacts": self.interfaces.contacts,
            "warnings": list(self.warnings),
        }


@known_options
def thrust_range(
    assembly: Assembly,
    supports: Sequence[int | str],
    direction: Sequence[float],
    *,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
) -> ThrustRange:
    """Find the least and the greatest force that an assembly can exert on some supports along a direction.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand.
    supports : sequence of str or int
        Names or numbers of support blocks.
    direction : sequence of float, shape (3,)
        Direction of the thrust, of any length; for an arch horizontal and outwards.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`.

    Returns
    -------
    ThrustRange
        Both ends, with the forces of each.

    Raises
    ------
    InputError
        When the assembly does not stand, for a block that is no support, or for an option that does not exist.

    Notes
    -----
    The thrust is all that the assembly does to the supports. So a tie between a support and a block counts with what
    presses on the support, whether its force is given or not: a tie that pulls a block down on a support leaves the
    thrust as it is. A tie between two supports acts on no block, and does not count.

    The thrust is linear in the contact forces, so both ends are conic programs over the admissible force fields. Each
    is proven from both sides: by a force field that carries it, and by a motion that no thrust beyond it can resist.
    Where the motion drives blocks into each other at contacts that are in no program, it proves nothing, and the
    outcome is "undecided", as in `blockstat.limit_load`.

    References
    ----------
    Heyman, J. (1966). The stone skeleton. Int. J. Solids Struct. 2, 249-279.

    Examples
    --------
    A brick that leans on nothing pushes its ground down with its weight.

    >>> import blockstat
    >>> from blockstat import Assembly, Block
    >>> from blockstat import box
    >>> ground, brick = box((0, 0, -1), (1, 1, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="brick")
    >>> wall = Assembly.from_blocks([ground, brick], supports=["ground"], density=1000.0)
    >>> found = blockstat.thrust_range(wall, ["ground"], (0, 0, -1))
    >>> print(f"{found.least:.1f} N to {found.greatest:.1f} N")
    9810.0 N to 9810.0 N
    """
    problem, inside = standing(
        assembly, friction=friction, gravity=gravity, loads=loads, gap=gap, interfaces=interfaces, solver=solver
    )
    numbers = support_indices(problem.assembly, supports)
    given = _given(problem, numbers, direction)
    problem, away = with_overlaps(problem), np.zeros((problem.assembly.n_blocks, 6))
    away[numbers, :3] = check_vector("direction", direction) / np.linalg.norm(direction)

    def ends(problem: Problem, inside: Floats) -> tuple[Extreme, Extreme]:
        thrust = _functional(problem, numbers, direction)
        least = extreme(problem, -thrust, inside, solver, supports=away)
        return least, extreme(problem, thrust, inside, solver, supports=-away)

    least, greatest = ends(problem, inside)
    doubts = range_warning(problem, least, greatest, ends, "the thrust", given=given, loads=loads, solver=solver)
    return ThrustRange(
        least=given - least.value,
        greatest=given + greatest.value,
        least_forces=least.forces,
        greatest_forces=greatest.forces,
        proven=least.proven and greatest.proven,
        least_ties=least.ties,
        greatest_ties=greatest.ties,
        interfaces=problem.interfaces,
        assembly=problem.assembly,
        warnings=tuple(dict.fromkeys([*problem.warnings, *least.doubts, *greatest.doubts, *doubts])),
    )


def range_warning(
    problem: Problem,
    least: Extreme,
    greatest: Extreme,
    ends: Callable[[Problem, Floats], tuple[Extreme, Extreme]],
    called: str,
    *,
    given: float = 0.0,
    loads: Loads | None,
    solver: str,
) -> list[str]:
    """Say which doubtful joints the ends of a range rest on, and where they are without them.

    Parameters
    ----------
    problem : Problem
        The posed problem.
    least, greatest : Extreme
        Of a functional with its sign turned, and of the functional.
    ends : callable
        Gives both for a problem and forces strictly inside its cones.
    called : str
        The functional in words.
    given : float, optional
        What is added to it [N].
    loads
        Those that the problem was posed with.
    solver : str
        As in `blockstat.assess`.

    Returns
    -------
    list of str
        A sentence, or none.
    """
    assert problem.program is not None

    def values(least: Extreme, greatest: Extreme) -> tuple[float, float]:
        return given - least.value, given + greatest.value

    def again(joints: Interfaces) -> tuple[float, float] | None:
        stood = standing_on(problem, joints, loads, solver)
        return None if stood is None else values(*ends(*stood))

    found = values(least, greatest)
    bounds = [abs(end) for end in found if np.isfinite(end)]
    room = SLIVER * max(bounds, default=0.0) + 2 * SHARP * problem.program.total_load * problem.program.force_unit

    def words(found: tuple[float, float]) -> str:
        low, high = (end if abs(end) > room else 0.0 for end in found)
        return f"lies between {low:.6g} N and {high:.6g} N"

    return resting_warning(
        problem,
        np.abs(least.forces) + np.abs(greatest.forces) if len(bounds) == 2 else None,  # rays are no forces
        found,
        again,
        f"{called} {words(found)}",
        worse=lambda bare, last: any(moved(*pair, room) for pair in zip(bare, last, strict=True)),
        words=lambda bare: f"it {words(bare)}",
    )


def standing(
    assembly: Assembly, *, solver: str, otherwise: str = "this is asked of what stands", **options: Any
) -> tuple[Problem, Floats]:
    """Return the problem of an assembly that stands, and a force field strictly inside its cones.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    solver : str
        As in `blockstat.assess`.
    otherwise : str, optional
        What the error says of an assembly that does not stand.
    **options
        Those of `pose`.

    Returns
    -------
    problem : Problem
        The posed problem.
    inside : array of float, shape (m, 3)
        Forces of its program.

    Raises
    ------
    InputError
        When the assembly does not stand, or is not proven to.
    """
    check_choice("solver", solver, CHOICES)
    problem = pose(assembly, **options)
    if not len(problem.assembly.free):
        raise InputError(f'"{assembly.name}": all blocks are supports; none can move or carry')
    outcome, force = _balanced(problem, solver)
    if outcome is Outcome.UNDECIDED:
        raise InputError(f'"{assembly.name}" is neither proven to stand as it is nor to fall')
    if outcome is not Outcome.STABLE:
        raise InputError(f'"{assembly.name}" does not stand as it is; {otherwise}')
    return problem, force


def _balanced(problem: Problem, solver: str) -> tuple[Outcome, Floats]:
    """Whether a problem has forces that balance it, and these."""
    if problem.program is None or len(problem.floating):
        return Outcome.UNSTABLE, np.empty((0, 3))
    posed = {"solver": solver, "motions": problem.motions}
    found = decide(problem.program, solve_penalty(problem.program, **posed), **posed)
    return outcome_of(found.certificate), found.force


def standing_on(
    problem: Problem, interfaces: Interfaces, loads: Loads | None, solver: str
) -> tuple[Problem, Floats] | None:
    """Return a problem with other joints, and a force field strictly inside its cones.

    Parameters
    ----------
    problem : Problem
        The posed problem.
    interfaces : Interfaces
        The joints.
    loads
        Those that it was posed with.
    solver : str
        As in `blockstat.assess`.

    Returns
    -------
    tuple or None
        As of `standing`; None where it is not proven to stand.
    """
    other = with_joints(problem, interfaces, loads)
    outcome, force = _balanced(other, solver)
    return (other, force) if outcome is Outcome.STABLE else None


def support_indices(assembly: Assembly, supports: Sequence[int | str]) -> Ints:
    """Return the numbers of support blocks that are given by name or number.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    supports : sequence of str or int
        Names or numbers.

    Returns
    -------
    array of int
        Numbers of the blocks, each once.

    Raises
    ------
    InputError
        For a block that is no support, naming the supports.
    """
    given = assembly.blocks_named(supports, "supports")
    indices = given[np.sort(np.unique(given, return_index=True)[1])]
    for index in indices[~assembly.support[indices]]:
        names = ", ".join(assembly.names[i] for i in np.flatnonzero(assembly.support)[:8])
        raise InputError(f'supports: "{assembly.names[index]}" is no support; supports are: {names}')
    return indices


def _functional(problem: Problem, supports: Ints, direction: Sequence[float]) -> Floats:
    """Row c with c' f the force on the supports along the direction, in scaled units, shape (3 m,)."""
    return np.concatenate([_on_supports(columns, supports, direction) for columns in problem.eq.columns])


def _on_supports(columns: Columns, supports: Ints, direction: Sequence[float]) -> Floats:
    """What unit forces of columns do to the supports along the direction, shape (3 n,)."""
    unit = check_vector("direction", direction)
    sign = np.isin(columns.pair[:, 1], supports).astype(float) - np.isin(columns.pair[:, 0], supports)
    return (sign[:, None] * (columns.force @ unit)).reshape(-1) / np.linalg.norm(unit)


def _given_wrenches(assembly: Assembly) -> Floats:
    """What the ties whose force is given do to the blocks and supports [N, N m], ties from support to support aside."""
    ties = [tie for tie in bearing_ties(assembly) if tie.constant]
    return tie_wrenches(assembly, ties, np.array([tie.least for tie in ties]))


def _given(problem: Problem, supports: Ints, direction: Sequence[float]) -> float:
    """What the ties whose force is given do to the supports along the direction [N]."""
    unit = check_vector("direction", direction)
    return float((_given_wrenches(problem.assembly)[supports, :3] @ unit).sum() / np.linalg.norm(unit))


def value(problem: Problem, functional: Floats, force: Floats) -> float:
    """Return a functional of contact forces, the joint laws' shift of the program's forces taken off.

    Parameters
    ----------
    problem : Problem
        The posed problem.
    functional : array of float, shape (3 m,)
        Its row.
    force : array of float, shape (m, 3)
        Forces of the program.

    Returns
    -------
    float
        [N] times the unit of the row.
    """
    program = problem.program
    assert program is not None
    held = float(functional[::3] @ program.shift)
    return (float(functional @ force.reshape(-1)) - held) * program.force_unit


def power_on_supports(problem: Problem, rate: Floats, motion: Floats, force: Floats) -> float:
    """Return the power of all that an assembly does to its supports as they move.

    Parameters
    ----------
    problem : Problem
        The posed problem.
    rate : array of float, shape (m, 3)
        What `Problem.rates_by_supports` gives for the movement.
    motion : array of float, shape (n_blocks, 6)
        Of the supports that move whole, zero elsewhere.
    force : array of float, shape (m, 3)
        Forces of the program.

    Returns
    -------
    float
        [N] times the unit of the movement. Contacts, bonds and ties count, also ties whose force is given.
    """
    return value(problem, rate.reshape(-1), force) + float((_given_wrenches(problem.assembly) * motion).sum())


@dataclass(frozen=True, eq=False)
class Extreme:
    """The largest value of a functional over admissible force fields."""

    value: float  #: [N], of the forces; inf where a ray of forces in balance raises it without end
    forces: Floats  #: admissible, shape (n_points, 3) [N]; the ray for a value without end
    ties: Floats | None  #: force of each tie, shape (n_ties,) [N]; None without ties
    doubts: tuple[str, ...] = ()  #: why no motion proves that there is no larger value; none with a ray

    @property
    def proven(self) -> bool:
        """Whether a motion proves that there is no larger value, or the ray that there is no largest."""
        return not self.doubts


def with_overlaps(problem: Problem) -> Problem:
    """Return a problem with the pairs of blocks that overlap, so that these are looked for once.

    Parameters
    ----------
    problem : Problem
        The posed problem.

    Returns
    -------
    Problem
        The same.
    """
    if problem.overlapping is not None:
        return problem
    return replace(problem, overlapping=overlaps(problem.assembly, gap=problem.gap)[0])


def extreme(
    problem: Problem, functional: Floats, inside: Floats, solver: str, supports: Floats | None = None
) -> Extreme:
    """Find the largest value of a functional over admissible force fields.

    Parameters
    ----------
    problem : Problem
        The posed problem.
    functional : array of float, shape (3 m,)
        Its row.
    inside : array of float, shape (m, 3)
        Forces strictly inside their cones, as `standing` returns them.
    solver : str
        As in `blockstat.assess`.
    supports : array of float, shape (n_blocks, 6), optional
        Velocities of the supports of which the functional is the work, with its sign turned.

    Returns
    -------
    Extreme
        The value, with the forces that carry it.
    """
    program = problem.program
    assert program is not None
    field, twists, doubt = inside, [], NO_FORCES
    for answer in optima(program, -functional, solver):
        if answer.status.is_infeasible:
            if _grows(program, functional, answer.force, inside):
                return Extreme(np.inf, problem.to_points(answer.force), problem.to_ties(answer.force))
            doubt = NO_RAY
        elif not answer.status.is_stalled:
            twists.append(answer.twist)
            found = admissible(program, certificate.balance(program, answer.force), inside)
            if found is not None:
                field = found
                break
    doubts = _doubts(problem, functional, twists, field, supports) if twists and doubt != NO_RAY else [doubt]
    return Extreme(value(problem, functional, field), problem.to_points(field), problem.to_ties(field), tuple(doubts))


def _doubts(
    problem: Problem, functional: Floats, twists: Sequence[Floats], field: Floats, supports: Floats | None
) -> list[str]:
    """Why the best of some motions does not prove that a functional is largest under a field; nothing where it does."""
    program = problem.program
    assert program is not None
    total = ASSUMED_FORCE * float(np.linalg.norm(field, axis=1).sum())
    bounds = [value_bound(program, functional, twist, total, problem.motions()) for twist in twists]
    found = value(problem, functional, field) / program.force_unit
    beyond = min(bounds) - float(functional[::3] @ program.shift) - found
    motion = problem.to_blocks(twists[int(np.argmin(bounds))]) + (0.0 if supports is None else supports)
    motion = unit_motion(problem.assembly, motion)
    doubts = overlap_warnings(problem, motion) or rim_warnings(problem, motion)
    if crushes(problem, motion):
        doubts.append(f"{UNPROVEN}: the motion that bounds it crushes contacts without area")
    if beyond > SHARP * max(program.total_load, abs(found)):
        past = f"{beyond * program.force_unit:.3g} N past the value"
        doubts.append(f"{UNPROVEN}: the motion that bounds it does so {past}")
    return doubts


def _grows(program: PenaltyProgram, functional: Floats, ray: Floats, inside: Floats) -> bool:
    """Whether forces without a load raise a functional beyond all that counts, added to forces in balance."""
    rise = float(functional @ ray.reshape(-1))
    if not rise > 0:
        return False
    nothing = np.zeros_like(program.load)
    for weights in RAISED:
        field = certificate.balance(program, inside + weights * program.total_load / rise * ray)
        raised = float(functional @ (field - inside).reshape(-1))
        if raised >= 0.5 * weights * program.total_load and certificate.check(program, field, nothing).proves_stable:
            return True
    return False


def optima(program: PenaltyProgram, cost: Floats, solver: str) -> Iterator[Answer]:
    """Yield forces in balance of the least cost, then those that are ever smaller and cost a little more.

    Parameters
    ----------
    program : PenaltyProgram
        The program.
    cost : array of float, shape (3 m,)
        Of each force.
    solver : str
        As in `blockstat.assess`.

    Yields
    ------
    Answer
        At each of `PRICES`.
    """
    for price in PRICES:
        priced = cost.copy()
        priced[::3] += price
        yield solve(conic_program(program, -program.load, offset=priced), solver=solver)


def admissible(program: PenaltyProgram, balanced: Floats, inside: Floats) -> Floats | None:
    """Return a field, mixed with as little as it takes of one strictly inside its cones to be proven.

    Parameters
    ----------
    program : PenaltyProgram
        The program.
    balanced : array of float, shape (m, 3)
        Forces that balance it.
    inside : array of float, shape (m, 3)
        Forces strictly inside their cones, as `standing` returns them.

    Returns
    -------
    array of float, shape (m, 3), or None
        Admissible forces; None where no mixture can be proven.
    """
    for share in SHARES:
        mixed = (1 - share) * balanced + share * inside
        if certificate.check(program, mixed, np.zeros_like(program.load)).proves_stable:
            return mixed
    return None
