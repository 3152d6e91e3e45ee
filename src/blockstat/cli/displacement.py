"""Commands beyond the limit load: the capacity curve, settlements, and the code check of a mechanism."""

from __future__ import annotations

import csv
import math
import re
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.cases import (
    Basis,
    Case,
    LoadsFile,
    chosen_case,
    growing_or_held,
    placed_load_and_loads,
    print_answer,
    warn_of_left_out,
)
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
    numbers,
    print_json,
)
from blockstat.cli.options import load as load_assembly
from blockstat.cli.pictures import picture_to_write
from blockstat.cli.places import Film, drawn, file_to_write, written
from blockstat.cli.progress import at_work, shown_progress
from blockstat.errors import InputError, InputWarning

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.large_displacement.capacity_curve import CapacityCurve

#: In units of g: on rock, the map of Italy has less than 0.3 for 475 years, and about twice that for 2475.
MOST_AG = 0.6
G = 9.81  #: [m/s2]
INTERRUPTED = "interrupted"  #: why a path was not followed, where that was the reason
TABLE = ".csv"  #: the suffix of a table of points
Ag = Annotated[float | None, typer.Option(help="Peak ground acceleration asked for at SLV, in units of g.")]
Soil = Annotated[str | None, typer.Option(help="Category of the ground, A to E; A by default.")]
Topography = Annotated[float | None, typer.Option(help="S_T of slopes and ridges; 1 by default.")]
F0 = Annotated[float | None, typer.Option(help="F0 of the spectrum; 2.5 by default.")]
Tc = Annotated[float | None, typer.Option(help="TC* of the spectrum [s]; 0.3 by default.")]
Confidence = Annotated[float | None, typer.Option("--fc", help="Confidence factor FC; 1.35 by default.")]
Behaviour = Annotated[float | None, typer.Option("--q", help="Behaviour factor q; 2 by default.")]


FORM = "NAME:DX,DY,DZ or X0,Y0,Z0,X1,Y1,Z1:DX,DY,DZ"
Moves = Annotated[
    list[str],
    typer.Option(
        metavar="NAME:DX,DY,DZ",
        help="How a part of the supports moves, in metres or as in 0,0,'-10 mm': NAME is a support, a group of "
        "supports, or a block or a group that stands on them; six lengths in its place are a box, which holds "
        "whole joints. "
        "May be given several times.",
    ),
]
Until = Annotated[
    float | None,
    typer.Option(
        metavar="D",
        help="How far the part that moves furthest is followed [m]; 0: only how it begins to move. "
        "By default until collapse, at most by the size of the assembly.",
    ),
]
Picture = Annotated[
    Path | None,
    typer.Option("-o", "--output", callback=picture_to_write, help="Also draw it (.png, .svg, .pdf)."),
]
Steps = Annotated[int, typer.Option(metavar="N", help="About how many points the curve or the path has.")]


def _curve_to_write(path: Path | None) -> Path | None:
    """The path of a picture or of a table; a callback, as `picture_to_write`."""
    return file_to_write(TABLE)(path) if path is not None and path.suffix.lower() == TABLE else picture_to_write(path)


Curve = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", callback=_curve_to_write, help="Also draw it (.png, .svg, .pdf), or write it (.csv)."
    ),
]


