"""Thrusts and domains of two loads against sums and against limits that are known."""

import inspect
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from blockstat import (
    InputError,
    JointLaw,
    ThrustOutcome,
    Tie,
    acceleration,
    load_domain,
    point_load,
    settle,
    thrust_range,
)
from blockstat.analysis import thrust
from blockstat.certificate.functional_bound import value_bound
from blockstat.solve.answer import Status
from evidence.scenes.small import arch, assembly, box, flat_arch, prism


@pytest.mark.parametrize("law", [{}, {"cohesion": 0.02}, {"tension": 0.02}, {"tension": 0.01, "cohesion": 0.02}])
def test_two_springings_carry_the_weight_between_them(law):
    # What one springing carries the other does not: the least of one is the weight without the greatest of the other.
    asm = arch(12, 0.2, friction=0.7).with_(joints=[JointLaw(("*", "*"), **law)] if law else [])
    weight = asm.mass[asm.free].sum()
    right, left, both = (thrust_range(asm, names, (0, 0, -1)) for names in (["right"], ["left"], ["left", "right"]))
    assert right.least < weight / 2 < right.greatest
    assert right.least + left.greatest == pytest.approx(weight, rel=1e-6)
    assert right.greatest + left.least == pytest.approx(weight, rel=1e-6)
    assert (both.least, both.greatest) == pytest.approx((weight, weight), rel=1e-6)
    if law:  # a law adds forces
        dry = thrust_range(asm.with_(joints=[]), ["right"], (0, 0, -1))
        assert right.least <= dry.least * (1 + 1e-9)
        assert right.greatest >= dry.greatest * (1 - 1e-9)


@pytest.mark.parametrize(
    ("friction", "gravity", "load", "least"),
    [(0.5, 1, 0, 1.0), (0.25, 1, 0, 2.0), (0.5, 2, 0, 2.0), (0.5, 1, 0.5, 1.5), (0.25, 2, 0.5, 5.0)],
)
def test_a_stone_between_two_walls_presses_until_friction_bears_its_weight(friction, gravity, load, least):
    """Each wall bears half, and presses with that over the friction; any more may be locked in."""
    asm = flat_arch(1, span=1.0)
    assert asm.free_weight == 1.0
    loads = point_load(asm, 2, (0.5, 0.5, 1.0), (0, 0, -load))
    found = thrust_range(asm, ["right"], (1, 0, 0), friction=friction, gravity=(0, 0, -gravity), loads=loads)
    assert found.outcome is ThrustOutcome.UNBOUNDED
    assert found.least == pytest.approx(least, rel=1e-6)


def test_a_thrust_has_a_sign():
    # Outwards at the right springing is +x, and the left one pushes as hard the other way.
    asm = arch(12, 0.2)
    outwards = thrust_range(asm, ["right"], (2, 0, 0))
    assert 0 < outwards.least < outwards.greatest
    for other in (thrust_range(asm, ["left"], (-1, 0, 0)), thrust_range(asm, ["right"], (1, 0, 0))):
        np.testing.assert_allclose([other.least, other.greatest], [outwards.least, outwards.greatest], rtol=1e-6)
    inwards = thrust_range(asm, ["right"], (-1, 0, 0))
    np.testing.assert_allclose([inwards.least, inwards.greatest], [-outwards.greatest, -outwards.least], rtol=1e-6)


GROUND = box((-4, -1, -1), (2, 2, 0), name="ground")
ROCK = box((3, -1, -1), (4, 2, 3), name="rock")


def tied(points, between=("ground", "pillar"), **tie):
    """A pillar of weight 1 on the ground beside a rock, with a tie."""
    blocks = [GROUND, box((0, 0, 0), (0.5, 1, 2), name="pillar"), ROCK]
    asm = assembly(blocks, supports=["ground", "rock"], friction=0.7, ties=[Tie(between, points, **tie)])
    return asm, float(asm.mass[1] * np.linalg.norm(asm.gravity))


def range_with_ties(*given):
    """The range without the checks of `evidence`, which know no ties here."""
    return inspect.unwrap(thrust_range)(*given)


