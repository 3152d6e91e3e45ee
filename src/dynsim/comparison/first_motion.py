"""How far Bullet starts to move the way the static mechanism says."""

from __future__ import annotations

import numpy as np

from blockstat.analysis.verdict import Verdict
from blockstat.typing import Floats
from dynsim.judge.criteria import ARM
from dynsim.judge.run import Run
from dynsim.judge.verdict import DynamicVerdict

#: The first motion is looked at when the fastest block has gone this part of the threshold, a three-hundredth of a
#: block by default: far above what the solver trembles, and the joints are still where they were built.
EARLY = 0.1


def first_motion_cosine(static: Verdict, dynamic: DynamicVerdict) -> float | None:
    """Return the cosine between the static mechanism and Bullet's first motion.

    Parameters
    ----------
    static : Verdict
        Its mechanism counts.
    dynamic : DynamicVerdict
        Of the same assembly; its run counts.

    Returns
    -------
    float or None
        1 for the same motion, 0 for unrelated ones; None where one of them does not move.

    Notes
    -----
    The scalar product of two fields of twists is that of kinetic energy, the sum over free blocks of m v.v' + w.I w'.
    Heavy blocks count for more, and rotations are weighed by the size of the block. Bullet's field is how far each
    block has moved and turned since release, at the first look at which one has moved by `EARLY` thresholds.

    Examples
    --------
    A pillar under too much sideways gravity tips in Bullet as its mechanism says.

    >>> from blockstat import Assembly, assess, box
    >>> from dynsim import first_motion_cosine, verify
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"], gravity=(3.0, 0.0, -9.81))
    >>> first_motion_cosine(assess(pillar), verify(pillar)) > 0.95
    True
    """
    frame = _early(dynamic.run, EARLY * dynamic.brick_threshold)
    if frame is None:
        return None
    static_motion, bullet_motion = static.mechanism, _moved(dynamic.run, frame)
    size = np.sqrt(_product(static, static_motion, static_motion) * _product(static, bullet_motion, bullet_motion))
    return float(_product(static, static_motion, bullet_motion) / size) if size > 0 else None


def _moved(run: Run, frame: int) -> Floats:
    """Displacement [m] and rotation vector [rad] of each block since release, shape (n_blocks, 6)."""
    from scipy.spatial.transform import Rotation

    turned = run.rotation[frame] @ run.rotation[0].swapaxes(1, 2)
    return np.hstack([run.since_release[frame], Rotation.from_matrix(turned).as_rotvec()])


def _early(run: Run, far: float) -> int | None:
    """First frame at which a free block has moved or turned by some distance [m]; None if none ever does."""
    free = run.assembly.free
    for frame in range(1, len(run.times)):
        moved = _moved(run, frame)[free]
        turned = ARM * run.assembly.size[free] * np.linalg.norm(moved[:, 3:], axis=1)
        if np.maximum(np.linalg.norm(moved[:, :3], axis=1), turned).max(initial=0.0) >= far:
            return frame
    return None


def _product(static: Verdict, first: Floats, second: Floats) -> float:
    """Of two fields of twists, shape (n_blocks, 6) each."""
    assembly, free = static.assembly, static.assembly.free
    a, b = first[free], second[free]
    moving = np.einsum("n,ni,ni->", assembly.mass[free], a[:, :3], b[:, :3])
    turning = np.einsum("ni,nij,nj->", a[:, 3:], assembly.inertia[free], b[:, 3:])
    return float(moving + turning)
