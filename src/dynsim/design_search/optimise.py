"""The design search with Bullet as its verifier, and its report."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from textwrap import fill

from blockstat.analysis.assess import assess
from blockstat.analysis.certificate_cache import Memory
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.design_search.candidate import ERROR
from blockstat.design_search.search import (
    Candidate,
    FailureTarget,
    Margin,
    SearchResult,
    check_strategy,
    search,
    space_of,
)
from blockstat.errors import InputError, known_options
from blockstat.imperfection.imperfections import Imperfections
from blockstat.spec import Scene, build, with_values
from blockstat.system.lines import PlainLines
from blockstat.system.lock import locked
from blockstat.view.plot import Place, plot
from blockstat.view.report import TITLE, Figure, write_designs, write_report
from dynsim.comparison.causes import likely_reason
from dynsim.engine.bullet import import_bullet
from dynsim.judge.verdict import DynamicVerdict
from dynsim.judge.verify import verify
from dynsim.parallel.pool import jobs_checked
from dynsim.parallel.speculative import SpeculativeRuns
from dynsim.settings import Settings

NOTE = (
    "Joints are dry: the glue and rotational stiffness of the scene are not modelled. Stable means that a force field "
    "within all friction cones exists; it does not promise rest, so Bullet has the last word."
)
#: What the picture says of a design that statics allow and that Bullet did not see stand.
MOVED = {
    "falls": "moved in Bullet though statics allow it",
    "creeps": "was still moving, slowly, at the end of the run in Bullet, though statics allow it",
}


@known_options
def optimise(
    building: Scene,
    directory: Path,
    *,
    names: Sequence[str] | None = None,
    settings: Settings | None = None,
    jobs: int | None = None,
    under: Callable[[Assembly], Assembly] = lambda assembly: assembly,
    conditions: str = "",
    options: str = "",
    strategy: str = "pruned",
    over: str = "line",
    margin: Margin | None = None,
    snap: bool = False,
    points: int = 6,
    imperfections: Imperfections | None = None,
    target: FailureTarget | None = None,
    gap: float | str = GAP,
    answered: Callable[[SearchResult], None] = lambda result: None,
) -> tuple[SearchResult, Path]:
    """Search for the lightest design that stands, confirm it in Bullet, and write a report.

    The directory gets history.csv, best.json, best.glb, pictures and report.html. An interrupted search goes on from
    its history.csv when called again; one that has no design that could be built is begun anew.

    Parameters
    ----------
    building : Scene
        A scene with ranges or values to search.
    directory : Path
        An existing directory.
    names : sequence of str, optional
        Parameters to move, in order; all ranges of the scene when None.
    settings : Settings, optional
        Of the dynamic verdicts, as in `verify`. Statics say how much a run has to resolve (`statics=True` there).
    jobs : int, optional
        Simulations side by side; all cores when None. The history is the same whatever the number.
    under : callable
        Puts each design under another friction or gravity.
    conditions : str
        Says which; a history under other conditions is not taken up.
    options : str
        What else was asked for, in words. The report says it, and a history does not depend on it.
    strategy, over, margin, snap, points, imperfections, target, gap : optional
        As in `blockstat.search`.
    answered : callable, optional
        Called with the best design and the history before the pictures and the report are made, which takes a while.

    Returns
    -------
    result : SearchResult
        The best design and the history.
    report : Path
        The file report.html.

    Raises
    ------
    InputError
        As `blockstat.search` does. Also for an option that does not exist, for a group of the settings that the largest
        design has not, and where Bullet cannot be imported.
    """
    check_strategy(strategy, over, margin, snap, target)
    import_bullet()
    _check_group(space_of(building, names).scene, settings, under)
    memory, jobs = Memory(), jobs_checked(jobs)
    with locked(directory):
        _drop_if_nothing_was_built(directory / "history.csv")
        with (
            shown_search() as progress,
            SpeculativeRuns(partial(verify, settings=settings, gap=gap, statics=True), jobs) as dynamic,
        ):

            def begin(assembly: Assembly, interfaces: Interfaces | None = None) -> None:
                dynamic.begin(assembly, interfaces=interfaces)

            result = search(
                building,
                static=lambda assembly, **worst: assess(assembly, memory=memory, score=False, **worst),
                verify=lambda assembly, interfaces=None: dynamic(assembly, interfaces=interfaces),
                begin=begin if jobs > 1 else None,
                speculative=jobs,
                under=under,
                memory=memory,
                names=names,
                history=directory / "history.csv",
                progress=progress,
                remark=likely_reason,
                conditions=f"{settings} {conditions}" if settings or conditions else "",
                strategy=strategy,
                over=over,
                margin=margin,
                snap=snap,
                points=points,
                imperfections=imperfections,
                target=target,
                gap=gap,
            )
        answered(result)
        figures = write_designs(result, directory, under=under, gap=gap, imperfections=imperfections)
        figures += _moved(result, directory, settings, under, gap)
        given = {"Judged": conditions, "Searched": options}
        notes = [*(f"{done} with {words}." for done, words in given.items() if words), NOTE]
        return result, write_report(result, directory, figures, notes=notes)


def _drop_if_nothing_was_built(history: Path) -> None:
    """Take away a history of errors alone: a corrected scene is another search, and there is nothing to keep."""
    if not history.is_file():
        return
    with history.open(newline="", errors="replace") as file:
        rows = list(csv.DictReader(file))
    if rows and all(row.get("static") == ERROR for row in rows):
        history.unlink()


def _check_group(largest: Scene, settings: Settings | None, under: Callable[[Assembly], Assembly]) -> None:
    """Refuse a group of Eq. 1 that the largest design, in which nothing is left out, has not."""
    if settings is None or settings.group is None:
        return
    try:
        assembly = under(build(largest))
    except InputError:
        return  # its row in the history says why it cannot be built; others may be
    assembly.in_group(settings.group)


@contextmanager
def shown_search() -> Iterator[Callable[[int, int, Candidate], None]]:
    """Show how far a search is on standard error: a bar on a terminal, and elsewhere a line every two seconds.

    Yields
    ------
    callable
        As `progress` of `blockstat.search`.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    def words(last: Candidate) -> str:
        word = f"{last.static} / {last.dynamic}" if last.dynamic else last.note or last.static
        return f"{' '.join(f'{value:g}' for value in last.parameters.values())}: {word}"

    console = Console(stderr=True)
    if not console.is_terminal:
        line = PlainLines()
        yield lambda done, expected, last: line(f"searching: {done} of at most {expected} designs; {words(last)}")
        return
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("searching", total=None)

        def progress(done: int, expected: int, last: Candidate) -> None:
            bar.update(task, completed=done, total=expected, description=words(last))

        yield progress


