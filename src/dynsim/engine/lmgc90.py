"""LMGC90 as a second engine: non-smooth contact dynamics of rigid blocks, through the optional package `compas_lmgc90`.

Bullet corrects velocities in sweeps, with slop and error reduction. LMGC90 solves the impulses of each step under exact
unilateral contact and Coulomb friction, by non-linear Gauss-Seidel to a tolerance (Jean 1999; Dubois et al. 2018). The
blocks, their scale and the criteria are the same, so where both say the same it is no matter of a solver.

The scene is simulated at the scale of `dynsim.engine.world`, turned so that gravity is down the third axis, as LMGC90
has it. Contacts are inelastic from the first step on: nothing has to settle, and overlaps are not pushed apart.

References
----------
M. Jean, The non-smooth contact dynamics method, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257.
F. Dubois, V. Acary and M. Jean, The contact dynamics method: a nonsmooth story, C. R. Mecanique 346 (2018) 247-262.
"""

from __future__ import annotations

import importlib
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.typing import Floats, Ints
from dynsim.engine.bodies import Shape, filled_blocks, outward_hull, shapes
from dynsim.engine.friction import STICKY, has_own_friction
from dynsim.engine.guards import check_can_simulate, check_places
from dynsim.engine.lmgc90_process import Scene, State
from dynsim.engine.world import BLOCK_MASS, BLOCK_SIZE, GRAVITY, Action
from dynsim.settings import Settings

MISSING = 'the engine "lmgc90" needs the package compas_lmgc90; install it with: pip install "blockstat[lmgc90]"'
#: Blocks closer than this share of the median block may touch within a step. They move by less: a block that falls
#: freely for a whole look of 0.02 s moves by 2 mm at the scale of the simulation, which is less than 3 mm.
ALERT = 0.01
#: Weight of the new velocity in a step; the midpoint rule conserves energy between contacts.
THETA = 0.5
#: LMGC90 names a material by four digits.
MOST_BLOCKS = 9999
#: LMGC90 ends the process where more triangles than this meet at a corner.
MOST_MEETING = 30


