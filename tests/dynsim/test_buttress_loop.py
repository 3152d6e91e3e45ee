"""The paper's buttress loop with the real Bullet."""

from dataclasses import replace

import pytest

from blockstat import InputError
from blockstat.spec import build, scene_from
from dynsim import DynamicOutcome, Settings, verify
from dynsim.design_search.buttress_loop import buttress_loop, cracks_by_wall

FAST = Settings.named("fast")


def hall(thickness, buttresses):
    return scene_from(
        {
            "name": "hall", "length": 3.0, "span": 2.4, "brick": {"length": 1.0, "height": 0.5},
            "wall": {"thickness": thickness, "height": 1.5}, "vault": {"thickness": 0.2, "voussoirs": 7},
            "buttresses": buttresses,
        }
    )  # fmt: skip


def sides(thickness, *names):
    return {side: {"number": 1, "thickness": thickness, "width": 0.4, "height": 1.0} for side in names}


def judge(assembly):
    return verify(assembly, settings=FAST)


def test_walls_that_need_none_get_none():
    result = buttress_loop(hall(0.8, sides(0.6, "south", "north")), judge)
    assert result.sound
    assert len(result.steps) == 1
    assert result.building.buttresses == {}


@pytest.mark.slow
def test_buttresses_are_added_to_walls_that_crack_until_none_does():
    scene = hall(0.25, sides({"value": 0.4, "min": 0.4, "max": 1.2, "step": 0.4}, "south", "north", "west"))
    result = buttress_loop(scene, judge)
    first, second = result.steps[:2]
    assert first.number == {}
    assert first.cracks
    assert second.number == {"south": 1, "north": 1, "west": 1}
    for before, after in zip(result.steps[1:], result.steps[2:], strict=False):
        for wall, count in after.number.items():
            grown = (count, after.thickness[wall]) != (before.number[wall], before.thickness[wall])
            # Only walls that crack get more.
            assert wall in before.cracks or not grown
    last = result.steps[-1]
    assert result.sound == (not last.cracks and last.outcome == "stands")


def test_a_wall_without_room_for_more_ends_the_loop():
    scene = hall(0.2, sides(0.04, "west"))
    result = buttress_loop(scene, judge)
    assert not result.sound
    assert result.steps[-1].cracks


@pytest.mark.parametrize("present", [False, {"value": 0, "min": 0, "max": 1, "step": 1}])
def test_buttresses_that_are_absent_in_the_scene_are_built_like_others(present):
    whole = judge(build(hall(0.8, {})))
    moves = replace(whole, outcome=DynamicOutcome.CREEPS)
    tables, told = sides(0.6, "south"), []

    def progress(step):
        told.append(step)
        assert len(told) <= 10

    there = buttress_loop(hall(0.8, tables), lambda _: moves)
    tables["south"]["present"] = present
    absent = buttress_loop(hall(0.8, tables), lambda _: moves, progress=progress)
    # A step without buttresses, and then one more each, as many as there is room for, each of them blocks.
    assert [step.number for step in absent.steps] == [{}, *({"south": n} for n in range(1, len(told)))]
    assert [step.blocks for step in absent.steps] == [step.blocks for step in there.steps]
    assert absent.steps[1].blocks > absent.steps[0].blocks


def test_cracks_are_those_of_the_walls_they_touch():
    found = cracks_by_wall({"wall.south | wall.west": 2, "buttress.south.2 | wall.south": 1, "ground | wall.east": 1})
    assert found == {"south": 3, "west": 2, "east": 1}
    assert cracks_by_wall({"vault": 4}) == {"south": 4, "north": 4}
    assert cracks_by_wall({"vault | wall.north": 1}) == {"north": 1}


def test_a_building_that_may_have_no_buttress_is_refused():
    with pytest.raises(InputError, match='"hall" has no buttresses to set'):
        buttress_loop(hall(0.5, {}), judge)


def test_a_building_that_moves_without_a_crack_gets_buttresses_under_its_vault_and_each_step_is_told():
    scene = hall(0.8, sides(0.6, "south", "west"))
    whole = judge(build(hall(0.8, {})))
    assert not whole.cracks.per_group()
    moves, told = replace(whole, outcome=DynamicOutcome.CREEPS), []
    result = buttress_loop(scene, lambda _: moves, progress=told.append)
    assert told == list(result.steps)
    assert not result.sound
    # First each wall gets one, and then only the south wall, from which the vault springs.
    assert [step.cracks for step in told] == [{"south": 1, "north": 1}] * len(told)
    assert [step.number.get("west", 0) for step in told[:3]] == [0, 1, 1]
    assert [step.number.get("south", 0) for step in told[:3]] == [0, 1, 2]
