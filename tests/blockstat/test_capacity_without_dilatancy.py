"""Curves of joints that slide without opening, where dilatancy would wedge blocks or lengthen ties."""

import numpy as np
import pytest

from blockstat import Assembly, Block, InputError, Tie, acceleration, box, capacity
from blockstat.contact.interfaces import find_interfaces
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.path import PathEnd
from blockstat.large_displacement.self_stress import carried_below_the_beginning, told_of_self_stress

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
    found = carried_below_the_beginning(locked, load, 0 * load, find_interfaces(locked), "auto", multiplier)
    assert (found is not None) is told
    if found is not None:
        words = "self-stress 0.4999 to 0.5 is carried at rest; this curve begins at 0.9"
        assert words in told_of_self_stress(found, multiplier)


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


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_a_lintel_slides_on_both_columns_at_once_where_it_may_take_them_along(order):
    """Lintel 2.5 m long, flush with two columns .5 m thick at x = 0 and 2, friction .15 in all four beds.

    Each bed slides at .15, and no bed can slide alone: the lintel slides on both columns, or both columns on the
    ground, or one of either. The bed that is used up first is that of the left column, after its thickness .5. Then the
    centroid of the lintel is at 1.25 + .5, left of the right column at 2, and the lintel falls.
    """
    columns = [box((x, 0, 0), (x + 0.5, 1, 2), name=name) for x, name in ((0, "left"), (2, "right"))]
    blocks = [*columns, box((0, 0, 2), (2.5, 1, 2.4), name="lintel")]
    trilith = Assembly.from_blocks([GROUND, *(blocks[k] for k in order)], supports=["ground"], friction=0.15)
    curve = capacity(trilith.with_(density=DENSITY), ALONG, control="lintel", steps=8)
    assert curve.outcome.word == "collapse"
    assert curve.displacement[-1] == pytest.approx(0.5, abs=2e-6)  # a bearing below a millionth of the block is none
    np.testing.assert_allclose(curve.lower, 0.15, rtol=1e-6)
    still = [trilith.names.index(name) for name in ("left", "right")]
    assert not curve.points[-2].pose.displacement[still].any()
    assert any("may be shared by several joints" in w for w in curve.warnings)


def buttressed(thick, high, wide, up, friction):
    """A wall and a triangular buttress beside it, .4 m along the wall, on the ground."""
    corners = [(thick, y, z) for y in (0.3, 0.7) for z in (0, up)] + [(thick + wide, y, 0) for y in (0.3, 0.7)]
    faces = [[0, 4, 1], [2, 3, 5], [0, 2, 5, 4], [0, 1, 3, 2], [1, 4, 5, 3]]
    blocks = [GROUND, box((0, 0, 0), (thick, 1, high), name="wall"), Block(corners, faces, name="buttress")]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=friction, density=DENSITY)


def multiplier_in_parallel(turn, thick, high, wide, up, friction):
    """The multiplier while the wall and the buttress turn by the same angle, sliding on each other.

    The wall turns about its toe, and the buttress about its own, which slides to the right by wide (1 / cos - 1), so
    that the faces stay on each other. Both beds have their full friction: with the normal force N of the face and that
    of the toe, V,

        N (c - mu s) + alpha w = mu V,   V = w + N (s + mu c),   so   N = w (mu - alpha) / ((1 - mu^2) c - 2 mu s).

    N acts at q above the low corner of the buttress, which is wide tan above the wall's toe along the face. Moments
    about the toes, of the buttress and of the wall, are in equilibrium with the same q.
    """
    s, c = np.sin(turn), np.cos(turn)
    wall, own = thick * high, 0.5 * wide * up * 0.4
    wedge = own / ((1 - friction**2) * c - 2 * friction * s) * wide * (friction + s / c)
    resisting = own * (2 / 3 * wide * c - up / 3 * s) + wall * (thick / 2 * c - high / 2 * s) + friction * wedge
    return resisting / (wall * (high / 2 * c + thick / 2 * s) + own * (up / 3 * c + 2 / 3 * wide * s) + wedge)


def test_a_buttress_slides_by_the_square_of_the_turn_of_the_wall_that_leans_on_it():
    """At rest its toe does not slip, and counts as sticking: that linkage has no pose beyond."""
    sizes = (0.4, 3.0, 0.8, 2.0, 0.8)
    curve = capacity(buttressed(*sizes), ALONG, control="wall", displacement=0.15, steps=6)
    assert curve.outcome.word == "reached"
    assert curve.lower[0] <= multiplier_in_parallel(0.0, *sizes) <= curve.upper[0] * (1 + 1e-6)
    for point in curve.points[1:]:
        turn = np.arcsin(point.pose.rotation[1, 0, 2])
        assert point.lower == pytest.approx(multiplier_in_parallel(turn, *sizes), rel=1e-6)
    assert len(curve.points) < 12
    assert not any("finite steps" in w for w in curve.warnings)


def test_finite_steps_never_creep_where_the_multiplier_leaps_to_and_fro(monkeypatch):
    """A step in which the multiplier changes much is a sixteenth of the longest at least: 4 take less than 128."""
    monkeypatch.setattr(LinkageFollower, "follow", lambda *_: iter([PathEnd.LOST]))
    curve = capacity(buttressed(0.4, 3.0, 0.8, 2.0, 0.8), ALONG, control="wall", displacement=0.01, steps=4)
    assert curve.outcome.word == "reached"
    assert len(curve.points) < 128


def test_a_leap_of_the_multiplier_next_to_rest_does_not_shorten_the_steps():
    """With associated flow both beds of the buttress slide from rest on, and the wall leans on its top.

    With the force N there, 1.36 m above the toe of the wall, and friction in full (`multiplier_in_parallel`),
    N 1.36 = W (1.26 alpha - .18) and N (1 - mu^2) = w (mu - alpha). W is .36 x 2.52, and w is .5 x 1.36 x .4.
    """
    sizes = (0.36, 2.52, 1.0, 1.36, 0.69)
    wall, own = 0.36 * 2.52 / 1.36, 0.5 * 1.36 * 0.4 / (1 - 0.69**2)
    curve = capacity(buttressed(*sizes), ALONG, control="wall", displacement=0.05, steps=1, flow="associated")
    assert curve.outcome.word == "reached"
    expected = (0.18 * wall + 0.69 * own) / (1.26 * wall + own)
    assert curve.lower[0] == pytest.approx(expected, rel=1e-6)
    assert len(curve.points) < 50
    assert not curve.events


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
