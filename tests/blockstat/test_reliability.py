"""Random friction, joints, weights and loads: probabilities that are known."""

import json
import math
import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import binom, chi2, norm
from test_imperfections import on_grounds, table

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    Random,
    Tie,
    acceleration,
    box,
    find_interfaces,
    first_order,
    fragility,
    limit_load,
    read,
    reliability,
    reserve_map,
    write,
)
from blockstat.chance.first_order import CARRIES_NONE, MOVES_NOTHING, OFF_BORDER, FirstOrderOutcome
from blockstat.chance.limit_state import MANY, limit_state
from blockstat.chance.monte_carlo import ReliabilityOutcome, _about, _binomial, _weighted
from blockstat.chance.population import Population
from blockstat.chance.trials import Trials
from blockstat.loads import WeightedLoads
from evidence.scenes.small import arch, stack
from overhang import apex, overhanging, ridge

SIDE = (1, 0, 0)
FLAT, TALL = stack(1, 2.0, 0.5, friction=0.6), stack(1, 1.0, 2.0, friction=2.0)
BOTH = stack(1, 1.0, 2.0, friction=0.6)

FRICTION, PUSH = norm(0.6, 0.1), norm(0.3, 0.15)
#: Name, scene, variables, load, what falls in closed form, probability: sliding, tipping at b / h = .5, and either.
KNOWN = [
    (
        "slides",
        FLAT,
        {"friction": Random("normal", 0.6, 0.1)},
        0.5,
        lambda z: 0.6 + 0.1 * z[0] < 0.5,
        FRICTION.cdf(0.5),
    ),
    ("tips", TALL, {"push": Random("normal", 0.3, 0.15)}, 1.0, lambda z: 0.3 + 0.15 * z[0] > 0.5, PUSH.sf(0.5)),
    (
        "slides or tips",
        BOTH,
        {"friction": Random("normal", 0.6, 0.1), "push": Random("normal", 0.3, 0.15)},
        1.0,
        lambda z: abs(0.3 + 0.15 * z[1]) > np.minimum(0.6 + 0.1 * z[0], 0.5),
        quad(lambda mu: FRICTION.pdf(mu) * (PUSH.sf(min(mu, 0.5)) + PUSH.cdf(-min(mu, 0.5))), 0, 2, points=[0.5])[0],
    ),
]
COLUMNS = ("name", "scene", "uncertain", "push", "falls", "exact")
SCENES = pytest.mark.parametrize(COLUMNS, KNOWN, ids=[row[0] for row in KNOWN])


def load_of(scene, push):
    return push * acceleration(scene, SIDE)


@SCENES
def test_every_draw_is_judged_as_the_closed_form_says(name, scene, uncertain, push, falls, exact):
    found = reliability(scene, uncertain, load=load_of(scene, push), draws=200, seed=1)
    rng = np.random.default_rng(1)
    count = sum(bool(falls(rng.standard_normal(len(uncertain)))) for _ in range(200))
    assert (found.failures, found.undecided) == (count, 0)
    assert found.probability == count / 200
    assert found.reused > 150


@pytest.mark.parametrize("prop", [apex(1.5 - 1e-3), ridge(1.5 - 1e-3)], ids=["corner", "edge"])
def test_a_slab_falls_in_the_draws_that_lose_the_strip_on_which_its_prop_bears(prop):
    """The prop is 1 mm from the rim of the slab, which overhangs its table and loses up to 4 mm."""
    found = reliability(overhanging(prop)[0], {"edge": Random("uniform", 0.0, 4e-3)}, draws=100, seed=1)
    lost = 4e-3 * norm.cdf(np.random.default_rng(1).standard_normal(100))
    assert (found.failures, found.undecided) == ((lost > 1e-3).sum(), 0)


@pytest.mark.parametrize(
    ("failures", "draws", "low", "high"), [(0, 10, 0.0, 0.3085), (5, 20, 0.0866, 0.4910), (10, 10, 0.6915, 1.0)]
)
def test_the_interval_is_that_of_clopper_and_pearson(failures, draws, low, high):
    """As tabulated in textbooks."""
    share, interval = _binomial(failures, 0, draws, 0.95)
    assert share == failures / draws
    assert interval == pytest.approx((low, high), abs=5e-5)
    wider = _binomial(failures - 1, 1, draws, 0.95)[1] if failures else interval
    assert wider[0] <= interval[0]
    assert wider[1] == interval[1]


@pytest.mark.parametrize(("confidence", "most"), [(0.95, 0.30850), (0.5, 0.12945)])
def test_an_interval_without_failures_ends_where_the_confidence_says(confidence, most):
    """No failure in 10 draws: 1 - ((1 - c) / 2)^(1 / 10). A flat block with a friction of .6 bears a push of .2."""
    push = {"push": Random("uniform", 0.1, 0.2)}
    found = reliability(FLAT, push, load=SIDE, draws=10, confidence=confidence)
    assert (found.failures, found.undecided) == (0, 0)
    assert found.interval == pytest.approx((0.0, 1 - ((1 - confidence) / 2) ** 0.1), rel=1e-9)
    assert found.interval[1] == pytest.approx(most, abs=5e-6)


@pytest.mark.slow
@SCENES
def test_the_interval_holds_the_known_probability_as_often_as_it_says(name, scene, uncertain, push, falls, exact):
    """95 of 100 seeds, and no fewer than chance explains (three standard deviations)."""
    load = load_of(scene, push)
    found = [reliability(scene, uncertain, load=load, draws=60, seed=seed).interval for seed in range(100)]
    assert sum(low <= exact <= high for low, high in found) >= 95 - 3 * math.sqrt(100 * 0.95 * 0.05)


def test_evidence_of_earlier_draws_changes_no_verdict():
    scene = arch(9, 0.2)
    uncertain = {"friction": Random("lognormal", 0.6, 0.15), "edge": Random("uniform", 0.0, 0.04)}
    load = load_of(scene, 0.2)
    one, two = (reliability(scene, uncertain, load=load, draws=60, seed=3, reuse=reuse) for reuse in (True, False))
    assert (one.failures, one.interval) == (two.failures, two.interval)
    assert 0 < one.failures < 60
    assert one.reused > 0
    side_by_side = reliability(scene, uncertain, load=load, draws=60, seed=3, jobs=2)
    assert (side_by_side.failures, side_by_side.interval) == (one.failures, one.interval)
    assert two.reused == 0


def test_a_linear_limit_state_has_an_exact_first_order_answer():
    """mu - push, both normal: beta = (.6 - .3) / sqrt(.1^2 + .15^2), shares as the variances."""
    uncertain = {"friction": Random("normal", 0.6, 0.1), "push": Random("normal", 0.3, 0.15)}
    found = first_order(FLAT, uncertain, SIDE)
    assert found.outcome is FirstOrderOutcome.FOUND
    beta = 0.3 / math.hypot(0.1, 0.15)
    assert found.beta == pytest.approx(beta, rel=1e-4)
    assert found.probability == pytest.approx(norm.cdf(-beta), rel=1e-3)
    assert found.shares["push"] == pytest.approx(0.15**2 / (0.1**2 + 0.15**2), rel=1e-3)
    assert found.values["friction"] == pytest.approx(found.values["push"], rel=1e-4)


def test_a_mean_that_falls_has_a_negative_beta():
    found = first_order(FLAT, {"push": Random("normal", 0.7, 0.1)}, SIDE)
    assert found.beta == pytest.approx(-1.0, rel=1e-4)


def test_draws_about_the_design_point_find_a_small_probability():
    """Phi(-4) = 3.2e-5 by 300 draws."""
    uncertain = {"push": Random("normal", 0.3, 0.05)}
    point = first_order(TALL, uncertain, SIDE)
    assert point.beta == pytest.approx(4.0, rel=1e-4)
    found = reliability(TALL, uncertain, load=SIDE, draws=300, about=point)
    exact = norm.cdf(-4.0)
    assert found.interval[0] <= exact <= found.interval[1]
    assert found.interval[1] - found.interval[0] < exact


