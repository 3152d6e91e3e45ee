"""Loads that are couples, alone and beside forces however small."""

import numpy as np
import pytest

from blockstat import Assembly, LoadOutcome, Outcome, assess, box, limit_load, point_load

GROUND, CUBE = box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube")
CEILING = box((-1, -1, 1), (2, 2, 2), name="ceiling")
WEIGHT, FRICTION = 9810.0, 0.5


def scene(*more, supports=("ground",)):
    return Assembly.from_blocks([GROUND, CUBE, *more], supports=supports, density=1000.0, friction=FRICTION)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_three_forces_around_a_cube_turn_it_about_its_axis(tolerance):
    # Their sum is rounding. A corner carries a quarter of the weight and rubs at half a diagonal.
    asm, angles = scene(), 0.3 + 2 * np.pi * np.arange(3) / 3
    out = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    turn = sum(point_load(asm, "cube", (0.5, 0.5, 1) + 0.4 * r, 1e3 * np.cross((0, 0, 1), r)) for r in out)
    found = limit_load(asm, turn, tolerance=tolerance)
    assert found.outcome is LoadOutcome.LIMIT
    assert (found.lower, found.upper) == pytest.approx((FRICTION * WEIGHT * 0.5**0.5 / 1200,) * 2, rel=1e-6)


@pytest.mark.parametrize("force", [0.0, 1e-9, 1e-6, 1e-3, 1.0])
def test_a_couple_tips_a_cube_whatever_small_force_is_beside_it(force):
    # About its edge: 1000 N m and the force at half the height, against the weight on half the width.
    load = np.zeros((2, 6))
    load[1, [0, 4]] = force, 1000.0
    found = limit_load(scene(), load)
    assert found.outcome is LoadOutcome.LIMIT
    assert (found.lower, found.upper) == pytest.approx((WEIGHT / 2 / (1000.0 + force / 2),) * 2, rel=1e-6)


@pytest.mark.parametrize("gravity", [9.81, 1e-3, 1e-6, 1e-9, 1e-12])
def test_a_couple_between_floor_and_ceiling_is_carried_whatever_the_weight(gravity):
    # A pair of vertical forces at the edges of 1 m carries it.
    loads = np.zeros((3, 6))
    loads[1, 4] = 100.0
    verdict = assess(scene(CEILING, supports=("ground", "ceiling")), gravity=(0, 0, -gravity), loads=loads)
    assert verdict.outcome is Outcome.STABLE
