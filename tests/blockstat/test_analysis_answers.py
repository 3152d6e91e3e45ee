"""Answers of limit analysis, tilts, frictions and thrusts: closed forms, every option, and what results say."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    LoadOutcome,
    Outcome,
    Verdict,
    acceleration,
    assess,
    find_interfaces,
    friction_limit,
    glued,
    limit_load,
    load_domain,
    point_load,
    thrust_range,
    tilt_limit,
)
from blockstat.analysis import assess as assessing
from blockstat.analysis import decision
from blockstat.analysis.assess import _second, judged
from blockstat.analysis.decision import (
    Bound,
    _bound_by,
    _checked,
    decide,
    lower_bound,
    narrowed,
    outcome_of,
    proven_bounds,
    solve_margin_locally,
    upper_bound,
)
from blockstat.analysis.limit_load import DILATES, UNBOUNDED, LimitLoad, _beyond_bounds, bracket
from blockstat.analysis.problem import pose
from blockstat.analysis.thrust import ThrustRange, admissible, support_indices
from blockstat.analysis.tilt_friction.bracket import Bracket, BracketOutcome
from blockstat.certificate.bracket import ROUNDING
from blockstat.certificate.bracket import Bracket as LimitBracket
from blockstat.certificate.check import FORCE_LIMIT, FORCE_TOLERANCE, WORK_ROUNDING, Certificate
from blockstat.program.penalty import as_strong_as_the_weight
from blockstat.solve.answer import Status
from blockstat.solve.penalty import solve_penalty
from blockstat.studies.two_loads import LoadDomain
from evidence.scenes.small import assembly, box, running_bond

GROUND = box((-9, -9, -1), (9, 9, 0), name="ground")
B, H = 1.0, 2.0


def block(**options):
    """A block of b x h = 1 x 2, half a metre deep, of 1 N in all: it tips at b / h = .5 and slides at the friction."""
    return assembly([GROUND, box((0, 0, 0), (B, 0.5, H), name="block")], friction=0.7, **options)


def close(found, expected, rel=1e-6):
    return pytest.approx((expected, expected), rel=rel) == (found.lower, found.upper)


@pytest.mark.parametrize("solver", ["auto", "interior-point", "clarabel"])
def test_a_block_tips_or_slides_whatever_the_size_of_the_load(solver):
    asm = block()
    for friction, expected in ((0.7, 0.5), (0.3, 0.3)):
        options = {"solver": solver, "friction": friction, "tolerance": 1e-6}
        assert close(limit_load(asm, (1, 0, 0), **options), expected)
        for size in (1e-4, 1e3):
            found = limit_load(asm, size * acceleration(asm, (1, 0, 0)), **options)
            assert close(found, expected / size)
            assert found.outcome is LoadOutcome.LIMIT
    assert close(limit_load(asm, (0, 1, 0), solver=solver, friction=9.0, tolerance=1e-6), 0.25)


def test_a_moment_alone_has_a_limit():
    asm, load = block(), np.zeros((2, 6))
    load[1, 4] = 1.0
    assert close(limit_load(asm, load, tolerance=1e-6), B / 2)
    load[1, 3:] = 0.0, -4.0, 0.0
    assert close(limit_load(asm, load, tolerance=1e-6), B / 8)


def test_gravity_friction_loads_and_joints_are_those_given():
    asm, joints = block(), find_interfaces(block())
    leaning = limit_load(asm, (1, 0, 0), gravity=(0.2, 0, -1), tolerance=1e-6)
    # The multiplier is in units of |g|; the block tips where the weight's line leaves the foot.
    assert close(leaning, (0.5 - 0.2) / np.hypot(0.2, 1))
    load = point_load(asm, "block", (0.5, 0.25, H), (0, 0, -3.0))
    assert close(limit_load(asm, (1, 0, 0), loads=load, friction=9.0, tolerance=1e-6), 2.0)
    assert close(limit_load(asm, (-1, 0, 0), interfaces=joints, tolerance=1e-6), 0.5)
    half = replace(joints, point=joints.point * [0.75, 1, 1])  # the foot ends at x = .75
    assert close(limit_load(asm, (1, 0, 0), interfaces=half, tolerance=1e-6), 0.25)


@pytest.mark.parametrize("tolerance", [0, -1e-3, 0.11, "x", None, np.nan])
def test_a_tolerance_is_above_nothing_and_at_most_a_tenth(tolerance):
    with pytest.raises(InputError, match=r"tolerance is .*; it must be above 0 and at most 0.1 of the limit"):
        limit_load(block(), (1, 0, 0), tolerance=tolerance)
    assert limit_load(block(), (1, 0, 0), tolerance=0.1).outcome is LoadOutcome.LIMIT


def test_what_does_not_stand_or_has_no_limit_says_so():
    asm = block()
    down = limit_load(asm, (0, 0, -1))
    assert (down.outcome, down.lower, down.upper, down.gap) == (LoadOutcome.UNBOUNDED, np.inf, np.inf, 0.0)
    assert down.summary()["lower"] is None
    np.testing.assert_allclose(down.forces[:, 0].sum(), asm.free_weight)
    falls = limit_load(asm, (1, 0, 0), gravity=(0.6, 0, -1))
    assert (falls.outcome, falls.lower, falls.upper) == (LoadOutcome.DEAD_LOAD_UNSTABLE, -np.inf, -np.inf)
    assert falls.mechanism.any()
    apart = assembly([GROUND, box((0, 0, 1), (1, 1, 2), name="up")])
    lost = limit_load(apart, (1, 0, 0))
    assert (lost.outcome, lost.lower, lost.upper, lost.iterations) == (
        LoadOutcome.DEAD_LOAD_UNSTABLE, -np.inf, -np.inf, 0,
    )  # fmt: skip
    with pytest.raises(InputError, match='"assembly": all blocks are supports; there is nothing to load'):
        limit_load(assembly([GROUND]), (1, 0, 0))
    up = limit_load(asm, (0, 0, 1), tolerance=1e-6)
    assert close(up, 1.0)
    strong = limit_load(glued(asm, 1e9), (1, 0, 0))
    assert strong.outcome is LoadOutcome.UNBOUNDED
    assert strong.lower == np.inf


def test_without_dilatancy_a_block_slides_at_its_friction_in_every_kind_of_joints():
    found = limit_load(block(), (1, 0, 0), friction=0.3, flow="coulomb")
    assert len(found.coulomb_kinds) == 3
    for lower, upper in found.coulomb_kinds:
        assert lower <= 0.3 * (1 + 1e-6)
        assert upper == pytest.approx(0.3, rel=1.1e-3)
        assert upper - lower <= 5e-4 * 0.3 * (1 + 1e-6)
    assert found.summary()["branch"] == "without dilatancy and self-stress"
    stiff = limit_load(block(), (1, 0, 0), friction=np.inf, flow="coulomb")
    assert len(stiff.coulomb_kinds) == 3  # it tips, and loses nothing
    for lower, _ in stiff.coulomb_kinds:
        assert lower == pytest.approx(stiff.lower, rel=1.1e-3)
    assert limit_load(block(), (1, 0, 0)).coulomb_kinds == ()
    pressed = limit_load(block(), (0, 0, -1), flow="coulomb")
    assert (pressed.outcome, pressed.coulomb_kinds) == (LoadOutcome.UNBOUNDED, ((np.inf, np.inf),) * 3)
    assert pressed.summary()["coulomb_lower"] is pressed.summary()["coulomb_upper"] is None
    assert "Without dilatancy and self-stress: inf (100000 times the weight was tried)" in pressed.explain()
    assert "Friction is associated" not in pressed.explain()
    assert "Friction is associated" in limit_load(block(), (0, 0, -1)).explain()


def in_a_slot(floor, friction=0.9):
    """A cube between two upright walls, on a floor or without one."""
    ends = [box((-1, 0, 0), (0, 1, 1), name="left"), box((1, 0, 0), (2, 1, 1), name="right")]
    low = [box((0, 0, -1), (1, 1, 0), name="floor")] if floor else []
    blocks = [*ends, *low, box((0, 0, 0), (1, 1, 1), name="cube")]
    return Assembly.from_blocks(blocks, supports=range(len(blocks) - 1), friction=friction)


@pytest.mark.parametrize(
    ("floor", "push", "least"),
    [
        (False, (0, 0, -1), 0.0),  # it falls out: no wall presses on it
        (True, (0, 0, 1), 1.0),  # it rises as soon as the floor carries nothing
        (True, (0, 1, -1), 9 * np.sqrt(2)),  # along the slot: k / sqrt 2 = mu (1 + k / sqrt 2)
        (True, (1, 0, 0), np.inf),
        (True, (0, 0, -1), np.inf),
        (True, (0, 0.8, -1), np.inf),  # within the friction of the floor
    ],
)
def test_a_cube_in_a_slot_jams_only_where_friction_dilates(floor, push, least):
    """With dilatancy the walls hold it whatever the push; without, as far as the weight and the push press."""
    asm = in_a_slot(floor)
    assert limit_load(asm, push).outcome is LoadOutcome.UNBOUNDED
    found = limit_load(asm, push, flow="coulomb")
    assert found.outcome is (LoadOutcome.UNBOUNDED if np.isinf(least) else LoadOutcome.UNDECIDED)
    assert any("dilate as they slide carry any multiple" in text for text in found.warnings) == np.isfinite(least)
    assert len(found.coulomb_kinds) == 3
    for lower, upper in found.coulomb_kinds:
        assert lower <= least * (1 + 1e-6)
        assert upper == pytest.approx(least, rel=1.5e-3)


def test_an_interrupt_below_a_load_without_limit_is_kept():
    def stop(trial, low, high):
        if trial == 1:
            raise KeyboardInterrupt

    found = limit_load(block(), (0, 0, -1), flow="coulomb", progress=stop)
    assert found.outcome is LoadOutcome.STOPPED
    assert found.warnings == ("stopped before every kind of joints without dilatancy was bracketed",)


def test_what_carries_nothing_carries_nothing_without_dilatancy():
    found = limit_load(block(), (1, 0, 0), friction=0.0, flow="coulomb", solver="interior-point")
    assert found.lower == 0.0
    assert found.coulomb_least == pytest.approx((0.0, 0.0), abs=1e-8)
    assert found.summary()["coulomb_lower"] == 0.0
    assert "Friction is associated" not in found.explain()


def limit(**changes):
    asm = block()
    joints = find_interfaces(asm)
    mechanism = np.zeros((2, 6))
    mechanism[1, 2] = 1.0
    made = LimitLoad(
        LoadOutcome.LIMIT, 1.0, 1.5, np.zeros((4, 3)), mechanism, joints, asm, ("w",), {"total": 1.0}, iterations=7
    )
    return replace(made, **changes)


def test_a_limit_counts_no_iterations_and_no_kinds_of_joints_unless_told():
    bare = LimitLoad(*(getattr(limit(), name) for name in LimitLoad.__match_args__[:9]))
    assert bare.gap == pytest.approx(1 / 3)
    assert (bare.iterations, bare.coulomb, bare.bonds, bare.worst) == (0, None, None, "")


def test_a_limit_tells_its_bracket_and_those_without_dilatancy():
    plain = limit()
    assert plain.gap == pytest.approx(1 / 3)
    assert plain.explain().splitlines() == [
        LoadOutcome.LIMIT.value, "1 <= multiplier <= 1.5",
        'Friction is associated: joints dilate as they slide, and real ones may carry less (see flow="coulomb").',
        "Joints of the mechanism: 0 hinges, 0 sliding, 1 opening.", "First to move: block.", "Warning: w",
    ]  # fmt: skip
    assert (plain.coulomb, plain.coulomb_least) == (None, None)
    kinds = limit(coulomb_kinds=((0.5, 0.6), (0.8, 0.9), (0.4, 0.45)), worst="w1")
    assert (kinds.coulomb, kinds.coulomb_least) == ((0.8, 0.9), (0.4, 0.45))
    lines = kinds.explain().splitlines()
    assert lines[1] == "Worst case of the imperfections: w1."
    assert lines[3:5] == [
        "Without dilatancy and self-stress: 0.8 to 0.9", "In the kind of joints that carries least: 0.4 to 0.45",
    ]  # fmt: skip
    alike = limit(coulomb_kinds=((0.8, 0.9), (0.75, 0.8)))
    assert "carries least" not in alike.explain()
    assert "carries least" in limit(coulomb_kinds=((0.8, 0.9), (0.75, 0.79))).explain()
    assert "multiplier" in limit(outcome=LoadOutcome.STOPPED).explain()
    assert "First to move" not in limit(mechanism=np.zeros((2, 6))).explain()
    bounds = {
        "1 <= multiplier <= 1.5": {},
        "1 <= multiplier": {"upper": np.inf},
        "multiplier <= 1.5": {"lower": -np.inf},
    }
    for words, open_end in bounds.items():
        assert limit(outcome=LoadOutcome.UNDECIDED, **open_end).explain().splitlines()[1:] == [words, "Warning: w"]
    assert "multiplier" not in limit(outcome=LoadOutcome.UNDECIDED, lower=-np.inf, upper=np.inf).explain()
    found = kinds.summary()
    expected = {
        "status": "limit", "outcome": "limit", "sentence": LoadOutcome.LIMIT.value, "lower": 1.0, "upper": 1.5,
        "iterations": 7, "coulomb_lower": 0.8, "coulomb_upper": 0.9, "coulomb_least": 0.4, "moving": ["block"],
        "joints": {"hinges": [], "sliding": [], "opening": [("ground", "block")]}, "blocks": 2, "interfaces": 1,
        "imperfections": "w1", "warnings": ["w"], "timings": {"total": 1.0},
    }  # fmt: skip
    assert {key: found[key] for key in expected} == expected
    bare = plain.summary()
    assert [bare[key] for key in ("coulomb_lower", "coulomb_upper", "coulomb_least", "branch", "imperfections")] == [
        None
    ] * 5


def test_what_an_answer_has_not_been_told_is_nothing():
    bare = LimitLoad(LoadOutcome.LIMIT, 1.0, 1.5, np.zeros((0, 3)), np.zeros((2, 6)), None, None, (), {})
    assert (bare.iterations, bare.coulomb_kinds, bare.bonds, bare.ties, bare.worst) == (0, (), None, None, "")
    found = assess(block())
    made = Verdict(
        Outcome.STABLE, 0.0, found.forces, found.adhesion, found.mechanism, found.certificate, found.interfaces,
        found.assembly, "by hand",
    )  # fmt: skip
    assert (made.warnings, made.flow, made.coulomb, made.displacement, made.worst) == ((), "associated", None, None, "")
    assert (len(made.floating), len(made.neutral), len(made.held), len(made.falling), made.timings) == (0, 0, 0, 0, {})
    assert (made.bonds, made.ties) == (None, None)
    assert bare != replace(bare)  # arrays are not compared
    for frozen, name in ((bare, "lower"), (made, "score"), (Bound(0.0, np.zeros(1)), "value")):
        with pytest.raises(AttributeError):
            setattr(frozen, name, 1.0)


@pytest.mark.parametrize(("lower", "upper", "gap"), [
    (1.0, 2.0, 0.5), (0.0, 0.0, 0.0), (np.inf, np.inf, 0.0), (-np.inf, -np.inf, 0.0), (1.0, np.inf, np.inf),
    (-np.inf, 1.0, np.inf), (-4.0, -2.0, 0.5), (-np.inf, np.inf, np.inf),
])  # fmt: skip
def test_the_gap_is_relative_to_the_larger_end(lower, upper, gap):
    assert limit(lower=lower, upper=upper).gap == pytest.approx(gap)


def test_a_kind_of_motion_is_told_from_its_tolerance_on():
    moved = limit()
    moved.mechanism[1] = 0, 0, 1e-3, 0, 0, 0
    assert moved.joints()["opening"] == [("ground", "block")]
    assert moved.joints(tolerance=2e-3) == {"hinges": [], "sliding": [], "opening": []}


def topples(load, angle):
    """Moment about the lower edge of a block of weight 1 and a vertical load on its top that keeps its direction."""
    a = math.radians(angle)
    return (math.cos(a) * B - math.sin(a) * H) / 2 + load * B / 2


@pytest.mark.parametrize("solver", ["auto", "clarabel"])
def test_tilts_of_a_block_are_those_of_its_edge(solver):
    asm = block(density=1.0).with_(friction=9.0)
    asm = asm.with_(density=np.array([1.0, 1.0]))
    for axis, expected in (("y", math.atan(0.5)), ("x", math.atan(0.25)), ((0, 2, 0), math.atan(0.5))):
        found = tilt_limit(asm, axis, solver=solver)
        assert (found.stands, found.falls) == pytest.approx((math.degrees(expected),) * 2, abs=1e-4)
        assert (found.parameter, found.unit, found.outcome) == ("tilt", "deg", BracketOutcome.LIMIT)
        assert found.kinds == ()
    slides = tilt_limit(asm, "y", friction=0.3, solver=solver)
    assert slides.stands == pytest.approx(math.degrees(math.atan(0.3)), abs=1e-4)
    assert found.value == found.stands


def test_loads_that_keep_their_direction_are_scanned_angle_by_angle():
    asm = block().with_(friction=9.0)
    load = point_load(asm, "block", (0.5, 0.25, H), (0, 0, -0.3))
    expected = brentq(lambda angle: topples(0.3, angle), 1, 80)
    found = tilt_limit(asm, "y", loads=load)
    assert found.stands == pytest.approx(expected, abs=1e-4)
    assert 0 < found.falls - found.stands <= 1e-6


@pytest.mark.parametrize("loads", [None, np.zeros((2, 6))])
@pytest.mark.parametrize(("axis", "lean"), [((0, 1, 0), 0.2), ((0, -1, 0), -0.2)])
def test_a_tilt_against_a_lean_goes_further(axis, lean, loads):
    # A tilt about y takes gravity towards -x, against a lean of atan(.2).
    asm = block(gravity=(0.2, 0, -1)).with_(friction=9.0)
    expected = math.degrees(math.atan(0.5) + math.atan(lean))
    assert tilt_limit(asm, axis, loads=loads).stands == pytest.approx(expected, abs=1e-4)


def test_tilts_about_gravity_change_nothing_and_what_falls_never_stands():
    asm = block()
    still = tilt_limit(asm, "z")
    assert (still.stands, math.isnan(still.falls), still.outcome) == (180.0, True, BracketOutcome.ALWAYS_STANDS)
    falling = tilt_limit(asm, (1.2, 0, -2.0), gravity=(0.6, 0, -1))
    assert math.isnan(falling.stands)
    assert falling.falls == 0.0
    assert falling.outcome is BracketOutcome.NEVER_STANDS
    for options in ({}, {"loads": np.zeros((2, 6))}):
        never = tilt_limit(asm, "y", gravity=(0.6, 0, -1), **options)
        assert math.isnan(never.stands)
        assert never.falls == 0.0
    alone = tilt_limit(assembly([GROUND]), "x")
    assert (alone.stands, math.isnan(alone.falls)) == (180.0, True)
    held = tilt_limit(glued(asm, 1e3), "y")
    assert (held.stands, math.isnan(held.falls)) == (180.0, True)


def test_an_axis_that_leans_is_scanned():
    """Gravity turns on a cone about an axis between x and z: it tips where the weight's line leaves the foot."""
    asm = block().with_(friction=9.0)
    found = tilt_limit(asm, (1, 0, 1))
    unit = np.array([1, 0, 1]) / 2**0.5

    def inside(degrees):
        a, g = math.radians(degrees), np.array([0.0, 0, -1])
        turned = math.cos(a) * g + math.sin(a) * np.cross(unit, g) + (1 - math.cos(a)) * (unit @ g) * unit
        x, y = H / 2 * turned[:2] / -turned[2]
        return min(B / 2 - abs(x), 0.25 - abs(y))

    assert found.stands == pytest.approx(brentq(inside, 1, 45), abs=1e-4)