#: What is weighed: what falls on one side, a small probability, both sides, and two mechanisms.
WEIGHED = [
    ("one side", TALL, {"push": Random("normal", 0.3, 0.1)}, lambda z: 0.3 + 0.1 * z[..., 0] > 0.5, norm.cdf(-2)),
    ("seldom", TALL, {"push": Random("normal", 0.3, 0.05)}, lambda z: 0.3 + 0.05 * z[..., 0] > 0.5, norm.cdf(-4)),
    ("two sides", TALL, {"push": Random("normal", 0, 0.2)}, lambda z: abs(0.2 * z[..., 0]) > 0.5, 2 * norm.cdf(-2.5)),
    (
        "slides or tips",
        BOTH,
        KNOWN[2][2],
        lambda z: abs(0.3 + 0.15 * z[..., 1]) > np.minimum(0.6 + 0.1 * z[..., 0], 0.5),
        KNOWN[2][-1],
    ),
]
WEIGHED = pytest.mark.parametrize(
    ("name", "scene", "uncertain", "falls", "exact"), WEIGHED, ids=[w[0] for w in WEIGHED]
)


def band(seeds):
    """Of so many intervals of 95 % the fewest that hold what they should, with a chance of one in forty of fewer."""
    return binom(seeds, 0.95).ppf(0.025)


@WEIGHED
@pytest.mark.parametrize("draws", [3, 20, 60, 400])
def test_weighted_intervals_hold_the_known_probability_as_often_as_they_say(
    name, scene, uncertain, falls, exact, draws
):
    """By the closed form of what falls, with the draws and weights of `reliability`."""
    population = Population(scene, find_interfaces(scene), None, uncertain)
    centre, held, sums = first_order(scene, uncertain, SIDE).point, 0, []
    for seed in range(300):
        trials = Trials(population, SIDE, centre, seed, reuse=True)
        fallen, weight = falls(trials.normals(draws)), trials.weights(draws)
        found, (low, high) = _weighted(weight, fallen, fallen, draws / (trials.turns(draws) == 0).sum(), 0.95)
        held += low <= exact <= high
        sums.append(found)
    assert held >= band(300)
    assert np.mean(sums) == pytest.approx(exact, abs=4 * np.std(sums) / math.sqrt(300))


@pytest.mark.parametrize("draws", [3, 20, 60, 400])
@pytest.mark.parametrize("mean", [0.55, 0.7, 0.8])
def test_weighted_intervals_of_a_mean_that_falls_hold_the_known_probability_as_often_as_they_say(mean, draws):
    """A block that tips at a push of .5, of more than that in the mean."""
    push = {"push": Random("normal", mean, 0.1)}
    population, exact = Population(TALL, find_interfaces(TALL), None, push), norm.cdf((mean - 0.5) / 0.1)
    about, held = first_order(TALL, push, SIDE), 0
    for seed in range(300):
        trials = Trials(population, SIDE, about.point, seed, reuse=True)
        fallen, weight = mean + 0.1 * trials.normals(draws)[:, 0] > 0.5, trials.weights(draws)
        largest = draws / (trials.turns(draws) == 0).sum()
        found, (low, high) = _about(about.beta, weight, fallen, fallen, largest, 0.95)
        held += low <= exact <= high
        assert 0 <= low <= found <= high <= 1
    assert held >= band(300)


def test_a_probability_near_one_is_told_by_the_draws_that_stand():
    """Phi(3) = .99865 of a block that tips at .5; undecided draws stand, but not at the upper end."""
    push = {"push": Random("normal", 0.8, 0.1)}
    about = first_order(TALL, push, SIDE)
    for seed in range(4):
        found = reliability(TALL, push, load=SIDE, about=about, draws=100, seed=seed)
        low, high = found.interval
        assert low <= found.probability <= high <= 1
        assert low <= norm.cdf(3.0) <= high
        assert high - low < 0.01
    weight, some = np.full(20, 0.01), np.arange(20) < 8
    stands = _weighted(weight, ~some, ~some, 4.0, 0.95)
    told, ends = _about(-1.0, weight, some, some, 4.0, 0.95)
    assert (1 - told, 1 - ends[1], 1 - ends[0]) == pytest.approx((stands[0], *stands[1]), abs=1e-12)
    wider = _about(-1.0, weight, np.arange(20) < 4, some, 4.0, 0.95)
    assert wider[0] == pytest.approx(1 - 0.01 * 16 / 20)
    assert wider[1][0] < ends[0]
    assert wider[1][1] == pytest.approx(ends[1])


@pytest.mark.parametrize("beta", [1.0, -1.0, math.nan])
def test_a_probability_from_weights_that_sum_to_too_much_is_not_out_of_range(beta):
    fallen = np.ones(20, dtype=bool) if not beta < 0 else np.zeros(20, dtype=bool)
    told, (low, high) = _about(beta, np.full(20, 3.0), fallen, fallen, 4.0, 0.95)
    assert told == (0.0 if beta < 0 else 1.0)
    assert 0 <= low <= told <= high <= 1


@pytest.mark.slow
@WEIGHED
def test_reliability_about_a_design_point_holds_the_known_probability(name, scene, uncertain, falls, exact):
    about = first_order(scene, uncertain, SIDE)
    found = [reliability(scene, uncertain, load=SIDE, draws=60, seed=seed, about=about) for seed in range(100)]
    assert sum(own.interval[0] <= exact <= own.interval[1] for own in found) >= band(100)
    assert sum(exact <= own.at_most for own in found) >= band(100)


def test_what_falls_to_the_other_side_of_the_design_point_is_seen():
    """A push of mean 0 tips a block at +-.5: 2 Phi(-2.5), of which draws about one point see half."""
    uncertain = {"push": Random("normal", 0.0, 0.2)}
    about, exact = first_order(TALL, uncertain, SIDE), 2 * norm.cdf(-2.5)
    found = reliability(TALL, uncertain, load=SIDE, draws=400, about=about)
    assert found.interval[0] <= exact <= found.interval[1] < 1.5 * exact
    said = found.explain()
    assert "drawn about the mean, the design point and its mirror image, weighted." in said
    assert f"seen by draws about the mean alone: at most {found.at_most:.4g}." in said
    assert found.summary()["at_most"] == found.at_most
    normal = np.random.default_rng(0).standard_normal(400)[::4]
    beyond = int((abs(0.2 * normal) > 0.5).sum())
    assert found.at_most == pytest.approx(binomial_bound(beyond, 100), rel=1e-9)
    assert reliability(TALL, uncertain, load=SIDE, draws=5).at_most is None


def binomial_bound(failures, draws):
    """The probability of which so few failures or fewer have a chance of 5 %."""
    return brentq(lambda p: binom(draws, p).cdf(failures) - 0.05, 1e-9, 1 - 1e-9, xtol=1e-14)


def test_without_failures_the_bound_is_that_of_the_largest_weight():
    """Of 40 draws a quarter are about the mean, so no weight is above 4: 4 / 40 ln 40 at 95 %."""
    uncertain = {"push": Random("normal", 0.3, 0.001)}
    about = replace(first_order(TALL, uncertain, SIDE), point=np.array([0.5]))
    found = reliability(TALL, uncertain, load=SIDE, draws=40, about=about)
    assert (found.failures, found.probability) == (0, 0.0)
    assert found.interval == pytest.approx((0.0, 0.1 * math.log(40)), rel=1e-12)


@pytest.mark.parametrize("failures", [10, 15])
def test_failures_of_one_weight_have_the_interval_of_poisson(failures):
    fallen = np.arange(20) < failures
    share, interval = _weighted(np.full(20, 0.3), fallen, fallen, 4.0, 0.95)
    assert share == pytest.approx(0.3 * failures / 20)
    ends = chi2.ppf(0.025, 2 * failures) / 2, chi2.ppf(0.975, 2 * failures + 2) / 2
    assert interval == pytest.approx([0.3 / 20 * end for end in ends], rel=1e-9)
    wider = _weighted(np.full(20, 0.3), fallen, np.arange(20) < failures + 1, 4.0, 0.95)[1]
    assert wider[0] == pytest.approx(interval[0])
    assert wider[1] > interval[1]


def test_half_of_the_draws_are_about_the_point_and_weights_are_bounded():
    population = Population(TALL, find_interfaces(TALL), None, {"push": Random("normal", 0.3, 0.05)})
    trials = Trials(population, SIDE, np.array([4.0]), 0, reuse=True)
    assert np.bincount(trials.turns(400) + 1).tolist() == [100, 100, 200]
    near = trials.normals(400) - 4.0 * trials.turns(400)[:, None]
    np.testing.assert_allclose(near, np.random.default_rng(0).standard_normal((400, 1)), atol=1e-12)
    weight = trials.weights(400)
    assert 0 < weight.min() < weight.max() <= 4.0
    z = trials.normals(400)[:, 0]
    mixture = norm.pdf(z) / 4 + norm.pdf(z - 4) / 2 + norm.pdf(z + 4) / 4
    assert weight == pytest.approx(norm.pdf(z) / mixture, rel=1e-9)
    np.testing.assert_array_equal(trials.normals(100), trials.normals(400)[:100])


