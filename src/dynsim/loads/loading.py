"""Tilting ground, supports that settle, blocks that are removed, pushes and constant loads.

Times are since release [s].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.errors import InputError, check_number, check_positive, check_vector
from blockstat.loads import numbers
from blockstat.typing import Floats
from dynsim.engine.world import World

LEVEL = 1e-3  #: an axis whose cosine with gravity is no more is level


@dataclass(frozen=True, eq=False)
class Tilt:
    """The ground tilts about a horizontal axis at a constant rate.

    Examples
    --------
    >>> from dynsim import Tilt
    >>> table = Tilt(axis=(0, 1, 0), to=10.0, rate=2.0)
    >>> table.end, table.angle(1.5)
    (5.0, 3.0)
    """

    axis: Any  #: shape (3,), of the right-handed rotation of gravity
    to: float  #: [degrees]
    rate: float = 1.0  #: [degrees/s]
    each_step = True
    travel = 0.0

    def __post_init__(self) -> None:
        check_vector("tilt: axis", self.axis)
        check_number("tilt: to", self.to)
        check_positive("tilt: to", abs(self.to))
        check_positive("tilt: rate", self.rate)

    @property
    def end(self) -> float:
        """Time at which the ground has its last tilt [s]."""
        return abs(self.to) / self.rate

    def angle(self, time: float) -> float:
        """Return the tilt of the ground.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        float
            Angle [degrees], with the sign of `to`.
        """
        return float(np.sign(self.to) * min(max(time, 0.0) * self.rate, abs(self.to)))

    def begin(self, world: World) -> None:
        """Check that the axis is level.

        Parameters
        ----------
        world : World
            What the action acts on.

        Raises
        ------
        InputError
            For any other axis: about a vertical one the ground turns and does not tilt, and about one in between it
            tilts by less than it turns.
        """
        axis, gravity = np.asarray(self.axis, dtype=float), world.assembly.gravity
        if abs(axis @ gravity) > LEVEL * np.linalg.norm(axis) * np.linalg.norm(gravity):
            raise InputError(
                f"tilt: axis is {axis.tolist()}; it must be at right angles to gravity, which is {gravity.tolist()}, "
                "so that the ground tilts by as much as it turns"
            )

    def act(self, world: World, time: float) -> None:
        """Turn gravity, which is what tilting ground does to blocks.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        from scipy.spatial.transform import Rotation

        axis = np.asarray(self.axis, dtype=float) / np.linalg.norm(self.axis)
        gravity = world.assembly.gravity
        turned = Rotation.from_rotvec(np.deg2rad(self.angle(time)) * axis).apply(np.array(gravity))
        world.drive(self, turned - gravity)


@dataclass(frozen=True, eq=False)
class Settlement:
    """Supports move along a path at a constant speed, without turning, and stay where it ends.

    What several settlements do to one support adds up.

    Examples
    --------
    >>> from dynsim import Settlement
    >>> yields = Settlement("springer.right", path=(0.1, 0, 0), speed=0.05, start=1.0)
    >>> yields.end, yields.travel
    (3.0, 0.1)
    """

    supports: Sequence[int | str] | int | str
    path: Any  #: displacements from where they were built, one after the other, shape (3,) or (k, 3) [m]
    speed: float  #: [m/s]
    start: float = 0.0  #: [s]
    each_step = True

    def __post_init__(self) -> None:
        path = np.atleast_2d(numbers(self.path))
        if path.ndim != 2 or path.shape[1] != 3 or not np.isfinite(path).all() or not path.any():
            raise InputError(f"settlement: path is {self.path!r}; it must be displacements of three numbers, not all 0")
        check_positive("settlement: speed", self.speed)
        check_number("settlement: start", self.start, least=0)

    @property
    def travel(self) -> float:
        """Largest distance of the supports from where they were built [m]."""
        return float(np.linalg.norm(self._corners, axis=1).max())

    @property
    def end(self) -> float:
        """Time at which the supports come to rest [s]."""
        return self.start + float(self._length[-1]) / self.speed

    @property
    def _corners(self) -> Floats:
        return np.vstack([np.zeros(3), np.atleast_2d(np.asarray(self.path, dtype=float))])

    @property
    def _length(self) -> Floats:
        """Of the path up to each corner [m]."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self._corners, axis=0), axis=1))])

    def displacement(self, time: float) -> Floats:
        """Return the displacement of the supports.

        Parameters
        ----------
        time : float
            Time since release [s].

        Returns
        -------
        array of float, shape (3,)
            Displacement from where they were built [m].
        """
        gone = (time - self.start) * self.speed
        return np.array([np.interp(gone, self._length, self._corners[:, k]) for k in range(3)])

    def begin(self, world: World) -> None:
        """Check that the blocks named exist and are supports.

        Parameters
        ----------
        world : World
            What the action acts on.

        Raises
        ------
        InputError
            For a block that does not exist or is no support.
        """
        chosen = world.assembly.blocks_named(self.supports, "settlement")
        loose = chosen[~world.assembly.support[chosen]]
        if len(loose):
            raise InputError(f'settlement: "{world.assembly.names[loose[0]]}" is no support; only supports are moved')

    def act(self, world: World, time: float) -> None:
        """Put the supports where they are at the end of the next time step.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        step = world.settings.time_step / world.time
        if time + step <= self.start:
            return
        here, there = self.displacement(time), self.displacement(time + step)
        for support in np.unique(world.assembly.blocks_named(self.supports, "settlement")):
            world.carry(int(support), here, (there - here) / step)


