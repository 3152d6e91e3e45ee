"""The displacement criteria of the procedural-masonry paper, and the full displacement beside them.

Both equations look down (along gravity) only: a wall that slides sideways passes them. So the length of the
displacement and the rotation are judged too.
"""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.typing import Floats, Ints

#: Default threshold: a thirtieth of the median block size (10 mm for blocks of 0.3 m) or a twentieth of the
#: smallest, whichever is more. Thresholds from this to five times it give the same verdicts.
MEDIAN_SHARE, SMALLEST_SHARE = 1 / 30, 1 / 20
#: Settling grows as the square of the number of courses; this share of the block size for each course squared is ten
#: times what a sound wall settles.
COURSE_SHARE = 3e-6
#: A block has turned too far when a point at half its size from its centre has moved by the threshold.
ARM = 0.5


def default_threshold(assembly: Assembly) -> float:
    """Displacement that counts as falling [m]."""
    size = assembly.size[~assembly.support]
    tall = np.median(size) * COURSE_SHARE * courses(assembly) ** 2
    return float(max(np.median(size) * MEDIAN_SHARE, size.min() * SMALLEST_SHARE) + tall)


def courses(assembly: Assembly) -> float:
    """How many blocks are on top of each other: height of the free blocks over the median height of one."""
    free = ~assembly.support
    along = assembly.vertices @ (assembly.gravity / np.linalg.norm(assembly.gravity))
    low = np.minimum.reduceat(along, assembly.vertex_start[:-1])[free]
    high = np.maximum.reduceat(along, assembly.vertex_start[:-1])[free]
    return float((high.max() - low.min()) / np.median(high - low))


def drops(assembly: Assembly, displacement: Floats) -> Floats:
    """Eq. 2: how far each block went down along gravity [m]; displacement : shape (..., n_blocks, 3)."""
    return displacement @ (assembly.gravity / np.linalg.norm(assembly.gravity))


def group_box_centre(assembly: Assembly, blocks: Ints, displacement: Floats, rotation: Floats) -> Floats:
    """Eq. 1: centre of the bounding box of some blocks as they lie now, shape (3,) [m]."""
    block = np.repeat(np.arange(assembly.n_blocks), np.diff(assembly.vertex_start))
    corner = np.flatnonzero(np.isin(block, blocks))
    owner = block[corner]
    arm = assembly.vertices[corner] - assembly.centroid[owner]
    moved = np.einsum("nij,nj->ni", rotation[owner], arm) + assembly.centroid[owner] + displacement[owner]
    return (moved.min(axis=0) + moved.max(axis=0)) / 2


def angles(rotation: Floats) -> Floats:
    """Angle by which each block has turned since the first frame [rad]; rotation : shape (n_frames, n, 3, 3).

    From the distance between the two matrices, 2 sqrt(2) sin(angle / 2), which is exact for small angles too.
    """
    apart = np.linalg.norm(rotation - rotation[0], axis=(2, 3))
    return 2 * np.arcsin(np.minimum(apart / (2 * np.sqrt(2)), 1.0))


def rate(times: Floats, displacement: Floats, window: float) -> float:
    """Speed of the fastest block at the end of a run [m/s], by where it was a window [s] before.

    displacement : shape (n_frames, n, 3) [m]. Shaking is no creep: over a third of the run, if that is longer, it
    averages out, so the slower of the two counts.
    """

    def over(duration: float) -> float:
        frame = max(int(np.searchsorted(times, times[-1] - duration * (1 + 1e-9))), 0)
        if frame >= len(times) - 1:
            return 0.0
        moved = np.linalg.norm(displacement[-1] - displacement[frame], axis=1)
        return float(moved.max() / (times[-1] - times[frame]))

    return min(over(window), over(max(window, times[-1] / 3)))
