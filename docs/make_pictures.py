"""Make the pictures of the README and the docs: `make pictures`."""

from pathlib import Path

from blockstat import assess, build, load_scene, with_values
from blockstat.plot import picture_of_verdict

HERE = Path(__file__).parent


def main() -> None:
    chapel = load_scene(HERE.parent / "examples" / "chapel.toml")
    for name, thickness in (("chapel", 0.6), ("chapel-thin", 0.3)):
        assembly = build(with_values(chapel, {"wall.thickness": thickness}))
        assembly = assembly.with_(name=f"walls of {thickness:g} m")
        print(picture_of_verdict(assess(assembly), HERE / f"{name}.png"))


if __name__ == "__main__":
    main()
