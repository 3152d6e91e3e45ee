"""Pictures and commands of building and taking down."""

import json
import os
import re
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from blockstat import (
    Assembly,
    InputError,
    Plan,
    Step,
    assess,
    assess_plan,
    box,
    plot_plan,
    plot_removal,
    remove_each,
    write,
    write_plan,
    write_plan_film,
)
from blockstat.cli.commands import app
from blockstat.view.building.removal import weight_lost
from browser import FLAGS, Tab, browser_path
from building_sites import arch, slab, tee
from evidence.scenes.small import stack


def test_what_falls_of_a_tee_with_a_block(tmp_path):
    """The four blocks weigh the same. Without one arm the top falls off the other, which tips then; the base stands."""
    assembly = tee()
    found = remove_each(assembly)
    falls = {name: set(removal.falls) for name, removal in found.items()}
    assert falls == {
        "base": {"left", "right", "top"}, "left": {"right", "top"}, "right": {"left", "top"}, "top": {"left", "right"},
    }  # fmt: skip
    np.testing.assert_allclose(weight_lost(assembly, found), [np.nan, 0.75, 0.5, 0.5, 0.5])
    assert plot_removal(assembly, found, tmp_path / "map.png").stat().st_size > 5000


@pytest.mark.parametrize("cubes", [4, 5, 6, 10])
def test_what_has_nothing_under_it_falls_and_the_other_pier_of_a_gate_stands(cubes):
    """Without the foot of a pier its cubes of 1/8 m3 fall, and a lintel of .4 m3 whose middle has no pier below it."""
    blocks = [box((-3, -1, -1), (3, 2, 0), name="ground")]
    for pier, x in (("left", -1.0), ("right", 0.5)):
        blocks += [box((x, 0, k / 2), (x + 0.5, 0.5, k / 2 + 0.5), name=f"{pier}{k}") for k in range(cubes)]
    blocks += [box((-1, 0, cubes / 2), (1, 0.5, cubes / 2 + 0.4), name="lintel")]
    gate = Assembly.from_blocks(blocks, supports=["ground"])
    found = remove_each(gate, blocks=["left0"])
    assert set(found["left0"].falls) == {"lintel", *(f"left{k}" for k in range(1, cubes))}
    share = ((cubes - 1) / 8 + 0.4) / (2 * cubes / 8 + 0.4)
    assert weight_lost(gate, found)[gate.names.index("left0")] == pytest.approx(share)


def test_what_falls_of_an_arch_are_the_stones_that_slide_or_tip_on_the_one_below():
    """Beds rise by 180 / 7 degrees a stone: from 51 on stones slide at a friction of .6.

    The centroid of the second stone, on a bed of 26 degrees, is beyond it, that of the first above its level bed.
    """
    found = remove_each(arch())
    for name, removal in found.items():
        assert sorted(removal.falls) == [f"s{k}" for k in range(1, 6) if f"s{k}" != name]


@pytest.mark.parametrize("idle", [0, 14])
def test_two_slabs_that_tip_only_together_fall_together(idle):
    """Slabs of 1.6 and 1 m have their centroids at .8 and 1.4 m, both that at 2.68 / 2.6 m. Their bed ends at 1 m.

    Each stands where the other is held. A weight of .3 m at their end balances them; others beside them make no
    difference, however many they are.
    """
    blocks = [slab(-40, 1, -1, 0, "ground"), slab(0, 1.6, 0, 1, "low"), slab(0.9, 1.9, 1, 2, "high")]
    blocks += [slab(0, 0.3, 1, 2, "weight"), *(slab(-2 * k - 2, -2 * k - 1, 0, 1, f"idle{k}") for k in range(idle))]
    scene = Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)
    assert assess(scene).outcome.word == "stable"
    found = remove_each(scene, blocks=["low", "high", "weight"])
    assert {name: set(removal.falls) for name, removal in found.items()} == {
        "low": {"high", "weight"}, "high": set(), "weight": {"low", "high"},
    }  # fmt: skip


