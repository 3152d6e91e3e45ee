"""What the commands of `blockstat` tell of their input, and which files they take and write."""

import json
import subprocess
import sys
import warnings
from functools import partial
from pathlib import Path

import pytest
import typer

from blockstat import Assembly, InputWarning, box, read, write
from blockstat.cli.cases import case_warnings
from blockstat.cli.commands import app
from blockstat.cli.options import _status
from blockstat.cli.places import _same
from dynsim.cli.commands import app as dynsim
from evidence.scenes.small import stack

SCENE = """\
name = "post"
[elements.post]
kind = "box"
size = [0.5, 0.5, 1.0]
[loads.push]
kind = "body"
force = [100, 0, 0]
[cases.a]
live = { push = 1 }
[cases.b]
factors = { push = 1 }
"""
NONE_ACTS = "no load of the scene acts without --case NAME, one of a, b"


@pytest.fixture
def run(run_command):
    return partial(run_command, app, "blockstat")


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "post.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def two(tmp_path):
    """Two stones on a ground."""
    return write(stack(2, 1.0, 1.0), tmp_path / "two.json")


@pytest.mark.usefixtures("recwarn")
def test_warnings_about_the_input_are_in_the_json_of_the_command_that_gives_them_alone(run, scene, two):
    status, out, _ = run("check", scene, "--json")
    assert (status, json.loads(out)["warnings"]) == (0, [f"{scene}: {NONE_ACTS}"])
    for command in ("check", "limit", "tilt"):
        asked = {"limit": ("--load", "1,0,0"), "tilt": ("--axis", "y")}.get(command, ())
        assert f"{scene}: {NONE_ACTS}" in json.loads(run(command, scene, *asked, "--json")[1])["warnings"]
    tilted = json.loads(run("check", scene, "--case", "a", "--tilt", "y,1", "--json")[1])["warnings"]
    assert tilted[0] == "--tilt y,1 rotates gravity alone; loads of a case stay as they are"
    around = json.loads(run("limit", scene, "--directions", 4, "--json")[1])
    assert f"{scene}: {NONE_ACTS}" in around["warnings"]
    with_loads = run("limit", scene, "--directions", 4, "--case", "b", "--json")[1]
    assert not any(NONE_ACTS in text for text in json.loads(with_loads)["warnings"])
    taken = json.loads(run("sequence", scene, "--remove-each", "--json")[1])["warnings"]
    assert taken == [f"{scene}: no load of the scene acts here: this command takes no load case, as a, b"]
    assert json.loads(run("check", two, "--json")[1])["warnings"] == []
    assert json.loads(run("sequence", two, "--remove-each", "--json")[1])["warnings"] == []


@pytest.mark.parametrize(
    ("chosen", "words"), [((), NONE_ACTS), (("--case", "a", "--tilt", "y,1"), "--tilt y,1 rotates")]
)
def test_warnings_about_the_input_are_in_the_report_and_on_standard_error(
    run, scene, tmp_path, monkeypatch, chosen, words
):
    monkeypatch.setattr("blockstat.view.assessment._pictures", lambda found: "")
    with pytest.warns(match=words):
        assert run("report", scene, "-o", tmp_path / "r.html", "--directions", 4, *chosen)[0] == 0
    page = (tmp_path / "r.html").read_text()
    told = page[page.index("<h2>Warnings</h2>") : page.index("<h2>What the answers mean</h2>")]
    assert words in told
    assert (NONE_ACTS in told) is not bool(chosen)
    assert "Warnings</h2><p>None" not in page


def test_a_picture_of_forces_is_told_that_no_load_acts(run, scene, tmp_path):
    with pytest.warns(match="no load of the scene acts here"):
        assert run("plot", scene, "-o", tmp_path / "forces.png", "--forces")[0] == 0


@pytest.fixture
def loads(tmp_path):
    """Cases of which one pushes a post of weight 20 that moves already, so that it bears no live load."""
    path = tmp_path / "loads.toml"
    text = '[loads.push]\nkind = "body"\nforce = [50, 0, 0]\n[cases.pushed]\nfactors = { push = 1 }\n'
    path.write_text(text + "[cases.more]\nfactors = { push = 1 }\nlive = { push = 1 }\n[cases.light]\nweight = 0.5\n")
    return path