@pytest.mark.parametrize("axis", ["w", (0, 0, 0), (1, 0), (1, np.nan, 0), ("a", 0, 0), (1, 0, 0, 0)])
def test_an_axis_is_a_letter_or_three_numbers(axis):
    with pytest.raises(InputError, match=r"axis is .*; it must be x, y, z or three numbers, not all zero"):
        tilt_limit(block(), axis)


def test_tilts_without_dilatancy_are_found_for_each_kind_of_joints():
    asm = block().with_(friction=0.3)
    found = tilt_limit(asm, "y", flow="coulomb")
    expected = math.degrees(math.atan(0.3))
    assert len(found.kinds) == 3
    for stands, falls in found.kinds:
        assert stands == pytest.approx(expected, abs=0.03)
        assert 0 < falls - stands <= 1e-2
    assert found.stands == max(stands for stands, _ in found.kinds)
    assert found.least[0] == min(stands for stands, _ in found.kinds)


@pytest.mark.parametrize(("options", "width"), [({}, 1e-6), ({"width": 1e-3}, 1e-3), ({"flow": "coulomb"}, 1e-4)])
def test_the_least_friction_of_a_slope_is_its_tangent(options, width):
    found = friction_limit(block(gravity=(0.4, 0, -1)), top=1.0, **options)
    assert found.falls - 1e-9 <= 0.4 <= found.stands + 2e-4
    assert found.stands == pytest.approx(0.4, abs=width + 1e-4)
    assert 0 < found.stands - found.falls <= width
    assert (found.parameter, found.unit) == ("friction", "")
    assert len(found.kinds) == (3 if "flow" in options else 0)


