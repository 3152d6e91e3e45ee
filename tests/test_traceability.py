"""Every figure of README and the pages stands in a generated block or beside the name of its source."""

import re
from pathlib import Path

import pytest

from evidence.jobs import JOBS
from evidence.pages import fill

ROOT = Path(__file__).parents[1]
UNIT = (
    r"s|ms|min|h|hours?|minutes?|seconds?|%|per cent|times|GB|MB|kB|GiB|MiB|points?"
    r"|blocks|contacts|draws|factorisations|iterations|programs|scenes|designs|mechanisms|steps|runs"
)
NUMBER = r"(?:\d[\d,]*(?:\.\d+)?(?:e-?\d+)?|\.\d+)"
#: What was measured: a number with a unit of time, size or ratio or of what is counted, so many of so many, or so many
#: times as much.
FIGURE = re.compile(
    rf"(?<![\w./#]){NUMBER}(?:\s*(?:to|and|or|–)\s*{NUMBER})?\s?(?:{UNIT})(?!\w)"
    r"|(?<![\w.])\d[\d,]* of (?:the |all )?\d[\d,]*"
    r"|\b(?:two|three|four|five|six|seven|eight|nine|ten) times as|\btwice as (?:long|fast|slow)|\bfactor of \d"
)
#: What names a source: a command, a file of the repository, a work of others, or a remark that readers do not see.
SOURCE = re.compile(
    r"`(?:python -m|make|blockstat|dynsim) |`(?:src|tests|evidence|extras|examples)/|<!-- source: "
    r"|\]\(https?://|\]\([\w./]*bibliography\.md"
)
LINK = re.compile(r"\]\(([\w./-]+\.md)")
REMARK = re.compile(r"<!-- source: (.*?) -->", re.DOTALL)
GENERATED = {path for job in JOBS for path in job.files()}
#: Pages that a target of the Makefile writes, and lists of licences and works.
OTHERS = {"mutants.md", "mutants_equivalent.md", "coverage.md", "licences.md", "bibliography.md", "CHANGELOG.md"}
PAGES = [
    path for path in fill.pages()
    if path not in GENERATED and path.name not in OTHERS and path.parent.name not in ("api", "notebooks")
]  # fmt: skip


def paragraphs(text: str) -> list[str]:
    """Paragraphs, items of lists and tables as written by hand: no generated block, no code."""
    text = fill.BLOCK.sub("", fill.without_foot(text))
    text = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^ {4}.*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"\n\s*\n(?=<!-- source: )", "\n", text)
    return re.split(r"\n\s*\n|\n(?=(?:- |\d+\. |\* ))", text)


def bare(paragraph: str) -> str:
    """A paragraph without code, formulas, targets of links and remarks."""
    return re.sub(r"`[^`]*`|\]\([^)]*\)|\$[^$]*\$|<!--.*?-->", " ", paragraph, flags=re.DOTALL)


def has_source(paragraph: str, figures: list[str], page: Path) -> bool:
    """Whether a paragraph names where its figures come from, or links to pages that show them among generated ones."""
    if SOURCE.search(paragraph):
        return True
    linked = [(page.parent / target).resolve() for target in LINK.findall(paragraph)]
    texts = [path.read_text() for path in linked if path.is_file() and fill.jobs_of(path, path.read_text())]
    numbers = re.findall(r"\d[\d,]*(?:\.\d+)?", " ".join(figures))
    return bool(texts) and all(re.search(rf"(?<![\d.]){re.escape(n)}(?!\d)", "\n".join(texts)) for n in numbers)


def without_source(page: Path) -> list[str]:
    found = []
    for paragraph in paragraphs(page.read_text()):
        if (figures := FIGURE.findall(bare(paragraph))) and not has_source(paragraph, figures, page):
            found.append(f"{', '.join(figures)}: {paragraph.strip()[:100]}")
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_every_figure_has_a_source(page):
    assert without_source(page) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_files_that_a_remark_names_exist(page):
    for remark in REMARK.findall(page.read_text()):
        named = re.findall(r"(?:src|tests|evidence|examples|docs)/[\w./]+", remark)
        assert named or "http" in remark or "the user" in remark, remark
        assert [name for name in named if not (ROOT / name).exists()] == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("A wall takes 0.20 s.", 1),
        ("A wall takes 0.20 s (`python -m evidence.benchmarks.solvers`).", 0),
        ("It agrees on 24 of 24.", 1),
        ("It agrees on 24 of 24.\n\n<!-- source: tests/test_traceability.py -->", 0),
        ("    so many lines of code take 3 s\n\n```text\n3 of 5\n```", 0),
        ("A wall is 0.3 m thick, after 2026-11-24, in version 0.2.", 0),
        ("It is off by -18.3 %, for 12 blocks.", 1),
        ("It takes three times as long.", 1),
        (f"It takes 3.217 s ([speed]({ROOT}/docs/speed.md)).", 1),
        ("Slower by .5 to 2 %.\n\nSee `python -m evidence.benchmarks.solvers`.", 1),
        ("<!-- results: solvers summary -->\n\n3 times\n\n<!-- end -->", 0),
    ],
)
def test_a_figure_without_a_source_is_found(text, found, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(text)
    assert len(without_source(page)) == found
