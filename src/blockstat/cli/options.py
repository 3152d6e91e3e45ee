"""Options that both commands share, and the one place where errors become messages and exit codes."""

from __future__ import annotations

import io
import json
import math
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.errors import InputError, InputWarning, rough
from blockstat.system.process import INTERRUPTED

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.system.process import Interruptions

FileArgument = Annotated[Path, typer.Argument(help="Assembly (.json, .obj, .glb, .stl, .ply, directory) or scene.")]
Friction = Annotated[
    float | None,
    typer.Option(help="Coefficient of friction in place of the file's; joint laws keep their own. inf for no sliding."),
]
Gravity = Annotated[
    str | None, typer.Option(metavar="GX,GY,GZ", help="Gravity vector in m/s2, z up, in place of the file's.")
]
Tilt = Annotated[
    str | None,
    typer.Option(
        metavar="AXIS,DEGREES",
        help="Rotate gravity about x, y or z, as if the ground tilted; levels and loads of a case stay as they are.",
    ),
]
Supports = Annotated[
    str | None,
    typer.Option(
        metavar="NAME,...", help="Names or numbers of blocks that cannot move; lowest for those at the bottom."
    ),
]


def _in_small_letters(text: str | None) -> str | None:
    """Return what is meant by a unit or an axis in capitals."""
    return None if text is None else text.lower()


