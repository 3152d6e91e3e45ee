from types import SimpleNamespace

import numpy as np
import pytest

from blockstat import Assembly, InputError, JointLaw, Tie, assess
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.design_search import margin
from blockstat.design_search.margin import TOP, Margin, _multiplier, _slopes, measure
from evidence.scenes.small import box


def leaning(values):
    """A pillar as wide as the parameter, a slab that falls off it, and a lid that a width of 0.5 just meets."""
    width = values["width"]
    blocks = [
        box((-3, -3, -1), (4, 4, 0), name="ground"),
        box((0, 0, 0), (width, 1, 1), name="pillar"),
        box((0.5, 1, 0), (1, 3, 1), name="neighbour"),
        box((0.5, 0.2, 1), (1, 2.8, 1.2), name="lid"),
        box((-1, 0, 1), (0.5, 1, 1.2), name="slab"),
    ]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)


def test_a_design_that_falls_where_joints_change_has_its_own_score():
    # A hair wider, the pillar carries the lid too, so there is no derivative; the score is known all the same.
    found = measure(leaning, {"width": 0.5}, ("width",), Margin())
    score = assess(leaning({"width": 0.5})).score
    assert 0 < score < 1
    assert found.static == "unstable"
    assert found.reserve == pytest.approx(-score, rel=1e-6)


@pytest.mark.parametrize(("width", "asked"), [(0.4, ["assess"]), (1.2, ["assess", "limit_load"])])
def test_a_design_that_falls_is_asked_for_no_limit_load(monkeypatch, width, asked):
    """One verdict for what falls; what stands is asked for its limit as well. Slopes need no further solve."""
    solved = []
    for name in ("assess", "limit_load"):
        own = getattr(margin, name)
        monkeypatch.setattr(margin, name, lambda *a, own=own, name=name, **k: (solved.append(name), own(*a, **k))[1])

    def pillar(values):
        blocks = [box((-3, -3, -1), (4, 4, 0), name="ground"), box((0, 0, 0), (values["width"], 1, 2), name="pillar")]
        return Assembly.from_blocks(blocks, supports=["ground"], gravity=(4.905, 0, -9.81))

    found = measure(pillar, {"width": width}, ("width",), Margin((1.0, 0.0, 0.0)))
    assert (found.static == "stable") == (width > 1)  # it tips where width / height is below .5
    assert solved == asked


def test_where_a_limit_load_is_left_open_the_score_counts(monkeypatch):
    """Neither a multiplier nor a derivative is proven here or beside: there was no number to take differences of."""
    wanted = measure(leaning, {"width": 0.4}, ("width",), Margin())

    def undecided(*_, **__):
        return SimpleNamespace(outcome=LoadOutcome.UNDECIDED, lower=-np.inf, upper=1.0)

    def refused(*_, **__):
        raise InputError("no derivative")

    monkeypatch.setattr(margin, "limit_load", undecided)
    monkeypatch.setattr(margin, "slopes_of_limit", refused)
    monkeypatch.setattr(margin, "slopes_of_score", refused)
    found = measure(leaning, {"width": 0.4}, ("width",), Margin())
    assert found.reserve == pytest.approx(wanted.reserve)
    assert found.reserve_slopes == pytest.approx(wanted.reserve_slopes, rel=1e-2)
    assert _slopes(lambda _: -np.inf, {"width": 0.4}, 1e-6).tolist() == [0.0]


@pytest.mark.parametrize("axis", [(1, 0, 1), (0, 0, 1), (1, 0, -0.001)])
def test_a_margin_of_tilt_has_a_horizontal_axis(axis):
    with pytest.raises(InputError, match=r"margin: axis is \(.*\); it must be horizontal: x, y, or three numbers"):
        Margin.tilt(axis, 10)
    level = (*axis[:2], 1e-17) if any(axis[:2]) else (0.6, 0.8, 0)
    # Turned about it, what is up goes to the side: the acceleration is at right angles to the axis, and level.
    assert np.dot(Margin.tilt(level, 10).direction, level) == pytest.approx(0.0, abs=1e-15)
    assert Margin.tilt(level, 10).direction[2] == 0.0


def test_a_margin_of_friction_leaves_less_of_it():
    assert Margin(friction=1.2).applied(leaning({"width": 0.5})).friction == pytest.approx(0.6 / 1.2)


