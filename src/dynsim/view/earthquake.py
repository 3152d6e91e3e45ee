"""Curves of incremental dynamic analysis and their fragility, side by side in one picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.errors import InputError
from blockstat.view.plot import fresh_figure, save_figure
from dynsim.earthquake.analysis import IncrementalAnalysis
from dynsim.earthquake.fragility import Fragility

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CURVE, LINE, FELL = "#56606B", "#0072B2", "#D55E00"  #: grey, blue and orange, which colour-blind readers tell apart
SIZE = (11.0, 4.6)  #: of the picture [inches]
#: A fall is drawn this far beyond the largest displacement of a run that stood: the run ends at the threshold.
BESIDE = 1.12
POINTS = 200  #: of the drawn fragility


def plot_incremental(found: IncrementalAnalysis, place: str | Path | Figure) -> str | Path | Figure:
    """Draw intensity against largest displacement for each record, and the fragility with its confidence band.

    A run in which a block fell is a cross at the right margin, on a level line from the last run that stood. Steps
    beside the fragility are the share of records that fell a block up to an intensity.

    Parameters
    ----------
    found : IncrementalAnalysis
        What is drawn. Without a fragility the curves alone are.
    place : str, Path or matplotlib Figure
        A file, in PNG, SVG or any format that matplotlib writes, or an empty figure to draw in.

    Returns
    -------
    str, Path or matplotlib Figure
        The place.

    Raises
    ------
    InputError
        When there are no runs to draw, or for a file that cannot be written.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> from dynsim import Pulse, incremental, plot_incremental
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.25, 0.5, 1), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"], friction=0.9)
    >>> pulses = {"short": Pulse((9.81, 0, 0), 0.5, "sine"), "long": Pulse((9.81, 0, 0), 0.9, "sine")}
    >>> plot_incremental(incremental(pillar, pulses, start=0.2, resolution=0.2, jobs=1), "ida.svg")
    'ida.svg'
    """
    if not any(curve.runs for curve in found.curves):
        raise InputError(f"{found.assembly.name}: no runs under records to draw: {found.outcome.value}")
    if isinstance(place, (str, Path)):
        figure = fresh_figure(Path(place))
        figure.set_size_inches(*SIZE)
        _draw(found, figure)
        save_figure(figure, place)
    else:
        _draw(found, place)
    return place


def _draw(found: IncrementalAnalysis, figure: Figure) -> None:
    try:
        fitted = found.fragility()
    except InputError:
        fitted = None
    axes = np.atleast_1d(figure.subplots(1, 1 if fitted is None else 2))
    _draw_curves(found, axes[0])
    if fitted is not None:
        _draw_fragility(found, fitted, axes[1])


def _draw_curves(found: IncrementalAnalysis, axes: Any) -> None:
    stood = [run.max_displacement for curve in found.curves for run in curve.runs if not run.fell]
    margin = 1e3 * BESIDE * (max(stood, default=0.0) or found.threshold)
    for curve in found.curves:
        below = [run for run in curve.runs if run.intensity < curve.upper]
        line = [(0.0, 0.0), *((1e3 * run.max_displacement, run.intensity) for run in below)]
        if np.isfinite(curve.upper):
            line += [(line[-1][0], curve.upper), (margin, curve.upper)]
        axes.plot(*np.array(line).T, color=CURVE, linewidth=1.0)
        above = [run for run in curve.runs if run.intensity > curve.upper and not run.fell]
        # Not joined: between these and the curve the block fell.
        for runs, look in ((below, {"color": CURVE}), (above, {"color": LINE, "markerfacecolor": "none"})):
            axes.plot(
                [1e3 * run.max_displacement for run in runs], [run.intensity for run in runs], "o", ms=3.5, **look
            )
    fell = [run.intensity for curve in found.curves for run in curve.runs if run.fell]
    axes.plot(np.full(len(fell), margin), fell, "x", color=FELL, markersize=6, label="falls")
    axes.set(xlabel="largest displacement [mm]", ylabel=f"{found.measure.upper()} [{found.unit}]", xlim=(0, None))
    axes.set_ylim(bottom=0)
    axes.set_title(f"{found.assembly.name}: {len(found.curves)} records", fontsize=11, parse_math=False)
    axes.legend(loc="lower right")


def _draw_fragility(found: IncrementalAnalysis, fitted: Fragility, axes: Any) -> None:
    collapses = np.sort(fitted.upper[np.isfinite(fitted.upper)])
    top = max(1.3 * float(collapses[-1]), fitted.median * np.exp(2 * fitted.dispersion))
    at = np.linspace(0.0, min(top, 2 * float(collapses[-1])), POINTS + 1)[1:]
    axes.fill_between(at, *fitted.band(at), color=LINE, alpha=0.15, label=f"{fitted.confidence:.0%} confidence")
    words = f"median {fitted.median:.3g} {found.unit}, dispersion {fitted.dispersion:.2g}"
    axes.plot(at, fitted.probability(at), color=LINE, linewidth=1.6, label=words)
    share = np.arange(1, len(collapses) + 1) / len(fitted.upper)
    axes.step([0.0, *collapses, at[-1]], [0.0, *share, share[-1]], where="post", color=CURVE, lw=1, label="records")
    axes.set(xlabel=f"{found.measure.upper()} [{found.unit}]", ylabel="probability of collapse")
    axes.set(xlim=(0, at[-1]), ylim=(0, 1))
    axes.legend(loc="lower right", fontsize=9)
