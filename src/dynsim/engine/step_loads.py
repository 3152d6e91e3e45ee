"""Forces and couples that act on the blocks for one time step, given to them as velocities.

Bullet's rows of friction leave the external torque of the step out (those of the normal force have it), so what leans
on friction under an external torque creeps. A velocity they see.
"""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.typing import Floats


class StepLoads:
    """Collects what the actions add in a time step, and turns it into velocities."""

    def __init__(self, assembly: Assembly) -> None:
        self._mass = assembly.mass
        self._inverse = np.linalg.inv(assembly.inertia)
        self._sum = np.zeros((2, assembly.n_blocks, 3))  #: forces [N] and couples [N m]
        self._used = False
        self.inertia_scale = 1.0
        self.keep = 1.0  #: share of the velocities that damping leaves in a step; Bullet's own would take the loads too

    @property
    def idle(self) -> bool:
        """Whether the velocities stay as they are."""
        return not self._used and self.keep == 1.0

    def add(self, forces: Floats, couples: Floats) -> None:
        """Forces at the centroids and couples, shape (n_blocks, 3) [N], [N m]."""
        self._sum += forces, couples
        self._used = True

    def take(self, rotation: Floats, linear: Floats, angular: Floats, time_step: float) -> tuple[Floats, Floats]:
        """Velocities with what was added since the last time, which is forgotten.

        rotation : since built, shape (n_blocks, 3, 3); linear, angular : shape (n_blocks, 3) [m/s], [1/s];
        time_step : [s].
        """
        inverse = rotation @ self._inverse @ rotation.swapaxes(1, 2) / self.inertia_scale
        linear = self.keep * linear + self._sum[0] * (time_step / self._mass[:, None])
        angular = self.keep * angular + np.einsum("nij,nj->ni", inverse, self._sum[1]) * time_step
        self._sum[:] = 0.0
        self._used = False
        return linear, angular