def test_what_falls_with_a_block_is_not_known_where_a_contact_has_no_normal():
    """A cube over a slot of its own width touches the sides along edges alone once its prop is gone."""
    blocks = [
        slab(-1, 0, -1, 0, "west"),
        slab(1, 2, -1, 0, "east"),
        slab(0, 1, -1, 0, "prop"),
        slab(0, 1, 0, 1, "cube"),
    ]
    scene = Assembly.from_blocks([*blocks, slab(0, 1, -2, -1, "ground")], supports=["west", "east", "ground"])
    removal = remove_each(scene, blocks=["prop"])["prop"]
    assert (removal.outcome.word, removal.falls) == ("undecided", None)


def test_a_strip_of_a_plan_has_the_first_step_that_falls(tmp_path):
    plan = Plan(tuple(Step((f"s{k}",)) for k in range(7)))
    found = assess_plan(arch(), plan)
    drawn = plot_plan(arch(), found, tmp_path / "plan.svg", frames=2).read_text()
    # The centroid of one stone lies above its bed, that of two beyond it.
    steps = ["step 0: stable", "step 1: unstable", "step 6: stable"]
    assert re.findall(r"<!-- (step \d+: \w+) -->", drawn) == steps
    with pytest.raises(InputError, match="frames is 0"):
        plot_plan(arch(), found, tmp_path / "plan.png", frames=0)


def test_a_film_shows_blocks_from_their_step_on_and_moves_those_that_fall(tmp_path):
    plan = Plan(tuple(Step((f"s{k}",)) for k in range(7)))
    path = write_plan_film(arch(), assess_plan(arch(), plan), tmp_path / "plan.glb", seconds=2.0)
    data = path.read_bytes()
    content = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    channels = [channel["target"] for channel in content["animations"][0]["channels"]]
    appear = {target["node"] - 1 for target in channels if target["path"] == "scale"}
    assert appear == set(range(1, 7))  # the first stone is there from the beginning
    moved = {target["node"] - 1 for target in channels if target["path"] == "translation"}
    assert {1, 2, 3, 4, 5} <= moved <= set(range(6))
    times = [
        accessor["max"][0] for accessor in content["accessors"] if "max" in accessor and "SCALAR" in accessor["type"]
    ]
    assert max(times) == pytest.approx(14.0)
    with pytest.raises(InputError, match=r"written as \.glb"):
        write_plan_film(arch(), assess_plan(arch(), plan), tmp_path / "plan.gif")


def test_a_film_in_which_nothing_falls_shows_the_last_step_as_long_as_the_others(tmp_path):
    plan = Plan(
        (Step(("s0",), ("s0",)), *(Step((f"s{k}",), tuple(f"s{j}" for j in range(k + 1))) for k in range(1, 7)))
    )
    found = assess_plan(arch(), plan)
    assert found.outcome.word == "stable"
    data = write_plan_film(arch(), found, tmp_path / "plan.glb", seconds=2.0).read_bytes()
    content = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    ends = [one["max"][0] for one in content["accessors"] if "max" in one and one["type"] == "SCALAR"]
    assert max(ends) == pytest.approx(14.0)  # the seventh block comes at 12 s


def test_a_reader_moves_the_slider_in_a_browser(tmp_path):
    executable = browser_path()
    from playwright.sync_api import sync_playwright

    from blockstat.view.building.slider import StepSlider
    from blockstat.view.three_d.page import start_viser, stop_viser

    assembly = arch()
    plan = Plan((Step(("s0",), ("s0",)), *(Step((f"s{k}",)) for k in range(1, 7))))
    server, address = start_viser(port=0)
    try:
        StepSlider(server, assembly, assess_plan(assembly, plan))
        with sync_playwright() as play:
            browser = play.chromium.launch(executable_path=executable, args=list(FLAGS))
            tab = Tab(browser, address)
            tab.sees("step 0: stable")
            tab.sees("held: s0")
            tab.number(0, 1)
            tab.sees("step 1: unstable")
            tab.sees("first to move: s1")
            tab.number(0, 6)
            tab.sees("step 6: stable")
            if picture := os.environ.get("STEP_PICTURE"):
                tab.page.screenshot(path=picture)
            assert not tab.errors
            assert not tab.outside
            browser.close()
    finally:
        stop_viser(server)