@pytest.mark.parametrize("strut", [False, True])
def test_a_tie_counts_with_what_presses_on_its_support_whether_its_force_is_given_or_not(strut):
    down, across = ((0.25, 0.5, -1), (0.25, 0.5, 2)), ((3, 0.5, 0.2), (0.5, 0.5, 0.2))
    for least in (0.1, 0.1 * (1 - 1e-7)):
        force = {"least": least, "greatest": 0.1, "strut": strut}
        asm, weight = tied(down, **force)
        found = range_with_ties(asm, ["ground"], (0, 0, -1))
        assert (found.least, found.greatest) == pytest.approx((weight, weight), rel=1e-6)
        assert found.least_ties == pytest.approx([0.1], rel=1e-6)
        assert found.greatest_ties == pytest.approx([0.1], rel=1e-6)
        # Across, the rock takes the pull of the tie, and the ground the same the other way.
        asm, _ = tied(across, between=("rock", "pillar"), **force)
        pull = 0.1 if strut else -0.1
        for name, way in (("rock", pull), ("ground", -pull)):
            found = range_with_ties(asm, [name], (1, 0, 0))
            assert (found.least, found.greatest) == pytest.approx((way, way), rel=1e-6)
        both = range_with_ties(asm, ["rock", "ground"], (1, 0, 0))
        assert (both.least, both.greatest) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_tie_between_two_supports_does_not_count():
    for least in (0.1, 0.0):
        asm, _ = tied(((3, 0.5, 1), (0, 0.5, -0.5)), between=("rock", "ground"), least=least, greatest=0.1)
        found = range_with_ties(asm, ["ground"], (1, 0, 0))
        assert (found.least, found.greatest) == pytest.approx((0.0, 0.0), abs=1e-9)


def key():
    """A stone between two walls whose friction alone holds it: each carries half its weight at .7 or more of it."""
    blocks = [
        box((-1, 0, 0), (0, 1, 1), name="left"),
        box((1, 0, 0), (2, 1, 1), name="right"),
        box((0, 0, 0), (1, 1, 1)),
    ]
    asm = assembly(blocks, supports=["left", "right"], friction=0.7)
    return asm, float(asm.mass[2] * np.linalg.norm(asm.gravity))


def test_the_thrust_of_a_stone_between_walls_has_one_end_and_that_of_its_weight_both():
    asm, weight = key()
    least = weight / 2 / 0.7
    out = thrust_range(asm, ["right"], (1, 0, 0))
    assert (out.outcome, out.greatest) == (ThrustOutcome.UNBOUNDED, inf)
    assert out.least == pytest.approx(least, rel=1e-6)
    back = thrust_range(asm, ["right"], (-1, 0, 0))
    assert (back.outcome, back.least) == (ThrustOutcome.NO_LEAST, -inf)
    assert back.greatest == pytest.approx(-least, rel=1e-6)
    up = thrust_range(asm, ["right"], (0, 0, 1))
    assert (up.outcome, up.least, up.greatest) == (ThrustOutcome.NO_ENDS, -inf, inf)
    both = thrust_range(asm, ["left", "right"], (0, 0, -1))
    assert both.outcome is ThrustOutcome.BOUNDED
    assert (both.least, both.greatest) == pytest.approx((weight, weight), rel=1e-6)


@pytest.mark.parametrize("friction", [0.0025, 0.0021])
def test_a_thrust_has_no_ends_where_it_takes_hundreds_of_times_as_much_self_stress(friction):
    # Pressed between the walls by any N the stone takes friction x N from one wall to the other.
    asm, _ = key()
    found = thrust_range(asm, ["right"], (0, 0, 1), friction=friction)
    assert (found.outcome, found.least, found.greatest) == (ThrustOutcome.NO_ENDS, -inf, inf)
    assert not found.warnings


def test_an_end_says_why_it_is_not_proven():
    # A thousand weights more would take a million weights of N.
    asm, weight = key()
    found = thrust_range(asm, ["right"], (0, 0, 1), friction=0.001)
    assert found.outcome is ThrustOutcome.UNDECIDED
    assert found.least <= -weight / 2 <= found.greatest
    (text,) = found.warnings
    assert text.startswith("an end of the range is not proven: self-stress may move it without end")


