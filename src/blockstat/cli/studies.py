"""Commands beside the verdict: the limit load over the horizon, the report, proof files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.cases import (
    Basis,
    Case,
    LoadsFile,
    all_cases,
    bracket,
    case_answers,
    case_warnings,
    chosen_case,
    growing_or_held,
    load_and_loads,
    loads_echoed,
    loads_said,
    print_answer,
    warn_of_idle_loads,
    warn_of_left_out,
    warn_of_no_mass,
)
from blockstat.cli.displacement import F0, Ag, Behaviour, Confidence, Soil, Tc, Topography, code_options
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
    lengths,
    names_in,
    print_json,
    source_of,
    told,
)
from blockstat.cli.options import load as load_assembly
from blockstat.cli.places import drawn, file_to_write
from blockstat.cli.progress import at_work
from blockstat.errors import InputError
from blockstat.system.writing import written_whole

if TYPE_CHECKING:
    from blockstat.analysis.limit_load import LimitLoad
    from blockstat.assembly import Assembly

Page = Annotated[
    Path,
    typer.Option(
        "-o",
        "--output",
        callback=file_to_write(".html", ".htm"),
        help="The page to write (.html); a browser prints it as PDF.",
    ),
]

#: What is said of a file with a tie whose strength no option gives.
ENDLESS = (
    "the tie in {} has no greatest force, so a limit load of that file counts on any pull; write its strength as "
    '"greatest" [N]'
)


def over_the_horizon(
    basis: Basis, directions: int, flow: str, tolerance: float, output: Path | None, as_json: bool
) -> None:
    """Print the limit loads all round, and draw them where that is asked for.

    Parameters
    ----------
    basis : Basis
        The blocks, and the loads that stay.
    directions : int
        How many directions.
    flow : str
        "associated" or "coulomb".
    tolerance : float
        Width asked of each bracket, relative to it.
    output : Path or None
        Where the polar plot goes; where there is no limit, none is drawn, and standard error says so.
    as_json : bool
        Print JSON.
    """
    from blockstat.studies.directions import limit_load_by_direction
    from blockstat.view.polar import plot_directions

    assembly, acting = basis.assembly, basis.case
    warn_of_no_mass(assembly, acting)
    with at_work("limit loads over the horizon") as say:

        def progress(done: int, name: str, found: LimitLoad) -> None:
            say(f"{done} of at least {directions} directions, {found.upper:.4g} towards {name} (Ctrl-C keeps them)")

        options: dict[str, Any] = {"flow": flow, "gap": basis.gap, "tolerance": tolerance}
        options["loads"] = None if acting is None else acting.loads
        found = limit_load_by_direction(assembly, directions, progress=progress, **options)
    if output is not None and not found.has_limits:
        typer.echo(f"{output}: not written, for there are no limit loads to draw", err=True)
        output = None
    with drawn(output=(plot_directions, found, output)) as files:
        print_answer(basis, found, as_json=as_json, files=files)
    if found.stopped:
        raise KeyboardInterrupt  # some directions are missing


def friction_command(
    file: FileArgument,
    case: Case = None,
    loads: LoadsFile = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    flow: Annotated[str, typer.Option(help="associated, or coulomb: no dilatancy and no self-stress.")] = "associated",
    as_json: AsJson = False,
) -> None:
    """Find the least coefficient of friction with which an assembly stands, whatever its own is."""
    from blockstat.analysis.tilt_friction.friction import friction_limit

    near = gap_of(gap)
    assembly = load_assembly(file, friction=None, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    acting = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    with at_work(f"trying frictions of {assembly.n_blocks:,} blocks"):
        found = friction_limit(assembly, loads=None if acting is None else acting.loads, gap=near, flow=flow)
    print_answer(Basis(file, assembly, acting, "act", units, up, near), found, as_json=as_json)


def tie_command(
    file: FileArgument,
    between: Annotated[str, typer.Option(metavar="A,B", help="The two blocks that the tie pulls together.")],
    points: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z,X,Y,Z",
            help="Where it holds each of them, z up, in metres or with a unit as in '250 mm'; "
            "by default at their centroids.",
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
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            callback=file_to_write(".json"),
            help="Also write the blocks with the tie (.json, in metres, z up).",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find the least and the greatest force of a tie between two blocks with which an assembly stands."""
    import numpy as np

    from blockstat.io.files import write
    from blockstat.joint import Tie
    from blockstat.reinforcement.ties import tie_range

    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near, form = gap_of(gap), "X,Y,Z,X,Y,Z"
    names = names_in(between)
    if len(names) != 2:
        raise InputError(f'--between is "{between}"; it must read A,B')
    blocks = assembly.blocks_named(names, "--between").tolist()
    if len(blocks) != 2:
        raise InputError(f'--between is "{between}", of which one is a layer of several blocks; it must read A,B')
    ends = assembly.centroid[blocks] if points is None else np.reshape(lengths(points, 6, "--points", form), (2, 3))
    tie = Tie((names[0], names[1]), (ends[0].tolist(), ends[1].tolist()), name=between)
    tied = assembly.with_(ties=[*assembly.ties, tie])
    acting = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    with at_work(f"tying {assembly.n_blocks:,} blocks"):
        found = tie_range(tied, len(assembly.ties), loads=None if acting is None else acting.loads, gap=near)
    with drawn(output=(write, tied, output)) as files:
        if files and output:
            found = replace(found, warnings=(*found.warnings, ENDLESS.format(output.name)))
        print_answer(Basis(file, assembly, acting, "act", units, up, near), found, as_json=as_json, files=files)


