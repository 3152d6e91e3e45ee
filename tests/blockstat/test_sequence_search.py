"""What a search for an order asks for besides statics, and how it is taken up again."""

import gc
import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from blockstat import (
    Assembly,
    InputError,
    JointLaw,
    Outcome,
    Plan,
    Step,
    assess_plan,
    box,
    build,
    count_orders,
    find_interfaces,
    find_order,
    friction_limit,
    load_scene,
    safest_order,
    write,
)
from blockstat.cli.commands import app
from blockstat.sequence import order, plan, search
from blockstat.sequence.insertion import StraightMotions
from blockstat.sequence.states import Whole
from building_sites import arch, prism, slab, tee


def drawer():
    """A drawer below a lid, between two cheeks."""
    blocks = [slab(-1, 4, -0.5, 0, "ground"), slab(0, 1, 0, 1, "left"), slab(2, 3, 0, 1, "right")]
    blocks += [slab(1, 2, 0, 1, "drawer"), slab(0, 3, 1, 1.5, "lid")]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)


def placed(found):
    return [block for step in found.plan.steps for block in step.install]


def test_a_drawer_comes_in_from_the_front_and_not_from_above():
    assembly = drawer()
    motions, everything = StraightMotions(assembly, find_interfaces(assembly)), np.ones(5, dtype=bool)
    assert np.abs(motions.find([3], everything).direction) == pytest.approx([0, 1, 0], abs=1e-6)
    without = everything.copy()
    without[4] = False
    assert motions.find([3], without).direction == pytest.approx([0, 0, -1], abs=1e-6)


def test_walls_before_and_behind_leave_only_the_way_from_above():
    assembly = drawer()
    fences = [box((-1, y, 0), (4, y + 0.5, 3), name=name) for y, name in ((-1, "front"), (1.5, "back"))]
    ground = box((-1, -1, -0.5), (4, 2, 0), name="ground")
    shapes = [(0, 1, 0, 1), (2, 3, 0, 1), (1, 2, 0, 1), (0, 3, 1, 1.5)]
    blocks = [slab(*shape, name) for shape, name in zip(shapes, assembly.names[1:], strict=True)]
    fenced = Assembly.from_blocks([ground, *fences, *blocks], supports=["ground", "front", "back"], friction=0.6)
    assert StraightMotions(fenced, find_interfaces(fenced)).find([5], np.ones(7, dtype=bool)).direction is None
    found = find_order(fenced, held_at_most=1, insertion=True)
    assert placed(found)[-1] == "lid"
    assert all(way == pytest.approx([0, 0, -1], abs=1e-6) for way in found.plan.metadata["insertion"].values())


def found_with_insertion(blocks, supports):
    assembly = Assembly.from_blocks(blocks, supports=supports, friction=0.6)
    return find_order(assembly, held_at_most=1, insertion=True)


def test_a_block_below_a_canopy_that_it_does_not_touch_slides_in_sideways():
    """Its one joint has its normal upwards, where the canopy is."""
    ground, stone = box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="stone")
    canopy = box((-1, -1, 1.5), (2, 2, 2), name="canopy")
    found = found_with_insertion([ground, stone, canopy], ["ground", "canopy"])
    assert found.outcome.word == "found"
    assert found.plan.metadata["insertion"]["stone"][2] == pytest.approx(0, abs=1e-9)


def test_a_block_comes_up_or_down_a_slope_where_it_is_shut_in_on_all_other_sides():
    """A slope of .5 below a canopy as steep, .5 above the block, and walls on both sides: along the slope alone."""
    blocks = [
        prism([(-6, -8), (8, -8), (8, 4), (-6, -3)], "ground"),
        prism([(0, 0), (1, 0.5), (1, 1.5), (0, 1)], "one"),
    ]
    blocks += [prism([(-6, -1.5), (8, 5.5), (8, 7), (-6, 0)], "canopy")]
    blocks += [box((-6, y, -8), (8, y + 0.5, 8), name=name) for y, name in ((-0.6, "front"), (1.1, "back"))]
    found = found_with_insertion(blocks, ["ground", "canopy", "front", "back"])
    assert found.outcome.word == "found"
    assert np.abs(found.plan.metadata["insertion"]["one"]) == pytest.approx(np.array([2, 0, 1]) / np.sqrt(5))