def import_lmgc90() -> Any:
    """Import the module of LMGC90's wrapper.

    Returns
    -------
    module
        The module compas_lmgc90._lmgc90.

    Raises
    ------
    InputError
        Where the package is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module("compas_lmgc90._lmgc90")
    except ImportError as error:
        raise InputError(MISSING) from error


class Lmgc90World:
    """Blocks of an assembly in LMGC90, with the methods of `World` that a run under weight needs.

    LMGC90 runs in a process of its own (`dynsim.engine.lmgc90_process`), which may end without harm to this one.
    """

    settles = False  #: there is nothing to damp away before a free run
    inertia_scale = 1.0  #: factor on the moments of inertia: it has the true ones

    def __init__(
        self,
        assembly: Assembly,
        settings: Settings,
        actions: Sequence[Action] = (),
        *,
        interfaces: Interfaces | None = None,
    ) -> None:
        """Check the assembly and prepare its shapes; LMGC90 starts when the context is entered.

        Parameters
        ----------
        assembly : Assembly
            Blocks, supports, friction and gravity.
        settings : Settings
            Time step and time between looks.
        actions : sequence of Action
            None may be given: only the weight is simulated.
        interfaces : Interfaces, optional
            Joints of the assembly; they may have no friction other than the assembly's.

        Raises
        ------
        InputError
            For a scene that cannot be simulated, for bonds, loads and joints with their own friction, and where the
            package is missing.
        """
        import_lmgc90()
        check_can_simulate(assembly)
        _check_scene(assembly, actions, interfaces)
        free = ~assembly.support
        self.assembly, self.settings = assembly, settings
        self.removed: set[int] = set()
        self.length = BLOCK_SIZE / float(np.median(assembly.size[free]))  #: simulation metres a scene metre
        strength = float(np.linalg.norm(assembly.gravity))
        self.time = float(np.sqrt(self.length * strength / GRAVITY))  #: simulation seconds a scene second
        self._mass = BLOCK_MASS / float(np.median(assembly.mass[free]))
        self._force = self._mass * GRAVITY / strength  #: simulation newtons a newton
        self._turn = rotation_between(assembly.gravity / strength, np.array([0.0, 0.0, -1.0]))

    def __enter__(self) -> Lmgc90World:
        scene = self._scene()
        self._scratch = tempfile.TemporaryDirectory(prefix="dynsim-")
        self._log = Path(self._scratch.name) / "lmgc90.log"
        path = os.pathsep.join([str(Path(__file__).parents[2]), *filter(None, sys.path)])
        self._process = subprocess.Popen(
            [sys.executable, "-c", "from dynsim.engine.lmgc90_process import main; main()", str(self._log)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=os.environ | {"PYTHONPATH": path},
        )  # fmt: skip
        try:
            self._now = self._start = self._asked(scene)
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.communicate()
        self._scratch.cleanup()

    def _asked(self, question: Any) -> State:
        """What the process of LMGC90 answers."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            pickle.dump(question, self._process.stdin, protocol=pickle.HIGHEST_PROTOCOL)
            self._process.stdin.flush()
            return pickle.load(self._process.stdout)
        except (EOFError, OSError, pickle.UnpicklingError):
            said = self._log.read_text(errors="replace").splitlines() if self._log.exists() else []
            told = next((line for line in reversed(said) if "error" in line.lower()), "without a word")
            told = "".join(letter for letter in told if letter.isprintable()).strip()  # Fortran's strings end in zeros
            raise InputError(
                f'"{self.assembly.name}": LMGC90 cannot simulate this scene and ended ({told}); use the engine "bullet"'
            ) from None

    def _scene(self) -> Scene:
        assembly = self.assembly
        found = shapes(assembly, exact=True)
        self.filled = filled_blocks(assembly, found)  #: blocks whose shapes fill recesses of theirs
        pieces = tuple(self._pieces(shape) for shape in found)
        _check_corners(assembly, pieces)
        volume = np.array([sum(outward_hull(piece)[1] for piece in own) for own in pieces])
        return Scene(
            step=self.settings.time_step, theta=THETA, friction=min(assembly.friction, STICKY),
            alert=ALERT * BLOCK_SIZE, density=assembly.mass * self._mass / volume,
            centre=assembly.centroid @ self._turn.T * self.length, pieces=pieces, support=assembly.support,
        )  # fmt: skip

    def _pieces(self, shape: Shape) -> tuple[Floats, ...]:
        """Corners of the convex pieces of a block about its centroid, as simulated [m]."""
        turn = self._turn @ shape.rotation
        return tuple(piece @ turn.T * self.length for piece in shape.pieces)

    @property
    def process_seconds(self) -> float:
        """Process time of LMGC90 [s]."""
        return self._now.seconds

    def set_time_step(self, step: float) -> None:
        """Keep the time step: LMGC90 has one from the start.

        Parameters
        ----------
        step : float
            That of the settings [s].
        """
        assert step == self.settings.time_step

    def damp(self, value: float) -> None:
        """Do nothing: contacts are inelastic.

        Parameters
        ----------
        value : float
            As in `World.damp`.
        """

    def deepest_overlap(self) -> float:
        """Return 0: overlaps are left as they are.

        Returns
        -------
        float
            0.
        """
        return 0.0

    def advance(self, time: float = 0.0) -> None:
        """Go forward by one look, which is `Settings.look_every` at simulation scale.

        Parameters
        ----------
        time : float
            Time since release at the start of the look [s]; not used.
        """
        self._now = self._asked(self.settings.substeps)

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
            When LMGC90 lost a block: its position is not a number.
        """
        return self._poses(self._now.place, self._now.frame)

    def _poses(self, place: Floats, frame: Floats) -> tuple[Floats, Floats]:
        start, first = self._start.place, self._start.frame
        check_places(self.assembly, place, frame)
        turned = frame @ first.swapaxes(1, 2)
        # The centre of mass of the pieces is not quite the centroid of the block.
        arm = self.assembly.centroid @ self._turn.T * self.length - start
        moved = place + np.einsum("nij,nj->ni", turned, arm) - arm - start
        return moved @ self._turn / self.length, self._turn.T @ turned @ self._turn

    def velocities(self) -> tuple[Floats, Floats]:
        """Return the mean velocities of the blocks over the last time step.

        Returns
        -------
        linear : array of float, shape (n_blocks, 3)
            Velocity of each centroid [m/s].
        angular : array of float, shape (n_blocks, 3)
            Angular velocity [1/s].
        """
        from scipy.spatial.transform import Rotation

        now = self._now
        (old, from_), (new, to) = self._poses(now.place_before, now.frame_before), self._poses(now.place, now.frame)
        step = self.settings.time_step / self.time
        return (new - old) / step, Rotation.from_matrix(to @ from_.swapaxes(1, 2)).as_rotvec() / step

    def contact_forces(self) -> tuple[Ints, Floats, Floats, None]:
        """Return the forces of the last time step at every contact point.

        Returns
        -------
        pairs : array of int, shape (k, 2)
            The two blocks of each point.
        point : array of float, shape (k, 3)
            Where they touch [m].
        force : array of float, shape (k, 3)
            Force on the second block, normal and friction together [N].
        normal : None
            Normals are not kept: friction is Coulomb's here.
        """
        now = self._now
        return now.pairs, now.point @ self._turn / self.length, now.force @ self._turn / self._force, None


def rotation_between(a: Floats, b: Floats) -> Floats:
    """Return the rotation that turns one direction into another the short way.

    Parameters
    ----------
    a, b : array of float, shape (3,)
        Unit vectors.

    Returns
    -------
    array of float, shape (3, 3)
        Rotation matrix R with R a = b.
    """
    from scipy.spatial.transform import Rotation

    axis = np.cross(a, b)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        if a @ b > 0:
            return np.eye(3)
        across = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        return Rotation.from_rotvec(np.pi * across / np.linalg.norm(across)).as_matrix()
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, a @ b)).as_matrix()


def _check_scene(assembly: Assembly, actions: Sequence[Action], interfaces: Interfaces | None = None) -> None:
    only = 'the engine "lmgc90" simulates weight and one friction'
    if actions or any(law.strong for law in assembly.joints):
        raise InputError(f'"{assembly.name}": {only}; loads, actions and bonds need the engine "bullet"')
    if has_own_friction(assembly, interfaces):
        raise InputError(f'"{assembly.name}": {only}; joints with their own friction need the engine "bullet"')
    if assembly.n_blocks > MOST_BLOCKS:
        raise InputError(f'"{assembly.name}" has {assembly.n_blocks} blocks; LMGC90 takes {MOST_BLOCKS} at most')


def _check_corners(assembly: Assembly, blocks: Sequence[Sequence[Floats]]) -> None:
    for name, pieces in zip(assembly.names, blocks, strict=True):
        meeting = max(int(np.bincount(outward_hull(piece)[0].reshape(-1)).max()) for piece in pieces)
        if meeting > MOST_MEETING:
            raise InputError(
                f'block "{name}" has a corner where {meeting} triangles of its hull meet; LMGC90 takes '
                f'{MOST_MEETING} at most; use the engine "bullet"'
            )
