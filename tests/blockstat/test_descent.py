"""Search by gradients: known least widths, certified reserves, fronts.

Least pier widths: barrel vault of centreline radius 2.5 m, 0.5 m thick, 20 straight-sided voussoirs, friction 0.7, on
free-standing piers (`evidence.references.arches`).
"""

from dataclasses import replace

import numpy as np
import pytest
from test_search import Judgement, Word, between, rows

from blockstat import InputError, Outcome, acceleration, assess, build, limit_load, search, with_values
from blockstat.design_search.candidate import Candidate
from blockstat.design_search.descent import Descent, _met, undominated
from blockstat.design_search.evaluator import Callbacks, Evaluator
from blockstat.design_search.margin import measure
from blockstat.design_search.search import Margin
from blockstat.design_search.space import space_of
from blockstat.spec import parameters, scene_from
from evidence.references.arches import PIERS

PUSH = (1.0, 0.0, 0.0)


def piers(height, width):
    return scene_from(
        {
            "name": "piers",
            "parameters": {"w": width},
            "elements": {
                "vault": {
                    "kind": "arch", "span": 4.5, "thickness": 0.5, "depth": 1.0, "voussoirs": 20, "at": [0, 0, height],
                },
                "left": {"kind": "box", "size": ["= w", 1.0, height], "at": ["= -2.25 - w / 2", 0, 0]},
                "right": {"kind": "box", "size": ["= w", 1.0, height], "at": ["= 2.25 + w / 2", 0, 0]},
            },
        }
    )  # fmt: skip


def portal():
    return scene_from(
        {
            "name": "portal",
            "parameters": {"t": between(0.15, 0.3, 0.05), "w": between(0.2, 0.8, 0.1), "n": between(6, 8, 2)},
            "elements": {
                "arch": {
                    "kind": "arch", "span": 2.0, "thickness": "= t", "depth": 0.5, "voussoirs": "= n", "at": [0, 0, 1],
                },
                "left": {"kind": "box", "size": ["= w", 0.5, 1.0], "at": ["= -1 - w / 2", 0, 0]},
                "right": {"kind": "box", "size": ["= w", 0.5, 1.0], "at": ["= 1 + w / 2", 0, 0]},
            },
        }
    )  # fmt: skip


def test_designs_whose_ranges_do_not_go_together_at_every_end_are_measured():
    """A block 2 m high carries t / 2 of its weight: 0.15 at t = 0.3, where t - u + 0.1 is no size at u = 0.6."""
    data = {
        "name": "w",
        "parameters": {"t": between(0.2, 0.8, 0.1), "u": between(0.2, 0.6, 0.1) | {"value": 0.2}},
        "elements": {
            "pier": {"kind": "pier", "size": [1.0, "= t"], "height": 2.0, "courses": 2},
            "ledge": {"kind": "box", "size": [1.0, "= t - u + 0.1", 0.1], "at": [3, 0, 0]},
        },
    }
    result = search(scene_from(data), verify=None, strategy="gradient", margin=Margin((0, 1, 0), 0.15))
    assert result.best_parameters["parameters.t"] == pytest.approx(0.3, abs=1e-3)
    for found in result.history:
        t, u = found.parameters.values()
        assert (found.static == "error") == (t - u + 0.1 < 1e-9)


@pytest.mark.parametrize("height", PIERS)
def test_the_least_pier_under_a_barrel_vault(height):
    scene = piers(height, between(0.5, 1.5, 0.01))
    result = search(scene, verify=None, strategy="gradient", margin=Margin(PUSH))
    assert result.best_parameters["parameters.w"] == pytest.approx(float(PIERS[height]), abs=1e-4)
    assert assess(build(result.best)).outcome is Outcome.STABLE
    assert len(result.history) < 20


def test_the_least_pier_step_by_step():
    scene = piers(2.5, between(0.66, 0.69, 1e-3))
    result = search(scene, verify=None)
    assert result.best_parameters == {"parameters.w": 0.674}


