"""From a solver's answer to an outcome, or to a bound on a multiplier: only the independent check counts.

An optimal force field lies on the boundary of its cones and is good only to the solver's tolerance. Mixed with a
little of a field that has room, it is strictly inside and balances a slightly smaller load: a proven lower bound. The
upper bound is that of a mechanism under which no joint closes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from blockstat.analysis.verdict import Outcome
from blockstat.certificate import check as certificate
from blockstat.certificate.bracket import is_closed
from blockstat.certificate.check import Certificate
from blockstat.certificate.interior_motions import Motions, no_motions, with_interior_motion
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.answer import Answer
from blockstat.solve.penalty import open_joints, solve_least_force, solve_margin, solve_penalty
from blockstat.typing import Floats

#: Each correction of a mechanism leaves a small part of its violation; more are made while they prove more.
CORRECTIONS = 3
#: A block that weighs less than this beside the heaviest is given this as its unit.
LIGHTEST = 1e-9
#: Shares of the field strictly inside its cones that are tried, smallest first.
SHARES = (0.0, *(10.0**-k for k in range(11, 1, -1)))
#: Part of the largest sum of forces that bonds and ties may use together where they are held to modest ones.
MODEST = 0.1
#: A mechanism that cannot be corrected (jammed blocks, joints that cannot slide) bounds the load for equilibria whose
#: contact forces add up to at most this many times those of the solver's own field.
ASSUMED_FORCE = 10.0
#: A mechanism with a motion added that opens all joints is good enough when it costs less than this of the multiplier.
CLOSE = 1e-8
#: Where in a bracket a verdict is asked for; the next one where the verdict before it told nothing.
FRACTIONS = (0.5, 0.25, 0.75)
#: A verdict has told something where it raises the lower bound, or leaves less than this of the bracket.
NARROWER = 0.95


def outcome_of(checked: Certificate) -> Outcome:
    """Return what a certificate proves.

    A certificate that proves both sides proves neither.

    Parameters
    ----------
    checked
        The certificate of some forces and a twist.

    Returns
    -------
    Outcome
        Stable, unstable or undecided.
    """
    if checked.proves_stable == checked.proves_unstable:
        return Outcome.UNDECIDED
    return Outcome.STABLE if checked.proves_stable else Outcome.UNSTABLE


def decide(program: PenaltyProgram, answer: Answer, *, solver: str = "auto", motions: Motions = no_motions) -> Answer:
    """Check an answer to the penalty program, and ask a second program near the limit.

    Parameters
    ----------
    program
        The penalty program.
    answer
        Nothing in it is trusted.
    solver
        Who solves the second program, one of `blockstat.solve.dispatch.CHOICES`.
    motions
        Gives twists that may open every joint, shape (6 n,) each (see `blockstat.certificate.interior_motions`).

    Returns
    -------
    Answer
        Forces corrected onto equilibrium, the mechanism corrected where that proves more, and their certificate.
    """
    found = _checked(program, answer, motions)
    if outcome_of(found.certificate) is not Outcome.UNDECIDED:
        return found
    correct = partial(open_joints, program, solver=solver)
    steps = [(program, solve) for solve in (solve_margin, solve_margin_locally, solve_least_force)]
    modest = _with_modest_bonds(program)
    for solved, solve in steps if modest is None else [(modest, solve_margin), *steps]:
        closer = _checked(program, solve(solved, solver=solver), motions, correct)
        decided = outcome_of(closer.certificate) is not Outcome.UNDECIDED
        if decided or closer.certificate.required_force > found.certificate.required_force:
            found = closer
        if decided:
            break
    return found


def _with_modest_bonds(program: PenaltyProgram) -> PenaltyProgram | None:
    """The program with less capacity of bonds and ties, so that their forces are of a bounded size; None if they are.

    A solver's forces lie midway between their bounds, where those of strong bonds are beyond `FORCE_LIMIT`. What
    stands with less capacity stands with more.
    """
    first = program.n_points
    most = MODEST * certificate.FORCE_LIMIT * certificate.total_load(program) / max(len(program.upper) - first, 1)
    upper = program.upper.copy()
    upper[first:] = np.maximum(np.minimum(upper[first:], most), program.lower[first:])
    strong = np.isfinite(program.upper) & (upper < program.upper)
    return replace(program, upper=np.where(strong, upper, program.upper)) if strong.any() else None


def solve_margin_locally(program: PenaltyProgram, *, solver: str = "auto") -> Answer:
    """Find the least adhesion in units of the lighter block of each joint.

    In the units of the whole assembly, light blocks are lost beside heavy ones.

    Parameters
    ----------
    program
        The penalty program.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    Answer
        As of `blockstat.solve.penalty.solve_margin`, in the units of the program.
    """
    own = np.linalg.norm(program.load.reshape(-1, 6), axis=1)
    own = np.maximum(own, LIGHTEST * own.max(initial=1.0))
    sides = np.where(program.point_blocks >= 0, np.append(own, np.inf)[program.point_blocks], np.inf)
    unit = sides.min(axis=1)
    answer = solve_margin(program.in_units(own, unit), solver=solver)
    return replace(
        answer,
        force=answer.force * unit[:, None],
        adhesion=answer.adhesion * unit[: program.n_points],
        twist=(answer.twist.reshape(-1, 6) / own[:, None]).reshape(-1),
    )


def _checked(
    program: PenaltyProgram,
    answer: Answer,
    motions: Motions,
    correct: Callable[[Floats], Floats] | None = None,
) -> Answer:
    """The answer with its certificate, its forces balanced and an opening motion added to its mechanism.

    correct : gives a twist next to one that closes joints; with it, forces outside their cones are corrected too.
    """
    force = answer.force if answer.status.is_proven else certificate.balance(program, answer.force)
    twist = answer.twist
    found = certificate.check(program, force, twist)
    if np.isfinite(found.required_force) and found.required_force > 0 and not found.proves_stable:
        first = () if answer.interior is None else (answer.interior,)
        wider = with_interior_motion(program, twist, (*first, *motions()))
        second = certificate.check(program, force, wider)
        if second.required_force > found.required_force:
            twist, found = wider, second
    if correct is not None and not _proves(found):
        settled = certificate.settle(program, force)
        second = certificate.check(program, settled, twist)
        if second.proves_stable:
            force, found = settled, second
    for _ in range(CORRECTIONS):
        if correct is None or not found.required_force or _proves(found):
            break
        closer = correct(twist)
        second = certificate.check(program, force, closer)
        if not second.required_force > found.required_force:
            break
        twist, found = closer, second
    return replace(answer, force=force, twist=twist, certificate=found)


def _proves(found: Certificate) -> bool:
    return found.proves_stable or found.proves_unstable


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


def proven_bounds(
    program: PenaltyProgram,
    load: Floats,
    answer: Answer,
    dead: Floats,
    *,
    solver: str = "auto",
    motions: Motions = no_motions,
) -> tuple[Bound | None, Bound | None]:
    """Return what an answer of a limit analysis proves from below and from above.

    Parameters
    ----------
    program, load
        As in `lower_bound`.
    answer
        Nothing in it is trusted.
    dead
        A field with slack for the dead load alone, shape (m, 3).
    solver, motions
        As in `upper_bound`.

    Returns
    -------
    tuple of Bound or None
        The lower and the upper bound.
    """
    low = lower_bound(program, load, answer.force, answer.multiplier, dead)
    return low, upper_bound(program, load, answer.twist, answer.force, solver=solver, motions=motions)


def narrowed(
    program: PenaltyProgram,
    load: Floats,
    low: Bound,
    high: Bound,
    *,
    tolerance: float,
    most: float,
    solver: str = "auto",
    motions: Motions = no_motions,
) -> tuple[Bound, Bound, int]:
    """Narrow a bracket of a multiplier by verdicts on single multipliers.

    A verdict has the last word on forces of a bounded size and on blocks that are light beside others, where the
    optimum of a limit analysis loses its digits.

    Parameters
    ----------
    program
        The penalty program with the dead load w.
    load
        The load l of the multiplier, shape (6 n,).
    low, high
        What is proven, with the forces and the mechanism.
    tolerance
        Width that is asked for, as of `blockstat.limit_load`.
    most
        The largest multiplier that is tried.
    solver, motions
        As of `decide`.

    Returns
    -------
    tuple
        The bounds and the iterations spent. They are wider than the tolerance where a verdict is undecided.
    """
    spent, tried, ceiling, moves = 0, 0, high, np.zeros_like(load)
    while low.value < most and not is_closed(low.value, high.value, tolerance) and tried < len(FRACTIONS):
        trial = low.value + FRACTIONS[tried] * (high.value - low.value)
        if np.isinf(high.value):
            trial = min(max(10.0 * low.value, 1.0), most)
        loaded = replace(program, load=program.load + trial * load, plane=None)
        answer = solve_penalty(loaded, solver=solver, motions=motions)
        answer = decide(loaded, answer, solver=solver, motions=motions)
        spent += answer.iterations
        word, before = outcome_of(answer.certificate), (low, high)
        if word is Outcome.STABLE:
            low = Bound(trial, answer.force)
        elif word is Outcome.UNSTABLE:
            ceiling = min(ceiling, Bound(trial, answer.twist), key=lambda bound: bound.value)
        # A mechanism bounds the limit, whatever the verdict was, for forces that grow with those of the lower bound.
        bounds = [_bound_by(program, load, twist, low) for twist in (moves, answer.twist)]
        nearest = min(bounds, key=lambda bound: bound.value)
        moves, high = nearest.evidence, min(ceiling, nearest, key=lambda bound: bound.value)
        # Beside the same forces the upper bound goes up and down by rounding alone, which would go on without end.
        narrower = high.value - low.value < NARROWER * (before[1].value - before[0].value)
        tried = 0 if low.value > before[0].value or narrower else tried + 1
    return low, high, spent


def _bound_by(program: PenaltyProgram, load: Floats, twist: Floats, low: Bound) -> Bound:
    """What a mechanism proves beside a lower bound; infinite where it is below that, and proves nothing."""
    found = _proven(program, load, twist, float(np.linalg.norm(low.evidence, axis=1).sum()))
    return found if found is not None and found.value >= low.value else Bound(np.inf, twist)


def _proven(program: PenaltyProgram, load: Floats, twist: Floats, total: float) -> Bound | None:
    """The multiplier above which a mechanism moves, for contact forces of at most ASSUMED_FORCE x total."""
    work = float(load @ twist)
    power, closing = certificate.power(program, twist)
    return Bound((closing * ASSUMED_FORCE * total - power) / work, twist / work) if work > 0 else None
