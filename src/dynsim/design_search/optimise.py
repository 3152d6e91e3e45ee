"""The design search with Bullet as its verifier, and its report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from blockstat.analysis.assess import assess
from blockstat.analysis.certificate_cache import Memory
from blockstat.assembly import Assembly
from blockstat.design_search.search import Candidate, SearchResult, search
from blockstat.model import build
from blockstat.spec import Scene, with_values
from blockstat.view.plot import Place, plot
from blockstat.view.report import Figure, write_designs, write_report
from dynsim.comparison.causes import likely_reason
from dynsim.judge.verify import DynamicVerdict, verify
from dynsim.parallel.pool import jobs_checked
from dynsim.parallel.speculative import Ahead
from dynsim.settings import Settings

NOTE = (
    "Joints are dry: the glue and rotational stiffness of the scene are not modelled. Stable means that a force field "
    "within all friction cones exists; it does not promise rest, so Bullet has the last word."
)


def optimise(
    building: Scene,
    directory: Path,
    *,
    names: Sequence[str] | None = None,
    settings: Settings | None = None,
    jobs: int | None = None,
    under: Callable[[Assembly], Assembly] = lambda assembly: assembly,
    conditions: str = "",
    **options: Any,
) -> tuple[SearchResult, Path]:
    """Search, confirm, and write history.csv, best.json, best.glb, pictures and report.html into a directory.

    An interrupted search goes on from its history.csv when called again. jobs : simulations side by side, as many as
    cores by default, whatever the number with the same history; under : puts each design under another
    friction or gravity, and conditions says which. options : those of `blockstat.search` (strategy, over, margin, snap,
    points). Returns the result and the report's path.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("searching", total=None)

        def progress(done: int, expected: int, last: Candidate) -> None:
            word = f"{last.static} / {last.dynamic}" if last.dynamic else last.note or last.static
            values = " ".join(f"{value:g}" for value in last.parameters.values())
            bar.update(task, completed=done, total=expected, description=f"{values}: {word}")

        memory, jobs = Memory(), jobs_checked(jobs)
        with Ahead(partial(verify, settings=settings), jobs) as dynamic:
            result = search(
                building,
                static=lambda assembly: assess(assembly, memory=memory, score=False),
                verify=dynamic,
                begin=dynamic.begin if jobs > 1 else None,
                speculative=jobs,
                under=under,
                memory=memory,
                names=names,
                history=directory / "history.csv",
                progress=progress,
                remark=likely_reason,
                conditions=f"{settings} {conditions}" if settings or conditions else "",
                **options,
            )
    figures = write_designs(result, directory, under=under)
    figures += _moved(result, directory, settings, under)
    notes = [f"Judged with {conditions}.", NOTE] if conditions else [NOTE]
    return result, write_report(result, directory, figures, notes=notes)


def _moved(
    result: SearchResult, directory: Path, settings: Settings | None, under: Callable[[Assembly], Assembly]
) -> list[Figure]:
    """The blocks that Bullet saw move: of the thinnest design that fell, else of the best one."""
    fallen = [c for c in result.history if c.dynamic in ("falls", "creeps")]
    chosen = min(fallen, key=lambda c: c.volume or 0.0).parameters if fallen else result.best_parameters
    if chosen is None:
        return []
    verdict = verify(under(build(with_values(result.building, chosen))), settings=settings)
    values = ", ".join(f"{name} {value:g}" for name, value in chosen.items())
    word = "moved in Bullet though statics allow it" if fallen else "stands in Bullet"
    return [Figure(picture_of_run(verdict, directory / "moved.png"), f"The design with {values} {word}.")]


def picture_of_run(verdict: DynamicVerdict, place: Place) -> Place:
    """The last frame of a run, displacements magnified to be seen, coloured by displacement."""
    run = verdict.run
    moved = verdict.displacement
    length = (moved**2).sum(axis=1) ** 0.5
    lower, upper = run.assembly.bounds
    scale = max(1.0, 0.05 * float((upper - lower).max()) / max(float(length.max()), 1e-9))
    scale = min(scale, 1000.0)
    return plot(
        run.assembly, place, values=1e3 * length, label="displacement since release [mm]", displacement=scale * moved,
        title=f"{run.assembly.name}: {verdict.outcome.word}, displacements x {scale:.0f}",
    )  # fmt: skip
