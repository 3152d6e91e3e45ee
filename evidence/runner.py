"""Runs jobs side by side and keeps what they took."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from time import time

from evidence.jobs import Job
from evidence.paths import ROOT
from evidence.tables import table

OUT = ROOT / "out" / "evidence"
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")
SIDE_BY_SIDE = 2


def record(job: Job) -> Path:
    """The file of what a job took."""
    return OUT / f"{job.name}.json"


def made(job: Job) -> dict[str, float]:
    """Process time and time on the clock of a job since the last full run, both in minutes; nothing if it failed."""
    return json.loads(record(job).read_text()) if record(job).is_file() else {}


def forget(jobs: Iterable[Job]) -> None:
    """Take the jobs as not made."""
    for job in jobs:
        record(job).unlink(missing_ok=True)


def run(job: Job) -> str:
    """Do a job; says what went wrong, or nothing."""
    OUT.mkdir(parents=True, exist_ok=True)
    forget([job])
    log = OUT / f"{job.name}.log"
    print(f"start   {job.name}, about {job.minutes:g} min\n", end="", flush=True)  # one write, two threads
    begin = time()
    with log.open("w") as file:
        process = subprocess.Popen(
            [sys.executable, *shlex.split(job.command)], cwd=ROOT, stdin=subprocess.DEVNULL, stdout=file,
            stderr=subprocess.STDOUT, env={**os.environ, **dict.fromkeys(THREADS, "1")},
        )  # fmt: skip
        _, status, usage = os.wait4(process.pid, 0)  # counts what its own children took as well
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        last = log.read_text().strip().splitlines()[-1:] or [f"exit status {process.returncode}"]
        return f"{last[0]} ({log.relative_to(ROOT)})"
    # Clocks of files are coarse.
    files = job.files(ROOT)
    old = [str(path.relative_to(ROOT)) for path in files if path.stat().st_mtime < begin - 1]
    if old or not files:
        return f"did not write {', '.join(old or job.writes)}"
    minutes = {"process": (usage.ru_utime + usage.ru_stime) / 60, "clock": (time() - begin) / 60}
    record(job).write_text(json.dumps(minutes))
    return ""


def run_all(jobs: Sequence[Job]) -> list[str]:
    """Do the jobs, the longest first; the names of those that failed."""
    failed = []
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        running = {pool.submit(run, job): job for job in sorted(jobs, key=lambda job: -job.minutes)}
        try:
            for number, future in enumerate(as_completed(running), 1):
                job, wrong = running[future], future.result()
                if wrong:
                    failed.append(job.name)
                words = wrong or "{process:.1f} min of process time, {clock:.1f} on the clock".format(**made(job))
                print(f"{'FAILED ' if wrong else 'done   '} {job.name}: {words} [{number}/{len(jobs)}]", flush=True)
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise
    return failed


def chosen(jobs: Sequence[Job], only: Sequence[str], missing: bool) -> list[Job]:
    """The jobs of those names, or all; without those that were made, if what is missing is wanted."""
    some = [job for job in jobs if not only or job.name in only]
    return [job for job in some if not (missing and made(job))]


def listed(jobs: Sequence[Job], earlier: str = "") -> str:
    """All jobs, what they write, and what they took; times that are not known here are those of an earlier table."""
    known = {}
    for line in earlier.splitlines()[2:]:
        name, *_, process, clock = line.strip("| ").split(" | ")
        known[name] = (process, clock)

    def took(job: Job) -> tuple[str, str]:
        found = made(job)
        return (f"{found['process']:.1f}", f"{found['clock']:.1f}") if found else known.get(job.name, ("-", "-"))

    return table(
        ["job", "command", "writes", "about [min]", "process time", "clock"],
        (
            [
                job.name, f"`python {job.command}`", ", ".join(f"`{pattern}`" for pattern in job.writes),
                f"{job.minutes:g}", *took(job),
            ]
            for job in jobs
        ),
    )  # fmt: skip
