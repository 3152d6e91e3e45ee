"""What every solver returns, before our own code has checked anything."""

from __future__ import annotations

from dataclasses import dataclass

from blockstat.polyhedron import Floats


@dataclass(frozen=True)
class RawSolution:
    """A candidate answer in the units of the program; nothing in it is trusted."""

    force: Floats  #: f, shape (m, 3)
    adhesion: Floats  #: s, shape (m,)
    twist: Floats  #: u, shape (6 n,)
    bounded: bool  #: False when no adhesion is enough; then `twist` is a ray along which the work grows
    status: str  #: the solver's own word, for the record only
    iterations: int
