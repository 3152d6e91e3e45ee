"""The displacement criteria of the procedural-masonry paper, and the full displacement beside them.

Both equations look down (along gravity) only: a wall that slides sideways passes them. So the length of the
displacement is judged too.
"""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.polyhedron import Floats, Ints

#: Default threshold: a thirtieth of the median block size (10 mm for blocks of 0.3 m) or a twentieth of the
#: smallest, whichever is more. Thresholds from this to five times it give the same verdicts.
MEDIAN_SHARE, SMALLEST_SHARE = 1 / 30, 1 / 20


def default_threshold(assembly: Assembly) -> float:
    """Displacement that counts as falling [m]."""
    size = assembly.size[~assembly.support]
    return float(max(np.median(size) * MEDIAN_SHARE, size.min() * SMALLEST_SHARE))


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
