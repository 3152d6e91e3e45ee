"""What the commands of `blockstat` refuse, say in words and write."""

import csv
import json
import math
import re
import warnings
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib.metadata import PackageNotFoundError
from types import SimpleNamespace

import numpy as np
import pytest

from blockstat import Assembly, InputError, InputWarning, JointLaw, box, capacity, read, write
from blockstat.analysis import limit_load
from blockstat.cli import examples, progress
from blockstat.cli.commands import app
from blockstat.cli.options import INTERRUPTED, _show_warning, _status
from blockstat.cli.studies import write_report
from blockstat.large_displacement.capacity_curve import CapacityOutcome
from blockstat.sequence.plan import Plan, Step, write_plan
from blockstat.sequence.states import Whole
from blockstat.studies import settling_path
from evidence.scenes.small import stack

CASES = """\
[loads.push]
kind = "body"
force = [0.8, 0, 0]
[cases.resting]
factors = { push = 1 }
[cases.growing]
live = { push = 1 }
[cases.storm]
live = { push = 4 }
"""


@pytest.fixture
def run(run_command):
    return partial(run_command, app, "blockstat")


@pytest.fixture
def places(tmp_path):
    """A post of weight 2, twice as high as wide, that tips when pushed at its centre by half of it; and load cases."""
    post = write(stack(1, 1.0, 2.0, name="post"), tmp_path / "post.json")
    (tmp_path / "cases.toml").write_text(CASES)
    (tmp_path / "none.toml").write_text('[loads.push]\nkind = "body"\nforce = [1, 0, 0]\n')
    named = {"cases": "cases.toml", "none": "none.toml", "folder": "", "out": "out.png", "page": "out.html"}
    return {"post": post, **{key: tmp_path / name for key, name in named.items()}}


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            "check {post} --imperfection friction=0.1 --imperfection friction=0.05",
            "--imperfection gives friction twice",
        ),
        ("check {post} --imperfection density.a=0.9,1 --imperfection density.a=1,1.1", "gives density.a twice"),
        (
            "reliability {post} --uncertain friction=normal,0.6,0.1 --uncertain friction=normal,0.3,0.1",
            "--uncertain gives friction twice",
        ),
        ("check {post} --format compas-model", "--format goes with -o FILE.json"),
        ("check {post} --format compas-model -o {folder}/a.glb", "--format goes with -o FILE.json"),
        ("check {post} --format nonsense -o {folder}/a.json", "--format"),
        ("capacity {post}", "--load AX,AY,AZ or --case NAME with live loads is needed: what grows until the limit"),
        ("limit {post} --case resting --loads {cases}", 'case "resting" has no live loads; give what grows by --load'),
        ("prove {post} --limit -o {folder}/p.json", "--load AX,AY,AZ or --case NAME with live loads is needed"),
        ("cases {post} --loads {none}", "none.toml: there are no load cases; write them as [cases.NAME]"),
        ("cases {post}", "post.json: there are no load cases"),
        ("limit {post} --directions 4 --loads {cases}", "--loads gives load cases; choose one by --case NAME"),
        ("limit {post} --directions 4 --imperfection edge=3mm", "--imperfection goes with --load or --case"),
        ("reliability {post}", "post.json: nothing is uncertain; write [uncertain] in the scene, or give --uncertain"),
        ("reliability {post} --uncertain friction=uniform,0.4,0.6 --first-order", "--first-order asks when a load is"),
        ("settle {post} --move ground:0,0,-0.01 --move ground:0.01,0,0 -o {out}", "--move names a part twice; give"),
        ("example chapel -o {folder}/gone/on/chapel.toml", "chapel.toml: no such directory: "),
        ("check {folder}/examples/bridge.toml", "no such file; blockstat example bridge -o"),
        ("sequence {post} --courses --flow coulomb", '--courses has flow "associated" alone, not "coulomb"'),
        ("sequence gone.json --courses --reserve --tilt", "--seconds, --journal, not --reserve, --tilt\n"),
        ("sequence {post} --held-at-most 1 --page", "--insertion, --journal, not --page\n"),
        ("sequence {post} --stages -o {out} --seconds 0", "--stages takes --flow, not --output, --seconds\n"),
        ("sequence {post} --remove-each --journal {out}", "--remove-each takes --output, --flow, not --journal\n"),
        ("sequence {post} --plan gone.json --along 1,0,0", "--reserve, --tilt, not --along\n"),
        ("sequence {post} --courses --stages", "give one of --plan PLAN.json, --held-at-most K, --courses"),
        ("prove {post} --limit --load 1,0,0 -o {folder}/p.json", "--load and --limit are different questions"),
    ],
)
def test_what_cannot_be_asked_is_one_line_and_status_two(run, places, command, words):
    before = sorted(places["folder"].iterdir())
    status, out, err = run(*command.format(**places).split())
    assert (status, out) == (2, "")
    assert err.startswith("blockstat: ")
    assert words in err
    assert err.count("\n") == 1
    assert sorted(places["folder"].iterdir()) == before


