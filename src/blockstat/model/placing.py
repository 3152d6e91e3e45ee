"""Elements put in place and assembled."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from blockstat.assembly import Assembly, Block
from blockstat.errors import InputError, no_such
from blockstat.typing import Floats


def moved(
    blocks: Iterable[Block],
    by: Sequence[float] = (0.0, 0.0, 0.0),
    *,
    turn: float = 0.0,
    prefix: str = "",
    density: float | None = None,
) -> list[Block]:
    """Blocks turned about the vertical through the origin and then moved.

    Parameters
    ----------
    blocks : iterable of Block
        They are not changed.
    by : sequence of float
        Displacement, shape (3,) [m].
    turn : float
        Counter-clockwise seen from above [degrees].
    prefix : str
        Put in front of names and groups ("nave." makes "nave.vault.north"), so that an element can be used more than
        once. One block without a name is called "nave"; several have their numbers, "nave.block3".
    density : float, optional
        Of the blocks that have none of their own [kg/m3].

    Returns
    -------
    list of Block
        In the same order.
    """
    blocks = list(blocks)
    if not (turn or any(by) or prefix or density):
        return blocks
    matrix = rotation(turn).T if turn else None
    step = np.asarray(by, dtype=float) if any(by) else None
    placed = []
    for block, label in zip(blocks, _labels(blocks, prefix), strict=True):
        vertices = np.asarray(block.vertices, dtype=float)
        vertices = vertices if matrix is None else vertices @ matrix
        vertices = vertices if step is None else vertices + step
        group = (prefix + block.group).rstrip(".")
        placed.append(Block(vertices, block.faces, label, group, density if block.density is None else block.density))
    return placed


def _labels(blocks: Sequence[Block], prefix: str) -> list[str]:
    """Names with a prefix; where several blocks have none, these have their numbers, as in an assembly."""
    names = [block.name for block in blocks]
    taken = set(names)
    if prefix and names.count("") > 1:
        for number in (i for i, name in enumerate(names) if not name):
            label = f"block{number}"
            while label in taken:
                label += "_"
            names[number] = label
    return [(prefix + name).rstrip(".") for name in names]


def rotation(turn: float) -> Floats:
    """The matrix that turns columns about the vertical; quarter turns are without rounding.

    Parameters
    ----------
    turn : float
        Counter-clockwise seen from above [degrees].

    Returns
    -------
    ndarray
        Shape (3, 3).
    """
    # Quarter turns without rounding: faces that matched still do.
    quarter, rest = divmod(turn, 90.0)
    angle = np.deg2rad(turn)
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[int(quarter) % 4] if rest == 0 else (np.cos(angle), np.sin(angle))
    return np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)], dtype=float)


def assemble(blocks: Iterable[Block], *, supports: str | Sequence[str] = "springer", **options: Any) -> Assembly:
    """An assembly of elements in which whole groups are supports.

    Parameters
    ----------
    blocks : iterable of Block
        All of the assembly.
    supports : str or sequence of str
        Groups that cannot move, each with its subgroups.
    **options
        Those of `Assembly.from_blocks`.

    Returns
    -------
    Assembly
        With the blocks in the order given.

    Raises
    ------
    InputError
        When a group has no blocks.

    Examples
    --------
    >>> from blockstat.model import arch, assemble
    >>> assemble(arch(span=2.0, thickness=0.3, depth=0.5, voussoirs=5, springers=0.2)).n_blocks
    7
    """
    blocks = list(blocks)
    wanted = [supports] if isinstance(supports, str) else list(supports)
    fixed: list[int | str] = []
    for group in wanted:
        found = [i for i, b in enumerate(blocks) if b.group == group or b.group.startswith(group + ".")]
        if not found:
            raise InputError(f"supports: {no_such('group', group, sorted({b.group for b in blocks if b.group}))}")
        fixed += found
    return Assembly.from_blocks(blocks, supports=fixed, **options)