@pytest.mark.parametrize("least", [0.05, 0.15])
def test_a_required_reserve_is_certified_and_no_design_of_the_grid_is_lighter(least):
    scene = portal()
    result = search(scene, verify=None, strategy="gradient", margin=Margin(PUSH, least))
    best = build(result.best)
    assert limit_load(best, acceleration(best, PUSH)).lower >= least
    volume = best.volume[best.free].sum()
    for values in space_of(scene).grid():
        asm = build(with_values(scene, values))
        if asm.volume[asm.free].sum() < volume:
            assert limit_load(asm, acceleration(asm, PUSH)).lower < least


def test_snapped_designs_lie_on_the_steps_and_have_the_reserve():
    scene = portal()
    result = search(scene, verify=None, strategy="gradient", margin=Margin(PUSH, 0.1), snap=True)
    for name, value in result.best_parameters.items():
        assert value in parameters(scene)[name].steps()
    best = build(result.best)
    assert limit_load(best, acceleration(best, PUSH)).lower >= 0.1


@pytest.mark.parametrize("margin", [Margin(PUSH), Margin(PUSH, friction=1.2)], ids=["as it is", "less friction"])
@pytest.mark.parametrize("width", [0.75, 0.62], ids=["stands", "falls"])
def test_slopes_are_those_of_volume_and_reserve(margin, width):
    space = space_of(piers(2.5, between(0.5, 1.5, 0.01)))

    def at(w):
        return measure(lambda v: build(space.near(v)), {"parameters.w": w}, ["parameters.w"], margin)

    here, step = at(width), 1e-3
    low, high = at(width - step), at(width + step)
    assert (here.static == "stable") == (width > 0.7)
    assert here.volume_slopes[0] == pytest.approx(2 * 2.5, rel=1e-6)
    assert here.reserve_slopes[0] == pytest.approx((high.reserve - low.reserve) / (2 * step), rel=2e-2)


def test_a_margin_of_friction_takes_friction_away():
    space = space_of(piers(2.5, between(0.5, 1.5, 0.01)))
    asm = build(space.near({"parameters.w": 0.75}))
    assert asm.friction == 0.7
    assert Margin(PUSH, friction=1.4).applied(asm).friction == pytest.approx(0.5)
    assert Margin(PUSH).applied(asm) is asm


def test_a_tilt_is_a_push():
    margin = Margin.tilt("x", 5.0)
    assert margin.direction == pytest.approx((0.0, 1.0, 0.0))
    assert margin.least == pytest.approx(np.tan(np.radians(5.0)))


@pytest.mark.parametrize(
    "make",
    [
        lambda: Margin((0.0, 0.0, 0.0)),
        lambda: Margin(PUSH, -0.1),
        lambda: Margin(PUSH, friction=0.5),
        lambda: Margin.tilt("x", 90.0),
        lambda: Margin("x"),
        lambda: Margin((1, 0)),
        lambda: Margin((1, 0, "far")),
        lambda: Margin(least="a"),
        lambda: Margin(least=float("nan")),
        lambda: Margin(friction=None),
        lambda: Margin.tilt("w", 5),
        lambda: Margin.tilt("z", 5),
        lambda: Margin.tilt((0, 1), 5),
        lambda: Margin.tilt("x", "10"),
    ],
)
def test_an_impossible_margin_is_refused(make):
    with pytest.raises(InputError, match="margin: "):
        make()


def test_more_reserve_is_asked_for_where_the_verifier_sees_a_fall():
    def verifier(assembly):
        limit = limit_load(assembly, acceleration(assembly, PUSH)).lower
        return Judgement(Word.STANDS if limit >= 0.03 else Word.FALLS)

    scene = piers(2.5, between(0.5, 1.5, 0.01))
    result = search(scene, verify=verifier, strategy="gradient", margin=Margin(PUSH))
    best = next(c for c in result.history if c.parameters == result.best_parameters)
    assert best.dynamic == "stands"
    assert 0.03 <= best.reserve < 0.1
    assert result.disagreements


