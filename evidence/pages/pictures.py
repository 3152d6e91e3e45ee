"""The pictures of the README and the docs."""

from blockstat import assess, build, limit_load, load_scene, reserve_map, with_values
from blockstat.view.plot import plot_mechanism, plot_stone_sensitivity, plot_verdict
from blockstat.view.utilisation import LABELS, plot_reserve_map, plot_utilisation
from evidence.paths import DOCS, EXAMPLES

ACROSS = (0, 1, 0)


def main() -> None:
    chapel = load_scene(EXAMPLES / "chapel.toml")
    pictures = []
    for name, thickness in (("chapel", 0.6), ("chapel-thin", 0.3)):
        assembly = build(with_values(chapel, {"wall.thickness": thickness}))
        assembly = assembly.with_(name=f"walls of {thickness:g} m")
        pictures.append(plot_verdict(assess(assembly), DOCS / f"{name}.png"))
    assembly = build(chapel)
    pictures.append(plot_utilisation(assess(assembly), DOCS / "chapel-joints.png"))
    limit = limit_load(assembly, ACROSS)
    pictures.append(plot_mechanism(limit, DOCS / "chapel-pushed.png"))
    pictures.append(plot_stone_sensitivity(limit, ACROSS, DOCS / "chapel-stone.png"))
    found = reserve_map(limit_load(assembly, ACROSS, optimum=True), ACROSS)
    pictures += [plot_reserve_map(found, what, DOCS / f"chapel-by-{what}.png") for what in LABELS]
    nave = build(load_scene(EXAMPLES / "nave.toml")).with_(name="nave, pushed across")
    pictures.append(plot_mechanism(limit_load(nave, ACROSS), DOCS / "nave.png"))
    print(*pictures, sep="\n")


if __name__ == "__main__":
    main()
