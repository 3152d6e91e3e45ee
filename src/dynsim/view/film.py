"""Films of a run: its motion past the verdict, a moving picture, and a strip of a few moments side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_number
from blockstat.system.writing import check_directory, written_whole
from blockstat.typing import Floats, Ints
from blockstat.view.painter import AZIMUTH, ELEVATION, posed, view_of, visible
from blockstat.view.plot import SUPPORT, save_figure
from dynsim.engine.world import Action, World
from dynsim.judge.run import Run, simulate
from dynsim.judge.verdict import DynamicVerdict
from dynsim.loads.load import Loads

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

#: The picture holds what falls up to this far beyond the blocks as built, and a margin, as shares of their larger
#: extent; what flies further is cut.
REACH, MARGIN = 0.6, 0.06
MOVED = "YlOrRd"  #: pale where nothing moved, so that joints are seen there
HEIGHT, WIDEST = 3.0, 24.0  #: of a panel and of the strip [inches]
MOVING = (".gif", ".mp4")  #: what `write_movie` writes
LARGEST = 6.0  #: the longer side of a moving picture [inches]


#: Nothing that falls does so for longer [s].
LONGEST = 600.0


def past_verdict(
    verdict: DynamicVerdict,
    seconds: float,
    *,
    loads: Loads = (),
    actions: Sequence[Action] = (),
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> Run:
    """Simulate the run of a verdict again, and go on past the moment at which it was decided.

    A run ends as soon as it is decided, so a fall is seen only as far as the threshold. This shows the rest of it. The
    verdict stays as it is. In Bullet what falls past the supports comes to lie on a floor, a little below the lowest
    point of all blocks as built. It is laid at the moment of the verdict, so it cannot change what was judged.

    Parameters
    ----------
    verdict : DynamicVerdict
        What `verify` returned.
    seconds : float
        How long to go on [s].
    loads, actions, gap, interfaces : optional
        Those that `verify` was called with. A verdict does not keep them: with others, or where they are left out, the
        film is of another motion than the one that was judged.

    Returns
    -------
    Run
        The same motion, and what follows.

    Raises
    ------
    InputError
        For a number of seconds that is not positive or above 600, and for a verdict without its settings.

    Examples
    --------
    >>> from blockstat.model import arch, assemble
    >>> from dynsim import past_verdict, verify
    >>> ring = assemble(arch(span=2.0, thickness=0.06, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> verdict = verify(ring)
    >>> film = past_verdict(verdict, 0.3)
    >>> verdict.outcome.word, round(float(film.times[-1] - verdict.run.times[-1]), 1)
    ('falls', 0.3)
    """
    check_number("film: seconds", seconds)
    if not 0 < seconds <= LONGEST:
        raise InputError(f"film: {seconds!r} seconds; a positive number of at most {LONGEST:g} is needed")
    if verdict.settings is None:
        raise InputError("film: the verdict does not know the settings of its run")
    run = verdict.run
    end = (float(run.times[-1]) + seconds) * run.pace
    # The longest window belongs to a resolution; a run that is not judged needs none.
    settings = replace(verdict.settings, end=max(end, verdict.settings.look_every), resolution=1.0)
    floor = [_Floor(float(run.times[-1]), verdict.brick_threshold + verdict.settling)]
    beside = [*actions, *(floor if run.engine == "bullet" else [])]
    joints: dict[str, Any] = {"gap": gap, "interfaces": interfaces}
    return simulate(run.assembly, settings=settings, loads=loads, actions=beside, engine=run.engine, **joints)


class _Floor:
    """Something to fall on, laid at a time [s], so far below the lowest point of the blocks as built [m]."""

    each_step = False

    def __init__(self, time: float, below: float) -> None:
        self._time, self._below = time, below

    def begin(self, world: World) -> None:
        pass

    def act(self, world: World, time: float) -> None:
        if time >= self._time - 1e-9:
            world.lay_floor(self._below)
            self._time = np.inf


def write_movie(run: Run, path: str | Path, *, frames_per_second: int = 25, slower: float = 1.0, **view: float) -> Path:
    """Write a run as a moving picture.

    Parameters
    ----------
    run : Run
        What is drawn.
    path : str or Path
        A GIF, or an MP4, which needs the package imageio-ffmpeg.
    frames_per_second : int
        Pictures a second of the film.
    slower : float
        How many seconds of the film show one of the run.
    **view : float
        `azimuth` and `elevation`, as in `film_strip`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For another suffix, a bad number, or an MP4 without that package.
    """
    from matplotlib import rc_context
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from matplotlib.figure import Figure

    path = Path(path)
    if path.suffix.lower() not in MOVING:
        raise InputError(f'{path}: cannot write "{path.suffix}"; a moving picture is written as: {", ".join(MOVING)}')
    if not (frames_per_second >= 1 and slower > 0):
        raise InputError(f"film: {frames_per_second!r} frames a second, {slower!r} times slower; both must be positive")
    count = max(round(float(run.times[-1]) * slower * frames_per_second), 1) + 1
    chosen = np.abs(run.times[:, None] - np.linspace(0.0, run.times[-1], count)).argmin(axis=0)
    painter = _Painter(run, chosen, **view)
    scale = LARGEST / float(painter.extent.max())
    width, height = (2 * round(50 * max(side, 1.0)) / 100 for side in painter.extent * scale)
    figure = Figure(figsize=(width, height), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    with rc_context({"animation.ffmpeg_path": mp4_program()} if path.suffix.lower() == ".mp4" else {}):
        kind: Any = FFMpegWriter if path.suffix.lower() == ".mp4" else PillowWriter
        writer = kind(fps=frames_per_second)
        with written_whole(path) as place, writer.saving(figure, str(place), dpi=100):
            for frame in chosen:
                axes.clear()
                painter.paint(axes, int(frame))
                axes.text(0.02, 0.97, f"{run.times[frame]:.2f} s", transform=axes.transAxes, va="top", fontsize=9)
                writer.grab_frame()
    return path


def mp4_program() -> str:
    """Return the program that makes MP4 files.

    Returns
    -------
    str
        Its path.

    Raises
    ------
    InputError
        Where the package imageio-ffmpeg, which brings it, is not installed.
    """
    try:
        import imageio_ffmpeg  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InputError(
            "an MP4 needs the package imageio-ffmpeg: pip install imageio-ffmpeg; a GIF needs none"
        ) from None
    return imageio_ffmpeg.get_ffmpeg_exe()


def film_strip(
    run: Run,
    path: str | Path,
    *,
    frames: int = 5,
    times: Sequence[float] | None = None,
    azimuth: float = AZIMUTH,
    elevation: float = ELEVATION,
) -> Path:
    """Draw moments of a run side by side.

    Colours tell how far each block has moved since release. Blocks that were taken out are not drawn.

    Parameters
    ----------
    run : Run
        What is drawn.
    path : str or Path
        A PNG, or any format that matplotlib writes.
    frames : int
        How many moments, evenly spread from release to the end.
    times : sequence of float, optional
        The moments themselves instead [s].
    azimuth, elevation : float
        From where one looks [degrees].

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For a bad path, moment or number.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> from dynsim import film_strip, simulate
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> film_strip(simulate(pillar), "pillar.png", frames=3).name
    'pillar.png'
    """
    from matplotlib.figure import Figure

    path = Path(path)
    check_directory(path)
    chosen = _moments(run, frames, times)
    painter = _Painter(run, chosen, azimuth, elevation)
    width, height = painter.extent
    panel = min(HEIGHT * width / height, WIDEST / len(chosen))
    figure = Figure(figsize=(panel * len(chosen) + 0.9, panel * height / width + 0.5), dpi=150, layout="constrained")
    panels = figure.subplots(1, len(chosen), squeeze=False)[0]
    for axes, frame in zip(panels, chosen, strict=True):
        painter.paint(axes, int(frame))
        axes.set_title(f"{run.times[frame]:.2f} s", fontsize=9)
    figure.colorbar(painter.colours, ax=list(panels), label="moved [mm]", shrink=0.8, aspect=30)
    save_figure(figure, path)
    return path


class _Painter:
    """Draws frames of a run in one window, in colours that tell how far each block has moved since release."""

    def __init__(self, run: Run, chosen: Ints, azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> None:
        from matplotlib import colormaps
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        self.run, self.view = run, view_of(azimuth, elevation)
        length = np.linalg.norm(run.since_release[chosen], axis=2)
        furthest = float(length[:, run.assembly.free].max()) * 1e3
        self.colours: ScalarMappable = ScalarMappable(Normalize(0.0, max(furthest, 1e-9)), colormaps[MOVED])
        self.lower, self.upper = _window(run, self.view, chosen)
        self.extent = self.upper - self.lower  #: shape (2,) [m]

    def paint(self, axes: Axes, frame: int) -> None:
        """Draw one frame."""
        from matplotlib.collections import PolyCollection

        run, assembly = self.run, self.run.assembly
        moved = np.linalg.norm(run.since_release[frame], axis=1)
        colour = np.array(self.colours.to_rgba(moved * 1e3))
        colour[assembly.support, :3] = SUPPORT
        # Blocks that are gone stay in the list without paint.
        colour[run.removed < run.times[frame] + 1e-12, 3] = 0.0
        if run.placed is not None:
            # A block is put in at the beginning of a step, which is the time of the frame before.
            colour[run.placed >= run.times[frame] - 1e-12, 3] = 0.0
        vertices = posed(assembly, run.displacement[frame], run.rotation[frame])
        polygons, paint, outline = visible(assembly, vertices, self.view, colour)
        axes.add_collection(PolyCollection(polygons, facecolors=paint, edgecolors=outline, linewidths=0.3))
        axes.set(xlim=(self.lower[0], self.upper[0]), ylim=(self.lower[1], self.upper[1]), aspect="equal")
        axes.set(xticks=[], yticks=[])
        axes.axis("off")


def _moments(run: Run, frames: int, times: Sequence[float] | None) -> Ints:
    """Frames to draw."""
    if times is None:
        if frames < 1:
            raise InputError(f"film strip: frames is {frames!r}; it must be at least 1")
        return np.unique(np.linspace(0, len(run.times) - 1, frames).round().astype(np.int64))
    given = np.asarray(times, dtype=float)
    bad = given[~((given >= 0) & (given <= run.times[-1] + 1e-9))]
    if len(bad) or not len(given):
        raise InputError(f"film strip: times are {list(times)!r}; they must lie between 0 and {run.times[-1]:g} s")
    return np.abs(run.times[:, None] - given).argmin(axis=0)


def _window(run: Run, view: Floats, chosen: Ints) -> tuple[Floats, Floats]:
    """Corners of the picture plane to show, shape (2,) each [m]."""
    assembly = run.assembly
    free = ~assembly.support[assembly.vertex_block]
    flat, first = assembly.vertices @ view[:2].T, assembly.vertex_start[:-1]
    lower, upper = flat[free].min(axis=0), flat[free].max(axis=0)
    extent = (upper - lower).max()
    # Foundations are seen whole; a slab that is larger than all that stands on it is cut.
    size = (np.maximum.reduceat(flat, first) - np.minimum.reduceat(flat, first)).max(axis=1)
    shown = (~assembly.support | (size < extent))[assembly.vertex_block]
    lower, upper = flat[shown].min(axis=0), flat[shown].max(axis=0)
    seen = np.concatenate([posed(assembly, run.displacement[k], run.rotation[k])[shown] for k in chosen]) @ view[:2].T
    lower = np.clip(seen.min(axis=0), lower - REACH * extent, lower)
    upper = np.clip(seen.max(axis=0), upper, upper + REACH * extent)
    return lower - MARGIN * extent, upper + MARGIN * extent
