"""The notebooks as they are stored; `make notebooks` runs them."""

import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))


def cells(path: Path, kind: str) -> list[dict]:
    return [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == kind]


def text(cell: dict) -> str:
    return "".join(cell["source"])


def test_they_are_there():
    assert {path.stem for path in NOTEBOOKS} == {
        "first_wall", "openings_and_buttresses", "vaults_and_meshes", "limit_load_and_mechanism", "static_dynamic",
        "search", "paper", "speed_error", "capacity", "construction_sequence", "building_a_cathedral", "experiments",
        "how_sure", "reliability",
    }  # fmt: skip


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_is_stored_without_outputs(path):
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells(path, "code"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_opens_with_what_is_learnt_and_ends_with_a_figure(path):
    first, *others = (text(cell) for cell in cells(path, "markdown"))
    assert first.startswith("# ")
    assert "What you will learn:" in first
    assert not any(line.startswith("# ") for cell in others for line in cell.splitlines())
    assert "plt.subplots" in text(cells(path, "code")[-1])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_checks_what_it_claims(path):
    assert any(line.startswith("assert ") for cell in cells(path, "code") for line in text(cell).splitlines())


def test_the_pages_list_each_of_them_once():
    lines = (Path(__file__).parents[1] / "docs" / "index.md").read_text().splitlines()
    listed = [line for line in lines if line.startswith("notebooks/")]
    assert sorted(listed) == [f"notebooks/{path.stem}" for path in NOTEBOOKS]
