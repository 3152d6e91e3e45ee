"""Curves of joints that slide without opening, where dilatancy would wedge blocks or lengthen ties."""

import numpy as np
import pytest

from blockstat import Assembly, Tie, box, capacity

DENSITY = 2000.0
G = 9.81
ALONG = (1, 0, 0)
GROUND = box((-3, -3, -3), (4, 3, 0), name="ground")


def slab(height, friction, tie):
    """A slab of 2 m x 1 m on the ground, under a ceiling, with a tie or a strut, and its weight."""
    blocks = [GROUND, box((0, 0, 0), (2, 1, height), name="s"), box((-3, -3, 3), (4, 3, 4), name="ceiling")]
    tied = Assembly.from_blocks(blocks, supports=["ground", "ceiling"], friction=friction, density=DENSITY, ties=[tie])
    return tied, 2 * height * DENSITY * G


def test_a_strut_that_has_yielded_pushes_no_more_when_the_slab_has_slid_past_it():
    """It pushes with F along e, from (1.5, 3) to (1 + u, .4), while it shortens: up to u = .5.

    The slab slides at W alpha = mu (W + F e_z) + F e_x. Beyond, the strut lengthens, and alpha = mu.
    """
    friction, force = 0.5, 1e4
    strut = Tie(("ceiling", "s"), ((1.5, 0.5, 3), (1, 0.5, 0.4)), greatest=force, strut=True)
    pushed, weight = slab(0.4, friction, strut)
    curve = capacity(pushed, ALONG, control="s", displacement=0.78, steps=6)
    for place in (0.0, 0.13, 0.39, 0.51, 0.6, 0.78):
        nearest = int(np.abs(curve.displacement - place).argmin())
        u = curve.displacement[nearest]
        e = np.array([0.5 - u, 2.6]) / np.hypot(0.5 - u, 2.6)
        expected = friction + (force / weight * (friction * e[1] + e[0]) if u < 0.5 else 0.0)
        assert curve.lower[nearest] == pytest.approx(expected, rel=1e-5)
    assert curve.at(0.505)[0] == pytest.approx(friction, rel=1e-5)
    (event,) = curve.events
    assert event.kind == "change"
    assert event.parameter == pytest.approx(0.5, abs=1e-4)
    assert event.before == pytest.approx(friction * (1 + force / weight), rel=1e-4)
    assert event.after == pytest.approx(friction, rel=1e-6)


@pytest.mark.parametrize("greatest", [4e3, 4e4])
def test_a_tie_that_only_dilatancy_would_lengthen_pulls_nothing(greatest):
    """From (2.5, -2) on the ground to (1, .1): sliding to the right shortens it, so that alpha = mu from rest on."""
    tie = Tie(("ground", "s"), ((2.5, 0.5, -2), (1, 0.5, 0.1)), greatest=greatest)
    tied, _ = slab(0.2, 0.9, tie)
    curve = capacity(tied, ALONG, control="s", displacement=1.5, steps=5)
    assert curve.outcome.word == "reached"
    np.testing.assert_allclose(curve.lower, 0.9, rtol=1e-6)
    assert (curve.upper >= curve.lower).all()
    assert len(curve.points) < 12