def test_the_least_friction_is_of_the_gravity_and_the_loads_given():
    asm = block(gravity=(0.4, 0, -1))
    assert friction_limit(block(), gravity=(0.4, 0, -1), width=1e-3).stands == pytest.approx(0.4, abs=1e-3)
    push = point_load(asm, "block", (0.5, 0.25, 0.0), (-0.4, 0, 0))
    assert friction_limit(asm, loads=push / 2, width=1e-3).stands == pytest.approx(0.2, abs=1e-3)
    freed = friction_limit(asm, loads=push)
    assert (freed.stands, math.isnan(freed.falls)) == (0.0, True)


def test_friction_is_tried_from_the_least_that_means_something_to_the_most_asked_for():
    never = friction_limit(block(gravity=(0.6, 0, -1)))
    assert (math.isnan(never.stands), never.falls) == (True, 10.0)
    asm = block(gravity=(0.4, 0, -1))
    assert friction_limit(asm, top=0.39).falls == 0.39
    assert friction_limit(asm, top=0.41, width=1e-3).stands == pytest.approx(0.4, abs=1e-3)
    cohesive = block().with_(joints=[JointLaw(("*", "*"), cohesion=1.0)])
    assert friction_limit(cohesive).stands == 1e-3
    assert friction_limit(block().with_(joints=[JointLaw(("*", "*"), tension=1.0)])).stands == 0.0