def test_a_direction_that_only_a_neighbour_suggests_stays_in_the_plan_when_the_neighbour_is_gone():
    """Under a canopy and between walls a stone comes in along its sloping top, over the low wall on one side.

    The slope is that of the joint with its cap. The cap is taken off first, and no joint has the slope then.
    """
    blocks = [box((-9, -9, -1), (9, 9, 0), name="ground"), box((-1, -2, 4), (2, 3, 5), name="canopy")]
    blocks += [box((-9, y, 0), (9, y + 1, 8), name=name) for y, name in ((-1.5, "front"), (1.5, "back"))]
    blocks += [box((-8, -0.5, 0), (-7, 1.5, 8), name="high"), box((6, -0.5, 0), (7, 1.5, 0.9), name="low")]
    stone = prism([(0, 0), (1, 0), (1, 1.2), (0, 1)], "stone")
    cap = prism([(0, 1), (1, 1.2), (1, 1.7), (0, 1.5)], "cap")
    found = found_with_insertion([*blocks, stone, cap], [block.name for block in blocks])
    assert placed(found) == ["stone", "cap"]
    ways = found.plan.metadata["insertion"]
    assert ways["stone"] == pytest.approx(np.array([-1, 0, -0.2]) / np.sqrt(1.04))
    assert set(ways) == {"stone", "cap"}


def closed_room(side):
    """A cube in a box of six walls that are so far from it on all sides but below."""
    low, high = -side, 1 + side
    walls = {
        "floor": ((low - 1, low - 1, -1), (high + 1, high + 1, 0)),
        "roof": ((low - 1, low - 1, high), (high + 1, high + 1, high + 1)),
        "west": ((low - 1, low, 0), (low, high, high)),
        "east": ((high, low, 0), (high + 1, high, high)),
        "front": ((low, low - 1, 0), (high, low, high)),
        "back": ((low, high, 0), (high, high + 1, high)),
    }
    blocks = [box(*corners, name=name) for name, corners in walls.items()]
    return [*blocks, box((0, 0, 0), (1, 1, 1), name="stone")], list(walls)


def test_that_there_is_no_way_in_is_said_only_where_joints_block_every_direction():
    """In a room of its own size a cube cannot move at all; in a larger one it can, and not all ways out are tried."""
    tight, wide = (found_with_insertion(*closed_room(side)) for side in (0.0, 0.25))
    assert (tight.outcome.word, tight.barred) == ("none", ())
    assert (wide.outcome.word, wide.barred, wide.undecided) == ("undecided", ("stone",), 0)
    assert "No straight motion was found for stone, nor proven not to exist." in wide.explain()
    assert "every way has been tried" not in wide.explain()


#: A channel, 2 x 1 with legs of .5 and a back of .5, open downwards.
CHANNEL = [(-1, 0), (-0.5, 0), (-0.5, 1), (0.5, 1), (0.5, 0), (1, 0), (1, 1.5), (-1, 1.5)]


def test_a_block_with_a_notch_is_put_over_the_post_that_fills_it():
    """Smaller about its centroid, the legs would run into the post."""
    blocks = [slab(-2, 2, -1, 0, "ground"), slab(-0.5, 0.5, 0, 1, "post"), prism(CHANNEL, "channel")]
    found = found_with_insertion(blocks, ["ground", "post"])
    assert found.outcome.word == "found"
    assert found.plan.metadata["insertion"]["channel"] == pytest.approx([0, 0, -1], abs=1e-9)


