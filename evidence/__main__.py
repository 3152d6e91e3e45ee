"""Make every table and picture of README.md and the docs again: `make evidence`.

    python -m evidence [--only JOB ...] [--missing] [--list]

The jobs run two at a time, the longest first, each with one thread; what they print is in out/evidence. A job that
fails does not stop the others, and the exit status is then 1. `--missing` runs what has not been made since the last
full run, `--list` nothing: it writes the table of jobs and prints it.
"""

from __future__ import annotations

import argparse
import sys
from time import time

from evidence import runner
from evidence.jobs import JOBS
from evidence.pages import fill
from evidence.paths import RESULTS
from evidence.results import load, save

TABLE = RESULTS / "evidence.md"


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m evidence", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [job.name for job in JOBS]
    parser.add_argument("--only", nargs="+", default=[], choices=names, metavar="JOB", help=", ".join(names))
    parser.add_argument("--missing", action="store_true", help="leave out what has been made since the last full run")
    parser.add_argument("--list", action="store_true", help="run nothing, write and print the table of jobs")
    options = parser.parse_args()
    jobs = [] if options.list else runner.chosen(JOBS, options.only, options.missing)
    if not (options.only or options.missing):
        runner.forget(jobs)
    begin = time()
    failed = runner.run_all(jobs)
    _, shown = load(TABLE)
    table = runner.listed(JOBS, shown["jobs"])
    if options.list:
        print(table)
    else:
        print(f"{len(jobs) - len(failed)} of {len(jobs)} jobs done in {(time() - begin) / 60:.1f} min")
    # The times on the page are those of one full run.
    if options.list or all(runner.made(job) for job in JOBS):
        save(TABLE, {"jobs": table})
    fill.main()
    if failed:
        sys.exit(f"failed: {', '.join(failed)}; try again with --missing")


if __name__ == "__main__":
    main()
