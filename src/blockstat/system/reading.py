"""Text from files that may be anything: pipes, devices, other encodings, and nests without end."""

from __future__ import annotations

import json
import re
import stat
from pathlib import Path
from typing import Any

from blockstat.errors import InputError

MOST_BYTES = 1_000_000_000  #: a text takes some ten times as much memory once it is read
#: Tables and lists in one another; the deepest that programs write are trees of elements.
DEEPEST = 100
#: Halves of UTF-16 pairs, which no encoding can write, and controls that move a terminal's cursor.
UNWRITABLE = re.compile("[\ud800-\udfff\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]")


def check_file(path: Path) -> None:
    """Check that a file can be read to its end.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    InputError
        For a file that does not exist, a pipe, a device, or one of more than `MOST_BYTES`.
    """
    try:
        found = path.stat()
    except (OSError, ValueError):
        own = path.parent.name == "examples" and path.suffix == ".toml"
        how = f"; blockstat example {path.stem} -o {path} writes it, if it comes with blockstat" if own else ""
        raise InputError(f"{path}: no such file{how}") from None
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"{path}: is no file but a {'directory' if path.is_dir() else 'pipe or a device'}")
    if found.st_size > MOST_BYTES:
        raise InputError(f"{path}: has {found.st_size / 1e9:.3g} GB; at most {MOST_BYTES / 1e9:g} GB are read")


def text_of(path: Path) -> str:
    """Return the text of a file in UTF-8, without a byte order mark.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str
        Line ends are those of Unix.

    Raises
    ------
    InputError
        As `check_file`, and for another encoding.
    """
    check_file(path)
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None


def json_of(path: Path) -> Any:
    """Return what a JSON file in UTF-8 holds.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    object
        Plain data, not yet checked.

    Raises
    ------
    InputError
        As `text_of`, for bad JSON with its line, and for lists and tables that are nested too deeply.
    """
    text = text_of(path)
    try:
        data = json.loads(text)
        check_depth(data)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InputError(f"{path}: {where}: not valid JSON ({error.msg})") from None
    except RecursionError:
        raise InputError(f"{path}: the JSON is nested too deeply") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except ValueError:  # Python reads no integer of so many digits
        raise InputError(f"{path}: holds a number of thousands of digits") from None
    return data


def check_depth(data: Any) -> None:
    """Check that tables and lists are not nested without end, with a loop that needs no stack.

    Parameters
    ----------
    data : object
        Plain data.

    Raises
    ------
    InputError
        For more than `DEEPEST` in one another.
    """
    level = [data]
    for _ in range(DEEPEST):
        level = [child for node in level for child in _children(node) if isinstance(child, (dict, list))]
        if not level:
            return
    raise InputError(f"tables and lists are nested more than {DEEPEST} deep")


def _children(node: Any) -> Any:
    return node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()


def check_words(what: str, words: tuple[str, ...]) -> None:
    r"""Check that names can be written to files and shown on a terminal.

    Parameters
    ----------
    what : str
        What the names are of, in the singular.
    words : tuple of str
        The names.

    Raises
    ------
    InputError
        For one with a lone surrogate or a control character. Tabs and line breaks are allowed.

    Examples
    --------
    >>> check_words("block", ("stone\x1b[2J",))
    Traceback (most recent call last):
    ...
    blockstat.errors.InputError: the name of block 0, 'stone\x1b[2J', holds a character that cannot be written
    """
    if not UNWRITABLE.search("\n".join(words)):
        return
    number = next(i for i, word in enumerate(words) if UNWRITABLE.search(word))
    raise InputError(f"the name of {what} {number}, {words[number][:40]!a}, holds a character that cannot be written")