def test_a_block_with_a_hook_is_not_lifted_but_slid_in():
    """Its lip is below a ledge. Cheeks leave the way away from the post alone, and a wall there leaves none."""
    hook = prism([(0, 0), (1, 0), (1, 2), (-1, 2), (-1, 1.5), (0, 1.5)], "hook")
    post = [(-2, 0), (0, 0), (0, 1.5), (-1, 1.5), (-1, 2), (1, 2), (1, 2.5), (-2, 2.5)]
    free = [box((-3, -1, -1), (3, 2, 0), name="ground"), prism(post, "post"), hook]
    cheeks = [box((-3, y, 0), (3, y + 1, 3), name=name) for y, name in ((-1, "front"), (1, "back"))]
    found = found_with_insertion(free, ["ground", "post"])
    assert found.plan.metadata["insertion"]["hook"][2] == pytest.approx(0, abs=1e-9)
    between = found_with_insertion([*free, *cheeks], ["ground", "post", "front", "back"])
    assert between.plan.metadata["insertion"]["hook"] == pytest.approx([-1, 0, 0], abs=1e-9)
    walled = [*free, *cheeks, slab(1, 2, 0, 2, "wall")]
    assert found_with_insertion(walled, ["ground", "post", "front", "back", "wall"]).outcome.word == "none"


def test_a_group_is_put_in_as_one_in_one_hand():
    assembly = tee()
    assert find_order(assembly, held_at_most=1).outcome.word == "none"
    found = find_order(assembly, held_at_most=1, groups=[["left", "right", "top"]])
    assert found.outcome.word == "found"
    assert {"left", "right", "top"} in [set(step.install) for step in found.plan.steps]
    assert assess_plan(assembly, found.plan).outcome.word == "stable"
    with pytest.raises(InputError, match='groups: block "ground" is a support'):
        find_order(assembly, held_at_most=1, groups=[["ground", "base"]])
    with pytest.raises(InputError, match='groups: block "top" is in two groups'):
        find_order(assembly, held_at_most=1, groups=[["top"], ["top", "left"]])


def test_a_group_comes_in_along_one_direction_that_is_free_for_all_its_blocks():
    """Two stones, each in a niche that fills it but for one side: these look away from each other, or the same way."""

    def niches(*open_to_the_right):
        blocks, cheeks = [], []
        for k, right in enumerate(open_to_the_right):
            y, end = 5.0 * k, -1 if right else 1
            cheeks += [
                box((0, y - 1, z), (1, y + 2, z + 1), name=f"{name}{k}") for z, name in ((-1, "floor"), (1, "lid"))
            ]
            cheeks += [
                box((0, y + s, 0), (1, y + s + 1, 1), name=f"{name}{k}") for s, name in ((-1, "front"), (1, "back"))
            ]
            cheeks.append(box((end, y, 0), (end + 1, y + 1, 1), name=f"end{k}"))
            blocks.append(box((0, y, 0), (1, y + 1, 1), name=f"stone{k}"))
        return Assembly.from_blocks([*cheeks, *blocks], supports=[block.name for block in cheeks], friction=0.6)

    options = {"held_at_most": 1, "insertion": True}
    both = [["stone0", "stone1"]]
    assert find_order(niches(False, True), **options).outcome.word == "found"
    assert find_order(niches(False, True), groups=both, **options).outcome.word == "none"
    found = find_order(niches(True, True), groups=both, **options)
    ways = found.plan.metadata["insertion"]
    assert ways == {"stone0": pytest.approx([-1, 0, 0]), "stone1": pytest.approx([-1, 0, 0])}


def test_what_is_there_before_a_block_counts_its_supports():
    seen = []

    def reach(block, there):
        seen.append((block, there))
        return "ground" in there

    assert find_order(tee(), held_at_most=2, reach=reach).outcome.word == "found"
    assert ("base", frozenset({"ground"})) in seen
    assert not any(block in there for block, there in seen)


