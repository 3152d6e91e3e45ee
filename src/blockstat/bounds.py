"""Bounds that do not lean on a solver: force fields pushed inside their cones, mechanisms with no joint closing.

An optimal force field lies on the boundary of its cones and is good only to the solver's tolerance. Mixed with a
little of a field that has room, it is strictly inside and balances a slightly smaller load: a proven lower bound.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.polyhedron import Floats
from blockstat.program import PenaltyProgram
from blockstat.solve import certificate, dual

#: Shares of the field with room that are tried, smallest first.
SHARES = (0.0, *(10.0**-k for k in range(11, 1, -1)))
#: A mechanism that cannot be mended (jammed blocks, joints that cannot slide) bounds the load for equilibria whose
#: contact forces add up to at most this many times those of the solver's own field.
ASSUMED_FORCE = 10.0


#: Each mending leaves a hundred-millionth of the violation; joints that cannot slide at all need more than one.
MENDINGS = 3


@dataclass(frozen=True, eq=False)
class Bound:
    """A proven value and the scaled force field or twist that proves it."""

    value: float
    evidence: Floats


def lower_bound(
    program: PenaltyProgram, load: Floats, force: Floats, multiplier: float, inside: Floats
) -> Bound | None:
    """The largest multiplier at most the given one for which a mixture of the two fields is admissible.

    force : field near the limit, for w + multiplier x load; inside : field with room, for w alone.
    """
    at_limit = replace(program, load=program.load + multiplier * load)
    balanced = certificate.balance(at_limit, force)
    nothing = np.zeros_like(program.load)
    for share in SHARES:
        mixed = (1 - share) * balanced + share * inside
        value = (1 - share) * multiplier
        loaded = replace(program, load=program.load + value * load)
        if certificate.check(loaded, mixed, nothing).proves_stable:
            return Bound(value, mixed)
    return None


def upper_bound(program: PenaltyProgram, load: Floats, twist: Floats, force: Floats) -> Bound | None:
    """What a mechanism proves: no equilibrium at a larger multiplier. None when the load does no work on it.

    force : the solver's field at the limit, shape (m, 3), the measure of forces if some joint still closes.

    For twists u with A' u in K* and l' u > 0, equilibrium at lambda asks for w' u + lambda l' u <= 0.
    """
    mended, closing = twist, np.inf
    for _ in range(MENDINGS):
        candidate = dual.open_joints(program, mended)
        _, left = certificate.power(program, candidate)
        if not left < closing:
            break
        mended, closing = candidate, left
        if closing == 0.0:
            break
    work = float(load @ mended)
    if work <= 0:
        return None
    slack = closing * ASSUMED_FORCE * float(np.linalg.norm(force, axis=1).sum())
    return Bound((slack - certificate.power(program, mended)[0]) / work, mended / work)
