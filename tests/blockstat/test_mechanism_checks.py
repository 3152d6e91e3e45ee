"""The verifications of mechanisms and their spectra: values of the formulas by hand, what is told and what refused."""

import re
from dataclasses import replace
from functools import cache
from math import atan, inf, nan, sqrt

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Floor,
    InputError,
    JointLaw,
    Site,
    SpectrumTable,
    Tie,
    acceleration,
    body_load,
    box,
    capacity,
    limit_load,
    linear_check,
    load_cases,
    nonlinear_check,
    point_load,
)
from blockstat.code_check.linear import GREATEST, bearable
from blockstat.large_displacement.capacity_curve import CapacityOutcome
from blockstat.large_displacement.finite_steps.fall import FallenBlocks
from blockstat.loads import WeightedLoads
from evidence.scenes.small import stack, trilith

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
        ({"behaviour": 0.5}, "behaviour is 0.5; it must be from 1 to 5"),
        ({"behaviour": inf}, "behaviour is inf; it must be from 1 to 5"),
        ({"macro_blocks": 0}, "macro_blocks is 0; it must be a whole number of at least 1"),
        ({"masses": [("wall", TOP, 0.0)]}, "masses: the weight on 'wall' is 0.0; it must be above 0"),
        ({"masses": [("wall", TOP, -5.0)]}, "masses: the weight on 'wall' is -5.0; it must be above 0"),
        ({"masses": [("wall", TOP, inf)]}, "masses: the weight on 'wall' is inf; it must be above 0"),
        ({"masses": [("wall", (0.25, 1.5), 1e4)]}, "masses: the point is (0.25, 1.5); it must be three finite numbers"),
        ({"demand": -0.1}, "demand is -0.1; it must be above 0"),
        ({"demand": nan}, "demand is nan; it must be above 0"),
        ({"demand": inf}, "demand is inf; it must be above 0"),
        ({"demand": True}, "demand is True; it must be above 0"),
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


def test_each_limit_state_has_a_spectrum_of_its_own():
    soft = {"SLD": Site("B", tc_star=0.28), "SLV": Site("B", tc_star=0.3), "SLC": Site("B", tc_star=0.36)}
    found = nonlinear_check(curve(), SIDE, site=soft)
    for name, own in soft.items():
        assert found.state(name).ag == nonlinear_check(curve(), SIDE, site=own).state(name).ag
    assert found.state("SLC").ag < nonlinear_check(curve(), SIDE, site=soft["SLD"]).state("SLC").ag
    words = "F0 and TC* are those of one return period for SLC, SLV; site= takes one for each"
    demand = {"SLV": 0.1, "SLC": 0.2}
    assert words in nonlinear_check(curve(), SIDE, site=soft["SLV"], demand=demand).warnings
    assert words not in nonlinear_check(curve(), SIDE, site=soft, demand=demand).warnings
    with pytest.raises(InputError, match="site has no spectrum of SLD, SLC; a mapping has one of SLD, SLV, SLC"):
        nonlinear_check(curve(), SIDE, site={"SLV": Site()})


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


def test_a_floor_on_a_wall_rocks_with_it():
    """As heavy as the wall, at its top: of 2 M the centroid is 3 m high, and I = M / 3 (b^2 + h^2) + M r^2."""
    weight = wall().free_weight
    push = [("wall", (0.25, 1.5, 2.0), (weight, 0, 0)), ("wall", TOP, (weight, 0, 0))]
    heavy = capacity(wall(), push, loads=[("wall", TOP, (0, 0, -weight))], control="wall")
    found = nonlinear_check(heavy, SIDE, masses=[("wall", TOP, weight)]).rocking
    assert found.slenderness == pytest.approx(atan(0.25 / 3.0), rel=1e-6)
    radius, about = sqrt(0.25**2 + 3.0**2), (0.5**2 + 4.0**2) / 3 + 0.25**2 + 4.0**2
    assert found.radius == pytest.approx(radius, rel=1e-6)
    assert found.frequency == pytest.approx(sqrt(2 * 9.81 * radius / about), rel=1e-6)


@pytest.mark.parametrize(
    "motion",
    [(1, 0, 0, 0, 0, 0), (1, 0.2, 0, 0, 0.5, 0), (1, 0, 0, 0, 0.4, 0.3)],
    ids=["slides", "screws", "about a slope"],
)
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
@pytest.mark.parametrize(("name", "allowed"), [("f0", "1 to 10"), ("tc_star", "0.01 to 5"), ("topography", "1 to 3")])
def test_the_numbers_of_a_site_are_those_of_a_site(name, allowed, value):
    with pytest.raises(InputError, match=re.escape(f"site: {name} is {value!r}; it must be from {allowed}")):
        Site(**{name: value})


@pytest.mark.parametrize("swapped", [{"f0": 0.3, "tc_star": 2.5}, {"tc_star": 300.0}, {"topography": 0.9}])
def test_numbers_of_a_site_that_ask_for_too_little_are_refused(swapped):
    with pytest.raises(InputError, match="it must be from"):
        Site(**swapped)


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("name", ["period", "own_period", "gamma", "psi", "damping", "own_damping"])
def test_the_numbers_of_a_floor_are_positive(name, value):
    with pytest.raises(InputError, match=re.escape(f"floor: {name} is {value!r}; it must be above 0")):
        Floor(**{"period": 0.3, "own_period": 0.2, "gamma": 1.2} | {name: value})


#: NTC 2018, table 3.2.IV: S_S of F0 ag/g, between its ends, and C_C of TC*.
TABLE = {
    "A": (lambda x: 1.0, (1.0, 1.0), lambda tc: 1.0),
    "B": (lambda x: 1.40 - 0.40 * x, (1.00, 1.20), lambda tc: 1.10 * tc**-0.20),
    "C": (lambda x: 1.70 - 0.60 * x, (1.00, 1.50), lambda tc: 1.05 * tc**-0.33),
    "D": (lambda x: 2.40 - 1.50 * x, (0.90, 1.80), lambda tc: 1.25 * tc**-0.50),
    "E": (lambda x: 2.00 - 1.10 * x, (1.00, 1.60), lambda tc: 1.15 * tc**-0.40),
}


@pytest.mark.parametrize("soil", TABLE)
@pytest.mark.parametrize(("f0", "ag"), [(2.5, 0.2), (2.0, 0.3), (2.5, 0.02), (2.5, 0.6)])
def test_a_soil_amplifies_as_the_table_says_between_its_ends(soil, f0, ag):
    factor, (least, greatest), _ = TABLE[soil]
    assert Site(soil, f0=f0).amplification(ag) == pytest.approx(min(max(factor(f0 * ag), least), greatest), rel=1e-12)