def test_the_table_of_cases_has_what_the_answers_rest_on_and_their_warnings(run, tmp_path, loads):
    blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="post")]
    blocks.append(box((0, 0, 9), (1, 1, 10), name="cloud"))
    file = write(Assembly.from_blocks(blocks, supports=["ground"], density=1.0), tmp_path / "post.json")
    status, out, _ = run("cases", file, "--loads", loads)
    assert status == 0
    assert "more    unstable    dead load unstable\n" in out
    assert out.count('Warning: block "cloud" touches nothing\n') == 1
    found = json.loads(run("cases", file, "--loads", loads, "--units", "m", "--friction", 0.6, "--json")[1])
    assert (found["friction"], found["units"], found["gravity"][:2]) == (0.6, "m", [0, 0])
    assert 'block "cloud" touches nothing' in found["warnings"]
    assert all('block "cloud" touches nothing' in row["warnings"] for row in found["rows"])
    assert [row.get("status") for row in found["rows"]] == [None, "dead_load_unstable", None]


def test_a_warning_of_some_cases_names_them():
    rows = [{"case": name, "warnings": own} for name, own in (("a", ["x", "y"]), ("b", ["y", "z"]), ("c", ["y", "z"]))]
    assert case_warnings(rows) == ["case a: x", "y", "cases b, c: z"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["check", "{two}", "-o", ""], "-o: the name of a file is empty"),
        (["check", "{two}", "--output="], "--output: the name of a file is empty"),
        (["convert", "{two}", "-o", "", "--format", "ply"], "-o: the name of a file is empty"),
        (["capacity", "{two}", "--load", "1,0,0", "--film", ""], "--film: the name of a file is empty"),
        (["check", "{two}", "--case", "a", "--loads", ""], "--loads: the name of a file is empty"),
        (["check", "--json", ""], "the name of a file is empty"),
        (["check", "--friction", "0.5", ""], "the name of a file is empty"),
        (["check", "{two}", "--gravity", ""], '--gravity is ""; it must read GX,GY,GZ'),
    ],
)
def test_a_file_without_a_name_is_refused_with_its_option(run, two, arguments, words):
    status, out, err = run(*[text.format(two=two) for text in arguments])
    assert (status, out, err) == (2, "", f"blockstat: {words}\n")


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("check {two} -o {two}", "-o {two}: this file is read, and would be overwritten; give another place"),
        ("check {two} -o {again}", "-o {again}: this file is read, and would be overwritten; give another place"),
        ("tie {two} --between a,b -o {link}", "-o {link}: this file is read, and would be overwritten"),
        ("sequence {two} --held-at-most 1 --journal {two}", "--journal {two}: this file is read, and would be"),
        ("sequence {plan} --courses -o {plan}", "-o {plan}: this file is read, and would be overwritten"),
        ("capacity {two} --load 1,0,0 -o {z} --film {z}", "-o and --film are both {z}; one would overwrite the other"),
        ("settle {two} --move ground:0,0,1 -o {z} --film {z}", "-o and --film are both {z}; one would overwrite the"),
    ],
)
def test_a_file_that_is_read_or_written_too_is_not_written_over(run, two, tmp_path, command, words):
    (tmp_path / "link.json").symlink_to(two)
    (tmp_path / "plan.json").write_text("{}")
    places = {"two": two, "again": tmp_path / ".." / tmp_path.name / "two.json", "z": tmp_path / "z.png"}
    places |= {name: tmp_path / f"{name}.json" for name in ("link", "plan")}
    before = two.read_bytes()
    status, out, err = run(*command.format(**places).split())
    assert (status, out) == (2, "")
    assert err.startswith("blockstat: " + words.format(**places))
    assert two.read_bytes() == before
    assert not places["z"].exists()


def test_a_device_takes_both_what_is_read_and_what_is_written(two):
    assert not _same(Path("/dev/null"), Path("/dev/null"))
    assert _same(two, two)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is full")
@pytest.mark.parametrize("options", [(), ("--json",)])
def test_a_full_standard_output_is_named(two, options):
    code = "from blockstat.cli.commands import main; main()"
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-c", code, "check", str(two), *options]
        answer = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert (answer.returncode, answer.stderr) == (2, "blockstat: standard output: No space left on device\n")