def test_a_crane_that_reaches_no_block_behind_another_builds_the_far_one_first():
    assembly = drawer()

    def reach(block, present):
        return block != "left" or "right" not in present

    order = placed(find_order(assembly, held_at_most=1, reach=reach))
    assert order.index("left") < order.index("right")
    assert find_order(assembly, held_at_most=1, reach=lambda block, present: block != "lid").outcome.word == "none"


KILLED = """
import os, signal
from blockstat import find_order
from building_sites import arch
calls = []

def reach(block, present):
    calls.append(block)
    if len(calls) == {calls}:
        os.kill(os.getpid(), signal.SIGKILL)
    return True

find_order(arch(), held_at_most=2, reach=reach, journal={path!r})
"""


def test_a_search_that_was_killed_goes_on_with_nothing_lost(tmp_path):
    path = tmp_path / "journal.jsonl"
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(root), *sys.path])}
    ended = subprocess.run(
        [sys.executable, "-c", KILLED.format(calls=30, path=str(path))], env=environment, check=False
    )
    assert ended.returncode == -signal.SIGKILL
    kept = path.read_text().splitlines()
    assert len(kept) > 5
    path.write_text("\n".join(kept) + '\n["0x1", "0x')  # and the last line was cut short
    found = find_order(arch(), held_at_most=2, journal=path)
    lines = path.read_text().splitlines()
    assert lines[: len(kept)] == kept
    assert found.outcome.word == "found"
    assert len(lines) - 1 == found.states
    assert placed(found) == placed(find_order(arch(), held_at_most=2, journal=tmp_path / "fresh.jsonl"))
    assert find_order(arch(), held_at_most=2, journal=path).solved == 0


def slope(tangent=0.3):
    """Two cubes on a slope, the lower one against a stop, all square to the slope."""
    turn = np.arctan(tangent)

    def turned(points):
        x, z = np.transpose(points)
        return list(zip(x * np.cos(turn) - z * np.sin(turn), x * np.sin(turn) + z * np.cos(turn), strict=True))

    def cube(x, name):
        return prism(turned([(x, 0), (x + 0.5, 0), (x + 0.5, 0.5), (x, 0.5)]), name)

    blocks = [prism(turned([(-0.5, -0.5), (2, -0.5), (2, 0), (0, 0), (0, 0.5), (-0.5, 0.5)]), "ground")]
    blocks += [cube(0, "low"), cube(0.5, "high")]
    return Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)


def test_the_safest_order_on_a_slope_begins_at_the_stop():
    """Alone on the slope the upper cube needs a friction of .3, its tangent; against the lower one it needs none."""
    found = safest_order(slope(), held_at_most=1)
    assert placed(found.found) == ["low", "high"]
    assert found.least_friction == (0.0, 0.0)
    assert found.reserve == np.inf
    other = Plan((Step(("high",)), Step(("low",))))
    assert assess_plan(slope(), other, reserve=True).least_friction[1] == pytest.approx(0.3, abs=1e-4)


def test_no_order_of_an_arch_needs_less_friction_than_the_arch():
    found = safest_order(arch(), held_at_most=2)
    low, high = found.least_friction
    needed = friction_limit(arch())
    assert low < needed.stands
    assert needed.falls < high <= low + 1e-3
    assert found.reserve == pytest.approx(0.6 / high)
    assert assess_plan(arch(), found.found.plan, friction=1.001 * high).outcome.word == "stable"


def test_an_assembly_that_falls_when_finished_has_no_order():
    found = find_order(arch(), held_at_most=2, friction=0.2)
    assert (found.outcome.word, found.finished.word, found.states) == ("none", "unstable", 1)
    said = found.explain()
    assert said.startswith("None: the finished assembly itself does not stand, and every order ends with it; first to")
    assert set(found.moving) <= {f"s{k}" for k in range(7)}
    assert "every way has been tried" not in said
    assert safest_order(arch(), held_at_most=2, friction=0.2).least_friction is None


