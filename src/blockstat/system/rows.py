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


def kept_rows(path: Path, head: dict[str, Any], make: Callable[[Any], T], *, other: str) -> list[T]:
    """Read the rows of a file; a new one gets its first line, and a last line cut short by a kill is dropped.

    Parameters
    ----------
    path : Path
        The file.
    head : dict
        What the rows are of, plain values.
    make : callable
        Makes an object of a row.
    other : str
        What the rows are where the first line is another, for the error.

    Returns
    -------
    list
        What `make` returns, in the order of the file.

    Raises
    ------
    InputError
        For a file of something else, or a damaged line. The file is then left as it is.
    """
    first = f"{json.dumps(head)}\n".encode()
    data = path.read_bytes() if path.is_file() else b""
    whole = data[: data.rfind(b"\n") + 1]
    if not whole and first.startswith(data):
        with written_whole(path) as place:
            place.write_bytes(first)
        return []
    found, rows = _parsed(path, whole, make)
    if found != head:
        raise InputError(f"{path}: these are {other}; move the file away or choose another")
    if whole != data:
        os.truncate(path, len(whole))
    return rows


def read_rows(path: Path, make: Callable[[Any], T]) -> tuple[Any, list[T]]:
    """Read the first line and the rows of a file.

    Parameters
    ----------
    path : Path
        The file.
    make : callable
        Makes an object of a row.

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
    return _parsed(path, path.read_bytes(), make)


def _parsed(path: Path, data: bytes, make: Callable[[Any], T]) -> tuple[Any, list[T]]:
    """The first line and the rows of what a file holds."""
    try:
        head, *rows = map(json.loads, data.splitlines())
        return head, [make(row) for row in rows]
    except (ValueError, TypeError, KeyError, RecursionError):
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