@pytest.mark.parametrize("needed", [0.042, 0.066])
def test_the_reserve_of_the_answer_is_near_the_least_with_which_a_design_stands(needed):
    """Asked for 0.01, 0.03 and 0.07 in turn, the third stands; two halvings leave a quarter of the last 0.04."""

    def verifier(assembly):
        limit = limit_load(assembly, acceleration(assembly, PUSH)).lower
        return Judgement(Word.STANDS if limit >= needed else Word.FALLS)

    result = search(piers(2.5, between(0.5, 1.5, 0.01)), verify=verifier, strategy="gradient", margin=Margin(PUSH))
    best = next(c for c in result.history if c.parameters == result.best_parameters)
    assert needed <= best.reserve <= needed + 0.01 + 1e-4
    assert all(c.dynamic != "stands" or c.volume >= best.volume for c in result.history)


def test_what_falls_with_some_reserve_is_asked_for_more_than_that(monkeypatch):
    # On coarse steps a design has more reserve than it was asked for; asked for less than that it would come again.
    asked, fallen = [], []
    honest = Descent.down

    def down(self, least):
        asked.append(least)
        return honest(self, least)

    def verifier(assembly):
        limit = limit_load(assembly, acceleration(assembly, PUSH)).lower
        if limit < 0.15:
            fallen.append(limit)
        return Judgement(Word.STANDS if limit >= 0.15 else Word.FALLS)

    monkeypatch.setattr(Descent, "down", down)
    scene = piers(2.5, between(0.7, 1.3, 0.2))
    result = search(scene, verify=verifier, strategy="gradient", margin=Margin(PUSH), snap=True)
    assert result.best is not None
    assert len(fallen) == 2
    assert all(least > reserve - 1e-6 for reserve, least in zip(fallen, asked[1:3], strict=True))
    # Between the reserves of the last that fell and of the one that stands there is no other step.
    assert all(fallen[-1] < least < asked[2] for least in asked[3:])


@pytest.mark.slow
def test_no_design_of_a_front_is_lighter_and_safer_than_another():
    result = search(portal(), verify=None, strategy="pareto", margin=Margin(PUSH, 0.02), points=4)
    volumes, reserves = [c.volume for c in result.front], [c.reserve for c in result.front]
    assert len(result.front) >= 3
    assert volumes == sorted(volumes)
    assert reserves == sorted(reserves)
    assert result.best_parameters == result.front[0].parameters
    for candidate in result.front:
        asm = build(with_values(portal(), candidate.parameters))
        assert limit_load(asm, acceleration(asm, PUSH)).lower == pytest.approx(candidate.reserve, rel=1e-6)
        assert candidate.stands


def test_too_many_combinations_of_what_is_counted_are_refused():
    scene = scene_from(
        {"name": "many", "parameters": {"n": between(3, 90, 1)},
         "elements": {"a": {"kind": "arch", "span": 2.0, "thickness": 0.3, "depth": 0.5, "voussoirs": "= n"}}}
    )  # fmt: skip
    with pytest.raises(InputError, match="88 combinations"):
        search(scene, verify=None, strategy="gradient")


def test_an_interrupted_descent_ends_with_the_same_history(tmp_path):
    scene = piers(2.5, between(0.5, 1.5, 0.01))
    options = {"verify": None, "strategy": "gradient", "margin": Margin(PUSH)}
    whole = search(scene, **options)
    path = tmp_path / "history.csv"

    def interrupt(done, expected, last):
        if done == 3:
            raise KeyboardInterrupt

    assert not search(scene, **options, history=path, progress=interrupt).finished
    again = search(scene, **options, history=path)
    assert rows(again) == rows(whole)
    with pytest.raises(InputError, match="of another search"):
        search(scene, **{**options, "margin": replace(options["margin"], least=0.1)}, history=path)


@pytest.mark.slow
@pytest.mark.parametrize("snap", [False, True])
def test_where_more_reserve_does_not_help_a_heavier_design_is_offered(snap):
    # Only nearly the heaviest designs stand by this verifier, and no design has the reserve that tells them apart.
    scene = portal()
    sizes = [build(with_values(scene, values)) for values in space_of(scene).grid()]
    most = max(asm.volume[asm.free].sum() for asm in sizes)

    def verify(asm):
        return Judgement(Word.STANDS if asm.volume[asm.free].sum() > 0.95 * most else Word.FALLS)

    result = search(scene, verify=verify, strategy="gradient", margin=Margin(PUSH, 0.05), snap=snap)
    assert result.best is not None
    best = build(result.best)
    assert best.volume[best.free].sum() > 0.95 * most
    assert limit_load(best, acceleration(best, PUSH)).lower >= 0.05


