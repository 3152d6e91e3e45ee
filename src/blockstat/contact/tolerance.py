"""The gap up to which two faces are a joint: a share of the size of a block, or a length."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats

if TYPE_CHECKING:
    from blockstat.geometry.polyhedron import Polyhedra

#: Largest gap or overlap of a joint, relative to the smaller block: 2 mm for a brick. Real vault meshes do not
#: close better, and their verdicts do not change from half this tolerance to five times it.
GAP = 1e-2
#: A joint open by more than this fraction of the block size does not quite close, which a verdict mentions.
LOOSE = 1e-3
THIN = 0.25  #: of the mean thickness of a block, volume over half its surface, that a gap may be at most
#: Of a gap given as a length, what the corners of a face may leave its plane. Two such faces are a joint if their
#: planes are as near as the gap says, and no two points that face each other are further apart than half of it more.
FLATNESS = 0.25
#: Part of the extent of the blocks by which single precision (GLB, STL) may move two faces apart, with the origin near
#: them. A coordinate is off by half of eps at most, the difference of two by eps, and the distance along a normal by
#: sqrt(3) times that. The extent is taken and not the coordinates, so that no verdict depends on the place.
ROUNDING = float(np.sqrt(3) * np.finfo(np.float32).eps)
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
LENGTH = re.compile(r"\s*([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*(mm|cm|m)\s*")


def read_gap(text: str | None) -> float | str:
    """Return the gap that a user types, on the command line or on the live page.

    Parameters
    ----------
    text : str or None
        A share of the size of a block, or a length such as "2 mm"; None for the default.

    Returns
    -------
    float or str
        The share, or the length as it was typed.

    Raises
    ------
    InputError
        As `stated_length`.

    Examples
    --------
    >>> read_gap("0.02"), read_gap("2 mm"), read_gap(None) == GAP
    (0.02, '2 mm', True)
    """
    if text is None:
        return GAP
    try:
        gap: float | str = float(text)
    except ValueError:
        gap = text
    stated_length(gap)
    return gap


def stated_length(gap: float | str) -> float | None:
    """Return the gap if it is a length.

    Parameters
    ----------
    gap : float or str
        A share of the size of a block, or a length such as "2 mm".

    Returns
    -------
    float or None
        The length [m]; None for a share.

    Raises
    ------
    InputError
        For any other text, and for a share that is not between 0 and 0.2.

    Examples
    --------
    >>> stated_length("2 mm"), stated_length(0.01)
    (0.002, None)
    """
    if isinstance(gap, str):
        found = LENGTH.fullmatch(gap)
        length = float(found[1]) * UNITS[found[2]] if found else 0.0
        if not 0 < length < np.inf:
            raise InputError(f'gap is "{gap}"; it must be a share of the block size, or a length such as "2 mm"')
        return length
    if not (isinstance(gap, (int, float)) and 0 < gap < 0.2):
        raise InputError(f'gap is {gap!r}; it must be between 0 and 0.2 of the block size, or a length such as "2 mm"')
    return None


def gap_lengths(solid: Polyhedra, gap: float | str) -> Floats:
    """Return the gap as a length for each block; one stated as a length includes the rounding of the coordinates.

    Parameters
    ----------
    solid : Polyhedra
        The blocks.
    gap : float or str
        A share of the size of a block, or a length such as "2 mm".

    Returns
    -------
    array, shape (n_blocks,)
        Lengths [m].

    Raises
    ------
    InputError
        As `stated_length`.
    """
    length = stated_length(gap)
    if length is None:
        return gap * solid.size  # type: ignore[operator]
    return np.full(solid.n_blocks, length + ROUNDING * float(np.ptp(solid.vertices, axis=0).max(initial=0.0)))


def allowed_gap(solid: Polyhedra, gap: float | str) -> Floats:
    """Return the largest gap of a joint of each block: less than would reach through a thin block.

    Parameters
    ----------
    solid : Polyhedra
        The blocks.
    gap : float or str
        A share of the size of a block, or a length such as "2 mm".

    Returns
    -------
    array, shape (n_blocks,)
        Lengths [m].

    Raises
    ------
    InputError
        As `stated_length`.
    """
    return np.minimum(gap_lengths(solid, gap), THIN * mean_thickness(solid))


def mean_thickness(solid: Polyhedra) -> Floats:
    """Return the volume of each block over half its surface: of a plate the thickness, of a cube a third of its side.

    Parameters
    ----------
    solid : Polyhedra
        The blocks.

    Returns
    -------
    array, shape (n_blocks,)
        Lengths [m].
    """
    surface = np.bincount(solid.face_block, solid.planes.area, solid.n_blocks)
    return np.asarray(2.0 * solid.volume / surface)


def gap_words(gap: float | str) -> str:
    """Say what the gap is.

    Parameters
    ----------
    gap : float or str
        A share of the size of a block, or a length such as "2 mm".

    Returns
    -------
    str
        For example "0.01 of the block size".
    """
    return gap.strip() if isinstance(gap, str) else f"{gap:g} of the block size"


def beyond(value: float, limit: float) -> str:
    """Write a length with as many digits as tell it from a smaller one, at least two.

    Parameters
    ----------
    value, limit : float
        The two lengths, of which the first is to be written.

    Returns
    -------
    str

    Examples
    --------
    >>> beyond(0.0034567, 0.002), beyond(0.0020011, 0.002)
    ('0.0035', '0.002001')
    """
    return next((text for digits in range(2, 17) if float(text := f"{value:.{digits}g}") > limit), repr(value))
