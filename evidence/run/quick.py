"""The pages of a quick run, in build/quick: each with fewer scenes than its text says, and a foot that says so."""

from __future__ import annotations

import shutil

from evidence.jobs import JOBS
from evidence.paths import ROOT

DOCS = ROOT / "build" / "quick" / "docs"
SAID = "*A quick run with fewer scenes than this page says, to see that everything runs: do not cite its figures.*"


def copy_pages() -> None:
    """Copy the pages that are written by hand; those of jobs and all results are made anew."""
    shutil.rmtree(DOCS.parent, ignore_errors=True)
    made = {path for job in JOBS for path in job.files(ROOT)}
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*"))]:
        inside = path.relative_to(ROOT)
        if path.is_file() and path not in made and inside.parts[1:2] not in [("results",), ("notebooks",)]:
            target = DOCS.parent / inside
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)
    (DOCS / "results").mkdir()
