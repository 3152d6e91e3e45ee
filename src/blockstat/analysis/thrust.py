"""Least and greatest thrust on supports, moving supports, and domains of two loads: linear programs over forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.bounds import SHARES
from blockstat.analysis.decision import decide, outcome_of
from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.analysis.problem import Problem, pose
from blockstat.analysis.verdict import Outcome
from blockstat.certificate import check as certificate
from blockstat.contact.interfaces import GAP, find_interfaces
from blockstat.errors import InputError
from blockstat.loads import as_load
from blockstat.program.conic import conic_program
from blockstat.program.equilibrium import column_rates
from blockstat.solve.dispatch import solve
from blockstat.solve.penalty import solve_penalty
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Two loads whose cosine is nearer to one than this are one load.
PARALLEL = 1e-9


@dataclass(frozen=True, eq=False)
class ThrustRange:
    """Least and greatest force on some supports in one direction [N], each carried by a proven force field."""

    least: float
    greatest: float  #: inf when self-stress can raise it without end
    least_forces: Floats  #: shape (n_points, 3) [N]
    greatest_forces: Floats


@dataclass(frozen=True, eq=False)
class Settlement:
    """What happens when a support begins to move."""

    mechanism: Floats  #: shape (n_blocks, 6), for unit movement of the supports [m/m, rad/m]
    forces: Floats  #: shape (n_points, 3) [N], the one state of the settling assembly
    reaction: float  #: force of the assembly on the moving supports along the movement [N]


@dataclass(frozen=True, eq=False)
class LoadDomain:
    """Pairs of multipliers (x, y) of two loads that are carried: between two polygons."""

    inner: Floats  #: shape (n, 2), proven by force fields, counter-clockwise
    outer: Floats  #: shape (n, 3), rows (a, b, c) of half-planes a x + b y <= c, proven by mechanisms


def thrust_range(
    assembly: Assembly, supports: Sequence[int | str], direction: Sequence[float], *, gap: float = GAP, **options: Any
) -> ThrustRange:
    """Least and greatest force that the assembly can exert on some supports along a direction.

    supports : names or indices of support blocks; direction : of the thrust, for an arch horizontal and outwards.
    Other options as in `assess`. Raises InputError when the assembly does not stand.
    """
    problem, inside = _standing(assembly, gap, options)
    thrust = _functional(problem, _support_indices(problem.assembly, supports), direction)
    solver = options.get("solver", "auto")
    least, least_forces = _extreme(problem, -thrust, inside, solver)
    greatest, greatest_forces = _extreme(problem, thrust, inside, solver)
    return ThrustRange(-least, greatest, least_forces, greatest_forces)


def settlement(
    assembly: Assembly, supports: Sequence[int | str], direction: Sequence[float], *, gap: float = GAP, **options: Any
) -> Settlement:
    """Mechanism, forces and reaction when supports begin to move along a direction.

    Minimises -w' u over motions with the supports' velocity given (the state of least potential energy): the forces
    are those of the thrust that resists the movement least.

    supports : names or indices of support blocks that move together; direction : of the movement, any length.
    Other options as in `assess`. Raises InputError when the assembly does not stand or jams.
    """
    problem, inside = _standing(assembly, gap, options)
    program = problem.program
    assert program is not None
    moving = _support_indices(problem.assembly, supports)
    thrust = _functional(problem, moving, direction)
    imposed = np.zeros((problem.assembly.n_blocks, 6))
    unit = np.asarray(direction, dtype=float)
    imposed[moving, :3] = unit / np.linalg.norm(unit)
    rate = column_rates(problem.assembly, problem.eq, imposed)
    moved = conic_program(program, -program.load, offset=rate.reshape(-1))
    answer = solve(moved, solver=options.get("solver", "auto"))
    if answer.status.is_infeasible:
        raise InputError(f'"{assembly.name}": the supports cannot move so; the blocks are jammed between them')
    force = _admissible(problem, certificate.balance(program, answer.force), inside)
    reaction = _value(problem, thrust, force)
    return Settlement(problem.to_blocks(answer.twist) + imposed, problem.to_points(force), reaction)


def load_domain(assembly: Assembly, one: Any, two: Any, *, directions: int = 32, **options: Any) -> LoadDomain:
    """The pairs of multipliers of two loads that the assembly carries, probed along rays from the dead load.

    one, two : loads as in `limit_load`. directions : number of rays, evenly spread. Other options as in `assess`.
    Raises InputError when the assembly does not stand or carries a combination without end.
    """
    first, second = as_load(assembly, one), as_load(assembly, two)
    shared = {"interfaces": find_interfaces(assembly, gap=options.pop("gap", GAP)), **options}
    if directions < 3:
        raise InputError(f"directions is {directions!r}; a polygon needs at least 3")
    cosine = float((first * second).sum() / np.sqrt((first**2).sum() * (second**2).sum()))
    if abs(cosine) > 1 - PARALLEL:
        raise InputError("the two loads are the same but for their size; they span no domain")
    inner, outer = [], []
    for angle in np.linspace(0, 2 * np.pi, directions, endpoint=False):
        x, y = np.cos(angle), np.sin(angle)
        limit = limit_load(assembly, x * first + y * second, **shared)
        if limit.outcome is not LoadOutcome.LIMIT:
            raise InputError(f"along ({x:.3g}, {y:.3g}): {limit.outcome.value}")
        inner.append((limit.lower * x, limit.lower * y))
        a, b = (float((load * limit.mechanism).sum()) for load in (first, second))
        outer.append((a, b, limit.upper * (a * x + b * y)))
    return LoadDomain(np.array(inner), np.array(outer))


def _standing(assembly: Assembly, gap: float, options: dict[str, Any]) -> tuple[Problem, Floats]:
    """The problem and a force field with room in its cones."""
    defaults = {"friction": None, "gravity": None, "loads": None, "interfaces": None, "solver": "auto"}
    given = defaults | options
    solver = given.pop("solver")
    problem = pose(assembly, gap=gap, **given)
    if problem.program is not None and not len(problem.floating):
        posed = {"solver": solver, "motions": problem.motions}
        found = decide(problem.program, solve_penalty(problem.program, **posed), **posed)
        if outcome_of(found.certificate) is Outcome.STABLE:
            return problem, found.force
    raise InputError(f'"{assembly.name}" does not stand; it has no thrust to speak of')


def _support_indices(assembly: Assembly, supports: Sequence[int | str]) -> Ints:
    indices = assembly.blocks_named(supports, "supports")
    for index in indices[~assembly.support[indices]]:
        names = ", ".join(assembly.names[i] for i in np.flatnonzero(assembly.support)[:8])
        raise InputError(f'supports: "{assembly.names[index]}" is no support; supports are: {names}')
    return indices


def _functional(problem: Problem, supports: Ints, direction: Sequence[float]) -> Floats:
    """Row c with c' f the force on the supports along the direction, in scaled units, shape (3 m,)."""
    unit = np.asarray(direction, dtype=float)
    if unit.shape != (3,) or not np.isfinite(unit).all() or not unit.any():
        raise InputError(f"direction is {direction!r}; it must be three numbers, not all zero")
    unit = unit / np.linalg.norm(unit)
    rows = []
    for columns in problem.eq.columns:
        sign = np.isin(columns.pair[:, 1], supports).astype(float) - np.isin(columns.pair[:, 0], supports)
        rows.append((sign[:, None] * (columns.force @ unit)).reshape(-1))
    return np.concatenate(rows)


