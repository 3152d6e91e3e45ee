"""The verifications of mechanisms and their spectra: values of the formulas by hand, what is told and what refused."""

import re
from dataclasses import replace
from functools import cache
from math import inf, nan, sqrt

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Floor,
    InputError,
    Site,
    SpectrumTable,
    box,
    capacity,
    limit_load,
    linear_check,
    nonlinear_check,
)
from blockstat.code_check.linear import GREATEST, bearable
from blockstat.large_displacement.capacity_curve import CapacityOutcome
from evidence.scenes.small import trilith

SIDE = (1, 0, 0)


@cache
def wall():
    """4 m high and .5 m thick: it turns about its foot at .5 / 4."""
    blocks = [box((-1, -1, -1), (2, 4, 0), name="ground"), box((0, 0, 0), (0.5, 3, 4), name="wall")]
    return Assembly.from_blocks(blocks, supports=["ground"])


@cache
def limit():
    return limit_load(wall(), SIDE)


@cache
def curve():
    return capacity(wall(), SIDE, control="wall")


TOP = (0.25, 1.5, 4.0)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"confidence": 0.99}, "confidence is 0.99; it must be at least 1"),
        ({"confidence": nan}, "confidence is nan; it must be at least 1"),
        ({"confidence": inf}, "confidence is inf; it must be at least 1"),
        ({"behaviour": 0.5}, "behaviour is 0.5; it must be at least 1"),
        ({"behaviour": inf}, "behaviour is inf; it must be at least 1"),
        ({"macro_blocks": 0}, "macro_blocks is 0; it must be at least 1"),
        ({"masses": [("wall", TOP, 0.0)]}, "masses: the weight on 'wall' is 0.0; it must be above 0"),
        ({"masses": [("wall", TOP, -5.0)]}, "masses: the weight on 'wall' is -5.0; it must be above 0"),
        ({"masses": [("wall", TOP, inf)]}, "masses: the weight on 'wall' is inf; it must be above 0"),
    ],
)
def test_a_linear_check_refuses_bad_numbers(options, says):
    with pytest.raises(InputError, match=re.escape(says)):
        linear_check(limit(), SIDE, **options)


@pytest.mark.parametrize("direction", [(-1, 0, 0), (0, 1, 0)])
def test_a_mechanism_is_verified_along_its_own_load(direction):
    moved = replace(limit(), mechanism=np.where(np.abs(limit().mechanism) < 1e-9, 0.0, limit().mechanism))
    says = f"the mechanism does not move along {list(direction)}; give the direction of its load"
    with pytest.raises(InputError, match=re.escape(says)):
        linear_check(moved, direction)


def test_the_ends_of_what_a_linear_check_takes_are_taken():
    found = linear_check(limit(), SIDE, confidence=1, behaviour=1, macro_blocks=1)
    assert found.acceleration == pytest.approx(0.125 * 9.81, rel=1e-6)  # alpha0 g, e* = FC = 1


def test_no_ground_acceleration_is_told_beyond_the_greatest():
    assert GREATEST == 10.0
    assert bearable(lambda ag: 0.1 * ag, 1.0) == 10.0
    assert bearable(lambda ag: 0.1 * ag, 2.0) == 10.0
    assert bearable(lambda ag: 0.1 * ag, 0.5) == pytest.approx(5.0)


@pytest.mark.parametrize("confidence", [0.99, nan, inf])
def test_a_nonlinear_check_refuses_a_confidence_below_one(confidence):
    with pytest.raises(InputError, match=f"confidence is {confidence!r}; it must be at least 1"):
        nonlinear_check(curve(), SIDE, confidence=confidence)


def test_without_a_demand_a_check_tells_a_capacity():
    found = nonlinear_check(curve(), SIDE)
    assert found.outcome.word == "capacity"
    assert found.explain().splitlines()[0] == "Capacity: no demand was given."
    asked = nonlinear_check(curve(), SIDE, demand={"SLV": 1e-3})
    assert asked.explain().splitlines()[0] == "Satisfied: all demands are borne."
    asked = nonlinear_check(curve(), SIDE, demand={"SLV": 1e-3, "SLD": 9.0})
    assert asked.explain().splitlines()[0] == "Not satisfied: a demand is not borne."


