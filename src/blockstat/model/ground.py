"""The fixed slab that a building stands on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.assembly import Block
from blockstat.model.solids import box

GROUND_MARGIN = 1.0  #: [m] around everything
GROUND_DEPTH = 0.5  #: [m]


def ground(blocks: Sequence[Block]) -> Block:
    """A slab with its top at z = 0 that reaches beyond all the blocks.

    Parameters
    ----------
    blocks : sequence of Block
        What stands on it.

    Returns
    -------
    Block
        Of the name and group "ground".
    """
    plan = np.concatenate([block.vertices for block in blocks])[:, :2]
    lower, upper = plan.min(axis=0) - GROUND_MARGIN, plan.max(axis=0) + GROUND_MARGIN
    return box((*lower, -GROUND_DEPTH), (*upper, 0.0), name="ground", group="ground")  # type: ignore[arg-type]
