"""The command `blockstat sequence`: judge a plan, or search one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.cases import warn_of_idle_loads
from blockstat.cli.chance import once
from blockstat.cli.options import (
    AsJson,
    FileArgument,
    Friction,
    Gap,
    Supports,
    Units,
    Up,
    gap_of,
    load,
    numbers,
    print_json,
)
from blockstat.cli.places import check_place, drawn, written
from blockstat.cli.progress import at_work
from blockstat.errors import InputError
from blockstat.result import listed

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.result import Result
    from blockstat.sequence.courses import Along, CoursesResult
    from blockstat.sequence.order import OrderResult, SafestOrder
    from blockstat.sequence.plan import PlanVerdict
    from blockstat.sequence.stages import StagesVerdict

#: Blocks that a line names.
FEW = 5
#: The questions, and the options that each takes beside those of the blocks and of the answer.
TAKES = {
    "--plan": ("--output", "--page", "--flow", "--reserve", "--tilt"),
    "--held-at-most": ("--output", "--flow", "--reserve", "--seconds", "--insertion", "--journal"),
    "--courses": ("--along", "--output", "--flow", "--seconds", "--journal"),
    "--remove-each": ("--output", "--flow"),
    "--stages": ("--flow",),
}

PlanFile = Annotated[Path | None, typer.Option("--plan", help="Judge this plan (.json), step by step.")]
HeldAtMost = Annotated[
    int | None, typer.Option(min=1, help="Search a plan in which never more than so many blocks are held.")
]
Remove = Annotated[
    bool, typer.Option("--remove-each", help="Take out each block in turn: which may go, and what falls with it.")
]
Stages = Annotated[
    bool, typer.Option("--stages", help="Judge the stages of the scene file, with the forces of its centrings.")
]
Courses = Annotated[bool, typer.Option("--courses", help="Build by courses: how few blocks must be held after each.")]
Directions = Annotated[
    list[str] | None,
    typer.Option(help="X,Y,Z in which courses follow each other, or GROUP=X,Y,Z, repeated in the order of building."),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", help="The plan found (.json), or of a plan a picture (.png, .svg, .pdf) or film (.glb)."
    ),
]
Page = Annotated[bool, typer.Option("--page", help="Open the steps of a plan on a page, with a slider.")]
Flow = Annotated[str, typer.Option(help="associated, or coulomb: no dilatancy and no self-stress.")]
Reserve = Annotated[
    bool,
    typer.Option(
        "--reserve", help="The least friction at which every step stands; of a search, the order with the least."
    ),
]
Tilt = Annotated[bool, typer.Option("--tilt", help="Also how far the ground may tilt at each step of a plan.")]
Seconds = Annotated[float | None, typer.Option(help="Stop searching after so long; Ctrl-C does so, too.")]
Insertion = Annotated[
    bool, typer.Option("--insertion", help="Blocks must come in by a straight motion that collides with nothing.")
]
JournalFile = Annotated[
    Path | None, typer.Option(help="Keep each judged state in this file; a search that was ended goes on from it.")
]


def sequence(
    context: typer.Context,
    file: FileArgument,
    plan: PlanFile = None,
    held_at_most: HeldAtMost = None,
    remove: Remove = False,
    stages: Stages = False,
    courses: Courses = False,
    along: Directions = None,
    output: Output = None,
    page: Page = False,
    friction: Friction = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    flow: Flow = "associated",
    reserve: Reserve = False,
    tilt: Tilt = False,
    seconds: Seconds = None,
    insertion: Insertion = False,
    journal: JournalFile = None,
    as_json: AsJson = False,
) -> None:
    """Judge the steps in which an assembly is built, or search an order with few held blocks."""
    from blockstat.io.files import blaming
    from blockstat.sequence.courses import CoursesResult, build_by_courses
    from blockstat.sequence.order import OrderResult, SafestOrder, find_order
    from blockstat.sequence.plan import PlanVerdict
    from blockstat.sequence.stages import assess_stages

    _refuse_unheeded(context)
    assembly = load(file, friction=friction, gravity=None, tilt=None, supports=supports, units=units, up=up)
    warn_of_idle_loads(assembly.metadata, file, chosen=False)
    options: dict[str, Any] = {"gap": gap_of(gap), "flow": flow}
    searched: dict[str, Any] = {"held_at_most": held_at_most, "seconds": seconds, "insertion": insertion}
    head = {"file": str(file)}
    if remove:
        return _remove_each(assembly, head, output, as_json, options)
    result: Result
    if stages:
        with _counted("stages and courses judged") as progress:
            result = blaming(file, lambda: assess_stages(assembly, progress=progress, **options))
    elif plan is not None:
        result = judged = _judged(assembly, plan, reserve=reserve, tilt=tilt, **options)
        head["verdict"] = judged.outcome.word
    elif courses:
        _refuse_flow(flow)
        limits: dict[str, Any] = {"gap": options["gap"], "seconds": seconds, "journal": journal}
        result = build_by_courses(assembly, along=_along(along), **limits)
    elif reserve:
        result = _safest(assembly, flow, journal, gap=options["gap"], **searched)
    else:
        result = find_order(assembly, journal=journal, **options, **searched)
    found = result.found if isinstance(result, SafestOrder) else result
    _answer(assembly, file, result, found, head, output, as_json)
    if isinstance(found, (OrderResult, CoursesResult)):
        _end_without_plan(found, output)
        return
    _end_unfinished(found, reserve)
    if page and isinstance(found, PlanVerdict):
        _show(assembly, found)


def _refuse_unheeded(context: typer.Context) -> None:
    """Refuse all but one question, and options that another question takes."""
    sources = {own.opts[-1]: context.get_parameter_source(own.name or "") for own in context.command.params}
    given = [option for option, source in sources.items() if source is not None and source.name == "COMMANDLINE"]
    asked = [option for option in given if option in TAKES]
    if len(asked) != 1:
        raise InputError("give one of --plan PLAN.json, --held-at-most K, --courses, --remove-each and --stages")
    known = {option for taken in TAKES.values() for option in taken}
    if refused := [option for option in given if option in known and option not in TAKES[asked[0]]]:
        raise InputError(f"{asked[0]} takes {', '.join(TAKES[asked[0]])}, not {', '.join(refused)}")
    _check_output(asked[0], context.params["output"])


def _check_output(asked: str, output: Path | None) -> None:
    """Refuse a file that the answer cannot be written to: the plan that is searched, or a picture of what is given."""
    from blockstat.view.plot import fresh_figure
    from blockstat.view.settling import film_path

    if output is None:
        return
    if asked == "--plan":
        film_path(output)
    elif asked == "--remove-each":
        fresh_figure(output)
    else:
        check_place(output, ".json")


def _safest(assembly: Assembly, flow: str, journal: Path | None, **options: Any) -> SafestOrder:
    """The order with the largest reserve of friction."""
    from blockstat.sequence.order import safest_order

    if flow != "associated" or journal is not None:
        raise InputError("--held-at-most with --reserve takes neither --flow coulomb nor --journal")
    return safest_order(assembly, **options)


def _judged(assembly: Assembly, plan: Path, *, reserve: bool, tilt: bool, **options: Any) -> PlanVerdict:
    """The verdict on each step of a plan."""
    from blockstat.sequence.plan import assess_plan, read_plan

    _refuse_flow_beside(options["flow"], reserve=reserve, tilt=tilt)
    steps = read_plan(plan, assembly)
    with _counted("steps judged") as progress:
        return assess_plan(assembly, steps, reserve=reserve, tilt=tilt, progress=progress, **options)


def _refuse_flow_beside(flow: str, **asked: bool) -> None:
    """Refuse what a plan is asked with another flow than the associated one, for it would be answered with that."""
    if flow != "associated" and any(asked.values()):
        options = " and ".join(f"--{name}" for name, given in asked.items() if given)
        raise InputError(f"--plan with {options} does not take --flow {flow}")


def _refuse_flow(flow: str) -> None:
    if flow != "associated":
        raise InputError(f'--courses has flow "associated" alone, not "{flow}"; judge its plan with --plan and --flow')


def _along(given: list[str] | None) -> Along:
    """The directions of courses: one, or one a group."""
    form = "X,Y,Z or GROUP=X,Y,Z"
    split = [text.rpartition("=") for text in given or ()]
    if len(split) > 1 and not all(group for group, _, _ in split):
        raise InputError("--along is given twice; without GROUP= there is one direction for all")
    directions: dict[str, list[float]] = {}
    for text, (group, _, direction) in zip(given or (), split, strict=True):
        once(directions, group, "--along")
        directions[group] = numbers(direction, 3, "--along", form, given=text)
    return directions.get("", directions or None)


def _answer(
    assembly: Assembly, file: Path, result: Result, found: Any, head: dict[str, Any], output: Path | None, as_json: bool
) -> None:
    """Print an answer, and write the plan that was judged or found, if there is one."""
    place = None if getattr(found, "plan", output) is None else output
    with drawn(output=(partial(_write, assembly, file), found, place)) as files:
        if as_json:
            print_json({**head, **result.summary(), **files})
        else:
            typer.echo(result.explain())
            written(files)


def _write(assembly: Assembly, file: Path, found: Any, output: Path) -> None:
    """Draw a plan that was judged, or write one that was found; it names the assembly beside it, or where that is."""
    from blockstat.sequence.plan import PlanVerdict, write_plan
    from blockstat.view.building.film import write_plan_film
    from blockstat.view.building.steps import plot_plan

    if isinstance(found, PlanVerdict):
        (write_plan_film if output.suffix.lower() == ".glb" else plot_plan)(assembly, found, output)
        return
    named = file.name if file.parent.resolve() == output.parent.resolve() else str(file.resolve())
    write_plan(replace(found.plan, assembly=named), output)


@contextmanager
def _counted(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show how many of several are done; the command keeps them when it is interrupted."""
    with at_work(what) as say:
        yield lambda done, number: say(f"{done} of {number} {what} (Ctrl-C keeps them)")