@pytest.mark.parametrize(
    ("command", "place", "words"),
    [
        ("capacity {file} --load 1,0,0", "gone/c.png", "no such directory"),
        ("capacity {file} --load 1,0,0", "c.txt", 'no picture is written as ".txt"'),
        ("settle {file} --move ground:0,0,-0.01", "gone/s.svg", "no such directory"),
        ("limit {file} --directions 4", "gone/d.png", "no such directory"),
        ("check {file}", "gone/v.glb", "no such directory"),
        ("check {file}", "v.stl", 'cannot write ".stl"; it is written as: .glb, .obj, .json'),
        ("prove {file}", "gone/p.json", "no such directory"),
        ("prove {file}", "p.png", 'cannot write ".png"; it is written as: .json'),
        ("plot {file} --forces", "gone/f.png", "no such directory"),
        ("plot {file} --mechanism", "gone/m.glb", "no such directory"),
        ("plot {file} --stone --load 1,0,0", "s.glb", "only a mechanism is written as .glb"),
        ("tie {file} --between a,b", "gone/t.json", "no such directory"),
        ("tie {file} --between a,b", "t.obj", 'cannot write ".obj"; it is written as: .json'),
        ("report {file}", "gone/r.html", "no such directory"),
        ("report {file}", "r.pdf", 'cannot write ".pdf"; it is written as: .html, .htm'),
        ("sequence {file} --held-at-most 2", "gone/plan.json", "no such directory"),
        ("sequence {file} --held-at-most 2", "plan.png", 'cannot write ".png"; it is written as: .json'),
        ("sequence {file} --courses", "plan", 'cannot write ""; it is written as: .json'),
        ("sequence {file} --plan plan.json", "plan.json", 'no picture is written as ".json"'),
        ("sequence {file} --remove-each", "map.glb", "a picture is .png or .svg"),
    ],
)
def test_a_place_where_no_answer_can_go_is_refused_before_the_file_is_read(run, tmp_path, command, place, words):
    """There is no file to read, and that is not what is said."""
    status, out, err = run(*command.format(file=tmp_path / "none.json").split(), "-o", tmp_path / place)
    assert (status, out) == (2, "")
    assert words in err
    assert not list(tmp_path.iterdir())


def test_the_table_of_cases_says_each_verdict_and_multiplier(run, places):
    status, out, _ = run("cases", places["post"], "--loads", places["cases"])
    head, *rows = out.splitlines()
    assert status == 0
    assert head.split() == "case verdict multiplier of the live loads".split()
    found = {row.split()[0]: row.split(maxsplit=2)[1:] for row in rows}
    assert set(found) == {"resting", "growing", "storm"}
    assert found["resting"] == ["stable", "no live loads"]
    assert found["storm"][0] == "unstable"
    for case, limit in (("growing", 1.0 / 0.8), ("storm", 1.0 / 3.2)):
        low, high = map(float, found[case][1].split(" to "))
        assert low <= limit * (1 + 1e-6)
        assert high == pytest.approx(limit, rel=1e-3)


def test_a_case_whose_live_loads_never_tip_has_no_bracket_but_a_word(run, places):
    places["cases"].write_text('[loads.snow]\nkind = "body"\nforce = [0, 0, -1]\n[cases.snow]\nlive = { snow = 1 }\n')
    row = run("cases", places["post"], "--loads", places["cases"])[1].splitlines()[1]
    assert row.split() == ["snow", "stable", "unbounded"]


def test_a_limit_of_live_loads_is_said_in_words(run, places):
    status, out, _ = run("limit", places["post"], "--case", "growing", "--loads", places["cases"])
    lines = out.splitlines()
    assert status == 0
    assert re.fullmatch(r"post: 2 blocks, \d+\.\d\d s", lines[0])
    assert lines[1].startswith("Friction 0.7, density 1 kg/m3, weight 0.002 kN, coordinates in m, joints closed to ")
    assert lines[2] == 'Loads: case "growing": 1 weight + 1 push (live); the live loads grow.'
    assert lines[3].startswith("Limit")


def angle(word, out):
    return float(re.search(word + r" ([\d.]+)", out)[1])


