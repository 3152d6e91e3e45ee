"""The command `blockstat reliability`."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from blockstat.cli.cases import Case, LoadsFile, chosen_case
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
from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.chance.variables import Random

FirstOrder = Annotated[bool, typer.Option("--first-order", help="Find the design point of --load, and draw about it.")]
FORM = (
    "KEY=normal,MEAN,DEVIATION, KEY=lognormal,MEAN,DEVIATION or KEY=uniform,LEAST,GREATEST, KEY one of friction, edge, "
    "push, density.GROUP, loads.GROUP"
)


def reliability_command(
    file: FileArgument,
    uncertain: Annotated[
        list[str],
        typer.Option(metavar="KEY=KIND,A,B", help="What is random, several times: friction=lognormal,0.6,0.1."),
    ],
    draws: Annotated[int, typer.Option(min=1, help="Number of draws.")] = 1000,
    jobs: Annotated[int, typer.Option(min=1, help="Processes side by side.")] = 1,
    seed: Annotated[int, typer.Option(help="Of the random numbers.")] = 0,
    load: Annotated[
        str | None,
        typer.Option(metavar="AX,AY,AZ", help="Acceleration in units of gravity that acts too; push is a factor."),
    ] = None,
    first_order: FirstOrder = False,
    case: Case = None,
    loads: LoadsFile = None,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    as_json: AsJson = False,
) -> None:
    """Estimate the probability that an assembly falls when friction, joints, weights and loads are random."""
    from blockstat.chance.first_order import first_order as design_point
    from blockstat.chance.monte_carlo import reliability
    from blockstat.contact.interfaces import GAP, find_interfaces
    from blockstat.loads import acceleration

    random = _random(uncertain)
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    chosen = chosen_case(assembly, file, case, loads)
    near = GAP if gap is None else gap_of(gap)
    faces = find_interfaces(assembly, gap=near)
    permanent, acting, point = None if chosen is None else chosen.loads, None, None
    if load is not None:
        direction = numbers(load, 3, "--load", "AX,AY,AZ")
        acting = math.hypot(*direction) * acceleration(assembly, direction)
    if first_order:
        if acting is None:
            raise InputError("--first-order asks when a load is not carried; give it by --load AX,AY,AZ")
        point = design_point(assembly, random, acting, loads=permanent, interfaces=faces)
    options = {
        "load": acting,
        "loads": permanent,
        "interfaces": faces,
        "about": point,
        "progress": _progress,
        "jobs": jobs,
    }
    found = reliability(assembly, random, draws=draws, seed=seed, **options)
    if as_json:
        first = {} if point is None else {"first_order": point.summary()}
        print_json({"file": str(file), **inputs(assembly, units=units, gap=near), **found.summary(), **first})
        return
    typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks\n{said(assembly, units=units, gap=near)}")
    if point is not None:
        typer.echo(point.explain())
    typer.echo(found.explain())


def _progress(done: int, draws: int) -> None:
    """Tell how far the draws are, now and then."""
    if done % 100 == 0 or done == draws:
        print(f"{done} of {draws} draws", file=sys.stderr)


def _random(given: list[str]) -> dict[str, Random]:
    """The random variables that the options name."""
    from blockstat.chance.variables import Random

    found = {}
    for text in given:
        key, equals, rest = (part.strip() for part in text.partition("="))
        parts = [part.strip() for part in rest.split(",")]
        if not equals or len(parts) != 3:
            raise InputError(f'--uncertain is "{text}"; it must read {FORM}')
        low, high = numbers(",".join(parts[1:]), 2, "--uncertain", FORM)
        found[key] = Random(parts[0], low, high)
    return found
