"""Analyses that rest on joints that are hardly there say so, and what they find without them.

Expected values are those of hand statics without the joint, or of the drawing without noise.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Tie,
    assess,
    box,
    friction_limit,
    moving_load,
    settle,
    settlement,
    thrust_range,
    tie_range,
    tilt_limit,
)
from blockstat.model.solids import prism

LIP = 1e-4  #: width of a bearing that is hardly there [m]


def plank(*, bed=1.5, low=0.0, **options):
    """A plank 2 m long whose right end bears on a lip, and its left part on a bed that is a little too low."""
    blocks = [
        box((0, 0, -1), (bed, 1, -low), name="bed"),
        box((2 - LIP, 0, -1), (3, 1, 0), name="post"),
        box((0, 0, 0), (2, 1, 0.5), name="plank"),
    ]
    return Assembly.from_blocks(blocks, supports=["bed", "post"], density=1000.0, gravity=(0, 0, -10), **options)


WEIGHT = 1e4  #: of the plank [N]


def told(found):
    """What is said of doubtful joints."""
    return [text for text in found.warnings if " only with joints " in text]


def test_a_tilt_says_what_it_is_without_a_lip():
    """Towards the lip the plank tips about it, 1 m from its centroid, or about the bed, 0.5 m from it."""
    found = tilt_limit(plank(friction=9.0), (0, -1, 0))
    assert found.stands == pytest.approx(math.degrees(math.atan(1 / 0.25)), rel=1e-4)
    (text,) = told(found)
    without = float(text.split("without them it is ")[1].removesuffix(" deg"))
    assert without == pytest.approx(math.degrees(math.atan(0.5 / 0.25)), rel=1e-4)
    assert not told(tilt_limit(plank(friction=9.0), "y"))


def upright(outline, depth, name):
    """A prism over an outline in the plane of x and z."""
    ends = [np.insert(outline, 1, y, axis=1) for y in (0.0, depth)]
    return prism(*ends, name=name)


@pytest.mark.parametrize(("seed", "axis"), [(0, (0, -1, 0)), (3, (0, 1, 0)), (5, (0, 1, 0))])
def test_the_tilt_of_a_noisy_drawing_names_that_of_the_exact_one(seed, axis):
    """A wall of 4 by 4 skewed stones in stack bond: where four meet, noise makes joints of two that only touch."""
    random, noise = np.random.default_rng(0), np.random.default_rng(seed)
    corner = np.array([[[0.6 * i, 0.4 * k] for k in range(5)] for i in range(5)])
    corner[1:-1, 1:-1] += 0.05 * random.uniform(-1, 1, (3, 3, 2))
    ground = [(-1, -0.3), (3.4, -0.3), (3.4, 0), (-1, 0)]
    outlines = [corner[[i, i + 1, i + 1, i], [k, k, k + 1, k + 1]] for i in range(4) for k in range(4)]
    blocks = [upright(ground, 1.0, "ground"), *(upright(own, 0.4, f"b{n}") for n, own in enumerate(outlines))]
    moved = [replace(own, vertices=own.vertices + noise.uniform(-1e-5, 1e-5, own.vertices.shape)) for own in blocks]
    exact, noisy = (Assembly.from_blocks(own, supports=["ground"], friction=0.6) for own in (blocks, moved))
    right, found = tilt_limit(exact, axis).stands, tilt_limit(noisy, axis)
    assert found.stands > 1.003 * right
    (text,) = told(found)
    assert float(text.split("without them it is ")[1].split()[0]) == pytest.approx(right, rel=1e-3)


def test_a_friction_says_what_it_is_without_a_stop():
    """On a slope of 20 degrees a stop of a tenth of a millimetre holds a block without friction."""
    blocks = [
        box((-1, -1, -1), (1, 2, 0), name="ground"),
        box((1, 0, -1), (2, 1, LIP), name="stop"),
        box((0, 0, 0), (1, 1, 0.5), name="block"),
    ]
    slope = [math.sin(math.radians(20)), 0, -math.cos(math.radians(20))]
    found = friction_limit(Assembly.from_blocks(blocks, supports=["ground", "stop"], gravity=slope))
    (text,) = told(found)
    assert found.stands == 0.0
    assert float(text.split("without them it is ")[1]) == pytest.approx(math.tan(math.radians(20)), rel=1e-4)


@pytest.mark.parametrize("low", [0.0, 0.004])
def test_a_thrust_says_what_it_is_without_a_lip(low):
    """The lip may take half of the weight, with the plank on the far edge of its bed. Without it the bed takes all.

    A bed that is too low for the plank does not quite close. It is left out only after the lip, and said of by itself.
    """
    found = thrust_range(plank(low=low, friction=0.5), ["bed"], (0, 0, -1))
    (text,) = told(found)
    assert (found.least, found.greatest) == pytest.approx((WEIGHT / 2, WEIGHT), rel=1e-3)
    assert 'narrower than 0.001 of their smaller block: "post" to "plank"; without them it lies between' in text
    low_end, high_end = text.split("without them it lies between ")[1].split(" N and ")
    assert (float(low_end), float(high_end.split(" N")[0])) == pytest.approx((WEIGHT, WEIGHT), rel=1e-4)
    rest = ', and without joints that do not quite close: "bed" to "plank" either it is not proven stable'
    assert text.endswith(rest) is bool(low)


def test_a_lift_of_a_lip_says_what_it_is_without_it():
    """Half of the plank resists as its end rises, and nothing where nothing rests on the support."""
    found = settlement(plank(friction=0.5), ["post"], (0, 0, 1))
    (text,) = told(found)
    assert found.reaction == pytest.approx(-WEIGHT / 2, rel=1e-3)
    assert text.endswith("without them it is 0 N")
    (text,) = told(settle(plank(friction=0.5), {"post": (0, 0, 0.01)}))
    assert text.endswith("without them it is not known")  # nothing is left on the part that moves
    assert not told(settle(plank(friction=0.5), {"post": (0, 0, -0.01)}))  # the plank stays on its bed


def test_a_tie_says_what_it_must_pull_without_a_lip():
    """The plank on a bed of 0.5 m tips about its edge, and the tie has an arm of half the root of two to that."""
    tie = Tie(("bed", "plank"), ((-0.5, 0.5, 0), (0, 0.5, 0.5)))
    found = tie_range(plank(bed=0.5, ties=[tie], friction=2.0))
    (text,) = told(found)
    assert found.least == pytest.approx(0.0, abs=1e-3 * WEIGHT)
    without = text.split("without them it lies between ")[1].split(" N")[0]
    assert float(without) == pytest.approx(WEIGHT * 0.5 / math.sqrt(0.5), rel=1e-3)


def test_a_moving_load_says_what_it_is_without_a_lip():
    """Without the lip, a wheel of 1 kN at the end of the plank tips it about its bed: both arms are 0.5 m."""
    for only_worst in (False, True):
        path = [(0, 0.5, 0.5), (2, 0.5, 0.5)]
        found = moving_load(plank(friction=0.5), [(0, 1e3)], path, positions=5, only_worst=only_worst)
        (text,) = told(found)
        assert float(text.split("without them it is ")[1]) == pytest.approx(WEIGHT / 1e3, rel=2e-3)


def test_wide_joints_that_close_are_not_said_of():
    blocks = [box((-1, -1, -1), (3, 2, 0), name="bed"), box((0, 0, 0), (2, 1, 0.5), name="plank")]
    asm = Assembly.from_blocks(blocks, supports=["bed"], friction=0.5)
    answers = [tilt_limit(asm, "y"), friction_limit(asm), thrust_range(asm, ["bed"], (0, 0, -1)), assess(asm)]
    assert not any(told(found) for found in answers)
