"""The search with the real statics and the real Bullet: the same answer pruned, and after any interruption."""

import importlib
import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from blockstat import InputError, Memory, assess, scene_text, search
from blockstat.design_search.candidate import Candidate, SearchResult
from blockstat.spec import scene_from
from dynsim import Settings, verify
from dynsim.comparison.causes import likely_reason
from dynsim.design_search.optimise import _moved, optimise, shown_search

FAST = Settings.named("fast")


def between(low, high, step):
    return {"value": high, "min": low, "max": high, "step": step}


PORTAL = {
    "name": "portal",
    "parameters": {"t": between(0.1, 0.25, 0.05), "pier": between(0.3, 0.6, 0.1), "strut": "search"},
    "elements": {
        "arch": {"kind": "arch", "span": 2.0, "thickness": "= t", "depth": 0.5, "voussoirs": 7, "at": [0, 0, 1.0]},
        "left": {"kind": "box", "size": ["= pier", 0.5, 1.0], "at": ["= -1 - pier / 2", 0, 0]},
        "right": {"kind": "box", "size": ["= pier", 0.5, 1.0], "at": ["= 1 + pier / 2", 0, 0]},
        "prop": {"kind": "box", "size": [0.3, 0.5, 1.0], "at": ["= -1.15 - pier", 0, 0], "present": "= strut"},
    },
}  # fmt: skip
ARCHES = {
    "name": "arches",
    "parameters": {"n": between(5, 9, 1), "t": between(0.095, 0.125, 0.015)},
    "elements": {"arch": {"kind": "arch", "span": "= 2 - t", "thickness": "= t", "depth": 0.6, "voussoirs": "= n"}},
}


def both(scene, over):
    memory = Memory()
    quick = search(
        scene, verify=lambda a: verify(a, settings=FAST), static=lambda a: assess(a, memory=memory), memory=memory,
        over=over, remark=likely_reason,
    )  # fmt: skip
    whole = search(scene, verify=lambda a: verify(a, settings=FAST), strategy="paper", over=over)
    return whole, quick


@pytest.mark.parametrize(
    ("scene", "over"), [(ARCHES, "line"), (ARCHES, "grid"), (PORTAL, "line")], ids=["arches", "arches grid", "portal"]
)
def test_pruning_gives_the_design_that_simulating_everything_gives(scene, over):
    whole, quick = both(scene_from(scene), over)
    assert whole.best_parameters is not None
    assert quick.best_parameters == whole.best_parameters
    assert quick.dynamic_runs < whole.dynamic_runs == len(whole.history)
    # Nothing that statics exclude stood, so Bullet alone would have found the same.
    assert not [c for c in whole.history if c.excluded and c.dynamic == "stands"]


@pytest.mark.slow
def test_pruning_gives_the_design_that_simulating_a_whole_grid_gives():
    whole, quick = both(scene_from(PORTAL), "grid")
    assert quick.best_parameters == whole.best_parameters
    assert quick.dynamic_runs < whole.dynamic_runs / 4
    assert not [c for c in whole.history if c.excluded and c.dynamic == "stands"]


def test_where_they_disagree_the_search_goes_on_and_says_why():
    scene = scene_from(PORTAL)
    result = search(scene, verify=lambda a: verify(a, settings=FAST), names=["parameters.pier"], remark=likely_reason)
    assert result.best_parameters is not None
    for candidate in result.disagreements:
        assert candidate.static == "stable"
        assert candidate.dynamic in ("falls", "creeps")
        assert candidate.note
        assert candidate.parameters["parameters.pier"] < result.best_parameters["parameters.pier"]