@pytest.mark.parametrize(
    ("soil", "least", "greatest"), [("B", 1.0, 1.2), ("C", 1.0, 1.5), ("D", 0.9, 1.8), ("E", 1.0, 1.6)]
)
def test_the_amplification_of_a_soil_has_two_ends(soil, least, greatest):
    assert (Site(soil).amplification(0.6), Site(soil).amplification(0.02)) == (least, greatest)


@pytest.mark.parametrize("soil", TABLE)
@pytest.mark.parametrize("tc_star", [0.3, 0.45])
def test_a_soil_moves_the_ends_of_the_plateau(soil, tc_star):
    """TC = C_C TC*, TB = TC / 3 and TD = 4 ag/g + 1.6 = 2.4 s."""
    site, corner = Site(soil, tc_star=tc_star), TABLE[soil][2](tc_star) * tc_star
    plateau = 0.2 * site.amplification(0.2) * 2.5
    for period in (corner / 3, 0.9 * corner, corner * (1 + 1e-12)):
        assert site.spectrum(0.2, period) == pytest.approx(plateau, rel=1e-9)
    assert site.spectrum(0.2, 0.0) == pytest.approx(plateau / 2.5, rel=1e-12)
    assert site.spectrum(0.2, corner / 6) == pytest.approx(plateau * (0.5 + 0.5 / 2.5), rel=1e-12)
    assert site.spectrum(0.2, 2 * corner) == pytest.approx(plateau / 2, rel=1e-12)
    assert site.spectrum(0.2, 4.8) == pytest.approx(plateau * corner * 2.4 / 4.8**2, rel=1e-12)


@pytest.mark.parametrize(
    ("soil", "amplified", "corner", "after_one_second"),
    [
        ("B", 1.20, 0.419846, 0.251907),
        ("C", 1.40, 0.468663, 0.328064),
        ("D", 1.65, 0.684653, 0.564839),
        ("E", 1.45, 0.558432, 0.404863),
    ],
)
@pytest.mark.parametrize("topography", [1.0, 1.2])
def test_the_spectrum_of_a_soil_by_hand(soil, amplified, corner, after_one_second, topography):
    """F0 = 2.5, TC* = .3 s and ag = .2 g: at 1 s S_e = ag S F0 TC, and S_T multiplies all of it."""
    site = Site(soil, f0=2.5, tc_star=0.3, topography=topography)
    assert site.amplification(0.2) == pytest.approx(topography * amplified, rel=1e-12)
    assert site.spectrum(0.2, 0.4) == pytest.approx(topography * 0.2 * amplified * 2.5, rel=1e-12)
    assert site.spectrum(0.2, 1.0) == pytest.approx(topography * after_one_second, rel=3e-6)
    assert site.spectrum(0.2, 1.0) / site.spectrum(0.2, 0.4) == pytest.approx(corner, rel=3e-6)


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
        ((0.0, "a"), (1.0, 2.0), "periods and values must be as many numbers, two at least"),
        ((0.0, 1.0), (1.0, nan), "values must be at least 0, and above 0 at the period 0"),
    ],
)
def test_a_table_of_a_spectrum_ascends_from_zero(periods, values, says):
    with pytest.raises(InputError, match=f"spectrum: {says}"):
        SpectrumTable(periods, values)


@pytest.mark.parametrize(("soil", "corner"), [("A", 0.3), ("C", 1.05 * 0.3**-0.33 * 0.3)])
def test_a_table_of_a_spectrum_is_damped_like_the_spectrum_of_the_site(soil, corner):
    # NTC 2018, 3.2.2: a straight line from ag S at T = 0 to eta ag S F0 at T_B = T_C / 3, and eta times the rest.
    site = Site(soil)
    periods = (0.0, corner / 3, corner)
    table = SpectrumTable(periods, tuple(site.spectrum(0.2, period) for period in periods))
    there = np.linspace(0, corner, 31)
    found = [table.spectrum(site.spectrum(0.2, 0), period, damping=12.0) for period in there]
    assert found == pytest.approx([site.spectrum(0.2, period, damping=12.0) for period in there], rel=1e-9)


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


#: The least roots of ag (2.4 - 3.75 ag) = k, where soil D has S = 2.4 - 1.5 F0 ag.
ROOTS = {k: (2.4 - sqrt(2.4**2 - 15 * k)) / 7.5 for k in (0.361, 0.37, 0.3839)}


@pytest.mark.parametrize("k", ROOTS)
def test_on_soil_d_the_least_of_three_accelerations_is_what_is_borne(k):
    """ag S rises to .384 at .32, falls to .36 at .40 and rises again."""
    soft = Site("D", f0=2.5)
    assert [soft.spectrum(ag, 0.0) for ag in (0.32, 0.40)] == pytest.approx([0.384, 0.36])
    assert bearable(lambda ag: soft.spectrum(ag, 0.0), k) == pytest.approx(ROOTS[k], rel=1e-12)


def test_a_peak_that_is_just_borne_is_no_bound():
    soft = Site("D", f0=2.5)
    assert bearable(lambda ag: soft.spectrum(ag, 0.0), 0.384 * (1 + 1e-9)) == pytest.approx(0.384 / 0.9, rel=1e-8)
    assert bearable(lambda ag: soft.spectrum(ag, 0.0), 0.384 * (1 - 1e-9)) == pytest.approx(0.32, rel=1e-4)


@pytest.mark.parametrize(("demand", "word"), [(0.2588, "satisfied"), (0.2590, "not_satisfied"), (0.32, "not_satisfied"),
                                              (0.40, "satisfied"), (0.42, "not_satisfied")])  # fmt: skip
