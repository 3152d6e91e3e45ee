"""Run a page as a reader would: its Python in one scope, its commands in a shell, and compare what the Python prints.

    python -I extras/run_page.py docs/quick_start.md

Files are written where it is run. Only the standard library is needed, so that it runs in any environment.
"""

import contextlib
import io
import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

#: A block of Python, what it prints, or a command in an indented block, less its comment.
STEP = re.compile(
    r"^```(?P<kind>python|text|toml)\n(?P<content>.*?)^```"
    r"|^    (?P<command>(?:mkdir -p \S+ && )?(?:blockstat|dynsim) [^\n]*?)(?:\s+#[^\n]*)?$",
    re.DOTALL | re.MULTILINE,
)

#: The first line of a scene file that the code of a page reads.
NAMED = re.compile(r"# (\w+\.toml)\n")


class PageError(Exception):
    """A page does not print what it shows."""


def steps(text: str) -> list[tuple[str, str]]:
    """Kinds ("python", "text", "toml" or "command") and contents, in the order of the page."""
    return [
        ("command", found["command"]) if found["command"] else (found["kind"], found["content"])
        for found in STEP.finditer(text)
    ]


def run_page(text: str, name: str, *, commands: bool) -> int:
    """Run a page and count its steps.

    The text block behind a Python block is what that must print. A scene that begins with its name is written first.
    """
    scope: dict = {}
    printed, done = "", 0
    for kind, content in steps(text):
        if kind == "toml":
            if file := NAMED.match(content):
                Path(file[1]).write_text(content, encoding="utf-8")
        elif kind == "text":
            if printed != content:
                raise PageError(f"{name} shows\n{content}and this is printed:\n{printed}")
            printed = ""
        elif printed:
            raise PageError(f"{name} does not show that this is printed:\n{printed}")
        elif kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as output:
                exec(compile(content, name, "exec"), scope)
            printed = output.getvalue()
        elif commands:
            print("  $", content, flush=True)
            if status := subprocess.run(content, shell=True, stdout=subprocess.DEVNULL).returncode:
                raise PageError(f"{name}: `{content}` ends with status {status}")
        done += commands or kind != "command"
    if printed:
        raise PageError(f"{name} does not show that this is printed:\n{printed}")
    return done


def main(pages: list[str]) -> None:
    # The commands of this environment come first, as in one that is activated.
    os.environ["PATH"] = os.pathsep.join((sysconfig.get_path("scripts"), os.environ.get("PATH", "")))
    for page in pages:
        try:
            done = run_page(Path(page).read_text(encoding="utf-8"), page, commands=True)
        except PageError as error:
            raise SystemExit(str(error)) from None
        print(f"{Path(page).name}: {done} steps as shown")


if __name__ == "__main__":
    main(sys.argv[1:])
