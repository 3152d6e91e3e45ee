"""What a command is given: each single value once, and files that have a name and are not written over others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from blockstat.errors import NAMELESS, InputError
from blockstat.system.writing import check_writable

#: Parameters that are files or directories, by what becomes of them.
READ = ("file", "files", "scene", "loads", "loads_file", "plan", "record")
WRITTEN = ("output", "film", "plot", "journal")


def check_place(path: Path, *suffixes: str) -> None:
    """Refuse a file that cannot be written; better asked before long work than after.

    Parameters
    ----------
    path : Path
        The file.
    *suffixes : str
        Those that it may have, such as ".json"; any where none is given.

    Raises
    ------
    InputError
        For another suffix, for a directory, and for a file in a directory that does not exist or takes no file.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(f'{path}: cannot write "{path.suffix}"; it is written as: {", ".join(suffixes)}')
    check_writable(path)


def file_to_write(*suffixes: str) -> Callable[[Path | None], Path | None]:
    """Return the callback of an option for a file, which refuses one that cannot be written before anything is read.

    Parameters
    ----------
    *suffixes : str
        As in `check_place`.

    Returns
    -------
    callable
        Returns the path that it is given.
    """

    def check(path: Path | None) -> Path | None:
        if path is not None:
            check_place(path, *suffixes)
        return path

    return check


Film = Annotated[
    Path | None,
    typer.Option(
        "--film",
        metavar="FILE",
        callback=file_to_write(".glb", ".png", ".svg"),
        help="Write the motion: .glb (animation), or .png, .svg (strip).",
    ),
]


class OnceGroup(TyperGroup):
    """A program that refuses an option of its own that takes one value and is given twice."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options before the name of a command.

        Parameters
        ----------
        ctx : Context
            Of the program.
        args : list of str
            What stands behind its name.

        Returns
        -------
        list of str
            What was not read.

        Raises
        ------
        InputError
            For an option that is given twice.
        """
        refuse_twice(self, ctx, args)
        return super().parse_args(ctx, args)