def report_command(
    file: FileArgument,
    output: Page,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    directions: Annotated[int, typer.Option(metavar="N", help="Of the horizon; a multiple of 4.")] = 16,
    case: Case = None,
    loads: LoadsFile = None,
    ag: Ag = None,
    soil: Soil = None,
    topography: Topography = None,
    f0: F0 = None,
    tc: Tc = None,
    confidence: Confidence = None,
    behaviour: Behaviour = None,
) -> None:
    """Write a report to hand over: assumptions, verdicts, the least limit load, pictures, warnings and sources.

    It lists all load cases; with --case all verdicts and limit loads are those under the loads of that case. With --ag
    it has the linear code check of Circolare 7/2019 towards +-x, +-y and the weakest direction, without live loads.
    """
    code = asked_code(ag, soil, topography, f0, tc, confidence, behaviour)
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    acting: dict[str, Any] = {"case": case, "loads": loads, "tilt": tilt}
    options = {"units": units, "up": up, "gap": gap_of(gap), "directions": directions, "code": code}
    write_report(file, assembly, output, **options, **acting)


def asked_code(ag: float | None, *others: Any) -> dict[str, Any] | None:
    """Return the code check that a report is asked for.

    Parameters
    ----------
    ag : float or None
        Value of `--ag`.
    *others : float, str or None
        The others, as `code_options` takes them.

    Returns
    -------
    dict or None
        Options of `blockstat.linear_check`; None without `--ag`.

    Raises
    ------
    InputError
        For others without `--ag`, or a value that cannot be used.
    """
    if ag is None and any(value is not None for value in others):
        raise InputError("--soil, --topography, --f0, --tc, --fc and --q are of the code check, which needs --ag")
    return None if ag is None else code_options(ag, *others)


def write_report(
    file: Path,
    assembly: Assembly,
    output: Path,
    *,
    units: str | None = None,
    up: str | None = None,
    gap: float | str | None = None,
    directions: int = 16,
    verify: Any = None,
    case: str | None = None,
    loads: Path | None = None,
    code: dict[str, Any] | None = None,
    tilt: str | None = None,
) -> None:
    """Assess an assembly and write the page.

    Parameters
    ----------
    file : Path
        The file that was read.
    assembly : Assembly
        Its blocks.
    output : Path
        The page.
    units : str, optional
        Of the file's coordinates; None for metres.
    up : str, optional
        The axis of the file that points up; None for that of its format.
    gap : float or str, optional
        Tolerance of the joint search; None for the default.
    directions : int, optional
        Of the horizon.
    verify : callable, optional
        Simulates the assembly, as `blockstat.assess_fully` calls it.
    case, loads : str and Path, optional
        Values of `--case` and `--loads`.
    code : dict, optional
        As `asked_code` returns it.
    tilt : str, optional
        Value of `--tilt`, which `assembly` has.

    Raises
    ------
    InputError
        For a load case that cannot be used.
    """
    from blockstat.contact.interfaces import GAP
    from blockstat.view.assessment import assess_fully, assessment_html

    near = GAP if gap is None else gap
    cases = all_cases(assembly, file, loads, gap=near, tilt=tilt)
    if case is None:
        warn_of_idle_loads({"cases": {name: {} for name in cases}}, loads or file, listed=True)
    elif case not in cases:
        chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)  # which names those that there are
    chosen = None if case is None else cases[case]
    warn_of_no_mass(assembly, chosen)
    if code is not None:
        warn_of_left_out(chosen)
    with at_work("load cases") as say:
        rows = list(case_answers(assembly, cases, gap=near))
        answers = tuple(
            (row["case"], cases[row["case"]].words, row["verdict"].replace("_", " "), bracket(row)) for row in rows
        )
        say("verdicts and limit loads")
        found = assess_fully(
            assembly, source=source_of(file, up), gap=near, units=units or "m", directions=directions,
            verify=verify, cases=answers, case=chosen, code=code,
        )  # fmt: skip
        say("pictures")
        text = assessment_html(replace(found, told=(*told(), *case_warnings(rows))))
    with written_whole(output) as place:
        place.write_text(text, encoding="utf-8", errors="backslashreplace")
    typer.echo(str(output))


def prove_command(
    file: FileArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", callback=file_to_write(".json"), help="Where to write the proof (.json).")
    ],
    load: Annotated[
        str | None,
        typer.Option(metavar="AX,AY,AZ", help="Prove both bounds of this acceleration, in place of the verdict."),
    ] = None,
    limit: Annotated[bool, typer.Option("--limit", help="Prove both bounds of the live loads of --case.")] = False,
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
    """Write an exact proof of admissible forces, or of a fall, for `python extras/check_proof.py`."""
    from blockstat.proof.proof_file import prove

    if load is not None and limit:
        raise InputError("--load and --limit are different questions; ask for one of them")
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near = gap_of(gap)
    chosen = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    growing, permanent = None, None if chosen is None else chosen.loads
    if load is not None or limit:
        growing, permanent = load_and_loads(assembly, load, chosen)
    live = growing_or_held(load) if load is not None or limit else "act"
    with at_work(f"proving {assembly.n_blocks:,} blocks"):
        proof = prove(assembly, growing, loads=permanent, gap=near)
    proof.write(output)
    if as_json:
        echo = loads_echoed(chosen, live)
        print_json({"file": str(file), "output": str(output), **echo, **proof.summary()})
        return
    typer.echo(f"{output}: {proof.explain()}")
    if chosen is not None:
        typer.echo(loads_said(chosen, live))