def test_the_fragility_of_a_slab_is_the_distribution_of_its_friction():
    found = fragility(FLAT, {"friction": Random("uniform", 0.4, 0.8)}, SIDE, draws=100)
    assert found.min() >= 0.4 - 1e-6
    assert found.max() <= 0.8 + 1e-6
    assert (found < 0.5).mean() == pytest.approx(0.25, abs=0.1)


@pytest.mark.parametrize(
    ("kind", "first", "second", "mean", "deviation"),
    [
        ("normal", 2.0, 0.5, 2.0, 0.5),
        ("lognormal", 2.0, 0.5, 2.0, 0.5),
        ("uniform", 1.0, 3.0, 2.0, 2.0 / math.sqrt(12)),
    ],
)
def test_distributions_have_their_mean_and_deviation(kind, first, second, mean, deviation):
    variable = Random(kind, first, second)
    moments = [quad(lambda z, k=k: variable.value(z) ** k * norm.pdf(z), -9, 9)[0] for k in (1, 2)]
    assert moments[0] == pytest.approx(mean, rel=1e-7)
    assert math.sqrt(moments[1] - moments[0] ** 2) == pytest.approx(deviation, rel=1e-6)


def test_a_heavier_block_and_a_permanent_load_are_random_too():
    """A dead push P at the foot of a block of weight W slides at P > mu W, W uniform."""
    loads = np.zeros((2, 6))
    weight = TALL.mass[1] * np.linalg.norm(TALL.gravity)
    loads[1] = [0.3 * weight, 0, 0, 0, -0.3 * weight, 0]
    scene = TALL.with_(friction=0.5)
    density = {"density.*": Random("uniform", 0.4 * TALL.density[1], 0.8 * TALL.density[1])}
    found = reliability(scene, density, loads=loads, draws=150)  # falls below .6 of its density
    assert found.interval[0] <= 0.5 <= found.interval[1]
    factor = {"loads.*": Random("uniform", 1.0, 3.0)}  # falls above 5 / 3
    found = reliability(scene, factor, loads=loads, draws=300)
    assert found.interval[0] <= 2 / 3 <= found.interval[1]


@pytest.mark.parametrize(
    ("uncertain", "message"),
    [
        ({}, "nothing is uncertain"),
        ({"mu": Random("normal", 1, 1)}, 'uncertain "mu"; keys are: friction, edge, corner, push'),
        ({"density.nave": Random("normal", 1, 1)}, 'no group "nave"'),
        ({"loads.*": Random("normal", 1, 1)}, "there are no permanent loads"),
        ({"push": Random("normal", 1, 1)}, "load=, which is not given"),
    ],
)
def test_errors_say_what_is_wrong(uncertain, message):
    with pytest.raises(InputError, match=message):
        reliability(FLAT, uncertain)


@pytest.mark.parametrize("given", [("gamma", 1, 1), ("normal", 1, -1), ("lognormal", 0, 1), ("uniform", 2, 1)])
def test_a_distribution_that_is_none_is_refused(given):
    with pytest.raises(InputError):
        Random(*given)


def test_the_command_prints_a_probability(tmp_path):
    file = write(TALL, tmp_path / "block.json")
    arguments = [
        "reliability",
        file,
        "--uncertain",
        "push=normal,0.3,0.05",
        "--load",
        "1,0,0",
        "--draws",
        "50",
        "--json",
    ]
    answer = run(*arguments, "--first-order")
    assert answer.returncode == 0, answer.stderr
    found = json.loads(answer.stdout)
    assert found["first_order"]["beta"] == pytest.approx(4.0, rel=1e-4)
    assert found["interval"][0] <= norm.cdf(-4.0) <= found["interval"][1]
    answer = run("reliability", file, "--uncertain", "push=0.3", "--load", "1,0,0")
    assert answer.returncode == 2
    assert '--uncertain is "push=0.3"; it must read KEY=normal,MEAN,DEVIATION' in answer.stderr


def run(*arguments):
    code = "from blockstat.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


def per_joint(correlation):
    return Random("normal", 0.6, 0.1, "joint", correlation)


def slabs(number):
    """Slabs side by side on the ground: any of them slides by itself."""
    blocks = [box((-1, -1, -1), (4 * number, 3, 0))]
    blocks += [box((3 * k, 0, 0), (3 * k + 2, 2, 0.5), name=f"slab{k}", group=f"row{k % 2}") for k in range(number)]
    return Assembly.from_blocks(blocks, supports=[0], friction=0.6)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 1.0])
def test_the_weakest_of_many_joints_decides(correlation):
    """Four slabs pushed by half their weight; equicorrelated friction: an integral over what is common."""
    scene = slabs(4)
    found = reliability(scene, {"friction": per_joint(correlation)}, load=load_of(scene, 0.5), draws=400)
    own = math.sqrt(1 - correlation)

    def stand(common):
        level = -1.0 - math.sqrt(correlation) * common
        return norm.pdf(common) * (norm.sf(level / own) if own else float(level < 0)) ** 4

    exact = 1 - quad(stand, -8, 8, points=[-1.0], limit=200)[0]
    assert found.interval[0] <= exact <= found.interval[1]


def test_values_belong_to_joints_blocks_courses_and_groups():
    tower = stack(3, 1.0, 0.5).with_(groups=("ground", "wall", "wall", "top"))
    faces = find_interfaces(tower)
    counts = {"all": 1, "group": 2, "course": 3, "block": 3, "joint": 3}
    for each, count in counts.items():
        population = Population(tower, faces, None, {"friction": Random("normal", 0.6, 0.1, each)})
        assert population.size == count, each
    shared = Population(tower, faces, None, {"edge": Random("uniform", 0, 0.1, "joint", 0.3)})
    assert shared.size == 4
    two = slabs(4)  # one height, two groups
    for each, count in {"course": 2, "block": 4, "group": 2}.items():
        weights = {"density.*": Random("normal", 2000, 100, each)}
        assert Population(two, find_interfaces(two), None, weights).size == count, each


def test_correlated_values_have_their_correlation():
    scene = slabs(4)
    population = Population(scene, find_interfaces(scene), None, {"friction": per_joint(0.3)})
    rng = np.random.default_rng(0)
    values = np.array([population.realise(z).interfaces.friction for z in rng.standard_normal((4000, population.size))])
    np.testing.assert_allclose(np.corrcoef(values.T), 0.3 + 0.7 * np.eye(4), atol=0.06)
    np.testing.assert_allclose(values.std(axis=0), 0.1, rtol=0.05)


def test_a_corner_out_of_place_moves_the_hinge():
    """A column tips at (b + e) / h about its toe, e the lesser displacement of the two corners of the toe, to first
    order; between the corners the column turns about one of them."""
    column = stack(1, 0.5, 2.0, friction=2.0)
    uncertain = {"corner": Random("normal", 0.0, 0.002)}
    found = fragility(column, uncertain, load_of(column, 1.0), draws=60, seed=4)
    assert found.mean() == pytest.approx(0.25, abs=2e-3)
    assert 2e-4 < found.std() < 2e-3
    judged = reliability(column, uncertain, load=load_of(column, 0.25), draws=60, seed=4)
    assert judged.failures == (found < 0.25).sum()
    assert judged.undecided == 0


def test_first_order_shares_name_the_joint_that_matters():
    """Of three joints of a stack that slides, the lowest carries most and slips first; by the exact derivatives."""
    tower = stack(3, 2.0, 0.5, friction=0.6)
    load = 0.4 * acceleration(tower, SIDE)  # on the masses as drawn
    one = first_order(tower, {"friction": Random("normal", 0.6, 0.1)}, load)
    assert one.beta == pytest.approx(2.0, rel=1e-4)
    heavy = np.array([1.0, 3.0, 1.0, 1.0]) * tower.density
    lowest = np.zeros((4, 6))
    lowest[1, 0], lowest[1, 4] = 1.0, -0.25  # pushes the lowest block at its foot: mu times all the weight above
    found = first_order(tower.with_(density=heavy), {"friction": per_joint(0.0)}, lowest)
    total = float(heavy[1:] @ tower.volume[1:] * np.linalg.norm(tower.gravity))
    assert found.values["friction"] == pytest.approx((1.0 / total + 0.6 + 0.6) / 3, rel=1e-3)  # of three joints
    np.testing.assert_allclose(found.shares_by_value["friction"], [1.0, 0.0, 0.0], atol=1e-6)


