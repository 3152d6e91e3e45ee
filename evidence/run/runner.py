"""Runs jobs side by side, and stamps what they made."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from time import time

from evidence import paths
from evidence.jobs import Job
from evidence.run import stamps
from evidence.run.stamps import Stamp
from evidence.run.threads import THREADS
from evidence.tables import table

OUT = paths.ROOT / "out" / "evidence"
SIDE_BY_SIDE = 2


def run(job: Job, quick: bool = False) -> Stamp | str:
    """Do a job; returns its stamp, or says what went wrong. A quick run has fewer scenes."""
    if job.absent and not quick:
        return f"no directory {job.absent[0]}; docs/evidence.md says where it comes from"
    OUT.mkdir(parents=True, exist_ok=True)
    log = OUT / f"{job.name}.log"
    print(f"start   {job.name}{'' if quick else f', about {job.minutes:g} min'}\n", end="", flush=True)  # in one write
    begin, commit, sources = time(), stamps.head(), stamps.sources_of(job)
    path = os.pathsep.join(filter(None, (str(paths.ROOT), os.environ.get("PYTHONPATH"))))
    with log.open("w") as file:
        process = subprocess.Popen(
            [sys.executable, *shlex.split(job.quick_command if quick else job.command)], cwd=paths.DOCS.parent,
            stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT,
            env={**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONPATH": path},
        )  # fmt: skip
        _, status, usage = os.wait4(process.pid, 0)  # counts what its own children took as well
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        last = log.read_text().strip().splitlines()[-1:] or [f"exit status {process.returncode}"]
        return f"{last[0]} ({log})"
    # Clocks of files are coarse.
    files = job.files(paths.DOCS.parent)
    old = [str(path.relative_to(paths.DOCS.parent)) for path in files if path.stat().st_mtime < begin - 1]
    if old or not files:
        return f"did not write {', '.join(old or job.writes)}"
    minutes = [round(seconds / 60, 4) for seconds in (usage.ru_utime + usage.ru_stime, time() - begin)]
    return Stamp(*commit, sources, *minutes)


def run_all(jobs: Sequence[Job], quick: bool = False) -> list[str]:
    """Do the jobs, the longest first and those that run alone at the end; the names of those that failed."""
    failed, done = [], 0
    for alone in (False, True):
        some = sorted((job for job in jobs if job.alone == alone), key=lambda job: -job.minutes)
        with ThreadPoolExecutor(1 if alone else SIDE_BY_SIDE) as pool:
            running = {pool.submit(run, job, quick): job for job in some}
            try:
                for future in as_completed(running):
                    job, found, done = running[future], future.result(), done + 1
                    failed += [job.name] if isinstance(found, str) else []
                    stamps.put({job.name: None if isinstance(found, str) else found})
                    print(f"{_told(job, found)} [{done}/{len(jobs)}]", flush=True)
            except KeyboardInterrupt:
                pool.shutdown(cancel_futures=True)
                raise
    return failed


def _told(job: Job, found: Stamp | str) -> str:
    if isinstance(found, str):
        return f"FAILED  {job.name}: {found}"
    return f"done    {job.name}: {found.process:.1f} min of process time, {found.clock:.1f} on the clock"


def chosen(jobs: Sequence[Job], only: Sequence[str], missing: bool) -> list[Job]:
    """The jobs of those names, or all; without those whose figures are current, if what is missing is wanted."""
    some = [job for job in jobs if not only or job.name in only]
    return [job for job in some if not (missing and stamps.current(job))]


def listed(jobs: Sequence[Job]) -> str:
    """All jobs, what they write, the commit of their figures and what they took."""
    known = stamps.stamps()

    def cells(job: Job) -> list[str]:
        own = known.get(job.name)
        made = (
            ("-", "-", "-") if own is None else (f"{own.commit}, {own.date}", f"{own.process:.1f}", f"{own.clock:.1f}")
        )
        writes = ", ".join(f"`{pattern}`" for pattern in job.writes)
        return [job.name, f"`python {job.command}`", writes, f"{job.minutes:g}", *made]

    return table(["job", "command", "writes", "about [min]", "commit", "process time", "clock"], map(cells, jobs))
