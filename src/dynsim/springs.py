"""Springs across joints, elastic up to a capacity and perfectly plastic beyond it.

Bullet steps with symplectic Euler, which is stable while dt^2 K + 2 dt C < 4 M (as an eigenvalue). With K = sum_j k_j B_j' B_j, and
|B_j y|^2 <= 2 |B_ja|^2 |y_a|^2 + 2 |B_jb|^2 |y_b|^2 for the two blocks of a joint, the largest eigenvalue of M^-1 K is at most the
largest sum over the joints of one block of 2 k_j |B_jc|^2; |B_jc|^2 is 1/m + r^2/I for a force at a distance r from the
centroid and 1/I for a moment, I the least principal moment of inertia. So a joint may be as stiff as
k = 1 / (4 dt^2 z_c |B_jc|^2) at either of its blocks c, z_c the number of its joints, and as viscous as k dt: forces and moments then
come to 3/2 each. Stiffer ones are made so.
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
    stiffness: Floats  #: [N/m], 0 for none
    angular: Floats  #: [N m/rad]
    viscous: Floats  #: [N s/m]
    angular_viscous: Floats  #: [N m s/rad]
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
        force = _pull(self.stiffness, shift, self.viscous, (shift - last_shift) / self.time_step)
        couple = _pull(self.angular, angle, self.angular_viscous, (angle - last_angle) / self.time_step)
        force = np.where(self.broken[:, None], 0.0, _capped(force, self.force))
        force[:, 0] = np.minimum(force[:, 0], 0.0)  # pressure is the contact's
        couple = np.where(self.broken[:, None], 0.0, _capped(couple, self.moment))
        back = frame.swapaxes(1, 2)
        apply_on_pairs(
            world, poses, self.pair, at, np.einsum("nij,nj->ni", back, force), np.einsum("nij,nj->ni", back, couple)
        )


def _pull(stiffness: Floats, amount: Floats, viscous: Floats, rate: Floats) -> Floats:
    """Force on block b, shape (n, 3)."""
    return -(stiffness[:, None] * amount + viscous[:, None] * rate)


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
    pair, centre = interfaces.pair[rows], centres(interfaces, rows)
    mass, turning = _mobility(assembly, pair, centre)
    joints = np.bincount(pair.reshape(-1), minlength=assembly.n_blocks)[pair]
    most, most_angular = (1.0 / (4.0 * world.time_step**2 * (joints * m).max(axis=1)) for m in (mass, turning))
    k, angular_k = np.minimum(stiffness, most), np.minimum(angular, most_angular)
    return Springs(
        pair=pair,
        centre=centre,
        frame=interfaces.frame[rows],
        size=np.sqrt(interfaces.area[rows]),
        stiffness=k,
        angular=angular_k,
        viscous=np.minimum(2 * damping * np.sqrt(k / mass.sum(axis=1)), most * world.time_step),
        angular_viscous=np.minimum(2 * damping * np.sqrt(angular_k / turning.sum(axis=1)), most_angular * world.time_step),
        force=force,
        moment=moment,
        reach=reach(assembly, pair) if breaks else np.full(len(rows), np.inf),
        time_step=world.time_step,
    )


def _mobility(assembly: Assembly, pair: Ints, centre: Floats) -> tuple[Floats, Floats]:
    """Bounds on |B_jc|^2 of forces [1/kg] and moments [1/(kg m2)] at both blocks of joints, shape (n, 2); 0 for a support."""
    free = ~assembly.support
    least = np.linalg.eigvalsh(assembly.inertia)[:, 0]
    arm = ((centre[:, None] - assembly.centroid[pair]) ** 2).sum(axis=2)
    turning = np.where(free, 1.0 / least, 0.0)[pair]
    return np.where(free, 1.0 / assembly.mass, 0.0)[pair] + arm * turning, turning
