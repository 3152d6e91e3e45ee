"""Commands that show: the live page and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.cli.cases import warn_of_idle_loads
from blockstat.cli.options import (
    PORT,
    FileArgument,
    Folder,
    Friction,
    Gap,
    Gravity,
    MostGigabytes,
    MostSeconds,
    Port,
    Supports,
    Tilt,
    Units,
    Up,
    gap_of,
    numbers,
)
from blockstat.cli.options import load as load_assembly
from blockstat.cli.places import check_place
from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.analysis.limit_load import LimitLoad
    from blockstat.assembly import Assembly

Reserve = Annotated[
    str | None,
    typer.Option(metavar="WHAT", help="What the limit hangs on most: edge, friction or corner; needs --load."),
]


def picture_to_write(path: Path | None) -> Path | None:
    """Return the path that an option gives for a picture; a callback, as that of `file_to_write`.

    Parameters
    ----------
    path : Path or None
        The file.

    Returns
    -------
    Path or None
        The same.

    Raises
    ------
    InputError
        For a file that cannot be written, or a suffix that is no picture's.
    """
    if path is not None:
        from blockstat.view.plot import fresh_figure

        check_place(path)
        fresh_figure(path)
    return path


def app_command(
    file: FileArgument,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    port: Port = PORT,
    folder: Folder = None,
    most_seconds: MostSeconds = 300.0,
    most_gigabytes: MostGigabytes = 4.0,
) -> None:
    """Open the live page: move a parameter and see the verdict change, in the browser, on this machine only."""
    from blockstat.app.background import Limits
    from blockstat.app.capacity_tab.panel import CapacityPanel
    from blockstat.app.server import serve

    serve(
        file,
        supports=supports or "",
        units=units,
        up=up,
        gap=gap,
        port=port,
        panels=[CapacityPanel()],
        folder=folder,
        limits=Limits(most_seconds, most_gigabytes),
    )


def plot_command(
    file: FileArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Picture to write (.png, .svg, .pdf, with --mechanism .glb).")
    ],
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    plain: Annotated[bool, typer.Option("--plain", help="Only the blocks, no verdict.")] = False,
    forces: Annotated[bool, typer.Option("--forces", help="The forces of the joints instead.")] = False,
    joints: Annotated[bool, typer.Option("--joints", help="How much of each joint's capacity is used.")] = False,
    mechanism: Annotated[
        bool, typer.Option("--mechanism", help="The mechanism and a ghost; -o FILE.glb for an animation.")
    ] = False,
    stone: Annotated[bool, typer.Option("--stone", help="Where a stone more helps most; needs --load.")] = False,
    reserve: Reserve = None,
    load: Annotated[
        str | None,
        typer.Option(metavar="AX,AY,AZ", help="With --mechanism, --stone or --reserve: of this limit load."),
    ] = None,
    view: Annotated[str, typer.Option(metavar="AZIMUTH,ELEVATION", help="Where to look from, in degrees.")] = "-55,25",
) -> None:
    """Draw the blocks, coloured by the static verdict or as the options ask."""
    from blockstat.analysis.assess import assess
    from blockstat.analysis.limit_load import limit_load
    from blockstat.view.plot import plot, plot_forces, plot_stone_sensitivity, plot_verdict
    from blockstat.view.utilisation import plot_utilisation

    azimuth, elevation = numbers(view, 2, "--view", "AZIMUTH,ELEVATION")
    look: dict[str, Any] = {"azimuth": azimuth, "elevation": elevation}
    choices = {"--plain": plain, "--forces": forces, "--joints": joints, "--mechanism": mechanism, "--stone": stone}
    asked = _one_of(choices | {"--reserve": reserve is not None})
    if load is not None and not (mechanism or stone or reserve):
        raise InputError("--load goes with --mechanism, --stone or --reserve")
    if (stone or reserve) and load is None:
        raise InputError(f"{asked} asks what raises a limit load; give its direction by --load AX,AY,AZ")
    direction = None if load is None else numbers(load, 3, "--load", "AX,AY,AZ")
    (check_place if mechanism and output.suffix.lower() == ".glb" else picture_to_write)(output)
    read: dict[str, Any] = {"supports": supports, "units": units, "up": up, "stands": not plain}
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, **read)
    near = gap_of(gap)
    warn_of_idle_loads({} if plain else assembly.metadata, file, chosen=False)
    if plain:
        plot(assembly, output, title=assembly.name, **look)
    elif stone and direction is not None:
        limit = limit_load(assembly, direction, gap=near, optimum=True)
        plot_stone_sensitivity(limit, direction, output, **look)
    elif reserve is not None and direction is not None:
        _plot_reserve(limit_load(assembly, direction, gap=near, optimum=True), direction, reserve, output, look)
    elif mechanism:
        _plot_mechanism(assembly, direction, near, output, look)
    else:
        draw = plot_forces if forces else plot_utilisation if joints else plot_verdict
        draw(assess(assembly, gap=near), output, **look)
    typer.echo(str(output))


def _one_of(choices: dict[str, bool]) -> str:
    """The picture that is asked for, "" for none."""
    asked = [name for name, on in choices.items() if on]
    if len(asked) > 1:
        raise InputError(f"{' and '.join(asked)} are different pictures; ask for one of them")
    return "".join(asked)


def _plot_reserve(limit: LimitLoad, direction: list[float], what: str, output: Path, look: dict[str, Any]) -> None:
    """What a limit load hangs on, as a picture, and the most of it in words."""
    from blockstat.errors import check_choice
    from blockstat.sensitivity.reserve import reserve_map
    from blockstat.view.utilisation import LABELS, plot_reserve_map

    check_choice("--reserve", what, tuple(LABELS))
    found = reserve_map(limit, direction, corners=what == "corner")
    plot_reserve_map(found, what, output, **look)
    label, step = LABELS[what]
    typer.echo(f"limit {found.value:.6g}; {label}:")
    for name, value in found.most(what):
        typer.echo(f"{step * value:+.3g}  {name}")


def _plot_mechanism(
    assembly: Assembly, direction: list[float] | None, gap: float | str, output: Path, look: dict[str, Any]
) -> None:
    """The mechanism of the verdict, or with a load that of its limit, as a picture or as an animation."""
    from blockstat.analysis.assess import assess
    from blockstat.analysis.limit_load import limit_load
    from blockstat.view.animation import write_mechanism
    from blockstat.view.plot import plot_mechanism

    if direction is None:
        result = assess(assembly, gap=gap)
        if not result.mechanism.any():
            raise InputError(
                f"{assembly.name} is {result.outcome.word} and has no mechanism; "
                "give --load AX,AY,AZ for that of its limit load"
            )
    else:
        result = limit_load(assembly, direction, gap=gap)
    if output.suffix.lower() == ".glb":
        write_mechanism(result, output)
    else:
        plot_mechanism(result, output, **look)
