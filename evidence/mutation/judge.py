"""Whether a test notices a mutation.

Each batch of tests runs in a process of its own, forked from one that has imported the libraries but nothing of the
project: most mutants fall within a second, and the imports would take several.
"""

from __future__ import annotations

import multiprocessing
import os
import re
import shutil
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from time import time

from evidence.mutation.mutations import SOURCE, Mutation, changed_lines
from evidence.mutation.reach import OPTIONS, Reach, environment
from evidence.paths import ROOT

#: Tests are run in batches: most mutants fall to the fastest few, and a batch of many files takes long to collect.
BATCHES = (15, 60, 1000)
#: A mutant may take this many times as long as the tests do without it, and so much for starting [s]; then it hangs.
PATIENCE, START = 5.0, 30.0
KILLED, SURVIVED, UNREACHED = "killed", "survived", "unreached"
#: What is imported once for all mutants.
LIBRARIES = (
    "pytest", "hypothesis", "scipy.sparse.linalg", "scipy.spatial", "scipy.optimize", "scipy.stats", "cvxpy",
    "clarabel", "shapely", "trimesh", "matplotlib.pyplot", "msgspec", "typer", "joblib", "pybullet",
)  # fmt: skip
PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload([*LIBRARIES, __name__])


@dataclass(frozen=True)
class Judgement:
    """What became of a mutant."""

    key: str
    room: str
    outcome: str  #: `KILLED`, `SURVIVED` or `UNREACHED` where no test runs its line
    before: str  #: lines of the source
    after: str  #: and of the mutant
    line: int
    by: str  #: the test that kills it
    tests: int  #: how many tests reach it
    tried: int  #: how many of them were run at most
    seconds: float  #: on the clock


class Jury:
    """The tests that reach mutations, and those of them that were seen to pass without one."""

    def __init__(self, reached: Reach, most: float) -> None:
        """Take the tests that reach each line, and how many seconds of tests a mutant gets at most."""
        self._reached, self._most = reached, most
        self._passes: dict[str, bool] = {}
        self._lock = Lock()

    def judge(self, mutation: Mutation) -> Judgement:
        """Run the tests that reach a mutation in a copy of the source, the fastest first."""
        begin = time()
        tests, after = self._reached.tests(mutation), mutation.text()
        before, new = changed_lines((SOURCE / mutation.path).read_text(), after)
        chosen, total = [], 0.0
        for test in tests:
            total += self._reached.seconds[test]
            if chosen and total > self._most:
                break
            chosen.append(test)
        outcome, by = (SURVIVED, "") if chosen else (UNREACHED, "")
        with TemporaryDirectory() as folder:
            source = Path(folder) / "src"
            shutil.copytree(SOURCE, source, ignore=shutil.ignore_patterns("*.egg-info"))
            (source / mutation.path).write_text(after)
            first = 0
            for batch in BATCHES:
                some, first = chosen[first : first + batch], first + batch
                if killer := self._killer(source, some):
                    outcome, by = KILLED, killer
                    break
        return Judgement(
            mutation.key, mutation.room, outcome, before, new, mutation.line, by, len(tests), len(chosen),
            round(time() - begin, 1),
        )  # fmt: skip

    def _killer(self, source: Path, tests: Sequence[str]) -> str:
        """The first test that fails and passes without the mutation, or how else the process ends; else nothing."""
        left = list(tests)
        while left:
            killer = failing(source, left, self._seconds(left))
            if killer not in left or self._does_pass(killer):
                return killer
            left.remove(killer)
        return ""

    def _does_pass(self, test: str) -> bool:
        """Whether a test passes without any mutation."""
        with self._lock:
            if test not in self._passes:
                self._passes[test] = not failing(SOURCE, [test], self._seconds([test]))
            return self._passes[test]

    def _seconds(self, tests: Sequence[str]) -> float:
        return sum(self._reached.seconds[test] for test in tests)


def failing(source: Path, tests: Sequence[str], seconds: float) -> str:
    """The test that fails first in a process of its own, or how else it fails; nothing where all pass.

    `seconds` are what the tests take without a mutation.
    """
    with TemporaryDirectory() as folder:
        told = Path(folder) / "told"
        process = PROCESSES.Process(target=_run, args=(source, list(tests), told))
        process.start()
        process.join(START + PATIENCE * seconds)
        with suppress(ProcessLookupError):  # what the tests have started ends too
            os.killpg(process.pid, signal.SIGKILL)
        if process.exitcode is None:
            process.join()
            return "no end"
        text = told.read_text() if told.is_file() else ""
        if not process.exitcode:
            return ""
        failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", text, re.M)
        return failed[1] if failed else "no import"


def _run(source: Path, tests: list[str], told: Path) -> None:
    """Run tests with both packages from a folder; what they print goes to a file."""
    os.setsid()
    with told.open("w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    known = [name for name in sys.modules if name.split(".")[0] in ("blockstat", "dynsim")]
    if known:
        raise RuntimeError(f"{known[0]} was imported before the mutation")
    os.chdir(ROOT)
    os.environ.update(environment(source))
    import pytest

    code = pytest.main([*OPTIONS, "-o", f"pythonpath={source} . tests", "-x", *tests])
    sys.stdout.flush()
    os._exit(int(code))
