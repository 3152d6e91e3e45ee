"""The check of a Coulomb state: forces and displacements that belong together under friction without dilatancy.

Forces alone do not show that an assembly stands: blocks jammed between others hold themselves on paper. A Coulomb state
is a pair of forces f and displacements v in which the displacements cause the forces. The forces balance and lie in
their cones, every loaded point closes, no unloaded point closes by more than its joint was open, and friction opposes
slip. Elastic slip below the surface of the cone is allowed, sliding at the surface as far as it goes.

Nothing here depends on how the pair was found: all figures come from the arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.certificate.check import FORCE_TOLERANCE, force_errors
from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats

#: Relative accuracy of the rates g = A'v that a solver returns. A closing or an opposition that is smaller, relative to
#: the largest rate, may be rounding: two joints that face each other across a block close by amounts that add up to
#: nothing, and one of them by a rounding error.
RATE_ACCURACY = 1e-6


@dataclass(frozen=True)
class CoulombCertificate:
    """The figures that decide about a Coulomb state; rates are relative to the largest rate."""

    residual: float  #: largest unbalanced force of a block, relative to its load
    cone_violation: float  #: largest missing normal force of a point, relative to the lighter block's load
    closing: float  #: least closing of a loaded point; it must be positive
    clearance_violation: float  #: largest closing of an unloaded point beyond what its joint was open
    friction_violation: float  #: `sum (|f_t| |g_t| + f_t.g_t) / sum |f| |g|`: friction that does not oppose slip
    unsupported: float  #: share of the normal forces at loaded points that do not close

    @property
    def proves_settled(self) -> bool:
        """Whether the pair is a Coulomb state, to the accuracy of the rates."""
        return (
            max(self.residual, self.cone_violation) <= FORCE_TOLERANCE
            and self.closing > RATE_ACCURACY
            and self.clearance_violation <= RATE_ACCURACY
            and self.friction_violation <= RATE_ACCURACY
        )


def check_coulomb_state(
    program: PenaltyProgram, force: Floats, displacement: Floats, clearance: Floats
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
    clearance
        By how much the joint was open at each point before, shape (m,), in units of the displacements; not negative.
        A point without clearance may not close unless it is loaded.

    Returns
    -------
    CoulombCertificate
        What the pair proves, and with which errors.

    References
    ----------
    De Saxce & Feng: The bipotential method, 1998.
    """
    residual, missing = force_errors(program, force)
    touching = slice(0, program.n_points)  # bonds, which follow, neither close nor slip
    gap_rate = (program.matrix.T @ displacement).reshape(-1, 3)[touching]
    own, clearance = force[touching], clearance[touching]
    size = max(float(np.abs(gap_rate).max(initial=0.0)), float(clearance.max(initial=0.0)), 1e-300)
    gap_rate, clearance = gap_rate / size, clearance / size
    loaded = loaded_points(program, force)[touching]
    closing = -gap_rate[:, 0]
    normal = np.maximum(own[:, 0], 0.0)
    tangent, slip = np.linalg.norm(own[:, 1:], axis=1), np.linalg.norm(gap_rate[:, 1:], axis=1)
    against = tangent * slip + np.einsum("ij,ij->i", own[:, 1:], gap_rate[:, 1:])
    work = float((np.linalg.norm(own, axis=1) * np.linalg.norm(gap_rate, axis=1)).sum())
    return CoulombCertificate(
        residual=residual,
        cone_violation=missing,
        closing=float(closing[loaded].min(initial=np.inf)),
        clearance_violation=float((closing - clearance)[~loaded].max(initial=0.0)),
        friction_violation=float(against[loaded].sum()) / work if work > 0 else 0.0,
        unsupported=float(normal[loaded & (closing <= RATE_ACCURACY)].sum() / max(normal.sum(), 1e-300)),
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
        False where the force is within the tolerance of the forces, relative to the lighter block's load.
    """
    own = np.linalg.norm(program.load.reshape(-1, 6), axis=1)
    blocks = program.point_blocks
    lighter = np.where(blocks >= 0, np.append(own, np.inf)[blocks], np.inf).min(axis=1)
    return np.linalg.norm(force, axis=1) > FORCE_TOLERANCE * lighter
