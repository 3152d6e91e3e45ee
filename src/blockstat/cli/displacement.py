"""Commands beyond the first motion: the capacity curve."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from blockstat.cli.cases import Case, LoadsFile, chosen_case, load_and_loads
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
    inputs,
    numbers,
    print_json,
    said,
)
from blockstat.cli.options import load as load_assembly
from blockstat.cli.progress import at_work


def capacity_command(
    file: FileArgument,
    load: Annotated[
        str | None, typer.Option(metavar="AX,AY,AZ", help="Direction of the acceleration; 1 is as strong as gravity.")
    ] = None,
    control: Annotated[
        str | None,
        typer.Option(
            metavar="BLOCK",
            help="Whose displacement along the load is measured: a block, a group, a point of a block as "
            "BLOCK:X,Y,Z [m], or mean, weighted by the load. "
            "By default the corner that moves most.",
        ),
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
    flow: Annotated[str, typer.Option(help="coulomb: joints slide without opening; or associated.")] = "coulomb",
    displacement: Annotated[
        float | None, typer.Option(metavar="D", help="Where to stop [m]; by default where the multiplier is zero.")
    ] = None,
    steps: Annotated[int, typer.Option(metavar="N", help="About how many points the curve has.")] = 30,
    tolerance: Annotated[float, typer.Option(metavar="T", help="Of the curve between its points.")] = 1e-4,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Also draw it (.png, .svg, .pdf).")] = None,
    as_json: AsJson = False,
) -> None:
    """Follow the mechanism of a limit load: multiplier against displacement. Interrupted, it keeps what is done."""
    from blockstat.large_displacement.capacity_curve import capacity
    from blockstat.view.settling import plot_capacity

    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near = gap_of(gap)
    growing, permanent = load_and_loads(load, chosen_case(assembly, file, case, loads))
    with at_work("limit load") as say:
        found = capacity(
            assembly,
            growing,
            control=_point(control),
            loads=permanent,
            flow=flow,
            gap=near,
            displacement=displacement,
            steps=steps,
            tolerance=tolerance,
            progress=lambda there, multiplier: say(f"{there:.4g} m: {multiplier:.4g}"),
        )
    if output is not None:
        plot_capacity(found, output)
    if as_json:
        drawn = {} if output is None else {"output": str(output)}
        echo = inputs(assembly, units=units, gap=near) | ({"case": case} if case else {})
        print_json({"file": str(file), **echo, **found.summary(), **drawn})
        return
    typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks, {found.timings['total']:.2f} s")
    typer.echo(f"{said(assembly, units=units, gap=near)}\n{found.explain()}")


def _point(control: str | None) -> Any:
    """A control with a point of its block, or as it is."""
    block, colon, point = (control or "").rpartition(":")
    return (block, numbers(point, 3, "--control", "BLOCK:X,Y,Z")) if colon else control
