"""Load cases in scene files and on the command line: what combines, and what errors name."""

import json
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from typer.testing import CliRunner

import blockstat
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
from blockstat.loading.cases import LoadCase
from blockstat.spec.files import load_file
from evidence.scenes.small import assembly, box, stack

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


def test_a_case_acts_with_all_its_loads_does_not_change_and_is_compared_by_identity():
    permanent, live = np.arange(12.0).reshape(2, 6), np.full((2, 6), 0.5)
    own = LoadCase("storm", permanent, live)
    assert own.loads == pytest.approx(permanent + live)
    assert own.words == ""
    assert replace(own, combination="wind (live)").words == "wind (live)"
    assert replace(own, description="in winter", combination="wind (live)").words == "in winter (wind (live))"
    with pytest.raises(FrozenInstanceError):
        own.name = "calm"
    assert replace(own) != own
    assert len({own, replace(own)}) == 2


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
    (tmp_path / "again.toml").write_text(scene_text(kept), encoding="utf-8")
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


def two_blocks(**options):
    blocks = [
        box((-1, -1, -1), (9, 9, 0), name="ground"), box((0, 0, 0), (1, 2, 3), name="post", density=3.0),
        box((4, 0, 0), (6, 1, 1), name="slab", density=5.0),
    ]  # fmt: skip
    return assembly(blocks, gravity=(0.5, 0, -2), **options)


def test_a_case_is_a_sum_with_factors_of_what_stays_and_what_grows():
    asm, random = two_blocks(), np.random.default_rng(3)
    own = {name: random.normal(size=(3, 6)) for name in ("a", "b", "unused")}
    table = {"factors": {"a": 1.5, "b": -0.5}, "live": {"b": 2.0, "a": 0.25}, "weight": 0.9, "description": "storm"}
    case = load_case(asm, "one", own, {"one": table, "broken": {"weight": 1}})
    weight = np.zeros((3, 6))
    weight[:, :3] = np.outer(asm.mass, asm.gravity)
    np.testing.assert_allclose(case.permanent, 1.5 * own["a"] - 0.5 * own["b"] - 0.1 * weight, rtol=1e-12)
    np.testing.assert_allclose(case.live, 2.0 * own["b"] + 0.25 * own["a"], rtol=1e-12)
    np.testing.assert_allclose(case.loads, case.permanent + case.live, rtol=1e-12)
    assert case.name == "one"
    assert case.words == "storm (0.9 weight + 1.5 a + -0.5 b + 2 b (live) + 0.25 a (live))"
    bare = load_cases(asm, own, {"bare": {}})["bare"]
    assert bare.words == bare.combination == "1 weight"
    assert bare.description == ""
    assert bare.loads.shape == (3, 6)
    assert not bare.loads.any()


def test_each_kind_of_table_is_the_load_of_its_function():
    asm = two_blocks()
    up, out = (0, 0, 1), (-1, 0, 0)
    patch = [(0, 0, 3), (1, 0, 3), (1, 1, 3), (0, 1, 3)]
    tables = {
        "point": ({"block": "post", "point": (0, 1, 2), "force": (1, 2, 3)}, blockstat.point_load),
        "line": ({"start": (0, 0, 3), "end": (1, 2, 3), "force": (0, 1, 0)}, blockstat.line_load),
        "patch": ({"corners": patch, "pressure": (0, 1, -2), "blocks": "post"}, blockstat.patch_load),
        "surface": ({"pressure": (1, 2, 3), "towards": up, "blocks": ["slab"]}, blockstat.surface_load),
        "body": ({"force": (1, 2, 3), "blocks": 1}, blockstat.body_load),
        "acceleration": ({"direction": (0, 1, 0), "profile": [(0, 1), (3, 2)]}, blockstat.acceleration),
        "pressure": ({"level": 2.0, "unit_weight": 3.0, "towards": out, "surcharge": 1.0}, blockstat.fluid_pressure),
        "fill": ({"level": 4.0, "unit_weight": 3.0}, blockstat.fill_load),
        "dispersed": ({"point": (0.4, 1, 4), "force": 3.0, "spread": 0.2}, blockstat.dispersed_load),
    }
    loads = {kind: {"kind": kind, **options} for kind, (options, _) in tables.items()}
    cases = load_cases(asm, loads, {kind: {"live": {kind: 1.0}} for kind in tables})
    for kind, (options, make) in tables.items():
        np.testing.assert_array_equal(cases[kind].live, make(asm, **options), err_msg=kind)
        assert cases[kind].live.any()


