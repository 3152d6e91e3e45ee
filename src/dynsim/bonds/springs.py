"""Springs across joints, elastic up to a capacity and perfectly plastic beyond it.

Each joint has four: tension, shear, bending and torsion. Bullet steps with symplectic Euler, which is stable while no
eigenvalue of M^-1 (dt^2 K + 2 dt C) exceeds 4. The stiffness of a spring is at most k, its share of a K whose
dt^2 M^-1 K has the largest eigenvalue 1, and its viscosity at most k dt: together that is 3. Springs that are asked to
be stiffer get that stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.cells import centres
from blockstat.contact.interfaces import Interfaces
from blockstat.program.bonds import bond_columns
from blockstat.program.equilibrium import equilibrium
from blockstat.typing import Floats, Ints
from dynsim.bonds.joint_motion import Poses, apply_on_pairs, at_points, reach, removed
from dynsim.engine.world import World

#: Bullet's damping while settling. Springs give, and with all velocity taken away they would hardly begin to: this
#: leaves exp(-16) of it after a second at simulation scale, the critical damping of a mode of 8 rad/s. Once a joint has
#: failed, all of it is taken, so that nothing falls before its release.
SETTLING = 1.0 - float(np.exp(-16.0))


@dataclass(eq=False)
class Springs:
    """Springs at the centres of some joints; arrays of shape (n,) unless said otherwise."""

    pair: Ints  #: shape (n, 2)
    centre: Floats  #: as built, shape (n, 3) [m]
    frame: Floats  #: as built, rows n, t1, t2, shape (n, 3, 3)
    size: Floats  #: side of a square of the joint's area [m], the arm of a rotation
    stiffness: Floats  #: along n, t1, t2, shape (n, 3) [N/m], 0 for none
    angular: Floats  #: about n, t1, t2, shape (n, 3) [N m/rad]
    viscous: Floats  #: shape (n, 3) [N s/m]
    angular_viscous: Floats  #: shape (n, 3) [N m s/rad]
    force: Floats  #: capacity in tension and in shear [N]
    moment: Floats  #: capacity in bending and in torsion [N m]
    reach: Floats  #: motion beyond which a joint has failed [m]
    breaks: bool  #: whether its spring is then gone
    broken: np.ndarray = field(init=False)  #: bool
    _damping: float = field(init=False, default=0.0)
    _before: tuple[Floats, Floats, float] | None = field(init=False, default=None)  # with the time step since [s]

    def __post_init__(self) -> None:
        self.broken = np.zeros(len(self.pair), dtype=bool)

    def act(self, world: World, time: float) -> None:
        """Apply what the springs carry for the next time step.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        poses = Poses(world)
        at, offset, turn = at_points(poses, self.pair, self.centre)
        frame = self.frame @ turn.swapaxes(1, 2)
        shift = np.einsum("nij,nj->ni", frame, offset)
        relative = poses.rotation[self.pair[:, 1]] @ turn.swapaxes(1, 2)
        angle = np.einsum("nij,nj->ni", frame, rotation_vector(relative))
        moved = np.maximum(np.linalg.norm(shift, axis=1), self.size * np.linalg.norm(angle, axis=1))
        beyond = moved > self.reach
        if time < 0:
            self._damp(world, 1.0 if beyond.any() else SETTLING)
        self.broken |= (beyond & self.breaks & (time >= 0)) | removed(world, self.pair)
        last_shift, last_angle, step = self._before or (shift, angle, world.time_step)
        self._before = shift, angle, world.time_step
        # The difference of two places is the velocity of symplectic Euler, exactly.
        force = -self.stiffness * shift - self.viscous * (shift - last_shift) / step
        couple = -self.angular * angle - self.angular_viscous * (angle - last_angle) / step
        force = np.where(self.broken[:, None], 0.0, _capped(force, self.force))
        force[:, 0] = np.minimum(force[:, 0], 0.0)  # pressure is the contact's
        couple = np.where(self.broken[:, None], 0.0, _capped(couple, self.moment))
        back = frame.swapaxes(1, 2)
        apply_on_pairs(
            world, poses, self.pair, at, np.einsum("nij,nj->ni", back, force), np.einsum("nij,nj->ni", back, couple)
        )

    def _damp(self, world: World, value: float) -> None:
        if value != self._damping:
            world.damp(value)
            self._damping = value


def _capped(value: Floats, capacity: Floats) -> Floats:
    """Components (n, t1, t2) within a capacity along the normal and one across it."""
    across = np.linalg.norm(value[:, 1:], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(across > capacity, capacity / across, 1.0)
    along = np.clip(value[:, 0], -capacity, capacity)
    return np.column_stack([along, value[:, 1:] * share[:, None]])


def rotation_vector(rotation: Floats) -> Floats:
    """Return axis times angle of rotation matrices.

    Parameters
    ----------
    rotation : array of float, shape (n, 3, 3)
        Rotations by less than pi.

    Returns
    -------
    array of float, shape (n, 3)
        Rotation vectors [rad].
    """
    axis = 0.5 * np.stack(
        [rotation[:, i, j] - rotation[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1
    )  # sin(angle) times the axis
    sine = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sine, 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1.0))
    return axis * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 1.0)[:, None]


