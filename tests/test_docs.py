"""The README and docs/: their code runs and prints what they show, and the reference leaves nothing public out."""

import pkgutil
import re
from pathlib import Path

import pytest

import blockstat
import dynsim
import run_page
from blockstat.large_displacement.capacity_curve import CapacityOutcome
from blockstat.studies.settling_path import PathOutcome

DOCS = Path(__file__).parents[1] / "docs"
PAGES = [DOCS.parent / "README.md", DOCS / "quick_start.md", *sorted((DOCS / "howto").glob("*.md"))]
#: Pages that say where things are.
GUIDES = [DOCS.parent / "CONTRIBUTING.md", DOCS / "architecture.md", DOCS / "evidence.md"]
FILE = re.compile(r"`((?:src|evidence|tests|docs|examples|blockstat|dynsim)/[\w./]*)`")
NAME = re.compile(r"`((?:blockstat|dynsim)(?:\.\w+)+)[`(]")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_code_prints_what_the_page_shows(page, root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(root / "examples")
    run_page.run_page(page.read_text(), str(page), commands=False)


@pytest.mark.parametrize(("page", "outcomes"), [("capacity", CapacityOutcome), ("settlement", PathOutcome)])
def test_a_table_of_outcomes_has_all_of_them(page, outcomes):
    table = (DOCS / "howto" / f"{page}.md").read_text().split("| `outcome` |")[1].split("\n\n")[0]
    assert set(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)) == {outcome.word for outcome in outcomes}


def test_the_reference_has_every_public_name_once():
    pages = "".join(page.read_text() for page in (DOCS / "api").glob("*.md"))
    named, module = [], ""
    for kind, name in re.findall(
        r"^\.\. (currentmodule|autoclass|autofunction|autodata):: ([\w.]+)$", pages, re.MULTILINE
    ):
        if kind == "currentmodule":
            module = name
        else:
            named.append(name if "." in name else f"{module}.{name}")
    public = [f"{package.__name__}.{name}" for package in (blockstat, dynsim) for name in package.__all__]
    assert set(public) <= set(named)
    assert len(named) == len(set(named))


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_files_that_a_guide_names_exist(page, root):
    named = FILE.findall(page.read_text())
    assert named
    assert [name for name in named if not any((folder / name).exists() for folder in (root, root / "src"))] == []


@pytest.mark.parametrize(
    "page",
    # Names of version 0.1 are tested in tests/blockstat/test_old_names.py.
    [DOCS.parent / "README.md", *sorted(set(DOCS.glob("*.md")) - {DOCS / "upgrading.md"})],
    ids=lambda page: page.stem,
)
def test_names_that_a_page_uses_exist(page):
    for name in NAME.findall(page.read_text()):
        pkgutil.resolve_name(name)
