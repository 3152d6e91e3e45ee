"""Several equal mechanisms that do not touch: the curve is that of the one that moves the control."""

import numpy as np
import pytest

from blockstat import Assembly, InputError, Tie, box, capacity, nonlinear_check
from blockstat.large_displacement.finite_steps import step
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.path import PathEnd
from evidence.scenes.small import hexahedron

#: A wall of 0.5 m by 3 m, pushed at its centroid, turns about its toe at 0.25 / 1.5.
ALONE = 1 / 6


def on_ground(*blocks, **options):
    ground = box((-5, -5, -1), (20, 10, 0), name="ground")
    options = {"supports": ["ground"], "density": 2000.0, "friction": 0.7} | options
    return Assembly.from_blocks([ground, *blocks], **options)


def wall(x, name, z=0.0):
    return box((x, 0, z), (x + 0.5, 3, z + 3), name=name)


def trilith(y):
    piers = [box((x, y, 0), (x + 0.5, y + 0.8, 3), name=f"{side}{y}") for x, side in ((0, "l"), (2.5, "r"))]
    return [*piers, box((0, y, 3), (3, y + 0.8, 3.4), name=f"t{y}")]


def turned(moved):
    """The multiplier when the centroid has moved by so much: its arm over its height above the toe."""
    return (0.25 - moved) / np.sqrt(0.25**2 + 1.5**2 - (0.25 - moved) ** 2)


@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.parametrize("control", ["wall 0", "wall 1"])
def test_of_equal_walls_one_turns_until_its_centroid_is_above_its_toe(count, control):
    walls = on_ground(*[wall(5.0 * k, f"wall {k}") for k in range(count)])
    curve = capacity(walls, (1, 0, 0), control=control)
    assert curve.outcome.word == "zero"
    assert curve.lower[0] == pytest.approx(ALONE, rel=1e-6)
    assert curve.displacement[-1] == pytest.approx(0.25, abs=1e-6)
    np.testing.assert_allclose(curve.at(0.125), turned(0.125), rtol=1e-3)
    others = [k for k, name in enumerate(walls.names) if name != control]
    assert not curve.points[-1].pose.displacement[others].any()
    (warning,) = curve.warnings
    assert warning.startswith("other parts begin to move at the same multiplier and are left at rest: ")
    assert all(f'"{walls.names[k]}"' in warning for k in others[1:])
    assert f'"{control}"' not in warning


@pytest.mark.parametrize("control", ["t0", "t3", None])
def test_of_equal_triliths_one_follows_the_turn_of_its_piers(control):
    # The piers turn about their toes until their tops, 0.5 m behind them, are above them, as a trilith alone does.
    curve = capacity(on_ground(*trilith(0), *trilith(3)), (1, 0, 0), control=control, steps=15)
    assert curve.outcome.word == "zero"
    assert curve.lower[0] == pytest.approx(ALONE, rel=1e-6)
    assert curve.displacement[-1] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(("control", "end"), [("mean", 0.125), (None, 0.5)])
def test_a_control_that_all_parts_move_follows_the_first(control, end):
    # Of the mean displacement the wall is half; of the corners that move most, its top's moves by 0.5 m.
    curve = capacity(on_ground(wall(0, "first"), wall(5, "second")), (1, 0, 0), control=control)
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(end, abs=1e-6)
    assert not curve.points[-1].pose.displacement[2].any()


@pytest.mark.parametrize(("control", "end"), [("large", 0.25), ("small", 0.125)])
def test_parts_of_other_size_and_equal_slenderness_move_alone_too(control, end):
    small = box((5, 0, 0), (5.25, 1, 1.5), name="small")
    curve = capacity(on_ground(wall(0, "large"), small), (1, 0, 0), control=control)
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(end, abs=1e-6)


def test_equal_walls_on_a_block_at_rest_are_parts():
    base = box((0, 0, 0), (6, 3, 1), name="base")
    for control in ("a", "b"):
        curve = capacity(on_ground(base, wall(0.5, "a", 1), wall(5, "b", 1)), (1, 0, 0), control=control)
        assert curve.outcome.word == "zero"
        assert curve.displacement[-1] == pytest.approx(0.25, abs=1e-6)


def test_what_a_beam_or_a_tie_joins_is_one_part():
    piers = [wall(x, f"pier {x}") for x in (0, 3, 6)]
    beam = box((0, 0, 3), (6.5, 3, 3.4), name="beam")
    curve = capacity(on_ground(*piers, beam), (1, 0, 0), control="beam")
    assert (curve.outcome.word, curve.warnings) == ("zero", ())
    assert curve.displacement[-1] == pytest.approx(0.5, abs=1e-6)
    tie = Tie(("a", "b"), ((0.5, 1.5, 2.9), (5, 1.5, 2.9)), greatest=1e6)
    tied = capacity(on_ground(wall(0, "a"), wall(5, "b"), ties=[tie]), (1, 0, 0), control="a")
    assert not any("other parts" in text for text in tied.warnings)
    assert tied.displacement[-1] == pytest.approx(0.25, rel=1e-3)


