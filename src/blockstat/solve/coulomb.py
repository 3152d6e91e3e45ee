"""One program of the Coulomb fixed point, and the state of forces and displacements that it comes close to.

Joint i is open by `t_i` at first and has the compliance c. Given slips s, solve the conic program::

    minimise (t + s)' f_n + c/2 |f|^2   subject to   A f + w = 0,   f in K.

Its cone multipliers are `z = A'v + (t + s) n + c f`, v the multipliers of the balance. By complementarity a loaded
point closes by `q_i = t_i + c f_n,i - (mu |z_t| - s)_i`, and friction opposes slip. At `s = mu |z_t|` nothing
dilates, and every loaded point closes. But no convergence is needed: where the slips grow by less than `t_i + c f_n,i`,
the iterate is a Coulomb state as it stands, with joints of unequal tightness (De Saxce & Feng 1998; Acary, Cadoux,
Lemarechal & Malick 2011).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blockstat.certificate.check import FORCE_TOLERANCE
from blockstat.certificate.coulomb_state import RATE_ACCURACY, CoulombCertificate, check_coulomb_state
from blockstat.linear_algebra.normal_equations import normal_equations
from blockstat.program.conic import conic_program
from blockstat.program.penalty import PenaltyProgram
from blockstat.solve.dispatch import solve
from blockstat.typing import Floats

#: The programs leave so much of the friction unused. Forces on the surface of the reduced cone stay inside the true one
#: when they are balanced to the last digits, which changes them by the accuracy of the solver, 1e-8 at worst.
UNUSED = 1e-4
#: Slip beside that which friction opposes, relative to the largest rate, that the correction leaves as it is: a tenth
#: of what the check lets pass.
OPPOSED = 0.1 * RATE_ACCURACY
#: Passes of the correction, each of them a factorisation, and of its refinement.
MOST_PASSES, REFINEMENTS = 4, 3
#: Normal stiffness of a point at most, in units of 1 / c, in the correction alone: rounding decides about more.
STIFF = 10.0
#: Stiffness of the ground in which blocks are bedded in the correction alone, in units of 1 / c: what turns freely
#: about two points is not moved by rounding. It takes no force: each refinement starts from what the joints balance.
BED = 1e-9


@dataclass(frozen=True, eq=False)
class Iterate:
    """What one program says about the joints of one member of the family."""

    force: Floats  #: shape (m, 3)
    displacement: Floats  #: v, shape (6 n,)
    slip: Floats  #: `mu |z_t|`, shape (m,)
    change: float  #: `sum f_n |mu |z_t| - s| / sum f_n`
    certificate: CoulombCertificate

    @classmethod
    def nothing(cls, program: PenaltyProgram) -> Iterate:
        """Return what is known where no program has an answer.

        Parameters
        ----------
        program
            The penalty program.

        Returns
        -------
        Iterate
            Zeros, which prove nothing.
        """
        force, displacement = np.zeros((len(program.friction), 3)), np.zeros(len(program.load))
        certificate = check_coulomb_state(program, force, displacement)
        return cls(force, displacement, np.zeros(len(force)), np.inf, certificate)


def solve_state(
    program: PenaltyProgram,
    slip: Floats,
    *,
    opening: Floats,
    compliance: float,
    known: bool = False,
    solver: str = "auto",
) -> Iterate | None:
    """Solve the program of some slips and correct its answer.

    Parameters
    ----------
    program
        The penalty program, with positive finite friction.
    slip
        s, shape (m,).
    opening
        t, by how much each joint is open at first, shape (m,).
    compliance
        c.
    known
        Whether the check takes t as known: a point without force may then close by that much.
    solver
        One of `blockstat.solve.dispatch.CHOICES`.

    Returns
    -------
    Iterate or None
        None where the solver finds no forces: slips without bound leave it no digits.
    """
    touching = np.arange(len(slip)) < program.n_points  # bonds neither close nor slip
    cost = touching * (opening + slip)
    unit = max(float(cost.max(initial=0.0)), 1.0)
    offset = np.zeros((len(cost), 3))
    offset[:, 0] = cost / unit
    for unused in (UNUSED, 0.0):  # at the limit of friction all of it is needed
        inner = replace(program, friction=(1.0 - unused) * program.friction, upper=(1.0 - unused) * program.upper)
        for name in ("matrix", "upper_bounded", "lower_bounded"):  # the same; not to be made again
            inner.__dict__[name] = getattr(program, name)
        conic = conic_program(inner, -program.load, offset=offset.reshape(-1), compliance=compliance / unit)
        answer = solve(conic, solver=solver)
        if not (answer.status.is_infeasible or answer.status.is_stalled):
            break
        if slip.any():
            return None
    else:
        return None
    rates = unit * answer.rates
    dilation = inner.friction * np.hypot(rates[:, 1], rates[:, 2])
    new = touching * dilation
    normal = np.maximum(answer.force[:, 0], 0.0) * touching
    change = float(normal @ np.abs(new - slip)) / max(float(normal.sum()), 1e-300)
    # z_n - mu |z_t|, what an unloaded point or bond lacks to be loaded.
    slack = np.maximum(rates[:, 0] - dilation, 0.0)
    force, displacement = _corrected(program, answer.force, unit * answer.twist, slack, opening, compliance)
    certificate = check_coulomb_state(program, force, displacement, opening if known else None)
    return Iterate(force, displacement, new, change, certificate)


def _corrected(
    program: PenaltyProgram, force: Floats, displacement: Floats, slack: Floats, opening: Floats, compliance: float
) -> tuple[Floats, Floats]:
    """Forces and displacements with the last digits of the balance, under which friction still opposes slip.

    Joints have the secant stiffness `f_n / q` and `|f_t| / |g_t|` of the answer. A residual of the balance displaces
    the blocks, and the displacements change the forces of the joints, which stay opposed to them. Points that carry
    nothing are left out: strict complementarity tells force from slack in units of the lighter block's load. Points
    that would pull after the correction are left out of the next pass.
    """
    own = np.linalg.norm(program.load.reshape(-1, 6), axis=1)
    sides = np.where(program.point_blocks >= 0, np.append(own, np.inf)[program.point_blocks], np.inf)
    lighter = np.minimum(sides.min(axis=1), 1e300)
    rate = (program.matrix.T @ displacement).reshape(-1, 3)
    at_rest = _at_rest(program, rate)
    force = np.where(at_rest[:, None], program.lower[:, None] * [1.0, 0.0, 0.0], force)
    normal, closing = force[:, 0], -rate[:, 0]
    # A point that closes may be loaded, however little.
    live = (normal > 0) & ((closing > 0) | (normal * (opening + compliance * lighter) > slack * lighter) | at_rest)
    slip, tangent = np.linalg.norm(rate[:, 1:], axis=1), np.linalg.norm(force[:, 1:], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        across = np.where(closing > 0, normal / closing, np.inf)
        along = np.where(slip > 0, tangent / slip, 0.0)
    stiffness = np.minimum(np.column_stack([across, along, along]), [[STIFF, 1.0, 1.0]] / np.array(compliance))
    # The solver's digits end at the largest forces; small ones oppose their slip only after this. Where they do so to
    # within the check they are left alone: slips in stiff joints have fewer digits than the forces.
    touching = np.arange(len(slip)) < program.n_points
    stiff = np.minimum(along, 1.0 / compliance)
    opposed = -stiff[:, None] * rate[:, 1:]
    aside = np.linalg.norm(force[:, 1:] - opposed, axis=1)
    turned = touching & (aside > OPPOSED * stiff * np.abs(rate).max(initial=0.0))
    force = np.column_stack([normal, np.where(turned[:, None], opposed, force[:, 1:])])
    at_bound = (normal <= program.lower * (1 + UNUSED)) | (normal >= program.upper * (1 - 2 * UNUSED))
    stiffness[at_bound & ((program.lower > 0) | np.isfinite(program.upper)), 0] = 0.0
    found = force, displacement
    for _ in range(MOST_PASSES):
        try:
            found = _balanced(
                program, force, displacement, np.where(live[:, None], stiffness, 0.0), live, BED / compliance
            )
        except ArithmeticError:
            break
        pulls = live & (found[0][:, 0] <= -FORCE_TOLERANCE * lighter)
        if not pulls.any():
            break
        live &= ~pulls
    return found


def _at_rest(program: PenaltyProgram, rate: Floats) -> np.ndarray:
    """Bonds and ties that do not open: they carry their least force, and what a solver leaves beyond it is rounding."""
    pulls = program.local[::3].any(axis=1) & (np.arange(len(rate)) >= program.n_points)
    return pulls & (rate[:, 0] >= 0)


def _balanced(
    program: PenaltyProgram, force: Floats, displacement: Floats, stiffness: Floats, live: np.ndarray, bed: float
) -> tuple[Floats, Floats]:
    """Forces of the live points that balance, and the displacements that go with the change."""
    matrix, weight = program.matrix, stiffness.reshape(-1)
    pair = np.repeat(program.point_blocks, 3, axis=0)
    equations = normal_equations(pair, len(program.load) // 6, 6)
    equations.update(np.sqrt(weight)[:, None] * program.local, bed)
    flat = np.where(live[:, None], force, 0.0).reshape(-1)
    for _ in range(REFINEMENTS):
        step = equations.solve(matrix @ flat + program.load)
        displacement = displacement + step
        flat = flat - weight * (matrix.T @ step)
    return flat.reshape(-1, 3), displacement
