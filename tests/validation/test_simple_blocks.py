"""One, two, n blocks: closed forms from first principles (statics of rigid blocks with Coulomb friction).

Each limit is bracketed: stable just inside, unstable just outside, at a relative distance of 1e-5.
"""

import numpy as np
import pytest

from blockstat import Outcome, assess
from evidence.scenes.small import assembly, box, flat_arch, overhanging, pulled_slab, slab, stack, trilith

NEAR = 1e-5


def horizontal(multiplier, azimuth=0.0):
    """Gravity with a horizontal part: a mass-proportional load in the direction of the azimuth."""
    return (multiplier * np.cos(azimuth), multiplier * np.sin(azimuth), -1.0)


def assert_limit(asm, limit, **options):
    assert assess(asm, gravity=horizontal(limit * (1 - NEAR)), **options).outcome is Outcome.STABLE
    assert assess(asm, gravity=horizontal(limit * (1 + NEAR)), **options).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize(
    ("width", "height", "mu"), [(1.0, 2.0, 0.7), (1.0, 1.0, 0.7), (0.3, 1.7, 0.5), (2.0, 1.0, 0.4)]
)
def test_block_tips_or_slides(width, height, mu):
    assert_limit(stack(1, width, height), min(mu, width / height), friction=mu)


@pytest.mark.parametrize("azimuth", np.deg2rad([0, 11.25, 22.5, 30, 45, 100, 190, 287]))
def test_friction_is_the_same_in_every_direction(azimuth):
    # A flat slab slides before it tips; a K-sided pyramid would give up to 1/cos(pi/K) times mu.
    asm = slab()
    inside, outside = (horizontal(0.5 * (1 + sign * NEAR), azimuth) for sign in (-1, 1))
    assert assess(asm, friction=0.5, gravity=inside).outcome is Outcome.STABLE
    assert assess(asm, friction=0.5, gravity=outside).outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("n", [2, 5, 12])
def test_stack_of_equal_blocks(n):
    assert_limit(stack(n, 1.0, 0.5), 1.0 / (n * 0.5) if n > 2 else 0.7, friction=0.7)


@pytest.mark.parametrize("lintel_density", [1.0, 1e3, 1e6])
def test_trilith_tips_like_its_columns_whatever_the_lintel(lintel_density):
    assert_limit(trilith(lintel_density), 0.5 / 2, friction=0.7)


@pytest.mark.parametrize(("n", "exact"), [(3, 0.9166667), (5, 1.1416667), (10, 1.4644841)])
def test_harmonic_overhang(n, exact):
    assert sum(1 / (2 * k) for k in range(1, n + 1)) == pytest.approx(exact, abs=1e-7)
    assert assess(overhanging(n, exact - 1e-4)).outcome is Outcome.STABLE
    assert assess(overhanging(n, exact + 1e-4)).outcome is Outcome.UNSTABLE


def test_centred_cube_presses_equally_on_its_corners():
    asm = assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))])
    verdict = assess(asm)
    np.testing.assert_allclose(verdict.forces[:, 0], 0.25, atol=1e-7)
    np.testing.assert_allclose(verdict.forces[:, 1:], 0.0, atol=1e-5)  # friction among the corners is free


def test_offset_cube_needs_its_weight_in_tension():
    # Contact over x in [.25, .5] of a unit cube whose centroid is at .75: two forces W in tension at the inner
    # edge and 2 W in compression at the outer one; over two corners an edge, sum s^2 = W^2 / 2.
    asm = assembly([box((-0.5, 0, 0), (0.5, 1, 1)), box((0.25, 0, 1), (1.25, 1, 2))])
    verdict = assess(asm)
    assert verdict.outcome is Outcome.UNSTABLE
    assert verdict.score == pytest.approx(np.sqrt(0.5), rel=1e-6)
    inner = np.isclose(verdict.interfaces.point[:, 0], 0.25)
    net = verdict.forces[:, 0] - verdict.adhesion
    assert net[inner].sum() == pytest.approx(-1.0, abs=1e-6)
    assert net[~inner].sum() == pytest.approx(2.0, abs=1e-6)


def test_pulled_slab_under_a_slab_against_a_wall():
    # A on the ground, B on A, B's end against a fixed wall, A pulled by P; associated limit
    # mu (W_A + 2 W_B / (1 - mu^2)).
    asm, pull = pulled_slab()
    mu, weight = asm.friction, 1.0
    exact = mu * (weight + 2 * weight / (1 - mu**2))
    assert exact == pytest.approx(1.833333, abs=1e-6)
    for factor, outcome in ((1 - NEAR, Outcome.STABLE), (1 + NEAR, Outcome.UNSTABLE)):
        assert assess(asm, loads=factor * exact * pull).outcome is outcome


@pytest.mark.parametrize("mu", [0.05, 0.3, 0.7])
def test_flat_arch_stands_on_paper_with_any_friction(mu):
    # Rigid abutments allow any thrust, so force-only statics call it stable: a known false positive.
    assert assess(flat_arch(8), friction=mu).outcome is Outcome.STABLE


def test_torsion_of_a_square_face_on_four_corner_points():
    # Four corner points carry sqrt(2)/2 mu N a (a face under uniform pressure would carry .3826 mu N a).
    mu, a = 0.6, 1.0
    asm = assembly([box((-1, -1, -1), (1, 1, 0)), box((-a / 2, -a / 2, 0), (a / 2, a / 2, 1))])
    for factor, outcome in ((1 - NEAR, Outcome.STABLE), (1 + NEAR, Outcome.UNSTABLE)):
        twist = np.zeros((2, 6))
        twist[1, 5] = factor * np.sqrt(0.5) * mu * 1.0 * a
        assert assess(asm, friction=mu, loads=twist).outcome is outcome
