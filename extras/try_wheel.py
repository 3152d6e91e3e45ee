"""Build the wheel, install it in a fresh environment of each Python, and run the tests of the statics there.

    python extras/try_wheel.py python3.10 python3.13 [--tests tests/validation ...] [--extras dynamics,ui] [--slow]

The tests run in a copy of the repository without src/, so that they see what the wheel holds and nothing else. Without
`--extras` there is no MKL (SuperLU solves), no Bullet and no live page, and tests that need these are skipped.
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PLACE = ROOT / "build" / "wheel"
COPIED = ("tests", "evidence", "examples", "docs", "extras", "README.md", "pyproject.toml")
#: What the statics are tested by; the rest is the house's own order, evidence and dynamics.
TESTS = ("tests/blockstat", "tests/property", "tests/validation")
NEEDED = ("pytest>=8", "hypothesis>=6.100")


def run(*words: str | Path, **options) -> int:
    print("+", *words, flush=True)
    return subprocess.run([str(word) for word in words], **options).returncode


def built() -> Path:
    """The wheel."""
    for old in (PLACE / "dist", ROOT / "build" / "lib"):  # setuptools would take old modules from lib
        shutil.rmtree(old, ignore_errors=True)
    if run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", PLACE / "dist", ROOT):
        raise SystemExit("the wheel cannot be built")
    return next((PLACE / "dist").glob("blockstat-*.whl"))


def copied() -> Path:
    """A copy of the repository without the source."""
    tree = PLACE / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    for name in COPIED:
        own = ROOT / name
        shutil.copytree(own, tree / name) if own.is_dir() else shutil.copy(own, tree / name)
    return tree


def fresh(python: str, place: Path, *what: str | Path) -> Path | None:
    """The Python of a new environment in which these are installed; None where that fails."""
    own = place / "bin" / "python" if os.name != "nt" else place / "Scripts" / "python.exe"
    install = (own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *what)
    return None if run(python, "-m", "venv", "--clear", place) or run(*install) else own


def tried(python: str, wheel: Path, tree: Path, given: argparse.Namespace) -> int:
    """The status of the tests with one Python."""
    place = PLACE / Path(python).name if "/" not in python else PLACE / Path(python).parent.parent.name
    own = fresh(python, place, f"{wheel}[{given.extras}]" if given.extras else wheel, *NEEDED)
    if own is None:
        return 1
    where = "import blockstat, sys; print(sys.version.split()[0], blockstat.__file__)"
    run(own, "-c", where, cwd=tree)
    words = ("-m", "pytest", *given.tests, *(() if given.slow else ("-m", "not slow")), "-p", "no:cacheprovider")
    return run(own, *words, cwd=tree)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pythons", nargs="+", metavar="PYTHON")
    parser.add_argument("--tests", nargs="+", default=TESTS)
    parser.add_argument("--extras", metavar="NAME,...")
    parser.add_argument("--slow", action="store_true", help="Run the slow tests, too.")
    given = parser.parse_args()
    os.environ.pop("PYTHONPATH", None)  # a checkout there would count as installed
    wheel, tree = built(), copied()
    status = {python: tried(python, wheel, tree, given) for python in given.pythons}
    for python, found in status.items():
        print(f"{python}: {'all passed' if not found else f'status {found}'}")
    raise SystemExit(max(status.values()) != 0)


if __name__ == "__main__":
    main()
