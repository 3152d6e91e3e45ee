"""Ground-motion records from CSV files: a column of times [s] and one to three of accelerations."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blockstat.errors import InputError, check_number, check_vector
from blockstat.system.reading import text_of
from dynsim.loads.ground import Record

FORM = "a line holds a time [s] and one, two or three accelerations [m/s2], separated by commas, semicolons or blanks"

#: Units that a line of headings may have in brackets.
SECONDS, METRES = ("s", "sec", "seconds"), ("m/s2", "m/s^2", "m/s\u00b2", "m/s**2", "m s-2", "ms-2")
#: Units that a comment above the numbers names in brackets, as `numpy.savetxt` writes headings: of accelerations or
#: velocities, and of times that are not in s. Other words in brackets, such as a year, are no units.
OF_MOTION = re.compile(r"[%m]?\s*g|gals?|.*/\s*s(ec)?\s*(\^|\*\*)?\s*[2\u00b2]?|.*s\s*(\^|\*\*)?\s*-\s*[12]")
OTHER_TIMES = ("ms", "msec", "milliseconds", "minutes")
#: Along which one column acts unless another direction is given.
X = (1.0, 0.0, 0.0)


def read_record(path: str | Path, *, direction: Sequence[float] = X, scale: float = 1.0) -> Record:
    r"""Read a ground motion from a CSV file.

    A line holds a time [s] and one to three accelerations. Lines that start with # and one line of headings are passed
    over; units in brackets in the headings, or above the numbers in a line that starts with #, must be s, and m/s2
    unless a scale is given.

    Parameters
    ----------
    path : str or Path
        The file, text in UTF-8.
    direction : sequence of three floats
        Direction of a single column of accelerations; two columns are x and y, three are x, y and z, and take none.
    scale : float
        Factor on the accelerations to have them in m/s2: 9.81 for a file in g.

    Returns
    -------
    Record
        The motion, a load of `verify`.

    Raises
    ------
    InputError
        Naming the file and the line: for a bad number, a missing or surplus column, a time that does not grow, other
        units, or a direction of more than one column.

    Examples
    --------
    >>> from pathlib import Path
    >>> from dynsim import read_record
    >>> _ = Path("shake.csv").write_text("time,acceleration\n0.0,0.0\n0.1,2.0\n0.2,0.0\n")
    >>> read_record("shake.csv").acceleration.tolist()
    [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    """
    path = Path(path)
    along = check_vector("record: direction", direction)
    check_number("record: scale", scale)
    if scale == 0:
        raise InputError("record: scale is 0; it must be a number other than 0")
    rows = _rows(path, scaled=scale != 1.0)
    if len(rows) < 2:
        raise InputError(f"{path}: {len(rows)} lines of numbers; a record has at least two ({FORM})")
    table = np.array(rows)
    values = scale * table[:, 1:]
    if values.shape[1] == 1:
        values = values * (along / np.linalg.norm(along))
    elif (along != X).any():
        raise InputError(
            f"{path}: a direction is for one column of accelerations; "
            f"this record has {values.shape[1]}, along {'x and y' if values.shape[1] == 2 else 'x, y and z'}"
        )
    values = np.hstack([values, np.zeros((len(values), 3 - values.shape[1]))])
    if not values.any():
        raise InputError(f"{path}: the acceleration is 0 throughout")
    return Record(table[:, 0], values)


def _rows(path: Path, *, scaled: bool) -> list[list[float]]:
    text = text_of(path)
    rows: list[list[float]] = []
    headed = False
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        if words[0].startswith("#"):
            if not rows:
                _check_comment(line, scaled, f"{path}, line {number}")
            continue
        if not rows and not headed and not any(map(_is_number, words)):
            headed = True
            _check_units(line, scaled, f"{path}, line {number}")
            continue
        if ";" in line and "," in line:
            raise InputError(f"{path}, line {number}: commas and semicolons both; decimals are written with a point")
        rows.append(_row(words, f"{path}, line {number}", rows))
    return rows


def _check_units(heading: str, scaled: bool, where: str) -> None:
    """Refuse units in brackets that are not those read: of times, and of accelerations that no scale changes."""
    units = _bracketed(heading)
    if len(units) > 1 and units[0] not in SECONDS:
        raise _other_times(units[0], where)
    for unit in () if scaled else units[1:] or units:
        if unit not in {*SECONDS, *METRES}:
            raise _other_accelerations(unit, where)


def _check_comment(comment: str, scaled: bool, where: str) -> None:
    """Refuse what is known for a unit in the brackets of a comment, and is not one that is read."""
    for unit in _bracketed(comment):
        if unit in OTHER_TIMES:
            raise _other_times(unit, where)
        if not scaled and OF_MOTION.fullmatch(unit) and unit not in METRES:
            raise _other_accelerations(unit, where)


def _bracketed(line: str) -> list[str]:
    """What stands in brackets, in small letters."""
    return [words.strip().lower() for words in re.findall(r"[\[(]([^\])]*)[\])]", line)]


def _other_times(unit: str, where: str) -> InputError:
    return InputError(f'{where}: times are in "{unit}"; they must be in s')


def _other_accelerations(unit: str, where: str) -> InputError:
    return InputError(f'{where}: accelerations are in "{unit}"; they must be in m/s2, or have a scale')


def _row(words: list[str], where: str, before: list[list[float]]) -> list[float]:
    """One line as numbers, checked against those before it."""
    bad = [word for word in words if not _is_number(word) or not math.isfinite(float(word))]
    if bad:
        raise InputError(f'{where}: "{bad[0]}" is not a finite number; {FORM}')
    row = [float(word) for word in words]
    if not 2 <= len(row) <= 4:
        raise InputError(f"{where}: {len(row)} columns; {FORM}")
    if not before and row[0] < 0:
        raise InputError(f"{where}: the time is {row[0]:g}; a record starts at 0 or later")
    if before and len(row) != len(before[0]):
        raise InputError(f"{where}: {len(row)} columns where the lines above have {len(before[0])}")
    if before and row[0] <= before[-1][0]:
        raise InputError(f"{where}: the time {row[0]:g} does not come after {before[-1][0]:g}")
    return row


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
