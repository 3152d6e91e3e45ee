"""Several files of the command line side by side."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from blockstat.cli.progress import at_work
from blockstat.errors import InputError, InputWarning

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from dynsim.comparison.table import Comparison, Comparisons
    from dynsim.judge.verdict import DynamicVerdict
    from dynsim.parallel.pool import Row

T = TypeVar("T")


def side_by_side(
    files: list[Path],
    read: Callable[[Path], Assembly],
    function: Callable[[Assembly], T],
    jobs: int | None,
    timeout: float | None,
    save: Callable[[list[Row[T]]], None] | None = None,
) -> list[Row[T]]:
    """Apply a function to the assembly of every file, one row a file.

    A file that cannot be read loses its own row only.

    Parameters
    ----------
    files : list of Path
        The files.
    read : callable
        Reads a file.
    function : callable
        Called with each assembly, in a process of its own.
    jobs : int or None
        Processes at a time; all cores when None.
    timeout : float or None
        Time by the clock that one file may take [s]; None for no bound.
    save : callable, optional
        Called with all rows after each one that is done.

    Returns
    -------
    list of Row
        In the order of the files.

    Raises
    ------
    InputError
        For a path where nothing is, before any file is read.
    """
    from dynsim.parallel.pool import INTERRUPTED, Row, run_many

    for file in files:
        if not _is_there(file):
            raise InputError(f"{file}: no such file")
    rows = [Row[T](file.stem, None, INTERRUPTED) for file in files]
    assemblies, number = [], []
    for i, file in enumerate(files):
        try:
            assemblies.append(read(file))
            number.append(i)
        except InputError as error:
            rows[i] = Row(file.stem, None, error.line)
        except OSError as error:
            rows[i] = Row(file.stem, None, f"{file}: {error.strerror or error}")
    with at_work(f"0/{len(assemblies)}") as say:
        done: list[int] = []

        def progress(index: int, row: Row[T]) -> None:
            done.append(index)
            rows[number[index]] = row
            for text in row.warnings:
                warnings.warn(InputWarning(f"{files[number[index]]}: {text}"), stacklevel=2)
            say(f"{len(done)}/{len(assemblies)} {files[number[index]].name}")
            if save is not None:
                save(rows)

        names = [files[i].stem for i in number]
        run_many(function, assemblies, names=names, jobs=jobs, timeout=timeout, progress=progress)
    if save is not None:
        save(rows)
    return rows


def _is_there(file: Path) -> bool:
    """Whether there may be a file; one in a directory that cannot be looked into loses its row as it is read."""
    try:
        return file.exists()
    except OSError:
        return True


def told_apart(files: list[Path], rows: list[Comparison]) -> list[Comparison]:
    """Return rows of which no two have the same name, unless a file is given twice.

    Parameters
    ----------
    files : list of Path
        The file of each row.
    rows : list of Comparison
        Named as the files say.

    Returns
    -------
    list of Comparison
        Rows with the same name are named by their files, and by the whole paths where file names agree too.
    """
    for name in (lambda file: file.stem, str):
        count = Counter(row.name for row in rows)
        rows = [
            replace(row, name=name(file)) if count[row.name] > 1 else row
            for file, row in zip(files, rows, strict=True)
        ]  # fmt: skip
    return rows


def end_of(rows: list[Row[Any]]) -> None:
    """End the command as interrupted when rows are missing for that, and as bad input when no file gave a result.

    Parameters
    ----------
    rows : list of Row
        All rows.

    Raises
    ------
    KeyboardInterrupt
        When a row was interrupted.
    InputError
        When no row has a result.
    """
    from dynsim.parallel.pool import INTERRUPTED

    if any(row.error == INTERRUPTED for row in rows):
        raise KeyboardInterrupt
    if all(row.result is None for row in rows):
        raise InputError("none of the files gave a verdict")


def verify_summary(row: Row[DynamicVerdict]) -> dict[str, Any]:
    """Return a verdict for JSON, or why there is none.

    Parameters
    ----------
    row : Row
        The result of one file.

    Returns
    -------
    dict of str to object
        Plain values.
    """
    if row.result is None:
        return {"verdict": None, "error": row.error}
    return row.result.summary()


def print_comparisons(rows: Comparisons) -> None:
    """Print a table on the terminal, and the notes below it.

    Parameters
    ----------
    rows : Comparisons
        One row a file.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from dynsim.comparison.table import Agreement

    table = Table(
        "name",
        "blocks",
        "faces",
        "static",
        "score",
        "s",
        "dynamic",
        *["LMGC90"] * rows.has_lmgc90,
        "Eq. 1 mm",
        "Eq. 2 mm",
        "moved mm",
        "s",
        "agree",
    )
    for row in rows:
        if row.static is None:
            table.add_row(Text(row.name), "", "", "no verdict")
            continue
        drops = [f"{1e3 * (value or 0.0):.3g}" for value in (row.group_drop, row.max_drop, row.max_displacement)]
        score = "inf" if row.score is None else f"{row.score:.2e}"
        agree = {Agreement.AGREE: "yes", Agreement.DIFFER: "NO"}.get(row.outcome, "-")
        table.add_row(
            Text(row.name), str(row.blocks), str(row.interfaces), row.static, score, f"{row.static_seconds:.2f}",
            row.dynamic, *[row.lmgc90 or "-"] * rows.has_lmgc90, *drops, f"{row.dynamic_seconds:.1f}", agree,
        )  # fmt: skip
    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    console.print(table)
    for row in rows:
        if row.note:
            console.print(f"{row.name}: {row.note}", highlight=False, markup=False, soft_wrap=True)