def test_a_demand_is_compared_at_its_own_acceleration(demand, word):
    """A wall .24975 x 1 bears q a0* = .37 g: ag S is .384 at .32, .36 at .40 and .378 at .42."""
    low = Assembly.from_blocks(
        [box((-1, -1, -1), (2, 4, 0), name="ground"), box((0, 0, 0), (0.24975, 3, 1), name="wall")], supports=["ground"]
    )
    found = linear_check(limit_load(low, SIDE), SIDE, site=Site("D", f0=2.5), demand=demand)
    assert found.outcome.word == word
    assert found.ag_life == pytest.approx(ROOTS[0.37], rel=1e-7)
    assert round(found.ag_life, 5) == 0.25890
    told = "; on this soil lesser accelerations are not all borne" if demand == 0.4 else ""
    assert f"ag = 0.258899 g (SLV), asked for {demand:g} g{told}." in found.explain()
    wide = Assembly.from_blocks(
        [box((-1, -1, -1), (2, 4, 0), name="ground"), box((0, 0, 0), (0.4995, 3, 1), name="wall")], supports=["ground"]
    )
    curve = capacity(wide, SIDE, control="wall", steps=5)
    found = nonlinear_check(curve, SIDE, site=Site("D", f0=2.5), demand={"SLD": demand})
    assert found.outcome.word == word
    assert found.state("SLD").ag == pytest.approx(ROOTS[0.37], rel=1e-6)
    assert f"ag = 0.258899 g, asked for {demand:g} g{told}." in found.explain()


def two():
    """Two walls side by side, each 4 m high and .5 m thick."""
    walls = [box((3 * k, 0, 0), (3 * k + 0.5, 3, 4), name=f"wall{k}") for k in range(2)]
    return Assembly.from_blocks([box((-2, -1, -1), (5, 4, 0), name="ground"), *walls], supports=["ground"])


def pushed(scene, name):
    """Loads on two walls that are no acceleration of both along x."""
    single = acceleration(scene, SIDE)
    single[2] = 0.0
    weight = scene.free_weight / 2
    at_top = [point_load(scene, f"wall{k}", (3 * k, 1.5, 4), (weight, 0, 0)) for k in range(2)]
    return {
        "one wall": single,
        "at the top": sum(at_top),
        "in newtons": at_top[0] / weight,
        "askew": acceleration(scene, (1, 1, 0)),
        "a tenth": 0.1 * acceleration(scene, SIDE),
        "a triangle": acceleration(scene, SIDE, profile=[(0, 0), (4, 1)]),
    }[name]


@pytest.mark.parametrize("name", ["one wall", "at the top", "in newtons", "askew", "a tenth", "a triangle"])
@pytest.mark.parametrize("told", [False, True])
def test_a_limit_under_another_load_than_an_acceleration_is_refused(name, told):
    found = limit_load(two(), pushed(two(), name))
    assert found.outcome.word == "limit"
    loads = {"loads": np.zeros((3, 6))} if told else {}
    says = "the limit is not that of an acceleration along [1.0, 0.0, 0.0] of all that has mass: another load acts on"
    with pytest.raises(InputError, match=re.escape(says)):
        linear_check(found, SIDE, **loads)


def test_permanent_loads_that_hold_back_are_told():
    """A force P at the top holds a wall of weight W: alpha0 = b / h + 2 P / W."""
    weight = wall().free_weight
    back = point_load(wall(), "wall", (0, 1.5, 4), (-0.01 * weight, 0, 0))
    held = limit_load(wall(), SIDE, loads=back)
    assert held.lower == pytest.approx(0.125 + 0.02, rel=1e-6)
    with pytest.raises(InputError, match="permanent loads that hold back are told as loads="):
        linear_check(held, SIDE)
    found = linear_check(held, SIDE, loads=back)
    assert found.acceleration == pytest.approx(0.145 * 9.81 / 1.35, rel=1e-6)
    with pytest.raises(InputError, match='another load acts on "wall" \\(with these permanent loads\\)'):
        linear_check(held, SIDE, loads=0.5 * back)
    with pytest.raises(InputError, match=r"loads have shape \(6,\); finite values of shape \(2, 6\) are needed"):
        linear_check(held, SIDE, loads=np.zeros(6))
    floor = point_load(wall(), "wall", (0.3, 1.5, 4), (0.0, 0, -weight))
    assert linear_check(limit_load(wall(), SIDE, loads=floor), SIDE).alpha0 > 0


def test_a_curve_of_another_load_is_refused():
    curve = capacity(wall(), point_load(wall(), "wall", (0, 1.5, 4), (wall().free_weight, 0, 0)), control="wall")
    with pytest.raises(InputError, match="the limit is not that of an acceleration"):
        nonlinear_check(curve, SIDE)


def test_what_ties_and_bonds_bear_is_no_load():
    """A tie at mid height yields at T: alpha0 = b / h + T / W. A bond of capacity F is a tension at the foot."""
    weight = wall().free_weight
    tie = Tie(("wall", "ground"), ((0, 1.5, 2), (-3, 1.5, 2)), greatest=0.05 * weight)
    found = linear_check(limit_load(wall().with_(ties=[tie]), SIDE), SIDE)
    assert found.alpha0 == pytest.approx(0.175, rel=1e-6)
    constant = replace(tie, least=0.05 * weight)
    assert linear_check(limit_load(wall().with_(ties=[constant]), SIDE), SIDE).alpha0 == pytest.approx(0.175, rel=1e-6)
    bond = JointLaw(("*", "*"), bond=0.1 * weight, bond_moment=0.01 * weight)
    found = linear_check(limit_load(wall().with_(joints=[bond]), SIDE), SIDE)
    assert found.alpha0 == pytest.approx(0.125 + (0.1 * 0.25 + 0.01) / 2, rel=1e-6)


@pytest.mark.parametrize("check", [lambda way: linear_check(limit(), way), lambda way: nonlinear_check(curve(), way)])
def test_a_direction_that_is_not_horizontal_is_refused(check):
    for way in ((1, 0, 0.1), (0, 0, 1)):
        says = f"direction is {[*map(float, way)]}; the acceleration of the code is horizontal"
        with pytest.raises(InputError, match=re.escape(says)):
            check(way)
    check((1, 0, 1e-4))


@pytest.mark.parametrize("damping", [2.0, 5.0, 10.0])
def test_the_spectrum_of_the_ground_below_a_floor_has_the_damping_of_the_building(damping):
    """C7.2.7: a_Z = S_e(T1, xi1) gamma psi sqrt(1 + .0004 xi1^2), with eta = sqrt(10 / (5 + xi1)) on the plateau."""
    high = Floor(period=0.3, own_period=0.3, gamma=1.2, damping=damping)
    peak = 1.1 / sqrt(damping / 100)
    expected = 0.1 * 2.5 * sqrt(10 / (5 + damping)) * 1.2 * sqrt(1 + 0.0004 * damping**2) * peak
    assert high.spectrum(Site("A"), 0.1) == pytest.approx(expected, rel=1e-12)
    borne = 0.125 / 1.35 * 0.1 / expected
    assert linear_check(limit(), SIDE, floor=high).ag_damage == pytest.approx(borne, rel=1e-6)
    assert nonlinear_check(curve(), SIDE, floor=high).state("SLD").ag == pytest.approx(borne, rel=1e-5)


