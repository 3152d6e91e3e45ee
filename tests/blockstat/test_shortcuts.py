"""Shortcuts of the statics whose hypothesis does not always hold: each scene is one in which it fails."""

import math

import numpy as np
import pytest

from blockstat import (
    Assembly,
    BracketOutcome,
    InputError,
    JointLaw,
    LoadOutcome,
    Outcome,
    Tie,
    assess,
    friction_limit,
    limit_load,
    limit_load_by_direction,
    point_load,
    tilt_limit,
)
from evidence.scenes.small import box, prism


def key_between_leaning_walls():
    """Two walls that stand by themselves and lean towards each other, and a light key between their upright faces."""
    profile = [(0, 0), (0.6, 0), (1, 0.4), (1, 1), (0.4, 1)]
    mirrored = [(2.2 - x, z) for x, z in profile][::-1]
    blocks = [
        box((-2, -1, -1), (5, 2, 0), name="ground"), prism(profile, 1.0, name="left"),
        prism(mirrored, 1.0, name="right"), box((1, 0, 0.5), (1.2, 1, 0.9), name="key", density=100.0),
    ]  # fmt: skip
    return Assembly.from_blocks(blocks, supports=["ground"], density=2000.0, friction=0.7)


def test_a_key_that_walls_lean_on_as_they_give_way_is_not_proven_to_fall():
    # The walls rest without the key, but in joints that give way they come closer and press it: a state exists.
    verdict = assess(key_between_leaning_walls(), flow="coulomb")
    assert verdict.outcome is Outcome.STABLE
    assert not len(verdict.falling)
    # In rigid joints that nothing has pressed it falls.
    assert verdict.headline.startswith("Stable in some joints only")
    assert "free to fall else: key." in verdict.explain()


def tied_pillar(**tie):
    """A pillar .5 m thick, 2 m high, of 9,810 N; a tie of its top pulls it away from the side to which it tilts."""
    blocks = [box((-4, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="pillar")]
    tie = Tie(("ground", "pillar"), ((-4, 0.5, 2), (0, 0.5, 2)), **tie)
    return Assembly.from_blocks(blocks, supports=["ground"], density=1000.0, friction=5.0, ties=[tie])


@pytest.mark.parametrize(("tie", "force"), [({"greatest": 2000.0}, 2000.0), ({"least": 1e3, "greatest": 1e3}, 1e3)])
def test_a_tie_does_not_grow_with_the_tilt(tie, force):
    # Moments about the lower edge: W (sin a - .25 cos a) = 2 T, the height of the tie being 2 m, of the weight 1 m.
    expected = math.degrees(math.asin(2 * force / 9810.0 / math.hypot(1, 0.25)) + math.atan(0.25))
    found = tilt_limit(tied_pillar(**tie), (0, -1, 0))
    assert found.stands == pytest.approx(expected, abs=1e-4)
    assert found.falls == pytest.approx(expected, abs=1e-4)


def test_more_friction_carries_less_tension_where_cohesion_is_given_too():
    blocks = [box((-1, -1, 1), (2, 2, 2), name="ceiling"), box((0, 0, 0), (1, 1, 1), name="cube")]
    laws = [JointLaw(("*", "*"), tension=4e4, cohesion=4e4)]  # tension up to cohesion over friction: 20 kN hang at .5
    hanging = Assembly.from_blocks(blocks, supports=["ceiling"], density=2000.0, joints=laws)
    assert assess(hanging, friction=0.5).outcome is Outcome.STABLE
    assert assess(hanging, friction=10.0).outcome is Outcome.UNSTABLE
    found = friction_limit(hanging)
    assert found.outcome is BracketOutcome.UNDECIDED
    assert any("more friction carries less tension" in text for text in found.warnings)


def ridge_beside_a_pillar(**options):
    """A pillar and the edge of a ridge at its back, in joints that may crush: what the edge carries is not known."""
    ridge = prism([(1.0, 1.5), (2.0, 1.2), (2.0, 1.8)], 0.6, name="ridge")
    turned = np.column_stack([0.2 + ridge.vertices[:, 1], ridge.vertices[:, 0], ridge.vertices[:, 2]])
    ridge.vertices[:] = turned
    ridge.faces[:] = [face[::-1] for face in ridge.faces]
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0.5, 0), (1, 1, 2), name="pillar"), ridge]
    laws = [JointLaw(("*", "*"), compression=1e8)]
    return Assembly.from_blocks(blocks, supports=["ground", "ridge"], density=1000.0, joints=laws, **options)


