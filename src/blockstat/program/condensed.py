"""The program of an assembly in which some blocks move as one body.

With T the wrenches of blocks about the middle of their body, summed by body, the program has T A for its matrix and T w
for its load, without the columns of joints within a body. A motion of the bodies, u = T'v, is one of the blocks. So a
mechanism of the condensed program is one of the whole, and its multiplier an upper bound; its forces leave open whether
the joints within the bodies hold.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from blockstat.geometry.components import connected_components
from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats, Ints


@dataclass(frozen=True, eq=False)
class Bodies:
    """Blocks of a program that move as one."""

    whole: PenaltyProgram
    body: Ints  #: of each block, from 0 without gaps, -1 for those that do not move, shape (n,)
    centroid: Floats  #: of each block, shape (n, 3), in lengths of the program

    @cached_property
    def number(self) -> int:
        """How many bodies move."""
        return int(self.body.max(initial=-1)) + 1

    @cached_property
    def columns(self) -> Ints:
        """The columns of three of the whole program that are between two bodies."""
        one, two = np.append(self.body, -1)[self.whole.point_blocks].T
        return np.flatnonzero(one != two)

    @cached_property
    def _wrench(self) -> Floats:
        """T of each block, shape (n, 6, 6): a force has a moment about the middle of the body."""
        moves = self.body >= 0
        number = np.bincount(self.body[moves], minlength=self.number)
        middle = np.zeros((self.number, 3))
        np.add.at(middle, self.body[moves], self.centroid[moves])
        arm = np.where(moves[:, None], self.centroid - (middle / number[:, None])[self.body], 0.0)
        found = np.tile(np.eye(6), (len(arm), 1, 1))
        found[:, 3:, :3] = np.cross(arm[:, None], np.eye(3)).transpose(0, 2, 1)
        return found

    @cached_property
    def program(self) -> PenaltyProgram:
        """The condensed program."""
        whole, columns = self.whole, self.columns
        block = whole.point_blocks[columns]
        local = whole.local.reshape(-1, 3, 2, 6)[columns]
        local = np.einsum("nsij,nksj->nksi", self._wrench[block], local)  # zeros for a support meet any block
        n_points = int((columns < whole.n_points).sum())
        point_blocks = np.append(self.body, -1)[block]
        local *= (point_blocks >= 0)[:, None, :, None]
        return replace(
            whole, local=local.reshape(-1, 12), load=self.loads(whole.load), point_blocks=point_blocks,
            n_points=n_points, plane=None,
            **{name: getattr(whole, name)[columns] for name in ("friction", "shift", "lower", "upper")},
        )  # fmt: skip

    def loads(self, load: Floats) -> Floats:
        """Return loads on blocks as loads on bodies.

        Parameters
        ----------
        load
            In the units of the program, shape (6 n,).

        Returns
        -------
        Floats
            Shape (6 n_bodies,).
        """
        moves, found = self.body >= 0, np.zeros((self.number, 6))
        np.add.at(found, self.body[moves], np.einsum("nij,nj->ni", self._wrench, load.reshape(-1, 6))[moves])
        return found.reshape(-1)

    def twists(self, twist: Floats) -> Floats:
        """Return a motion of the bodies as one of the blocks.

        Parameters
        ----------
        twist
            Of the condensed program, shape (6 n_bodies,).

        Returns
        -------
        Floats
            Shape (6 n,).
        """
        own = np.concatenate([twist.reshape(-1, 6), np.zeros((1, 6))])[self.body]
        return np.einsum("nji,nj->ni", self._wrench, own).reshape(-1)


def moving_as_one(support: np.ndarray, pair: Ints, rate: Floats, still: float) -> Ints:
    """Return which blocks move as one.

    Parameters
    ----------
    support
        Which blocks are supports, shape (n,) bool.
    pair
        The two blocks of each contact point, shape (m, 2).
    rate
        Of one against the other there, shape (m, 3).
    still
        Joints whose points all move by less than this, where the fastest moves at 1, do not.

    Returns
    -------
    array of int
        Body of each block, -1 for those that do not move, shape (n,).
    """
    n, speed = len(support), np.abs(rate).max(axis=1, initial=0.0)
    found, joint = np.unique(pair, axis=0, return_inverse=True)
    fastest = np.zeros(len(found))
    np.maximum.at(fastest, joint.reshape(-1), speed)
    held = np.flatnonzero(support)
    ground = np.column_stack([held, np.roll(held, 1)])
    _, label = connected_components(n, np.concatenate([found[fastest <= still * speed.max(initial=0.0)], ground]))
    at_rest = label == label[held[0]]
    body: Ints = np.where(at_rest, -1, np.unique(np.where(at_rest, -1, label), return_inverse=True)[1] - 1)
    return body
