"""Build every example scene by courses and write docs/sequences.md."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from time import process_time

from blockstat import Assembly, CoursesResult, build, build_by_courses, load_scene
from evidence.paths import DOCS, EXAMPLES
from evidence.tables import table

#: Where walls go up by courses and a vault follows ring by ring along the nave.
ALONG: Mapping[str, Mapping[str, tuple[int, int, int]]] = {
    "basilica": {"church": (0, 0, 1), "apse": (0, 0, 1), "vault": (1, 0, 0)},
}
SCENES = sorted(path.stem for path in EXAMPLES.glob("*.toml"))
PAGE = """# Building sequences of the examples

Written by `make evidence ONLY=sequences`. Every scene of `examples/` is built by courses (`build_by_courses`,
`blockstat sequence FILE --courses`): blocks whose centroids are level are put in and held, and once all of them are
there as many as possible are let go. After each course the state has a certificate: forces that balance every block
which is not held. "Held" is the largest number of blocks held between two courses. "Proven" says that no fewer will do
with these courses in this order: blocks that fall alone beside all others must each be held, and of further mechanisms
those that share no block each ask for one more. Friction is that of the scenes, 0.7.

{table}

- "Blocks" are those without the supports.
- "Free" counts the courses after which nothing needs to be held, the last one among them.
- The basilica is built in stages: its walls and its apse by courses, then its vault along the nave, ring by ring.
- Seconds are process time, the search for joints included, of one process. With `--journal` a run that was stopped goes
  on from the courses that are done.
"""


def built(name: str, assembly: Assembly, journal: Path | None) -> tuple[CoursesResult, float]:
    """The building by courses and its process time; the work of a journal is not done again."""
    begin = process_time()
    path = None if journal is None else journal / f"{name}.jsonl"
    return build_by_courses(assembly, along=ALONG.get(name), journal=path), process_time() - begin


def cells(name: str, assembly: Assembly, found: CoursesResult, seconds: float) -> list[str]:
    """One row of the table."""
    free = sum(not course.held for course in found.courses)
    proven = str(found.at_least) if found.at_least < found.most_held else "the least"
    held = str(found.most_held)
    words = "" if found.outcome.word == "built" else f" ({found.outcome.word})"
    size = f"{len(assembly.free):,}"
    return [name, size, str(len(found.courses)), f"{free}{words}", held, proven, f"{seconds:.0f}"]


def kept(page: Path) -> dict[str, list[str]]:
    """The rows that the page has, by scene."""
    lines = page.read_text().splitlines() if page.exists() else []
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return {cells[0]: cells for cells in rows if cells[0] != "scene"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--journal", type=Path, help="a directory that keeps the courses that are done")
    parser.add_argument("--only", nargs="+", default=SCENES, choices=SCENES, help="keep the rows of all other scenes")
    parser.add_argument("--write", action="store_true", help="write docs/sequences.md")
    options = parser.parse_args()
    new = {}
    for name in options.only:
        assembly = build(load_scene(EXAMPLES / f"{name}.toml"))
        new[name] = cells(name, assembly, *built(name, assembly, options.journal))
        print(*new[name], flush=True)
        if options.write:
            known = kept(DOCS / "sequences.md") | new
            rows = [known[scene] for scene in SCENES if scene in known]
            heads = ["scene", "blocks", "courses", "free", "held", "proven", "s"]
            (DOCS / "sequences.md").write_text(PAGE.format(table=table(heads, rows)))


if __name__ == "__main__":
    main()
