"""What a user is told of an assembly that does not stand, and what would hold it."""

import json
import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from blockstat import (
    Assembly,
    InputError,
    InputWarning,
    Tie,
    assess,
    box,
    plot_forces,
    plot_settlement,
    plot_utilisation,
    read,
    settle,
    thrust_range,
    write,
)
from blockstat.cli.commands import app
from blockstat.cli.options import _status, lengths
from blockstat.view.painter import view_of
from blockstat.view.settling import DRAWN, SINKING
from evidence.scenes.small import arch, stack

GROUND = box((-2, -1, -1), (1, 1, 0), name="ground")
LEANING = Assembly.from_blocks([GROUND, box((0, 0, 0), (3, 1, 1), name="block")], supports=[0], density=1000.0)


def run(*arguments):
    return _status(lambda: app(list(map(str, arguments)), standalone_mode=False), "blockstat")


def answer(capsys, *arguments):
    assert run(*arguments, "--json") == 0
    return json.loads(capsys.readouterr().out)


def test_what_does_not_stand_is_not_said_to_settle_or_to_thrust():
    with pytest.raises(InputError, match="does not stand as it is; it falls without any movement of its supports"):
        settle(LEANING, {"ground": (0, 0, -0.01)})
    with pytest.raises(InputError, match="does not stand as it is; this is asked of what stands"):
        thrust_range(LEANING, ["ground"], (1, 0, 0))


def test_that_no_forces_balance_is_said_in_words():
    told = assess(LEANING).explain()
    assert "No normal forces at all, however large, balance the blocks." in told
    assert "inf" not in told


def test_joints_that_do_not_close_are_told_of_what_falls_too():
    apart = [GROUND, box((0, 0, 0.002), (3, 1, 1.002), name="block")]
    verdict = assess(Assembly.from_blocks(apart, supports=[0]))
    assert verdict.outcome.word == "unstable"
    assert "1 of 1 joints do not quite close (up to 2 mm) and count as touching" in verdict.warnings


def test_the_least_friction_on_a_slope_is_its_tangent(tmp_path, capsys):
    path = write(stack(1), tmp_path / "stone.json")
    found = answer(capsys, "friction", path, "--tilt", "y,20")
    assert found["stands"] == pytest.approx(math.tan(math.radians(20)), abs=1e-5)
    assert found["falls"] <= found["stands"]


def test_a_tie_needs_the_force_of_moment_balance(tmp_path, capsys):
    """The block of 29,430 N leans out by half a metre, and the tie pulls with a lever arm of sqrt 2 m."""
    path, tied = write(LEANING, tmp_path / "leaning.json"), tmp_path / "tied.json"
    ends = "-1,500 mm,0,0,0.5,1"
    found = answer(capsys, "tie", path, "--between", "ground,block", "--points", ends, "-o", tied)
    assert found["least"] == pytest.approx(29430 * 0.5 / math.sqrt(2), rel=1e-5)
    assert assess(read(tied)).outcome.word == "stable"


def test_a_tie_that_cannot_hold_says_so(tmp_path, capsys):
    path = write(LEANING, tmp_path / "leaning.json")
    ends = "0.5,0.5,-1,0.5,0.5,0"  # it pulls down, behind the edge by half a metre, without a limit
    assert run("tie", path, "--between", "ground,block", "--points", ends) == 0
    ends = "2.5,0.5,-1,2.5,0.5,0"  # it pulls down beyond the edge
    assert run("tie", path, "--between", "ground,block", "--points", ends) == 2
    assert 'no force of tie "ground,block" within its bounds makes it stand' in capsys.readouterr().err
    assert run("tie", path, "--between", "block") == 2
    assert run("tie", path, "--between", "ground,block", "-o", tmp_path / "a.obj") == 2


@pytest.mark.parametrize("ends", [("a", "b"), ("a", "right")])
def test_a_tie_resists_supports_that_part_with_all_its_force(ends):
    """Two blocks on two supports: the friction of each bears more than the tie, so the tie yields."""
    blocks = [box((0, 0, -1), (1, 1, 0), name="left"), box((3, 0, -1), (4, 1, 0), name="right")]
    blocks += [box((0, 0, 0), (1, 1, 1), name="a"), box((3, 0, 0), (4, 1, 1), name="b")]
    tie = Tie(ends, ((0.5, 0.5, 0.0), (3.5, 0.5, 0.0)), greatest=500.0)
    tied = Assembly.from_blocks(blocks, supports=[0, 1], density=1000.0, friction=0.7, ties=[tie])
    assert settle(tied, {"right": (0.01, 0, 0)}).reaction == pytest.approx(-500.0)
    assert settle(tied, {"right": (-0.01, 0, 0)}).reaction == pytest.approx(0.0, abs=1e-3)  # it slackens


def test_lengths_have_units_or_are_metres():
    assert lengths("0, 1.5,-10 mm", 3, "--move", "X") == [0.0, 1.5, -0.01]
    assert lengths("1e1cm,2in,-.5 m", 3, "--move", "X") == pytest.approx([0.1, 0.0508, -0.5])
    for bad in ("1,2", "1,2,3 miles", "1,2,mm", "0,0,inf m"):
        with pytest.raises(InputError, match=f'--move is "{bad}"; it must read X'):
            lengths(bad, 3, "--move", "X")


def test_a_movement_takes_units_and_one_beyond_the_blocks_is_doubted(tmp_path, capsys):
    ring = write(arch(9, 0.4), tmp_path / "ring.json")
    found = answer(capsys, "settle", ring, "--move", "left:-10 mm,0,0")
    assert found["displacement"] == pytest.approx(0.01)
    with pytest.warns(InputWarning, match='--move moves supports by 10 m, .* as in "10 mm"'):
        run("settle", ring, "--move", "left:-10,0,0")


def test_pictures_say_where_forces_are_not_in_equilibrium():
    for plot in (plot_forces, plot_utilisation):
        for assembly, said in ((LEANING, True), (stack(2), False)):
            axes = plt.figure().add_subplot()
            plot(assess(assembly), axes)
            assert ("not in equilibrium" in axes.get_title()) is said


def test_the_joint_of_a_support_is_drawn_where_the_support_goes():
    found = settle(arch(9, 0.4), {"left": (-0.02, 0, 0)})
    axes = plt.figure().add_subplot()
    plot_settlement(found, axes)
    orange = [c for c in axes.collections if isinstance(c, PolyCollection) and np.allclose(c.get_facecolor(), SINKING)]
    drawn = np.array(orange[0].get_paths()[0].vertices[:-1])
    outline = found.interfaces.outline(int(found.foundations[0].joints[0]))
    shift = (drawn - outline @ view_of(-55.0, 25.0)[:2].T).mean(axis=0)
    direction = view_of(-55.0, 25.0)[:2] @ np.array([-1.0, 0, 0])
    assert shift[0] * direction[1] == pytest.approx(shift[1] * direction[0], abs=1e-9)
    assert shift @ direction > 0.1 * DRAWN
