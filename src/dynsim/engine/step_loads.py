"""Forces and couples of one time step, applied as changes of velocity.

Bullet's friction rows do not include the external torque of the step (the rows of the normal force do), so a block that
leans on friction under an external torque creeps. They do include velocities.
"""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.typing import Floats


class StepLoads:
    """The forces and couples that actions add in a time step, and the velocities they lead to."""

    def __init__(self, assembly: Assembly) -> None:
        """Start with no loads.

        Parameters
        ----------
        assembly : Assembly
            The blocks that loads are added to.
        """
        self._mass = assembly.mass
        self._inverse = np.linalg.inv(assembly.inertia)
        self._sum = np.zeros((2, assembly.n_blocks, 3))  #: forces [N] and couples [N m]
        self._used = False

    @property
    def idle(self) -> bool:
        """Whether nothing was added since the last step."""
        return not self._used

    def add(self, forces: Floats, couples: Floats) -> None:
        """Add forces at the centroids and couples to those of the next time step.

        Parameters
        ----------
        forces, couples : array of float, shape (n_blocks, 3)
            Forces [N] and couples [N m].
        """
        self._sum += forces, couples
        self._used = True

    def take(
        self,
        rotation: Floats,
        linear: Floats,
        angular: Floats,
        time_step: float,
        *,
        left: float,
        inertia_scale: float,
    ) -> tuple[Floats, Floats]:
        """Return the velocities after what was added since the last call, and forget it.

        Parameters
        ----------
        rotation : array of float, shape (n_blocks, 3, 3)
            Rotation of the blocks since built.
        linear, angular : array of float, shape (n_blocks, 3)
            Velocities before [m/s], [1/s].
        time_step : float
            Time step [s].
        left : float
            Share of the velocities before that damping leaves.
        inertia_scale : float
            Factor on the inertia as built.

        Returns
        -------
        linear, angular : array of float, shape (n_blocks, 3)
            Velocities after [m/s], [1/s].
        """
        inverse = rotation @ self._inverse @ rotation.swapaxes(1, 2) / inertia_scale
        linear = left * linear + self._sum[0] * (time_step / self._mass[:, None])
        angular = left * angular + np.einsum("nij,nj->ni", inverse, self._sum[1]) * time_step
        self._sum[:] = 0.0
        self._used = False
        return linear, angular
