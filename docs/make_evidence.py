"""Make every table and picture of README.md and the docs again: `make evidence`.

    python docs/make_evidence.py [--only JOB ...] [--missing] [--list]

The jobs run two at a time, the longest first, each with one thread; what they print is in out/evidence. A job that
fails does not stop the others, and the exit status is then 1. `--missing` runs what has not been made since the last
full run, `--list` nothing: it only writes the table of jobs.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from time import time

import make_pages  # finds results
from results import save

ROOT = Path(__file__).parents[1]
OUT = ROOT / "out" / "evidence"
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")
SIDE_BY_SIDE = 2


@dataclass(frozen=True)
class Job:
    """A script that writes pages, results or pictures.

    `command` follows the name of the interpreter, `writes` are patterns from the root of the project, `minutes` of
    process time are roughly what it takes.
    """

    name: str
    command: str
    writes: tuple[str, ...]
    minutes: float

    def files(self) -> list[Path]:
        """What there is of what it writes."""
        return [path for pattern in self.writes for path in sorted(ROOT.glob(pattern))]


def page(name: str, command: str, minutes: float, *writes: str) -> Job:
    """A job that writes docs/NAME.md and pictures."""
    return Job(name.replace("_", "-"), command, (f"docs/{name}.md", *writes), minutes)


def table(name: str, minutes: float, *options: str, script: str = "", writes: Sequence[str] = ()) -> Job:
    """A job that writes docs/results/NAME.md for the marked blocks of pages."""
    file = f"docs/results/{name}.md"
    command = " ".join([f"benchmarks/{script or name}.py", *options, "--write", file])
    return Job(name.replace("_", "-"), command, (file, *writes), minutes)


JOBS = (
    page("validation", "docs/make_validation.py", 1),
    page("dynamics_validation", "docs/make_dynamics_validation.py", 5),
    page("hard", "docs/make_hard.py", 2),
    page("gallery", "docs/make_gallery.py", 4, "docs/gallery/*.png"),
    page("scenes", "docs/make_scenes.py", 0.1),
    page("speed_error", "benchmarks/speed_error.py --write", 9, "docs/speed-error.png"),
    page("bullet", "benchmarks/bullet.py --write", 10, "docs/bullet.png"),
    page("paper", "examples/paper/experiment.py --write", 5, "docs/paper.png"),
    page(
        "comparison",
        "examples/compare_scenes.py --jobs 1 --write docs/comparison.md",
        15,
        "docs/comparison/*.png",
        "docs/results/comparison.md",
    ),
    Job("pictures", "docs/make_pictures.py", ("docs/chapel*.png",), 1),
    Job("screenshots", "docs/make_screenshots.py", ("docs/app-*.png",), 5),
    table("compare_verdicts", 2.5),
    table("glue", 1.5),
    table("stiffness", 2),
    table("loads", 1, "--strips docs", writes=["docs/strip-*.png"]),
    table("iterations", 2),
    table("search", 24, "--sample 16", "--lighter", "--reasons"),
    table("soundness", 3),
    table("sweep", 0.3),
    table("live_page", 1.5),
    table("solvers", 11),
    table("solvers_large", 10, "--large", "--limit 300", script="solvers"),
)


def made(job: Job) -> dict[str, float]:
    """Process time and time on the clock of a job since the last full run, both in minutes; nothing if it failed."""
    record = OUT / f"{job.name}.json"
    return json.loads(record.read_text()) if record.is_file() else {}


def run(job: Job) -> str:
    """Do a job; says what went wrong, or nothing."""
    OUT.mkdir(parents=True, exist_ok=True)
    record, log = OUT / f"{job.name}.json", OUT / f"{job.name}.log"
    record.unlink(missing_ok=True)
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
    old = [str(path.relative_to(ROOT)) for path in job.files() if path.stat().st_mtime < begin - 1]
    if old or not job.files():
        return f"did not write {', '.join(old or job.writes)}"
    minutes = {"process": (usage.ru_utime + usage.ru_stime) / 60, "clock": (time() - begin) / 60}
    record.write_text(json.dumps(minutes))
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


def listed(jobs: Sequence[Job]) -> str:
    """All jobs, what they write, and what they took."""
    rows = ["| job | command | writes | about [min] | process time | clock |", "|---" * 6 + "|"]
    for job in jobs:
        writes = ", ".join(f"`{pattern}`" for pattern in job.writes)
        took = "{process:.1f} | {clock:.1f}".format(**made(job)) if made(job) else "- | -"
        rows.append(f"| {job.name} | `python {job.command}` | {writes} | {job.minutes:g} | {took} |")
    return "\n".join(rows)


def chosen(jobs: Sequence[Job], only: Sequence[str], missing: bool) -> list[Job]:
    """The jobs of those names, or all; without those that were made, if what is missing is wanted."""
    some = [job for job in jobs if not only or job.name in only]
    return [job for job in some if not (missing and made(job))]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [job.name for job in JOBS]
    parser.add_argument("--only", nargs="+", default=[], choices=names, metavar="JOB", help=", ".join(names))
    parser.add_argument("--missing", action="store_true", help="leave out what has been made since the last full run")
    parser.add_argument("--list", action="store_true", help="run nothing, write the table of jobs")
    options = parser.parse_args()
    jobs = [] if options.list else chosen(JOBS, options.only, options.missing)
    if not (options.only or options.missing):
        for job in jobs:
            (OUT / f"{job.name}.json").unlink(missing_ok=True)
    begin = time()
    failed = run_all(jobs)
    print(f"{len(jobs) - len(failed)} of {len(jobs)} jobs done in {(time() - begin) / 60:.1f} min")
    # A table without some of the times would be poorer than the one there is.
    if options.list or all(made(job) for job in JOBS):
        save(make_pages.RESULTS / "evidence.md", {"jobs": listed(JOBS)})
    make_pages.main()
    if failed:
        sys.exit(f"failed: {', '.join(failed)}; try again with --missing")


if __name__ == "__main__":
    main()
