"""Curves of joints that slide without opening, where dilatancy would wedge blocks or lengthen ties."""

import numpy as np
import pytest

from blockstat import Assembly, InputError, Tie, acceleration, box, capacity
from blockstat.contact.interfaces import find_interfaces
from blockstat.large_displacement.self_stress import warning_of_self_stress

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


def slot(*fixed):
    """A block in a slot between two free walls on the ground, all of weight 1 per 0.4 m3, with friction 1/2."""
    walls = [box((x, -1, 0), (x + 1, 3, 1), name=name) for x, name in ((-1, "left"), (1, "right"))]
    blocks = [box((-4, -3, -1), (5, 6, 0), name="ground"), box((0, 0, 0), (1, 1, 0.4), name="s"), *walls]
    return Assembly.from_blocks(blocks, supports=["ground", *fixed], friction=0.5, density=DENSITY)


@pytest.mark.parametrize("fixed", [(), ("left",)], ids=["free walls", "one wall fixed"])
def test_walls_that_nothing_presses_hold_no_block_in_their_slot(fixed):
    """The block slides out on the ground alone, at mu. Dilatancy would push the walls aside."""
    weight = 0.4 * DENSITY * G
    curve = capacity(slot(*fixed), [("s", (0.5, 0, 0.05), (0, weight, 0))], control="s", displacement=0.4, steps=4)
    assert curve.outcome.word == "reached"
    np.testing.assert_allclose(curve.lower, 0.5, rtol=1e-4)
    assert not any("self-stress" in warning for warning in curve.warnings)
    # Associated flow: the walls weigh 4 / .4 = 10 times the block, and slide at 1/2 on the ground.
    assert curve.upper[0] > 1.0


def test_a_curve_without_a_mechanism_says_what_friction_without_dilatancy_carries():
    """Between a floor and a ceiling a slab slides at mu, where joints that open as they slide lock it."""
    blocks = [GROUND, box((0, 0, 0), (2, 1, 0.4), name="s"), box((-3, -3, 0.4), (4, 3, 1), name="ceiling")]
    locked = Assembly.from_blocks(blocks, supports=["ground", "ceiling"], friction=0.5, density=DENSITY)
    with pytest.raises(InputError, match=r"self-stress limit_load.* finds that 0\.499\d* to 0\.5 is carried"):
        capacity(locked, ALONG, control="s")
    with pytest.raises(InputError, match=r"no mechanism to follow$"):
        capacity(locked, ALONG, control="s", flow="associated")


@pytest.mark.parametrize(("multiplier", "told"), [(0.5, False), (0.9, True)])
def test_a_multiplier_that_only_self_stress_holds_is_told(multiplier, told):
    """Whatever a curve begins with: the slab between floor and ceiling carries mu without self-stress."""
    blocks = [GROUND, box((0, 0, 0), (2, 1, 0.4), name="s"), box((-3, -3, 0.4), (4, 3, 1), name="ceiling")]
    locked = Assembly.from_blocks(blocks, supports=["ground", "ceiling"], friction=0.5, density=DENSITY)
    load = acceleration(locked, ALONG)
    found = warning_of_self_stress(locked, load, 0 * load, find_interfaces(locked), "auto", multiplier)
    assert bool(found) is told
    assert not told or "self-stress 0.4999 to 0.5 is carried at rest; this curve begins at 0.9" in found[0]


def test_where_any_joint_of_a_stack_may_slide_the_top_one_takes_it_all():
    """Three blocks of 1 m x 1 m x .5 m and friction .2: each joint slides at .2, and so do all together.

    The top block alone slides until its weight and the push .2 meet at the edge, at 1 - .5 - .25 x .2, and tips. That
    needs no push when its centre is at the edge, at .5. Two blocks on the third would tip at .4.
    """
    blocks = [box((-3, -3, -1), (3, 3, 0), name="ground")]
    blocks += [box((0, 0, 0.5 * k), (1, 1, 0.5 * k + 0.5), name=f"b{k}") for k in range(3)]
    stack = Assembly.from_blocks(blocks, supports=["ground"], friction=0.2, density=DENSITY)
    curve = capacity(stack, ALONG, control="b2", steps=8)
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.5, rel=1e-6)
    assert curve.displacement[curve.upper > 0.2 - 1e-6].max() == pytest.approx(0.45, rel=1e-4)
    assert any(
        '"b0" and "b1", "b1" and "b2". The path follows the slip between "b1" and "b2" alone' in w
        for w in curve.warnings
    )


def interrupted(*_, **__):
    raise KeyboardInterrupt


def test_an_interrupt_of_the_last_question_keeps_the_curve(monkeypatch):
    monkeypatch.setattr("blockstat.large_displacement.self_stress.coulomb_state", interrupted)
    curve = capacity(slot("left"), [("s", (0.5, 0, 0.05), (0, 1e3, 0))], control="s", displacement=0.1, steps=3)
    assert curve.outcome.word == "reached"
    assert any("interrupted before it was known" in text for text in curve.warnings)


def test_an_interrupt_while_the_reason_of_an_error_is_sought_makes_no_figure(monkeypatch):
    monkeypatch.setattr("blockstat.analysis.coulomb.coulomb_state", interrupted)
    blocks = [GROUND, box((0, 0, 0), (2, 1, 0.4), name="s"), box((-3, -3, 0.4), (4, 3, 1), name="ceiling")]
    locked = Assembly.from_blocks(blocks, supports=["ground", "ceiling"], friction=0.5, density=DENSITY)
    with pytest.raises(KeyboardInterrupt):
        capacity(locked, ALONG, control="s")
