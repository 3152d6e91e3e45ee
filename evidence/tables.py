"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def head(names: Sequence[str]) -> str:
    """The heading of a table and the line below it."""
    return "|" + "|".join(f" {name} " if name else " " for name in names) + "|\n" + "|---" * len(names) + "|"


def row(cells: Iterable[object]) -> str:
    """One line of a table."""
    return "| " + " | ".join(map(str, cells)) + " |"


def table(names: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """A whole table."""
    return "\n".join([head(names), *map(row, rows)])
