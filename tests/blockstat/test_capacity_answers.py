"""What a capacity curve refuses, what it is controlled by, and what it tells of its points and events."""

from dataclasses import replace
from itertools import islice, permutations

import numpy as np
import pytest

from blockstat import Assembly, InputError, JointLaw, capacity, nonlinear_check
from blockstat.large_displacement.finite_steps.follower import StepFollower
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.path import PathEnd, PathEvent
from evidence.dynamics.capacity import portal
from evidence.scenes.small import assembly, box, running_bond, u_wall

ALONG = (1.0, 0.0, 0.0)
TOP = (0.25, 0.5, 2.0)
FOOT = (0.25, 0.5, 0.0)


def block(**options):
    """A block of weight 1, which turns about its toe at 1/4."""
    ground = box((-3, -3, -1), (4, 4, 0), name="ground", group="ground")
    return assembly([ground, box((0, 0, 0), (0.5, 1, 2), name="block", group="wall")], **{"friction": 0.9} | options)


@pytest.fixture(scope="module")
def curve():
    return capacity(block(), ALONG, control="block", steps=2, displacement=0.1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tolerance": 0.0}, r"tolerance is 0\.0; it must be above 0"),
        ({"tolerance": 0.2}, r"tolerance is 0\.2; it must be a number of at most 0\.1"),
        ({"tolerance": True}, "tolerance is True; it must be above 0"),
        ({"tolerance": "fine"}, "tolerance is 'fine'; it must be above 0"),
        ({"steps": 2.5}, "steps is 2.5; it must be a whole number"),
        ({"displacement": "far"}, "displacement is 'far'; it must be above 0"),
        ({"displacement": True}, "displacement is True; it must be above 0"),
        ({"interfaces": 3}, "interfaces is 3; it must be what find_interfaces returns"),
        ({"control": (None, (0, 0, 0))}, "control: None is neither a block's index nor its name"),
        ({"control": np.array([1, 2])}, r"control is array\(\[1, 2\]\); it must be a block, a group"),
        ({"control": ("block",)}, r"control is \('block',\); it must be a block, a group, a block and a point of it"),
        ({"control": ("block", TOP, 1.0)}, "it must be a block, a group, a block and a point of it, or mean"),
        ({"control": ("block", (0.25, 0.5, 2.1))}, r"the point \[0.25, 0.5, 2.1\] is not on block \"block\""),
        ({"control": ("ground", (0.0, 0.0, 0.0))}, 'of "ground" along the load does not move in the mechanism'),
        ({"load": [("block", TOP, ALONG), ("block", FOOT, (-1, 0, 0))]}, "the forces of the load have no resultant"),
        ({"load": [("block", TOP, ALONG), (1, 2, 3)]}, "loads: each must be a block, a point and a force"),
        ({"load": [(1, 0, 0), (1, 0, 0)]}, r"load has shape \(2, 3\); three numbers \(a direction\)"),
        ({"loads": [("block", TOP, ALONG), (1, 2, 3)]}, "loads: each must be a block, a point and a force"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_bad_options_of_a_curve_are_named(options, words):
    with pytest.raises(InputError, match=words):
        capacity(block(), options.pop("load", ALONG), **options)


@pytest.mark.parametrize("number", [np.float32, np.float64])
def test_numbers_of_any_kind_are_options_of_a_curve(number):
    asked = capacity(block(), ALONG, control="block", steps=2, displacement=number(0.125), tolerance=number(2**-10))
    plain = capacity(block(), ALONG, control="block", steps=2, displacement=0.125, tolerance=2**-10)
    assert asked.displacement[-1] == 0.125
    np.testing.assert_array_equal(asked.lower, plain.lower)
    assert capacity(block(), ALONG, control="block", steps=2, displacement=np.int64(1)).outcome.word == "zero"


def test_joints_that_crush_are_refused():
    crushing = block(joints=[JointLaw(("ground", "wall"), compression=100.0)])
    with pytest.raises(InputError, match="crush at their hinges, which is not followed"):
        capacity(crushing, ALONG)
    stiff = block(joints=[JointLaw(("ground", "wall"), friction=0.8)])
    assert capacity(stiff, ALONG, steps=1, displacement=0.01).lower[0] == pytest.approx(0.25)


def test_a_control_that_the_mechanism_moves_back_is_along_what_opposes_the_load():
    # About the toe a push of 1 at 2 m acts against 2 at the foot and a weight of 1 at 0.25 m: 1/8.
    forces = [("block", TOP, ALONG), ("block", FOOT, (-2.0, 0, 0))]
    curve = capacity(block(), forces, control="block", steps=1, displacement=0.01)
    assert curve.control == 'centroid of "block" against the load'
    assert [curve.lower[0], curve.upper[0]] == pytest.approx([0.125, 0.125], rel=1e-6)
    assert curve.displacement[-1] == pytest.approx(0.01)
    assert curve.points[-1].pose.displacement[1, 0] == pytest.approx(0.01)  # along x, and the resultant along -x
    along = capacity(block(), ALONG, control=("block", TOP), steps=1, displacement=0.01)
    assert along.control == 'point (0.25, 0.5, 2) of "block" along the load'


def test_dead_loads_are_forces_at_points_or_a_wrench_on_each_block():
    # A weight of 1 more in the centroid doubles the moment that resists; about its foot it does the same at rest.
    wrench = np.zeros((2, 6))
    wrench[1, 2] = -1.0
    own, more = (
        capacity(block(), ALONG, control="block", loads=loads, steps=1, displacement=0.05)
        for loads in (wrench, [("block", (0.25, 0.5, 1.0), (0.0, 0.0, -1.0))])
    )
    assert own.lower[0] == pytest.approx(0.5, rel=1e-6)
    np.testing.assert_allclose(own.at(0.05), more.at(0.05), rtol=1e-6)
    with pytest.raises(InputError, match="loads"):
        capacity(block(), ALONG, loads=np.zeros((3, 6)))


def test_a_curve_is_known_from_rest_to_its_largest_displacement(curve):
    assert curve.at(0.0) == (curve.lower[0], curve.upper[0])
    assert curve.at(0.1) == (curve.lower[-1], curve.upper[-1])
    for beyond in (-0.001, 0.101):
        with pytest.raises(InputError, match=rf"displacement is {beyond}; the curve is known from 0 to 0\.1 m"):
            curve.at(beyond)


def with_points(curve, *rows):
    """The curve with points of other displacement and multiplier."""
    points = tuple(replace(curve.points[0], displacement=d, lower=m, upper=m) for d, m in rows)
    return replace(curve, points=points)


def test_after_a_snap_back_the_last_passage_counts(curve):
    again = with_points(curve, (0.0, 0.4), (0.2, 0.3), (0.1, 0.2), (0.3, 0.0))
    assert again.at(0.2) == pytest.approx((0.1, 0.1))  # between (0.1, 0.2) and (0.3, 0)
    jump = with_points(curve, (0.0, 0.4), (0.2, 0.3), (0.2, 0.1), (0.4, 0.0))
    assert jump.at(0.2) == pytest.approx((0.1, 0.1))
    back = with_points(curve, (0.0, 0.4), (0.2, 0.3), (0.1, 0.1))  # the curve ends on its way back
    assert back.at(0.15) == pytest.approx((0.2, 0.2))
    assert back.at(0.2) == pytest.approx((0.3, 0.3))
    assert back.at(0.05) == pytest.approx((0.375, 0.375))


def test_events_are_told_with_what_opens_and_closes(curve):
    jump = PathEvent("jump", 0.05, 0.2, 0.125, (0,), ())
    end = PathEvent("closing", 0.07, 0.1, None, (), (0,))
    plain = PathEvent("change", 0.06, 0.2, 0.2, (), ())
    told = replace(curve, events=(jump, plain, end)).explain().splitlines()[3:]
    assert told[0].startswith("Jump at 0.05 m from 0.2: to 0.125 (opens ")
    assert told[1] == "Change at 0.06 m from 0.2: to 0.2."
    assert told[2].startswith("Closing at 0.07 m from 0.1: no admissible state follows (closes ")
    for line in (told[0], told[2]):
        assert "ground" in line
        assert "block" in line
    assert len(curve.explain().splitlines()) == 3


def test_an_interrupt_before_the_first_point_ends_the_call(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr("blockstat.large_displacement.capacity_analysis.follow_path", interrupted)
    with pytest.raises(KeyboardInterrupt):
        capacity(block(), ALONG)


def test_large_linkages_are_followed_by_sparse_equations_to_the_same_poses(monkeypatch):
    # The block turns about its toe: at a displacement d of its top corner the angle is asin(d / 2) at first.
    options = {"control": ("block", (0.5, 0.5, 2.0)), "steps": 4, "displacement": 0.2}
    dense = capacity(block(), ALONG, **options)
    monkeypatch.setattr("blockstat.large_displacement.displaced.velocity_rows.MAX_DENSE_UNKNOWNS", 0)
    found = capacity(block(), ALONG, **options)
    angle = np.arcsin(0.1)
    assert found.at(0.2) == pytest.approx([np.tan(np.arctan(0.25) - angle)] * 2, rel=1e-5)
    np.testing.assert_allclose(found.at(0.1), dense.at(0.1), rtol=1e-6)


def test_where_the_linkage_is_lost_finite_steps_go_on_to_the_same_multiplier(monkeypatch):
    # The diagonal from the toe to the centroid has the length sqrt(17) / 4: where that is 0.25 - d out, it is as high
    # as Pythagoras says.
    monkeypatch.setattr("blockstat.large_displacement.linkage.follower.MAX_STEPS", 3)
    curve = capacity(block(), ALONG, control="block", steps=10, displacement=0.2)
    assert curve.outcome.word == "reached"
    assert curve.at(0.2) == pytest.approx([0.05 / np.sqrt(17 / 16 - 0.05**2)] * 2, rel=1e-4)
    assert "no linkage from" in curve.warnings[0]


def test_a_curve_that_cannot_be_followed_is_lost_and_keeps_its_points(monkeypatch):
    monkeypatch.setattr("blockstat.large_displacement.linkage.follower.MAX_STEPS", 3)
    monkeypatch.setattr("blockstat.large_displacement.finite_steps.follower.MAX_STEPS", 2)
    curve = capacity(block(), ALONG, control="block", steps=10, displacement=0.2)
    assert curve.outcome.word == "lost"
    assert 0 < curve.displacement[-1] < 0.2
    assert curve.explain().startswith("Lost: the mechanism could not be followed any further")


def refused_after(items, follow):
    """A follower that comes to a pose with joints at fault after so many items."""

    def refused(*given):
        yield from islice(follow(*given), items)
        raise InputError("interfaces: at fault")

    return refused


@pytest.mark.parametrize("steps_too", [False, True])
def test_a_fault_on_the_way_keeps_the_curve_up_to_there(monkeypatch, steps_too):
    """The diagonal from the toe to the centroid is sqrt(17) / 4 long: Pythagoras gives the multiplier at each point."""
    monkeypatch.setattr(LinkageFollower, "follow", refused_after(4, LinkageFollower.follow))
    if steps_too:
        monkeypatch.setattr(StepFollower, "follow", refused_after(3, StepFollower.follow))
    curve = capacity(block(), ALONG, control="block", steps=10, displacement=0.2)
    out = 0.25 - curve.displacement
    np.testing.assert_allclose(curve.lower, out / np.sqrt(17 / 16 - out**2), rtol=1e-3)
    assert curve.outcome.word == ("lost" if steps_too else "reached")
    assert 0.04 < curve.displacement[-1] < 0.2 if steps_too else curve.displacement[-1] == pytest.approx(0.2)
    told = [text for text in curve.warnings if text.endswith("whose joints cannot be analysed: interfaces: at fault")]
    assert len(told) == 1 + steps_too


def test_a_fault_before_the_first_point_is_passed_on(monkeypatch):
    monkeypatch.setattr(LinkageFollower, "follow", refused_after(0, LinkageFollower.follow))
    with pytest.raises(InputError, match="interfaces: at fault"):
        capacity(block(), ALONG, control="block", steps=2, displacement=0.2)


def test_a_curve_of_joints_with_cells_is_refused():
    wall = running_bond(4, 4, joints=[JointLaw(("*", "*"), cells=4)])
    with pytest.raises(InputError, match="joints that are divided into cells are not followed as they open"):
        capacity(wall, (1, 0, 0))


def test_finite_steps_leave_no_contact_open():
    """All round the blocks of a wall joints overlap by rounding: no motion is inside all their inequalities."""
    curve = capacity(u_wall(5).with_(friction=0.6), (0, -1, 0), steps=10, displacement=1.0)
    assert curve.outcome.word == "reached"
    assert any("finite steps" in text for text in curve.warnings)
    assert not [text for text in curve.warnings if "open by up to" in text]


@pytest.mark.parametrize("steps", [10, 40])
def test_a_wall_in_its_plane_ends_where_it_does_with_other_steps(steps):
    """A contact closes on the way, after which the mechanism is no linkage: that is no collapse."""
    panel = running_bond(5, 3).with_(friction=0.65)
    curve, other = (capacity(panel, ALONG, steps=n) for n in (steps, 20))
    assert curve.outcome.word == other.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(other.displacement[-1], rel=1e-3)


def test_a_mixture_of_mechanisms_is_no_mechanism():
    """Where this arch on piers jumps, another mechanism carries the same, but not a little way on: it is not taken."""
    scene = portal(3.3671793841744355, 0.5249504754356459, 1.396302702379932, 1.05465206733624, 12)
    curves = [capacity(scene.with_(friction=0.66208934580), ALONG, control="mean", steps=n) for n in (20, 40, 80)]
    for curve in curves:
        assert [event.kind for event in curve.events] == [event.kind for event in curves[0].events]
        assert curve.outcome.word == "zero"
        assert curve.displacement[-1] == pytest.approx(curves[0].displacement[-1], rel=1e-5)


def overhanging_on_glue():
    """A cube of weight 1 that reaches .6 m beyond the ground: glue holds it, and without glue it tips at -.1/.5."""
    blocks = [box((-2, 0, -1), (0, 1, 0), name="ground"), box((-0.4, 0, 0), (0.6, 1, 1), name="block")]
    return assembly(blocks, friction=0.7, joints=[JointLaw(("*", "*"), tension=10.0)])


@pytest.mark.parametrize("by_steps", [False, True])
def test_a_curve_of_joints_that_hold_by_tension_alone_ends_at_rest(monkeypatch, by_steps):
    """The glue holds half of 10 x .4 at each end: alpha .5 + .1 = 2 x .4. It is gone when the joint opens."""
    if by_steps:
        monkeypatch.setattr(LinkageFollower, "follow", lambda *_: iter([PathEnd.LOST]))
    curve = capacity(overhanging_on_glue(), ALONG, steps=5)
    assert curve.limit.lower == pytest.approx(1.4, rel=1e-6)
    assert curve.displacement[-1] == 0.0
    assert curve.outcome.word == ("collapse" if by_steps else "zero")
    assert curve.lower[-1] == pytest.approx(1.4 if by_steps else -0.2, rel=1e-6)
    with pytest.raises(InputError, match="as soon as the mechanism moves the multiplier drops"):
        nonlinear_check(curve, ALONG)


@pytest.mark.parametrize("share", [0.001, 1.0, 20.0])
def test_a_block_that_its_load_lifts_hangs_on_it(share):
    """The multiplier times the load is the weight, and what hangs balances at any height."""
    lifted = block()
    force = share * lifted.free_weight
    curve = capacity(lifted, [("block", TOP, (0, 0, force))], displacement=0.1)
    assert curve.outcome.word == "reached"
    np.testing.assert_allclose(curve.lower, 1 / share, rtol=1e-6)
    assert (np.diff(curve.displacement) > 0).all()
    assert curve.displacement[[0, -1]] == pytest.approx([0, 0.1])
    np.testing.assert_allclose(curve.points[-1].pose.displacement[1], (0, 0, 0.1), atol=1e-9)


def test_a_curve_that_never_comes_to_zero_ends_where_nothing_is_left():
    """Pushed upwards, a block floats at its weight, however high."""
    lifted = block()
    curve = capacity(lifted, (0, 0, 1))
    assert curve.outcome.word == "reached"
    np.testing.assert_allclose(curve.lower, 1.0, rtol=1e-6)
    assert curve.displacement[-1] == pytest.approx(2 * np.ptp(lifted.vertices, axis=0).max())
    assert any("no displacement was asked for" in text for text in curve.warnings)


def test_forces_on_supports_are_no_part_of_what_the_control_is_along():
    against = [("block", TOP, ALONG), ("ground", (0, 0, -0.5), (-1, 0, 0))]
    curve = capacity(block(), against, steps=1, displacement=0.01)
    assert curve.lower[0] == pytest.approx(0.125, rel=1e-6)  # the weight .25 behind the toe, the force 2 above it
    with pytest.raises(InputError, match="the forces of the load have no resultant on free blocks"):
        capacity(block(), [("block", TOP, ALONG), ("block", FOOT, (-1, 0, 0)), ("ground", (0, 0, -0.5), ALONG)])


def test_a_path_whose_end_is_not_found_is_lost(monkeypatch):
    monkeypatch.setattr("blockstat.large_displacement.linkage.follower.MAX_STEPS", 3)
    monkeypatch.setattr("blockstat.large_displacement.finite_steps.follower.MAX_END_TRIALS", 0)
    curve = capacity(block(), ALONG, control="block", steps=10, displacement=0.2)
    assert curve.displacement[-1] < 0.2 - 1e-3
    assert curve.outcome.word == "lost"


MORTAR = [{"tension": 3e3}, {"cohesion": 1e3}, {"bond": 2e3}]


def mortared(law):
    """A slab of 1 m x 1 m x .4 m on mortar of a strength on the ground, friction .3."""
    blocks = [box((-3, -3, -1), (4, 3, 0), name="ground"), box((0, 0, 0), (1, 1, 0.4), name="s")]
    joints = [JointLaw(("*", "*"), friction=0.3, **law)]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.3, density=2000.0, joints=joints)


@pytest.mark.parametrize("law", MORTAR, ids=str)
def test_a_joint_that_dilates_loses_its_strength_as_it_slides(law):
    """With associated flow it is open by .3 of the slip: friction alone is left, .3 of the weight."""
    curve = capacity(mortared(law), ALONG, control="s", steps=3, displacement=0.6, flow="associated")
    np.testing.assert_allclose(curve.lower, 0.3, rtol=1e-6)
    np.testing.assert_allclose(curve.upper[1:], 0.3, rtol=1e-6)
    assert curve.upper[0] > 0.37
    assert curve.warnings == ()


@pytest.mark.parametrize("law", MORTAR, ids=str)
def test_strength_that_counts_although_its_joint_has_slid_is_told(law):
    """Without dilatancy the joint stays shut, and so the cohesion of 1 kN, beside .3 of 7848 N, counts to the end."""
    curve = capacity(mortared(law), ALONG, control="s", steps=3, displacement=0.6)
    expected = 0.3 + {"tension": 0.3 * 3e3, "cohesion": 1e3, "bond": 0.3 * 2e3}[next(iter(law))] / (0.4 * 2000 * 9.81)
    np.testing.assert_allclose(curve.lower, expected, rtol=1e-5)
    (warning,) = curve.warnings
    assert "slid by up to 600 mm counts in full" in warning
    assert '"ground" and "s"' in warning
    dry = capacity(mortared({}), ALONG, control="s", steps=3, displacement=0.6)
    assert dry.warnings == ()


@pytest.mark.parametrize("order", permutations(range(3)))
def test_a_wall_and_a_smooth_buttress_beside_it_tip_together_in_any_order(order):
    """Weights 1.5 and .84 by arms of .25 and .15, over the same by heights of 1.5 and 1.4.

    Both turn about their left edges at first. The lower corner of the wall goes to the left by a square of the turn, so
    the buttress may lean as far as tan(t / 2) only, t being the turn of the wall, and it is no linkage. Where the wall
    is over its edge, at .25, the buttress is far from its own, and does not press on it. Steps end within a half of a
    hundredth of that.
    """
    blocks = [
        box((-2, -1, -1), (4, 2, 0), name="ground"),
        box((0, 0, 0), (0.5, 1, 3), name="wall", group="wall"),
        box((0.5, 0, 0), (0.8, 1, 2.8), name="buttress", group="buttress"),
    ]
    smooth = [JointLaw(("wall", "buttress"), friction=0.0)]
    placed = [blocks[k] for k in order]
    scene = Assembly.from_blocks(placed, supports=["ground"], density=1.0, friction=2.0, joints=smooth)
    curve = capacity(scene, (-1, 0, 0), control="wall")
    assert curve.lower[0] == pytest.approx((1.5 * 0.25 + 0.84 * 0.15) / (1.5 * 1.5 + 0.84 * 1.4), rel=1e-4)
    assert curve.outcome.word == "zero"
    assert any("finite steps" in text for text in curve.warnings)
    assert curve.displacement[-1] == pytest.approx(0.25, rel=5e-3)
