"""What joint laws and ties accept, refuse and write, each condition from both sides."""

from dataclasses import FrozenInstanceError
from math import inf, nan

import numpy as np
import pytest

from blockstat import InputError, JointLaw, Tie
from blockstat.joint import CELLS, MOST_CELLS, check_laws, fits


@pytest.mark.parametrize("between", ["ab", "wall", ("a",), ("a", "b", "c"), ("a", 1), None, {"a", "b"}, (None, "b")])
def test_a_law_is_between_two_group_names(between):
    with pytest.raises(InputError, match="it must be two group names"):
        JointLaw(between)


def test_a_law_may_be_between_a_list_of_two_names():
    assert JointLaw(["a", "b"]).between == ["a", "b"]


@pytest.mark.parametrize("name", ["friction", "tension", "bond", "cohesion", "bond_moment", "compression"])
@pytest.mark.parametrize("value", ["1", True, False, [1.0], 1j])
def test_the_numbers_of_a_law_are_numbers(name, value):
    with pytest.raises(InputError, match=f"joint law between a and b: {name} is .*; it must be a number"):
        JointLaw(("a", "b"), **{name: value})


@pytest.mark.parametrize("name", ["tension", "bond"])
def test_a_strength_of_none_is_written_as_zero(name):
    with pytest.raises(InputError, match=f"{name} is None; it must be a number"):
        JointLaw(("a", "b"), **{name: None})


@pytest.mark.parametrize("name", ["friction", "cohesion", "bond_moment", "compression"])
def test_what_a_law_does_not_say_is_none(name):
    assert getattr(JointLaw(("a", "b"), **{name: None}), name) is None
    assert getattr(JointLaw(("a", "b")), name) is None


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("friction", -1e-9, "at least 0"),
        ("friction", nan, "at least 0"),
        ("friction", 0, None),
        ("friction", inf, None),
        ("tension", -1e-9, "at least 0"),
        ("tension", inf, "at least 0"),
        ("tension", 0, None),
        ("tension", 1e10, None),
        ("bond", -1e-9, "at least 0"),
        ("bond", inf, "at least 0"),
        ("bond", 0.0, None),
        ("cohesion", -1e-9, "at least 0"),
        ("cohesion", inf, "at least 0"),
        ("cohesion", 0.0, None),
        ("bond_moment", -1e-9, "at least 0"),
        ("bond_moment", inf, "at least 0"),
        ("bond_moment", 0.0, None),
        ("compression", 0.0, "above 0"),
        ("compression", inf, "above 0"),
        ("compression", nan, "above 0"),
        ("compression", -1.0, "above 0"),
        ("compression", 1e-30, None),
        ("compression", np.float32(2), None),
    ],
)
def test_the_numbers_of_a_law_have_bounds(name, value, says):
    if says is None:
        assert getattr(JointLaw(("a", "b"), **{name: value}), name) == value
    else:
        with pytest.raises(InputError, match=f"joint law between a and b: {name} is .*; it must be {says}"):
            JointLaw(("a", "b"), **{name: value})


@pytest.mark.parametrize(
    ("cells", "ok"), [(0, True), (1, True), (64, True), (65, False), (-1, False), (True, False), (2.0, False)]
)
def test_a_law_divides_joints_into_at_most_sixty_four_cells_a_side(cells, ok):
    assert MOST_CELLS == 64
    if ok:
        assert JointLaw(("a", "b"), cells=cells).cells == cells
    else:
        with pytest.raises(InputError, match=f"cells is {cells!r}; it must be 0 to 64"):
            JointLaw(("a", "b"), cells=cells)


def test_a_joint_that_may_crush_has_eight_cells_a_side_unless_the_law_says_otherwise():
    assert CELLS == 8
    assert JointLaw(("a", "b")).divisions == 0
    assert JointLaw(("a", "b"), compression=1.0).divisions == 8
    assert JointLaw(("a", "b"), compression=1.0, cells=3).divisions == 3
    assert JointLaw(("a", "b"), cells=1).divisions == 1


@pytest.mark.parametrize(
    ("law", "strong"),
    [
        ({}, False),
        ({"friction": 0.3, "cells": 2}, False),
        ({"tension": 1.0}, True),
        ({"bond": 1.0}, True),
        ({"cohesion": 0.0}, True),
        ({"bond_moment": 1.0}, True),
        ({"compression": 1.0}, True),
    ],
)
def test_a_law_of_friction_alone_is_no_strength(law, strong):
    assert JointLaw(("a", "b"), **law).strong is strong
    assert JointLaw(("a", "b"), **law).as_dict() == {"between": ("a", "b"), **law}
    with pytest.raises(FrozenInstanceError):
        JointLaw(("a", "b")).friction = 1.0
    assert JointLaw(("a", "b"), **law) == JointLaw(("a", "b"), **law)