def test_a_slider_shows_the_blocks_of_a_step_and_says_what_falls():
    pytest.importorskip("viser")
    from blockstat.view.building.slider import StepSlider
    from blockstat.view.three_d.page import start_viser, stop_viser

    assembly = arch()
    plan = Plan((Step(("s0",), ("s0",)), Step(("s1",)), *(Step((f"s{k}",)) for k in range(2, 7))))
    server, _ = start_viser(port=0)
    try:
        page = StepSlider(server, assembly, assess_plan(assembly, plan))
        assert "step 0: stable" in page.words.content
        assert "held: s0" in page.words.content
        page.to(1)
        assert "step 1: unstable" in page.words.content
        assert "first to move: s1" in page.words.content
        drawn = np.split(page._canvas.vertices, assembly.vertex_start[1:-1])
        shown = {name for name, points in zip(assembly.names, drawn, strict=True) if np.ptp(points, axis=0).max() > 0}
        assert shown == {"s0", "s1", "west", "east"}
        page.slider.value = 6
        assert page.slider.max == 6
    finally:
        stop_viser(server)


def test_the_command_says_which_blocks_may_go(tmp_path):
    write(tee(), tmp_path / "tee.json")
    arguments = ["sequence", str(tmp_path / "tee.json"), "--remove-each", "-o", str(tmp_path / "map.png")]
    found = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert found["removed"] == {"base": "unstable", "left": "unstable", "right": "unstable", "top": "unstable"}
    assert set(found["falls"]["base"]) == {"left", "right", "top"}
    assert (tmp_path / "map.png").exists()
    assert "0 of 4 blocks may be taken out now" in CliRunner().invoke(app, arguments).stdout


def test_the_command_draws_a_plan_and_writes_the_assembly_into_one_that_it_finds(tmp_path):
    write(tee(), tmp_path / "tee.json")
    write_plan(Plan((Step(("base",)), Step(("left",)), Step(("right",)), Step(("top",)))), tmp_path / "plan.json")
    command = ["sequence", str(tmp_path / "tee.json")]
    answer = CliRunner().invoke(
        app, [*command, "--plan", str(tmp_path / "plan.json"), "-o", str(tmp_path / "plan.png")]
    )
    assert answer.exit_code == 0
    assert (tmp_path / "plan.png").stat().st_size > 5000
    answer = CliRunner().invoke(app, [*command, "--held-at-most", "2", "-o", str(tmp_path / "found.json")])
    assert answer.exit_code == 0
    assert json.loads((tmp_path / "found.json").read_text())["assembly"] == "tee.json"
    assert CliRunner().invoke(app, command).exit_code != 0


def test_a_block_whose_removal_is_undecided_is_grey_and_the_label_says_so():
    tower = stack(2)
    open_ended = SimpleNamespace(falls=None)
    stands = SimpleNamespace(falls=())
    axes = plot_removal(tower, {"stone0": open_ended, "stone1": stands}, Figure().add_subplot())
    bar = axes.figure.axes[1]
    assert bar.get_ylabel() == "weight that falls with a block [%] (grey: not known)"
    assert bar.get_ylim() == (0, 100)
    assert is_grey(axes).any()
    known = plot_removal(tower, {"stone0": stands, "stone1": stands}, Figure().add_subplot())
    assert known.figure.axes[1].get_ylabel() == "weight that falls with a block [%]"
    assert not is_grey(known).any()


def is_grey(axes):
    """The polygons of a picture that have no hue; supports have one."""
    return np.ptp(axes.collections[0].get_facecolor()[:, :3], axis=1) < 1e-9