def test_loads_and_cases_come_from_the_scene_where_none_are_given():
    loads, cases = {"push": {"kind": "body", "force": [3.0, 0, 0]}}, {"own": {"live": {"push": 2.0}}}
    asm = two_blocks(metadata={"loads": loads, "cases": cases})
    assert load_cases(asm)["own"].live[:, 0].sum() == pytest.approx(6.0)
    assert load_case(asm, "own").live[:, 0].sum() == pytest.approx(6.0)
    assert load_case(asm, "twice", cases={"twice": {"live": {"push": 4.0}}}).live[:, 0].sum() == pytest.approx(12.0)
    other = load_case(asm, "own", {"push": np.ones((3, 6))})
    assert other.live[:, 0].sum() == pytest.approx(6.0)
    assert other.live[0, 3] == 2.0
    with pytest.raises(InputError, match='no case "on"; cases are: own'):
        load_case(asm, "on")
    assert load_cases(two_blocks()) == {}


ON_TOP = """\
[loads]
snow = { kind = "surface", pressure = [0, 0, -1000], towards = [0, 0, 1] }
drag = { kind = "surface", pressure = [1, 0, 0], towards = [0, 0, 1] }

[cases]
c = { live = { snow = 1 } }
d = { live = { drag = 1 } }
"""


def test_loads_on_faces_leave_out_the_joints_that_the_analysis_has(tmp_path):
    (tmp_path / "l.toml").write_text(ON_TOP)
    # Two cubes of 1 m and 1 N with joints that are 20 mm open; a drag on the upper top tips both at 0.5 / 1.02.
    blocks = [box((-1, -1, -1), (2, 2, 0), name="ground")]
    blocks += [box((0, 0, z), (1, 1, z + 1), name=f"cube{k}") for k, z in enumerate((0.02, 1.04))]
    open_joints, snow = assembly(blocks, supports=["ground"]), load_file(tmp_path / "l.toml")
    for gap, below in (("30 mm", 0.0), (1e-3, -1000.0)):
        live = load_case(open_joints, "c", **snow, gap=gap).live
        assert live[1:, 2] == pytest.approx([below, -1000.0])
        assert load_cases(open_joints, **snow, gap=gap)["c"].live == pytest.approx(live)
    write(open_joints, tmp_path / "cubes.json")
    command = [str(tmp_path / "cubes.json"), "--gap", "30 mm", "--loads", str(tmp_path / "l.toml"), "--json"]
    limit = json.loads(CliRunner().invoke(app, ["limit", *command, "--case", "d"]).stdout)
    assert limit["lower"] == pytest.approx(0.5 / 1.02, abs=0.01)
    rows = {row["case"]: row for row in json.loads(CliRunner().invoke(app, ["cases", *command]).stdout)["rows"]}
    assert rows["d"]["lower"] == pytest.approx(limit["lower"], rel=1e-3)


def test_the_table_of_cases_knows_the_gap_and_refuses_blocks_that_overlap(tmp_path):
    (tmp_path / "l.toml").write_text(
        '[loads.push]\nkind = "body"\nforce = [0.4, 0, 0]\n[cases.c]\nlive = { push = 2 }\n'
    )
    table = []
    for depth in (0.009, 0.3):  # what is 9 mm in the ground slides at a friction of 0.7, pushed by 0.8 of its weight
        blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, -depth), (1, 1, 0.5 - depth), name="slab")]
        write(assembly(blocks, density=2.0, friction=0.7), tmp_path / "sunk.json")
        command = [str(tmp_path / "sunk.json"), "--gap", "10 mm", "--loads", str(tmp_path / "l.toml"), "--json"]
        table.append(CliRunner().invoke(app, ["cases", *command]))
    (row,) = json.loads(table[0].stdout)["rows"]
    assert (row["verdict"], row["status"]) == ("unstable", "limit")
    assert row["upper"] == pytest.approx(0.7 / 0.8, rel=1e-3)
    assert isinstance(table[1].exception, InputError)
    assert 'blocks "ground" and "slab" overlap by 0.3 m' in str(table[1].exception)