def test_beyond_the_period_of_the_building_the_floor_asks_at_least_what_the_ground_does():
    """C7.2.5: a part of 1 s on a stiff building of .05 s; soil A has TC = .3 s, so S_e = .1 x 2.5 x .3."""
    slow = Floor(period=0.05, own_period=1.0, gamma=1.2, psi=0.1)
    assert slow.spectrum(Site("A"), 0.1) == pytest.approx(0.075, rel=1e-12)
    assert replace(slow, own_damping=10.0).spectrum(Site("A"), 0.1) == pytest.approx(0.075 * sqrt(10 / 15), rel=1e-12)
    stiff = Floor(period=1.0, own_period=0.3, gamma=1.2, psi=0.01)
    assert stiff.spectrum(Site("A"), 0.1) < 0.02


@pytest.mark.parametrize("value", [0.0, -0.1, nan, inf, "high"])
def test_a_nonlinear_check_refuses_a_demand_that_is_no_acceleration(value):
    with pytest.raises(InputError, match=re.escape(f"demand of SLV is {value!r}; it must be above 0")):
        nonlinear_check(curve(), SIDE, demand={"SLV": value})


@cache
def curve_of_a_point():
    """Its oscillator moves two thirds as far as its control, so displacements are rounded."""
    return capacity(wall(), SIDE, control=("wall", (0.25, 1.5, 3.0)))


def dropping(number, remains):
    """The same curve, which drops at a point and tells no event; as it may where it is followed by finite steps."""
    points = curve_of_a_point().points
    after = [replace(point, lower=remains * point.lower, upper=remains * point.upper) for point in points[number:]]
    return replace(curve_of_a_point(), points=(*points[: number + 1], *after))


@pytest.mark.parametrize("number", range(1, 11))
@pytest.mark.parametrize("remains", [0.4, 0.6])
def test_a_drop_of_more_than_half_bounds_life_safety(number, remains):
    """A wall of one body has e* = 1; after the drop it bears the multiplier after it."""
    there = dropping(number, remains).points[number]
    found = nonlinear_check(dropping(number, remains), SIDE, confidence=1.0)
    state = found.state("SLV")
    if remains > 0.5:
        assert state.displacement == pytest.approx(0.4 * found.ultimate, rel=1e-9)
        return
    part = there.displacement / curve_of_a_point().displacement[-1]
    assert state.displacement == pytest.approx(part * found.ultimate, rel=1e-9)
    assert state.acceleration == pytest.approx(remains * there.lower * 9.81, rel=1e-9)
    slope = nonlinear_check(dropping(number, remains), SIDE, confidence=1.0, shape="line").state("SLV")
    assert slope.displacement == state.displacement


def test_a_drop_at_rest_leaves_no_capacity():
    with pytest.raises(InputError, match="as soon as the mechanism moves the multiplier drops to less than half"):
        nonlinear_check(dropping(0, 0.4), SIDE)