def test_a_curve_that_ends_before_zero_is_warned_of():
    words = "the curve ends before the multiplier is zero; d0 is its end"
    assert words not in nonlinear_check(curve(), SIDE).warnings
    half = curve().points[: len(curve().points) // 2]
    short = replace(curve(), outcome=CapacityOutcome.COLLAPSE, points=half)
    found = nonlinear_check(short, SIDE)
    assert words in found.warnings
    part = half[-1].displacement / curve().points[-1].displacement
    assert found.ultimate == pytest.approx(part * nonlinear_check(curve(), SIDE).ultimate, rel=1e-12)
    assert words not in nonlinear_check(replace(short, outcome=CapacityOutcome.ZERO), SIDE).warnings


def test_one_body_that_turns_is_a_rocking_block():
    """Housner: R is half the diagonal, p^2 = 3 g / (4 R)."""
    found = nonlinear_check(curve(), SIDE)
    radius = sqrt(0.25**2 + 2.0**2)
    assert found.rocking.radius == pytest.approx(radius, rel=1e-6)
    assert found.rocking.frequency == pytest.approx(sqrt(3 * 9.81 / (4 * radius)), rel=1e-6)
    assert "One rocking block: R = " in found.explain()


@pytest.mark.parametrize("motion", [(1, 0, 0, 0, 0, 0), (1, 0.2, 0, 0, 0.5, 0)], ids=["slides", "screws"])
def test_a_body_that_slides_or_screws_is_no_rocking_block(motion):
    first = replace(curve().points[0], mechanism=np.array([np.zeros(6), np.array(motion, dtype=float)]))
    found = nonlinear_check(replace(curve(), points=(first, *curve().points[1:])), SIDE)
    assert found.rocking is None
    assert "rocking block" not in found.explain()


def test_a_portal_of_three_bodies_is_no_rocking_block():
    found = nonlinear_check(capacity(trilith(), SIDE, control="mean"), SIDE, macro_blocks=3)
    assert len(found.bodies) == 3
    assert found.rocking is None
    assert "rocking block" not in found.explain()


BAD = [0.0, -1.0, nan, inf]


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("name", ["f0", "tc_star", "topography"])
def test_the_numbers_of_a_site_are_positive(name, value):
    with pytest.raises(InputError, match=re.escape(f"site: {name} is {value!r}; it must be above 0")):
        Site(**{name: value})


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("name", ["period", "own_period", "gamma", "psi", "damping", "own_damping"])
def test_the_numbers_of_a_floor_are_positive(name, value):
    with pytest.raises(InputError, match=re.escape(f"floor: {name} is {value!r}; it must be above 0")):
        Floor(**{"period": 0.3, "own_period": 0.2, "gamma": 1.2} | {name: value})


@pytest.mark.parametrize(
    ("periods", "values", "says"),
    [
        ((0.0,), (1.0,), "periods and values must be as many numbers, two at least"),
        ((0.0, 1.0), (1.0, 2.0, 3.0), "periods and values must be as many numbers, two at least"),
        (((0.0, 1.0),), ((1.0, 2.0),), "periods and values must be as many numbers, two at least"),
        ((0.1, 1.0), (1.0, 2.0), "periods must ascend from 0"),
        ((0.0, 1.0, 1.0), (1.0, 2.0, 3.0), "periods must ascend from 0"),
        ((0.0, inf), (1.0, 2.0), "periods must ascend from 0"),
        ((0.0, 1.0), (0.0, 2.0), "values must be at least 0, and above 0 at the period 0"),
        ((0.0, 1.0), (1.0, -2.0), "values must be at least 0, and above 0 at the period 0"),
        ((0.0, 1.0), (1.0, nan), "values must be at least 0, and above 0 at the period 0"),
    ],
)
def test_a_table_of_a_spectrum_ascends_from_zero(periods, values, says):
    with pytest.raises(InputError, match=f"spectrum: {says}"):
        SpectrumTable(periods, values)


@pytest.mark.parametrize(
    ("own", "off"),
    [
        (0.24, 0.0),  # .8 T1
        (0.30, 0.0),
        (0.33, 0.0),  # 1.1 T1
        (0.12, 0.5**1.6),
        (0.66, 1.0**1.2),
        (0.495, 0.5**1.2),
    ],
)
def test_a_floor_amplifies_most_from_eight_tenths_to_eleven_tenths_of_its_period(own, off):
    peak = 1.1 / sqrt(0.05)  # eta of 5 % is 1
    expected = 1.2 * 0.5 * sqrt(1.0 + 0.0004 * 25.0) * peak / (1.0 + (peak - 1.0) * off)
    assert Floor(period=0.3, own_period=own, gamma=1.2, psi=0.5).factor() == pytest.approx(expected, rel=1e-12)
