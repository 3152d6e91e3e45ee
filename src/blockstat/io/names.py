"""Names of blocks as files give them: perhaps missing, perhaps the same for all."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence

from blockstat.errors import InputError, InputWarning


def distinct_names(names: Sequence[str], supports: Sequence[int | str]) -> list[str]:
    """Number the names that occur more than once: "Mesh" becomes "Mesh.0", "Mesh.1", ...

    Parameters
    ----------
    names : sequence of str
        Of the blocks; "" for none.
    supports : sequence of int or str
        Supports as they were given.

    Returns
    -------
    list of str
        One a block.

    Raises
    ------
    InputError
        When a support is given by a name that occurs more than once, because it says nothing.

    Warns
    -----
    InputWarning
        Where a name occurs more than once.

    Examples
    --------
    >>> distinct_names(["ground", "", ""], supports=["ground"])
    ['ground', '', '']
    """
    count = Counter(name for name in names if name)
    repeated = {name for name, times in count.items() if times > 1}
    if not repeated:
        return list(names)
    for support in supports:
        if support in repeated:
            raise InputError(f'supports: {count[str(support)]} blocks are named "{support}"; give their indices')
    warnings.warn(
        InputWarning(f'several blocks share a name ("{min(repeated)}"); they are numbered from .0'),
        stacklevel=3,
    )
    return numbered(names)


def numbered(names: Sequence[str]) -> list[str]:
    """Return names with a number where a name occurs more than once.

    Parameters
    ----------
    names : sequence of str
        Of the blocks; "" for none.

    Returns
    -------
    list of str
        One a block.

    Examples
    --------
    >>> numbered(["Mesh", "ground", "Mesh", ""])
    ['Mesh.0', 'ground', 'Mesh.1', '']
    """
    count = Counter(name for name in names if name)
    repeated = {name for name, times in count.items() if times > 1}
    seen: Counter[str] = Counter()
    taken = {name for name in count if name not in repeated}
    result = []
    for name in names:
        label = name
        while name in repeated and (label == name or label in taken):
            label = f"{name}.{seen[name]}"
            seen[name] += 1
        taken.add(label)
        result.append(label)
    return result