def test_a_bracket_tells_both_sides_and_those_of_all_kinds():
    kinds = ((0.5, 0.4), (0.3, 0.2), (math.nan, 10.0))
    friction = Bracket(0.3, 0.2, "friction", "", kinds, worst="case")
    assert friction.least == kinds[2]
    lines = friction.explain().splitlines()
    assert lines == [
        BracketOutcome.LIMIT.value, "Worst case of the imperfections: case.", "Stable at a friction of 0.3.",
        "Not stable at a friction of 0.2.",
        "In stiff joints, elastic ones and both in one a Coulomb state is found down to 0.5, 0.3, none.",
    ]  # fmt: skip
    tilt = Bracket(30.0, 31.0, "tilt", "deg", ((30.0, 31.0), (20.0, 21.0), (math.nan, 0.0)))
    assert tilt.least == tilt.kinds[2] or math.isnan(tilt.least[0])
    assert tilt.explain().endswith("a Coulomb state is found up to 30, 20, none deg.")
    assert Bracket(30.0, 31.0, "tilt", "deg", ((30.0, 31.0), (20.0, 21.0))).least == (20.0, 21.0)
    plain = Bracket(1.0, math.nan)
    assert plain.least[0] == 1.0
    assert plain.explain().splitlines() == [
        BracketOutcome.ALWAYS_STANDS.value, "Stable at a parameter of 1.", DILATES,
    ]  # fmt: skip
    assert Bracket(math.nan, 2.0).explain().splitlines()[1] == "Not stable at a parameter of 2."
    assert friction.summary() == {
        "outcome": "limit", "sentence": BracketOutcome.LIMIT.value, "parameter": "friction", "unit": "", "stands": 0.3,
        "falls": 0.2, "imperfections": "case", "kinds": [[0.5, 0.4], [0.3, 0.2], [None, 10.0]],
        "warnings": [],
    }  # fmt: skip
    assert plain.summary()["imperfections"] is None


def two_supports():
    """A beam of 8 N on two supports a quarter and three quarters along it, and a third support that is apart."""
    blocks = [
        box((0, 0, -1), (0.5, 1, 0), name="left"), box((3.0, 0, -1), (3.5, 1, 0), name="right"),
        box((0, 0, 0), (4, 1, 2), name="beam"), box((9, 0, 0), (10, 1, 1), name="apart"),
    ]  # fmt: skip
    return assembly(blocks, supports=["left", "right", "apart"], friction=0.5)


def test_reactions_of_a_beam_follow_from_moments_about_the_corners_of_its_supports():
    asm = two_supports()
    for supports in (["right"], ["left"]):
        found = thrust_range(asm, supports, (0, 0, -3))
        # Least on the right: right reaction at 3.5 from its mate at .5; most: at 3 from 0.
        ends = [8 * (2 - a) / (b - a) if supports == ["right"] else 8 * (b - 2) / (b - a)
                for a in (0.0, 0.5) for b in (3.0, 3.5)]  # fmt: skip
        assert (found.least, found.greatest) == pytest.approx((min(ends), max(ends)), rel=1e-6)
    both = thrust_range(asm, ["left", "right", "apart"], (0, 0, -1))
    assert (both.least, both.greatest) == pytest.approx((8, 8), rel=1e-6)
    assert thrust_range(asm, ["apart"], (0, 0, -1)).greatest == pytest.approx(0.0, abs=1e-9)
    sideways = thrust_range(asm, [0], (1, 0, 0))
    # Friction .5 of what the left carries at most, against the same of the right.
    assert sideways.greatest == pytest.approx(-thrust_range(asm, ["right"], (1, 0, 0)).least, rel=1e-6)
    load = point_load(asm, "beam", (4, 0.5, 2), (0, 0, -1.0))
    more = thrust_range(asm, ["right"], (0, 0, -1), loads=load)
    ends = [(8 * (2 - a) + (4 - a)) / (b - a) for a in (0.0, 0.5) for b in (3.0, 3.5)]
    assert (more.least, more.greatest) == pytest.approx((min(ends), max(ends)), rel=1e-6)
    assert more.least_forces.shape == more.greatest_forces.shape == (more.interfaces.n_points, 3)


def test_a_wedged_block_is_pressed_without_end():
    blocks = [
        box((-1, 0, 0), (0, 1, 1), name="left"), box((0, 0, 0), (1, 1, 1), name="block"),
        box((1, 0, 0), (2, 1, 1), name="right"), box((0, 0, -1), (1, 1, 0), name="floor"),
    ]  # fmt: skip
    asm = assembly(blocks, supports=["left", "right", "floor"], friction=0.5)
    found = thrust_range(asm, ["left"], (-1, 0, 0))
    assert found.least == pytest.approx(0.0, abs=1e-6)
    assert found.greatest == np.inf
    assert found.outcome.word == "unbounded"
    assert found.summary()["greatest"] is None
    assert found.summary()["least"] == pytest.approx(0.0, abs=1e-6)


