"""Make every table and picture of README.md and the docs again: `make evidence`.

    python -m evidence [--only JOB ...] [--missing] [--quick] [--list]

The jobs run two at a time, the longest first, each with one thread; what they print is in out/evidence. A job that
fails does not stop the others, and the exit status is then 1. `--missing` leaves out jobs whose figures come from the
sources that there are: it goes on where a run was interrupted. `--quick` runs all with fewer scenes, and makes pages of
its own in build/quick, which say so. `--list` runs nothing: it writes the table of jobs and prints it.
"""

from __future__ import annotations

import argparse
import os
import sys
from time import time

from evidence import paths
from evidence.jobs import JOBS
from evidence.pages import fill
from evidence.results import save
from evidence.run import quick, runner, stamps


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m evidence", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [job.name for job in JOBS]
    parser.add_argument("--only", nargs="+", default=[], choices=names, metavar="JOB", help=", ".join(names))
    parser.add_argument("--missing", action="store_true", help="leave out what comes from the present sources")
    parser.add_argument("--quick", action="store_true", help="fewer scenes, and pages in build/quick")
    parser.add_argument("--list", action="store_true", help="run nothing, write and print the table of jobs")
    options = parser.parse_args()
    if options.quick and paths.DOCS != quick.DOCS:
        quick.copy_pages()
        os.environ["BLOCKSTAT_DOCS"] = str(quick.DOCS)
        os.execv(sys.executable, [sys.executable, "-m", "evidence", *sys.argv[1:]])
    jobs = [] if options.list else runner.chosen(JOBS, options.only, options.missing)
    if not (options.only or options.missing or options.list):
        stamps.put({job.name: None for job in JOBS})
    begin = time()
    failed = runner.run_all(jobs, options.quick)
    table = runner.listed(JOBS)
    if options.list:
        print(table)
    else:
        print(f"{len(jobs) - len(failed)} of {len(jobs)} jobs done in {(time() - begin) / 60:.1f} min")
    save(paths.RESULTS / "evidence.md", {"jobs": table}, ["--list"])
    fill.main()
    if options.quick:
        print(f"pages with fewer scenes are in {quick.DOCS}")
    if failed:
        sys.exit(f"failed: {', '.join(failed)}; try again with --missing")


if __name__ == "__main__":
    main()