@dataclass(frozen=True, eq=False)
class Removal:
    """Blocks are taken out at a time: a centring is struck, a voussoir is lost. It happens at the next look.

    Examples
    --------
    >>> from dynsim import Removal
    >>> Removal(["arch.3", "arch.4"], time=0.5).end
    0.5
    """

    blocks: Sequence[int | str] | int | str
    time: float = 0.0  #: [s]
    each_step = False
    travel = 0.0

    def __post_init__(self) -> None:
        check_number("removal: time", self.time, least=0)

    @property
    def end(self) -> float:
        """Time at which the blocks are taken out [s]."""
        return self.time

    def begin(self, world: World) -> None:
        """Check that the blocks named exist and that others are left.

        Parameters
        ----------
        world : World
            What the action acts on.

        Raises
        ------
        InputError
            For a block that does not exist, or when no free block is left.
        """
        chosen = world.assembly.blocks_named(self.blocks, "removal")
        if not np.setdiff1d(world.assembly.free, chosen).size:
            raise InputError("removal: nothing that can move is left")

    def act(self, world: World, time: float) -> None:
        """Take the blocks out once their time has come.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        if time < self.time:
            return
        for block in world.assembly.blocks_named(self.blocks, "removal"):
            if int(block) not in world.removed:
                world.remove(int(block))


@dataclass(frozen=True, eq=False)
class Push:
    """A sudden change of a block's velocity, as a velocity or an impulse, at the look nearest to its time.

    Examples
    --------
    >>> from dynsim import Push
    >>> Push("arch.3", velocity=(0.5, 0, 0), impulse=(10, 0, 0))
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: push: a velocity or an impulse is needed, one of the two
    """

    block: int | str
    velocity: Any = None  #: shape (3,) [m/s]
    impulse: Any = None  #: shape (3,) [N s]
    point: Any = None  #: of the impulse, as built, shape (3,) [m]; None for the centroid
    time: float = 0.0  #: [s]
    each_step = False
    travel = 0.0

    def __post_init__(self) -> None:
        if (self.velocity is None) == (self.impulse is None):
            raise InputError("push: a velocity or an impulse is needed, one of the two")
        if self.point is not None and self.impulse is None:
            raise InputError("push: a point goes with an impulse; a velocity is the whole block's")
        for name in ("velocity", "impulse"):
            if getattr(self, name) is not None:
                check_vector(f"push: {name}", getattr(self, name))
        if self.point is not None:
            check_vector("push: point", self.point, zero=True)
        check_number("push: time", self.time, least=0)

    @property
    def end(self) -> float:
        """Time of the push [s]."""
        return self.time

    def begin(self, world: World) -> None:
        """Check that the block named exists and is free.

        Parameters
        ----------
        world : World
            What the action acts on.

        Raises
        ------
        InputError
            For a block that does not exist or is a support.
        """
        block, *others = world.assembly.blocks_named(self.block, "push")
        if others:
            raise InputError(f"push: block is {self.block!r}; it must be one block; each needs its own push")
        if world.assembly.support[block]:
            raise InputError(f'push: "{world.assembly.names[block]}" is a support, which cannot move')

    def act(self, world: World, time: float) -> None:
        """Change the velocity of the block at the look nearest to its time.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        look = world.settings.substeps * world.settings.time_step / world.time
        if np.floor((time - self.time) / look + 0.5) != 0:
            return
        assembly, block = world.assembly, int(world.assembly.blocks_named(self.block, "push")[0])
        linear, angular = (values[block] for values in world.velocities())
        if self.velocity is not None:
            world.set_velocity(block, linear + self.velocity, angular)
            return
        rotation = world.poses()[1][block]
        centre = assembly.centroid[block]
        arm = rotation @ (np.asarray(self.point if self.point is not None else centre, dtype=float) - centre)
        impulse = np.asarray(self.impulse, dtype=float)
        inertia = world.inertia_scale * rotation @ assembly.inertia[block] @ rotation.T
        spin = np.linalg.solve(inertia, np.cross(arm, impulse))
        world.set_velocity(block, linear + impulse / assembly.mass[block], angular + spin)


