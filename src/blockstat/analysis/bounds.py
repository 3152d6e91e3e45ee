"""Bounds that do not lean on a solver: force fields pushed inside their cones, mechanisms with no joint closing.

An optimal force field lies on the boundary of its cones and is good only to the solver's tolerance. Mixed with a
little of a field that has room, it is strictly inside and balances a slightly smaller load: a proven lower bound.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.certificate import check as certificate
from blockstat.certificate.interior_motions import Motions, no_motions, with_interior_motion
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.penalty import open_joints
from blockstat.typing import Floats

#: Shares of the field strictly inside its cones that are tried, smallest first.
SHARES = (0.0, *(10.0**-k for k in range(11, 1, -1)))
#: A mechanism that cannot be corrected (jammed blocks, joints that cannot slide) bounds the load for equilibria whose
#: contact forces add up to at most this many times those of the solver's own field.
ASSUMED_FORCE = 10.0
#: A mechanism with a motion added that opens all joints is good enough when it costs less than this of the multiplier.
CLOSE = 1e-8
#: Each correction leaves a hundred-millionth of the violation; joints that cannot slide at all need more than one.
CORRECTIONS = 3


@dataclass(frozen=True, eq=False)
class Bound:
    """A proven value and the scaled force field or twist that proves it."""

    value: float
    evidence: Floats


def lower_bound(
    program: PenaltyProgram, load: Floats, force: Floats, multiplier: float, inside: Floats
) -> Bound | None:
    """Find the largest multiplier at most the given one for which a mixture of two force fields is admissible.

    Parameters
    ----------
    program
        The penalty program with the dead load w.
    load
        The load l of the multiplier, shape (6 n,).
    force
        A field near the limit, for w + multiplier x l, shape (m, 3).
    multiplier
        The solver's limit.
    inside
        A field with slack, for w alone, shape (m, 3).

    Returns
    -------
    Bound or None
        The multiplier and the field that carries it; None when no mixture is proven.
    """
    at_limit = replace(program, load=program.load + multiplier * load)
    balanced = certificate.balance(at_limit, force)
    nothing = np.zeros_like(program.load)
    for share in SHARES:
        mixed = (1 - share) * balanced + share * inside
        value = (1 - share) * multiplier
        loaded = replace(program, load=program.load + value * load)
        found = certificate.check(loaded, mixed, nothing)
        if not found.proves_stable and found.cone_violation == 0.0:
            mixed = certificate.balance(loaded, mixed)  # which at the limit itself may leave no slack to move in
            found = certificate.check(loaded, mixed, nothing)
        if found.proves_stable:
            return Bound(value, mixed)
    return None


def upper_bound(
    program: PenaltyProgram,
    load: Floats,
    twist: Floats,
    force: Floats,
    *,
    solver: str = "auto",
    motions: Motions = no_motions,
) -> Bound | None:
    """Find what a mechanism proves: no equilibrium at a larger multiplier.

    Parameters
    ----------
    program
        The penalty program with the dead load w.
    load
        The load l of the multiplier, shape (6 n,).
    twist
        The mechanism, shape (6 n,).
    force
        The solver's field at the limit, shape (m, 3), the measure of forces if some joint still closes.
    solver
        One of `blockstat.solve.dispatch.CHOICES`, for the correction of the mechanism.
    motions
        Gives twists that may open every joint, shape (6 n,) each.

    Returns
    -------
    Bound or None
        The multiplier and the mechanism; None when the load does no work on it.

    Notes
    -----
    For twists u with A'u in K* and l'u > 0, equilibrium at lambda asks for w'u + lambda l'u <= 0.
    """
    total = float(np.linalg.norm(force, axis=1).sum())
    best = _proven(program, load, with_interior_motion(program, twist, motions()), total)
    kinematic = -certificate.power(program, twist)[0] / float(load @ twist) if load @ twist > 0 else -np.inf
    if best is not None and best.value - kinematic <= CLOSE * abs(kinematic):
        return best
    corrected, closing = twist, np.inf
    for _ in range(CORRECTIONS):
        corrected = open_joints(program, corrected, solver=solver)
        _, left = certificate.power(program, corrected)
        found = _proven(program, load, corrected, total)
        if found is not None and (best is None or found.value < best.value):
            best = found
        if left == 0.0 or not left < closing:
            break
        closing = left
    return best


def _proven(program: PenaltyProgram, load: Floats, twist: Floats, total: float) -> Bound | None:
    """The multiplier above which a mechanism moves, for contact forces of at most ASSUMED_FORCE x total."""
    work = float(load @ twist)
    power, closing = certificate.power(program, twist)
    return Bound((closing * ASSUMED_FORCE * total - power) / work, twist / work) if work > 0 else None