@pytest.mark.parametrize("names", ["ab", "ba"])
@pytest.mark.parametrize(("control", "end"), [("a", 0.25), ("mean", 0.125)])
def test_of_two_tied_walls_the_first_turns_towards_the_second(names, control, end):
    """The tie from the right face of "a" to the left one of "b" hinders no turn of "a" towards "b", and has no force.

    A turn of both by t lengthens it: over the toe of "a" its one end keeps its height to first order, while the other
    rises by .5 t. Held at its length it lets "a" turn by more than "b", which then needs less of the load than "b": no
    tension is in equilibrium with that. So "a" turns alone, from .25 / 1.5 until its centroid is above its toe.
    """
    tie = Tie(("a", "b"), ((0.5, 1.5, 2.7), (5, 1.5, 2.7)), greatest=3e4)
    walls = {"a": wall(0, "a"), "b": wall(5, "b")}
    curve = capacity(on_ground(*(walls[name] for name in names), ties=[tie]), (1, 0, 0), control=control)
    assert (curve.outcome.word, curve.events, curve.warnings) == ("zero", (), ())
    assert curve.lower[0] == pytest.approx(ALONE, rel=1e-6)
    assert curve.displacement[-1] == pytest.approx(end, abs=1e-6)


def test_a_wall_that_a_tie_holds_back_does_not_move_first():
    tie = Tie(("a", "b"), ((0.5, 1.5, 2.7), (5, 1.5, 2.7)), greatest=3e4)
    with pytest.raises(InputError, match="does not move before other blocks have, as a tie holds it"):
        capacity(on_ground(wall(0, "a"), wall(5, "b"), ties=[tie]), (1, 0, 0), control="b")


def test_sliding_parts_are_left_at_rest_too():
    curve = capacity(
        on_ground(wall(0, "a"), wall(5, "b"), friction=0.1), (1, 0, 0), control="b", displacement=0.2, steps=5
    )
    assert curve.outcome.word == "reached"
    np.testing.assert_allclose(curve.lower, 0.1, rtol=1e-6)
    assert not curve.points[-1].pose.displacement[1].any()


def test_the_verification_is_that_of_one_wall():
    one = nonlinear_check(capacity(on_ground(wall(0, "a")), (1, 0, 0), control="a"), (1, 0, 0), demand={"SLV": 0.1})
    two = on_ground(wall(0, "a"), wall(5, "b"))
    both = nonlinear_check(capacity(two, (1, 0, 0), control="a"), (1, 0, 0), demand={"SLV": 0.1})
    assert both.ultimate == pytest.approx(0.25, abs=1e-6)
    assert both.bodies == one.bodies
    assert both.mass == pytest.approx(one.mass)
    assert both.state("SLV").ag == pytest.approx(one.state("SLV").ag, rel=1e-4)


def voussoirs(centre, tag, n=9, inner=0.85, outer=1.15):
    """A semicircular arch that springs at a height of 0.5 m."""

    def joint(angle, y):
        c, s = np.cos(angle), np.sin(angle)
        return [(centre + r * c, y, 0.5 + r * s) for r in (outer, inner)]

    angles = np.linspace(np.pi, 0, n + 1)
    for k, (a, b) in enumerate(zip(angles[:-1], angles[1:], strict=True)):
        front, back = ([*joint(a, y), *joint(b, y)[::-1]] for y in (0, 0.5))
        yield hexahedron(back, front, name=f"{tag}{k}")


def test_each_of_two_equal_arches_on_a_stout_pier_moves_as_between_rigid_supports():
    left, pier, right = (
        box((x0, 0, 0), (x1, 0.5, 0.5), name=name)
        for x0, x1, name in ((-0.6, 0.3, "left"), (2.0, 2.9, "pier"), (4.6, 5.5, "right"))
    )
    ends = {"supports": ["ground", "left", "right"]}
    one = on_ground(left, pier, *voussoirs(1.15, "p"), supports=["ground", "left", "pier"])
    two = on_ground(left, pier, right, *voussoirs(1.15, "p"), *voussoirs(3.75, "q"), **ends)
    alone, beside = (capacity(arches, (1, 0, 0), control="p4") for arches in (one, two))
    assert alone.outcome.word == beside.outcome.word == "zero"
    assert beside.displacement[-1] == pytest.approx(alone.displacement[-1], rel=1e-5)
    there = np.linspace(0, 0.9 * alone.displacement[-1], 5)
    np.testing.assert_allclose([beside.at(x)[0] for x in there], [alone.at(x)[0] for x in there], rtol=1e-3)


def test_finite_steps_leave_the_others_at_rest_or_say_that_they_move(monkeypatch):
    monkeypatch.setattr(LinkageFollower, "follow", lambda *_: iter([PathEnd.LOST]))
    walls = on_ground(wall(0, "a"), wall(5, "b"))
    curve = capacity(walls, (1, 0, 0), control="b")
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.25, abs=1e-3)
    assert any('are left at rest: "a"' in text for text in curve.warnings)
    assert np.abs(curve.points[-1].pose.displacement[1]).max() < 1e-9
    assert not curve.limit.mechanism[1].any()
    monkeypatch.setattr(step, "without_left_at_rest", lambda linkage, pose, motion: motion)
    sliding = walls.with_(friction=0.1)
    both = capacity(sliding, (1, 0, 0), control="b", displacement=0.05, steps=5)
    assert any('at the same multiplier and move too: "a"' in text for text in both.warnings)
    assert both.limit.mechanism[1].any()
