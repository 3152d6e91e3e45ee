"""What the comparisons of this directory write: tables in Markdown, and pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from blockstat import Assembly, assess
from blockstat.view.painter import posed, view_of, visible
from blockstat.view.plot import SUPPORT, mechanism_pose
from dynsim import Comparison, Comparisons, Settings, simulate, verify
from dynsim.comparison.causes import Cause

STATIC = ("stable", "stable_only_by_self_stress", "undecided", "unstable")
BULLET = ("stands", "creeps", "falls")
#: A fall is drawn when a block has gone this far, in block sizes; a mechanism moved this far, in extents.
FAR, SHOWN = 0.6, 0.06
COLUMNS, LEAST_SHARE = 5, 0.9
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")


@dataclass(frozen=True)
class LimitRow:
    """Limits of one assembly in one direction, in units of gravity: force fields, without dilatancy, Bullet."""

    name: str
    family: str
    blocks: int
    associated: float
    coulomb: float
    bullet: float
    finer: float | None = None  #: Bullet's with finer time steps, where it was asked for


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def matrix(rows: Comparisons, statics: str) -> str:
    """The confusion matrix: a line for each static verdict that occurs, a column for each of Bullet's."""
    counts = rows.confusion(statics)
    said = [word for word in STATIC if any(pair[0] == word for pair in counts)]
    title = {"static": "force fields alone", "coulomb": "with Coulomb friction"}[statics]
    return table(
        [title, *(f"Bullet: {word}" for word in BULLET), "all"],
        (
            [s.replace("_", " "), *(counts.get((s, b), 0) for b in BULLET), sum(counts.get((s, b), 0) for b in BULLET)]
            for s in said
        ),
    )


def by_cause(rows: Comparisons) -> dict[Cause, Comparisons]:
    """Rows with a cause, sorted by it."""
    causes = (cause for cause in Cause if any(row.cause == cause.word for row in rows))
    return {cause: Comparisons(tuple(row for row in rows if row.cause == cause.word)) for cause in causes}


