"""The command `dynsim ida`: records scaled until a block falls, and the fragility over them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from blockstat.cli.cases import warn_of_idle_loads
from blockstat.cli.options import (
    AsJson,
    FileArgument,
    Friction,
    Gap,
    Gravity,
    Supports,
    Tilt,
    Units,
    Up,
    gap_of,
    load,
    numbers,
    print_json,
)
from blockstat.cli.places import drawn
from blockstat.cli.progress import at_work
from blockstat.errors import InputError
from dynsim.cli.bonds import AngularStiffness, Glue, ScaleInertia, stiffness_of, with_glue
from dynsim.cli.criteria import Group, Preset, Threshold, settings_of
from dynsim.cli.loads import DIRECTION, SCALE, Direction, Jobs, Scale

if TYPE_CHECKING:
    from dynsim.earthquake.runs import ScaledRun
    from dynsim.loads.ground import Record

Records = Annotated[
    list[Path],
    typer.Option("--record", help="CSV of time [s] and one to three accelerations [m/s2]; once for each record."),
]
Kept = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", "--out", metavar="DIR", help="Keep each run here; the same command goes on from it."
    ),
]

GOES_ON = "the same command goes on from here"
NOTHING_KEPT = "nothing is kept; with -o DIR each run is, and the same command goes on from them"


def ida(
    file: FileArgument,
    record: Records,
    direction: Direction = DIRECTION,
    scale: Scale = SCALE,
    measure: Annotated[str, typer.Option(help='Intensity: "pga" [g, 9.81 m/s2] or "pgv" [m/s].')] = "pga",
    start: Annotated[float, typer.Option(help="First intensity.")] = 0.1,
    factor: Annotated[float, typer.Option(help="From one intensity to the next on the way up.")] = 1.25,
    up_to: Annotated[float, typer.Option(help="Greatest intensity.")] = 3.0,
    resolution: Annotated[float, typer.Option(help="Of the collapse intensity, relative.")] = 0.05,
    beyond: Annotated[int, typer.Option(help="Steps above the collapse intensity that are run, too.")] = 2,
    confidence: Annotated[float, typer.Option(help="Of the intervals and the band of the fragility.")] = 0.95,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    group: Group = None,
    threshold: Threshold = None,
    glue: Glue = None,
    inertia_scale: ScaleInertia = None,
    angular_stiffness: AngularStiffness = None,
    preset: Preset = "default",
    jobs: Jobs = None,
    output: Kept = None,
    plot: Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw both curves (.png, .svg).")] = None,
    as_json: AsJson = False,
) -> None:
    """Scale records of ground motion until a block falls, and fit a fragility over them.

    Each record is scaled up by steps until a block overturns, or moves further than the median size of the blocks or
    than the threshold; then the intensity at which it falls is bracketed. Records go side by side in processes.
    """
    from blockstat.view.plot import fresh_figure
    from dynsim.earthquake.analysis import incremental
    from dynsim.view.earthquake import plot_incremental

    if plot is not None:
        fresh_figure(plot)  # before the runs, to say at once that it cannot be written
    near, motions = gap_of(gap), _named(record, direction, scale)
    assembly = load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    warn_of_idle_loads(assembly.metadata, file, chosen=False)
    settings = settings_of(preset, threshold, group)
    with at_work(f"{len(motions)} records, {assembly.n_blocks:,} blocks") as say:
        found = incremental(
            with_glue(assembly, glue), motions, measure=measure, start=start, factor=factor, up_to=up_to,
            resolution=resolution, beyond=beyond, confidence=confidence, settings=settings, gap=near,
            actions=stiffness_of(inertia_scale, angular_stiffness), directory=output, jobs=jobs, progress=_told(say),
        )  # fmt: skip
    picture = plot if any(curve.runs for curve in found.curves) else None
    with drawn(plot=(plot_incremental, found, picture)) as files:
        if as_json:
            print_json({"file": str(file), **found.summary(), **files})
        else:
            seconds = found.process_seconds
            typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks, {seconds:.1f} s\n{found.explain()}")
            if not found.finished:
                typer.echo(f"interrupted: {NOTHING_KEPT if output is None else GOES_ON}")
            if files:
                typer.echo(f"picture: {picture}")
    if not found.finished:
        raise KeyboardInterrupt


def _named(files: list[Path], direction: str, scale: float) -> dict[str, Record]:
    """The records by the names of their files, by their paths where names agree."""
    from dynsim.loads.record import read_record

    count = Counter(file.resolve() for file in files)
    if twice := [file for file in files if count[file.resolve()] > 1]:
        raise InputError(f"--record {twice[-1]} is given twice; a record counts once in a fragility")
    stems = Counter(file.stem for file in files)
    along = numbers(direction, 3, "--direction", "X,Y,Z")
    names = [file.stem if stems[file.stem] == 1 else str(file) for file in files]
    return {name: read_record(f, direction=along, scale=scale) for name, f in zip(names, files, strict=True)}


def _told(say: Callable[[str], None]) -> Callable[[ScaledRun], None]:
    """Say how many runs are done, and what became of the last."""
    done = 0

    def tell(run: ScaledRun) -> None:
        nonlocal done
        done += 1
        say(f"{done} runs, {run.record or 'without a record'} at {run.intensity:.4g}: {run.outcome}")

    return tell
