"""Coordinates in single precision, which hold seven digits: far from the origin they are on a coarse grid."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blockstat.assembly import Block
from blockstat.contact.tolerance import GAP, LOOSE
from blockstat.errors import InputError, InputWarning
from blockstat.typing import Floats

ADVICE = "export the model about a local origin, or in double precision (.obj)"


def spacing(corners: Floats, scale: float = 1.0) -> float:
    """Return how far apart numbers of single precision are at the largest of some coordinates.

    Parameters
    ----------
    corners : array of float
        Coordinates as a file holds them.
    scale : float, optional
        By which they are multiplied afterwards.

    Returns
    -------
    float
        In the unit of the coordinates.

    Examples
    --------
    >>> spacing(np.array([4812345.0])), spacing(np.array([1.0])) == 2**-23
    (0.5, True)
    """
    return scale * float(np.spacing(np.float32(np.abs(corners).max(initial=0.0))))


def check_spacing(path: Path, blocks: Sequence[Block], apart: Sequence[float]) -> None:
    """Refuse blocks whose joints are lost in the rounding of single precision, and warn where they open by it.

    Parameters
    ----------
    path : Path
        The file.
    blocks : sequence of Block
        In metres.
    apart : sequence of float
        How far apart numbers are at the largest coordinate of each block [m]; zero for double precision.

    Raises
    ------
    InputError
        Where that is more than the gap that a joint may have, `blockstat.contact.tolerance.GAP` of the block.

    Warns
    -----
    InputWarning
        Where it is more than the gap from which a joint does not quite close, `LOOSE` of the block.
    """
    shares = [step / size_of(block, step) if step else 0.0 for block, step in zip(blocks, apart, strict=True)]
    worst = int(np.argmax(shares)) if shares else 0
    if not shares or not shares[worst] > LOOSE:
        return
    text = (
        f"the coordinates are in single precision, and so far from the origin its numbers are {apart[worst] * 1e3:.3g}"
    )
    text += f' mm apart, {shares[worst]:.2g} of the size of block "{blocks[worst].name or f"block{worst}"}"'
    if shares[worst] > GAP:
        raise InputError(f"{text}; joints are lost in that: {ADVICE}")
    warnings.warn(InputWarning(f"{path}: {text}; joints open by as much: {ADVICE}"), stacklevel=4)


def size_of(block: Block, step: float) -> float:
    """Return the cube root of the volume of a block, or of its box where the volume is lost in rounding.

    Parameters
    ----------
    block : Block
        In any unit.
    step : float
        How far apart the numbers of its coordinates are, in that unit.

    Returns
    -------
    float
        In that unit.
    """
    corners = np.asarray(block.vertices, dtype=float)
    corners = corners - corners.mean(axis=0)
    box = np.maximum(np.ptp(corners, axis=0), step)
    fans = np.array([(face[0], *pair) for face in block.faces for pair in zip(face[1:-1], face[2:], strict=True)])
    volume = abs(float(np.linalg.det(corners[fans]).sum())) / 6 if len(fans) else 0.0
    return float(np.cbrt(volume if volume > step * box.prod() / box.min() else box.prod()))