def test_supports_of_a_thrust_are_supports():
    asm = two_supports()
    assert support_indices(asm, ["apart", 0]).tolist() == [3, 0]
    with pytest.raises(InputError, match='supports: "beam" is no support; supports are: left, right, apart'):
        support_indices(asm, ["left", "beam"])
    with pytest.raises(InputError, match="direction"):
        thrust_range(asm, ["left"], (0, 0, 0))
    with pytest.raises(InputError, match='"assembly" does not stand as it is; this is asked of what stands'):
        thrust_range(asm, ["left"], (0, 0, -1), gravity=(5, 0, -1))
    many = assembly([box((2 * k, 0, 0), (2 * k + 1, 1, 1), name=f"s{k}") for k in range(10)], supports=range(9))
    with pytest.raises(InputError, match=r"supports are: s0, s1, s2, s3, s4, s5, s6, s7$"):
        support_indices(many, ["s9"])


def test_a_thrust_and_a_domain_tell_their_ends():
    asm = two_supports()
    made = ThrustRange(1.0, 2.5, np.zeros((1, 3)), np.zeros((1, 3)), find_interfaces(asm), asm, ("w",))
    assert made.explain().splitlines()[1:] == ["1 N <= thrust <= 2.5 N", "Warning: w"]
    assert (made.summary()["least"], made.summary()["greatest"], made.summary()["blocks"]) == (1.0, 2.5, 4)
    domain = LoadDomain(np.array([(0.0, -1.0), (2.0, 0.5), (-3.0, 4.0)]), np.ones((5, 3)))
    assert domain.explain().splitlines()[1:] == [
        "Inner polygon: 3 corners, x from -3 to 2, y from -1 to 4.", "Outer polygon: 5 half-planes.",
    ]  # fmt: skip
    assert domain.summary()["inner"] == [[0.0, -1.0], [2.0, 0.5], [-3.0, 4.0]]


def test_the_domain_of_two_pushes_is_the_diamond_of_a_block_that_tips():
    """Foot of 1 x .5, height 2: |x| <= .5 and |y| <= .25 tip about an edge, with no friction in the way."""
    asm = block().with_(friction=9.0)
    found = load_domain(asm, (1, 0, 0), 2 * acceleration(asm, (0, 1, 0)), directions=8)
    assert found.inner.shape == (8, 2)
    assert found.outer.shape == (8, 3)
    for k, (x, y) in enumerate(found.inner):
        angle = 2 * np.pi * k / 8
        reach = min(0.5 / max(abs(np.cos(angle)), 1e-12), 0.125 / max(abs(np.sin(angle)), 1e-12))
        assert (x, y) == pytest.approx((reach * np.cos(angle), reach * np.sin(angle)), abs=1e-6)
        a, b, c = found.outer[k]
        assert a * x + b * y == pytest.approx(c, rel=1e-5)
        assert (found.outer[:, :2] @ (x, y) <= found.outer[:, 2] * (1 + 1e-6)).all()
    with pytest.raises(InputError, match=r"along \(-?\d.*\): Unbounded"):
        load_domain(asm, (1, 0, 0), (0, 0, -1), directions=4)
    with pytest.raises(InputError, match="directions is 2; it must be a whole number of at least 3"):
        load_domain(asm, (1, 0, 0), (0, 1, 0), directions=2)
    assert len(load_domain(asm, (1, 0, 0), (0, 1, 0), directions=3).inner) == 3
    for two in ((3, 0, 0), (-1, 0, 0), (1, 1e-6, 0)):
        with pytest.raises(InputError, match="the two loads are the same but for their size"):
            load_domain(asm, (1, 0, 0), two)
    tilted = load_domain(asm, (1, 0, 0), (0, 1, 0), directions=4, gravity=(0, 0, -2), friction=0.2)
    assert np.abs(tilted.inner).max() == pytest.approx(0.2, rel=1e-4)


@pytest.mark.parametrize(("changes", "outcome"), [
    ({}, Outcome.UNDECIDED), ({"imbalance": 0.0, "cone_violation": FORCE_TOLERANCE}, Outcome.STABLE),
    ({"imbalance": 0.0, "cone_violation": 1.1 * FORCE_TOLERANCE}, Outcome.UNDECIDED),
    ({"imbalance": 0.0, "cone_violation": 0.0, "total_force": 1.1 * FORCE_LIMIT}, Outcome.UNDECIDED),
    ({"work": 1.0, "required_force": FORCE_LIMIT}, Outcome.UNSTABLE),
    ({"work": WORK_ROUNDING, "required_force": np.inf}, Outcome.UNDECIDED),
    ({"imbalance": 0.0, "cone_violation": 0.0, "work": 1.0, "required_force": np.inf}, Outcome.UNDECIDED),
])  # fmt: skip
def test_a_certificate_that_proves_both_sides_proves_neither(changes, outcome):
    nothing = Certificate(1.0, 1.0, 0.0, 0.0, 0.0, imbalance=1.0, total_force=1.0)
    assert outcome_of(replace(nothing, **changes)) is outcome


def program_of(asm, **options):
    given = {"friction": None, "gravity": None, "loads": None, "gap": 0.01, "interfaces": None}
    return pose(asm, **(given | options))


def test_bounds_of_a_multiplier_are_those_of_the_fields_and_mechanisms_given():
    problem = program_of(block().with_(friction=9.0))
    program, load = problem.program, problem.scaled(acceleration(problem.assembly, (1, 0, 0)))
    dead = decide(program, solve_penalty(program, stands=True)).force
    found = limit_load(problem.assembly, (1, 0, 0), optimum=True)
    twist = np.zeros(6)
    # It tips about the edge at x = 1: its centroid is .5 beside and 1 above.
    twist[:] = 1.0, 0, 0.5, 0, problem.program.length_unit, 0
    high = upper_bound(program, load, twist, dead)
    assert high.value == pytest.approx(0.5, rel=1e-6)
    assert load @ high.evidence == pytest.approx(1.0)
    lazy = twist.copy()
    lazy[2] = 0.8  # it rises more than it must: an upper bound, but not the limit
    assert upper_bound(program, load, lazy, dead).value >= 0.5 * (1 - 1e-9)
    assert upper_bound(program, load, -twist, dead) is None or upper_bound(program, load, -twist, dead).value >= 0.5
    points = found.forces / program.force_unit
    low = lower_bound(program, load, points, 0.5, dead)
    assert low.value == pytest.approx(0.5, rel=1e-6)
    assert low.value <= 0.5
    assert lower_bound(program, load, points, 0.6, dead) is None or lower_bound(
        program, load, points, 0.6, dead
    ).value <= 0.5 * (1 + 1e-9)
    zero = lower_bound(program, load, dead, 0.0, dead)
    assert zero.value == 0.0