@pytest.mark.parametrize(
    ("made", "options", "words"),
    [
        # Stones of width 1 in a tower of height 3 tip at tan = 1/3: 18.4349 degrees.
        (stack(3, name="tower"), ("--axis", "y"), r"Limit: .*\nStable at a tilt of 18\.4349\d+ deg\."),
        (stack(3, name="tower"), ("--axis", "z"), r"Always stands: .*\nStable at a tilt of 180 deg\."),
        (stack(3, name="tower", gravity=(0.4, 0, -1)), ("--axis", "y"), r"Never stands: .*\nNot stable at a tilt of 0"),
        (stack(1, friction=0.3, name="tower"), ("--axis", "y", "--flow", "coulomb"), "Change: "),
    ],
)  # fmt: skip
def test_each_answer_on_a_tilt_has_its_own_words(run, tmp_path, made, options, words):
    status, out, _ = run("tilt", write(made, tmp_path / "tower.json"), *options)
    assert status == 0
    head, basis, answer = out.split("\n", 2)
    assert re.fullmatch(rf"tower: \d blocks, tilted about {options[1]}", head)
    assert basis.startswith("Friction ")
    assert re.match(words, answer)
    assert ("In stiff joints" in out) is ("coulomb" in options)
    assert ("Friction is associated" in out) is ("coulomb" not in options and "Never" not in words)


def test_a_probability_is_said_in_words_with_the_design_point_before_it(run, places):
    random = ["--uncertain", "push=normal,0.4,0.05", "--load", "1,0,0", "--draws", 40]
    status, out, _ = run("reliability", places["post"], *random)
    assert status == 0
    assert out.startswith("post: 2 blocks\nFriction 0.7, ")
    assert " of 40 draws fall, 0 undecided." in out
    assert "design point" not in out
    first = run("reliability", places["post"], *random, "--first-order")[1]
    # The push that tips the post is two deviations from the mean: Phi(-2).
    probability, beta = map(float, re.search(r"Probability (\S+) \(beta (\S+)\)\.", first).groups())
    assert (probability, beta) == pytest.approx((0.02275, 2.0), rel=1e-3)
    assert first.index("push: 0.5 at the design point, 100% of the variance.") < first.index("of 40 draws fall")


def test_draws_that_are_kept_leave_no_other_file(run, places):
    kept = places["folder"] / "kept"
    kept.mkdir()
    random = ["--uncertain", "push=normal,0.4,0.05", "--load", "1,0,0", "--draws", 4]
    assert run("reliability", places["post"], *random, "-o", kept / "draws.jsonl")[0] == 0
    assert [path.name for path in kept.iterdir()] == ["draws.jsonl"]


def test_a_proof_is_of_the_verdict_or_of_both_bounds_of_a_load(run, places, tmp_path):
    live = ["--case", "growing", "--loads", places["cases"]]
    for options, what in (
        ([], "Stable"),
        (live, "Stable"),
        (["--load", "1,0,0"], "Limit"),
        ([*live, "--limit"], "Limit"),
    ):
        status, out, _ = run("prove", places["post"], *options, "-o", tmp_path / "proof.json")
        assert status == 0
        assert out.startswith(f"{tmp_path / 'proof.json'}: {what}: exact ")


def test_the_least_friction_is_said_in_words(run, tmp_path):
    lean = write(stack(1, 1.0, 0.5, name="slab", gravity=(0.4, 0, -1)), tmp_path / "slab.json")
    status, out, _ = run("friction", lean)
    assert status == 0
    assert re.match(r"slab: 2 blocks\nFriction .*\nLimit: ", out)
    # It slides where friction is less than the slope of the load.
    assert float(re.search(r"Stable at a friction of ([\d.]+)\.\n", out)[1]) == pytest.approx(0.4, abs=1e-4)


def test_a_settlement_is_said_in_words_up_to_the_collapse(run, places):
    status, out, _ = run("settle", places["post"], "--move", "ground:0,0,-0.001")
    assert status == 0
    assert out.startswith("post: 2 blocks\nFriction 0.7, ")
    assert "\nFurther on. Follows: " in out


def test_a_settlement_is_followed_as_far_as_is_asked(run, places):
    # Two posts carry a lintel of 3 m, on joints of 1 m. As the right one sinks by s, the lintel turns by about s / 2.
    beam = [box((0, 0, 0), (1, 1, 1), name="left"), box((2, 0, 0), (3, 1, 1), name="right")]
    beam = Assembly.from_blocks([*beam, box((0, 0, 1), (3, 1, 2), name="lintel")], supports=["left", "right"])
    scene = write(beam.with_(name="beam"), places["folder"] / "beam.json")
    command = ["settle", scene, "--move", "right:0,0,-0.01", "--steps", 4]
    status, out, _ = run(*command, "--until", 0)
    assert status == 0
    assert "\nOpen, to first order in the movement: 2 joints." in out
    assert out.splitlines()[-1] == "Not followed further: --until 0."
    picture = places["folder"] / "beam.png"
    status, out, _ = run(*command, "--until", 0.02, "-o", picture)
    assert status == 0
    assert "Further on. Reached: " in out
    assert "\nMovement 20 mm; " in out
    assert out.splitlines()[-1] == f"output: {picture}"
    assert picture.stat().st_size > 0
    assert json.loads(run(*command, "--until", 0, "--json")[1])["path"] is None
    for option in (["--until", -1], ["--until", "nan"], ["--steps", 0]):
        status, _, error = run(*command, *option)
        assert status == 2
        assert option[0] in error