def test_without_bullet_no_search_begins(tmp_path, monkeypatch):
    def refuse(name):
        raise ModuleNotFoundError(name)

    monkeypatch.delitem(sys.modules, "pybullet", raising=False)
    monkeypatch.setattr(importlib, "import_module", refuse)
    with pytest.raises(InputError, match=r"^Bullet needs pybullet: pip install "):
        optimise(scene_from(ARCHES), tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_corrected_scene_takes_the_directory_of_one_that_could_not_be_built(tmp_path):
    wrong = json.loads(json.dumps(ARCHES))
    wrong["elements"]["arch"]["at"] = [0, 0, -0.3]  # into the ground
    failed, report = optimise(scene_from(wrong), tmp_path, names=["parameters.t"], settings=FAST, jobs=1)
    assert failed.outcome.word == "failed"
    assert "into the ground" in failed.explain()
    assert report.is_file()
    assert len((tmp_path / "history.csv").read_text().splitlines()) > 1
    found, _ = optimise(scene_from(ARCHES), tmp_path, names=["parameters.t"], settings=FAST, jobs=1)
    assert found.best_parameters is not None
    with pytest.raises(InputError, match="of another search"):  # a history that is worth something is kept
        optimise(scene_from(wrong), tmp_path, names=["parameters.t"], settings=FAST, jobs=1)


PROGRAM = """
import json, sys
from dynsim.cli.commands import main
main()
"""
TOML = """
name = "arches"
[parameters]
n = { value = 9, min = 5, max = 9, step = 1 }
t = { value = 0.155, min = 0.095, max = 0.155, step = 0.015 }
[elements.arch]
kind = "arch"
span = "= 2 - t"
thickness = "= t"
depth = 0.6
voussoirs = "= n"
"""


def start(tmp_path, *options):
    scene = tmp_path / "arches.toml"
    scene.write_text(TOML)
    command = [
        sys.executable, "-c", PROGRAM, "optimise", str(scene), "-o", str(tmp_path / "out"), "--over", "grid",
        "--preset", "fast", "--json", *options,
    ]  # fmt: skip
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def plain(row):
    return {key: value for key, value in row.items() if "seconds" not in key}


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    process = start(tmp_path_factory.mktemp("whole"), "--jobs", "1")
    out, err = process.communicate()
    assert process.returncode == 0, err
    return json.loads(out)


@pytest.mark.slow
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGKILL], ids=["SIGINT", "SIGKILL"])
def test_stopped_again_and_again_the_history_ends_the_same(tmp_path, uninterrupted, sign):
    history = tmp_path / "out" / "history.csv"
    stops = 0
    for rows in (1, 3, 5):
        process = start(tmp_path)
        while process.poll() is None and not (history.is_file() and history.read_text().count("\n") > rows):
            time.sleep(0.01)
        if process.poll() is None:
            os.kill(process.pid, sign)
            stops += 1
        out, err = process.communicate()
        if sign is signal.SIGINT:
            assert "Traceback" not in err
    assert stops >= 2
    process = start(tmp_path)
    out, err = process.communicate()
    assert process.returncode == 0, err
    again = json.loads(out)
    assert again["best"] == uninterrupted["best"]
    assert list(map(plain, again["history"])) == list(map(plain, uninterrupted["history"]))


def test_on_a_terminal_a_search_is_a_bar_with_the_last_design(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "150")
    with shown_search() as progress:
        progress(2, 7, Candidate({"t": 0.2, "n": 7}, "stable", 0.0, "stands", 1.0, 7, 0.1, 0.2))
    text = capsys.readouterr()
    assert "0.2 7: stable / stands" in text.err
    assert "2/7" in re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text.err)
    assert text.out == ""


@pytest.mark.parametrize(
    ("dynamic", "said"),
    [
        ("falls", "The design with parameters.t 0.4 moved in Bullet though statics allow it."),
        ("creeps", "The design with parameters.t 0.4 was still moving, slowly, at the end of the run in Bullet"),
        ("stands", "The design with parameters.t 0.5 stands in Bullet."),
    ],
)
def test_a_picture_of_what_moved_is_of_a_design_that_statics_allow(tmp_path, dynamic, said):
    post = {"kind": "box", "size": ["= t", 0.5, 1.0]}
    scene = scene_from({"name": "post", "parameters": {"t": between(0.3, 0.5, 0.1)}, "elements": {"post": post}})
    rows = [(0.5, "stable", "stands"), (0.4, "stable", dynamic), (0.3, "unstable", "falls"), (0.2, "error", "falls")]
    history = [Candidate({"parameters.t": t}, static, 0.0, moved, t / 2, 2, 0.0, 0.0) for t, static, moved in rows]
    result = SearchResult(scene, scene, {"parameters.t": 0.5}, tuple(history))
    [figure] = _moved(result, tmp_path, FAST, lambda assembly: assembly, 0.01)
    assert figure.caption.startswith(said)


def test_a_file_is_no_folder_for_a_search(tmp_path):
    scene, taken = tmp_path / "arches.toml", tmp_path / "taken.json"
    scene.write_text(scene_text(scene_from(ARCHES)))
    taken.write_text("kept")
    command = [sys.executable, "-m", "dynsim", "optimise", str(scene), "-o", str(taken)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (answer.returncode, taken.read_text()) == (2, "kept")
    assert answer.stderr == f"dynsim: output: {taken} is a file; a search writes into a folder\n"
