"""Files that a command names: none is without a name, and none is written over another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand

from blockstat.errors import NAMELESS, InputError

#: Parameters that are files or directories, by what becomes of them.
READ = ("file", "files", "scene", "loads", "loads_file", "plan", "record")
WRITTEN = ("output", "film", "plot", "journal")


class PlacesCommand(TyperCommand):
    """A command that refuses files without a name, and files that it would write over what it reads or writes."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, unless a file has no name: that would be the directory one is in.

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
            For a file without a name.
        """
        refuse_nameless(self.params, args)
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
    """Make all commands of a program such as refuse files without a name, and those that would be written over.

    Parameters
    ----------
    app : typer.Typer
        With all its commands.
    """
    for command in app.registered_commands:
        command.cls = PlacesCommand


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
