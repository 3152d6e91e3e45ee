"""Where optional data for the tests is found."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).parents[1]
CASES = Path(os.environ.get("BLOCKSTAT_CASES", ROOT.parent / "shared" / "cases"))


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def cases() -> Path:
    """Directory of assemblies from other projects; the test is skipped where it is absent."""
    if not CASES.is_dir():
        pytest.skip("no directory of cases")
    return CASES


# The same examples on every run of CI, new ones everywhere else.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")
