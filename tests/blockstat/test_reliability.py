"""Random friction, joints, weights and loads: probabilities that are known."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from blockstat import InputError, Random, acceleration, first_order, fragility, reliability, write
from blockstat.chance.first_order import FirstOrderOutcome
from blockstat.chance.monte_carlo import _binomial
from evidence.scenes.small import arch, stack

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
        ({"mu": Random("normal", 1, 1)}, 'uncertain "mu"; keys are: friction, edge, push'),
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