def test_an_interrupted_curve_is_told_and_has_the_status_of_an_interrupt(run, places, monkeypatch):
    found = capacity(read(places["post"]), (1, 0, 0), steps=3)
    part = replace(found, outcome=CapacityOutcome.INTERRUPTED)
    monkeypatch.setattr("blockstat.large_displacement.capacity_analysis.capacity", lambda *_, **__: part)
    status, out, error = run("capacity", places["post"], "--load", "1,0,0")
    assert status == 130
    assert "Interrupted: the curve is known up to here." in out
    assert error.endswith("interrupted\n")


def test_a_capacity_curve_is_written_as_a_table(run, places):
    table = places["folder"] / "curve.csv"
    status, out, _ = run("capacity", places["post"], "--load", "1,0,0", "--steps", 4, "-o", table)
    assert (status, out.splitlines()[-1]) == (0, f"output: {table}")
    head, *rows = csv.reader(table.read_text().splitlines())
    assert head == ["displacement [m]", "lower", "upper"]
    found = capacity(read(places["post"]), (1, 0, 0), steps=4)
    np.testing.assert_array_equal(np.array(rows, dtype=float).T, [found.displacement, found.lower, found.upper])
    none = places["folder"] / "none" / "curve.csv"
    assert "no such directory" in run("capacity", places["post"], "--load", "1,0,0", "-o", none)[2]