def test_an_error_of_another_file_is_not_one_of_standard_output(capsys):
    def fail():
        raise OSError(28, "No space left on device")

    assert _status(fail, "blockstat") == 2
    assert capsys.readouterr().err == "blockstat: No space left on device\n"


@pytest.mark.parametrize(
    ("command", "value"),
    [
        ("reliability {two} --uncertain", "friction=normal,0.6,nan"),
        ("reliability {two} --uncertain", "friction=normal,0.6,0.1,joint,x"),
        ("settle {two} --move", "ground:0,0"),
        ("settle {two} --move", "0,0:0,0,1"),
        ("capacity {two} --load 1,0,0 --control", "stone0:1,2"),
        ("sequence {two} --courses --along", "wall=0,1"),
    ],
)
def test_an_option_that_does_not_read_as_it_must_is_quoted_whole(run, two, command, value):
    status, out, err = run(*command.format(two=two).split(), value)
    assert (status, out) == (2, "")
    assert f'{command.split()[-1]} is "{value}"; it must read ' in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["check", "{two}", "--supports", ""], 'supports: no block ""'),
        (["repair", "{two}", "--supports", "", "-o", "{folder}/r.json"], 'supports: no block ""'),
        (["example", "--list", "foo"], "--list names the examples, and takes none; given: foo"),
        (["example", "-o", "{folder}/ex.toml"], "-o is where one example goes; give its name"),
        (["example", "aqueduct", "-o", "{folder}/ex.json"], 'ex.json: cannot write ".json"; it is written as: .toml'),
    ],
)
def test_an_option_that_would_be_ignored_is_refused(run, two, tmp_path, arguments, words):
    status, out, err = run(*[text.format(two=two, folder=tmp_path) for text in arguments])
    assert (status, out) == (2, "")
    assert words in err
    assert list(tmp_path.iterdir()) == [two]


@pytest.mark.parametrize("name", ["c.gif", "c.pdf"])
@pytest.mark.parametrize("command", ["capacity {two} --load 1,0,0", "settle {two} --move ground:0,0,1"])
def test_a_film_is_written_as_what_the_help_says_alone(run, two, tmp_path, command, name):
    status, out, err = run(*command.format(two=two).split(), "--film", tmp_path / name)
    assert (status, out) == (2, "")
    assert f'cannot write "{name[1:]}"; it is written as: .glb, .png, .svg' in err


def test_a_sequence_says_what_it_wrote(run, two, tmp_path):
    plan, picture = tmp_path / "plan.json", tmp_path / "steps.svg"
    for command, place in (
        (("--held-at-most", 2), plan),
        (("--plan", plan), picture),
        (("--remove-each",), picture),
    ):
        status, out, _ = run("sequence", two, *command, "-o", place)
        assert (status, out.splitlines()[-1]) == (0, f"output: {place}")
        place.unlink()
        assert json.loads(run("sequence", two, *command, "-o", place, "--json")[1])["output"] == str(place)
        assert place.is_file()
        assert "output" not in json.loads(run("sequence", two, *command, "--json")[1])


WALL = """
[elements.wall]
kind = "box"
size = [0.5, 3.0, 2.0]
density = 2700
[loads.wind]
kind = "surface"
pressure = [6000, 0, 0]
towards = [-1, 0, 0]
"""
NO_CASE = "these loads act in no load case: wind; a case names them in [cases.NAME]"


@pytest.mark.parametrize("cases", ["", "[cases.still]\nweight = 0.9\n"])
def test_loads_that_no_case_has_are_told(run, tmp_path, cases):
    """They would overturn the wall: 36 kN at half its height."""
    path = tmp_path / "wall.toml"
    path.write_text(WALL + cases)
    chosen = ("--case", "still") if cases else ()
    for command, asked in (("check", ()), ("limit", ("--load", "1,0,0"))):
        with pytest.warns(match="these loads act in no load case"):
            status, out, _ = run(command, path, *asked, *chosen, "--json")
        assert status == 0
        assert f"{path}: {NO_CASE}" in json.loads(out)["warnings"]
    acting = "[cases.storm]\nfactors = { wind = 1 }\n"
    path.write_text(WALL + cases + acting)
    status, out, _ = run("check", path, "--case", "storm", "--json")
    assert (status, json.loads(out)["verdict"], json.loads(out)["warnings"]) == (0, "unstable", [])


