"""One program at a time in an output directory."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from blockstat.errors import InputError

NAME = ".blockstat-lock"


@contextmanager
def locked(directory: str | Path, *, name: str = NAME) -> Iterator[None]:
    """Keep a directory to this process while the body of a `with` statement runs.

    The system frees the lock when the process ends, however it ends. The file of the lock is removed at the end of the
    body, where the system removes files that are open (Windows does not); one that a killed process left is taken over.

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
    while (handle := _taken(path, directory)) is None:
        pass
    try:
        os.ftruncate(handle, 0)
        os.write(handle, f"{os.getpid()}\n".encode())
        yield
    finally:
        with suppress(OSError):
            path.unlink()  # while it is locked: who has opened it meanwhile sees that it is gone
        os.close(handle)


def _taken(path: Path, directory: str | Path) -> int | None:
    """Open a file and lock it; None where the file that was opened is no longer there: who had it has removed it.

    A lock on a file that is gone keeps nobody out, for the next one makes a new file. Only who has the lock removes the
    file, so one that is there once it is locked stays.
    """
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    is_there = False
    try:
        _take(handle)
        with suppress(FileNotFoundError):
            is_there = os.path.samestat(os.fstat(handle), path.stat())
    except OSError:
        owner = os.pread(handle, 20, 0).decode("ascii", "replace").strip() if hasattr(os, "pread") else ""
        who = f"process {owner}" if owner.isdigit() else "another process"
        message = f"{directory}: {who} writes there; wait for its end, or choose another directory"
        raise InputError(message) from None
    finally:
        if not is_there:
            os.close(handle)
    return handle if is_there else None


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
