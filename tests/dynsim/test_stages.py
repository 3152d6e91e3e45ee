"""Which runs stand behind a verdict, and when motion counts as rest."""

import numpy as np
import pytest

from dynsim import Settings
from dynsim.loaded import Calm
from dynsim.stages import chain, stages
from problems import arch, stack


@pytest.mark.parametrize("n", [9, 40])
def test_a_chain_ends_at_the_crown(n):
    # The block furthest from both springers has half of the joints, rounded up, to cross.
    assert chain(arch(n, 0.15)) == (n + 1) // 2
    assert chain(stack(n)) == n


def test_a_stand_is_believed_at_one_step_and_a_fall_checked_at_two_others():
    found = stages(arch(100, 0.15), Settings())
    assert found.check and found.fine
    assert found.check.time_step > found.first.time_step > found.fine.time_step
    assert found.fine.iterations == 2 * found.first.iterations == 200
    alone = stages(stack(3), Settings.named("fast"))
    assert alone.check is None and alone.fine is None


def watched(position, distance=0.02, small=0.1):
    """When motion along x, looked at every 20 ms, first counts as rest; None if it never does in 3 s."""
    calm = Calm(distance, 0.5, small)
    for k in range(151):
        if calm.since(0.02 * k, np.array([[position(0.02 * k), 0.0, 0.0]])):
            return 0.02 * k
    return None


def test_motion_that_dies_away_is_rest_and_motion_that_grows_is_not():
    assert watched(lambda t: 0.0) == pytest.approx(0.5, abs=0.05)
    assert watched(lambda t: 0.09 * (1 - np.exp(-t))) is not None
    assert watched(lambda t: 0.05 * t) is None  # creeps
    assert watched(lambda t: 0.03 * (1 + t) ** 2) is None  # accelerates