@pytest.mark.parametrize(("weight", "told"), [(1.5, True), (0.6, False)])
def test_a_case_that_presses_down_without_mass_is_told_where_an_acceleration_grows(
    run, tmp_path, monkeypatch, weight, told
):
    """A building half as heavy again tips at the same share of its weight; pressed down by as much, it tips later."""
    monkeypatch.setattr("blockstat.view.assessment._pictures", lambda found: "")
    path = tmp_path / "wall.toml"
    path.write_text(WALL + f"[cases.own]\nweight = {weight}\n[cases.windy]\nfactors = {{ wind = 1 }}\n")
    asked = [("limit", "--load", "1,0,0", "--json"), ("limit", "--directions", 4, "--json")]
    asked.append(("report", "-o", tmp_path / "r.html", "--directions", 4))
    for command, *options in asked:
        with warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("always")
            assert run(command, path, *options, "--case", "own")[0] == 0
        extra = (weight - 1) * 0.5 * 3 * 2 * 2700 * 9.81
        text = f'case "own": the loads that stay press down by {extra:.6g} N and have no mass'
        assert any(str(each.message).startswith(text) for each in given) is told


#: A pier of 19620 N, and a roof that weighs as much on its top.
SHAKEN = """
[material]
density = 2000
[elements.pier]
kind = "box"
size = [0.5, 1, 2]
[loads]
roof = { kind = "point", block = "pier", point = [0, 0, 2], force = [0, 0, -19620] }
inertia = { kind = "point", block = "pier", point = [0, 0, 2], force = [19620, 0, 0] }
wind = { kind = "point", block = "pier", point = [0, 0, 2], force = [19620, 0, 0] }
quake = { kind = "acceleration", direction = [1, 0, 0] }
[cases]
roofed = { factors = { roof = 1.0 }, live = { quake = 1.0 } }
heavy = { weight = 2.0, live = { quake = 1.0 } }
half = { factors = { roof = 1.0 }, live = { quake = 2.0, inertia = 1.0 } }
whole = { factors = { roof = 1.0 }, live = { quake = 2.0, inertia = 2.0 } }
windy = { factors = { roof = 1.0 }, live = { wind = 1.0 } }
still = { factors = { roof = 1.0 }, live = { wind = 1.0, quake = 0.0 } }
light = { weight = 0.5, factors = { roof = 0.5 } }
"""


@pytest.mark.parametrize("command", ["limit", "capacity"])
@pytest.mark.parametrize(
    ("case", "idle"), [("roofed", 19620), ("heavy", 19620), ("half", 9810), ("whole", 0), ("windy", 0), ("still", 0)]
)
def test_an_earthquake_among_the_live_loads_does_not_push_what_has_no_mass(run, tmp_path, command, case, idle):
    """With all of the roof's inertia 1 g tips it at 1/6, 2 g at 1/12; a wind has a limit of its own."""
    path = tmp_path / "pier.toml"
    path.write_text(SHAKEN)
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        status, out, _ = run(command, path, "--case", case, "--json")
    told = [str(each.message) for each in given if "no mass" in str(each.message)]
    assert len(told) == bool(idle)
    assert all(text.startswith(f'case "{case}": the loads that stay press down by {idle} N') for text in told)
    assert status == 0
    if (command, case) == ("limit", "whole"):
        assert json.loads(out)["upper"] == pytest.approx(1 / 12, rel=1e-3)


def test_the_table_of_cases_tells_what_an_earthquake_does_not_push(run, tmp_path):
    path = tmp_path / "pier.toml"
    path.write_text(SHAKEN)
    _, out, _ = run("cases", path, "--json")
    rows = {row["case"]: [text for text in row["warnings"] if "no mass" in text] for row in json.loads(out)["rows"]}
    assert {name for name, told in rows.items() if told} == {"roofed", "heavy", "half"}
    assert rows["half"][0].startswith("the loads that stay press down by 9810 N and have no mass")


