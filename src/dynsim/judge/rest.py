"""Rest detection, and the criteria under loads: which blocks count, from when on, against what threshold."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.contact.tolerance import stated_length
from blockstat.geometry.components import connected_components
from blockstat.program.ties import tied_pairs
from blockstat.typing import Floats, Ints
from dynsim.judge.criteria import default_threshold
from dynsim.loads.load import Load
from dynsim.loads.loading import Removal, Settlement
from dynsim.settings import LOOKS, SHOWN

#: Blocks rock for long: after the last change of a load a run may take this many times `Settings.end`.
AFTERWARDS = 3.0
#: Blocks rest when their trend is slower than an imbalance at the resolution would have made them by this factor.
SAFE = 4.0
#: Standard errors that are added to a trend.
ERRORS = 2.0
#: Times that differ by less are equal [s].
ROUNDING = 1e-9
#: Share of the window from which on a run without a trend may end. An imbalance at the resolution has moved a block of
#: 0.3 m by 0.3 mm then, a quarter of `SHOWN`: ten times as far as blocks of a sound chapel sink into each other.
SOONEST = 0.5


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


def threshold_under(assembly: Assembly, loads: Sequence[Load], given: float | None = None) -> float:
    """Return the displacement that counts as falling under some loads.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    loads : sequence of Load
        Loads of a run.
    given : float, optional
        The threshold asked for [m]. When None it is the default threshold, or the size of a block where a load changes.

    Returns
    -------
    float
        Displacement [m]: the threshold and what the loads themselves move.
    """
    if given is None and np.isinf(last_change(loads)):
        given = default_threshold(assembly)
    elif given is None:
        given = float(np.median(assembly.size[assembly.free]))
    carried = np.zeros(assembly.n_blocks)  # what several settlements do to one support adds up
    for load in loads:
        on = assembly.blocks_named(load.supports, "settlement") if isinstance(load, Settlement) else slice(None)
        carried[on] += load.travel
    return given + float(carried.max())


def free_drop(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Return how far each block may drop that nothing holds as built.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    array of float, shape (n_blocks,)
        The gap up to which two faces are a joint [m] where no chain of joints and ties leads from the block to a
        support: what drops further touched nothing. Infinite for the other blocks.
    """
    _, part = connected_components(assembly.n_blocks, np.vstack([interfaces.pair, tied_pairs(assembly)]))
    loose = ~np.isin(part, part[assembly.support])
    length = stated_length(interfaces.searched)
    gap = np.full(assembly.n_blocks, length) if length is not None else assembly.size * float(interfaces.searched)
    return np.where(loose, gap, np.inf)


def movement(assembly: Assembly, blocks: Ints, moved: Floats, turned: Floats) -> Floats:
    """Return displacements and rotations of blocks so that the square of their rates is twice the energy over the mass.

    Parameters
    ----------
    assembly : Assembly
        Has the inertia.
    blocks : array of int, shape (k,)
        Numbers of blocks.
    moved : array of float, shape (n_blocks, 3)
        Displacements [m].
    turned : array of float, shape (n_blocks, 3)
        Rotation vectors [rad].

    Returns
    -------
    array of float, shape (k, 6)
        Displacements, and rotations times radii of gyration [m].
    """
    gyration = np.linalg.cholesky(assembly.inertia[blocks] / assembly.mass[blocks, None, None])
    return np.hstack([moved[blocks], np.einsum("nji,nj->ni", gyration, turned[blocks])])