def test_a_pillar_with_a_margin_of_friction_slides_where_it_has_none_left():
    # A slab slides at its coefficient of friction: under a push of half its weight with .6, not with .6 / 1.5.
    def slab(_):
        blocks = [box((-3, -3, -1), (4, 4, 0), name="ground"), box((0, 0, 0), (2, 2, 0.2), name="slab")]
        return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)

    found = [measure(slab, {}, (), Margin((1.0, 0.0, 0.0), 0.5, friction=f)) for f in (1.0, 1.5)]
    assert [one.reserve for one in found] == pytest.approx([0.6, 0.4], rel=1e-3)


def on_ground(*blocks, supports=("ground",)):
    ground = box((-3, -3, -1), (9, 4, 0), name="ground")
    return Assembly.from_blocks([ground, *blocks], supports=supports, friction=0.6)


def test_what_no_push_moves_has_the_most_reserve():
    def held(values):
        width = values["width"]
        wall = box((width, 0, 0.5), (width + 1, 1, 1), name="wall")  # it does not hold what tips away from it
        return on_ground(box((0, 0, 0), (width, 1, 1), name="stone"), wall, supports=("ground", "wall"))

    found = measure(held, {"width": 0.5}, ("width",), Margin((1.0, 0.0, 0.0)))
    assert (found.reserve, found.static) == (TOP, "stable")
    assert found.reserve_slopes.tolist() == [0.0]
    away = measure(held, {"width": 0.5}, ("width",), Margin((-1.0, 0.0, 0.0)))  # it tips at width / height
    assert away.reserve == pytest.approx(0.5, rel=1e-6)
    assert away.reserve_slopes == pytest.approx([1.0], rel=1e-3)


def test_what_nothing_holds_has_the_least_reserve():
    def hung(values):
        return on_ground(box((0, 0, 1), (values["width"], 1, 2), name="hung"))

    found = measure(hung, {"width": 0.5}, ("width",), Margin())
    assert (found.reserve, found.static) == (-TOP, "unstable")
    assert found.reserve_slopes.tolist() == [0.0]


def test_a_reserve_where_joints_change_has_differences_for_its_slopes():
    """A pillar tips at its width over its height; a light lid lies on a hair of it as soon as it is wider."""

    def beside(values):
        blocks = [
            box((-3, -3, -1), (9, 4, 0), name="ground"),
            box((0, 0, 0), (values["width"], 1, 1), name="pillar", group="pillar"),
            box((0.5, 1.2, 0), (2.5, 3, 1), name="neighbour"),
            box((0.5, 0.2, 1), (2.5, 2.8, 1.2), name="lid", group="lid", density=1.0),
        ]
        smooth = JointLaw(("pillar", "lid"), friction=0.0)
        return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6, joints=[smooth])

    found = measure(beside, {"width": 0.5}, ("width",), Margin((1.0, 0.0, 0.0)))
    assert found.static == "stable"
    assert found.reserve == pytest.approx(0.5, rel=1e-6)
    assert found.reserve_slopes == pytest.approx([1.0], rel=0.1)


def test_a_case_carries_its_limit_load_or_lacks_its_score():
    push = Margin((1.0, 0.0, 0.0))
    pillar = on_ground(box((0, 0, 0), (0.5, 1, 2), name="pillar"))
    assert _multiplier(pillar, push) == pytest.approx(0.25, rel=1e-6)
    falls = leaning({"width": 0.4})
    assert _multiplier(falls, push) == pytest.approx(-assess(falls).score)
    assert _multiplier(falls, push) < 0


def test_a_tied_design_has_the_slopes_of_its_moment_about_the_toe():
    """A pillar of unit height with a tie at its top carries b + 2 F / W, and W goes with its width b."""

    def tied(values):
        pillar = box((0, 0, 0), (values["width"], 1, 1), name="pillar")
        tie = Tie(("ground", "pillar"), ((-3, 0.5, 1), (0, 0.5, 1)), greatest=1000.0)
        return on_ground(pillar).with_(ties=[tie])

    weight = float(np.linalg.norm(tied({"width": 0.4}).gravity) * tied({"width": 0.4}).mass[1])
    found = measure(tied, {"width": 0.4}, ("width",), Margin((1.0, 0.0, 0.0)))
    assert found.reserve == pytest.approx(0.4 + 2000.0 / weight, rel=1e-6)
    assert found.reserve_slopes == pytest.approx([1.0 - 2000.0 / weight / 0.4], rel=1e-6)
