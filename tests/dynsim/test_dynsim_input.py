"""What the commands of `dynsim` make of files, options and warnings, before and after an analysis that is not run."""

import json
from functools import partial
from pathlib import Path

import pytest

from blockstat import InputError, InputWarning
from dynsim.cli.commands import app

SCENE = """\
name = "post"
[parameters]
width = { value = 0.5, min = 0.4, max = 0.5, step = 0.1 }
[elements.post]
kind = "box"
size = ["= width", 0.5, 1.0]
[loads.push]
kind = "body"
force = [100, 0, 0]
[cases.a]
live = { push = 1 }
[cases.b]
live = { push = 2 }
"""


@pytest.fixture
def run(run_command):
    return partial(run_command, app, "dynsim")


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "post.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def idle(monkeypatch):
    """Analyses that end at once."""

    def over(*_, **__):
        raise InputError("over")

    for name in ("judge.verify.verify", "earthquake.analysis.incremental", "design_search.optimise.optimise"):
        monkeypatch.setattr(f"dynsim.{name}", over)
    monkeypatch.setattr("dynsim.parallel.pool.run_many", lambda *_, **__: None)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("verify {scene}", ["without --case NAME, one of a, b"]),
        ("verify {scene} {other}", ["without --case NAME, one of a, b"] * 2),
        ("verify {scene} --case a", []),
        ("shake {scene} --pulse 1,0,0,1", ["here: this command takes no load case, as a, b"]),
        ("compare {scene} {other}", ["here: this command takes no load case, as a, b"] * 2),
        ("ida {scene} --record {record}", ["here: this command takes no load case, as a, b"]),
        ("optimise {scene} -o {folder}/out", ["here: this command takes no load case, as a, b"]),
    ],
)
@pytest.mark.usefixtures("idle")
def test_loads_of_a_scene_that_do_not_act_are_told_once_a_file(run, scene, tmp_path, recwarn, command, words):
    other, record = tmp_path / "other.toml", tmp_path / "quake.csv"
    other.write_text(SCENE)
    record.write_text("0,0\n0.1,1\n0.2,0\n")
    run(*command.format(scene=scene, other=other, record=record, folder=tmp_path).split())
    told = [str(one.message) for one in recwarn if issubclass(one.category, InputWarning)]
    files = (scene, other)
    assert told == [f"{file}: no load of the scene acts {why}" for file, why in zip(files, words, strict=False)]


@pytest.mark.usefixtures("recwarn")
@pytest.mark.usefixtures("idle")
def test_warnings_about_the_input_are_in_the_json(run, scene):
    out = run("compare", scene, "--json")[1]
    assert json.loads(out)["warnings"] == [
        f"{scene}: no load of the scene acts here: this command takes no load case, as a, b"
    ]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["ida", "{scene}", "--record", ""], "--record: the name of a file is empty"),
        (["verify", "{scene}", "-o", ""], "-o: the name of a file is empty"),
        (["verify", "{scene}", "-o", "r.npz", "--film", ""], "Invalid value for '--film'"),
    ],
)
def test_a_file_without_a_name_is_refused_with_its_option(run, scene, arguments, words):
    status, out, err = run(*[text.format(scene=scene) for text in arguments])
    assert (status, out, err.startswith(f"dynsim: {words}")) == (2, "", True)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("compare {scene} -o {folder}/rows.json", 'cannot write ".json"; it is written as: .csv'),
        ("compare {scene} {table} -o {table}", "this file is read, and would be overwritten; give another place"),
        ("ida {scene} --record {table} --plot {table}", "this file is read, and would be overwritten"),
    ],
)
def test_a_table_is_written_as_such_and_over_nothing_that_is_read(run, scene, tmp_path, command, words):
    table = tmp_path / "table.csv"
    table.write_text("0,0\n1,0\n")
    status, out, err = run(*command.format(scene=scene, table=table, folder=tmp_path).split())
    assert (status, out) == (2, "")
    assert words in err
    assert table.read_text() == "0,0\n1,0\n"


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--remove", "post@nan"),
        ("--settle", "ground:0,0"),
        ("--settle", "ground:0,0,1@fast"),
        ("--push", "post:1,2"),
        ("--push", "post:1,0,0@x"),
        ("--tilt-to", "x"),
        ("--tilt-to", "x,1,2,3"),
    ],
)
def test_an_option_that_does_not_read_as_it_must_is_quoted_whole(run, scene, option, value):
    status, out, err = run("verify", scene, option, value)
    assert (status, out) == (2, "")
    assert f'{option} is "{value}"; it must read ' in err
    assert '--pulse is "1,0"; it must read ' in run("shake", scene, "--pulse", "1,0")[2]


@pytest.mark.usefixtures("idle", "recwarn")
def test_no_process_at_all_is_refused_for_one_file_too(run, scene):
    status, out, err = run("verify", scene, "--jobs", -1)
    assert (status, out, err) == (2, "", "dynsim: --jobs is -1; it must be a whole number of at least 1\n")


@pytest.mark.usefixtures("idle")
def test_a_file_that_cannot_be_looked_at_loses_its_own_row_only(run, tmp_path, monkeypatch):
    exists = Path.exists

    def closed(path, **options):
        if path.name == "closed.json":
            raise PermissionError(13, "Permission denied", str(path))
        return exists(path, **options)

    monkeypatch.setattr(Path, "exists", closed)
    monkeypatch.setattr("os.access", lambda *_, **__: False)
    (tmp_path / "bad.json").write_text("{")
    status, out, err = run("verify", tmp_path / "bad.json", tmp_path / "closed.json")
    assert status == 2
    assert f"{tmp_path / 'bad.json'}: no verdict: " in out
    assert f"{tmp_path / 'closed.json'}: no verdict: {tmp_path / 'closed.json'}: Permission denied" in out
    assert err.endswith("dynsim: none of the files gave a verdict\n")
