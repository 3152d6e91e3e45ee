"""Capacity curves known without `capacity`: closed forms of one block, and linkages by Newton's method to 1e-14.

An arch or a portal with four hinges is a four-bar linkage. The poses are those of its exact kinematics, the multiplier
is that of virtual work, the thrust is checked at every joint, and at a jump the mean displacement is held. The
displacement is the mean one along the load, weighted by mass [m].
"""

from __future__ import annotations

import numpy as np

#: Semicircular arches of radius 1 m: voussoirs, thickness / radius; multipliers at nine displacements, the last
#: displacement and those of the jumps. Displacements are tenths of the last one but for (20, 0.15).
ARCHES = {
    (10, 0.20): (
        [0.267648025, 0.237494612, 0.208649229, 0.180913162, 0.154115420]
        + [0.128106907, 0.102755827, 0.077944014, 0.053563936],
        0.053679464,
        [0.053679464],
    ),
    (20, 0.20): (
        [0.260125176, 0.235725730, 0.196969252, 0.168786828, 0.141954193]
        + [0.105535254, 0.077979759, 0.051287154, 0.025331462],
        0.039342556,
        [0.008418042, 0.022195129],
    ),
    (20, 0.15): (
        [0.137146788, 0.125147093, 0.113339235, 0.101712026, 0.090254884]
        + [0.078957783, 0.067811205, 0.056806103, 0.045933860],
        0.015107185,
        [0.014390927],
    ),
}
#: An arch of 20 voussoirs, 0.5 m thick, of radius 2.5 m on buttresses 1 m wide, by their height [m].
PORTALS = {
    5.0: (
        [0.041027727, 0.036539410, 0.032036904, 0.027518816, 0.022983718]
        + [0.018430139, 0.013856566, 0.009261437, 0.004643138],
        0.041139882,
        [],
    ),
    2.5: (
        [0.122419690, 0.108232519, 0.094801503, 0.081383136, 0.067957706]
        + [0.054505153, 0.041004891, 0.027435622, 0.013775118],
        0.084788749,
        [0.009017518],
    ),
}
#: Relative rounding of the last displacements: half of their last digit.
DIGITS = 0.5e-9 / min(end for known in (ARCHES, PORTALS) for _, end, _ in known.values())


def overturning(width: float, height: float, moved: np.ndarray) -> np.ndarray:
    """Multiplier of a block that turns over its toe, by the displacement of its centroid: zero above the toe."""
    left = width / 2 - np.asarray(moved)
    return left / np.sqrt((width**2 + height**2) / 4 - left**2)
