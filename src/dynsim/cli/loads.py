"""Options of the command line that name loads, and how they are read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from blockstat.cli.options import AXES, lengths, names_in, numbers
from blockstat.errors import InputError, check_count

if TYPE_CHECKING:
    from dynsim.loads.ground import Pulse, Ramp
    from dynsim.loads.load import Load
    from dynsim.loads.record import Record

Remove = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME,...[@SECONDS]", help="Take blocks out, after release at that time; repeatable."),
]
Settle = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME,...:DX,DY,DZ[@SPEED]",
        help="Move supports, by metres or as in 0,0,'-10 mm', at so many metres a second (0.02); repeatable.",
    ),
]
Pushed = Annotated[
    list[str] | None,
    typer.Option("--push", metavar="NAME:VX,VY,VZ[@SECONDS]", help="Give a block a velocity in m/s; repeatable."),
]
TiltTo = Annotated[
    str | None,
    typer.Option(metavar="AXIS,DEGREES[,RATE]", help="Tilt the ground after release, at 1 degree/s by default."),
]


def _some_jobs(jobs: int | None) -> int | None:
    """Refuse fewer processes than one, also where one file is read and there is nothing to share."""
    if jobs is not None:
        check_count("--jobs", jobs)
    return jobs


Jobs = Annotated[int | None, typer.Option(callback=_some_jobs, help="Processes at a time; all cores by default.")]
Timeout = Annotated[float | None, typer.Option(help="Seconds by the clock that one file may take.")]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", help="Write the run: .glb (animation), .gif or .mp4 (film), .npz (data) or .png (film strip)."
    ),
]
Film = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", help="With -o: simulate so long past the verdict, to see a fall; it stays."),
]
RecordFile = Annotated[
    Path | None, typer.Option("--record", help="CSV of time [s] and one to three accelerations [m/s2].")
]
Direction = Annotated[str, typer.Option(metavar="X,Y,Z", help="Of a record with one column of accelerations.")]
Scale = Annotated[float, typer.Option(help="Factor on the accelerations of the record (9.81 for a file in g).")]
PulseText = Annotated[
    str | None,
    typer.Option(
        "--pulse", metavar="AX,AY,AZ,SECONDS[,SHAPE]", help="Pulse: rectangle, half-sine, sine or triangle; m/s2."
    ),
]
RampText = Annotated[
    str | None,
    typer.Option("--ramp", metavar="AX,AY,AZ,SECONDS", help="Acceleration that grows to a value in m/s2 and stays."),
]

SPEED = 0.02  #: [m/s] at which supports settle
DIRECTION, SCALE = "1,0,0", 1.0  #: of a record, unless the user says otherwise


def loads_of(
    remove: list[str] | None, settle: list[str] | None, push: list[str] | None, tilt_to: str | None
) -> list[Load]:
    """Return the loads that options name.

    Parameters
    ----------
    remove, settle, push : list of str or None
        Values of `--remove`, `--settle` and `--push`; None for an option that is not given.
    tilt_to : str or None
        Value of `--tilt-to`; None for an option that is not given.

    Returns
    -------
    list of Load
        One for each value.

    Raises
    ------
    InputError
        Naming the option, for a value that does not read as it must.
    """
    from dynsim.loads.loading import Push, Removal, Settlement, Tilt

    loads: list[Load] = []
    for text in remove or ():
        names, time = _split(text, "@", "--remove", "NAME,...[@SECONDS]", 0.0, text)
        loads.append(Removal(names_in(names), time))
    for text in settle or ():
        form = "NAME,...:DX,DY,DZ[@SPEED]"
        names, path = _named(text, "--settle", form)
        path, speed = _split(path, "@", "--settle", form, SPEED, text)
        loads.append(Settlement(names_in(names), lengths(path, 3, "--settle", form, given=text), speed))
    for text in push or ():
        form = "NAME:VX,VY,VZ[@SECONDS]"
        name, velocity = _named(text, "--push", form)
        velocity, time = _split(velocity, "@", "--push", form, 0.0, text)
        loads.append(Push(name, velocity=numbers(velocity, 3, "--push", form, given=text), time=time))
    if tilt_to is not None:
        form = "AXIS,DEGREES[,RATE]"
        axis, _, rest = tilt_to.partition(",")
        if axis not in AXES:
            raise InputError(f'--tilt-to is "{tilt_to}"; it must read {form} with AXIS one of x, y, z')
        count = 2 if "," in rest else 1
        loads.append(Tilt(AXES[axis], *numbers(rest, count, "--tilt-to", form, given=tilt_to)))
    return loads


def ground_of(
    record: Path | None, pulse: str | None, ramp: str | None, direction: str, scale: float
) -> Record | Pulse | Ramp:
    """Return the motion of the ground that options name.

    Parameters
    ----------
    record : Path or None
        Value of `--record`; None for an option that is not given.
    pulse, ramp : str or None
        Values of `--pulse` and `--ramp`; None for an option that is not given.
    direction : str
        Direction of a record with one column of accelerations, "X,Y,Z".
    scale : float
        Factor on the accelerations of the record [-].

    Returns
    -------
    Record, Pulse or Ramp
        The motion.

    Raises
    ------
    InputError
        When not exactly one of the three is given, for a direction or a scale without a record, or for a value that
        does not read as it must.
    """
    from dynsim.loads.ground import Pulse, Ramp
    from dynsim.loads.record import read_record

    given = [name for name, value in (("--record", record), ("--pulse", pulse), ("--ramp", ramp)) if value is not None]
    if len(given) != 1:
        raise InputError(f"shake: one of --record, --pulse and --ramp is needed; given: {', '.join(given) or 'none'}")
    if record is not None:
        return read_record(record, direction=numbers(direction, 3, "--direction", "X,Y,Z"), scale=scale)
    if (direction, scale) != (DIRECTION, SCALE):
        raise InputError("--scale and --direction go with --record; the values of --pulse and --ramp are in m/s2")
    if pulse is not None:
        form = "AX,AY,AZ,SECONDS[,SHAPE]"
        words = pulse.split(",")
        values = numbers(",".join(words[:4]), 4, "--pulse", form, given=pulse)
        return Pulse(values[:3], values[3], ",".join(words[4:]) or "rectangle")
    assert ramp is not None
    values = numbers(ramp, 4, "--ramp", "AX,AY,AZ,SECONDS")
    return Ramp(values[:3], values[3])


def _named(text: str, option: str, form: str) -> tuple[str, str]:
    """Return what stands before and after the last colon."""
    name, colon, rest = text.rpartition(":")
    if not (name and colon):
        raise InputError(f'{option} is "{text}"; it must read {form}')
    return name, rest


def _split(text: str, mark: str, option: str, form: str, default: float, given: str) -> tuple[str, float]:
    """Return what stands before a mark, and the number after it; the whole value of the option is for the error."""
    head, found, tail = text.rpartition(mark)
    if not found:
        return text, default
    return head, numbers(tail, 1, option, form, given=given)[0]
