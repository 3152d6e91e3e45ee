"""The command `blockstat sequence`: judge a plan, or search one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from blockstat.cli.options import AsJson, FileArgument, Friction, Gap, Supports, Units, gap_of, load, print_json
from blockstat.errors import InputError


def sequence(
    file: FileArgument,
    plan: Annotated[Path | None, typer.Option(help="Judge this plan (.json), step by step.")] = None,
    held_at_most: Annotated[
        int | None, typer.Option(min=1, help="Search a plan in which never more than so many blocks are held.")
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Where to write the plan found.")] = None,
    friction: Friction = None,
    supports: Supports = None,
    units: Units = None,
    gap: Gap = None,
    flow: Annotated[str, typer.Option(help="associated, or coulomb: no dilatancy and no self-stress.")] = "associated",
    reserve: Annotated[
        bool, typer.Option("--reserve", help="Also the least friction at which every step stands.")
    ] = False,
    seconds: Annotated[float | None, typer.Option(help="Stop searching after so long; Ctrl-C does so, too.")] = None,
    insertion: Annotated[
        bool, typer.Option("--insertion", help="Blocks must come in by a straight motion that collides with nothing.")
    ] = False,
    journal: Annotated[
        Path | None, typer.Option(help="Keep each judged state in this file; a search that was ended goes on from it.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Judge the steps in which an assembly is built, or search an order with few held blocks."""
    from blockstat.contact.interfaces import GAP
    from blockstat.sequence.order import find_order
    from blockstat.sequence.plan import assess_plan, read_plan, write_plan

    if (plan is None) == (held_at_most is None):
        raise InputError("give --plan PLAN.json to judge a plan, or --held-at-most K to search one")
    assembly = load(file, friction=friction, gravity=None, tilt=None, supports=supports, units=units)
    options: dict[str, Any] = {"gap": GAP if gap is None else gap_of(gap), "flow": flow}
    if plan is not None:
        result = assess_plan(assembly, read_plan(plan, assembly), reserve=reserve, **options)
        head = {"file": str(file), "verdict": result.outcome.word}
    else:
        assert held_at_most is not None
        result = find_order(
            assembly, held_at_most=held_at_most, seconds=seconds, insertion=insertion, journal=journal, **options
        )
        if output is not None and result.plan is not None:
            named = file.name if file.parent.resolve() == output.parent.resolve() else str(file.resolve())
            write_plan(replace(result.plan, assembly=named), output)
        head = {"file": str(file)}
    if as_json:
        print_json({**head, **result.summary()})
        return
    typer.echo(result.explain())
