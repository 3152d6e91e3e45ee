"""Supports that move in whole or in part, and the cracks that follow."""

import inspect
import json
import subprocess
import sys

import numpy as np
import pytest

from blockstat import Assembly, InputError, JointLaw, Tie, box, plot_settlement, point_load, settle, settlement, write
from evidence.scenes.small import arch, assembly
from thin_contacts import extruded


def beam(**options):
    """A lintel 3 m long on two piers of .5 m, which stand on one slab of ground."""
    blocks = [
        box((-1, -1, -1), (5, 2, 0), name="ground", group="ground"),
        box((0, 0, 0), (0.5, 1, 2), name="left", group="pier.left"),
        box((2.5, 0, 0), (3, 1, 2), name="right", group="pier.right"),
        box((0, 0, 2), (3, 1, 2.5), name="lintel", group="lintel"),
    ]
    return Assembly.from_blocks(blocks, supports=["ground"], name="beam", density=1000.0, **options)


@pytest.mark.parametrize("k", range(12))
@pytest.mark.parametrize("way", [(0.01, 0, 0), (0.01, 0.005, 0)])
def test_blocks_that_ride_along_with_a_support_resist_nothing(k, way):
    """No force does work on a column that moves with its ground: there is no reaction."""
    blocks = [box((-3, -1, -1), (0, 2, 0), name="still"), box((0, -1, -1), (4, 2, 0), name="moves")]
    blocks += [box((0.2 + 0.01 * k, 0, 0.3 * i), (1.1 + 0.03 * k, 1, 0.3 * (i + 1))) for i in range(4)]
    blocks.append(box((-2, 0, 0), (-1, 1, 0.7 + 0.1 * k)))
    found = settle(Assembly.from_blocks(blocks, supports=["still", "moves"], density=2000.0), {"moves": way})
    assert found.reaction == 0.0
    assert found.outcome.word == "free"


@pytest.mark.parametrize("end", ["a", "b"])
def test_a_support_that_sinks_from_below_a_beam_carries_nothing(end):
    """A beam from 0 to 4.2 m on supports at 0, 1.5 and 4: its centre at 2.1 is between the two that stay.

    Without the one at 0 it lies on those at 1.5 to 1.7 and 4 to 4.2; without the one at 1.5 on those at its ends.
    """
    supports = [box((x, 0, 0), (x + 0.2, 1, 1), name=name) for x, name in ((0, "a"), (1.5, "b"), (4, "c"))]
    on_three = Assembly.from_blocks([*supports, box((0, 0, 1), (4.2, 1, 1.4), name="beam")], supports=["a", "b", "c"])
    found = settle(on_three, {end: (0, 0, -0.01)})
    assert (found.outcome.word, found.reaction) == ("free", 0.0)
    np.testing.assert_array_equal(found.foundations[0].reaction, 0)
    assert f'"{end}" moves by (0, 0, -10) mm with 1 joint on it, and carries (0, 0, 0) N.' in found.explain()


def opening(found, a, b):
    return {crack.blocks: crack.opening for crack in found.cracks()}.get((a, b), 0.0)


WEIGHTS = 1000.0 * 9.81 * np.array([1.0, 1.0, 1.5])  #: of the piers and the lintel [N]


@pytest.mark.parametrize(
    "where",
    ["right", "pier.right", (2, -1, -1, 4, 2, 1), (4, 2, 1, 2, -1, -1)],
    ids=["block", "group", "region", "region from its other corner"],
)
def test_the_ground_sinks_below_one_pier_alone(where):
    # The lintel turns by s / 2.5 about the left pier's inner edge and the right one's outer edge, and both its ends
    # open by half a metre of that. The right pier sinks with half the lintel: that is what it carries.
    found = settle(beam(), {where: (0, 0, -0.01)})
    assert opening(found, "left", "lintel") == pytest.approx(0.5 * 0.01 / 2.5, rel=1e-5)
    assert opening(found, "right", "lintel") == pytest.approx(0.5 * 0.01 / 2.5, rel=1e-5)
    assert opening(found, "ground", "right") == pytest.approx(0, abs=1e-7)
    np.testing.assert_allclose(found.mechanism[2], [0, 0, -0.01, 0, 0, 0], atol=1e-7)
    np.testing.assert_allclose(found.mechanism[[0, 1]], 0, atol=1e-7)
    # Reactions at the edges x = .5 and 3: moments of the lintel about .5 give W (1.5 - .5) / 2.5 on the right.
    assert found.reaction == pytest.approx(WEIGHTS[1] + 0.4 * WEIGHTS[2], rel=1e-6)
    np.testing.assert_allclose(found.foundations[0].reaction[2], -found.reaction, rtol=1e-6)
    assert found.displacement == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("end", "words"),
    [(2.6, "from 2.5 to 3 m in x, the box from 2 to 2.6 m"), (2.9, "from 2.5 to 3 m in x, the box from 2 to 2.9 m")],
    ids=["centre outside", "centre inside"],
)
def test_a_box_that_cuts_a_joint_is_refused(end, words):
    """The joint of the right pier is from 2.5 to 3 m: the ground parts below it, which no motion of the whole shows."""
    with pytest.raises(InputError) as refused:
        settle(beam(), {(2, -1, -1, end, 2, 1): (0, 0, -0.01)})
    assert str(refused.value) == (
        f'region (2, -1, -1, {end}, 2, 1): the joint of "ground" and "right" lies partly in this box: it is {words}; '
        "the box must hold whole joints, so divide the support or the block there, or take a box that holds the joint"
    )


