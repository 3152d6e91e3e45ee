"""Files of docs/results: what a script found, in named parts, under the command that wrote it.

A page shows a part between two marks, which `evidence.pages.fill` fills:

    <!-- results: glue critical -->
    <!-- end -->
"""

from __future__ import annotations

import argparse
import json
import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from evidence.paths import ROOT

PART = re.compile(r"^## (\S+)\n", re.MULTILINE)
COMMAND = re.compile(r"^Written by `(.+)`\.$", re.MULTILINE)


def parser(text: str | None) -> argparse.ArgumentParser:
    """Options that every script has which writes a file of docs/results; text : its docstring."""
    found = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("--json", action="store_true", help="print the figures as JSON")
    found.add_argument("--write", type=Path, metavar="FILE", help="put the parts into this file of docs/results")
    return found


def report(options: argparse.Namespace, figures: Any, parts: dict[str, str]) -> None:
    """Print the figures as JSON or their parts as Markdown, and write the parts to a file, as the options ask."""
    print(json.dumps(figures) if options.json else "\n\n".join(parts.values()))
    if options.write:
        save(options.write, parts)


def command(arguments: Sequence[str]) -> str:
    """The command line of this process with these arguments, as one would type it at the root of the project."""
    module = Path(sys.argv[0]).resolve().relative_to(ROOT).with_suffix("")
    names = [name for name in module.parts if name != "__main__"]
    return shlex.join(["python", "-m", ".".join(names), *arguments])


def save(path: Path, parts: dict[str, str], arguments: Sequence[str] | None = None) -> None:
    """Write the parts, Markdown by one-word names, to a file.

    arguments : those that make the whole file, where this process renewed a part of it
    """
    text = f"# {path.stem}\n\nWritten by `{command(sys.argv[1:] if arguments is None else arguments)}`.\n"
    text += "".join(f"\n## {name}\n\n{part.strip()}\n" for name, part in parts.items())
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def load(path: Path) -> tuple[str, dict[str, str]]:
    """The command that wrote a file, and its parts."""
    head, *rest = PART.split(path.read_text())
    found = COMMAND.search(head)
    if not found:
        raise ValueError(f"{path} does not name its command")
    return found[1], dict(zip(rest[::2], map(str.strip, rest[1::2]), strict=True))
