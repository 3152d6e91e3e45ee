"""The figure of a capacity curve as SVG inside the page: it scales with the screen and is read out as one sentence."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

import numpy as np

from blockstat.app.capacity_tab.trace import Trace
from blockstat.result import millimetres, plain
from blockstat.typing import Floats
from blockstat.view.settling import CHANGE, CURVE

#: Size of the figure and of the margins around the axes, in units of the SVG: about pixels in the panel.
WIDTH, HEIGHT = 310.0, 220.0
LEFT, RIGHT, TOP, BOTTOM = 48.0, 12.0, 18.0, 38.0
OLD = "#868e96"  #: of the curve of another design
INK, GRID = "#343a40", "#dee2e6"
#: Names of events closer together than this would overlap: the line alone marks them.
APART = 44.0


@dataclass(frozen=True)
class Axes:
    """From displacements [mm] and multipliers [g] to places in the figure.

    Attributes
    ----------
    low, high : float
        Ends of the axis of displacements [mm].
    top : float
        End of the axis of multipliers [g], which begins at 0.
    """

    low: float
    high: float
    top: float

    def x(self, displacement: Floats | float) -> Floats:
        """Return places across.

        Parameters
        ----------
        displacement : array of float or float
            [mm].

        Returns
        -------
        array of float
            In units of the SVG.
        """
        share = (np.asarray(displacement, dtype=float) - self.low) / (self.high - self.low)
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def y(self, multiplier: Floats | float) -> Floats:
        """Return places down.

        Parameters
        ----------
        multiplier : array of float or float
            [g].

        Returns
        -------
        array of float
            In units of the SVG.
        """
        return HEIGHT - BOTTOM - np.asarray(multiplier, dtype=float) / self.top * (HEIGHT - TOP - BOTTOM)


def axes_of(trace: Trace) -> Axes:
    """Return axes that hold a curve.

    Parameters
    ----------
    trace : Trace
        With a state at least.

    Returns
    -------
    Axes
        From 0, or from the least displacement below it, to the last state or event and to a little above the curve. A
        curve without displacement has an axis of 1 mm.
    """
    displacement, _, upper = trace.plotted()
    top = float(upper.max())
    there = [0.0, *displacement.tolist(), *(1e3 * event.displacement for event in trace.events)]
    low, high = min(there), max(there)
    return Axes(low, high if high > low else low + 1.0, 1.05 * top if top > 0 else 1.0)


def figure(trace: Trace, at: int, *, old: bool = False) -> str:
    """Return the figure of a curve.

    Parameters
    ----------
    trace : Trace
        The curve.
    at : int
        Number of the state that is marked.
    old : bool, optional
        Whether the curve is that of another design than the one on show: it is grey then.

    Returns
    -------
    str
        HTML; empty for a curve without a state.

    Examples
    --------
    >>> import numpy as np
    >>> from blockstat.app.capacity_tab.figure import figure
    >>> from blockstat.app.capacity_tab.trace import Seen, Trace
    >>> trace = Trace("+x", [Seen(d, 0.25 - d, 0.25 - d, np.zeros((1, 3)), np.eye(3)[None]) for d in (0.0, 0.25)])
    >>> figure(trace, 0).count("<polygon")
    1
    """
    if not trace.states:
        return ""
    displacement, lower, upper = trace.plotted()
    axes, colour = axes_of(trace), OLD if old else CURVE
    x, low, high = axes.x(displacement), axes.y(lower), axes.y(upper)
    band = _points(np.append(x, x[::-1]), np.append(low, high[::-1]))
    parts = [
        *_grid(axes),
        f'<polygon points="{band}" fill="{colour}" fill-opacity="0.25" stroke="none"/>',
        *(
            f'<polyline points="{_points(x, bound)}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
            for bound, width in ((high, 0.8), (low, 1.6))
        ),
        *_events(trace, axes, OLD if old else CHANGE),
    ]
    if not old:
        middle = (low[at] + high[at]) / 2
        parts.append(f'<circle cx="{x[at]:.1f}" cy="{middle:.1f}" r="4" fill="#fff" stroke="#000" stroke-width="2"/>')
    return (
        f'<div style="margin:0 6px"><svg role="img" aria-label="{escape(_sentence(trace, old))}" '
        f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%" font-size="11" fill="{INK}">{"".join(parts)}</svg></div>'
    )


def _points(x: Floats, y: Floats) -> str:
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def _grid(axes: Axes) -> list[str]:
    """Ticks with their numbers, and what the axes stand for."""
    from matplotlib.ticker import MaxNLocator

    bottom, right, parts = HEIGHT - BOTTOM, WIDTH - RIGHT, []
    for tick in MaxNLocator(4).tick_values(axes.low, axes.high):
        if axes.low <= tick <= axes.high:
            x = float(axes.x(tick))
            parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{bottom}" stroke="{GRID}"/>')
            parts.append(f'<text x="{x:.1f}" y="{bottom + 14}" text-anchor="middle">{tick:g}</text>')
    for tick in MaxNLocator(4).tick_values(0.0, axes.top):
        if 0 <= tick <= axes.top:
            y = float(axes.y(tick))
            parts.append(f'<line x1="{LEFT}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}" stroke="{GRID}"/>')
            parts.append(f'<text x="{LEFT - 5}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>')
    middle = (TOP + bottom) / 2
    parts.append(f'<text x="{(LEFT + right) / 2}" y="{HEIGHT - 6}" text-anchor="middle">displacement [mm]</text>')
    parts.append(
        f'<text x="12" y="{middle}" text-anchor="middle" transform="rotate(-90 12 {middle})">multiplier [g]</text>'
    )
    return parts


def _events(trace: Trace, axes: Axes, colour: str) -> list[str]:
    """A dashed line for each event, and its name where there is room for it."""
    parts, last = [], -np.inf
    for event in trace.events:
        x = float(axes.x(1e3 * event.displacement))
        parts.append(
            f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}" stroke="{colour}" '
            'stroke-dasharray="4 3"/>'
        )
        if x - last >= APART:
            anchor = "end" if x > WIDTH - APART else "start"
            parts.append(f'<text x="{x:.1f}" y="{TOP - 5}" text-anchor="{anchor}">{escape(event.kind)}</text>')
            last = x
    return parts


def _sentence(trace: Trace, old: bool) -> str:
    """What a screen reader says of the figure."""
    first, last = trace.states[0], trace.states[-1]
    of = "Capacity curve of another design" if old else "Capacity curve"
    events = "".join(f"; {event.kind} at {millimetres(event.displacement)} mm" for event in trace.events[:4])
    return (
        f"{of} towards {trace.push}: multiplier {plain(first.lower)} g at rest, {plain(last.lower)} g at "
        f"{millimetres(last.displacement)} mm{events}"
    )