def test_a_settlement_is_told_though_its_path_is_interrupted_before_it_can_be_filmed(run, places, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(settling_path, "settle_to_collapse", interrupted)
    film = places["folder"] / "film.png"
    status, out, _ = run("settle", places["post"], "--move", "ground:0,0,-0.001", "--film", film)
    assert status == 130
    assert out.splitlines()[-1] == "Not followed further: interrupted."
    assert not film.exists()


@pytest.mark.parametrize(("law", "words"), [({"compression": 1e9}, "crush at their hinges"), ({"cells": 2}, "cells")])
def test_a_settlement_that_cannot_be_followed_is_told_for_a_small_movement(run, places, law, words):
    post = write(stack(1, joints=[JointLaw(("*", "*"), **law)], name="firm"), places["folder"] / "firm.json")
    status, out, _ = run("settle", post, "--move", "ground:0,0,-0.001")
    assert status == 0
    assert out.splitlines()[-1].startswith("Not followed further: joints ")
    assert words in out.splitlines()[-1]
    answer = json.loads(run("settle", post, "--move", "ground:0,0,-0.001", "--json")[1])
    assert (answer["collapse"], answer["path"]) == (None, None)
    assert answer["reaction"] is not None
    film = places["folder"] / "film.glb"
    status, _, error = run("settle", post, "--move", "ground:0,0,-0.001", "--film", film)
    assert status == 2
    assert "--film: joints " in error
    assert not film.exists()


def test_a_plain_picture_has_the_blocks_alone(run, places):
    drawn = []
    for options in (["--plain"], []):
        picture = places["folder"] / "post.svg"
        assert run("plot", places["post"], *options, "-o", picture)[1] == f"{picture}\n"
        drawn.append(picture.read_text())
    # matplotlib leaves the words of a picture as comments beside their outlines.
    assert "<!-- post -->" in drawn[0]
    assert "stable" not in drawn[0]
    assert "<!-- post: stable -->" in drawn[1]


def test_what_a_limit_hangs_on_is_listed_with_its_size(run, places):
    status, out, _ = run("plot", places["post"], "--reserve", "edge", "--load", "1,0,0", "-o", places["out"])
    assert status == 0
    head, row, place = out.splitlines()
    # An edge that is e short leaves an arm of 1/2 - e below a centre at a height of 1: 1 mm costs 0.001.
    value, label = re.fullmatch(r"limit (\S+); (.*):", head).groups()
    assert float(value) == pytest.approx(0.5)
    assert label == "change of the limit by 1 mm of edges lost"
    assert row == '-0.001  "ground" and "stone0"'
    assert place == str(places["out"])


def test_the_blocks_that_may_be_taken_out_are_counted_and_the_others_named(run, tmp_path):
    tower = write(stack(2, name="tower"), tmp_path / "tower.json")
    status, out, _ = run("sequence", tower, "--remove-each")
    assert status == 0
    assert out.splitlines() == [
        "1 of 2 blocks may be taken out now: stone1.",
        "stone0: unstable; falls with it: stone1",
    ]
    assert [path.name for path in tmp_path.iterdir()] == ["tower.json"]


def test_the_loads_of_a_case_stay_in_all_directions(run, places):
    # A push of .8 acts already of the 1 that tips the post of weight 2.
    command = "limit {post} --directions 4 --case resting --loads {cases} --json"
    status, out, err = run(*command.format(**places).split())
    assert (status, err) == (0, "")
    told = json.loads(out)
    assert told["case"] == "resting"
    upper = {row["name"]: row["upper"] for row in told["directions"]}
    assert [upper[name] for name in ("+x", "-x", "+y", "-y")] == pytest.approx([0.1, 0.9, 0.5, 0.5], rel=1e-4)


@pytest.mark.parametrize(
    "command",
    [
        "code-check {post} --load 1,0,0 --ag 0.1",
        "capacity {post} --load 1,0,0",
        "limit {post} --directions 4",
        "plot {post} --mechanism --load 1,0,0 -o {out}",
        "report {post} -o {page}",
    ],
)
def test_an_interrupt_inside_a_limit_load_ends_the_command(run, places, monkeypatch, command):
    interrupt_limit_loads(monkeypatch)
    status, out, err = run(*command.format(**places).split())
    assert (status, out) == (INTERRUPTED, "")
    assert err.endswith("blockstat: interrupted\n")
    assert not places["out"].exists()
    assert not places["page"].exists()


def test_the_limit_load_of_one_direction_keeps_its_bracket_when_it_is_interrupted(run, places, monkeypatch):
    interrupt_limit_loads(monkeypatch)
    status, out, _ = run("limit", places["post"], "--load", "1,0,0")
    assert status == 0
    assert "Stopped: the assembly carries the load up to the lower bound" in out


def interrupt_limit_loads(monkeypatch):
    """Ctrl-C in the first iteration of every limit load, as if the scene were large."""

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(limit_load, "pays", lambda *_: True)
    monkeypatch.setattr(limit_load, "interior_point", SimpleNamespace(solve=interrupted))


def test_a_broken_library_while_an_interrupt_came_is_an_interrupt(capsys):
    def broken():
        raise RuntimeError("lost")

    assert _status(broken, "blockstat", SimpleNamespace(came=True)) == INTERRUPTED
    assert capsys.readouterr().err == "blockstat: interrupted\n"
    assert _status(broken, "blockstat", SimpleNamespace(came=False)) == 1
    assert "internal error (RuntimeError: lost)" in capsys.readouterr().err


def test_only_warnings_about_input_are_shown_and_as_one_line(capsys):
    _show_warning(DeprecationWarning("old"), DeprecationWarning)
    assert capsys.readouterr().err == ""
    _show_warning(InputWarning("two\nlines"), InputWarning)
    assert capsys.readouterr().err == "warning: two\\nlines\n"


def test_the_progress_of_a_limit_load_tells_its_kinds_of_joints(monkeypatch):
    told = []

    @contextmanager
    def at_work(_):
        yield told.append

    monkeypatch.setattr(progress, "at_work", at_work)
    with progress.shown_progress() as show:
        show(1, -0.5, 2.0)
        show(2, 0.25, 0.5)
    with progress.shown_progress() as show:
        show(0, 0.1, 0.4)
        show(1, 0.2, 0.4)
        show(0, 0.3, 0.4)
    assert [text.removesuffix(" (Ctrl-C keeps the bracket)") for text in told] == [
        "iteration 1: 0 reached, at most 2",
        "iteration 2: 0.25 reached, at most 0.5",
        "without dilatancy, stiff joints, trial 0: 0.1 to 0.4",
        "without dilatancy, stiff joints, trial 1: 0.2 to 0.4",
        "without dilatancy, elastic joints, trial 0: 0.3 to 0.4",
    ]


def test_examples_are_those_of_the_installed_package_or_none(run, tmp_path, monkeypatch):
    monkeypatch.setattr(examples, "__file__", str(tmp_path / "a" / "b" / "c" / "examples.py"))
    scene = tmp_path / "hut.toml"
    scene.write_text("# A hut. Small.\n")

    class Installed(str):
        def locate(self):
            return scene

    monkeypatch.setattr(
        examples, "files", lambda _: [Installed("share/blockstat/examples/hut.toml"), Installed("x.py")]
    )
    assert run("example", "--list") == (0, f"{'hut':16}A hut.\n", "")

    def missing(_):
        raise PackageNotFoundError

    for nothing in (missing, lambda _: None):
        monkeypatch.setattr(examples, "files", nothing)
        status, out, err = run("example", "--list")
        assert (status, out) == (2, "")
        assert err == "blockstat: the examples were not installed; they are in the folder examples of the source\n"


@pytest.mark.parametrize(
    "command",
    [
        "check {post} -o /proc/blocks.glb",
        "capacity {post} --load 1,0,0 -o /proc/curve.png",
        "capacity {post} --load 1,0,0 --film /proc/fall.glb",
        "sequence {post} --held-at-most 1 -o /proc/plan.json",
        "sequence {post} --remove-each -o /proc/map.png",
    ],
)
def test_a_directory_that_takes_no_file_is_refused_before_the_work(run, places, monkeypatch, command):
    monkeypatch.setattr(Whole, "assess", None)
    monkeypatch.setattr("blockstat.analysis.assess.assess", None)
    monkeypatch.setattr("blockstat.large_displacement.capacity_analysis.capacity", None)
    status, out, errors = run(*command.format(**places).split())
    assert (status, out) == (2, "")
    assert "no file can be written in /proc" in errors


@pytest.mark.parametrize(
    ("command", "writer"),
    [
        ("check {post} -o {blocks}", "blockstat.view.attributes.write_verdict"),
        ("capacity {post} --load 1,0,0 --steps 3 -o {out}", "blockstat.view.settling.plot_capacity"),
        ("settle {post} --move ground:0,0,-0.1 --until 0 -o {out}", "blockstat.view.settling.plot_settlement"),
        ("limit {post} --directions 4 -o {out}", "blockstat.view.polar.plot_directions"),
        ("tie {post} --between ground,stone0 -o {plan}", "blockstat.io.files.write"),
        ("sequence {post} --remove-each -o {out}", "blockstat.view.building.removal.plot_removal"),
        ("sequence {post} --held-at-most 1 -o {plan}", "blockstat.sequence.plan.write_plan"),
    ],
)
def test_an_answer_is_printed_where_its_file_cannot_be_written(run, places, monkeypatch, command, writer):
    def refuse(*_, **__):
        raise InputError("the disk is full")

    places |= {"blocks": places["folder"] / "blocks.glb", "plan": places["folder"] / "plan.json"}
    question, _, _ = command.partition(" -o ")
    answer = run(*question.format(**places).split())[1]
    monkeypatch.setattr(writer, refuse)
    status, out, errors = run(*command.format(**places).split())
    assert status == 2
    assert without_seconds(out) == without_seconds(answer) != ""
    assert errors.endswith("blockstat: the disk is full\n")


def without_seconds(text):
    return re.sub(r"[\d.]+ m?s\b", "", text)


@pytest.mark.parametrize("question", [["--held-at-most", 1], ["--held-at-most", 1, "--reserve"], ["--courses"]])
def test_a_search_that_an_interrupt_ends_without_a_plan_is_interrupted(run, places, monkeypatch, tmp_path, question):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    plan = tmp_path / "plan.json"
    monkeypatch.setattr(Whole, "assess", interrupt)
    status, out, errors = run("sequence", places["post"], *question, "-o", plan)
    assert status == INTERRUPTED
    assert "Stopped: the search was ended" in out
    assert f"{plan}: not written, for no plan was found" in errors
    assert not plan.exists()


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("question", [["--held-at-most", 1], ["--held-at-most", 1, "--reserve"], ["--courses"]])
def test_a_search_without_a_plan_when_its_time_is_over_says_so_and_fails(run, places, tmp_path, question, as_json):
    """A script that looks at the status alone does not go on without its plan."""
    plan = tmp_path / "plan.json"
    limit = ["--seconds", "1e-9", "-o", plan]
    status, out, errors = run("sequence", places["post"], *question, *limit, *["--json"] * as_json)
    assert status == 2
    assert "interrupted" not in out + errors
    assert f"{plan}: not written, for no plan was found" in errors
    assert errors.endswith("blockstat: --seconds 1e-09: no plan was found in this time; give it more\n")
    assert not plan.exists()
    if as_json:
        told = json.loads(out)
        assert (told["outcome"], told["time_limit"]) == ("stopped", 1e-9)
    else:
        assert out.startswith("Stopped: the limit of 1e-09 s was over before ")


def test_courses_that_were_not_looked_at_are_counted_too(run, tower, monkeypatch):
    interrupt_after(monkeypatch, 2)
    status, out, _ = run("sequence", tower["tower"], "--courses")
    assert status == INTERRUPTED
    assert out.splitlines()[1] == "2 of 3 courses; 2 of them stand by themselves."


@pytest.fixture
def tower(places):
    """A tower of three stones in stages: after the second step of its plan nothing is missing but the top."""
    groups = ("", "foot", "shaft", "top")
    stages = [{"name": group, "place": [group]} for group in groups[1:]]
    tower = stack(3, name="tower").with_(groups=groups, metadata={"stages": stages})
    tower = write(tower, places["folder"] / "tower.json")
    plan = places["folder"] / "steps.json"
    write_plan(Plan(tuple(Step((f"stone{k}",)) for k in range(3))), plan)
    return places | {"tower": tower, "steps": plan}


def interrupt_after(monkeypatch, states):
    """Ctrl-C while a state is judged, once so many are."""
    assess, judged = Whole.assess, []

    def interrupted(*given, **options):
        if len(judged) >= states:
            raise KeyboardInterrupt
        judged.append(given)
        return assess(*given, **options)

    monkeypatch.setattr(Whole, "assess", interrupted)


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_leaves_the_stages_that_are_judged(run, tower, monkeypatch, as_json):
    interrupt_after(monkeypatch, 2)
    status, out, err = run("sequence", tower["tower"], "--stages", *["--json"] * as_json)
    assert status == INTERRUPTED
    assert err.endswith("blockstat: interrupted\n")
    if as_json:
        told = json.loads(out)
        assert (told["verdict"], told["missing"]) == ("stopped", 1)
        assert [stage["name"] for stage in told["stages"]] == ["foot", "shaft"]
    else:
        judged = ["foot: 1 blocks, stable", "shaft: 2 blocks, stable"]
        assert out.splitlines() == ["Stopped: 2 of 3 stages and courses were judged.", *judged]


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_leaves_the_steps_of_a_plan_that_are_judged(run, tower, monkeypatch, as_json):
    interrupt_after(monkeypatch, 2)
    question = ["sequence", tower["tower"], "--plan", tower["steps"], "--tilt", "-o", tower["out"]]
    status, out, _ = run(*question, *["--json"] * as_json)
    assert status == INTERRUPTED
    assert tower["out"].stat().st_size > 0
    if as_json:
        told = json.loads(out)
        assert (told["verdict"], told["outcome"], told["missing"]) == ("stopped", "stopped", 1)
        assert [step["verdict"] for step in told["steps"]] == ["stable", "stable"]
    else:
        first, head, stable, _tilt, _file = out.splitlines()
        assert first == "Stopped: an interrupt came before every step was judged."
        assert head.startswith("plan: 2 of 3 steps, at most 0 held")
        assert stable == "Each of these is stable."


def test_an_interrupt_in_the_search_of_the_least_friction_leaves_the_steps(run, tower, monkeypatch):
    interrupt_after(monkeypatch, 3)
    status, out, err = run("sequence", tower["tower"], "--plan", tower["steps"], "--reserve", "--json")
    assert status == INTERRUPTED
    assert "the least friction at which every step stands was not found" in err
    told = json.loads(out)
    assert (told["verdict"], told["missing"], told["least_friction"], len(told["steps"])) == ("stable", 0, None, 3)


def test_an_example_goes_into_a_folder_that_is_made(run, places):
    place = places["folder"] / "examples" / "tower.toml"
    assert run(*f"example tower -o {place}".split())[:2] == (0, f"{place}\n")
    assert place.is_file()


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_leaves_the_blocks_that_were_taken_out(run, tower, monkeypatch, as_json):
    # The whole tower; without stone0, and stone1 and stone2 alone above it; without stone1, stone0 alone below it, and
    # what is left when stone2 has fallen.
    interrupt_after(monkeypatch, 7)
    status, out, _ = run("sequence", tower["tower"], "--remove-each", *["--json"] * as_json)
    assert status == INTERRUPTED
    if as_json:
        told = json.loads(out)
        assert (told["removed"], told["missing"]) == ({"stone0": "unstable", "stone1": "unstable"}, 1)
    else:
        first, second, *rows = out.splitlines()
        assert first == "Stopped: 2 of 3 blocks were taken out in turn."
        assert second == "0 of 2 blocks may be taken out now."
        assert [row.split(";")[0] for row in rows] == ["stone0: unstable", "stone1: unstable"]


@pytest.mark.parametrize(("question", "told"), [
    (("--stages",), "3 of 3 stages and courses judged (Ctrl-C keeps them)"),
    (("--remove-each",), "3 of 3 blocks taken out (Ctrl-C keeps them)"),
    (("--plan", "{steps}"), "3 of 3 steps judged (Ctrl-C keeps them)"),
])  # fmt: skip
def test_what_is_judged_of_a_sequence_is_counted_meanwhile(run, tower, monkeypatch, question, told):
    said = []

    @contextmanager
    def at_work(_):
        yield said.append

    monkeypatch.setattr("blockstat.cli.sequence.at_work", at_work)
    assert run("sequence", tower["tower"], *(text.format(**tower) for text in question))[0] == 0
    assert len(said) == 3
    assert said[-1] == told


def test_an_interrupt_while_a_picture_is_drawn_does_not_take_the_answer(run, tower, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("blockstat.view.building.removal.plot_removal", interrupt)
    status, out, _ = run("sequence", tower["tower"], "--remove-each", "-o", tower["out"])
    assert status == INTERRUPTED
    assert out.startswith("1 of 3 blocks may be taken out now: stone2.\n")


def test_a_report_on_a_file_of_no_encoding_names_it_by_its_code(places, monkeypatch):
    monkeypatch.setattr("blockstat.view.assessment._pictures", lambda found: "")
    file, page = places["folder"] / "caf\udce9.json", places["page"]
    write_report(file, read(places["post"]), page, directions=4)
    assert r"caf\udce9.json" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("as_json", [False, True])
def test_an_interrupt_leaves_the_load_cases_that_are_done(run, places, monkeypatch, as_json):
    interrupt_limit_loads(monkeypatch)
    status, out, _ = run("cases", places["post"], "--loads", places["cases"], *["--json"] * as_json)
    assert status == INTERRUPTED
    rows = json.loads(out)["rows"] if as_json else [line.split() for line in out.splitlines()[1:]]
    assert [row["case" if as_json else 0] for row in rows] == ["resting"]


def test_a_block_with_a_colon_in_its_name_can_be_the_control(run, tmp_path):
    blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="wall:1")]
    wall = write(Assembly.from_blocks(blocks, supports=["ground"]), tmp_path / "wall.json")
    for control in ("wall:1", "wall:1:0.5,0.5,2"):
        status, out, _ = run("capacity", wall, "--load", "1,0,0", "--steps", 3, "--control", control)
        assert (status, "wall:1" in out) == (0, True)