def tipping():
    """The program of a block that tips, a push towards +x, and forces that balance its weight."""
    problem = program_of(block().with_(friction=9.0))
    load = problem.scaled(acceleration(problem.assembly, (1, 0, 0)))
    return problem, load, decide(problem.program, solve_penalty(problem.program, stands=True)).force


@pytest.mark.parametrize("scale", [0.05, 1.0, 20.0])
def test_a_mechanism_that_closes_a_joint_is_corrected_whatever_its_size(scale):
    problem, load, dead = tipping()
    unit = problem.program.length_unit
    for rise in (0.5, 0.499, 0.48):  # it must rise by half of what it moves aside
        twist = scale * np.array([1.0, 0, rise, 0, unit, 0])
        found = upper_bound(problem.program, load, twist, dead, motions=problem.motions)
        assert found.value == pytest.approx(0.5, rel=1e-6)
        assert load @ found.evidence == pytest.approx(1.0)
        rate = (problem.program.matrix.T @ found.evidence).reshape(-1, 3)
        assert (rate[:, 0] - 9.0 * np.hypot(rate[:, 1], rate[:, 2]) >= -1e-8 * np.abs(rate).max()).all()
    assert upper_bound(problem.program, load, 0 * twist, dead) is None


def test_verdicts_on_single_multipliers_narrow_a_bracket():
    problem, load, dead = tipping()
    ends = Bound(0.0, dead), Bound(np.inf, np.zeros(6))
    low, high, spent = narrowed(problem.program, load, *ends, tolerance=1e-2, most=1e5, motions=problem.motions)
    assert low.value <= 0.5 * (1 + 1e-9)
    assert high.value >= 0.5 * (1 - 1e-9)
    assert high.value - low.value <= 1e-2 * high.value
    assert spent > 0


def test_verdicts_are_asked_for_inside_the_bracket_as_long_as_they_tell_nothing(monkeypatch):
    problem, load, dead = tipping()
    ends, tried, solve = (Bound(0.2, dead), Bound(0.8, np.zeros(6))), [], decision.solve_penalty

    def noted(program, **options):
        tried.append((program.load - problem.program.load) @ load / (load @ load))
        return solve(program, **options)

    monkeypatch.setattr(decision, "solve_penalty", noted)
    monkeypatch.setattr(decision, "outcome_of", lambda certificate: Outcome.UNDECIDED)
    monkeypatch.setattr(decision, "_proven", lambda *_: None)
    narrowed(problem.program, load, *ends, tolerance=1e-2, most=1e5, motions=problem.motions)
    assert tried == pytest.approx([0.5, 0.35, 0.65])


def test_a_bracket_that_is_narrow_is_left_alone():
    problem, load, dead = tipping()
    ends = Bound(0.4996, dead), Bound(0.5001, np.zeros(6))
    assert narrowed(problem.program, load, *ends, tolerance=1e-2, most=1e5) == (*ends, 0)


def test_no_multiplier_beyond_the_most_is_tried():
    problem, _, dead = tipping()
    down = problem.scaled(acceleration(problem.assembly, (0, 0, -1)))
    ends = Bound(0.0, dead), Bound(np.inf, np.zeros(6))
    low, high, _ = narrowed(problem.program, down, *ends, tolerance=1e-3, most=300.0)
    assert (low.value, high.value) == (300.0, np.inf)
    low, high, _ = narrowed(problem.program, down, *ends, tolerance=1e-3, most=0.5)
    assert (low.value, high.value) == (0.5, np.inf)


def light_and_heavy():
    """A cube of a billionth of another's density beside it, on a slope of .2."""
    blocks = [
        GROUND, box((0, 0, 0), (1, 1, 1), name="heavy", density=1.0),
        box((3, 0, 0), (4, 1, 1), name="light", density=1e-9),
    ]  # fmt: skip
    return assembly(blocks, gravity=(0.2, 0, -1), friction=0.5)


def test_light_blocks_beside_heavy_ones_are_balanced_in_their_own_units():
    program = program_of(light_and_heavy()).program
    answer = solve_margin_locally(program)
    force = answer.force.reshape(-1, 3)
    for index in range(2):
        rows = slice(6 * index, 6 * index + 6)
        out = (program.matrix @ force.reshape(-1) + program.load)[rows]
        assert np.abs(out).max() <= 1e-6 * np.abs(program.load[rows]).max()
    assert (np.hypot(force[:, 1], force[:, 2]) <= 0.5 * force[:, 0] + 1e-6 * np.abs(force).max(axis=1)).all()


def test_light_blocks_beside_heavy_ones_are_judged():
    asm = light_and_heavy()
    assert assess(asm).outcome is Outcome.STABLE
    assert assess(asm, friction=0.19).outcome is Outcome.UNSTABLE


def test_bounds_of_an_answer_hold_each_other():
    problem = program_of(block().with_(friction=9.0))
    load = problem.scaled(acceleration(problem.assembly, (1, 0, 0)))
    dead = decide(problem.program, solve_penalty(problem.program, stands=True)).force
    low, high = proven_bounds(problem.program, load, limit_answer(problem), dead, motions=problem.motions)
    assert low.value <= high.value * (1 + 1e-9)
    assert (low.value, high.value) == pytest.approx((0.5, 0.5), rel=1e-6)


def limit_answer(problem):
    from blockstat.program.conic import conic_program
    from blockstat.solve.dispatch import solve

    load = problem.scaled(acceleration(problem.assembly, (1, 0, 0)))
    return solve(conic_program(problem.program, -problem.program.load, pinned=load))


@pytest.mark.parametrize("solver", ["interior-point", "clarabel", "cvxpy"])
def test_the_missing_adhesion_is_the_same_by_every_solver(solver):
    asm = block(gravity=(0.8, 0, -0.5))
    found = assess(asm, solver=solver)
    assert found.outcome is Outcome.UNSTABLE
    assert found.score > 0
    assert found.score == pytest.approx(assess(asm).score, rel=1e-4)


def test_what_follows_the_reference_is_solved_by_another_solver():
    # The reference solves the penalty program alone; a Coulomb state is not asked of it.
    solvers = ("auto", "clarabel", "interior-point", "cvxpy")
    assert [_second(solver) for solver in solvers] == ["auto", "clarabel", "interior-point", "clarabel"]
    found = assess(block(), solver="cvxpy", flow="coulomb")
    assert found.outcome is Outcome.STABLE
    assert found.coulomb.settles is True


def test_random_tightnesses_are_tried_where_they_are_asked_for_only():
    problem = program_of(block())
    for flow in ("coulomb", "associated"):
        assert judged(problem, flow=flow).outcome is Outcome.STABLE
    assert math.isnan(judged(problem, flow="coulomb").coulomb.tightness)
    assert judged(problem, flow="coulomb", tightnesses=1).coulomb.tightness == 1.0
    assert judged(problem, tightnesses=1).coulomb is None


