"""Pose the equilibrium problem of an assembly: check the input, find the joints, set up the program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact import Interfaces, find_interfaces
from blockstat.equilibrium import Equilibrium, equilibrium, split_floating, weight
from blockstat.errors import InputError
from blockstat.joint import joint_friction, point_tension
from blockstat.overlap import check_overlaps
from blockstat.planar import find_plane
from blockstat.polyhedron import Floats, Ints
from blockstat.program import PenaltyProgram, penalty_program
from blockstat.result import Outcome

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A joint open by more than this fraction of the block size is mentioned when the verdict rests on it.
LOOSE = 1e-3


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything the solvers and the certificates need, and what was noticed on the way."""

    assembly: Assembly
    interfaces: Interfaces
    load: Floats  #: dead load on each block, shape (n_blocks, 6) [N, N m]
    eq: Equilibrium  #: of the blocks that a chain of joints ties to a support
    program: PenaltyProgram | None  #: None when there is no such block
    floating: Ints  #: blocks that nothing holds
    gap: float
    warnings: tuple[str, ...]
    timings: dict[str, float]

    def to_blocks(self, twist: Floats) -> Floats:
        """A scaled twist of the program as velocities and rotations of all blocks, shape (n_blocks, 6)."""
        mechanism = np.zeros((self.assembly.n_blocks, 6))
        if self.program is not None:
            mechanism[self.eq.blocks] = twist.reshape(-1, 6) / np.repeat([1.0, self.program.length_unit], 3)
        return mechanism

    def to_points(self, force: Floats) -> Floats:
        """Scaled forces of the program as contact forces at all points [N], shape (n_points, 3)."""
        forces = np.zeros((self.interfaces.n_points, 3))
        if self.program is not None:
            forces[self.eq.points] = force * self.program.force_unit
            forces[self.eq.points, 0] -= self.program.tension * self.program.force_unit
        return forces

    def adhesion_at_points(self, adhesion: Floats) -> Floats:
        """Scaled missing adhesion at all contact points [N], shape (n_points,)."""
        values = np.zeros(self.interfaces.n_points)
        if self.program is not None:
            values[self.eq.points] = adhesion * self.program.force_unit
        return values

    @property
    def slips(self) -> bool:
        """Whether every joint follows Coulomb's law: friction neither nothing nor infinite."""
        friction = self.program.friction if self.program is not None else np.empty(0)
        return bool(len(friction) and (friction > 0).all() and np.isfinite(friction).all())

    def scaled(self, load: Floats) -> Floats:
        """A wrench on each block, shape (n_blocks, 6) [N, N m], as a load vector of the program, shape (6 n,)."""
        assert self.program is not None
        unit = np.repeat([1.0, self.program.length_unit], 3) * self.program.force_unit
        return (load[self.eq.blocks] / unit).reshape(-1)


def pose(
    assembly: Assembly,
    *,
    friction: float | None,
    gravity: Any,
    loads: Floats | None,
    gap: float,
    interfaces: Interfaces | None,
) -> Problem:
    """Check the input and set up the program; the options are those of `assess`."""
    changes = {k: v for k, v in (("friction", friction), ("gravity", gravity)) if v is not None}
    assembly = assembly.with_(**changes) if changes else assembly
    if not assembly.support.any():
        raise InputError(f'"{assembly.name}" has no supports; list the blocks that cannot move under "supports"')
    load = weight(assembly) + checked_loads(assembly, loads)
    timings: dict[str, float] = {}
    warnings: list[str] = []
    with timed(timings, "interfaces"):
        if interfaces is None:
            interfaces = find_interfaces(assembly, gap=gap)
            warnings += check_overlaps(assembly, gap=gap)
    with timed(timings, "equilibrium"):
        held, floating = split_floating(assembly, interfaces)
        touched = np.isin(interfaces.pair, held)
        points = np.flatnonzero((touched[:, 0] | touched[:, 1])[interfaces.point_interface])
        eq = equilibrium(assembly, interfaces, load, held, points)
        mu = joint_friction(assembly, interfaces)[interfaces.point_interface[points]]
        tension = point_tension(assembly, interfaces)[points] if assembly.joints else None
        plane = find_plane(assembly, interfaces, eq)
        program = penalty_program(eq, mu, tension, plane) if len(held) else None
    warnings += _floating_warnings(assembly, floating, interfaces)
    if assembly.support.all():
        warnings.append("all blocks are supports; there was nothing to check")
    return Problem(assembly, interfaces, load, eq, program, floating, gap, tuple(warnings), timings)


