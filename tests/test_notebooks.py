"""The code of each notebook runs as it stands."""

import json
import os
from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).parents[1] / "notebooks"


def run(name, monkeypatch):
    """Names of a notebook after all its cells, which are stored without outputs."""
    path = NOTEBOOKS / f"{name}.ipynb"
    monkeypatch.chdir(NOTEBOOKS)
    cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
    assert all(not cell["outputs"] for cell in cells)
    scope: dict = {}
    for cell in cells:
        source = cell["source"].replace("from IPython.display import Image", "Image = str")
        exec(compile(source, os.fspath(path), "exec"), scope)
    return scope


def test_every_notebook_is_run_here():
    assert {path.stem for path in NOTEBOOKS.glob("*.ipynb")} == {"chapel", "paper"}


def test_the_chapel(monkeypatch, capsys):
    scope = run("chapel", monkeypatch)
    assert [v.outcome.word for v in scope["verdicts"].values()] == ["stable"] * 3 + ["unstable"] * 2
    assert scope["dynamic"].outcome.word in capsys.readouterr().out.lower()


@pytest.mark.slow
def test_the_paper(monkeypatch):
    scope = run("paper", monkeypatch)
    assert [v.outcome.word for v in scope["verdicts"].values()] == ["stable", "stable", "unstable"]
    free, slow = scope["runs"].values()
    assert free.outcome.word == "falls"
    # The inertia hides the fall, and the verdict warns of it.
    assert slow.outcome.word != "falls"
    assert slow.max_displacement < free.max_displacement
    assert any("inertia" in text for text in slow.warnings)
