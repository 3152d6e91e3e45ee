"""Build wheel and sdist into dist/, check both, and run the quick start from each in a fresh environment.

    python extras/dist.py [--python python3.11]

The build sees the files that git has and no others. The wheel is built from the sdist, so what the build needs is in
it. An sdist holds all that git has, so that tests, evidence and pages can be run from it; a wheel holds the two
packages, their types and the examples. The tools stand in an environment of their own in build/dist.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

from try_wheel import ROOT, fresh, run

PLACE = ROOT / "build" / "dist"
OUT = ROOT / "dist"
PAGE = ROOT / "docs" / "quick_start.md"
TOOLS = ("build>=1.2", "twine>=6")
#: What setuptools adds to an sdist.
ADDED = ("PKG-INFO", "setup.cfg", "src/blockstat.egg-info/")
TYPES = ("blockstat/py.typed", "dynsim/py.typed")
#: Says in an environment where the packages come from, and what a reader would ask first.
WHERE = """
import blockstat, dynsim, importlib.metadata, sys
print(sys.version.split()[0], blockstat.__file__, dynsim.__file__)
assert importlib.metadata.version("blockstat") == blockstat.__version__ == sys.argv[1], blockstat.__version__
assert all(module.__file__.startswith(sys.prefix) for module in (blockstat, dynsim)), "imported from elsewhere"
"""


def tracked(root: Path) -> set[str]:
    """The files that git has, less links to directories, whose files are listed elsewhere."""
    found = subprocess.run(["git", "-C", root, "ls-files", "-z"], capture_output=True, text=True)
    if found.returncode:
        raise SystemExit("make dist packs what git has: run it in a clone of the repository")
    return {name for name in found.stdout.split("\0") if (root / name).is_file()}


def copied(root: Path, names: set[str], place: Path) -> Path:
    """A tree of these files alone."""
    tree = place / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    for name in sorted(names):
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(root / name, tree / name)
    return tree


def wrong_in_sdist(held: set[str], names: set[str]) -> list[str]:
    """What an sdist lacks of the names, and what it holds beside them."""
    lacking = [f"the sdist lacks {name}" for name in sorted(names - held)]
    beside = [f"the sdist holds {name}" for name in sorted(held - names) if not name.startswith(ADDED)]
    return lacking + beside


def wrong_in_wheel(held: set[str], names: set[str]) -> list[str]:
    """What a wheel lacks of the packages, their types and the examples, and what it holds beside them."""
    needed = {name.removeprefix("src/") for name in names if name.startswith("src/")} | set(TYPES)
    scenes = {Path(name).name for name in names if name.startswith("examples/") and name.endswith((".toml", ".obj"))}
    share = {name.rpartition("/")[2] for name in held if ".data/data/share/blockstat/examples/" in name}
    own = {name for name in held if ".dist-info/" not in name and ".data/" not in name}
    return (
        [f"the wheel lacks {name}" for name in sorted(needed - held)]
        + [f"the wheel lacks the example {name}" for name in sorted(scenes - share)]
        + [f"the wheel holds {name}" for name in sorted(own - needed)]
    )


def files_of(archive: Path) -> set[str]:
    """The names of the files, in an sdist without its directory."""
    if archive.suffix == ".whl":
        with zipfile.ZipFile(archive) as opened:
            return set(opened.namelist())
    with tarfile.open(archive) as opened:
        return {member.name.partition("/")[2] for member in opened.getmembers() if not member.isdir()}


def built(tree: Path, tools: Path) -> tuple[Path, Path]:
    """The sdist, and the wheel built from it."""
    shutil.rmtree(OUT, ignore_errors=True)
    if run(tools, "-m", "build", "--outdir", OUT, tree, stdout=subprocess.DEVNULL):
        raise SystemExit("wheel and sdist cannot be built")
    sdist, wheel = next(OUT.glob("*.tar.gz")), next(OUT.glob("*.whl"))
    if run(tools, "-m", "twine", "check", "--strict", sdist, wheel):
        raise SystemExit("the metadata is not in order")
    return sdist, wheel


def tried(python: str, archive: Path) -> bool:
    """Whether the quick start runs from an archive in a fresh environment and an empty directory."""
    kind = "wheel" if archive.suffix == ".whl" else "sdist"
    own = fresh(python, PLACE / kind, archive)
    if own is None:
        return False
    empty = PLACE / f"{kind}-empty"
    shutil.rmtree(empty, ignore_errors=True)
    empty.mkdir()
    version = archive.name.removesuffix(".tar.gz").split("-")[1]
    # -I: neither this checkout nor the empty directory is on the path.
    return not (
        run(own, "-I", "-c", WHERE, version, cwd=empty) or run(own, "-I", ROOT / "extras/run_page.py", PAGE, cwd=empty)
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=sys.executable, help="With which the environments are made.")
    python = parser.parse_args().python
    os.environ.pop("PYTHONPATH", None)
    names = tracked(ROOT)
    changed = subprocess.run(["git", "-C", ROOT, "status", "--porcelain"], capture_output=True, text=True).stdout
    if changed:
        print(f"These files are not as the last commit has them; commit before a release:\n{changed}", end="")
    tree = copied(ROOT, names, PLACE)
    tools = fresh(python, PLACE / "tools", *TOOLS)
    if tools is None:
        raise SystemExit("the tools cannot be installed")
    sdist, wheel = built(tree, tools)
    wrong = wrong_in_sdist(files_of(sdist), names) + wrong_in_wheel(files_of(wheel), names)
    if wrong:
        raise SystemExit("\n".join([*wrong, "MANIFEST.in and pyproject.toml say what goes where"]))
    good = {archive: tried(python, archive) for archive in (wheel, sdist)}
    for archive, works in good.items():
        print(f"{archive.relative_to(ROOT)}: {'the quick start runs' if works else 'the quick start fails'}")
    raise SystemExit(not all(good.values()))


if __name__ == "__main__":
    main()
