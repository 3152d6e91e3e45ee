"""The command `dynsim`: verify, shake, limit, compare; the others have modules of their own."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from blockstat.cli.cases import (
    Case,
    LoadsFile,
    chosen_case,
    growing_or_held,
    load_and_loads,
    loads_echoed,
    loads_said,
    warn_of_idle_loads,
)
from blockstat.cli.displacement import warn_of_far_movement
from blockstat.cli.options import (
    AsJson,
    FileArgument,
    Friction,
    Gap,
    Gravity,
    MostBlocks,
    Supports,
    Tilt,
    Units,
    Up,
    Version,
    gap_of,
    load,
    print_json,
    run_app,
)
from blockstat.cli.places import drawn, file_to_write, keep_places
from blockstat.cli.progress import at_work
from blockstat.errors import InputError
from dynsim.cli.bonds import AngularStiffness, Glue, ScaleInertia, stiffness_of, with_glue
from dynsim.cli.criteria import Engine, Group, Preset, Threshold, settings_of
from dynsim.cli.ida import ida
from dynsim.cli.loads import (
    DIRECTION,
    SCALE,
    Direction,
    Film,
    Jobs,
    Output,
    PulseText,
    Pushed,
    RampText,
    RecordFile,
    Remove,
    Scale,
    Settle,
    TiltTo,
    Timeout,
    ground_of,
    loads_of,
)
from dynsim.cli.optimise import optimise
from dynsim.cli.page import open_page
from dynsim.cli.progress import shown
from dynsim.cli.report import report
from dynsim.cli.rows import end_of, print_comparisons, side_by_side, told_apart, verify_summary
from dynsim.cli.sequence import sequence

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.loading.cases import LoadCase
    from dynsim.comparison.table import Comparison
    from dynsim.judge.verdict import DynamicVerdict
    from dynsim.parallel.pool import Row

app = typer.Typer(
    no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None
)  # plain help: markup would swallow units and table names in brackets
app.command("app")(open_page)


@app.callback()
def about(version: Version = False, most_blocks: MostBlocks = None) -> None:
    """Dynamics of masonry in Bullet or LMGC90: verdicts, limits, comparisons, design search."""


@app.command()
def verify(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", readable=False, help="Assemblies or scenes.")],
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    group: Group = None,
    threshold: Threshold = None,
    remove: Remove = None,
    settle: Settle = None,
    push: Pushed = None,
    tilt_to: TiltTo = None,
    case: Case = None,
    loads_file: LoadsFile = None,
    glue: Glue = None,
    inertia_scale: ScaleInertia = None,
    angular_stiffness: AngularStiffness = None,
    engine: Engine = "bullet",
    preset: Preset = "default",
    output: Output = None,
    film: Film = None,
    jobs: Jobs = None,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Simulate assemblies, several files side by side, and evaluate them by displacement.

    Eq. 1 and Eq. 2 of Fita et al. 2017 are the descent of a group and the largest descent of a block.
    """
    from dynsim.judge.verify import verify as run
    from dynsim.loads.load import as_loads

    def read(file: Path) -> Assembly:
        assembly = load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
        for acts in loads:
            warn_of_far_movement(assembly, "--settle", [acts.travel])
        if case is None and loads_file is None:
            warn_of_idle_loads(assembly.metadata, file)
        return with_glue(assembly, glue)

    settings, near = settings_of(preset, threshold, group), gap_of(gap)
    loads, acting = loads_of(remove, settle, push, tilt_to), None
    if case is not None or loads_file is not None:
        if len(files) > 1:
            raise InputError("--case goes with one file")
        assembly = read(files[0])
        acting = chosen_case(assembly, files[0], case, loads_file, gap=near, tilt=tilt)
        if acting is not None and tilt_to is not None and acting.weight != 1:
            factor = f'the factor {acting.weight:g} on it in case "{acting.name}" would not rotate'
            raise InputError(f"--tilt-to {tilt_to} rotates the weight as drawn; {factor}")
        loads += as_loads(assembly, None if acting is None else acting.loads)
    actions = stiffness_of(inertia_scale, angular_stiffness)
    evaluate = partial(run, settings=settings, loads=loads, actions=actions, gap=near, engine=engine)
    if len(files) == 1 and timeout is None:
        _verify_one(files[0], read(files[0]), evaluate, output, as_json, film, acting)
        return
    if output is not None or film is not None:
        raise InputError("-o writes the run of one file without --timeout")
    rows = side_by_side(files, read, evaluate, jobs, timeout)
    if as_json:
        print_json({"rows": [{"file": str(f), **verify_summary(r)} for f, r in zip(files, rows, strict=True)]})
    else:
        for file, row in zip(files, rows, strict=True):
            words = row.result.outcome.word if row.result is not None else f"no verdict: {row.error}"
            typer.echo(f"{file}: {words}")
    end_of(rows)


def _verify_one(
    file: Path,
    assembly: Assembly,
    evaluate: partial[DynamicVerdict],
    output: Path | None,
    as_json: bool,
    film: float | None,
    case: LoadCase | None = None,
) -> None:
    """One verdict, its run written where that is asked for."""
    from dynsim.view.export import check_path, write_run
    from dynsim.view.film import LONGEST, past_verdict

    if output is not None:
        check_path(output)
    if film is not None and (output is None or not 0 < film <= LONGEST):
        raise InputError(f"--film takes a positive number of seconds, at most {LONGEST:g}, and goes with -o FILE")
    # From the first look on, the run tells how far it is.
    first = f"preparing {assembly.n_blocks:,} blocks (closing joints, cutting concave blocks, settling)"
    with at_work(first) as say:
        verdict = evaluate(assembly, progress=shown(say, assembly.n_blocks, evaluate.keywords["settings"]))

    def write(verdict: DynamicVerdict, path: Path) -> None:
        acting = {name: evaluate.keywords[name] for name in ("loads", "actions", "gap")}
        write_run(verdict.run if film is None else past_verdict(verdict, film, **acting), path)

    with drawn(output=(write, verdict, output)) as files:
        if as_json:
            print_json({"file": str(file), **loads_echoed(case), **verdict.summary(), **files})
            return
        typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks, {verdict.run.process_seconds:.1f} s")
        if case is not None:
            typer.echo(loads_said(case))
        typer.echo(verdict.explain())
        if files:
            typer.echo(f"run: {output}")