def test_a_lighter_weight_takes_no_mass_from_a_roof_in_limit_and_code_check_alike(run, tmp_path):
    path = tmp_path / "pier.toml"
    path.write_text(SHAKEN)
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        run("limit", path, "--case", "light", "--load", "1,0,0")
        out = run("code-check", path, "--case", "light", "--load", "1,0,0")[1]
    assert any('case "light": the loads that stay press down by 9810 N' in str(each.message) for each in given)
    assert "permanent loads of 9810 N press down and have no mass" in out


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            "check {two} --supports ground --supports stone0",
            "--supports is given twice; it takes one value: --supports",
        ),
        ("check {two} --case a --friction .9 --case=a", "--case is given twice; it takes one value: --case NAME"),
        ("check {two} --tilt x,5 --tilt y,5", "--tilt is given twice; it takes one value: --tilt AXIS,DEGREES"),
        ("limit {two} --load 1,0,0 --load 0,1,0", "--load is given twice; it takes one value: --load AX,AY,AZ"),
        ("check {two} -o {folder}/a.glb --output {folder}/b.glb", "-o is given twice; it takes one value"),
        ("--most-blocks 5 --most-blocks 9 check {two}", "--most-blocks is given twice; it takes one value"),
    ],
)
def test_a_single_value_that_is_given_twice_is_refused(run, two, tmp_path, command, words):
    status, out, err = run(*command.format(two=two, folder=tmp_path).split())
    assert (status, out) == (2, "")
    assert err.startswith(f"blockstat: {words}")
    assert list(tmp_path.iterdir()) == [two]


@pytest.mark.parametrize("program", [app, dynsim], ids=["blockstat", "dynsim"])
def test_all_commands_refuse_every_single_value_that_is_given_twice(run_command, program):
    commands = typer.main.get_command(program).commands
    assert len(commands) > 7
    for name, command in commands.items():
        for own in command.params:
            if own.param_type_name == "option" and not (own.is_flag or own.multiple):
                given = [text for option in (own.opts[0], own.opts[-1]) for text in (option, "1")]
                status, out, err = run_command(program, "it", name, *given)
                assert (status, out) == (2, "")
                assert err.startswith(f"it: {own.opts[0]} is given twice"), (name, err)


def test_flags_and_options_of_several_values_may_be_given_again(run, two):
    assert run("check", two, "--json", "--json")[0] == 0
    moves = ("--move", "ground:0,0,-0.01", "--move", "ground:0.01,0,0")
    assert "--move names a part twice" in run("settle", two, *moves)[2]  # read by the command itself
    assert run("check", two, "--imperfection", "edge=1%", "--imperfection", "friction=1.2")[0] == 0


def test_blanks_around_names_and_capitals_of_units_and_axes_are_read(run, two, tmp_path):
    mesh = write(read(two), tmp_path / "two.obj", up="y", units="mm")
    told = [
        json.loads(run("check", mesh, "--supports", names, "--up", up, "--units", units, "--json")[1])
        for names, up, units in (("ground,stone0", "y", "mm"), ("ground, stone0 ", "Y", "MM"))
    ]
    assert told[0]["verdict"] == "stable"
    for key in ("weight", "supports", "up", "units", "moving"):
        assert told[0].get(key) == told[1].get(key)


def test_a_file_that_is_turned_is_told_in_the_answer_and_the_report(run, two, tmp_path, monkeypatch):
    monkeypatch.setattr("blockstat.view.assessment._pictures", lambda found: "")
    turned, glb = write(read(two), tmp_path / "two.obj", up="y"), write(read(two), tmp_path / "two.glb")
    words = "coordinates in m, turned: y up in the file, joints closed"
    assert words in run("check", turned, "--up", "y")[1]
    assert words in run("check", glb)[1]
    assert "turned" not in run("check", two)[1]
    assert json.loads(run("check", turned, "--up", "y", "--json")[1])["up"] == "y"
    assert json.loads(run("check", two, "--json")[1])["up"] == "z"
    assert run("report", turned, "--up", "y", "-o", tmp_path / "r.html", "--directions", 4)[0] == 0
    assert "two.obj, turned: y up in the file, z up here" in (tmp_path / "r.html").read_text()


