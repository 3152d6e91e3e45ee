"""A map of what falls when single blocks are taken out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.errors import known_options
from blockstat.typing import Floats
from blockstat.view.plot import Place, plot

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A block moves in a mechanism when it is faster than this share of the fastest.
MOVES = 0.01


def weight_lost(assembly: Assembly, found: dict[str, Verdict]) -> Floats:
    """Return the weight of the blocks that move when each block is taken out.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    found : dict of str to Verdict
        What `blockstat.remove_each` returns.

    Returns
    -------
    array of float, shape (n_blocks,)
        Share of the weight of all free blocks in the mechanism that was found, 0 where the rest stands, nan where that
        is undecided, and for blocks that were not tried.
    """
    lost = np.full(assembly.n_blocks, np.nan)
    total = assembly.mass[assembly.free].sum()
    for name, verdict in found.items():
        block = assembly.names.index(name)
        if verdict.outcome is Outcome.STABLE:
            lost[block] = 0.0
        elif verdict.outcome is Outcome.UNSTABLE:
            lost[block] = assembly.mass[verdict.motion > MOVES].sum() / total
    return lost


@known_options
def plot_removal(assembly: Assembly, found: dict[str, Verdict], place: Place, **options: Any) -> Place:
    """Draw each block in the colour of the weight that falls with it when it is taken out.

    Parameters
    ----------
    assembly : Assembly
        All blocks.
    found : dict of str to Verdict
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