def spring_set(
    world: World,
    interfaces: Interfaces,
    rows: Ints,
    *,
    stiffness: float,
    angular: float,
    force: Floats,
    moment: Floats,
    damping: float,
    breaks: bool,
) -> Springs:
    """Return springs at the centres of some interfaces, no stiffer than the time step allows.

    Parameters
    ----------
    world : World
        What the blocks are in.
    interfaces : Interfaces
        Joints of its assembly.
    rows : array of int, shape (n,)
        Which of them have springs.
    stiffness, angular : float
        Stiffness in translation [N/m] and in rotation [N m/rad]; inf for the stiffest, 0 for none.
    force, moment : array of float, shape (n,)
        Capacities [N], [N m].
    damping : float
        Of each spring, as a share of the critical damping of its joint.
    breaks : bool
        Whether a spring is gone once its joint has failed.

    Returns
    -------
    Springs
        The springs.
    """
    assembly = world.assembly
    pair, centre = interfaces.pair[rows], centres(interfaces, rows)
    reduced = _reduced(assembly, pair, centre, interfaces.frame[rows])
    wanted = np.array([stiffness, angular])[:, None, None]
    joints = np.bincount(pair.reshape(-1), minlength=assembly.n_blocks)[pair].max(axis=1)
    share = np.where(wanted > 0, reduced / joints[:, None], 0.0)
    step = max(world.settings.settle_step or 0.0, world.settings.time_step) / world.time  # the longest of the run
    most = share / (step**2 * _fastest(assembly, interfaces, rows, share))
    k = np.minimum(wanted, most)
    viscous = np.minimum(2 * damping * np.sqrt(k * reduced), most * step)
    return Springs(
        pair=pair,
        centre=centre,
        frame=interfaces.frame[rows],
        size=np.sqrt(interfaces.area[rows]),
        stiffness=k[0],
        angular=k[1],
        viscous=viscous[0],
        angular_viscous=viscous[1],
        force=force,
        moment=moment,
        reach=reach(assembly, pair),
        breaks=breaks,
    )


def _fastest(assembly: Assembly, interfaces: Interfaces, rows: Ints, stiffness: Floats) -> float:
    """Largest eigenvalue of M^-1 K [1/s2]; stiffness : forces and moments along n, t1, t2, shape (2, n_rows, 3)."""
    from scipy import sparse
    from scipy.sparse.linalg import eigsh

    free = assembly.free
    columns = bond_columns(interfaces, rows)
    matrix = equilibrium(assembly, interfaces, np.zeros((assembly.n_blocks, 6)), free, rows[:0], (columns,)).matrix
    (tension, *shear), (torsion, *bending) = stiffness.transpose(0, 2, 1)
    arm2 = interfaces.area[rows]
    none = np.zeros(len(rows))
    k = [(tension, none, none), (none, *shear), (none, *(b / arm2 for b in bending)), (none, torsion / arm2, none)]
    # A mass matrix' root: of the mass, and of the inertia by its Cholesky factor.
    root = np.linalg.inv(np.linalg.cholesky(assembly.inertia[free]))
    inverse = np.zeros((len(free), 6, 6))
    inverse[:, :3, :3] = np.eye(3) / np.sqrt(assembly.mass[free])[:, None, None]
    inverse[:, 3:, 3:] = root
    weighted = (
        sparse.block_diag(list(inverse)) @ matrix @ sparse.diags(np.sqrt(np.moveaxis(np.array(k), 2, 0).reshape(-1)))
    )
    gram = (weighted @ weighted.T).tocsr()
    start = np.random.default_rng(0).normal(size=gram.shape[0])
    return float(eigsh(gram, k=1, v0=start, return_eigenvectors=False)[0])


def _reduced(assembly: Assembly, pair: Ints, centre: Floats, frame: Floats) -> Floats:
    """Mass [kg] and inertia [kg m2] that the springs of each joint move, along n, t1, t2, shape (2, n, 3)."""
    moving, turning = (_along(frame, mobility).sum(axis=1) for mobility in _mobilities(assembly, pair, centre))
    return 1.0 / np.array([moving, turning])


def _mobilities(assembly: Assembly, pair: Ints, centre: Floats) -> tuple[Floats, Floats]:
    """Return what a unit force at the centres and a unit moment do to each block of joints, 0 for a support.

    Two arrays of shape (n, 2, 3, 3): acceleration of the centre [1/kg], and of the rotation [1/(kg m2)].
    """
    free = (~assembly.support)[pair][:, :, None, None]
    turning = np.linalg.inv(assembly.inertia)[pair] * free
    arm = centre[:, None] - assembly.centroid[pair]
    cross = np.cross(np.eye(3)[None, None], arm[:, :, None])  # row i is e_i x r, the rotation's effect seen along e_i
    moving = np.eye(3) / assembly.mass[pair][:, :, None, None] * free + cross @ turning @ cross.swapaxes(2, 3)
    return np.asarray(moving, dtype=float), np.asarray(turning, dtype=float)


def _along(frame: Floats, mobility: Floats) -> Floats:
    """Largest mobility along the normal and across it, shape (n, 2, 3) for n, t1, t2."""
    local = frame[:, None] @ mobility @ frame[:, None].swapaxes(2, 3)
    across = np.linalg.eigvalsh(local[:, :, 1:, 1:])[..., -1]
    return np.stack([local[:, :, 0, 0], across, across], axis=2).astype(float)
