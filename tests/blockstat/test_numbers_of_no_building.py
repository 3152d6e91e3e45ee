"""Numbers that no building has, each refused from the first one on, and what happens where one gets through."""

import gc
from math import inf, nan

import numpy as np
import pytest
from scipy import sparse

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    Outcome,
    Tie,
    anchor_plate,
    assess,
    box,
    friction_limit,
    limit_load,
)
from blockstat.linear_algebra.factor import SuperLU, make_factor

SCENE = Assembly.from_blocks(
    [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube")],
    supports=["ground"], density=1000.0, friction=0.5,
)  # fmt: skip
ENDS = ((0.5, 0.5, 0), (0.5, 0.5, 1))


def along_x(force):
    load = np.zeros((2, 6))
    load[1, 0] = force
    return load


@pytest.mark.parametrize("make", [make_factor, SuperLU])
@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_a_matrix_that_is_not_finite_is_refused_before_it_is_factored(make, value):
    factor = make()
    with pytest.raises(ArithmeticError, match="values that are not finite"):
        factor.update(sparse.csr_array(np.array([[2.0, value], [0.0, 2.0]])))
    factor.update(sparse.csr_array(np.array([[2.0, 1.0], [0.0, 2.0]])))
    assert factor.solve(np.array([3.0, 3.0])) == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("make", [make_factor, SuperLU])
@pytest.mark.parametrize("shape", [(0,), (0, 3)])
def test_a_matrix_without_rows_is_factored_and_its_factor_ends_in_silence(make, shape, monkeypatch):
    """As where all blocks stick to supports. What a `__del__` raises Python tells by a hook."""
    told = []
    monkeypatch.setattr("sys.unraisablehook", told.append)
    factor = make()
    factor.update(sparse.csr_array((0, 0)))
    assert factor.solve(np.zeros(shape)).shape == shape
    del factor
    gc.collect()
    assert not told


@pytest.mark.parametrize(("force", "allowed"), [(1e160, False), (1e30, False), (9e29, True), (1e-31, False)])
def test_loads_are_of_a_size_that_has_digits(force, allowed):
    # Half the weight is the friction.
    if allowed:
        assert limit_load(SCENE, along_x(force)).lower == pytest.approx(4905.0 / force, rel=1e-6)
        assert assess(SCENE, loads=along_x(force)).outcome is Outcome.UNSTABLE
        return
    with pytest.raises(InputError, match=r"below 1e\+30 N or N m" if force > 1 else "load is zero on every free block"):
        limit_load(SCENE, along_x(force))
    if force > 1:
        with pytest.raises(InputError, match=r"the largest force or moment of a load is 1e\+.*; it must be below"):
            assess(SCENE, loads=along_x(force))


@pytest.mark.parametrize("friction", [1.1e6, 1e300])
def test_no_sliding_is_asked_for_by_an_infinite_friction(friction):
    for ask in (
        lambda: SCENE.with_(friction=friction),
        lambda: assess(SCENE, friction=friction),
        lambda: JointLaw(("*", "*"), friction=friction),
    ):
        with pytest.raises(InputError, match=r"friction is .*; it must be at most 1e6, or inf for no sliding"):
            ask()


@pytest.mark.parametrize("friction", [1e6, inf])
def test_joints_that_hardly_slide_and_those_that_do_not_tip(friction):
    asm = SCENE.with_(joints=[JointLaw(("*", "*"), friction=friction)])
    assert limit_load(asm, (1, 0, 0)).lower == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(("name", "unit"), [("bond", "N"), ("bond_moment", "N m")])
def test_a_bond_that_nothing_bears_is_refused(name, unit):
    assert getattr(JointLaw(("*", "*"), **{name: 1e10}), name) == 1e10
    with pytest.raises(InputError, match=rf"{name} is 11000000000.0 {unit}; no bond bears 1e\+10"):
        JointLaw(("*", "*"), **{name: 1.1e10})


def test_a_tie_yields_below_all_that_has_digits_or_never():
    assert Tie((0, 1), ENDS, greatest=1e10).greatest == 1e10
    assert Tie((0, 1), ENDS).greatest == inf
    with pytest.raises(InputError, match=r"greatest is 1e\+20 N; it must be at most 1e\+10 N, or inf"):
        Tie((0, 1), ENDS, greatest=1e20)


@pytest.mark.parametrize("strut", ["no", 1, None])
def test_a_strut_is_one_or_not(strut):
    with pytest.raises(InputError, match=r"^tie: strut is .*; it must be true or false$"):
        Tie((0, 1), ENDS, strut=strut)


def test_an_anchor_plate_has_a_density():
    with pytest.raises(InputError, match='block "plate": density is -5; it must be a positive number'):
        anchor_plate((0, 0, 2), (-1, 0, 0), (0.4, 0.6), density=-5)


def test_one_density_counts_for_all_blocks_and_a_bad_one_names_its_block():
    light = SCENE.with_(density=800)
    assert light.density.tolist() == [800.0, 800.0]
    assert light.mass[1] == pytest.approx(800.0)
    assert SCENE.with_(density=[1, 2]).density.dtype == float
    for bad, says in (
        ([1000.0, 0.0], 'block "cube": density is 0.0'), (-1.0, 'block "ground": density is -1.0'),
        ([1000.0, nan], 'block "cube": density is nan'), (1e30, 'block "ground": density is 1e'),
        ([1.0, 2.0, 3.0], "one for each of the 2 blocks"), ("stone", "one for each of the 2 blocks"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=says):
            SCENE.with_(density=bad)


def test_supports_are_true_or_false_for_each_block():
    for given in ([False, True], (0, 1), np.array([0.0, 1.0])):
        changed = SCENE.with_(support=given)
        assert changed.support.dtype == bool
        assert changed.free.tolist() == [0]
    for bad in ([True], True, ["ground", "cube"], [0, 2], None, [nan, 1.0]):
        with pytest.raises(InputError, match="support must be true or false for each of the 2 blocks"):
            SCENE.with_(support=bad)


@pytest.mark.parametrize("top", [inf, nan, 0.0, -1.0, "10", None])
def test_the_most_friction_that_is_tried_is_finite(top):
    with pytest.raises(InputError, match=r"top is .*; it must be above 0"):
        friction_limit(SCENE, top=top)


@pytest.mark.parametrize("width", [0.0, -1.0, nan, "wide"])
def test_a_bracket_of_friction_has_a_width(width):
    with pytest.raises(InputError, match=r"width is .*; it must be at least 1e-12"):
        friction_limit(SCENE, width=width)


def test_a_bracket_of_friction_ends_where_no_number_is_between():
    found = friction_limit(SCENE, gravity=(3, 0, -9), width=1e-12)
    assert (found.stands, found.falls) == pytest.approx((1 / 3, 1 / 3), rel=1e-5)
