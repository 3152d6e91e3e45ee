"""A journal of the states that a search has judged, so that it can be taken up again after any end.

Each line is one state and what came of it, written before the search goes on. The search itself is determined by these
outcomes. So it is run again from the beginning, and states in the journal cost nothing. A last line cut short is left
out.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.sequence.states import Whole


class Journal:
    """Outcomes of states on disk.

    Parameters
    ----------
    path : str or Path
        A file of lines of JSON; it is made if it is not there.
    whole : Whole
        The assembly with its joints.
    flow : str
        "associated" or "coulomb".

    Raises
    ------
    InputError
        For a file that is no journal, or that of another assembly, friction or flow.
    """

    def __init__(self, path: str | Path, whole: Whole, flow: str) -> None:
        self._path = Path(path)
        head = {"journal": "blockstat sequence", "of": _fingerprint(whole), "flow": flow}
        self.known: dict[tuple[int, int], Any] = {}  #: what `note` was given, by state
        try:
            lines = self._path.read_text().split("\n") if self._path.exists() else []
            if lines and self._read(lines[0]) != head:
                raise InputError(f"{path}: a journal of another assembly, friction or flow; give a new file")
            for line in lines[1:-1]:
                present, held, outcome = self._read(line)
                self.known[int(present, 16), int(held, 16)] = outcome
            kept = "\n".join([json.dumps(head), *lines[1:-1]]) + "\n"
            self._file = self._path.open("w" if kept != "\n".join(lines) else "a")
            if kept != "\n".join(lines):
                self._file.write(kept)
                self._file.flush()
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}") from None

    def _read(self, line: str) -> Any:
        try:
            return json.loads(line)
        except ValueError:
            raise InputError(f"{self._path}: not a journal of a search") from None

    def note(self, state: tuple[int, int], outcome: Any) -> None:
        """Write down what came of a state.

        Parameters
        ----------
        state : (int, int)
            Blocks present and held, as bits.
        outcome : object
            Anything that JSON can hold.
        """
        self._file.write(json.dumps([hex(state[0]), hex(state[1]), outcome]) + "\n")
        self._file.flush()


def _fingerprint(whole: Whole) -> str:
    """A digest of shapes, supports, joints and friction."""
    assembly, faces = whole.assembly, whole.interfaces
    digest = hashlib.sha256(repr((assembly.names, assembly.friction, assembly.gravity.tolist())).encode())
    for array in (assembly.vertices, assembly.support, assembly.mass, faces.pair, faces.point, faces.frame):
        digest.update(array.tobytes())
    return digest.hexdigest()