def test_points_far_apart_on_a_slope_are_no_drop():
    """A curve that is straight down to zero, told by three points."""
    points = curve().points
    few = replace(curve(), points=(points[0], points[len(points) // 2], points[-1]))
    found = nonlinear_check(few, SIDE)
    assert found.state("SLV").displacement == pytest.approx(0.4 * found.ultimate, rel=1e-9)


@pytest.mark.parametrize(
    ("masses", "says"),
    [
        ([("wall", (0, 1.5, 3))], "each is a block, a point of it and a weight"),
        ([(["wall", "ground"], (0, 1.5, 3), 10.0)], "are 2 blocks; give one"),
        ([("wall", (0, 1.5, 3), "heavy")], "the weight on 'wall' is 'heavy'; it must be above 0"),
    ],
)
def test_a_mass_is_one_weight_at_a_point_of_one_block(masses, says):
    with pytest.raises(InputError, match=says):
        linear_check(limit_load(wall(), SIDE), SIDE, masses=masses)


def test_a_check_takes_the_permanent_loads_of_a_case_as_the_limit_does():
    # With .9 of the weight and as much of the load the multiplier of the whole weight is .9 of that at rest.
    light = WeightedLoads(np.zeros((2, 6)), 0.9)
    limit = limit_load(wall(), SIDE, loads=light)
    assert linear_check(limit, SIDE, loads=light).alpha0 == pytest.approx(0.9 * 0.125, rel=1e-6)


def test_numbers_of_a_check_are_numbers():
    with pytest.raises(InputError, match="confidence is 'x'; it must be at least 1"):
        linear_check(limit_load(wall(), SIDE), SIDE, confidence="x")
    with pytest.raises(InputError, match="site: f0 is 'a'; it must be from 1 to 10"):
        Site(f0="a")


@pytest.mark.parametrize("site", ["B", 0.3, {"SLD": "B", "SLV": "B", "SLC": "B"}])
def test_the_ground_of_a_check_is_a_site_or_a_table(site):
    of = "site of SLD" if isinstance(site, dict) else "site"
    with pytest.raises(InputError, match=f"{of} is .*; it must be a Site or a SpectrumTable"):
        nonlinear_check(curve(), SIDE, site=site)
    wall = stack(1, 1.0, 2.0)
    with pytest.raises(InputError, match=r"site is .*; it must be a Site or a SpectrumTable"):
        linear_check(limit_load(wall, SIDE), SIDE, site=site)


@pytest.mark.parametrize("courses", [2, 3, 4])
def test_a_course_that_slides_alone_is_a_mechanism_of_one_body(courses):
    """Every bed slides at mu = .1 with what is above it, and the solver mixes them; the top course alone has e* = 1."""
    found = checked([box((0, 0, k), (3, 3, k + 1)) for k in range(courses)], friction=0.1, demand=0.18)
    assert found.participation == 1.0
    assert found.acceleration == pytest.approx(0.1 * 9.81 / 1.35, rel=1e-6)
    assert found.outcome.word == "not_satisfied"  # a0* 2 / 9.81 = .148


@pytest.mark.parametrize("size", [0.25, 0.5, 1.0])
def test_walls_that_do_not_touch_are_mechanisms_of_one_body(size):
    """Both tip at b/h = 1/8."""
    found = checked([box((0, 0, 0), (0.5, 3, 4)), box((3, 0, 0), (3 + 0.5 * size, 3, 4 * size))])
    assert found.acceleration == pytest.approx(0.125 * 9.81 / 1.35, rel=1e-6)


def test_bodies_that_need_each_other_are_apart():
    """A lintel on two posts that tip: neither moves without the other two, all by one horizontal displacement."""
    posts = [box((x, 0, 0), (x + 0.5, 1, 3)) for x in (0, 3)]
    found = checked([*posts, box((0, 0, 3), (3.5, 1, 3.5))], friction=5.0)
    assert not any("without the others" in text for text in found.warnings)
    # Posts of weight 1.5 move by 1.5, the lintel of weight 1.75 by 3: (4.5 + 5.25)^2 / (4.75 (6.75 + 15.75)).
    assert (len(found.bodies), found.participation) == (3, pytest.approx(9.75**2 / (4.75 * 22.5), rel=1e-4))


def test_pairs_of_bodies_that_do_not_touch_are_mechanisms_of_their_own():
    """Two bays of a lintel on two posts of unequal size: which of them moves how far is arbitrary."""
    bays = []
    for x, size in ((0.0, 1.0), (8.0, 2.0)):
        spans = [((0, 0, 0), (0.5, 1, 3)), ((3, 0, 0), (3.5, 1, 3)), ((0, 0, 3), (3.5, 1, 3.5))]
        bays += [box(*(size * np.array(end) + (x, 0, 0) for end in span)) for span in spans]
    ground = box((-2, -2, -1), (18, 4, 0))
    scene = Assembly.from_blocks([ground, *bays], supports=[0], friction=5.0)
    found = linear_check(limit_load(scene, SIDE), SIDE, macro_blocks=6)
    assert len(found.bodies) == 6
    assert found.participation == 1.0
    assert any("without the others" in text for text in found.warnings)


def bent(friction, **options):
    """Two courses of 2.5 and 1.5 m, .5 m thick, that bend between the ground and the edge of a slab 3.7 m up."""
    blocks = [
        box((-1, -1, -1), (2, 4, 0), name="ground"), box((0.5, 0, 3.7), (1, 3, 4.5), name="slab"),
        box((0, 0, 0), (0.5, 3, 2.5), name="low"), box((0, 0, 2.5), (0.5, 3, 4), name="high"),
    ]  # fmt: skip
    return Assembly.from_blocks(blocks, supports=["ground", "slab"], friction=friction, **options)


#: By hand: the lower course turns about its toe, the joint at 2.5 m closes at x = 0 and moves 2.5 aside; there the
#: upper one turns so that its corner at the slab stays where it is along x, and only slides up.
BENT = np.array([[2.5, 1.25], [1.5, 2.5 - 2.5 / 1.2 * 0.75]])  # weight, displacement
PART_OF_BENT = (BENT[:, 0] @ BENT[:, 1]) ** 2 / (BENT[:, 0].sum() * (BENT[:, 0] @ BENT[:, 1] ** 2))


@pytest.mark.parametrize("flow", ["associated", "coulomb"])
def test_bodies_whose_joints_open_as_they_slide_are_taken_as_one(flow):
    """With associated friction the slab pushes the upper course back: e* sinks to .72, and a0* is 36 % too high."""
    found = linear_check(limit_load(bent(0.6), SIDE, flow=flow), SIDE)
    assert found.apart < 0.8 < PART_OF_BENT < 1.0
    assert found.participation == 1.0
    assert found.acceleration == pytest.approx(found.alpha0 * 9.81 / 1.35, rel=1e-9)
    assert any("open as they slide" in text for text in found.warnings)


@pytest.mark.parametrize("friction", [0.4, 0.5, 0.6])
def test_the_bodies_of_a_curve_move_as_joints_that_slide_without_opening_do(friction):
    found = nonlinear_check(capacity(bent(friction), SIDE, control="mean"), SIDE)
    assert found.participation == pytest.approx(PART_OF_BENT, rel=1e-6)


def under(friction):
    """A course of 1 m that slides out under one of .8 m, which a support holds."""
    blocks = [
        box((-1, -1, -1), (3, 4, 0), name="ground"), box((0, 0, 0), (1, 3, 1), name="low"),
        box((0, 0, 1), (1, 3, 1.8), name="high"), box((1, 0, 1.5), (1.5, 3, 2.3), name="top"),
    ]  # fmt: skip
    return Assembly.from_blocks(blocks, supports=["ground", "top"], friction=friction)


def test_a_block_that_stands_still_takes_no_part():
    """The upper course leans on the support, which carries a = .478 without self-stress.

    With n between the courses: 1.04 n = .8 - .16 a and a = .2 (1 + n) + .2 n.
    """
    alpha0 = (0.2 + 0.4 * 0.8 / 1.04) / (1 + 0.4 * 0.16 / 1.04)
    found = nonlinear_check(capacity(under(0.2), SIDE, control="low"), SIDE, demand={"SLD": 0.5})
    assert found.bodies == ((1,),)
    assert found.participation == 1.0
    assert found.alpha0 == pytest.approx(alpha0, rel=1e-3)
    assert found.state("SLD").ag == pytest.approx(alpha0 / 1.35, rel=1e-3)
    assert found.outcome.word == "not_satisfied"
    assert not linear_check(limit_load(under(0.4), SIDE, flow="coulomb"), SIDE, demand=2.0).satisfied


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_a_block_that_falls_out_bounds_life_safety(share):
    """From .125 at rest to zero along a line: the multiplier where it falls is that of the next point."""
    whole = curve_of_a_point()
    there = share * whole.displacement[-1]
    found = nonlinear_check(replace(whole, fallen=(FallenBlocks(there, np.array([1])),)), SIDE, confidence=1.0)
    before, beyond = np.flatnonzero(whole.displacement < there)[-1], np.flatnonzero(whole.displacement >= there)[0]
    state, part = found.state("SLV"), whole.displacement[before] / whole.displacement[-1]
    assert state.displacement == pytest.approx(min(part, 0.4) * found.ultimate, rel=1e-9)
    if share < 0.4:
        assert state.acceleration == pytest.approx(whole.lower[beyond] * 9.81, rel=1e-9)


@pytest.mark.parametrize("factor", [0.9, 0.6, 1.4])
def test_a_multiplier_is_in_units_of_the_gravity_of_the_scene(factor):
    own = wall().with_(gravity=(0, 0, -9.81 * factor))
    found = linear_check(limit_load(own, SIDE), SIDE)
    assert found.acceleration == pytest.approx(0.125 * factor * 9.81 / 1.35, rel=1e-6)
    assert found.ag_damage == pytest.approx(0.125 * factor / 1.35, rel=1e-6)
    assert not found.warnings
    states, usual = (nonlinear_check(capacity(scene, SIDE, control="wall"), SIDE) for scene in (own, wall()))
    assert states.state("SLV").period == pytest.approx(usual.state("SLV").period / factor**0.5, rel=1e-6)
    assert states.rocking.frequency == pytest.approx(usual.rocking.frequency * factor**0.5, rel=1e-9)


def test_a_gravity_in_other_units_is_that_of_the_earth():
    found = linear_check(limit_load(wall().with_(gravity=(0, 0, -1)), SIDE), SIDE)
    assert found.acceleration == pytest.approx(0.125 * 9.81 / 1.35, rel=1e-6)
    assert any("gravity is 1, which is taken as 9.81 m/s2" in text for text in found.warnings)


@pytest.mark.parametrize("gravity", [9810.0, 981.0, 32.2])
def test_displacements_are_verified_in_metres_only(gravity):
    """In millimetres a wall of 4 m by .5 m bore 10 g, the most that is told. Accelerations have no length."""
    scene = wall().with_(gravity=(0, 0, -gravity))
    curve = capacity(scene, SIDE, control="wall", steps=5)
    with pytest.raises(InputError, match=r"it must be at most 14\.715 m/s2, .* give the scene in metres"):
        nonlinear_check(curve, SIDE)
    found = linear_check(limit_load(scene, SIDE), SIDE)
    assert found.acceleration == pytest.approx(0.125 * 9.81 / 1.35, rel=1e-4)


def test_a_permanent_load_that_presses_down_without_mass_is_told():
    wall = on_a_base([box((0, 0, 0), (0.5, 3, 4), name="wall")])
    dead = point_load(wall, "wall", (0.25, 1.5, 4), (0, 0, -5e4))
    limit = limit_load(wall, (1, 0, 0), loads=dead)
    for loads in (None, dead):
        (told,) = linear_check(limit, (1, 0, 0), loads=loads).warnings
        assert "50000 N press down and have no mass" in told
    assert linear_check(limit_load(wall, (1, 0, 0)), (1, 0, 0)).warnings == ()


@pytest.mark.parametrize(("suction", "weight", "known"), [("wall", 1.0, ()), ("other", 1.0, (0, 1)), (None, 0.9, (1,))])
def test_a_load_that_lifts_does_not_take_away_the_mass_of_one_that_presses(suction, weight, known):
    """A roof of 8 kN stays without its mass whatever lifts by more, as a tenth of the weight of each wall does."""
    walls = on_a_base([box((x, 0, 0), (x + 0.5, 3, 3), name=name) for x, name in ((0, "wall"), (2, "other"))])
    loads = {"roof": {"kind": "point", "block": "wall", "point": (0.25, 1.5, 3), "force": (0, 0, -8e3)}}
    if suction:
        place = (0.25 if suction == "wall" else 2.25, 1.5, 3)
        loads["wind"] = {"kind": "point", "block": suction, "point": place, "force": (0, 0, 9e3)}
    cases = load_cases(walls, loads, {"all": {"factors": dict.fromkeys(loads, 1.0), "weight": weight}})
    for k, given in enumerate((cases["all"].permanent, cases["all"].weighted_permanent)):
        limit = limit_load(walls, (1, 0, 0), loads=given)
        found = linear_check(limit, (1, 0, 0), loads=given, demand=0.01)
        assert found.outcome.word == "not_verified"
        assert ("8000 N press down and have no mass" if k in known else 'permanent loads lift "') in found.warnings[0]


def test_a_factor_on_the_weight_that_is_told_lifts_nothing():
    wall = on_a_base([box((0, 0, 0), (0.5, 3, 3), name="wall")])
    light = load_cases(wall, {}, {"light": {"weight": 0.9}})["light"].weighted_permanent
    found = linear_check(limit_load(wall, (1, 0, 0), loads=light), (1, 0, 0), loads=light, demand=0.01)
    assert (found.outcome.word, found.warnings) == ("satisfied", ())
    assert found.alpha0 == pytest.approx(0.9 * 0.5 / 3, rel=1e-4)  # the weight is less, and its inertia is not


def test_masses_whose_weight_is_no_permanent_load_are_told():
    """A balcony of weight P at y beyond the toe of a wall: (W b / 2 - P y) / (W h / 2 + P z); told without its weight,
    W b / 2 over the same, which is right for a floor that other walls bear."""
    wall = on_a_base([box((0, 0, 0), (0.5, 3, 4), name="wall")])
    weight, own, place = wall.free_weight, 2e4, np.array([1.2, 1.5, 2.0])
    balcony, pushed = np.zeros((2, 6, 2)).transpose(2, 0, 1)
    for load, force in ((balcony, (0, 0, -own)), (pushed, (own, 0, 0))):
        load[1] = [*force, *np.cross(place - wall.centroid[1], force)]
    inertia = acceleration(wall, (1, 0, 0)) + pushed
    for loads, moment in ((balcony, weight * 0.25 - own * 0.7), (None, weight * 0.25)):
        limit = limit_load(wall, inertia, loads=loads)
        found = linear_check(limit, (1, 0, 0), masses=[("wall", place, own)], demand=0.05)
        assert found.alpha0 == pytest.approx(moment / (2.0 * weight + 2.0 * own), rel=1e-4)
        assert found.outcome.word == "satisfied"
        told = [text for text in found.warnings if "no permanent load has their weight" in text]
        assert (len(told) == 1) == (loads is None)
        assert not told or told[0].startswith("masses of 20000 N are accelerated")


def test_what_is_borne_without_the_mass_of_a_permanent_load_is_not_verified():
    """A wall of weight W with R upon it tips at (W + R) b / 2 over W h / 2; with the mass of R, over W h / 2 + R h."""
    wall = on_a_base([box((0, 0, 0), (0.5, 3, 4), name="wall")])
    weight, roof, top = wall.free_weight, 5e4, (0.25, 1.5, 4)
    dead = point_load(wall, "wall", top, (0, 0, -roof))
    limit, curve = limit_load(wall, (1, 0, 0), loads=dead), capacity(wall, (1, 0, 0), control="wall", loads=dead)
    found = linear_check(limit, (1, 0, 0), loads=dead, demand=0.05)
    sentence = "Not verified: the demand is borne without the inertia of permanent loads, whose mass is left out."
    assert found.explain().splitlines()[0] == found.summary()["sentence"] == sentence
    assert (found.outcome.word, found.satisfied) == ("not_verified", None)
    assert found.warnings == (
        "permanent loads of 50000 N press down and have no mass, so alpha0 is too high; what of them is weight must be "
        "accelerated, too: as blocks, or in Python as masses of the check and in the load of the limit",
    )
    assert found.alpha0 == pytest.approx(0.25 * (weight + roof) / (2 * weight), rel=1e-5)
    assert linear_check(limit, (1, 0, 0), loads=dead, demand=0.6).outcome.word == "not_satisfied"
    assert linear_check(limit, (1, 0, 0), loads=dead).outcome.word == "capacity"
    of_curve = nonlinear_check(curve, (1, 0, 0), loads=dead, demand={"SLD": 0.01, "SLV": 0.02})
    assert of_curve.explain().splitlines()[0] == (
        "Not verified: all demands are borne without the inertia of permanent loads, whose mass is left out."
    )
    assert [state.satisfied for state in of_curve.states] == [None, None, None]
    mixed = nonlinear_check(curve, (1, 0, 0), loads=dead, demand={"SLD": 0.01, "SLV": 5.0})
    assert (mixed.outcome.word, mixed.state("SLV").satisfied) == ("not_satisfied", False)

    push = body_load(wall, (weight, 0, 0)) + point_load(wall, "wall", top, (roof, 0, 0))
    options = {"loads": dead, "masses": [("wall", top, roof)]}
    whole = linear_check(limit_load(wall, push, loads=dead), (1, 0, 0), demand=0.05, **options)
    assert (whole.outcome.word, whole.warnings) == ("satisfied", ())
    assert whole.alpha0 == pytest.approx(0.25 * (weight + roof) / (2 * weight + 4 * roof), rel=1e-5)


def test_beyond_its_last_period_a_table_has_the_velocity_of_the_last():
    """Between TC = .47 s and TD = 2.4 s S_e T is constant, so a table that ends at 1 s tells the same up to TD."""
    site = Site("C", f0=2.5, tc_star=0.3)
    table = SpectrumTable((0.0, 0.5, 1.0), tuple(site.spectrum(0.2, period) for period in (0.0, 0.5, 1.0)))
    for period in (1.5, 2.26):
        assert table.spectrum(site.spectrum(0.2, 0.0), period) == pytest.approx(site.spectrum(0.2, period), rel=1e-9)
    assert table.spectrum(site.spectrum(0.2, 0.0), 4.0) > site.spectrum(0.2, 4.0)


def test_a_floor_asks_for_no_less_than_the_ground():
    """At the foot of a building psi goes to 0; what stands there feels the ground."""
    wall = on_a_base([box((0, 0, 0), (0.5, 3, 4), name="wall")])
    limit, curve = limit_load(wall, (1, 0, 0)), capacity(wall, (1, 0, 0), control="wall")
    for psi in (0.1, 1e-3):
        low = Floor(period=0.3, own_period=0.05, gamma=1.2, psi=psi)
        assert linear_check(limit, (1, 0, 0), floor=low).ag_life == linear_check(limit, (1, 0, 0)).ag_life
        states = [nonlinear_check(curve, (1, 0, 0), floor=own).state("SLD").ag for own in (low, None)]
        assert states[0] == states[1]


def test_the_slenderness_of_a_rocking_block_is_that_of_its_diagonal_with_a_tie_too():
    tie = Tie((0, "b"), ((-1, 0.5, 2), (0, 0.5, 2)), greatest=2000.0)
    free = on_a_base([box((0, 0, 0), (0.5, 1, 2), name="b")], density=1000.0, friction=5.0)
    for asm in (free, free.with_(ties=[tie])):
        found = nonlinear_check(capacity(asm, (1, 0, 0), control="b"), (1, 0, 0)).rocking
        assert found.slenderness == pytest.approx(np.arctan(0.25), rel=1e-6)


def test_the_demand_of_a_curve_is_given_by_limit_state():
    wall = on_a_base([box((0, 0, 0), (0.5, 3, 4), name="wall")])
    with pytest.raises(InputError, match=r"demand is 0\.15; give it by limit state"):
        nonlinear_check(capacity(wall, (1, 0, 0), control="wall"), (1, 0, 0), demand=0.15)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"floor": (0.3, 0.1, 1.2)}, "floor is .*; it must be a Floor"),
        ({"masses": 5}, "masses is 5; it must be a list"),
        ({"masses": [("ground", (0, 0, -1), 1e6)]}, "masses: 'ground' is a support, which no mass pushes"),
    ],
)
def test_what_is_no_floor_and_no_mass_is_refused(options, says):
    for check, of in ((linear_check, limit()), (nonlinear_check, curve_of_wall())):
        with pytest.raises(InputError, match=says):
            check(of, SIDE, **options)


