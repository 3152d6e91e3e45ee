"""Write docs/command_line.md and docs/command_line, the reference of both commands, from the commands themselves."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from typing import Any

from typer.main import get_command

from blockstat.cli.commands import app as blockstat
from dynsim.cli.commands import app as dynsim
from evidence.paths import DOCS
from evidence.tables import table

PROGRAMS: Mapping[str, Any] = {"blockstat": get_command(blockstat), "dynsim": get_command(dynsim)}
#: Pages below the first one: the title, the program and its commands.
PAGES: Mapping[str, tuple[str, str, Sequence[str]]] = {
    "questions": (
        "blockstat: verdicts and limits",
        "blockstat",
        ("check", "limit", "tilt", "friction", "cases", "capacity", "code-check", "settle", "tie"),
    ),
    "chance": (
        "blockstat: chance, proofs and sequences",
        "blockstat",
        ("reliability", "prove", "sequence"),
    ),
    "files": (
        "blockstat: files and pictures",
        "blockstat",
        ("example", "build", "convert", "repair", "plot", "report", "app"),
    ),
    "simulation": (
        "dynsim: simulation",
        "dynsim",
        ("verify", "shake", "ida", "limit", "compare", "sequence", "optimise", "report", "app"),
    ),
}
HEAD = """# Command line

Written by `make evidence ONLY=command-line` from the commands themselves; `--help` says the same. `blockstat` is the
statics and `dynsim` is Bullet. `python -m blockstat` and `python -m dynsim` do the same.

A FILE is a scene (`.toml`), an assembly (`.json`, COMPAS too), or a mesh (`.obj`, `.glb`, `.stl`, `.ply`, or a folder
of them). A mesh does not say which blocks are supports: give `--supports NAME,...`, or
`--supports lowest` for those that reach down to the lowest corner. Lengths are metres unless
`--units` says otherwise, and z points up (in GLB y) unless `--up` does. A file in other units or axes is converted to
metres with z up, and every other option, load, path and tie is in these axes. An option that takes one value is refused
if it is given twice. `--json` prints one JSON object on standard output; progress goes to standard error.

| exit status | meaning |
|---|---|
| 0 | a verdict was reached, whichever it is |
| 1 | an internal error; or the program that reads the output has closed it |
| 2 | bad input, with what to write instead. Also: no file gave a verdict; no design stood and some were not judged; \
or `--seconds` were over before a plan was found |
| 130 | interrupted: before there was an answer, or while some of several are missing; what is done is printed |
"""
WRITTEN = "Written by `make evidence ONLY=command-line`. [Command line](../command_line.md) lists all commands.\n"
SPECIAL = re.compile(r"([|*<$])")


def commands(program: str) -> dict[str, Any]:
    """The commands of a program that its help lists."""
    return {name: command for name, command in PROGRAMS[program].commands.items() if not command.hidden}


def arguments(command: Any) -> list[Any]:
    """The parameters of a command that have no name on the command line."""
    return [own for own in command.params if own.param_type_name == "argument"]


def usage(program: str, name: str, command: Any) -> str:
    """How a command is called."""
    words = [own.name.upper() + ("..." if own.nargs == -1 else "") for own in arguments(command)]
    asked = [word if own.required else f"[{word}]" for word, own in zip(words, arguments(command), strict=True)]
    return " ".join([program, name, *asked, "[OPTIONS]"])


def escaped(text: str) -> str:
    """Words as they stand in a cell of a table."""
    return SPECIAL.sub(r"\\\1", " ".join(text.split()))


def rows(command: Any, program: str) -> list[list[str]]:
    """The parameters of a command: name, default and meaning."""
    context = command.make_context(program, [], resilient_parsing=True)
    found = []
    for own in command.params:
        record = own.get_help_record(context)
        if record is None or "--help" in own.opts:
            continue
        name, said = record
        said = said.removesuffix("[required]")
        said, _, given = said.partition("  [default: ")
        if own.param_type_name == "argument":
            name = own.name.upper()
        default = "needed" if own.required else f"`{given.removesuffix(']')}`" if given else "none"
        found.append([f"`{name}`", default, escaped(said)])
    return found


def section(program: str, name: str) -> str:
    """A command: what it does, how it is called, and its options."""
    command = PROGRAMS[program].commands[name]
    said = re.sub(r"\n\s*\n", "\n\n", inspect.cleandoc(command.help))
    shown = table(["option", "default", ""], rows(command, program))
    return f"## {program} {name}\n\n{said}\n\n    {usage(program, name, command)}\n\n{shown}\n"


def first_page() -> str:
    """Both commands in a table, and what all of their commands have in common."""
    shared = [rows(whole, program) for program, whole in PROGRAMS.items()]
    if shared[0] != shared[1]:
        raise SystemExit("the two programs have different options before the command: show those of each")
    parts = [HEAD, f"Before the name of a command:\n\n{table(['option', 'default', ''], shared[0])}\n"]
    for program, whole in PROGRAMS.items():
        listed = [
            [f"[`{name}`](command_line/{page}.md#{program}-{name})", first_paragraph(commands(program)[name].help)]
            for page, (_, own, names) in PAGES.items() if own == program for name in names
        ]  # fmt: skip
        parts.append(f"## {program}\n\n{inspect.cleandoc(whole.help)}\n\n{table(['command', ''], listed)}\n")
    below = "\n".join(f"command_line/{page}" for page in PAGES)
    return "\n".join([*parts, f"```{{toctree}}\n:hidden:\n\n{below}\n```\n"])


def first_paragraph(text: str) -> str:
    """The first paragraph of a help."""
    return escaped(inspect.cleandoc(text).split("\n\n")[0])


def pages() -> dict[str, str]:
    """The whole reference, by file in docs."""
    found = {"command_line.md": first_page()}
    for page, (title, program, names) in PAGES.items():
        found[f"command_line/{page}.md"] = "\n".join(
            [f"# {title}\n\n{WRITTEN}", *(section(program, name) for name in names)]
        )
    return found


if __name__ == "__main__":
    for name, text in pages().items():
        (DOCS / name).parent.mkdir(exist_ok=True)
        (DOCS / name).write_text(text)