def test_loads_of_a_file_with_y_up_are_in_axes_with_z_up(run, tmp_path):
    """A slab, 3 m high, 1 m thick along y and 2 m long along x, which tips about y at a third and about x at two."""
    blocks = [box((-3, -3, -1), (3, 3, 0), name="ground"), box((-1, -0.5, 0), (1, 0.5, 3), name="slab")]
    slab = Assembly.from_blocks(blocks, supports=["ground"], friction=5.0)
    turned = write(slab, tmp_path / "slab.obj", up="y")
    for load, expected in (("1,0,0", 2 / 3), ("0,1,0", 1 / 3)):
        found = json.loads(run("limit", turned, "--up", "y", "--load", load, "--json")[1])
        assert found["lower"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("gravity", "words"),
    [
        ("0,0,9.81", "gravity points up; down is -z"), ("0,1,9.81", "gravity points up"),
        ("9.81,0,0", "gravity points sideways"), ("0,0,-9810", "gravity is 9,810 m/s2"),
        ("0,0,-0.00981", "gravity is 0.00981 m/s2"), ("0,1,-9.81", ""), ("0,0,-1", ""), ("0,0,-1.62", ""),
    ],
)  # fmt: skip
def test_a_gravity_that_does_not_pull_down_or_is_of_another_unit_is_doubted(run, two, tmp_path, gravity, words):
    with warnings.catch_warnings():
        warnings.simplefilter("always", InputWarning)
        told = json.loads(run("check", two, "--gravity", gravity, "--json")[1])["warnings"]
        data = json.loads(two.read_text()) | {"gravity": [float(part) for part in gravity.split(",")]}
        own = tmp_path / "own.json"
        own.write_text(json.dumps(data))
        of_file = json.loads(run("check", own, "--json")[1])["warnings"]
    for found in (told, of_file):
        assert [text for text in found if "gravity" in text] == [text for text in found if words and words in text]
        assert any("gravity" in text for text in found) is bool(words)


def test_an_acceleration_of_the_ground_that_may_be_in_metres_is_doubted(run, two):
    with warnings.catch_warnings():
        warnings.simplefilter("always", InputWarning)
        told = json.loads(run("code-check", two, "--load", "1,0,0", "--ag", "1.47", "--json")[1])["warnings"]
        assert any("--ag is 1.47 g" in text and "1.47 m/s2 are 0.15" in text for text in told)
        told = json.loads(run("code-check", two, "--load", "1,0,0", "--ag", "0.5", "--json")[1])["warnings"]
        assert not any("--ag" in text for text in told)


def test_live_loads_of_zero_are_not_the_same_as_none(run, two, tmp_path):
    path = tmp_path / "loads.toml"
    loads = "".join(f'[loads.{name}]\nkind = "body"\nforce = [{size}, 0, 0]\n' for name, size in (("no", 0), ("w", 9)))
    cases = "[cases.a]\nlive = { no = 1 }\n[cases.b]\nlive = { w = 0 }\n[cases.c]\nfactors = { w = 1 }\n"
    path.write_text(loads + cases)
    lines = run("cases", two, "--loads", path)[1].splitlines()
    assert [line.split("stable")[1].strip() for line in lines[1:]] == ["live loads are zero"] * 2 + ["no live loads"]
    assert 'the live loads of case "a" are zero' in run("limit", two, "--loads", path, "--case", "a")[2]
    assert 'case "c" has no live loads' in run("limit", two, "--loads", path, "--case", "c")[2]


def test_a_plan_in_place_of_an_assembly_and_a_decimal_comma_are_told(run, two, tmp_path):
    plan, comma = tmp_path / "plan.json", tmp_path / "comma.json"
    plan.write_text(json.dumps({"steps": [{"install": ["stone0"]}]}))
    comma.write_text(json.dumps(json.loads(two.read_text()) | {"friction": "0,7"}))
    assert "this is a plan of building; give the assembly, and --plan with it" in run("check", plan)[2]
    assert (
        "friction: it must be a number, not a text; write 0.7 without quotes, with a decimal point"
        in run("check", comma)[2]
    )
    status, _, err = run("check", two, "--friction", "0,5")
    assert (status, "a decimal point, such as 0.5" in err) == (2, True)
