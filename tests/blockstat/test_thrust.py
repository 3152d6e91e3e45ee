"""Thrusts and domains of two loads against sums and against limits that are known."""

import numpy as np
import pytest

from blockstat import JointLaw, thrust_range
from evidence.scenes.small import arch


@pytest.mark.parametrize("law", [{}, {"cohesion": 0.02}, {"tension": 0.02}, {"tension": 0.01, "cohesion": 0.02}])
def test_two_springings_carry_the_weight_between_them(law):
    # What one springing carries the other does not: the least of one is the weight without the greatest of the other.
    asm = arch(12, 0.2, friction=0.7).with_(joints=[JointLaw(("*", "*"), **law)] if law else [])
    weight = asm.mass[asm.free].sum()
    right, left, both = (thrust_range(asm, names, (0, 0, -1)) for names in (["right"], ["left"], ["left", "right"]))
    assert right.least < weight / 2 < right.greatest
    assert right.least + left.greatest == pytest.approx(weight, rel=1e-6)
    assert right.greatest + left.least == pytest.approx(weight, rel=1e-6)
    assert (both.least, both.greatest) == pytest.approx((weight, weight), rel=1e-6)
    if law:  # a law adds forces
        dry = thrust_range(asm.with_(joints=[]), ["right"], (0, 0, -1))
        assert right.least <= dry.least * (1 + 1e-9)
        assert right.greatest >= dry.greatest * (1 - 1e-9)


def test_a_thrust_has_a_sign():
    # Outwards at the right springing is +x, and the left one pushes as hard the other way.
    asm = arch(12, 0.2)
    outwards = thrust_range(asm, ["right"], (2, 0, 0))
    assert 0 < outwards.least < outwards.greatest
    for other in (thrust_range(asm, ["left"], (-1, 0, 0)), thrust_range(asm, ["right"], (1, 0, 0))):
        np.testing.assert_allclose([other.least, other.greatest], [outwards.least, outwards.greatest], rtol=1e-6)
    inwards = thrust_range(asm, ["right"], (-1, 0, 0))
    np.testing.assert_allclose([inwards.least, inwards.greatest], [-outwards.greatest, -outwards.least], rtol=1e-6)
