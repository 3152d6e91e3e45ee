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

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.typing import Floats, Ints
from dynsim.engine.bodies import outward_hull, shapes
from dynsim.engine.friction import STICKY, has_own_friction
from dynsim.engine.guards import check_assembly
from dynsim.engine.lmgc90_pieces import add_pieces
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
ALL_FREEDOMS = range(1, 7)
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
        from compas_lmgc90 import _lmgc90  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise InputError(MISSING) from error
    return _lmgc90


class Lmgc90World:
    """Blocks of an assembly in LMGC90, with the methods of `World` that a run under weight needs.

    There is one simulation of LMGC90 in a process. A second one replaces the first.
    """

    settles = False  #: there is nothing to damp away before a free run

    def __init__(self, assembly: Assembly, settings: Settings, actions: Sequence[Action] = ()) -> None:
        """Check the assembly and prepare its shapes; LMGC90 starts when the context is entered.

        Parameters
        ----------
        assembly : Assembly
            Blocks, supports, friction and gravity.
        settings : Settings
            Time step and time between looks.
        actions : sequence of Action
            None may be given: only the weight is simulated.

        Raises
        ------
        InputError
            For a scene that cannot be simulated, for bonds and loads, and where the package is missing.
        """
        self._module = import_lmgc90()
        check_assembly(assembly)
        _check_scene(assembly, actions)
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
        with _silent():
            self._solver = self._module.LMGC90Solver()
            self._solver.initialize(self.settings.time_step, THETA, False)
            self._set_up()
            self._start = self._bodies(self._solver.get_initial_state())
        self._now = self._before = self._start
        self._last: Any = None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with _silent():
            self._solver.finalize()

    def _set_up(self) -> None:
        assembly, solver = self.assembly, self._solver
        blocks = [self._pieces(shape, block) for block, shape in enumerate(shapes(assembly))]
        _check_corners(assembly, blocks)
        volume = np.array([sum(outward_hull(piece)[1] for piece in pieces) for pieces in blocks])
        solver.add_one_tact_behav("iqsc0", "IQS_CLB", [min(assembly.friction, STICKY)])
        solver.set_materials(assembly.mass * self._mass / volume)
        solver.set_see_tables(ALERT * BLOCK_SIZE)
        solver.set_nb_bodies(assembly.n_blocks)
        for block, pieces in enumerate(blocks):
            centre = (self._turn @ assembly.centroid[block]) * self.length
            driven = len(ALL_FREEDOMS) if assembly.support[block] else 0
            name = f"s{block + 1:04d}"
            if len(pieces) == 1:
                faces = (outward_hull(pieces[0])[0] + 1).ravel().tolist()
                solver.set_one_polyr(name, centre.tolist(), faces, pieces[0].ravel().tolist(), driven, 0)
            else:
                add_pieces(self._module, name, centre, pieces, driven)
            for freedom in ALL_FREEDOMS[:driven]:
                solver.set_drvdof(block + 1, freedom, np.zeros(6), True, False)
        solver.close_before_computing()

    def _pieces(self, shape: Any, block: int) -> list[Floats]:
        """Corners of the convex pieces of a block about its centroid, as simulated [m]."""
        turn = self._turn @ shape.rotation
        return [piece @ turn.T * self.length for piece in shape.pieces]

    @staticmethod
    def _bodies(state: Any) -> tuple[Floats, Floats]:
        """Centres of mass and frames (columns are axes) of the bodies as simulated."""
        frames = np.array([np.reshape(frame, (3, 3)).T for frame in state.body_frames])
        return np.array([list(body) for body in state.bodies]), frames

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
        with _silent():
            for _ in range(self.settings.substeps):
                self._last = self._solver.compute_one_step()
                self._before, self._now = self._now, self._bodies(self._last)

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
        RuntimeError
            When LMGC90 lost a block: its position is not a number.
        """
        return self._poses(self._now)

    def _poses(self, state: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        (place, frame), (start, first) = state, self._start
        if not (np.isfinite(place).all() and np.isfinite(frame).all()):
            raise RuntimeError("LMGC90 lost a block (its position is not a number)")
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

        (old, from_), (new, to) = self._poses(self._before), self._poses(self._now)
        step = self.settings.time_step / self.time
        return (new - old) / step, Rotation.from_matrix(to @ from_.swapaxes(1, 2)).as_rotvec() / step

    def contact_forces(self) -> tuple[Ints, Floats, Floats]:
        """Return the forces of the last time step at every contact point.

        Returns
        -------
        pairs : array of int, shape (k, 2)
            The two blocks of each point.
        point : array of float, shape (k, 3)
            Where they touch [m].
        force : array of float, shape (k, 3)
            Force on the second block, normal and friction together [N].
        """
        if self._last is None:
            return np.zeros((0, 2), dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 3))
        pairs = np.array([list(pair) for pair in self._last.interaction_bodies], dtype=np.int64).reshape(-1, 2) - 1
        point = np.array([list(p) for p in self._last.interaction_coords]).reshape(-1, 3)
        on_first = np.array([list(f) for f in self._last.interaction_force_global]).reshape(-1, 3)
        return pairs, point @ self._turn / self.length, -on_first @ self._turn / self._force


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


def _check_scene(assembly: Assembly, actions: Sequence[Action]) -> None:
    only = 'the engine "lmgc90" simulates weight and one friction'
    if actions or any(law.strong for law in assembly.joints):
        raise InputError(f'"{assembly.name}": {only}; loads, actions and bonds need the engine "bullet"')
    if has_own_friction(assembly):
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


@contextmanager
def _silent() -> Iterator[None]:
    """Keep what Fortran prints from the terminal."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