def test_an_interrupted_run_goes_on_where_it_stopped(tmp_path):
    file = tmp_path / "draws.jsonl"
    uncertain = {"push": Random("normal", 0.3, 0.15)}

    def stop(done, draws):
        if done >= 100:
            raise KeyboardInterrupt

    stopped = reliability(TALL, uncertain, load=SIDE, draws=200, file=file, progress=stop)
    assert stopped.outcome is ReliabilityOutcome.STOPPED
    assert stopped.draws == 100
    until_then = reliability(TALL, uncertain, load=SIDE, draws=100)
    assert (stopped.failures, stopped.interval) == (until_then.failures, until_then.interval)
    assert len(file.read_text().splitlines()) == 101
    file.write_text(file.read_text() + '{"draw": 1')  # killed while it wrote
    done = []
    found = reliability(TALL, uncertain, load=SIDE, draws=200, file=file, progress=lambda *own: done.append(own))
    assert done[0] == (120, 200)
    whole = reliability(TALL, uncertain, load=SIDE, draws=200)
    assert (found.failures, found.interval) == (whole.failures, whole.interval)
    more = reliability(TALL, uncertain, load=SIDE, draws=250, file=file, jobs=2)
    assert more.failures == reliability(TALL, uncertain, load=SIDE, draws=250).failures
    with pytest.raises(InputError, match="draws of something else"):
        reliability(TALL, uncertain, load=SIDE, draws=200, file=file, seed=1)
    file.write_text(file.read_text().replace("outcome", "outcme", 1))
    with pytest.raises(InputError, match="a line is damaged"):
        reliability(TALL, uncertain, load=SIDE, draws=200, file=file)


@pytest.mark.slow
def test_draws_go_to_all_workers_of_a_cluster_and_one_killed_in_the_middle_loses_none(tmp_path):
    distributed = pytest.importorskip("distributed")
    import joblib

    uncertain = {"push": Random("normal", 0.3, 0.15)}
    file, workers, killed = tmp_path / "draws.jsonl", set(), []

    def kill_one(done, draws):
        if not killed:
            killed.extend(client.run(os.getpid).values())
            os.kill(killed[0], signal.SIGKILL)

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        client.run(sys.path.extend, [p for p in sys.path if p])
        with joblib.parallel_config(backend="dask"):
            with distributed.get_task_stream(client) as stream:
                reliability(TALL, uncertain, load=SIDE, draws=100, file=file)
            workers.update(task["worker"] for task in stream.data)
            found = reliability(TALL, uncertain, load=SIDE, draws=300, file=file, progress=kill_one)
    assert len(workers) == 2
    assert len(killed) == 2
    numbers = [json.loads(line)["draw"] for line in file.read_text().splitlines()[1:]]
    assert sorted(numbers) == list(range(300))
    assert found.failures == reliability(TALL, uncertain, load=SIDE, draws=300).failures


SCENE = """
name = "post"
[elements.post]
kind = "pier"
size = [0.5, 0.5]
height = 1.0
courses = 2
[uncertain]
push = { kind = "normal", mean = 0.3, deviation = 0.05, direction = [1, 0, 0] }
friction = { kind = "lognormal", mean = 2.0, deviation = 0.01, each = "joint", correlation = 0.5 }
[uncertain.density]
post = { kind = "uniform", least = 1900, most = 2100, each = "course" }
"""


def test_a_scene_says_what_is_uncertain(tmp_path):
    file = tmp_path / "post.toml"
    file.write_text(SCENE)
    found = reliability(read(file), draws=100)
    answer = run("reliability", file, "--draws", "100", "--json", "-o", tmp_path / "draws.jsonl")
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    assert (told["failures"], told["interval"]) == (found.failures, list(found.interval))
    assert first_order(read(file)).beta == pytest.approx(4.0, rel=0.02)  # tips at b / h = .5
    again = run("reliability", file, "--draws", "100", "--json", "-o", tmp_path / "draws.jsonl")
    assert json.loads(again.stdout)["seconds"] == told["seconds"]


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('"normal", mean', '"gamma", mean', "uncertain.push.kind: Invalid enum value 'gamma'"),
        ("deviation = 0.05, ", "", "uncertain.push.deviation: it is needed; normal has mean and deviation"),
        ("least = 1900", "mean = 1", "uncertain.density.post.mean: it does not belong here; uniform has least and"),
        ("uncertain.density", "uncertain.weight", "uncertain.weight.post: unknown key; keys here are: friction"),
        ("post = {", "roof = {", 'no group "roof"'),
        ('each = "joint"', 'each = "stone"', "uncertain.friction.each: Invalid enum value 'stone'"),
        (", direction = [1, 0, 0]", "", "push is a factor on a load; give it by --load AX,AY,AZ"),
        ("correlation = 0.5 }", "correlation = 0.5, direction = [1, 0, 0] }", "uncertain.friction.direction: push"),
    ],
)
def test_errors_of_a_scene_name_the_key(tmp_path, before, after, message):
    file = tmp_path / "post.toml"
    assert before in SCENE
    file.write_text(SCENE.replace(before, after, 1))
    answer = run("reliability", file, "--draws", "10")
    assert answer.returncode == 2
    assert message in " ".join(answer.stderr.split())
    assert "Traceback" not in answer.stderr


def test_draws_without_dilatancy_and_self_stress():
    """A block jammed between two walls: forces exist with any friction, but nothing has pressed the walls on it.

    Of a block on a slope both questions have the same answer, which is that of friction against the slope.
    """
    walls = [box((-1, 0, 0), (0, 1, 3)), box((1, 0, 0), (2, 1, 3))]
    jammed = Assembly.from_blocks([*walls, box((0, 0, 1), (1, 1, 2))], supports=[0, 1])
    uncertain = {"friction": Random("lognormal", 0.6, 0.1)}
    assert reliability(jammed, uncertain, draws=20).failures == 0
    found = reliability(jammed, uncertain, draws=20, flow="coulomb")
    assert (found.failures, found.self_stress, found.probability) == (20, 20, 1.0)
    assert "self-stress would hold 20 of those" in found.explain()
    assert (found.summary()["flow"], found.summary()["self_stress"]) == ("coulomb", 20)
    slope = {"uncertain": {"friction": Random("normal", 0.6, 0.1)}, "load": 0.5 * acceleration(FLAT, SIDE), "draws": 60}
    plain, coulomb = (reliability(FLAT, flow=flow, **slope) for flow in ("associated", "coulomb"))
    friction = 0.6 + 0.1 * np.random.default_rng(0).standard_normal(60)
    assert plain.failures == coulomb.failures == (friction < 0.5).sum()
    assert coulomb.self_stress == 0
    with pytest.raises(InputError, match="flow is 'couloumb'; it must be one of: associated, coulomb"):
        reliability(FLAT, flow="couloumb", **slope)


def test_the_file_of_draws_says_what_was_drawn(tmp_path):
    file = tmp_path / "draws.jsonl"
    uncertain = {
        "friction": Random("normal", 0.1, 0.2),
        "push": Random("uniform", 0.2, 0.4),
        "density.*": Random("normal", 2000, 100, each="block"),
    }
    scene = stack(3, 1.0, 1.0, friction=0.6)
    reliability(scene, uncertain, load=SIDE, draws=30, file=file)
    rows = [json.loads(line) for line in file.read_text().splitlines()[1:]]
    normals = np.random.default_rng(0).standard_normal((30, 5))
    for row, normal in zip(rows, normals, strict=True):
        values = row["values"]
        assert values["friction"] == pytest.approx(max(0.1 + 0.2 * normal[0], 0.0))  # none is less than 0
        assert values["push"] == pytest.approx(0.2 + 0.2 * norm.cdf(normal[1]))
        blocks = 2000 + 100 * normal[2:]
        assert values["density.*"] == pytest.approx([blocks.min(), blocks.mean(), blocks.max()])
        least = min(values["friction"], 1 / 3)  # it slides, or tips about its foot
        assert (row["outcome"] == "unstable") == (values["push"] > least)
    # Rows of an earlier version have no values; the run goes on from them.
    older = [{key: own for key, own in row.items() if key != "values"} for row in rows]
    first = file.read_text().splitlines()[0]
    file.write_text("\n".join([first, *map(json.dumps, older)]) + "\n")
    assert reliability(scene, uncertain, load=SIDE, draws=31, file=file).draws == 31
    with pytest.raises(InputError, match="draws of something else"):
        reliability(scene, uncertain, load=SIDE, draws=31, file=file, flow="coulomb")


