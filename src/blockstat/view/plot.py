"""Pictures of assemblies and of what the statics say about them, with matplotlib, no OpenGL.

Each goes to a file, or into axes of one's own: `figure, axes = plt.subplots()`, then `plot(assembly, axes)`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from blockstat.analysis.limit_load import LimitLoad, LoadOutcome
from blockstat.analysis.verdict import Outcome, Verdict, corner_speed
from blockstat.errors import InputError, known_options
from blockstat.result import plain
from blockstat.sensitivity.parameters import stone_sensitivity
from blockstat.system.writing import check_directory, written_whole
from blockstat.typing import Floats, Ints
from blockstat.view.painter import AZIMUTH, ELEVATION, looked_at, posed, view_of, visible, with_copies

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from blockstat.assembly import Assembly
    from blockstat.contact.interfaces import Interfaces

#: Where a picture goes: a file, or matplotlib axes.
Place = TypeVar("Place", str, Path, "Axes")

STONE = (0.87, 0.83, 0.75)
SUPPORT = (0.72, 0.74, 0.76)
UNKNOWN = (0.45, 0.45, 0.45)  #: blocks without a value, darker than supports
MOVED = "plasma"  #: colour maps that keep their order in grey and for colour-blind readers
DEMAND = "viridis"
USED = "friction or strength used in the force field found (1: at the limit)"  #: label of `Verdict.demand`
SIGNED = "RdBu"  #: blue above zero, red below
THIN = "#0072B2"  #: contacts without area
GHOST = (0.95, 0.95, 0.95, 0.55)
NO_PICTURE = {"pgf", "raw", "rgba"}  #: what matplotlib writes that is code for TeX, or no file of a picture
STILL = 1e-3  #: blocks slower than this, relative to the fastest, leave no ghost


@known_options
def plot(
    assembly: Assembly,
    place: Place,
    *,
    values: Floats | None = None,
    label: str = "",
    colours: str = MOVED,
    top: float | None = None,
    bottom: float = 0.0,
    displacement: Floats | None = None,
    rotation: Floats | None = None,
    ghosts: Ints | None = None,
    title: str = "",
    azimuth: float = AZIMUTH,
    elevation: float = ELEVATION,
    opacity: float = 1.0,
    overlay: Callable[[Axes], None] | None = None,
) -> Place:
    """Draw the blocks in parallel projection.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    place : str, Path or matplotlib Axes
        A file, in PNG or any format that matplotlib writes, or the axes to draw in.
    values : array of float, shape (n_blocks,), optional
        One number a block to colour by; a block without one, nan, is grey.
    label : str, optional
        Of the colour bar, with the unit of the values.
    colours : str, optional
        Name of a colour map of matplotlib.
    top, bottom : float, optional
        Ends of the colour bar; the top by default the largest value.
    displacement : array of float, shape (n_blocks, 3), optional
        How far the blocks are drawn from their places [m].
    rotation : array of float, shape (n_blocks, 3, 3), optional
        How they are turned about their centroids, as rotation matrices.
    ghosts : array of int, optional
        Blocks, ascending, that are drawn a second time where they were, pale and behind the others.
    title : str, optional
        Above the picture.
    azimuth, elevation : float, optional
        Where one looks from [deg].
    opacity : float, optional
        Of the blocks, 0 to 1.
    overlay : callable, optional
        Draws on the axes at last.

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
    >>> from blockstat import Assembly, box, plot
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    >>> plot(cube, "cube.png", azimuth=30.0)
    'cube.png'
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import Normalize

    if isinstance(place, (str, Path)):
        figure = fresh_figure(Path(place))
        axes = figure.add_subplot()
    else:
        figure, axes = None, place
    view = view_of(azimuth, elevation)
    colour = np.where(assembly.support[:, None], SUPPORT, STONE).astype(float)
    bar = None
    if values is not None:
        scale = Normalize(bottom, top or max(float(np.nan_to_num(values).max()), 1e-12))
        bar = ScalarMappable(scale, colormaps[colours])
        known = np.isfinite(values)[:, None]
        painted = np.where(known, bar.to_rgba(np.nan_to_num(values))[:, :3], UNKNOWN)
        colour = np.where(assembly.support[:, None], SUPPORT, painted)

    colour = np.column_stack([colour, np.full(assembly.n_blocks, opacity)])
    ghosts = np.empty(0, dtype=np.int64) if ghosts is None else ghosts
    polygons, paint, outline = _haunted(assembly, posed(assembly, displacement, rotation), view, colour, ghosts)
    axes.add_collection(PolyCollection(polygons, facecolors=paint, edgecolors=outline, linewidths=0.35))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.axis("off")
    if title:
        axes.set_title(title, fontsize=11, parse_math=False)
    if bar is not None:
        axes.figure.colorbar(bar, ax=axes, shrink=0.6).set_label(label, parse_math=False)
    if overlay is not None:
        overlay(axes)
    if figure is not None:
        save_figure(figure, place)
    return place


