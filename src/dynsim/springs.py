"""Springs across joints, elastic up to a capacity and perfectly plastic beyond it.

Each joint has four: tension, shear, bending and torsion. Bullet steps with symplectic Euler, which is stable while the largest
eigenvalue of M^-1 (dt^2 K + 2 dt C) is below 4. With K = sum_j k_j B_j' B_j and |B_j y|^2 <= 2 |B_ja|^2 |y_a|^2 + 2 |B_jb|^2 |y_b|^2
for the two blocks of a joint, that of M^-1 K is at most the largest sum over the springs of one block of 2 k_j |B_jc|^2, where
|B_jc|^2 is the mobility of the block along the spring. So a spring may be as stiff as k = 1 / (8 dt^2 z_c |B_jc|^2) at either of its
blocks c, z_c the number of its joints, and as viscous as k dt: all together then come to 3. Stiffer ones are made so.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from blockstat.assembly import Assembly
from blockstat.cells import centres
from blockstat.contact import Interfaces
from blockstat.polyhedron import Floats, Ints
from dynsim.joint_motion import Poses, apply_on_pairs, at_points, reach

if TYPE_CHECKING:
    from dynsim.world import World


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
    reach: Floats  #: motion that breaks it [m], inf for none
    time_step: float  #: [s]
    broken: np.ndarray = field(init=False)  #: bool
    _before: tuple[Floats, Floats] | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.broken = np.zeros(len(self.pair), dtype=bool)

    def act(self, world: World) -> None:
        """Apply what the springs carry now for one time step."""
        poses = Poses(world)
        at, apart, turn = at_points(poses, self.pair, self.centre)
        frame = self.frame @ turn.swapaxes(1, 2)
        shift = np.einsum("nij,nj->ni", frame, apart)
        relative = poses.rotation[self.pair[:, 1]] @ turn.swapaxes(1, 2)
        angle = np.einsum("nij,nj->ni", frame, rotation_vector(relative))
        moved = np.maximum(np.linalg.norm(shift, axis=1), self.size * np.linalg.norm(angle, axis=1))
        self.broken |= moved > self.reach
        last_shift, last_angle = self._before or (shift, angle)
        self._before = shift, angle
        # The difference of two places is the velocity of symplectic Euler, exactly.
        force = -self.stiffness * shift - self.viscous * (shift - last_shift) / self.time_step
        couple = -self.angular * angle - self.angular_viscous * (angle - last_angle) / self.time_step
        force = np.where(self.broken[:, None], 0.0, _capped(force, self.force))
        force[:, 0] = np.minimum(force[:, 0], 0.0)  # pressure is the contact's
        couple = np.where(self.broken[:, None], 0.0, _capped(couple, self.moment))
        back = frame.swapaxes(1, 2)
        apply_on_pairs(
            world, poses, self.pair, at, np.einsum("nij,nj->ni", back, force), np.einsum("nij,nj->ni", back, couple)
        )


def _capped(value: Floats, capacity: Floats) -> Floats:
    """Components (n, t1, t2) within a capacity along the normal and one across it."""
    across = np.linalg.norm(value[:, 1:], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(across > capacity, capacity / across, 1.0)
    along = np.clip(value[:, 0], -capacity, capacity)
    return np.column_stack([along, value[:, 1:] * share[:, None]])


def rotation_vector(rotation: Floats) -> Floats:
    """Axis times angle of rotation matrices, shape (n, 3) [rad]; angles below pi."""
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
    """Springs at the centres of some interfaces, no stiffer than the time step allows.

    stiffness, angular : [N/m], [N m/rad], inf for the stiffest; force, moment : capacities, shape (n,) [N], [N m];
    damping : of each spring, as a share of the critical one of its joint.
    """
    assembly = world.assembly
    pair, centre, frame = interfaces.pair[rows], centres(interfaces, rows), interfaces.frame[rows]
    joints = np.bincount(pair.reshape(-1), minlength=assembly.n_blocks)[pair]
    found = []
    for wanted, mobility in zip((stiffness, angular), _mobilities(assembly, pair, centre), strict=True):
        along = _along(frame, mobility)
        most = 1.0 / (8.0 * world.time_step**2 * (joints[:, :, None] * along).max(axis=1))
        k = np.minimum(wanted, most)
        found += [k, np.minimum(2 * damping * np.sqrt(k / along.sum(axis=1)), most * world.time_step)]
    return Springs(
        pair=pair,
        centre=centre,
        frame=frame,
        size=np.sqrt(interfaces.area[rows]),
        stiffness=found[0],
        viscous=found[1],
        angular=found[2],
        angular_viscous=found[3],
        force=force,
        moment=moment,
        reach=reach(assembly, pair) if breaks else np.full(len(rows), np.inf),
        time_step=world.time_step,
    )


def _mobilities(assembly: Assembly, pair: Ints, centre: Floats) -> tuple[Floats, Floats]:
    """What a unit force at the centres and a unit moment do to each block of joints, 0 for a support.

    Two arrays of shape (n, 2, 3, 3): acceleration of the centre [1/kg], and of the rotation [1/(kg m2)].
    """
    free = (~assembly.support)[pair][:, :, None, None]
    turning = np.linalg.inv(assembly.inertia)[pair] * free
    arm = centre[:, None] - assembly.centroid[pair]
    cross = np.cross(np.eye(3)[None, None], arm[:, :, None])  # row i is e_i x r, the rotation's effect seen along e_i
    moving = np.eye(3) / assembly.mass[pair][:, :, None, None] * free + cross @ turning @ cross.swapaxes(2, 3)
    return moving, turning


def _along(frame: Floats, mobility: Floats) -> Floats:
    """Largest mobility along the normal and across it, shape (n, 2, 3) for n, t1, t2."""
    local = frame[:, None] @ mobility @ frame[:, None].swapaxes(2, 3)
    across = np.linalg.eigvalsh(local[:, :, 1:, 1:])[..., -1]
    return np.stack([local[:, :, 0, 0], across, across], axis=2)