def test_a_control_that_is_not_there_is_answered_with_each_name_once(run, tmp_path):
    tower = stack(2).with_(groups=("", "stone0", "shaft"))
    status, out, err = run("capacity", write(tower, tmp_path / "t.json"), "--load", "1,0,0", "--control", "foo")
    assert (status, out) == (2, "")
    assert err.endswith('no control "foo"; controls are: ground, stone0, stone1, shaft, mean\n')


def test_tilt_and_friction_and_ties_take_load_cases(run, places):
    """A post of weight 2, half as wide as high: pushed at its centre by .8 it needs a friction of .4.

    Tilted by a about y, 2 sin a + .8 pushes it and 2 cos a holds it down: it tips where the ratio is 1/2.
    """
    chosen = ("--loads", places["cases"], "--case", "resting")
    status, out, _ = run("friction", places["post"], *chosen, "--json")
    assert (status, json.loads(out)["case"], json.loads(out)["stands"]) == (0, "resting", pytest.approx(0.4, abs=1e-4))
    out = run("tilt", places["post"], "--axis=0,-1,0", *chosen)[1]
    angle = math.degrees(math.asin(1.0 / math.sqrt(5.0)) - math.asin(0.8 / math.sqrt(5.0)))
    assert float(re.search(r"Stable at a tilt of (.*) deg", out)[1]) == pytest.approx(angle, abs=1e-3)
    assert "Warning: loads stay as they are while gravity rotates" in out
    assert "loads stay" not in run("tilt", places["post"], "--axis", "y")[1]
    # The storm of 3.2 tips it with 3.2 - 1 about the edge (1, 0), 3 / sqrt(2) beside the tie from (-2, 0) to (0, 2).
    tie = ("--between", "ground,stone0", "--points=-2,0.5,0,0,0.5,2", "--friction", 2)
    out = run("tie", places["post"], *tie, "--loads", places["cases"], "--case", "storm", "--json")[1]
    assert json.loads(out)["least"] == pytest.approx(2.2 * math.sqrt(2.0) / 3.0, rel=1e-4)
    plain = json.loads(run("tie", places["post"], *tie, "--json")[1])
    assert (plain["least"], plain["warnings"]) == (pytest.approx(0, abs=1e-6), [])
    written = run("tie", places["post"], *tie, "-o", places["post"].with_name("tied.json"))[1]
    assert "Warning: the tie in tied.json has no greatest force" in written


