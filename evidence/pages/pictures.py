"""The pictures of the README and the docs."""

import re
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.figure import Figure

from blockstat import (
    assess,
    build,
    capacity,
    limit_load,
    load_scene,
    moving_load,
    plot_capacity,
    reserve_map,
    with_values,
)
from blockstat.view.plot import plot_mechanism, plot_stone_sensitivity, plot_verdict
from blockstat.view.utilisation import LABELS, plot_reserve_map, plot_utilisation
from evidence.paths import DOCS, EXAMPLES
from evidence.plotting import save

ACROSS = (0, 1, 0)
OUTWARD = (0, -1, 0)


def chapel() -> list[Path]:
    """Verdicts, limits and reserves of the chapel."""
    scene = load_scene(EXAMPLES / "chapel.toml")
    made = []
    for name, thickness in (("chapel", 0.6), ("chapel-thin", 0.3)):
        assembly = build(with_values(scene, {"wall.thickness": thickness}))
        assembly = assembly.with_(name=f"walls of {thickness:g} m")
        made.append(plot_verdict(assess(assembly), DOCS / f"{name}.png"))
    assembly = build(scene)
    made.append(plot_utilisation(assess(assembly), DOCS / "chapel-joints.png"))
    limit = limit_load(assembly, ACROSS)
    made.append(plot_mechanism(limit, DOCS / "chapel-pushed.png"))
    made.append(plot_stone_sensitivity(limit, ACROSS, DOCS / "chapel-stone.png"))
    found = reserve_map(limit_load(assembly, ACROSS, optimum=True), ACROSS)
    return made + [plot_reserve_map(found, what, DOCS / f"chapel-by-{what}.png") for what in LABELS]


def facade() -> list[Path]:
    """The mechanism and the capacity curve of the facade that docs/howto/facade.md shows as a scene."""
    text = (DOCS / "howto" / "facade.md").read_text()
    (scene,) = re.findall(r"```toml\n(# facade\.toml\n.*?)```", text, re.DOTALL)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "facade.toml"
        path.write_text(scene)
        assembly = build(load_scene(path))
    limit = limit_load(assembly, OUTWARD)
    curve = capacity(assembly, OUTWARD, control="house.wall.front", steps=10)
    drawn = plot_mechanism(limit, DOCS / "facade-mechanism.png", azimuth=-60.0)
    return [drawn, plot_capacity(curve, DOCS / "facade-capacity.png")]


def bridge() -> list[Path]:
    """The influence line of an axle on the bridge of docs/howto/bridge.md."""
    assembly = build(load_scene(EXAMPLES / "bridge.toml"))
    line = moving_load(assembly, [(0.0, 100e3)], [(0, 0, 6), (25, 0, 6)], positions=101, joints=False, tolerance=0.01)
    middle = np.where(np.isfinite(line.upper), (line.lower + line.upper) / 2, np.nan)
    figure = Figure(figsize=(7, 2.8), layout="constrained")
    axes = figure.add_subplot()
    for left, right in ((0, 3), (8, 10), (15, 17), (22, 25)):
        axes.axvspan(left, right, color="0.9", linewidth=0)
    axes.semilogy(line.place, middle, "o-", markersize=3, color="#0072b2")
    axes.set(xlim=(0, 25), ylim=(10, 3000), xlabel="place of the axle [m]", ylabel="multiplier of 100 kN")
    axes.grid(visible=True, axis="y", color="0.85")
    return [save(figure, DOCS / "bridge-axle.png", dpi=100)]


def main() -> None:
    print(*chapel(), *facade(), *bridge(), sep="\n")


if __name__ == "__main__":
    main()