def _value(problem: Problem, functional: Floats, force: Floats) -> float:
    """A functional of contact forces [N], the joint laws' shift of the program's forces taken off."""
    program = problem.program
    assert program is not None
    held = float(functional[::3] @ program.shift)
    return (float(functional @ force.reshape(-1)) - held) * program.force_unit


def _extreme(problem: Problem, functional: Floats, inside: Floats, solver: str) -> tuple[float, Floats]:
    """Largest value of a functional over admissible force fields [N], proven by the field returned."""
    program = problem.program
    assert program is not None
    answer = solve(conic_program(program, -program.load, offset=-functional), solver=solver)
    if answer.status.is_infeasible:
        return np.inf, problem.to_points(answer.force)
    field = _admissible(problem, certificate.balance(program, answer.force), inside)
    return _value(problem, functional, field), problem.to_points(field)


def _admissible(problem: Problem, balanced: Floats, inside: Floats) -> Floats:
    """The field, mixed with as little as it takes of one with room in its cones to be proven."""
    program = problem.program
    assert program is not None
    for share in SHARES:
        mixed = (1 - share) * balanced + share * inside
        if certificate.check(program, mixed, np.zeros_like(program.load)).proves_stable:
            return mixed
    raise InputError(f'"{problem.assembly.name}": no force field near the extreme could be proven')
