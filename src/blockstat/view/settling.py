"""Large and small displacements in pictures: joints that open as supports settle, capacity curves, films of both."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.large_displacement.capacity_curve import CapacityCurve
from blockstat.result import plain
from blockstat.studies.foundations import Settlement
from blockstat.studies.settling_path import SettlementPath
from blockstat.system.writing import check_directory
from blockstat.typing import Floats
from blockstat.view.animation import quaternions, write_motion
from blockstat.view.painter import AZIMUTH, ELEVATION, looked_at, posed, view_of
from blockstat.view.plot import Place, draw_joints, extent, fresh_figure, plot, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from blockstat.assembly import Assembly

#: The furthest corner is drawn so far from its place, relative to the assembly's extent.
DRAWN = 1 / 25
CURVE, CHANGE = "#0072B2", "#D55E00"  #: blue and orange, which colour-blind readers tell apart
SINKING = (0.84, 0.37, 0.0, 0.8)  #: orange, joints below which the supports move
SECONDS = 5.0  #: that a film of a path takes
FRAMES, HEIGHT, WIDEST = 5, 3.0, 24.0  #: of a strip: panels, and its sizes [inches]
NAMED = 5  #: cracks whose widths stand beside them
LABEL = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": CHANGE, "linewidth": 0.6}


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
    look, view = looked_at(options)
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
    return plot(assembly, place, **drawn | look, overlay=draw)


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
    axes.set_xlabel(f"displacement [mm]: {found.control}", fontsize=9, parse_math=False)
    axes.set_ylabel("load multiplier")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.set_title(found.assembly.name, fontsize=11, parse_math=False)


def film_path(path: str | Path) -> Path:
    """Return the path if `write_path` can write there; better asked before long work than after.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For a directory that does not exist or takes no file, or a suffix that is not written.
    """
    path = Path(path)
    if path.suffix.lower() == ".glb":
        check_directory(path)
    else:
        fresh_figure(path)
    return path


def film_times(displacement: Floats) -> Floats:
    """Return when a film shows each state on a path: as the displacement goes, and time for a jump, which takes none.

    Parameters
    ----------
    displacement : array of float, shape (k,)
        Of the control [m].

    Returns
    -------
    array of float, shape (k,)
        Ascending from 0 to the length of the film [s].

    Examples
    --------
    >>> from blockstat.view.settling import film_times
    >>> film_times([0.0, 0.1, 0.4]).tolist()
    [0.0, 1.25, 5.0]
    """
    step = np.abs(np.diff(displacement))
    # A jump takes no displacement, but it is to be seen, also where nothing else is on the path.
    least = float(step.sum()) / max(len(step), 1) / 10 or 1.0
    times = np.append(0.0, np.cumsum(np.maximum(step, least)))
    return times * (SECONDS / max(float(times[-1]), 1e-300))


def write_path(
    found: CapacityCurve | SettlementPath, path: str | Path, *, azimuth: float = AZIMUTH, elevation: float = ELEVATION
) -> Path:
    """Write how the blocks move along a capacity curve or a settlement, in true scale.

    Parameters
    ----------
    found : CapacityCurve or SettlementPath
        What `blockstat.capacity` or `blockstat.settle_to_collapse` returned.
    path : str or Path
        An animated GLB, coloured by how far each block moves; or a PNG or any format that matplotlib writes, for a
        strip of moments side by side, with the widths of the widest cracks in millimetres where supports settle.
    azimuth, elevation : float, optional
        Where one looks from at a strip [deg].

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For a file that cannot be written.

    Notes
    -----
    A support that moves in part only is drawn where it was.

    Examples
    --------
    >>> from blockstat import Assembly, box, capacity, write_path
    >>> blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (0.5, 1, 2), name="block")]
    >>> wall = Assembly.from_blocks(blocks, supports=["ground"])
    >>> write_path(capacity(wall, (1, 0, 0), steps=10), "falls.glb").name
    'falls.glb'
    """
    path = film_path(path)
    assembly = found.assembly if isinstance(found, CapacityCurve) else found.first.assembly
    poses = [point.pose for point in found.points] if isinstance(found, CapacityCurve) else found.poses
    displacement, rotation = (
        np.array([getattr(pose, name) for pose in poses]) for name in ("displacement", "rotation")
    )
    if isinstance(found, SettlementPath):
        moves = found.first.mechanism[assembly.support, :3] / found.first.displacement
        displacement[:, assembly.support] += found.displacement[:, None, None] * moves
    if path.suffix.lower() != ".glb":
        _strip(found, assembly, path, displacement, rotation, (azimuth, elevation))
        return path
    times = film_times(found.displacement)
    if len(times) == 1:
        times, displacement, rotation = np.array([0.0, SECONDS]), displacement[[0, 0]], rotation[[0, 0]]
    length = np.where(assembly.support, 0.0, np.linalg.norm(displacement, axis=2).max(axis=0))
    return write_motion(
        assembly, path, times=times, displacement=displacement, quaternion=quaternions(rotation), values=length,
        name="path",
    )  # fmt: skip


def _strip(
    found: CapacityCurve | SettlementPath,
    assembly: Assembly,
    path: Path,
    displacement: Floats,
    rotation: Floats,
    angles: tuple[float, float],
) -> None:
    """Moments along a path side by side, each in the same window."""
    there = found.displacement
    chosen = np.unique(np.abs(there[:, None] - np.linspace(there[0], there[-1], FRAMES)).argmin(axis=0))
    across = view_of(*angles)[:2]
    corners = [posed(assembly, displacement[k], rotation[k]) @ across.T for k in chosen]
    low, high = np.min([c.min(axis=0) for c in corners], axis=0), np.max([c.max(axis=0) for c in corners], axis=0)
    width, height = np.maximum(1.08 * (high - low), 1e-300)
    panel = min(HEIGHT * width / height, WIDEST / len(chosen))
    figure = fresh_figure(path)
    figure.set_size_inches(panel * len(chosen) + 0.2, panel * height / width + 0.5)
    panels = figure.subplots(1, len(chosen), squeeze=False)[0]
    for axes, k in zip(panels, chosen, strict=True):
        plot(assembly, axes, displacement=displacement[k], rotation=rotation[k], azimuth=angles[0], elevation=angles[1])
        middle = 0.5 * (low + high)
        axes.set_xlim(middle[0] - width / 2, middle[0] + width / 2)
        axes.set_ylim(middle[1] - height / 2, middle[1] + height / 2)
        axes.set_title(f"{plain(1e3 * float(there[k]))} mm", fontsize=9)
        if isinstance(found, SettlementPath):
            _widths(found, axes, float(there[k]), displacement[k], across)
    save_figure(figure, path)


def _widths(found: SettlementPath, axes: Axes, there: float, displacement: Floats, across: Floats) -> None:
    """The widths of the widest cracks, between the two blocks."""
    assembly = found.first.assembly
    number = {name: k for k, name in enumerate(assembly.names)}
    for pair, width in found.cracks(there)[:NAMED]:
        own = [number[name] for name in pair]
        place = across @ (assembly.centroid + displacement)[own].mean(axis=0)
        axes.annotate(f"{1e3 * width:.3g}", place, fontsize=6, ha="center", va="center", bbox=LABEL)
