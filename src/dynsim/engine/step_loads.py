"""Forces and couples that act on the blocks for one time step, given to them as velocities.

Bullet's rows of friction leave the external torque of the step out (those of the normal force have it), so what leans
on friction under an external torque creeps. A velocity they see.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from blockstat.typing import Floats

if TYPE_CHECKING:
    from dynsim.engine.world import World


class StepLoads:
    """Collects what the actions add, and applies it once a step."""

    def __init__(self, world: World) -> None:
        assembly = world.assembly
        self._world = world
        self._inverse = np.linalg.inv(assembly.inertia)
        self._sum = np.zeros((2, assembly.n_blocks, 3))  #: forces [N] and couples [N m]
        self._used = False
        self.inertia_scale = 1.0
        self.keep = 1.0  #: share of the velocities that damping leaves in a step; Bullet's own would take the loads too

    def add(self, forces: Floats, couples: Floats) -> None:
        """Forces at the centroids and couples, shape (n_blocks, 3) [N], [N m]."""
        self._sum += forces, couples
        self._used = True

    def apply(self) -> None:
        """Change the velocities."""
        if not self._used and self.keep == 1.0:
            return
        world = self._world
        rotation = world.poses()[1]
        inverse = rotation @ self._inverse @ rotation.swapaxes(1, 2) / self.inertia_scale
        linear, angular = (self.keep * value for value in world.velocities())
        linear += self._sum[0] * (world.time_step / world.assembly.mass[:, None])
        angular += np.einsum("nij,nj->ni", inverse, self._sum[1]) * world.time_step
        blocks = world.assembly.free
        if world.removed:
            blocks = np.setdiff1d(blocks, list(world.removed))
        world.set_velocities(blocks, linear[blocks], angular[blocks])
        self._sum[:] = 0.0
        self._used = False
