"""What `make dist` refuses, and how it runs a page. The build itself and the fresh environments are the target's."""

import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

import dist
import run_page

ROOT = Path(__file__).parents[1]
NAMES = {
    "pyproject.toml", "tests/test_arch.py", "examples/chapel.toml", "examples/canopy.obj", "examples/dome.py",
    "src/blockstat/__init__.py", "src/blockstat/py.typed", "src/dynsim/__init__.py", "src/dynsim/py.typed",
}  # fmt: skip
SHARE = "blockstat-0.2.0.data/data/share/blockstat/examples/"
WHEEL = {
    "blockstat/__init__.py", "blockstat/py.typed", "dynsim/__init__.py", "dynsim/py.typed",
    f"{SHARE}chapel.toml", f"{SHARE}canopy.obj", "blockstat-0.2.0.dist-info/METADATA",
}  # fmt: skip


def test_make_knows_the_target():
    makefile = (ROOT / "Makefile").read_text()
    assert re.search(r"^dist:.*  ## .+\n\t.*extras/dist\.py", makefile, re.MULTILINE)
    assert " dist " in re.search(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)[1]
    assert "make dist" in (ROOT / "CONTRIBUTING.md").read_text()


def test_an_sdist_has_what_git_has_and_what_setuptools_adds():
    assert dist.wrong_in_sdist({*NAMES, "PKG-INFO", "setup.cfg", "src/blockstat.egg-info/SOURCES.txt"}, NAMES) == []
    assert dist.wrong_in_sdist(NAMES - {"tests/test_arch.py"}, NAMES) == ["the sdist lacks tests/test_arch.py"]
    assert dist.wrong_in_sdist({*NAMES, "build/old.py"}, NAMES) == ["the sdist holds build/old.py"]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (set(), []),
        ({"dynsim/py.typed"}, ["the wheel lacks dynsim/py.typed"]),
        ({"blockstat/__init__.py"}, ["the wheel lacks blockstat/__init__.py"]),
        ({f"{SHARE}canopy.obj"}, ["the wheel lacks the example canopy.obj"]),
        ({"tests/test_arch.py"}, ["the wheel holds tests/test_arch.py"]),
        ({"evidence/jobs.py"}, ["the wheel holds evidence/jobs.py"]),
        ({"blockstat/heal.py"}, ["the wheel holds blockstat/heal.py"]),
    ],
)
def test_a_wheel_has_the_packages_their_types_and_the_examples_alone(changed, said):
    assert dist.wrong_in_wheel(WHEEL ^ changed, NAMES) == said


def test_a_package_without_its_types_is_refused_though_git_has_none():
    untyped = {name for name in NAMES if not name.endswith("py.typed")}
    wheel = {name for name in WHEEL if not name.endswith("py.typed")}
    assert dist.wrong_in_wheel(wheel, untyped) == [
        "the wheel lacks blockstat/py.typed",
        "the wheel lacks dynsim/py.typed",
    ]


def test_the_files_of_archives_are_read(tmp_path):
    (tmp_path / "a.py").write_text("")
    with tarfile.open(tmp_path / "b-1.tar.gz", "w:gz") as opened:
        opened.add(tmp_path / "a.py", "b-1/src/a.py")
    with zipfile.ZipFile(tmp_path / "b-1-py3-none-any.whl", "w") as opened:
        opened.write(tmp_path / "a.py", "b/a.py")
    assert dist.files_of(tmp_path / "b-1.tar.gz") == {"src/a.py"}
    assert dist.files_of(tmp_path / "b-1-py3-none-any.whl") == {"b/a.py"}


def test_a_directory_without_git_is_refused(tmp_path):
    with pytest.raises(SystemExit, match="in a clone of the repository"):
        dist.tracked(tmp_path)


PAGE = """Text.

    pip install .
    mkdir -p made && blockstat example chapel -o made/chapel.toml    # a comment

```python
x = 2
print(x)
```

```text
2
```

    blockstat --version
"""


def test_the_steps_of_a_page_come_in_its_order():
    assert run_page.steps(PAGE) == [
        ("command", "mkdir -p made && blockstat example chapel -o made/chapel.toml"),
        ("python", "x = 2\nprint(x)\n"),
        ("text", "2\n"),
        ("command", "blockstat --version"),
    ]
    assert [kind for kind, _ in run_page.steps(dist.PAGE.read_text())].count("command") >= 3


@pytest.mark.parametrize(
    ("page", "said"),
    [
        (PAGE.replace("\n2\n", "\n3\n"), "shows\n3\nand this is printed:\n2"),
        (PAGE.replace("```text\n2\n```", ""), "does not show that this is printed:\n2"),
        (PAGE + "\n    blockstat nothing\n", "`blockstat nothing` ends with status 2"),
    ],
    ids=["other text", "no text", "a command that fails"],
)
def test_a_page_that_does_not_hold_is_told(page, said, tmp_path):
    (tmp_path / "page.md").write_text(page)
    script = ROOT / "extras" / "run_page.py"
    answer = subprocess.run([sys.executable, script, "page.md"], cwd=tmp_path, capture_output=True, text=True)
    assert answer.returncode == 1
    assert said in answer.stderr


def test_a_page_that_holds_is_counted(tmp_path):
    (tmp_path / "page.md").write_text(PAGE)
    script = ROOT / "extras" / "run_page.py"
    answer = subprocess.run([sys.executable, script, "page.md"], cwd=tmp_path, capture_output=True, text=True)
    assert (answer.returncode, answer.stdout.splitlines()[-1]) == (0, "page.md: 4 steps as shown"), answer.stderr
    assert (tmp_path / "made" / "chapel.toml").is_file()
