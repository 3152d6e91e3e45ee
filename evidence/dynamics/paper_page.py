"""docs/paper.md and its picture from the figures of `evidence.dynamics.paper`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib import colormaps

from evidence.plotting import panels, save
from evidence.tables import table

INTRODUCTION = """# The paper's experiment

Written by `python -m evidence.dynamics.paper --write`. The paper ([Fita 2017](bibliography.md#fita-2017)) puts a vault
on walls of 2, 1 and 0.5 m and simulates it with Bullet inside a modelling program. It finds that a building of low
rotational stiffness (7,000) stands only with the thickest wall, and that a building of high stiffness (70,000) stands
even with the thinnest. Its buttress loop gives 6 buttresses to each wall and 7 to the back wall.

## Assumptions

The paper does not state everything that a second run needs. These are the assumptions here:

- The chapel is 6 m by 4 m inside, with walls 3 m high of blocks of 1.5 m by 0.75 m, a barrel vault 0.3 m thick in 9
  courses, and buttresses 0.5 m wide, 0.6 m thick and 2 m high. It has {blocks} blocks without buttresses.
- The density is 2,691 kg/m3, and the friction is that of the paper, 0.7. In the paper's program, glue of 10 is a
  threshold on accumulated impacts, which has no unit here. So joints are dry.
- "Rotational stiffness" has two readings here. The modelling program uses the word for a scale of the inertia of each
  block. The paper writes it as a spring at each joint, in N m/rad.
- The buttress loop begins without buttresses. If the building cracks, it adds one on each wall. Then it adds one more
  on each wall that cracks, spaced by Eqs. 3-5, until no joint opens or slides by more than a hundredth of its smaller
  block. It simulates {seconds:g} s at the scale of 0.3 m blocks, with the preset "fast".
"""
PICTURE = (
    "![three plots of the drop of a vault against time, with lines that rise to the right](paper.png)",
    "",
    "*The drop of the vault against simulated time, for walls of 2 m, 1 m and 0.5 m. Drops below 0.01 mm are drawn "
    "there; beyond some metres the blocks fall freely.*",
)


def page(figures: dict[str, Any]) -> str:
    """The page as Markdown."""
    parts = [INTRODUCTION.format(blocks=figures["blocks"], seconds=figures["seconds"])]
    parts += ["## Buttresses for each wall", "", *_loops(figures), ""]
    parts += ["## Drop against simulated time", "", *_drops(figures), "", *PICTURE, ""]
    parts += ["## Findings", "", *_findings(figures)]
    return "\n".join(parts) + "\n"


def _loops(figures: dict[str, Any]) -> list[str]:
    sides = ("south", "north", "west", "east")
    heads = ["reading", "walls", *sides, "ends without a crack", "Bullet runs", "statics of the last"]
    lines = []
    for row in figures["loops"]:
        number = [row["number"].get(side, 0) for side in sides]
        sound = "yes" if row["sound"] else "no"
        lines.append([row["reading"], f"{row['wall']:g} m", *number, sound, row["runs"], row["static"]])
    least = ", ".join(
        f"{row['wall']:g} m: {'more than 8' if row['least'] is None else row['least']}" for row in figures["static"]
    )
    return [
        table(heads, lines),
        "",
        f"Least number on each springing wall with which statics find an equilibrium: {least}.",
    ]


def _drops(figures: dict[str, Any]) -> list[str]:
    lines = []
    for row in figures["drops"]:
        cells = (f"{round(v, 1) + 0.0:.1f}" if v < 2000 else "fallen" for v in row["drop_mm"])
        lines.append([row["reading"], f"{row['wall']:g} m", *cells])
    heads = ["reading", "walls", *(f"{t:g} s" for t in figures["times"])]
    return ["Drop of the vault (Eq. 1) without buttresses, in mm.", "", table(heads, lines)]


def _findings(figures: dict[str, Any]) -> list[str]:
    """Sentences that the figures decide."""
    drops = {(row["reading"], row["wall"]): row["drop_mm"] for row in figures["drops"]}
    dry, soft, hard = (drops[name, 0.5] for name in ("dry, true inertia", "inertia x 7,000", "inertia x 70,000"))
    least = {row["wall"]: row["least"] for row in figures["static"]}
    first, last = figures["times"][0], figures["times"][-1]
    lines = [
        f"- After {first:g} s the vault on 0.5 m walls has dropped by {_mm(dry[0])} with true inertia, by "
        f"{_mm(soft[0])} with 7,000 times the inertia and by {_mm(hard[0])} with 70,000 times. After {last:g} s the "
        f"drops are {_mm(dry[-1])}, {_mm(soft[-1])} and {_mm(hard[-1])}.",
    ]
    if least[0.5] != 0:
        lines.append(
            "- Statics find no equilibrium of the 0.5 m walls without buttresses, and statics do not depend on "
            "inertia. If stiffness means inertia, stiff buildings stand with thin walls only because the simulated "
            "time is short."
        )
    for row in figures["loops"]:
        if row["wall"] == 0.5:
            words = ", ".join(f"{side} {count}" for side, count in row["number"].items()) or "no buttress"
            end = "" if row["sound"] else ", and still cracks"
            lines.append(
                f"- 0.5 m walls, {row['reading']}: the loop ends with {words}{end} (paper: 6 each, 7 at the back)."
            )
    for value in ("7,000", "70,000"):
        fall = drops[f"springs of {value} N m/rad", 0.5]
        lines.append(
            f"- Springs of {value} N m/rad at the joints: the vault on 0.5 m walls has dropped by {_mm(fall[0])} after "
            f"{first:g} s, {_mm(fall[-2])} after {figures['times'][-2]:g} s and {_mm(fall[-1])} after {last:g} s."
        )
    lines += [
        "- The moment of a spring has no bound here, as if its joint could never break. Statics have no such joint. "
        "So a design that statics exclude may stand on springs: do not prune with them ([search](search.md)).",
        "- The numbers of buttresses in the paper depend on a plan, heights, buttress sizes and a crack threshold that "
        "it does not give. They cannot be expected to agree.",
    ]
    return lines


def _mm(value: float) -> str:
    return f"{value:.1f} mm" if value < 2000 else "more than 2 m"


def picture(figures: dict[str, Any], path: Path) -> Path:
    """Drop against simulated time, one panel a wall."""
    walls = sorted({row["wall"] for row in figures["drops"]}, reverse=True)
    figure, axes = panels((11, 3.6), 1, len(walls), sharey=True)
    names = list(dict.fromkeys(row["reading"] for row in figures["drops"]))
    colours = {name: colormaps["viridis"](0.95 * k / len(names)) for k, name in enumerate(names)}
    marks = {name: "osD^v"[k % 5] for k, name in enumerate(names)}
    for axis, wall in zip(axes, walls, strict=True):
        for row in figures["drops"]:
            if row["wall"] == wall:
                drop = [max(v, 0.01) for v in row["drop_mm"]]
                name = row["reading"]
                axis.loglog(figures["times"], drop, marker=marks[name], color=colours[name], label=name)
        axis.set_title(f"walls of {wall:g} m")
        axis.set_xlabel("simulated time [s]")
        axis.set_xticks(figures["times"], [f"{t:g}" for t in figures["times"]])
        axis.minorticks_off()
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("drop of the vault [mm]")
    axes[0].legend(fontsize=8)
    return save(figure, path)