def save_figure(figure: Any, path: Any) -> None:
    """Write a picture whole or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The picture.
    path : str or Path
        The file; its suffix is the format.

    Raises
    ------
    InputError
        For a format that matplotlib does not write, or a disk that is full.
    """
    with written_whole(path) as beside:
        try:
            figure.savefig(str(beside))
        except ValueError as error:
            raise InputError(f"{path}: {error}") from None


def fresh_figure(path: Path) -> Figure:
    """Return an empty figure for a file that can be written.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    matplotlib Figure
        In the size of all pictures.

    Raises
    ------
    InputError
        For a file that cannot be written, or a suffix that is no picture's.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    check_directory(path)
    if not path.suffix:
        raise InputError(f"{path}: a picture needs a suffix, such as .png, .svg or .pdf")
    if path.suffix.lower() == ".glb":
        raise InputError(f"{path}: only a mechanism is written as .glb (--mechanism); a picture is .png or .svg")
    figure = Figure(figsize=(8, 6), dpi=150, layout=ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.1))
    written = figure.canvas.get_supported_filetypes().keys() - NO_PICTURE
    if path.suffix.lower().removeprefix(".") not in written:
        raise InputError(f'{path}: no picture is written as "{path.suffix}"; a picture is .png, .svg or .pdf')
    return figure


def _haunted(
    assembly: Assembly, vertices: Floats, view: Floats, colour: Floats, ghosts: Ints
) -> tuple[list[Floats], Floats, Floats]:
    """Polygons and colours of blocks moved to `vertices`, with ghosts of some of them where they were."""
    layer = np.zeros(assembly.n_blocks + len(ghosts), dtype=np.int64)
    layer[ghosts], layer[assembly.n_blocks :] = 1, -1
    both = with_copies(assembly, ghosts)
    vertices = np.concatenate([vertices, both.vertices[len(vertices) :]])
    colour = np.concatenate([colour, np.broadcast_to(GHOST, (len(ghosts), 4))])
    return visible(both, vertices, view, colour, layer)


def plot_verdict(verdict: Verdict, place: Place, **options: Any) -> Place:
    """Draw the mechanism of an assembly that moves, else the demand on the joints of one that stands.

    Parameters
    ----------
    verdict : Verdict
        The verdict.
    place : str, Path or matplotlib Axes
        A file or axes, as in `plot`.
    **options
        Options of `plot_mechanism` where blocks move. Where none moves, options of `plot` without `values`, `label`,
        `colours`, `top` and `title`, which are set here.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        For a file that cannot be written, an unknown option, or an amplitude that is not above 0.

    Examples
    --------
    >>> from blockstat import Assembly, assess, box, plot_verdict
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plot_verdict(assess(assembly), "stands.png")
    'stands.png'
    >>> plot_verdict(assess(assembly, gravity=(9.0, 0.0, -9.81)), "falls.png")
    'falls.png'
    """
    assembly = verdict.assembly
    if not len(verdict.moving):
        drawn = {
            "values": verdict.demand(), "colours": DEMAND, "top": 1.0, "label": USED,
            "title": f"{assembly.name}: {verdict.outcome.word.replace('_', ' ')}",
        }  # fmt: skip
        return plot(assembly, place, **drawn | options)
    return plot_mechanism(verdict, place, **options)


def plot_mechanism(
    result: Verdict | LimitLoad, place: Place, *, amplitude: float | None = None, **options: Any
) -> Place:
    """Draw a mechanism in front of a pale ghost of the assembly at rest.

    Parameters
    ----------
    result : Verdict or LimitLoad
        What has a mechanism: an unstable verdict or a limit load.
    place : str, Path or matplotlib Axes
        A file or axes, as in `plot`.
    amplitude : float, optional
        How far the fastest corner goes [m]; by default a twelfth of the assembly's extent.
    **options
        Options of `plot`; `ghosts=None` leaves out the ghost.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        When nothing moves (the verdict is stable, or the load has no limit), when `amplitude` is not above 0, for a
        file that cannot be written, or for an unknown option.

    Examples
    --------
    >>> from blockstat import Assembly, box, limit_load, plot_mechanism
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plot_mechanism(limit_load(assembly, (1, 0, 0)), "pushed.png", amplitude=0.3)
    'pushed.png'
    """
    assembly = result.assembly
    shown, turned = mechanism_pose(result, amplitude=amplitude)
    speed = corner_speed(assembly, result.mechanism)
    if isinstance(result, Verdict):
        title = f"{assembly.name}: {result.outcome.word}, first motion exaggerated"
    else:
        title = f"{assembly.name}: mechanism of the limit load, multiplier {result.upper:.4g}"
    drawn = {
        "values": speed, "label": "speed of the fastest corner, relative", "title": title, "displacement": shown,
        "rotation": turned, "ghosts": np.flatnonzero(speed > STILL),
    }  # fmt: skip
    return plot(assembly, place, **drawn | options)


def plot_stone_sensitivity(limit: LimitLoad, direction: Sequence[float], place: Place, **options: Any) -> Place:
    """Draw where a stone more helps most: what mass added at each block does to the limit load.

    Blue raises the limit, red lowers it. The numbers are for a hundredth of the masonry's mass at the block's centroid,
    pushed like the rest (see `blockstat.sensitivity.parameters.stone_sensitivity`).

    Parameters
    ----------
    limit : LimitLoad
        A limit load.
    direction : sequence of float
        Three numbers, the acceleration of which `limit` is the limit.
    place : str, Path or matplotlib Axes
        A file or axes, as in `plot`.
    **options
        Options of `plot`.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        When the load has no limit, when `limit` is not that of `direction`, for a file that cannot be written, or for
        an unknown option.

    Examples
    --------
    >>> from blockstat import Assembly, box, limit_load, plot_stone_sensitivity
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> limit = limit_load(assembly, (1, 0, 0))
    >>> plot_stone_sensitivity(limit, (1, 0, 0), "stone.png")
    'stone.png'
    """
    assembly = limit.assembly
    change = stone_sensitivity(limit, direction) * 0.01 * assembly.mass[assembly.free].sum()
    reach = max(float(np.abs(change).max()), 1e-12)
    drawn = {
        "values": change, "colours": SIGNED, "bottom": -reach, "top": reach,
        "label": "change of the limit by 1 % more mass, put here",
        "title": f"{assembly.name}: where a stone more helps (limit {limit.lower:.4g})",
    }  # fmt: skip
    return plot(assembly, place, **drawn | options)


def mechanism_pose(result: Verdict | LimitLoad, *, amplitude: float | None = None) -> tuple[Floats, Floats]:
    """Return the blocks moved along a mechanism.

    Parameters
    ----------
    result : Verdict or LimitLoad
        What has a mechanism.
    amplitude : float, optional
        How far the fastest corner goes [m]; by default a twelfth of the assembly's extent.

    Returns
    -------
    displacement : array of float, shape (n_blocks, 3)
        Displacements of the centroids [m].
    rotation : array of float, shape (n_blocks, 3, 3)
        Finite rotations about the centroids, as matrices.

    Raises
    ------
    InputError
        When the result has no mechanism, or when `amplitude` is not above 0.

    Examples
    --------
    >>> from blockstat import Assembly, box, limit_load, mechanism_pose
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> displacement, rotation = mechanism_pose(limit_load(assembly, (1, 0, 0)), amplitude=0.3)
    >>> displacement.shape, rotation.shape
    ((2, 3), (2, 3, 3))
    """
    from scipy.spatial.transform import Rotation

    twist = moving_twist(result, amplitude)
    return twist[:, :3], Rotation.from_rotvec(twist[:, 3:]).as_matrix()


def moving_twist(result: Verdict | LimitLoad, amplitude: float | None = None) -> Floats:
    """Return the motion of each block at the end of the motion shown.

    Parameters
    ----------
    result : Verdict or LimitLoad
        What has a mechanism.
    amplitude : float, optional
        How far the fastest corner goes [m]; by default a twelfth of the assembly's extent.

    Returns
    -------
    array of float, shape (n_blocks, 6)
        Displacement of the centroid [m] and rotation vector [rad].

    Raises
    ------
    InputError
        When the result has no mechanism, or when `amplitude` is not above 0.
    """
    name, outcome = result.assembly.name, result.outcome
    if not result.mechanism.any():
        kind = "limit load" if isinstance(outcome, LoadOutcome) else "verdict"
        raise InputError(
            f"{name}: no mechanism to show, the {kind} is {outcome.word}; an unstable verdict or a limit load has one"
        )
    if amplitude is None:
        amplitude = extent(result.assembly) / 12
    if not (np.isfinite(amplitude) and amplitude > 0):
        raise InputError(f"amplitude is {amplitude!r}; it must be a length above 0 [m]")
    return amplitude * result.mechanism


def extent(assembly: Assembly) -> float:
    """Return the longest side of the box round the free blocks.

    Parameters
    ----------
    assembly : Assembly
        The blocks; where all are supports, the box is round all of them.

    Returns
    -------
    float
        Length [m].
    """
    lower, upper = assembly.bounds
    free = assembly.free if len(assembly.free) else np.arange(assembly.n_blocks)
    return float((upper[free].max(axis=0) - lower[free].min(axis=0)).max())


def plot_forces(verdict: Verdict, place: Place, **options: Any) -> Place:
    """Draw the resultant of each joint as a line through its centre of pressure, over pale blocks.

    The lines' lengths go with the forces; in an arch they join up to its thrust line. Of an assembly that does not
    stand the forces are those of least residual tension, as the title says, and joints in tension are dotted. Contacts
    without area are blue: an edge on a face is a line, a corner or the crossing of two edges is a dot.

    Parameters
    ----------
    verdict : Verdict
        The verdict.
    place : str, Path or matplotlib Axes
        A file or axes, as in `plot`.
    **options
        Options of `plot` without `overlay`, which draws the forces.

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
    >>> from blockstat import Assembly, assess, box, plot_forces
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plot_forces(assess(assembly), "forces.png")
    'forces.png'
    """
    from matplotlib.colors import to_rgba

    look, view = looked_at(options)
    point, force, tension = resultants(verdict)
    size = np.linalg.norm(force, axis=1)
    reach = 0.06 * extent(verdict.assembly) / max(float(size.max(initial=0.0)), 1e-300)

    faces = verdict.interfaces
    thin = np.flatnonzero(faces.kinds)

    def draw(axes: Axes) -> None:
        draw_joints(axes, faces, view, thin, np.broadcast_to(to_rgba(THIN), (len(thin), 4)))
        for middle, pull, torn in zip(point, force, tension, strict=True):
            ends = np.array([middle - reach * pull, middle + reach * pull]) @ view[:2].T
            axes.plot(*ends.T, color="#b2182b", linewidth=1.2, linestyle=":" if torn else "-")

    name = verdict.assembly.name
    what = "joint forces" if balanced(verdict) else "not in equilibrium, joint forces of least residual tension"
    drawn = {"title": f"{name}: {what}, longest {plain(size.max(initial=0.0) / 1e3)} kN", "opacity": 0.35}
    return plot(verdict.assembly, place, **drawn | look, overlay=draw)


def balanced(verdict: Verdict) -> bool:
    """Return whether the forces of a verdict balance the blocks without adhesion.

    Parameters
    ----------
    verdict : Verdict
        The verdict.

    Returns
    -------
    bool
    """
    return verdict.outcome in (Outcome.STABLE, Outcome.STABLE_ONLY_BY_SELF_STRESS)


def draw_joints(
    axes: Axes, interfaces: Interfaces, view: Floats, rows: Ints, colours: Any, shift: Floats | None = None
) -> None:
    """Draw joints: a patch as a polygon, an edge on a face as a line, a corner or a crossing of edges as a dot.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    interfaces : Interfaces
        The joints.
    view : array of float, shape (3, 3)
        Right, up and towards the eye, as `view_of` returns them.
    rows : array of int, shape (n,)
        The joints that are drawn, in this order. Lines and dots come after all patches.
    colours : array of float, shape (n, 4)
        Colours, red, green, blue and opacity.
    shift : array of float, shape (n, 3), optional
        How far they are drawn from their places [m].
    """
    from matplotlib.collections import LineCollection, PolyCollection

    away = np.zeros((len(rows), 3)) if shift is None else shift
    flat = [(interfaces.outline(k) + step) @ view[:2].T for k, step in zip(rows, away, strict=True)]
    corners = np.array([min(len(points), 3) for points in flat], dtype=np.int64)
    patches, lines, dots = ([flat[i] for i in np.flatnonzero(corners == n)] for n in (3, 2, 1))
    edge = {"edgecolors": "black", "linewidths": 0.3}
    axes.add_collection(PolyCollection(patches, facecolors=colours[corners == 3], **edge))
    # A line is drawn twice, so that a pale colour has a rim, too.
    axes.add_collection(LineCollection(lines, colors="black", linewidths=3.2, capstyle="round"))
    axes.add_collection(LineCollection(lines, colors=colours[corners == 2], linewidths=2.4, capstyle="round"))
    if dots:
        axes.scatter(*np.concatenate(dots).T, s=22, c=colours[corners == 1], zorder=3, **edge)


def resultants(verdict: Verdict) -> tuple[Floats, Floats, np.ndarray]:
    """Return the resultant of each joint that carries any.

    Parameters
    ----------
    verdict : Verdict
        The verdict.

    Returns
    -------
    point : array of float, shape (n, 3)
        Centres of pressure [m].
    force : array of float, shape (n, 3)
        Forces on the second block of each joint [N].
    tension : array of bool, shape (n,)
        Whether the joint is in tension.
    """
    return joint_resultants(verdict)[1:]


def joint_resultants(verdict: Verdict) -> tuple[Ints, Floats, Floats, np.ndarray]:
    """Return the resultant of each joint that carries any, with the number of the joint.

    Parameters
    ----------
    verdict : Verdict
        The verdict.

    Returns
    -------
    joint : array of int, shape (n,)
        Numbers of the joints, ascending.
    point : array of float, shape (n, 3)
        Centres of pressure [m].
    force : array of float, shape (n, 3)
        Forces on the second block of each joint [N].
    tension : array of bool, shape (n,)
        Whether the joint is in tension.
    """
    faces = verdict.interfaces
    net = verdict.forces - verdict.adhesion[:, None] * np.array([1.0, 0.0, 0.0])
    k = faces.point_interface
    world = np.einsum("nij,ni->nj", faces.frame[k], net)
    first = faces.start[:-1]
    if not faces.n_interfaces:
        return np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty((0, 3)), np.empty(0, dtype=bool)
    force = np.add.reduceat(world, first)
    normal = np.add.reduceat(net[:, 0], first)
    share = np.abs(net[:, 0])
    total = np.add.reduceat(share, first)
    point = np.add.reduceat(share[:, None] * faces.point, first) / np.where(total > 0, total, 1.0)[:, None]
    carries = np.linalg.norm(force, axis=1) > 1e-6 * max(float(np.linalg.norm(force, axis=1).max()), 1e-300)
    return np.flatnonzero(carries), point[carries], force[carries], normal[carries] < 0
