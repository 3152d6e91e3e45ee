"""Verdicts say how the blocks move, and where."""

import numpy as np
import pytest

from blockstat import assess
from evidence.scenes.small import arch, assembly, box


def on_a_slope(width, friction, degrees):
    """A block of height 2 on the ground, under gravity tilted towards +x."""
    blocks = [box((-9, -9, -1), (9, 9, 0), name="ground"), box((0, 0, 0), (width, 1, 2), name="stone")]
    angle = np.radians(degrees)
    gravity = (9.81 * np.sin(angle), 0, -9.81 * np.cos(angle))
    return assess(assembly(blocks, supports=["ground"]), friction=friction, gravity=gravity).explain()


@pytest.mark.parametrize(
    ("width", "friction", "degrees", "words"),
    [
        (2.0, 0.3, 20.0, "Slides at ground | stone."),  # tan 20 = .364 > .3; it tips beyond 45 degrees only
        (0.5, 0.7, 20.0, "Opens as a hinge at ground | stone."),  # it tips where tan a > .5 / 2
    ],
)
def test_a_block_on_a_slope_slides_or_tips(width, friction, degrees, words):
    assert words in on_a_slope(width, friction, degrees).splitlines()


def test_a_thin_arch_opens_hinges():
    # Heyman: a semicircular arch thinner than .1075 of its radius falls by hinges, and none of its joints slides.
    told = assess(arch(21, 0.08)).explain()
    assert "Opens as a hinge at" in told
    assert "Slides" not in told


def test_a_hanging_block_parts_from_what_is_above():
    blocks = [box((0, 0, 1), (1, 1, 2), name="lintel"), box((0, 0, 0), (1, 1, 1), name="below")]
    told = assess(assembly(blocks, supports=["lintel"])).explain()
    assert "Parts at lintel | below." in told
    assert "Residual tension: 0 " not in told