@pytest.mark.parametrize(
    "box_of",
    [
        (2.5, 0, -1, 3, 1, 0),
        (2.5 + 1e-7, 0, 0, 3, 1 - 1e-7, 0),
        (0.5, -1, -1, 5, 2, 1),
        (0.5 - 1e-7, -1, -1, 5, 2, 0),
    ],
    ids=["its rim", "its rim, rounded", "the rim of the other", "the rim of the other, rounded"],
)
def test_a_box_may_touch_the_rim_of_a_joint(box_of):
    found = settle(beam(), {box_of: (0, 0, -0.01)})
    assert found.foundations[0].joints.tolist() == [1]
    assert found.reaction == pytest.approx(WEIGHTS[1] + 0.4 * WEIGHTS[2], rel=1e-6)


def test_a_box_whose_corner_cuts_a_slanting_joint_is_told_from_one_beside_it():
    """A joint in the plane x = z from (0, 0) to (1, 1): the box of its corners holds more than the joint."""
    ground = extruded([(0, 0), (1, 0), (1, 1)], 0, 1, name="ground")
    wedge = extruded([(0, 0), (1, 1), (0, 1)], 0, 1, name="wedge")
    slope = Assembly.from_blocks([ground, wedge], supports=["ground"], friction=2.0)
    with pytest.raises(InputError, match=r"region .*: no joint of a support lies in this box"):
        settle(slope, {(0.6, -1, -1, 3, 2, 0.5): (0, 0, -0.01)})
    with pytest.raises(InputError, match=r"from 0 to 1 m in z, the box from -1 to 0.5 m;"):
        settle(slope, {(0.4, -1, -1, 3, 2, 0.5): (0, 0, -0.01)})


def lintel():
    """A lintel of 2 m on two piers of .5 m that cannot move by themselves, and its weight."""
    piers = [box((x, 0, 0), (x + 0.5, 1, 2), name=name) for x, name in ((0, "left"), (1.5, "right"))]
    blocks = [*piers, box((0, 0, 2), (2, 1, 2.5), name="lintel")]
    asm = Assembly.from_blocks(blocks, supports=["left", "right"], density=1000.0)
    return asm, asm.free_weight


@pytest.mark.parametrize(
    ("load", "gravity", "expected"), [(0, None, 1 / 3), (0.5, None, 1 / 3 + 0.5), (0, 2, 2 / 3), (0.5, 2, 2 / 3 + 0.5)]
)
def test_a_pier_that_sinks_carries_what_moments_say(load, gravity, expected):
    """Moments about the inner edge of the left pier, x = .5: W at 1 and a load at 2 against the outer edge at 2."""
    asm, weight = lintel()
    options = {
        "loads": point_load(asm, "lintel", (2, 0.5, 2.5), (0, 0, -load * weight)),
        "gravity": None if gravity is None else (0, 0, -gravity * 9.81),
    }
    found = settle(asm, {"right": (0, 0, -0.015)}, **options)
    assert found.reaction == pytest.approx(expected * weight, rel=1e-6)
    assert found.foundations[0].reaction[2] == pytest.approx(-expected * weight, rel=1e-6)
    assert settlement(asm, ["right"], (0, 0, -2), **options).reaction == pytest.approx(expected * weight, rel=1e-6)


@pytest.mark.parametrize("friction", [0.3, 0.5])
def test_a_pier_that_moves_out_is_held_by_the_friction_of_half_a_lintel(friction):
    """The thrust is at most the friction on either pier, and so greatest where both carry half."""
    asm, weight = lintel()
    held = pytest.approx(-friction * weight / 2, rel=1e-6)
    assert settle(asm, {"right": (0.01, 0, 0)}, friction=friction).reaction == held
    assert settlement(asm, ["right"], (1, 0, 0), friction=friction).reaction == held