def test_an_edge_that_may_crush_is_remembered_from_one_direction_to_the_next():
    asm = ridge_beside_a_pillar()
    assert limit_load(asm, (0, 1, 0)).outcome is LoadOutcome.UNDECIDED
    found = limit_load_by_direction(asm, 4, refine=False)
    assert found.limits[found.names.index("+y")].outcome is LoadOutcome.UNDECIDED
    assert np.isinf(found.upper[found.names.index("+y")])
    # Away from the ridge it tips where its weight leaves the joint, less than 4 % earlier with eight cells.
    tips = 0.25
    assert 0.96 * tips < math.tan(math.radians(tilt_limit(asm, (-1, 0, 0)).falls)) <= tips
    towards = tilt_limit(asm, (1, 0, 0))
    assert towards.stands < math.degrees(math.atan(tips))
    assert (towards.outcome, math.isnan(towards.falls)) == (BracketOutcome.OPEN, True)  # the ridge may hold it
    leaning = asm.with_(gravity=(0, 4.0, -9.0))
    assert assess(leaning, friction=10.0).outcome is Outcome.UNDECIDED
    assert friction_limit(leaning).outcome is BracketOutcome.UNDECIDED


@pytest.mark.parametrize("friction", [None, 0.5, 0.0, np.inf])
def test_one_joint_without_friction_does_not_turn_the_others_associated(friction):
    blocks = [
        box((-1, 0, 0), (0, 1, 1), name="left"), box((1, 0, 0), (2, 1, 1), name="right"),
        box((0, 0, 0), (1, 1, 1), name="key"), box((5, 0, -1), (8, 1, 0), name="ground"),
        box((6, 0, 0), (7, 1, 1), name="apart", group="apart"),
    ]  # fmt: skip
    laws = [] if friction is None else [JointLaw(("apart", "*"), friction=friction)]
    asm = Assembly.from_blocks(blocks, supports=["left", "right", "ground"], friction=0.7, joints=laws)
    assert assess(asm).outcome is Outcome.STABLE
    assert assess(asm, flow="coulomb").outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS
    # The key is held by self-stress alone, so without it not even the weight is carried.
    if friction != 0:
        found = limit_load(asm, point_load(asm, "apart", (6.5, 0.5, 0.5), (0, 1, 0)), flow="coulomb")
        assert found.outcome is LoadOutcome.LIMIT
        assert set(found.coulomb_kinds) == {(0.0, 0.0)}


def test_what_nothing_holds_and_nothing_moves_is_undecided_under_every_load():
    blocks = [
        box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube"),
        box((0, 0, 5), (1, 1, 6), name="hung"),
    ]  # fmt: skip
    asm = Assembly.from_blocks(blocks, supports=["ground"], density=1000.0)
    lift = np.zeros((3, 6))
    lift[2, 2] = 9810.0
    assert assess(asm, loads=lift).outcome is Outcome.UNDECIDED
    found = limit_load(asm, point_load(asm, "cube", (0.5, 0.5, 0.5), (1, 0, 0)), loads=lift)
    assert found.outcome is LoadOutcome.UNDECIDED


@pytest.mark.parametrize("name", ["tension", "cohesion", "compression"])
def test_a_strength_that_no_stone_has_is_refused(name):
    with pytest.raises(InputError, match=r"joint law between \* and \*: .* no stone bears 1e\+10 Pa"):
        JointLaw(("*", "*"), **{name: 1e13})


@pytest.mark.parametrize("least", [0, 0.0])
def test_the_force_of_a_tie_is_not_cut_to_whole_newtons(least):
    """A block of 1 N on ground without friction, pushed by .8 N; the tie pulls along the same line."""
    blocks = [box((-4, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="block")]
    tie = Tie(("ground", "block"), ((-4, 0.5, 0.5), (0, 0.5, 0.5)), least=least)
    options = {"supports": ["ground"], "density": 1.0, "gravity": (0, 0, -1), "friction": 0.0, "ties": [tie]}
    asm = Assembly.from_blocks(blocks, **options)
    verdict = assess(asm, loads=point_load(asm, "block", (0.5, 0.5, 0.5), (0.8, 0, 0)))
    assert verdict.outcome is Outcome.STABLE
    assert verdict.ties == pytest.approx([0.8], rel=1e-6)
