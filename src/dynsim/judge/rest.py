"""Rest detection, and the criteria under loads: which blocks count, from when on, against what threshold."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Assembly
from blockstat.typing import Floats, Ints
from dynsim.judge.criteria import default_threshold
from dynsim.loads.load import Load
from dynsim.loads.loading import Removal

#: Blocks rock for long: after the last change of a load a run may take this many times `Settings.end`.
AFTERWARDS = 3.0
#: Motion dies away when it is less than this part of what it was in the time before.
DYING = 0.9
#: Blocks are quiet when they moved, in the root mean square, by less than this part of the rest distance in half the
#: time. One block shakes at random; a mechanism too slow to be seen in it yet moves many at once.
QUIET = 0.04
#: What is not quiet has to be still for this many times as long.
LONGER = 2.0


def last_change(loads: Sequence[Load]) -> float:
    """Return when the loads change for the last time.

    Parameters
    ----------
    loads : sequence of Load
        Loads of a run.

    Returns
    -------
    float
        Time since release [s]; -inf where no load changes.
    """
    return max((load.end for load in loads), default=-np.inf)


def stays(assembly: Assembly, loads: Sequence[Load]) -> Ints:
    """Return the free blocks that no load takes away.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    loads : sequence of Load
        Loads of a run.

    Returns
    -------
    array of int
        Numbers of blocks, ascending.
    """
    gone = [assembly.blocks_named(load.blocks, "removal") for load in loads if isinstance(load, Removal)]
    return np.setdiff1d(assembly.free, np.concatenate(gone)) if gone else assembly.free


def threshold_under(assembly: Assembly, loads: Sequence[Load]) -> float:
    """Return the displacement that counts as falling under some loads.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    loads : sequence of Load
        Loads of a run.

    Returns
    -------
    float
        Displacement [m]: the default threshold, or the size of a block and what the loads move where a load changes.
    """
    if np.isinf(last_change(loads)):
        return default_threshold(assembly)
    return float(np.median(assembly.size[assembly.free])) + sum(load.travel for load in loads)


class RestDetection:
    """Whether blocks are at rest, from one sample of their places to the next.

    Blocks rest when they are still and quiet. They are still when they stayed within a distance of one place for a
    time. They are also still when they are near where they were released, moved by less than three such distances in
    that time, and by less than in the time before. They are quiet when the root mean square of their motion is small.
    Blocks that have been within the distance of one place for longer need not be quiet.
    """

    def __init__(self, distance: float, duration: float, small: float) -> None:
        """Set what counts as rest.

        Parameters
        ----------
        distance : float
            Displacement within which blocks are still [m].
        duration : float
            For how long they have to be [s].
        small : float
            How far from where they were released blocks may be while their motion dies away [m].
        """
        self._distance, self._duration, self._small = distance, duration, small
        self._start, self._place = -np.inf, np.empty((0, 3))
        self._past: deque[tuple[float, Floats]] = deque()
        self.reached = False

    def look(self, time: float, moved: Floats) -> bool:
        """Take displacements in, and return whether the blocks are at rest.

        Parameters
        ----------
        time : float
            Time of the look [s]; before 0 nothing is at rest.
        moved : array of float, shape (n_blocks, 3)
            Displacements [m].

        Returns
        -------
        bool
            Whether the blocks are at rest.
        """
        if time <= 0 or _furthest(moved - self._place) >= self._distance:
            self._start, self._place = max(time, 0.0), moved
        if time > 0:
            self._remember(time, moved)
            still_for = time - self._start
            still = still_for >= self._duration or self._dies_away(time, moved)
            self.reached = still and (still_for >= LONGER * self._duration or self._quiet(time, moved))
        return self.reached

    def _remember(self, time: float, moved: Floats) -> None:
        """Keep the looks of the last two durations, from the last one before them on."""
        self._past.append((time, moved))
        while len(self._past) > 1 and self._past[1][0] <= time - 2 * self._duration + 1e-9:
            self._past.popleft()

    def _before(self, time: float) -> Floats:
        """Displacements in the look nearest to a time."""
        return min(self._past, key=lambda look: abs(look[0] - time))[1]

    def _quiet(self, time: float, moved: Floats) -> bool:
        steps = moved - self._before(time - self._duration / 2)
        return float(np.sqrt((steps**2).sum(axis=1).mean())) < QUIET * self._distance

    def _dies_away(self, time: float, moved: Floats) -> bool:
        """Whether the motion of the last `duration` is small and smaller than that of the one before."""
        first, start = self._past[0]
        if first > time - 2 * self._duration + 1e-9:
            return False
        middle = self._before(time - self._duration)
        last, before = _furthest(moved - middle), _furthest(middle - start)
        return last < min(3 * self._distance, DYING * before) and _furthest(moved) < self._small


def _furthest(moved: Floats) -> float:
    return float(np.linalg.norm(moved, axis=1).max())
