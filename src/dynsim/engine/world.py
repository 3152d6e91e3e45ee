"""One Bullet client with the blocks of an assembly in it, and what may act on them.

The scene is simulated at a fixed scale: lengths so that the median block measures 0.3 m, gravity 9.81 m/s2,
masses so that the median block weighs 100 kg. Rigid-block dynamics under Coulomb friction is scale-free with
time going as sqrt(length / gravity), so units change nothing, and Bullet sees what it was tuned for.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces, find_interfaces
from blockstat.errors import InputError
from blockstat.loads import up_of
from blockstat.typing import Floats, Ints
from dynsim.engine.bodies import Shape, filled_blocks, hull_obj, likeness, shapes
from dynsim.engine.bullet import ENGINE, contact_points, import_bullet, matrices, quaternion
from dynsim.engine.friction import block_friction, common_friction, has_own_friction
from dynsim.engine.guards import (
    check_blocks,
    check_can_simulate,
    check_overlap,
    check_places,
    check_rotations,
    iterations_for,
    may_have_uneven_masses,
)
from dynsim.engine.step_loads import StepLoads
from dynsim.settings import Settings

BLOCK_SIZE = 0.3  #: [m] median block size in the simulation
BLOCK_MASS = 100.0  #: [kg] median block mass in the simulation
CARRIER_MASS = 1e10  #: [kg] of a support that is moved: nothing in the scene can push it
GRAVITY = 9.81  #: [m/s2] in the simulation
ALIKE = 1e-9  #: corners this close, as a share of the block size, are the same: rounding of coordinates
MOVABLE = (1, -1)  #: Bullet's collision group of what moves, and the mask of all that it touches
ANCHOR = 1  #: a contact point that does not slide is held where it was


class Action(Protocol):
    """Something that acts on the blocks while they are simulated: a load, a bond, a spring.

    Everything it does goes through the methods of `World`, in the scene's own units. An action that must act at every
    time step makes the run step from Python, a little more slowly.
    """

    @property
    def each_step(self) -> bool:
        """True: `act` comes before every time step; False: before every look."""
        ...

    def begin(self, world: World) -> None:
        """Prepare for a run; called once, before settling.

        Parameters
        ----------
        world : World
            What the action acts on.
        """
        ...

    def act(self, world: World, time: float) -> None:
        """Act on the blocks; called through settling and the free run.

        Parameters
        ----------
        world : World
            What the action acts on.
        time : float
            Time since release [s], negative while settling.
        """
        ...


class World:
    """Blocks of an assembly in one Bullet client; a context manager.

    Poses, forces and velocities go in and out in the scene's own units. The engine knows no bonds: whoever runs it
    hands in those of the joint laws (`dynsim.bonds_of`) among the actions.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> from dynsim import Settings, World
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="block")]
    >>> with World(Assembly.from_blocks(blocks, supports=["ground"]), Settings()) as world:
    ...     world.advance(0.0)
    ...     moved, turned = world.poses()
    >>> moved.shape, turned.shape, bool(abs(moved).max() < 1e-3)
    ((2, 3), (2, 3, 3), True)
    """

    settles = True  #: blocks sink and shake a little when they are put in place
    process_seconds = 0.0  #: process time of other processes [s]
    inertia_scale = 1.0  #: factor on the moments of inertia as built; `scale_inertia` changes it

    def __init__(
        self,
        assembly: Assembly,
        settings: Settings,
        actions: Sequence[Action] = (),
        *,
        interfaces: Interfaces | None = None,
    ) -> None:
        """Check the assembly and prepare its shapes; Bullet starts when the context is entered.

        Parameters
        ----------
        assembly : Assembly
            Blocks, supports, friction and gravity.
        settings : Settings
            Time step and iterations of the contact solver.
        actions : sequence of Action
            What acts on the blocks, the bonds of the joint laws among it.
        interfaces : Interfaces, optional
            Joints of the assembly; searched for when they are first needed.

        Raises
        ------
        InputError
            For a scene that Bullet cannot simulate rightly.
        """
        check_can_simulate(assembly)
        free = ~assembly.support
        self.assembly, self.settings = assembly, settings
        if interfaces is not None:
            self.interfaces = interfaces
        if may_have_uneven_masses(assembly, settings.iterations):
            needed = iterations_for(assembly, self.interfaces)
            self.settings = replace(settings, iterations=max(settings.iterations, needed))
        self.length = BLOCK_SIZE / float(np.median(assembly.size[free]))  #: simulation metres a scene metre
        strength = float(np.linalg.norm(assembly.gravity))
        self.time = float(np.sqrt(self.length * strength / GRAVITY))  #: simulation seconds a scene second
        self._mass = BLOCK_MASS / float(np.median(assembly.mass[free]))
        self._acceleration = GRAVITY / strength
        self.time_step = settings.time_step / self.time  #: [s]; `set_time_step` changes it
        self.actions = tuple(actions)
        self._stepwise = any(action.each_step for action in self.actions)
        self._shapes = shapes(assembly)
        self.filled = filled_blocks(assembly, self._shapes)  #: blocks whose shapes fill recesses of theirs
        check_rotations(assembly, np.stack([shape.rotation for shape in self._shapes]))
        own = has_own_friction(assembly, interfaces)
        self._friction = block_friction(assembly, self.interfaces) if own else common_friction(assembly)
        self._directory: tempfile.TemporaryDirectory[str] | None = None
        self._client = -1
        self._loads = StepLoads(assembly) if self._stepwise else None
        self._damping = 0.0
        self._bodies: list[int] = []
        self._made: dict[bytes, int] = {}
        self._driven: dict[Action, Floats] = {}
        self._gravity = np.asarray(assembly.gravity, dtype=float)
        self._ways: dict[int, Floats] = {}  # displacement and velocity of the supports that move in a time step
        self._carried: set[int] = set()
        self.removed: set[int] = set()  #: blocks taken out by `remove`
        self._held: set[int] = set()

    @cached_property
    def interfaces(self) -> Interfaces:
        """The joints of the assembly as built; searched for when they are first asked for."""
        return find_interfaces(self.assembly)

    def __enter__(self) -> World:
        self._directory = tempfile.TemporaryDirectory(prefix="dynsim-")
        self._bullet = import_bullet()
        self._client = self._bullet.connect(self._bullet.DIRECT)
        try:
            self._set_up()
            for action in self.actions:
                action.begin(self)
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bullet.disconnect(self._client)
        if self._directory:
            self._directory.cleanup()

    def _set_up(self) -> None:
        b = self._bullet
        b.setPhysicsEngineParameter(
            numSolverIterations=self.settings.iterations, physicsClientId=self._client, **ENGINE
        )
        self.set_time_step(self.settings.time_step)
        self.set_gravity(self.assembly.gravity)
        # Boxes and hulls never mix: Bullet keeps a margin on one kind and not on the other, and boxes with the faces of
        # hulls keep contact points that have slid, which hold them (docs/dynamics.md).
        as_boxes = all(shape.half_extents is not None for shape in self._shapes)
        for block, shape in enumerate(self._shapes):
            self._bodies.append(self._add(block, shape, as_boxes))

    def _shape(self, shape: Shape, as_box: bool) -> int:
        """Make the collision shape of a block; negative where Bullet refuses it."""
        b = self._bullet
        if as_box:
            assert shape.half_extents is not None
            half = (shape.half_extents * self.length).tolist()
            return b.createCollisionShape(b.GEOM_BOX, halfExtents=half, physicsClientId=self._client)
        assert self._directory is not None
        path = Path(self._directory.name) / "block.obj"  # read at once and not kept
        path.write_text(hull_obj([piece * self.length for piece in shape.pieces]))
        return b.createCollisionShape(
            b.GEOM_MESH, fileName=str(path), flags=b.URDF_INITIALIZE_SAT_FEATURES, physicsClientId=self._client
        )

    def _add(self, block: int, shape: Shape, as_box: bool) -> int:
        b, assembly = self._bullet, self.assembly
        mass = 0.0 if assembly.support[block] else float(assembly.mass[block] * self._mass)
        alike = likeness(shape, ALIKE * BLOCK_SIZE / self.length)
        if alike not in self._made:
            self._made[alike] = self._shape(shape, as_box)
        collision = self._made[alike]
        body = -1 if collision < 0 else b.createMultiBody(
            baseMass=mass, baseCollisionShapeIndex=collision, useMaximalCoordinates=1, physicsClientId=self._client,
            basePosition=(assembly.centroid[block] * self.length).tolist(),
            baseOrientation=quaternion(shape.rotation).tolist(),
        )  # fmt: skip
        if body < 0:
            raise InputError(f'Bullet refused block "{assembly.names[block]}"; draw it with fewer or larger faces')
        options: dict[str, Any] = {
            "lateralFriction": float(self._friction[block]), "spinningFriction": 0.0, "rollingFriction": 0.0,
            "restitution": 0.0, "linearDamping": 0.0, "angularDamping": 0.0, "frictionAnchor": ANCHOR,
            "activationState": b.ACTIVATION_STATE_DISABLE_SLEEPING,
        }  # fmt: skip
        if mass > 0:
            options["mass"] = mass
            options["localInertiaDiagonal"] = (shape.inertia * self._mass * self.length**2).tolist()
        b.changeDynamics(body, -1, physicsClientId=self._client, **options)
        return body

    def set_time_step(self, step: float) -> None:
        """Set the time step from now on; the time between looks stays.

        Parameters
        ----------
        step : float
            Time step at simulation scale [s].
        """
        self.settings = s = replace(self.settings, time_step=step)
        self.time_step = step / self.time
        self._bullet.setPhysicsEngineParameter(
            fixedTimeStep=step if self._stepwise else s.substeps * step,
            numSubSteps=0 if self._stepwise else s.substeps, physicsClientId=self._client,
        )  # fmt: skip

    def damp(self, value: float) -> None:
        """Set the linear and angular damping of all blocks.

        Parameters
        ----------
        value : float
            Share of the velocity that a second at simulation scale takes away; 1 takes all of it away at every step.
        """
        self._damping = value
        own = 0.0 if self._stepwise else value  # Bullet's would take what acts in a step, too
        for body in self._bodies:
            self._bullet.changeDynamics(body, -1, linearDamping=own, angularDamping=own, physicsClientId=self._client)

    def advance(self, time: float = 0.0) -> None:
        """Go forward by one look, which is `Settings.look_every` at simulation scale.

        Parameters
        ----------
        time : float
            Time since release at the start of the look [s].
        """
        for step in range(self.settings.substeps if self._stepwise else 1):
            for action in self.actions:
                if step == 0 or action.each_step:
                    action.act(self, time + step * self.time_step)
            self._apply_step_loads()
            self._bullet.stepSimulation(physicsClientId=self._client)

    def _apply_step_loads(self) -> None:
        """Give the blocks what acts on them for one time step, as velocities, and put moving supports in place."""
        for support, (displacement, velocity) in self._ways.items():
            self._put(support, displacement, velocity)
        self._ways.clear()
        if self._loads is None or (self._loads.idle and self._damping == 0):
            return
        left = (1.0 - self._damping) ** self.settings.time_step
        now = self.poses()[1], *self.velocities()
        linear, angular = self._loads.take(*now, self.time_step, left=left, inertia_scale=self.inertia_scale)
        blocks = self.assembly.free
        if self.removed or self._held:
            blocks = np.setdiff1d(blocks, list(self.removed | self._held))
        self.set_velocities(blocks, linear[blocks], angular[blocks])

    def set_gravity(self, gravity: Sequence[float] | Floats) -> None:
        """Set gravity from now on.

        Parameters
        ----------
        gravity : array of float, shape (3,)
            Gravity [m/s2].
        """
        self._gravity = np.asarray(gravity, dtype=float)
        self._bullet.setGravity(*(np.asarray(gravity) * self._acceleration), physicsClientId=self._client)

    def push(self, blocks: Sequence[int] | Ints, forces: Floats, points: Floats) -> None:
        """Apply forces on some blocks until the end of Bullet's next call.

        That is one time step where some action acts at each of them, and one look elsewhere.

        Parameters
        ----------
        blocks : sequence of int, length k
            Numbers of the blocks.
        forces : array of float, shape (k, 3)
            Forces [N].
        points : array of float, shape (k, 3)
            Where they act [m].

        Raises
        ------
        InputError
            For a block that does not exist and for values that are not finite.
        """
        check_blocks(self.assembly, np.asarray(blocks))
        if not (np.isfinite(forces).all() and np.isfinite(points).all()):
            raise InputError("a force or its point is not a number")
        scaled = (np.asarray(forces, dtype=float) * self._mass * self._acceleration).tolist()
        where = (np.asarray(points, dtype=float) * self.length).tolist()
        for block, force, point in zip(blocks, scaled, where, strict=True):
            self._bullet.applyExternalForce(
                self._bodies[block], -1, force, point, self._bullet.WORLD_FRAME, physicsClientId=self._client
            )

    def load(self, forces: Floats, couples: Floats) -> None:
        """Apply forces at the centroids and couples for the next time step.

        Only actions that act at each step may call it. For couples this is the way; see `dynsim.engine.step_loads`.

        Parameters
        ----------
        forces, couples : array of float, shape (n_blocks, 3)
            Forces [N] and couples [N m].
        """
        assert self._loads is not None
        self._loads.add(forces, couples)

    def scale_inertia(self, scale: float) -> None:
        """Scale the moments of inertia of all blocks from now on; the masses stay.

        Parameters
        ----------
        scale : float
            Factor on the inertia as built.
        """
        self.inertia_scale = scale
        for block in self.assembly.free:
            self._weigh(block)

    def _weigh(self, block: int) -> None:
        """Give a block its mass and its moments of inertia."""
        moments = self.inertia_scale * self._shapes[block].inertia * self._mass * self.length**2
        self._bullet.changeDynamics(
            self._bodies[block], -1, mass=self.assembly.mass[block] * self._mass,
            localInertiaDiagonal=moments.tolist(), physicsClientId=self._client,
        )  # fmt: skip

    def lay_floor(self, below: float) -> None:
        """Lay a level floor, so that what falls past the supports lies somewhere.

        Parameters
        ----------
        below : float
            How far it is below the lowest point of the blocks as built [m].
        """
        b, down = self._bullet, -up_of(self.assembly)
        level = float((self.assembly.vertices @ down).max()) + below
        plane = b.createCollisionShape(b.GEOM_PLANE, planeNormal=(-down).tolist(), physicsClientId=self._client)
        at = (level * self.length * down).tolist()
        floor = b.createMultiBody(0.0, plane, basePosition=at, physicsClientId=self._client)
        b.changeDynamics(floor, -1, lateralFriction=max(self._friction), restitution=0.0, physicsClientId=self._client)

    def poses(self) -> tuple[Floats, Floats]:
        """Return where the blocks are.

        Returns
        -------
        displacement : array of float, shape (n_blocks, 3)
            Of each centroid from where it was built [m].
        rotation : array of float, shape (n_blocks, 3, 3)
            Rotation since built.

        Raises
        ------
        InputError
            When Bullet lost a block: its position is not a number.
        """
        answers = [
            self._bullet.getBasePositionAndOrientation(body, physicsClientId=self._client) for body in self._bodies
        ]
        position = np.array([answer[0] for answer in answers]) / self.length
        orientation = np.array([answer[1] for answer in answers])
        check_places(self.assembly, position, orientation)
        initial = np.stack([shape.rotation for shape in self._shapes])
        rotation = matrices(orientation) @ initial.swapaxes(1, 2)
        return position - self.assembly.centroid, rotation

    def deepest_overlap(self) -> float:
        """Return the deepest penetration between two blocks as they stand.

        Returns
        -------
        float
            Depth [m]; 0 for none.

        Raises
        ------
        InputError
            Naming two blocks that overlap, or whose pieces do, so far that Bullet would throw them apart.
        """
        b = self._bullet
        b.performCollisionDetection(physicsClientId=self._client)
        contacts = b.getContactPoints(physicsClientId=self._client) or ()
        deepest = min(contacts, key=lambda contact: contact[8], default=None)
        if deepest is None or deepest[8] >= 0:
            return 0.0
        depth = -deepest[8] / self.length
        pair = self._bodies.index(deepest[1]), self._bodies.index(deepest[2])
        check_overlap(self.assembly, pair, depth, self.filled)
        return depth

    def drive(self, source: Action, acceleration: Floats) -> None:
        """Accelerate every block by a body force on top of gravity.

        Parameters
        ----------
        source : Action
            Who drives; what different sources give adds up.
        acceleration : array of float, shape (3,)
            Acceleration from now on [m/s2].
        """
        self._driven[source] = np.asarray(acceleration, dtype=float)
        self.set_gravity(np.sum([self.assembly.gravity, *self._driven.values()], axis=0))

    def velocities(self) -> tuple[Floats, Floats]:
        """Return the velocities of the blocks.

        Returns
        -------
        linear : array of float, shape (n_blocks, 3)
            Velocity of each centroid [m/s].
        angular : array of float, shape (n_blocks, 3)
            Angular velocity [1/s].
        """
        answers = [self._bullet.getBaseVelocity(body, physicsClientId=self._client) for body in self._bodies]
        linear, angular = np.array(answers).swapaxes(0, 1)
        return linear * (self.time / self.length), angular * self.time

    def set_velocity(self, block: int, linear: Floats, angular: Floats) -> None:
        """Set the velocity of a free block.

        Parameters
        ----------
        block : int
            Number of the block.
        linear, angular : array of float, shape (3,)
            Velocity of the centroid [m/s] and angular velocity [1/s].
        """
        self.set_velocities([block], np.atleast_2d(linear), np.atleast_2d(angular))

    def set_velocities(self, blocks: Sequence[int] | Ints, linear: Floats, angular: Floats) -> None:
        """Set the velocities of free blocks.

        Parameters
        ----------
        blocks : sequence of int, length k
            Numbers of the blocks.
        linear, angular : array of float, shape (k, 3)
            Velocities of the centroids [m/s] and angular velocities [1/s].
        """
        one, two = (linear * (self.length / self.time)).tolist(), (angular / self.time).tolist()
        for block, v, w in zip(blocks, one, two, strict=True):
            self._bullet.resetBaseVelocity(self._bodies[block], v, w, physicsClientId=self._client)

    def carry(self, support: int, displacement: Floats, velocity: Floats) -> None:
        """Move a support for the next time step.

        Only actions that act at each step may call it. What several actions give adds up.

        Parameters
        ----------
        support : int
            Number of the block.
        displacement : array of float, shape (3,)
            Displacement from where it was built [m].
        velocity : array of float, shape (3,)
            Velocity [m/s].

        Notes
        -----
        Bullet takes any static body to be at rest, so a static support would slip under what stands on it. A support
        that moves becomes a body of enormous mass, told its place and velocity before every step.
        """
        self._ways[support] = self._ways.get(support, 0.0) + np.array([displacement, velocity], dtype=float)

    def _put(self, support: int, displacement: Floats, velocity: Floats) -> None:
        """Put a moving support in its place for one time step."""
        b, body = self._bullet, self._bodies[support]
        if support not in self._carried:
            self._carried.add(support)
            heavy = [CARRIER_MASS * BLOCK_SIZE**2] * 3
            b.changeDynamics(body, -1, mass=CARRIER_MASS, localInertiaDiagonal=heavy, physicsClientId=self._client)
            for other in np.flatnonzero(self.assembly.support):
                b.setCollisionFilterPair(body, self._bodies[other], -1, -1, 0, physicsClientId=self._client)
        place = (self.assembly.centroid[support] + displacement) * self.length
        turned = b.getBasePositionAndOrientation(body, physicsClientId=self._client)[1]
        b.resetBasePositionAndOrientation(body, place.tolist(), turned, physicsClientId=self._client)
        # Bullet adds no gravity to a body that was made as a static one, and leaves it where it is put.
        own = (velocity * (self.length / self.time)).tolist()
        b.resetBaseVelocity(body, own, [0.0] * 3, physicsClientId=self._client)

    def remove(self, block: int) -> None:
        """Take a block out: nothing touches it any more, and `poses` tells where it last was.

        Parameters
        ----------
        block : int
            Number of the block.
        """
        b, body = self._bullet, self._bodies[block]
        b.changeDynamics(body, -1, mass=0.0, physicsClientId=self._client)
        b.setCollisionFilterGroupMask(body, -1, 0, 0, physicsClientId=self._client)
        b.resetBaseVelocity(body, [0.0] * 3, [0.0] * 3, physicsClientId=self._client)
        self.removed.add(block)

    def place(self, block: int, displacement: Floats, rotation: Floats) -> None:
        """Put a block somewhere and hold it there, also one that was taken out.

        Parameters
        ----------
        block : int
            Number of the block.
        displacement : array of float, shape (3,)
            From where it was built [m].
        rotation : array of float, shape (3, 3)
            Rotation since built.
        """
        b, body = self._bullet, self._bodies[block]
        where = (self.assembly.centroid[block] + displacement) * self.length
        turned = quaternion(rotation @ self._shapes[block].rotation)
        b.resetBasePositionAndOrientation(body, where.tolist(), turned.tolist(), physicsClientId=self._client)
        b.setCollisionFilterGroupMask(body, -1, *MOVABLE, physicsClientId=self._client)
        self.removed.discard(block)
        self.hold(block)

    def hold(self, block: int) -> None:
        """Hold a block where it is: nothing can push it.

        Parameters
        ----------
        block : int
            Number of the block.
        """
        b, body = self._bullet, self._bodies[block]
        b.changeDynamics(body, -1, mass=0.0, physicsClientId=self._client)
        b.resetBaseVelocity(body, [0.0] * 3, [0.0] * 3, physicsClientId=self._client)
        self._held.add(block)

    def let_go(self, block: int) -> None:
        """Let go of a block that is held.

        Parameters
        ----------
        block : int
            Number of the block.
        """
        self._held.discard(block)
        self._weigh(block)
        self.set_gravity(self._gravity)

    def contact_forces(self) -> tuple[Ints, Floats, Floats, Floats]:
        """Return the forces of the last time step at every contact point.

        Returns
        -------
        pairs : array of int, shape (k, 2)
            The two blocks of each point.
        point : array of float, shape (k, 3)
            Where they touch [m].
        force : array of float, shape (k, 3)
            Force on the second block, normal and friction together [N].
        normal : array of float, shape (k, 3)
            Unit normals, out of the second block.
        """
        pairs, point, impulse, normal = contact_points(self._bullet, self._client, self._bodies)
        # Forces are averaged over the sub-steps as if only one counted.
        count = 1 if self._stepwise else self.settings.substeps
        return pairs, point / self.length, impulse * (count / (self._mass * self._acceleration)), normal
