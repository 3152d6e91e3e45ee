"""The displacement criteria of the procedural-masonry paper, and the length of the displacement beside them.

Both equations measure displacement along gravity only: a wall that slides sideways passes them. So the length of the
displacement and the rotation count too. And both have one threshold for all blocks, within which one that is small
beside most others may topple. So a small block is also held against its own size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import known_options
from blockstat.geometry.components import connected_components
from blockstat.loads import horizontal, up_of
from blockstat.typing import Floats, Ints
from dynsim.judge.cracks import find_cracks

#: Default threshold: a thirtieth of the median block size (10 mm for blocks of 0.3 m) or a twentieth of the
#: smallest, whichever is more. Thresholds from this to five times it give the same verdicts.
MEDIAN_SHARE, SMALLEST_SHARE = 1 / 30, 1 / 20
#: Settling grows as the square of the number of courses; this share of the block size for each course squared is ten
#: times what a sound wall settles.
COURSE_SHARE = 3e-6
#: Share of its extent by which the outline of a block is drawn in where blocks on top of each other are looked for.
BESIDE = 1e-3
#: Where loads change, blocks rock and slide. One that has turned by more than this has another face down than before.
OVERTURNED = np.pi / 4
#: A block has turned too far when a point at half its size from its centre has moved by its threshold.
ARM = 0.5


def default_threshold(assembly: Assembly) -> float:
    """Return the displacement that counts as falling.

    Parameters
    ----------
    assembly : Assembly
        The blocks; supports do not count.

    Returns
    -------
    float
        Displacement [m].
    """
    size = assembly.size[~assembly.support]
    return float(max(np.median(size) * MEDIAN_SHARE, size.min() * SMALLEST_SHARE) + _settling(assembly))


def own_threshold(assembly: Assembly, most: float, *, overturns: bool = False) -> Floats:
    """Return the displacement that counts as falling for each block by its own size.

    Parameters
    ----------
    assembly : Assembly
        The blocks; supports have thresholds that do not count.
    most : float
        The threshold of any block [m].
    overturns : bool, optional
        Whether blocks may rock and slide, as under loads that change: their size counts then, not a twentieth of it.

    Returns
    -------
    array of float, shape (n_blocks,)
        Displacement [m]: what alone the block would have for its threshold, and no more than that of any block.
    """
    own = assembly.size if overturns else assembly.size * SMALLEST_SHARE + _settling(assembly)
    return np.minimum(own, most)


def _settling(assembly: Assembly) -> float:
    """What is allowed for the settling of the courses [m]."""
    return float(np.median(assembly.size[~assembly.support]) * COURSE_SHARE * courses(assembly) ** 2)


@dataclass(frozen=True, eq=False)
class SmallBlocks:
    """Which blocks have gone further than their own thresholds, and not with others that have not.

    Notes
    -----
    A small block on a large one goes where that goes, which may be further than the threshold of the small one and is
    no fall. So two blocks go together while their joint has opened and slid by less than the smaller of their
    thresholds. A block beyond its own has fallen when it does not go together, through any number of joints, with a
    support or with a block within its own threshold. Turns need no such rule: what goes together turns together, and
    the larger of two blocks has fallen at the smaller angle.
    """

    assembly: Assembly
    interfaces: Interfaces  #: joints of the assembly
    own: Floats  #: threshold of each block, shape (n_blocks,) [m]
    carried: float = 0.0  #: what loads move themselves [m]
    gone: Ints | None = None  #: blocks that are not there

    def strayed(self, moved: Floats, rotation: Floats) -> np.ndarray:
        """Return which blocks have fallen by their own thresholds.

        Parameters
        ----------
        moved : array of float, shape (n_blocks, 3)
            Displacements [m].
        rotation : array of float, shape (n_blocks, 3, 3)
            Rotations.

        Returns
        -------
        array of bool, shape (n_blocks,)
            Supports never have.
        """
        far = (np.linalg.norm(moved, axis=1) >= self.own + self.carried) & ~self.assembly.support
        if not far.any():
            return far
        still = np.zeros_like(moved), np.tile(np.eye(3), (len(moved), 1, 1))
        joints = find_cracks(self.assembly, still, (moved, rotation), interfaces=self.interfaces, removed=self.gone)
        least = np.where(self.assembly.support, np.inf, self.own)[joints.pair].min(axis=1)
        together = joints.pair[np.maximum(joints.opening, joints.slip) < least]
        _, part = connected_components(len(far), together)
        return far & ~np.isin(part, part[~far])


def courses(assembly: Assembly) -> float:
    """Return how many blocks lie on top of each other.

    Parameters
    ----------
    assembly : Assembly
        The blocks; supports do not count.

    Returns
    -------
    float
        Of the free blocks above and below one, seen along gravity, their height over the mean height of one of them;
        the most for any block.
    """
    from shapely import STRtree, box

    axes = np.vstack([horizontal(assembly), -up_of(assembly)])
    along = assembly.vertices @ axes.T
    low = np.minimum.reduceat(along, assembly.vertex_start[:-1])[~assembly.support]
    high = np.maximum.reduceat(along, assembly.vertex_start[:-1])[~assembly.support]
    aside = BESIDE * (high - low)  # blocks side by side share no more than an edge of their outlines
    outlines = box(*(low + aside)[:, :2].T, *(high - aside)[:, :2].T)
    one, other = STRtree(outlines).query(outlines, predicate="intersects")
    lowest, highest = low[:, 2].copy(), high[:, 2].copy()
    np.minimum.at(lowest, one, low[other, 2])
    np.maximum.at(highest, one, high[other, 2])
    mean = np.bincount(one, (high - low)[other, 2]) / np.bincount(one)
    return float(((highest - lowest) / mean).max())


@known_options
def drops(assembly: Assembly, displacement: Floats) -> Floats:
    """Return how far each block went down (Eq. 2).

    Parameters
    ----------
    assembly : Assembly
        Its gravity says what is down.
    displacement : array of float, shape (..., 3)
        Displacements [m].

    Returns
    -------
    array of float, shape (...)
        Component along gravity [m], positive downwards.

    Examples
    --------
    >>> import numpy as np
    >>> from blockstat import Assembly, box
    >>> from dynsim import drops
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> drops(pillar, np.array([[0.0, 0.0, 0.0], [0.2, 0.0, -0.1]])).tolist()
    [0.0, 0.1]
    """
    return displacement @ -up_of(assembly)


@known_options
def group_box_centre(assembly: Assembly, blocks: Ints, displacement: Floats, rotation: Floats) -> Floats:
    """Return the centre of the bounding box of some blocks as they lie now (Eq. 1).

    Parameters
    ----------
    assembly : Assembly
        The blocks as built.
    blocks : array of int
        Numbers of the blocks of the group.
    displacement : array of float, shape (n_blocks, 3)
        Displacement of the centroids since built [m].
    rotation : array of float, shape (n_blocks, 3, 3)
        Rotation since built.

    Returns
    -------
    array of float, shape (3,)
        Centre of the box [m].

    Examples
    --------
    >>> import numpy as np
    >>> from blockstat import Assembly, box
    >>> from dynsim import group_box_centre
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> still, upright = np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
    >>> group_box_centre(pillar, np.array([1]), still, upright).tolist()
    [0.25, 0.25, 1.0]
    """
    block = np.repeat(np.arange(assembly.n_blocks), np.diff(assembly.vertex_start))
    corner = np.flatnonzero(np.isin(block, blocks))
    owner = block[corner]
    arm = assembly.vertices[corner] - assembly.centroid[owner]
    moved = np.einsum("nij,nj->ni", rotation[owner], arm) + assembly.centroid[owner] + displacement[owner]
    return (moved.min(axis=0) + moved.max(axis=0)) / 2


def angles(rotation: Floats) -> Floats:
    """Return the angle by which each block has turned since the first frame.

    Parameters
    ----------
    rotation : array of float, shape (n_frames, n_blocks, 3, 3)
        Rotation matrices.

    Returns
    -------
    array of float, shape (n_frames, n_blocks)
        Angles [rad].

    Notes
    -----
    The distance of two rotation matrices is 2 sqrt(2) sin(angle / 2), which is exact for small angles too.
    """
    difference = np.linalg.norm(rotation - rotation[0], axis=(2, 3))
    return 2 * np.arcsin(np.minimum(difference / (2 * np.sqrt(2)), 1.0))


def rate(times: Floats, displacement: Floats, window: float, since: float = 0.0) -> float:
    """Return the speed of the fastest block at the end of a run.

    Parameters
    ----------
    times : array of float, shape (n_frames,)
        Times [s].
    displacement : array of float, shape (n_frames, n_blocks, 3)
        Displacements [m].
    window : float
        Time over which the speed is taken [s].
    since : float
        Time from which on motion counts [s], such as the end of the loads: what they carry is no creep. A run that
        ended before has the speed of its last window.

    Returns
    -------
    float
        Speed [m/s].

    Notes
    -----
    Shaking is no creep. Over a third of the time that counts, if that is longer than the window, it averages out, so
    the smaller of the two speeds counts.
    """
    first = int(np.searchsorted(times, since * (1 - 1e-9)))
    first = first if first < len(times) - 1 else 0

    def over(duration: float) -> float:
        frame = max(int(np.searchsorted(times, times[-1] - duration * (1 + 1e-9))), first)
        if frame >= len(times) - 1:
            return 0.0
        moved = np.linalg.norm(displacement[-1] - displacement[frame], axis=1)
        return float(moved.max() / (times[-1] - times[frame]))

    return min(over(window), over(max(window, (times[-1] - times[first]) / 3)))