def test_a_block_in_the_air_falls_whatever_state_the_others_have():
    lost, stone = box((4, 0, 3), (5, 1, 4), name="lost"), box((0, 0, 1), (1, 1, 2), name="block")
    walls = [box((-1, 0, 0), (0, 1, 3), name="left"), box((1, 0, 0), (2, 1, 3), name="right")]
    stands, wedged = [GROUND, box((0, 0, 0), (1, 1, 1), name="block")], [GROUND, *walls, stone]
    fixed = ["ground", "left", "right"]
    for blocks, supports, others in (
        (stands, ["ground"], Outcome.STABLE), (wedged, fixed, Outcome.STABLE_ONLY_BY_SELF_STRESS),
    ):  # fmt: skip
        without, asm = (assembly(given, supports=supports, friction=0.5) for given in (blocks, [*blocks, lost]))
        assert judged(program_of(without), flow="coulomb").outcome is others
        found = judged(program_of(asm), flow="coulomb")
        assert (found.outcome, found.coulomb, found.flow) == (Outcome.UNSTABLE, None, "coulomb")
        assert found.certificate.work > 0
        assert found.certificate.required_force == found.score == np.inf
        assert found.floating.tolist() == [len(blocks)]


def test_a_loose_bracket_ends_the_solve_on_the_way():
    options = {"solver": "interior-point", "tolerance": 0.1}
    early, whole = (limit_load(block(), (1, 0, 0), optimum=optimum, **options) for optimum in (False, True))
    assert early.outcome is whole.outcome is LoadOutcome.LIMIT
    assert early.iterations < whole.iterations
    for found in (early, whole):
        assert found.lower <= 0.5 * (1 + 1e-6)
        assert found.upper >= 0.5 * (1 - 1e-6)
        assert found.upper - found.lower <= 0.1 * found.upper


def pulled_apart(excess):
    """A quarter of the weight at each corner, two of which also pull at each other by a share beyond friction."""
    problem = program_of(block())
    force = np.zeros((4, 3))
    force[:, 0] = 0.25
    points, frame = problem.interfaces.point, problem.interfaces.frame[0]
    pull = 0.7 * 0.25 * (1 + excess) * frame @ (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
    force[:2] += pull, -pull
    return problem, force


@pytest.mark.parametrize("multiplier", [0.0, 0.5, 4.0])
@pytest.mark.parametrize(("beyond", "unbounded"), [(-0.5, True), (0.5, True), (3.0, False)])
def test_what_forces_carry_but_for_rounding_is_without_bound(beyond, unbounded, multiplier):
    """Forces s times too large for their cones beside those with a slack of one carry the share 1 / s of the most."""
    problem, ray = pulled_apart((1 + beyond * ROUNDING) / UNBOUNDED)
    dead = pulled_apart(-1.0)[1]
    down = problem.scaled(acceleration(problem.assembly, (0, 0, -1)))
    answer = replace(solve_penalty(problem.program), force=ray * (multiplier or 1.0), multiplier=multiplier)
    on_the_way = LimitBracket(problem.program, down, dead, 1e-3, problem.motions)
    word, lower, upper, force = _beyond_bounds(on_the_way, answer, dead, 2.0)
    assert force is (dead if unbounded else on_the_way.force)
    assert upper == np.inf
    if unbounded:
        assert (word, lower) == (LoadOutcome.UNBOUNDED, np.inf)
    else:
        assert word is LoadOutcome.UNDECIDED
        assert lower == pytest.approx(UNBOUNDED / 2, rel=1e-8)
        assert lower < (1 - ROUNDING) * UNBOUNDED / 2


@pytest.mark.parametrize(("lean", "settles"), [(0.2, True), (0.6, False)])
def test_forces_outside_their_cones_are_pressed_in_where_that_proves_a_stand(lean, settles):
    problem = program_of(block(gravity=(lean, 0, -1)))
    answer = replace(
        solve_penalty(problem.program), status=Status.ACCEPTED, force=pulled_apart(0.2)[1], twist=np.zeros(6)
    )
    given = _checked(problem.program, answer, problem.motions)
    assert not given.certificate.proves_stable
    assert (given.force == answer.force).all()
    found = _checked(problem.program, answer, problem.motions, lambda twist: twist)
    assert found.certificate.proves_stable is settles
    if settles:
        out = problem.program.matrix @ found.force.reshape(-1) + problem.program.load
        assert np.abs(out).max() <= 1e-12
        assert (np.hypot(found.force[:, 1], found.force[:, 2]) <= 0.7 * found.force[:, 0] + 1e-12).all()
    else:
        assert (found.force == answer.force).all()


def test_a_limit_counts_where_something_moves_whatever_an_edge_along_an_edge_carries():
    """Cubes slide at their friction; one of them would be driven into the edge of a fixed one."""
    blocks = [
        GROUND, box((1, 0, 1), (2, 1, 2), name="high"), box((1.4, -2, 0.5), (3, 3, 1), name="shelf"),
        box((0, 0, 0), (1, 1, 1), name="low"),
    ]  # fmt: skip
    free = box((-4, 0, 0), (-3, 1, 1), name="free")
    for others, limit, falls, upper in (
        ([], LoadOutcome.UNDECIDED, LoadOutcome.UNDECIDED, np.inf),
        ([free], LoadOutcome.LIMIT, LoadOutcome.DEAD_LOAD_UNSTABLE, 0.3),
    ):
        asm = assembly([*blocks, *others], supports=["ground", "high", "shelf"], friction=0.3)
        push = acceleration(asm, (1, 0, 0))
        found = limit_load(asm, push)
        assert (found.outcome, found.upper) == (limit, pytest.approx(upper, rel=1e-6))
        assert found.lower == pytest.approx(0.3, rel=1e-6)
        lost = limit_load(asm.with_(gravity=(0.4, 0, -1)), push)
        assert (lost.outcome, lost.lower, lost.upper) == (falls, -np.inf, -np.inf if others else np.inf)
        for answer in (found, lost):
            told = [text for text in answer.warnings if '"high" and "low" touch only edge along edge' in text]
            assert bool(told) is not bool(others)
            if others:
                assert answer.mechanism[3] == pytest.approx(np.zeros(6), abs=1e-6)
                assert answer.mechanism[4, 0] > 0


@pytest.mark.parametrize("n", [5, 6, 12])
def test_blocks_that_touch_nothing_are_counted_beyond_the_first_five(n):
    lost = [box((2 * k, 0, 5), (2 * k + 1, 1, 6), name=f"lost{k}") for k in range(n)]
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="stands"), *lost])
    told = [text for text in program_of(asm).warnings if "more blocks touch nothing" in text]
    assert told == ([f"{n - 5} more blocks touch nothing"] if n > 5 else [])