def test_less_friction_is_refused_at_once_where_a_joint_law_has_its_own():
    scene = scene_from(
        {
            "name": "pier",
            "parameters": {"w": between(0.5, 1.5, 0.01)},
            "elements": {"pier": {"kind": "box", "size": ["= w", 1.0, 3.0]}},
            "joints": [{"between": ["pier", "*"], "friction": 0.5}],
        }
    )
    for strategy in ("gradient", "pareto"):
        with pytest.raises(InputError, match="friction of joint laws is not divided"):
            search(scene, verify=None, strategy=strategy, margin=Margin(PUSH, friction=1.5))
    space = space_of(scene)
    with pytest.raises(InputError, match="friction of joint laws is not divided"):
        measure(lambda v: build(space.near(v)), space.start, ["parameters.w"], Margin(PUSH, friction=1.5))


def test_a_front_of_piers_grows_from_the_least_reserve_to_that_of_the_widest():
    scene = piers(2.5, between(0.6, 0.9, 0.01))
    result = search(scene, verify=None, strategy="pareto", margin=Margin(PUSH, 0.01), points=2)
    lightest, widest = result.front
    asm = build(with_values(scene, {"parameters.w": 0.9}))
    most = limit_load(asm, acceleration(asm, PUSH)).lower
    assert lightest.reserve == pytest.approx(0.01, abs=1e-3)
    assert widest.reserve == pytest.approx(most, abs=1e-3)
    assert lightest.volume < widest.volume
    assert result.best_parameters == lightest.parameters


def test_a_front_has_only_what_the_verifier_sees_stand():
    fallen = lambda assembly: Judgement(Word.FALLS)  # noqa: E731
    scene = piers(2.5, between(0.7, 0.9, 0.1))
    result = search(scene, verify=fallen, strategy="pareto", margin=Margin(PUSH, 0.01), points=2)
    assert result.front == ()
    assert result.best is None


def test_of_designs_the_light_and_safe_are_kept():
    def design(volume, reserve):
        return Candidate({}, "stable", None, "static", volume, 1, 0.0, 0.0, reserve=reserve)

    light, safe, heavy, worse = design(1.0, 0.1), design(2.0, 0.3), design(3.0, 0.3), design(1.0, 0.05)
    unknown = design(0.5, None)
    assert undominated([heavy, safe, worse, light]) == (light, safe)
    assert undominated([light, unknown]) == (unknown, light)
    assert undominated([]) == ()


def test_what_was_asked_before_keeps_its_verdict_and_gains_a_reserve_and_slopes():
    scene = piers(2.5, between(0.6, 0.9, 0.1))
    evaluator = Evaluator(space_of(scene), Callbacks(assess, lambda assembly: Judgement(Word.STANDS)), None)
    before = evaluator.ask({"parameters.w": 0.9})
    assert (before.dynamic, before.reserve, before.slopes) == ("stands", None, ())
    after = Descent(evaluator, Margin(PUSH), {}, ("parameters.w",)).measured(np.ones(1))
    asm = build(with_values(scene, {"parameters.w": 0.9}))
    assert after.reserve == pytest.approx(limit_load(asm, acceleration(asm, PUSH)).lower, rel=1e-4)
    assert after.slopes[0] == pytest.approx(2 * 2.5, rel=1e-6)  # of the volume: two piers 2.5 m high
    assert replace(after, reserve=None, slopes=()) == before