class PlacesCommand(TyperCommand):
    """A command that refuses values given twice, files without a name, and files that it would write over others."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, unless a value is given twice or a file has no name, which would be the directory.

        Parameters
        ----------
        ctx : Context
            Of the command.
        args : list of str
            What stands behind its name.

        Returns
        -------
        list of str
            What was not read.

        Raises
        ------
        InputError
            For an option that takes one value and is given twice, and for a file without a name.
        """
        refuse_nameless(self.params, args)
        refuse_twice(self, ctx, args)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command, unless it would write over what it reads or writes.

        Parameters
        ----------
        ctx : Context
            Of the command.

        Returns
        -------
        object
            What the command returns.

        Raises
        ------
        InputError
            Naming the file.
        """
        refuse_overwriting(self.params, ctx.params)
        return super().invoke(ctx)


def keep_places(app: typer.Typer) -> None:
    """Make all commands of a program such as refuse values given twice and files that cannot be meant.

    Parameters
    ----------
    app : typer.Typer
        With all its commands.
    """
    app.info.cls = OnceGroup
    for command in app.registered_commands:
        command.cls = PlacesCommand


def refuse_twice(command: Any, ctx: Any, given: Sequence[str]) -> None:
    """Raise InputError where an option that takes one value is given twice: the last one alone would count.

    Parameters
    ----------
    command : Command
        As typer has it, with its options.
    ctx : Context
        Of the command.
    given : sequence of str
        What stands behind its name.

    Raises
    ------
    InputError
        Naming the option.
    """
    if ctx.resilient_parsing:  # a line that is completed, not run
        return
    _, _, order = command.make_parser(ctx).parse_args(args=list(given))  # takes what it reads off the list
    single = [own for own in order if not (getattr(own, "is_flag", False) or own.multiple or own.nargs != 1)]
    for k, own in enumerate(single):
        if own in single[:k]:
            form = f": {own.opts[0]} {own.metavar}" if own.metavar else ""
            raise InputError(f"{own.opts[0]} is given twice; it takes one value{form}")


def refuse_nameless(parameters: Sequence[Any], given: Sequence[str]) -> None:
    """Raise InputError where the name of a file is empty.

    Parameters
    ----------
    parameters : sequence
        Options and arguments of a command, as typer has them.
    given : sequence of str
        What stands behind its name.

    Raises
    ------
    InputError
        Naming the option.
    """
    taking = {name: own for own in parameters for name in own.opts if not getattr(own, "is_flag", True)}
    before = ""
    for text in given:
        option, equals, value = text.partition("=")
        if equals and not value and option in taking:
            before, text = option, ""
        if not text and before not in taking:
            raise InputError(NAMELESS)
        if not text and _is_file(taking[before]):
            raise InputError(f"{before}: {NAMELESS}")
        before = "" if before in taking else text


def _is_file(option: Any) -> bool:
    """Whether an option names a file; a film is seconds in some commands."""
    return option.metavar == "FILE" or (option.name != "film" and option.name in (*READ, *WRITTEN, "folder"))


def refuse_overwriting(parameters: Sequence[Any], values: dict[str, Any]) -> None:
    """Raise InputError where a file would be written over one that is read, or over another one that is written.

    Parameters
    ----------
    parameters : sequence
        Options and arguments of a command, as typer has them.
    values : dict
        What is given for each, by name.

    Raises
    ------
    InputError
        Naming the file and the options.
    """
    read = [path for _, path in _paths(parameters, values, READ)]
    written = list(_paths(parameters, values, WRITTEN))
    for k, (option, path) in enumerate(written):
        if any(_same(path, other) for other in read):
            raise InputError(f"{option} {path}: this file is read, and would be overwritten; give another place")
        if others := [other for other, place in written[:k] if _same(path, place)]:
            raise InputError(f"{others[0]} and {option} are both {path}; one would overwrite the other")


def _paths(parameters: Sequence[Any], values: dict[str, Any], names: Sequence[str]) -> Iterator[tuple[str, Path]]:
    """The files that are given for some parameters, with the first name of each option."""
    for own in parameters:
        if own.name in names:
            value = values.get(own.name)
            for path in value if isinstance(value, (list, tuple)) else [value]:
                if isinstance(path, Path):
                    yield own.opts[0], path


def _same(one: Path, other: Path) -> bool:
    """Whether two paths are one file or directory; a device takes what all write."""
    try:
        return one.samefile(other) and (one.is_file() or one.is_dir())
    except OSError:  # one of them is not there yet
        return one.resolve() == other.resolve()


def written(files: Mapping[str, str]) -> None:
    """Print the names of files that a command has written, one a line.

    Parameters
    ----------
    files : mapping of str
        By their key, as `drawn` returns them.
    """
    for key, path in files.items():
        typer.echo(f"{key}: {path}")


@contextmanager
def drawn(**wanted: tuple[Callable[[Any, Path], Any], Any, Path | None]) -> Iterator[dict[str, str]]:
    """Write the pictures that were asked for; one that cannot be written is told when the answer has been printed.

    Parameters
    ----------
    **wanted : (callable, object, Path or None)
        By its key in the JSON: what writes it, what is shown, and the file.

    Yields
    ------
    dict of str
        The files that were written, by key.

    Raises
    ------
    InputError
        After the body of the `with` statement, for a file that was not written.
    KeyboardInterrupt
        After the body, for an interrupt while they were written.
    """
    files, refused = dict[str, str](), list[InputError | KeyboardInterrupt]()
    for key, (write, shown, path) in wanted.items():
        if path is None or any(isinstance(error, KeyboardInterrupt) for error in refused):
            continue
        try:
            write(shown, path)
            files[key] = str(path)
        except (InputError, KeyboardInterrupt) as error:
            refused.append(error)
    yield files
    for error in refused:
        raise error
