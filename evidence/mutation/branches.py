"""Branches of the source that no test takes, by room: `make coverage`.

    python -m evidence.mutation.branches [--measure] [--list ROOM ...] [--write FILE]

`--measure` runs all tests that CI runs under coverage.py, in every process that they start. Otherwise the last
measurement in out/coverage is read. `--list` prints each branch of a room that no test takes, `--write` the page.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from evidence.mutation.mutations import ROOMS, SOURCE
from evidence.mutation.reach import OPTIONS
from evidence.paths import ROOT
from evidence.run.stamps import measured_now
from evidence.tables import table

OUT = ROOT / "out" / "coverage"
HEAD = """# Branches that tests take

This page is printed by `make coverage`. A branch is a way from a line that decides to the next one, counted by
[coverage.py](https://coverage.readthedocs.io) in all processes that the tests of CI start. That a test takes a branch
does not say that it would notice the other way: that is what [mutants](mutants.md) ask. Engines that are not installed
and the live page without a browser take no branch.
"""
#: Every process of a test counts, also those that a signal ends and those that leave by `os._exit`.
CONFIG = f"""[run]
branch = True
parallel = True
data_file = {OUT / "data"}
source = {SOURCE}
patch = subprocess, _exit
sigterm = True
disable_warnings = no-data-collected, module-not-measured, module-not-imported
"""


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m evidence.mutation.branches",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--measure", action="store_true", help="run the tests first")
    parser.add_argument("--jobs", type=int, default=2, help="tests at a time")
    parser.add_argument("--list", nargs="+", default=[], metavar="ROOM", help=", ".join(ROOMS))
    parser.add_argument("--write", type=Path, metavar="FILE", help="put the page here")
    options = parser.parse_args()
    if options.measure:
        measure(options.jobs)
    report = OUT / "report.json"
    if not report.is_file():
        raise SystemExit(f"no {report.relative_to(ROOT)}: run with --measure first")
    files = {
        str(Path(name).resolve().relative_to(SOURCE)): found
        for name, found in json.loads(report.read_text())["files"].items()
    }
    print(counts(files))
    for room in options.list:
        print(f"\n{room}\n" + "\n".join(untaken(files, room)))
    if options.write:
        options.write.write_text(f"{page(files)}\n{measured_now()}\n")


def measure(jobs: int) -> None:
    """Run the tests that CI runs, and write what coverage.py reports of all their processes."""
    OUT.mkdir(parents=True, exist_ok=True)
    for old in OUT.glob("data*"):
        old.unlink()
    config = OUT / "coveragerc"
    config.write_text(CONFIG)
    environment = {**os.environ, "CI": "1", "PYTHONPATH": os.pathsep.join((str(SOURCE), str(ROOT)))}

    def run(*arguments: str) -> int:
        return subprocess.run([sys.executable, "-m", *arguments], cwd=ROOT, env=environment).returncode

    settings = f"--rcfile={config}"
    failed = run("coverage", "run", settings, "-m", "pytest", "-n", str(jobs), *OPTIONS)
    run("coverage", "combine", settings, "--quiet")
    run("coverage", "json", settings, "--quiet", "--ignore-errors", "-o", str(OUT / "report.json"))
    if failed:
        print(f"the tests left with {failed}: branches that failing tests take may be missing")


def page(files: Mapping[str, Any]) -> str:
    """The table, and what is not taken in the rooms that hold verdicts, bounds, contacts, laws, loads and files."""
    left = [line for room in ROOMS for line in untaken(files, room)]
    text = f"{HEAD}\n{counts(files)}\n\n## Not taken in the rooms of the mutants\n\n"
    return text + ("```text\n" + "\n".join(left) + "\n```\n" if left else "None.\n")


def counts(files: Mapping[str, Any]) -> str:
    """A table of branches and lines by room."""
    rows = []
    for room in sorted({name.rpartition("/")[0] for name in files}):
        own = [found["summary"] for name, found in files.items() if name.rpartition("/")[0] == room]
        rows.append([f"`{room}`", *_sums(own)])
    rows.append(["all", *_sums([found["summary"] for found in files.values()])])
    return table(["room", "lines", "not run", "branches", "not taken", "taken"], rows)


def untaken(files: Mapping[str, Any], room: str) -> Iterator[str]:
    """The branches of a room that no test takes: the line that decides, and where it did not go."""
    for name, found in sorted(files.items()):
        if name.startswith(room):
            lines = (SOURCE / name).read_text().splitlines()
            for start, stop in found["missing_branches"]:
                goal = f"to line {stop}: {lines[stop - 1].strip()}" if stop > 0 else "to the end of it"
                yield f"{name}:{start}: {lines[abs(start) - 1].strip()}\n    never {goal}"


def _sums(summaries: list[Mapping[str, int]]) -> list[object]:
    lines, unrun, branches, missed = (
        sum(summary[key] for summary in summaries)
        for key in ("num_statements", "missing_lines", "num_branches", "missing_branches")
    )
    return [lines, unrun, branches, missed, f"{100 * (1 - missed / branches):.1f} %" if branches else "-"]


if __name__ == "__main__":
    main()
