"""Props: struts from the ground that push on blocks along fixed lines and never pull.

A prop is elastic and as stiff as the time step allows, k = m / dt^2 with damping k dt (see `dynsim.bonds.ties`), m the
mass that it moves. Under a force T it gives by T dt^2 / m, as far as T moves m in one step. It has no force when it is
set up.
"""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.typing import Floats, Ints
from dynsim.bonds.joint_motion import Poses, moved_mass
from dynsim.engine.world import World


class PropForces:
    """Props under the blocks of an assembly, set up and taken away while it is simulated."""

    each_step = True

    def __init__(self, assembly: Assembly, blocks: Ints, points: Floats, directions: Floats) -> None:
        """Take the props; none of them stands yet.

        Parameters
        ----------
        assembly : Assembly
            The blocks.
        blocks : array of int, shape (n,)
            The block that each prop pushes.
        points : array of float, shape (n, 3)
            Where, on the blocks as built [m].
        directions : array of float, shape (n, 3)
            Which way they push; of any length.
        """
        self._block, self._point = np.asarray(blocks, dtype=np.int64), np.asarray(points, dtype=float)
        directions = np.asarray(directions, dtype=float)
        self._line = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        self._mass = moved_mass(assembly, self._block[:, None], self._point[:, None], self._line)
        self._standing = np.zeros(len(self._block), dtype=bool)
        self._start = np.zeros(len(self._block))  #: of the point along the line, where the prop has no force [m]
        self._before = np.zeros(len(self._block))
        self.force = np.zeros(len(self._block))  #: of the last time step, shape (n,) [N]

    def stand(self, world: World, standing: np.ndarray) -> None:
        """Set props up, where their blocks are now, and take others away.

        Parameters
        ----------
        world : World
            What the blocks are in.
        standing : array of bool, shape (n,)
            Which props stand from now on.
        """
        along = self._along(Poses(world))
        self._start = np.where(standing & ~self._standing, along, self._start)
        self._standing, self._before = standing.copy(), along

    def begin(self, world: World) -> None:
        """Do nothing: no prop stands before it is set up.

        Parameters
        ----------
        world : World
            What the action acts on.
        """

    def act(self, world: World, time: float) -> None:
        """Apply what the props push with in the next time step.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s].
        """
        self.force = np.zeros(len(self._block))
        if not self._standing.any():
            return
        poses = Poses(world)
        along = self._along(poses)
        wanted = (self._start - along) + (self._before - along)  # the second is the velocity, times the step
        self.force = np.where(self._standing, self._mass / world.time_step**2 * np.maximum(wanted, 0.0), 0.0)
        self._before = along
        push = self.force[:, None] * self._line
        total, moment = np.zeros((2, len(poses.centroid), 3))
        np.add.at(total, self._block, push)
        np.add.at(moment, self._block, np.cross(self._arm(poses), push))
        world.load(total, moment)

    def _arm(self, poses: Poses) -> Floats:
        """From the centroids to the points as they are now, shape (n, 3) [m]."""
        return np.einsum("nij,nj->ni", poses.rotation[self._block], self._point - poses.built[self._block])

    def _along(self, poses: Poses) -> Floats:
        """Where the points are along their lines, shape (n,) [m]."""
        return np.einsum("ni,ni->n", poses.centroid[self._block] + self._arm(poses), self._line)