def test_that_loads_do_not_tilt_is_told_where_there_are_loads(run, places):
    chosen = ("--loads", places["cases"], "--case", "resting")
    words = "--tilt y,1 rotates gravity alone; loads of a case stay as they are"
    for command in (("check", *chosen), ("cases", "--loads", places["cases"]), ("friction", *chosen)):
        with pytest.warns(InputWarning, match=words):
            run(command[0], places["post"], "--tilt", "y,1", *command[1:])
    for command in (("--tilt", "y,1"), chosen):
        with warnings.catch_warnings(record=True) as told:
            run("check", places["post"], *command)
        assert not [one for one in told if "rotates" in str(one.message)]


def test_names_with_a_comma_are_told_apart_and_moved(run, tmp_path):
    blocks = [box((0, 0, 0), (1, 1, 1), name="a,b"), box((0, 0, 1), (1, 1, 2), name="c:1")]
    scene = write(Assembly.from_blocks(blocks, supports=[0], density=1000.0), tmp_path / "names.json")
    status, _, said = run("check", scene, "--supports", "a,b")
    assert status == 2
    assert 'no block "a"; blocks are: "a,b", "c:1"; commas part the names of a list, so give' in said
    assert run("check", scene, "--supports", "0")[0] == 0
    status, out, _ = run("settle", scene, "--move", "a,b:0,0,-0.01")
    assert status == 0
    assert '"a,b" moves by (0, 0, -10) mm' in out
