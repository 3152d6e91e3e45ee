"""Rotational stiffness in both readings against the equation of motion of one block on its edge."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from blockstat import InputError, Outcome, Tie, assess, glued
from dynsim import AngularSprings, DynamicOutcome, InertiaScale, Settings, simulate, verify
from evidence.scenes.small import stack

WIDTH, HEIGHT, G = 0.25, 1.0, 9.81
MASS = WIDTH * HEIGHT


def block(push):
    """A block of 0.25 x 1 x 1 m and 0.25 kg on the ground, under a sideways acceleration of `push` g."""
    return stack(1, WIDTH, HEIGHT, gravity=(push * G, 0, -G), friction=5.0)


def overturning(angle, push):
    """Moment of the weight about the edge [N m] at a rotation [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return MASS * G * (push * (HEIGHT / 2 * c + WIDTH / 2 * s) - (WIDTH / 2 * c - HEIGHT / 2 * s))


def tilt(run):
    """Rotation of the block about y, shape (n_frames,) [rad]."""
    return np.arctan2(run.rotation[:, 1, 0, 2], run.rotation[:, 1, 0, 0])


@pytest.mark.parametrize("scale", [1.0, 100.0, 7000.0])
def test_a_tipping_block_with_scaled_inertia(scale):
    push = 1.5 * WIDTH / HEIGHT
    settings = Settings(end=1.0 + 0.25 * np.sqrt(scale), settle=0.02)
    run = simulate(block(push), settings=settings, actions=[InertiaScale(scale)])
    about_edge = scale * MASS * (WIDTH**2 + HEIGHT**2) / 12 + MASS * (WIDTH**2 + HEIGHT**2) / 4

    def motion(_, y):
        return y[1], overturning(y[0], push) / about_edge

    seen = tilt(run)
    exact = solve_ivp(motion, (0, run.times[-1]), (seen[0], 0), t_eval=run.times, rtol=1e-8).y[0]
    shown = (exact > 0.05) & (exact < 0.5)
    assert shown.sum() > 5
    np.testing.assert_allclose(seen[shown], exact[shown], rtol=0.03)


def test_slower_by_the_root_of_the_scale():
    times = []
    for scale in (2500.0, 10000.0):
        run = simulate(block(0.5), settings=Settings(end=15.0), actions=[InertiaScale(scale)])
        assert tilt(run).max() > 0.05
        times.append(np.interp(0.05, tilt(run), run.times))
    assert times[1] / times[0] == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("share", [1.5, *(pytest.param(share, marks=pytest.mark.slow) for share in (3.0, 10.0))])
def test_a_block_leans_on_an_angular_spring(share):
    # Beyond tipping, the block rests where k times the rotation is the moment of its weight about the edge.
    push = 1.2 * WIDTH / HEIGHT
    k = share * MASS * G * HEIGHT / 2
    exact = brentq(lambda angle: overturning(angle, push) - k * angle, 0, 1.0)
    run = simulate(block(push), settings=Settings(end=8.0), actions=[AngularSprings(k, damping=0.5)])
    assert tilt(run)[-1] == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize(("share", "outcome"), [(0.8, DynamicOutcome.FALLS), (1.3, DynamicOutcome.STANDS)])
def test_buckling_on_an_angular_spring(share, outcome):
    # Just past tipping the spring decides: k against the slope of the overturning moment, near W h / 2.
    push = 1.02 * WIDTH / HEIGHT
    slope = MASS * G * (push * WIDTH / 2 + HEIGHT / 2)
    verdict = verify(block(push), settings=Settings(end=8.0), actions=[AngularSprings(share * slope, damping=0.5)])
    assert verdict.outcome is outcome
    assert "N m/rad" in verdict.explain()


@pytest.mark.parametrize("excess", [0.98, 1.02])
def test_a_spring_with_a_capacity_has_a_bond_as_its_twin(excess):
    push = 2.0 * WIDTH / HEIGHT
    capacity = excess * overturning(0.0, push)
    springs = AngularSprings(1e9, moment=capacity)
    static = assess(glued(block(push), 0.0, moment=capacity))
    verdict = verify(block(push), actions=[springs])
    assert static.outcome is (Outcome.STABLE if excess > 1 else Outcome.UNSTABLE)
    assert verdict.outcome is (DynamicOutcome.STANDS if excess > 1 else DynamicOutcome.FALLS)
    assert "the most at this time step" in verdict.warnings[0]


def test_scaled_inertia_is_told_with_the_verdict():
    verdict = verify(block(0.0), actions=[InertiaScale(7000.0)])
    assert verdict.outcome is DynamicOutcome.STANDS
    assert "scaled by 7000" in verdict.warnings[0]
    assert verify(block(0.0)).warnings == ()


def test_less_inertia_is_told_as_faster():
    # omega^2 goes as 1 / inertia.
    assert "rotations are up to 2 times as fast;" in InertiaScale(0.25).caveat
    assert "rotations take up to 2 times as long" in InertiaScale(4.0).caveat


@pytest.mark.parametrize("held", ["bond", "tie", "spring"])
def test_less_inertia_is_refused_where_springs_are_as_stiff_as_the_time_step_allows(held):
    asm, actions = stack(1), [InertiaScale(0.1)]
    if held == "bond":
        asm = glued(asm, 1.0, moment=1.0)
    elif held == "tie":
        asm = asm.with_(ties=[Tie(("ground", "stone0"), ((0.5, 0.5, 0.0), (0.5, 0.5, 1.0)), 0.0, 1.0)])
    else:
        actions.append(AngularSprings(1.0))
    with pytest.raises(InputError, match=r"inertia scale is 0\.1; it must be at least 1 with ties, angular springs or"):
        simulate(asm, actions=actions)


@pytest.mark.parametrize(
    "make",
    [
        lambda: InertiaScale(0.0),
        lambda: InertiaScale(float("nan")),
        lambda: AngularSprings(-1.0),
        lambda: AngularSprings(1.0, moment=0.0),
        lambda: AngularSprings(1.0, damping=2.0),
        lambda: AngularSprings("stiff"),  # pyright: ignore[reportArgumentType]
    ],
)
def test_bad_stiffness(make):
    with pytest.raises(InputError, match="it must be"):
        make()