@pytest.mark.parametrize(("snap", "offered"), [(False, 0.92), (True, 1.0)], ids=["any", "on steps"])
def test_after_a_fall_the_next_measured_design_that_is_clearly_heavier_is_offered(snap, offered):
    # 0.65 m is below the least width. 0.8 m falls; with the arch, of 3.9 m2, 0.83 and 0.85 m weigh less than 5 % more.
    scene, asked = piers(2.5, between(0.6, 1.4, 0.05)), []

    def verify(assembly):
        asked.append(assembly)
        return Judgement(Word.STANDS if len(asked) > 1 else Word.FALLS)

    evaluator = Evaluator(space_of(scene), Callbacks(assess, verify), None)
    descent = Descent(evaluator, Margin(PUSH), {}, ("parameters.w",))
    for width in (1.2, 0.65, 1.0, 0.92, 0.85, 0.83, 0.8):
        descent.measured(np.array([(width - 0.6) / 0.8]))
    assert _met(evaluator, 0.01, snap=snap) == {"parameters.w": pytest.approx(offered)}
    assert len(asked) == 2
    assert _met(evaluator, 9.0, snap=snap) is None


def crowded(**parameters):
    """A block that overlaps another one beside it where it is wider than 1.5 m (and, where they say so, n is 1)."""
    apart = "= 1.0 + 5 * (n - 1)" if "n" in parameters else 1.0
    elements = {
        "wide": {"kind": "box", "size": ["= w", 1.0, "= h" if "h" in parameters else 1.0]},
        "beside": {"kind": "box", "size": [0.5, 0.5, 0.5], "at": [apart, 0, 0]},
    }
    if "n" in parameters:
        elements["counted"] = {"kind": "box", "size": ["= n", 1.0, 1.0], "at": [-9, 0, 0]}
    return scene_from({"name": "crowded", "parameters": parameters, "elements": elements})


@pytest.mark.parametrize(
    ("others", "expected"),
    [
        ({}, {}),
        ({"n": between(1, 2, 1)}, {"parameters.n": 1.0}),
        ({"h": between(1.0, 1.5, 0.1)}, {"parameters.h": 1.0}),
    ],
    ids=["one combination", "two combinations", "two that move"],
)
def test_where_the_largest_design_overlaps_a_descent_begins_at_a_smaller_one(others, expected):
    # A block of width w and height h tips at a push of w / h.
    scene = crowded(w=between(0.25, 1.75, 0.125), **others)
    result = search(scene, verify=None, strategy="gradient", margin=Margin(PUSH, 0.3))
    assert result.best_parameters == pytest.approx({"parameters.w": 0.3} | expected, abs=1e-4)


def test_a_front_grows_up_to_the_largest_design_that_is_built():
    scene = crowded(w=between(0.25, 1.75, 0.125))
    result = search(scene, verify=None, strategy="pareto", margin=Margin(PUSH, 0.3), points=2)
    # Blocks wider than 0.7 m, the coefficient of friction times their height, slide before they tip.
    assert [c.reserve for c in result.front] == pytest.approx([0.3, 0.7], abs=1e-4)


def test_a_combination_of_which_no_design_is_built_is_left_with_the_reason():
    scene = crowded(w=between(1.6, 2.0, 0.1), n=between(1, 2, 1))
    result = search(scene, verify=None, strategy="gradient", margin=Margin(PUSH, 0.3))
    assert result.best_parameters == pytest.approx({"parameters.w": 1.6, "parameters.n": 2.0})
    failed = [c for c in result.history if c.failed]
    assert {c.parameters["parameters.n"] for c in failed} == {1.0}
    assert f"{len(failed)} of {len(result.history)} designs could not be judged" in result.explain()


def test_an_interrupted_search_on_steps_offers_no_design_between_them():
    # The least width that a push of 0.33 asks of a block one high lies between steps.
    scene = scene_from(
        {"name": "one", "parameters": {"w": between(0.1, 1.0, 0.1)},
         "elements": {"block": {"kind": "box", "size": ["= w", 1.0, 1.0]}}}
    )  # fmt: skip
    options = {"verify": None, "strategy": "gradient", "margin": Margin(PUSH, 0.33)}

    def interrupt(done, expected, last):
        if last.reserve == pytest.approx(0.33, abs=1e-3):
            raise KeyboardInterrupt

    between_steps = search(scene, **options, progress=interrupt)
    assert between_steps.best_parameters == {"parameters.w": pytest.approx(0.33, abs=1e-3)}
    on_steps = search(scene, **options, snap=True, progress=interrupt)
    assert not on_steps.finished
    assert on_steps.best_parameters == {"parameters.w": 1.0}
