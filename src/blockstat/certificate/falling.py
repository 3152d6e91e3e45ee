"""Blocks that fall freely from joints that nothing has pressed: a proof that only self-stress holds them.

Let a set F of free blocks accelerate by g and all others be in equilibrium without forces of F. Between two blocks of F
nothing moves. A contact of a block of F with another, normal n away from F, closes where `n'g > 0`. If none does, zero
forces at all contacts of F satisfy the equations of motion, unilateral contact and Coulomb's law. So F falls, and no
force that this motion makes resists it. Equilibrium needs a thrust that was there before, as of a block that is clamped
between two others. Whether the others rest without F is another question, which `blockstat.analysis.assess` asks:
others that lean on F press on it. A state in joints that give way may exist all the same, as others may clamp F then.

The union of two such sets is one. The largest remains when all blocks are taken away that press on a support, on what
presses on one, and so on. No program is solved, and friction plays no part.
"""

from __future__ import annotations

import numpy as np

from blockstat.contact.interfaces import Interfaces
from blockstat.typing import Floats, Ints

#: Cosine of the angle between a normal and the horizontal below which a joint is vertical: normals of files in single
#: precision are right to 1e-7.
VERTICAL = 1e-6


def falling_blocks(support: np.ndarray, interfaces: Interfaces, down: Floats, tied: Ints) -> Ints:
    """Find the largest set of blocks that may fall freely.

    Parameters
    ----------
    support
        Which blocks cannot move, shape (n_blocks,).
    interfaces
        The joints, with all contacts that may carry a force.
    down
        Direction of gravity, a unit vector.
    tied
        Numbers of the interfaces that may carry tension, and hold on both sides.

    Returns
    -------
    Ints
        Numbers of blocks, ascending; empty where every block presses on something that a support carries.
    """
    along = interfaces.frame[:, 0] @ down
    fixed = np.isin(np.arange(interfaces.n_interfaces), tied)
    rests = np.concatenate(
        [interfaces.pair[(along > VERTICAL) | fixed], interfaces.pair[(along < -VERTICAL) | fixed][:, ::-1]]
    )
    carried = np.array(support, dtype=bool)
    while True:
        new = carried.copy()
        new[rests[carried[rests[:, 1]], 0]] = True
        if (new == carried).all():
            return np.flatnonzero(~carried)
        carried = new