class RestDetection:
    """Whether blocks are at rest, from one sample of their places to the next.

    Notes
    -----
    An imbalance of a share e of the weight gives some block an acceleration of at least e g, so that after a time t
    its velocity is at least e g t. Rotations count by the radii of gyration (`movement`). Contact noise makes
    blocks tremble about a place, and creep a little. So the velocity is that of the trend: over the last t, a
    parabola is fitted by least squares to each coordinate of each block. Its velocity is e g t / 2 or more in the
    middle and e g t or more at the end. Blocks are at rest when both velocities, with `ERRORS` standard errors
    added, are below e g t / `SAFE` for all blocks. What trembles has no trend, what creeps has one that stays
    small, what falls has one that grows.

    The time t is that since release, from `SOONEST` times T = `Settings.window` on, and never more than T. Where fewer
    than `LOOKS` looks fit into t, the trend is that of the last `LOOKS`, and must be as slow. The velocity of an
    imbalance grows as t and the error of a trend shrinks as t^(3/2): where blocks lie still the run ends early, and
    where noise could hide an imbalance it goes on.

    For e g stands 2 `SHOWN` times the default threshold / T^2, as contact noise grows with the courses. At the scale of
    the simulation (see `dynsim.engine.world`) that is e g to 1.5 times e g for few courses, and `SAFE` times e g only
    for more than 160.
    """

    def __init__(self, threshold: float, window: float) -> None:
        """Set what counts as rest.

        Parameters
        ----------
        threshold : float
            Default threshold of the assembly [m].
        window : float
            Time over which trends are taken [s].
        """
        self._threshold, self._window = threshold, window
        self._times: list[float] = []
        self._moved: list[Floats] = []
        self.reached = False

    def lengthen(self, window: float) -> None:
        """Ask for a longer time without a trend; looks up to now count.

        Parameters
        ----------
        window : float
            Time over which trends are taken [s].
        """
        self._window, self.reached = window, False

    def look(self, time: float, moved: Floats) -> bool:
        """Take displacements in, and return whether the blocks are at rest.

        Parameters
        ----------
        time : float
            Time of the look [s]; before 0 nothing is at rest.
        moved : array of float, shape (n_blocks, 6)
            Displacements, and rotations times radii of gyration, as `movement` gives them [m].

        Returns
        -------
        bool
            Whether the blocks are at rest.
        """
        if time >= 0:
            self._times.append(time)
            self._moved.append(moved)
            length = min(time - self._times[0], self._window)
            first = bisect_right(self._times, time - length + ROUNDING) - 1  # the last look before that time
            first = min(first, len(self._times) - LOOKS)  # a longer time than the window where looks are far apart
            fastest = 2 * SHOWN * self._threshold / self._window**2 * length / SAFE
            enough = length > SOONEST * self._window - ROUNDING and first >= 0
            self.reached = bool(enough and self._speed(first) < fastest)
        return self.reached

    def _speed(self, first: int) -> float:
        """Velocity of the fastest trend since a look, with its standard errors [m/s]."""
        moved = np.array(self._moved[first:])
        velocity, error = trend(np.array(self._times[first:]), moved.reshape(len(moved), -1))
        fast = np.abs(velocity).max(axis=0) + ERRORS * error
        return float(np.linalg.norm(fast.reshape(moved.shape[1:]), axis=1).max())


def trend(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return the velocities of parabolas fitted by least squares, and the standard error at the end.

    Parameters
    ----------
    times : array of float, shape (n,)
        Times, at least four.
    values : array of float, shape (n, k)
        What is fitted.

    Returns
    -------
    velocity : array of float, shape (2, k)
        In the middle and at the end, in units of the values a unit of time.
    error : array of float, shape (k,)
        Of the velocity at the end; it is less in the middle.

    Examples
    --------
    >>> times = np.linspace(0.0, 1.0, 5)
    >>> trend(times, times[:, None] ** 2)[0].round(9).tolist()
    [[1.0], [2.0]]
    """
    since = times - times[-1]
    basis = np.stack([np.ones_like(since), since, since**2], axis=1)
    inverse = np.linalg.pinv(basis)
    fitted = inverse @ values
    square = ((values - basis @ fitted) ** 2).sum(axis=0) / (len(times) - 3)
    velocity = np.stack([fitted[1] + since[0] * fitted[2], fitted[1]])
    return velocity, np.sqrt(square) * np.linalg.norm(inverse[1])