def test_the_design_point_is_told_with_the_variable_that_matters_first():
    """Of mu - push the design point is at .6 - .3 x .01 / .0325 for both; the shares are .0225 and .01 of .0325."""
    uncertain = {"friction": Random("normal", 0.6, 0.1), "push": Random("normal", 0.3, 0.15)}
    said = first_order(FLAT, uncertain, SIDE).explain().splitlines()
    assert said[0] == FirstOrderOutcome.FOUND.value
    assert said[1] == "Probability 0.04805 (beta 1.664)."
    assert [line.split(":")[0] for line in said[2:]] == ["push", "friction"]
    assert [line.split(" ")[1][:5] for line in said[2:]] == ["0.507", "0.507"]
    assert [line.split(", ")[1] for line in said[2:]] == ["69% of the variance.", "31% of the variance."]


def test_what_changes_nothing_has_no_design_point():
    found = first_order(FLAT, {"push": Random("uniform", 0.3, 0.3)}, SIDE)
    assert found.outcome is FirstOrderOutcome.NOT_FOUND
    assert found.shares == {"push": 0.0}
    assert found.explain().splitlines() == [FirstOrderOutcome.NOT_FOUND.value, MOVES_NOTHING]
    assert found.summary()["reason"] == MOVES_NOTHING
    assert np.isnan(found.point).all()
    assert found.values == {}
    assert math.isnan(found.beta)
    assert math.isnan(found.probability)
    assert "robability" not in found.explain()
    assert json.loads(json.dumps(found.summary(), allow_nan=False))["probability"] is None


def test_where_any_multiple_of_the_load_is_carried_the_push_alone_has_a_derivative():
    """A block between two walls may be pushed to either with any force."""
    walls = [box((x, -1, 0), (x + 1, 1, 1), name=f"wall{x}") for x in (-2, 1)]
    blocks = [box((-3, -3, -1), (3, 3, 0), name="ground"), *walls, box((-1, -1, 0), (1, 1, 1), name="block")]
    scene = Assembly.from_blocks(blocks, supports=["ground", "wall-2", "wall1"])
    population = Population(scene, find_interfaces(scene), None, both_normal((0.6, 0.1), (0.3, 0.15)))
    value, slope = limit_state(population, (1, 0, 0), np.zeros(2))
    assert value == pytest.approx(MANY - 0.3, rel=1e-12)
    assert slope == pytest.approx([0.0, -0.15])


def test_weight_is_carried_any_number_of_times_and_lifted_once():
    scene = FLAT.with_(gravity=np.array([0.0, 0.0, -1.0]))
    population = Population(scene, find_interfaces(scene), None, both_normal((0.6, 0.1), (0.3, 0.15)))
    value, slope = limit_state(population, (0, 0, -1), np.zeros(2))
    assert value == pytest.approx(1.3, rel=1e-6)
    assert slope == pytest.approx([0.0, 0.15], abs=1e-6)


def test_a_load_that_holds_what_falls_without_it_has_a_limit_state():
    """A slab tilted by .9 g stays where mu (1 + p) is .9 or more, p the weight that is added: at p = .9 / mu - 1."""
    scene, (mu, push) = FLAT.with_(gravity=np.array([0.9, 0.0, -1.0])), (0.6, 0.3)
    more = np.array([np.zeros(6), [0, 0, -scene.mass[1], 0, 0, 0]])
    uncertain = both_normal((mu, 0.1), (push, 0.15))
    population = Population(scene, find_interfaces(scene), None, uncertain)
    value, slope = limit_state(population, more, np.zeros(2))
    assert value == pytest.approx(push - (0.9 / mu - 1), rel=1e-6)
    assert slope == pytest.approx([0.1 * 0.9 / mu**2, 0.15], rel=1e-6)
    found = first_order(scene, uncertain, more)
    nearest = minimize_scalar(
        lambda z: math.hypot(z, (0.9 / (mu + 0.1 * z) - 1 - push) / 0.15), bounds=(-3, 6), method="bounded"
    )
    assert found.beta == pytest.approx(-nearest.fun, rel=1e-5)
    assert found.shares["friction"] == pytest.approx((nearest.x / nearest.fun) ** 2, rel=1e-3)


def both_normal(friction, push):
    return {"friction": Random("normal", *friction), "push": Random("normal", *push)}


def tilted(share):
    """A slab under a gravity that is tilted, and a push as strong as its weight before the tilt."""
    scene = FLAT.with_(gravity=np.array([share, 0.0, -1.0]))
    return scene, sideways(scene.mass[1])


@pytest.mark.parametrize(("tilt", "friction", "push"), [
    (0.3, (0.10, 0.05), (0.05, 0.10)),  # falls with any push
    (0.3, (0.25, 0.10), (0.10, 0.02)),
    (0.3, (0.28, 0.05), (0.01, 0.05)),
    (0.3, (0.5, 0.05), (0.1, 0.05)),  # stands without the push, and with it
    (-0.3, (0.2, 0.02), (0.45, 0.05)),  # stands with the push alone, until that is too strong
    (0.0, (0.6, 0.0), (-0.7, 0.1)),  # falls to the other side
    (0.0, (0.6, 0.1), (-0.3, 0.15)),
])  # fmt: skip
def test_the_sliding_of_a_tilted_slab_has_an_exact_first_order_answer(tilt, friction, push):
    """It slides where |tilt + push| is above mu: a plane, but for what slides to the other side."""
    scene, load = tilted(tilt)
    found = first_order(scene, both_normal(friction, push), load)
    beta = (friction[0] - abs(tilt + push[0])) / math.hypot(friction[1], push[1])
    assert found.outcome is FirstOrderOutcome.FOUND
    assert found.beta == pytest.approx(beta, rel=1e-5)
    assert found.probability == pytest.approx(norm.cdf(-beta), rel=1e-4)
    assert found.shares["friction"] == pytest.approx(friction[1] ** 2 / (friction[1] ** 2 + push[1] ** 2), abs=1e-5)


@pytest.mark.parametrize(("push", "beta"), [(0.2, 2.0), (0.05, -1.0)])
def test_a_push_that_is_too_weak_to_hold_a_slab_has_a_design_point(push, beta):
    """Of a tilt of .3 friction holds .2: the push must be .1, and .5 at most."""
    scene, load = tilted(-0.3)
    found = first_order(scene.with_(friction=0.2), {"push": Random("normal", push, 0.05)}, load)
    assert found.beta == pytest.approx(beta, rel=1e-5)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("mean", "deviation"), [(0.05, 0.1), (0.0, 0.1), (-0.01, 0.1), (-0.05, 0.25), (-0.2, 0.13)])
def test_the_design_point_is_at_the_nearer_end_of_what_is_carried(side, mean, deviation):
    """A slab of friction .5 on ground tilted by .3 stands under pushes from -.8 to .2, or from -.2 to .8, times 1 m/s2.

    They are in units of gravity, which is the root of 1 + .09 here.
    """
    push = {"push": Random("normal", side * mean, deviation)}
    found = first_order(tilted_slab(side * 0.3, 0.5), push, (1, 0, 0))
    assert found.beta == pytest.approx((0.2 / np.hypot(1.0, 0.3) - mean) / deviation, rel=1e-6)


@pytest.mark.parametrize(("mean", "deviation"), [(0.3, 0.15), (0.8, 0.15), (2.0, 0.5), (3.0, 1.0)])
def test_a_weight_that_holds_a_slab_holds_it_the_better_the_more_it_is(mean, deviation):
    """On ground tilted by .9 at friction .6 half of its own weight must be added, and any more may be."""
    slab = tilted_slab(0.9, 0.6)
    weight = np.array([np.zeros(6), [0, 0, -slab.mass[1], 0, 0, 0]])
    found = first_order(slab, {"push": Random("normal", mean, deviation)}, weight)
    assert found.beta == pytest.approx((mean - 0.5) / deviation, rel=1e-6)


def tilted_slab(tilt, friction):
    """A slab of unit gravity downwards and a tilt along x."""
    blocks = [box((-3, -3, -1), (3, 3, 0), name="ground"), box((-1, -1, 0), (1, 1, 0.2), name="slab")]
    scene = Assembly.from_blocks(blocks, supports=["ground"], friction=friction)
    return scene.with_(gravity=np.array([tilt, 0.0, -1.0]))


def test_a_step_to_where_nothing_is_carried_is_shortened():
    """A pillar that tips at a quarter of its mean density: the tangent at the mean leads to less than none."""
    found = first_order(pillar(), {"density.p": Random("normal", 2000.0, 200.0)}, sideways(500.0 * 2.0 * 9.81 / 2))
    assert found.beta == pytest.approx(7.5, rel=1e-5)


