"""Which tests reach a line, and how long each takes: every test file is run once with the recorder."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import signal
import subprocess
import sys
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from evidence.mutation.mutations import SOURCE, Mutation
from evidence.paths import ROOT
from evidence.run.threads import THREADS

OUT = ROOT / "out" / "mutation"
FOLDERS = ("blockstat", "crosscheck", "validation", "property", "dynsim")
#: A test file has so long for all its tests [s]; what it has not run by then is not known.
MOST = 600.0
OPTIONS = ("-q", "-p", "no:cacheprovider", "-m", "not slow")


@dataclass(frozen=True)
class Reach:
    """The tests of each line."""

    seconds: dict[str, float]  #: by test
    lines: dict[str, dict[int, set[str]]]  #: tests by line by file

    def tests(self, mutation: Mutation) -> list[str]:
        """The tests that reach a mutation, the fastest first.

        A line at the level of the module runs once, when the first test imports it, and any test of the file may see
        it. A statement over several lines counts as its first line.
        """
        own = self.lines.get(mutation.path, {})
        first = deciding_line((SOURCE / mutation.path).read_text(), mutation.line)
        found = set().union(*own.values()) if first is None else own.get(first, set())
        return sorted(found - {""}, key=lambda test: (self.seconds[test], test))


def deciding_line(text: str, line: int) -> int | None:
    """The first line of the innermost statement at a line, if it is in a function; None at the level of the module.

    A signature with its defaults and decorators is at the level of what it stands in.
    """
    found: ast.stmt | None = None
    inside = False
    statements = list(ast.parse(text).body)
    while at := next((s for s in statements if _first_line(s) <= line <= (s.end_lineno or s.lineno)), None):
        found = at
        inside = inside or (isinstance(at, ast.FunctionDef) and line >= _first_line(at.body[0]))
        statements = _statements_in(at)
    return found.lineno if found is not None and inside else None


def _first_line(statement: ast.stmt) -> int:
    return min([statement.lineno, *(node.lineno for node in getattr(statement, "decorator_list", []))])


def _statements_in(statement: ast.stmt) -> list[ast.stmt]:
    """The statements of the blocks of a statement."""
    found = [s for name in ("body", "orelse", "finalbody") for s in getattr(statement, name, [])]
    for part in [*getattr(statement, "handlers", []), *getattr(statement, "cases", [])]:
        found += part.body
    return found


def test_files() -> list[Path]:
    """All test files of the two packages."""
    return sorted(path for folder in FOLDERS for path in (ROOT / "tests" / folder).glob("test_*.py"))


def environment(source: Path = SOURCE, **more: str) -> dict[str, str]:
    """The environment of a test process that imports both packages from a folder."""
    path = os.pathsep.join(map(str, (source, ROOT)))
    return {**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONPATH": path, "CI": "1", **more}


def reach(paths: Sequence[Path], jobs: int) -> Reach:
    """What the tests of some files reach, from the records that there are and from those that are missing."""
    with ThreadPoolExecutor(jobs) as pool:
        records = list(pool.map(_record, paths))
    seconds: dict[str, float] = {}
    lines: defaultdict[str, defaultdict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
    for record in records:
        seconds |= record["seconds"]
        tests = ["", *record["seconds"]]
        for name, own in record["lines"].items():
            for line, numbers in own.items():
                lines[name][int(line)] |= {tests[number] for number in numbers}
    return Reach(seconds, {name: dict(own) for name, own in lines.items()})


def _record(path: Path) -> dict[str, dict]:
    """The record of a test file, made where the file or a source that its tests reach has changed since."""
    target = OUT / "reach" / f"{path.parent.name}.{path.stem}.json"
    if target.is_file() and _is_of(record := json.loads(target.read_text()), path):
        return record
    target.parent.mkdir(parents=True, exist_ok=True)
    target.unlink(missing_ok=True)
    name = str(path.relative_to(ROOT))
    print(f"reach   {name}\n", end="", flush=True)
    arguments = [sys.executable, "-m", "pytest", *OPTIONS, "-p", "evidence.mutation.recorder", name]
    process = subprocess.Popen(
        arguments, cwd=ROOT, env=environment(MUTATION_RECORD=str(target)), stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        process.wait(MOST)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)  # it writes what it has
        process.wait()
    if not target.is_file():
        return {"seconds": {}, "lines": {}}
    record = json.loads(target.read_text())
    record["test"] = _state(path)
    record["sources"] = {name: _state(SOURCE / name) for name in record["lines"]}
    target.write_text(json.dumps(record))
    return record


def _is_of(record: dict[str, dict], path: Path) -> bool:
    """Whether a record is of a test file and of the sources that it reaches as they are."""
    sources = {SOURCE / name: state for name, state in record.get("sources", {}).items()} | {path: record.get("test")}
    return all(file.is_file() and _state(file) == state for file, state in sources.items())


def _state(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:12]
