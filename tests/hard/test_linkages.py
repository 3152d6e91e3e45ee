"""The linkages that hard cases are compared with, against statics and against closed forms."""

import numpy as np
import pytest

from evidence.hard.linkages import FourBar, Ring, Spread, bedded, first_mechanism, semicircle


@pytest.mark.parametrize(("voussoirs", "thickness"), [(9, 0.24), (10, 0.2), (16, 0.18)])
@pytest.mark.parametrize("turn", [0.0, 0.02])
def test_the_thrust_of_a_linkage_that_follows_from_its_work_passes_through_all_its_hinges(voussoirs, thickness, turn):
    # The multiplier is that of the work; the reaction balances two bars; the third one is in balance then.
    linkage = first_mechanism(semicircle(voussoirs, thickness))
    thrust = linkage.thrust(turn)
    assert [thrust[joint] for joint in linkage.hinges] == pytest.approx([0, 1, 0, 1], abs=1e-7)


@pytest.mark.parametrize("turn", [0.01, 0.05, 0.1])
def test_the_bars_of_a_linkage_keep_their_lengths(turn):
    linkage = first_mechanism(semicircle(10, 0.2))
    for rest, there, angle in linkage.bars(turn):
        assert np.isfinite([*rest, *there, angle]).all()
    (_, first, _), (_, second, _), (_, last, _) = linkage.bars(turn)
    a, b, _, d = linkage.pivots
    assert np.linalg.norm(second - first) == pytest.approx(np.linalg.norm(b - a), rel=1e-12)
    assert last == pytest.approx(d)
    assert linkage.displacement(turn) > 0


def test_any_other_hinges_than_those_found_have_their_thrust_outside_a_joint():
    ring = semicircle(8, 0.2)
    found = first_mechanism(ring)
    assert found.slack(1e-6) > 0
    others = [
        FourBar(ring, (a, b, c, d)) for d in (7, 8) for c in range(4, d) for b in range(2, c) for a in range(min(b, 3))
    ]
    inside = [other.hinges for other in others if other.displacement(1e-6) > 0 and other.slack(1e-6) > 0]
    assert inside == [found.hinges]


def test_a_bed_takes_as_much_of_either_voussoir_and_leaves_the_mass_as_it_is():
    plain, with_beds = semicircle(10, 0.2), bedded(10, 0.2, 1e-6)
    assert len(with_beds.angle) == 2 * len(plain.angle)
    assert with_beds.masses[0].sum() == pytest.approx(plain.masses[0].sum(), rel=1e-5)


def test_masses_of_a_ring_are_those_of_its_trapezia():
    area, centre = Ring(np.array([np.pi / 2 + 0.1, np.pi / 2 - 0.1]), 0.2).masses
    inner, outer = 0.9 * np.sin(0.1), 1.1 * np.sin(0.1)
    high = 0.2 * np.cos(0.1)
    assert area[0] == pytest.approx((inner + outer) * high, rel=1e-12)
    low = 0.9 * np.cos(0.1)
    assert centre[0] == pytest.approx([0, low + high / 3 * (inner + 2 * outer) / (inner + outer)], abs=1e-12)


def test_a_spread_arch_falls_where_its_thrust_has_left_the_springing():
    spread = Spread(semicircle(10, 0.15))
    assert spread.slack(0.0) > 0
    assert spread.slack(spread.collapse) == pytest.approx(0.0, abs=1e-9)
    # Three hinges in balance: the thrust grows as the crown comes down.
    before, after = (spread.least_thrust(spread.joint, at)[0] for at in (0.0, spread.collapse))
    assert after > before
