"""Fill the marked blocks of README.md and docs/*.md from docs/results: `make pages`.

    <!-- results: FILE PART -->
    ...
    <!-- end -->

What stands between the marks is replaced by that part of docs/results/FILE.md (see `evidence.results`).
"""

from __future__ import annotations

import re
from pathlib import Path

from evidence.paths import DOCS, RESULTS, ROOT
from evidence.results import load

BLOCK = re.compile(r"<!-- results: (\S+) (\S+) -->\n.*?<!-- end -->", re.DOTALL)


def pages() -> list[Path]:
    """Pages written by hand or filled; what is built or copied is in directories that begin with an underscore."""
    docs = sorted(DOCS.rglob("*.md"))
    return [
        ROOT / "README.md",
        *(p for p in docs if p.relative_to(DOCS).parts[0][0] != "_" and RESULTS not in p.parents),
    ]


def filled(text: str) -> str:
    """The text of a page with the present results in its blocks."""

    def part(block: re.Match) -> str:
        file, name = block.groups()
        _, parts = load(RESULTS / f"{file}.md")
        if name not in parts:
            raise ValueError(f'no part "{name}" in docs/results/{file}.md; its parts are: {", ".join(parts)}')
        return f"<!-- results: {file} {name} -->\n\n{parts[name]}\n\n<!-- end -->"

    return BLOCK.sub(part, text)


def main() -> None:
    for path in pages():
        text = path.read_text()
        if (new := filled(text)) != text:
            path.write_text(new)
            print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
