"""The nonlinear verification of Circolare 7/2019, C8.7.1.2.1, against examples worked by hand.

Every step of the hand examples follows the formulas of the Circolare with the spectrum of NTC 2018, 3.2.3.2.1: F0 2.5,
TC* 0.30 s, FC 1.35, g 9.81.
"""

from dataclasses import replace

import numpy as np
import pytest

from blockstat import (
    Assembly,
    Block,
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

FINE = 1e-6


def on_ground(*blocks, **more):
    ground = box((-9, -5, -1), (9, 9, 0), name="ground")
    return Assembly.from_blocks([ground, *blocks], supports=["ground"], **more)


@pytest.fixture(scope="module", params=[1, 4])
def wall(request):
    courses = request.param
    blocks = [box((0, 0, 4 * k / courses), (0.5, 3, 4 * (k + 1) / courses), name=f"c{k}") for k in range(courses)]
    return capacity(on_ground(*blocks), (1, 0, 0), control="mean", tolerance=FINE)


def test_a_wall_by_its_line_whether_in_one_piece_or_in_courses(wall):
    """Counted one by one, four courses would bear 32 % more: a_g .213984 at SLV."""
    found = nonlinear_check(wall, (1, 0, 0), site=Site("B"), shape="line")
    life, collapse = found.state("SLV"), found.state("SLC")
    assert len(found.bodies) == 1
    assert (found.participation, found.ultimate) == pytest.approx((1.0, 0.25), rel=1e-8)
    assert found.acceleration == pytest.approx(0.908333, abs=1e-6)
    assert (life.acceleration, life.period) == pytest.approx((0.545, 2.260794), abs=1e-6)
    ground = [state.ag for state in found.states]
    assert ground == pytest.approx([0.077160, 0.162041, 0.237594], abs=1e-6)
    assert (life.displacement, collapse.displacement) == pytest.approx((0.10, 0.15), rel=1e-8)


def test_a_wall_by_its_curve(wall):
    life = nonlinear_check(wall, (1, 0, 0), site=Site("B")).state("SLV")
    assert (life.acceleration, life.period) == pytest.approx((0.542295, 2.266424), abs=2e-6)
    assert life.ag == pytest.approx(0.162041, abs=2e-6)


def test_a_check_says_which_mechanism_it_verified(wall):
    """The wall turns about its foot, as the limit load says."""
    courses = [box((0, 0, k), (0.5, 3, k + 1), name=f"course {k}") for k in range(2)]
    other = Assembly.from_blocks([box((-1, -1, -1), (2, 4, 0), name="ground"), *courses], supports=["ground"])
    limit = limit_load(other, (1, 0, 0))
    found = linear_check(limit, (1, 0, 0))
    assert {"First to move: course 1, course 0.", "Joints of the mechanism: 1 hinge, 0 sliding, 0 opening."} <= set(
        found.explain().splitlines()
    )
    assert found.summary()["moving"] == ["course 1", "course 0"]
    assert found.summary()["joints"] == {"hinges": [("ground", "course 0")], "sliding": [], "opening": []}
    curved = nonlinear_check(wall, (1, 0, 0))
    assert f"First to move: {', '.join(curved.summary()['moving'])}." in curved.explain().splitlines()
    assert sorted(curved.summary()["moving"]) == [name for name in wall.assembly.names if name != "ground"]


def test_a_wall_is_a_rocking_block(wall):
    rocking = nonlinear_check(wall, (1, 0, 0)).rocking
    radius = np.hypot(0.25, 2.0)
    assert rocking.radius == pytest.approx(radius)
    assert rocking.slenderness == pytest.approx(np.arctan(0.125))
    assert rocking.frequency == pytest.approx(np.sqrt(3 * 9.81 / (4 * radius)), rel=1e-6)


FACADE = {
    0.0: (0.070351393, 0.511220, 0.510286153, 0.294761, 0.117904, 0.306732, 3.272234, 0.306538, 0.043427, 0.183900),
    15.0: (0.047356984, 0.344127, 0.342453527, 0.197814, 0.079126, 0.206476, 3.267252, 0.206317, 0.029233, 0.134757),
}


@pytest.mark.parametrize("thrust", FACADE, ids=str)
def test_the_hand_example_of_a_facade(thrust):
    """Three strips 6 m wide with floor, roof, a mass without weight and the thrust of a vault [kN]."""
    alpha0, start, control, ultimate, life, line, period, curved, damage, ground = FACADE[thrust]
    triangle = [(0, 0, 6.8), (0, 6, 6.8), (0, 3, 8.9), (0.4, 0, 6.8), (0.4, 6, 6.8), (0.4, 3, 8.9)]
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
    strips = [box((0, 0, 0), (0.6, 6, 3.6), name="low"), box((0, 0, 3.6), (0.5, 6, 6.8), name="high")]
    facade = on_ground(*strips, Block(triangle, faces, name="gable"), density=18.0, gravity=(0, 0, -1), friction=10.0)
    floor, roof, top = (0.45, 3, 3.6), (0.35, 3, 6.8), (0.35, 3, 6.8)
    dead = [("low", floor, (0, 0, -36)), ("high", roof, (0, 0, -24)), ("low", (0.6, 3, 3.2), (-thrust, 0, 0))]
    live = [(name, facade.centroid[k], (-facade.mass[k], 0, 0)) for k, name in enumerate(facade.names) if k]
    live += [("low", floor, (-36, 0, 0)), ("high", roof, (-24, 0, 0)), ("high", top, (-20, 0, 0))]
    dead = [row for row in dead if any(row[2])]
    curve = capacity(facade, live, loads=dead, control=("high", (0, 3, 6.8)), tolerance=FINE)
    assert curve.lower[0] == pytest.approx(alpha0, rel=1e-7)
    assert curve.displacement[-1] == pytest.approx(control, rel=1e-7)
    heavy = [("low", floor, 36 * 9.81), ("high", roof, 24 * 9.81), ("high", top, 20 * 9.81)]
    found = nonlinear_check(curve, (-1, 0, 0), site=Site("B"), masses=heavy, shape="line")
    state = found.state("SLV")
    assert (found.acceleration, found.ultimate) == pytest.approx((start, ultimate), abs=1e-6)
    assert (state.displacement, state.acceleration, state.period) == pytest.approx((life, line, period), abs=1.1e-6)
    assert (found.state("SLD").ag, state.ag) == pytest.approx((damage, ground), abs=1e-6)
    exact = nonlinear_check(curve, (-1, 0, 0), site=Site("B"), masses=heavy)
    assert exact.state("SLV").acceleration == pytest.approx(curved, abs=2e-6)


def test_a_bell_gable_on_a_building():
    """xi1 5 % is a fraction in the peak of the floor spectrum: as per cent, resonance would reduce it."""
    gable = on_ground(box((0, 0, 0), (0.5, 3, 3), name="gable"))
    floor = Floor(period=0.05 * 10**0.75, own_period=0.174556213, gamma=1.2)
    curve = capacity(gable, (1, 0, 0), control="gable", tolerance=FINE)
    found = nonlinear_check(curve, (1, 0, 0), site=Site("A"), floor=floor, shape="line")
    assert found.acceleration == pytest.approx(1.211111, abs=1e-6)
    states = {state.name: state for state in found.states}
    assert states["SLD"].ag == pytest.approx(0.011301, abs=1e-6)
    life, collapse = states["SLV"], states["SLC"]
    assert (life.acceleration, life.period, life.ag) == pytest.approx((0.726667, 1.957905, 0.207332), abs=1e-6)
    assert (collapse.period, collapse.ag) == pytest.approx((2.727081, 0.245172), abs=1e-6)


def test_demands_decide_and_a_table_stands_for_a_site(wall):
    demand = {"SLD": 0.05, "SLV": 0.15}
    assert nonlinear_check(wall, (1, 0, 0), site=Site("B"), demand=demand).outcome.word == "satisfied"
    demand["SLC"] = 0.3
    told = nonlinear_check(wall, (1, 0, 0), site=Site("B"), demand=demand)
    assert told.outcome.word == "not_satisfied"
    assert "asked for 0.3 g" in told.explain()
    assert told.summary()["states"]["SLC"]["satisfied"] is False
    # A spectrum of one displacement from 1 s on: S_e = 0.4 / T^2, so that ag is in proportion to the displacement.
    periods = np.append(0.0, np.linspace(1, 6, 501))
    table = SpectrumTable(tuple(periods), tuple(np.append(0.2, 0.4 / periods[1:] ** 2)))
    found = nonlinear_check(wall, (1, 0, 0), site=table)
    eta = np.sqrt(10 / 13)
    assert found.state("SLV").ag == pytest.approx(0.1 / (0.4 * 9.81 / (4 * np.pi**2) * eta) * 0.2, rel=1e-4)


def test_an_unfinished_curve_is_refused(wall):
    short = capacity(wall.assembly, (1, 0, 0), displacement=0.05)
    with pytest.raises(InputError, match="does not tell where the multiplier is zero"):
        nonlinear_check(short, (1, 0, 0))
    with pytest.raises(InputError, match="SLX"):
        nonlinear_check(wall, (1, 0, 0), demand={"SLX": 0.1})


def dry_stones(courses):
    """A wall of equal courses that slide on each other, each pushed as much as it bears: all slide at the same push."""
    return on_ground(*(box((0, 0, k), (4, 3, k + 1), name=f"c{k}") for k in range(courses)), friction=0.2)


def moved(wall, *shifts):
    """The limit load of a wall with a mechanism of our own, in which its courses slide by so much."""
    limit = limit_load(wall, (1, 0, 0))
    mechanism = np.zeros((wall.n_blocks, 6))
    mechanism[1:, 0] = shifts
    return replace(limit, lower=limit.upper, mechanism=mechanism)


def portal():
    """The limit load of a lintel .5 m high on two posts .5 m thick and 3 m high: all tip together at .5 / 3.

    Posts of weight 1.5 move by 1.5 and the lintel of weight 1.75 by 3.
    """
    posts = [box((x, 0, 0), (x + 0.5, 1, 3), name=name) for x, name in ((0, "left"), (3, "right"))]
    return limit_load(on_ground(*posts, box((0, 0, 3), (3.5, 1, 3.5), name="lintel"), friction=5.0), (1, 0, 0))


OF_PORTAL = 9.75**2 / (4.75 * 22.5)


def test_up_to_three_bodies_have_the_participation_of_the_formula():
    found = linear_check(portal(), (1, 0, 0))
    assert len(found.bodies) == 3
    assert (found.participation, found.apart) == pytest.approx((OF_PORTAL, OF_PORTAL), rel=1e-6)
    assert found.acceleration == pytest.approx(9.81 / (6 * OF_PORTAL * 1.35), rel=1e-6)
    assert not found.warnings


def test_beds_at_the_point_of_sliding_are_taken_as_one():
    """Three equal weights that slide by 1/3, 2/3 and 1 have e* = 2^2 / (3 x 14/9) = 6/7; each bed slides alone, too."""
    found = linear_check(moved(dry_stones(3), 1 / 3, 2 / 3, 1), (1, 0, 0))
    assert len(found.bodies) == 3
    assert (found.participation, found.apart) == pytest.approx((1.0, 6 / 7))
    assert found.acceleration == pytest.approx(0.2 * 9.81 / 1.35, rel=1e-6)
    assert "without the others" in found.warnings[0]


def test_a_mechanism_of_more_bodies_is_taken_as_one():
    """Of four equal weights that slide by k/4, e* = 2.5^2 / (4 x 30/16) = 10/12; as one body a0* = alpha0 g / FC."""
    limit = moved(dry_stones(4), 0.25, 0.5, 0.75, 1)
    found = linear_check(limit, (1, 0, 0), site=Site("B"), demand=0.1)
    assert (len(found.bodies), found.participation) == (4, 1.0)
    assert found.apart == pytest.approx(10 / 12)
    assert found.acceleration == pytest.approx(0.2 * 9.81 / 1.35, rel=1e-6)
    assert "the safe side" in found.explain()
    assert found.summary()["e_star_apart"] == found.apart


def test_who_judges_bodies_to_be_macro_blocks_has_the_formula():
    found, by_formula = (linear_check(portal(), (1, 0, 0), site=Site("B"), macro_blocks=most) for most in (2, 3))
    assert (found.participation, found.apart) == pytest.approx((1.0, OF_PORTAL))
    assert by_formula.acceleration == pytest.approx(found.acceleration / OF_PORTAL)
    between = (found.ag_life + by_formula.ag_life) / 2
    for most, word in ((2, "not_satisfied"), (3, "satisfied")):
        checked = linear_check(portal(), (1, 0, 0), site=Site("B"), macro_blocks=most, demand=between)
        assert checked.outcome.word == word


def test_weights_that_the_mechanism_does_not_move_do_not_count():
    """A motion far below what the bracket resolves would halve e* of one body that slides; it is none."""
    limit = replace(moved(dry_stones(2), 1e-4, 1), lower=0.2 * (1 - 1e-6), upper=0.2)
    found = linear_check(limit, (1, 0, 0))
    assert found.bodies == ((2,),)
    assert found.participation == pytest.approx(1.0)
    counted = linear_check(replace(limit, lower=0.2, upper=0.2), (1, 0, 0))
    assert counted.apart == pytest.approx(0.5, rel=1e-3)
    assert counted.participation == 1.0  # two beds at the point of sliding


def test_the_multiplier_without_dilatancy_is_taken_where_it_is_known():
    limit = moved(dry_stones(1), 1)
    assert "with associated friction" in linear_check(limit, (1, 0, 0)).explain()
    lower = replace(limit, coulomb_kinds=((0.15, 0.151), (0.17, 0.171)))
    found = linear_check(lower, (1, 0, 0))
    assert found.alpha0 == 0.15
    assert "without dilatancy" in found.explain()


def test_a_curve_of_many_bodies_is_that_of_one_body():
    """As one body a0 and d0 both shrink by e* of the bodies apart, and the period stays."""
    blocks = [box((0, 0, 0), (0.5, 3, 3), name="wall"), box((4, 0, 0), (7, 3, 3), name="idle")]
    curve = capacity(on_ground(*blocks), (1, 0, 0), control="wall", tolerance=FINE)
    mechanism = curve.points[0].mechanism.copy()
    mechanism[curve.assembly.blocks_named("idle")] = (0.1, 0, 0, 0, 0, 0)
    points = (replace(curve.points[0], mechanism=mechanism), *curve.points[1:])
    curve = replace(curve, points=points, limit=replace(curve.limit, mechanism=mechanism))
    one = nonlinear_check(curve, (1, 0, 0), macro_blocks=1)
    # By C8.7.1.5: weights 1.5 to 9; the mean displacements are 1/2 by rotation about the toe, and .1.
    spin = np.linalg.norm(mechanism[curve.assembly.blocks_named("wall")[0], 3:])
    speed, still = np.array([1.5 * spin, 0.1]), np.array([1.5, 9.0])
    total, first, second = still.sum(), still @ speed, still @ speed**2
    assert one.apart == pytest.approx(first**2 / (total * second), rel=1e-6)
    assert one.apart < 0.9
    assert one.participation == 1.0
    assert one.acceleration == pytest.approx(one.alpha0 * 9.81 / 1.35)
    assert one.ultimate == pytest.approx(curve.displacement[-1] * first / total, rel=1e-6)
    # Apart, d0 = second / first and a0 is larger by 1 / e*: the period is the same.
    there, borne = 0.4 * curve.displacement[-1] * second / first, one.state("SLV").acceleration / one.apart
    assert one.state("SLV").period == pytest.approx(1.68 * np.pi * np.sqrt(there / borne), rel=1e-6)
    # The wall falls without the idle block, so that it is taken as one with it by itself.
    mixed = nonlinear_check(curve, (1, 0, 0))
    assert mixed.participation == 1.0
    assert mixed.state("SLV").ag == one.state("SLV").ag
    assert "without the others" in mixed.warnings[0]
    assert "more than the 1" in one.warnings[0]


def test_a_curve_on_which_the_masses_come_back_is_taken_up_to_there():
    """Three columns under a lintel: the middle one goes on falling while the lintel comes back to where it was."""
    columns = [
        box((x, 0, 0), (x + wide, 1, 2), name=n) for n, x, wide in (("a", 0, 0.5), ("b", 1.3, 0.4), ("c", 2.5, 0.5))
    ]
    lintel = box((0, 0, 2), (3, 1, 2.6), name="lintel")
    scene = Assembly.from_blocks([box((-9, -5, -1), (9, 5, 0), name="ground"), *columns, lintel], supports=["ground"])
    scene = scene.with_(friction=0.6)
    curve = capacity(scene, (-1, 0, 0), control="b")
    mean = [-(scene.mass[scene.free] @ point.pose.displacement[scene.free, 0]) for point in curve.points]
    turn = int(np.argmax(mean))
    assert mean[-1] < 0.5 * mean[turn]
    found = nonlinear_check(curve, (-1, 0, 0))
    assert f"the mean of the masses goes back from {curve.displacement[turn]:.4g} m of the control on" in "".join(
        found.warnings
    )
    cut = nonlinear_check(replace(curve, points=curve.points[: turn + 1]), (-1, 0, 0))
    assert found.ultimate == cut.ultimate
    # The same building, with most of the lintel's weight as a load that has mass, at its centroid.
    own = scene.names.index("lintel")
    light = scene.with_(density=np.where(np.arange(scene.n_blocks) == own, 0.1, 1.0) * scene.density)
    points, more = light.centroid.tolist(), 0.9 * scene.mass[own] * 9.81
    push = [(name, points[k], (-9.81 * light.mass[k], 0, 0)) for k, name in enumerate(light.names) if k in light.free]
    push.append(("lintel", points[own], (-more, 0, 0)))
    again = capacity(light, push, loads=[("lintel", points[own], (0, 0, -more))], control="b")
    dead = np.zeros((light.n_blocks, 6))
    dead[own, 2] = -more
    same = nonlinear_check(again, (-1, 0, 0), masses=[("lintel", points[own], more)], loads=dead)
    assert same.ultimate == pytest.approx(found.ultimate, rel=1e-3)


def test_a_curve_whose_control_goes_back_is_taken_up_to_there(wall):
    points = wall.points
    back = replace(wall, points=(*points[:20], *points[12:]))
    turn = points[19].displacement
    found, whole = (nonlinear_check(curve, (1, 0, 0), site=Site("B"), shape="line") for curve in (back, wall))
    assert found.ultimate == pytest.approx(whole.ultimate * turn / wall.displacement[-1])
    assert f"goes back from {turn:.4g} m on" in "".join(found.warnings)
    assert all(low.ag < high.ag for low, high in zip(found.states[1:], whole.states[1:], strict=True))
