"""What is installed, by which name and version, is said in several files: they agree."""

import re
from pathlib import Path

import pytest
import tomllib

import blockstat

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
#: Names of conda-forge where they differ.
CONDA = {"cvxpy": "cvxpy-base", "matplotlib": "matplotlib-base", "msgspec": "msgspec-python"}


def names(requirements):
    return {re.match(r"[\w-]+", text)[0].replace("-", "_") for text in requirements}


def test_one_version_everywhere():
    citation = (ROOT / "CITATION.cff").read_text()
    manifest = tomllib.loads((ROOT / "extras/blender/blockstat_extension/blender_manifest.toml").read_text())
    cited = re.search(r"^version: (.*)$", citation, re.MULTILINE)[1]
    assert {PROJECT["version"], blockstat.__version__, cited, manifest["version"]} == {blockstat.__version__}
    date = re.search(r"^date-released: (\d{4}-\d\d-\d\d)$", citation, re.MULTILINE)[1]
    released = re.findall(r"^## (?!Unreleased)(.*)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert released[0] == f"{cited} - {date}"


def test_conda_has_what_pip_has():
    yaml = pytest.importorskip("yaml")
    given = yaml.safe_load((ROOT / "environment.yml").read_text())["dependencies"]
    pip = next(own["pip"] for own in given if isinstance(own, dict))
    conda = names(own for own in given if isinstance(own, str))
    needed = [text for text in PROJECT["dependencies"] if "python_version <" not in text]
    assert {CONDA.get(name, name).replace("-", "_") for name in names(needed)} <= conda
    extras = PROJECT["optional-dependencies"]
    assert names(extras["dynamics"] + extras["ui"]) <= conda | names(pip)


def test_the_jobs_of_github_run_what_exists():
    yaml = pytest.importorskip("yaml")
    jobs = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text())["jobs"]
    steps = " ".join(step.get("run", "") for job in jobs.values() for step in job["steps"])
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"make ([a-z-]+)", steps)) <= targets
    assert all((ROOT / path).exists() for path in re.findall(r"(?:extras|tests)/[\w./]+", steps))
    lowest = PROJECT["requires-python"].removeprefix(">=")
    assert jobs["wheel"]["strategy"]["matrix"]["python"][0] == lowest