@cache
def curve_of_wall():
    return capacity(wall(), SIDE, control="wall")


def on_a_base(blocks, **options):
    return Assembly.from_blocks([box((-1, -1, -1), (9, 9, 0)), *blocks], supports=[0], **options)


def checked(blocks, demand=None, **options):
    return linear_check(limit_load(on_a_base(blocks, **options), (1, 0, 0)), (1, 0, 0), demand=demand)


@cache
def parapet():
    """A wall of 2 m, and on it a parapet 2 m high and .2 m thick, which turns about its own foot at .2 / 2."""
    blocks = [
        box((-1, -1, -1), (2, 4, 0), name="ground"),
        box((0, 0, 0), (1, 3, 2), name="wall"),
        box((0.4, 0, 2), (0.6, 3, 4), name="parapet"),
    ]
    return Assembly.from_blocks(blocks, supports=["ground"])


def test_a_mechanism_on_no_support_is_told_to_be_high_up():
    says = "no block of the mechanism touches a support"
    above, along = limit_load(parapet(), SIDE), capacity(parapet(), SIDE, control="parapet", steps=5)
    assert above.lower == pytest.approx(0.1, abs=1e-4)
    floor = Floor(period=0.3, own_period=0.1, gamma=1.2)
    for check, found, low in ((linear_check, above, limit()), (nonlinear_check, along, curve())):
        assert sum(says in text for text in check(found, SIDE).warnings) == 1
        assert not any(says in text for text in check(found, SIDE, floor=floor).warnings)
        assert not any(says in text for text in check(low, SIDE).warnings)


