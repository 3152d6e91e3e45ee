"""Whether macro-blocks hold: the limit state of all blocks against that of the macro-blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.large_displacement.displaced.pose import displaced_assembly
from blockstat.large_displacement.finite_steps.trial_state import (
    RIGID_JOINT_SPEEDS,
    TrialState,
    limit_state_of_blocks,
    with_limit_state,
)
from blockstat.large_displacement.statics.limit_state import LimitState
from blockstat.large_displacement.statics.macro_blocks import common_refinement, macro_blocks_of

#: Macro-blocks hold where the multiplier of all blocks is smaller by this part at most. Chosen as a difference that an
#: engineer accepts.
MAX_MULTIPLIER_LOSS = 0.01
#: Blocks fall on their own where their fastest corner moves faster than this in a fall of all blocks. Relative to the
#: fastest. Chosen: the next is tried where macro-blocks without them still carry, then each block is one.
FALLING_SPEEDS = (0.1, 0.01, 1e-3)


def with_macro_blocks_that_hold(trial: TrialState) -> tuple[TrialState, LimitState]:
    """Return a trial state whose macro-blocks hold, and the limit state of its blocks.

    Parameters
    ----------
    trial
        The trial state.

    Returns
    -------
    trial : TrialState
        With smaller macro-blocks where those of the given one do not hold.
    limit : LimitState
        Of all blocks.
    """
    smaller = iter(RIGID_JOINT_SPEEDS)
    while trial.macro_blocks is not None and trial.limit.multiplier is not None:
        found = limit_state_of_blocks(trial)
        if found.multiplier is None:
            return _with_falling_blocks(trial, found)
        if found.multiplier >= (1.0 - MAX_MULTIPLIER_LOSS) * trial.limit.multiplier:
            return trial, found
        speed = next(smaller, None)
        blocks = None if speed is None else macro_blocks_of(trial.configuration, found.mechanism, speed)
        trial = with_limit_state(trial, found.mechanism, blocks)
    return trial, trial.limit


def _with_falling_blocks(trial: TrialState, found: LimitState) -> tuple[TrialState, LimitState]:
    """A trial state with macro-blocks from which those blocks are taken that fall within them."""
    assert trial.macro_blocks is not None
    speed = corner_speed(displaced_assembly(trial.linkage.assembly, trial.pose), found.mechanism)
    for share in FALLING_SPEEDS:
        falls = speed > share * speed.max()
        alone = np.where(falls, np.arange(len(falls)), -1)
        trial = with_limit_state(trial, trial.limit.mechanism, common_refinement(trial.macro_blocks, alone))
        if trial.limit.multiplier is None or trial.macro_blocks is None:
            return trial, trial.limit
    return replace(trial, limit=found, macro_blocks=None), found
