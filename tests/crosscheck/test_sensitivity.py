"""Gradients from the duals against finite differences of whole solves, and Taylor remainders of second order."""

import numpy as np
import pytest

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    Tie,
    acceleration,
    assess,
    build,
    limit_load,
    with_values,
)  # fmt: skip
from blockstat.sensitivity.parameters import limit_load_gradient, score_gradient
from blockstat.spec import scene_from
from evidence.scenes.small import HUT, arch, assembly, box, running_bond


def sideways(assembly):
    return acceleration(assembly, (1, 0, 0))


def an_arch(values):
    return arch(12, values["t"], radius=values["r"], depth=values["d"])


def a_wall(values):
    return running_bond(6, 4, length=values["length"], height=values["height"], depth=0.3)


def a_hut(values):
    scene = {**HUT, "wall": {"thickness": {"value": 0.6, "min": 0.1, "max": 2.0, "step": 0.1}, "height": 1.5}}
    scene["vault"] = {"thickness": {"value": 0.3, "min": 0.1, "max": 1.0, "step": 0.1}, "voussoirs": 7}
    return build(with_values(scene_from(scene), dict(values)))


def across(assembly):
    return acceleration(assembly, (0, 1, 0))


CASES = [
    (an_arch, {"t": 0.2, "r": 1.0, "d": 0.5}, sideways),
    (a_wall, {"length": 0.4, "height": 0.175}, sideways),
    (a_hut, {"wall.thickness": 0.73, "vault.thickness": 0.27}, across),
]


@pytest.mark.parametrize(("make", "values", "load"), CASES, ids=["arch", "wall", "vault"])
def test_limit_load_gradient(make, values, load):
    limit, gradient = limit_load_gradient(make, values, load)
    for name, value in values.items():
        step = 1e-3 * value
        ends = []
        for sign in (1, -1):
            changed = make({**values, name: value + sign * step})
            ends.append(limit_load(changed, load(changed)).lower)
        slope = (ends[0] - ends[1]) / (2 * step)
        assert gradient[name] == pytest.approx(slope, rel=2e-4, abs=1e-5)
    assert limit.gap < 1e-5


def test_taylor_remainder_of_the_limit_load_is_of_second_order():
    values = {"t": 0.2, "r": 1.0, "d": 0.5}
    limit, gradient = limit_load_gradient(an_arch, values, sideways)
    steps = np.array([4e-3, 2e-3, 1e-3])
    rest = []
    for step in steps:
        changed = an_arch({**values, "t": 0.2 + step})
        rest.append(abs(limit_load(changed, sideways(changed)).lower - limit.lower - gradient["t"] * step))
    slopes = np.diff(np.log(rest)) / np.diff(np.log(steps))
    np.testing.assert_allclose(slopes, 2.0, atol=0.1)


def test_a_size_without_influence_has_no_derivative():
    # Dry masonry is scale-free: all lengths together, and the depth of a planar arch alone, change nothing.
    values = {"t": 0.2, "r": 1.0, "d": 0.5}
    _, gradient = limit_load_gradient(an_arch, values, sideways)
    assert gradient["d"] == pytest.approx(0.0, abs=1e-6)
    assert gradient["t"] * 0.2 + gradient["r"] * 1.0 == pytest.approx(0.0, abs=1e-6)


def test_score_gradient():
    values = {"t": 0.09, "r": 1.0}

    def make(v):
        return arch(12, v["t"], radius=v["r"])

    verdict, gradient = score_gradient(make, values)
    assert verdict.score > 0
    for name, value in values.items():
        step = 1e-4 * value
        ends = [assess(make({**values, name: value + sign * step})).score for sign in (1, -1)]
        assert gradient[name] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-3, abs=1e-5)
    assert gradient["t"] < 0  # a thicker arch lacks less


def test_joints_whose_tension_goes_with_their_area():
    law = JointLaw(("*", "*"), tension=0.02)

    def make(v):
        return arch(12, v["t"]).with_(joints=[law], gravity=(v["tilt"], 0, -1))

    def slope(measure, values):
        ends = [measure(make({**values, "t": values["t"] + sign * 1e-4})) for sign in (1, -1)]
        return (ends[0] - ends[1]) / 2e-4

    values = {"t": 0.2, "tilt": 0.0}
    _, gradient = limit_load_gradient(make, values, sideways)
    assert gradient["t"] == pytest.approx(slope(lambda a: limit_load(a, (1, 0, 0)).lower, values), rel=1e-4)
    values = {"t": 0.15, "tilt": 0.45}
    verdict, gradient = score_gradient(make, values)
    assert verdict.score > 0.01
    assert gradient["t"] == pytest.approx(slope(lambda a: assess(a).score, values), rel=1e-4)


def test_stable_designs_have_no_score_to_change_and_unstable_ones_no_limit():
    _, gradient = score_gradient(an_arch, {"t": 0.2, "r": 1.0, "d": 0.5})
    assert gradient == {"t": 0.0, "r": 0.0, "d": 0.0}
    with pytest.raises(InputError, match="no limit load to differentiate"):
        limit_load_gradient(an_arch, {"t": 0.05, "r": 1.0, "d": 0.5}, sideways)


def tied(values, force):
    """A pillar, and a tie at a height of 1.6 m that pulls it towards -x with up to a force."""
    width, height = values["width"], values["height"]
    blocks = [box((-4, -2, -1), (6, 2, 0), name="ground"), box((0, 0, 0), (width, 0.5, height), name="pillar")]
    tie = Tie(("ground", "pillar"), ((-3, 0.25, 1.6), (0, 0.25, 1.6)), greatest=force)
    return assembly(blocks, density=1800.0, gravity=(0, 0, -9.81), ties=[tie])