def _moved(
    result: SearchResult,
    directory: Path,
    settings: Settings | None,
    under: Callable[[Assembly], Assembly],
    gap: float | str,
) -> list[Figure]:
    """Draw the blocks that Bullet saw move: of the thinnest design that statics allow and it does not, or the best."""
    thinnest = min(result.disagreements, key=lambda c: c.volume or 0.0, default=None)
    chosen = result.best_parameters if thinnest is None else thinnest.parameters
    if chosen is None:
        return []
    values = ", ".join(f"{name} {value:g}" for name, value in chosen.items())
    title = fill(f"{'best' if thinnest is None else 'rejected'} design: {values}", TITLE)
    assembly = under(build(with_values(result.building, chosen))).with_(name=title)
    verdict = verify(assembly, settings=settings, gap=gap, statics=True)
    word = "stands in Bullet" if thinnest is None else MOVED[thinnest.dynamic]
    return [Figure(picture_of_run(verdict, directory / "moved.png"), f"The design with {values} {word}.")]


def picture_of_run(verdict: DynamicVerdict, place: Place) -> Place:
    """Draw the last frame of a run, coloured by displacement, with displacements magnified to be seen.

    Parameters
    ----------
    verdict : DynamicVerdict
        Its run is drawn.
    place : path or axes
        Where to.

    Returns
    -------
    path or axes
        The place.
    """
    run = verdict.run
    moved = verdict.displacement
    length = (moved**2).sum(axis=1) ** 0.5
    lower, upper = run.assembly.bounds
    scale = max(1.0, 0.05 * float((upper - lower).max()) / max(float(length.max()), 1e-9))
    scale = min(scale, 1000.0)
    return plot(
        run.assembly, place, values=1e3 * length, label="displacement since release [mm]", displacement=scale * moved,
        title=f"{run.assembly.name}\n{verdict.outcome.word}, displacements x {scale:.0f}",
    )  # fmt: skip