def test_where_no_push_holds_what_falls_no_design_point_is_told(tmp_path):
    """A slab slides down a tilt, and a push across it does not hold it: draws about the mean say that it falls."""
    scene, push = FLAT.with_(gravity=np.array([3.0, 0.0, -10.0])), (0, 1, 0)
    uncertain = both_normal((0.2, 0.02), (0.1, 0.01))  # .3 is five deviations away
    found = first_order(scene, uncertain, push)
    assert found.explain().splitlines() == [FirstOrderOutcome.NOT_FOUND.value, CARRIES_NONE]
    with pytest.raises(InputError, match="about has no design point"):
        reliability(scene, uncertain, load=push, draws=3, about=found)
    file = write(scene, tmp_path / "slab.json")
    random = ("--uncertain", "friction=normal,0.2,0.02", "--uncertain", "push=normal,0.1,0.01")
    answer = run("reliability", file, *random, "--load", "0,1,0", "--draws", "20", "--first-order", "--json")
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    assert (told["first_order"]["outcome"], told["first_order"]["reason"]) == ("not_found", CARRIES_NONE)
    assert told["first_order"]["probability"] is None
    assert (told["sampled_about"], told["probability"]) == ("the mean", 1.0)


@pytest.mark.parametrize(("tilt", "push", "said"), [(0.3, 0.05, OFF_BORDER), (0.0, -0.7, "With the mean values the")])
def test_a_point_that_is_not_at_the_limit_is_not_found(monkeypatch, tilt, push, said):
    """A limit state that is wrong where the dead load falls, or for a push to the other side, leads to no answer."""

    def wrong(population, load, normal):
        return max(0.1 - tilt, 0.0) - (push + 0.1 * normal[1]), np.array([0.0, -0.1])

    monkeypatch.setattr("blockstat.chance.first_order.limit_state", wrong)
    scene, load = tilted(tilt)
    found = first_order(scene.with_(friction=0.1), both_normal((0.1, 0.001), (push, 0.1)), load)
    assert found.outcome is FirstOrderOutcome.NOT_FOUND
    assert found.reason.startswith(said)
    assert math.isnan(found.beta)


@pytest.mark.parametrize("share", [None, 1.0, 0.9])
def test_the_derivatives_by_weights_and_permanent_loads_are_those_of_the_closed_form(share):
    """A slab of mass rho and weight k rho with a push f P at its foot slides at k mu - f P / rho times rho."""
    loads = np.zeros((2, 6))
    loads[1, [0, 4]] = 0.2, -0.2 * 0.25
    uncertain = {"density.*": Random("normal", 1.0, 0.05), "loads.*": Random("normal", 1.0, 0.1)}
    acting = loads if share is None else WeightedLoads(loads, share)
    population = Population(FLAT, find_interfaces(FLAT), acting, uncertain)
    for density, factor in ((0.0, 0.0), (1.0, -2.0)):
        weight, part = 1.0 + 0.05 * density, 1.0 + 0.1 * factor
        value, slope = limit_state(population, SIDE, np.array([density, factor]))
        assert value == pytest.approx((share or 1.0) * 0.6 - part * 0.2 / weight - 1.0, abs=1e-7)
        assert slope == pytest.approx([0.05 * part * 0.2 / weight**2, -0.1 * 0.2 / weight], rel=1e-5)


@pytest.mark.parametrize("loads", [None, WeightedLoads(np.zeros((2, 6)), 0.8)])
def test_the_derivative_by_corners_is_that_of_differences(loads):
    column = stack(1, 0.5, 2.0, friction=2.0)
    population = Population(column, find_interfaces(column), loads, {"corner": Random("normal", 0.0, 0.002)})
    rng = np.random.default_rng(5)
    place, way = rng.standard_normal((2, population.size))
    slope = limit_state(population, SIDE, place)[1]
    ahead, behind = (limit_state(population, SIDE, place + step * way)[0] for step in (0.02, -0.02))
    assert abs(ahead - behind) > 1e-6
    assert slope @ way == pytest.approx((ahead - behind) / 0.04, rel=2e-3)


def test_the_length_of_a_direction_is_not_dropped():
    """The post tips at a push of .5: a tenth of gravity is carried, and as strong as gravity it is not."""
    uncertain = {"friction": Random("uniform", 1.9, 2.0)}
    for ask in (reliability, first_order):
        with pytest.raises(InputError, match=r"load is \(0.1, 0, 0\), a direction, .*Give 0.1 \* acceleration"):
            ask(TALL, uncertain, load=(0.1, 0, 0))
    assert reliability(TALL, uncertain, load=0.1 * acceleration(TALL, (0.1, 0, 0)), draws=5).probability == 0
    constant = uncertain | {"push": Random("uniform", 0.1, 0.1)}
    assert reliability(TALL, constant, load=(0.1, 0, 0), draws=5).probability == 0
    assert first_order(TALL, constant, load=(0.1, 0, 0)).outcome is FirstOrderOutcome.NOT_FOUND
    assert reliability(TALL, uncertain, load=(0.707, 0.707, 0), draws=5).probability == 1
    # Where a push says how strong it is, and where a multiplier is asked for, the length of a direction says nothing.
    pushed = {"push": Random("uniform", 0.1, 0.2)}
    assert reliability(TALL, pushed, load=(2, 0, 0), draws=5).probability == 0
    assert fragility(TALL, uncertain, (2, 0, 0), draws=3) == pytest.approx(0.5, rel=1e-4)


def test_a_load_that_is_given_goes_before_that_of_the_scene(tmp_path):
    """The post tips at a push of .5; twice as strong a load takes half the push: beta = (.25 - .3) / .05."""
    file = tmp_path / "post.toml"
    file.write_text(SCENE)
    post = read(file)
    load = load_of(post.with_(density=np.full(post.n_blocks, 2000.0)), 2.0)
    assert first_order(post, load=load).beta == pytest.approx(-1.0, rel=0.05)


def test_a_block_that_touches_nothing_falls_in_every_draw():
    scene = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 2), (1, 1, 3))], supports=[0])
    found = reliability(scene, {"density.*": Random("normal", 2000.0, 100.0)}, draws=5)
    assert (found.failures, found.undecided, found.probability) == (5, 0, 1.0)


def sunk(depth, **options):
    """A slab of 1 x 1 x 0.5 m that is so far in the ground [m]; its hundredth is 8 mm."""
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, -depth), (1, 1, 0.5 - depth), name="slab")]
    return Assembly.from_blocks(blocks, supports=["ground"], **options)


def test_an_overlap_within_the_gap_is_a_joint_in_every_draw():
    slides = sunk(0.009, gravity=(8, 0, -9.81))  # faster than a friction of 0.5 holds
    options = {"gap": "10 mm", "draws": 5}
    found = reliability(slides, {"friction": Random("normal", 0.5, 0.01)}, **options)
    assert (found.failures, found.undecided) == (5, 0)
    uncertain = {"friction": Random("normal", 0.6, 0.1), "push": Random("normal", 0.3, 0.15)}
    assert first_order(sunk(0.009), uncertain, SIDE, gap="10 mm").beta == pytest.approx(0.3 / math.hypot(0.1, 0.15))


def test_blocks_that_overlap_as_drawn_are_refused(tmp_path):
    file, friction = tmp_path / "sunk.json", {"friction": Random("normal", 0.5, 0.01)}
    deep = sunk(0.3)
    write(deep, file)
    for ask in (reliability, first_order, fragility):
        with pytest.raises(InputError, match=r'blocks "ground" and "slab" overlap by 0.3 m'):
            ask(deep, friction, load=SIDE)
    told = run("reliability", file, "--uncertain", "friction=normal,0.5,0.01", "--draws", "5").stderr
    assert 'blocks "ground" and "slab" overlap by 0.3 m' in told


@pytest.mark.parametrize(
    ("uncertain", "message"),
    [
        ({"push": Random("normal", 1, 1, "group")}, 'uncertain "push": each is "group"; it has no parts of its own'),
        ({"corner": Random("normal", 0, 1, "block")}, 'uncertain "corner": each is "block"; it has no parts'),
        ({"corner": Random("normal", 0, 1, correlation=0.5)}, 'uncertain "corner": correlation is 0.5; its values'),
        (
            {"density.*": Random("normal", 1, 1, "joint")},
            'uncertain "density.*": each is "joint"; it belongs to blocks',
        ),
        (
            {"friction": Random("normal", 1, 1)},
            'uncertain "friction": joints keep a friction of their own, by the joint law between',
        ),
    ],
)
def test_variables_that_have_no_such_parts_or_laws_are_refused(uncertain, message):
    scene = FLAT.with_(joints=[JointLaw(("*", "*"), friction=0.5)])
    with pytest.raises(InputError) as error:
        reliability(scene, uncertain, load=SIDE)
    assert message in str(error.value)


