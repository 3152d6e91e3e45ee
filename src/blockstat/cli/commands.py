"""The command `blockstat`: build, convert, repair, check, limit, tilt, sequence, plot."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from blockstat.cli.cases import (
    Basis,
    Case,
    LoadsFile,
    cases_command,
    chosen_case,
    growing_or_held,
    load_and_loads,
    print_answer,
)
from blockstat.cli.chance import Imperfect, imperfections_of, reliability_command
from blockstat.cli.displacement import capacity_command, code_check_command, settle_command
from blockstat.cli.examples import example_command
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
    names_in,
    numbers,
    print_json,
    run_app,
    warn_of_odd_numbers,
)
from blockstat.cli.options import load as load_assembly
from blockstat.cli.pictures import app_command, picture_to_write, plot_command
from blockstat.cli.places import drawn, file_to_write, keep_places, written
from blockstat.cli.progress import at_work, shown_progress
from blockstat.cli.sequence import sequence
from blockstat.cli.studies import friction_command, over_the_horizon, prove_command, report_command, tie_command
from blockstat.errors import InputError, check_choice

MOST_TIGHTNESSES = 10_000  #: each is a solve; this many tell a share to a hundredth
Flow = Annotated[str, typer.Option(help="associated, or coulomb: no dilatancy and no self-stress.")]

app = typer.Typer(
    no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None
)  # plain help: markup would swallow units and table names in brackets
app.command("cases")(cases_command)
app.command("capacity")(capacity_command)
app.command("code-check")(code_check_command)
app.command("settle")(settle_command)
app.command("friction")(friction_command)
app.command("tie")(tie_command)
app.command("report")(report_command)
app.command("prove")(prove_command)
app.command("reliability")(reliability_command)


@app.callback()
def about(version: Version = False, most_blocks: MostBlocks = None) -> None:
    """Statics of masonry made of rigid blocks: whether it stands, and which block moves first."""


@app.command()
def build(
    scene: Annotated[Path, typer.Argument(help="Scene file (.toml).")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Where to write (.json, .obj, .glb, .stl, .ply).")],
) -> None:
    """Build the blocks of a scene and write them."""
    from blockstat.io.files import write
    from blockstat.spec import build as build_blocks
    from blockstat.spec import load_scene

    assembly = build_blocks(load_scene(scene))
    write(assembly, output)
    volume = assembly.volume[assembly.free].sum()
    typer.echo(f"{output}: {assembly.n_blocks} blocks, {volume:.4g} m3 of masonry")


@app.command()
def convert(
    file: FileArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Where to write (.json, .obj, .glb, .stl, .ply, or a directory).")
    ],
    format: Annotated[
        str | None,
        typer.Option(help="Of .json: native, compas-assembly or compas-model; of a directory: ply or stl."),
    ] = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
) -> None:
    """Read an assembly or a scene and write it in another format, in metres, z up (in GLB y up).

    --units and --up say what the file that is read is in. Read what is written without them.
    """
    from blockstat.io.files import write

    chosen: dict[str, Any] = {"supports": supports, "units": units, "up": up, "stands": False}
    assembly = load_assembly(file, friction=None, gravity=None, tilt=None, **chosen)
    write(assembly, output, format=format)
    typer.echo(f"{output}: {assembly.n_blocks} blocks, {_written(output, None, None)}")


@app.command("heal", hidden=True)  # the name of this command before it was `repair`
@app.command("repair")
def repair_command(
    context: typer.Context,
    file: FileArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Where to write the repaired blocks.")],
    gap: Annotated[
        float | None, typer.Option(help="Largest gap that is closed, relative to block size; 0 closes none.")
    ] = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
) -> None:
    """Repair rough geometry and print what was changed: merge vertices, turn and flatten faces, close joints.

    --units and --up say what the file is in. The repaired blocks are written in the same units and axes.
    """
    from blockstat.contact.interfaces import GAP
    from blockstat.geometry_repair.repair import repair
    from blockstat.io.files import write

    if context.info_name == "heal":
        typer.echo("blockstat heal is now blockstat repair, and goes with 0.3", err=True)
    chosen = None if supports is None else names_in(supports)
    assembly, report = repair(file, gap=GAP if gap is None else gap, supports=chosen, units=units, up=up)
    warn_of_odd_numbers(assembly, file)
    write(assembly, output, units=units, up=up)
    typer.echo(report.explain())
    typer.echo(f"{output}: {assembly.n_blocks} blocks, {_written(output, units, up)}")


def _written(output: Path, units: str | None, up: str | None) -> str:
    """What the coordinates of a file that was written are in, and the options with which to read it."""
    from blockstat.io.parts import own_up

    asked = [f"--{name} {value}" for name, value in (("units", units), ("up", up)) if value is not None]
    frame = f"in {units or 'm'}, {up or own_up(output.suffix)} up"
    return f"{frame}; read it with {' '.join(asked)}" if asked else frame


@app.command()
def check(
    file: FileArgument,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    solver: Annotated[str, typer.Option(help="auto, interior-point, clarabel or cvxpy (the primal).")] = "auto",
    flow: Flow = "associated",
    tightnesses: Annotated[
        int, typer.Option(metavar="N", help="With --flow coulomb: at how many random tightnesses of the joints too.")
    ] = 0,
    case: Case = None,
    loads: LoadsFile = None,
    imperfection: Imperfect = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            callback=file_to_write(".glb", ".obj", ".json"),
            help="Also write the blocks with displacement and demand (.glb, .obj), or with joints and forces (.json).",
        ),
    ] = None,
    format: Annotated[
        str | None, typer.Option(help="Of -o FILE.json: compas-assembly (default) or compas-model.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Give a static verdict on whether an assembly stands, with its certificate."""
    from blockstat.analysis.assess import assess
    from blockstat.view.attributes import COMPAS_FORMATS, write_verdict

    if format is not None:
        check_choice("--format", format, COMPAS_FORMATS)
        if output is None or output.suffix.lower() != ".json":
            raise InputError("--format goes with -o FILE.json")
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near = gap_of(gap)
    acting = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    permanent = None if acting is None else acting.weighted_loads
    if not 0 <= tightnesses <= MOST_TIGHTNESSES or (tightnesses and flow != "coulomb"):
        asked = f"it must be 0 to {MOST_TIGHTNESSES:,} and goes with --flow coulomb"
        raise InputError(f"--tightnesses is {tightnesses}; {asked}")
    options: dict[str, Any] = {"tightnesses": tightnesses, "imperfections": imperfections_of(imperfection)}
    with at_work(f"judging {assembly.n_blocks:,} blocks"):
        verdict = assess(assembly, gap=near, solver=solver, flow=flow, loads=permanent, **options)
    write = partial(write_verdict, format=format or COMPAS_FORMATS[0])
    basis = Basis(file, assembly, acting, "act", units, up, near)
    with drawn(output=(write, verdict, output)) as files:
        if as_json:
            summary = verdict.summary()
            print_json({"file": str(file), "verdict": summary.pop("outcome"), **basis.echo(), **summary, **files})
            return
        seconds = verdict.timings["total"]
        faces = verdict.interfaces
        typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks, {faces.n_interfaces} interfaces, {seconds:.2f} s")
        typer.echo(basis.words())
        typer.echo(verdict.explain())
        if len(verdict.floating):
            typer.echo("Blocks that nothing holds need joints (`blockstat repair`, --gap) or a support (--supports).")
        elif verdict.outcome.word == "unstable":
            typer.echo(
                "What would make it stand: `blockstat friction`, `blockstat tie`, "
                "and the how-to page on models that fall."
            )
        written(files)


