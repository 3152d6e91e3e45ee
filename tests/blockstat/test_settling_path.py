"""What a settlement path tells where nothing resists, where it is broken off, and where it cannot begin."""

import json
import subprocess
import sys
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from scipy.optimize import brentq, linprog
from scipy.spatial.transform import Rotation

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    Tie,
    box,
    find_interfaces,
    point_load,
    settle,
    settle_to_collapse,
    write,
)
from blockstat.large_displacement.finite_steps.follower import StepFollower
from blockstat.model import arch, assemble
from blockstat.studies import settling_path
from blockstat.studies.settling_path import PathOutcome
from evidence.scenes.small import assembly, prism

SINKS = {"right": (0, 0, -1)}


def run(*arguments):
    command = [sys.executable, "-m", "blockstat", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def portal(**options):
    piers = [box((x, 0, 0), (x + 0.5, 1, 2), name=name, group=name) for x, name in ((0, "left"), (1.5, "right"))]
    lintel = box((0, 0, 2), (2, 1, 2.5), name="lintel", group="lintel")
    return Assembly.from_blocks([*piers, lintel], supports=["left", "right"], friction=0.9, **options)


def beside_a_wall(**options):
    """A block of weight 1 on the ground that touches a wall, which is a support of its own."""
    blocks = [box((-1, -1, -1), (3, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="block", group="block")]
    blocks.append(box((1, 0, 0), (2, 1, 1), name="wall", group="wall"))
    return assembly(blocks, supports=["ground", "wall"], friction=0.6, **options)


def test_a_wall_that_leaves_moves_no_block():
    found = settle(beside_a_wall(), {"wall": (0.01, 0, 0)})
    assert "Blocks that move with them" not in found.explain()
    assert [(crack.blocks, round(crack.opening, 9)) for crack in found.cracks()] == [(("block", "wall"), 0.01)]
    assert found.reaction == pytest.approx(0, abs=1e-9)
    pushed = settle(beside_a_wall(), {"wall": (-0.01, 0, 0)})
    assert "Blocks that move with them: block." in pushed.explain()


def test_a_wall_that_leaves_may_go_any_way():
    found = settle_to_collapse(beside_a_wall(), {"wall": (1, 0, 0)}, displacement=0.05, steps=3)
    assert found.outcome is PathOutcome.REACHED
    assert found.displacement[-1] == pytest.approx(0.05)
    np.testing.assert_allclose(found.reaction, 0, atol=1e-9)
    [(pair, width)] = found.cracks()
    assert pair == ("block", "wall")
    assert width == pytest.approx(0.05, rel=1e-6)


def beside_a_smooth_wall(*points, **bounds):
    """The same with a tie from the block to a wall without friction."""
    ties = [Tie(("block", "wall"), points, **bounds)]
    return beside_a_wall(ties=ties, joints=[JointLaw(("block", "wall"), friction=0.0)])


def test_a_wall_drags_a_block_along_by_a_tie():
    wall = beside_a_smooth_wall((0.5, 0.5, 0.0), (1.5, 0.5, 0.0))
    found = settle_to_collapse(wall, {"wall": (1, 0, 0)}, displacement=0.05, steps=3)
    np.testing.assert_allclose(found.reaction, -0.6, rtol=1e-6)  # friction on the ground
    np.testing.assert_allclose(found.poses[-1].displacement[1], (0.05, 0, 0), atol=1e-9)


@pytest.mark.parametrize("least", [0.0, 0.3], ids=["yields", "constant"])
def test_a_tie_with_a_given_force_follows_the_wall_to_which_it_is_anchored(least):
    wall = beside_a_smooth_wall((0.5, 0.5, 0.0), (2.5, 0.5, 1.5), least=least, greatest=0.3)
    found = settle_to_collapse(wall, {"wall": (1, 0, 0)}, displacement=0.05, steps=3)
    assert found.displacement[-1] == pytest.approx(0.05)
    away = 2.0 + found.displacement
    np.testing.assert_allclose(found.reaction, -0.3 * away / np.hypot(away, 1.5), rtol=1e-6)
    np.testing.assert_allclose(found.poses[-1].displacement, 0, atol=1e-9)


def test_a_tie_that_a_rising_wall_slackens_lifts_the_block_when_it_is_taut_again():
    """It is shortest where it is level, after .01, and as long as at rest after .02."""
    wall = beside_a_smooth_wall((0.5, 0.5, 0.05), (1.5, 0.5, 0.04))
    found = settle_to_collapse(wall, {"wall": (0, 0, 1)}, displacement=0.05, steps=4)
    assert [(event.kind, round(event.parameter, 8)) for event in found.events] == [("closing", 0.02)]
    before = found.displacement < 0.0199
    np.testing.assert_allclose(found.reaction[before], 0, atol=1e-9)
    assert found.reaction[-1] == pytest.approx(-1.0, rel=1e-6)
    np.testing.assert_allclose(found.poses[-1].displacement[1], (0, 0, 0.03), atol=1e-7)


@pytest.mark.parametrize("steps", [10, 40])
def test_a_tie_across_the_movement_drags_the_block_over_the_ground(steps):
    """At rest the tie does not lengthen. Then the block slides along s and stays on the circle of radius r.

    Friction balances the tie, so s is along the tie, which has turned by a: a' = cos a / r, and the ground feels
    mu W sin a = mu W tanh(d / r).
    """
    ground, block = box((-5, -5, -1), (15, 1.5, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="block")
    wall = box((-5, 2, -1), (15, 3, 2), name="wall")
    rod = Tie(("block", "wall"), ((0.5, 0.5, 0), (0.5, 2, 0)))
    asm = assembly([ground, block, wall], supports=["ground", "wall"], ties=[rod], friction=0.6)
    found = settle_to_collapse(asm, {"ground": (1, 0, 0)}, displacement=2.0, steps=steps)
    assert found.outcome is PathOutcome.REACHED
    np.testing.assert_allclose(found.reaction, -0.6 * np.tanh(found.displacement / 1.5), rtol=0.2 / steps, atol=1e-9)
    # A tie that moves with the block is as if it were not there.
    along = replace(asm, ties=(Tie(("block", "ground"), ((0.5, 0.5, 1), (0.5, 1.2, 0))),))
    assert settle_to_collapse(along, {"ground": (1, 0, 0)}).outcome is PathOutcome.FOLLOWS


def test_a_tie_between_two_supports_holds_no_block():
    points = ((0.5, 0.5, -0.5), (1.5, 0.5, 0.5))
    ties = [Tie(("ground", "wall"), points, 0.2, greatest) for greatest in (0.2, np.inf)]
    found = settle_to_collapse(beside_a_wall(ties=ties), {"wall": (1, 0, 0)}, displacement=0.05, steps=3)
    assert found.outcome is PathOutcome.REACHED
    np.testing.assert_allclose(found.reaction, 0, atol=1e-9)
    np.testing.assert_allclose(found.first.foundations[0].reaction, 0, atol=1e-9)


def test_the_glue_of_a_block_that_rides_on_its_support_is_no_part_of_the_reaction():
    # Pushed against the wall by half its weight, it rubs on it as the smooth ground lifts it.
    glued = beside_a_wall(
        joints=[JointLaw(("*", "block"), friction=0.0, tension=3.0), JointLaw(("wall", "block"), friction=0.6)]
    )
    push = [("block", (0, 0.5, 0.5), (0.5, 0, 0))]
    found = settle_to_collapse(glued, {"ground": (0, 0, 1)}, displacement=0.05, steps=3, loads=push)
    np.testing.assert_allclose(found.reaction, -(1 + 0.6 * 0.5), rtol=1e-6)


HELD = ("right", "lintel")
DOWN = ((1.75, 0.5, 1.0), (1.75, 0.5, 2.0))


@pytest.mark.parametrize(("options", "held"), [
    ({"joints": [JointLaw(HELD, tension=1e5)]}, 1e5 / 4 * 0.5 / 1.5),
    ({"joints": [JointLaw(HELD, bond=2e4, bond_moment=1e4)]}, (2e4 * 0.25 + 1e4) / 1.5),
    ({"ties": [Tie(HELD, DOWN, greatest=5e3)]}, 5e3 * 0.25 / 1.5),
    ({"ties": [Tie(HELD, DOWN, 5e3, 5e3)]}, 5e3 * 0.25 / 1.5),
], ids=["tension", "bond", "yields", "constant"])  # fmt: skip
def test_what_holds_a_lintel_to_the_pier_that_sinks_resists_from_the_first_moment(options, held):
    """It turns by 1 / 1.5 about the outer edge of the pier: its joint opens so much half a metre away, inside."""
    found = settle_to_collapse(portal(**options), SINKS, displacement=0.02, steps=1)
    reaction = portal().free_weight / 3 - held
    assert found.first.reaction == pytest.approx(reaction, rel=1e-6)
    assert found.first.foundations[0].reaction[2] == pytest.approx(-reaction, rel=1e-6)
    assert found.reaction[0] == pytest.approx(reaction, rel=1e-6)


def test_what_has_no_joints_has_no_cracks():
    found = settle(portal(), {"right": (0, 0, -0.01)})
    assert len(found.cracks()) == 2
    assert replace(found, interfaces=found.interfaces.subset(np.zeros(2, dtype=bool))).cracks() == []


@pytest.mark.parametrize("region", [(0, 0, 0, 1, 1), (0, 0, 0), (0,) * 7, ()])
def test_a_region_has_six_numbers(region):
    with pytest.raises(InputError, match=r"a region is .*; it must be six numbers, x0, y0, z0, x1, y1, z1"):
        settle(portal(), {region: (0, 0, -0.01)})


@pytest.mark.parametrize("movement", [(1,), "a", np.nan, True])
def test_cracks_are_asked_for_at_a_number(movement):
    found = settle_to_collapse(portal(), SINKS, displacement=0.05, steps=3)
    with pytest.raises(InputError, match=r"displacement is .*; it must be a finite number"):
        found.cracks(movement)


def test_progress_is_told_movement_and_reaction_of_each_point():
    told = []
    found = settle_to_collapse(portal(), SINKS, displacement=0.05, steps=3, progress=lambda *now: told.append(now))
    assert told == list(zip(found.displacement, found.reaction, strict=True))
    # Half the lintel rests on the right pier's outer edge and the left one's inner edge: 1 to 2 of 1.5 m.
    assert told[0][1] == pytest.approx(portal().free_weight / 3, rel=1e-3)


def test_a_path_that_is_interrupted_ends_at_the_last_point():
    def stop(movement, reaction):
        if movement > 0.02:
            raise KeyboardInterrupt

    found = settle_to_collapse(portal(), SINKS, displacement=0.1, steps=10, progress=stop)
    assert found.outcome is PathOutcome.INTERRUPTED
    assert 0.02 < found.displacement[-1] < 0.1
    assert found.collapse is None
    assert found.explain().startswith("Interrupted: the path is known up to here.\nMovement ")


def test_an_interruption_before_the_first_point_is_passed_on(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(settling_path, "follow_path", interrupted)
    with pytest.raises(KeyboardInterrupt):
        settle_to_collapse(portal(), SINKS, displacement=0.05)


def test_a_fault_on_the_way_keeps_the_path_up_to_there(monkeypatch):
    whole = settle_to_collapse(portal(), SINKS, displacement=0.1, steps=10)
    real = StepFollower.follow

    def refused(*given):
        yield from islice(real(*given), 4)
        raise InputError("interfaces: at fault")

    monkeypatch.setattr(StepFollower, "follow", refused)
    found = settle_to_collapse(portal(), SINKS, displacement=0.1, steps=10)
    assert found.outcome is PathOutcome.LOST
    np.testing.assert_array_equal(found.displacement, whole.displacement[:4])
    np.testing.assert_array_equal(found.reaction, whole.reaction[:4])
    assert f"from {found.displacement[-1]:.4g} m on the blocks come to a pose whose joints" in found.explain()


def thick_arch(thickness, side, way):
    """A semicircular arch of radius 1 on supports, one of which moves."""
    ring = arch(span=2 - thickness, thickness=thickness, depth=0.5, voussoirs=12, springers=0.3)
    return settle_to_collapse(assemble(ring, friction=0.8), {f"springer.{side}": way}, steps=10)


def test_a_thick_arch_whose_stones_turn_by_a_right_angle_falls_at_once_like_its_neighbours():
    """The straight line through two thicker arches leads to it, and its mirror image falls at the same place."""
    ends = [thick_arch(thickness, "right", (1, 0, 0)) for thickness in (0.3, 0.302, 0.305)]
    assert [end.outcome for end in ends] == 3 * [PathOutcome.COLLAPSE]
    here, near, far = (end.collapse for end in ends)
    assert here == pytest.approx(near - (far - near) * 2 / 3, rel=1e-4)
    assert thick_arch(0.3, "left", (-1, 0, 0)).collapse == pytest.approx(here, rel=1e-9)


def test_a_stone_that_falls_falls_whatever_lies_far_away():
    """It bears on the post over .1 m, and its centroid is beyond the pier. A slab far away is more than a fall long."""
    blocks = [box((-1, 0, -2), (0, 1, 0), name="pier"), box((0.3, 0, -2), (1.3, 1, 0), name="post")]
    blocks.append(box((-0.3, 0, 0), (0.4, 1, 0.2), name="stone"))
    away = [box((20, 0, -1), (32, 1, 0), name="floor"), box((20.5, 0, 0), (31.5, 1, 0.4), name="slab")]
    alone = Assembly.from_blocks(blocks, supports=["pier", "post"], friction=0.6)
    beside = Assembly.from_blocks([*blocks, *away], supports=["pier", "post", "floor"], friction=0.6)
    for scene in (alone, beside):
        found = settle_to_collapse(scene, {"post": (1, 0, 0)}, displacement=1.0)
        assert found.collapse == pytest.approx(0.1, rel=1e-4)
        assert [event.kind for event in found.events] == ["jump"]
        assert not any("finite steps" in text for text in found.warnings)


def test_a_path_without_any_state_is_jammed(monkeypatch):
    monkeypatch.setattr(settling_path, "follow_path", lambda *_, **__: iter(()))
    with pytest.raises(InputError, match='"assembly": the blocks are jammed between the moving supports'):
        settle_to_collapse(portal(), SINKS, displacement=0.05)


def test_a_path_that_is_lost_at_rest_tells_no_movement(monkeypatch):
    real = settling_path.follow_path

    def lost(*given, **options):
        yield next(iter(real(*given, **options)))
        yield settling_path.PathOutcome.LOST

    monkeypatch.setattr(settling_path, "follow_path", lost)
    found = settle_to_collapse(portal(), SINKS, displacement=0.05)
    assert found.outcome is PathOutcome.LOST
    assert "Movement" not in found.explain()
    assert found.explain().splitlines()[0] == PathOutcome.LOST.value
    assert all(line.startswith("Warning: ") for line in found.explain().splitlines()[1:])


@pytest.mark.parametrize(("law", "words"), [
    ({"compression": 1e9}, "joints with compressive strength crush at their hinges"),
    ({"cells": 4}, "joints that are divided into cells are not followed as they open"),
])  # fmt: skip
def test_joints_whose_points_change_as_they_open_are_refused(law, words):
    with pytest.raises(InputError, match=words):
        settle_to_collapse(portal(joints=[JointLaw(("*", "*"), **law)]), SINKS, displacement=0.05, steps=1)
    rough = settle_to_collapse(portal(joints=[JointLaw(("*", "*"), friction=0.9)]), SINKS, displacement=0.05, steps=1)
    assert rough.outcome is not PathOutcome.COLLAPSE


def lintel(bearing, origin=(0, 0, 0)):
    """A lintel of 2.5 m on a wall that ends at 1 m, and on a right one on which it has a bearing."""
    o = np.array(origin)
    blocks = [
        box(o + (0, 0, -1), o + (1, 1, 0), name="left"), box(o + (3 - bearing, 0, -1), o + (4, 1, 0), name="right"),
        box(o + (0.5, 0, 0), o + (3, 1, 0.5), name="lintel"),
    ]  # fmt: skip
    return Assembly.from_blocks(blocks, supports=["left", "right"], friction=0.7)


def slides_at_the_left(turn):
    """Friction that is needed at the left, less that there is, of a lintel that slides at the right; weight 1.

    It turns about the edge of the left wall, a quarter of the lintel from its end. The three forces are concurrent.
    """
    sine, cosine = np.sin(turn), np.cos(turn)
    arm = 0.75 * cosine + 0.25 * sine
    right = arm / (2 * cosine + 0.7 * 2 * sine)
    normal = -0.7 * right * sine + (1 - right) * cosine
    along = 0.7 * right * cosine + (1 - right) * sine
    return along - 0.7 * normal


@pytest.mark.parametrize(("bearing", "steps"), [(0.04, 30), (0.02, 150), (0.01, 30)])
@pytest.mark.parametrize("origin", [(0, 0, 0), (5e5, 4.6e6, 200)])
def test_a_lintel_whose_support_sinks_falls_when_its_corner_is_at_the_edge(bearing, steps, origin):
    """It has turned by t with 2 (1 - cos t) = e, so the support has sunk by 2 sin t."""
    assert slides_at_the_left(np.arccos(1 - bearing / 2)) < 0
    path = settle_to_collapse(lintel(bearing, origin), {"right": (0, 0, -1)}, steps=steps)
    assert path.collapse == pytest.approx(2 * (bearing - bearing**2 / 4) ** 0.5, rel=0.01)


@pytest.mark.parametrize("steps", [30, 200])
def test_a_lintel_on_a_longer_bearing_begins_to_slide_at_the_other_wall(steps):
    """From there on its corner stays where it is, at a = 2 cos t from the left wall, and the lintel is pulled off that.

    Its end is at the left edge at 2.5 cos u = a; the support has then sunk by a tan u.
    """
    away = 2 * np.cos(brentq(slides_at_the_left, 0, 0.6))
    assert 2 - away < 0.1
    path = settle_to_collapse(lintel(0.1), {"right": (0, 0, -1)}, steps=steps)
    assert path.collapse == pytest.approx(away * np.tan(np.arccos(away / 2.5)), rel=0.01)


def test_the_loads_of_a_case_go_with_their_points(tmp_path):
    """A load as heavy as the lintel, in the middle of its top: moments about the edge of the left wall.

    The lintel slides at the right and turns by t; its corner is at 2 cos t, 2 sin t below the edge.
    """
    made = lintel(0.04)
    file, cases = write(made, tmp_path / "lintel.json"), tmp_path / "cases.toml"
    weight = float(made.mass[2]) * 9.80665
    point = f'kind = "point"\nblock = "lintel"\npoint = [1.75, 0.5, 0.5]\nforce = [0, 0, {-weight}]'
    cases.write_text(f"[loads.top]\n{point}\n[cases.loaded.factors]\ntop = 1.0\n")
    options = ("--move", "right:0,0,-1", "--until", "0.3", "--case", "loaded", "--loads", cases, "--json")
    answer = run("settle", file, *options)
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)["path"]
    sine = np.array(told["displacement"]) / 2
    cosine = np.sqrt(1 - sine**2)
    arms = (0.75 * cosine + 0.25 * sine) + (0.75 * cosine + 0.5 * sine)
    expected = weight * arms / (2 * cosine + 0.7 * 2 * sine)
    assert sine[-1] == pytest.approx(0.15)
    np.testing.assert_allclose(told["reaction"][1:], expected[1:], rtol=1e-3)
    assert not any("centroids" in text for text in told["warnings"])


def test_wrenches_are_said_to_move_with_the_centroids():
    made = lintel(0.04)
    top = point_load(made, "lintel", (1.75, 0.5, 0.5), (0, 0, -1e3))
    path = settle_to_collapse(made, {"right": (0, 0, -1)}, loads=top, displacement=0.01, steps=1)
    assert any("centroids" in text for text in path.warnings)


def flat_arch(rise, unit=1.0, friction=5.0):
    """Two blocks 1 m long between two abutments, which meet at midspan."""
    ends = [
        ((-1, 0, -1), (0, 1, rise)),
        ((2, 0, -1), (3, 1, rise)),
        ((0, 0, 0), (1, 1, rise)),
        ((1, 0, 0), (2, 1, rise)),
    ]
    blocks = [
        box(unit * np.array(low), unit * np.array(high), name=name)
        for name, (low, high) in zip(("left", "right", "one", "other"), ends, strict=True)
    ]
    return Assembly.from_blocks(blocks, supports=["left", "right"], density=2000 / unit**3, friction=friction)


@pytest.mark.parametrize(("rise", "unit"), [(0.3, 1.0), (0.6, 1.0), (0.6, 1000.0)])
def test_three_hinges_carry_until_they_are_in_line(rise, unit):
    # Hinges at the lower corners of the abutments and at the upper one of the crown: two bars, drawn out straight.
    found = settle_to_collapse(flat_arch(rise, unit), {"right": (1, 0, 0)})
    exact = 2 * (np.hypot(1, rise) - 1)
    assert found.outcome is PathOutcome.COLLAPSE
    assert found.collapse / unit == pytest.approx(exact, rel=1e-5)
    assert found.collapse / unit < exact
    # Moments of one block about its springing: the thrust times the rise left is the weight times its arm.
    bar, crown = np.hypot(1, rise), 1 + found.displacement / unit / 2
    left = np.sqrt(bar**2 - crown**2)
    turn = np.arctan2(left, crown) - np.arctan2(rise, 1)
    arm = 0.5 * np.cos(turn) - rise / 2 * np.sin(turn)
    thrust = 2000 * 9.81 * rise * arm / left
    np.testing.assert_allclose(found.reaction, thrust, rtol=1e-4)
    assert not found.warnings


def test_blocks_that_slide_from_supports_that_leave_are_not_followed_out_of_contact():
    # The thrust at rest is that of sliding, W / mu: the blocks cannot slide down and stay in contact with both sides.
    found = settle_to_collapse(flat_arch(0.6, friction=0.9), {"right": (1, 0, 0)})
    assert found.outcome is PathOutcome.LOST
    assert found.collapse is None
    assert found.displacement[-1] < 1e-3


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_lintel_on_two_ridges_slides_off_when_its_slope_is_the_friction(friction):
    """At first it turns about the ridges and sticks to both; then these move apart as sqrt(4 + d^2). Sunk by d, its
    slope is d / 2."""
    ridges = [prism([(x - 0.5, -1), (x + 0.5, -1), (x, 0)], 1.0, name=name) for x, name in ((0, "left"), (2, "right"))]
    lintel = box((-0.3, 0, 0), (2.3, 1, 0.3), name="lintel")
    scene = assembly([*ridges, lintel], supports=["left", "right"], friction=friction)
    found = settle_to_collapse(scene, SINKS)
    assert found.outcome is PathOutcome.COLLAPSE
    assert found.collapse == pytest.approx(2 * friction, rel=0.01)


def test_the_reaction_at_first_is_that_of_joints_that_still_hold_in_tension():
    law = [JointLaw(("*", "*"), tension=2e3)]
    ring = arch(span=1.85, thickness=0.15, depth=0.5, voussoirs=10, springers=0.3)
    found = settle_to_collapse(
        assemble(ring, friction=0.7, joints=law), {"springer.right": (1, 0, 0)}, displacement=0.01, steps=2
    )
    assert found.displacement[0] == 0.0
    assert found.reaction[0] == pytest.approx(found.first.reaction, rel=1e-6)
    bare = settle(assemble(ring, friction=0.7), {"springer.right": (1, 0, 0)}).reaction
    assert found.reaction[0] < 0.98 * bare < found.reaction[1]


def test_a_joint_that_slides_keeps_the_friction_it_was_given():
    wall = beside_a_smooth_wall((0.5, 0.5, 0.0), (1.5, 0.5, 0.0))
    faces = replace(find_interfaces(wall), friction=np.array([0.3, 0.0]))
    found = settle_to_collapse(wall, {"wall": (1, 0, 0)}, displacement=0.05, steps=3, interfaces=faces)
    np.testing.assert_allclose(found.reaction, -0.3, rtol=1e-6)


def spreading(springers, *beside, **options):
    blocks = [*arch(span=1.85, thickness=0.2, depth=0.5, voussoirs=11, springers=springers), *beside]
    ring = assemble(blocks, supports=["springer", *(block.group for block in beside)], friction=0.7)
    return settle_to_collapse(ring, {"springer.right": (1, 0, 0)}, **options)


@pytest.mark.parametrize("beside", [(), (box((4, -1, -2), (5, 1, -1), group="rock"),)], ids=["", "rock"])
@pytest.mark.parametrize("springers", [0.3, 1.0, 2.0])
def test_how_large_supports_are_does_not_matter_to_an_arch_on_them(springers, beside):
    """At first its thrust is the least that there is, and it grows as the crown sinks."""
    found = spreading(springers, *beside)
    assert found.outcome is PathOutcome.COLLAPSE
    assert found.collapse == pytest.approx(spreading(0.1).collapse, rel=1e-4)
    assert (found.reaction > (1 - 1e-6) * found.first.reaction).all()


@pytest.mark.parametrize("beyond", [1, 5, 50])
def test_a_block_that_is_drawn_over_falls_however_wide_the_ground_is(beyond):
    """The tie rises to the wall; the block falls when its centroid is above its toe, and nothing stops it."""
    blocks = [box((-2, -2, -1), (2.5 + beyond, 3, 0), name="ground"), box((0, 0, 0), (0.5, 1, 1), name="block")]
    blocks.append(box((2, 0, 0), (2.4, 1, 2), name="wall"))
    rod = Tie(("block", "wall"), ((0.5, 0.5, 0.9), (2.0, 0.5, 1.5)))
    drawn = Assembly.from_blocks(blocks, supports=["ground", "wall"], friction=0.4, ties=[rod])
    found = settle_to_collapse(drawn, {"wall": (1, 0, 0)}, displacement=1.0)
    turn = np.arctan2(0.25, 0.5)
    away = np.sqrt(1.5**2 + 0.6**2 - (1.5 - 0.9 * np.cos(turn)) ** 2)
    assert found.outcome is PathOutcome.COLLAPSE
    assert found.collapse == pytest.approx(0.5 + 0.9 * np.sin(turn) + away - 2.0, rel=1e-4)


@pytest.mark.parametrize("greatest", [np.inf, 1e9, 1e6, 1e4])
def test_a_tie_that_never_carries_its_strength_might_as_well_have_none(greatest):
    """It draws a block half as wide as high over its toe, until the centroid stands above that.

    At first it pulls with half the width over its height of the weight. Turned by t about the toe, the block has the
    end of the tie at .9 (sin t, cos t) from there; the tie is 1.5 long; and moments about the toe give its force.
    """
    blocks = [box((-2, -2, -1), (6, 3, 0), name="ground"), box((0, 0, 0), (0.5, 1, 1), name="block")]
    blocks.append(box((2, 0, 0), (2.4, 1, 2), name="wall"))
    rod = Tie(("block", "wall"), ((0.5, 0.5, 0.9), (2.0, 0.5, 0.9)), greatest=greatest)
    drawn = Assembly.from_blocks(blocks, supports=["ground", "wall"], friction=0.4, ties=[rod])
    found = settle_to_collapse(drawn, {"wall": (1, 0, 0)}, displacement=1.0)
    turn = np.arctan2(0.25, 0.5)
    end = 0.5 + 0.9 * np.sin(turn) + np.sqrt(1.5**2 - (0.9 - 0.9 * np.cos(turn)) ** 2) - 2.0
    assert found.collapse == pytest.approx(end, rel=1e-4)
    assert found.reaction.min() == pytest.approx(-0.25 / 0.9 * drawn.free_weight, rel=1e-6)
    assert [event.after for event in found.events] in ([], [None])  # no jump but the fall

    def force(moved):
        def line(turn):
            return np.array([1.5 + moved - 0.9 * np.sin(turn), 0.9 - 0.9 * np.cos(turn)])

        turn = brentq(lambda turn: np.hypot(*line(turn)) - 1.5, 0.0, 1.0)
        x, z = line(turn) / 1.5
        lever = 0.25 * np.cos(turn) - 0.5 * np.sin(turn)
        return -drawn.free_weight * lever * x / (0.9 * np.cos(turn) * x - 0.9 * np.sin(turn) * z)

    expected = [force(moved) for moved in found.displacement]
    np.testing.assert_allclose(found.reaction, expected, rtol=1e-6, atol=1e-4 * drawn.free_weight)
    assert found.reaction.max() <= 1e-6 * drawn.free_weight


@pytest.mark.parametrize("share", [0.25, 0.35, 0.5])
def test_a_leaning_block_falls_when_the_tie_that_holds_it_reaches_its_strength(share):
    """The wall it hangs on comes nearer, and it leans over its toe, further and further: moments about the toe."""
    ground, wall = box((-3, -2, -1), (4, 3, 0), name="ground"), box((-1.4, 0, 0), (-1, 1, 1.2), name="wall")
    block = prism([(0, 0), (0.4, 0), (1.2, 1), (0.8, 1)], 1.0, name="block")
    rod = Tie(("block", "wall"), ((0.8, 0.5, 1.0), (-1.0, 0.5, 1.0)), greatest=share)
    scene = assembly([ground, block, wall], supports=["ground", "wall"], ties=[rod], friction=0.9)
    weight = scene.free_weight
    scene = replace(scene, ties=(replace(rod, greatest=share * weight),))

    def held(turn):
        """Force of the tie over the weight, and how far the wall has come."""
        sine, cosine = np.sin(turn), np.cos(turn)
        x, z = 0.4 * cosine + sine, cosine - 0.4 * sine
        along = np.array([-np.sqrt(1.8**2 - (1 - z) ** 2), 1 - z]) / 1.8
        return (0.2 * cosine + 0.5 * sine) / (x * along[1] - z * along[0]), 0.4 + x + 1.8 * along[0] + 1

    turn = brentq(lambda turn: held(turn)[0] - share, 0, 1)
    found = settle_to_collapse(scene, {"wall": (1, 0, 0)}, displacement=2.0)
    assert found.collapse == pytest.approx(held(turn)[1], rel=1e-4)


def on_two_piers(left, right, **options):
    """A lintel of 2.2 m on a bearing of each of two piers, of which the right one moves away, friction .6."""
    ends = {"left": ((-0.5, 0, 0), (left, 1, 2)), "right": ((2.2 - right, 0, 0), (2.7, 1, 2))}
    ends["lintel"] = ((0, 0, 2), (2.2, 1, 2.4))
    blocks = [box(*corners, name=name, group=name) for name, corners in ends.items()]
    return Assembly.from_blocks(blocks, supports=["left", "right"], friction=0.6, density=2000.0, **options)


@pytest.mark.parametrize(("left", "right"), [(0.3, 0.4), (0.05, 0.2), (0.2, 0.2), (0.4, 0.15)])
def test_a_lintel_may_slide_on_its_shorter_bearing_alone(left, right):
    """It falls when that is used up. Were the slip shared, it would fall at twice the shorter bearing."""
    path = settle_to_collapse(on_two_piers(left, right), {"right": (1, 0, 0)}, steps=12)
    assert path.collapse == pytest.approx(min(left, right), rel=1e-3)
    (shared, *_) = path.warnings
    assert 'by several joints in any way: "left" and "lintel", "right" and "lintel"' in shared
    if left != right:
        assert f'the slip between "{"left" if left < right else "right"}" and "lintel" alone' in shared


def test_a_lintel_slides_where_it_is_smoother():
    """Friction .2 on the right: it slides there alone, over .4 m. The left pier carries .7 / 1.1 as much at least."""
    smoother = on_two_piers(0.3, 0.4, joints=[JointLaw(("right", "lintel"), friction=0.2)])
    path = settle_to_collapse(smoother, {"right": (1, 0, 0)}, steps=12)
    assert path.collapse == pytest.approx(0.4, rel=1e-3)
    assert not any("several joints" in warning for warning in path.warnings)


def on_two_edges(movement, turned=(0, 0, 0), origin=(0, 0, 0), **options):
    """The path of a lintel on bearings of .3 and .2 m, of which the right one moves; friction .5."""
    turn = Rotation.from_rotvec(turned).as_matrix()
    ends = {
        "left": ((-1, -1, -1), (0.3, 2, 0)),
        "right": ((2, -1, -1), (3, 2, 0)),
        "lintel": ((0, 0, 0), (2.2, 1, 0.4)),
    }
    blocks = [box(*corners, name=name) for name, corners in ends.items()]
    blocks = [replace(block, vertices=np.asarray(block.vertices, float) @ turn.T + origin) for block in blocks]
    asm = Assembly.from_blocks(blocks, supports=["left", "right"], friction=0.5, gravity=turn @ [0, 0, -9.81])
    return settle_to_collapse(asm, {"right": tuple(turn @ np.asarray(movement, float))}, **options)


@pytest.mark.parametrize("steps", [30, 60])
def test_a_lintel_whose_end_has_come_to_the_rim_of_its_bearing_is_not_held_by_that(steps):
    """It falls when the distance of its right lower corner C from the left rim E is its length, 2.2 m.

    Turned by t it sticks to E and slides at C on the right pier. E is x = 1.9 cos t beside C and z = 1.9 sin t above.
    The right force leans by phi, tan phi = .5, and meets the weight, which acts a = 1.1 cos t - .2 sin t beside C, at a
    height of -a / tan phi. The left one, at an angle g with the normal, meets it at z + (x - a) / tan(t - g). Where g
    reaches phi, it slides at E instead: from there on C goes with the right pier, by 1 across and 2 down.
    """

    def beyond_friction(t):
        x, z, arm = 1.9 * np.cos(t), 1.9 * np.sin(t), 1.1 * np.cos(t) - 0.2 * np.sin(t)
        return z + (x - arm) / np.tan(t - np.arctan(0.5)) + arm / 0.5

    turn = brentq(beyond_friction, 0.01, 0.4)
    begins = 1.9 * np.sin(turn) * np.sqrt(5) / 2
    falls = brentq(
        lambda s: np.hypot(1.9 * np.cos(turn) + (s - begins) / np.sqrt(5), 2 * s / np.sqrt(5)) - 2.2, begins, 1.0
    )
    path = on_two_edges((1, 0, -2), steps=steps)
    assert path.events[0].parameter == pytest.approx(begins, rel=1e-4)
    assert path.collapse == pytest.approx(falls, rel=1e-4)


@pytest.mark.parametrize("turned", [(0, 0, 0), (0, 2, 1), (-1, 2, 0.5)])
def test_a_lintel_whose_corner_has_come_to_the_rim_of_the_pier_that_leaves_is_not_held_by_that(turned):
    """It sticks to the left rim, 1.9 m from the corner, and turns about it as the right pier goes by z across and down.

    The corner leaves that pier, whose rim was at 1.7 m, at 1.9^2 - z^2 = (1.7 + z)^2.
    """
    path = on_two_edges((1, 0, -1), turned, origin=(5e5, 4.6e6, 120))
    across = (np.sqrt(3.4**2 + 8 * (1.9**2 - 1.7**2)) - 3.4) / 4
    assert path.collapse == pytest.approx(across * np.sqrt(2), rel=1e-4)


def test_the_reaction_at_the_end_is_the_last_that_the_arch_has_before_it_falls():
    # As a survey writes it, an arch is turned, far from the origin, and rounded to 0.1 mm. It falls into a pose that
    # forces balance at that very movement, pulling its support; it stands in none.
    blocks = arch(span=1.85, thickness=0.15, depth=0.5, voussoirs=10, springers=0.3)
    ring = assemble(blocks, friction=0.7)
    clean = settle_to_collapse(ring, {"springer.right": (1, 0, 0)})
    turn = Rotation.from_euler("z", 143.1, degrees=True)
    surveyed = [
        replace(block, vertices=np.round(turn.apply(block.vertices) + [452000.3, 5021000.7, 130.2], 4))
        for block in blocks
    ]
    rough = Assembly.from_blocks(surveyed, supports=["springer.left", "springer.right"], friction=0.7)
    found = settle_to_collapse(rough, {"springer.right": turn.apply((1, 0, 0)).tolist()}, displacement=0.2)
    assert found.outcome is PathOutcome.COLLAPSE
    # The thrust of an arch on spreading supports grows until it falls.
    assert (np.diff(found.reaction) > 0).all()
    assert found.reaction[-1] == pytest.approx(clean.reaction[-1], rel=1e-3)
    assert [width for _, width in found.cracks()] == pytest.approx([w for _, w in clean.cracks()], rel=0.02)
    assert [event.after for event in found.events] == [None]
    assert len(found.poses) == len(found.displacement) == len(found.openings)


def test_cracks_at_a_movement_are_those_of_a_path_that_ends_there():
    ring = assemble(arch(span=1.85, thickness=0.15, depth=0.5, voussoirs=10, springers=0.3), friction=0.7)
    spreads = {"springer.right": (1, 0, 0)}
    coarse = settle_to_collapse(ring, spreads, steps=4)
    for movement in (0.005, 0.05):
        assert not np.isclose(coarse.displacement, movement, rtol=1e-3).any()
        exact = settle_to_collapse(ring, spreads, displacement=movement).cracks()
        assert [width for _, width in exact[:3]] == pytest.approx(
            [width for _, width in coarse.cracks(movement)[:3]], rel=0.01
        )
    assert coarse.cracks(0.0) == []
    assert coarse.cracks(coarse.collapse) == coarse.cracks()


@pytest.mark.parametrize("movement", [-0.001, 0.06])
def test_cracks_beyond_a_path_are_not_known(movement):
    found = settle_to_collapse(portal(), SINKS, displacement=0.05, steps=3)
    with pytest.raises(InputError, match=r"it must be from 0 to 0\.05"):
        found.cracks(movement)


def test_the_first_motion_of_a_symmetrical_arch_is_the_one_that_goes_on():
    ring = assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    begins, spreads = 1e-3, {"springer.right": (1, 0, 0)}
    path = settle_to_collapse(ring, spreads, displacement=begins, steps=2)
    first = [(crack.blocks, crack.opening * begins) for crack in path.first.cracks() if crack.opening > 1e-6]
    assert len(first) == 3  # hinges
    assert dict(first) == pytest.approx(dict(path.cracks()), rel=0.01)


#: Corners of the stones of a flat arch and of its abutments in their plane; joints lie on the first and third sides.
STONES = {
    "v0": [(-0.75, 0), (-0.911, 0.6), (-0.304, 0.6), (-0.25, 0)],
    "v1": [(-0.25, 0), (-0.304, 0.6), (0.304, 0.6), (0.25, 0)],
    "v2": [(0.25, 0), (0.304, 0.6), (0.911, 0.6), (0.75, 0)],
    "L": [(-2.75, 0), (-2.75, 0.6), (-0.911, 0.6), (-0.75, 0)],
    "R": [(0.75, 0), (0.911, 0.6), (2.75, 0.6), (2.75, 0)],
}


def unbalanced(stones, pose, movement, friction):
    """The least part of the weight of the three stones that no forces on their corners balance, by an own program."""
    shapes, centroid = [], (stones.centroid + pose.displacement)[:, [0, 2]]
    for k, corners in enumerate(STONES.values()):
        turned = (np.array(corners) - stones.centroid[k, [0, 2]]) @ pose.rotation[k][[0, 2]][:, [0, 2]].T
        shapes.append(centroid[k] + turned + (movement if k == 4 else 0.0))
    columns = []
    for one, two in [(0, 3), (3, 0), (0, 1), (1, 0), (1, 2), (2, 1), (2, 4), (4, 2)]:  # corners of one on sides of two
        for side in (0, 2):
            start, along = shapes[two][side], shapes[two][side + 1] - shapes[two][side]
            length = np.linalg.norm(along)
            along = along / length
            normal = np.array([-along[1], along[0]])  # the corners go clockwise
            for corner in shapes[one]:
                if abs((corner - start) @ normal) < 1e-7 and -1e-9 < (corner - start) @ along < length + 1e-9:
                    for sign in (1, -1):
                        force, column = normal + sign * friction * along, np.zeros(15)
                        for block, way in ((one, 1), (two, -1)):
                            arm = corner - centroid[block]
                            column[3 * block :][:3] = way * np.array([*force, arm[0] * force[1] - arm[1] * force[0]])
                        columns.append(column[:9])
    weight = np.zeros(9)
    weight[1::3] = stones.mass[:3] / stones.mass[:3].sum()
    matrix = np.hstack([np.array(columns).T, np.eye(9), -np.eye(9)])
    cost = np.concatenate([np.zeros(len(columns)), np.ones(18)])
    return linprog(cost, A_eq=matrix, b_eq=weight).fun


@pytest.mark.parametrize("steps", [30, 60])
def test_a_flat_arch_whose_stones_slip_a_little_stands_until_its_hinges_are_in_line(steps):
    """At .075 m a pose of finite steps is off balance by 1e-4 of the weight: a slip of a millimetre, and no fall."""
    blocks = [prism(corners[::-1], 1.0, name=name) for name, corners in STONES.items()]
    friction, way = 0.85, np.array([1, 0, 0.12]) / np.hypot(1, 0.12)
    stones = Assembly.from_blocks(blocks, supports=("L", "R"), friction=friction)
    found = settle_to_collapse(stones, {"R": tuple(way)}, displacement=1.5, steps=steps)
    assert found.outcome is PathOutcome.COLLAPSE
    assert 0.3 < found.collapse
    assert found.reaction.max() > 10 * found.reaction[0]  # three hinges are almost in line
    for k in np.searchsorted(found.displacement, [0.05, 0.09, 0.15, 0.25, 0.33]):
        assert unbalanced(stones, found.poses[k], found.displacement[k] * way[[0, 2]], friction) < 1e-6