def capacity_command(
    file: FileArgument,
    load: Annotated[
        str | None, typer.Option(metavar="AX,AY,AZ", help="Direction of a push on all masses, as strong as gravity.")
    ] = None,
    control: Annotated[
        str | None,
        typer.Option(
            metavar="BLOCK",
            help="Whose displacement along the load is measured: a block, a group, a point of a block as "
            "BLOCK:X,Y,Z [m], or mean, weighted by the load. By default the corner that moves most.",
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
    steps: Steps = 30,
    tolerance: Annotated[float, typer.Option(metavar="T", help="Of the curve between its points.")] = 1e-4,
    output: Curve = None,
    film: Film = None,
    as_json: AsJson = False,
) -> None:
    """Follow the mechanism of a limit load: multiplier against displacement. Interrupted, it keeps what is done."""
    from blockstat.large_displacement.capacity_analysis import capacity
    from blockstat.large_displacement.capacity_curve import CapacityOutcome
    from blockstat.view.settling import film_path, write_path

    film = None if film is None else film_path(film)
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near = gap_of(gap)
    acting = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    growing, permanent = placed_load_and_loads(assembly, load, acting)
    basis = Basis(file, assembly, acting, growing_or_held(load), units, up, near)
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
    with drawn(output=(_write_curve, found, output), film=(write_path, found, film)) as files:
        print_answer(basis, found, as_json=as_json, head=f", {found.timings['total']:.2f} s", files=files)
    if found.outcome is CapacityOutcome.INTERRUPTED:
        raise KeyboardInterrupt  # a part of the curve is missing


def _write_curve(found: CapacityCurve, path: Path) -> None:
    """The curve as a picture, or its points in a table."""
    from blockstat.system.writing import written_whole
    from blockstat.view.settling import plot_capacity

    if path.suffix.lower() != TABLE:
        plot_capacity(found, path)
        return
    with written_whole(path) as place, place.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["displacement [m]", "lower", "upper"])
        table.writerows(zip(found.displacement.tolist(), found.lower.tolist(), found.upper.tolist(), strict=True))


def settle_command(
    file: FileArgument,
    move: Moves,
    case: Case = None,
    loads: LoadsFile = None,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    until: Until = None,
    steps: Steps = 30,
    output: Picture = None,
    film: Film = None,
    as_json: AsJson = False,
) -> None:
    """Let parts of the supports move: what follows, which joints open, the force on them, and when it falls."""
    from blockstat.large_displacement.displaced.structure import why_not_followed
    from blockstat.studies.foundations import settle
    from blockstat.studies.settling_path import PathOutcome, settle_to_collapse
    from blockstat.view.settling import film_path, plot_settlement, write_path

    film = None if film is None else film_path(film)
    moves = _moves(move)
    _check_extent(until, steps)
    near = gap_of(gap)
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    for displacement in moves.values():
        warn_of_far_movement(assembly, "--move", displacement)
    chosen = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    here, moved = (None, None) if chosen is None else (chosen.loads, chosen.placed_loads)
    with at_work(f"settling {assembly.n_blocks:,} blocks") as say:
        found = settle(assembly, moves, loads=here, gap=near)
        reason = "--until 0" if until == 0 else why_not_followed(found.assembly, found.interfaces)
        if reason and film is not None:
            raise InputError(f"--film: {reason}")
        path = None
        if not reason:
            say("following the settlement")
            options = {"loads": moved, "interfaces": found.interfaces, "displacement": until, "steps": steps}
            try:
                path = settle_to_collapse(
                    assembly, moves, progress=lambda there, reaction: say(f"{there:.4g} m: {reaction:.4g} N"), **options
                )
            except KeyboardInterrupt:  # before the first point; what happens at first is known
                reason = INTERRUPTED
            else:  # of motions with the same energy, the one that is followed
                found = replace(found, mechanism=path.first.mechanism)
    basis = Basis(file, assembly, chosen, "act", units, up, near)
    with drawn(output=(plot_settlement, found, output), film=(write_path, path, film if path else None)) as files:
        if as_json:
            further = {"collapse": path and path.collapse, "path": path and path.summary()}
            print_json({"file": str(file), **basis.echo(), **found.summary(), **further, **files})
        else:
            typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks\n{basis.words()}\n{found.explain()}")
            typer.echo(f"Further on. {path.explain()}" if path else f"Not followed further: {reason}.")
            written(files)
    if reason == INTERRUPTED or (path and path.outcome is PathOutcome.INTERRUPTED):
        raise KeyboardInterrupt  # the path, or a part of it, is missing


def _check_extent(until: float | None, steps: int) -> None:
    """Refuse a movement that is none, and no steps."""
    if until is not None and not until >= 0:
        raise InputError(f"--until is {until:g}; it must be a length in metres, or 0")
    if steps < 1:
        raise InputError(f"--steps is {steps}; it must be at least 1")


def warn_of_far_movement(assembly: Assembly, option: str, movement: Sequence[float]) -> None:
    """Warn where supports are to move further than the blocks reach.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    option : str
        Name of the option, for the warning.
    movement : sequence of float, shape (3,)
        The displacement [m].

    Warns
    -----
    InputWarning
        With what to type.
    """
    far, reach = math.hypot(*movement), float((assembly.vertices.max(axis=0) - assembly.vertices.min(axis=0)).max())
    if far > reach:
        text = f"{option} moves supports by {far:,.4g} m, and the blocks reach over {reach:,.4g} m"
        warnings.warn(f'{text}; lengths are metres unless a unit follows, as in "10 mm"', InputWarning, stacklevel=2)


def code_check_command(
    file: FileArgument,
    load: Annotated[str, typer.Option(metavar="AX,AY,AZ", help="Direction of the push on all masses, horizontal.")],
    ag: Ag = None,
    soil: Soil = None,
    topography: Topography = None,
    f0: F0 = None,
    tc: Tc = None,
    confidence: Confidence = None,
    behaviour: Behaviour = None,
    flow: Annotated[str, typer.Option(help="associated, or coulomb: alpha0 without dilatancy.")] = "associated",
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
    """Verify the mechanism of a limit load linearly by Circolare 7/2019, C8.7.1.2.1.

    Loads of a case have no mass: under those that press down no demand is verified as borne. Draw a roof as a block.
    The live loads of a case are left out; loads that act with the earthquake stand under its factors.
    """
    from blockstat.analysis.limit_load import LoadOutcome, limit_load
    from blockstat.code_check.linear import linear_check

    near = gap_of(gap)
    code = code_options(ag, soil, topography, f0, tc, confidence, behaviour)
    direction = numbers(load, 3, "--load", "AX,AY,AZ")
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    acting = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    warn_of_left_out(acting)
    permanent = None if acting is None else acting.weighted_permanent  # what is live may not act in an earthquake
    with shown_progress(kept=False) as progress:
        limit = limit_load(assembly, direction, loads=permanent, flow=flow, gap=near, progress=progress)
    if limit.outcome is LoadOutcome.STOPPED:
        raise KeyboardInterrupt
    found = linear_check(limit, direction, loads=permanent, **code)
    print_answer(Basis(file, assembly, acting, "left_out", units, up, near), found, as_json=as_json)


def code_options(
    ag: float | None,
    soil: str | None,
    topography: float | None,
    f0: float | None,
    tc: float | None,
    confidence: float | None,
    behaviour: float | None,
) -> dict[str, Any]:
    """Return options of `blockstat.linear_check` from those of a command.

    Parameters
    ----------
    ag, soil, topography, f0, tc, confidence, behaviour : float or str, optional
        Values of `--ag`, `--soil`, `--f0`, `--tc`, `--fc` and `--q`; None for the defaults.

    Returns
    -------
    dict
        Keyword arguments.

    Raises
    ------
    InputError
        For a value that cannot be used.

    Warns
    -----
    InputWarning
        Where `--ag` may be in m/s2.
    """
    from blockstat.code_check.spectrum import Site

    if ag is not None and not 0 < ag < 10:
        raise InputError(f"--ag is {ag:g}; it is in units of g, such as 0.15")
    if ag is not None and ag > MOST_AG:
        text = f"--ag is {ag:g} g, more than the hazard maps ask for; it is in units of g: {ag:g} m/s2 are {ag / G:.2g}"
        warnings.warn(text, InputWarning, stacklevel=2)
    given = {"soil": soil, "topography": topography, "f0": f0, "tc_star": tc}
    site = Site(**{name: value for name, value in given.items() if value is not None})
    factors = {"demand": ag, "confidence": confidence, "behaviour": behaviour}
    return {"site": site, **{name: value for name, value in factors.items() if value is not None}}


def _point(control: str | None) -> Any:
    """A control with a point of its block, or as it is: the name of a block may hold a colon."""
    form = "BLOCK, or BLOCK:X,Y,Z"
    block, _, point = (control or "").rpartition(":")
    return (block, numbers(point, 3, "--control", form, given=control)) if block and "," in point else control


def _moves(given: list[str]) -> dict[Any, list[float]]:
    """The displacement of each part."""
    moves = dict(_move(text) for text in given)
    if len(moves) < len(given):
        raise InputError("--move names a part twice; give its whole displacement once")
    return moves


def _move(text: str) -> tuple[Any, list[float]]:
    """The part and the displacement of one --move."""
    where, colon, displacement = text.rpartition(":")
    if not colon or not where:
        raise InputError(f'--move is "{text}"; it must read {FORM}')
    moved = lengths(displacement, 3, "--move", FORM, given=text)
    # Six lengths are a box, and what begins with no number is a name, which may have commas.
    box = "," in where and re.match(r"\s*[-+]?\.?\d", where)
    return (tuple(lengths(where, 6, "--move", FORM, given=text)) if box else where), moved
