"""The cosine of the static mechanism with Bullet's first motion."""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import assess
from dynsim import first_motion_cosine, verify
from evidence.scenes.small import arch, assembly, box, stack

MOVES = {
    "a block tips": lambda: stack(1, 0.5, 2.0, gravity=(0.4, 0, -1)),
    "a thin arch opens hinges": lambda: arch(12, 0.08),
    "a block falls freely": lambda: assembly([box((0, 0, 0), (1, 1, 1)), box((3, 0, 5), (4, 1, 6))]),
}


@pytest.mark.parametrize("name", list(MOVES))
def test_a_motion_with_one_freedom_begins_as_the_mechanism(name):
    scene = MOVES[name]()
    static, dynamic = assess(scene), verify(scene)
    assert first_motion_cosine(static, dynamic) == pytest.approx(1, abs=0.01)
    assert first_motion_cosine(replace(static, mechanism=-3 * static.mechanism), dynamic) == pytest.approx(-1, abs=0.01)


@pytest.mark.parametrize("friction", [0.3, 0.7])
def test_a_block_that_slides_does_so_without_the_lift_of_associated_flow(friction):
    # The mechanism lifts it at the rate of friction, so the angle between the two is that of friction.
    scene = stack(1, 2.0, 0.2, gravity=(0.9, 0.3, -1), friction=friction)
    assert first_motion_cosine(assess(scene), verify(scene)) == pytest.approx(1 / np.hypot(1, friction), abs=0.005)


def test_an_unrelated_motion_has_none_of_it():
    scene = stack(1, 2.0, 0.2, gravity=(0.9, 0, -1))
    aside = np.zeros((2, 6))
    aside[1, 1] = 1.0
    assert first_motion_cosine(replace(assess(scene), mechanism=aside), verify(scene)) == pytest.approx(0, abs=0.01)


def test_units_do_not_matter():
    scene = arch(12, 0.08)
    large = scene.with_(vertices=1e3 * scene.vertices, gravity=(0, 0, -1e3))
    assert first_motion_cosine(assess(large), verify(large)) == pytest.approx(
        first_motion_cosine(assess(scene), verify(scene)), abs=1e-3
    )


def test_what_does_not_move_has_no_cosine():
    resting, falling = stack(2), stack(2, gravity=(0.9, 0, -1))
    assert first_motion_cosine(assess(falling), verify(resting)) is None
    assert first_motion_cosine(assess(resting), verify(falling)) is None