def test_friction_is_random_beside_laws_that_say_nothing_of_it():
    scene = FLAT.with_(joints=[JointLaw(("*", "*"), cohesion=1.0)])
    assert reliability(scene, {"friction": Random("normal", 0.6, 0.1)}, draws=3).failures == 0


@pytest.mark.parametrize("correlation", [-0.1, 1.1, math.nan])
def test_a_correlation_that_is_none_is_refused(correlation):
    with pytest.raises(InputError, match=f"normal: the correlation is {correlation}; it must be from 0 to 1"):
        Random("normal", 1.0, 0.1, "joint", correlation)


@pytest.mark.parametrize("name", ["draws", "jobs"])
@pytest.mark.parametrize("value", [0, -1, 2.0, "2", True])
def test_numbers_of_draws_and_jobs_that_are_none_are_refused(name, value):
    for ask in (reliability, fragility):
        with pytest.raises(InputError, match=f"{name} is {value!r}; it must be a whole number of at least 1"):
            ask(FLAT, {"friction": Random("normal", 0.6, 0.1)}, load=SIDE, **{name: value})


@pytest.mark.parametrize("confidence", [0.0, 1.0])
def test_a_confidence_that_is_none_is_refused(confidence):
    with pytest.raises(InputError, match=f"confidence is {confidence}; it must be between 0 and 1"):
        reliability(FLAT, {"friction": Random("normal", 0.6, 0.1)}, confidence=confidence)


def test_questions_without_a_load_or_with_two_multipliers_are_refused():
    with pytest.raises(InputError, match="first-order estimate asks when a load is not carried; give it as load"):
        first_order(FLAT, {"friction": Random("normal", 0.6, 0.1)})
    with pytest.raises(InputError, match='the multiplier itself is what "push" would be; leave it out'):
        fragility(FLAT, {"push": Random("normal", 0.6, 0.1)}, SIDE)
    with pytest.raises(InputError, match="uncertain is None; it must be random variables by key"):
        fragility(FLAT, None, SIDE)


@pytest.mark.parametrize("uncertain", [
    {"friction": Random("normal", 0.6, 0.1)}, {"edge": Random("normal", 0.01, 0.001)},
    {"friction": Random("normal", 0.6, 0.1, each="joint")},
])  # fmt: skip
def test_a_property_of_joints_where_there_are_none_is_refused(uncertain):
    apart = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((5, 5, 5), (6, 6, 6))], supports=[0])
    (key,) = uncertain
    with pytest.raises(InputError, match=f'uncertain "{key}": the scene has nothing that it is a property of'):
        reliability(apart, uncertain, draws=3)


GIVEN = {"push": Random("uniform", 0.3, 0.7)}


@pytest.fixture
def kept(tmp_path):
    """A tower of two blocks with the file of its draws."""
    tower, file = stack(2, 1.0, 1.0, friction=2.0), tmp_path / "draws.jsonl"
    joints = find_interfaces(tower)
    reliability(tower, GIVEN, load=SIDE, draws=5, file=file, interfaces=joints)
    assert reliability(tower.with_(name="again"), GIVEN, load=SIDE, draws=6, file=file, interfaces=joints).draws == 6
    return tower, joints, file


@pytest.mark.parametrize(
    "change",
    [
        lambda own, joints: (own.with_(ties=[Tie((0, 2), ((-0.5, 0, 0), (-0.5, 0, 2)))]), joints),
        lambda own, joints: (own.with_(groups=("ground", "low", "high")), joints),
        lambda own, joints: (own.with_(face_vertices=own.face_vertices[::-1].copy()), joints),
        lambda own, joints: (own, replace(joints, friction=np.array([2.0, 0.1]))),
        lambda own, joints: (own, replace(joints, frame=joints.frame[:, [0, 2, 1]] * [[[1], [1], [-1]]])),
        lambda own, joints: (own, replace(joints, area=2 * joints.area)),
        lambda own, joints: (own.with_(friction=1.9), joints),
        lambda own, joints: (own.with_(joints=[JointLaw(("*", "*"), tension=1.0)]), joints),
    ],
    ids=["ties", "groups", "faces", "friction of joints", "frames", "areas", "friction", "laws"],
)
def test_the_file_of_draws_of_another_structure_is_refused(kept, change):
    tower, joints, file = kept
    own = Population(tower, joints, None, GIVEN)
    other, faces = change(tower, joints)
    before, after = (Trials(p, SIDE, np.zeros(1), 0, reuse=True).digest() for p in (own, replace(
        own, assembly=other, interfaces=faces)))  # fmt: skip
    assert before != after
    if other.face_vertices is tower.face_vertices:
        with pytest.raises(InputError, match="draws of something else"):
            reliability(other, GIVEN, load=SIDE, draws=6, file=file, interfaces=faces)


def test_the_file_of_draws_knows_the_factor_on_the_weight():
    loads, uncertain = np.ones((2, 6)), {"loads.*": Random("normal", 1.0, 0.1)}
    given = (loads, WeightedLoads(loads), WeightedLoads(loads, 0.9), WeightedLoads(loads, 0.8))
    populations = [Population(FLAT, find_interfaces(FLAT), own, uncertain) for own in given]
    digests = [Trials(own, SIDE, np.zeros(1), 0, reuse=True).digest() for own in populations]
    assert digests[0] == digests[1]
    assert len(set(digests)) == 3


def test_draws_about_a_point_have_a_file_of_their_own(tmp_path):
    uncertain, file = {"push": Random("normal", 0.3, 0.05)}, tmp_path / "draws.jsonl"
    about = first_order(TALL, uncertain, SIDE)
    options = {"load": SIDE, "file": file, "about": about}
    found = reliability(TALL, uncertain, draws=60, **options)
    whole = reliability(TALL, uncertain, draws=80, load=SIDE, about=about)
    more = reliability(TALL, uncertain, draws=80, **options)
    assert found.interval != more.interval
    assert (more.probability, more.interval, more.at_most) == (whole.probability, whole.interval, whole.at_most)
    with pytest.raises(InputError, match="draws of something else"):
        reliability(TALL, uncertain, draws=60, load=SIDE, file=file)


@pytest.mark.parametrize("each", ["all", "joint"])
def test_friction_is_not_random_where_interfaces_have_their_own(each):
    joints = find_interfaces(FLAT)
    own = replace(joints, friction=np.full(joints.n_interfaces, 0.6))
    with pytest.raises(
        InputError, match='uncertain "friction": joints keep a friction of their own, which the interfaces give'
    ):
        reliability(FLAT, {"friction": Random("normal", 0.3, 0.1, each)}, interfaces=own, load=SIDE, draws=3)
    assert reliability(FLAT, {"push": Random("uniform", 0.5, 0.59)}, interfaces=own, load=SIDE, draws=3).failures == 0


def test_ends_of_ties_stay_where_they_are_drawn_when_corners_move():
    """A tie with a given force carries what its force at its end makes of the load, about the centroid of the draw."""
    end, force = np.array([0.0, 0.5, 1.5]), 0.1
    tie = Tie(("ground", "stone0"), ((-3, 0.5, 1.5), tuple(end)), least=force, greatest=force)
    bare = stack(1, 0.5, 2.0, friction=2.0)
    tied = bare.with_(ties=[tie])
    uncertain = {"corner": Random("normal", 0.0, 0.01)}
    populations = [Population(one, find_interfaces(one), None, uncertain) for one in (tied, bare)]
    for normal in np.random.default_rng(7).standard_normal((5, populations[0].size)):
        value, slope = limit_state(populations[0], SIDE, normal)
        draw, pull = populations[1].realise(normal), np.array([-force, 0.0, 0.0])
        given = np.zeros((2, 6))
        given[1] = [*pull, *np.cross(end - draw.assembly.centroid[1], pull)]
        limit = limit_load(draw.assembly, SIDE, loads=given, interfaces=draw.interfaces, optimum=True)
        assert value + 1 == pytest.approx(limit.lower, rel=1e-7)
        ends = [limit_state(populations[0], SIDE, normal + sign * 1e-4 * slope)[0] for sign in (1, -1)]
        assert (ends[0] - ends[1]) / 2e-4 == pytest.approx(slope @ slope, rel=1e-4)
    assert reliability(tied, uncertain, load=load_of(tied, 0.25), draws=20).failures == 0
    loose = bare.with_(ties=[replace(tie, points=(tie.points[0], (-0.1, 0.5, 1.5)))])
    with pytest.raises(InputError, match=r"the point \[-0.1, 0.5, 1.5\] is not on block"):
        reliability(loose, uncertain, draws=2)


