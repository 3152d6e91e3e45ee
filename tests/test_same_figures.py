"""Recordings of figures: what is the same, and what is told when it is not."""

import json
import subprocess
import sys

import pytest

from evidence.same_figures import compare, difference

BEFORE = {"arch": {"assess: outcome": "stable", "assess: score": 0.5, "limit_load: upper": 2000.0}}


def changed(**figures):
    return {"arch": BEFORE["arch"] | {key.replace("_of_", ": "): value for key, value in figures.items()}}


def test_the_same_figures_are_the_same():
    report, same = compare(BEFORE, json.loads(json.dumps(BEFORE)))
    assert same
    assert "outcomes | 1 | 1 | 0 | 0" in report


@pytest.mark.parametrize(
    ("after", "told"),
    [
        (changed(assess_of_outcome="unstable"), "differs: arch | assess: outcome: stable -> unstable (inf)"),
        (changed(assess_of_score=0.5 + 2e-9), "differs: arch | assess: score: 0.5 -> 0.500000002 (2.0e-09)"),
        (changed(assess_of_score="nan"), "differs: arch | assess: score: 0.5 -> nan (inf)"),
        ({}, "only before: arch | assess: score: 0.5"),
        (changed() | {"dome": {"assess: score": 0}}, "only after: dome | assess: score: 0"),
    ],
)
def test_a_figure_that_differs_is_named(after, told):
    report, same = compare(BEFORE, after)
    assert not same
    assert told in report.splitlines()


def test_differences_are_relative_to_large_values():
    assert difference(2000.0, 2000.0 + 1e-6) == pytest.approx(5e-10)
    assert difference(1e-12, 3e-12) < 1e-11
    assert difference("inf", "inf") == 0.0
    assert difference("nan", "nan") == 0.0


def test_recordings_of_one_case_are_the_same_and_a_change_ends_with_status_one(cases, root, tmp_path):
    def run(*words):
        return subprocess.run(
            [sys.executable, "-m", "evidence.same_figures", *words], cwd=root, capture_output=True, text=True
        )

    files = [str(tmp_path / "one.json"), str(tmp_path / "two.json")]
    for file in files:
        run("record", file, "--only", "case rbe_stack_1").check_returncode()
    answer = run("compare", *files)
    assert answer.returncode == 0, answer.stdout
    kept = json.loads((tmp_path / "two.json").read_text())
    own = kept["figures"]["case rbe_stack_1"]
    assert own["assess: outcome"] == "stable"
    own["limit_load: lower"] += 1e-3
    (tmp_path / "two.json").write_text(json.dumps(kept))
    answer = run("compare", *files)
    assert answer.returncode == 1
    assert "differs: case rbe_stack_1 | limit_load: lower" in answer.stdout