def causes(rows: Comparisons, assemblies: dict[str, Assembly], folder: Path, page: Path) -> str:
    """A section for each cause: what it is, a picture of every assembly, and the figures."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("cause-*.png"):
        old.unlink()
    sections = []
    for cause, own in by_cause(rows).items():
        picture = folder / f"cause-{cause.word.replace('_', '-')}.png"
        contact_sheet([(row, assemblies[row.name]) for row in own], picture)
        title = f"### {cause.word.replace('_', ' ').capitalize()}: {len(own)}"
        link = f"![{len(own)} assemblies]({picture.relative_to(page.parent)})"
        sections += [title, f"{cause.value[0].upper()}{cause.value[1:]}.", link, figures(own)]
    return "\n\n".join(sections)


def figures(rows: Comparisons) -> str:
    """The verdicts on some assemblies."""

    def number(value: float | None, factor: float = 1.0) -> str:
        return "" if value is None else f"{factor * value:.3g}"

    return table(
        ["", "blocks", "force fields", "Coulomb", "score", "Bullet", "settled [mm]", "then moved [mm]"],
        (
            [
                row.name, row.blocks, row.static, (row.coulomb or "").replace("_", " "), number(row.score), row.dynamic,
                number(row.settling, 1e3), number(row.max_displacement, 1e3),
            ]
            for row in rows
        ),
    )  # fmt: skip


def contact_sheet(rows: Sequence[tuple[Comparison, Assembly]], path: Path) -> None:
    """A panel an assembly: Bullet's fall, the static mechanism of what stands though it should not, or as it rests."""
    columns = min(COLUMNS, len(rows))
    lines = -(-len(rows) // columns)
    figure = Figure(figsize=(2.4 * columns, 2.3 * lines), dpi=100, layout="constrained")
    panels = list(figure.subplots(lines, columns, squeeze=False).flat)
    for axes in panels:
        axes.axis("off")
    for axes, (row, assembly) in zip(panels, rows, strict=False):
        vertices, drawn = _moved(row, assembly)
        _draw(axes, assembly, vertices)
        axes.set_title(f"{row.name}\n{drawn}", fontsize=7)
    figure.savefig(path)


def _moved(row: Comparison, assembly: Assembly) -> tuple[np.ndarray, str]:
    """Corners to draw, and what they show."""
    if row.dynamic != "stands":
        far = FAR * float(np.median(assembly.size[assembly.free]))
        step = verify(assembly).run.time_step
        run = simulate(
            assembly,
            settings=Settings(time_step=step),
            stop=lambda _, moved: bool(np.linalg.norm(moved, axis=1).max() > far),
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


def families(rows: Comparisons, family: Callable[[Comparison], str]) -> str:
    """How often verdicts agree, family by family."""
    lines = []
    names = list(dict.fromkeys(family(row) for row in rows))
    for name in [*names, "all"]:
        own = [row for row in rows if name in (family(row), "all")]
        cosines = [row.cosine for row in own if row.cosine is not None]
        lines.append(
            [
                name, len(own),
                sum(row.agree is True for row in own), sum(row.agree is False for row in own),
                sum(row.agree_coulomb is True for row in own), sum(row.agree_coulomb is False for row in own),
                sum(row.static == "unstable" and row.dynamic == "stands" for row in own),
                f"{np.median(cosines):.3f}" if cosines else "",
                f"{min(cosines):.2f}" if cosines else "",
            ]
        )  # fmt: skip
    head = ["", "scenes", "force fields agree", "differ", "Coulomb agrees", "differs", "excluded but stands"]
    return table([*head, "median cosine", "least"], lines)


def histogram(rows: Comparisons, family: Callable[[Comparison], str], path: Path) -> None:
    """Cosines between the static mechanism and Bullet's first motion."""
    own = [row for row in rows if row.cosine is not None]
    names = list(dict.fromkeys(family(row) for row in own))
    figure = Figure(figsize=(6.5, 3.2), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    least = min([0.8, *(row.cosine for row in own if row.cosine is not None)])
    axes.hist(
        [[row.cosine for row in own if family(row) == name] for name in names],
        bins=list(np.linspace(np.floor(20 * least) / 20, 1.0, 21)), stacked=True, label=names,
        color=[COLOURS[k % len(COLOURS)] for k in range(len(names))], edgecolor="white", linewidth=0.4,
    )  # fmt: skip
    axes.set(xlabel="cosine of the static mechanism with Bullet's first motion", ylabel="scenes")
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path)


def scatter(rows: Sequence[LimitRow], path: Path) -> None:
    """Bullet's limit over both static ones."""
    figure = Figure(figsize=(9.0, 4.4), dpi=110, layout="constrained")
    names = list(dict.fromkeys(row.family for row in rows))
    for axes, which, title in zip(
        figure.subplots(1, 2, sharey=True), ("associated", "coulomb"), ("force fields alone", "without dilatancy"),
        strict=True,
    ):  # fmt: skip
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
    figure.axes[0].set_ylabel("Bullet's limit [g]")
    figure.axes[0].legend(frameon=False, fontsize=8)
    figure.savefig(path)


def ratios(rows: Sequence[LimitRow]) -> str:
    """Bullet's limit over the static ones, family by family."""
    lines = []
    for name in [*dict.fromkeys(row.family for row in rows), "all"]:
        own = [row for row in rows if name in (row.family, "all")]
        cells: list[object] = [name, len(own)]
        for which in ("associated", "coulomb"):
            share = np.array([row.bullet / getattr(row, which) for row in own])
            apart = max((row.bullet - getattr(row, which) for row in own), key=abs)
            cells += [f"{np.median(share):.3f}", f"{share.min():.3f}", f"{share.max():.3f}", f"{apart:+.3f}"]
        lines.append(cells)
    measures = ("least", "most", "furthest [g]")
    head = ["", "scenes", "Bullet / force fields: median", *measures, "Bullet / Coulomb: median", *measures]
    return table(head, lines)


def finer_limits(rows: Sequence[LimitRow]) -> str:
    """Bullet's limits beside those with finer time steps, where these were asked for."""
    return table(
        ["", "force fields [g]", "Coulomb [g]", "Bullet [g]", "Bullet, finer [g]"],
        (
            [row.name, f"{row.associated:.4f}", f"{row.coulomb:.4f}", f"{row.bullet:.4f}", f"{row.finer:.4f}"]
            for row in rows
            if row.finer is not None
        ),
    )
