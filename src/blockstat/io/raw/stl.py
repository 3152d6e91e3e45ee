"""STL as text: solids between lines "solid NAME" and "endsolid NAME".

trimesh looks for these words anywhere, in names too, and leaves out a solid without an end.
"""

from __future__ import annotations

import re
from itertools import count
from pathlib import Path

from blockstat.errors import InputError

#: A line that begins or ends a solid; a byte order mark may stand before the first.
LINE = re.compile(rb"^(?:\xef\xbb\xbf)?[ \t]*(end)?solid(?=\s|$)[ \t]*([^\r\n]*)", re.MULTILINE | re.IGNORECASE)
HEAD, FACET = 84, 50  #: bytes of a binary file before its first facet, and of a facet
FILL = 4  #: blank bytes or zeros that may follow the last facet of a binary file


def numbered(data: bytes) -> bytes:
    r"""Return an STL with its solids named by their numbers, from which `names` tells what they are called.

    Parameters
    ----------
    data : bytes
        The file.

    Returns
    -------
    bytes
        The facets of a binary file as they are.

    Raises
    ------
    InputError
        For a text that ends before its last solid does, and a binary file with fewer facets than it says.

    Examples
    --------
    >>> numbered(b"solid a wall\nendsolid a wall\nsolid\nendsolid\n").split(b"\n")
    [b'solid 0', b'endsolid', b'solid 1', b'endsolid', b'']
    """
    if binary := _binary(data):
        return binary
    if b"\0" in data and not LINE.search(data):
        _check_whole(data)
    ends = [found[1] is not None for found in LINE.finditer(data)]
    begun, ended = ends.count(False), ends.count(True)
    if begun != ended:
        raise InputError(f'it is cut short: {begun} lines begin with "solid" and {ended} with "endsolid"')
    numbers = count()
    return LINE.sub(lambda found: b"endsolid" if found[1] else b"solid %d" % next(numbers), data)


def names(path: Path) -> list[str]:
    """Return what the solids of an STL are called.

    Parameters
    ----------
    path : Path
        A file that `numbered` takes.

    Returns
    -------
    list of str
        One for each solid of a text, "" for none; binary files name nothing.
    """
    data = path.read_bytes()
    if _binary(data):
        return []
    return [found[2].decode("utf-8", "replace").strip() for found in LINE.finditer(data) if not found[1]]


def is_binary(path: Path) -> bool:
    """Return whether an STL holds numbers of single precision and no text.

    Parameters
    ----------
    path : Path
        A file that `numbered` takes.

    Returns
    -------
    bool
    """
    return bool(_binary(path.read_bytes()))


def _check_whole(data: bytes) -> None:
    """Raise InputError for a binary file that is cut short."""
    said, held = int.from_bytes(data[80:HEAD], "little"), (len(data) - HEAD) // FACET
    if len(data) < HEAD:
        raise InputError(
            f"it is cut short: it has {len(data)} bytes, and a binary STL begins with {HEAD} before a facet"
        )
    if held < said:
        raise InputError(f"it is cut short: it says that it has {said} facets, and holds {held}")


def _binary(data: bytes) -> bytes:
    """What a binary file holds: 80 bytes, the number of facets, and 50 bytes a facet; nothing of a text.

    Some exporters fill up the last word or line; longer ends are more facets than the file says.
    """
    size = HEAD + FACET * int.from_bytes(data[80:HEAD], "little")
    filled = 0 <= len(data) - size <= FILL and not data[size:].strip(b"\0 \t\r\n")
    return data[:size] if filled else b""
