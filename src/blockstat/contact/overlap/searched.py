"""The joints of an assembly, looked for once its blocks are known not to run into each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

from blockstat.contact.interfaces import GAP, Interfaces, find_interfaces, near_blocks
from blockstat.contact.overlap.penetration import check_copies, check_overlaps
from blockstat.typing import Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


def searched_joints(assembly: Assembly, gap: float | str = GAP) -> tuple[Interfaces, Ints, tuple[str, ...]]:
    """Find the joints of an assembly.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap : float or str, optional
        As in `blockstat.assess`.

    Returns
    -------
    interfaces : Interfaces
        The joints.
    overlapping : array of int, shape (n, 2)
        Pairs of blocks that overlap.
    warnings : tuple of str
        About these.

    Raises
    ------
    InputError
        When blocks are copies of each other, or overlap deeply.
    """
    check_copies(assembly)
    near = near_blocks(assembly, gap=gap)
    overlapping, told = check_overlaps(assembly, gap=gap, near=near)
    return find_interfaces(assembly, gap=gap, near=near), overlapping, tuple(told)
