"""The command `blockstat example`: scenes that travel with the package."""

from __future__ import annotations

import re
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Annotated

import typer

from blockstat.errors import InputError, no_such


def example_command(
    name: Annotated[str | None, typer.Argument(help="Of the example; --list names them.")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Where to write; NAME.toml by default.")] = None,
    listed: Annotated[bool, typer.Option("--list", help="Name the examples, a line each.")] = False,
) -> None:
    """Write one of the scenes that come with blockstat, to begin with."""
    from blockstat.system.reading import text_of
    from blockstat.system.writing import written_whole

    places = examples()
    if listed and name is not None:
        raise InputError(f"--list names the examples, and takes none; given: {name}")
    if output is not None and name is None:
        raise InputError("-o is where one example goes; give its name, of those that --list names")
    if name is None:
        for found, path in places.items():
            typer.echo(f"{found:16}{_described(text_of(path))}")
        return
    if name not in places:
        raise no_such("example", name, places)
    target = output or Path(f"{name}.toml")
    if target.suffix.lower() != ".toml":
        raise InputError(f'{target}: cannot write "{target.suffix}"; it is written as: .toml')
    if not target.parent.parent.is_dir():
        raise InputError(f"{target}: no such directory: {target.parent}")
    text = text_of(places[name])
    named = re.findall(r'^file *= *"([^"/]+)"', text, re.MULTILINE)
    copies = [(places[name], target), *((places[name].parent / n, target.parent / n) for n in named)]
    for _, place in copies:
        if place.exists():
            raise InputError(f"{place}: exists; give another place by -o")
    target.parent.mkdir(exist_ok=True)
    for source, place in copies:
        with written_whole(place) as beside:
            beside.write_bytes(source.read_bytes())
        typer.echo(str(place))


def examples() -> dict[str, Path]:
    """Return the scenes that come with the package, by name.

    Returns
    -------
    dict of str to Path
        In the order of their names: from the installed package, or from a checkout that is installed editable.

    Raises
    ------
    InputError
        When they were not installed.
    """
    checkout = Path(__file__).parents[3] / "examples"
    found = [path for path in checkout.glob("*.toml")] if (checkout / "chapel.toml").is_file() else []
    if not found:
        try:
            found = [Path(str(file.locate())) for file in files("blockstat") or () if "blockstat/examples" in str(file)]
        except PackageNotFoundError:
            found = []
    places = {path.stem: path for path in sorted(found) if path.suffix == ".toml"}
    if not places:
        raise InputError("the examples were not installed; they are in the folder examples of the source")
    return places


def _described(text: str) -> str:
    """The first sentence of the comment at the head of a scene, or its description."""
    own = re.search(r'^description *= *"(.*)"', text, re.MULTILINE)
    head = re.match(r"((?:#.*\n)+)", text)
    words = own[1] if own else " ".join(line.strip("# ") for line in head[1].splitlines()) if head else ""
    return re.split(r"(?<=[.]) ", words)[0]