@app.command()
def limit(
    file: FileArgument,
    load: Annotated[
        str | None, typer.Option(metavar="AX,AY,AZ", help="Direction of a push on all masses, as strong as gravity.")
    ] = None,
    directions: Annotated[
        int | None, typer.Option(metavar="N", help="In place of --load: all round the horizon; a multiple of 4.")
    ] = None,
    case: Case = None,
    loads: LoadsFile = None,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    flow: Flow = "associated",
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", callback=picture_to_write, help="Polar plot of the directions (.png, .svg, .pdf)."
        ),
    ] = None,
    tolerance: Annotated[float, typer.Option(metavar="T", help="Width asked of the bracket, relative to it.")] = 1e-4,
    imperfection: Imperfect = None,
    as_json: AsJson = False,
) -> None:
    """Bracket a push on all masses, in one direction or in all, or the live loads of a case.

    Both bounds are proven. With --flow coulomb those without dilatancy are what was found.
    """
    from blockstat.analysis.limit_load import limit_load

    if load is None and directions is None and case is None:
        raise InputError("give --load AX,AY,AZ, --directions N for all of the horizon, or --case NAME with live loads")
    if load is not None and directions is not None:
        raise InputError("--load and --directions are different questions; ask for one of them")
    if output is not None and directions is None:
        raise InputError("-o draws the directions; it goes with --directions")
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near = gap_of(gap)
    if directions is not None and imperfection:
        raise InputError("--imperfection goes with --load or --case")
    acting = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    if directions is not None:
        basis = Basis(file, assembly, acting, "stay", units, up, near)
        over_the_horizon(basis, directions, flow, tolerance, output, as_json)
        return
    growing, permanent = load_and_loads(assembly, load, acting, weighted=True)
    allowed = imperfections_of(imperfection)
    with shown_progress(kept=allowed is None) as progress:
        result = limit_load(
            assembly,
            growing,
            loads=permanent,
            flow=flow,
            gap=near,
            tolerance=tolerance,
            imperfections=allowed,
            progress=progress,
        )
    basis = Basis(file, assembly, acting, growing_or_held(load), units, up, near)
    print_answer(basis, result, as_json=as_json, head=f", {result.timings['total']:.2f} s")


