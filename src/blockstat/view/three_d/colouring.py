"""Colours of blocks by what is known of them, and the legend that explains them.

The maps keep their order in grey and for colour-blind readers: viridis for demand, cividis for tension, plasma for
motion. Values are put into a few steps, so that a view needs a few meshes and not one a block.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats, Ints
from blockstat.view.plot import DEMAND, MOVED, SUPPORT, USED

if TYPE_CHECKING:
    from blockstat.analysis.verdict import Verdict
    from blockstat.assembly import Assembly

STEPS = 12
TENSION = "cividis"
#: Okabe & Ito's colours for categories, which colour-blind readers tell apart; black is left to edges.
CATEGORIES = ("#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7", "#999999")
CHOICES = ("verdict", "demand", "tension", "group", "displacement")


@dataclass(frozen=True, eq=False)
class Colouring:
    """A colour for every block, as a number in a short list of colours."""

    palette: np.ndarray  #: shape (n_colours, 3), 0 to 255; the first is that of supports
    index: Ints  #: shape (n_blocks,), into the palette
    legend: str  #: HTML


def colouring(choice: str, verdict: Verdict, moved: Floats | None = None) -> Colouring:
    """Return the colours of the blocks by a choice.

    Parameters
    ----------
    choice : str
        "demand", "tension", "group", "displacement" or "verdict", which takes the mechanism of what moves, else the
        demand.
    verdict : Verdict
        The verdict.
    moved : array of float, shape (n_blocks,), optional
        Distances that a dynamic run found [m]. "displacement" shows them in place of the mechanism's, and so does
        "verdict" where there is a mechanism.

    Returns
    -------
    Colouring
        The colours and their legend.

    Raises
    ------
    InputError
        For another choice.
    """
    assembly = verdict.assembly
    if choice not in CHOICES:
        raise InputError(f"no colouring {choice!r}; colourings are: {', '.join(CHOICES)}")
    if choice == "group":
        return _by_group(assembly)
    if choice == "verdict":
        choice = "displacement" if verdict.mechanism.any() else "demand"
    if choice == "demand":
        return scaled(assembly, verdict.demand(), DEMAND, 1.0, USED)
    if choice == "tension":
        if np.isnan(verdict.score):
            plain = scaled(assembly, np.zeros(assembly.n_blocks), TENSION, 0.0, "")
            return replace(plain, legend="residual tension: not known yet, the fall was proven without it")
        missing = tension(verdict) / 1e3
        return scaled(assembly, missing, TENSION, float(missing.max(initial=0.0)), "residual tension at a block [kN]")
    if moved is not None:
        return scaled(assembly, 1e3 * moved, MOVED, 1e3 * float(moved.max(initial=0.0)), "displacement [mm]")
    top = 1.0 if verdict.mechanism.any() else 0.0
    return scaled(assembly, verdict.motion, MOVED, top, "speed in the mechanism, 1 = fastest block [-]")


def tension(verdict: Verdict) -> Floats:
    """Return the adhesion missing at the joints of each block.

    Parameters
    ----------
    verdict : Verdict
        The verdict.

    Returns
    -------
    array of float, shape (n_blocks,)
        Sum over the contact points of the block [N].
    """
    faces = verdict.interfaces
    total = np.zeros(verdict.assembly.n_blocks)
    for side in faces.pair[faces.point_interface].T:
        np.add.at(total, side, verdict.adhesion)
    return total


def scaled(assembly: Assembly, values: Floats, name: str, top: float, label: str) -> Colouring:
    """Return the colours of a map by values, in steps; supports are grey.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    values : array of float, shape (n_blocks,)
        One number a block, from 0.
    name : str
        Name of a colour map of matplotlib.
    top : float
        Upper end of the scale; with 0 all blocks have its first colour.
    label : str
        For the legend, with the unit of the values.

    Returns
    -------
    Colouring
        The colours and their legend.
    """
    from matplotlib import colormaps

    share = values / top if top > 0 else np.zeros(assembly.n_blocks)
    step = np.clip((share * STEPS).astype(np.int64), 0, STEPS - 1)
    colours = colormaps[name]((np.arange(STEPS) + 0.5) / STEPS)[:, :3]
    palette = np.rint(255 * np.vstack([SUPPORT, colours])).astype(np.int64)
    index = np.where(assembly.support, 0, step + 1)
    return Colouring(palette, index, _bar(palette[1:], top, label))


def _by_group(assembly: Assembly) -> Colouring:
    names = sorted({g for g, fixed in zip(assembly.groups, assembly.support, strict=True) if not fixed})
    number = {name: 1 + k % len(CATEGORIES) for k, name in enumerate(names)}
    palette = np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in CATEGORIES])
    palette = np.vstack([np.rint(255 * np.array(SUPPORT)), palette]).astype(np.int64)
    pairs = zip(assembly.groups, assembly.support, strict=True)
    index = np.array([0 if fixed else number[group] for group, fixed in pairs], dtype=np.int64)
    rows = [("support", 0), *((name or "no group", number[name]) for name in names)]
    return Colouring(palette, index, "".join(_swatch(palette[k], name) for name, k in rows))


def _swatch(colour: np.ndarray, text: str) -> str:
    box = f"display:inline-block;width:.9em;height:.9em;margin-right:.5em;background:{_css(colour)}"
    return f'<div><span style="{box}"></span>{escape(text)}</div>'


def _bar(palette: np.ndarray, top: float, label: str) -> str:
    if top <= 0:
        return _swatch(palette[0], f"0: {label}") + _support()
    cells = "".join(f'<span style="flex:1;background:{_css(c)}"></span>' for c in palette)
    ends = "".join(f"<span>{_number(value)}</span>" for value in (0.0, top / 2, top))
    return (
        f"<div>{escape(label)}</div>"
        f'<div style="display:flex;height:1em;margin:.25em 0">{cells}</div>'
        f'<div style="display:flex;justify-content:space-between">{ends}</div>' + _support()
    )


def _number(value: float) -> str:
    """Three digits, without a power of ten where there is room for all of them."""
    return f"{value:,.0f}" if 1000 <= value < 1e6 else f"{value:.3g}"


def _support() -> str:
    return _swatch(np.rint(255 * np.array(SUPPORT)), "support")


def _css(colour: np.ndarray) -> str:
    return "rgb({},{},{})".format(*(int(c) for c in colour))
