"""A map of what falls when single blocks are taken out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import known_options
from blockstat.typing import Floats
from blockstat.view.plot import Place, plot

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.sequence.taking_down.removal import RemovalVerdict


def weight_lost(assembly: Assembly, found: dict[str, RemovalVerdict]) -> Floats:
    """Return the weight of the blocks that fall when each block is taken out.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    found : dict of str to RemovalVerdict
        What `blockstat.remove_each` returns.

    Returns
    -------
    array of float, shape (n_blocks,)
        Share of the weight of all free blocks, that of the block itself left out: 0 where the rest stands, nan where
        it is undecided which blocks fall, and for blocks that were not tried.
    """
    lost = np.full(assembly.n_blocks, np.nan)
    total = assembly.mass[assembly.free].sum()
    number = {name: k for k, name in enumerate(assembly.names)}
    for name, removal in found.items():
        if removal.falls is not None:
            lost[number[name]] = assembly.mass[[number[fallen] for fallen in removal.falls]].sum() / total
    return lost


@known_options
def plot_removal(assembly: Assembly, found: dict[str, RemovalVerdict], place: Place, **options: Any) -> Place:
    """Draw each block in the colour of the weight that falls when it is taken out.

    These are the blocks that cannot stand even if all others are held, and those that cannot once they are gone, until
    the rest stands (`RemovalVerdict.falls`). Nothing is hit by what comes down.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    found : dict of str to RemovalVerdict
        What `blockstat.remove_each` returns.
    place : str, Path or matplotlib Axes
        As of `blockstat.plot`.
    **options
        As of `blockstat.plot`.

    Returns
    -------
    str, Path or matplotlib Axes
        The place. Free blocks without an answer, not tried or undecided, are grey, and the label says so.

    Examples
    --------
    >>> from blockstat import Assembly, box, plot_removal, remove_each
    >>> blocks = [box((-1, 0, -1), (1, 1, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="low"),
    ...           box((0, 0, 1), (1, 1, 2), name="high")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plot_removal(assembly, remove_each(assembly), "removal.png")
    'removal.png'
    """
    lost = 100 * weight_lost(assembly, found)
    unknown = " (grey: not known)" if np.isnan(lost[assembly.free]).any() else ""
    drawn: dict[str, Any] = {
        "title": "taking out single blocks",
        "label": f"weight that falls with a block [%]{unknown}",
    }
    if not np.nan_to_num(lost).any():
        drawn["top"] = 100.0
    return plot(assembly, place, values=lost, **drawn | options)
