"""Tilts of scenes without symmetry: each way has its own limit, in closed form."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, InputError, JointLaw, Outcome, assess, friction_limit, tilt_limit
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.analysis.tilt_friction.bisection import close_in, scan
from blockstat.analysis.tilt_friction.bracket import BracketOutcome
from evidence.scenes.small import assembly, box

#: By a tilt about y gravity leans towards -x, about -y towards +x.
AXES = {"y": (0, 1, 0), "-y": (0, -1, 0)}


def leaning_pair(tension):
    """Two unit cubes, the upper one half a metre towards +x, in joints that do not slide."""
    blocks = [box((-3, -3, -1), (3, 3, 0)), box((0, 0, 0), (1, 1, 1)), box((0.5, 0, 1), (1.5, 1, 2))]
    return assembly(blocks, friction=9.0, joints=[JointLaw(("*", "*"), tension=tension)] if tension else [])


def least_angle(*cases):
    """Least a of `height sin a = arm cos a + held` [deg]."""
    return min(
        math.degrees(math.atan2(arm, height) + math.asin(held / math.hypot(height, arm))) for height, arm, held in cases
    )


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("tension", [0.0, 2.0])
def test_a_leaning_pair_tilts_further_one_way(axis, tension):
    # (height, arm) of the weight about the edge it tips over, and the moment of two corners that pull with a quarter of
    # the strength of their joint each: of the upper cube on half its face, and of both cubes on the ground.
    arms = (0.0, 0.5) if axis == "-y" else (0.5, 1.5)
    expected = least_angle((0.5, arms[0], 2 * tension * 0.5 / 4 * 0.5), (2.0, arms[1], 2 * tension / 4))
    asm = leaning_pair(tension)
    found = tilt_limit(asm, AXES[axis])
    assert found.stands == pytest.approx(expected, abs=1e-4)
    assert found.falls == pytest.approx(expected, abs=1e-4)
    for degrees, outcome in ((expected - 0.01, Outcome.STABLE), (expected + 0.01, Outcome.UNSTABLE)):
        turn = Rotation.from_rotvec(math.radians(degrees) * np.array(AXES[axis]))
        assert assess(asm, gravity=turn.apply(asm.gravity.copy())).outcome is outcome


@pytest.mark.parametrize(("stands", "falls"), [(0.0, 1.0), (1.0, 0.0)])
@pytest.mark.parametrize("half", [0.1, 2e-7, 0.0])
def test_what_stands_and_what_falls_are_each_closed_in_on_beside_undecided_values(stands, falls, half):
    def judge(value):
        if abs(value - 0.3) < half:
            return Outcome.UNDECIDED, math.nan
        return (Outcome.STABLE if (value < 0.3) == (stands < falls) else Outcome.UNSTABLE), math.nan

    found = close_in(judge, stands, {falls: Outcome.UNSTABLE}, 1e-6)
    ends = (0.3 - half, 0.3 + half) if stands < falls else (0.3 + half, 0.3 - half)
    assert found == pytest.approx(ends, abs=1e-6)
    assert abs(found[0] - found[1]) <= 2 * half + 1e-6 if half > 1e-6 else abs(found[0] - found[1]) <= 1e-6


SCORES = {
    "along a line": (lambda gap: 0.01 * gap, 9),
    "along a parabola": (lambda gap: gap + 50 * gap**2, 16),
    "at once": (lambda gap: 1.0, 25),
    "along a root": (lambda gap: math.sqrt(gap), 45),
    "none": (lambda gap: math.nan, 21),
    "infinite": (lambda gap: math.inf, 21),
}


@pytest.mark.parametrize(("stands", "falls"), [(0.0, 1.0), (1.0, 0.0)])
@pytest.mark.parametrize("score", SCORES)
def test_a_bracket_is_closed_in_on_whatever_the_scores(score, stands, falls):
    rule, most = SCORES[score]
    tried = []

    def judge(value):
        tried.append(value)
        gap = (value - 0.3217) * (1 if stands < falls else -1)
        return (Outcome.STABLE, 0.0) if gap < 0 else (Outcome.UNSTABLE, rule(gap))

    one, other = close_in(judge, stands, {falls: Outcome.UNSTABLE}, 1e-6)
    assert min(one, other) <= 0.3217 <= max(one, other) <= min(one, other) + 1e-6
    assert (one < other) == (stands < falls)
    assert len(tried) <= most


def slab_on_a_slope(*laws):
    """A slab on a slope of .3 rad, as gravity that leans, with a wedge beside it that it does not touch."""
    slope = [9.81 * math.sin(0.3), 0, -9.81 * math.cos(0.3)]
    blocks = [
        box((-1, -1, -1), (9, 2, 0), name="ground", group="ground"), box((0, 0, 0), (1, 1, 0.3), name="slab"),
        box((6, 0, 0), (7, 1, 0.3), name="other", group="other"),
    ]  # fmt: skip
    return Assembly.from_blocks(blocks, supports=["ground"], gravity=slope, joints=laws)


def test_joints_whose_law_has_a_friction_keep_it_and_that_is_said():
    found = friction_limit(slab_on_a_slope(JointLaw(("ground", "other"), friction=0.9)))
    assert found.value == pytest.approx(math.tan(0.3), abs=2e-6)
    assert found.warnings == (
        '1 of 2 joints keep a friction of their own, by the joint law between "ground" and "other"',
    )
    assert "Warning: 1 of 2 joints keep" in found.explain()
    assert not friction_limit(slab_on_a_slope()).warnings


def test_friction_is_not_asked_for_where_no_joint_takes_it():
    with pytest.raises(InputError, match="all joints keep a friction of their own"):
        friction_limit(slab_on_a_slope(JointLaw(("*", "*"), friction=0.5)))


@pytest.mark.parametrize("ask", [lambda asm: tilt_limit(asm, "y"), friction_limit])
def test_what_is_undecided_as_it_stands_is_not_told_to_fall(ask, monkeypatch):
    from blockstat.analysis.tilt_friction import tilt, varied

    monkeypatch.setattr(varied, "judged", lambda *_, **__: replace(real, outcome=Outcome.UNDECIDED))
    asm = slab_on_a_slope()
    real = assess(asm)
    if ask is not friction_limit:
        asm = asm.with_(gravity=(0, 0, -9.81), friction=0.0)
        monkeypatch.setattr(tilt, "limited", lambda *_, **__: dead)
        dead = SimpleNamespace(outcome=LoadOutcome.DEAD_LOAD_UNSTABLE)
    found = ask(asm)
    assert found.outcome is BracketOutcome.UNDECIDED
    assert "table at" not in found.explain()


def test_blocks_that_overlap_are_said_beside_the_tilt():
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, -0.02), (1, 1, 2), name="sunk")]
    found = tilt_limit(Assembly.from_blocks(blocks, supports=["ground"], friction=1.0), "y")
    assert any("overlap" in text for text in found.warnings), found.explain()


def overlapping_pair(**options):
    """Two pillars of 1 x 1 x 2 m that overlap by 3 cm, so that no fall is proven."""
    blocks = [box((-2, -1, -1), (4, 2, 0)), box((0, 0, 0), (1, 1, 2)), box((0.97, 0, 0), (1.97, 1, 2))]
    return Assembly.from_blocks(blocks, supports=[0], friction=1.0, **options)


def test_a_fall_that_is_not_proven_is_not_told():
    """The pillar at the side tips at atan(1/2) = 26.57 degrees, and its corners that overlap may hold it."""
    found = tilt_limit(overlapping_pair(), "y")
    assert (found.outcome, math.isnan(found.falls)) == (BracketOutcome.OPEN, True)
    assert found.stands == pytest.approx(math.degrees(math.atan(0.5)), abs=1e-4)
    assert "Not stable" not in found.explain()
    assert found.summary()["falls"] is None
    assert found.summary()["outcome"] == "open"
    slides = friction_limit(overlapping_pair(gravity=(0.3, 0, -1.0)))  # at .3
    assert (slides.outcome, math.isnan(slides.falls)) == (BracketOutcome.OPEN, True)
    assert 0.3 <= slides.stands < 0.3 + 2e-6
    assert friction_limit(slab_on_a_slope()).outcome is BracketOutcome.LIMIT


def stopped_by_an_edge(*others):
    """A cube on a slope of .3 along the diagonal of its base, in front of a pillar of which it meets an edge alone."""
    down = 0.3 / math.sqrt(2.0)
    blocks = [box((-3, -3, -1), (9, 9, 0)), box((0, 0, 0), (1, 1, 1)), box((1, 1, 0), (2, 2, 1)), *others]
    supports = [0, 2, *([3] if others else [])]
    return Assembly.from_blocks(blocks, supports=supports, gravity=(down, down, -1.0))


def test_a_fall_beyond_undecided_values_is_closed_in_on():
    """The edge may stop the cube, below .3. A slab on a wedge of another slope slides below .2 all the same."""
    turn = Rotation.from_rotvec((math.atan(0.3) - math.atan(0.2)) * np.array([1.0, -1.0, 0.0]) / math.sqrt(2.0))
    wedge, slab = (
        Block(np.array([6.0, 0.0, 3.0]) + turn.apply(one.vertices), one.faces)
        for one in (box((-1, -1, -0.5), (1, 1, 0)), box((-0.5, -0.5, 0), (0.5, 0.5, 0.2)))
    )
    alone, both = (friction_limit(stopped_by_an_edge(*others), width=1e-4) for others in ((), (wedge, slab)))
    assert (alone.outcome, both.outcome) == (BracketOutcome.OPEN, BracketOutcome.OPEN)
    assert math.isnan(alone.falls)
    assert "Not stable" not in alone.explain()
    assert both.falls == pytest.approx(0.2, abs=1e-4)
    assert "Not stable at a friction of" in both.explain()
    for found in (alone, both):
        assert found.stands == pytest.approx(0.3, abs=1e-4)


def test_a_tilt_beyond_which_nothing_is_proven_is_that_of_the_load():
    """The edge may stop the cube, which slides at atan(.3)."""
    asm = stopped_by_an_edge().with_(gravity=(0, 0, -1.0), friction=0.3)
    found = tilt_limit(asm, (1, -1, 0))
    assert found.outcome is BracketOutcome.OPEN
    assert found.stands == pytest.approx(math.degrees(math.atan(0.3)), abs=1e-4)


@pytest.mark.parametrize("limit", [28.3, 30.0])
def test_a_fall_is_told_where_one_is_proven_before_the_value_that_is_undecided(limit):
    def judge(degrees):
        if degrees == 30.0:
            return Outcome.UNDECIDED, math.nan
        return (Outcome.STABLE if degrees < limit else Outcome.UNSTABLE), math.nan

    stands, falls = scan(judge, 180.0, 1e-6)
    assert limit - 1e-6 <= stands < limit
    assert math.isnan(falls) if limit == 30.0 else limit <= falls <= stands + 1e-6


def test_the_friction_of_the_assembly_plays_no_part_beside_cohesion():
    """100 kN/m2 on 1 m2 hold a slab of some kN on any slope, with the least friction that cohesion goes with."""
    found = friction_limit(slab_on_a_slope(JointLaw(("*", "*"), cohesion=1e5)).with_(friction=0.0))
    assert (found.outcome, found.stands) == (BracketOutcome.ALWAYS_STANDS, 1e-3)


@pytest.mark.parametrize(("flow", "told"), [("associated", True), ("coulomb", False)])
def test_a_tilt_without_dilatancy_is_not_said_to_dilate(flow, told):
    blocks = [box((-1, -1, -1), (2, 2, 0)), box((0, 0, 0), (1, 1, 2))]
    for axis in ("z", (0, 0, -1)):
        found = tilt_limit(Assembly.from_blocks(blocks, supports=[0], friction=1.0), axis, flow=flow)
        assert found.outcome is BracketOutcome.ALWAYS_STANDS
        assert ("Friction is associated" in found.explain()) is told


@pytest.mark.parametrize("option", ["top", "width"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, "1", None])
def test_the_ends_and_the_width_of_a_bracket_of_friction_are_numbers_above_0(option, value):
    with pytest.raises(InputError, match=f"{option} is {value!r}; it must be "):
        friction_limit(slab_on_a_slope(), **{option: value})
