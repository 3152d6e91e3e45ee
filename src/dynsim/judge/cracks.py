"""Joints that opened or slid in a run, counted by group."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces, find_interfaces
from blockstat.errors import known_options
from blockstat.result import Result, Sentence
from blockstat.typing import Floats, Ints

#: A joint is cracked when it has opened or slid by more than this share of the smaller of its two blocks.
CRACK = 1e-2


class CrackOutcome(Sentence):
    """Whether joints cracked; the value of each is the sentence that a user reads."""

    SOUND = "Sound: no joint opened or slid by more than its threshold."
    CRACKED = "Cracked: joints opened or slid by more than their threshold."


@dataclass(frozen=True, eq=False)
class Cracks(Result):
    """All joints of an assembly but those of blocks taken out, and how far each has opened and slid since release."""

    assembly: Assembly
    pair: Ints  #: shape (n_interfaces, 2), blocks a < b
    opening: Floats  #: shape (n_interfaces,) [m], of the corner that opened most; 0 for none
    slip: Floats  #: shape (n_interfaces,) [m], of the corner that slid furthest
    threshold: Floats  #: shape (n_interfaces,) [m], from which a joint counts as cracked

    @cached_property
    def cracked(self) -> np.ndarray:
        """Whether each joint is cracked, shape (n_interfaces,) bool."""
        return (self.opening > self.threshold) | (self.slip > self.threshold)

    @property
    def outcome(self) -> CrackOutcome:
        """Whether a joint is cracked."""
        return CrackOutcome.CRACKED if self.n_cracks else CrackOutcome.SOUND

    @property
    def n_cracks(self) -> int:
        """Number of cracked joints."""
        return int(self.cracked.sum())

    def per_group(self) -> dict[str, int]:
        """Return the number of cracked joints by group.

        Returns
        -------
        dict of str to int
            Joints within a group under its name, joints between two groups under "a | b"; most cracks first.
        """
        groups = self.assembly.groups
        counts = Counter(" | ".join(sorted({groups[a], groups[b]})) for a, b in self.pair[self.cracked])
        return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))

    def explain(self, limit: int = 5) -> str:
        """Return the number of cracks in words, with the groups that cracked most.

        Parameters
        ----------
        limit : int
            How many groups are named at most.

        Returns
        -------
        str
            One line of plain text.
        """
        rows = list(self.per_group().items())
        text = ", ".join(f"{f'{name} {count}' if name else f'{count} without a group'}" for name, count in rows[:limit])
        more = f" and {len(rows) - limit} more groups" if len(rows) > limit else ""
        count = f"Cracks: {self.n_cracks} of {len(self.pair)} joints"
        return f"{count} ({text}{more})." if rows else f"{count}."

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "cracks": self.per_group(),
            "n_cracks": self.n_cracks,
            "n_interfaces": len(self.pair),
        }


@known_options
def find_cracks(
    assembly: Assembly,
    before: tuple[Floats, Floats],
    after: tuple[Floats, Floats],
    *,
    threshold: float | None = None,
    interfaces: Interfaces | None = None,
    removed: Ints | None = None,
) -> Cracks:
    """Return the opening and the slip of each joint between two poses.

    Parameters
    ----------
    assembly : Assembly
        The blocks as built.
    before, after : tuple of two arrays
        Displacement of the centroids from where they were built, shape (n_blocks, 3) [m], and rotation since built,
        shape (n_blocks, 3, 3).
    threshold : float, optional
        Opening or slip from which a joint is cracked [m]; None: a hundredth of the size of its smaller block.
    interfaces : Interfaces, optional
        Joints of the assembly; searched for when None.
    removed : array of int, optional
        Blocks that were taken out: their joints are gone and do not count.

    Returns
    -------
    Cracks
        All joints that are left, and which of them are cracked.

    Examples
    --------
    >>> import numpy as np
    >>> from blockstat import Assembly, box
    >>> from dynsim import find_cracks
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> still, upright = np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1))
    >>> lifted = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.01]])
    >>> found = find_cracks(pillar, (still, upright), (lifted, upright))
    >>> found.outcome.word, found.opening.round(6).tolist(), found.slip.round(6).tolist()
    ('cracked', [0.01], [0.0])
    """
    faces = find_interfaces(assembly) if interfaces is None else interfaces
    if removed is not None and len(removed):
        faces = faces.subset(np.flatnonzero(~np.isin(faces.pair, removed).any(axis=1)))
    relative = _jump(assembly, faces, *after) - _jump(assembly, faces, *before)
    index = faces.point_interface
    normal = faces.frame[index, 0]
    along = np.einsum("ij,ij->i", relative, normal)
    across = np.linalg.norm(relative - along[:, None] * normal, axis=1)
    opening, slip = np.zeros((2, faces.n_interfaces))
    np.maximum.at(opening, index, along)
    np.maximum.at(slip, index, across)
    limit = CRACK * assembly.size[faces.pair].min(axis=1) if threshold is None else np.full(len(opening), threshold)
    return Cracks(assembly, faces.pair, opening, slip, limit)


def _jump(assembly: Assembly, faces: Interfaces, displacement: Floats, rotation: Floats) -> Floats:
    """Where block b has taken each contact point less where block a has, shape (n_points, 3) [m], in the frame of a.

    Seen from block a, so that a joint which turns as a whole neither opens nor slides.
    """
    a, b = faces.pair[faces.point_interface].T
    centre = assembly.centroid

    def moved(block: Ints) -> Floats:
        return (
            centre[block] + displacement[block] + np.einsum("nij,nj->ni", rotation[block], faces.point - centre[block])
        )

    return np.einsum("nji,nj->ni", rotation[a], moved(b) - moved(a))