Units = Annotated[
    str | None,
    typer.Option(
        callback=_in_small_letters,
        help="Of the coordinates in the file, converted to metres: m, dm, cm, mm, in or ft. Lengths in loads and in "
        "other options are in metres.",
    ),
]
Up = Annotated[
    str | None,
    typer.Option(
        metavar="AXIS",
        callback=_in_small_letters,
        help="Of the file, that points up: z, y, x, -z, -y or -x; by default z, in GLB y. The blocks are turned to z "
        "up, with y up (x, y, z) to (x, -z, y); loads, gravity, paths and ties of options and of --loads are in these "
        "axes.",
    ),
]
Gap = Annotated[
    str | None, typer.Option(help='Largest gap of a joint: a share of the block size, or a length such as "2 mm".')
]
PORT = 8321
Port = Annotated[int, typer.Option(min=1, max=65535, help="Of the page on 127.0.0.1; the next free one if taken.")]
Folder = Annotated[
    Path | None, typer.Option(help="Where files are that uploaded scenes name; that of FILE by default.")
]
MostSeconds = Annotated[float, typer.Option(min=1, help="A verdict that takes longer is stopped.")]
MostGigabytes = Annotated[float, typer.Option(min=0.5, help="Memory of one process of the page, on Linux.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]

_TOLD: dict[str, None] = {}  #: warnings about the input of the command that runs, each once
#: What typer raises for arguments that it cannot read; it exports only this child of it.
UsageError: type[Exception] = typer.BadParameter.__bases__[0]
PRINTING = ("typer", "click", "rich")  #: packages that print on standard output
ROUNDING = 1e-14  #: a part of gravity below this share is what rotation there and back leaves of none
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def gap_of(text: str | None) -> float | str:
    """Return what `--gap` says.

    Parameters
    ----------
    text : str or None
        A number or a length; None for the default.

    Returns
    -------
    float or str
        The number, or the text.

    Raises
    ------
    InputError
        For a text that is neither.
    """
    from blockstat.contact.tolerance import read_gap

    return read_gap(text)


def load(
    path: Path,
    *,
    friction: float | None,
    gravity: str | None,
    tilt: str | None,
    supports: str | None = None,
    units: str | None = None,
    up: str | None = None,
    stands: bool = True,
) -> Assembly:
    """Read a file and apply the options.

    Parameters
    ----------
    path : Path
        A file or a directory, as `blockstat.read` takes it.
    friction : float or None
        Coefficient of friction [-]; None for the file's.
    gravity : str or None
        Value of `--gravity`, "GX,GY,GZ" [m/s2]; None for the file's.
    tilt : str or None
        Value of `--tilt`, "AXIS,DEGREES"; None for no tilt.
    supports : str, optional
        Value of `--supports`, names or numbers of blocks separated by commas; None for the file's.
    units : str, optional
        Of the coordinates in the file; they are converted to metres.
    up : str, optional
        Value of `--up`, the axis of the file that points up.
    stands : bool, optional
        Whether something is asked that needs supports.

    Returns
    -------
    Assembly
        In metres, under the friction and gravity asked for.

    Raises
    ------
    InputError
        For a file that cannot be used, or an option that does not read as it must.

    Warns
    -----
    InputWarning
        Where units, friction or the axis that is up look wrong, with what to type.
    """
    from blockstat.assembly import check_supports
    from blockstat.io.parts import odd_gravity
    from blockstat.spec.files import blaming, read

    assembly = read(path, supports=None if supports is None else names_in(supports), units=units, up=up)
    if stands:
        blaming(path, lambda: check_supports(assembly))
    assembly = modified(assembly, friction=friction, gravity=None, tilt=None)
    warn_of_odd_numbers(assembly, path)
    if gravity is not None:
        assembly = modified(assembly, friction=None, gravity=gravity, tilt=None)
        for text in odd_gravity(assembly):
            warnings.warn(f"--gravity {gravity}: {text}", InputWarning, stacklevel=2)
    return modified(assembly, friction=None, gravity=None, tilt=tilt)


def names_in(text: str) -> list[str]:
    """Return the names in the text of an option.

    Parameters
    ----------
    text : str
        Names separated by commas, perhaps with blanks around them.

    Returns
    -------
    list of str
        The names without the blanks.

    Examples
    --------
    >>> names_in("footL, footR")
    ['footL', 'footR']
    """
    return [name.strip() for name in text.split(",")]


def source_of(path: Path, up: str | None = None) -> str:
    """Return where the blocks are from, and how they were turned.

    Parameters
    ----------
    path : Path
        The file that `load` has read.
    up : str, optional
        Value of `--up`; None for the axis of the format.

    Returns
    -------
    str
        Such as "tower.obj, turned: y up in the file, z up here".
    """
    from blockstat.io.parts import own_up

    up = up or own_up(path.suffix)
    return str(path) if up == "z" else f"{path}, turned: {up} up in the file, z up here"


def warn_of_odd_numbers(assembly: Assembly, path: Path) -> None:
    """Warn where units or the axis that is up look wrong.

    Parameters
    ----------
    assembly : Assembly
        As it was read.
    path : Path
        The file.

    Warns
    -----
    InputWarning
        With what to type.
    """
    from blockstat.io.parts import doubts, own_up

    for text in doubts(assembly, up=own_up(path.suffix), scene=path.suffix.lower() == ".toml"):
        warnings.warn(f"{path}: {text}", InputWarning, stacklevel=2)


def modified(assembly: Assembly, *, friction: float | None, gravity: str | None, tilt: str | None) -> Assembly:
    """Return an assembly under the friction and gravity that the options ask for.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    friction : float or None
        Coefficient of friction [-]; None for the assembly's.
    gravity : str or None
        Value of `--gravity`, "GX,GY,GZ" [m/s2]; None for the assembly's.
    tilt : str or None
        Value of `--tilt`, "AXIS,DEGREES", by which gravity is rotated; None for no tilt.

    Returns
    -------
    Assembly
        The same blocks.

    Raises
    ------
    InputError
        For an option that does not read as it must, a negative friction, or a gravity of zero.

    Warns
    -----
    InputWarning
        With a friction that may be an angle, and with another one where joint laws keep their own.
    """
    changes: dict[str, Any] = {}
    if friction is not None:
        changes["friction"] = friction
        if (doubted := rough("--friction", friction)) is not None:
            warnings.warn(doubted, InputWarning, stacklevel=2)
        if own := [law for law in assembly.joints if law.friction not in (None, friction)]:
            from blockstat.contact.point_law import kept_by

            text = f'"{assembly.name}": --friction {friction:g} is asked for, and joints {kept_by(own)}'
            warnings.warn(text, InputWarning, stacklevel=2)
    if gravity is not None:
        changes["gravity"] = numbers(gravity, 3, "--gravity", "GX,GY,GZ")
    if tilt is not None:
        changes["gravity"] = _tilted(changes.get("gravity", assembly.gravity), tilt)
    return assembly.with_(**changes) if changes else assembly


def numbers(text: str, count: int, option: str, form: str, *, given: str | None = None) -> list[float]:
    """Return the numbers in the text of an option.

    Parameters
    ----------
    text : str
        Numbers separated by commas.
    count : int
        How many numbers there must be.
    option : str
        Name of the option, for the error.
    form : str
        What the option must read, for the error.
    given : str, optional
        The whole value of the option where the numbers are a part of it, for the error.

    Returns
    -------
    list of float
        All are finite.

    Raises
    ------
    InputError
        When the text is anything but so many finite numbers; it names the option and its form.

    Examples
    --------
    >>> from blockstat.cli.options import numbers
    >>> numbers("0,1,0", 3, "--load", "AX,AY,AZ")
    [0.0, 1.0, 0.0]
    """
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise InputError(f'{option} is "{text if given is None else given}"; it must read {form}')
    return values


def lengths(text: str, count: int, option: str, form: str, *, given: str | None = None) -> list[float]:
    """Return the lengths in the text of an option, which are in metres where no unit follows.

    Parameters
    ----------
    text : str
        Lengths separated by commas, as "0,0,-10 mm".
    count, option, form, given
        As in `numbers`.

    Returns
    -------
    list of float
        All are finite [m].

    Raises
    ------
    InputError
        When the text is anything but so many lengths; it names the option and its form.

    Examples
    --------
    >>> from blockstat.cli.options import lengths
    >>> lengths("0,1.5,-10 mm", 3, "--move", "DX,DY,DZ")
    [0.0, 1.5, -0.01]
    """
    from blockstat.io.parts import metres_in

    parts = [part.strip() for part in text.split(",")]
    units = [next((unit for unit in ("mm", "cm", "dm", "m", "in", "ft") if part.endswith(unit)), "") for part in parts]
    bare = [part.removesuffix(unit) for part, unit in zip(parts, units, strict=True)]
    values = numbers(",".join(bare), count, option, form, given=text if given is None else given)
    return [value * metres_in(unit or None) for value, unit in zip(values, units, strict=True)]


def upright(assembly: Assembly, tilt: str | None) -> Assembly:
    """Return an assembly under the gravity that it has without `--tilt`.

    Parameters
    ----------
    assembly : Assembly
        As `load` returns it with this tilt.
    tilt : str or None
        Value of `--tilt`; None for no tilt.

    Returns
    -------
    Assembly
        The same blocks.
    """
    return assembly if tilt is None else assembly.with_(gravity=_tilted(assembly.gravity, tilt, back=True))


def _tilted(gravity: Any, tilt: str, *, back: bool = False) -> Any:
    import numpy as np
    from scipy.spatial.transform import Rotation

    axis, _, degrees = tilt.partition(",")
    if axis not in AXES:
        raise InputError(f'--tilt is "{tilt}"; it must read AXIS,DEGREES with AXIS one of x, y, z')
    try:
        angle = numbers(degrees, 1, "--tilt", "AXIS,DEGREES")[0]
    except InputError:
        raise InputError(f'--tilt is "{tilt}"; it must read AXIS,DEGREES with DEGREES a number') from None
    turn = Rotation.from_rotvec(np.deg2rad(-angle if back else angle) * np.array(AXES[axis]))
    found = turn.apply(np.array(gravity))
    # Upright again, up is an axis itself, and not one to rounding.
    return np.where(np.abs(found) < ROUNDING * np.linalg.norm(found), 0.0, found) if back else found


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON object on standard output, with the warnings about the input before those of the answer.

    Parameters
    ----------
    value : dict
        Plain values: dicts, lists, strings, finite numbers, booleans and None.

    Raises
    ------
    ValueError
        For a number that is not finite, which JSON does not have.
    """
    own = value.get("warnings", [])
    print(json.dumps(value | {"warnings": list(dict.fromkeys([*told(), *own]))}, allow_nan=False))


def told() -> tuple[str, ...]:
    """Return the warnings about the input that this command has given so far on standard error.

    Returns
    -------
    tuple of str
        Each once.
    """
    return tuple(_TOLD)


def _say_version(wanted: bool) -> None:
    if wanted:
        from blockstat import __version__

        print(__version__)
        raise typer.Exit


def _allow_blocks(most: float | None) -> None:
    if most is not None:
        from blockstat.model.size import ALLOWED, most_blocks

        os.environ[ALLOWED] = f"{most:g}"  # processes that this one starts build as much
        most_blocks()


MostBlocks = Annotated[
    float | None,
    typer.Option(
        "--most-blocks", metavar="N", help="Blocks that a scene may have; 300,000 by default.", callback=_allow_blocks
    ),
]
Version = Annotated[
    bool, typer.Option("--version", help="Print the version and end.", callback=_say_version, is_eager=True)
]


def run_app(app: typer.Typer, prog: str) -> None:
    """Run a command and end the process with its exit status; a stack trace is never shown.

    Parameters
    ----------
    app : typer.Typer
        The command.
    prog : str
        Its name, which begins each message about an error.

    Raises
    ------
    SystemExit
        Always: with 0 on success, 2 on bad input, 1 on a failure of the program, 130 when interrupted, or the status
        that the command asks for.
    """
    from blockstat.system.process import Interruptions, end_now

    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name of a file may be of no encoding
    with warnings.catch_warnings():
        warnings.simplefilter("default", InputWarning)
        warnings.showwarning = _show_warning
        interruptions = Interruptions()
        interruptions.heed()
        status = _status(lambda: app(prog_name=prog, standalone_mode=False), prog, interruptions)
        interruptions.ignore()  # what is left is to clean up
        if status == INTERRUPTED:
            end_now(status)
        sys.exit(status)


def _status(call: Callable[[], Any], prog: str, interruptions: Interruptions | None = None) -> int:
    try:
        with _warnings_kept():
            ended = call()
            sys.stdout.flush()  # a full disk is told here
        if ended == INTERRUPTED:  # as typer reports it
            raise KeyboardInterrupt
        return ended if isinstance(ended, int) else 0
    except InputError as error:
        for text in error.told():
            print(f"{prog}: {_one_line(text)}", file=sys.stderr)
        return 2
    except UsageError as error:
        _say_usage(error, prog)
        return 2
    except (KeyboardInterrupt, typer.Abort):
        print(f"{prog}: interrupted", file=sys.stderr)
        return INTERRUPTED
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else 0
    except OSError as error:
        place = error.filename or ("standard output" if _from_printing(error) else "")
        print(f"{prog}: {f'{place}: ' if place else ''}{error.strerror or error}", file=sys.stderr)
        return 2
    except MemoryError:
        print(f"{prog}: not enough memory for a scene of this size", file=sys.stderr)
        return 1
    except Exception as error:
        came = interruptions is not None and interruptions.came
        told = "interrupted" if came else f"internal error ({type(error).__name__}: {error}); please report it"
        print(f"{prog}: {told}", file=sys.stderr)
        return INTERRUPTED if came else 1


def _from_printing(error: OSError) -> bool:
    """Whether an error came as something was printed, by where it was raised: an error of writing names no file.

    What is left to print then goes nowhere, or the interpreter would tell of it again as it ends.
    """
    *_, (frame, _) = traceback.walk_tb(error.__traceback__)
    if frame.f_globals["__name__"].partition(".")[0] not in PRINTING and frame.f_globals["__name__"] != __name__:
        return False
    if sys.stdout is sys.__stdout__:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
    return True


def _one_line(text: str) -> str:
    """A text as it may stand on a terminal: names in files may hold what clears the screen or looks like an answer."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def _say_usage(error: Any, prog: str) -> None:
    """Print what is wrong with the arguments in one line, or the help where there are none."""
    if type(error).__name__ == "NoArgsIsHelpError":  # typer brings its own click, or uses that which is installed
        print(error.format_message(), file=sys.stderr)
        return
    command = error.ctx.command_path if error.ctx is not None else prog
    if text := " ".join(error.format_message().split()).rstrip("."):
        if "valid number" in text or "valid float" in text:  # in the words of one typer or another
            text += "; a number is written with a decimal point, such as 0.5"
        print(f"{prog}: {text}; see `{command} --help`", file=sys.stderr)


def _show_warning(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    if issubclass(category, InputWarning):
        print(f"warning: {_one_line(str(message))}", file=sys.stderr)


@contextmanager
def _warnings_kept() -> Iterator[None]:
    """Keep the warnings about the input that a command gives, and show them as before."""
    with warnings.catch_warnings():
        show = warnings.showwarning

        def keep(message: Warning | str, category: type[Warning], *others: Any, **options: Any) -> None:
            if issubclass(category, InputWarning):
                _TOLD[str(message)] = None
            show(message, category, *others, **options)

        warnings.showwarning = keep
        try:
            yield
        finally:
            _TOLD.clear()
