"""Load cases in scene files and on the command line: what combines, and what errors name."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from blockstat import (
    InputError,
    Tie,
    build,
    limit_load,
    load_case,
    load_cases,
    load_scene,
    read,
    scene_from,
    scene_text,
    write,
)
from blockstat.cli.commands import app

SCENE = """\
name = "bay"
[elements.post]
kind = "pier"
size = [0.5, 0.5]
height = 2.0
courses = 4

[loads.wind]
kind = "surface"
pressure = [500, 0, 0]
towards = [-1, 0, 0]

[loads.roof]
kind = "point"
block = "post.pier.3.0"
point = [0, 0, 2.0]
force = [0, 0, -2000]

[cases.storm]
factors = { roof = 1.0 }
live = { wind = 1.5 }
weight = 0.9

[ties.guy]
between = ["ground", "post.pier.3.0"]
points = [[-1, 0, 0], [-0.25, 0, 1.9]]
greatest = 10.0
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "bay.toml"
    path.write_text(SCENE)
    return path


def test_a_case_adds_its_loads_with_their_factors(scene):
    bay = build(load_scene(scene))
    case = load_case(bay, "storm")
    weight = bay.mass[bay.free] * 9.81
    assert case.live[bay.free, 0] == pytest.approx([1.5 * 500 * 0.5 * 0.5] * 4)
    assert case.permanent[bay.free, 2] == pytest.approx(0.1 * weight - [0, 0, 0, 2000])
    # Moments about the foot: (0.9 W + 2000) b / 2 and what the tie adds, over 1.5 x 500 x 0.5 x 2 at mid height.
    free = limit_load(bay.with_(ties=()), case.live, loads=case.permanent)
    assert free.lower == pytest.approx((0.9 * weight.sum() + 2000) * 0.25 / 750, rel=1e-6)
    line = np.array([0.75, 1.9]) / np.hypot(0.75, 1.9)
    pull = 10.0 * (1.9 * line[0] + 0.5 * line[1])
    tied = limit_load(bay, case.live, loads=case.permanent)
    assert tied.lower - free.lower == pytest.approx(pull / 750, rel=1e-5)


def test_scenes_and_blocks_keep_loads_cases_and_ties_in_files(scene, tmp_path):
    kept = load_scene(scene)
    (tmp_path / "again.toml").write_text(scene_text(kept))
    assert load_scene(tmp_path / "again.toml") == kept
    bay = build(kept)
    write(bay, tmp_path / "bay.json")
    again = read(tmp_path / "bay.json")
    assert (
        again.ties
        == bay.ties
        == (Tie(("ground", "post.pier.3.0"), ((-1, 0, 0), (-0.25, 0, 1.9)), 0.0, 10.0, name="guy"),)
    )
    assert np.array_equal(load_case(again, "storm").loads, load_case(bay, "storm").loads)


@pytest.mark.parametrize(
    ("good", "bad", "message"),
    [
        ("towards", "tward", "line 11: loads.wind.tward: unknown key; keys of a surface load are: pressure, towards"),
        ('"surface"', '"srf"', "line 9: loads.wind.kind: no kind 'srf'; kinds are: point, line"),
        ("roof = 1.0", "rof = 1", 'line 20: cases.storm.factors.rof: no load "rof"'),
        ("weight = 0.9", 'weight = "a"', "line 22: cases.storm.weight: 'a' is not a finite number"),
        ("greatest = 10.0", "most = 10.0", "line 27: ties.guy.most: unknown key"),
    ],
)
def test_errors_name_the_key_and_the_line(scene, good, bad, message):
    scene.write_text(SCENE.replace(good, bad))
    with pytest.raises(InputError, match=r"bay\.toml, ") as caught:
        load_scene(scene)
    assert message in str(caught.value)


def test_the_command_line_takes_a_case_and_tables_all(scene, tmp_path):
    run = CliRunner().invoke
    found = run(app, ["limit", str(scene), "--case", "storm", "--json"])
    bay = build(load_scene(scene))
    case = load_cases(bay)["storm"]
    assert json.loads(found.stdout)["lower"] == limit_load(bay, case.live, loads=case.permanent).lower
    pushed = json.loads(run(app, ["limit", str(scene), "--case", "storm", "--load", "1,0,0", "--json"]).stdout)
    assert pushed["lower"] == limit_load(bay, (1, 0, 0), loads=case.loads).lower
    checked = json.loads(run(app, ["check", str(scene), "--case", "storm", "--json"]).stdout)
    assert (checked["case"], checked["verdict"]) == ("storm", "stable")
    rows = json.loads(run(app, ["cases", str(scene), "--json"]).stdout)["rows"]
    assert [(row["case"], row["verdict"], row["lower"]) for row in rows] == [
        ("storm", "stable", json.loads(found.stdout)["lower"])
    ]
    write(bay, tmp_path / "bay.obj")
    apart = tmp_path / "loads.toml"
    apart.write_text('[loads.push]\nkind = "body"\nforce = [100, 0, 0]\n[cases.own]\nlive = { push = 1 }\n')
    mesh = [
        "limit",
        str(tmp_path / "bay.obj"),
        "--supports",
        "ground",
        "--loads",
        str(apart),
        "--case",
        "own",
        "--json",
    ]
    assert json.loads(run(app, mesh).stdout)["upper"] == pytest.approx(0.25 * bay.free_weight / 100, rel=1e-6)


def test_a_load_off_its_block_is_named_with_its_line(scene):
    scene.write_text(SCENE.replace("point = [0, 0, 2.0]", "point = [0, 0, 2.2]"))
    found = CliRunner().invoke(app, ["check", str(scene), "--case", "storm"])
    assert "line 13: loads.roof: point [0.0, 0.0, 2.2] is not on block" in str(found.exception)


def test_cases_of_a_building_in_the_short_form_are_read():
    hut = {"name": "hut", "length": 3.0, "span": 2.0, "loads": {"snow": {"kind": "body", "force": [0, 0, -1]}}}
    with pytest.raises(InputError, match=r"cases\.a\.live\.rain: no load"):
        scene_from(hut | {"cases": {"a": {"live": {"rain": 1}}}})
    assert load_case(build(scene_from(hut | {"cases": {"a": {"live": {"snow": 2}}}})), "a").live[
        :, 2
    ].sum() == pytest.approx(-2)
