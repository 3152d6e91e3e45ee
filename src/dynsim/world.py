"""One Bullet client with the blocks of an assembly in it.

The scene is simulated at a fixed scale: lengths so that the median block measures 0.3 m, gravity 9.81 m/s2,
masses so that the median block weighs 100 kg. Rigid-block dynamics under Coulomb friction is scale-free with
time going as sqrt(length / gravity), so units change nothing, and Bullet sees what it was tuned for.
"""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.polyhedron import Floats, Ints
from dynsim.action import Action
from dynsim.bodies import Shape, hull_obj, shapes
from dynsim.settings import Settings

BLOCK_SIZE = 0.3  #: [m] median block size in the simulation
BLOCK_MASS = 100.0  #: [kg] median block mass in the simulation
GRAVITY = 9.81  #: [m/s2] in the simulation
STICKY = 100.0  #: Bullet's stand-in for infinite friction


class World:
    """A context manager around one client; poses go in and out in the scene's own units."""

    def __init__(self, assembly: Assembly, settings: Settings, actions: Sequence[Action] = ()) -> None:
        free = ~assembly.support
        if not free.any():
            raise InputError(f'"{assembly.name}": all blocks are supports; there is nothing to simulate')
        if assembly.joints:
            raise InputError(f'"{assembly.name}" has joint laws; Bullet simulates dry joints of one friction only')
        self.assembly = assembly
        self.settings = settings
        self.length = BLOCK_SIZE / float(np.median(assembly.size[free]))  #: simulation metres a scene metre
        strength = float(np.linalg.norm(assembly.gravity))
        self.time = float(np.sqrt(self.length * strength / GRAVITY))  #: simulation seconds a scene second
        self._mass = BLOCK_MASS / float(np.median(assembly.mass[free]))
        self._acceleration = GRAVITY / strength
        self._actions = tuple(actions)
        self._stepwise = any(action.each_step for action in self._actions)
        self._shapes = shapes(assembly)
        self._directory: tempfile.TemporaryDirectory[str] | None = None
        self._client = -1
        self._bodies: list[int] = []

    def __enter__(self) -> World:
        self._directory = tempfile.TemporaryDirectory(prefix="dynsim-")
        self._bullet = _import_bullet()
        self._client = self._bullet.connect(self._bullet.DIRECT)
        try:
            self._set_up()
            for action in self._actions:
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
        b, s = self._bullet, self.settings
        b.setPhysicsEngineParameter(
            fixedTimeStep=s.time_step if self._stepwise else s.substeps * s.time_step,
            numSubSteps=0 if self._stepwise else s.substeps, numSolverIterations=s.iterations,
            warmStartingFactor=0.85, contactSlop=1e-6, contactERP=0.2, solverResidualThreshold=0.0, enableSAT=1,
            enableFileCaching=0, physicsClientId=self._client,
        )  # fmt: skip
        self.set_gravity(self.assembly.gravity)
        # Boxes and hulls never mix: Bullet keeps a margin on one kind and not on the other.
        as_boxes = all(shape.half_extents is not None for shape in self._shapes)
        for block, shape in enumerate(self._shapes):
            self._bodies.append(self._add(block, shape, as_boxes))

    def _add(self, block: int, shape: Shape, as_box: bool) -> int:
        b = self._bullet
        if as_box:
            assert shape.half_extents is not None
            collision = b.createCollisionShape(
                b.GEOM_BOX,
                halfExtents=(shape.half_extents * self.length).tolist(),
                physicsClientId=self._client,
            )
        else:
            assert self._directory is not None
            path = Path(self._directory.name) / f"{block}.obj"
            path.write_text(hull_obj([piece * self.length for piece in shape.pieces]))
            collision = b.createCollisionShape(
                b.GEOM_MESH,
                fileName=str(path),
                flags=b.URDF_INITIALIZE_SAT_FEATURES,
                physicsClientId=self._client,
            )
        assembly = self.assembly
        mass = 0.0 if assembly.support[block] else assembly.mass[block] * self._mass
        body = b.createMultiBody(
            baseMass=mass,
            baseCollisionShapeIndex=collision,
            basePosition=(assembly.centroid[block] * self.length).tolist(),
            baseOrientation=_quaternion(shape.rotation).tolist(),
            useMaximalCoordinates=1,
            physicsClientId=self._client,
        )
        if collision < 0 or body < 0:
            raise RuntimeError(f'Bullet refused block "{assembly.names[block]}"')
        friction = min(assembly.friction, STICKY)
        options = {
            "lateralFriction": float(np.sqrt(friction)), "spinningFriction": 0.0, "rollingFriction": 0.0,
            "restitution": 0.0, "linearDamping": 0.0, "angularDamping": 0.0, "frictionAnchor": 1,
            "activationState": b.ACTIVATION_STATE_DISABLE_SLEEPING,
        }  # fmt: skip
        if mass > 0:
            options["mass"] = mass
            options["localInertiaDiagonal"] = (shape.inertia * self._mass * self.length**2).tolist()
        b.changeDynamics(body, -1, physicsClientId=self._client, **options)
        return body

    def damp(self, value: float) -> None:
        """Set linear and angular damping of all blocks; 1 takes all velocity away at every step."""
        for body in self._bodies:
            self._bullet.changeDynamics(
                body, -1, linearDamping=value, angularDamping=value, physicsClientId=self._client
            )

    def advance(self, time: float = 0.0) -> None:
        """Go forward by one look (`Settings.look_every` of simulated time); time : since release at its start [s]."""
        steps = self.settings.substeps if self._stepwise else 1
        for step in range(steps):
            for action in self._actions:
                if step == 0 or action.each_step:
                    action.act(self, time + step * self.settings.time_step / self.time)
            self._bullet.stepSimulation(physicsClientId=self._client)

    def set_gravity(self, gravity: Sequence[float] | Floats) -> None:
        """Gravity from now on, shape (3,) [m/s2]."""
        self._bullet.setGravity(*(np.asarray(gravity) * self._acceleration), physicsClientId=self._client)

    def push(self, blocks: Sequence[int] | Ints, forces: Floats, points: Floats) -> None:
        """Forces on some blocks until the end of the next step of `advance`; forces, points : shape (k, 3) [N], [m]."""
        scaled = np.asarray(forces, dtype=float) * self._mass * self._acceleration
        for block, force, point in zip(blocks, scaled, np.asarray(points, dtype=float) * self.length, strict=True):
            self._bullet.applyExternalForce(
                self._bodies[block], -1, force.tolist(), point.tolist(), self._bullet.WORLD_FRAME,
                physicsClientId=self._client,
            )  # fmt: skip

    def poses(self) -> tuple[Floats, Floats]:
        """Displacement of each centroid from where it was built, shape (n, 3) [m], and rotation matrices (n, 3, 3).

        Raises RuntimeError when Bullet lost a block to NaN.
        """
        answers = [
            self._bullet.getBasePositionAndOrientation(body, physicsClientId=self._client) for body in self._bodies
        ]
        position = np.array([answer[0] for answer in answers]) / self.length
        orientation = np.array([answer[1] for answer in answers])
        if not (np.isfinite(position).all() and np.isfinite(orientation).all()):
            raise RuntimeError("Bullet lost a block (its position is not a number)")
        initial = np.stack([shape.rotation for shape in self._shapes])
        rotation = _matrices(orientation) @ initial.swapaxes(1, 2)
        return position - self.assembly.centroid, rotation

    def deepest_overlap(self) -> float:
        """Deepest penetration between two blocks as they stand, in scene metres; 0 for none."""
        b = self._bullet
        b.performCollisionDetection(physicsClientId=self._client)
        contacts = b.getContactPoints(physicsClientId=self._client) or ()
        return max((-contact[8] for contact in contacts), default=0.0) / self.length


def _import_bullet() -> Any:
    """Import pybullet without its greeting, which it writes past Python's own streams."""
    if "pybullet" in sys.modules:
        return sys.modules["pybullet"]
    sys.stdout.flush()
    kept = [(stream, os.dup(stream)) for stream in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream, _ in kept:
            os.dup2(nowhere, stream)
        return importlib.import_module("pybullet")
    finally:
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)


def _quaternion(rotation: Floats) -> Floats:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_quat()


def _matrices(quaternion: Floats) -> Floats:
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion).as_matrix()
