"""Decentring, fewest props, least centring: duality, exact small cases, all orders of an arch."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from blockstat import (
    Assembly,
    InputError,
    InputWarning,
    Prop,
    assess_states,
    box,
    centring,
    decentring,
    falsework,
    fewest_props,
    hoists,
    least_centring,
)
from blockstat.geometry.polyhedron import point_velocity
from building_sites import arch, least_force, tee
from evidence.scenes.small import stack

OPEN = ["s0", "s1", "s2", "s4", "s5", "s6"]  # the keystone is missing


def least_forces(hoisted, order):
    """Those after each of the stones is placed."""
    return [least_force(hoisted, tuple(sorted(order[: k + 1]))) for k in range(len(order))]


def test_blocks_follow_the_centring_by_what_it_gives_way_and_the_work_is_that_of_its_forces():
    assembly = arch()
    props = centring(assembly, OPEN)
    found = decentring(assembly, (OPEN, []), props, lowering=0.002)
    weight = assembly.mass[:, None] * assembly.gravity
    work = float((weight * found.displacement[:, :3]).sum())
    expected = least_force(False, (0, 1, 2, 4, 5, 6))
    assert work == pytest.approx(0.002 * found.falsework.total, rel=1e-6)
    assert found.falsework.total == pytest.approx(expected * assembly.mass[0] * 9.81, rel=1e-6)
    block = [assembly.names.index(prop.block) for prop in props]
    velocity = point_velocity(assembly, found.displacement, np.array(block), np.array([p.point for p in props]))
    along = np.einsum("nj,nj->n", velocity, np.array([p.direction for p in props]))
    assert (along >= -0.002 * (1 + 1e-6)).all()  # no block sinks further than its prop
    loaded = found.falsework.force > 1e-4 * found.falsework.total
    assert loaded.any()
    assert along[loaded] == pytest.approx(-0.002, rel=1e-4)  # and those that rest on it sink as far


def test_both_halves_of_an_open_arch_hinge_and_a_closed_one_leaves_its_centring():
    assembly = arch()
    found = decentring(assembly, (OPEN, []), centring(assembly, OPEN))
    assert len(found.hinges) >= 2
    pairs = {frozenset(assembly.names[k] for k in found.interfaces.pair[j]) for j in found.hinges}
    assert not any("s3" in pair for pair in pairs)
    assert "hinge" in found.explain()
    closed = [f"s{k}" for k in range(7)]
    found = decentring(assembly, (closed, []), centring(assembly, closed))
    assert not len(found.moving)
    assert "comes free" in found.explain()


def beam():
    """A beam of 4 m on nothing, with five places for props."""
    blocks = [box((-3, 0, -1), (-2, 1, 0), name="ground"), box((0, 0, 1), (4, 1, 2), name="beam")]
    assembly = Assembly.from_blocks(blocks, supports=["ground"])
    return assembly, [Prop("beam", (x, 0.5, 1.0), (0.0, 0.0, 1.0)) for x in (0.2, 1.0, 1.7, 2.5, 3.8)]


def test_a_beam_needs_two_props_unless_one_stands_below_its_middle():
    assembly, props = beam()
    found = fewest_props(assembly, (["beam"], []), props)
    assert len(found.props) == 2
    assert min(p.point[0] for p in found.props) < 2 < max(p.point[0] for p in found.props)
    middle = Prop("beam", (2.0, 0.5, 1.0), (0.0, 0.0, 1.0))
    assert fewest_props(assembly, (["beam"], []), [*props, middle]).props == (middle,)
    assert fewest_props(assembly, (["beam"], []), props[:3]) is None


def test_the_fewest_props_of_an_open_arch_hold_it_and_no_fewer_do():
    assembly = arch()
    props = centring(assembly, OPEN)
    found = fewest_props(assembly, (OPEN, []), props)
    assert found.outcome.word == "held"
    for k in range(len(found.props)):
        fewer = [prop for prop in found.props if prop is not found.props[k]]
        assert falsework(assembly, (OPEN, []), fewer).outcome.word == "not_held"


@pytest.mark.parametrize("props", [hoists, centring])
def test_least_peaks_over_all_orders_of_an_arch(props):
    """No other of the 7! orders has a lower peak, each of their states by the plane program."""
    assembly = arch()
    found = least_centring(assembly, props)
    peak = min(max(least_forces(props is hoists, order)) for order in permutations(range(7)))
    assert found.peak / (assembly.mass[0] * 9.81) == pytest.approx(peak, abs=1e-6)
    assert sorted(found.order) == [f"s{k}" for k in range(7)]
    own = least_forces(props is hoists, [int(name[1:]) for name in found.order])
    assert np.array(found.forces) / (assembly.mass[0] * 9.81) == pytest.approx(own, abs=1e-6)
    for k, force in enumerate(found.forces):
        stands = assess_states(assembly, [(found.order[: k + 1], [])])[0].outcome.word == "stable"
        assert stands == (force < 1e-6 * assembly.mass[0] * 9.81)


def test_a_centring_that_cannot_be_lowered_is_refused():
    assembly = arch()
    for lowering in (0, -0.001, float("inf"), float("nan"), "1 mm"):
        with pytest.raises(InputError, match=f"lowering is {lowering!r}; it must be above 0"):
            decentring(assembly, (OPEN, []), centring(assembly, OPEN), lowering=lowering)
    with pytest.raises(InputError, match="nothing to lower"):
        decentring(assembly, (OPEN, []), hoists(assembly, ["s0"]))


def test_blocks_that_no_prop_reaches_are_built_in_no_order():
    with pytest.raises(InputError, match="these props cannot hold the blocks in any order"):
        least_centring(arch(), lambda assembly, names: [])
    assembly = stack(2)
    assert least_centring(assembly, lambda assembly, names: []).order == ("stone0", "stone1")


def stone_on_two_props():
    """A cube of 10 kN in the air, with a prop .1 and one .9 from its edge: each alone lets it turn."""
    blocks = [box((-2, 0, -1), (-1, 1, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="stone")]
    assembly = Assembly.from_blocks(blocks, supports=["ground"], density=1000.0, gravity=(0, 0, -10))

    def props(assembly, names):
        return [Prop("stone", (x, 0.5, 1.0), (0.0, 0.0, 1.0)) for x in (0.1, 0.9) if "stone" in names]

    return assembly, props


def test_all_props_of_a_block_count_in_the_least_centring():
    assembly, props = stone_on_two_props()
    found = least_centring(assembly, props)
    assert found.peak == pytest.approx(10_000.0, rel=1e-6)
    assert found.explain().splitlines()[0] == "The centring carries 10000 N at most; no order needs less."
    assert least_centring(assembly, props, least="peak").peak == pytest.approx(5_000.0, rel=1e-6)
    with pytest.raises(InputError, match="these props cannot hold the blocks in any order"):
        least_centring(assembly, lambda assembly, names: props(assembly, names)[:1])


def test_what_props_are_not_proven_to_leave_falling_is_not_said_to_fall(monkeypatch):
    """A stone on one prop beside its middle falls; without the proof of it this is not said."""
    assembly, props = stone_on_two_props()
    one = props(assembly, ["stone"])[:1]
    assert falsework(assembly, (["stone"], []), one).outcome.word == "not_held"
    monkeypatch.setattr("blockstat.sequence.props.falls_on_props", lambda *what: False)
    assert falsework(assembly, (["stone"], []), one).outcome.word == "undecided"
    with pytest.raises(InputError, match="no order found in which these props hold the blocks; in 1 states"):
        least_centring(assembly, lambda assembly, names: props(assembly, names)[:1])
    found = least_centring(tee(), hoists)
    assert found.undecided == 0
    blocked = replace(found, undecided=2)
    assert "no order needs less, unless it goes by one of 2 states that props may or may not hold." in blocked.explain()


@pytest.mark.parametrize("least", ["total", "peak"])
@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e8])
def test_hoists_hold_pebbles_on_a_stone_however_much_heavier_it_is(ratio, least):
    """Two pebbles on one side of the middle of a stone: nothing but their own hoists balances them on it."""
    edge = ratio ** (-1 / 3)
    blocks = [box((-9, -9, -1), (9, 9, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="stone")]
    for k in (0, 1):
        x = 0.2 + k * edge
        blocks.append(box((x, 0.2, 2), (x + edge, 0.2 + edge, 2 + edge), name=f"pebble{k}"))
    assembly = Assembly.from_blocks(blocks, supports=["ground"], density=1000.0, gravity=(0, 0, -10))
    names = assembly.names[1:]
    found = falsework(assembly, (names, []), hoists(assembly, names), least=least)
    assert found.outcome.word == "held"
    assert found.by_block == pytest.approx(dict(zip(names, (10 * assembly.mass[1:]).tolist(), strict=True)), rel=1e-5)


def test_props_that_may_or_may_not_hold_a_cube_in_contacts_without_a_normal_are_undecided():
    """A cube over a slot of its own width touches the sides along edges alone, and falls if these carry nothing."""
    blocks = [box((-1, 0, -1), (0, 1, 0), name="west"), box((1, 0, -1), (2, 1, 0), name="east")]
    scene = Assembly.from_blocks([*blocks, box((0, 0, 0), (1, 1, 1), name="cube")], supports=["west", "east"])
    state, level = (["cube"], []), Prop("cube", (0.0, 0.5, 0.5), (1.0, 0.0, 0.0))
    found = falsework(scene, state, [level])
    assert found.outcome.word == found.summary()["outcome"] == "undecided"
    assert (np.isnan(found.total), found.bound) == (True, 0.0)
    assert found.explain() == "Undecided: these props are proven neither to hold the blocks nor not to."
    assert fewest_props(scene, state, [level]).outcome.word == "undecided"
    with pytest.raises(InputError, match="decentring: these props are proven neither to hold the blocks nor not to"):
        decentring(scene, state, [level])
    with pytest.raises(InputError, match="in 1 states they are proven neither"):
        least_centring(scene, lambda assembly, names: [level] * ("cube" in names))
    under = Prop("cube", (0.5, 0.5, 0.0), (0.0, 0.0, 1.0))
    with pytest.warns(InputWarning, match="1 smaller set may hold the blocks, too"):  # no props at all
        assert fewest_props(scene, state, [level, under]).props == (under,)


@pytest.mark.parametrize(
    ("point", "direction", "words"),
    [
        ((0.5, 0.5, 1.0), (0.0, 0.0, 0.0), "direction is .*; it must be three numbers, not all zero"),
        ((0.5, 0.5, 1.0), (0.0, 0.0, float("nan")), "direction is .*; it must be three numbers"),
        ((float("nan"), 0.5, 1.0), (0.0, 0.0, 1.0), "point is .*; it must be three finite numbers"),
        ((0.5, float("inf"), 1.0), (0.0, 0.0, 1.0), "point is .*; it must be three finite numbers"),
        ((0.5, 1.0), (0.0, 0.0, 1.0), "point is .*; it must be three finite numbers"),
    ],
)
def test_a_prop_without_a_place_or_a_direction_is_refused(point, direction, words):
    with pytest.raises(InputError, match=f'prop under "stone": {words}'):
        Prop("stone", point, direction)
    assert Prop("stone", (0, 0, 0), (0, 0, 1)).point == (0, 0, 0)


def test_a_prop_beside_its_block_is_refused_and_one_at_a_corner_is_not():
    """In millimetres instead of metres it would have a long arm, and need almost no force."""
    assembly, _ = beam()
    state = (["beam"], [])
    for point in ((3000.0, 0.5, 1.0), (2.0, 1.1, 1.0), (2.0, 0.5, 0.9)):
        with pytest.raises(InputError, match=r'the prop at .* is not on block "beam", which is from \[0.0, 0.0, 1.0\]'):
            falsework(assembly, state, [Prop("beam", point, (0.0, 0.0, 1.0))])
    ends = [Prop("beam", (x, 0.5, 1.0), (0.0, 0.0, 1.0)) for x in (0.0, 4.0)]
    assert falsework(assembly, state, ends).force == pytest.approx([assembly.mass[1] * 9.81 / 2] * 2)
