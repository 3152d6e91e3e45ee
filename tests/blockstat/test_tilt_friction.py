"""Tilts of scenes without symmetry: each way has its own limit, in closed form."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import JointLaw, Outcome, assess, tilt_limit
from blockstat.analysis.tilt_friction import _halve
from evidence.scenes.small import assembly, box

#: By a tilt about y gravity leans towards -x, about -y towards +x.
AXES = {"y": (0, 1, 0), "-y": (0, -1, 0)}


def leaning_pair(tension):
    """Two unit cubes, the upper one half a metre towards +x, in joints that do not slide."""
    blocks = [box((-3, -3, -1), (3, 3, 0)), box((0, 0, 0), (1, 1, 1)), box((0.5, 0, 1), (1.5, 1, 2))]
    return assembly(blocks, friction=9.0, joints=[JointLaw(("*", "*"), tension=tension)] if tension else [])


def least_angle(*cases):
    """Least a of `height sin a = arm cos a + held` [deg]."""
    return min(
        math.degrees(math.atan2(arm, height) + math.asin(held / math.hypot(height, arm))) for height, arm, held in cases
    )


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("tension", [0.0, 2.0])
def test_a_leaning_pair_tilts_further_one_way(axis, tension):
    # (height, arm) of the weight about the edge it tips over, and the moment of two corners that pull with a quarter of
    # the strength of their joint each: of the upper cube on half its face, and of both cubes on the ground.
    arms = (0.0, 0.5) if axis == "-y" else (0.5, 1.5)
    expected = least_angle((0.5, arms[0], 2 * tension * 0.5 / 4 * 0.5), (2.0, arms[1], 2 * tension / 4))
    asm = leaning_pair(tension)
    found = tilt_limit(asm, AXES[axis])
    assert found.stands == pytest.approx(expected, abs=1e-4)
    assert found.falls == pytest.approx(expected, abs=1e-4)
    for degrees, outcome in ((expected - 0.01, Outcome.STABLE), (expected + 0.01, Outcome.UNSTABLE)):
        turn = Rotation.from_rotvec(math.radians(degrees) * np.array(AXES[axis]))
        assert assess(asm, gravity=turn.apply(asm.gravity)).outcome is outcome


@pytest.mark.parametrize(("stands", "falls"), [(0.0, 1.0), (1.0, 0.0)])
def test_a_bisection_ends_where_a_verdict_is_undecided(stands, falls):
    def outcome(value):
        if abs(value - 0.3) < 0.1:
            return Outcome.UNDECIDED
        return Outcome.STABLE if (value < 0.3) == (stands < falls) else Outcome.UNSTABLE

    found = _halve(outcome, stands, falls)
    assert found == ((0.0, 0.5) if stands < falls else (0.5, 0.0))  # a quarter is undecided
    sure = _halve(lambda value: Outcome.STABLE if value < 0.3 else Outcome.UNSTABLE, 0.0, 1.0, 1e-3)
    assert sure[0] < 0.3 <= sure[1] <= sure[0] + 1e-3