@app.command()
def shake(
    file: FileArgument,
    record: RecordFile = None,
    pulse: PulseText = None,
    ramp: RampText = None,
    direction: Direction = DIRECTION,
    scale: Scale = SCALE,
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
    output: Output = None,
    film: Film = None,
    as_json: AsJson = False,
) -> None:
    """Shake the ground by a record, a pulse or a ramp of acceleration, and assess the state afterwards.

    A block falls when it overturns, or moves further than the median size of the blocks or than the threshold, relative
    to the ground.
    """
    from dynsim.judge.verify import verify as run

    motion, near = ground_of(record, pulse, ramp, direction, scale), gap_of(gap)
    assembly = load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    warn_of_idle_loads(assembly.metadata, file, chosen=False)
    settings = settings_of(preset, threshold, group)
    actions = stiffness_of(inertia_scale, angular_stiffness)
    evaluate = partial(run, settings=settings, loads=[motion], actions=actions, gap=near)
    _verify_one(file, with_glue(assembly, glue), evaluate, output, as_json, film)


@app.command()
def limit(
    file: FileArgument,
    direction: Annotated[
        str | None, typer.Option("--load", metavar="X,Y,Z", help="Direction of a push on all masses.")
    ] = None,
    case: Case = None,
    loads_file: LoadsFile = None,
    width: Annotated[float, typer.Option(help="Of the bracket, relative.")] = 0.01,
    check: Annotated[bool, typer.Option(help="Two more runs beside the bracket.")] = True,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    threshold: Threshold = None,
    glue: Glue = None,
    preset: Preset = "default",
    as_json: AsJson = False,
) -> None:
    """Bracket the multiplier of an acceleration, or of the live loads of a case, that moves an assembly in Bullet.

    A block falls when it moves further than the threshold, by default about a thirtieth of the median block size; a run
    ends there. Limits need --preset default or careful: in the coarse steps of fast, joints creep.
    """
    from dynsim.judge.limit import LimitOutcome
    from dynsim.judge.limit import limit as run

    near = gap_of(gap)
    assembly = load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    acting = chosen_case(assembly, file, case, loads_file, gap=near, tilt=tilt)
    growing, permanent = load_and_loads(assembly, direction, acting)
    settings = settings_of(preset, threshold)
    with at_work("static limit") as say:
        found = run(
            with_glue(assembly, glue), growing, loads=permanent, settings=settings, width=width, check=check, gap=near,
            progress=lambda trial: say(f"{trial.multiplier:.5g}: {trial.verdict} (Ctrl-C keeps the bracket)"),
        )  # fmt: skip
    if as_json:
        print_json({"file": str(file), **loads_echoed(acting, growing_or_held(direction)), **found.summary()})
    else:
        typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks, {found.process_seconds:.1f} s")
        if acting is not None:
            typer.echo(loads_said(acting, growing_or_held(direction)))
        typer.echo(found.explain())
    if found.outcome is LimitOutcome.STOPPED and not (isfinite(found.lower) and isfinite(found.upper)):
        raise KeyboardInterrupt  # before there was a bracket


@app.command()
def compare(
    files: Annotated[list[Path], typer.Argument(readable=False, help="Assemblies or scenes.")],
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    engines: Annotated[str, typer.Option(help='"bullet" or "bullet,lmgc90".')] = "bullet",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", callback=file_to_write(".csv"), help="Also write the rows as CSV.")
    ] = None,
    jobs: Jobs = None,
    timeout: Timeout = None,
    as_json: AsJson = False,
) -> None:
    """Compare static and dynamic verdicts, one row a file, several files at a time."""
    from dynsim.comparison.compare import check_engines, compare_one
    from dynsim.comparison.table import Comparison, Comparisons

    def read(file: Path) -> Assembly:
        assembly = load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
        warn_of_idle_loads(assembly.metadata, file, chosen=False)
        return assembly

    evaluate = partial(compare_one, engines=check_engines(engines.split(",")), gap=gap_of(gap))

    def kept(rows: list[Row[Comparison]]) -> Comparisons:
        found = [r.result or Comparison(name=f.stem, note=r.error) for f, r in zip(files, rows, strict=True)]
        return Comparisons(tuple(told_apart(files, found)))

    def save(rows: list[Row[Comparison]]) -> None:
        if output is not None:
            kept(rows).write_csv(output)

    found = side_by_side(files, read, evaluate, jobs, timeout, save=save)
    rows = kept(found)
    if as_json:
        print_json({"rows": [{"file": str(f), **asdict(row)} for f, row in zip(files, rows, strict=True)]})
    else:
        print_comparisons(rows)
    end_of(found)


app.command()(ida)
app.command()(optimise)
app.command()(report)
app.command()(sequence)
keep_places(app)


def main() -> None:
    """Run the command `dynsim`; this is the entry point of the console script."""
    run_app(app, "dynsim")