def test_a_load_is_measured_by_its_forces_and_couples_in_weights():
    program = program_of(block()).program
    for load, size in (((3.0, 4, 12, 0, 0, 0), 13.0), ((0, 0, -8, 4, 1, 0), 9.0), ((0, 0, 0, 2.0, -3, 6), 7.0)):
        scaled, unit = as_strong_as_the_weight(program, np.array(load))
        assert unit == pytest.approx(size / program.total_load)
        np.testing.assert_allclose(scaled * unit, load)


@pytest.mark.parametrize("solver", ["auto", "clarabel", "interior-point", "cvxpy"])
def test_cvxpy_is_asked_where_it_is_named_and_nowhere_else(solver, monkeypatch):
    asked, on_paper = [], assessing.solve_on_paper
    monkeypatch.setattr(assessing, "solve_on_paper", lambda program: asked.append(1) or on_paper(program))
    assert assess(block(), solver=solver).outcome is Outcome.STABLE
    assert bool(asked) is (solver == "cvxpy")


@pytest.mark.parametrize(("width", "outcome"), [(99999.5, LoadOutcome.LIMIT), (100000.5, LoadOutcome.UNBOUNDED)])
def test_a_load_of_a_hundred_thousand_weights_counts_as_carried_without_bound(width, outcome):
    # A slab of a metre in height that does not slide turns over its edge at its width in weights.
    ground = box((-1, -1, -1), (width + 1, 2, 0))
    found = limit_load(assembly([ground, box((0, 0, 0), (width, 1, 1))], friction=np.inf), (1, 0, 0))
    assert found.outcome is outcome
    if outcome is LoadOutcome.LIMIT:
        assert (found.lower, found.upper) == pytest.approx((width, width), rel=1e-8)


def test_an_optimum_follows_where_the_bracket_does_not_close_on_the_way(monkeypatch):
    wall = running_bond(9, 12)
    plain = limit_load(wall, (0, 1, 0))
    monkeypatch.setattr(LimitBracket, "closed", property(lambda self: False))
    found = limit_load(wall, (0, 1, 0))
    assert found.outcome is plain.outcome is LoadOutcome.LIMIT
    assert found.iterations > plain.iterations
    assert found.upper - found.lower <= plain.upper - plain.lower
    assert plain.lower * (1 - 1e-9) <= found.lower <= found.upper <= plain.upper * (1 + 1e-9)


def test_a_bound_that_is_proven_beyond_a_hundred_thousand_weights_is_none(monkeypatch):
    problem, _, dead = tipping()
    direction = acceleration(problem.assembly, (1, 0, 0))
    proven = Bound(UNBOUNDED, dead), None
    monkeypatch.setattr("blockstat.analysis.limit_load.proven_bounds", lambda *args, **options: proven)
    word, lower, upper, force, twist, _ = bracket(problem, dead, direction, "auto")
    assert (word, lower, upper) == (LoadOutcome.UNBOUNDED, np.inf, np.inf)
    np.testing.assert_array_equal(force, dead)
    assert not twist.any()


def test_a_field_near_an_extreme_is_mixed_with_as_little_as_it_takes():
    problem, _, dead = tipping()
    outside = dead.copy()
    outside[0, 1] += 20.0 * np.abs(dead).max()  # beyond the cone of its point, and balanced by no other
    assert admissible(problem.program, dead, dead) is not None
    assert admissible(problem.program, outside, outside) is None


def test_a_mechanism_that_closes_bounds_by_ten_times_the_forces_of_the_lower_bound():
    problem, load, dead = tipping()
    program, unit = problem.program, problem.program.length_unit
    twist = np.array([1.0, 0, 0.45, 0, unit, 0])  # it must rise by .5 of what it moves aside
    closing = -(program.matrix.T @ twist).reshape(-1, 3)[:, 0].min()
    assert closing > 0
    total = np.sqrt((dead**2).sum(axis=1)).sum()
    most = closing * 10.0 * total
    rate = (program.matrix.T @ twist).reshape(-1, 3)
    lack = np.maximum(-(rate[:, 0] - 9.0 * np.hypot(rate[:, 1], rate[:, 2])), 0.0).max()
    expected = (lack * 10.0 * total - program.load @ twist) / (load @ twist)
    found = _bound_by(program, load, twist, Bound(0.0, dead))
    assert found.value == pytest.approx(expected)
    assert expected >= (most - program.load @ twist) / (load @ twist)


def test_iterations_are_those_of_the_dead_load_and_of_the_multiplier():
    wall = running_bond(9, 12)
    problem = program_of(wall)
    direction = acceleration(wall, (0, 1, 0))
    dead = decide(problem.program, solve_penalty(problem.program, stands=True), motions=problem.motions)
    alone = bracket(problem, dead.force, direction, "auto")
    found = limit_load(wall, (0, 1, 0))
    assert isinstance(found.iterations, int)
    assert found.iterations == dead.iterations + alone[-1]
    # Unless the optimum is asked for, a bracket ends as soon as it is narrow.
    assert alone[-1] < bracket(problem, dead.force, direction, "auto", optimum=True)[-1]
    # Twice the load is carried half as often.
    double = limit_load(wall, 2 * acceleration(wall, (0, 1, 0)))
    assert (2 * double.lower, 2 * double.upper) == pytest.approx((found.lower, found.upper), rel=1e-4)


def test_a_block_whose_weight_is_lifted_is_balanced_in_units_of_the_others():
    pair = assembly([GROUND, box((0, 0, 0), (1, 1, 1)), box((3, 0, 0), (4, 1, 1))])
    program = program_of(pair).program
    program = replace(program, load=program.load * np.repeat([1.0, 0.0], 6))
    answer = solve_margin_locally(program)
    assert np.isfinite(answer.force).all()
    assert np.isfinite(answer.twist).all()
    np.testing.assert_allclose(program.matrix @ answer.force.reshape(-1), -program.load, atol=1e-6)


@pytest.mark.parametrize("lean", [0.505, 0.6])
def test_a_mechanism_that_closes_a_little_is_opened_by_a_motion_that_opens_all_joints(lean):
    # A block that tips at .5 turns about its edge; told too flat by a ten-thousandth, it would need forces to resist.
    problem = program_of(block(gravity=(lean, 0, -1)))
    flat = np.array([1.0, 0, 0.5 - 1e-4, 0, problem.program.length_unit, 0])
    answer = replace(solve_penalty(problem.program), status=Status.ACCEPTED, twist=flat, interior=None)
    alone = _checked(problem.program, answer, lambda: ())
    assert alone.certificate.required_force < FORCE_LIMIT
    assert not alone.certificate.proves_unstable
    found = _checked(problem.program, answer, problem.motions)
    assert found.certificate.proves_unstable
    assert np.abs(found.twist - flat).max() < 1e-3


def test_two_neighbouring_values_are_printed_with_the_digits_that_tell_them_apart():
    lines = Bracket(12.58472081234, 12.58472081239, "tilt", "deg").explain().splitlines()
    assert lines[1:3] == ["Stable at a tilt of 12.5847208123 deg.", "Not stable at a tilt of 12.5847208124 deg."]
