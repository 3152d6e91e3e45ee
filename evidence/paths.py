"""Where things lie: the project, its pages and examples, and assemblies from other projects."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: The pages. A quick run of the evidence has its own, as a process elsewhere may.
DOCS = Path(os.environ.get("BLOCKSTAT_DOCS", ROOT / "docs"))
RESULTS = DOCS / "results"
EXAMPLES = ROOT / "examples"
#: Assemblies from other projects. Jobs that need them say so, and fail where they are absent.
CASES = Path(os.environ.get("BLOCKSTAT_CASES", ROOT.parent / "shared" / "cases"))
#: Plans of building from other projects.
SEQUENCES = Path(os.environ.get("BLOCKSTAT_SEQUENCES", CASES.parent / "sequences"))
#: Tests in laboratories.
EXPERIMENTS = Path(os.environ.get("BLOCKSTAT_EXPERIMENTS", ROOT.parent / "shared" / "experiments"))
