"""Coordinates as text of few digits: far from the origin they are on a coarse grid."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blockstat.assembly import Block
from blockstat.contact.tolerance import GAP
from blockstat.errors import InputWarning
from blockstat.io.raw import stl
from blockstat.io.raw.precision import size_of

#: Digits that programs write when they are not told how many: C's %g and C++ 6, %e 7. Of numbers that all have fewer
#: it cannot be said that any were left out.
FEW = (6, 7)
#: Of the least side of its box, no block is smaller: a tetrahedron fills a sixth of its box, and the cube root is 0.55.
THICK = 0.5
#: The coordinates of a vertex: "v" in an OBJ, "vertex" in an STL.
VERTEX = re.compile(rb"^[ \t]*(?:v|vertex)[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.MULTILINE | re.IGNORECASE)
NUMBER = re.compile(rb"[-+]?(\d*)(?:\.(\d*))?(?:[eE]([-+]?\d{1,3}))?")


def check_digits(path: Path, files: Sequence[Path], blocks: Sequence[Block], metres: float) -> None:
    """Warn where the digits that a text holds of its coordinates are too few to tell where corners are.

    Parameters
    ----------
    path : Path
        What was asked for: a file, or the directory of several.
    files : sequence of Path
        The files; those that are no .obj and no .stl in text are passed over.
    blocks : sequence of Block
        In the unit of the files.
    metres : float
        Metres in that unit.

    Warns
    -----
    InputWarning
        Where no number has more digits than programs write by default, small numbers have decimals that large ones
        lack, and the last digit of the largest coordinate of a block is worth more than the gap that a joint may have,
        `blockstat.contact.tolerance.GAP` of the block.
    """
    texts = [file for file in files if file.suffix.lower() == ".obj" or _is_text(file)]
    corners = [np.asarray(block.vertices, dtype=float) for block in blocks]
    if not texts or not all(np.isfinite(own).all() for own in corners):
        return  # refused later
    reach = np.array([np.abs(own).max(initial=1e-9) for own in corners])
    first = np.floor(np.log10(reach))  # the place of the first digit
    least = THICK * np.array([np.ptp(own, axis=0).min() for own in corners])
    doubted = np.flatnonzero(10.0 ** (first + 1 - FEW[0]) > GAP * least)
    if not len(doubted):
        return
    digits, finest = _written(texts)
    if not FEW[0] <= digits <= FEW[1]:
        return
    step = 10.0 ** (first[doubted] + 1 - digits)
    shares = [own / size_of(blocks[k], own) for own, k in zip(step.tolist(), doubted.tolist(), strict=True)]
    worst = int(np.argmax(shares))
    if not (shares[worst] > GAP and finest < first[doubted[worst]] + 1 - digits):
        return
    name = blocks[doubted[worst]].name or f"block{doubted[worst]}"
    warnings.warn(
        InputWarning(
            f"{path}: no coordinate has more than {digits} digits, and so far from the origin the last of them is "
            f'worth {step[worst] * metres * 1e3:.3g} mm, {shares[worst]:.2g} of the size of block "{name}"; corners '
            "are rounded to that: export the model about a local origin, or with more digits"
        ),
        stacklevel=4,
    )


def _is_text(file: Path) -> bool:
    return file.suffix.lower() == ".stl" and not stl.is_binary(file)


def _written(texts: Sequence[Path]) -> tuple[int, int]:
    """The most digits of a coordinate of some files, and the power of ten of the finest last digit.

    No digits where numbers are not cut to some digits: %g leaves out zeros at the end, and %e writes all in one form.
    A program that writes "0.0" beside "1.25" gives as many digits as a number has.
    """
    found = {number for file in texts for vertex in VERTEX.findall(file.read_bytes()) for number in vertex}
    parts = [own.groups(b"") for own in map(NUMBER.fullmatch, found) if own]
    cut = not any(fraction.endswith(b"0") for _, fraction, _ in parts)
    in_one_form = all(power for _, _, power in parts) and len({len(fraction) for _, fraction, _ in parts}) == 1
    if not (cut or in_one_form):
        return 0, 0
    digits = [len((whole + fraction).lstrip(b"0")) for whole, fraction, _ in parts]
    last = [int(power or 0) - len(fraction) for _, fraction, power in parts]
    # Zero has no digits, and says nothing.
    return max(digits, default=0), min((own for own, n in zip(last, digits, strict=True) if n), default=0)
