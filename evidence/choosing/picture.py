"""Error over seconds, a panel a choice."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from matplotlib.figure import Figure

from evidence.choosing.curves import DEFAULT, DIGITS, Followed
from evidence.choosing.draws import MEAN, Sampled
from evidence.choosing.limits import Bracketed
from evidence.choosing.runs import Judged
from evidence.plotting import COLOURS, panels

T = TypeVar("T")
TITLES = {
    "limits": ("Limit load, by tolerance", "error of the lower bound"),
    "curves": ("Capacity curve, by steps and tolerance", "error, share of the multiplier at rest"),
    "runs": ("Bullet, by resolution", "imbalance, share of the weight"),
    "draws": ("Monte Carlo, by draws", "relative error"),
}
#: Where a legend is, by what its panel goes further down for it, and the margins at its sides.
LEGENDS = (("upper right", 1, 0.05), ("lower left", 200, 0.05), ("lower left", 30, 0.15), ("lower left", 20, 0.05))


def draw(
    limits: Sequence[Bracketed],
    curves: tuple[Sequence[Followed], Sequence[Followed]],
    runs: Sequence[Judged],
    draws: Sequence[Sampled],
) -> Figure:
    """Four panels, both axes logarithmic."""
    figure, axes = panels((11, 8.5), 2, 2)
    for axis, (title, error) in zip(axes, TITLES.values(), strict=True):
        axis.set(title=title, xscale="log", yscale="log", xlabel="process seconds", ylabel=error)
        axis.grid(alpha=0.3)
    for name, colour in _coloured(row.scene for row in limits):
        own = [row for row in limits if row.scene == name]
        axes[0].plot([r.seconds for r in own], [r.error for r in own], "o-", color=colour, label=name)
    _curves(axes[1], *curves)
    _runs(axes[2], runs)
    _draws(axes[3], draws)
    for axis, (corner, below, right) in zip(axes, LEGENDS, strict=True):
        axis.margins(x=right)
        low, high = axis.get_ylim()
        axis.set_ylim(low / below, high)
        axis.legend(frameon=False, fontsize=8, loc=corner)
    return figure


def _coloured(names: Iterable[T]) -> Iterable[tuple[T, str]]:
    return zip(dict.fromkeys(names), COLOURS, strict=False)


def _curves(axis: Any, linkages: Sequence[Followed], walls: Sequence[Followed]) -> None:
    """Linkages by steps and by tolerance, and walls by steps without the finest."""
    for name, colour in _coloured(row.scene for row in (*linkages, *walls)):
        own = [row for row in (*linkages, *walls) if row.scene == name]
        if own[0] in walls:
            own = [row for row in own if row.steps < max(r.steps for r in own)]
            axis.plot([r.seconds for r in own], [max(r.error, DIGITS) for r in own], "s", color=colour, label=name)
            continue
        few = min(row.steps for row in own)
        for words, style, part in (
            ("steps", "o-", [row for row in own if row.tolerance == DEFAULT["tolerance"]]),
            ("tolerance", "^--", sorted((r for r in own if r.steps == few), key=lambda r: -r.tolerance)),
        ):
            axis.plot([r.seconds for r in part], [r.error for r in part], style, color=colour, label=f"{name}, {words}")


def _runs(axis: Any, rows: Sequence[Judged]) -> None:
    """Filled: seen to stand beyond the limit; hollow: seen to fall before it; a preset is a star."""
    for name, colour in _coloured(row.scene for row in rows):
        own = [row for row in rows if row.scene == name]
        line = [row for row in own if not row.preset or row.setting == "default"]
        axis.plot([r.seconds for r in line], [_size(r) for r in line], "-", color=colour, label=name)
        for row in own:
            face = colour if row.missed >= 0 else "white"
            marker, size = ("*", 13) if row.preset else ("o", 7)
            axis.plot([row.seconds], [_size(row)], marker, color=colour, markerfacecolor=face, markersize=size)
            if row.preset:
                # The fast preset is left of the others, and so are its words.
                side, near = (-6, "right") if row.setting == "fast" else (6, "left")
                place = {"xytext": (side, 4), "textcoords": "offset points", "ha": near}
                axis.annotate(row.setting, (row.seconds, _size(row)), fontsize=8, **place)
    axis.plot([], [], "ko", markerfacecolor="white", label="hollow: falls before the limit")
    axis.plot([], [], "k*", markersize=11, label="preset")


def _size(row: Judged) -> float:
    """What is drawn of an imbalance: nothing is less than the bracket is wide."""
    return max(abs(row.missed), row.high - row.low)


def _draws(axis: Any, rows: Sequence[Sampled]) -> None:
    """Errors against known values with their theory, and intervals where nothing is known."""
    for (scene, about), colour in _coloured((row.scene, row.about) for row in rows):
        own = [row for row in rows if (row.scene, row.about) == (scene, about)]
        seconds, error = [r.seconds for r in own], np.array([r.error for r in own])
        name = scene if about == MEAN else f"{scene}, about {about}"
        if np.isnan(error).all():
            axis.plot(seconds, [r.interval for r in own], "s--", color=colour, label=f"{name}: interval")
            continue
        axis.plot(seconds, error, "o-", color=colour, label=name)
        axis.plot(seconds, [r.expected for r in own], ":", color=colour)
    axis.plot([], [], "k:", label="by theory")
