"""Figures that need no display."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

#: Colours that colour-blind readers tell apart (Okabe and Ito).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")


def panels(size: tuple[float, float], rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, list]:
    """A figure of that many inches and its axes, row by row; options : of `Figure.subplots`."""
    figure = Figure(figsize=size, layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False, **options).flat)


def shades(name: str, number: int) -> list:
    """So many colours of a map of matplotlib, from its dark end to just before its light one."""
    return list(colormaps[name](np.linspace(0.0, 0.95, number)))


def save(figure: Figure, path: Path, dpi: int = 110) -> Path:
    """Write a figure to a file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=dpi)
    return path
