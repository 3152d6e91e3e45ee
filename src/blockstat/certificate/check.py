"""What a verdict rests on: a force field or a mechanism, checked in plain numpy whatever the solver said.

Stable: forces inside every friction cone that balance every block. Unstable: twists under which no joint
closes, and sliding joints open at the rate friction asks for, while the loads do positive work. Both
statements are checked on the matrix itself and carry their own error.

Both are bounded by one number, `FORCE_LIMIT`. Forces beyond it balance anything, since their directions and arms are
rounded. So forces of a stable assembly sum to at most that many weights, and those of any equilibrium of an unstable
one would have to sum to at least as many.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from blockstat.linear_algebra.normal_equations import normal_equations
from blockstat.program.penalty import PenaltyProgram
from blockstat.program.planar import Plane
from blockstat.typing import Floats

#: A force field proves stability when no block's residual, rounding aside, and no cone violation next to it exceeds
#: this fraction of the block's own load: negligible against its weight.
FORCE_TOLERANCE = 1e-9
#: Rounding of a residual, relative to the forces that meet in a block: a sum of k products is good to k x 2^-53 of
#: them, and a block has about a hundred.
ROUNDING = 1e-14
#: The normal force of points outside their cones is raised by their deficit, by this fraction of it, and by this many
#: mean weights.
PRESSED = 0.02
#: Forces prove stability when their normal forces sum to at most this many total weights, and a mechanism proves
#: instability when those of any equilibrium would sum to at least as many. Sound assemblies stand with about as many
#: weights as they have courses or voussoirs.
FORCE_LIMIT = 1e6
#: Work of the loads below this fraction of `|w| |u|` is rounding.
WORK_ROUNDING = 1e-13


@dataclass(frozen=True)
class Certificate:
    """The figures that decide, each computed from the forces and twists returned with the verdict."""

    #: largest unbalanced force or moment / size of a block, relative to that block's load, nothing taken off
    residual: float
    cone_violation: float  #: largest missing normal force of a point, relative to the lighter block's load
    work: float  #: work of the loads on the mechanism, relative to `|w| |u|`; 0 without a mechanism
    mechanism_violation: float  #: largest amount by which a joint closes or slides without opening, relative to `|u|`
    #: least total normal force of any equilibrium, in total weights; inf: none exists. With infinite friction
    #: the total of whole contact forces.
    required_force: float
    #: the largest residual less what rounding may be of it (`ROUNDING` of the forces that meet in the block), relative
    #: to the block's load
    imbalance: float = 0.0
    total_force: float = 0.0  #: total normal force of the given forces, measured as `required_force`
    slack: float = 0.0  #: least normal force that a point has to spare, relative to the lighter block's load

    @property
    def proves_stable(self) -> bool:
        """Whether forces of a bounded size balance every block inside their cones, to the stated tolerance."""
        return max(self.imbalance, self.cone_violation) <= FORCE_TOLERANCE and self.total_force <= FORCE_LIMIT

    @property
    def proves_unstable(self) -> bool:
        """Whether the loads drive the mechanism and no forces of a bounded size could resist it."""
        return self.work > WORK_ROUNDING and self.required_force >= FORCE_LIMIT


#: What nothing has been checked of; it proves nothing.
UNCHECKED = Certificate(np.inf, np.inf, 0.0, 0.0, 0.0, imbalance=np.inf)


def balance(program: PenaltyProgram, force: Floats, *, passes: int = 4) -> Floats:
    """Correct forces onto equilibrium with the least change relative to their slack inside the cones.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.
    passes
        How often the residual is computed at most; corrections, one fewer, are repeated until it is rounding.

    Returns
    -------
    Floats
        Shape (m, 3); the given forces where the correction cannot be computed.

    Notes
    -----
    Minimises `sum |df_i|^2 / d_i` subject to `A (f + df) + w = 0` with d_i the distance of f_i from its cone's
    boundary, so that points without slack are left alone.
    """
    slack = np.maximum(point_slack(program, force), 0.0)
    slack += 1e-9 * slack.max(initial=1.0)
    slip = np.minimum(program.friction, 1.0)  # the cone is that much narrower across than along
    weights = slack[:, None] * np.column_stack([np.ones_like(slip), slip, slip])
    plane = program.plane
    if plane is not None and not (plane.mirrors(force.reshape(-1)) and _is_planar(program, plane, force)):
        plane = None
    try:
        solve = _solver(program, weights) if plane is None else _solver_in_plane(program, plane, weights)
        return _balanced(program, force, weights.reshape(-1), solve, passes)
    except ArithmeticError:
        return force


def _is_planar(program: PenaltyProgram, plane: Plane, force: Floats) -> bool:
    """Whether what is left to balance lies in the plane to rounding; far from the origin, coordinates do not."""
    residual = program.matrix @ force.reshape(-1) + program.load
    out = residual - plane.unfold @ (plane.unfold.T @ residual)
    size = max(np.abs(force).max(initial=0.0), np.abs(program.load).max(initial=0.0))
    return bool(np.abs(out).max(initial=0.0) <= ROUNDING * size)


def _solver(program: PenaltyProgram, weights: Floats) -> Callable[[Floats], Floats]:
    """Solves A D A' u = r, D the weights of the forces, shape (m, 3). Raises ArithmeticError if it can not."""
    pair = np.repeat(program.point_blocks, 3, axis=0)
    normal = normal_equations(pair, len(program.load) // 6, 6)
    normal.update(np.sqrt(weights).reshape(-1, 1) * program.local)
    return normal.solve


def _solver_in_plane(program: PenaltyProgram, plane: Plane, weights: Floats) -> Callable[[Floats], Floats]:
    """The same where forces and loads are planar: half the unknowns, and one row for a point and its mirror image."""
    head, tangent = program.planar_local
    both = weights[plane.first] + weights[plane.second]
    rows = np.concatenate([np.sqrt(both[:, :1]) * head, np.sqrt(both[:, 1:2]) * tangent])
    normal = normal_equations(np.tile(program.point_blocks[plane.first], (2, 1)), len(program.load) // 6, 3)
    normal.update(rows)
    return lambda residual: plane.unfold @ normal.solve(plane.unfold.T @ residual)


def settle(program: PenaltyProgram, force: Floats, *, trials: int = 4) -> Floats:
    """Balance forces; where that leaves their cones, press them back and balance them again.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.
    trials
        How often they are pressed back at most.

    Returns
    -------
    Floats
        Shape (m, 3); not every one need lie inside its cone.
    """
    balanced = balance(program, force)
    for _ in range(trials):
        closer = pressed(program, balanced)
        if closer is balanced:
            break
        balanced = balance(program, closer)
    return balanced


def pressed(program: PenaltyProgram, force: Floats) -> Floats:
    """Press forces into their cones where they lie outside, by a little more than their deficit.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.

    Returns
    -------
    Floats
        Shape (m, 3); the given forces themselves where none lies outside.
    """
    deficit = np.maximum(-point_slack(program, force), 0.0)
    if not deficit.any() or not np.isfinite(deficit).all():
        return force
    closer = force.copy()
    closer[:, 0] += (1.0 + PRESSED) * deficit + PRESSED * (deficit > 0)
    return closer


def _balanced(
    program: PenaltyProgram, force: Floats, weights: Floats, solve: Callable[[Floats], Floats], passes: int
) -> Floats:
    """Newton's step for the correction, repeated until rounding."""
    matrix = program.matrix
    flat, best = force.reshape(-1).copy(), np.inf
    result = flat
    for last in range(passes, 0, -1):
        residual = matrix @ flat + program.load
        size = np.abs(residual).max(initial=0.0)
        if not size < best:
            break
        result, best = flat, size
        if last == 1:
            break
        flat = flat - weights * (matrix.T @ solve(residual))
    return result.reshape(-1, 3)


def cone_slack(force: Floats, friction: Floats) -> Floats:
    """Return the slack of the normal force at each point, `f_n - |f_t| / mu`.

    Parameters
    ----------
    force
        Shape (m, 3).
    friction
        mu of each point, shape (m,), inf allowed.

    Returns
    -------
    Floats
        Shape (m,), negative outside the cone.
    """
    tangent = np.hypot(force[:, 1], force[:, 2])
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(np.isinf(friction), 0.0, np.where(tangent > 0, tangent / friction, 0.0))
    # Infinite friction still needs pressure to rub against.
    without = np.isinf(friction) & (force[:, 0] <= 0) & (tangent > 0)
    return np.where(without, np.minimum(force[:, 0], -tangent), force[:, 0] - needed)


def opening_slack(gap_rate: Floats, friction: Floats) -> Floats:
    """Return the slack of the opening at each point, `g_n - mu |g_t|`.

    Parameters
    ----------
    gap_rate
        Relative velocities, shape (m, 3).
    friction
        mu of each point, shape (m,), inf allowed.

    Returns
    -------
    Floats
        Shape (m,), negative where a mechanism closes or drags a joint. A joint that cannot slide has `-|g_t|` at most:
        what it drags works against the friction force itself.
    """
    slide = np.hypot(gap_rate[:, 1], gap_rate[:, 2])
    no_slip = np.isinf(friction)
    coulomb = gap_rate[:, 0] - np.where(no_slip, 0.0, friction) * slide
    return np.where(no_slip, np.minimum(gap_rate[:, 0], 0.0) - slide, coulomb)


def point_slack(program: PenaltyProgram, force: Floats) -> Floats:
    """Return the slack of the normal force at each point within its cone and its bounds.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.

    Returns
    -------
    Floats
        Shape (m,), negative outside.
    """
    slack = cone_slack(force, program.friction)
    if len(program.upper_bounded) or len(program.lower_bounded):
        normal = force[:, 0]
        above = np.where(program.lower > 0, normal - program.lower, np.inf)
        slack = np.minimum(slack, np.minimum(above, program.upper - normal))
    return slack


def power(program: PenaltyProgram, twist: Floats) -> tuple[float, float]:
    """Return the work of the loads on a twist less what crushing, cohesion and bonds take up, and the largest closing.

    Parameters
    ----------
    program
        The penalty program.
    twist
        Shape (6 n,), in its units.

    Returns
    -------
    work : float
        Positive when the loads drive the twist.
    closing : float
        The largest violation of A'u in K* at points without an upper bound, to be judged by the caller.

    Notes
    -----
    At a point with an upper bound any deficit of opening `r = g_n - mu |g_t|` is bought at upper x deficit. At a point
    with a lower bound any surplus is paid lower x surplus. These are the best multipliers y and z of the dual for this
    twist. A point without an upper bound that closes takes up its violation times `f_n + a`. The work is less the part
    of the cohesion, violation x a; what is left to be judged is that of f_n.
    """
    gap_rate = (program.matrix.T @ twist).reshape(-1, 3)
    slack = opening_slack(gap_rate, program.friction)
    violation = np.maximum(-slack, 0.0)
    work = float(program.load @ twist)
    if len(program.upper_bounded):
        no_slip = np.isinf(program.friction[program.upper_bounded])
        rate = gap_rate[program.upper_bounded]
        opening = np.where(no_slip, rate[:, 0], slack[program.upper_bounded])
        work -= float(program.upper[program.upper_bounded] @ np.maximum(-opening, 0.0))
        violation[program.upper_bounded] = np.where(no_slip, np.hypot(rate[:, 1], rate[:, 2]), 0.0)
    if len(program.lower_bounded):
        work += float(program.lower[program.lower_bounded] @ np.maximum(slack[program.lower_bounded], 0.0))
    work -= float(violation @ np.where(np.isinf(program.upper), program.shift, 0.0))
    return work, float(violation.max(initial=0.0))


def check(program: PenaltyProgram, force: Floats, twist: Floats) -> Certificate:
    """Compute the certificate of forces and a twist.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.
    twist
        Shape (6 n,), in its units, of any size.

    Returns
    -------
    Certificate
        What they prove, and with which errors.
    """
    errors = force_errors(program, force)
    size = np.abs(twist).max(initial=0.0)
    work, closing = power(program, twist / size) if size > 0 else (0.0, 0.0)
    required = 0.0
    if work > 0:
        required = np.inf if closing == 0 else work / closing / total_load(program)
    return Certificate(
        residual=errors.residual,
        imbalance=errors.imbalance,
        cone_violation=max(0.0, -errors.slack),
        slack=errors.slack,
        total_force=errors.total,
        work=work / float(np.abs(program.load).sum() or 1.0),
        mechanism_violation=closing,
        required_force=float(required),
    )


@dataclass(frozen=True)
class ForceErrors:
    """What forces leave to be wished for; see `Certificate` for the figures."""

    residual: float
    imbalance: float
    slack: float
    total: float

    def within(self, tolerance: float) -> bool:
        """Return whether forces of a bounded size balance inside their cones.

        Parameters
        ----------
        tolerance
            Of residuals and cones, relative to the load of a block.

        Returns
        -------
        bool
            True where they do.
        """
        return max(self.imbalance, -self.slack) <= tolerance and self.total <= FORCE_LIMIT


def force_errors(program: PenaltyProgram, force: Floats) -> ForceErrors:
    """Compute what decides whether forces prove stability.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.

    Returns
    -------
    ForceErrors
        The largest residual with and without rounding, the least slack, and the total force.

    Notes
    -----
    Rounding that exceeds the load of a block would let anything pass there, so nothing is taken off its residual.
    """
    n, a_b = len(program.load) // 6, program.point_blocks
    residual = np.linalg.norm((program.matrix @ force.reshape(-1) + program.load).reshape(n, 6), axis=1)
    own = np.linalg.norm(program.load.reshape(n, 6), axis=1)
    magnitude = np.linalg.norm(force, axis=1)
    met = np.array([np.bincount(side[side >= 0], magnitude[side >= 0], n) for side in a_b.T]).sum(axis=0)
    rounding = ROUNDING * met
    rounding[(rounding >= own) & (own > 0)] = 0.0
    excess = np.maximum(residual - rounding, 0.0)

    lighter = np.where(a_b >= 0, np.append(own, np.inf)[a_b], np.inf).min(axis=1)
    slack = point_slack(program, force)
    missing = _ratio(np.maximum(-slack, 0.0), lighter)
    spare = -missing if missing > 0 else float((slack / np.where(lighter > 0, lighter, 1.0)).min(initial=np.inf))
    dry = np.where(np.isinf(program.friction), magnitude, np.abs(force[:, 0] - program.shift))
    return ForceErrors(_ratio(residual, own), _ratio(excess, own), spare, float(dry.sum()) / total_load(program))


def total_load(program: PenaltyProgram) -> float:
    """Return the sum of the magnitudes of the loads on the blocks.

    Parameters
    ----------
    program
        The penalty program.

    Returns
    -------
    float
        In its units, force and moment of a block in one; 1 without loads.
    """
    whole = program.load
    if program.shift.any():  # the load of the program is what is left of it beside the cohesion
        whole = whole + program.matrix @ (program.shift[:, None] * np.array([1.0, 0.0, 0.0])).reshape(-1)
    return float(np.linalg.norm(whole.reshape(-1, 6), axis=1).sum()) or 1.0


def _ratio(value: Floats, unit: Floats) -> float:
    """Largest value / unit; anything over nothing is infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.where(value > 0, value / unit, 0.0).max(initial=0.0))
