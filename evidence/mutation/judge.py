"""Whether a test notices a mutation."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import time

from evidence.mutation.mutations import SOURCE, Mutation, changed_lines
from evidence.mutation.reach import PYTEST, Reach, environment
from evidence.paths import ROOT

#: Tests are run in batches: most mutants fall to the fastest few, and a batch of many files takes long to collect.
BATCHES = (15, 60, 1000)
#: A mutant may take this many times as long as the tests do without it, and so much for starting [s]; then it hangs.
PATIENCE, START = 5.0, 30.0
KILLED, SURVIVED, UNREACHED = "killed", "survived", "unreached"
#: What pytest leaves with where tests failed, and where they could not even be collected.
FAILURES = (1, 2, 3, 4)


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


def judge(mutation: Mutation, reached: Reach, most: float) -> Judgement:
    """Run the tests that reach a mutation in a copy of the source, the fastest first, up to some seconds of tests."""
    begin = time()
    tests, after = reached.tests(mutation), mutation.text()
    before, new = changed_lines((SOURCE / mutation.path).read_text(), after)
    chosen, total = [], 0.0
    for test in tests:
        total += reached.seconds[test]
        if chosen and total > most:
            break
        chosen.append(test)
    outcome, by = (SURVIVED, "") if chosen else (UNREACHED, "")
    with TemporaryDirectory() as folder:
        source = Path(folder) / "src"
        shutil.copytree(SOURCE, source, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        (source / mutation.path).write_text(after)
        first = 0
        for batch in BATCHES:
            some, first = chosen[first : first + batch], first + batch
            if some and (killer := _killer(source, some, sum(reached.seconds[test] for test in some))):
                outcome, by = KILLED, killer
                break
    return Judgement(
        mutation.key, mutation.room, outcome, before, new, mutation.line, by, len(tests), len(chosen),
        round(time() - begin, 1),
    )  # fmt: skip


def _killer(source: Path, tests: list[str], seconds: float) -> str:
    """The test that fails first, or how else the process fails; nothing where all pass."""
    try:
        done = subprocess.run(
            [sys.executable, *PYTEST, "-x", *tests], cwd=ROOT, env=environment(source), capture_output=True, text=True,
            timeout=START + PATIENCE * seconds,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "no end"
    if done.returncode in FAILURES or done.returncode < 0:
        failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.M)
        return failed[1] if failed else "no import"
    if done.returncode:
        raise RuntimeError(f"pytest left with {done.returncode}: {done.stdout}{done.stderr}")
    return ""
