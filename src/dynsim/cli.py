"""The command `dynsim`: verify, compare, optimise."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from blockstat.cli_options import (
    PORT,
    AsJson,
    FileArgument,
    Friction,
    Gravity,
    Port,
    Supports,
    Tilt,
    Units,
    load,
    modified,
    print_json,
    run_app,
)
from blockstat.errors import InputError

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)

Group = Annotated[str | None, typer.Option(help='Group of Eq. 1; "vault" if there is one, else everything.')]
Threshold = Annotated[float | None, typer.Option(help="Displacement that counts as falling, in metres.")]


@app.callback()
def about() -> None:
    """Dynamics of masonry in Bullet: does it stay where it is put?"""


@app.command()
def verify(
    file: FileArgument,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    group: Group = None,
    threshold: Threshold = None,
    as_json: AsJson = False,
) -> None:
    """Simulate an assembly and judge it by displacement (Eq. 1, Eq. 2)."""
    from dynsim.settings import Settings
    from dynsim.verify import verify as run

    assembly = load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units)
    settings = Settings(group=group, roof_threshold=threshold, brick_threshold=threshold)
    verdict = run(assembly, settings=settings)
    if as_json:
        print_json({"file": str(file), **verdict.summary()})
        return
    typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks, {verdict.run.process_seconds:.1f} s")
    typer.echo(verdict.explain())


@app.command()
def compare(
    files: Annotated[list[Path], typer.Argument(help="Assemblies or scenes.")],
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Also write the rows as CSV.")] = None,
    as_json: AsJson = False,
) -> None:
    """Static and dynamic verdicts side by side, one row a file."""
    from rich.console import Console

    from dynsim.compare import Comparison, write_csv
    from dynsim.compare import compare as both

    rows = []
    with Console(stderr=True).status("comparing") as status:
        for number, file in enumerate(files):
            status.update(f"{number + 1}/{len(files)} {file.name}")
            try:
                rows.append(
                    both(load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units))
                )
            except InputError as error:
                rows.append(Comparison(name=file.stem, note=str(error)))
            if output is not None:
                write_csv(rows, output)
    if as_json:
        print_json({"rows": [{"file": str(f), **asdict(row)} for f, row in zip(files, rows, strict=True)]})
    else:
        _print_rows(rows)
    if all(row.static is None for row in rows):
        raise InputError("none of the files gave a verdict")


def _print_rows(rows: list) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(
        "name",
        "blocks",
        "faces",
        "static",
        "score",
        "s",
        "dynamic",
        "Eq. 1 mm",
        "Eq. 2 mm",
        "moved mm",
        "s",
        "agree",
    )
    for row in rows:
        if row.static is None:
            table.add_row(row.name, "", "", "no verdict")
            continue
        drops = [f"{1e3 * value:.3g}" for value in (row.group_drop, row.max_drop, row.max_displacement)]
        score = "inf" if row.score is None else f"{row.score:.2e}"
        agree = {True: "yes", False: "NO", None: "-"}[row.agree]
        table.add_row(
            row.name, str(row.blocks), str(row.interfaces), row.static, score, f"{row.static_seconds:.2f}",
            row.dynamic, *drops, f"{row.dynamic_seconds:.1f}", agree,
        )  # fmt: skip
    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    console.print(table)
    for row in rows:
        if row.note:
            console.print(f"{row.name}: {row.note}", highlight=False, markup=False, soft_wrap=True)


@app.command()
def optimise(
    scene: Annotated[Path, typer.Argument(help="Scene file (.toml) with ranges {value, min, max, step}.")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Directory; out/<name> by default.")] = None,
    only: Annotated[
        str | None,
        typer.Option("--parameters", metavar="PATH,...", help="Parameters to move, in order; all ranges by default."),
    ] = None,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    group: Group = None,
    threshold: Threshold = None,
    as_json: AsJson = False,
) -> None:
    """Thin a building down: statics prune, Bullet verifies, a report tells."""
    from blockstat.io.scene import load_scene
    from blockstat.search import check_names
    from dynsim.optimise import optimise as run
    from dynsim.settings import Settings

    building = load_scene(scene)
    directory = output or Path("out") / building.name
    names = only.split(",") if only else None
    check_names(building, names)
    directory.mkdir(parents=True, exist_ok=True)
    settings = Settings(group=group, roof_threshold=threshold, brick_threshold=threshold)
    given = {"friction": friction, "gravity": gravity, "tilt": tilt}
    result, report = run(
        building,
        directory,
        names=names,
        settings=settings,
        under=lambda assembly: modified(assembly, friction=friction, gravity=gravity, tilt=tilt),
        conditions=", ".join(f"{name} {value}" for name, value in given.items() if value is not None),
    )
    if as_json:
        print_json(
            {
                "best": result.best_parameters,
                "finished": result.finished,
                "history": [asdict(candidate) for candidate in result.history],
                "report": str(report),
            }
        )
    else:
        best = result.best_parameters
        words = ", ".join(f"{k} = {v:g}" for k, v in best.items()) if best else "no design stood"
        typer.echo(f"best: {words}\nreport: {report}")
    if not result.finished:
        raise KeyboardInterrupt


@app.command("app")
def app_command(file: FileArgument, supports: Supports = None, port: Port = PORT) -> None:
    """Open the live page with Bullet: "Let it fall" and "Optimise" beside the static verdict."""
    from blockstat.app.server import serve
    from dynsim.panel import FallPanel, OptimisePanel

    serve(file, supports=supports or "", port=port, panels=[FallPanel(), OptimisePanel()])


def main() -> None:
    """Entry point of the console script."""
    run_app(app, "dynsim")
