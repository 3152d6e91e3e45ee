"""Rest detection, and the criteria under loads: which blocks count, from when on, against what threshold."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.contact.point_law import last_law
from blockstat.contact.tolerance import stated_length
from blockstat.errors import InputError
from blockstat.geometry.components import connected_components
from blockstat.loads import up_of
from blockstat.program.ties import tied_pairs
from blockstat.result import listed, millimetres
from blockstat.typing import Floats, Ints
from dynsim.judge.criteria import ARM, OVERTURNED, SmallBlocks, angles, default_threshold, drops, own_threshold
from dynsim.judge.run import Run
from dynsim.loads.load import Load
from dynsim.loads.loading import Removal, Settlement
from dynsim.settings import LOOKS, SHOWN, Settings

#: Blocks rock for long: after the last change of a load a run may take this many times `Settings.end`.
AFTERWARDS = 3.0
#: Blocks rest when their trend is slower than an imbalance at the resolution would have made them by this factor.
SAFE = 4.0
#: Standard errors that are added to a trend.
ERRORS = 2.0
#: Times that differ by less are equal [s].
ROUNDING = 1e-9
#: Blocks that a warning names at most.
NAMED = 5
#: A joint is upright where its normal is level to this share: that of a wall drawn to a millimetre a metre.
UPRIGHT = 1e-3
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
    return given + carried_by(assembly, loads)


def carried_by(assembly: Assembly, loads: Sequence[Load]) -> float:
    """Return how far loads move the supports.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    loads : sequence of Load
        Loads of a run.

    Returns
    -------
    float
        The largest distance of a support [m]; what several settlements do to one adds up.
    """
    carried = np.zeros(assembly.n_blocks)
    for load in loads:
        on = assembly.blocks_named(load.supports, "settlement") if isinstance(load, Settlement) else slice(None)
        carried[on] += load.travel
    return float(carried.max())


@dataclass(frozen=True, eq=False)
class Fallen:
    """Which blocks of a run have fallen, frame by frame, in arrays of shape (n_frames, n_blocks)."""

    moved: Floats  #: displacement since release of the blocks that count, shape (n_frames, n_blocks, 3) [m]
    turned: Floats  #: by which angle since release [rad]
    dropped: Floats  #: how far since built [m]
    apart: np.ndarray  #: whether through the air, by more than a joint may be open
    beyond: np.ndarray  #: whether at all
    small: Ints  #: numbers of the blocks that have fallen by thresholds of their own alone
    supports: float  #: the furthest that a support came down, at the end [m]


class Falls:
    """When blocks have fallen under some loads.

    A threshold of displacement that was asked for counts as it is, for every block. The default one is that of each
    block by its own size where this is less (see `dynsim.judge.criteria.SmallBlocks`).
    """

    def __init__(self, assembly: Assembly, interfaces: Interfaces, loads: Sequence[Load], settings: Settings) -> None:
        """Set the thresholds.

        Parameters
        ----------
        assembly : Assembly
            The blocks.
        interfaces : Interfaces
            Joints of the assembly.
        loads : sequence of Load
            Loads of the run.
        settings : Settings
            Have the thresholds that were asked for.

        Raises
        ------
        InputError
            When removals leave nothing that can move.
        """
        self.judged = stays(assembly, loads)  #: numbers of the blocks that count
        if not len(self.judged):
            raise InputError("removal: nothing that can move is left")
        self.roof = threshold_under(assembly, loads, settings.roof_threshold)  #: of Eq. 1 [m]
        self.brick = threshold_under(assembly, loads, settings.brick_threshold)  #: of Eq. 2 and of displacements [m]
        self.turn = threshold_under(assembly, loads)  #: of turns, for most blocks [m]
        self.changes, self.carried = last_change(loads) > -np.inf, carried_by(assembly, loads)
        self.own = own_threshold(assembly, self.turn - self.carried, overturns=self.changes)  #: of each block [m]
        self._assembly, self._asked = assembly, settings.brick_threshold is not None
        self._small = SmallBlocks(
            assembly, interfaces, self.own, self.carried, np.setdiff1d(assembly.free, self.judged)
        )
        self._loose = np.full(assembly.n_blocks, np.inf)
        self._loose[self.judged] = free_drop(assembly, interfaces, self.carried)[self.judged]

    def decided(self, moved: Floats, turned: Floats) -> bool:
        """Return whether a run may end. With a threshold that was asked for it goes on to that.

        Parameters
        ----------
        moved, turned : array of float, shape (n_blocks, 3)
            Displacements [m] and rotation vectors [rad] since release.

        Returns
        -------
        bool
            Whether a block has fallen.
        """
        from scipy.spatial.transform import Rotation

        moved, turned = self._counting(moved), self._counting(turned)
        if np.linalg.norm(moved, axis=1).max() >= max(self.brick, self.roof):
            return True
        if self._asked:
            return False
        if self._too_far(np.linalg.norm(turned, axis=1)).any():
            return True
        return bool(self._small.strayed(moved, Rotation.from_rotvec(turned).as_matrix()).any())

    def of(self, run: Run) -> Fallen:
        """Return which blocks of a run have fallen.

        Parameters
        ----------
        run : Run
            What is judged.

        Returns
        -------
        Fallen
            By frame.
        """
        moved = self._counting(run.since_release, axis=1)
        turned = self._counting(angles(run.rotation), axis=1)
        dropped = np.asarray(drops(self._assembly, run.displacement))
        apart = np.asarray(dropped > self._loose)
        length = np.linalg.norm(moved, axis=2)
        strayed = np.zeros_like(apart)
        for frame in () if self._asked else np.flatnonzero((length >= self.own + self.carried).any(axis=1)):
            strayed[frame] = self._small.strayed(moved[frame], run.rotation[frame] @ run.rotation[0].swapaxes(1, 2))
        most = (length >= self.brick) | (turned * ARM * self._assembly.size >= self.turn) | apart
        beyond = most | self._too_far(turned) | strayed
        small = np.flatnonzero(beyond.any(axis=0) & ~most.any(axis=0) & (self.own < self.turn - self.carried))
        supports = max(0.0, float(drops(self._assembly, run.since_release[-1, self._assembly.support]).max()))
        return Fallen(moved, turned, dropped, apart, beyond, small, supports)

    def _counting(self, values: Floats, axis: int = 0) -> Floats:
        """The values of the blocks that count, and 0 for the others."""
        counting = np.isin(np.arange(self._assembly.n_blocks), self.judged)
        return np.where(counting.reshape([-1 if k == axis else 1 for k in range(values.ndim)]), values, 0.0)

    def _too_far(self, angle: Floats) -> np.ndarray:
        """Which angles are those of a fall."""
        overturned = OVERTURNED if self.changes else np.pi
        return (angle * ARM * self._assembly.size >= self.own + self.carried) | (angle >= overturned)

    def words(self, fallen: Fallen) -> list[str]:
        """Return what must be said of a run besides its outcome.

        Parameters
        ----------
        fallen : Fallen
            Of the run.

        Returns
        -------
        list of str
            Of blocks that fell through the air, that fell by their own size alone, and that fell far and lie at rest.
        """
        names, told = self._assembly.names, list[str]()
        if fallen.apart.any():
            blocks = _named(names, np.flatnonzero(fallen.apart.any(axis=0)))
            furthest = millimetres(fallen.dropped[fallen.apart].max(), 2)
            told.append(
                f"nothing carried {blocks} as built: blocks fell through the air by up to {furthest} mm, settling "
                "included, which is more than a joint may be open"
            )
        if len(fallen.small):
            first = int(fallen.small[0])
            told.append(
                f"blocks smaller than most fell by their own thresholds: {_named(names, fallen.small)}; that of "
                f'"{names[first]}" is {millimetres(self.own[first] + self.carried, 2)} mm'
            )
        return told if fallen.beyond.any() else told + self._came_down(fallen)

    def _came_down(self, fallen: Fallen) -> list[str]:
        """What is said of blocks that came down further than supports did and than blocks at rest do."""
        low = np.asarray(drops(self._assembly, fallen.moved[-1]))
        least = own_threshold(self._assembly, default_threshold(self._assembly)) + fallen.supports
        down = np.flatnonzero(low >= least)
        if not len(down):
            return []
        down = down[np.argsort(-low[down], kind="stable")]
        first = int(down[0])
        return [
            f"{_named(self._assembly.names, down)} came down and stayed within the threshold: "
            f'"{self._assembly.names[first]}" by {millimetres(low[first], 2)} mm, '
            f"{low[first] / self._assembly.size[first]:.2g} of its size"
        ]


def _named(names: Sequence[str], blocks: Ints) -> str:
    return listed([names[int(block)] for block in blocks], NAMED)


def free_drop(assembly: Assembly, interfaces: Interfaces, carried: float = 0.0) -> Floats:
    """Return how far each block may drop that nothing carries as built.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    interfaces : Interfaces
        Joints of the assembly.
    carried : float, optional
        How far the loads themselves move what blocks touch [m].

    Returns
    -------
    array of float, shape (n_blocks,)
        The gap up to which two faces are a joint [m] where no joints and ties can carry the weight of the block to a
        support: what drops further fell through the air. Infinite for the other blocks.

    Notes
    -----
    The weight of blocks presses them on joints whose push has a component upwards, and only there. Friction holds a
    block on upright joints, or below others, where a thrust presses them, and thrust comes from weight on inclined
    joints, as in a flying arch between upright walls. So blocks that no chain carries upwards are held only where there
    is an inclined joint among them or beside them. A joint with a strength of its own carries both ways, as a tie does.
    """
    pair, up = interfaces.pair, up_of(assembly)
    push = interfaces.frame[:, 0] @ up  # of the first block of a pair on the second
    strong = np.array([law is not None and law.strong for law in last_law(assembly, interfaces)], dtype=bool)
    both = np.vstack([pair[strong], tied_pairs(assembly)])
    joined = np.vstack([pair, both])
    _, whole = connected_components(assembly.n_blocks, joined)
    touches = np.isin(whole, whole[assembly.support])
    carried_up = [pair[push > UPRIGHT], pair[push < -UPRIGHT][:, ::-1], both, both[:, ::-1]]
    held = _reached(assembly, np.vstack(carried_up))
    _, part = connected_components(assembly.n_blocks, joined[~held[joined].any(axis=1)])
    inclined = (np.abs(push) > UPRIGHT) & (np.abs(push) < np.sqrt(1 - UPRIGHT**2))
    held |= touches & np.isin(part, part[np.unique(pair[inclined])])
    length = stated_length(interfaces.searched)
    gap = np.full(assembly.n_blocks, length) if length is not None else assembly.size * float(interfaces.searched)
    return np.where(held, np.inf, gap + np.where(touches, carried, 0.0))


def _reached(assembly: Assembly, carries: Ints) -> np.ndarray:
    """Which blocks the supports carry, given pairs of one that carries and one that is carried."""
    from scipy import sparse
    from scipy.sparse.csgraph import dijkstra

    n = assembly.n_blocks
    graph = sparse.coo_array((np.ones(len(carries)), (carries[:, 0], carries[:, 1])), shape=(n, n)).tocsr()
    supports = np.flatnonzero(assembly.support)
    return np.isfinite(dijkstra(graph, indices=supports, unweighted=True, min_only=True))


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
