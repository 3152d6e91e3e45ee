"""The limit load over the horizon, as a polar plot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from blockstat.analysis.limit_load import LoadOutcome
from blockstat.errors import InputError
from blockstat.studies.directions import OPEN, DirectionalLimits, DirectionOutcome
from blockstat.typing import Floats
from blockstat.view.plot import Place, fresh_figure, save_figure

#: Blue, orange and green, which colour-blind readers tell apart.
LINE, WEAKEST, COULOMB = "#0072B2", "#D55E00", "#009E73"


def plot_directions(found: DirectionalLimits, place: Place) -> Place:
    """Draw the limit load multiplier of each direction as a distance from the centre, the weakest one marked.

    Between two directions the line is straight on the plan: by convexity at least so much is carried there. A
    direction that is undecided is hollow: it carries what is drawn, and may carry more. With flow="coulomb" what the
    joints that carry least carry without dilatancy is drawn beside that, and its least is marked; the dashed line
    between these points proves nothing.

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
    if not found.has_limits:
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
    wide = np.array([limit.outcome in OPEN for limit in found.limits])
    line = _curve(axes, found.angles, np.where(limited, found.lower, np.nan), wide, LINE, label="associated friction")
    axes.fill(*line, color=LINE, alpha=0.12)
    worst, least, basis, doubt = found.weakest, found.least.upper, "", ""
    if found.outcome is DirectionOutcome.UNDECIDED:
        doubt = "undecided, at most "
    if found.weakest_coulomb is not None:
        worst, carried, basis = found.weakest_coulomb, found.coulomb_least[:, 0], " without dilatancy"
        least = float(carried[worst])
        _curve(axes, found.angles, carried, wide, COULOMB, label="without dilatancy", linestyle="--")
    if wide.any():
        axes.plot([], [], "o", color="0.4", markerfacecolor="white", markersize=5, label="undecided")
    if wide.any() or basis:
        axes.legend(loc="lower left", bbox_to_anchor=(-0.15, -0.15), fontsize=9)
    axes.plot([0, found.angles[worst]], [0, least], color=WEAKEST, linewidth=2)
    inside = "white" if wide[worst] else WEAKEST
    axes.plot(found.angles[worst], least, "o", color=WEAKEST, markerfacecolor=inside, markersize=7)
    so_far = " so far" if found.stopped else ""
    of_how_many = f"least{so_far} of {len(found.limits)} directions{basis}"
    told = f"{of_how_many}: {doubt}{least:.4g} towards {found.names[worst]}"
    axes.set_title(f"{found.assembly.name}: {told}", fontsize=11, parse_math=False)
    axes.set_thetagrids([0, 45, 90, 135, 180, 225, 270, 315], ["+x", "", "+y", "", "-x", "", "-y", ""])
    axes.set_rmin(0.0)
    axes.set_rlabel_position(22.5)


def _curve(
    axes: Any, angle: Floats, size: Floats, hollow: NDArray[np.bool_], colour: str, **look: Any
) -> tuple[Floats, Floats]:
    """Draw points of known size and the polygon through them, which is closed where all are known; return it."""
    known = np.isfinite(size)
    at = np.flatnonzero(known)
    line = _straight(*(values[np.append(at, at[:1]) if known.all() else at] for values in (angle, size)))
    axes.plot(*line, color=colour, linewidth=1.4, **look)
    for rows, inside, width in ((at[~hollow[at]], colour, 3.5), (at[hollow[at]], "white", 5.0)):
        if len(rows):
            axes.plot(angle[rows], size[rows], "o", color=colour, markerfacecolor=inside, markersize=width)
    return line


def _straight(angle: Floats, size: Floats, *, pieces: int = 24) -> tuple[Floats, Floats]:
    """The polygon through points of a polar plot, its sides in short pieces because the axes would bend them."""
    corner = size * np.exp(1j * angle)
    share = np.linspace(0.0, 1.0, pieces, endpoint=False)
    path = (corner[:-1, None] * (1 - share) + corner[1:, None] * share).reshape(-1)
    path = np.append(path, corner[-1:])
    return np.angle(path), np.abs(path)
