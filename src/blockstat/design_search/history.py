"""The history of a search on disk: one line a judgement, written as it comes.

A design that statics allow and that is simulated only later gets a second line, which replaces the first.
"""

from __future__ import annotations

import csv
import hashlib
import os
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from blockstat.assembly import Assembly
from blockstat.design_search.candidate import Candidate
from blockstat.errors import InputError
from blockstat.spec import Scene
from blockstat.spec.composition import Composition

COLUMNS = (
    "static", "evidence", "score", "dynamic", "volume", "blocks", "reserve", "slopes",
    "static_seconds", "dynamic_seconds", "note",
)  # fmt: skip
SCENE = "scene"  #: last column: a digest of the scene, so that rows of another scene are never taken for its own

Key = tuple[float, ...]


def digest(scene: Scene, conditions: str) -> str:
    """Return a digest of what rows depend on besides their parameters.

    Parameters
    ----------
    scene : Scene
        It is digested with the content of the files that its elements name.
    conditions : str
        What else the verdicts depend on.

    Returns
    -------
    str
        Twelve hexadecimal digits.
    """
    found = hashlib.sha256(msgspec.json.encode(scene, order="sorted") + conditions.encode())
    for element in scene.elements.values() if isinstance(scene, Composition) else ():
        if isinstance(element.get("file"), str):
            found.update(_content(Path(element["file"])))
    return found.hexdigest()[:12]


def assembly_digest(assembly: Assembly) -> str:
    """Return a digest of all that a verdict depends on in an assembly, to the last digit.

    Parameters
    ----------
    assembly : Assembly
        Its name and its metadata do not count.

    Returns
    -------
    str
        Sixteen hexadecimal digits.
    """
    found = hashlib.sha256()
    for field in fields(assembly):
        value = getattr(assembly, field.name)
        if field.name not in ("name", "metadata"):
            plain = [value.dtype.str, value.shape] if isinstance(value, np.ndarray) else value
            found.update(f"{field.name} {plain!r}".encode())
            found.update(value.tobytes() if isinstance(value, np.ndarray) else b"")
    return found.hexdigest()[:16]


def _content(path: Path) -> bytes:
    """Hashes of a file, or of the files in a directory with their names; nothing for what is not there."""
    if path.is_dir():
        files = (own for own in sorted(path.rglob("*")) if own.is_file())
        return b"".join(bytes(own.relative_to(path)) + _content(own) for own in files)
    return hashlib.sha256(path.read_bytes()).digest() if path.is_file() else b""


class History:
    """A CSV file of candidates.

    Parameters
    ----------
    path : Path
        The file; it is made when it is first read.
    names : list of str
        The parameters, in the order of their columns.
    scene : str
        Digest of the scene and of the conditions of the search.
    """

    def __init__(self, path: Path, names: list[str], scene: str) -> None:
        self.path, self.names, self.scene = path, names, scene
        self.columns = [*names, *COLUMNS, SCENE]

    def read(self) -> dict[Key, Candidate]:
        """Read the rows of an earlier run, and begin the file where there is none.

        A last line cut short by a kill is dropped from the file.

        Returns
        -------
        dict of tuple to Candidate
            By the parameter values, in the order of the file; of two lines on one design the later counts.

        Raises
        ------
        InputError
            For a history of another search, or a damaged row.
        """
        if not self.path.is_file() or not self.path.stat().st_size:
            with self.path.open("w", newline="") as file:
                csv.writer(file).writerow(self.columns)
            return {}
        text = whole_lines(self.path)
        reader = csv.DictReader(text.splitlines())
        rows = list(reader)
        if not text:
            self.path.unlink()
            return self.read()
        if reader.fieldnames != self.columns or any(row[SCENE] != self.scene for row in rows):
            raise InputError(
                f"{self.path}: this history is of another search; move it away or choose another directory"
            )
        try:
            return {tuple(c.parameters.values()): c for c in map(self._candidate, rows)}
        except (ValueError, TypeError):
            raise InputError(f"{self.path}: a row is damaged; correct it or move the file away") from None

    def append(self, candidate: Candidate) -> None:
        """Write one line more, which is on the disk before this returns.

        Parameters
        ----------
        candidate : Candidate
            A judgement.
        """
        row: dict[str, Any] = {k: "" if v is None else v for k, v in asdict(candidate).items() if k in COLUMNS}
        row["slopes"] = " ".join(map(repr, candidate.slopes))
        row["note"] = " ".join(candidate.note.split())
        with self.path.open("a", newline="") as file:
            csv.DictWriter(file, self.columns).writerow({**candidate.parameters, **row, SCENE: self.scene})
            file.flush()
            os.fsync(file.fileno())

    def _candidate(self, row: dict[str, str]) -> Candidate:
        def number(name: str) -> float | None:
            return float(row[name]) if row[name] else None

        return Candidate(
            parameters={name: float(row[name]) for name in self.names},
            static=row["static"],
            score=number("score"),
            dynamic=row["dynamic"],
            volume=number("volume"),
            blocks=int(row["blocks"]) if row["blocks"] else None,
            static_seconds=float(row["static_seconds"]),
            dynamic_seconds=float(row["dynamic_seconds"]),
            note=row["note"],
            evidence=row["evidence"],
            reserve=number("reserve"),
            slopes=tuple(map(float, row["slopes"].split())),
        )


def whole_lines(path: Path) -> str:
    """Read a file of lines; what a kill left of a last line is first taken out of the file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str
        Its text, which ends with a line break or is empty.
    """
    text = path.read_text(errors="replace")
    if not text.endswith("\n"):
        text = text[: text.rfind("\n") + 1]
        replacement = path.with_suffix(".tmp")
        replacement.write_text(text)
        os.replace(replacement, path)
    return text
