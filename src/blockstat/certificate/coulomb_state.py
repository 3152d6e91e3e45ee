"""The check of a Coulomb state: forces and displacements that belong together under friction without dilatancy.

Forces alone do not show that an assembly stands: blocks jammed between others hold themselves on paper. A Coulomb state
is a pair of forces f and displacements v in which the displacements cause the forces:

- the forces balance every block and lie in their cones;
- every loaded point closes, `q_i = -(A'v)_n > 0`;
- no unloaded point closes by more than its joint was open before. How far that was is not known. No joint is taken to
  have been looser than the loaded points of the same state, so that an unloaded point may close by as much as the
  loaded point that closes most;
- friction opposes slip: `f_t = -k g_t` with some k >= 0, so elastic slip below the surface of the cone is allowed, and
  sliding at the surface as far as it goes;
- bonds oppose what stretches, shears and bends them.

Such a pair exists just where joints can be named in which the loads cause the forces: joint i with a normal stiffness
`f_n / q_i`, a tangential stiffness `|f_t| / |g_t|`, and nothing that acts before the loads come. Self-stress has no
such joints, because two loaded points that face each other across a block can not both close.

Cohesion acts as a constant attraction, since the forces of the program count from the apex of the cone. A point at its
lower bound need not close. Nothing here depends on how the pair was found: all figures come from the arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.certificate.check import FORCE_LIMIT, FORCE_TOLERANCE, force_errors
from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats

#: Relative accuracy of the rates g = A'v. A closing or an opposition that is smaller, relative to the largest rate, may
#: be rounding: two joints that face each other across a block close by amounts that add up to nothing, and one of them
#: by a rounding error. Solvers return rates to 1e-8 at worst.
RATE_ACCURACY = 1e-6


@dataclass(frozen=True)
class CoulombCertificate:
    """The figures that decide about a Coulomb state; rates are relative to the largest rate."""

    residual: float  #: largest unbalanced force of a block beyond rounding, relative to its load
    total_force: float  #: sum of the normal forces, in total weights
    cone_violation: float  #: largest missing normal force of a point, relative to the lighter block's load
    closing: float  #: least closing of a loaded point, which must be positive; inf where nothing is loaded
    clearance_violation: float  #: closing of an unloaded point beyond the largest of a loaded one
    friction_violation: float  #: largest slip of a loaded point that its friction does not oppose, or of a bond
    unsupported: float  #: share of the normal forces at loaded points that do not close

    @property
    def proves_settled(self) -> bool:
        """Whether the pair is a Coulomb state, to the accuracy of the rates."""
        return (
            max(self.residual, self.cone_violation) <= FORCE_TOLERANCE
            and self.total_force <= FORCE_LIMIT
            and self.closing > RATE_ACCURACY
            and self.clearance_violation <= RATE_ACCURACY
            and self.friction_violation <= RATE_ACCURACY
        )


def check_coulomb_state(
    program: PenaltyProgram, force: Floats, displacement: Floats, opening: Floats | None = None
) -> CoulombCertificate:
    """Compute the certificate of forces and displacements.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.
    displacement
        v of all free blocks, shape (6 n,), of any size.
    opening
        By how much the joint was open at each point before, in units of the displacements, shape (m,), if that is
        known. A point may then also close by that much without carrying anything.

    Returns
    -------
    CoulombCertificate
        What the pair proves, and with which errors.

    References
    ----------
    De Saxce & Feng: The bipotential method, 1998.
    """
    if not (np.isfinite(force).all() and np.isfinite(displacement).all()):
        return CoulombCertificate(np.inf, np.inf, np.inf, -np.inf, np.inf, np.inf, 1.0)
    errors = force_errors(program, force)
    rate = (program.matrix.T @ displacement).reshape(-1, 3)
    size = max(float(np.abs(rate).max(initial=0.0)), 1e-300)
    rate = rate / size
    closing = -rate[:, 0]
    touching = np.arange(len(rate)) < program.n_points  # bonds follow
    loaded = loaded_points(program, force)
    at_points, normal = loaded & touching, np.maximum(force[:, 0], 0.0) * touching
    free = np.full(len(rate), closing[at_points].max(initial=0.0))
    if opening is not None:
        free = np.maximum(free, opening / size)
    aside = _against_opposition(force[loaded], rate[loaded])
    stretched = np.maximum(rate[loaded & ~touching, 0], 0.0)  # a bond that comes closer pulls no more
    return CoulombCertificate(
        residual=errors.imbalance,
        total_force=errors.total,
        cone_violation=max(0.0, -errors.slack),
        closing=float(closing[at_points].min(initial=np.inf)),
        clearance_violation=float((closing - free)[~loaded & touching].max(initial=0.0)),
        friction_violation=float(max(aside.max(initial=0.0), stretched.max(initial=0.0))),
        unsupported=float(normal[at_points & (closing <= RATE_ACCURACY)].sum() / max(normal.sum(), 1e-300)),
    )


def loaded_points(program: PenaltyProgram, force: Floats) -> np.ndarray:
    """Return which points carry a force that equilibrium would miss.

    Parameters
    ----------
    program
        The penalty program.
    force
        Shape (m, 3), in its units.

    Returns
    -------
    array of bool, shape (m,)
        False where the force is within the tolerance of the forces, relative to the lighter block's load, of nothing or
        of its lower bound.
    """
    own = np.linalg.norm(program.load.reshape(-1, 6), axis=1)
    blocks = program.point_blocks
    lighter = np.where(blocks >= 0, np.append(own, np.inf)[blocks], np.inf).min(axis=1)
    tolerance = FORCE_TOLERANCE * lighter
    at_bound = (program.lower > 0) & (force[:, 0] <= program.lower + tolerance)
    return (np.linalg.norm(force, axis=1) > tolerance) & ~at_bound


def _against_opposition(force: Floats, rate: Floats) -> Floats:
    """By how much the slip of each point lies off the half-line of slips that its friction opposes, shape (n,).

    It counts by the friction's share of the force: at a point without friction any slip is right.
    """
    size = np.maximum(np.linalg.norm(force, axis=1), 1e-300)
    tangent = np.linalg.norm(force[:, 1:], axis=1)
    along = force[:, 1:] / np.maximum(tangent, 1e-300)[:, None]
    opposed = np.minimum(np.einsum("ij,ij->i", along, rate[:, 1:]), 0.0)
    return tangent / size * np.linalg.norm(rate[:, 1:] - opposed[:, None] * along, axis=1)
