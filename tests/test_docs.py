"""The README and docs/: their code runs and prints what they show, and the reference leaves nothing public out."""

import contextlib
import io
import pkgutil
import re
from pathlib import Path

import pytest

import blockstat
import dynsim

DOCS = Path(__file__).parents[1] / "docs"
PAGES = [DOCS.parent / "README.md", DOCS / "quick_start.md", *sorted((DOCS / "howto").glob("*.md"))]
#: Pages that say where things are.
GUIDES = [DOCS.parent / "CONTRIBUTING.md", DOCS / "architecture.md", DOCS / "evidence.md"]
FILE = re.compile(r"`((?:src|evidence|tests|docs|examples|blockstat|dynsim)/[\w./]*)`")
NAME = re.compile(r"`((?:blockstat|dynsim)(?:\.\w+)+)[`(]")
#: Code, what it prints, and scene files.
BLOCK = re.compile(r"```(python|text|toml)\n(.*?)```", re.DOTALL)
#: The first line of a scene file that the code of a page reads.
NAMED = re.compile(r"# (\w+\.toml)\n")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_code_prints_what_the_page_shows(page, root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(root / "examples")
    scope: dict = {}
    printed = ""
    for kind, content in BLOCK.findall(page.read_text()):
        if kind == "toml":
            if file := NAMED.match(content):
                Path(file[1]).write_text(content)
            continue
        if kind == "text":
            assert printed == content
            printed = ""
            continue
        assert not printed, "the page does not show what this prints"
        with contextlib.redirect_stdout(io.StringIO()) as output:
            exec(compile(content, str(page), "exec"), scope)
        printed = output.getvalue()
    assert not printed


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


@pytest.mark.parametrize("page", [DOCS.parent / "README.md", *sorted(DOCS.glob("*.md"))], ids=lambda page: page.stem)
def test_names_that_a_page_uses_exist(page):
    for name in NAME.findall(page.read_text()):
        pkgutil.resolve_name(name)
