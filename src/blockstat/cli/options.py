"""Options that both commands share, and the one place where errors become messages and exit codes."""

from __future__ import annotations

import json
import math
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from blockstat.errors import InputError, InputWarning

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

FileArgument = Annotated[Path, typer.Argument(help="Assembly (.json, .obj, .glb, .stl, .ply, directory) or scene.")]
Friction = Annotated[
    float | None, typer.Option(help="Coefficient of friction in place of the file's; inf for no sliding.")
]
Gravity = Annotated[str | None, typer.Option(metavar="GX,GY,GZ", help="Gravity vector in m/s2 in place of the file's.")]
Tilt = Annotated[
    str | None,
    typer.Option(metavar="AXIS,DEGREES", help="Rotate gravity about x, y or z, as if the ground tilted."),
]
Supports = Annotated[
    str | None,
    typer.Option(metavar="NAME,...", help="Blocks that cannot move, by name or number, in place of the file's."),
]
Units = Annotated[
    str | None, typer.Option(help="Of the coordinates in the file, converted to metres: m, dm, cm, mm, in or ft.")
]
PORT = 8321
Port = Annotated[int, typer.Option(min=1, max=65535, help="Of the page on 127.0.0.1; the next free one if taken.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]

#: What typer raises for arguments that it cannot read; it exports only this child of it.
UsageError: type[Exception] = typer.BadParameter.__bases__[0]
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def load(
    path: Path,
    *,
    friction: float | None,
    gravity: str | None,
    tilt: str | None,
    supports: str | None = None,
    units: str | None = None,
) -> Assembly:
    """Read a file and apply the options."""
    from blockstat.spec import read

    chosen = supports.split(",") if supports else None
    return modified(read(path, supports=chosen, units=units), friction=friction, gravity=gravity, tilt=tilt)


def modified(assembly: Assembly, *, friction: float | None, gravity: str | None, tilt: str | None) -> Assembly:
    """The assembly under the friction and gravity that the options ask for."""
    changes: dict[str, Any] = {}
    if friction is not None:
        changes["friction"] = friction
    if gravity is not None:
        changes["gravity"] = numbers(gravity, 3, "--gravity", "GX,GY,GZ")
    if tilt is not None:
        changes["gravity"] = _tilted(changes.get("gravity", assembly.gravity), tilt)
    return assembly.with_(**changes) if changes else assembly


def numbers(text: str, count: int, option: str, form: str) -> list[float]:
    """Return the numbers in the text of an option; raise InputError that says the form where they are not."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise InputError(f'{option} is "{text}"; it must read {form}')
    return values


def _tilted(gravity: Any, tilt: str) -> Any:
    import numpy as np
    from scipy.spatial.transform import Rotation

    axis, _, degrees = tilt.partition(",")
    if axis not in AXES:
        raise InputError(f'--tilt is "{tilt}"; it must read AXIS,DEGREES with AXIS one of x, y, z')
    try:
        angle = numbers(degrees, 1, "--tilt", "AXIS,DEGREES")[0]
    except InputError:
        raise InputError(f'--tilt is "{tilt}"; it must read AXIS,DEGREES with DEGREES a number') from None
    return Rotation.from_rotvec(np.deg2rad(angle) * np.array(AXES[axis])).apply(np.asarray(gravity))


def print_json(value: Any) -> None:
    """One object on standard output; non-finite numbers have no place in it."""
    print(json.dumps(value, allow_nan=False))


def _say_version(wanted: bool) -> None:
    if wanted:
        from blockstat import __version__

        print(__version__)
        raise typer.Exit


Version = Annotated[
    bool, typer.Option("--version", help="Print the version and end.", callback=_say_version, is_eager=True)
]


def run_app(app: typer.Typer, prog: str) -> None:
    """Run a command: 2 on bad input, 1 on our own failure, 130 when interrupted; never a stack trace."""
    with warnings.catch_warnings():
        warnings.simplefilter("default", InputWarning)
        warnings.showwarning = _show_warning
        sys.exit(_status(lambda: app(prog_name=prog, standalone_mode=False), prog))


def _status(call: Callable[[], Any], prog: str) -> int:
    try:
        ended = call()
        return ended if isinstance(ended, int) else 0
    except InputError as error:
        print(f"{prog}: {error}", file=sys.stderr)
        return 2
    except UsageError as error:
        _say_usage(error, prog)
        return 2
    except (KeyboardInterrupt, typer.Abort):
        print(f"{prog}: interrupted", file=sys.stderr)
        return 130
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else 0
    except OSError as error:
        print(f"{prog}: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    except MemoryError:
        print(f"{prog}: not enough memory for a scene of this size", file=sys.stderr)
        return 1
    except Exception as error:
        print(f"{prog}: internal error ({type(error).__name__}: {error}); please report it", file=sys.stderr)
        return 1


def _say_usage(error: Any, prog: str) -> None:
    """Print what is wrong with the arguments in one line; the message is empty where the help was printed instead."""
    command = error.ctx.command_path if error.ctx is not None else prog
    if text := " ".join(error.format_message().split()).rstrip("."):
        print(f"{prog}: {text}; see `{command} --help`", file=sys.stderr)


def _show_warning(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    if issubclass(category, InputWarning):
        print(f"warning: {message}", file=sys.stderr)
