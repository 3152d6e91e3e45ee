"""The joint laws of an assembly as bonds in Bullet.

There are two kinds of bond. Each is the exact twin of a static one of `blockstat.joint`.

A joint with tension and without a moment capacity is a **cohesive preload**: equal and opposite forces along the normal
at the corners of the joint, T in total, as if a spring of no stiffness pressed the blocks together. The contact then
carries f' = f + T with f'_n >= 0 and |f'_t| <= mu f'_n. That is Coulomb's law with a tension cut-off T and a cohesion
mu T.

A bond with a moment capacity is a **perfectly plastic spring** at the centre of the joint, as stiff as the time step
allows (see `dynsim.bonds.springs`). It has capacities in tension, shear, bending and torsion, each by itself.

Either breaks for good when, after release, its blocks have moved apart or slid by more than the gap up to which a joint
is one (`blockstat.contact.interfaces.GAP`). A bond with a moment capacity also breaks when its blocks have turned by
that much over the size of the joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces, find_interfaces
from blockstat.contact.point_law import PointLaw, last_law, point_law
from blockstat.errors import InputError, known_options
from blockstat.joint import JointLaw
from blockstat.program.bonds import bonded
from blockstat.typing import Floats, Ints
from dynsim.bonds.joint_motion import Poses, apply_on_pairs, at_points, reach, removed
from dynsim.bonds.springs import Springs, spring_set
from dynsim.bonds.ties import TieForces
from dynsim.engine.world import Action, World
from dynsim.loads.ground import Pulse, Ramp, Record
from dynsim.loads.load import Load
from dynsim.loads.loading import Constant, Tilt

#: A cohesion that exceeds friction x tension by less than this share of it does so by rounding.
ROUNDING = 1e-9


@known_options
def bonds_of(assembly: Assembly, *, interfaces: Interfaces | None = None) -> tuple[Action, ...]:
    """Return the actions that stand for the joint laws and the ties of an assembly.

    Parameters
    ----------
    assembly : Assembly
        Blocks, joint laws and ties.
    interfaces : Interfaces, optional
        Joints of the assembly; searched for when None.

    Returns
    -------
    tuple of Action
        Ties, bonds and cohesive preloads; none for dry joints without ties.

    Raises
    ------
    InputError
        Naming the law: for a compressive strength, and for a cohesion above friction times tension. Neither can be
        simulated exactly.

    Examples
    --------
    >>> from blockstat import Assembly, box, glued
    >>> from dynsim import bonds_of
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> len(bonds_of(pillar)), len(bonds_of(glued(pillar, 1000.0)))
    (0, 1)
    """
    actions: list[Action] = [TieForces(assembly)] if assembly.ties else []
    if not assembly.joints:
        return tuple(actions)
    interfaces = find_interfaces(assembly) if interfaces is None else interfaces
    law = point_law(assembly, interfaces)
    _check(assembly, interfaces, law)
    if law.shift.any():
        actions.append(CohesivePreload(interfaces, law.shift))
    if len(bonded(assembly, interfaces)[0]):
        actions.append(CentreBonds(interfaces))
    return tuple(actions)


def weakened(
    assembly: Assembly, interfaces: Interfaces, loads: Sequence[Load] = (), times: float = 1.0
) -> Assembly | None:
    """Return the assembly with no joint glued by more than the weight of all free blocks and the loads on them.

    Parameters
    ----------
    assembly : Assembly
        Blocks and joint laws.
    interfaces : Interfaces
        Joints of the assembly.
    loads : sequence of Load
        What acts besides the weight. Of motions of the ground the largest acceleration counts, of a tilt the change of
        gravity; what moves or removes blocks has no size.
    times : float
        How many times that is the most.

    Returns
    -------
    Assembly or None
        None where no joint law is stronger than that.

    Notes
    -----
    What stands with weaker glue stands with stronger glue under loads that last, and under loads that change where the
    weaker glue does not crack. But the contact solver has to carry every preload too, and far above what is needed it
    makes blocks creep. Glued blocks that move with the ground as one body ask of a joint no
    more force than this, and a moment of it about the joint. So what is needed is a few times as much in a slender one.
    """
    if not assembly.joints:
        return None
    most = times * (assembly.free_weight + sum(_size(load, assembly) for load in loads))
    area = float(interfaces.area.max(initial=0.0)) or 1.0
    laws = [_at_most(law, most, area) for law in assembly.joints]
    return None if laws == list(assembly.joints) else assembly.with_(joints=laws)


def changed_joints(given: Assembly, weak: Assembly, interfaces: Interfaces) -> Ints:
    """Return the joints that are glued in another way in one assembly than in another one of the same blocks.

    Parameters
    ----------
    given, weak : Assembly
        The assemblies.
    interfaces : Interfaces
        Joints of both.

    Returns
    -------
    array of int
        Rows of the interfaces.
    """
    laws = zip(last_law(given, interfaces), last_law(weak, interfaces), strict=True)
    return np.flatnonzero([own != other for own, other in laws])


def _size(load: Load, assembly: Assembly) -> float:
    """What a load asks of the blocks at most, to be compared with their weight [N]."""
    if isinstance(load, Constant):
        return load.size(assembly)
    strength = 0.0
    if isinstance(load, Tilt):
        strength = 2 * np.sin(np.deg2rad(min(abs(load.to), 180.0)) / 2) * np.linalg.norm(assembly.gravity)
    elif isinstance(load, Pulse):
        strength = np.linalg.norm(load.peak)
    elif isinstance(load, Ramp):
        strength = np.linalg.norm(load.to)
    elif isinstance(load, Record):
        strength = np.linalg.norm(load.acceleration, axis=1).max()
    return float(assembly.mass[assembly.free].sum() * strength)


def _at_most(law: JointLaw, most: float, area: float) -> JointLaw:
    """Return a law whose tension is at most `most` [N] on a joint of that area [m2], its other strengths in ratio."""
    share = min(1.0, most / max(law.bond, law.tension * area, 1e-300))
    if share == 1.0:
        return law
    moment = None if law.bond_moment is None else share * law.bond_moment
    cohesion = None if law.cohesion is None else share * law.cohesion
    return replace(law, bond=share * law.bond, tension=share * law.tension, bond_moment=moment, cohesion=cohesion)


def _check(assembly: Assembly, interfaces: Interfaces, law: PointLaw) -> None:
    """Refuse what a preload cannot do: its cone has its apex where the tension ends, and no cap."""
    chosen = last_law(assembly, interfaces)
    for point in np.flatnonzero((law.floor > ROUNDING * law.shift) | np.isfinite(law.cap)):
        rule = chosen[interfaces.point_interface[point]]
        assert rule is not None
        raise InputError(f"{_label(rule)}: {_reason(rule)}")


def _label(rule: JointLaw) -> str:
    return "joint law between " + " and ".join(rule.between)


def _reason(rule: JointLaw) -> str:
    if rule.compression is not None:
        return f"compression is {rule.compression!r}; Bullet's joints do not crush, leave it out to simulate"
    return (
        f"cohesion is {rule.cohesion!r} Pa; Bullet can hold at most friction x (tension and bond) in shear, "
        "lower it or leave it out to simulate"
    )


class CohesivePreload:
    """Forces that press the blocks of each joint together until it breaks."""

    each_step = True

    def __init__(self, interfaces: Interfaces, tension: Floats) -> None:
        """Set the preload of each joint.

        Parameters
        ----------
        interfaces : Interfaces
            Joints of the assembly.
        tension : array of float, shape (n_points,)
            Preload of each contact point [N]; 0 for none.
        """
        rows = np.flatnonzero(tension > 0)
        self._interface = interfaces.point_interface[rows]
        self._pair = interfaces.pair[self._interface]
        self._point = interfaces.point[rows]
        self._normal = interfaces.frame[self._interface, 0]
        self._tension = tension[rows]
        self.broken = np.zeros(interfaces.n_interfaces, dtype=bool)  #: shape (n_interfaces,)

    def begin(self, world: World) -> None:
        """Restore all bonds, and set how far each may open or slip.

        Parameters
        ----------
        world : World
            What the action acts on.
        """
        self.broken = np.zeros_like(self.broken)
        self._reach = reach(world.assembly, self._pair)

    def act(self, world: World, time: float) -> None:
        """Press the blocks of each joint together for the next time step, and break joints that have opened or slid.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        poses = Poses(world)
        at, offset, turn = at_points(poses, self._pair, self._point)
        normal = np.einsum("nij,nj->ni", turn, self._normal)
        opening = np.einsum("ni,ni->n", offset, normal)
        slip = np.linalg.norm(offset - opening[:, None] * normal, axis=1)
        apart = (np.maximum(opening, slip) > self._reach) & (time >= 0)  # settling is no motion of the blocks
        gone = apart | removed(world, self._pair)
        self.broken[self._interface[gone]] = True
        pull = np.where(self.broken[self._interface], 0.0, self._tension)
        apply_on_pairs(world, poses, self._pair, at, -pull[:, None] * normal)