def test_the_factor_on_the_weight_is_that_of_densities_that_are_imperfect_or_random(tmp_path):
    """A slab of mass rho and weight 0.9 rho, pushed by P at its foot, slides at 0.9 mu rho."""
    write(stack(1, 2.0, 0.5, friction=0.6), tmp_path / "slab.json")
    (tmp_path / "l.toml").write_text(
        '[loads.push]\nkind = "point"\nblock = "stone0"\npoint = [0, 0.5, 0]\nforce = [0.28, 0, 0]\n'
        "[cases.dead]\nfactors = { push = 1 }\nweight = 0.9\n[cases.live]\nlive = { push = 1 }\nweight = 0.9\n"
    )

    def told(command, case, *options):
        given = [str(tmp_path / "slab.json"), "--loads", str(tmp_path / "l.toml"), "--case", case, *options, "--json"]
        return json.loads(CliRunner().invoke(app, [command, *given], catch_exceptions=False).stdout)

    worst = ["--imperfection", "density.*=0.8,1.2", "--imperfection", "loads.*=0,1.5"]
    assert told("check", "dead", *worst)["verdict"] == "stable"  # 1.5 x .28 = .42 < .9 x .6 x .8 = .432
    assert told("limit", "live", *worst)["upper"] == pytest.approx(0.432 / 0.28, rel=1e-4)
    pushed = told("limit", "dead", *worst, "--load", "1,0,0")
    assert pushed["upper"] == pytest.approx((0.432 - 0.42) / 0.8, rel=1e-3)
    # Where the push is .2 of the mass too, it slides below rho = .28 / (.9 x .6 - .2).
    random = ["--uncertain", "density.*=normal,1,0.05", "--load", "0.2,0,0", "--first-order", "--draws", "1"]
    beta = told("reliability", "dead", *random)["first_order"]["beta"]
    assert beta == pytest.approx((1 - 0.28 / 0.34) / 0.05, rel=1e-3)


@pytest.mark.parametrize(("loads", "cases", "message"), [
    ({"a": 3}, {}, "loads.a: it must be a table with a kind, or a wrench on each block"),
    ({"a": {}}, {}, "loads.a.kind: the kind is missing; kinds are: point, line"),
    ({"a": {"kind": "wnd"}}, {}, "loads.a.kind: no kind 'wnd'"),
    ({"a": {"kind": ["body"]}}, {}, "loads.a.kind: no kind"),
    ({"a": {"kind": "body"}}, {}, "loads.a: a body load needs force; keys are: force, blocks, group"),
    ({"a": {"kind": "body", "force": (1, 0, 0), "interfaces": 1}}, {}, "loads.a.interfaces: unknown key"),
    ({"a": {"kind": "surface", "pressure": 1, "towards": 1, "assembly": 1}}, {}, "loads.a.assembly: unknown key"),
    ({}, {"c": 3}, "cases.c: it must be a table with factors or live"),
    ({}, {"c": {"factor": {}}}, "cases.c.factor: unknown key; keys here are: factors, live, weight, description"),
    ({}, {"c": {"live": 3}}, "cases.c.live: it must give a number to each load"),
    ({}, {"c": {"live": {"a": 1}}}, 'cases.c.live.a: no load "a"; loads are: none'),
    ({}, {"c": {"weight": True}}, "cases.c.weight: True is not a finite number"),
    ({}, {"c": {"weight": np.inf}}, "cases.c.weight: inf is not a finite number"),
    ({"a": np.ones((2, 6))}, {"c": {"factors": {"a": 1}}}, "loads.a: the array has shape (2, 6); finite values of"),
    ({"a": np.full((3, 6), np.nan)}, {"c": {"live": {"a": 1}}}, "loads.a: the array has shape (3, 6); finite values"),
    ({"a": {"kind": "body", "force": (1, 2)}}, {"c": {"live": {"a": 1}}}, "loads.a: force is (1, 2)"),
    ({"a": {"kind": "dispersed", "point": (-1, 1, 9), "force": 1.0, "spread": 1.0, "footprint": "ab"}},
     {"c": {"live": {"a": 1}}}, "loads.a: footprint is 'ab'; the two sides of the loaded area are needed"),
    ({"a": np.ones((3, 6))}, {"c": {"factors": {"a": "x"}}}, "cases.c.factors.a: 'x' is not a finite number"),
])  # fmt: skip
def test_what_is_wrong_with_a_load_or_a_case_is_named(loads, cases, message):
    with pytest.raises(InputError) as caught:
        load_cases(two_blocks(), loads, cases)
    assert message in str(caught.value)


def test_all_that_is_wrong_with_a_case_is_told_at_once():
    loads = {"a": {"kind": "body", "force": (1, 0, 0)}}
    case = {"live": {"a": None, "b": 1}, "factors": 3, "weight": "x", "more": 1}
    with pytest.raises(InputError) as caught:
        load_cases(two_blocks(), loads, {"c": case})
    assert [text.split(":")[0] for text in caught.value.args] == [
        "cases.c.more", "cases.c.factors", "cases.c.live.a", "cases.c.live.b", "cases.c.weight",
    ]  # fmt: skip


def test_loads_that_no_case_uses_need_not_fit_the_blocks():
    asm = two_blocks()
    loads = {"used": {"kind": "body", "force": (1, 0, 0)}, "spare": {"kind": "body", "force": (1, 0, 0), "group": "no"}}
    assert load_cases(asm, loads, {"c": {"live": {"used": 1}}})["c"].live[:, 0].sum() == pytest.approx(1.0)
    with pytest.raises(InputError, match=r'loads.spare: no group "no"'):
        load_cases(asm, loads, {"c": {"factors": {"spare": np.float64(1)}}})