def test_all_is_in_proportion_to_the_movement():
    one, two = (settle(beam(), {"right": (0, 0, -s)}) for s in (0.01, 0.02))
    np.testing.assert_allclose(two.joint_motion, 2 * one.joint_motion, atol=1e-9)
    assert two.reaction == pytest.approx(one.reaction)


def test_two_parts_that_sink_alike_crack_nothing():
    found = settle(beam(), {"left": (0, 0, -0.01), "right": (0, 0, -0.01)})
    assert found.cracks() == []
    assert found.reaction == pytest.approx(WEIGHTS.sum(), rel=1e-6)
    whole = settle(beam(), {"ground": (0, 0, -0.01)})
    assert whole.cracks() == []
    assert whole.reaction == pytest.approx(WEIGHTS.sum(), rel=1e-6)


DOWN = ((1.25, 0.5, 0.0), (1.25, 0.5, 2.2))


@pytest.mark.parametrize("options", [
    {"ties": [Tie(("ground", "lintel"), DOWN, 5e3, 5e3)]},
    {"ties": [Tie(("ground", "lintel"), DOWN, 5e3)]},
    {"joints": [JointLaw(("ground", "pier"), bond=5e3, bond_moment=5e3)]},
], ids=["constant", "tie", "bond"])  # fmt: skip
def test_ground_that_sinks_carries_the_weights_whatever_is_pulled_down_on_it(options):
    found = settle(beam(**options), {"ground": (0, 0, -0.01)})
    assert found.reaction == pytest.approx(WEIGHTS.sum(), rel=1e-6)
    np.testing.assert_allclose(found.foundations[0].reaction, (0, 0, -WEIGHTS.sum()), atol=1e-2)


def test_several_supports_move_each_its_own_way():
    # Heyman: an arch whose supports spread by s in all opens at the crown below and at the haunches above; that one
    # support moves by s, or both by s / 2, is the same.
    ring = arch(20, 0.15)
    one = settle(ring, {"right": (0.02, 0, 0)})
    both = settle(ring, {"left": (-0.01, 0, 0), "right": (0.01, 0, 0)})
    weight = ring.free_weight
    # references: H/W at s = 0 for N = 20, t/R = .15.
    assert one.reaction / weight == pytest.approx(0.175634884, abs=1e-6)
    assert 2 * both.reaction / weight == pytest.approx(2 * 2 * 0.175634884, abs=1e-5)
    wide = [sorted(crack.opening for crack in found.cracks()) for found in (one, both)]
    np.testing.assert_allclose(*wide, atol=1e-7)
    old = settlement(ring, ["right"], (1, 0, 0))
    assert old.reaction == pytest.approx(one.reaction, rel=1e-6)


@pytest.mark.parametrize(
    ("moves", "expected"),
    [
        ({}, "no supports move"),
        ({"moon": (0, 0, -1)}, 'foundations: no block "moon"'),
        ({"lintel": (0, 0, -1)}, "it does not stand on a support"),
        ({"right": (0, 0, 0)}, "must be three numbers, not all zero"),
        ({"right": (0, 0, -1), "pier": (0, 0, -1)}, 'two moves share the joint of "ground" and "right"'),
        ({(9, 9, 9, 10, 10, 10): (0, 0, -1)}, "no joint of a support lies in this box"),
    ],
)
def test_errors_say_what_is_wrong(moves, expected):
    with pytest.raises(InputError, match=expected):
        settle(beam(), moves)


def test_a_support_that_only_anchors_a_tie_drags_what_is_tied_to_it():
    """The block slides at .6 of its weight of 1."""
    ground, anchor = box((-5, -5, -1), (5, 5, 0), name="ground"), box((6, 0, -1), (7, 1, 2), name="anchor")
    tie = Tie(("block", "anchor"), ((1, 0.5, 0), (6, 0.5, 0)))
    block = box((0, 0, 0), (1, 1, 1), name="block")
    asm = assembly([ground, block, anchor], supports=["ground", "anchor"], ties=[tie], friction=0.6)
    found = settle(asm, {"anchor": (0.01, 0, 0)})
    assert found.reaction == pytest.approx(settlement(asm, ["anchor"], (1, 0, 0)).reaction) == pytest.approx(-0.6)
    assert [list(part.reaction) for part in found.foundations] == [pytest.approx([-0.6, 0, 0])]
    with pytest.raises(InputError, match='"anchor": nothing rests on it or is tied to it'):
        settle(asm.with_(ties=[]), {"anchor": (0.01, 0, 0)})