class CentreBonds:
    """Bonds with capacities in force and in moment at the centres of joints."""

    each_step = True

    def __init__(self, interfaces: Interfaces) -> None:
        """Set the joints that the bonds are in.

        Parameters
        ----------
        interfaces : Interfaces
            Joints of the assembly.
        """
        self._interfaces = interfaces
        self.broken = np.zeros(interfaces.n_interfaces, dtype=bool)  #: shape (n_interfaces,)

    def begin(self, world: World) -> None:
        """Make the springs of the bonds, as stiff as the time step allows.

        Parameters
        ----------
        world : World
            What the action acts on.
        """
        assembly, interfaces = world.assembly, self._interfaces
        rows, _ = bonded(assembly, interfaces)
        laws = [law for law in (last_law(assembly, interfaces)[k] for k in rows) if law is not None]
        self._rows = rows
        self._springs: Springs = spring_set(
            world, interfaces, rows,
            force=np.array([law.bond for law in laws]), moment=np.array([law.bond_moment or 0.0 for law in laws]),
            stiffness=np.inf, angular=np.inf, damping=1.0, breaks=True,
        )  # fmt: skip
        self.broken = np.zeros_like(self.broken)

    def act(self, world: World, time: float) -> None:
        """Apply what the bonds carry for the next time step, and note which have broken.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        self._springs.act(world, time)
        self.broken[self._rows] = self._springs.broken