@pytest.mark.parametrize(("push", "least"), [(0.5, 0.75**0.5), (1.0, 1.75), (2.0, 4.75)])
def test_a_least_thrust_that_only_endless_self_stress_reaches_is_approached(push, least):
    """A block of weight 1 on smooth ground, between a smooth wall and a western face that leans at the friction angle.

    A horizontal thrust N is on the rim of the western cone. With a push P across and V upwards the force (N, P, V) is
    in the cone where N >= 0.75 V + P^2 / V. So V falls to 0 as P^2 / N does, and is positive for every N. N is least
    at V = P / sqrt(0.75) or, where that is more than the weight, at V = 1.
    """
    outlines = {"west": [(-2, 0), (0.5, 0), (0, 1), (-2, 1)], "block": [(0.5, 0), (2, 0), (2, 1), (0, 1)]}
    blocks = [prism(outline, 1.0, name=name, group=name) for name, outline in outlines.items()]
    blocks += [box((2, 0, -1), (3, 1, 1), name="east", group="east")]
    blocks += [box((0.5, 0, -1), (2, 1, 0), name="ground", group="ground")]
    smooth = [JointLaw(("block", other), friction=0.0) for other in ("east", "ground")]
    asm = assembly(blocks, supports=[0, 2, 3], friction=0.5, joints=smooth)
    asm = asm.with_(density=1 / asm.mass[1])
    loads = point_load(asm, 1, (0.25, 0.5, 0.5), (0, push, 0))
    west, ground, east = (
        thrust_range(asm, [name], way, loads=loads)
        for name, way in (("west", (0, 0, -1)), ("ground", (0, 0, -1)), ("east", (1, 0, 0)))
    )
    assert 0 < west.least < 2e-5
    assert 1 - 2e-5 < ground.greatest < 1
    assert (west.greatest, ground.least) == pytest.approx((1.0, 0.0), abs=1e-6)
    assert (east.least, east.greatest) == (pytest.approx(least, rel=1e-6), inf)
    for found in (west, ground):
        assert found.proven or "an end of the range is not proven" in found.warnings[0]
    assert 0 < settle(asm, {"west": (0, 0, -0.01)}, loads=loads).reaction < 2e-5


@pytest.mark.parametrize("status", [Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE, Status.STALLED])
def test_what_a_solver_says_without_a_ray_proves_no_thrust_without_end(monkeypatch, status):
    plain = thrust.solve
    monkeypatch.setattr(thrust, "solve", lambda *given, **options: replace(plain(*given, **options), status=status))
    found = thrust_range(arch(12, 0.2), ["right"], (1, 0, 0))
    assert found.outcome is ThrustOutcome.UNDECIDED
    assert found.least == found.greatest > 0  # the thrust of the forces with which it was found to stand
    assert found.explain().startswith("Undecided: a proven force field carries each value told, but thrusts beyond")
    assert found.summary()["proven"] is False


def test_an_extreme_that_no_motion_confirms_is_one_sided(monkeypatch):
    plain = thrust.solve
    still = lambda *given, **options: (lambda found: replace(found, twist=0 * found.twist))(plain(*given, **options))  # noqa: E731
    monkeypatch.setattr(thrust, "solve", still)
    assert thrust_range(arch(12, 0.2), ["right"], (1, 0, 0)).outcome is ThrustOutcome.UNDECIDED


def test_a_thrust_is_one_sided_where_a_support_touches_at_an_edge_alone():
    blocks = [
        box((0, 0, -1), (2, 1, 0), name="pier"), box((0, 0, 0), (3, 1, 0.5), name="slab"),
        box((3, 0, -1), (4, 1, 0), name="pier2"),
    ]  # fmt: skip
    asm = assembly(blocks, supports=["pier", "pier2"])
    weight = float(asm.mass[1] * np.linalg.norm(asm.gravity))
    found = thrust_range(asm, ["pier"], (0, 0, -1))
    assert found.outcome is ThrustOutcome.UNDECIDED  # the edge of the other pier may carry a part
    assert (found.least, found.greatest) == pytest.approx((weight, weight), rel=1e-6)
    (text,) = found.warnings
    assert text.startswith('"slab" and "pier2" touch only edge along edge')


def test_a_domain_refuses_a_deep_overlap():
    asm = assembly([GROUND, box((0, 0, -0.3), (1, 1, 1), name="b")], supports=["ground"])
    with pytest.raises(InputError, match='blocks "ground" and "b" overlap by'):
        load_domain(asm, (1, 0, 0), (0, 1, 0), directions=3)