def pillar():
    """A block of group p, 1 x 1 x 2 m: a force at its centroid tips it at half its weight."""
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="pillar", group="p")]
    return Assembly.from_blocks(blocks, supports=["ground"], density=2000.0, friction=2.0)


def sideways(force):
    return np.array([np.zeros(6), [force, 0, 0, 0, 0, 0]])


@pytest.mark.parametrize("keys", [("density.*", "density.p"), ("density.p", "density.*")])
def test_of_two_densities_of_a_block_the_last_one_counts(keys):
    """It tips at 1600 kg/m3, two standard deviations below the mean of one variable."""
    load = sideways(1600.0 * 2.0 * 9.81 / 2)
    found = first_order(pillar(), {key: Random("normal", 2000.0, 200.0) for key in keys}, load)
    assert found.beta == pytest.approx(2.0, rel=1e-5)
    assert found.shares == pytest.approx({keys[0]: 0.0, keys[1]: 1.0}, abs=1e-9)


def test_two_factors_on_the_loads_of_a_block_multiply():
    """With weight W, 0.2 W times both factors and then 0.1 W push: it tips where their product is 2."""
    weight = 2000.0 * 2.0 * 9.81
    uncertain = {"loads.*": Random("normal", 1.0, 0.1), "loads.p": Random("normal", 1.0, 0.2)}
    found = first_order(pillar(), uncertain, sideways(0.1 * weight), loads=sideways(0.2 * weight))
    nearest = minimize_scalar(lambda u: math.hypot(u, (2 / (1 + 0.1 * u) - 1) / 0.2), bounds=(0, 5), method="bounded")
    assert found.outcome is FirstOrderOutcome.FOUND
    assert found.beta == pytest.approx(nearest.fun, rel=1e-4)
    assert found.shares["loads.*"] == pytest.approx((nearest.x / nearest.fun) ** 2, abs=1e-3)


@pytest.mark.parametrize("joints", [[], [JointLaw(("*", "*"), compression=1e6)]], ids=["edges", "cells"])
def test_corners_of_feet_are_not_random_with_their_edges_or_laws(joints):
    """The feet are 16 mm wide: 9 mm from both sides leave nothing of them, wherever their corners are."""
    asm = on_grounds(table((0, 0.016), (0.984, 1)), joints=joints)
    uncertain = {} if joints else {"edge": Random("uniform", 0.009, 0.010)}
    assert joints or reliability(asm, uncertain, draws=3).failures == 3
    for ask in (reliability, first_order):
        with pytest.raises(InputError, match='blocks "ground-1" and "table" touch in several patches'):
            ask(asm, {**uncertain, "corner": Random("normal", 0.0, 0.001)}, load=SIDE)


def test_the_push_of_the_scene_acts_beside_other_random_variables(tmp_path):
    """The post tips at a push of .5 of its weight; the scene's is normal, .3 and then .6 with a deviation of .05."""
    file = tmp_path / "post.toml"
    file.write_text(SCENE)
    friction = {"friction": Random("lognormal", 2.0, 0.01)}
    assert first_order(read(file), friction).beta == pytest.approx(4.0, rel=0.02)
    assert first_order(read(file), {"push": Random("normal", 0.4, 0.05)}).beta == pytest.approx(2.0, rel=0.02)
    file.write_text(SCENE.replace("mean = 0.3", "mean = 0.6"))
    assert reliability(read(file), friction, draws=20).failures >= 17  # fewer: less than once in 1000


def test_a_design_point_of_other_variables_is_refused_before_any_draw():
    push, told = {"push": Random("normal", 0.3, 0.1)}, []
    about = first_order(TALL, push, SIDE)
    both = {**push, "friction": Random("normal", 2.0, 0.1)}
    with pytest.raises(InputError, match="about has a design point of 1 random values and uncertain has 2"):
        reliability(TALL, both, load=SIDE, draws=3, about=about, progress=lambda *_: told.append(_))
    assert not told


def test_edges_are_not_random_where_joints_are_divided_into_cells():
    """The interfaces of an earlier limit hold cells, whose centres are no corners to move in."""
    divided = stack(1, 1.0, 2.0, friction=2.0, joints=[JointLaw(("*", "*"), compression=1e3)])
    cells = limit_load(divided, SIDE).interfaces
    uncertain = {"edge": Random("normal", 0.02, 0.005)}
    for ask in (reliability, first_order, fragility):
        with pytest.raises(InputError, match='uncertain "edge": joints that are divided into cells have no edges'):
            ask(divided, uncertain, load=SIDE, interfaces=cells)


@pytest.mark.parametrize(("joints", "more", "beside"), [
    ([JointLaw(("*", "*"), cells=4)], {}, "joints that are divided into cells"),
    ([], {"corner": Random("normal", 0.0, 0.005)}, '"corner"'),
])  # fmt: skip
def test_edges_have_no_derivative_beside_corners_and_cells(joints, more, beside):
    """Draws know the answer: a block that has lost some 2 cm at each edge tips at .48 of its weight."""
    block = stack(1, 1.0, 2.0, friction=2.0, joints=joints)
    uncertain = {"edge": Random("normal", 0.02, 0.001), "push": Random("uniform", 0.4, 0.41), **more}
    assert reliability(block, uncertain, load=SIDE, draws=3).failures == 0
    with pytest.raises(InputError, match=f'uncertain "edge" beside {beside} has no derivative to first order'):
        first_order(block, uncertain, SIDE)


def test_friction_below_what_cohesion_needs_counts_as_the_least_it_may_go_with():
    """A slab with a cohesion of .3 of its weight slides at mu + .3; a ninth of the draws of mu are below .001."""
    area, weight = find_interfaces(FLAT).area[0], FLAT.mass[1] * np.linalg.norm(FLAT.gravity)
    held = FLAT.with_(joints=[JointLaw(("*", "*"), cohesion=0.3 * weight / area)])
    uncertain = {"friction": Random("normal", 0.6, 0.5)}
    population = Population(held, find_interfaces(held), None, uncertain)
    for normal, mu in ((-3.0, 1e-3), (-0.4, 0.4)):
        draw = population.realise(np.array([normal]))
        assert limit_load(draw.assembly, SIDE).lower == pytest.approx(mu + 0.3, rel=1e-5)
    assert population.gradient(np.array([-3.0]), draw, mapped(FLAT), np.zeros((2, 6))) == [0.0]
    assert population.gradient(np.array([-0.4]), draw, mapped(FLAT), np.zeros((2, 6))) == pytest.approx([0.5])
    found = reliability(held, uncertain, load=load_of(held, 0.5), draws=60)
    low, high = found.interval
    assert low < norm(0.6, 0.5).cdf(0.2) < high


def mapped(scene):
    return reserve_map(limit_load(scene, SIDE, optimum=True), SIDE, corners=False)


@pytest.mark.parametrize(
    "uncertain",
    [{"friction": Random("normal", 0.6, 0.1)}, {"density.stack": Random("lognormal", 2000.0, 100.0)}],
)
def test_a_variable_on_which_the_limit_does_not_depend_gives_no_design_point(uncertain):
    """A stack .5 m wide and 2 m high tips at .25, whatever its friction and density: slopes are rounding."""
    cubes = [box((0, 0, k / 2), (0.5, 0.5, k / 2 + 0.5), name=f"s{k}", group="stack") for k in range(4)]
    stack = Assembly.from_blocks([box((-5, -5, -1), (5, 5, 0), name="ground"), *cubes], supports=["ground"])
    found = first_order(stack, uncertain, SIDE)
    assert found.outcome is FirstOrderOutcome.NOT_FOUND
    assert math.isnan(found.beta)
    assert list(found.shares.values()) == [0.0]


def test_what_is_random_has_a_distribution():
    block = Assembly.from_blocks([box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 1))], supports=[0])
    for ask in (reliability, first_order):
        with pytest.raises(InputError, match=r'uncertain "friction" is 0\.7; it must be a blockstat\.Random, such as '):
            ask(block, {"friction": 0.7}, load=(1, 0, 0))