def _end_unfinished(judged: PlanVerdict | StagesVerdict, reserve: bool) -> None:
    """End a command as interrupted where stages or steps are missing, or the least friction that was asked for."""
    if reserve and not judged.missing and getattr(judged, "least_friction", None) is None:
        typer.echo("the least friction at which every step stands was not found", err=True)
        raise KeyboardInterrupt
    if judged.missing:
        raise KeyboardInterrupt


def _end_without_plan(searched: OrderResult | CoursesResult, output: Path | None) -> None:
    """End a search that found no plan, as interrupted or as out of time where that was why; that none is, is an answer.

    Raises
    ------
    InputError
        Where `--seconds` were over: a script that goes on would go on without its plan.
    KeyboardInterrupt
        Where it was interrupted.
    """
    if searched.plan is None and output is not None:
        typer.echo(f"{output}: not written, for no plan was found", err=True)
    if searched.time_limit is not None:
        raise InputError(f"--seconds {searched.time_limit:g}: no plan was found in this time; give it more")
    if searched.outcome.word == "stopped":
        raise KeyboardInterrupt


def _show(assembly: Assembly, judged: PlanVerdict) -> None:
    """Serve the steps of a plan until the page is stopped."""
    from threading import Event

    from blockstat.view.building.slider import StepSlider
    from blockstat.view.three_d.page import start_viser, stop_viser

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
    from blockstat.sequence.taking_down.removal import remove_each
    from blockstat.view.building.removal import plot_removal

    with _counted("blocks taken out") as progress:
        found = remove_each(assembly, progress=progress, **options)
    missing = len(assembly.free) - len(found)
    words = {name: verdict.outcome.word for name, verdict in found.items()}
    others = [name for name in found if words[name] != "stable"]
    falls = {name: found[name].falls for name in others}
    moving = {name: [assembly.names[k] for k in found[name].moving] for name in others}
    with drawn(output=(partial(plot_removal, assembly), found, output)) as files:
        if as_json:
            print_json({**head, "removed": words, "moving": moving, "falls": falls, "missing": missing, **files})
        else:
            _print_removed(words, falls, missing)
            written(files)
    if missing:
        raise KeyboardInterrupt


def _print_removed(words: dict[str, str], falls: dict[str, tuple[str, ...] | None], missing: int) -> None:
    """Print how many blocks may be taken out, and what becomes of the others."""
    if missing:
        typer.echo(f"Stopped: {len(words)} of {len(words) + missing} blocks were taken out in turn.")
    may_go = [name for name, word in words.items() if word == "stable"]
    named = f": {', '.join(may_go)}" if may_go else ""
    typer.echo(f"{len(may_go)} of {len(words)} blocks may be taken out now{named}.")
    for name, others in falls.items():
        what = "which blocks fall is undecided" if others is None else f"falls with it: {listed(others, FEW)}"
        typer.echo(f"{name}: {words[name]}; {what}")
