"""Where optional data for the tests is found, and an independent check of every answer."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from blockstat.cli.options import _status
from evidence.checks import derived, independent
from evidence.opinion import brackets, building, curves
from evidence.paths import CASES

ROOT = Path(__file__).parents[1]

# Before any test module imports them: every answer that forces or a mechanism prove is checked a second time.
for checks in (independent, derived, brackets, building, curves):
    checks.install()


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def cases() -> Path:
    """Directory of assemblies from other projects; the test is skipped where it is absent."""
    if not CASES.is_dir():
        pytest.skip("no directory of cases")
    return CASES


@pytest.fixture
def run_command(capsys):
    """Run a command as its console script does; the answer is the exit status and what was printed."""

    def run(app, program, *arguments):
        given = [str(argument) for argument in arguments]
        status = _status(lambda: app(given, prog_name=program, standalone_mode=False), program)
        return status, *capsys.readouterr()

    return run


@pytest.hookimpl(tryfirst=True)  # before those are left out that are not asked for
def pytest_collection_modifyitems(config, items):
    """Mark the tests that take long, and leave out what holds of a release alone unless asked for: `-m release`."""
    long_tests = set((ROOT / "tests" / "long_tests.txt").read_text().splitlines())
    for item in items:
        if item.nodeid in long_tests:
            item.add_marker(pytest.mark.long)
    if not any("::" in argument for argument in config.args):  # else a file is there in part
        files = {item.nodeid.split("::")[0] for item in items}
        there = {item.nodeid.split("[")[0] for item in items}
        named = {name.split("[")[0] for name in long_tests if name.split("::")[0] in files}
        if gone := sorted(named - there):
            raise pytest.UsageError(f"tests/long_tests.txt names what is not there: {', '.join(gone)}")
    if "release" not in config.option.markexpr:
        for item in items:
            if item.get_closest_marker("release"):
                item.add_marker(pytest.mark.skip(reason="holds of a release: pytest -m release"))


# The same examples on every run of CI, new ones everywhere else.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")