def test_checks_repeat_the_warnings_of_what_they_verify():
    told = "joints are 2 mm open"
    assert linear_check(replace(limit(), warnings=(told,)), SIDE).warnings == (told,)
    assert nonlinear_check(replace(curve(), warnings=(told,)), SIDE).warnings == (told,)


def test_a_table_that_ends_on_its_plateau_is_told_where_it_is_taken_beyond():
    short, whole = (SpectrumTable((0.0, 0.1, last), (0.1, 0.25, value)) for last, value in ((0.2, 0.25), (2.0, 0.05)))
    (told,) = nonlinear_check(curve(), SIDE, site=short).warnings
    assert told.startswith("the spectrum ends at 0.2 s with its greatest value and is taken beyond")
    assert nonlinear_check(curve(), SIDE, site=whole).warnings == ()
    assert linear_check(limit(), SIDE, site=short).warnings == ()
    high = Floor(period=0.3, own_period=0.1, gamma=1.2)
    assert linear_check(limit(), SIDE, site=short, floor=high).warnings[0].endswith("give it beyond its plateau")


def test_damping_leaves_no_less_of_a_table_than_its_factor():
    """Off a value below the peak at 1 s the part in proportion to T would be more than the value itself."""
    late = SpectrumTable((0.0, 0.5, 1.0), (0.1, 0.05, 1.0))
    eta = sqrt(10 / (5 + 10))
    assert late.spectrum(0.1, 0.5, damping=10.0) == pytest.approx(eta * 0.05)
    site, ag, tb = Site("A"), 0.1, 0.1  # T_B = T_C / 3
    table = SpectrumTable((0.0, tb, 0.3, 1.0), tuple(site.spectrum(ag, t) for t in (0.0, tb, 0.3, 1.0)))
    assert table.spectrum(ag, 0.05, damping=10.0) == pytest.approx(site.spectrum(ag, 0.05, damping=10.0))