def test_a_limit_with_a_tie_changes_as_the_moment_about_the_toe():
    """The limit is b / h + 2 F z / (W h), W = rho g b d h; one that the tie cannot help is b / h."""

    def make(values):
        return tied(values, values["force"])

    values = {"width": 0.6, "height": 2.0, "force": 2000.0}
    weight = 1800.0 * 0.6 * 0.5 * 2.0 * float(np.linalg.norm(make(values).gravity))
    gain = 2 * 2000.0 * 1.6 / (weight * 2.0)
    limit, gradient = limit_load_gradient(make, values, sideways)
    assert limit.lower == pytest.approx(0.3 + gain, rel=1e-6)
    assert gradient == pytest.approx(
        {"width": 0.5 - gain / 0.6, "height": -0.15 - gain, "force": gain / 2000.0}, rel=1e-6
    )
    limit, gradient = limit_load_gradient(make, values, lambda made: acceleration(made, (-1, 0, 0)))
    assert limit.lower == pytest.approx(0.3, rel=1e-6)
    assert gradient == pytest.approx({"width": 0.5, "height": -0.15, "force": 0.0}, abs=1e-6)


@pytest.mark.parametrize("pull", [{"least": 5e3, "greatest": 5e3}, {"least": 5e3}, {"greatest": 1e3}])
def test_a_score_with_ties_changes_as_whole_solves_do(pull):
    """A tower that a tie with a given or a least force pulls over, or that leans on one which yields."""

    def make(values):
        width, height = values["width"], values["height"]
        blocks = [box((-4, -2, -1), (6, 2, 0), name="ground")]
        blocks += [box((0, 0, k * height), (width, 0.5, (k + 1) * height)) for k in range(3)]
        force = {key: values["share"] * value for key, value in pull.items()}
        tie = Tie((3, "ground"), ((0, 0.25, 2.5 * height), (-3, 0.3, 0.2)), **force)
        lean = 0.0 if "least" in pull else 9.0
        return assembly(blocks, density=1800.0, ties=[tie], gravity=(lean, 0.1, -9.81))

    values = {"width": 0.4, "height": 0.6, "share": 1.0}
    verdict, gradient = score_gradient(make, values)
    assert verdict.score > 0.1
    for name, value in values.items():
        ends = [assess(make({**values, name: value * (1 + sign * 1e-4)})).score for sign in (1, -1)]
        assert gradient[name] == pytest.approx((ends[0] - ends[1]) / (2e-4 * value), rel=1e-5)
        assert gradient[name] != 0


def test_a_step_that_adds_a_tie_has_no_derivative():
    def make(values):
        made = tied({"width": 0.6, "height": 2.0}, 2000.0)
        return made.with_(ties=made.ties * (1 + (values["more"] > 1.0)))

    with pytest.raises(InputError, match="a small step changes how many ties there are"):
        limit_load_gradient(make, {"more": 1.0}, sideways)


def rubbing(values, *, tension=0.0, own=False, **options):
    """A low slab that slides: its weight is 0.2 x density x g, and its joint has an area of 1 m2."""
    law = JointLaw(("slab", "*"), friction=values["mu"] if own else None, tension=tension)
    parts = [box((-2, -2, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 0.2), name="slab", group="slab")]
    options |= {"friction": 0.9 if own else values["mu"], "density": 1000.0, "joints": [law]}
    return Assembly.from_blocks(parts, supports=["ground"], **options)


@pytest.mark.parametrize("own", [False, True], ids=["assembly", "law"])
@pytest.mark.parametrize("tension", [0.0, 500.0])
def test_the_limit_of_what_slides_goes_with_its_friction(own, tension):
    """Coulomb with a tension T: H = mu (W + T A), so the multiplier grows by 1 + T A / W for each unit of mu."""

    def make(values):
        return rubbing(values, tension=tension, own=own)

    limit, gradient = limit_load_gradient(make, {"mu": 0.4}, sideways)
    more = 1 + tension / (200 * np.linalg.norm(limit.assembly.gravity))
    assert limit.lower == pytest.approx(0.4 * more, rel=1e-5)
    assert gradient["mu"] == pytest.approx(more, rel=1e-5)


@pytest.mark.parametrize("mu", [0.9, np.inf])
def test_friction_leaves_the_limit_of_what_tips_as_it_is(mu):
    def make(values):
        parts = [box((-2, -2, -1), (2, 2, 0)), box((0, 0, 0), (values["width"], 1, 2))]
        return Assembly.from_blocks(parts, supports=[0], friction=mu + values["more"])

    _, gradient = limit_load_gradient(make, {"width": 1.0, "more": 0.01}, sideways)
    assert gradient["width"] == pytest.approx(0.5, rel=1e-5)
    assert gradient["more"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("own", [False, True], ids=["assembly", "law"])
@pytest.mark.parametrize("tension", [0.0, 200.0])
def test_the_score_of_what_slides_goes_with_its_friction(own, tension):
    def make(values):
        return rubbing(values, tension=tension, own=own, gravity=(6.0, 0.0, -9.0))

    _, gradient = score_gradient(make, {"mu": 0.4})
    slope = (assess(make({"mu": 0.401})).score - assess(make({"mu": 0.399})).score) / 0.002
    assert slope < -1
    assert gradient["mu"] == pytest.approx(slope, rel=1e-4)


def test_a_load_may_be_a_direction():
    for load in (lambda _: (1, 0, 0), lambda _: (5, 0, 0)):
        limit, gradient = limit_load_gradient(rubbing, {"mu": 0.4}, load)
        assert limit.lower == pytest.approx(0.4, rel=1e-6)
        assert gradient["mu"] == pytest.approx(1.0, rel=1e-6)
