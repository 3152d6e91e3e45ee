"""Run the protocol: settle under full damping, then let go and watch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np

from blockstat.assembly import Assembly
from blockstat.polyhedron import Floats
from dynsim.action import Action
from dynsim.settings import Settings
from dynsim.world import World

#: Taller scenes need longer to show a fall: times grow as sqrt(height) above this height at simulation scale.
TALL = 2.0


@dataclass(frozen=True, eq=False)
class Run:
    """A trajectory. Frame 0 is the settled state; displacements are from where the blocks were built."""

    assembly: Assembly
    times: Floats  #: shape (n_frames,) [s] since release, in the scene's own time
    displacement: Floats  #: shape (n_frames, n_blocks, 3) [m], of the centroids
    rotation: Floats  #: shape (n_frames, n_blocks, 3, 3), from the orientation as built
    initial_overlap: float  #: [m], deepest penetration between shapes before the first step
    process_seconds: float

    @property
    def since_release(self) -> Floats:
        """Displacement of the centroids since the settled state, shape (n_frames, n_blocks, 3) [m]."""
        return self.displacement - self.displacement[0]


def simulate(
    assembly: Assembly,
    *,
    settings: Settings | None = None,
    stop: Callable[[float, Floats], bool] | None = None,
    actions: Sequence[Action] = (),
) -> Run:
    """Settle an assembly and let it go.

    stop : called at every look with the simulated share of `Settings.end` that has gone since release and the
    displacement since then, shape (n_blocks, 3) [m]; True ends the run. actions : what acts on the blocks meanwhile.
    """
    settings = settings or Settings()
    start = process_time()
    times, displacement, rotation = [], [], []
    with World(assembly, settings, actions) as world:
        overlap = world.deepest_overlap()
        stretch = np.sqrt(max(_height(assembly) * world.length / TALL, 1.0))
        look = settings.substeps * settings.time_step
        world.damp(1.0)
        settling = round(settings.settle * stretch / look)
        for frame in range(settling):
            world.advance((frame - settling) * look / world.time)
        world.damp(0.0)
        looks = round(settings.end * stretch / look)
        for frame in range(looks + 1):
            if frame:
                world.advance((frame - 1) * look / world.time)
            moved, turned = world.poses()
            times.append(frame * look / world.time)
            displacement.append(moved)
            rotation.append(turned)
            if stop is not None and stop(settings.end * frame / looks, moved - displacement[0]):
                break
    return Run(assembly, np.array(times), np.array(displacement), np.array(rotation), overlap, process_time() - start)


def _height(assembly: Assembly) -> float:
    """Extent of the free blocks along gravity [m]."""
    free = np.repeat(~assembly.support, np.diff(assembly.vertex_start))
    along = assembly.vertices[free] @ (assembly.gravity / np.linalg.norm(assembly.gravity))
    return float(np.ptp(along))
