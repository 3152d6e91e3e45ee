"""The command `blockstat sequence`: judge a plan, or search one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.options import AsJson, FileArgument, Friction, Gap, Supports, Units, gap_of, load, print_json
from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.result import Result
    from blockstat.sequence.order import OrderResult
    from blockstat.sequence.plan import PlanVerdict

#: Blocks that a line names.
FEW = 5


def sequence(
    file: FileArgument,
    plan: Annotated[Path | None, typer.Option(help="Judge this plan (.json), step by step.")] = None,
    held_at_most: Annotated[
        int | None, typer.Option(min=1, help="Search a plan in which never more than so many blocks are held.")
    ] = None,
    remove: Annotated[
        bool, typer.Option("--remove-each", help="Take out each block in turn: which may go, and what falls with it.")
    ] = False,
    stages: Annotated[
        bool, typer.Option("--stages", help="Judge the stages of the scene file, with the forces of its centrings.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="The plan found (.json), or a picture (.png, .svg, .pdf).")
    ] = None,
    page: Annotated[bool, typer.Option("--page", help="Open the steps of a plan on a page, with a slider.")] = False,
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
    from blockstat.sequence.plan import assess_plan, read_plan
    from blockstat.sequence.stages import assess_stages

    if (plan is not None) + (held_at_most is not None) + remove + stages != 1:
        raise InputError("give one of --plan PLAN.json, --held-at-most K, --remove-each and --stages")
    assembly = load(file, friction=friction, gravity=None, tilt=None, supports=supports, units=units)
    options: dict[str, Any] = {"gap": GAP if gap is None else gap_of(gap), "flow": flow}
    head = {"file": str(file)}
    if remove:
        return _remove_each(assembly, head, output, as_json, options)
    result: Result
    if stages:
        result = assess_stages(assembly, **options)
    elif plan is not None:
        result = judged = assess_plan(assembly, read_plan(plan, assembly), reserve=reserve, **options)
        head["verdict"] = judged.outcome.word
        _show(assembly, judged, output, page)
    else:
        options |= {"held_at_most": held_at_most, "seconds": seconds, "insertion": insertion, "journal": journal}
        result = found = find_order(assembly, **options)
        _write(found, file, output)
    if as_json:
        print_json({**head, **result.summary()})
    else:
        typer.echo(result.explain())


def _write(found: OrderResult, file: Path, output: Path | None) -> None:
    """Write the plan that was found; it names the assembly beside it, or where that is."""
    from blockstat.sequence.plan import write_plan

    if output is not None and found.plan is not None:
        named = file.name if file.parent.resolve() == output.parent.resolve() else str(file.resolve())
        write_plan(replace(found.plan, assembly=named), output)


def _show(assembly: Assembly, judged: PlanVerdict, output: Path | None, page: bool) -> None:
    """Draw the steps of a plan, and serve them until the page is stopped, where these are asked for."""
    from threading import Event

    from blockstat.view.building.slider import StepSlider
    from blockstat.view.building.steps import plot_plan
    from blockstat.view.three_d.page import start_viser, stop_viser

    if output is not None:
        plot_plan(assembly, judged, output)
    if not page:
        return
    server, address = start_viser()
    StepSlider(server, assembly, judged)
    typer.echo(f"{address} (Ctrl-C stops it)", err=True)
    try:
        Event().wait()
    except KeyboardInterrupt:
        stop_viser(server)


def _remove_each(
    assembly: Assembly, head: dict[str, Any], output: Path | None, as_json: bool, options: dict[str, Any]
) -> None:
    """Which blocks may be taken out now, as a list and as a map."""
    from blockstat.sequence.props import remove_each
    from blockstat.view.building.removal import plot_removal

    found = remove_each(assembly, **options)
    if output is not None:
        plot_removal(assembly, found, output)
    words = {name: verdict.outcome.word for name, verdict in found.items()}
    moving = {name: [assembly.names[k] for k in found[name].moving] for name in found if words[name] != "stable"}
    if as_json:
        print_json({**head, "removed": words, "moving": moving})
        return
    may_go = [name for name, word in words.items() if word == "stable"]
    typer.echo(f"{len(may_go)} of {len(words)} blocks may be taken out now.")
    for name, others in moving.items():
        more = " ..." if len(others) > FEW else ""
        typer.echo(f"{name}: {words[name]}; first to move: {', '.join(others[:FEW])}{more}")
