"""A second opinion on Coulomb states: do the displacements of a verdict cause its forces? Point by point, in loops.

Shares no code with `blockstat.certificate.coulomb_state`; it takes blocks, joints, forces in newtons and displacements
in metres. Balance and cones are the business of `evidence.checks.independent`.
"""

from __future__ import annotations

import math

from evidence.checks.strength import strengths

LOADED = 1e-8  #: of the lighter block's weight, the least force that counts
ROUNDING = 1e-7  #: of the largest relative displacement; looser than a tenth of what the certificate forgives
OFF = 1e-5  #: of the largest relative displacement, how far a slip may lie off the direction that friction opposes


def moved(asm, displacement, block, point):
    """The displacement of a point that is fixed to a block."""
    u, turn = displacement[block][:3], displacement[block][3:]
    arm = [point[i] - asm.centroid[block][i] for i in range(3)]
    return [u[i] + turn[(i + 1) % 3] * arm[(i + 2) % 3] - turn[(i + 2) % 3] * arm[(i + 1) % 3] for i in range(3)]


def check_displacements(verdict):
    """Raise AssertionError unless every loaded point closes and friction opposes slip."""
    asm, faces = verdict.assembly, verdict.interfaces
    law = strengths(asm, faces)
    rates = []
    for k, point in enumerate(faces.point):
        joint = faces.point_interface[k]
        one, other = (moved(asm, verdict.displacement, block, point) for block in faces.pair[joint])
        rates.append([sum(axis[i] * (other[i] - one[i]) for i in range(3)) for axis in faces.frame[joint]])
    largest = max(abs(value) for rate in rates for value in rate)
    closed, open_ = [], []
    for k, (rate, force) in enumerate(zip(rates, verdict.forces, strict=True)):
        pair = faces.pair[faces.point_interface[k]]
        weights = [float(asm.mass[b]) * math.hypot(*asm.gravity) for b in pair if not asm.support[b]]
        if not weights:
            continue  # between supports
        shift = law.cohesion[k] / law.mu[k]
        normal = force[0] + shift
        limited = law.tension[k] < shift and force[0] <= -law.tension[k] * (1 - 1e-6)
        size = math.hypot(normal, force[1], force[2])
        if size <= LOADED * min(weights) or limited:
            open_.append(-rate[0])
            continue
        assert -rate[0] > ROUNDING * largest, f"point {k} carries {size:.3g} N and does not close"
        closed.append(-rate[0])
        friction = math.hypot(force[1], force[2])
        if friction > 0:
            # What is left of the slip besides its part against the friction.
            along = min((force[1] * rate[1] + force[2] * rate[2]) / friction, 0.0)
            left = math.hypot(rate[1] - along * force[1] / friction, rate[2] - along * force[2] / friction)
            assert left * friction / size <= OFF * largest, f"friction at point {k} does not oppose its slip"
    assert max(open_, default=0.0) <= max(closed, default=0.0) + OFF * largest, (
        "a point without force closes more than any that carries"
    )
