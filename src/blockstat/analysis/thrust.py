"""Least and greatest thrust on supports, and domains of two loads: linear programs over forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.decision import SHARES, decide, outcome_of
from blockstat.analysis.limit_load import LoadOutcome, limit_load
from blockstat.analysis.problem import Problem, pose
from blockstat.analysis.verdict import Outcome
from blockstat.certificate import check as certificate
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import InputError, check_choice, check_vector, known_options
from blockstat.loads import as_load
from blockstat.program.conic import conic_program
from blockstat.result import Result, Sentence, finite
from blockstat.solve.dispatch import CHOICES, solve
from blockstat.solve.penalty import solve_penalty
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Two loads whose cosine is nearer to one than this are one load.
PARALLEL = 1e-9


class ThrustOutcome(Sentence):
    """The answers of `thrust_range`; each value is the sentence a user reads."""

    BOUNDED = "Bounded: the thrust lies between a least and a greatest value, each carried by a proven force field."
    UNBOUNDED = "Unbounded: self-stress can raise the thrust without end; the least value is proven."


class DomainOutcome(Sentence):
    """The answer of `load_domain`; the value is the sentence a user reads."""

    BOUNDED = "Bounded: every pair of multipliers in the inner polygon is carried, none outside the outer one."


@dataclass(frozen=True, eq=False)
class ThrustRange(Result):
    """Least and greatest force on some supports in one direction [N], each carried by a proven force field."""

    least: float  #: [N]
    greatest: float  #: [N], inf when self-stress can raise it without end
    least_forces: Floats  #: shape (n_points, 3) [N]
    greatest_forces: Floats  #: shape (n_points, 3) [N]
    interfaces: Interfaces
    assembly: Assembly
    warnings: tuple[str, ...] = ()

    @property
    def outcome(self) -> ThrustOutcome:
        """Whether the thrust has a greatest value."""
        return ThrustOutcome.BOUNDED if np.isfinite(self.greatest) else ThrustOutcome.UNBOUNDED

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
            "least": finite(self.least),
            "greatest": finite(self.greatest),
            "blocks": self.assembly.n_blocks,
            "interfaces": self.interfaces.n_interfaces,
            "contacts": self.interfaces.contacts,
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, eq=False)
class LoadDomain(Result):
    """Pairs of multipliers (x, y) of two loads that are carried: between two polygons."""

    inner: Floats  #: shape (n, 2), proven by force fields, counter-clockwise
    outer: Floats  #: shape (n, 3), rows (a, b, c) of half-planes a x + b y <= c, proven by mechanisms

    @property
    def outcome(self) -> DomainOutcome:
        """The domain is bounded; `load_domain` refuses others."""
        return DomainOutcome.BOUNDED

    def explain(self) -> str:
        """Return the answer and its evidence in words, one fact a line.

        Returns
        -------
        str
            One fact a line.
        """
        (x0, y0), (x1, y1) = self.inner.min(axis=0), self.inner.max(axis=0)
        return "\n".join(
            [
                self.outcome.value,
                f"Inner polygon: {len(self.inner)} corners, x from {x0:.6g} to {x1:.6g}, y from {y0:.6g} to {y1:.6g}.",
                f"Outer polygon: {len(self.outer)} half-planes.",
            ]
        )

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "inner": self.inner.tolist(),
            "outer": self.outer.tolist(),
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
    The thrust is linear in the contact forces, so both ends are conic programs over the admissible force fields.

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
    thrust = _functional(problem, support_indices(problem.assembly, supports), direction)
    least, least_forces = extreme(problem, -thrust, inside, solver)
    greatest, greatest_forces = extreme(problem, thrust, inside, solver)
    return ThrustRange(
        least=-least,
        greatest=greatest,
        least_forces=least_forces,
        greatest_forces=greatest_forces,
        interfaces=problem.interfaces,
        assembly=problem.assembly,
        warnings=problem.warnings,
    )


@known_options
def load_domain(
    assembly: Assembly,
    one: Any,
    two: Any,
    *,
    directions: int = 32,
    friction: float | None = None,
    gravity: Any = None,
    loads: Floats | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    solver: str = "auto",
) -> LoadDomain:
    """Find the pairs of multipliers of two loads that an assembly carries, along rays from the dead load.

    Parameters
    ----------
    assembly : Assembly
        The blocks; they must stand.
    one, two : array_like
        The two loads, each as in `blockstat.limit_load`.
    directions : int, optional
        Number of rays, evenly spread; at least 3.
    friction, gravity, loads, gap, interfaces, solver
        As in `blockstat.assess`.

    Returns
    -------
    LoadDomain
        A polygon inside the domain and one around it.

    Raises
    ------
    InputError
        When the assembly does not stand, carries a combination without end, when the two loads are one, or for an
        option that does not exist.

    Notes
    -----
    Every ray is a limit analysis. Its force field is a corner of the inner polygon, its mechanism a half-plane of the
    outer one; the domain is convex because the friction is associated.

    Examples
    --------
    A pillar of 0.5 x 0.5 x 2 m tips at a quarter of its weight, to either side.

    >>> from blockstat import Assembly, box, load_domain
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = load_domain(pillar, (1, 0, 0), (0, 1, 0), directions=4)
    >>> found.outcome.word, np.abs(found.inner).max().round(4).item()
    ('bounded', 0.25)
    """
    assembly = assembly if gravity is None else assembly.with_(gravity=gravity)
    first, second = as_load(assembly, one), as_load(assembly, two)
    shared = find_interfaces(assembly, gap=gap) if interfaces is None else interfaces
    if directions < 3:
        raise InputError(f"directions is {directions!r}; a polygon needs at least 3")
    cosine = float((first * second).sum() / np.sqrt((first**2).sum() * (second**2).sum()))
    if abs(cosine) > 1 - PARALLEL:
        raise InputError("the two loads are the same but for their size; they span no domain")
    inner, outer = [], []
    for angle in np.linspace(0, 2 * np.pi, directions, endpoint=False):
        x, y = np.cos(angle), np.sin(angle)
        limit = limit_load(
            assembly, x * first + y * second,
            friction=friction, loads=loads, gap=gap, interfaces=shared, solver=solver, optimum=True,
        )  # fmt: skip
        if limit.outcome is not LoadOutcome.LIMIT:
            raise InputError(f"along ({x:.3g}, {y:.3g}): {limit.outcome.value}")
        inner.append((limit.lower * x, limit.lower * y))
        a, b = (float((load * limit.mechanism).sum()) for load in (first, second))
        outer.append((a, b, limit.upper * (a * x + b * y)))
    return LoadDomain(np.array(inner), np.array(outer))


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
        When the assembly does not stand.
    """
    check_choice("solver", solver, CHOICES)
    problem = pose(assembly, **options)
    if not len(problem.assembly.free):
        raise InputError(f'"{assembly.name}": all blocks are supports; none can move or carry')
    if problem.program is not None and not len(problem.floating):
        posed = {"solver": solver, "motions": problem.motions}
        found = decide(problem.program, solve_penalty(problem.program, **posed), **posed)
        if outcome_of(found.certificate) is Outcome.STABLE:
            return problem, found.force
    raise InputError(f'"{assembly.name}" does not stand as it is; {otherwise}')


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
        Numbers of the blocks.

    Raises
    ------
    InputError
        For a block that is no support, naming the supports.
    """
    indices = assembly.blocks_named(supports, "supports")
    for index in indices[~assembly.support[indices]]:
        names = ", ".join(assembly.names[i] for i in np.flatnonzero(assembly.support)[:8])
        raise InputError(f'supports: "{assembly.names[index]}" is no support; supports are: {names}')
    return indices


def _functional(problem: Problem, supports: Ints, direction: Sequence[float]) -> Floats:
    """Row c with c' f the force on the supports along the direction, in scaled units, shape (3 m,)."""
    unit = check_vector("direction", direction)
    unit = unit / np.linalg.norm(unit)
    rows = []
    for columns in problem.eq.columns:
        sign = np.isin(columns.pair[:, 1], supports).astype(float) - np.isin(columns.pair[:, 0], supports)
        rows.append((sign[:, None] * (columns.force @ unit)).reshape(-1))
    return np.concatenate(rows)


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


