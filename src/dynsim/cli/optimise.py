"""The command `dynsim optimise`."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.cases import warn_of_idle_loads
from blockstat.cli.chance import Imperfect, imperfections_of
from blockstat.cli.options import AsJson, Friction, Gap, Gravity, Tilt, gap_of, modified, print_json
from blockstat.errors import InputError
from blockstat.result import finite
from dynsim.cli.criteria import Group, Preset, Threshold, settings_of

if TYPE_CHECKING:
    from blockstat.design_search.search import Margin, SearchResult

Folder = Annotated[Path | None, typer.Option("-o", "--output", help="Directory; out/<name> by default.")]
Moved = Annotated[
    str | None,
    typer.Option("--parameters", metavar="PATH,...", help="Parameters to move, in order; all ranges by default."),
]
Strategy = Annotated[str, typer.Option(help='"paper", "pruned", "gradient", "pareto" or "robust".')]
Over = Annotated[str, typer.Option(help='"line": one parameter after the other; "grid": every combination.')]
Reserve = Annotated[
    str | None,
    typer.Option(metavar="X,Y,Z,LEAST", help='Push in this direction to be carried [g]; not for "paper", "pruned".'),
]
Probability = Annotated[
    float | None,
    typer.Option(help='"robust": stay below this probability of failure; the scene says what is [uncertain].'),
]


def optimise(
    scene: Annotated[Path, typer.Argument(help="Scene file (.toml) with ranges {value, min, max, step}.")],
    output: Folder = None,
    only: Moved = None,
    strategy: Strategy = "pruned",
    over: Over = "line",
    reserve: Reserve = None,
    imperfection: Imperfect = None,
    probability: Probability = None,
    snap: Annotated[bool, typer.Option(help='"gradient": only designs on the steps of the ranges.')] = False,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    gap: Gap = None,
    group: Group = None,
    threshold: Threshold = None,
    preset: Preset = "default",
    jobs: Annotated[int | None, typer.Option(help="Simulations side by side; as many as cores by default.")] = None,
    as_json: AsJson = False,
) -> None:
    """Search for a lighter design that stands: statics prune, Bullet verifies, and a report is written."""
    from blockstat.design_search.search import FailureTarget, space_of
    from blockstat.spec import load_scene
    from dynsim.design_search.optimise import optimise as run

    building, near = load_scene(scene), gap_of(gap)
    directory = output or Path("out") / building.name
    names = only.split(",") if only else None
    space_of(building, names)
    warn_of_idle_loads({"loads": building.loads, "cases": building.cases}, scene, chosen=False)
    if directory.is_file():
        raise InputError(f"output: {directory} is a file; a search writes into a folder")
    directory.mkdir(parents=True, exist_ok=True)
    settings = settings_of(preset, threshold, group)
    conditions = {"friction": friction, "gravity": gravity, "tilt": tilt, "gap": gap}
    others = {
        "strategy": strategy, "over": over, "parameters": only, "snap": snap or None, "reserve": reserve,
        "imperfection": " and ".join(imperfection or ()) or None, "probability": probability, "group": group,
        "threshold": threshold, "preset": preset,
    }  # fmt: skip
    answers: list[SearchResult] = []
    try:
        result, report = run(
            building, directory, names=names, settings=settings, jobs=jobs,
            under=lambda assembly: modified(assembly, friction=friction, gravity=gravity, tilt=tilt),
            conditions=_told(conditions), options=_told(others), strategy=strategy, over=over,
            margin=_margin(reserve) if reserve is not None else None, snap=snap,
            imperfections=imperfections_of(imperfection),
            target=None if probability is None else FailureTarget(probability), gap=near, answered=answers.append,
        )  # fmt: skip
    except KeyboardInterrupt:
        for answer in answers:  # while the report was drawn
            _print_result(answer, None, as_json)
        raise
    _print_result(result, report, as_json)
    if not result.finished:
        raise KeyboardInterrupt
    if result.best is None and any(candidate.failed for candidate in result.history):
        raise InputError(result.none_stood)


def _told(given: dict[str, Any]) -> str:
    """Options and their values in words."""
    return ", ".join(f"{name} {value}" for name, value in given.items() if value is not None)


def _print_result(result: SearchResult, report: Path | None, as_json: bool) -> None:
    """Print the best design and where its report is, if it was written, or all of the history as JSON."""
    from blockstat.design_search.candidate import failures

    if as_json:
        print_json(
            {
                "outcome": result.outcome.word,
                "sentence": result.outcome.value,
                "best": result.best_parameters,
                "unexamined": finite(result.unexamined),
                "undecided": result.undecided,
                "finished": result.finished,
                "history": [asdict(candidate) for candidate in result.history],
                "front": [asdict(candidate) for candidate in result.front],
                "static_solves": result.static_solves,
                "certificates_reused": result.certificates_reused,
                "dynamic_runs": result.dynamic_runs,
                "failure": result.summary()["failure"],
                "report": report and str(report),
            }
        )
    else:
        best = result.best_parameters
        words = (
            ", ".join(f"{k} = {v:g}" for k, v in best.items())
            if best
            else result.none_stood
            if result.finished
            else "none so far"
        )
        if report is None or not result.finished:
            when = " while the report was drawn" if result.finished else ""
            typer.echo(f"interrupted{when}: the same command goes on from here")
        if failed := failures(asdict(candidate) for candidate in result.history):
            typer.echo(failed)
        if told := result.at_ends:
            typer.echo(told)
        typer.echo(f"best: {words}\nreport: {report or 'not written'}")


def _margin(text: str) -> Margin:
    from blockstat.design_search.search import Margin

    try:
        x, y, z, least = (float(number) for number in text.split(","))
    except ValueError:
        raise InputError(f'--reserve is "{text}"; it must be X,Y,Z,LEAST such as 0,1,0,0.05') from None
    return Margin((x, y, z), least)
