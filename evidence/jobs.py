"""The list of jobs: every script that writes pages, results or pictures, once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from evidence.paths import ROOT


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

    def files(self, root: Path = ROOT) -> list[Path]:
        """What there is of what it writes."""
        return [path for pattern in self.writes for path in sorted(root.glob(pattern))]


def page(name: str, minutes: float, module: str, *writes: str) -> Job:
    """A job that writes docs/NAME.md and pictures; module : of this package, and its options."""
    return Job(name.replace("_", "-"), f"-m evidence.{module}", (f"docs/{name}.md", *writes), minutes)


def result(name: str, minutes: float, module: str, *writes: str) -> Job:
    """A job that writes docs/results/NAME.md, of which pages show parts, and pictures."""
    file = f"docs/results/{name}.md"
    return Job(name.replace("_", "-"), f"-m evidence.{module} --write {file}", (file, *writes), minutes)


def pictures(name: str, minutes: float, module: str, *writes: str) -> Job:
    """A job that writes pictures alone."""
    return Job(name, f"-m evidence.{module}", writes, minutes)


JOBS: Sequence[Job] = (
    page("validation", 1, "pages.validation"),
    page("dynamics_validation", 5, "pages.dynamics_validation"),
    page("hard", 4, "pages.hard"),
    page("fuzz", 20, "fuzz.run --scenes 20000 --limits 500 --jobs 2 --write docs/fuzz.md"),
    page("sequences", 30, "pages.sequences --write"),
    page("gallery", 1, "pages.gallery", "docs/gallery/*.png"),
    page("scenes", 0.1, "pages.scene_language"),
    page("speed_error", 9, "benchmarks.speed_error --write", "docs/speed-error.png"),
    page("bullet", 10, "dynamics.bullet --write", "docs/bullet.png"),
    page("paper", 5, "dynamics.paper --write", "docs/paper.png"),
    page(
        "comparison", 15, "comparisons.verdicts --jobs 1 --write docs/comparison.md", "docs/comparison/*.png",
        "docs/results/comparison.md",
    ),
    result("coulomb", 90, "comparisons.coulomb --engines bullet,lmgc90", "docs/results/coulomb.json"),
    result("experiments", 12, "experiments.predict"),
    result("experiments_measured", 0.1, "experiments.compare"),
    result("scatter", 0.1, "experiments.scatter"),
    result("architecture", 0.1, "pages.architecture", "docs/architecture.png"),
    pictures("pictures", 1, "pages.pictures", "docs/chapel*.png"),
    pictures("screenshots", 5, "pages.screenshots", "docs/app-*.png"),
    result("compare_verdicts", 2.5, "comparisons.huts"),
    result("glue", 1.5, "dynamics.glue"),
    result("stiffness", 2, "dynamics.stiffness"),
    result("settlements", 1.5, "checks.settlements"),
    result("panel", 3, "checks.panel"),
    result("capacity", 15, "dynamics.capacity"),
    result("loads", 1, "dynamics.loads --strips docs", "docs/strip-*.png"),
    result("iterations", 2, "dynamics.iterations"),
    result("plans", 30, "dynamics.plans"),
    result("search", 24, "benchmarks.search --sample 16 --lighter --reasons"),
    result("soundness", 3, "comparisons.soundness"),
    result("rubble", 0.1, "comparisons.rubble"),
    result("contacts", 0.5, "benchmarks.contacts"),
    result("sweep", 0.3, "benchmarks.sweep"),
    result("live_page", 1.5, "benchmarks.live_page"),
    result("proofs", 6, "checks.proofs"),
    result("chance", 8, "checks.chance"),
    result("solvers", 11, "benchmarks.solvers"),
    result("solvers_large", 10, "benchmarks.solvers --large --limit 300"),
)  # fmt: skip
