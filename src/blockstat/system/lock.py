"""One program at a time in an output directory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from blockstat.errors import InputError

NAME = ".blockstat-lock"


@contextmanager
def locked(directory: str | Path, *, name: str = NAME) -> Iterator[None]:
    """Keep a directory to this process while the body of a `with` statement runs.

    The system frees the lock when the process ends, however it ends.

    Parameters
    ----------
    directory : str or Path
        It exists.
    name : str, optional
        Of the file that is locked, for a lock on less than the directory.

    Raises
    ------
    InputError
        When another process has the directory, with its number.
    """
    path = Path(directory) / name
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        try:
            _take(handle)
        except OSError:
            owner = os.pread(handle, 20, 0).decode("ascii", "replace").strip() if hasattr(os, "pread") else ""
            who = f"process {owner}" if owner.isdigit() else "another process"
            message = f"{directory}: {who} writes there; wait for its end, or choose another directory"
            raise InputError(message) from None
        os.ftruncate(handle, 0)
        os.write(handle, f"{os.getpid()}\n".encode())
        yield
    finally:
        os.close(handle)


def _take(handle: int) -> None:
    """Lock an open file, or raise OSError at once."""
    try:
        import fcntl
    except ImportError:  # Windows
        import msvcrt

        # A byte far behind the number, so that the number can be read while it is locked.
        os.lseek(handle, 1 << 20, os.SEEK_SET)
        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        os.lseek(handle, 0, os.SEEK_SET)
    else:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