@app.command("tilt")
def tilt_command(
    file: FileArgument,
    axis: Annotated[str, typer.Option(metavar="AXIS", help="x, y, z or three numbers AX,AY,AZ.")],
    case: Case = None,
    loads: LoadsFile = None,
    friction: Friction = None,
    gravity: Gravity = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    imperfection: Imperfect = None,
    flow: Flow = "associated",
    as_json: AsJson = False,
) -> None:
    """Find the angle by which the ground may tilt about an axis before the assembly falls.

    Gravity turns right-handed: about x it pushes towards +y, about y towards -x. Only this sense is tried;
    --axis=-1,0,0 turns it the other way. The loads of a case stay as they are while gravity rotates.
    """
    from math import isnan

    from blockstat.analysis.tilt_friction.tilt import tilt_limit

    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=None, supports=supports, units=units, up=up)
    near = gap_of(gap)
    about = axis if "," not in axis else numbers(axis, 3, "--axis", "x, y, z or AX,AY,AZ")
    acting = chosen_case(assembly, file, case, loads, gap=near, tilt=None)
    options: dict[str, Any] = {"loads": None if acting is None else acting.weighted_loads, "flow": flow, "gap": near}
    with at_work(f"tilting {assembly.n_blocks:,} blocks"):
        found = tilt_limit(assembly, about, imperfections=imperfections_of(imperfection), **options)
    basis = Basis(file, assembly, acting, "act", units, up, near)
    stands, falls = (None if isnan(value) else value for value in (found.stands, found.falls))
    if as_json:
        angles = {"axis": axis, "angle_deg": stands or 0.0, "stands_deg": stands, "falls_deg": falls}
        kinds = {"kinds_deg": found.summary()["kinds"]} if found.kinds else {}
        worst = {"imperfections": found.worst} if found.worst else {}
        told = {"outcome": found.outcome.word, "warnings": list(found.warnings)}
        print_json({"file": str(file), **angles, **kinds, **basis.echo(), **worst, **told})
        return
    typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks, tilted about {axis}")
    typer.echo(f"{basis.words()}\n{found.explain()}")


app.command("app")(app_command)
app.command("example")(example_command)
app.command("plot")(plot_command)
app.command("sequence")(sequence)
keep_places(app)


def main() -> None:
    """Run the command `blockstat`; this is the entry point of the console script."""
    run_app(app, "blockstat")
