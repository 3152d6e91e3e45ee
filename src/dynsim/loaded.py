"""How a run under loads that change is judged: which blocks count, from when on, and against what threshold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Assembly
from blockstat.polyhedron import Floats, Ints
from dynsim.action import Load
from dynsim.criteria import default_threshold
from dynsim.given import blocks_named
from dynsim.loading import Removal

#: Blocks rock for long: after the last change of a load a run may take this many times `Settings.end`.
AFTERWARDS = 3.0


def last_change(loads: Sequence[Load]) -> float:
    """Time since release of the last change of a load [s]; -inf where none changes."""
    return max((load.end for load in loads), default=-np.inf)


def stays(assembly: Assembly, loads: Sequence[Load]) -> Ints:
    """The free blocks that no load takes away."""
    gone = [blocks_named(assembly, load.blocks, "removal") for load in loads if isinstance(load, Removal)]
    return np.setdiff1d(assembly.free, np.concatenate(gone)) if gone else assembly.free


def threshold_under(assembly: Assembly, loads: Sequence[Load]) -> float:
    """Displacement that counts as falling [m]: of a block's size where loads shake, tilt or move the ground."""
    if np.isinf(last_change(loads)):
        return default_threshold(assembly)
    return float(np.median(assembly.size[assembly.free])) + sum(load.travel for load in loads)


class Calm:
    """Whether blocks have stayed within a distance of one place for a time, as seen look by look."""

    def __init__(self, distance: float, duration: float) -> None:
        self._distance, self._duration = distance, duration
        self._start, self._place = -np.inf, np.empty((0, 3))
        self.reached = False

    def since(self, time: float, moved: Floats) -> bool:
        """Look at displacements, shape (n, 3) [m], at a time; before 0 nothing is calm."""
        if time <= 0 or np.linalg.norm(moved - self._place, axis=1).max() >= self._distance:
            self._start, self._place = max(time, 0.0), moved
        self.reached = time > 0 and time - self._start >= self._duration
        return self.reached
