"""The list of jobs: every script that writes pages, results or pictures, once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evidence.paths import CASES, EXPERIMENTS, ROOT, SEQUENCES


@dataclass(frozen=True)
class Job:
    """A script that writes pages, results or pictures.

    `command` follows the name of the interpreter, `writes` are patterns from the root of the project, `minutes` of
    process time are roughly what it takes. `fewer` are the options of a quick run, which stand after the others.
    `needs` are the directories of other projects' data without which there are no figures. A job that measures the
    clock is run `alone`.
    """

    name: str
    command: str
    writes: tuple[str, ...]
    minutes: float
    fewer: str = ""
    needs: tuple[Path, ...] = ()
    alone: bool = False

    @property
    def quick_command(self) -> str:
        """The command of a quick run."""
        return f"{self.command} {self.fewer}".strip()

    def files(self, root: Path = ROOT) -> list[Path]:
        """What there is of what it writes."""
        return [path for pattern in self.writes for path in sorted(root.glob(pattern))]

    @property
    def absent(self) -> list[Path]:
        """The directories that it needs and that are not there."""
        return [path for path in self.needs if not path.is_dir()]


def page(name: str, minutes: float, module: str, *writes: str, **more: Any) -> Job:
    """A job that writes docs/NAME.md and pictures; module : of this package, and its options."""
    return Job(name.replace("_", "-"), f"-m evidence.{module}", (f"docs/{name}.md", *writes), minutes, **more)


def result(name: str, minutes: float, module: str, *writes: str, **more: Any) -> Job:
    """A job that writes docs/results/NAME.md, of which pages show parts, and pictures."""
    file = f"docs/results/{name}.md"
    return Job(name.replace("_", "-"), f"-m evidence.{module} --write {file}", (file, *writes), minutes, **more)


def pictures(name: str, minutes: float, module: str, *writes: str) -> Job:
    """A job that writes pictures alone."""
    return Job(name, f"-m evidence.{module}", writes, minutes)


JOBS: Sequence[Job] = (
    page("validation", 1, "pages.validation", needs=(CASES,)),
    page("dynamics_validation", 3, "pages.dynamics_validation"),
    page("hard", 4, "pages.hard", fewer="--fast --piles 500"),
    page(
        "fuzz", 20, "fuzz.run --scenes 20000 --limits 500 --jobs 2 --write docs/fuzz.md",
        fewer="--scenes 300 --limits 20",
    ),
    page("sequences", 30, "pages.sequences --write", fewer="--only chapel bridge canopy"),
    page("gallery", 1, "pages.gallery", "docs/gallery/*.png"),
    page("scenes", 0.1, "pages.scene_language", "docs/scenes/*.md"),
    page("command_line", 0.1, "pages.command_line", "docs/command_line/*.md"),
    page("speed_error", 9, "benchmarks.speed_error --write", "docs/speed-error.png", fewer="--no-bullet --largest 350"),
    result(
        "choosing", 7, "choosing.page", "docs/choosing.png",
        fewer="--steps 20 --draws 100 --tolerance 1e-5 --within 0.01",
    ),
    page(
        "bullet", 10, "dynamics.bullet --write", "docs/bullet.png", "docs/results/bullet.md",
        fewer="--sizes S --presets fast default",
    ),
    page("paper", 5, "dynamics.paper --write", "docs/paper.png", fewer="--seconds 1 --walls 1"),
    page(
        "comparison", 15, "comparisons.verdicts --jobs 1 --write docs/comparison.md", "docs/comparison/*.png",
        "docs/results/comparison.md", fewer="--scenes 12 --limits 2",
    ),
    result(
        "coulomb", 40, "comparisons.coulomb --engines bullet --most 1200 --minutes 10", "docs/results/coulomb.json",
        fewer="--engines none --random 8 --largest 300", needs=(CASES,),
    ),
    result("experiments", 12, "experiments.predict", fewer="--walls 1", needs=(EXPERIMENTS,)),
    result("experiments_measured", 0.1, "experiments.compare", fewer="--walls 1", needs=(EXPERIMENTS,)),
    result("scatter", 0.1, "experiments.scatter", needs=(EXPERIMENTS,)),
    result("architecture", 0.1, "pages.architecture", "docs/architecture.png"),
    pictures("pictures", 2, "pages.pictures", "docs/chapel*.png", "docs/facade-*.png", "docs/bridge-*.png"),
    pictures("screenshots", 5, "pages.screenshots", "docs/app-*.png"),
    result("compare_verdicts", 2.5, "comparisons.huts", fewer="--scenes 10"),
    result("glue", 1.5, "dynamics.glue", fewer="--scenes 10"),
    result("stiffness", 2, "dynamics.stiffness", fewer="--walls 1"),
    result("settlements", 1.5, "checks.settlements"),
    result("panel", 3, "checks.panel", fewer="--step 0.05 --draws 2"),
    result("capacity", 15, "dynamics.capacity", fewer="--scenes 1 --places 1 --large 1"),
    result("loads", 1, "dynamics.loads --strips docs", "docs/strip-*.png"),
    result("iterations", 2, "dynamics.iterations"),
    result("plans", 30, "dynamics.plans", fewer="--only arch", needs=(SEQUENCES,)),
    result(
        "search", 24, "benchmarks.search --sample 16 --lighter --reasons",
        fewer="--sample 2 --widest 0.4 --no-gradient",
    ),
    result("soundness", 3, "comparisons.soundness", fewer="--designs 60"),
    result("rubble", 0.1, "comparisons.rubble", needs=(CASES / "rubble",)),
    result("contacts", 0.5, "benchmarks.contacts", needs=(CASES,)),
    result("sweep", 0.3, "benchmarks.sweep"),
    result("workers", 4, "choosing.workers", fewer="--size 0.1 --repeat 1", alone=True),
    result("live_page", 1.5, "benchmarks.live_page", fewer="--sizes 300"),
    result("proofs", 6, "checks.proofs", fewer="--only sizes --largest 100", needs=(CASES,)),
    result("chance", 8, "checks.chance", fewer="--draws 100"),
    result("solvers", 11, "benchmarks.solvers", fewer="--sizes 100 --limit 10"),
    result("solvers_large", 10, "benchmarks.solvers --large --limit 300", fewer="--limit 6 --alone 1000"),
)  # fmt: skip