def extreme(problem: Problem, functional: Floats, inside: Floats, solver: str) -> tuple[float, Floats]:
    """Largest value of a functional over admissible force fields [N], proven by the field returned."""
    program = problem.program
    assert program is not None
    answer = solve(conic_program(program, -program.load, offset=-functional), solver=solver)
    if answer.status.is_infeasible:
        return np.inf, problem.to_points(answer.force)
    field = admissible(problem, certificate.balance(program, answer.force), inside)
    return value(problem, functional, field), problem.to_points(field)


def admissible(problem: Problem, balanced: Floats, inside: Floats) -> Floats:
    """Return a field, mixed with as little as it takes of one strictly inside its cones to be proven.

    Parameters
    ----------
    problem : Problem
        The posed problem.
    balanced : array of float, shape (m, 3)
        Forces of the program that balance it.
    inside : array of float, shape (m, 3)
        Forces strictly inside their cones, as `standing` returns them.

    Returns
    -------
    array of float, shape (m, 3)
        Admissible forces.

    Raises
    ------
    InputError
        When no mixture can be proven.
    """
    program = problem.program
    assert program is not None
    for share in SHARES:
        mixed = (1 - share) * balanced + share * inside
        if certificate.check(program, mixed, np.zeros_like(program.load)).proves_stable:
            return mixed
    raise InputError(f'"{problem.assembly.name}": no force field near the extreme could be proven')