@cache
def pinnacle(mass):
    """A pinnacle .2 m wide and 1 m high on a tower of a given mass, with a cross of 700 N on its tip."""
    side = (mass / 1800.0) ** (1 / 3)
    blocks = [
        box((-1, -1, -1), (side + 1, side + 1, 0), name="ground"),
        box((0, 0, 0), (side, side, side), name="tower"),
        box((0, 0, side), (0.2, 0.2, side + 1), name="pinnacle"),
    ]
    scene = Assembly.from_blocks(blocks, supports=["ground"], density=1800.0)
    return scene, (0.1, 0.1, side + 1)


@pytest.mark.parametrize("mass", [1e4, 1e7, 1e8])
def test_a_load_without_mass_is_told_however_heavy_the_building_is(mass):
    """alpha0 with the inertia of the cross is (W + F) .1 / (.5 W + F), W = 706 N; without it twice that and more."""
    scene, tip = pinnacle(mass)
    weight, cross = scene.mass[2] * 9.81, 700.0
    dead = point_load(scene, "pinnacle", tip, (0, 0, -cross))
    idle = linear_check(limit_load(scene, SIDE, loads=dead), SIDE, loads=dead, demand=0.25)
    assert idle.outcome.word == "not_verified"
    assert any("permanent loads of 700 N press down and have no mass" in text for text in idle.warnings)
    live = acceleration(scene, SIDE) + point_load(scene, "pinnacle", tip, (cross, 0, 0))
    whole = linear_check(
        limit_load(scene, live, loads=dead), SIDE, loads=dead, masses=[("pinnacle", tip, cross)], demand=0.25
    )
    assert whole.alpha0 == pytest.approx(0.1 * (weight + cross) / (0.5 * weight + cross), rel=2e-4)
    assert whole.outcome.word == "not_satisfied"
    held = point_load(scene, "pinnacle", tip, (-60.0, 0, 0))
    with pytest.raises(InputError, match='another load acts on "pinnacle"'):
        linear_check(limit_load(scene, SIDE, loads=held), SIDE)


def test_a_block_that_slides_has_no_displacement_that_is_verified():
    """.5 m thick and .8 m high at a friction of .5 it slides, as far as the ground is drawn."""
    blocks = [box((-1, -1, -1), (4, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 0.8), name="parapet")]
    scene = Assembly.from_blocks(blocks, supports=["ground"], friction=0.5)
    sliding = capacity(scene, SIDE, control="parapet", steps=10)
    found = nonlinear_check(sliding, SIDE, demand={"SLD": 0.1, "SLV": 0.3})
    assert [state.satisfied for state in found.states] == [True, None, None]
    assert found.outcome.word == "not_verified"
    assert any("the mechanism slides" in text for text in found.warnings)


def test_a_curve_that_rises_again_is_taken_at_its_least_multiplier_before():
    """From .125 at rest the multiplier falls to zero at .5 m along a line, with a dip to .04 at a fourth of the way."""
    whole = curve()
    k = int(np.argmin(np.abs(whole.displacement - 0.25 * whole.displacement[-1])))
    points = list(whole.points)
    points[k] = replace(points[k], lower=0.04)
    dipped = nonlinear_check(replace(whole, points=tuple(points)), SIDE)
    share = 9.81 / 1.35  # of one body, e* = 1
    assert dipped.state("SLC").acceleration == pytest.approx(0.04 * share, rel=1e-6)
    # At SLC the period is beyond TD, where the demand on the displacement does not depend on it; at SLV it is not.
    assert dipped.state("SLC").ag == pytest.approx(nonlinear_check(whole, SIDE).state("SLC").ag, rel=1e-9)
    assert dipped.state("SLV").ag < 0.9 * nonlinear_check(whole, SIDE).state("SLV").ag


def test_loads_taken_at_centroids_leave_a_displacement_unverified():
    """A roof on the axis of a wall moves further than its centroid: d0 by wrenches is half as large again."""
    roof = point_load(wall(), "wall", TOP, (0, 0, -80e3))
    inertia = body_load(wall(), (wall().free_weight, 0, 0)) + point_load(wall(), "wall", TOP, (80e3, 0, 0))
    given = {"loads": roof, "masses": [("wall", TOP, 80e3)]}
    moved = nonlinear_check(capacity(wall(), inertia, loads=roof, control="wall"), SIDE, **given, demand={"SLV": 0.01})
    assert moved.outcome.word == "not_verified"
