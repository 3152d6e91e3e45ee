"""Files are written beside their place and renamed: whoever looks finds the old file or the new one, never a half."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex

from blockstat.errors import InputError


def check_writable(path: Path) -> None:
    """Refuse a file that cannot be written; better asked before long work than after.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    InputError
        For a directory, and as `check_directory` does.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a directory; a file is needed")
    check_directory(path)


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """Give a place to write to, which takes the place of a file when the body of a `with` statement ends well.

    Parameters
    ----------
    path : str or Path
        The file to be; one that is there is kept until the new one is complete. A device is written directly.

    Yields
    ------
    Path
        In the same directory and with the same suffix.

    Raises
    ------
    InputError
        When the disk is full or refuses; it names the file, and says whether an old one is kept.

    Examples
    --------
    >>> with written_whole("note.txt") as place:
    ...     _ = place.write_text("done")
    >>> Path("note.txt").read_text()
    'done'
    """
    path = Path(path)
    final, beside = _places(path)
    if beside is None:
        yield path
        return
    try:
        try:
            yield beside
            if beside.exists():
                _settle(beside, final)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        kept = "; the file that was there is kept" if final.exists() else ""
        raise InputError(f"{path}: cannot be written ({error.strerror or error}){kept}") from None


def check_directory(path: str | Path) -> None:
    """Refuse a file in a directory that takes none; better asked before long work than after.

    Parameters
    ----------
    path : str or Path
        The file to be.

    Raises
    ------
    InputError
        When its directory does not exist, or no file can be made in it.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: no such directory: {path.parent}")
    _, beside = _places(path)
    if beside is None:
        return
    try:
        beside.touch()
        beside.unlink()
    except OSError as error:
        raise InputError(f"{path}: no file can be written in {beside.parent} ({error.strerror or error})") from None


def _places(path: Path) -> tuple[Path, Path | None]:
    """The file that a path means, and a new one beside it; None beside a device, which is written directly."""
    final = path.resolve() if path.is_symlink() else path
    if final.exists() and not final.is_file():
        return final, None
    return final, final.with_name(f".{final.stem[:40]}-{token_hex(4)}{final.suffix}")


def _settle(beside: Path, final: Path) -> None:
    with beside.open("rb") as file:
        os.fsync(file.fileno())
    if final.exists():
        shutil.copymode(final, beside)
    os.replace(beside, final)