def test_the_numbers_of_a_law_default_to_nothing():
    law = JointLaw(("a", "b"))
    assert (law.tension, law.bond, law.cells) == (0.0, 0.0, 0)
    assert (law.friction, law.cohesion, law.bond_moment, law.compression) == (None,) * 4


@pytest.mark.parametrize(
    ("name", "group", "does"),
    [
        ("*", "", True),
        ("*", "a.b", True),
        ("wall", "wall", True),
        ("wall", "wall.north", True),
        ("wall", "wall2", False),
        ("wall.north", "wall", False),
        ("wall", "a.wall", False),
        ("a.b", "a.b.c", True),
        ("", "", True),
        ("wall", "", False),
    ],
)
def test_a_name_means_a_group_and_its_parts(name, group, does):
    assert fits(name, group) is does


def test_laws_are_about_groups_that_exist():
    groups = ["wall.north", "", "vault", "wall.north"]
    check_laws([JointLaw(("wall", "*")), JointLaw(("vault", "wall.north"))], groups)
    check_laws([], groups)
    with pytest.raises(InputError) as caught:
        check_laws([JointLaw(("walls", "vault")), JointLaw(("vault.top", "walls"))], groups)
    told = caught.value.told()
    assert [text.split('"')[1] for text in told] == ["walls", "vault.top"]
    assert all(text.startswith("joint law: no group") for text in told)
    assert all("vault, wall.north" in text for text in told)


POINTS = ((0.0, 0.0, 2.0), (4.0, 0.0, 2.0))


@pytest.mark.parametrize("between", ["ab", ("a",), ("a", "b", "c"), ("a", "a"), (3, 3), None])
def test_a_tie_is_between_two_blocks(between):
    with pytest.raises(InputError, match=r"^tie: between is .*; it must be two blocks"):
        Tie(between, POINTS)


def test_blocks_of_a_tie_are_named_or_numbered():
    assert Tie(["a", 2], POINTS).between == ["a", 2]
    assert Tie((0, 1), POINTS).between == (0, 1)


@pytest.mark.parametrize(
    "points",
    [
        ((0, 0, 2), (0, 0, 2)),
        ((0, 0), (1, 0)),
        ((0, 0, 2),),
        ((0, 0, 2), (1, 0, 2), (2, 0, 2)),
        ((0, 0, nan), (1, 0, 2)),
        ((0, 0, 2), (inf, 0, 2)),
        "points",
        None,
        ((0, 0, 2), (1, 0)),
        ((0, 0, "x"), (1, 0, 2)),
        ({}, {}),
    ],
)
def test_a_tie_has_two_different_points_of_three_numbers(points):
    with pytest.raises(
        InputError, match=r'^tie "bar": points are .*; they must be two different points of three numbers'
    ):
        Tie(("a", "b"), points, name="bar")


@pytest.mark.parametrize("axis", range(3))
def test_points_that_differ_along_one_axis_are_two(axis):
    other = [0.0, 0.0, 2.0]
    other[axis] += 1e-9
    assert Tie(("a", "b"), (POINTS[0], tuple(other))).points[1] == tuple(other)


@pytest.mark.parametrize("field", ["least", "greatest"])
@pytest.mark.parametrize("value", ["1", True, None, -1e-9, nan, [1.0]])
def test_the_forces_of_a_tie_are_numbers_of_at_least_nothing(field, value):
    with pytest.raises(InputError, match=f"tie: {field} is .*; it must be a number of at least 0"):
        Tie(("a", "b"), POINTS, **{field: value})


@pytest.mark.parametrize(
    ("least", "greatest", "ok"), [(1, 1, True), (1, 2, True), (2, 1, False), (inf, inf, False), (0, 0, True)]
)
def test_the_least_force_of_a_tie_is_finite_and_at_most_its_greatest(least, greatest, ok):
    if ok:
        tie = Tie(("a", "b"), POINTS, least=least, greatest=greatest)
        assert tie.constant is (least == greatest)
    else:
        with pytest.raises(InputError, match=f"tie: least is {least}; it must be at most greatest, {greatest}"):
            Tie(("a", "b"), POINTS, least=least, greatest=greatest)


def test_a_tie_is_written_by_what_differs_from_a_plain_one():
    plain = Tie(("a", "b"), POINTS)
    assert plain.as_dict() == {"between": ("a", "b"), "points": POINTS}
    assert (plain.least, plain.greatest, plain.strut, plain.name, plain.label) == (0.0, inf, False, "", "tie")
    assert not plain.constant
    full = Tie(("a", "b"), POINTS, least=1.0, greatest=np.float32(2), strut=True, name="bar")
    assert full.as_dict() == {
        "between": ("a", "b"), "points": POINTS, "least": 1.0, "greatest": 2.0, "strut": True, "name": "bar",
    }  # fmt: skip
    assert full.label == 'tie "bar"'
    with pytest.raises(FrozenInstanceError):
        full.least = 0.0
