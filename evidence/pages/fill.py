"""Fill the marked blocks of README.md and docs/*.md from docs/results: `make pages`.

    <!-- results: FILE PART -->
    ...
    <!-- end -->

What stands between the marks is replaced by that part of docs/results/FILE.md (see `evidence.results`). The foot of a
page that shows figures says which commit they are of (`evidence.run.stamps`).
"""

from __future__ import annotations

import re
from pathlib import Path

from evidence.jobs import JOBS, Job
from evidence.paths import DOCS, RESULTS
from evidence.results import load
from evidence.run import quick
from evidence.run.stamps import foot

BLOCK = re.compile(r"<!-- results: (\S+) (\S+) -->\n.*?<!-- end -->", re.DOTALL)
FOOT = re.compile(r"\n*<!-- made -->\n.*?<!-- end -->\n*\Z", re.DOTALL)


def pages() -> list[Path]:
    """Pages written by hand or filled; what is built or copied is in directories that begin with an underscore."""
    docs = sorted(DOCS.rglob("*.md"))
    return [
        DOCS.parent / "README.md",
        *(p for p in docs if p.relative_to(DOCS).parts[0][0] != "_" and RESULTS not in p.parents),
    ]


def jobs_of(path: Path, text: str) -> list[Job]:
    """The jobs whose figures a page shows: the one that writes it, and those of its blocks."""
    shown = {path, *(RESULTS / f"{file}.md" for file, _ in BLOCK.findall(text))}
    return [job for job in JOBS if shown & set(job.files(DOCS.parent))]


def filled(text: str) -> str:
    """The text of a page with the present results in its blocks."""

    def part(block: re.Match) -> str:
        file, name = block.groups()
        if not (RESULTS / f"{file}.md").is_file():
            if DOCS == quick.DOCS:
                return block[0]  # a job that failed, or was not asked for
            raise ValueError(f"there is no docs/results/{file}.md: run make evidence ONLY={file.replace('_', '-')}")
        _, parts = load(RESULTS / f"{file}.md")
        if name not in parts and DOCS == quick.DOCS:
            return block[0]
        if name not in parts:
            raise ValueError(f'no part "{name}" in docs/results/{file}.md; its parts are: {", ".join(parts)}')
        return f"<!-- results: {file} {name} -->\n\n{parts[name]}\n\n<!-- end -->"

    return BLOCK.sub(part, text)


def without_foot(text: str) -> str:
    """The text of a page without what `page` adds."""
    return FOOT.sub("\n", text)


def page(path: Path) -> str:
    """The text of a page with the present results, and a foot if it shows any."""
    text = filled(without_foot(path.read_text()))
    jobs = jobs_of(path, text)
    if not jobs:
        return text
    said = foot(jobs) if DOCS != quick.DOCS else f"{foot(jobs)}\n\n{quick.SAID}"
    return f"{text.rstrip()}\n\n<!-- made -->\n{said}\n<!-- end -->\n"


def main() -> None:
    for path in pages():
        if (new := page(path)) != path.read_text():
            path.write_text(new)
            print(path.relative_to(DOCS.parent))


if __name__ == "__main__":
    main()
