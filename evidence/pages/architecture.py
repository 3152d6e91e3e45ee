"""The picture and the table of the rooms, from the imports of the source: docs/architecture.png and docs/results.

python -m evidence.pages.architecture [--json] [--write FILE]
"""

from __future__ import annotations

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from evidence import results
from evidence.paths import DOCS, ROOT
from evidence.plotting import save
from evidence.structure import Graph, imports, modules, rooms_graph

SOURCE = ROOT / "src"
FILLS = {"blockstat": "#d6e6f4", "dynsim": "#fde3c8"}
EDGES = {"blockstat": "#0072b2", "dynsim": "#d55e00"}
IMPORTS = re.compile(r"This room imports (.+?)(?:\. |\.$)")
WIDTH, HEIGHT, ACROSS, UP = 1.6, 0.42, 1.8, 0.8


def rooms() -> Graph:
    """Rooms, each with the rooms it imports. The modules of a package root are open to all and left out."""
    graph = rooms_graph(imports(modules(SOURCE)))
    folders = {room for room in graph if (SOURCE / room.replace(".", "/")).is_dir()}
    return {room: graph[room] & folders for room in folders}


def levels(graph: Graph) -> dict[str, int]:
    """Height of each room: one more than that of the highest room it imports."""
    height: dict[str, int] = {}
    for room in TopologicalSorter(graph).static_order():
        height[room] = max((height[other] + 1 for other in graph[room]), default=0)
    return height


def reduced(graph: Graph) -> Graph:
    """The imports that no other path of imports implies."""
    below: Graph = {}
    for room in TopologicalSorter(graph).static_order():
        below[room] = graph[room].union(*(below[other] for other in graph[room]))
    return {room: others - set().union(*(below[other] for other in others)) for room, others in graph.items()}


def places(graph: Graph) -> dict[str, tuple[float, float]]:
    """Centre of each box: rows by height, `blockstat` to the left of `dynsim`."""
    height = levels(graph)
    rows: dict[tuple[str, int], list[str]] = {}
    for room in sorted(graph):
        rows.setdefault((room.split(".")[0], height[room]), []).append(room)
    widest = {package: max(len(row) for (own, _), row in rows.items() if own == package) for package in FILLS}
    centre = {"blockstat": 0.0, "dynsim": ACROSS * (widest["blockstat"] + widest["dynsim"]) / 2}
    found: dict[str, tuple[float, float]] = {}
    for (package, level), row in sorted(rows.items(), key=lambda item: item[0][1]):
        row.sort(key=lambda room: sum(found[other][0] for other in graph[room]) / max(len(graph[room]), 1))
        for k, room in enumerate(row):
            found[room] = centre[package] + (k - (len(row) - 1) / 2) * ACROSS, level * UP
    return found


def picture(graph: Graph, path: Path) -> Path:
    """Write a picture with a box a room, each above all that it imports, and arrows to these."""
    place = places(graph)
    xs, ys = zip(*place.values(), strict=True)
    left, right, low, high = min(xs) - WIDTH, max(xs) + WIDTH, min(ys) - HEIGHT, max(ys) + 1.5 * HEIGHT
    figure = Figure(figsize=(right - left, high - low))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(left, right), ylim=(low, high))
    axes.set_axis_off()
    for room, others in reduced(graph).items():
        for other in others:
            start, end = (place[room][0], place[room][1] - HEIGHT / 2), (place[other][0], place[other][1] + HEIGHT / 2)
            axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=9, color="0.55", linewidth=0.8,
                                           shrinkA=0, shrinkB=0))  # fmt: skip
    for room, (x, y) in place.items():
        package, name = room.split(".")
        axes.add_patch(FancyBboxPatch((x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT, linewidth=1.2, zorder=2,
                                      boxstyle="round,pad=0,rounding_size=0.06", facecolor=FILLS[package],
                                      edgecolor=EDGES[package]))  # fmt: skip
        axes.text(x, y, name, ha="center", va="center", fontsize=10, zorder=3)
    for package, colour in EDGES.items():
        x = min(px for room, (px, _) in place.items() if room.startswith(package)) - WIDTH / 2
        axes.text(x, max(ys) + HEIGHT, package, color=colour, fontsize=12, fontweight="bold", va="center")
    return save(figure, path, dpi=100)


def purpose(room: str) -> tuple[str, str]:
    """What a room is for and what it imports, by its own account: the first sentence, and that of its imports."""
    doc = ast.get_docstring(ast.parse((SOURCE / room.replace(".", "/") / "__init__.py").read_text())) or ""
    first, _, rest = " ".join(doc.split()).partition(". ")
    imported = IMPORTS.search(rest)
    return f"{first.removesuffix('.')}.", imported[1] if imported else ""


def table(graph: Graph) -> str:
    """A row a room, from the ground up."""
    height = levels(graph)
    rows = ["| room | purpose | imports |", "|---|---|---|"]
    for room in sorted(graph, key=lambda room: (room.startswith("dynsim"), height[room], room)):
        first, rest = purpose(room)
        rows.append(f"| `{room}` | {first} | {rest} |")
    return "\n".join(rows)


def main() -> None:
    options = results.parser(__doc__).parse_args()
    graph = rooms()
    picture(graph, DOCS / "architecture.png")
    results.report(options, {room: sorted(others) for room, others in graph.items()}, {"rooms": table(graph)})


if __name__ == "__main__":
    main()
