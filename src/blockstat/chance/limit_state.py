"""The limit state of a load on random blocks, negative where the load is not carried, and its derivative.

The multiples of the load that are carried beside the dead load are those of an interval, as the admissible forces are
convex. It holds 0 where the assembly stands without the load. The limit state is how far the push is inside the end
that is nearer. So it goes on where the dead load falls but some multiple of the load would hold it, or would have to be
taken back: a slab that slides at friction less tilt has this limit whatever its sign.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.problem import checked_loads, pose
from blockstat.chance.population import Draw, Population
from blockstat.errors import InputError
from blockstat.loads import WeightedLoads, as_load, numbers, weighted
from blockstat.program.conic import conic_program
from blockstat.program.penalty import as_strong_as_the_weight
from blockstat.sensitivity.parameters import pinned
from blockstat.sensitivity.reserve import reserve_map
from blockstat.solve.answer import Status
from blockstat.solve.dispatch import solve
from blockstat.typing import Floats

#: Multipliers beyond this are not told apart.
MANY = 1e6


def limit_state(population: Population, load: Any, normal: Floats) -> tuple[float, Floats]:
    """Return the limit state and its derivative.

    Parameters
    ----------
    population
        What is random.
    load
        As in `blockstat.limit_load`.
    normal
        Standard normal variables, shape (size,).

    Returns
    -------
    value : float
        How far the push is from the nearer end of the multipliers that are carried, in units of the load; negative
        beyond it, where the load is not carried. -inf where no multiplier is found to be carried.
    slope : Floats
        Shape (size,). Where any multiple of the load is carried, that of the push alone; zero where no limit is proven.

    Raises
    ------
    InputError
        For a random "edge" beside a random "corner" or joints that are divided into cells: there is no derivative.
    """
    divided = any(law.divisions for law in population.assembly.joints)
    if "edge" in population.uncertain and ("corner" in population.uncertain or divided):
        beside = "joints that are divided into cells" if divided else '"corner"'
        raise InputError(f'uncertain "edge" beside {beside} has no derivative to first order; leave one out, or draw')
    draw = population.realise(normal)
    direction = numbers(load)
    ends = _ends(population, draw, direction)
    if ends is None:
        return -np.inf, np.zeros(population.size)
    least, most, _ = ends
    nearer = most - draw.push <= draw.push - least if np.isfinite([least, most]).any() else draw.push >= 0
    sign = 1.0 if nearer else -1.0
    found = _limit(population, draw, sign * direction, sign * _between(*ends))
    value = min(found.lower, MANY) - sign * draw.push
    if found.outcome is LoadOutcome.LIMIT:
        corners = "corner" in population.uncertain
        _, twist = pinned(found, as_load(draw.assembly, sign * direction), checked_loads(draw.assembly, draw.loads))
        derivatives = reserve_map(found, sign * direction, loads=draw.loads, corners=corners)
        return value, population.gradient(normal, draw, derivatives, twist, push=-sign)
    slope = population.gradient(normal, draw, None, np.zeros((draw.assembly.n_blocks, 6)), push=-sign)
    return value, slope if found.outcome is LoadOutcome.UNBOUNDED else np.zeros_like(slope)


def _limit(population: Population, draw: Draw, load: Floats, inside: float) -> LimitLoad:
    """The limit of a load beside the dead load, found from a multiple of it that is carried."""
    pushed = inside * as_load(draw.assembly, load)
    own = WeightedLoads(np.zeros_like(pushed)) if draw.loads is None else weighted(draw.loads)
    loads = replace(own, beside=own.beside + pushed) if inside else draw.loads
    options: dict[str, Any] = {"loads": loads, "gap": population.gap, "interfaces": draw.interfaces}
    found = limit_load(draw.assembly, load, optimum=True, **options)
    return replace(found, lower=found.lower + inside, upper=found.upper + inside)


def _ends(population: Population, draw: Draw, load: Floats) -> tuple[float, float, float] | None:
    """The least and the greatest multiple of a load that is carried, and the one that is as strong as the weight.

    An end is infinite where there is none; None where no multiple is carried. Nothing is proven here: `limit_load` from
    a multiple between them finds out whether it is carried.
    """
    options: dict[str, Any] = {"friction": None, "gravity": None, "gap": population.gap}
    problem = pose(draw.assembly, loads=draw.loads, interfaces=draw.interfaces, **options)
    program = problem.program
    if program is None or len(problem.floating):
        return None
    scaled, unit = as_strong_as_the_weight(program, problem.scaled(as_load(draw.assembly, load)))
    ends = []
    for sign in (-1.0, 1.0):
        answer = solve(conic_program(program, -program.load, pinned=sign * scaled))
        if answer.status is Status.DUAL_INFEASIBLE:
            return None
        ends.append(sign * np.inf if answer.status is Status.PRIMAL_INFEASIBLE else sign * answer.multiplier / unit)
    least, most = ends
    return (float(least), float(most), 1.0 / unit) if least <= most else None


def _between(least: float, most: float, weight: float) -> float:
    """A multiple between two ends: none of the load where that is between, else in the middle or one weight inside."""
    if least <= 0 <= most:
        return 0.0
    if np.isinf(most):
        return least + weight
    return most - weight if np.isinf(least) else (least + most) / 2
