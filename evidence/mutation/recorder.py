"""A plugin of pytest that writes down which test runs which lines, and for how long.

    MUTATION_RECORD=FILE python -m pytest -p evidence.mutation.recorder TESTS

The file is JSON: seconds by test, -1 for one that fails or is skipped, and by file of the source the tests of each
line, numbered from 1 in this order; 0 stands for imports.
"""

from __future__ import annotations

import json
import os
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import coverage
import pytest

from evidence.mutation.mutations import SOURCE, files

FOUND = coverage.Coverage(data_file=None, include=[str(path) for path in files()], messages=False)
SECONDS: defaultdict[str, float] = defaultdict(float)
FAILED: set[str] = set()
FOUND.start()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Give the lines of a test its name."""
    FOUND.switch_context(item.nodeid)
    result = yield
    FOUND.switch_context("")
    return result


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add up the time of a test; one that fails or is skipped as it is kills nothing."""
    SECONDS[report.nodeid] += report.duration
    if not report.passed:
        FAILED.add(report.nodeid)


def pytest_sessionfinish() -> None:
    """Write the file."""
    FOUND.stop()
    data, tests = FOUND.get_data(), {"": 0} | {test: k for k, test in enumerate(SECONDS, 1)}
    known = {0, *(number for test, number in tests.items() if test and test not in FAILED)}
    lines = {
        str(Path(name).relative_to(SOURCE)): {
            line: sorted(known & {tests[test] for test in own}) for line, own in data.contexts_by_lineno(name).items()
        }
        for name in data.measured_files()
    }
    seconds = {test: -1.0 if test in FAILED else round(value, 3) for test, value in SECONDS.items()}
    Path(os.environ["MUTATION_RECORD"]).write_text(json.dumps({"seconds": seconds, "lines": lines}))
