"""Capacity curves against closed forms and against linkages followed by Newton's method to 1e-14.

One twist: alpha = tan(B - th). Sliding over an edge: the resultant stays in what is left of the bed. Two blocks: exact
kinematics. Arches and portals: four-bar linkages with their thrust checked at every joint, and jumps at constant mean
displacement when the thrust leaves.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from blockstat import Assembly, Block, InputError, JointLaw, Tie, box, capacity, model, settle_to_collapse
from blockstat.large_displacement.linkage.follower import LinkageFollower
from blockstat.large_displacement.linkage.path import PathEnd
from blockstat.model import assemble
from evidence.references.linkages import ARCHES, PORTALS
from evidence.scenes.small import running_bond

WITHIN = 1e-3


def assembled(blocks, *, supports=("ground",), friction=0.9, **more):
    return Assembly.from_blocks(blocks, supports=supports, friction=friction, density=1 / 9.81, **more)


GROUND = box((-9, -5, -1), (9, 5, 0), name="ground", group="ground")


def block(width, height, **more):
    return assembled([GROUND, box((0, 0, 0), (width, 1, height), name="block")], **more)


def voussoirs(number, thickness, radius=1.0):
    angle = np.linspace(np.pi, 0, number + 1)
    faces = [[3, 2, 1, 0], [4, 5, 6, 7], [1, 5, 4, 0], [2, 6, 5, 1], [3, 7, 6, 2], [0, 4, 7, 3]]
    for k in range(number):
        corners = [(radius - thickness / 2, k), (radius + thickness / 2, k)]
        corners += [(radius + thickness / 2, k + 1), (radius - thickness / 2, k + 1)]
        ring = [(r * np.cos(angle[j]), r * np.sin(angle[j])) for r, j in corners]
        yield Block([(x, y, z) for y in (0, 1) for x, z in ring], faces, name=f"voussoir {k}")


def arch(number, thickness, friction=0.7):
    feet = [box((x - 0.3, 0, -0.3), (x + 0.3, 1, 0), name=name) for x, name in ((-1, "left"), (1, "right"))]
    return assembled([*voussoirs(number, thickness), *feet], supports=("left", "right"), friction=friction)


def portal(width, height):
    feet = [(-2.25 - width, -2.25, "left"), (2.25, 2.25 + width, "right")]
    piers = [box((x0, 0, -height), (x1, 1, 0), name=name) for x0, x1, name in feet]
    ground = box((-9, -1, -height - 1), (9, 2, -height), name="ground")
    return assembled([ground, *voussoirs(20, 0.5, 2.5), *piers], friction=0.7)


def follows(curve, displacement, multiplier, within=WITHIN):
    """Whether the bracket is at the given multipliers, relative to the first one, and closed."""
    found = np.array([curve.at(there) for there in displacement])
    size = within * curve.lower[0]
    assert np.abs(found - np.asarray(multiplier)[:, None]).max() <= size
    assert (curve.lower <= curve.upper).all()
    assert (curve.upper - curve.lower).max() <= 1e-6


def test_one_block_is_tan_of_what_is_left_of_its_diagonal():
    curve = capacity(block(0.5, 2.0), (1, 0, 0), control="block")
    follows(curve, [0.05, 0.10, 0.15, 0.20], [0.197787271, 0.147087101, 0.097474036, 0.048564293])
    there = np.linspace(0, 0.225, 10)
    follows(curve, there, (0.25 - there) / np.sqrt(4.25 / 4 - (0.25 - there) ** 2))
    assert curve.outcome.word == "zero"
    assert curve.displacement[-1] == pytest.approx(0.25, rel=1e-6)


def test_the_corner_that_moves_most_goes_by_the_width_of_the_block():
    curve = capacity(block(0.5, 2.0), (1, 0, 0))
    assert curve.displacement[-1] == pytest.approx(0.5, rel=1e-6)


def test_a_free_standing_stack_turns_as_one():
    n, b, a = 4, 0.5, 0.4
    courses = [box((0, 0, k * a), (b, 1, (k + 1) * a), name=f"{k}") for k in range(n)]
    curve = capacity(assembled([GROUND, *courses]), (1, 0, 0), control="mean")
    there = np.linspace(0, 0.9 * b / 2, 10)
    follows(curve, there, (b / 2 - there) / np.sqrt((b**2 + (n * a) ** 2) / 4 - (b / 2 - there) ** 2))


def test_a_trilith_carries_the_friction_that_its_columns_need_and_ends_at_their_width():
    columns = [box((x, 0, 0), (x + 0.5, 1, 2), name=f"column {x}") for x in (0, 2)]
    curve = capacity(
        assembled([GROUND, *columns, box((0, 0, 2), (2.5, 1, 2.4), name="lintel")]), (1, 0, 0), control="lintel"
    )
    there = np.linspace(0, 0.45, 10)
    follows(curve, there, (0.5 - there) / np.sqrt(4.25 - (0.5 - there) ** 2))
    assert curve.displacement[-1] == pytest.approx(0.5, rel=1e-6)


def test_a_dead_load_and_a_tendon_part_ways_at_once():
    # The block has turned by an angle about its toe, and all moments are about it.
    def moved(turn):
        return 0.25 - 0.25 * np.cos(turn) + np.sin(turn)

    def under_a_load(turn):
        return (0.5 - 3 * np.tan(turn)) / (1 + 0.25 * np.tan(turn))

    def under_a_tendon(turn):
        c, s = np.cos(turn), np.sin(turn)
        x, z = -0.25 * c + 2 * s, 0.25 * s + 2 * c  # of its upper end, from the toe
        length = np.hypot(x + 0.25, z)
        return (0.25 * c - s - (x * z - z * (x + 0.25)) / length) / (c + 0.25 * s)

    turns = np.array([0.02, 0.05, 0.10, 0.15])
    loaded = capacity(block(0.5, 2.0), (1, 0, 0), control="block", loads=[("block", (0.25, 0.5, 2), (0, 0, -1))])
    follows(loaded, moved(turns), under_a_load(turns))
    assert loaded.displacement[-1] == pytest.approx(moved(np.arctan(1 / 6)), rel=1e-6)
    tendon = Tie(("ground", "block"), ((0.25, 0.5, 0), (0.25, 0.5, 2)), least=1.0, greatest=1.0)
    tied = capacity(block(0.5, 2.0, ties=[tendon]), (1, 0, 0), control="block")
    follows(tied, moved(turns), under_a_tendon(turns))
    assert tied.displacement[-1] == pytest.approx(moved(brentq(under_a_tendon, 0.1, 1.0, xtol=1e-12)), rel=1e-6)


def test_a_block_slides_to_an_edge_and_turns_over_it():
    ground = box((-5, -5, -1), (1.1, 5, 0), name="ground")
    curve = capacity(
        assembled([ground, box((-0.5, 0, 0), (0.5, 1, 0.5), name="block")], friction=0.4), (1, 0, 0), control="block"
    )
    there = np.concatenate([np.linspace(0, 0.999, 10), np.linspace(1.001, 1.09, 10)])
    q = np.maximum(there - 1.0, 0)
    follows(curve, there, (0.1 - q) / np.sqrt(0.01 + 0.0625 - (0.1 - q) ** 2))
    assert [event.kind for event in curve.events] == ["change"]
    assert curve.events[0].parameter == pytest.approx(1.0, abs=1e-4)
    assert curve.displacement[-1] == pytest.approx(1.1, rel=1e-4)


@pytest.mark.parametrize(
    ("width", "height", "friction", "edge"),
    [
        (1.9348172, 1.1422269, 0.7412269, 2.2117085),
        (1.9127041, 0.6053809, 0.6233264, 2.7404067),
        (0.62, 0.46, 0.7, 2.0),
    ],
)
def test_sliding_blocks_of_any_shape_turn_where_the_resultant_reaches_the_edge(width, height, friction, edge):
    # Odd numbers: across the slip no contact resists, and loads do work there by rounding only.
    ground = box((-5, -5, -1), (edge, 5, 0), name="ground")
    slab = assembled([ground, box((0, 0, 0), (width, 1, height), name="block")], friction=friction)
    curve = capacity(slab, (1, 0, 0), control="block")
    left = np.minimum(edge - width / 2 - curve.displacement, friction * height / 2)
    exact = left / np.sqrt((friction * height / 2) ** 2 + (height / 2) ** 2 - left**2)
    assert np.abs(curve.lower - exact).max() <= WITHIN * friction
    assert curve.displacement[-1] == pytest.approx(edge - width / 2, rel=WITHIN)


@pytest.mark.parametrize("unit", [1.0, 0.1])
def test_a_stack_slides_to_an_edge_and_turns_over_it_whatever_the_unit_of_length(unit):
    """The resultant is at the edge when the common centroid, at a height h, is .35 h before it.

    From there on the stack turns about the edge, until its centroid is above that: by arctan .35. The control is the
    centroid of the slab, which is then .35 h behind the edge and .25 above it.
    """
    boxes = {
        "ground": ((-2, -2, -1), (1.6, 3, 0)),
        "slab": ((0, 0, 0), (1, 1, 0.5)),
        "block": ((0.2, 0, 0.5), (0.8, 1, 0.8)),
    }
    blocks = [box(*unit * np.array(ends), name=name) for name, ends in boxes.items()]
    curve = capacity(assembled(blocks, friction=0.35), (1, 0, 0), control="slab")
    behind = 0.35 * (0.5 * 0.25 + 0.18 * 0.65) / (0.5 + 0.18)
    turn = np.arctan(0.35)
    ahead = -behind * np.cos(turn) + 0.25 * np.sin(turn)
    assert curve.outcome.word == "zero"
    assert curve.events[0].parameter == pytest.approx(unit * (1.1 - behind), rel=1e-5)
    assert curve.displacement[-1] == pytest.approx(unit * (1.1 + ahead), rel=1e-5)


@pytest.mark.parametrize("slope", [0.1, -0.1])
def test_a_block_slides_down_or_up_a_slope_to_its_edge(slope):
    gravity = (9.81 * np.sin(slope), 0, -9.81 * np.cos(slope))
    ground = box((-5, -5, -1), (1.1, 5, 0), name="ground")
    blocks = [ground, box((-0.5, 0, 0), (0.5, 1, 0.5), name="block")]
    curve = capacity(
        assembled(blocks, friction=0.4, gravity=gravity), (np.cos(slope), 0, np.sin(slope)), control="block"
    )
    lean = np.arctan(0.4) - slope
    turn = np.array([np.arcsin(-point.pose.rotation[1][2, 0]) for point in curve.points])
    assert np.abs(curve.lower - np.tan(lean - turn)).max() <= WITHIN * curve.lower[0]
    assert [event.kind for event in curve.events] == ["change"]
    assert curve.events[0].parameter == pytest.approx(np.cos(slope), rel=1e-4)
    assert turn[-1] == pytest.approx(lean, rel=WITHIN)


def test_two_blocks_that_slide_together_do_not_spin():
    blocks = [box((0, 0, 0), (0.8, 1, 0.4), name="lower"), box((0, 0, 0.4), (0.6, 1, 0.8), name="upper")]
    curve = capacity(assembled([GROUND, *blocks], friction=0.5), (1, 0, 0), displacement=0.05)
    assert curve.outcome.word == "reached"
    assert curve.lower == pytest.approx(0.5, rel=1e-6)
    assert np.abs([point.pose.rotation - np.eye(3) for point in curve.points]).max() <= 1e-9


def test_associated_friction_lifts_a_block_that_slides():
    blocks = assembled([GROUND, box((0, 0, 0), (1, 1, 0.5), name="block")], friction=0.4)
    lifted, flat = (
        capacity(blocks, (1, 0, 0), control="block", displacement=0.2, flow=flow) for flow in ("associated", "coulomb")
    )
    assert lifted.outcome.word == flat.outcome.word == "reached"
    assert lifted.points[-1].pose.displacement[1] == pytest.approx([0.2, 0, 0.08], abs=1e-9)
    assert flat.points[-1].pose.displacement[1] == pytest.approx([0.2, 0, 0], abs=1e-9)
    for curve in (lifted, flat):
        assert curve.lower == pytest.approx(0.4, rel=1e-6)


def halves():
    return [
        box((0, 0, 0), (0.25, 1, 1.5), name="lower", group="wall"),
        box((0, 0, 1.5), (0.25, 1, 3), name="upper", group="wall"),
    ]


def test_a_wall_bends_below_a_stop_until_it_leaves_it():
    stop = box((0.25, -0.5, 2.9), (1, 1.5, 4), name="stop", group="stop")
    smooth = [JointLaw(("wall", "stop"), friction=0.0)]
    wall = assembled([GROUND, *halves(), stop], supports=("ground", "stop"), friction=0.7, joints=smooth)
    curve = capacity(wall, (1, 0, 0), control=("lower", (0, 0, 1.5)))
    values = [0.351851852, 0.318960075, 0.285226871, 0.250750601, 0.215647723]
    values += [0.180050636, 0.144104836, 0.107965492, 0.071793577, 0.035751722]
    assert curve.lower[0] == pytest.approx(values[0], rel=1e-8)
    follows(curve, 0.024318932 * np.arange(10), values)
    assert curve.displacement[-1] == pytest.approx(0.237635463, rel=WITHIN)
    assert curve.outcome.word == "collapse"  # the wall leaves the stop, and nothing else holds it
    assert curve.lower[-1] == pytest.approx(0.008131138, abs=WITHIN * values[0])


def test_a_wall_bends_below_a_slab_that_can_only_rise():
    slab = replace(box((0, 0, 3), (0.25, 1, 3.3), name="slab", group="slab"), density=5 / 9.81)
    guides = [box((-1, -0.5, 3.05), (0, 1.5, 4), name="west", group="guide")]
    guides += [box((0.25, -0.5, 3.05), (1, 1.5, 4), name="east", group="guide")]
    smooth = [JointLaw(("slab", "guide"), friction=0.0)]
    wall = assembled(
        [GROUND, *halves(), slab, *guides], supports=("ground", "west", "east"), friction=0.7, joints=smooth
    )
    load = np.zeros((wall.n_blocks, 6))
    load[1:3, 0] = 0.375
    curve = capacity(wall, load, control="lower")
    hinge = np.array([0.0, 0.025, 0.05, 0.1, 0.15, 0.2])
    # The hinge is the block's upper left corner; its centroid goes half as far.
    follows(curve, hinge / 2, [0.666666667, 0.598422907, 0.530686501, 0.396491160, 0.263608963, 0.131590339])
    assert curve.displacement[-1] == pytest.approx(0.125, rel=1e-3)


@pytest.mark.parametrize("shape", ARCHES, ids=str)
def test_arches_jump_to_other_hinges(shape):
    values, end, jumps = ARCHES[shape]
    curve = capacity(arch(*shape), (1, 0, 0), control="mean")
    there = np.arange(1, 10) * end / 10
    if shape == (20, 0.15):
        there = 0.001510719 * np.arange(1, 10)
    follows(curve, there, values)
    assert [event.kind for event in curve.events] == ["jump"] * len(jumps)
    assert [event.parameter for event in curve.events] == pytest.approx(jumps, rel=WITHIN)
    assert curve.displacement[-1] == pytest.approx(end, rel=WITHIN)
    assert curve.outcome.word == ("collapse" if shape == (10, 0.20) else "zero")


def test_what_an_arch_jumps_to_is_the_next_joint():
    curve = capacity(arch(20, 0.20), (1, 0, 0), control="mean")
    first, second = curve.events
    assert (first.before, first.after) == pytest.approx((0.232399268, 0.222447717), rel=WITHIN)
    assert (second.before, second.after) == pytest.approx((0.125371285, 0.115650518), rel=WITHIN)
    called = [["voussoir 8", "voussoir 9"], ["voussoir 7", "voussoir 8"]]
    summary = curve.summary()["events"][0]
    assert [*summary["opens"], *summary["shuts"]] == called


def test_a_coarse_arch_opens_its_hinges_by_the_angles_of_a_four_bar_linkage():
    curve = capacity(arch(10, 0.20), (1, 0, 0), control="mean")
    turn = [np.linalg.norm(matrix - np.eye(3)) / np.sqrt(2) for matrix in curve.points[-1].pose.rotation]
    # Joint 1 is below the second voussoir, which turns by its opening.
    assert 2 * np.arcsin(turn[1] / 2) == pytest.approx(0.094712, rel=WITHIN)
    assert curve.points[-1].pose.displacement[4, [0, 2]] == pytest.approx([0.077908337, -0.025817563], rel=WITHIN)


@pytest.mark.parametrize("height", PORTALS, ids=str)
def test_portals_of_monolithic_buttresses(height):
    values, end, jumps = PORTALS[height]
    curve = capacity(portal(1.0, height), (1, 0, 0), control="mean")
    follows(curve, np.arange(1, 10) * end / 10, values)
    assert [event.parameter for event in curve.events] == pytest.approx(jumps, rel=WITHIN)
    assert curve.displacement[-1] == pytest.approx(end, rel=WITHIN)


def test_half_the_tolerance_halves_the_error_at_least():
    exact = lambda d: (0.25 - d) / np.sqrt(4.25 / 4 - (0.25 - d) ** 2)  # noqa: E731
    there = np.linspace(0, 0.25, 1001)
    worst = []
    for tolerance in (4e-3, 2e-3, 1e-3):
        curve = capacity(block(0.5, 2.0), (1, 0, 0), control="block", steps=1, tolerance=tolerance)
        found = np.interp(there, curve.displacement, curve.lower)
        worst.append(np.abs(found - exact(there)).max() / 0.25)
        assert worst[-1] <= tolerance
    assert worst[1] <= 0.51 * worst[0]
    assert worst[2] <= 0.51 * worst[1]


def test_an_interrupted_curve_keeps_what_is_done():
    def stop(there, multiplier):
        if there > 0.1:
            raise KeyboardInterrupt

    curve = capacity(block(0.5, 2.0), (1, 0, 0), control="block", progress=stop)
    assert curve.outcome.word == "interrupted"
    assert 0.1 < curve.displacement[-1] < 0.25


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"control": "ground"}, "does not move"),
        ({"control": "nobody"}, 'no control "nobody"'),
        ({"load": (0, 0, -1)}, "carries any multiple of the load"),
        ({"displacement": -1.0}, "displacement is -1.0"),
        ({"steps": 0}, "steps is 0"),
        ({"flow": "viscous"}, "flow"),
    ],
    ids=lambda value: str(value)[:20],
)
def test_bad_input_is_a_sentence(options, words):
    load = options.pop("load", (1, 0, 0))
    with pytest.raises(InputError, match=words):
        capacity(block(0.5, 2.0), load, **options)


SPREADING = {
    (10, 0.15): (0.177164289, 0.233755834, 0.109251346),
    (20, 0.15): (0.175634884, 0.231624772, 0.108201857),
    (20, 0.20): (0.154244839, 0.305047575, 0.305356573),
    (40, 0.20): (0.153990276, 0.284567911, 0.254409607),
}


@pytest.mark.parametrize("shape", SPREADING, ids=str)
def test_arches_on_spreading_supports_fall_where_three_hinges_carry_no_more(shape):
    """Three hinges are determinate: H y = W_up (x_hinge - x_centroid). The haunch hinges stay where they are."""
    ring = arch(*shape)
    start, end, opening = SPREADING[shape]
    found = settle_to_collapse(ring, {"right": (1, 0, 0)})
    thrust = found.reaction / ring.free_weight
    assert found.outcome.word == "collapse"
    assert found.collapse == pytest.approx(opening, rel=WITHIN)
    assert (thrust[0], thrust[-1]) == pytest.approx((start, end), rel=WITHIN)
    assert len(found.cracks()) == 3
    if shape == (20, 0.20):
        expected = [0.169032515, 0.186082191, 0.230337493, 0.300041261]
        assert np.interp([0.05, 0.1, 0.2, 0.3], found.displacement, thrust) == pytest.approx(expected, rel=WITHIN)


@pytest.mark.parametrize("shape", [(10, 0.15), (20, 0.20)], ids=str)
def test_finite_steps_alone_lead_an_arch_to_where_its_linkage_falls(shape, monkeypatch):
    monkeypatch.setattr(LinkageFollower, "follow", lambda *_: iter([PathEnd.LOST]))
    ring = arch(*shape)
    start, _, opening = SPREADING[shape]
    found = settle_to_collapse(ring, {"right": (1, 0, 0)})
    assert found.outcome.word == "collapse"
    assert found.collapse == pytest.approx(opening, rel=1e-2)
    assert found.reaction[0] == pytest.approx(start * ring.free_weight, rel=WITHIN)
    assert any("finite steps" in text for text in found.warnings)
    if shape == (20, 0.20):
        expected = [0.169032515, 0.186082191, 0.230337493, 0.300041261]
        thrust = np.interp([0.05, 0.1, 0.2, 0.3], found.displacement, found.reaction / ring.free_weight)
        assert thrust == pytest.approx(expected, rel=2e-3)


def test_a_wall_on_ground_that_is_torn_apart_is_followed_and_loses_energy():
    wall = running_bond(4, 3, gravity=(0, 0, -9.81)).with_(friction=0.6)
    found = settle_to_collapse(wall, {(0.4, -9, -1, 9, 9, 0.01): (1, 0, -1)}, displacement=0.2)
    assert found.outcome.word in ("collapse", "reached")
    assert found.displacement[-1] > 0.02
    height = np.array([pose.displacement[:, 2] for pose in found.poses]) @ (9.81 * wall.mass * ~wall.support)
    mean = 0.5 * (found.reaction[1:] + found.reaction[:-1])
    work = np.append(0.0, np.cumsum(mean * np.diff(found.displacement)))
    # What the weight loses moves the support, or is lost in friction and falls.
    assert (work <= -height + 1e-3 * wall.free_weight * found.displacement).all()
    assert work[-1] > 0


@pytest.mark.parametrize(
    ("voussoirs", "direction"), [(10, (-0.78, 0, 0.63)), (19, (1, 0, 0.01)), (17, (0.59, 0, -0.81))]
)
def test_an_arch_on_a_support_that_moves_any_way_gives_the_work_that_its_weight_does(voussoirs, direction):
    # At rest a symmetrical thrust line touches four joints and more; three of them open.
    ring = assemble(model.arch(span=2, thickness=0.15, depth=0.5, voussoirs=voussoirs, springers=0.3), friction=0.85)
    found = settle_to_collapse(ring, {"springer.right": direction}, steps=60)
    assert found.outcome.word == "collapse"
    fallen = -np.array([pose.displacement[:, 2] for pose in found.poses]) @ (9.81 * ring.mass * ~ring.support)
    step = np.diff(found.displacement)
    work = step * 0.5 * (found.reaction[1:] + found.reaction[:-1])
    assert work == pytest.approx(np.where(step > 0, np.diff(fallen), 0.0), rel=1e-3)  # what falls at a jump is lost
    assert found.displacement[-1] > 0.03


def test_a_lintel_whose_support_sinks_and_leaves_slides_on_it_and_turns():
    # It turns by th about the edge of the other one; on the sinking one its far corner slides against friction:
    # N (2.3 cos th - 2.3 mu sin th) = W (1.0 cos th + .15 sin th), sin th = .98 s / 2.3.
    mu, along = 0.4, np.array([-0.2, 0, -0.98]) / np.hypot(0.2, 0.98)
    supports = [box((-1, 0, -1), (0, 1, 0), name="left"), box((2, 0, -1), (3, 1, 0), name="right")]
    lintel = box((-0.3, 0, 0), (2.3, 1, 0.3), name="lintel")
    asm = Assembly.from_blocks([*supports, lintel], supports=["left", "right"], friction=mu)
    found = settle_to_collapse(asm, {"right": tuple(along)}, displacement=0.3)
    turn = np.arcsin(-along[2] * found.displacement / 2.3)
    weight = 9.81 * asm.mass[2]
    normal = weight * (np.cos(turn) + 0.15 * np.sin(turn)) / (2.3 * (np.cos(turn) - mu * np.sin(turn)))
    assert found.outcome.word == "reached"
    assert found.reaction == pytest.approx(normal * (-along[2] + mu * along[0]), rel=1e-9)


def test_both_supports_by_half_are_one_support_by_all():
    found = settle_to_collapse(arch(10, 0.15), {"right": (0.5, 0, 0), "left": (-0.5, 0, 0)})
    assert 2 * found.collapse == pytest.approx(0.109251346, rel=WITHIN)


def test_supports_that_all_move_alike_meet_no_resistance():
    found = settle_to_collapse(arch(10, 0.15), {"right": (0, 0, -1), "left": (0, 0, -1)})
    assert found.outcome.word == "follows"
    assert found.collapse is None
    assert "no joint opens or slides" in found.explain()