@dataclass(frozen=True, eq=False)
class Constant:
    """A load that acts from the first step of settling on, as that of a static limit load.

    Parameters
    ----------
    load : array of shape (3,) or (n_blocks, 6)
        A body acceleration [m/s2], or a wrench on each block about its centroid [N, N m]. Wrenches keep their direction
        and go with the block's centroid.

    Examples
    --------
    >>> import numpy as np
    >>> from dynsim import Constant
    >>> Constant((1.0, 0, 0)).each_step, Constant(np.zeros((2, 6))).each_step
    (False, True)
    """

    load: Any
    travel = 0.0
    end = float("-inf")

    def __post_init__(self) -> None:
        try:
            load = np.asarray(self.load, dtype=float)
        except (TypeError, ValueError):
            load = np.full(3, np.nan)  # refused below
        if not ((load.shape == (3,) or load.shape[1:] == (6,)) and np.isfinite(load).all()):
            raise InputError(
                f"constant: load is {self.load!r}; it must be an acceleration of three finite numbers, or six finite "
                "numbers a block"
            )

    @property
    def each_step(self) -> bool:
        """Whether it acts at each time step: wrenches do, an acceleration is set once."""
        return np.shape(self.load) != (3,)

    def size(self, assembly: Assembly) -> float:
        """Return how large the load is, to be compared with the weight.

        Parameters
        ----------
        assembly : Assembly
            What it acts on.

        Returns
        -------
        float
            Sum of its forces on the free blocks and of its moments over their sizes [N].

        Raises
        ------
        InputError
            As `begin` does.
        """
        free, load = assembly.free, self._checked(assembly)
        if not self.each_step:
            return float(assembly.mass[free].sum() * np.linalg.norm(load))
        arms = np.linalg.norm(load[free, 3:], axis=1) / assembly.size[free]
        return float((np.linalg.norm(load[free, :3], axis=1) + arms).sum())

    def begin(self, world: World) -> None:
        """Set an acceleration, which stays.

        Parameters
        ----------
        world : World
            What the action acts on.

        Raises
        ------
        InputError
            For wrenches on another number of blocks.
        """
        load = self._checked(world.assembly)
        if not self.each_step:
            world.drive(self, load)

    def _checked(self, assembly: Assembly) -> Floats:
        """The load as numbers that fit an assembly."""
        load = np.asarray(self.load, dtype=float)
        if load.shape not in ((3,), (assembly.n_blocks, 6)):
            raise InputError(f"constant: load has shape {load.shape}; it must be (3,) or ({assembly.n_blocks}, 6)")
        return load

    def wrenches(self, assembly: Assembly) -> Floats:
        """Return the load as static analyses take it.

        Parameters
        ----------
        assembly : Assembly
            What it acts on.

        Returns
        -------
        array of float, shape (n_blocks, 6)
            Wrenches on the free blocks about their centroids, those of an acceleration among them [N, N m].

        Raises
        ------
        InputError
            As `begin` does.
        """
        load = self._checked(assembly)
        if not self.each_step:
            load = np.pad(np.outer(assembly.mass, load), ((0, 0), (0, 3)))
        return np.where(assembly.support[:, None], 0.0, load)

    def act(self, world: World, time: float) -> None:
        """Apply wrenches for the next time step.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        if self.each_step:
            wrench = self.wrenches(world.assembly)
            world.load(wrench[:, :3], wrench[:, 3:])
