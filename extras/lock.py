"""Renew requirements.lock with the hashes of PyPI, and the table of licences; or check that both are whole.

    python extras/lock.py            the versions of this environment, with the digests of all their files
    python extras/lock.py --same     the versions that the lock has already
    python extras/lock.py --check    without a network: every version has a hash and is the one that is installed

It needs the standard library alone. `make` installs with `--require-hashes`, so that a file that was changed since is
refused.
"""

import json
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, distributions, metadata
from pathlib import Path
from urllib.request import Request, urlopen

ROOT = Path(__file__).resolve().parents[1]
LOCK, LICENCES = ROOT / "requirements.lock", ROOT / "docs" / "licences.md"
OWN = ("blockstat", "pip", "setuptools", "wheel")
HEAD = """# Licences

What blockstat stands on, as requirements.lock names it, with the licence that each package states.
`python extras/lock.py` writes this page. Of these, only numpy, scipy, clarabel, cvxpy, shapely, trimesh, mapbox-earcut,
matplotlib, joblib, msgspec and typer, and what they need, are installed without an extra.

| package | version | licence |
|---|---|---|
"""


def installed() -> dict[str, str]:
    """Versions of this environment by normal name."""
    found = {re.sub(r"[-_.]+", "-", own.metadata["Name"]).lower(): own.version for own in distributions()}
    return {name: version for name, version in sorted(found.items()) if name not in OWN}


def locked() -> dict[str, tuple[str, list[str]]]:
    """Versions and hashes of the lock by name."""
    text = LOCK.read_text().replace("\\\n", " ")
    rows = (re.match(r"([\w.-]+)==(\S+)(.*)", line) for line in text.splitlines())
    return {row[1]: (row[2], re.findall(r"--hash=sha256:([0-9a-f]{64})", row[3])) for row in rows if row}


def published(name: str, version: str) -> list[str]:
    """Digests of the files of a version, by the simple index of PyPI (PEP 691)."""
    accepted = {"Accept": "application/vnd.pypi.simple.v1+json"}
    with urlopen(Request(f"https://pypi.org/simple/{name}/", headers=accepted), timeout=60) as answer:
        files = json.load(answer)["files"]
    own = re.compile(rf"[^-]+(-[^-\d][^-]*)*-{re.escape(version)}(-.*\.whl|\.tar\.gz|\.zip|\.tar\.bz2)")
    found = sorted({file["hashes"]["sha256"] for file in files if own.fullmatch(file["filename"])})
    if not found:
        raise SystemExit(f"{name} {version}: PyPI has no such file")
    return found


def licence_of(name: str) -> str:
    """What a package says of its licence, in a few words: the one that is installed, or else the newest on PyPI."""
    try:
        own = metadata(name)
        classifiers, texts = own.get_all("Classifier", []), (own["License-Expression"], own["License"])
    except PackageNotFoundError:
        with urlopen(f"https://pypi.org/pypi/{name}/json", timeout=60) as answer:
            info = json.load(answer)["info"]
        classifiers, texts = info["classifiers"], (info.get("license_expression"), info["license"])
    first = (texts[1] or "").strip().split("\n")[0]
    classes = ", ".join(text.rpartition(" :: ")[2] for text in classifiers if text.startswith("License ::"))
    return (texts[0] or (first if 0 < len(first) < 60 else classes) or "see PyPI").replace("|", "/")


def renew(versions: dict[str, str]) -> None:
    """Write the lock and the table."""
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda item: published(*item), versions.items()))
        licences = list(pool.map(licence_of, versions))
    lines, rows = [], []
    for (name, version), hashes, licence in zip(versions.items(), found, licences):
        lines.append(" \\\n".join([f"{name}=={version}", *(f"    --hash=sha256:{own}" for own in hashes)]))
        rows.append(f"| [{name}](https://pypi.org/project/{name}/) | {version} | {licence} |")
    LOCK.write_text("\n".join(lines) + "\n")
    LICENCES.write_text(HEAD + "\n".join(rows) + "\n")


def faults() -> list[str]:
    """What is wrong with the lock or the table, a line each."""
    here, table = installed(), LICENCES.read_text()
    found = []
    for name, (version, hashes) in locked().items():
        if not hashes:
            found.append(f"{name}: the lock has no hash")
        if here.get(name, version) != version:
            found.append(f"{name}: {here[name]} is installed, and the lock has {version}")
        if f"| [{name}](https://pypi.org/project/{name}/) | {version} |" not in table:
            found.append(f"{name}: docs/licences.md does not have {version}")
    return found


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        sys.exit("\n".join(faults()) or 0)
    renew({name: version for name, (version, _) in locked().items()} if sys.argv[1:] == ["--same"] else installed())
