"""The protocol of a run: settle under full damping, then release and record."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil
from time import process_time

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces
from blockstat.errors import check_number, known_options
from blockstat.loads import up_of
from blockstat.typing import Floats, Ints
from dynsim.bonds.glue import bonds_of
from dynsim.checks import check_engine
from dynsim.engine.guards import check_can_simulate
from dynsim.engine.lmgc90 import Lmgc90World
from dynsim.engine.world import Action, World
from dynsim.judge.closing import closed_scene
from dynsim.judge.cracks import find_cracks
from dynsim.loads.load import Loads, as_actions, as_loads
from dynsim.settings import Settings

#: Taller scenes need longer to show a fall: times grow as sqrt(height) above this height at simulation scale.
TALL = 2.0
#: The last part of settling has the time step of the free run, so that nothing changes when blocks are let go.
OWN_STEP = 0.2
#: Contact points whose normals differ by less are on one plane [rad]. Those of joints of small buildings differ by up
#: to a quarter of that.
PARALLEL = 5e-3
#: A point presses where its normal force is more than this share of the largest one: less is rounding.
PRESSED = 1e-9


@dataclass(frozen=True)
class PlaneForce:
    """The resultant of the contact forces of two blocks on one plane."""

    pair: tuple[int, int]
    pressure: float  #: [N]
    friction: float  #: length of the component in the plane [N]
    at_points: float  #: sum of the lengths of the components of the points in the plane [N]; more where they turn
    spread: float  #: largest angle between a normal of the points and that of the plane [rad]


@dataclass(frozen=True, eq=False)
class Contacts:
    """Forces at the contact points in the last time step."""

    pairs: Ints  #: the two blocks of each point, shape (k, 2)
    point: Floats  #: shape (k, 3) [m]
    force: Floats  #: on the second block, shape (k, 3) [N]
    normal: Floats | None = None  #: unit normals out of the second block, shape (k, 3); None where none were kept

    def on(self, block: int) -> Floats:
        """Return the sum of the contact forces on a block.

        Parameters
        ----------
        block : int
            Number of the block.

        Returns
        -------
        array of float, shape (3,)
            Force [N].
        """
        second, first = (self.pairs[:, k] == block for k in (1, 0))
        return self.force[second].sum(axis=0) - self.force[first].sum(axis=0)

    def between(self) -> dict[tuple[int, int], Floats]:
        """Return the contact force between every two blocks that touch.

        Returns
        -------
        dict of (int, int) to array of float, shape (3,)
            Force on the block with the larger number [N], by pair, the smaller number first.
        """
        ordered = np.sort(self.pairs, axis=1)
        force = np.where((ordered == self.pairs).all(axis=1)[:, None], self.force, -self.force)
        pairs, group = np.unique(ordered, axis=0, return_inverse=True)
        total = np.zeros((len(pairs), 3))
        np.add.at(total, group.reshape(-1), force)
        return {(int(a), int(b)): value for (a, b), value in zip(pairs, total, strict=True)}

    def planes(self) -> list[PlaneForce]:
        """Return the resultant on each plane in which two blocks press on each other.

        Returns
        -------
        list of PlaneForce
            None where no normals were kept.

        Notes
        -----
        A sum of forces in one cone is in that cone. So the resultant on a plane is within the friction cone where the
        force at each point is, and so is the sum of the lengths. Points without pressure are left out: Bullet does not
        bound their friction.
        """
        if self.normal is None or not len(self.pairs):
            return []
        ordered = np.sort(self.pairs, axis=1)
        sign = np.where((ordered == self.pairs).all(axis=1), 1.0, -1.0)[:, None]
        force, normal = sign * self.force, sign * self.normal
        pressure = -np.einsum("ni,ni->n", force, normal)
        if not (kept := pressure > PRESSED * np.abs(pressure).max()).any():
            return []
        ordered, force, normal, pressure = ordered[kept], force[kept], normal[kept], pressure[kept]
        plane, first, spread = _planes_of(ordered, normal)
        count = len(first)
        across = force + pressure[:, None] * normal
        total = np.stack([np.bincount(plane, part, count) for part in across.T], axis=1)
        friction = np.linalg.norm(total, axis=1)
        at_points = np.bincount(plane, np.linalg.norm(across, axis=1), count)
        values = np.stack([np.bincount(plane, pressure, count), friction, at_points, spread], axis=1)
        return [
            PlaneForce((a, b), *value) for (a, b), value in zip(ordered[first].tolist(), values.tolist(), strict=True)
        ]


def _planes_of(pair: Ints, normal: Floats) -> tuple[Ints, Ints, Floats]:
    """Planes of points: that of each, the first point of each plane, and the largest angle to the normal of that."""
    _, pair_of = np.unique(pair @ [pair.max(initial=0) + 1, 1], return_inverse=True)
    plane, firsts, count = np.zeros(len(pair), dtype=int), [], 0
    off, left = np.zeros(len(pair)), np.arange(len(pair))
    while len(left):  # at once one plane of each pair that has points left
        _, index, which = np.unique(pair_of[left], return_index=True, return_inverse=True)
        first = left[index]
        off[left] = np.linalg.norm(normal[left] - normal[first][which], axis=1)
        alike = off[left] < PARALLEL
        plane[left[alike]] = count + which[alike]
        firsts.append(first)
        count += len(first)
        left = left[~alike]
    spread = np.zeros(count)
    np.maximum.at(spread, plane, off)
    return plane, np.concatenate(firsts), spread


@dataclass(frozen=True, eq=False)
class Run:
    """A trajectory. Frame 0 is the settled state; displacements are from where the blocks were built."""

    assembly: Assembly
    times: Floats  #: shape (n_frames,) [s] since release, in the scene's own time
    displacement: Floats  #: shape (n_frames, n_blocks, 3) [m], of the centroids
    rotation: Floats  #: shape (n_frames, n_blocks, 3, 3), from the orientation as built
    initial_overlap: float  #: [m], deepest penetration between shapes before the first step
    process_seconds: float
    kinetic: Floats  #: kinetic energy of the free blocks, shape (n_frames,) [J]
    removed: Floats  #: time at which each block was taken out, shape (n_blocks,) [s]; inf for never
    contacts: Contacts  #: forces between blocks at the end
    time_step: float  #: [s] at simulation scale
    pace: float  #: seconds of `Settings` a second of the scene: they are for blocks of 0.3 m and 2 m of height
    engine: str = "bullet"  #: what simulated it
    #: time at which each block was put in, shape (n_blocks,) [s]; -inf before the start; None: all were
    placed: Floats | None = None
    filled: tuple[str, ...] = ()  #: blocks whose shapes fill recesses deeper than statics bridge in a joint

    @property
    def warnings(self) -> list[str]:
        """What a verdict must say about the shapes."""
        if not self.filled:
            return []
        first, *rest = self.filled
        others = f" and {len(rest)} more" if rest else ""
        return [
            f'no good cut into convex pieces was found of "{first}"{others}: pieces fill recesses deeper than a joint '
            "may be open, and what stands there may only stand on the filling"
        ]

    @property
    def since_release(self) -> Floats:
        """Displacement of the centroids since the settled state, shape (n_frames, n_blocks, 3) [m]."""
        return self.displacement - self.displacement[0]

    def came_apart(self, joints: Interfaces) -> bool:
        """Return whether one of some joints opened or slid after release, for good or for a while.

        Parameters
        ----------
        joints : Interfaces
            The joints that count. Those of blocks that were taken out do not.

        Returns
        -------
        bool
            Whether one did by half of what breaks a bond: a turn that breaks it opens the corners by no more.
        """
        poses = list(zip(self.displacement, self.rotation, strict=True))
        gone = np.flatnonzero(np.isfinite(self.removed))
        for pose in poses:
            found = find_cracks(self.assembly, poses[0], pose, interfaces=joints, removed=gone)
            if (np.maximum(found.opening, found.slip) > found.threshold / 2).any():
                return True
        return False

    @property
    def potential(self) -> Floats:
        """Potential energy of the free blocks above what it was as built, shape (n_frames,) [J]."""
        free, gravity = self.assembly.free, self.assembly.gravity
        return -np.einsum("tni,n,i->t", self.displacement[:, free], self.assembly.mass[free], gravity)


@known_options
def simulate(
    assembly: Assembly,
    *,
    settings: Settings | None = None,
    stop: Callable[[float, Floats, Floats], bool] | None = None,
    loads: Loads = (),
    actions: Sequence[Action] = (),
    hold: float = 0.0,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
    engine: str = "bullet",
    progress: Callable[[float, float, float], None] | None = None,
) -> Run:
    """Settle an assembly under full damping, release it, and return its motion.

    Parameters
    ----------
    assembly : Assembly
        Blocks, supports and joint laws. The bonds of the joint laws are simulated too.
    settings : Settings, optional
        Time steps and durations; the default settings when None.
    stop : callable, optional
        Called at every look with three values: the part of `Settings.longest` that has passed since release and `hold`
        [s] (negative until then), and the displacements [m] and rotation vectors [rad] since release, both of shape
        (n_blocks, 3). True ends the run.
    loads : Load, array of shape (n_blocks, 6), or a sequence of them
        What acts besides the weight, as in `verify`.
    actions : sequence of Action
        What else acts on the blocks.
    hold : float
        The free run is longer by this time [s].
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`; not used where `interfaces` are given.
    interfaces : Interfaces, optional
        Joints of the assembly; searched for when None. Those that statics count as closed are closed here, too.
    engine : str
        "bullet", or "lmgc90" for weight alone; see `verify`.
    progress : callable, optional
        Called at every look after release with the time that has been simulated, the time at which `hold` is over, and
        the time at which the run ends at the latest [s].

    Returns
    -------
    Run
        The trajectory of all blocks.

    Raises
    ------
    InputError
        As `verify` does, for a scene, a load or a joint law that cannot be simulated. Also for an option that does not
        exist.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> from dynsim import simulate
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> run = simulate(pillar)
    >>> run.displacement.shape[1:], bool(abs(run.since_release).max() < 1e-3)
    ((2, 3), True)
    """
    settings = Settings.of(settings)
    check_number("hold", hold, least=0)
    check_engine(engine)
    check_can_simulate(assembly)
    start = process_time()
    times, displacement, rotation, kinetic = [], [], [], []
    removed = np.full(assembly.n_blocks, np.inf)
    scene = closed_scene(assembly, find_interfaces(assembly, gap=gap) if interfaces is None else interfaces)
    assembly, interfaces = scene.assembly, scene.interfaces
    acting = (*bonds_of(assembly, interfaces=interfaces), *as_loads(assembly, loads), *as_actions(actions))
    with _world(engine, assembly, settings, acting, interfaces) as world:
        settings = world.settings
        overlap = world.deepest_overlap()
        stretch = np.sqrt(max(height_of(assembly) * world.length / TALL, 1.0))
        look = settings.substeps * settings.time_step
        settling = round(settings.settle * stretch / look) if world.settles else 0
        coarse = min(round(settling * (1 - OWN_STEP)), settling - 1) if settings.settle_step else 0
        if settling:
            world.damp(1.0)
            world.set_time_step(settings.settle_step or settings.time_step)
        for frame in range(settling):
            if frame == coarse:
                world.set_time_step(settings.time_step)
            world.advance((frame - settling) * look / world.time)
        if settling:
            world.damp(0.0)
        looks = round(settings.longest * stretch / look)
        held = ceil(hold * world.time / look - 1e-9)
        for frame in range(held + looks + 1):
            if frame:
                world.advance((frame - 1) * look / world.time)
            moved, turned = world.poses()
            times.append(frame * look / world.time)
            displacement.append(moved)
            rotation.append(turned)
            kinetic.append(_kinetic(assembly, *world.velocities(), turned, world.inertia_scale))
            new = [block for block in world.removed if np.isinf(removed[block])]
            removed[new] = times[-1] - look / world.time
            if progress is not None:
                progress(times[-1], held * look / world.time, (held + looks) * look / world.time)
            if stop is not None:
                since = (moved - displacement[0], rotation_vectors(rotation[0], turned))
                if stop(settings.longest * (frame - held) / looks, *since):
                    break
        contacts = Contacts(*world.contact_forces())
        spent = process_time() - start + world.process_seconds
    return Run(
        assembly, np.array(times), np.array(displacement), np.array(rotation), overlap, spent,
        np.array(kinetic), removed, contacts, settings.time_step, float(world.time / stretch),
        engine, filled=world.filled,
    )  # fmt: skip


def _world(
    engine: str, assembly: Assembly, settings: Settings, acting: Sequence[Action], interfaces: Interfaces
) -> World | Lmgc90World:
    """The engine with the blocks in it."""
    if engine == "bullet":
        return World(assembly, settings, acting, interfaces=interfaces)
    return Lmgc90World(assembly, replace(settings, time_step=settings.quick_step), acting, interfaces=interfaces)


def rotation_vectors(start: Floats, end: Floats) -> Floats:
    """Return the rotations from one set of orientations to another.

    Parameters
    ----------
    start, end : array of float, shape (n_blocks, 3, 3)
        Rotation matrices.

    Returns
    -------
    array of float, shape (n_blocks, 3)
        Rotation vectors [rad].
    """
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(end @ start.transpose(0, 2, 1)).as_rotvec()


def _kinetic(assembly: Assembly, velocity: Floats, spin: Floats, rotation: Floats, scale: float) -> float:
    """Kinetic energy of the free blocks, their inertia scaled [J]."""
    free = assembly.free
    local = np.einsum("nji,nj->ni", rotation[free], spin[free])  # in the axes of the block as built
    turning = scale * np.einsum("ni,nij,nj->", local, assembly.inertia[free], local)
    return float((assembly.mass[free] @ (velocity[free] ** 2).sum(axis=1) + turning) / 2)


def height_of(assembly: Assembly) -> float:
    """Return the extent of the free blocks along gravity.

    Parameters
    ----------
    assembly : Assembly
        The blocks as built, at least one of them free.

    Returns
    -------
    float
        From the lowest corner to the highest [m].
    """
    free = np.repeat(~assembly.support, np.diff(assembly.vertex_start))
    along = assembly.vertices[free] @ up_of(assembly)
    return float(np.ptp(along))