def test_an_interrupt_before_the_finished_assembly_is_judged_says_nothing_of_it(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(Whole, "assess", interrupted)
    found = find_order(arch(), held_at_most=2, friction=0.2)  # it would fall
    assert (found.outcome.word, found.finished, found.summary()["finished"]) == ("stopped", None, None)
    assert "The finished assembly itself, with which every order ends, was not judged." in found.explain()
    monkeypatch.undo()
    assert find_order(arch(), held_at_most=2, seconds=0.0).finished is Outcome.STABLE


def test_blocks_that_hardly_move_are_at_rest_only_where_the_others_fall_without_them(monkeypatch):
    """The arm falls off its base, which a mechanism moves by 1e-10 of that; noise, unless the check says otherwise."""
    assess, assembly = Whole.assess, tee()
    base, left = (assembly.names.index(name) for name in ("base", "left"))

    def with_noise(self, *state, **options):
        verdict = assess(self, *state, **options)
        mechanism = verdict.mechanism.copy()
        mechanism[base, 2] += 1e-10
        return replace(verdict, mechanism=mechanism)

    monkeypatch.setattr(Whole, "assess", with_noise)
    state = (1 << base | 1 << left, 0)
    found = search.Search(Whole(assembly), 1, "associated")._outcome(state)
    assert (found["moving"], found["complete"]) == ([left], True)
    monkeypatch.setattr(Whole, "falls_by", lambda *_: False)
    found = search.Search(Whole(assembly), 1, "associated")._outcome(state)
    assert (found["moving"], found["complete"]) == ([left, base], False)


def test_a_motion_proves_a_fall_where_no_joint_closes_and_its_weight_does_work():
    """The arm has its centroid .1 beyond the edge of its base: about that edge it falls, and the base cannot sink."""
    assembly = tee()
    whole, (base, left) = Whole(assembly), (assembly.names.index(name) for name in ("base", "left"))
    state = whole.state_of(["base", "left"], [], "state")
    motion = np.zeros((assembly.n_blocks, 6))
    motion[left, 4] = -1.0
    motion[left, :3] = np.cross(motion[left, 3:], assembly.centroid[left] - (-0.5, 0.5, 0.25))
    assert motion[left, 2] == pytest.approx(-0.1)
    assert whole.falls_by(motion, *state)
    assert not whole.falls_by(-motion, *state)
    motion[base, 2] = -1.0
    assert not whole.falls_by(motion, *state)


def test_the_command_writes_the_safest_order(tmp_path):
    write(slope(), tmp_path / "slope.json")
    command = ["sequence", str(tmp_path / "slope.json"), "--held-at-most", "1", "--reserve"]
    answer = CliRunner().invoke(app, [*command, "--json", "-o", str(tmp_path / "plan.json")])
    assert json.loads(answer.stdout)["least_friction"] == [0.0, 0.0]
    assert json.loads((tmp_path / "plan.json").read_text())["steps"][0]["install"] == ["low"]
    assert "takes neither --flow coulomb" in str(CliRunner().invoke(app, [*command, "--flow", "coulomb"]).exception)


def test_a_journal_of_something_else_is_refused(tmp_path):
    path = tmp_path / "journal.jsonl"
    find_order(tee(), held_at_most=2, journal=path)
    with pytest.raises(InputError, match="outcomes of another assembly"):
        find_order(arch(), held_at_most=2, journal=path)
    path.write_text("nonsense\n")
    with pytest.raises(InputError, match="a line is damaged"):
        find_order(tee(), held_at_most=2, journal=path)


def test_a_journal_that_was_cut_short_in_its_first_line_begins_anew(tmp_path):
    path = tmp_path / "journal.jsonl"
    find_order(tee(), held_at_most=2, journal=path)
    whole = path.read_text()
    head = whole.split("\n")[0]
    for begun in ("", head[:30], head):
        path.write_text(begun)
        assert find_order(tee(), held_at_most=2, journal=path).outcome.word == "found"
        assert path.read_text() == whole


@pytest.mark.parametrize(
    "data",
    [
        *(b"\xff\xfe\x00\x01\n", b"{\n", b"nonsense", b"HEAD\n5\n", b'HEAD\n["x", "0x0", {}]\n'),
        b"HEAD\n" + b"[" * 100_000 + b"\n",
    ],
)
def test_a_file_that_is_no_journal_is_refused_and_kept(tmp_path, data):
    path = tmp_path / "journal.jsonl"
    find_order(tee(), held_at_most=2, journal=path)
    data = data.replace(b"HEAD", path.read_bytes().split(b"\n")[0])
    path.write_bytes(data)
    with pytest.raises(InputError, match=f"{path.name}: a line is damaged"):
        find_order(tee(), held_at_most=2, journal=path)
    assert path.read_bytes() == data


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning", "error::ResourceWarning")
def test_a_journal_keeps_no_file_open(tmp_path):
    find_order(tee(), held_at_most=2, journal=tmp_path / "journal.jsonl")
    gc.collect()


def test_a_journal_of_other_joints_is_refused(tmp_path):
    """The same blocks with another law, another friction of the joints, or a group that a law is about."""
    assembly = slope(0.6).with_(friction=0.1)
    faces = find_interfaces(assembly)
    rough, smooth = ({"interfaces": replace(faces, friction=np.full(faces.n_interfaces, mu))} for mu in (0.7, 0.5))
    law = JointLaw(("rock", "rock"), tension=1e6)
    grouped, loose = (assembly.with_(joints=(law,), groups=("rock", kind, kind)) for kind in ("rock", "sand"))
    glued = assembly.with_(joints=(JointLaw(("*", "*"), tension=1e6),))
    cases = [((glued, {}), (assembly, {})), ((assembly, rough), (assembly, smooth)), ((grouped, {}), (loose, {}))]
    for number, (first, second) in enumerate(cases):
        path = tmp_path / f"{number}.jsonl"
        one = find_order(first[0], held_at_most=1, journal=path, **first[1])
        again = find_order(first[0].with_(name="renamed"), held_at_most=1, journal=path, **first[1])
        assert (again.outcome, again.solved) == (one.outcome, 0)
        with pytest.raises(InputError, match="outcomes of another assembly, joints, friction or flow"):
            find_order(second[0], held_at_most=1, journal=path, **second[1])


LARGE = [pytest.param(name, marks=pytest.mark.slow) for name in ("mario", "dome", "dome72")]


@pytest.mark.parametrize("name", ["arch", "tetris-1", "tetris-2", "tetris-4", *LARGE])
def test_published_assemblies_are_built_with_two_hands(cases, name):
    """Ziqi Wang, LearningToAssemble (2025): friction .55, two robots."""
    from blockstat import read

    folder = cases.parent / "sequences"
    if not folder.is_dir():
        pytest.skip("no directory of sequences")
    assembly = read(next(folder.rglob(f"{name}.json")))
    found = find_order(assembly, held_at_most=2, friction=0.55)
    assert found.outcome.word == "found"
    again = assess_plan(assembly, found.plan, friction=0.55)
    assert again.outcome.word == "stable"
    assert found.plan.most_held <= 2
    assert json.dumps(again.summary())


@pytest.mark.slow
def test_the_chapel_is_built_with_two_hands():
    chapel = build(load_scene(Path(__file__).parents[2] / "examples" / "chapel.toml"))
    found = find_order(chapel, held_at_most=2)
    assert found.outcome.word == "found"
    assert sorted(placed(found)) == sorted(chapel.names[k] for k in chapel.free)
    assert assess_plan(chapel, found.plan).outcome.word == "stable"


def valley(left, right, top=1.0, density=1.0):
    """Two blocks on the sides of a valley, of slopes `left` and `right`, that lean on each other over a trench.

    Together they need no friction: each side pushes with weight x slope. Alone, each needs the tangent of its slope.
    """
    blocks = [
        prism([(-1, left), (-1, left - 1), (-0.2, left - 1), (-0.2, 0.2 * left)], "west"),
        prism([(0.2, 0.2 * right), (0.2, right - 1), (1, right - 1), (1, right)], "east"),
        prism([(-1, left), (0, 0), (0, 1), (-1, 1)], "left"),
        prism([(0, 0), (1, right), (1, top), (0, top)], "right"),
    ]
    blocks[2] = replace(blocks[2], density=density * 2000.0)
    blocks[3] = replace(blocks[3], density=2000.0)
    return Assembly.from_blocks(blocks, supports=["west", "east"], friction=0.6)


def test_the_first_block_in_a_valley_needs_its_slope_unless_a_second_hand_holds_the_other():
    """With one hand a block stands alone on a slope of .3; two hands hold both until they lean on each other."""
    found = safest_order(valley(0.3, 0.3), held_at_most=1)
    low, high = found.least_friction
    assert low < 0.3 <= high + 1e-6
    assert high == pytest.approx(0.3, abs=2e-5)
    assert high - low <= 1e-3
    assert found.reserve == pytest.approx(2.0, abs=1e-3)
    assert f"Every step stands from a friction of {high:.5f}: reserve {found.reserve:.3f}." in found.explain()
    assert f"No order does at {low:.5f}." in found.explain()
    assert "Stopped" not in found.explain()
    assert found.summary()["least_friction"] == [low, high]
    two = safest_order(valley(0.3, 0.3), held_at_most=2)
    assert two.least_friction == (0.0, 0.0)
    assert "No order does" not in two.explain()
    assert two.summary()["reserve"] is None


def test_the_safest_order_leaves_the_order_that_was_found_first_for_one_that_needs_less():
    """At .6 the taller block is taken out first and leaves the other on a slope of .4; its own slope is .1."""
    # equal thrusts: the left block has an area of .95, the right one, half as high, of .3
    assembly = valley(0.1, 0.4, top=0.5, density=0.3 * 0.4 / (0.95 * 0.1))
    assert placed(find_order(assembly, held_at_most=1))[0] == "right"
    found = safest_order(assembly, held_at_most=1)
    assert placed(found.found) == ["left", "right"]
    assert found.least_friction[1] == pytest.approx(0.1, abs=2e-5)
    assert found.reserve == pytest.approx(6.0, abs=2e-3)


def test_a_search_for_the_safest_order_that_is_interrupted_says_what_is_not_excluded():
    calls = []

    def reach(block, present):
        calls.append(block)
        if len(calls) > enough:
            raise KeyboardInterrupt
        return True

    enough = np.inf
    find_order(valley(0.3, 0.3), held_at_most=1, reach=reach)
    enough, calls[:] = len(calls), []  # the first search ends, the next one does not
    found = safest_order(valley(0.3, 0.3), held_at_most=1, reach=reach, seconds=100.0)
    assert found.found.outcome.word == "found"
    assert found.least_friction == (0.0, pytest.approx(0.3, abs=2e-5))
    assert "Stopped: orders that stand at less are not excluded above 0.00000." in found.explain()
    assert "No order does" not in found.explain()


@pytest.mark.parametrize(("which", "stands"), [(1, 0.6), (2, 0.3)])
def test_an_interrupt_while_the_least_friction_is_sought_keeps_the_order(monkeypatch, which, stands):
    """While that of the plan is sought it is known to stand at .6 alone, and then from its slope of .3 on."""
    calls, least_friction = [], order.least_friction

    def interrupted(*given):
        calls.append(given)
        if len(calls) == which:
            raise KeyboardInterrupt
        return least_friction(*given)

    monkeypatch.setattr(order, "least_friction", interrupted)
    found = safest_order(valley(0.3, 0.3), held_at_most=1)
    assert (found.found.outcome.word, found.ended.word) == ("found", "stopped")
    assert found.least_friction == (0.0, pytest.approx(stands, abs=2e-5))
    assert "Stopped: orders that stand at less are not excluded above 0.00000." in found.explain()


def test_the_time_counts_while_the_least_friction_is_sought(monkeypatch):
    clock, find = [1000.0], order.find_order

    def slow(*given, **options):
        found = find(*given, **options)
        clock[0] += 100.0
        return found

    monkeypatch.setattr(order, "find_order", slow)
    for module in (order, plan, search):
        monkeypatch.setattr(module, "monotonic", lambda: clock[0])
    found = safest_order(valley(0.3, 0.3), held_at_most=1, seconds=50.0)
    assert (found.found.outcome.word, found.ended.word, found.least_friction) == ("found", "stopped", (0.0, 0.6))
    assert found.reserve == pytest.approx(1.0)


def test_what_is_not_decided_at_less_friction_does_not_exclude_an_order_there(monkeypatch):
    """Below a friction of .3 nothing is proven: neither that the block in the valley falls nor that it stands."""
    assess = Whole.assess

    def undecided(self, *state, **options):
        verdict = assess(self, *state, **options)
        return replace(verdict, outcome=Outcome.UNDECIDED) if self.assembly.friction < 0.3 else verdict

    monkeypatch.setattr(Whole, "assess", undecided)
    found = safest_order(valley(0.3, 0.3), held_at_most=2)
    assert found.least_friction == (0.0, pytest.approx(0.3, abs=2e-5))
    assert "Undecided: orders that stand at less are not excluded above 0.00000." in found.explain()
    assert "No order does" not in found.explain()
    stands = assess_plan(valley(0.3, 0.3), found.found.plan, reserve=True)
    assert re.search(r"from a friction of 0\.3000\d \(not proven at 0\.(29999|30000)\): reserve", stands.explain())


def test_a_search_without_an_order_has_no_steps_and_no_reserve():
    found = find_order(tee(), held_at_most=1)
    assert (found.summary()["steps"], found.summary()["most_held"]) == (None, None)
    assert found.explain().startswith("None: no order with so few held blocks exists")
    assert "held at once" not in found.explain()
    safest = safest_order(tee(), held_at_most=1)
    assert np.isnan(safest.reserve)
    assert safest.explain().splitlines()[0] == found.explain().splitlines()[0]
    assert "friction" not in safest.explain()
    assert (safest.summary()["least_friction"], safest.summary()["reserve"]) == (None, None)


def test_a_search_that_ran_out_of_time_does_not_say_that_there_is_no_order():
    found = find_order(tee(), held_at_most=2, seconds=0.0)
    assert (found.outcome.word, found.plan) == ("stopped", None)
    assert "the limit of 0 s was over before the search found an order" in found.explain()
    assert found.time_limit == 0.0
    assert np.isnan(safest_order(tee(), held_at_most=2, seconds=0.0).reserve)


def test_states_that_are_not_decided_leave_the_search_undecided(monkeypatch):
    """What is not proven to fall does not prove that there is no order."""
    assess = Whole.assess

    def undecided(self, *state, **options):
        verdict = assess(self, *state, **options)
        return replace(verdict, outcome=Outcome.UNDECIDED) if verdict.outcome is Outcome.UNSTABLE else verdict

    assert find_order(tee(), held_at_most=1).outcome.word == "none"
    assert count_orders(tee()).undecided == 0
    monkeypatch.setattr(Whole, "assess", undecided)
    found = find_order(tee(), held_at_most=1)
    assert found.outcome.word == "undecided"
    assert "states could be proven neither stable nor unstable" in found.explain()
    whole = find_order(arch(), held_at_most=2, friction=0.2)
    assert (whole.outcome.word, whole.finished.word, whole.moving) == ("undecided", "undecided", ())
    assert whole.explain().startswith("Undecided: the finished assembly itself, with which every order ends,")
    count = count_orders(tee())
    assert (count.stable, count.undecided) == (3, 13)


def test_a_search_without_a_hand_is_refused():
    for hands in (0, 1.5, "2"):
        for ordered in (find_order, safest_order):
            with pytest.raises(InputError, match=f"held_at_most is {hands!r}; it must be a whole number of at least 1"):
                ordered(tee(), held_at_most=hands)
