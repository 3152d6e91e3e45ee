"""Ties and struts: one bounded unknown each, a force along the line between two blocks.

The force T of a tie pulls its two blocks together, least <= T <= greatest. It enters the programs as a column of three
after those of the bonds. Only its first component is a force:

    f_n = T along the line, from block b to block a;   the other two act on nothing.

In the dual, a mechanism that lengthens the tie costs greatest x rate; one that shortens it gains least x rate. A tie
whose force is given is a load.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from blockstat.errors import InputError
from blockstat.joint import Tie
from blockstat.loads import on_block
from blockstat.program.equilibrium import Columns, wrenches_between
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


def tied_pairs(assembly: Assembly) -> Ints:
    """Return the blocks of each tie.

    Parameters
    ----------
    assembly
        The blocks and their ties.

    Returns
    -------
    Ints
        Shape (n_ties, 2).
    """
    pairs = [assembly.blocks_named(tie.between, tie.label) for tie in assembly.ties]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def bearing_ties(assembly: Assembly) -> tuple[Tie, ...]:
    """Return the ties that act on a block that is no support.

    Parameters
    ----------
    assembly
        The blocks and their ties.

    Returns
    -------
    tuple of Tie
        In their order; a tie between two supports is not among them.
    """
    pairs = zip(assembly.ties, tied_pairs(assembly), strict=True)
    return tuple(tie for tie, pair in pairs if not assembly.support[pair].all())


def check_anchors(assembly: Assembly) -> None:
    """Check that the ends of ties are on their blocks; the ground may be anywhere.

    Parameters
    ----------
    assembly
        The blocks and their ties.

    Raises
    ------
    InputError
        Naming the tie and the block.
    """
    for tie, pair in zip(assembly.ties, tied_pairs(assembly), strict=True):
        for block, point in zip(pair.tolist(), tie.points, strict=True):
            place = np.asarray(point, dtype=float)
            if not assembly.support[block] and not on_block(assembly, block, place):
                raise InputError(f'{tie.label}: the point {place.tolist()} is not on block "{assembly.names[block]}"')


def tie_columns(assembly: Assembly, ties: Sequence[Tie]) -> Columns:
    """Return one column of three for each tie; only its first component is a force.

    Parameters
    ----------
    assembly
        The blocks.
    ties
        Those wanted.

    Returns
    -------
    Columns
        Of unit tension, or of unit compression of struts.
    """
    n = len(ties)
    ends = np.array([tie.points for tie in ties], dtype=float).reshape(n, 2, 3)
    line = ends[:, 1] - ends[:, 0]
    sign = np.array([1.0 if tie.strut else -1.0 for tie in ties])
    force = np.zeros((n, 3, 3))
    force[:, 0] = (sign / np.linalg.norm(line, axis=1))[:, None] * line
    pairs = np.array([assembly.blocks_named(tie.between, tie.label) for tie in ties], dtype=np.int64).reshape(-1, 2)
    return Columns(point=ends[:, 1], pair=pairs, force=force)


def given_wrenches(assembly: Assembly) -> Floats:
    """Return what the ties whose forces are given do to the blocks.

    Parameters
    ----------
    assembly
        The blocks and their ties.

    Returns
    -------
    Floats
        Wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].
    """
    given = [tie for tie in assembly.ties if tie.constant]
    return tie_wrenches(assembly, given, np.array([tie.least for tie in given]))


def tie_wrenches(assembly: Assembly, ties: Sequence[Tie], force: Floats) -> Floats:
    """Return what ties do to the blocks.

    Parameters
    ----------
    assembly
        The blocks.
    ties
        The ties.
    force
        Tension, or compression of struts, shape (n_ties,) [N].

    Returns
    -------
    Floats
        Wrench on each block about its centroid, shape (n_blocks, 6) [N, N m].
    """
    columns = tie_columns(assembly, ties)
    return wrenches_between(assembly, columns.pair, columns.point, force[:, None] * columns.force[:, 0])
