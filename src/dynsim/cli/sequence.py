"""The command `dynsim sequence`: a plan of building carried out in Bullet, beside what the statics say."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.cases import warn_of_idle_loads
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
    print_json,
)
from blockstat.cli.places import drawn
from blockstat.cli.progress import at_work
from blockstat.errors import InputError
from blockstat.system.reading import json_of
from dynsim.cli.criteria import Preset
from dynsim.cli.loads import Output

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from dynsim.comparison.steps import StepComparison
    from dynsim.judge.replay import DynamicSequence


def sequence(
    file: FileArgument,
    plan: Annotated[
        Path | None, typer.Option(help="The plan (.json). Without it FILE is the plan, and names its assembly.")
    ] = None,
    friction: Friction = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    statics: Annotated[
        bool, typer.Option(help="Also judge each step by statics, by Coulomb's where they differ.")
    ] = True,
    preset: Preset = "default",
    output: Output = None,
    as_json: AsJson = False,
) -> None:
    """Carry out a plan of building in Bullet and judge each step by displacement, beside the statics."""
    from blockstat.sequence.plan import read_plan
    from dynsim.judge.replay import STEP
    from dynsim.judge.replay import sequence as run
    from dynsim.settings import Settings
    from dynsim.view.export import check_path, write_run

    near = gap_of(gap)
    if output is not None:
        check_path(output)
    if plan is None:
        file, plan = _assembly_of(file), file
    assembly = load(file, friction=friction, gravity=None, tilt=None, supports=supports, units=units, up=up)
    warn_of_idle_loads(assembly.metadata, file, chosen=False)
    steps = read_plan(plan, assembly)
    settings = Settings.named(preset, **(STEP if preset != "careful" else {}))  # what is asked for with care stays
    with at_work(f"{len(steps.steps)} steps") as say:

        def progress(done: int, number: int) -> None:
            say(f"{done} of {number} steps carried out (Ctrl-C keeps them)")

        found = run(assembly, steps, settings=settings, gap=near, progress=progress)
    summary: dict[str, Any] = {"file": str(file), **found.summary()}
    lines, interrupted = [found.explain()], found.missing > 0
    if statics:
        compared = None if interrupted else _beside(assembly, found, near)
        interrupted = compared is None
        summary["statics"] = compared and compared.summary()
        lines.append("Statics: no answer, interrupted." if compared is None else compared.explain())
    with drawn(output=(write_run, found.run, output)) as files:
        if as_json:
            print_json(summary | files)
        else:
            typer.echo("\n".join(lines + [f"run: {output}"] * len(files)))
    if interrupted:
        raise KeyboardInterrupt


def _beside(assembly: Assembly, found: DynamicSequence, gap: float | str) -> StepComparison | None:
    """What statics say of each step; None where an interrupt came, for the run is known."""
    from dynsim.comparison.steps import compare_steps

    try:
        with at_work(f"statics of {len(found.steps)} steps"):
            return compare_steps(assembly, found, gap=gap)
    except KeyboardInterrupt:
        return None


def _assembly_of(plan: Path) -> Path:
    """The assembly that a plan names, beside it."""
    try:
        named = json_of(plan).get("assembly", "")
    except AttributeError:
        named = ""
    if not named:
        raise InputError(f"{plan}: names no assembly; write `dynsim sequence ASSEMBLY --plan PLAN.json`")
    return plan.parent / str(named)
