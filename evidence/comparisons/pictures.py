"""Pictures of the comparisons of static and dynamic verdicts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.colors import Normalize

from blockstat import Assembly, assess
from blockstat.view.painter import posed, view_of, visible
from blockstat.view.plot import SUPPORT, mechanism_pose
from dynsim import Comparison, Comparisons, Settings, simulate, verify
from evidence.comparisons.limits import LimitRow
from evidence.plotting import COLOURS, panels, save

#: A fall is drawn when a block has gone this far, in block sizes; a mechanism moved this far, in extents.
FAR, SHOWN = 0.6, 0.06
COLUMNS, LEAST_SHARE = 5, 0.9


def contact_sheet(rows: Sequence[tuple[Comparison, Assembly]], path: Path) -> None:
    """A panel an assembly: Bullet's fall, the static mechanism of what stands though it should not, or as it rests."""
    columns = min(COLUMNS, len(rows))
    lines = -(-len(rows) // columns)
    figure, places = panels((2.4 * columns, 2.3 * lines), lines, columns)
    for axes in places:
        axes.axis("off")
    for axes, (row, assembly) in zip(places, rows, strict=False):
        vertices, drawn = _moved(row, assembly)
        _draw(axes, assembly, vertices)
        axes.set_title(f"{row.name}\n{drawn}", fontsize=7)
    save(figure, path, dpi=100)


def _moved(row: Comparison, assembly: Assembly) -> tuple[np.ndarray, str]:
    """Corners to draw, and what they show."""
    if row.dynamic != "stands":
        far = FAR * float(np.median(assembly.size[assembly.free]))
        step = verify(assembly).run.time_step
        run = simulate(
            assembly,
            settings=Settings(time_step=step),
            stop=lambda _, moved, __: bool(np.linalg.norm(moved, axis=1).max() > far),
        )
        return posed(assembly, run.displacement[-1], run.rotation[-1]), f"Bullet after {run.times[-1]:.2g} s"
    if row.static == "unstable":
        lower, upper = assembly.bounds
        reach = SHOWN * float((upper.max(axis=0) - lower.min(axis=0)).max())
        return posed(assembly, *mechanism_pose(assess(assembly), amplitude=reach)), "stands; static mechanism"
    return assembly.vertices, "stands"


def _draw(axes, assembly: Assembly, vertices: np.ndarray) -> None:
    """Blocks at some place, coloured by how far they have moved."""
    from matplotlib import colormaps
    from matplotlib.collections import PolyCollection

    moved = np.maximum.reduceat(np.linalg.norm(vertices - assembly.vertices, axis=1), assembly.vertex_start[:-1])
    colour = colormaps["YlOrRd"](Normalize(0.0, max(float(moved.max()), 1e-12))(0.8 * moved))
    colour[assembly.support, :3] = SUPPORT
    view = view_of(-55.0, 25.0)
    polygons, paint, outline = visible(assembly, vertices, view, colour)
    axes.add_collection(PolyCollection(polygons, facecolors=paint, edgecolors=outline, linewidths=0.3))
    free = ~assembly.support[assembly.vertex_block]
    seen = np.vstack([assembly.vertices[free], vertices[free]]) @ view[:2].T
    lower, upper = seen.min(axis=0), seen.max(axis=0)
    margin = 0.12 * (upper - lower).max()
    axes.set(xlim=(lower[0] - margin, upper[0] + margin), ylim=(lower[1] - margin, upper[1] + margin), aspect="equal")


def histogram(rows: Comparisons, family: Callable[[Comparison], str], path: Path) -> None:
    """Cosines between the static mechanism and Bullet's first motion."""
    own = [row for row in rows if row.cosine is not None]
    names = list(dict.fromkeys(family(row) for row in own))
    figure, (axes,) = panels((6.5, 3.2))
    least = min([0.8, *(row.cosine for row in own if row.cosine is not None)])
    axes.hist(
        [[row.cosine for row in own if family(row) == name] for name in names],
        bins=list(np.linspace(np.floor(20 * least) / 20, 1.0, 21)), stacked=True, label=names,
        color=[COLOURS[k % len(COLOURS)] for k in range(len(names))], edgecolor="white", linewidth=0.4,
    )  # fmt: skip
    axes.set(xlabel="cosine of the static mechanism with Bullet's first motion", ylabel="scenes")
    axes.legend(frameon=False, fontsize=8)
    save(figure, path)


def scatter(rows: Sequence[LimitRow], path: Path) -> None:
    """Bullet's limit over both static ones."""
    figure, places = panels((9.0, 4.4), 1, 2, sharey=True)
    names = list(dict.fromkeys(row.family for row in rows))
    titles = ("force fields alone", "without dilatancy")
    for axes, which, title in zip(places, ("associated", "coulomb"), titles, strict=True):
        ends = [0.8 * min(row.bullet for row in rows), 1.25 * max(row.associated for row in rows)]
        axes.plot(ends, ends, color="black", linewidth=0.8, zorder=0)
        axes.plot(ends, [LEAST_SHARE * end for end in ends], color="grey", linewidth=0.6, linestyle="--", zorder=0)
        for k, name in enumerate(names):
            own = [row for row in rows if row.family == name]
            axes.scatter(
                [getattr(row, which) for row in own], [row.bullet for row in own], s=26,
                color=COLOURS[k % len(COLOURS)], marker="osD^vP"[k % 6], edgecolors="black", linewidths=0.4, label=name,
            )  # fmt: skip
        axes.set(xscale="log", yscale="log", xlabel=f"static limit, {title} [g]", aspect="equal")
        axes.grid(alpha=0.3, which="both", linewidth=0.4)
    places[0].set_ylabel("Bullet's limit [g]")
    places[0].legend(frameon=False, fontsize=8)
    save(figure, path)