@pytest.mark.parametrize("friction", [0.7, 5.0, inf])
@pytest.mark.parametrize("law", [{}, {"tension": 0.02}, {"compression": 50.0}])
def test_a_motion_confirms_each_end_of_the_thrust_of_an_arch(friction, law):
    asm = arch(12, 0.2, friction=friction).with_(joints=[JointLaw(("*", "*"), **law)] if law else [])
    found = thrust_range(asm, ["right"], (1, 0, 0))
    assert found.outcome is ThrustOutcome.BOUNDED
    assert found.proven


def test_a_motion_bounds_a_functional_by_the_work_of_the_loads_and_the_price_of_what_closes():
    # A cube of weight 1: lifted at 1 it bounds what presses on the ground; at rest the ground closes at 1, and forces
    # may add up to 10.
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="cube")], supports=["ground"])
    problem, inside = thrust.standing(
        asm, solver="auto", friction=None, gravity=None, loads=None, gap=0.01, interfaces=None
    )
    program = problem.program
    press = np.zeros(3 * len(inside))
    press[::3] = 1.0
    lift = np.array([0, 0, 1.0, 0, 0, 0])
    for twist, motions, bound in ((lift, (), 1.0), (0 * lift, (), 10.0), (0 * lift, (lift,), 1.0), (2 * lift, (), 2.0)):
        assert value_bound(program, press, twist, 10.0, motions) == pytest.approx(bound, rel=1e-9)


def test_a_domain_tells_what_its_limit_loads_warn_of():
    """A slab on a floor and on a ridge beside it, which is crushed; pushed along both it slides and rises from them."""
    ridge = prism([(1.2, -1), (1.8, -1), (1.5, 0)], 1.0, name="ridge")
    blocks = [box((-1, -3, -1), (1, 4, 0), name="floor"), ridge, box((0, 0, 0), (1.6, 1, 0.2), name="slab")]
    law = JointLaw(("*", "*"), compression=1e9)
    asm = assembly(blocks, supports=["floor", "ridge"], friction=0.3).with_(joints=[law])
    found = load_domain(asm, (0, 1, 0), (0, 0, 1), directions=3)
    assert found.warnings == (
        'contacts without area carry nothing under a joint law with compressive strength: "ridge" and "slab"',
    )


def pillar(**options):
    """1 x 1 x 2 m: it weighs 20 kN and tips at half of that."""
    return assembly(
        [GROUND, box((0, 0, 0), (1, 1, 2), name="b", group="wall")],
        supports=["ground"],
        density=1000.0,
        gravity=(0, 0, -10),
        **options,
    )


def test_loads_that_differ_on_supports_alone_span_no_domain():
    """What acts on a support moves nothing: the domain would have no end along their difference."""
    block = pillar()
    one = acceleration(block, (1, 0, 0))
    for other in (acceleration(block, (1, 0, 0), group="wall"), acceleration(block, (-1, 0, 0), group="wall")):
        with pytest.raises(InputError, match="the two loads are the same but for their size; they span no domain"):
            load_domain(block, one, other, directions=4)


def test_loads_that_agree_on_a_heavy_support_alone_span_a_domain():
    block = pillar()
    along, across = (acceleration(block, way) for way in ((1, 0, 0), (0, 1, 0)))
    along[0] = across[0] = (1e9, 0, 0, 0, 0, 0)
    found = load_domain(block, along, across, directions=4)
    assert np.abs(found.inner).max(axis=0) == pytest.approx([0.5, 0.5], rel=1e-5)


@pytest.mark.parametrize("directions", [8.0, 2, True, "8"])
def test_the_rays_of_a_domain_are_a_whole_number(directions):
    with pytest.raises(InputError, match=f"directions is {directions!r}; it must be a whole number of at least 3"):
        load_domain(pillar(), (1, 0, 0), (0, 1, 0), directions=directions)


def test_a_support_that_is_named_twice_counts_once():
    """A tie that pulls a block down on its support leaves the thrust the weight."""
    held = pillar(ties=[Tie(("ground", "b"), ((0.5, 0.5, 0), (0.5, 0.5, 2)), least=100.0, greatest=100.0)])
    for names in (["ground"], ["ground", "ground"], [0, "ground"]):
        found = range_with_ties(held, names, (0, 0, -1))
        assert (found.least, found.greatest) == pytest.approx((20e3, 20e3), rel=1e-6)
