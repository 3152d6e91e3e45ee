"""A film strip of a run: a few moments side by side, painted as in `blockstat.view.plot`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats, Ints
from blockstat.view.painter import posed, view_of, visible
from blockstat.view.plot import SUPPORT, save_figure
from dynsim.judge.run import Run

#: The picture holds what falls up to this far beyond the blocks as built, and a margin, as shares of their larger
#: extent; what flies further is cut.
REACH, MARGIN = 0.6, 0.06
MOVED = "YlOrRd"  #: pale where nothing moved, so that joints are seen there
HEIGHT, WIDEST = 3.0, 24.0  #: of a panel and of the strip [inches]


def film_strip(
    run: Run,
    path: str | Path,
    *,
    frames: int = 5,
    times: Sequence[float] | None = None,
    azimuth: float = -55.0,
    elevation: float = 25.0,
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
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: no such directory: {path.parent}")
    chosen = _moments(run, frames, times)
    assembly, view = run.assembly, view_of(azimuth, elevation)
    length = np.linalg.norm(run.since_release[chosen], axis=2)
    shown = ScalarMappable(Normalize(0.0, max(float(length[:, assembly.free].max()) * 1e3, 1e-9)), colormaps[MOVED])
    lower, upper = _window(run, view, chosen)
    width, height = upper - lower
    panel = min(HEIGHT * width / height, WIDEST / len(chosen))
    figure = Figure(figsize=(panel * len(chosen) + 0.9, panel * height / width + 0.5), dpi=150, layout="constrained")
    panels = figure.subplots(1, len(chosen), squeeze=False)[0]
    for axes, frame, moved in zip(panels, chosen, length, strict=True):
        colour = np.array(shown.to_rgba(moved * 1e3))
        colour[assembly.support, :3] = SUPPORT
        # Blocks that are gone stay in the list without paint.
        colour[run.removed < run.times[frame] + 1e-12, 3] = 0.0
        if run.placed is not None:
            colour[run.placed > run.times[frame] + 1e-12, 3] = 0.0
        vertices = posed(assembly, run.displacement[frame], run.rotation[frame])
        polygons, paint, outline = visible(assembly, vertices, view, colour)
        axes.add_collection(PolyCollection(polygons, facecolors=paint, edgecolors=outline, linewidths=0.3))
        axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), aspect="equal", xticks=[], yticks=[])
        axes.set_title(f"{run.times[frame]:.2f} s", fontsize=9)
        axes.axis("off")
    figure.colorbar(shown, ax=list(panels), label="moved [mm]", shrink=0.8, aspect=30)
    save_figure(figure, path)
    return path


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
    built = assembly.vertices[free] @ view[:2].T
    lower, upper = built.min(axis=0), built.max(axis=0)
    extent = (upper - lower).max()
    seen = np.concatenate([posed(assembly, run.displacement[k], run.rotation[k])[free] for k in chosen]) @ view[:2].T
    lower = np.clip(seen.min(axis=0), lower - REACH * extent, lower)
    upper = np.clip(seen.max(axis=0), upper, upper + REACH * extent)
    return lower - MARGIN * extent, upper + MARGIN * extent
