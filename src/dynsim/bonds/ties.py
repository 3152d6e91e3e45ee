"""Ties, struts, tendons and anchors: forces along the lines between points of two blocks.

The statics give a tie any force from `least` to `greatest` and no stretch. In a simulation its force needs one: the
tie is elastic between the two, yields at `greatest` and never pulls with less than `least`. A tie with one force alone
has it throughout, along the line of its ends as they move. Bullet steps with symplectic Euler, which is stable while
dt^2 k / m + 2 dt c / m stays below 4, m the mass that the tie moves. With k = m / dt^2 and c = k dt that is 3: the
stiffest tie that the time step allows. At a force T it stretches by T dt^2 / m, as far as T moves m in one step.
"""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.program.ties import tied_pairs
from dynsim.bonds.joint_motion import Poses, apply_on_pairs, moved_mass, removed
from dynsim.engine.world import World


class TieForces:
    """The ties of an assembly; those between two supports do nothing and are left out."""

    each_step = True

    def __init__(self, assembly: Assembly) -> None:
        """Take the ties, with the lengths that they have as built."""
        pair = tied_pairs(assembly)
        live = np.flatnonzero(~assembly.support[pair].all(axis=1))
        ties = [assembly.ties[k] for k in live]
        self._pair = pair[live]
        self._points = np.array([tie.points for tie in ties], dtype=float).reshape(-1, 2, 3)
        self._least = np.array([tie.least for tie in ties])
        self._greatest = np.array([tie.greatest for tie in ties])
        self._sign = np.array([-1.0 if tie.strut else 1.0 for tie in ties])
        line = self._points[:, 1] - self._points[:, 0]
        self._built = np.linalg.norm(line, axis=1)  #: [m]
        self._mass = moved_mass(assembly, self._pair, self._points, line / self._built[:, None])
        self._as_built()

    def _as_built(self) -> None:
        self._rest = self._built  #: length at which the force is the least [m]
        self._before = self._built
        self.force = self._least  #: of the last time step, tension or compression of struts, shape (n,) [N]

    def begin(self, world: World) -> None:
        """Give the ties their lengths as built, at rest, whatever an earlier run has done to them.

        Parameters
        ----------
        world : World
            What the action acts on.
        """
        self._as_built()

    def act(self, world: World, time: float) -> None:
        """Apply what the ties carry for the next time step.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        poses, step = Poses(world), world.time_step
        one, two = (
            poses.centroid[block]
            + np.einsum("nij,nj->ni", poses.rotation[block], self._points[:, side] - poses.built[block])
            for side, block in enumerate(self._pair.T)
        )
        line = one - two
        length = np.linalg.norm(line, axis=1)
        stiffness = self._mass / step**2
        stretch = self._sign * (length - self._rest)
        # The difference of two places is the velocity of symplectic Euler, exactly.
        wanted = self._least + stiffness * (stretch + self._sign * (length - self._before))
        force = np.clip(wanted, self._least, self._greatest)
        self.force = np.where(removed(world, self._pair), 0.0, force)
        self._rest = self._rest + self._sign * np.maximum(stretch - (self._greatest - self._least) / stiffness, 0.0)
        self._before = length
        pull = (self._sign * self.force / np.where(length > 0, length, 1.0))[:, None] * line
        apply_on_pairs(world, poses, self._pair, two, pull)
