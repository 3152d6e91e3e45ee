"""What differs between the pages of two runs besides seconds: two runs on one commit should differ in nothing else.

    python -m evidence.same_pages DOCS OTHER

Compares all text files of two directories of pages. Numbers are left out in columns whose head, in rows whose label,
and in sentences that speak of time (seconds, ratios of times, the load of the machine) or memory. Parts that are about
speed alone, and lists that a sentence about time opens, are left out. Of the stamps, commits and hashes count. Prints
each line that differs, and ends with status 1 if there is one.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path

#: What says that a column or a sentence is about time or memory, which no two runs share.
TIME = re.compile(
    r"\b(?:s|ms|min|seconds|minutes|time|clock|processes|workers?|cores|faster|slower|MB|bytes)\b|\[s\]"
    r"|\btimes (?:as long|per|the plain verdict)\b|\bload before\b|^\s*ratio\s*$|\"times\":"
)
#: A row whose label has such a unit, or that names the load of the machine, holds nothing that two runs share.
UNIT = re.compile(r"\[(?:m?s|min)\]|\bload of the \d+ cores\b")
#: Parts of results that are about speed alone, by file and part.
SPEED = {
    ("solvers", "profiles"), ("solvers", "resolve"), ("solvers", "targets"), ("solvers_large", "alone"),
    ("solvers_large", "targets"), ("glue", "cost"),
}  # fmt: skip
#: Times of one or more parts; those that are too short to show are left out.
TIMES = re.compile(r"#(?:; #)+")
#: Where a part of a result begins in its file, where it begins on a page, and where it ends there.
PART, BLOCK, END = re.compile(r"## (\w.*)"), re.compile(r"<!-- results: (\S+) (.+) -->"), "<!-- end -->"
SENTENCES = re.compile(r"(?<=[.;]) ")
NUMBER = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")
TEXT = (".md", ".json", ".csv")


def lines_of(path: Path) -> Iterator[str]:
    """The lines of a page without what is measured in seconds."""
    if path.name == "stamps.json":
        stamps = json.loads(path.read_text())
        yield from (f"{name} {own['commit']} {own['sources']}" for name, own in sorted(stamps.items()))
        return
    heads: list[str] = []
    part, opened = ("", ""), False
    for line in path.read_text().splitlines():
        if named := BLOCK.fullmatch(line):
            part = (named[1], named[2])
        elif named := PART.fullmatch(line):
            part = (path.stem, named[1])
        elif line == END:
            part = ("", "")
        opened = bool(opened and (not line or line.startswith("- "))) or bool(line.endswith(":") and TIME.search(line))
        if part in SPEED or (opened and line.startswith("- ")):
            continue
        cells = line.strip().strip("|").split("|") if line.startswith("|") else []
        if not cells:
            heads = []
            yield " ".join(NUMBER.sub("#", own) if TIME.search(own) else own for own in SENTENCES.split(line))
            continue
        heads = heads or cells
        timed = [bool(TIME.search(head) or UNIT.search(cells[0])) for head in heads] + [False] * len(cells)
        yield "|".join(
            TIMES.sub("#", NUMBER.sub("#", cell)) if late or TIME.search(cell) else cell
            for cell, late in zip(cells, timed, strict=False)
        )


def differences(first: Path, second: Path) -> list[str]:
    """Each line that differs, with its file."""
    names = sorted(
        {path.relative_to(root) for root in (first, second) for path in root.rglob("*") if path.suffix in TEXT}
    )
    found = []
    for name in names:
        one, other = (list(lines_of(root / name)) if (root / name).is_file() else [] for root in (first, second))
        for number, (before, after) in enumerate(zip_longest(one, other, fillvalue=""), 1):
            if before != after:
                found.append(f"{name}:{number}\n- {before}\n+ {after}")
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("docs", type=Path, metavar="DOCS")
    parser.add_argument("other", type=Path, metavar="OTHER")
    options = parser.parse_args()
    found = differences(options.docs, options.other)
    print("\n".join(found) or "no difference but seconds")
    raise SystemExit(1 if found else 0)


if __name__ == "__main__":
    main()
