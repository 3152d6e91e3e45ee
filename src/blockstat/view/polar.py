"""The limit load over the horizon, as a polar plot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from blockstat.analysis.limit_load import LoadOutcome
from blockstat.errors import InputError
from blockstat.studies.directions import DirectionalLimits, DirectionOutcome
from blockstat.view.plot import Place, fresh_figure, save_figure

LINE, WEAKEST = "#0072B2", "#D55E00"  #: blue and orange, which colour-blind readers tell apart


def plot_directions(found: DirectionalLimits, place: Place) -> Place:
    """Draw the limit load multiplier of each direction as a distance from the centre, the weakest one marked.

    Between two directions the line is straight on the plan: by convexity at least so much is carried there.

    Parameters
    ----------
    found : DirectionalLimits
        The limit loads over the horizon.
    place : str, Path or matplotlib Axes
        A file, in PNG, SVG or any format that matplotlib writes, or polar axes to draw in.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        When no direction has a limit, or for a file that cannot be written.

    Examples
    --------
    >>> from blockstat import Assembly, box, limit_load_by_direction, plot_directions
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 0.5, 2), name="slab")]
    >>> slab = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plot_directions(limit_load_by_direction(slab, 8), "horizon.svg")
    'horizon.svg'
    """
    if found.outcome in (DirectionOutcome.DEAD_LOAD_UNSTABLE, DirectionOutcome.UNBOUNDED):
        raise InputError(f"{found.assembly.name}: no limit loads to draw: {found.outcome.value}")
    if isinstance(place, (str, Path)):
        figure = fresh_figure(Path(place))
        _draw(found, figure.add_subplot(projection="polar"))
        save_figure(figure, place)
    else:
        _draw(found, place)
    return place


def _draw(found: DirectionalLimits, axes: Any) -> None:
    limited = np.array([limit.outcome is not LoadOutcome.UNBOUNDED for limit in found.limits])
    angle, carried = found.angles[limited], found.lower[limited]
    around = np.append(np.arange(len(angle)), 0) if limited.all() else np.arange(len(angle))
    line = _straight(angle[around], carried[around])
    axes.plot(*line, color=LINE, linewidth=1.4)
    axes.fill(*line, color=LINE, alpha=0.12)
    axes.plot(angle, carried, "o", color=LINE, markersize=3.5)
    worst = found.weakest
    axes.plot([0, found.angles[worst]], [0, found.upper[worst]], color=WEAKEST, linewidth=2)
    axes.plot(found.angles[worst], found.upper[worst], "o", color=WEAKEST, markersize=7)
    axes.set_title(f"{found.assembly.name}: least {found.least.upper:.4g} towards {found.names[worst]}", fontsize=11)
    axes.set_thetagrids([0, 45, 90, 135, 180, 225, 270, 315], ["+x", "", "+y", "", "-x", "", "-y", ""])
    axes.set_rmin(0.0)
    axes.set_rlabel_position(22.5)


def _straight(angle: np.ndarray, size: np.ndarray, *, pieces: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """The polygon through points of a polar plot, its sides in short pieces because the axes would bend them."""
    corner = size * np.exp(1j * angle)
    share = np.linspace(0.0, 1.0, pieces, endpoint=False)
    path = (corner[:-1, None] * (1 - share) + corner[1:, None] * share).reshape(-1)
    path = np.append(path, corner[-1:])
    return np.angle(path), np.abs(path)
