"""Large and small displacements in pictures: how far joints open as supports settle, and capacity curves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.large_displacement.capacity_curve import CapacityCurve
from blockstat.result import plain
from blockstat.studies.foundations import Settlement
from blockstat.typing import Floats
from blockstat.view.painter import view_of
from blockstat.view.plot import Place, draw_joints, extent, fresh_figure, plot, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The furthest corner is drawn so far from its place, relative to the assembly's extent.
DRAWN = 1 / 25
CURVE, CHANGE = "#0072B2", "#D55E00"  #: blue and orange, which colour-blind readers tell apart
SINKING = (0.84, 0.37, 0.0, 0.8)  #: orange, joints below which the supports move


def plot_settlement(found: Settlement, place: Place, **options: Any) -> Place:
    """Draw the blocks as they follow the supports, exaggerated, coloured by the widest opening at their joints.

    Joints below which the supports move are orange and move with them.

    Parameters
    ----------
    found : Settlement
        What `blockstat.settle` returned.
    place : str, Path or matplotlib Axes
        A file or axes, as in `blockstat.plot`.
    **options
        Options of `blockstat.plot`.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        For a file that cannot be written, or an unknown option.

    Examples
    --------
    >>> from blockstat import plot_settlement, settle
    >>> from blockstat.model import arch, assemble
    >>> ring = assemble(arch(span=2.0, thickness=0.4, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> plot_settlement(settle(ring, {"springer.right": (0.02, 0, 0)}), "spread.png")
    'spread.png'
    """
    from scipy.spatial.transform import Rotation

    from blockstat.analysis.verdict import corner_speed

    assembly = found.assembly
    scale = DRAWN * extent(assembly) / max(float(corner_speed(assembly, found.mechanism).max()), 1e-300)
    azimuth, elevation = options.pop("azimuth", -55.0), options.pop("elevation", 25.0)
    view = view_of(azimuth, elevation)
    moved = np.concatenate([np.empty(0, int), *(part.joints for part in found.foundations)])
    steps = [np.tile(scale * part.displacement, (len(part.joints), 1)) for part in found.foundations]
    shift = np.concatenate([np.empty((0, 3)), *steps])

    def draw(axes: Axes) -> None:
        draw_joints(axes, found.interfaces, view, moved, np.tile(SINKING, (len(moved), 1)), shift)

    widest = f"{plain(1e3 * found.displacement)} mm of settlement, drawn {scale:.3g} times as large"
    drawn = {
        "values": 1e3 * openings(found), "label": "widest opening at the block's joints [mm]",
        "title": f"{assembly.name}: {widest}", "displacement": scale * found.mechanism[:, :3],
        "rotation": Rotation.from_rotvec(scale * found.mechanism[:, 3:]).as_matrix(),
    }  # fmt: skip
    return plot(assembly, place, **drawn | options, azimuth=azimuth, elevation=elevation, overlay=draw)


def openings(found: Settlement) -> Floats:
    """Return the widest opening at the joints of each block.

    Parameters
    ----------
    found : Settlement
        A settlement.

    Returns
    -------
    array of float, shape (n_blocks,)
        [m], 0 where no joint opens.
    """
    widest = np.zeros(found.assembly.n_blocks)
    opening = np.maximum(found.joint_motion[:, 0], 0.0)
    for side in found.interfaces.pair[found.interfaces.point_interface].T:
        np.maximum.at(widest, side, opening)
    return widest


def plot_capacity(found: CapacityCurve, place: Place) -> Place:
    """Draw the bracket of the multiplier against the displacement, and mark where the mechanism changes.

    Parameters
    ----------
    found : CapacityCurve
        What `blockstat.capacity` returned.
    place : str, Path or matplotlib Axes
        A file, in PNG, SVG or any format that matplotlib writes, or axes to draw in.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        For a file that cannot be written.

    Examples
    --------
    >>> from blockstat import Assembly, box, capacity, plot_capacity
    >>> blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="block")]
    >>> wall = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plot_capacity(capacity(wall, (1, 0, 0), steps=10), "capacity.svg")
    'capacity.svg'
    """
    if isinstance(place, (str, Path)):
        figure = fresh_figure(Path(place))
        _draw(found, figure.add_subplot())
        save_figure(figure, place)
    else:
        _draw(found, place)
    return place


def _draw(found: CapacityCurve, axes: Any) -> None:
    there = 1e3 * found.displacement
    axes.fill_between(there, found.lower, found.upper, color=CURVE, alpha=0.25, linewidth=0)
    axes.plot(there, found.lower, "-o", color=CURVE, markersize=2.5, linewidth=1.4)
    for event in found.events:
        axes.axvline(1e3 * event.parameter, color=CHANGE, linewidth=0.8, linestyle="--")
        axes.annotate(event.kind, (1e3 * event.parameter, event.before), color=CHANGE, fontsize=8)
    axes.set_xlabel(f"displacement [mm]: {found.control}", fontsize=9)
    axes.set_ylabel("load multiplier")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.set_title(found.assembly.name, fontsize=11)
