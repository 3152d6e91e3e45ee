"""Which source the figures of a job come from: docs/results/stamps.json.

A stamp holds the commit and its date, the hash of the sources that the job depends on (`evidence.run.sources`), and
what the job took. The commit is the last one that changed any source, so that a second run on the same sources gives
the same stamps. A page is current as long as the hashes of its jobs are those of the sources there are.
"""

from __future__ import annotations

import json
import shlex
import subprocess
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass

from evidence import paths
from evidence.jobs import Job
from evidence.run.sources import digest

#: What figures come from.
SOURCES = ("src", "evidence", "examples", "requirements.lock")


@dataclass(frozen=True)
class Stamp:
    """The source of a job's figures, and what they took."""

    commit: str  #: with "+" where files had changed since
    date: str  #: of the commit
    sources: str  #: the hash of what the job depends on
    process: float  #: process time [min]
    clock: float  #: [min]

    def __str__(self) -> str:
        return _source(self.commit, self.date)


def _source(commit: str, date: str) -> str:
    return f"commit `{commit}` of {date}"


def _foot(source: str) -> str:
    return f"*The figures of this page are of {source}.*"


def head() -> tuple[str, str]:
    """The last commit that changed a source and its date; a "+" where sources have changed since."""

    def git(*words: str) -> str:
        return subprocess.run(
            ["git", *words, "--", *SOURCES], cwd=paths.ROOT, capture_output=True, text=True, check=True
        ).stdout.strip()

    try:
        commit, date = git("log", "-1", "--abbrev=10", "--format=%h %cs").split()
        return commit + ("+" if git("status", "--porcelain") else ""), date
    except (OSError, ValueError, subprocess.CalledProcessError):
        return "unknown", "unknown"


def measured_now() -> str:
    """The foot of a page that is no job's: its figures come from the source as it is."""
    commit, date = head()
    return _foot(_source(commit, date))


def sources_of(job: Job) -> str:
    """The hash of what a job depends on now."""
    return digest(shlex.split(job.command)[1])


def stamps() -> dict[str, Stamp]:
    """The stamps of all jobs that have one."""
    path = paths.RESULTS / "stamps.json"
    return {name: Stamp(**own) for name, own in json.loads(path.read_text()).items()} if path.is_file() else {}


def put(new: Mapping[str, Stamp | None]) -> None:
    """Change the stamps of these jobs; None takes a stamp away."""
    every = {name: own for name, own in {**stamps(), **new}.items() if own is not None}
    text = json.dumps({name: asdict(every[name]) for name in sorted(every)}, indent=1) + "\n"
    paths.RESULTS.mkdir(parents=True, exist_ok=True)
    (paths.RESULTS / "stamps.json").write_text(text)


def current(job: Job) -> bool:
    """Whether a job's figures come from the sources that there are."""
    own = stamps().get(job.name)
    return own is not None and own.sources == sources_of(job)


def foot(jobs: Iterable[Job]) -> str:
    """What the foot of a page says of the jobs whose figures it shows."""
    known = stamps()
    lines: dict[str, list[str]] = {}
    for job in jobs:
        own = known.get(job.name)
        words = "a commit that was not noted" if own is None else str(own)
        if own is not None and not current(job):
            words += ", and the source has changed since"
        lines.setdefault(words, []).append(job.name)
    if len(lines) == 1:
        return _foot(next(iter(lines)))
    return "\n".join(f"*Figures of {', '.join(names)}: {words}.*  " for words, names in lines.items()).rstrip()
