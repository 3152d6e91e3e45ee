"""Files of JSON lines: the first says what the rows are of, and rows are appended as they come."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TextIO, TypeVar

from blockstat.errors import InputError
from blockstat.system.writing import written_whole

T = TypeVar("T")


def kept_rows(path: Path, head: dict[str, Any], make: Callable[[dict[str, Any]], T], *, other: str) -> list[T]:
    """Read the rows of a file; a new one gets its first line, and a line cut short by a kill is dropped.

    Parameters
    ----------
    path : Path
        The file.
    head : dict
        What the rows are of, plain values.
    make : callable
        Makes an object of the values of a row.
    other : str
        What the rows are where the first line is another, for the error.

    Returns
    -------
    list
        What `make` returns, in the order of the file.

    Raises
    ------
    InputError
        For a file of something else, or a damaged line.
    """
    if path.is_file() and not (data := path.read_bytes()).endswith(b"\n"):
        os.truncate(path, data.rfind(b"\n") + 1)
    if not path.is_file() or not path.stat().st_size:
        with written_whole(path) as place:
            place.write_text(json.dumps(head) + "\n")
        return []
    found, rows = read_rows(path, make)
    if found != head:
        raise InputError(f"{path}: these are {other}; move the file away or choose another")
    return rows


def read_rows(path: Path, make: Callable[[dict[str, Any]], T]) -> tuple[Any, list[T]]:
    """Read the first line and the rows of a file.

    Parameters
    ----------
    path : Path
        The file.
    make : callable
        Makes an object of the values of a row.

    Returns
    -------
    head : object
        What the rows are of.
    rows : list
        What `make` returns, in the order of the file.

    Raises
    ------
    InputError
        For a damaged line.
    """
    with path.open() as file:
        try:
            head, *rows = map(json.loads, file)
            return head, [make(row) for row in rows]
        except (ValueError, TypeError, KeyError):
            raise InputError(f"{path}: a line is damaged; correct it or move the file away") from None


def append_rows(file: TextIO, rows: Iterable[dict[str, Any]]) -> None:
    """Write rows that are on the disk before this returns.

    Parameters
    ----------
    file : text file
        Open for appending.
    rows : iterable of dict
        Plain values.
    """
    file.writelines(json.dumps(row) + "\n" for row in rows)
    file.flush()
    os.fsync(file.fileno())
