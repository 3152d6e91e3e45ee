"""From a scene to a confirmed design: the real statics, the real Bullet, the files and the command lines."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from blockstat import assess, read, write
from blockstat.spec import scene_from
from dynsim import Comparison, compare
from dynsim.cli.rows import told_apart
from dynsim.design_search.optimise import optimise
from evidence.scenes.small import HUT, arch, stack

SCENE_TOML = """
name = "hut"
length = 2.0
span = 2.4
[brick]
length = 0.8
height = 0.5
[wall]
thickness = { value = 0.8, min = 0.2, max = 0.8, step = 0.2 }
height = 1.5
[vault]
thickness = { value = 0.3, min = 0.2, max = 0.3, step = 0.1 }
voussoirs = 7
"""


def run(*arguments):
    code = "from dynsim.cli.commands import main; main()"
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True)


@pytest.fixture(scope="module")
def optimised(tmp_path_factory):
    directory = tmp_path_factory.mktemp("hut")
    result, report = optimise(scene_from(HUT), directory)
    return directory, result, report


def test_the_search_prunes_verifies_and_confirms(optimised):
    _, result, _ = optimised
    assert any(c.dynamic == "pruned" for c in result.history)
    assert any(c.dynamic == "stands" for c in result.history)
    best = next(c for c in result.history if c.parameters == result.best_parameters)
    assert (best.static, best.dynamic) == ("stable", "stands")
    assert best.parameters["wall.thickness"] < 0.8


def test_the_report_and_the_design_are_on_disk(optimised):
    directory, result, report = optimised
    text = report.read_text()
    assert text.count("data:image/png;base64,") == 5
    # Self-contained; that the view in three dimensions asks for nothing is for a browser to tell (test_app_browser).
    assert "http" not in re.sub(r'<iframe srcdoc="[^"]*"', "", text)
    for candidate in result.history:
        assert f"<td>{candidate.static}</td>" in text
    for name in ("best.json", "best.glb"):
        assert assess(read(directory / name)).outcome.word == "stable"
    assert read(directory / "best.json").metadata["parameters"] == result.best_parameters
    for name in ("building", "demand", "mechanism", "moved"):
        assert (directory / f"{name}.png").read_bytes()[:4] == b"\x89PNG"


def test_killed_and_started_again_the_command_ends_the_same(tmp_path, optimised):
    _, whole, _ = optimised
    scene = tmp_path / "hut.toml"
    scene.write_text(SCENE_TOML)
    history = tmp_path / "out" / "history.csv"
    code = "from dynsim.cli.commands import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "optimise", str(scene), "-o", str(tmp_path / "out")],
        stdout=subprocess.DEVNULL,
    )
    while process.poll() is None and not (history.is_file() and history.read_text().count("\n") >= 3):
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    kept = history.read_text().count("\n") - 1
    assert 2 <= kept < len(whole.history)
    answer = run("optimise", scene, "-o", tmp_path / "out", "--json")
    assert answer.returncode == 0, answer.stderr
    again = json.loads(answer.stdout)
    assert again["best"] == whole.best_parameters
    assert [(r["parameters"], r["static"], r["dynamic"]) for r in again["history"]] == [
        (c.parameters, c.static, c.dynamic) for c in whole.history
    ]


def test_verify_on_the_command_line(tmp_path):
    path = write(stack(2, 0.5, 1.0), tmp_path / "stack.json")
    for tilt, word in (("y,13", "stands"), ("y,15", "falls")):
        answer = run("verify", path, "--tilt", tilt, "--json")
        assert answer.returncode == 0, answer.stderr
        data = json.loads(answer.stdout)
        assert data["verdict"] == word
        assert data["blocks"] == 3
        assert data["simulated_seconds"] > 0
        assert {
            "max_displacement",
            "max_drop",
            "group_drop",
            "first_block",
            "process_seconds",
            "cracks",
            "rate",
        } <= set(data)
        assert (data["first_block"] is None) == (word == "stands")
    assert json.loads(run("verify", path, "--preset", "fast", "--json").stdout)["verdict"] == "stands"
    assert "presets are: fast, default, careful" in run("verify", path, "--preset", "slow").stderr
    assert run("verify", path, "--group", "roof").returncode == 2
    assert run("verify", tmp_path / "gone.json").returncode == 2


def test_compare_gives_a_row_for_every_file_even_a_bad_one(tmp_path):
    good = write(arch(9, 0.2), tmp_path / "good.json")
    thin = write(arch(9, 0.07), tmp_path / "thin.json")
    bad = tmp_path / "bad.json"
    bad.write_text("{")
    answer = run("compare", good, bad, thin, "--json", "-o", tmp_path / "rows.csv")
    assert answer.returncode == 0, answer.stderr
    rows = json.loads(answer.stdout)["rows"]
    assert [(r["static"], r["dynamic"], r["agree"]) for r in rows] == [
        ("stable", "stands", True), (None, None, None), ("unstable", "falls", True),
    ]  # fmt: skip
    assert "not valid JSON" in rows[1]["note"]
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 4
    assert run("compare", bad).returncode == 2


def test_compare_refuses_a_missing_file_before_any_run(tmp_path):
    good, gone = write(stack(1), tmp_path / "good.json"), tmp_path / "gone.json"
    answer = run("compare", good, gone, "-o", tmp_path / "rows.csv")
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr == f"dynsim: {gone}: no such file\n"
    assert not (tmp_path / "rows.csv").exists()


def test_rows_with_the_same_name_are_named_by_their_files():
    def named(*given):
        files, names = [Path(file) for file, _ in given], [Comparison(name) for _, name in given]
        return [row.name for row in told_apart(files, names)]

    assert named(("a.json", "hut"), ("b.json", "arch")) == ["hut", "arch"]
    assert named(("a.json", "hut"), ("b.json", "hut"), ("c.json", "arch")) == ["a", "b", "arch"]
    assert named(("old/a.json", "hut"), ("new/a.json", "hut")) == ["old/a.json", "new/a.json"]


def test_a_wrong_option_of_optimise_is_all_that_is_printed(tmp_path):
    scene = tmp_path / "hut.toml"
    scene.write_text(SCENE_TOML)
    answer = run("optimise", scene, "-o", tmp_path / "out", "--over", "nosuch")
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr == "dynsim: over is 'nosuch'; it must be one of: line, grid\n"


def test_a_difference_comes_with_a_likely_reason(cases, tmp_path):
    table = compare(read(cases / "cra_H.json"))
    row = table[0]
    assert (row.static, row.dynamic, row.agree) == ("stable", "falls", False)
    assert "only by self-stress" in row.note
    table.write_csv(tmp_path / "h.csv")
    assert "only by self-stress" in (tmp_path / "h.csv").read_text()


def test_optimise_under_another_friction(tmp_path):
    scene = tmp_path / "hut.toml"
    scene.write_text(SCENE_TOML)
    out = tmp_path / "out"
    answer = run("optimise", scene, "-o", out, "--friction", "0.2", "--parameters", "wall.thickness", "--json")
    assert answer.returncode == 0, answer.stderr
    history = json.loads(answer.stdout)["history"]
    # Without enough friction no thickness helps: the vault slides off its springing.
    assert {row["dynamic"] for row in history} == {"pruned"}
    assert "Judged with friction 0.2." in (out / "report.html").read_text()
    again = run("optimise", scene, "-o", out, "--parameters", "wall.thickness")
    assert again.returncode == 2
    assert "this history is of another search" in again.stderr
