"""The lightest design under imperfections or below a probability of failure: pillars that tip at (b - 2 delta) / h."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from blockstat import FailureTarget, Imperfections, InputError, Margin, Random, assess, build, scene_from, search
from blockstat.design_search.descent import Descent
from blockstat.design_search.evaluator import Callbacks, Evaluator
from blockstat.design_search.search import _lightest_so_far
from blockstat.design_search.space import space_of

#: A pillar 1 m high and b wide, of one course on the ground; with this friction it does not slide.
TABLES = {
    "name": "pillar",
    "parameters": {"b": {"value": 0.8, "min": 0.2, "max": 0.8, "step": 0.05}},
    "material": {"friction": 2.0},
    "elements": {"pillar": {"kind": "pier", "size": ["= b", 0.5], "height": 1.0, "courses": 1}},
}
PILLAR = scene_from(TABLES)
PUSH = Margin((1.0, 0.0, 0.0), 0.3)
ALONG = {"direction": (1.0, 0.0, 0.0)}


def width(**options):
    found = search(PILLAR, verify=None, **options)
    return found, found.best_parameters["parameters.b"]


@pytest.mark.parametrize("delta", [0.0, 0.01, 0.03])
def test_edges_that_are_lost_make_the_pillar_as_much_wider(delta):
    allowed = Imperfections(edge=delta)
    _, b = width(strategy="robust", margin=PUSH, imperfections=allowed)
    assert b == pytest.approx(0.3 + 2 * delta, abs=1e-4)
    assert b >= 0.3 + 2 * delta
    assert width(strategy="gradient", margin=PUSH, imperfections=allowed)[1] == b
    snapped = width(strategy="robust", margin=PUSH, imperfections=allowed, snap=True)[1]
    assert snapped == pytest.approx(min(w for w in (0.3, 0.35, 0.4) if w >= b - 1e-9), abs=1e-9)


def test_friction_is_divided_in_the_worst_case():
    """It slides at mu / 1.25 whatever its width: no design of friction .35 has a reserve of .3."""
    weak = scene_from({**TABLES, "material": {"friction": 0.35}})
    options = {"verify": None, "strategy": "robust", "margin": PUSH}
    assert search(weak, imperfections=Imperfections(friction=1.1), **options).best_parameters is not None
    assert search(weak, imperfections=Imperfections(friction=1.25), **options).best_parameters is None


def test_other_strategies_judge_the_worst_case_too():
    """A joint that loses all it has carries nothing."""
    half = {"imperfections": Imperfections(edge=0.16)}
    assert width(strategy="pruned")[1] == pytest.approx(0.2)
    assert width(strategy="pruned", **half)[1] == pytest.approx(0.35)
    assert width(strategy="pruned", over="grid", **half)[1] == pytest.approx(0.35)


#: What a design is heavier for its draws, in standard deviations: 400 draws tell a probability to about a third.
SURE = 0.15


def test_a_descent_begins_at_a_smaller_design_where_the_largest_cannot_be():
    """The pillar is 1 - a - b wide, which is none at a = b = 0.6."""
    pillar = {"kind": "pier", "size": ["= 1 - a - b", 0.5], "height": 1.0, "courses": 1}
    bars = {name: {"value": 0.2, "min": 0.2, "max": 0.6, "step": 0.2} for name in "ab"}
    tables = {**TABLES, "parameters": bars, "elements": {"pillar": pillar}}
    found = search(scene_from(tables), verify=None, strategy="gradient", margin=PUSH)
    assert 1 - sum(found.best_parameters.values()) == pytest.approx(0.3, abs=1e-4)
    push, target = norm(0.2, 0.05), FailureTarget(0.05, {"push": Random("normal", 0.2, 0.05)}, **ALONG)
    found = search(scene_from(tables), verify=None, strategy="robust", target=target)
    assert push.isf(0.05) <= 1 - sum(found.best_parameters.values()) <= push.isf(0.05) + SURE * 0.05
    # Where none can be built, the rows say why.
    tables["elements"] = {"pillar": pillar | {"size": ["= 0.4 - a - b + 1e-15", 0.5]}}
    found = search(scene_from(tables), verify=None, strategy="robust", target=target)
    assert found.outcome.word == "failed"
    assert found.history


@pytest.mark.parametrize("probability", [0.05, 1e-3])
def test_a_random_push_asks_for_its_quantile(probability):
    """It tips at b: the probability of a design is known, and below the target, as its draws show."""
    push = norm(0.2, 0.05)
    uncertain = {"push": Random("normal", 0.2, 0.05)}
    found, b = width(strategy="robust", target=FailureTarget(probability, uncertain, **ALONG))
    low, high = found.assured.draws.interval
    assert low <= push.sf(b) <= high <= probability
    assert push.isf(probability) <= b <= push.isf(probability) + SURE * 0.05
    assert found.assured.first.probability == pytest.approx(push.sf(b), rel=0.02)
    assert found.summary()["failure"]["draws"] == 400


def test_more_draws_need_less_stone():
    """With 1500 draws a probability is known to a seventh."""
    push, uncertain = norm(0.2, 0.05), {"push": Random("normal", 0.2, 0.05)}
    few, many = (
        width(strategy="robust", target=FailureTarget(1e-3, uncertain, draws=n, **ALONG))[1] for n in (60, 1500)
    )
    assert push.isf(1e-3) < many < few
    assert push.sf(many) > 0.8e-3


def test_a_design_that_tips_to_both_sides_is_below_the_target():
    """A push of mean 0: it falls with 2 Phi(-b / sd), twice what the design point says."""
    uncertain = {"push": Random("normal", 0.0, 0.1)}
    found, b = width(strategy="robust", target=FailureTarget(0.01, uncertain, **ALONG))
    exact = 2 * norm.sf(b, 0, 0.1)
    low, high = found.assured.draws.interval
    assert low <= exact <= high <= 0.01
    assert found.assured.first.probability == pytest.approx(exact / 2, rel=0.02)


def test_a_design_that_the_descent_leaves_a_little_too_light_is_made_heavier():
    """The rounds settle on one arch whose worst point lacks more than is allowed."""
    ring = {"kind": "arch", "span": 1.8, "depth": 0.5, "voussoirs": 20}
    ring["thickness"] = {"value": 0.5, "min": 0.12, "max": 0.5, "step": 0.01}
    uncertain = {"edge": Random("uniform", 0, 0.02), "push": Random("normal", 0.15, 0.04)}
    target = FailureTarget(0.01, uncertain, **ALONG)
    arch = scene_from({"name": "arch", "elements": {"ring": ring}})
    found = search(arch, verify=None, strategy="robust", target=target)
    assert found.outcome.word == "found"
    assert 0.005 < found.assured.first.probability <= 0.01
    assert found.assured.draws.interval[1] <= 0.01


def test_two_random_variables_share_what_they_ask_for():
    """b - 2 delta = push, both normal: beta = (b - .02 - .2) / sqrt(.05^2 + .008^2)."""
    uncertain = {"push": Random("normal", 0.2, 0.05), "edge": Random("normal", 0.01, 0.004)}
    found, b = width(strategy="robust", target=FailureTarget(0.01, uncertain, **ALONG))
    both = norm(0.22, (0.05**2 + 0.008**2) ** 0.5)
    low, high = found.assured.draws.interval
    assert low <= both.sf(b) <= high <= 0.01
    assert both.isf(0.01) <= b <= both.isf(0.01) + SURE * both.std()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"strategy": "robust"}, 'strategy "robust" needs imperfections, or a target'),
        ({"strategy": "gradient", "target": FailureTarget(0.1)}, 'a target is for strategy "robust"'),
        ({"strategy": "robust", "target": FailureTarget(0.1)}, "nothing pushes; give a direction"),
        (
            {
                "strategy": "robust",
                "target": FailureTarget(0.1, {"friction": Random("normal", 1, 0.1, "joint")}, **ALONG),
            },
            '"friction" has values of its own',
        ),
    ],
)
def test_what_does_not_go_together_is_said(options, message):
    with pytest.raises(InputError, match=message):
        search(PILLAR, verify=None, **options)


@pytest.mark.parametrize("probability", [0.0, 0.5, 2.0])
def test_a_target_is_a_small_probability(probability):
    with pytest.raises(InputError, match=r"above 0 and below 0\.5"):
        FailureTarget(probability)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"probability": "a"}, "probability"), ({"probability": None}, "probability"),
        ({"probability": 0.1, "direction": (0, 0.1)}, "direction"),
        ({"probability": 0.1, "direction": "x"}, "direction"), ({"probability": 0.1, "draws": 1.5}, "draws"),
    ],
)  # fmt: skip
def test_a_target_that_says_no_numbers_is_told_by_its_part(given, named):
    with pytest.raises(InputError, match=f"target: {named} is "):
        FailureTarget(**given)


def test_a_target_that_no_width_reaches_has_no_design():
    """The widest pillar tips at 0.8: a push of 0.9 on average topples it more often than not."""
    uncertain = {"push": Random("normal", 0.9, 0.05)}
    found = search(PILLAR, verify=None, strategy="robust", target=FailureTarget(0.05, uncertain, **ALONG))
    assert (found.best, found.best_parameters, found.assured) == (None, None, None)
    assert found.outcome.word == "none_stands"
    assert found.summary()["failure"] is None


def wind(assembly, **options):
    """The verdict under a push H at half the height that tips a pillar narrower than .5 m: rho g .5 b b / 2 = H / 2."""
    push = np.zeros((assembly.n_blocks, 6))
    push[assembly.free, 0] = assembly.density[assembly.free] * 9.81 * 0.5**2 / 2
    return assess(assembly, loads=push, **options)


STRATEGIES = [
    {"strategy": "gradient", "margin": PUSH},
    {"strategy": "pareto", "margin": PUSH, "points": 3},
    {"strategy": "robust", "margin": PUSH, "imperfections": Imperfections(friction=1.1)},
    {"strategy": "robust", "target": FailureTarget(0.05, {"push": Random("normal", 0.2, 0.05)}, draws=60, **ALONG)},
]


@pytest.mark.parametrize("options", STRATEGIES, ids=["gradient", "pareto", "robust", "target"])
def test_a_design_that_statics_call_unstable_is_never_offered(options):
    """The reserve alone asks for a width of .3 m."""
    found, b = width(static=wind, **options)
    assert b >= 0.5
    assert all(c.parameters["parameters.b"] >= 0.5 for c in found.front)
    pruned = [c for c in found.history if c.dynamic == "pruned"]
    assert all(c.parameters["parameters.b"] < 0.5 for c in pruned)
    assert pruned or options["strategy"] == "robust"  # rounds of a target have rows of their own


@pytest.mark.parametrize("options", STRATEGIES, ids=["gradient", "pareto", "robust", "target"])
def test_statics_that_fail_are_told(options):
    with pytest.raises(ZeroDivisionError):
        search(PILLAR, verify=None, static=lambda assembly, **_: 1 / 0, **options)


@pytest.mark.parametrize(("static", "offered"), [(assess, {"parameters.b": 0.4}), (wind, None)])
def test_an_interrupted_search_offers_no_design_without_the_reserve_or_that_statics_rule_out(static, offered):
    """A pillar of .25 m stands, with a reserve of .25; the wind tips one of .4 m."""
    evaluator = Evaluator(space_of(PILLAR), Callbacks(static, None), None)
    descent = Descent(evaluator, PUSH, {}, ("parameters.b",))
    assert [descent.measured(np.array([(b - 0.2) / 0.6])).stands for b in (0.8, 0.4, 0.25)] == [True] * 3
    assert _lightest_so_far(evaluator, PUSH.least) == offered


def test_the_best_at_an_end_that_has_no_last_digit_is_offered():
    """The widest pillar, 2/3 m, has a reserve of 2/3."""
    thirds = {"value": 0.5, "min": 1 / 3, "max": 2 / 3, "step": 1 / 3}
    scene = scene_from({**TABLES, "parameters": {"b": thirds}})
    found = search(scene, verify=None, strategy="gradient", margin=Margin((1.0, 0.0, 0.0), 2 / 3 - 1e-6))
    assert 2 / 3 - 2e-6 <= found.best_parameters["parameters.b"] <= 2 / 3
    assert found.history[0].parameters == {"parameters.b": 2 / 3}


class Slender:
    """A dynamic verifier in which pillars of less than .36 m fall; it notes whom it is asked about."""

    def __init__(self):
        self.asked = []

    def __call__(self, assembly):
        self.asked.append(float(assembly.volume[assembly.free].sum() / 0.5))
        return SimpleNamespace(outcome=SimpleNamespace(word="stands" if self.asked[-1] >= 0.36 else "falls"))


def test_the_rounds_of_a_target_simulate_each_design_once_and_all_of_them_count(tmp_path):
    target = FailureTarget(0.05, {"push": Random("normal", 0.2, 0.05)}, draws=60, **ALONG)
    options = {"strategy": "robust", "target": target, "history": tmp_path / "history.csv"}
    verifier = Slender()
    found = search(PILLAR, verify=verifier, **options)
    assert len(verifier.asked) > 2
    np.testing.assert_allclose([c.parameters["parameters.b"] for c in found.history], verifier.asked, rtol=1e-9)
    assert len(set(verifier.asked)) == len(verifier.asked) == found.dynamic_runs
    assert found.best_parameters["parameters.b"] >= 0.36
    assert found.confirmation.outcome.word == "stands"
    assert {c.dynamic for c in found.history} == {"stands", "falls"}
    again = Slender()
    resumed = search(PILLAR, verify=again, **options)
    assert (again.asked, resumed.best_parameters) == ([], found.best_parameters)


def test_an_interrupted_search_for_a_target_offers_nothing():
    """The first design that is simulated stands, and is lighter than the target asks for."""

    def verify(assembly):
        return SimpleNamespace(outcome=SimpleNamespace(word="stands"))

    def interrupt(done, expected, last):
        if last.dynamic == "stands":
            raise KeyboardInterrupt

    target = FailureTarget(0.05, {"push": Random("normal", 0.2, 0.05)}, draws=60, **ALONG)
    found = search(PILLAR, verify=verify, strategy="robust", target=target, progress=interrupt)
    assert (found.finished, found.best, found.dynamic_runs) == (False, None, 1)


def test_a_target_takes_the_push_of_the_scene_beside_other_variables():
    """A direction of length 2 makes the push twice as strong."""
    push = {"kind": "normal", "mean": 0.2, "deviation": 0.05, "direction": [2.0, 0.0, 0.0]}
    scene = build(scene_from({**TABLES, "uncertain": {"push": push}}))
    friction = Random("normal", 2.0, 0.1)
    uncertain, direction = FailureTarget(0.1, {"friction": friction}).variables(scene)
    assert uncertain == {"friction": friction, "push": Random("normal", 0.4, 0.1)}
    assert direction == (2.0, 0.0, 0.0)