def free_fall(problem: Problem) -> Floats:
    """Motion of the groups that nothing holds, each as one body along its load, shape (n_blocks, 6)."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    assembly, pair = problem.assembly, problem.interfaces.pair
    n = assembly.n_blocks
    graph = sparse.coo_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    motion = np.zeros((n, 6))
    for group in np.unique(label[problem.floating]):
        blocks = np.flatnonzero(label == group)
        pull = problem.load[blocks, :3].sum(axis=0)
        rounding = 1e-12 * np.abs(problem.load[blocks]).sum()
        if np.linalg.norm(pull) > rounding:
            motion[blocks, :3] = pull / np.linalg.norm(pull)
            continue
        arm = assembly.centroid[blocks] - assembly.centroid[blocks].mean(axis=0)
        moment = (problem.load[blocks, 3:] + np.cross(arm, problem.load[blocks, :3])).sum(axis=0)
        if np.linalg.norm(moment) > rounding * float(assembly.size[blocks].mean()):
            turn = moment / np.linalg.norm(moment)
            motion[blocks, :3], motion[blocks, 3:] = np.cross(turn, arm), turn
    return motion


def checked_loads(assembly: Assembly, loads: Floats | None) -> Floats:
    """A wrench on each block, shape (n_blocks, 6) [N, N m]; zeros for None."""
    if loads is None:
        return np.zeros((assembly.n_blocks, 6))
    try:
        loads = np.asarray(loads, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"loads must be numbers of shape ({assembly.n_blocks}, 6)") from None
    if loads.shape != (assembly.n_blocks, 6) or not np.isfinite(loads).all():
        raise InputError(f"loads have shape {loads.shape}; finite values of shape ({assembly.n_blocks}, 6) are needed")
    return loads


def _floating_warnings(assembly: Assembly, floating: Ints, interfaces: Interfaces) -> list[str]:
    touched = np.unique(interfaces.pair)
    alone = np.setdiff1d(floating, touched)
    return [f'block "{assembly.names[i]}" touches nothing' for i in alone[:5]] + (
        [f"{len(alone) - 5} more blocks touch nothing"] if len(alone) > 5 else []
    )


def gap_warnings(problem: Problem, outcome: Outcome) -> list[str]:
    """Say when the verdict may hang on the joint tolerance."""
    assembly, interfaces, gap = problem.assembly, problem.interfaces, problem.gap
    near = [d for d in interfaces.dropped if d.reason == "gap"]
    if outcome is not Outcome.STABLE and near:
        least = min(near, key=lambda d: d.value / d.limit)
        a, b = assembly.names[least.a], assembly.names[least.b]
        return [
            f"{len(near)} near joints were not taken (gap tolerance {gap:g} of the block size), the closest "
            f'"{a}" to "{b}" with {least.value:.2g} m: a larger tolerance may change the verdict'
        ]
    loose = interfaces.gap > LOOSE * assembly.size[interfaces.pair].min(axis=1)
    if outcome is Outcome.STABLE and loose.any():
        worst = interfaces.gap[loose].max()
        return [f"{loose.sum()} of {len(loose)} joints do not quite close (up to {worst:.2g} m) and count as touching"]
    return []


@contextmanager
def timed(timings: dict[str, float], step: str) -> Iterator[None]:
    """Add the process time of a step to the timings."""
    start = process_time()
    yield
    timings[step] = process_time() - start