def test_what_is_jammed_says_so():
    walls = [box((-1, 0, 0), (0, 1, 2), name="west"), box((1, 0, 0), (2, 1, 2), name="east")]
    wedge = assembly([*walls, box((0, 0, -1), (1, 1, 0), name="floor"), box((0, 0, 0), (1, 1, 1), name="block")],
                     supports=[0, 1, 2])  # fmt: skip
    with pytest.raises(InputError, match="jammed"):
        settle(wedge, {"east": (-0.01, 0, 0)})


def test_the_command_settles_draws_and_explains(tmp_path):
    file, picture = write(beam(), tmp_path / "beam.json"), tmp_path / "settled.png"
    code = "from blockstat.cli.commands import main; main()"

    def run(*arguments):
        command = [sys.executable, "-c", code, "settle", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True)

    answer = run(file, "--move", "pier.right:0,0,-0.01", "-o", picture, "--json")
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    assert told["displacement"] == pytest.approx(0.01)
    assert told["reaction"] == pytest.approx(WEIGHTS[1] + 0.4 * WEIGHTS[2], rel=1e-6)
    assert told["cracks"][0]["opening"] == pytest.approx(0.002, rel=1e-4)
    assert {"collapse", "path"} <= set(told)
    assert (told["friction"], told["density"], told["units"]) == (0.7, 1000.0, "m")
    assert picture.read_bytes().startswith(b"\x89PNG")
    plain = run(file, "--move", "2,-1,-1,4,2,1:0,0,-0.01")
    assert "left and lintel: 2 mm" in plain.stdout
    assert "--move is" in run(file, "--move", "right").stderr


@pytest.mark.parametrize("start", ["-0.2", "-.2", "+-.2", "-.x"])
def test_a_box_begins_with_a_number_however_it_is_written(start, tmp_path, run_command):
    from blockstat.cli.commands import app

    file = write(beam(), tmp_path / "beam.json")
    status, out, error = run_command(app, "blockstat", "settle", file, "--move", f"{start},-1,-1,1,2,1:0,0,-.01")
    if start in ("-0.2", "-.2"):
        # The lintel turns about the inner edge of the other pier: 10 mm x 0.5 m / 2.5 m.
        assert (status, "right and lintel: 2 mm" in out) == (0, True), error
    else:
        assert status == 2
        assert f'no block "{start},-1,-1,1,2,1"' in error.replace("\n", " ")


def test_the_picture_goes_into_axes_too():
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    assert plot_settlement(settle(beam(), {"right": (0, 0, -0.01)}), axes) is axes
    assert axes.collections


def test_two_moves_do_not_share_a_support_that_has_ties_alone():
    """A block that hangs from a roof by three ties, with no joint on it; it sinks as far as the roof does."""
    ends = [((x, y, 3), (x, y, 1)) for x, y in ((0, 0), (1, 0), (0.5, 1))]
    blocks = [box((-1, -1, 3), (2, 2, 4), name="roof"), box((0, 0, 0), (1, 1, 1), name="load")]
    hung = Assembly.from_blocks(blocks, supports=["roof"], ties=[Tie(("roof", "load"), pair) for pair in ends])
    found = inspect.unwrap(settle)(hung, {"roof": (0, 0, -0.01)})  # the checks of `evidence` measure by joints
    np.testing.assert_allclose(found.mechanism[1], [0, 0, -0.01, 0, 0, 0], atol=1e-7)
    with pytest.raises(InputError, match='two moves share the support "roof"; let each support belong to one of them'):
        settle(hung, {"roof": (0, 0, -0.01), 0: (0, 0, -0.01)})


@pytest.mark.parametrize("where", [None, 1.5, frozenset(["right"])])
def test_a_part_that_moves_has_a_name_or_a_number(where):
    with pytest.raises(InputError, match=r"a part that moves is .*; it must be a block, a group or the six numbers"):
        settle(beam(), {where: (0, 0, -0.01)})


def test_a_layer_of_supports_settles_whole():
    # Both posts of a lintel sink alike, as one block of both would.
    blocks = [box((0, 0, 0), (1, 1, 1), name="BASE::left"), box((2, 0, 0), (3, 1, 1), name="BASE::right")]
    gate = assembly([*blocks, box((0, 0, 1), (3, 1, 2), name="lintel")], supports=["BASE"])
    found = settle(gate, {"BASE": (0, 0, -0.01)})
    assert [*found.cracks()] == []
    assert found.mechanism[2, 2] == pytest.approx(-0.01)
