"""Files of docs/results: what a script found, in named parts, under the command that wrote it.

A page shows a part between two marks, which `docs/make_pages.py` fills:

    <!-- results: glue critical -->
    <!-- end -->
"""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PART = re.compile(r"^## (\S+)\n", re.MULTILINE)
COMMAND = re.compile(r"^Written by `(.+)`\.$", re.MULTILINE)


def command() -> str:
    """The command line of this process, as one would type it at the root of the project."""
    script = Path(sys.argv[0]).resolve().relative_to(ROOT)
    return shlex.join(["python", script.as_posix(), *sys.argv[1:]])


def save(path: Path, parts: dict[str, str]) -> None:
    """Write the parts, Markdown by one-word names, to a file."""
    text = f"# {path.stem}\n\nWritten by `{command()}`.\n"
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
